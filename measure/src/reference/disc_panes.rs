//! What transparent surfaces let pass of each sample of a disc.
//!
//! A triangle stands before all of the disc, beside it, or before some samples ([`super::forms`]). Evenly coloured ones that stand
//! before all of it are multiplied once; of the others each sample is asked. Where a form is not clear, the exact question of
//! [`super::glass`] is: so a sheet is crossed once, even where a way meets the edge of two triangles.
//!
//! **Ambiguity.** A surface that a move may bring in the way, or out of it, counts for the least that is right and not for the
//! largest; of an uneven one the least and the largest over the moves count.

use glam::{DVec2, DVec3};

use super::disc::DiscTracer;
use super::forms::{Class, Partial};
use super::glass::{PaneColor, Panes, is_crossed_once};
use super::moved::MOVES;
use super::surface::Triangle;
use super::tracer::CasterSet;
use super::way::Way;

/// The transparent surfaces between a receiver's point and a disc.
pub(crate) struct PanesBefore<'a> {
    /// What those let pass that stand before all of it.
    whole: DVec3,
    partly: Vec<PaneBefore<'a>>,
    coordinate_m: f64,
}

/// One that may stand before part of the disc, or is not evenly coloured.
struct PaneBefore<'a> {
    triangle: &'a Triangle,
    color: &'a PaneColor,
    /// Before which part of the disc; `None` where before all of it.
    partial: Option<Partial>,
}

impl<'a> PanesBefore<'a> {
    /// Those of `casters` on the way.
    pub(crate) fn new(tracer: &mut DiscTracer<'a>, way: &Way<'_>, casters: &CasterSet) -> Self {
        let reference = tracer.reference;
        let (mut whole, mut partly) = (DVec3::ONE, Vec::new());
        if let Some(Panes { triangles, colors, bvh, .. }) = &reference.panes {
            bvh.walk_cone(&way.cone(bvh), &mut tracer.stack, |leaf| {
                for place in leaf {
                    let (triangle, color) = (&triangles[place], &colors[place]);
                    if !triangle.casts || !casters.contains(triangle.instance) {
                        continue;
                    }
                    let class = reference.classify_triangle((place as u32, triangle), way, way.all_moves());
                    let partial = match (class, color.even) {
                        (Class::Misses, _) => continue,
                        (Class::Covers, Some(tint)) => {
                            whole *= tint;
                            continue;
                        }
                        (Class::Covers, None) => None,
                        (Class::Partly(partial), _) => Some(partial),
                    };
                    partly.push(PaneBefore { triangle, color, partial });
                }
                true
            });
        }
        Self { whole, partly, coordinate_m: reference.coordinate_m }
    }

    /// What passes to all samples, where that is the same.
    pub(crate) fn of_all(&self) -> Option<DVec3> {
        self.partly.is_empty().then_some(self.whole)
    }

    /// What passes to `sample`: the least that is right, what is exact, and the largest that is right.
    pub(crate) fn tints(&self, way: &Way<'_>, sample: DVec2) -> [DVec3; 3] {
        let [mut least, mut exact, mut largest] = [self.whole; 3];
        for pane in &self.partly {
            let decided = pane.partial.as_ref().map_or(Some(true), |partial| partial.decides(sample));
            if decided == Some(false) {
                continue;
            }
            let [low, tint, high] = pane.passing(way, sample);
            least *= low;
            if decided.unwrap_or_else(|| pane.is_crossed(way, sample, self.coordinate_m)) {
                exact *= tint;
            }
            if decided == Some(true) {
                largest *= high;
            }
        }
        if way.unsettled {
            return [DVec3::ZERO, exact, DVec3::ONE];
        }
        [least.min(exact), exact, largest.max(exact)]
    }
}

impl PaneBefore<'_> {
    /// What it lets pass where the way to `sample` crosses it: the least over all moves, without one, and the largest.
    fn passing(&self, way: &Way<'_>, sample: DVec2) -> [DVec3; 3] {
        if let Some(tint) = self.color.even {
            return [tint; 3];
        }
        let tint = |index: usize| {
            let (point, light) = (way.move_alone(index).point, way.sample(index, sample));
            let direction = light.truncate() - point * light.w;
            let crossing =
                self.triangle.plane_parameter(point, direction).map_or(point, |t| point + direction * t);
            self.color.passing(crossing)
        };
        let exact = tint(0);
        let moved = (1..MOVES).map(tint);
        let [least, largest] =
            moved.fold([exact; 2], |[least, largest], tint| [least.min(tint), largest.max(tint)]);
        [least, exact, largest]
    }

    /// Whether the way from the point to `sample` crosses it.
    fn is_crossed(&self, way: &Way<'_>, sample: DVec2, coordinate_m: f64) -> bool {
        let (triangle, point, light) = (self.triangle, way.move_alone(0).point, way.sample(0, sample));
        let facing = triangle.facing(light);
        facing != 0
            && is_crossed_once(&triangle.corners, point, light.truncate() - point * light.w)
            && triangle.side_of(point, coordinate_m) == -facing
            && !triangle.holds(way.moved.surface, coordinate_m)
    }
}
