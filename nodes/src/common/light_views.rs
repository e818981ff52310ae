//! From where a light looks at its casters: the views that maps are drawn in.
//!
//! A directional light has an orthographic view, or one for each cascade; a spot a perspective view of its cone; a point light
//! six, along the axes of the world. Each shows a *window* and no more: of what casts, what can fall on something. Windows have
//! sizes from a fixed series and begin on multiples of whole texels, counted from a fixed place, so that texels lie where they
//! lay while the eye or a caster moves a little, and what did not move is not drawn again.
//!
//! Everything is composed in f64. Depth is reversed: 1 near, and 0 at the far plane, which each view has where the last of what
//! receives lies along it (paper 003 §8.2.1.2): a lamp that is far away is then as exact as one that is near.

use glam::{DAffine3, DMat3, DMat4, DVec2, DVec3, DVec4};
use shadowgraph_engine::math::{Aabb, Plane};
use shadowgraph_engine::scene::{LightKind, LightSnapshot};
use shadowgraph_engine::shadow::View;

use super::boxes::{cut, faces_of};

/// Windows begin on multiples of this share of themselves.
const STEPS: u32 = 32;
/// Windows have sizes of this many steps for each power of two.
const SIZES: f64 = 8.0;
/// A window is at least this share of its other side.
const LEAST_SHARE: f64 = 1e-4;
/// And at least this wide, a metre before the light.
const LEAST_WIDTH: f64 = 1e-13;
/// Nothing is nearer to a light, relative to how far away casters are: there depth would leave the range of f32.
const NEAREST: f64 = 1e-10;
/// Of so many steps along each axis are the directions in which a point light may look.
const DIRECTIONS: f64 = 4.0;
/// Within so much of its direction: then a texel is no larger than it would be in one of six views.
const NARROW_COSINE: f64 = 0.7;
/// A spot that opens wider than this is seen in six views.
const WIDEST_RAD: f64 = 1.05;

/// How depth falls from the light on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Depth {
    /// From 1 to 0 over so many metres; the end lies so high along the direction towards the light.
    Orthographic {
        /// In metres from the origin.
        end_m: f64,
        /// In metres.
        range_m: f64,
    },
    /// Linear in 1 / distance along the view.
    Perspective {
        /// In metres.
        near_m: f64,
        /// In metres.
        far_m: f64,
    },
}

/// What a light sees of the world in one layer of its maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightView {
    /// The light; for a direction the world's origin.
    pub origin: DVec3,
    /// Its rows are the view's axes: right, up, and towards the light.
    pub light_from_world: DMat3,
    /// The window: of what is a metre before the light, or in metres.
    pub window: [DVec2; 2],
    /// How depth falls.
    pub depth: Depth,
}

/// Where a caster is, and where its shadows may fall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CasterBox {
    /// The box around all of it.
    pub whole: Aabb,
    /// The box around what its shadows may fall on, where that is known.
    pub shadows: Option<Aabb>,
}

/// What a view is to be good for.
#[derive(Clone, Copy, Debug)]
pub struct MapSize {
    /// Texels along a side.
    pub texels: u32,
    /// Texels beside a point that are looked up for it, and a little more.
    pub margin: f64,
}

impl LightView {
    /// A point of the world along the view's axes, from its origin.
    pub fn light_from(&self, p_in_world: DVec3) -> DVec3 {
        self.light_from_world * (p_in_world - self.origin)
    }

    /// All of its numbers, for keys.
    pub fn bits(&self) -> [u64; 18] {
        let depth = match self.depth {
            Depth::Orthographic { end_m, range_m } => [end_m, range_m],
            Depth::Perspective { near_m, far_m } => [near_m, far_m],
        };
        let numbers = self.light_from_world.to_cols_array().into_iter().chain(self.origin.to_array());
        let numbers =
            numbers.chain(self.window.into_iter().flat_map(|corner| corner.to_array())).chain(depth);
        let mut bits = [0; 18];
        bits.iter_mut().zip(numbers).for_each(|(bits, number)| *bits = number.to_bits());
        bits
    }

    /// Whether it is a lamp's.
    pub fn is_perspective(&self) -> bool {
        matches!(self.depth, Depth::Perspective { .. })
    }

    /// From the view's axes to clip space.
    pub fn clip_from_light(&self) -> DMat4 {
        let [low, high] = self.window;
        let (scale, middle) = (2.0 / (high - low), (low + high) / (high - low));
        match self.depth {
            Depth::Orthographic { end_m, range_m } => DMat4::from_cols(
                DVec4::X * scale.x,
                DVec4::Y * scale.y,
                DVec4::Z / range_m,
                DVec4::new(-middle.x, -middle.y, -end_m / range_m, 1.0),
            ),
            Depth::Perspective { near_m, far_m } => {
                let steepness = near_m / (far_m - near_m);
                DMat4::from_cols(
                    DVec4::X * scale.x,
                    DVec4::Y * scale.y,
                    DVec4::new(middle.x, middle.y, steepness, -1.0),
                    DVec4::Z * (steepness * far_m),
                )
            }
        }
    }

    /// From some local space to clip space.
    pub fn clip_from_local(&self, world_from_local: &DAffine3) -> DMat4 {
        let translation = self.light_from(world_from_local.translation);
        let matrix3 = self.light_from_world * world_from_local.matrix3;
        self.clip_from_light() * DMat4::from(DAffine3 { matrix3, translation })
    }

    /// From some local space to (x, y) in texels of a map of so many, x right and y down, and depth.
    pub fn map_from_local(&self, world_from_local: &DAffine3, texels: u32) -> DMat4 {
        let half = f64::from(texels) * 0.5;
        let texels_from_clip =
            DMat4::from_cols(DVec4::X * half, DVec4::Y * -half, DVec4::Z, DVec4::new(half, half, 0.0, 1.0));
        texels_from_clip * self.clip_from_local(world_from_local)
    }

    /// What it shows on so many texels along a side, for the plan's text.
    pub fn description(&self, texels: u32) -> String {
        let [low, high] = self.window;
        let size = high - low;
        match self.depth {
            Depth::Orthographic { .. } => {
                format!("{texels} x {texels} texels on {:.3} x {:.3} m", size.x, size.y)
            }
            Depth::Perspective { near_m, far_m } => format!(
                "{texels} x {texels} texels on {:.3} x {:.3} m at 1 m, from {near_m:.3e} m to {far_m:.3e} m",
                size.x, size.y
            ),
        }
    }

    /// Whether something within `bounds` may be in the window and before what receives.
    pub fn may_show(&self, bounds: &Aabb) -> bool {
        let corners = bounds.corners().map(|corner| self.light_from(corner));
        let [low, high] = self.window;
        match self.depth {
            Depth::Orthographic { end_m, .. } => {
                let around = Aabb::from_points(corners);
                around.max.z >= end_m
                    && around.min.truncate().cmple(high).all()
                    && around.max.truncate().cmpge(low).all()
            }
            Depth::Perspective { .. } => seen_window(&corners, low, high).is_some(),
        }
    }
}

/// The part of a window that a box before a perspective view spans, given by its corners along the view's axes, and how near it
/// comes; `None` where it is beside or behind the light.
fn seen_window(corners: &[DVec3; 8], low: DVec2, high: DVec2) -> Option<([DVec2; 2], f64)> {
    let before = |corner: &&DVec3| corner.z < 0.0;
    let count = corners.iter().filter(before).count();
    if count == 0 {
        return None;
    }
    let spanned = |corners: &[DVec3]| {
        let seen = corners.iter().map(|corner| corner.truncate() / -corner.z);
        let least = seen.clone().fold(DVec2::INFINITY, DVec2::min).max(low);
        let most = seen.fold(DVec2::NEG_INFINITY, DVec2::max).min(high);
        let nearest_m = corners.iter().map(|corner| -corner.z).fold(f64::INFINITY, f64::min);
        least.cmple(most).all().then_some(([least, most], nearest_m))
    };
    if count == corners.len() {
        return spanned(corners);
    }
    // Cut off what is beside the window, and behind the light.
    let size_m = corners.iter().map(|corner| corner.length()).fold(0.0, f64::max);
    let beside = [
        DVec3::new(1.0, 0.0, low.x),
        DVec3::new(-1.0, 0.0, -high.x),
        DVec3::new(0.0, 1.0, low.y),
        DVec3::new(0.0, -1.0, -high.y),
    ];
    let beside = beside.map(|normal| Plane { normal: normal.normalize(), offset: 0.0 });
    let behind = Plane { normal: DVec3::NEG_Z, offset: NEAREST * size_m };
    let mut faces = faces_of(corners);
    for plane in beside.iter().chain([&behind]) {
        faces = cut(&faces, plane);
    }
    spanned(&faces.concat())
}

/// Where a window along one axis begins and how long it is, around `low` … `high` with the margin on both sides.
fn snapped(low: f64, high: f64, size: MapSize) -> (f64, f64) {
    let texels = f64::from(size.texels);
    let step = f64::from(size.texels.div_ceil(STEPS)) / texels;
    let wanted = (high - low) / (1.0 - step - 2.0 * size.margin / texels);
    let length = ((wanted.log2() * SIZES).ceil() / SIZES).exp2();
    let begin = low - size.margin * length / texels;
    let step = step * length;
    ((begin / step).floor() * step, length)
}

/// The window around both corners.
fn window(low: DVec2, high: DVec2, least: f64, size: MapSize) -> [DVec2; 2] {
    let wider = (high - low).max_element() * LEAST_SHARE;
    let grown = (DVec2::splat(wider.max(least)) - (high - low)).max(DVec2::ZERO) * 0.5;
    let (low, high) = (low - grown, high + grown);
    let (x, y) = (snapped(low.x, high.x, size), snapped(low.y, high.y, size));
    [DVec2::new(x.0, y.0), DVec2::new(x.0 + x.1, y.0 + y.1)]
}

/// The axes along which a direction towards the light is z.
pub fn axes_towards(towards: DVec3) -> DMat3 {
    let towards = towards.normalize();
    let (right, up) = towards.any_orthonormal_pair();
    // Rows, and right-handed.
    DMat3::from_cols(right, up, towards).transpose()
}

/// The view of a direction in which `casters` may shadow what is at `receivers`; both along its axes, boxes of the former and
/// points that span the latter. `top_within` says how high a caster reaches within a window. `None` where nothing can.
pub fn directional_view(
    light_from_world: DMat3,
    casters: &[CasterBox],
    top_within: impl Fn(usize, &LightView) -> f64,
    receivers: &[DVec3],
    size: MapSize,
) -> Option<LightView> {
    let around = Aabb::from_points(receivers.iter().copied());
    if around.is_empty() {
        return None;
    }
    let matter = |caster: &Aabb| {
        let meets =
            |axis: usize| caster.min[axis] <= around.max[axis] && caster.max[axis] >= around.min[axis];
        meets(0) && meets(1) && caster.max.z > around.min.z
    };
    // Of a flat caster what is before something.
    let before = |caster: &CasterBox| {
        let Aabb { mut min, mut max } = caster.whole;
        if let Some(shadows) = caster.shadows {
            (min.x, min.y) = (min.x.max(shadows.min.x), min.y.max(shadows.min.y));
            (max.x, max.y) = (max.x.min(shadows.max.x), max.y.min(shadows.max.y));
        }
        Aabb { min, max }
    };
    let wanted = casters.iter().map(before).filter(|bounds| !bounds.is_empty() && matter(bounds));
    let wanted = wanted.fold(Aabb::EMPTY, |all, caster| all.union(&caster));
    if wanted.is_empty() {
        return None;
    }
    let (low, high) = (wanted.min.max(around.min), wanted.max.min(around.max));
    let least = 1e-9 * (around.radius() + around.center().length()).max(f64::MIN_POSITIVE);
    let window = window(low.truncate(), high.truncate(), least, size);
    // What lies in the window's margins may cast too.
    let overlaps = |caster: &Aabb| {
        caster.min.truncate().cmple(window[1]).all() && caster.max.truncate().cmpge(window[0]).all()
    };
    let ending_at = |top_m: f64| {
        let rounding = MapSize { margin: 0.0, texels: STEPS };
        let (end_m, range_m) = snapped(around.min.z - least, top_m + least, rounding);
        let depth = Depth::Orthographic { end_m, range_m };
        LightView { origin: DVec3::ZERO, light_from_world, window, depth }
    };
    let overlapping = || casters.iter().enumerate().filter(|(_, caster)| overlaps(&caster.whole));
    let highest_m = overlapping().map(|(_, caster)| caster.whole.max.z).fold(wanted.max.z, f64::max);
    // Depth has no digits to spare for what is high above another place.
    let whole = ending_at(highest_m);
    let top_m = overlapping().map(|(number, _)| top_within(number, &whole)).fold(around.min.z, f64::max);
    Some(ending_at(top_m.max(around.min.z + least)))
}

/// The six views of a point light, in the order of the axes (+x, −x, +y, −y, +z, −z): `None` where nothing casts. `casters` are
/// boxes in the world; what lies farther along a view than all of `receivers` casts nothing there.
pub fn point_views(
    origin: DVec3,
    casters: &[CasterBox],
    receivers: &Aabb,
    size: MapSize,
) -> [Option<LightView>; 6] {
    // Each view a little wider than its sixth, so that what is looked up beside a seam is there.
    let widest = 1.0 / (1.0 - 2.0 * size.margin / f64::from(size.texels));
    std::array::from_fn(|face| {
        let mut forward = DVec3::ZERO;
        forward[face / 2] = if face % 2 == 0 { 1.0 } else { -1.0 };
        perspective_view(origin, forward, widest, (casters, receivers), size)
    })
}

/// One view of a point light in place of six, where all of `casters` stand on one side of it. It looks along one of a fixed set of
/// directions, so that it does not turn with every caster that moves a little.
pub fn narrow_view(
    origin: DVec3,
    casters: &[CasterBox],
    receivers: &Aabb,
    size: MapSize,
) -> Option<Option<LightView>> {
    // Of a flat caster it is enough to see what is behind it, which may be less than all of it, or more.
    let whole: Vec<Aabb> = casters.iter().map(|caster| caster.whole).collect();
    let behind: Vec<Aabb> = casters.iter().map(|caster| caster.shadows.unwrap_or(caster.whole)).collect();
    let (forward, cosine) = narrow_cone(origin, &whole).or_else(|| narrow_cone(origin, &behind))?;
    let opening = cosine.acos().tan() + 2.0 * size.margin / f64::from(size.texels);
    Some(perspective_view(origin, forward, opening, (casters, receivers), size))
}

/// One of a fixed set of directions, and the cosine of the cone around it in which all boxes are; `None` where that is wide.
fn narrow_cone(origin: DVec3, boxes: &[Aabb]) -> Option<(DVec3, f64)> {
    let all = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(bounds));
    let towards = (all.center() - origin).normalize_or_zero();
    let forward = (towards * DIRECTIONS).round().normalize_or_zero();
    let corners = boxes.iter().flat_map(|bounds| bounds.corners());
    let widest = corners.map(|corner| (corner - origin).normalize_or_zero().dot(forward));
    // What a box holds is within the cone about its corners, as long as that is less than half of all directions.
    let cosine = widest.fold(1.0_f64, f64::min);
    let is_narrow = cosine > NARROW_COSINE && boxes.iter().all(|bounds| !bounds.contains(origin));
    is_narrow.then_some((forward, cosine))
}

/// The views of a spot: one, or those of a point light where it opens too wide for that.
pub fn spot_views(
    light: &LightSnapshot,
    casters: &[CasterBox],
    receivers: &Aabb,
    size: MapSize,
) -> Vec<Option<LightView>> {
    let origin = light.position.truncate();
    match spot_opening(light) {
        Some(opening) => {
            vec![perspective_view(origin, light.direction, opening.tan(), (casters, receivers), size)]
        }
        None => point_views(origin, casters, receivers, size).to_vec(),
    }
}

/// Half the angle of a spot that one view can show.
pub fn spot_opening(light: &LightSnapshot) -> Option<f64> {
    match light.light.kind {
        LightKind::Spot { outer_rad, .. } => Some(outer_rad).filter(|angle| *angle <= WIDEST_RAD),
        _ => None,
    }
}

fn perspective_view(
    origin: DVec3,
    forward: DVec3,
    widest: f64,
    (casters, receivers): (&[CasterBox], &Aabb),
    size: MapSize,
) -> Option<LightView> {
    let light_from_world = axes_towards(-forward);
    let local = |bounds: &Aabb| bounds.corners().map(|corner| light_from_world * (corner - origin));
    let farthest_m = local(receivers).into_iter().map(|p| -p.z).fold(f64::NEG_INFINITY, f64::max);
    let (low, high) = (DVec2::splat(-widest), DVec2::splat(widest));
    let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let (mut nearest_m, mut end_m) = (f64::INFINITY, 0.0_f64);
    for CasterBox { whole, shadows } in casters {
        let corners = local(whole);
        let from_m = corners.iter().map(|p| -p.z).fold(f64::INFINITY, f64::min);
        if from_m > farthest_m {
            continue;
        }
        let Some(([from, to], seen_m)) = seen_window(&corners, low, high) else { continue };
        // Of a flat caster what is before something.
        let seen = match shadows.map(|bounds| seen_window(&local(&bounds), low, high)) {
            None => Some([from, to]),
            Some(behind) => behind.map(|([least, most], _)| [from.max(least), to.min(most)]),
        };
        if let Some([from, to]) = seen.filter(|[from, to]| from.cmple(*to).all()) {
            (least, most) = (least.min(from), most.max(to));
        }
        nearest_m = nearest_m.min(seen_m);
        end_m = corners.iter().map(|p| p.length()).fold(end_m, f64::max);
    }
    if end_m == 0.0 || least.cmpgt(most).any() {
        return None;
    }
    // A little more than there is between them.
    let slack_m = 1e-3 * (farthest_m - nearest_m.max(0.0)) + 1e-9 * farthest_m;
    let near_m = (nearest_m - slack_m).max(NEAREST * end_m);
    let far_m = (farthest_m + slack_m).max(near_m * (1.0 + 1e-9));
    let window = window(least, most, LEAST_WIDTH, size);
    Some(LightView { origin, light_from_world, window, depth: Depth::Perspective { near_m, far_m } })
}

/// The corners of what a view sees of `bounds` between two distances along it, in metres.
pub fn seen_corners(view: &View, bounds: &Aabb, [from_m, to_m]: [f64; 2]) -> Vec<DVec3> {
    if bounds.is_empty() {
        return Vec::new();
    }
    let eye = view.camera.world_from_view.translation;
    let forward = view.camera.world_from_view.transform_vector3(DVec3::NEG_Z).normalize_or_zero();
    let mut planes = view.frustum.planes.clone();
    planes.push(Plane { normal: forward, offset: forward.dot(eye) + from_m });
    if to_m.is_finite() {
        planes.push(Plane { normal: -forward, offset: -forward.dot(eye) - to_m });
    }
    let margin = 1e-9 * (bounds.radius() + bounds.center().length());
    let mut faces = faces_of(&bounds.corners());
    for plane in planes {
        faces = cut(&faces, &Plane { offset: plane.offset - margin, ..plane });
    }
    faces.concat()
}

/// Where cascades end along the view: half way between equal lengths and equal ratios.
pub fn splits([nearest_m, farthest_m]: [f64; 2], cascades: u32, perspective: bool) -> Vec<f64> {
    let begin_m = nearest_m.max(farthest_m * 1e-4);
    let end = |number: u32| {
        let share = f64::from(number) / f64::from(cascades);
        let even = begin_m + (farthest_m - begin_m) * share;
        let by_ratio = begin_m * (farthest_m / begin_m).powf(share);
        if perspective && begin_m > 0.0 { 0.5 * (even + by_ratio) } else { even }
    };
    (1..=cascades).map(end).collect()
}

/// How far along the view its nearest and farthest receivers are, in metres.
pub fn seen_range(view: &View, bounds: &Aabb) -> Option<[f64; 2]> {
    let view_from_world = view.camera.world_from_view.inverse();
    let corners = seen_corners(view, bounds, [0.0, f64::INFINITY]);
    let distances: Vec<f64> = corners.iter().map(|p| -view_from_world.transform_point3(*p).z).collect();
    let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
    let farthest = distances.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (nearest <= farthest).then_some([nearest, farthest])
}
