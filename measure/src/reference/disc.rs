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

use super::bvh::Open;
use super::forms::{Class, Form, Partial};
use super::moved::{CORNERS, MOVES};
use super::samples::{Group, SampleTree};
use super::surface::Triangle;
use super::tracer::Reference;
use super::way::{Aim, ROUNDING, Way};

/// What a sample's direction may be off on the GPU, as a share of its length: some roundings of f32.
const DIRECTION_EPSILON: f64 = 1e-6;

/// What the point sees of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sight {
    pub(crate) lit: bool,
    /// Whether all moves agree.
    pub(crate) certain: bool,
}

/// Answers questions about discs, one after the other; one for each thread and query.
pub(crate) struct DiscTracer<'a> {
    pub(crate) reference: &'a Reference,
    pub(super) stack: Vec<Open>,
    /// What stands before part of the disc last gathered for.
    partly: Vec<Partial>,
    /// The indices of those of them that may be in the way: of all samples, then of a group, then of a group in that.
    open: Vec<u32>,
    /// What single moves say of those that were open for any sample: as many for each as there are moves.
    by_move: Vec<Option<Class>>,
    /// The receiver's plane.
    own_side: Option<Form>,
    /// What covered a whole disc last.
    last_cover: u32,
}

impl Reference {
    pub(crate) fn disc_tracer(&self) -> DiscTracer<'_> {
        DiscTracer {
            reference: self,
            stack: Vec::with_capacity(64),
            partly: Vec::new(),
            open: Vec::new(),
            by_move: Vec::new(),
            own_side: None,
            last_cover: u32::MAX,
        }
    }
}

impl DiscTracer<'_> {
    /// Finds everything that is between; `Some` when every sample is lit, or every one dark, beyond doubt.
    pub(crate) fn gather(&mut self, way: &Way<'_>) -> Option<bool> {
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
        let cone = way.cone(&reference.bvh);
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

    /// Tells what the point sees of all `samples` of a disc, after [`DiscTracer::gather`]: of groups where that is the same for all
    /// and the forms say so, of single ones elsewhere. What was found to be out of the way of a group is not asked about
    /// within it.
    pub(crate) fn ask(
        &mut self,
        way: &Way<'_>,
        (tree, samples): (&SampleTree, &[DVec2]),
        tell: &mut dyn FnMut(&[u32], Sight),
    ) {
        self.open.clear();
        self.open.extend(0..self.partly.len() as u32);
        if let Some(all) = tree.all() {
            self.ask_group(way, (tree, samples), all, 0, tell);
        }
    }

    /// The same of a group; what may be in the way of it is open from number `first` on.
    fn ask_group(
        &mut self,
        way: &Way<'_>,
        (tree, samples): (&SampleTree, &[DVec2]),
        group: &Group,
        first: usize,
        tell: &mut dyn FnMut(&[u32], Sight),
    ) {
        let own = self.open.len();
        if let Some(sight) = self.sees_all(way, group, first) {
            tell(tree.members(group), sight);
        } else if let Some(children) = tree.children(group) {
            for child in children {
                self.ask_group(way, (tree, samples), child, own, tell);
            }
        } else {
            for index in tree.members(group) {
                let sight = self.sees(way, samples[*index as usize], own);
                tell(&[*index], sight);
            }
        }
        self.open.truncate(own);
    }

    /// What the point sees of the disc's centre, which all samples are in, after [`DiscTracer::gather`].
    pub(crate) fn sees_center(&mut self, way: &Way<'_>) -> Sight {
        self.open.clear();
        self.open.extend(0..self.partly.len() as u32);
        self.sees(way, DVec2::ZERO, 0)
    }

    /// What the point sees of `sample`, where only what is open from number `first` on may be in the way.
    fn sees(&mut self, way: &Way<'_>, sample: DVec2, first: usize) -> Sight {
        let dark = Sight { lit: false, certain: true };
        let Self { reference, partly, open, by_move, own_side, .. } = self;
        let (Some(facing), surface) = (own_side, way.moved.surface) else { return dark };
        let faces = facing.sign_of(facing.at(sample));
        if faces < 0 {
            return dark;
        }
        let own = open.len();
        for place in first..own {
            let partial = &partly[open[place] as usize];
            match partial.decides(sample) {
                Some(false) => {}
                Some(true) => match reference.is_hole_for(partial, way, [sample; 1]) {
                    Some(true) => {}
                    Some(false) => {
                        open.truncate(own);
                        return dark;
                    }
                    None => open.push(open[place]),
                },
                None => open.push(open[place]),
            }
        }
        let mut blocked = |index: usize| {
            let light = way.sample(index, sample);
            open[own..].iter().any(|partial| {
                let partial = &mut partly[*partial as usize];
                reference.blocks_move(partial, by_move, way, index, (sample, light))
            })
        };
        let is_blocked = blocked(0);
        let turned_away = faces == 0 && surface.facing(way.sample(0, sample)) * way.moved.eye_side <= 0;
        // Where the sample may lie anywhere, the moves do not tell where; only margins do.
        let certain = match open.len() == own {
            true => faces != 0,
            false => {
                let settled = !way.unsettled && (is_blocked || faces != 0);
                settled && (1..MOVES + CORNERS).all(|index| blocked(index) == is_blocked)
            }
        };
        open.truncate(own);
        Sight { lit: !is_blocked && !turned_away, certain }
    }

    /// What the point sees of every sample of a group, where that is the same for all and the forms say so. What may be in
    /// the way is open from number `first` on, and what still may is added to that.
    fn sees_all(&mut self, way: &Way<'_>, group: &Group, first: usize) -> Option<Sight> {
        let Self { reference, partly, open, by_move, own_side, .. } = self;
        let facing = (*own_side)?;
        let [least, largest] = facing.range_in(group);
        let dark = Sight { lit: false, certain: true };
        if largest < -facing.margin {
            return Some(dark);
        }
        let own = open.len();
        for place in first..own {
            let partial = &partly[open[place] as usize];
            match partial.decides_all(group) {
                Some(false) => {}
                Some(true) => match reference.is_hole_for(partial, way, group.around()) {
                    Some(true) => {}
                    // Wherever samples face away, too.
                    Some(false) => return Some(dark),
                    None => open.push(open[place]),
                },
                None => open.push(open[place]),
            }
        }
        if least <= facing.margin {
            return None;
        }
        if open.len() == own {
            return Some(Sight { lit: true, certain: true });
        }
        if way.unsettled {
            return None;
        }
        let mut blocked = |index: usize| {
            let mut all_known = true;
            for partial in &open[own..] {
                match reference.known(&mut partly[*partial as usize], by_move, way, index) {
                    Class::Misses => {}
                    Class::Covers => return Some(true),
                    Class::Partly(alone) => match alone.decides_all(group) {
                        Some(true) if !alone.is_masked => return Some(true),
                        Some(false) => {}
                        Some(true) | None => all_known = false,
                    },
                }
            }
            all_known.then_some(false)
        };
        let is_blocked = blocked(0)?;
        let mut all_known = true;
        for index in 1..MOVES + CORNERS {
            match blocked(index) {
                Some(other) if other != is_blocked => {
                    return Some(Sight { lit: !is_blocked, certain: false });
                }
                other => all_known &= other.is_some(),
            }
        }
        all_known.then_some(Sight { lit: !is_blocked, certain: true })
    }
}

impl Reference {
    /// How much of the disc `place` stands before, for a point or for all its moves.
    fn classify(&self, place: u32, way: &Way<'_>, aim: &Aim) -> Class {
        let triangle = &self.triangles[place as usize];
        let casts = triangle.casts && way.casters.contains(triangle.instance);
        if casts { self.classify_triangle((place, triangle), way, aim) } else { Class::Misses }
    }

    /// How much of the disc a triangle stands before, whatever it is part of.
    pub(super) fn classify_triangle(
        &self,
        (place, triangle): (u32, &Triangle),
        way: &Way<'_>,
        aim: &Aim,
    ) -> Class {
        if triangle.is(way.moved.surface) {
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

    /// Whether the ways from the point, wherever it is moved, to all samples within the hull of `samples` meet a hole of
    /// `partial` (true) or none; they meet the triangle. `None` where they may meet both, or a sample may lie anywhere.
    fn is_hole_for<const N: usize>(
        &self,
        partial: &Partial,
        way: &Way<'_>,
        samples: [DVec2; N],
    ) -> Option<bool> {
        if !partial.is_masked {
            return Some(false);
        }
        if way.unsettled {
            return None;
        }
        let triangle = &self.triangles[partial.place as usize];
        let mut crossings = [[DVec3::ZERO; N]; MOVES + CORNERS];
        for (index, crossings) in crossings.iter_mut().enumerate() {
            let point = way.move_alone(index).point;
            for (crossing, sample) in crossings.iter_mut().zip(samples) {
                let light = way.sample(index, sample);
                let direction = light.truncate() - point * light.w;
                // A hull none of which is behind the point stays a hull.
                let t = triangle.plane_parameter(point, direction).filter(|t| *t > 0.0)?;
                *crossing = point + direction * t;
            }
            // What the point alone leaves open, its moves do not decide.
            if index == 0 {
                triangle.is_hole_within(crossings)?;
            }
        }
        triangle.is_hole_within(crossings.as_flattened())
    }

    /// Whether `partial` stands between the point, moved so, and `sample`.
    #[inline(always)]
    fn blocks_move(
        &self,
        partial: &mut Partial,
        by_move: &mut Vec<Option<Class>>,
        way: &Way<'_>,
        index: usize,
        (sample, light): (DVec2, DVec4),
    ) -> bool {
        let (place, point) = (partial.place, way.move_alone(index).point);
        let triangle = &self.triangles[place as usize];
        match self.known(partial, by_move, way, index) {
            Class::Misses => false,
            Class::Covers => true,
            Class::Partly(alone) => match alone.decides(sample) {
                Some(true) if alone.is_masked => !triangle.has_hole_towards(point, light),
                Some(blocks) => blocks,
                None => triangle.blocks(point, light, self.coordinate_m),
            },
        }
    }

    /// How much of the disc `partial` stands before for the point, moved so, alone.
    #[inline(always)]
    fn known<'a>(
        &self,
        partial: &mut Partial,
        by_move: &'a mut Vec<Option<Class>>,
        way: &Way<'_>,
        index: usize,
    ) -> &'a Class {
        let first = *partial.moves.get_or_insert_with(|| {
            by_move.extend((0..MOVES + CORNERS).map(|_| None));
            (by_move.len() - MOVES - CORNERS) as u32
        });
        let place = partial.place;
        by_move[first as usize + index]
            .get_or_insert_with(|| self.classify(place, way, way.move_alone(index)))
    }
}
