//! A small tracer over all triangles of a scene: no tree, no code shared with the reference, so that it can judge the
//! answers the hard cases give by hand.

use std::sync::Arc;

use glam::{DVec3, DVec4, Vec2, Vec3};
use shadowgraph::measure::LightSize;
use shadowgraph_engine::math::{Aabb, facing_sign};
use shadowgraph_engine::scene::{
    AlphaMode, Image, Instance, LightSnapshot, Material, SceneSnapshot, TexCoord, TextureRef, Wrap,
};

/// A triangle's mask by its nearest texels: enough for points well inside holes and leaves.
pub(crate) struct Mask {
    image: Option<(Arc<Image>, TextureRef)>,
    uvs: [Vec2; 3],
    alphas: [f32; 3],
    cutoff: f32,
}

impl Mask {
    fn of(snapshot: &SceneSnapshot, instance: &Instance, triangle: usize) -> Option<Self> {
        let material = instance.material_of(triangle);
        let AlphaMode::Mask { cutoff } = material.alpha_mode else { return None };
        let (data, corners) = (instance.mesh.data(), instance.mesh.triangle(triangle));
        let texture = material.base_color_texture;
        let second = texture.is_some_and(|texture| texture.tex_coord == TexCoord::Second);
        let uvs = if second { &data.second_uvs } else { &data.uvs };
        let alpha = |vertex: u32| data.colors.get(vertex as usize).map_or(1.0, |color| color.w);
        Some(Self {
            image: texture.map(|texture| (Arc::clone(&snapshot.images[&texture.image]), texture)),
            uvs: corners.map(|vertex| uvs.get(vertex as usize).copied().unwrap_or_default()),
            alphas: corners.map(alpha),
            cutoff,
        })
    }

    /// Whether there is no hole at the point of these weights of the second and third corner.
    fn is_there(&self, [u, v]: [f64; 2]) -> bool {
        let weights = Vec3::new((1.0 - u - v) as f32, u as f32, v as f32);
        let mut alpha = Vec3::from(self.alphas).dot(weights);
        if let Some((image, texture)) = &self.image {
            let [a, b, c] = self.uvs;
            let uv = (a * weights.x + b * weights.y + c * weights.z).extend(1.0);
            let place = texture.transform.rows().map(|row| row.dot(uv));
            let texel = |axis: usize, size: u32| match texture.wrap[axis] {
                Wrap::Clamp => (place[axis].clamp(0.0, 0.9999) * size as f32) as u32,
                Wrap::Repeat => (place[axis].rem_euclid(1.0) * size as f32) as u32 % size,
                Wrap::Mirror => {
                    let within = place[axis].rem_euclid(2.0);
                    (within.min(2.0 - within) * size as f32) as u32 % size
                }
            };
            let (x, y) = (texel(0, image.width), texel(1, image.height));
            alpha *= f32::from(image.rgba8[((y * image.width + x) * 4 + 3) as usize]) / 255.0;
        }
        alpha >= self.cutoff
    }
}

/// A triangle that blocks light.
pub(crate) struct BareTriangle {
    corners: [DVec3; 3],
    mask: Option<Mask>,
    /// Whether it is seen from its front only, and whether a mirroring transform has turned its corners the other way.
    culled: bool,
    mirrored: bool,
}

/// A scene's snapshot as bare triangles, one box for each instance.
pub(crate) struct Soup {
    pub(crate) instances: Vec<(Aabb, Vec<BareTriangle>)>,
    glass: Vec<Glass>,
}

/// A triangle that lets light through.
pub(crate) struct Glass {
    corners: [DVec3; 3],
    uvs: [Vec2; 3],
    material: Arc<Material>,
    image: Option<Arc<Image>>,
}

impl Glass {
    /// What passes at the point of these weights of the second and third corner: (1 − α)·rgb, and all where α is 0.
    fn transmission(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let mut color = self.material.base_color.as_dvec4();
        if let Some(image) = &self.image {
            let [a, b, c] = self.uvs.map(Vec2::as_dvec2);
            let uv = (a * (1.0 - u - v) + b * u + c * v).fract();
            let texel = |coordinate: f64, size: u32| ((coordinate * f64::from(size)) as u32).min(size - 1);
            let index = (texel(uv.y, image.height) * image.width + texel(uv.x, image.width)) as usize * 4;
            let linear = |byte: u8| {
                let value = f64::from(byte) / 255.0;
                if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
            };
            let bytes = &image.rgba8[index..index + 4];
            color *=
                DVec4::new(linear(bytes[0]), linear(bytes[1]), linear(bytes[2]), f64::from(bytes[3]) / 255.0);
        }
        if color.w == 0.0 { [1.0; 3] } else { (color.truncate() * (1.0 - color.w)).to_array() }
    }
}

impl Soup {
    pub(crate) fn new(snapshot: &SceneSnapshot) -> Self {
        let of = |i: &Instance| {
            let opaque = (0..i.mesh.triangle_count()).filter(|t| i.material_of(*t).is_opaque());
            let bare = |t: usize| BareTriangle {
                corners: i.world_triangle(t),
                mask: Mask::of(snapshot, i, t),
                culled: !i.material_of(t).double_sided,
                mirrored: i.world_from_local.matrix3.determinant() < 0.0,
            };
            let triangles = opaque.map(bare).collect();
            (i.world_bounds.expanded(i.world_bounds.radius() * 1e-9), triangles)
        };
        let glass = |i: &Instance, triangle: usize| {
            let material = Arc::clone(i.material_of(triangle));
            let uvs = &i.mesh.data().uvs;
            let uv = |vertex: u32| uvs.get(vertex as usize).copied().unwrap_or_default();
            Glass {
                corners: i.world_triangle(triangle),
                uvs: i.mesh.triangle(triangle).map(uv),
                image: material
                    .base_color_texture
                    .map(|texture| Arc::clone(&snapshot.images[&texture.image])),
                material,
            }
        };
        let panes = snapshot.instances.iter().flat_map(|i| {
            let through = (0..i.mesh.triangle_count()).filter(|t| !i.material_of(*t).is_opaque());
            through.map(|t| glass(i, t)).collect::<Vec<_>>()
        });
        Self { instances: snapshot.instances.iter().map(of).collect(), glass: panes.collect() }
    }

    /// The nearest hit along origin + t·direction with t between the limits, and the triangle's corners.
    pub(crate) fn hit(&self, origin: DVec3, direction: DVec3, limits: [f64; 2]) -> Option<(f64, [DVec3; 3])> {
        self.nearest(origin, direction, limits, |_| true)
    }

    /// The same of what an eye sees there: single-sided triangles show their front only.
    pub(crate) fn seen(
        &self,
        origin: DVec3,
        direction: DVec3,
        limits: [f64; 2],
    ) -> Option<(f64, [DVec3; 3])> {
        self.nearest(origin, direction, limits, |triangle| {
            let [a, b, c] = triangle.corners;
            let faces_eye = (b - a).cross(c - a).dot(direction) < 0.0;
            !triangle.culled || faces_eye != triangle.mirrored
        })
    }

    fn nearest(
        &self,
        origin: DVec3,
        direction: DVec3,
        limits: [f64; 2],
        counts: impl Fn(&BareTriangle) -> bool,
    ) -> Option<(f64, [DVec3; 3])> {
        let mut best: Option<(f64, [DVec3; 3])> = None;
        for (bounds, triangles) in &self.instances {
            if !bounds.intersects_ray(origin, direction, limits[1]) {
                continue;
            }
            for triangle in triangles {
                if let Some((t, weights)) = crossing(&triangle.corners, origin, direction)
                    && t > limits[0]
                    && t < best.map_or(limits[1], |b| b.0)
                    && triangle.mask.as_ref().is_none_or(|mask| mask.is_there(weights))
                    && counts(triangle)
                {
                    best = Some((t, triangle.corners));
                }
            }
        }
        best
    }

    /// The factor of `light` at `point` on `surface`, seen from `to_eye`; `None` outside the light's reach.
    pub(crate) fn factor(
        &self,
        light: &LightSnapshot,
        point: DVec3,
        surface: [DVec3; 3],
        to_eye: DVec3,
    ) -> Option<[f64; 3]> {
        if !light.reaches(point) {
            return None;
        }
        let [a, b, c] = surface;
        let eye_sign = facing_sign(a, b, c, to_eye.extend(0.0));
        if facing_sign(a, b, c, light.position) * eye_sign <= 0 {
            return Some([0.0; 3]);
        }
        let to_light = light.position.truncate() - point * light.position.w;
        let end = if light.position.w == 0.0 { f64::INFINITY } else { 1.0 - 1e-12 };
        let start = if light.position.w == 0.0 { 1e-7 * (1.0 + point.length()) } else { 1e-7 };
        if self.hit(point, to_light, [start, end]).is_some() {
            return Some([0.0; 3]);
        }
        let crossed = self.glass.iter().filter_map(|glass| {
            let (t, weights) = crossing(&glass.corners, point, to_light)?;
            (t > start && t < end).then(|| glass.transmission(weights))
        });
        Some(crossed.fold([1.0; 3], |product, next| [0, 1, 2].map(|i| product[i] * next[i])))
    }

    /// The mean factor over the light's disc: of directions within `half_angle_rad`, or around a point for `radius_m`.
    pub(crate) fn soft_factor(
        &self,
        light: &LightSnapshot,
        LightSize { radius_m, half_angle_rad }: LightSize,
        point: DVec3,
        surface: [DVec3; 3],
        to_eye: DVec3,
    ) -> Option<[f64; 3]> {
        const SIDE: usize = 48;
        let to_light = light.position.truncate() - point * light.position.w;
        let distance = to_light.length();
        let radius = match light.position.w {
            0.0 => half_angle_rad.tan() * distance,
            _ if distance <= radius_m => 0.0,
            _ => radius_m * distance / (distance * distance - radius_m * radius_m).sqrt(),
        };
        if radius == 0.0 {
            return self.factor(light, point, surface, to_eye);
        }
        light.reaches(point).then_some(())?;
        let (u, v) = to_light.normalize().any_orthonormal_pair();
        let mut sum = [0.0; 3];
        for i in 0..SIDE * SIDE {
            let within = |k: usize| (k as f64 + 0.5) / SIDE as f64;
            let (r, angle) = (radius * within(i % SIDE).sqrt(), within(i / SIDE) * std::f64::consts::TAU);
            let moved = (u * angle.cos() + v * angle.sin()) * r;
            let sample = LightSnapshot { position: light.position + moved.extend(0.0), ..light.clone() };
            let factor = self.factor(&sample, point, surface, to_eye).unwrap_or_default();
            sum = [0, 1, 2].map(|i| sum[i] + factor[i]);
        }
        Some(sum.map(|sum| sum / (SIDE * SIDE) as f64))
    }
}

/// Where the ray meets the triangle: its parameter, and the weights of the second and third corner.
fn crossing([a, b, c]: &[DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, [f64; 2])> {
    let (ab, ac) = (*b - *a, *c - *a);
    let normal = ab.cross(ac);
    let det = -direction.dot(normal);
    let from_a = origin - *a;
    let t = from_a.dot(normal) / det;
    let moment = from_a.cross(direction);
    let (u, v) = (ac.dot(moment) / det, -ab.dot(moment) / det);
    // Where det is 0 these are NaN or infinite, and every comparison says no.
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some((t, [u, v]))
}
