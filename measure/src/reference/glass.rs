//! Transparent surfaces: what light takes on when it passes them, and which of them a ray passes.
//!
//! **The factor** of a light at a point is what is opaque says (0 or 1) times the product of what every transparent
//! triangle strictly between the point and the light lets pass ([`Material::transmission_at`]), red, green and blue apart.
//! The base colour is looked up where the segment crosses, in f64: texture (decoded from sRGB before texels blend) times
//! vertex colour times the material's own.
//!
//! **Each surface counts once.** A segment that meets two triangles in their common edge, or many in a corner, must pass
//! one of them as seen from either side of the sheet. So a crossing is judged for a direction that is moved by
//! (ε, ε², ε³): of the triangles around an edge or a corner exactly those on one side of the moved line are crossed,
//! whichever way they are wound.
//!
//! **Ambiguity.** Textures that blend make every factor change with every move. What half floats cannot tell apart is no
//! change: [`SAME_FACTOR`].

use std::sync::{Arc, LazyLock};

use glam::{DVec2, DVec3, DVec4, Vec3};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::scene::{Image, Material, SceneSnapshot, TextureRef};

use super::bvh::Bvh;
use super::channels::HALF_FLOAT_LOSS;
use super::holes::{CornerWeights, corner_uvs, texture_value};
use super::moved::{MOVES, Moved};
use super::query::Query;
use super::surface::Triangle;
use super::tracer::{CasterSet, Probe, Tracer};

/// Factors that differ by no more are the same for the ambiguity band: half of what an exact factor may lose in the
/// half floats it is kept in.
pub(crate) const SAME_FACTOR: f64 = HALF_FLOAT_LOSS / 2.0;

/// The transparent surfaces of a scene.
pub(crate) struct Panes {
    /// In the order of the tree's leaves.
    pub(crate) triangles: Vec<Triangle>,
    /// What each of `triangles` wears.
    pub(super) colors: Vec<PaneColor>,
    pub(crate) bvh: Bvh,
    /// Around all of them.
    pub(crate) bounds: Aabb,
}

/// The base colour of one triangle.
#[derive(Clone)]
pub(super) struct PaneColor {
    material: Arc<Material>,
    corner_colors: [DVec4; 3],
    texture: Option<(Arc<Image>, TextureRef)>,
    corner_uvs: [DVec2; 3],
    weights: CornerWeights,
    /// What passes it, where that is the same everywhere.
    pub(super) even: Option<DVec3>,
}

impl PaneColor {
    fn of(snapshot: &SceneSnapshot, triangle: &Triangle) -> Self {
        let instance = &snapshot.instances[triangle.instance as usize];
        let index = triangle.triangle as usize;
        let material = Arc::clone(instance.material_of(index));
        let worn = material.base_color_texture;
        let color = |vertex| DVec4::from(instance.mesh.color8(vertex).map(|byte| f64::from(byte) / 255.0));
        let corner_colors = instance.mesh.triangle(index).map(color);
        let [a, b, c] = corner_colors;
        let is_even = worn.is_none() && a == b && b == c;
        Self {
            corner_colors,
            even: is_even.then(|| material.transmission_at(material.base_color.as_dvec4() * a)),
            texture: worn.and_then(|worn| Some((Arc::clone(snapshot.images.get(&worn.image)?), worn))),
            corner_uvs: corner_uvs(instance, worn, index),
            weights: CornerWeights::of(triangle.corners),
            material,
        }
    }

    /// What passes the triangle at `point`.
    pub(super) fn passing(&self, point: DVec3) -> DVec3 {
        self.material.transmission_at(self.at(point))
    }

    /// The linear base colour at `point` of the triangle.
    fn at(&self, point: DVec3) -> DVec4 {
        let weights = self.weights.at(point);
        let mut color = self.material.base_color.as_dvec4();
        color *= (0..3).map(|i| self.corner_colors[i] * weights[i]).sum::<DVec4>();
        if let Some((image, texture)) = &self.texture {
            let uv = (0..3).map(|i| self.corner_uvs[i] * weights[i]).sum();
            color *= texture_value(image, texture, uv, decoded);
        }
        color
    }
}

/// A texel of a base colour: sRGB decoded, alpha as it is.
fn decoded(texel: [u8; 4]) -> DVec4 {
    static LINEAR: LazyLock<[f64; 256]> = LazyLock::new(|| {
        let linear = |v: f64| if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
        std::array::from_fn(|byte| linear(byte as f64 / 255.0))
    });
    let [r, g, b] = [texel[0], texel[1], texel[2]].map(|byte| LINEAR[usize::from(byte)]);
    DVec4::new(r, g, b, f64::from(texel[3]) / 255.0)
}

impl Panes {
    /// The transparent surfaces of `snapshot`; `None` where there are none.
    pub(crate) fn of_scene(snapshot: &SceneSnapshot) -> Option<Self> {
        let drawn = Triangle::wearing(snapshot, |material| !material.is_opaque());
        if drawn.is_empty() {
            return None;
        }
        let boxes: Vec<Aabb> = drawn.iter().map(Triangle::bounds).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |sum, b| sum.union(b));
        let (bvh, order) = Bvh::new(&boxes, &bounds);
        let triangles: Vec<Triangle> = order.iter().map(|index| drawn[*index as usize].clone()).collect();
        let colors = triangles.iter().map(|triangle| PaneColor::of(snapshot, triangle)).collect();
        Some(Self { triangles, colors, bvh, bounds })
    }

    /// Multiplies onto `tints` what triangle `place` lets pass between each of the `wanted` points and the light.
    fn pass(
        &self,
        place: usize,
        (probe, casters, coordinate_m): (&Probe<'_>, &CasterSet, f64),
        wanted: u8,
        tints: &mut [DVec3; MOVES],
    ) {
        let (triangle, color) = (&self.triangles[place], &self.colors[place]);
        let facing = triangle.facing(probe.light);
        if !triangle.casts || !casters.contains(triangle.instance) || facing == 0 {
            return;
        }
        let mut in_own_plane = None;
        for (index, point) in probe.points.iter().enumerate() {
            let to_light = probe.light.truncate() - *point * probe.light.w;
            let between = wanted & (1 << index) != 0
                && is_crossed_once(&triangle.corners, *point, to_light)
                && triangle.side_of(*point, coordinate_m) == -facing;
            let ignored =
                between && *in_own_plane.get_or_insert_with(|| probe.is_own_plane(triangle, coordinate_m));
            if between && !ignored {
                let crossing =
                    triangle.plane_parameter(*point, to_light).map_or(*point, |t| *point + to_light * t);
                tints[index] *= color.passing(crossing);
            }
        }
    }
}

/// Whether the line through `from` along `direction`, moved by next to nothing, passes through the triangle.
pub(crate) fn is_crossed_once(corners: &[DVec3; 3], from: DVec3, direction: DVec3) -> bool {
    let [u, v, w] = corners.map(|corner| corner - from);
    // The sign of det(direction + (ε, ε², ε³), a, b).
    let sign = |a: DVec3, b: DVec3| {
        let product = a.cross(b);
        let signs = [direction.dot(product), product.x, product.y, product.z];
        signs.into_iter().find(|sign| *sign != 0.0).is_some_and(|sign| sign > 0.0)
    };
    let first = sign(u, v);
    first == sign(v, w) && first == sign(w, u)
}

impl<'a> Tracer<'a> {
    /// The transparent surfaces along `from + t·direction` with t from `t_min` to before `t_end`, nearest first; of
    /// several at exactly the same t the first drawn comes first. A mask's holes and alpha 0 are no surface.
    pub(crate) fn layers(
        &mut self,
        from: DVec3,
        direction: DVec3,
        t_min: f64,
        t_end: f64,
    ) -> Vec<(&'a Triangle, f64)> {
        let reference = self.reference;
        let mut layers = Vec::new();
        let Some(panes) = &reference.panes else { return layers };
        let Some(ray) = panes.bvh.ray(from, direction, t_min..t_end, 0.0) else { return layers };
        panes.bvh.walk(&ray, &mut self.stack, |leaf| {
            for (triangle, color) in panes.triangles[leaf.clone()].iter().zip(&panes.colors[leaf]) {
                let t = triangle.hit(from, direction).filter(|t| (t_min..t_end).contains(t));
                let Some(t) = t.filter(|_| is_crossed_once(&triangle.corners, from, direction)) else {
                    continue;
                };
                let base_color = color.at(from + direction * t);
                if color.material.coverage(base_color.w) > 0.0 {
                    layers.push((triangle, t));
                }
            }
            None
        });
        let order = |(triangle, _): &(&Triangle, f64)| (triangle.instance, triangle.triangle);
        layers.sort_by(|a, b| a.1.total_cmp(&b.1).then_with(|| order(a).cmp(&order(b))));
        layers
    }

    /// For each point of `probe`, what the transparent surfaces of `casters` between it and the light let pass.
    pub(crate) fn tints(&mut self, probe: &Probe<'_>, casters: &CasterSet) -> [DVec3; MOVES] {
        let mut tints = [DVec3::ONE; MOVES];
        let Some(panes) = &self.reference.panes else { return tints };
        let center = probe.points[0];
        let spread_m = probe.points.iter().map(|p| (*p - center).abs().max_element()).fold(0.0_f64, f64::max);
        let all = ((1_u32 << probe.points.len()) - 1) as u8;
        let together = panes.bvh.takes_thickness(spread_m);
        let rays: Vec<(DVec3, f64, u8)> = if together {
            vec![(center, spread_m, all)]
        } else {
            probe.points.iter().enumerate().map(|(index, point)| (*point, 0.0, 1 << index)).collect()
        };
        for (from, thickness_m, wanted) in rays {
            let Some(way) = panes.bvh.way_to_light(from, probe.light, thickness_m) else { continue };
            panes.bvh.walk(&way, &mut self.stack, |leaf| {
                for place in leaf {
                    panes.pass(place, (probe, casters, self.reference.coordinate_m), wanted, &mut tints);
                }
                None
            });
        }
        tints
    }
}

impl Query {
    /// What the transparent casters let pass to a point on `receiver`; all where it receives nothing.
    pub(crate) fn tint_at(&self, tracer: &mut Tracer<'_>, point: DVec3, receiver: &Triangle) -> Vec3 {
        let Some(casters) = self.transparent.as_ref().filter(|_| receiver.receives) else { return Vec3::ONE };
        let light = tracer.reference.lights[self.light].position;
        let probe = Probe { points: &[point], receiver: Some(receiver), light, casters: &self.casters };
        tracer.tints(&probe, casters)[0].as_vec3()
    }

    /// The same at a pixel, and whether it is ambiguous.
    pub(crate) fn tint(
        &self,
        tracer: &mut Tracer<'_>,
        moved: &Moved<'_>,
        casters: &CasterSet,
    ) -> (DVec3, bool) {
        let light = &tracer.reference.lights[self.light];
        let reached = moved.points.map(|point| light.reaches(point));
        if !moved.surface.receives || !reached[0] {
            return (DVec3::ONE, false);
        }
        let tints = tracer.tints(&self.probe(tracer, moved), casters);
        let changes = |tint: &DVec3| (*tint - tints[0]).abs().max_element() > SAME_FACTOR;
        let changed = tints.iter().zip(reached).any(|(tint, reached)| reached && changes(tint));
        (tints[0], changed || moved.is_at_rim(light.position, casters))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn point() -> impl Strategy<Value = DVec3> {
        [-4_i32..=4, -4_i32..=4, 1_i32..=4].prop_map(|c| DVec3::from(c.map(f64::from)))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        /// A fan around a point is one sheet: a line from below that does not miss it crosses exactly one of its
        /// triangles, even through the middle or along an edge, whichever way they are wound.
        #[test]
        fn a_sheet_is_crossed_once(
            from in point(),
            to in (-3_i32..=3, -3_i32..=3),
            turns in prop::array::uniform6(any::<(bool, bool)>()),
        ) {
            let rim = [(4, 0), (4, 4), (-4, 4), (-4, 0), (-4, -4), (4, -4)];
            let rim = rim.map(|(x, y)| DVec3::new(f64::from(x), f64::from(y), 0.0));
            let from = from * DVec3::new(1.0, 1.0, -1.0);
            let direction = DVec3::new(f64::from(to.0), f64::from(to.1), 0.0) - from;
            let crossed = (0..6).filter(|i| {
                let (a, b) = (rim[*i], rim[(i + 1) % 6]);
                let (flip, turn) = turns[*i];
                let corners = if flip { [a, DVec3::ZERO, b] } else { [DVec3::ZERO, a, b] };
                let [a, b, c] = corners;
                is_crossed_once(&if turn { [b, c, a] } else { corners }, from, direction)
            });
            prop_assert_eq!(crossed.count(), 1);
        }
    }

    #[test]
    fn texels_are_decoded_before_they_blend() {
        let image =
            Image { name: "two".into(), width: 2, height: 1, rgba8: vec![0, 0, 0, 0, 255, 255, 188, 255] };
        let texture = TextureRef::new(Default::default());
        let color = texture_value(&image, &texture, DVec2::new(0.5, 0.5), decoded);
        assert!((color - DVec4::new(0.5, 0.5, 0.5 * 0.502_886, 0.5)).abs().max_element() < 1e-6, "{color}");
    }
}
