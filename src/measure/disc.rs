//! Which samples of a light's disc does a point see? Every triangle that stands anywhere between the point and the disc is
//! found at once, and most are settled for the whole disc.
//!
//! As the sample moves over the disc, everything that decides whether a triangle is in the way (three edge functions,
//! and on which side of the triangle's plane the light is) changes linearly: a [`Form`]. Its least and largest values over the disc are
//! known in closed form. So a triangle misses the whole disc, covers all of it, or is kept for single samples.
//!
//! **Nothing is decided by a form that is not clear.** The moves of the ambiguity band change a form by no more than
//! its margin, rounding included. Within the margin each of the moves has forms of its own ([`Aim`]), whose margins are
//! rounding alone, and where these are not clear either the exact questions of [`super::surface`] are asked; so the answers
//! are those of asking every triangle for every sample and move.

use glam::{DVec2, DVec3, DVec4};
use shadowgraph_engine::shadow::{LightDisc, LightSize};

use super::bvh::Open;
use super::moved::{CORNERS, MOVES, Moved};
use super::reference::{CasterSet, Reference};
use super::surface::Triangle;

/// Rounding of forms and of what they stand in for, in shares of the products they are sums of: some tens of roundings.
const ROUNDING: f64 = 1e-14;

/// What a sample's direction may be off on the GPU, as a share of its length: some roundings of f32.
const DIRECTION_EPSILON: f64 = 1e-6;

/// All ways from a receiver's point, and its moved copies, to the light.
pub(super) struct Way<'a> {
    moved: &'a Moved<'a>,
    casters: &'a CasterSet,
    light: DVec4,
    /// The point with the margins that cover its moves, then the point and each moved copy by itself.
    aims: [Aim; 1 + MOVES + CORNERS],
    /// The disc that the unmoved point sees.
    disc: LightDisc,
    /// Whether samples lie anywhere, as far as the moves can tell.
    unsettled: bool,
}

/// All ways from one point to the disc that it sees.
struct Aim {
    point: DVec3,
    /// From the point to the disc's centre, and to where the disc's axes end from there.
    to_center: DVec3,
    axes: [DVec3; 2],
    /// The disc's radius.
    radius: f64,
    /// How far the point moves, and how far a sample.
    point_moves: f64,
    sample_moves: f64,
}

/// A disc is unsettled when its samples move by more than this share of its radius.
const UNSETTLED: f64 = 1.0 / 16.0;

impl<'a> Way<'a> {
    pub(super) fn new(size: LightSize, casters: &'a CasterSet, light: DVec4, moved: &'a Moved<'a>) -> Self {
        let points = moved.everywhere();
        let center = points[0];
        let position = light.truncate();
        let to_light = |point: DVec3| position - point * light.w;
        let discs = points.map(|point| size.disc(to_light(point).extend(light.w)));
        let axes = |disc: &LightDisc| [disc.u * disc.radius, disc.v * disc.radius];
        let own = axes(&discs[0]);
        let turns = discs.iter().map(axes).map(|[u, v]| (u - own[0]).length() + (v - own[1]).length());
        let sample_moves = turns.fold(0.0, f64::max);
        let point_moves = points.iter().map(|point| point.distance(center)).fold(0.0, f64::max);
        let aim = |index: usize, moves: [f64; 2]| Aim {
            point: points[index],
            to_center: to_light(points[index]),
            axes: axes(&discs[index]),
            radius: discs[index].radius,
            point_moves: moves[0],
            sample_moves: moves[1] + 1e-15 * (position.length() + discs[index].radius),
        };
        Self {
            moved,
            casters,
            light,
            aims: std::array::from_fn(|index| match index.checked_sub(1) {
                None => aim(0, [point_moves, sample_moves]),
                Some(index) => aim(index, [0.0; 2]),
            }),
            disc: discs[0],
            unsettled: sample_moves > discs[0].radius * UNSETTLED,
        }
    }

    /// The disc that the unmoved point sees.
    pub(super) fn disc(&self) -> &LightDisc {
        &self.disc
    }

    /// The point with all its moves.
    fn all_moves(&self) -> &Aim {
        &self.aims[0]
    }

    /// The point alone, or one of its moved copies.
    fn move_alone(&self, index: usize) -> &Aim {
        &self.aims[index + 1]
    }

    /// Where a moved point sees `sample`.
    fn sample(&self, index: usize, sample: DVec2) -> DVec4 {
        let [u, v] = self.move_alone(index).axes;
        self.light + (u * sample.x + v * sample.y).extend(0.0)
    }
}

impl Aim {
    /// The largest distance of a sample from the point, and of one from `corner`.
    fn reach(&self, corner: DVec3, light: DVec4) -> [f64; 2] {
        let beyond = self.radius + self.sample_moves;
        let length = self.to_center.length() + beyond;
        [length, if light.w == 0.0 { length } else { corner.distance(light.truncate()) + beyond }]
    }

    /// How `normal` · sample changes over the disc, from `center` on.
    fn form(&self, center: f64, normal: DVec3, margin: f64) -> Form {
        Form { center, slope: DVec2::new(normal.dot(self.axes[0]), normal.dot(self.axes[1])), margin }
    }

    /// On which side of `triangle` samples lie.
    fn light_side(&self, triangle: &Triangle, light: DVec4, moves: f64) -> Form {
        let normal = triangle.normal();
        let corner = triangle.corners[0];
        let center = normal.dot(light.truncate() - corner * light.w);
        let [_, reach] = self.reach(corner, light);
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
    /// Positive beyond doubt.
    const EVERYWHERE: Self = Self { center: 1.0, slope: DVec2::ZERO, margin: 0.0 };

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
    /// Where what each move says of it by itself begins, once that was asked.
    moves: Option<u32>,
    /// The three edges and the side of the light, positive where the triangle is in the way. The side is 1 everywhere
    /// where on which side the point lies is open: then edges only exclude, by different signs.
    forms: [Form; 4],
    /// Whether it may have holes: then forms only exclude.
    is_masked: bool,
    /// On which side of its plane the point lies is open.
    open: bool,
}

impl Partial {
    /// Whether it stands before `sample`, but for holes, where the forms settle that.
    #[inline(always)]
    fn decides(&self, sample: DVec2) -> Option<bool> {
        let mut all_clear = !self.open;
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

/// What is known of a triangle and one move.
enum Known {
    Nothing,
    Is(Class),
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
    /// The indices of those of them that are open for a sample.
    doubtful: Vec<u32>,
    /// What single moves say of those that were open for any sample: as many for each as there are moves.
    by_move: Vec<Known>,
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
            by_move: Vec::new(),
            own_side: None,
            last_cover: u32::MAX,
        }
    }
}

impl DiscTracer<'_> {
    /// Finds everything that is between; `Some` when every sample is lit, or every one dark, beyond doubt.
    pub(super) fn gather(&mut self, way: &Way<'_>) -> Option<bool> {
        let Self { reference, stack, partly, by_move, own_side, last_cover, .. } = self;
        partly.clear();
        by_move.clear();
        let aim = way.all_moves();
        let surface = way.moved.surface;
        // Moved in depth, the point leaves its plane, and the light is seen from there.
        let normal = surface.normal().normalize_or_zero();
        let off_plane = way.moved.points.map(|point| (normal.dot(point - way.moved.points[0])).abs());
        let off_plane = if way.light.w == 0.0 { 0.0 } else { off_plane.into_iter().fold(0.0, f64::max) };
        let direction_error = DIRECTION_EPSILON * aim.reach(surface.corners[0], way.light)[0];
        let facing = match surface.lets_light_pass {
            true => Form::EVERYWHERE,
            false => {
                let side = aim.light_side(surface, way.light, off_plane + direction_error);
                side.times(f64::from(way.moved.eye_side))
            }
        };
        let [least, largest] = facing.range();
        if largest < -facing.margin || (way.moved.eye_side == 0 && !surface.lets_light_pass) {
            return Some(false);
        }
        *own_side = Some(facing);
        if reference.triangles.get(*last_cover as usize).is_some()
            && matches!(reference.classify(*last_cover, way, aim), Class::Covers)
        {
            return Some(false);
        }
        let spread = |axis: usize| aim.axes[0][axis].hypot(aim.axes[1][axis]) + aim.sample_moves;
        let far_m = DVec3::new(spread(0), spread(1), spread(2));
        let cone = reference.bvh.cone(aim.point, aim.point_moves, aim.to_center, far_m, way.light.w != 0.0);
        let mut covered = false;
        reference.bvh.walk_cone(&cone, stack, |leaf| {
            for place in leaf {
                match reference.classify(place as u32, way, aim) {
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
        let Self { reference, partly, doubtful, by_move, own_side, .. } = self;
        let (Some(facing), surface) = (own_side, way.moved.surface) else { return dark };
        let faces = facing.sign_of(facing.at(sample));
        if faces < 0 {
            return dark;
        }
        doubtful.clear();
        let mut covering = None;
        for (index, partial) in partly.iter().enumerate() {
            match partial.decides(sample) {
                Some(false) => continue,
                Some(true) if !partial.is_masked => {
                    covering = Some(index);
                    break;
                }
                Some(true) | None => doubtful.push(index as u32),
            }
        }
        if let Some(index) = covering {
            // Neighbouring samples are likely to be behind the same triangle.
            partly.swap(0, index);
            return dark;
        }
        let mut blocked = |index: usize| {
            let mut blocks = |open: &u32| {
                reference.blocks_move(&mut partly[*open as usize], by_move, way, (index, sample))
            };
            doubtful.iter().any(&mut blocks)
        };
        let is_blocked = blocked(0);
        let turned_away = faces == 0 && surface.facing(way.sample(0, sample)) * way.moved.eye_side <= 0;
        // Where the sample may lie anywhere, the moves do not tell where; only margins do.
        let certain = match doubtful.is_empty() {
            true => faces != 0,
            false => {
                let settled = !way.unsettled && (is_blocked || faces != 0);
                settled && (1..MOVES + CORNERS).all(|index| blocked(index) == is_blocked)
            }
        };
        Sight { lit: !is_blocked && !turned_away, certain }
    }
}

impl Reference {
    /// How much of the disc `place` stands before, for a point or for all its moves.
    fn classify(&self, place: u32, way: &Way<'_>, aim: &Aim) -> Class {
        let triangle = &self.triangles[place as usize];
        if !triangle.casts || triangle.is(way.moved.surface) || !way.casters.contains(triangle.instance) {
            return Class::Misses;
        }
        let point = aim.point;
        let ends = triangle.corners.map(|corner| corner - point);
        let normal = triangle.normal();
        // On which side the point is, if its moves and the rounding of positions leave no doubt.
        let height = -normal.dot(ends[0]);
        let tolerance = triangle.side_tolerance(point, self.coordinate_m) * (1.0 + 1e-6)
            + normal.length() * aim.point_moves
            + ROUNDING * triangle.edges_product() * ends[0].length();
        let open = height.abs() <= tolerance;
        if open && triangle.holds(way.moved.surface, self.coordinate_m) {
            return Class::Misses;
        }
        // Seen from the other side, edges run the other way round.
        let sign = if open { 1.0 } else { -height.signum() };
        let edge = |index: usize| {
            let next = (index + 1) % 3;
            let across = ends[index].cross(ends[next]);
            let length = (ends[next] - ends[index]).length();
            let [reach, from_corner] = aim.reach(triangle.corners[index], way.light);
            let margin = aim.point_moves * length * (from_corner + aim.sample_moves)
                + aim.sample_moves * across.length()
                + ROUNDING * reach * ends[index].length() * ends[next].length();
            aim.form(aim.to_center.dot(across), across, margin).times(sign)
        };
        let edges = [edge(0), edge(1), edge(2)];
        let side = if open { Form::EVERYWHERE } else { aim.light_side(triangle, way.light, 0.0).times(sign) };
        let forms = [edges[0], edges[1], edges[2], side];
        let never = |form: &Form| form.range()[1] < -form.margin;
        let always = |form: &Form| form.range()[0] > form.margin;
        if forms.iter().any(never) && (!open || edges.iter().any(always)) {
            return Class::Misses;
        }
        let is_masked = triangle.is_masked();
        if !open && !is_masked && forms.iter().all(always) {
            return Class::Covers;
        }
        Class::Partly(Partial { place, moves: None, forms, is_masked, open })
    }

    /// Whether `partial` stands between the point, moved so, and `sample`.
    #[inline(always)]
    fn blocks_move(
        &self,
        partial: &mut Partial,
        by_move: &mut Vec<Known>,
        way: &Way<'_>,
        (index, sample): (usize, DVec2),
    ) -> bool {
        let triangle = &self.triangles[partial.place as usize];
        let first = *partial.moves.get_or_insert_with(|| {
            by_move.extend((0..MOVES + CORNERS).map(|_| Known::Nothing));
            (by_move.len() - MOVES - CORNERS) as u32
        });
        let known = &mut by_move[first as usize + index];
        if let Known::Nothing = known {
            *known = Known::Is(self.classify(partial.place, way, way.move_alone(index)));
        }
        let (point, light) = (way.move_alone(index).point, way.sample(index, sample));
        match known {
            Known::Is(Class::Misses) => false,
            Known::Is(Class::Covers) => true,
            Known::Is(Class::Partly(alone)) => match alone.decides(sample) {
                Some(true) if alone.is_masked => !triangle.has_hole_towards(point, light),
                Some(blocks) => blocks,
                None => triangle.blocks(point, light, self.coordinate_m),
            },
            Known::Nothing => triangle.blocks(point, light, self.coordinate_m),
        }
    }
}
