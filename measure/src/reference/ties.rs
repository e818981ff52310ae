//! Surfaces that lie in one plane: which of them is seen is rounding; and whether a volume that hangs from the rim of one is before
//! them is rounding too, next to that rim.
//!
//! A rasteriser covers a pixel by corners it has snapped to [`super::PIXEL_MOVE`]. So a pixel's centre may lie on one side of an
//! edge and be covered by what is on the other side of it. Where a volume begins at that edge, the view enters it through
//! its cap on the one side and through its side on the other, which is all the same to what lies behind. But to what lies in the
//! cap's own plane it is not: no cap is before that, and a side that covers a pixel beyond its edge is, by as much as plane
//! and side part within the snap. No depth that was kept tells the two apart. So next to a [`Rim`] a factor is ambiguous.

use glam::{DVec3, DVec4};

use super::bvh::{Bvh, Open};
use super::glass::is_crossed_once;
use super::moved::{Moved, SIDEWAYS};
use super::surface::Triangle;
use super::tracer::{CasterSet, Tracer};
use super::view::View;

/// Where a caster's surface in the plane of what is seen ends, or begins, within the snap of a pixel's centre.
#[derive(Clone, Copy)]
pub(crate) struct Rim<'a> {
    /// The caster.
    instance: u32,
    seen: &'a Triangle,
    /// Where the surface that is seen ends and goes on in another plane: how.
    beyond: Option<&'a Triangle>,
}

impl Rim<'_> {
    /// Whether a volume begins there for `light`, if `casters` cast: at no edge between two triangles that it sees from one side.
    pub(crate) fn counts(&self, light: DVec4, casters: &CasterSet) -> bool {
        casters.contains(self.instance)
            && self.beyond.is_none_or(|beyond| beyond.facing(light) != self.seen.facing(light))
    }
}

/// What lies in the plane of a surface next to a pixel's centre.
#[derive(Default)]
pub(crate) struct InPlane<'a> {
    /// Other surfaces there of the same kind, opaque or transparent, that show: at the centre or where it moves to. (Of two
    /// halves of a square the one next to a pixel's centre may be drawn.)
    pub(crate) showing: Vec<&'a Triangle>,
    /// The rims of casters of both kinds.
    pub(crate) rims: Vec<Rim<'a>>,
    /// Whether the surface that is seen ends there, or goes on in another plane.
    pub(crate) at_edge: bool,
}

impl<'a> Tracer<'a> {
    /// What lies in the plane of what is seen at a place of the target.
    pub(crate) fn in_plane_of(&mut self, moved: &Moved<'a>, view: &View<'_>, place: [f64; 2]) -> InPlane<'a> {
        let reference = self.reference;
        let opaque = (&reference.bvh, &reference.triangles[..]);
        let panes = reference.panes.as_ref().map(|panes| (&panes.bvh, &panes.triangles[..]));
        let rays = rays(view, place, moved.longer);
        let mut found = InPlane::default();
        for (tree, is_pane) in [(Some(opaque), false), (panes, true)] {
            let Some(tree) = tree else { continue };
            let coplanar = self.coplanar(tree, moved, rays[0].1);
            if is_pane == moved.surface.lets_light_pass {
                let shows = |triangle: &Triangle| {
                    rays.iter().any(|(from, direction)| triangle.hit(*from, *direction).is_some())
                };
                let coordinate_m = reference.coordinate_m;
                found.showing.extend(coplanar.iter().filter(|triangle| {
                    !triangle.is(moved.surface)
                        && triangle.shares_plane(moved.surface, coordinate_m)
                        && shows(triangle)
                }));
            }
            found.at_edge |= self.add_rims((&coplanar, &rays), moved, (view, place), &mut found.rims);
        }
        found
    }

    /// All triangles of a tree that lie in the plane of what is seen, within the snap of the pixel's centre.
    fn coplanar(
        &mut self,
        (bvh, triangles): (&Bvh, &'a [Triangle]),
        moved: &Moved<'_>,
        direction: DVec3,
    ) -> Vec<&'a Triangle> {
        let coordinate_m = self.reference.coordinate_m;
        let stack: &mut Vec<Open> = &mut self.stack;
        let [center, sideways @ ..] = moved.points;
        let spread_m = sideways[..4].iter().map(|p| (*p - center).abs().max_element()).fold(0.0, f64::max);
        // On a surface seen edge-on, next to the centre is far away; there only what the centre itself shows counts.
        let spread_m = if bvh.takes_thickness(spread_m) { spread_m } else { 0.0 };
        let mut found = Vec::new();
        // No way at all, as thick as the moves are wide.
        let Some(around) = bvh.ray(center, direction, 0.0..0.0, spread_m) else { return found };
        bvh.walk(&around, stack, |leaf| {
            found.extend(triangles[leaf].iter().filter(|triangle| {
                triangle.side_of(center, coordinate_m) == 0 && triangle.holds(moved.surface, coordinate_m)
            }));
            None
        });
        found
    }

    /// Adds the rims of those of `coplanar` that cast; whether the surface that is seen ends.
    fn add_rims(
        &mut self,
        (coplanar, rays): (&[&'a Triangle], &[Ray; 5]),
        moved: &Moved<'a>,
        (view, place): (&View<'_>, [f64; 2]),
        rims: &mut Vec<Rim<'a>>,
    ) -> bool {
        let is_own = |triangle: &Triangle| triangle.instance == moved.surface.instance;
        let mut instances: Vec<u32> =
            coplanar.iter().filter(|t| t.casts || is_own(t)).map(|t| t.instance).collect();
        instances.sort_unstable();
        instances.dedup();
        let mut at_edge = false;
        for instance in instances {
            // A surface goes on beyond an edge that two of its triangles share: as many are there as here.
            let own = || coplanar.iter().filter(|triangle| triangle.instance == instance);
            let [here, there @ ..] = rays.map(|(from, direction)| {
                own().filter(|t| is_crossed_once(&t.corners, from, direction)).count()
            });
            for ([dx, dy], there) in SIDEWAYS.iter().zip(there) {
                if here == there {
                    continue;
                }
                let ends = there < here && instance == moved.surface.instance;
                at_edge |= ends;
                let beyond = ends.then(|| {
                    self.beyond(moved, view, [place[0] + dx * moved.longer, place[1] + dy * moved.longer])
                });
                rims.push(Rim { instance, seen: moved.surface, beyond: beyond.flatten() });
            }
        }
        at_edge
    }

    /// The triangle in which the surface that is seen goes on at `place`, in another plane.
    fn beyond(&mut self, moved: &Moved<'a>, view: &View<'_>, place: [f64; 2]) -> Option<&'a Triangle> {
        let reference = self.reference;
        let seen = moved.surface;
        let goes_on = |triangle: &&Triangle| {
            let shared = triangle.corners.iter().filter(|corner| seen.corners.contains(corner));
            triangle.instance == seen.instance && shared.count() >= 2
        };
        if !seen.lets_light_pass {
            return view.first_hit(self, place).and_then(|(hit, _)| reference.surface(hit)).filter(goes_on);
        }
        let (from, direction) = view.ray(place);
        let [near_m, far_m] = view.range_m();
        let layers = self.layers(from, direction, near_m, far_m).into_iter();
        layers.map(|(triangle, _)| triangle).find(goes_on)
    }
}

/// Where a ray begins, and its direction.
type Ray = (DVec3, DVec3);

/// The rays through a place of the target, and through where it moves to, which is so many times as far as corners are snapped.
fn rays(view: &View<'_>, [x, y]: [f64; 2], longer: f64) -> [Ray; 5] {
    let [left, right, up, down] = SIDEWAYS;
    [[0.0; 2], left, right, up, down].map(|[dx, dy]| view.ray([x + dx * longer, y + dy * longer]))
}
