//! Where masked triangles have holes, in f64.
//!
//! There is a hole where base colour alpha × vertex colour alpha × texture alpha is below the cutoff. The texture is
//! read at full size with its own filter and wrapping, and the product compared as an f32, which is what cutoffs are.

use std::ops::{Add, Mul, Sub};
use std::sync::Arc;

use glam::{DVec2, DVec3};
use shadowgraph_engine::scene::{Image, Instance, SceneSnapshot, TexCoord, TextureRef, Wrap};

use super::cover::Cover;

/// The mask of one triangle.
#[derive(Clone, Debug)]
pub(crate) struct Mask {
    cutoff: f32,
    /// Base colour alpha.
    alpha: f64,
    /// Vertex colour alpha at the corners.
    corner_alphas: [f64; 3],
    texture: Option<(Arc<Image>, TextureRef)>,
    /// Transformed texture coordinates at the corners.
    corner_uvs: [DVec2; 3],
    weights: CornerWeights,
    /// Where the texture is all alike.
    cover: Option<Arc<Cover>>,
}

impl Mask {
    /// The mask of `triangle` of `instance`, if its material has one.
    pub(crate) fn of(snapshot: &SceneSnapshot, instance: &Instance, triangle: usize) -> Option<Box<Self>> {
        let material = instance.material_of(triangle);
        let cutoff = material.cutoff()?;
        let vertices = instance.mesh.triangle(triangle);
        let worn = material.base_color_texture;
        let image =
            worn.and_then(|texture| Some((Arc::clone(snapshot.images.get(&texture.image)?), texture)));
        Some(Box::new(Self {
            cutoff,
            alpha: f64::from(material.base_color.w),
            corner_alphas: vertices.map(|vertex| f64::from(instance.mesh.color8(vertex)[3]) / 255.0),
            texture: image,
            corner_uvs: corner_uvs(instance, worn, triangle),
            weights: CornerWeights::of(instance.world_triangle(triangle)),
            cover: None,
        }))
    }

    /// The texture, the least and the largest factor on its alpha, and the cutoff.
    pub(crate) fn texture_alphas(&self) -> Option<(&Arc<Image>, [f64; 2], f32)> {
        let (image, _) = self.texture.as_ref()?;
        let [a, b, c] = self.corner_alphas;
        let factors = [a.min(b).min(c), a.max(b).max(c)].map(|corner| corner * self.alpha);
        Some((image, factors, self.cutoff))
    }

    pub(crate) fn set_cover(&mut self, cover: Arc<Cover>) {
        self.cover = Some(cover);
    }

    /// Whether all within the hull of `points` of the triangle is hole (true) or solid; `None` where that is not sure.
    pub(crate) fn is_hole_within(&self, points: &[DVec3]) -> Option<bool> {
        let ((_, texture), cover) = (self.texture.as_ref()?, self.cover.as_ref()?);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in points {
            let uv = self.uv_of(self.weights.at(*point));
            (low, high) = (low.min(uv), high.max(uv));
        }
        cover.over(texture, low, high)
    }

    /// Whether there is a hole at `point` of the triangle.
    pub(crate) fn has_hole_at(&self, point: DVec3) -> bool {
        let weights = self.weights.at(point);
        let mut alpha = self.alpha * (0..3).map(|i| self.corner_alphas[i] * weights[i]).sum::<f64>();
        if let Some((image, texture)) = &self.texture {
            alpha *= texture_alpha(image, texture, self.uv_of(weights));
        }
        (alpha as f32) < self.cutoff
    }

    fn uv_of(&self, weights: [f64; 3]) -> DVec2 {
        (0..3).map(|i| self.corner_uvs[i] * weights[i]).sum()
    }
}

/// Where on `texture` the corners of `triangle` lie, as its transform leaves them.
pub(crate) fn corner_uvs(instance: &Instance, texture: Option<TextureRef>, triangle: usize) -> [DVec2; 3] {
    let uvs = match texture.map(|texture| texture.tex_coord) {
        Some(TexCoord::Second) => &instance.mesh.data().second_uvs,
        _ => &instance.mesh.data().uvs,
    };
    let transform = texture.map(|texture| texture.transform).unwrap_or_default();
    instance.mesh.triangle(triangle).map(|vertex| {
        let scaled =
            uvs.get(vertex as usize).copied().unwrap_or_default().as_dvec2() * transform.scale.as_dvec2();
        let (sin, cos) = f64::from(transform.rotation_rad).sin_cos();
        DVec2::new(cos * scaled.x + sin * scaled.y, cos * scaled.y - sin * scaled.x)
            + transform.offset.as_dvec2()
    })
}

/// How much each corner of a triangle weighs at points of its plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CornerWeights {
    first: DVec3,
    /// How the second and the third corner's weights grow along the triangle.
    gradients: [DVec3; 2],
}

impl CornerWeights {
    pub(crate) fn of([a, b, c]: [DVec3; 3]) -> Self {
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let gradients = [ac.cross(normal), normal.cross(ab)].map(|across| across / normal.length_squared());
        Self { first: a, gradients }
    }

    pub(crate) fn at(&self, point: DVec3) -> [f64; 3] {
        let [b, c] = self.gradients.map(|gradient| gradient.dot(point - self.first));
        [1.0 - b - c, b, c]
    }
}

/// The alpha of `image` at `uv`.
fn texture_alpha(image: &Image, texture: &TextureRef, uv: DVec2) -> f64 {
    texture_value(image, texture, uv, |texel| f64::from(texel[3]) / 255.0)
}

/// What `value` makes of the texels of `image` at `uv`, blended if they blend.
pub(crate) fn texture_value<T>(
    image: &Image,
    texture: &TextureRef,
    uv: DVec2,
    value: impl Fn([u8; 4]) -> T,
) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>,
{
    let size = [image.width, image.height].map(i64::from);
    let texel = |x: i64, y: i64| {
        let first = ((y * size[0] + x) * 4) as usize;
        let bytes = image.rgba8.get(first..first + 4).and_then(|bytes| bytes.try_into().ok());
        value(bytes.unwrap_or([255; 4]))
    };
    let place = uv * DVec2::new(size[0] as f64, size[1] as f64);
    let column = |x: i64| wrapped(x, size[0], texture.wrap[0]);
    let row = |y: i64| wrapped(y, size[1], texture.wrap[1]);
    if !texture.smooth {
        return texel(column(floor(place.x)), row(floor(place.y)));
    }
    let (x, y) = (floor(place.x - 0.5), floor(place.y - 0.5));
    let weight = place - 0.5 - DVec2::new(x as f64, y as f64);
    let columns = [column(x), column(x.saturating_add(1))];
    let blended = |y: i64| {
        let [left, right] = columns.map(|x| texel(x, y));
        left + (right - left) * weight.x
    };
    let [top, bottom] = [blended(row(y)), blended(row(y.saturating_add(1)))];
    top + (bottom - top) * weight.y
}

/// The largest whole number that is not more. (`f64::floor` is a call where processors are not told to have it.)
fn floor(value: f64) -> i64 {
    let truncated = value as i64;
    truncated - i64::from(value < truncated as f64)
}

/// The texel that stands for number `index` of `size`.
fn wrapped(index: i64, size: i64, wrap: Wrap) -> i64 {
    // Most are; and a remainder is slow.
    if (0..size).contains(&index) {
        return index;
    }
    match wrap {
        Wrap::Repeat => index.rem_euclid(size),
        Wrap::Clamp => index.clamp(0, size - 1),
        Wrap::Mirror => {
            let within = index.rem_euclid(2 * size);
            if within < size { within } else { 2 * size - 1 - within }
        }
    }
}

#[cfg(test)]
mod tests {
    use shadowgraph_engine::scene::ImageKey;
    use slotmap::Key;

    use super::*;

    /// Alphas 0, 51, 102 … 255 in one row.
    fn ramp() -> Image {
        let rgba8 = (0..6).flat_map(|x| [0, 0, 0, x * 51]).collect();
        Image { name: "ramp".into(), width: 6, height: 1, rgba8 }
    }

    #[test]
    fn texels_wrap_and_blend_as_their_texture_says() {
        let alpha = |texture: TextureRef, u: f64| texture_alpha(&ramp(), &texture, DVec2::new(u / 6.0, 0.5));
        let smooth = TextureRef::new(ImageKey::null());
        let blocky = TextureRef { smooth: false, ..smooth };
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} is not {b}");
        near(alpha(blocky, 1.01), 0.2);
        near(alpha(blocky, 1.99), 0.2);
        near(alpha(smooth, 1.5), 0.2);
        near(alpha(smooth, 2.0), 0.3);
        // Beyond the last texel's middle: its neighbour is the first, itself, or itself again.
        near(alpha(smooth, 6.0), 0.5);
        near(alpha(TextureRef { wrap: [Wrap::Clamp; 2], ..smooth }, 6.0), 1.0);
        near(alpha(TextureRef { wrap: [Wrap::Mirror; 2], ..smooth }, 6.0), 1.0);
        near(alpha(TextureRef { wrap: [Wrap::Mirror; 2], ..blocky }, 7.5), 0.8);
        near(alpha(TextureRef { wrap: [Wrap::Clamp; 2], ..blocky }, -3.0), 0.0);
        near(alpha(blocky, -1.5), 0.8);
    }

    #[test]
    fn weights_are_those_of_the_corners() {
        let corners = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 2.0, 1.0), DVec3::new(0.0, 5.0, 2.0)];
        for expected in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.5, 0.2, 0.3)] {
            let [a, b, c] = corners;
            let point = a * expected.x + b * expected.y + c * expected.z;
            assert!((DVec3::from(CornerWeights::of(corners).at(point)) - expected).length() < 1e-12);
        }
    }
}
