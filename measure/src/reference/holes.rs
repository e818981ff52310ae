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

    /// Whether all within the hull of `points` of the triangle with these corners is hole (true) or solid; `None` where
    /// that is not sure.
    pub(crate) fn is_hole_within(&self, corners: &[DVec3; 3], points: &[DVec3]) -> Option<bool> {
        let ((_, texture), cover) = (self.texture.as_ref()?, self.cover.as_ref()?);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in points {
            let weights = weights(corners, *point).to_array();
            let uv: DVec2 = (0..3).map(|i| self.corner_uvs[i] * weights[i]).sum();
            (low, high) = (low.min(uv), high.max(uv));
        }
        cover.over(texture, low, high)
    }

    /// Whether there is a hole at `point` of the triangle with these corners.
    pub(crate) fn has_hole_at(&self, corners: &[DVec3; 3], point: DVec3) -> bool {
        let weights = weights(corners, point);
        let sum = |values: [f64; 3]| values[0] * weights.x + values[1] * weights.y + values[2] * weights.z;
        let mut alpha = self.alpha * sum(self.corner_alphas);
        if let Some((image, texture)) = &self.texture {
            let uv = DVec2::new(sum(self.corner_uvs.map(|uv| uv.x)), sum(self.corner_uvs.map(|uv| uv.y)));
            alpha *= texture_alpha(image, texture, uv);
        }
        (alpha as f32) < self.cutoff
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

/// How much each corner weighs at `point` of the triangle's plane.
pub(crate) fn weights(corners: &[DVec3; 3], point: DVec3) -> DVec3 {
    let [a, b, c] = corners.map(|corner| corner - point);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let areas = DVec3::new(normal.dot(b.cross(c)), normal.dot(c.cross(a)), normal.dot(a.cross(b)));
    areas / normal.length_squared()
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
        let (x, y) = (wrapped(x, size[0], texture.wrap[0]), wrapped(y, size[1], texture.wrap[1]));
        let first = ((y * size[0] + x) * 4) as usize;
        let bytes = image.rgba8.get(first..first + 4).and_then(|bytes| bytes.try_into().ok());
        value(bytes.unwrap_or([255; 4]))
    };
    let place = uv * DVec2::new(size[0] as f64, size[1] as f64);
    if !texture.smooth {
        return texel(place.x.floor() as i64, place.y.floor() as i64);
    }
    let corner = (place - 0.5).floor();
    let weight = place - 0.5 - corner;
    let (x, y) = (corner.x as i64, corner.y as i64);
    let row = |y: i64| texel(x, y) + (texel(x + 1, y) - texel(x, y)) * weight.x;
    row(y) + (row(y + 1) - row(y)) * weight.y
}

/// The texel that stands for number `index` of `size`.
fn wrapped(index: i64, size: i64, wrap: Wrap) -> i64 {
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
            assert!((weights(&corners, point) - expected).length() < 1e-12);
        }
    }
}
