//! Surfaces that lie in one plane: which of them is seen is rounding.

use super::bvh::{Bvh, Open};
use super::moved::{Moved, SIDEWAYS};
use super::reference::Tracer;
use super::surface::Triangle;
use super::view::View;

impl<'a> Tracer<'a> {
    /// The other opaque surfaces that lie in the plane of what is seen at a place of the target, and show there: at its
    /// centre or where that moves to. (Of two halves of a square the one next to a pixel's centre may be drawn.)
    pub(super) fn in_plane_of(
        &mut self,
        moved: &Moved<'_>,
        view: &View<'_>,
        place: [f64; 2],
    ) -> Vec<&'a Triangle> {
        let Self { reference, stack, .. } = self;
        let among = (&reference.bvh, &reference.triangles[..], reference.coordinate_m);
        in_plane_of(among, stack, moved, view, place)
    }

    /// The same of transparent surfaces.
    pub(super) fn panes_in_plane_of(
        &mut self,
        moved: &Moved<'_>,
        view: &View<'_>,
        place: [f64; 2],
    ) -> Vec<&'a Triangle> {
        let Self { reference, stack, .. } = self;
        let Some(panes) = &reference.panes else { return Vec::new() };
        in_plane_of((&panes.bvh, &panes.triangles, reference.coordinate_m), stack, moved, view, place)
    }
}

fn in_plane_of<'a>(
    (bvh, triangles, coordinate_m): (&Bvh, &'a [Triangle], f64),
    stack: &mut Vec<Open>,
    moved: &Moved<'_>,
    view: &View<'_>,
    place: [f64; 2],
) -> Vec<&'a Triangle> {
    let [center, sideways @ ..] = moved.points;
    let spread_m = sideways[..4].iter().map(|p| (*p - center).abs().max_element()).fold(0.0, f64::max);
    // On a surface seen edge-on, next to the centre is far away; there only what the centre itself shows counts.
    let spread_m = if bvh.takes_thickness(spread_m) { spread_m } else { 0.0 };
    let (_, direction) = view.ray(place);
    // No way at all, as thick as the moves are wide.
    let Some(around) = bvh.ray(center, direction, 0.0..0.0, spread_m) else { return Vec::new() };
    let shows = |triangle: &Triangle| {
        [[0.0; 2]].iter().chain(&SIDEWAYS).any(|[dx, dy]| {
            let (from, direction) = view.ray([place[0] + dx, place[1] + dy]);
            triangle.hit(from, direction).is_some()
        })
    };
    let mut found = Vec::new();
    bvh.walk(&around, stack, |leaf| {
        found.extend(triangles[leaf].iter().filter(|triangle| {
            triangle.side_of(center, coordinate_m) == 0
                && !triangle.is(moved.surface)
                && triangle.shares_plane(moved.surface, coordinate_m)
                && shows(triangle)
        }));
        None
    });
    found
}
