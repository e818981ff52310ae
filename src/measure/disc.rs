//! Which samples of a light's disc does a point see? Every triangle that stands anywhere between the point and the disc is
//! found at once, and most are settled for the whole disc.
//!
//! As the sample moves over the disc, everything that decides whether a triangle is in the way (three edge functions,
//! and on which side of the triangle's plane the light is) changes linearly: a [`Form`]. Its least and largest values over the disc are
//! known in closed form. So a triangle misses the whole disc, covers all of it, or is kept for single samples.
//!
//! **Nothing is decided by a form that is not clear.** The moves of the ambiguity band change a form by no more than
//! its margin, rounding included. Within the margin the exact questions of [`super::surface`] are asked, for each of the
//! moves; so the answers are those of asking every triangle for every sample and move.

use glam::{DVec2, DVec3, DVec4};
use shadowgraph_engine::shadow::{LightDisc, LightSize};

use super::bvh::Open;
use super::moved::{CORNERS, MOVES, Moved};
use super::reference::{CasterSet, Hit, Reference};
use super::surface::Triangle;

/// Rounding of forms and of what they stand in for, in shares of the products they are sums of: some tens of roundings.
const ROUNDING: f64 = 1e-14;

/// What a sample's direction may be off on the GPU, as a share of its length: some roundings of f32.
const DIRECTION_EPSILON: f64 = 1e-6;

/// All ways from a receiver's point, and its moved copies, to the light.
pub(super) struct Way<'a> {
    moved: &'a Moved,
    casters: &'a CasterSet,
    light: DVec4,
    discs: [LightDisc; MOVES + CORNERS],
    /// From the point to the disc's centre, and to where the disc's axes end from there.
    to_center: DVec3,
    axes: [DVec3; 2],
    /// The disc's radius.
    radius: f64,
    /// How far the point moves, and how far a sample.
    point_moves: f64,
    sample_moves: f64,
    /// Whether samples lie anywhere, as far as the moves can tell.
    unsettled: bool,
}

/// A disc is unsettled when its samples move by more than this share of its radius.
const UNSETTLED: f64 = 1.0 / 16.0;

impl<'a> Way<'a> {
    pub(super) fn new(size: LightSize, casters: &'a CasterSet, light: DVec4, moved: &'a Moved) -> Self {
        let points = moved.everywhere();
        let center = points[0];
        let position = light.truncate();
        let discs = points.map(|point| size.disc((position - point * light.w).extend(light.w)));
        let axes = |disc: &LightDisc| [disc.u * disc.radius, disc.v * disc.radius];
        let own = axes(&discs[0]);
        let turns = discs.iter().map(axes).map(|[u, v]| (u - own[0]).length() + (v - own[1]).length());
        let sample_moves = turns.fold(0.0, f64::max);
        let point_moves = points.iter().map(|point| point.distance(center)).fold(0.0, f64::max);
        let radius = discs[0].radius;
        Self {
            moved,
            casters,
            light,
            to_center: position - center * light.w,
            axes: own,
            radius,
            discs,
            point_moves,
            unsettled: sample_moves > radius * UNSETTLED,
            sample_moves: sample_moves + 1e-15 * (position.length() + radius),
        }
    }

    /// The disc that the unmoved point sees.
    pub(super) fn disc(&self) -> &LightDisc {
        &self.discs[0]
    }

    /// Where a moved point sees `sample`.
    fn sample(&self, index: usize, sample: DVec2) -> DVec4 {
        let LightDisc { radius, u, v } = self.discs[index];
        self.light + ((u * sample.x + v * sample.y) * radius).extend(0.0)
    }

    /// The largest distance of a sample from the point, and of one from `corner`.
    fn reach(&self, corner: DVec3) -> [f64; 2] {
        let beyond = self.radius + self.sample_moves;
        let length = self.to_center.length() + beyond;
        [length, if self.light.w == 0.0 { length } else { corner.distance(self.light.truncate()) + beyond }]
    }

    /// How `normal` · sample changes over the disc, from `center` on.
    fn form(&self, center: f64, normal: DVec3, margin: f64) -> Form {
        Form { center, slope: DVec2::new(normal.dot(self.axes[0]), normal.dot(self.axes[1])), margin }
    }

    /// On which side of `triangle` samples lie.
    fn light_side(&self, triangle: &Triangle, moves: f64) -> Form {
        let normal = triangle.normal();
        let corner = triangle.corners[0];
        let center = normal.dot(self.light.truncate() - corner * self.light.w);
        let [_, reach] = self.reach(corner);
        let rounding = ROUNDING * reach * triangle.edges_product();
        self.form(center, normal, normal.length() * (self.sample_moves + moves) + rounding)
    }
}

/// A linear function over the unit disc, and what it may be off.
#[derive(Clone, Copy)]
struct Form {
    center: f64,
    slope: DVec2,
    margin: f64,
}

impl Form {
    fn times(self, sign: f64) -> Self {
        Self { center: self.center * sign, slope: self.slope * sign, ..self }
    }

    /// The smallest and the largest value.
    fn range(&self) -> [f64; 2] {
        let reach = self.slope.length() * (1.0 + 1e-12);
        [self.center - reach, self.center + reach]
    }

    #[inline(always)]
    fn at(&self, sample: DVec2) -> f64 {
        self.center + self.slope.dot(sample)
    }

    /// +1 or −1 where the value's sign is beyond doubt.
    #[inline(always)]
    fn sign_of(&self, value: f64) -> i32 {
        i32::from(value > self.margin) - i32::from(value < -self.margin)
    }
}

/// A triangle that may stand before part of the disc.
struct Partial {
    place: u32,
    /// The three edges and the side of the light, positive where the triangle is in the way. The side is 1 everywhere
    /// where on which side the point lies is open: then edges only exclude, by different signs.
    forms: [Form; 4],
    /// Whether all forms being positive settles that it is in the way.
    settles: bool,
    /// On which side of its plane the point lies is open.
    open: bool,
}

impl Partial {
    /// Whether it stands before `sample`, where the forms settle that.
    #[inline(always)]
    fn decides(&self, sample: DVec2) -> Option<bool> {
        let mut all_clear = self.settles;
        let mut excluding = [false; 2];
        for form in &self.forms {
            let value = form.at(sample);
            if value < -form.margin {
                excluding[0] = true;
                if !self.open || excluding[1] {
                    return Some(false);
                }
            } else if value <= form.margin {
                all_clear = false;
            } else if self.open && form.slope != DVec2::ZERO {
                // The side of the light, which is 1 everywhere, excludes nothing.
                excluding[1] = true;
                if excluding[0] {
                    return Some(false);
                }
            }
        }
        all_clear.then_some(true)
    }
}

enum Class {
    Misses,
    Covers,
    Partly(Partial),
}

/// What the point sees of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sight {
    pub(super) lit: bool,
    /// Whether all moves agree.
    pub(super) certain: bool,
}

/// Answers questions about discs, one after the other; one for each thread and query.
pub(super) struct DiscTracer<'a> {
    pub(super) reference: &'a Reference,
    stack: Vec<Open>,
    /// What stands before part of the disc last gathered for.
    partly: Vec<Partial>,
    /// Those of them that are open for a sample.
    doubtful: Vec<u32>,
    /// The receiver's plane.
    own_side: Option<Form>,
    /// What covered a whole disc last.
    last_cover: u32,
}

impl Reference {
    pub(super) fn disc_tracer(&self) -> DiscTracer<'_> {
        DiscTracer {
            reference: self,
            stack: Vec::with_capacity(64),
            partly: Vec::new(),
            doubtful: Vec::new(),
            own_side: None,
            last_cover: u32::MAX,
        }
    }
}

impl DiscTracer<'_> {
    /// Finds everything that is between; `Some` when every sample is lit, or every one dark, beyond doubt.
    pub(super) fn gather(&mut self, way: &Way<'_>) -> Option<bool> {
        let Self { reference, stack, partly, own_side, last_cover, .. } = self;
        partly.clear();
        let surface = reference.surface(way.moved.hit)?;
        // Moved in depth, the point leaves its plane, and the light is seen from there.
        let normal = surface.normal().normalize_or_zero();
        let off_plane = way.moved.points.map(|point| (normal.dot(point - way.moved.points[0])).abs());
        let off_plane = if way.light.w == 0.0 { 0.0 } else { off_plane.into_iter().fold(0.0, f64::max) };
        let direction_error = DIRECTION_EPSILON * way.reach(surface.corners[0])[0];
        let facing =
            way.light_side(surface, off_plane + direction_error).times(f64::from(way.moved.eye_side));
        let [least, largest] = facing.range();
        if largest < -facing.margin || way.moved.eye_side == 0 {
            return Some(false);
        }
        *own_side = Some(facing);
        if reference.triangles.get(*last_cover as usize).is_some()
            && matches!(reference.classify(*last_cover, way), Class::Covers)
        {
            return Some(false);
        }
        let spread = |axis: usize| way.axes[0][axis].hypot(way.axes[1][axis]) + way.sample_moves;
        let far_m = DVec3::new(spread(0), spread(1), spread(2));
        let [from, ..] = way.moved.points;
        let cone = reference.bvh.cone(from, way.point_moves, way.to_center, far_m, way.light.w != 0.0);
        let mut covered = false;
        reference.bvh.walk_cone(&cone, stack, |leaf| {
            for place in leaf {
                match reference.classify(place as u32, way) {
                    Class::Misses => {}
                    Class::Partly(partial) => partly.push(partial),
                    Class::Covers => {
                        *last_cover = place as u32;
                        covered = true;
                    }
                }
            }
            !covered
        });
        match covered {
            true => Some(false),
            false => (partly.is_empty() && least > facing.margin).then_some(true),
        }
    }

    /// Whether the point sees `sample`, after [`DiscTracer::gather`].
    pub(super) fn sees(&mut self, way: &Way<'_>, sample: DVec2) -> Sight {
        let dark = Sight { lit: false, certain: true };
        let Self { reference, partly, doubtful, own_side, .. } = self;
        let (Some(facing), Some(surface)) = (own_side, reference.surface(way.moved.hit)) else { return dark };
        let faces = facing.sign_of(facing.at(sample));
        if faces < 0 {
            return dark;
        }
        doubtful.clear();
        let mut covering = None;
        for (index, partial) in partly.iter().enumerate() {
            match partial.decides(sample) {
                Some(false) => continue,
                Some(true) => {
                    covering = Some(index);
                    break;
                }
                None => {}
            }
            doubtful.push(partial.place);
        }
        if let Some(index) = covering {
            // Neighbouring samples are likely to be behind the same triangle.
            partly.swap(0, index);
            return dark;
        }
        let blocked_at = |doubtful: &[u32], first: usize, points: &[DVec3]| {
            let blocks = |place: &u32| reference.blocked_moves(*place, way, sample, first, points);
            doubtful.iter().fold(0, |bits, place| bits | blocks(place))
        };
        let all = (1_u8 << MOVES) - 1;
        let blocked = blocked_at(doubtful, 0, &way.moved.points);
        let turned_away = faces == 0 && surface.facing(way.sample(0, sample)) * way.moved.eye_side <= 0;
        // Seven moves do not tell where else an unsettled sample may lie; only margins do.
        let settled = doubtful.is_empty() || !way.unsettled;
        let mut certain = settled && (blocked == all || (blocked == 0 && faces != 0));
        if certain && !doubtful.is_empty() {
            let corners = blocked_at(doubtful, MOVES, &way.moved.corners);
            certain = corners == if blocked == 0 { 0 } else { u8::MAX };
        }
        Sight { lit: blocked & 1 == 0 && !turned_away, certain }
    }
}

impl Reference {
    /// How much of the disc `place` stands before.
    fn classify(&self, place: u32, way: &Way<'_>) -> Class {
        let triangle = &self.triangles[place as usize];
        let hit = Hit { instance: triangle.instance, triangle: triangle.triangle };
        if !triangle.casts || hit == way.moved.hit || !way.casters.contains(triangle.instance) {
            return Class::Misses;
        }
        let [point, ..] = way.moved.points;
        let ends = triangle.corners.map(|corner| corner - point);
        let normal = triangle.normal();
        // On which side the point is, if its moves and the rounding of positions leave no doubt.
        let height = -normal.dot(ends[0]);
        let tolerance = triangle.side_tolerance(point, self.coordinate_m) * (1.0 + 1e-6)
            + normal.length() * way.point_moves
            + ROUNDING * triangle.edges_product() * ends[0].length();
        let open = height.abs() <= tolerance;
        // Seen from the other side, edges run the other way round.
        let sign = if open { 1.0 } else { -height.signum() };
        let edge = |index: usize| {
            let next = (index + 1) % 3;
            let across = ends[index].cross(ends[next]);
            let length = (ends[next] - ends[index]).length();
            let [reach, from_corner] = way.reach(triangle.corners[index]);
            let margin = way.point_moves * length * (from_corner + way.sample_moves)
                + way.sample_moves * across.length()
                + ROUNDING * reach * ends[index].length() * ends[next].length();
            way.form(way.to_center.dot(across), across, margin).times(sign)
        };
        let edges = [edge(0), edge(1), edge(2)];
        let everywhere = Form { center: 1.0, slope: DVec2::ZERO, margin: 0.0 };
        let side = if open { everywhere } else { way.light_side(triangle, 0.0).times(sign) };
        let forms = [edges[0], edges[1], edges[2], side];
        let never = |form: &Form| form.range()[1] < -form.margin;
        let always = |form: &Form| form.range()[0] > form.margin;
        if forms.iter().any(never) && (!open || edges.iter().any(always)) {
            return Class::Misses;
        }
        let settles = !open && !triangle.is_masked();
        if settles && forms.iter().all(always) {
            return Class::Covers;
        }
        Class::Partly(Partial { place, forms, settles, open })
    }

    /// One bit for each of `points`, the moved ones from number `first` on: 1 where `place` stands between it and `sample`.
    fn blocked_moves(&self, place: u32, way: &Way<'_>, sample: DVec2, first: usize, points: &[DVec3]) -> u8 {
        let triangle = &self.triangles[place as usize];
        let [center, ..] = way.moved.points;
        let mut own_plane = None;
        let mut blocked = 0;
        for (index, point) in points.iter().enumerate() {
            if triangle.blocks(*point, way.sample(first + index, sample), self.coordinate_m) {
                // Moved off its plane: what holds the unmoved point in its own plane is the receiver's surface.
                let ignored = first + index >= 5
                    && *own_plane.get_or_insert_with(|| triangle.side_of(center, self.coordinate_m) == 0);
                blocked |= u8::from(!ignored) << index;
            }
        }
        blocked
    }
}
