//! How many transparent surfaces lie one behind the other at a pixel? An upper bound for the whole view, found on the CPU:
//! so many layers a frame draws.
//!
//! Every triangle marks, row by row, the pixels whose centre it may cover, as a difference to the pixel before; sums along
//! the rows then count the triangles of each pixel. A rasteriser that snaps vertices to 1/256 pixel covers no pixel that
//! is not marked here ([`SNAP_PX`]). The count is exact but for pixels whose centre is that near an edge, for what
//! opaque surfaces hide, and for places without surface (alpha 0), which are counted.

use glam::{DMat4, DVec4};

use crate::scene::{Instance, SceneSnapshot};
use crate::shadow::View;

/// How far beyond its edges a triangle may cover a pixel's centre: its corners snap to 1/256 pixel, and more is lost in
/// f32.
const SNAP_PX: f64 = 1.0 / 64.0;

/// The most transparent surfaces that lie one behind the other at any pixel; never less than there are.
pub(super) fn most_layers(snapshot: &SceneSnapshot, view: &View, parts: &[(u32, u32)]) -> u32 {
    let [width, height] = view.size_px.map(|n| n as usize);
    let mut rows = Rows { width, height, differences: vec![0; (width + 1) * height] };
    let clip_from_world = view.camera.clip_from_world(view.size_px);
    for (instance, part) in parts {
        let instance = &snapshot.instances[*instance as usize];
        rows.add_part(instance, *part as usize, &clip_from_world);
    }
    rows.most()
}

/// For each row of pixels the differences of counts from pixel to pixel, and one beyond.
struct Rows {
    width: usize,
    height: usize,
    differences: Vec<i32>,
}

impl Rows {
    fn add_part(&mut self, instance: &Instance, part: usize, clip_from_world: &DMat4) {
        let clip_from_local = *clip_from_world * DMat4::from(instance.world_from_local);
        let clip: Vec<DVec4> =
            instance.mesh.positions().iter().map(|p| clip_from_local * p.as_dvec3().extend(1.0)).collect();
        // Which way a triangle's corners run on the screen, where the side that is drawn is seen.
        let mirrored = instance.world_from_local.matrix3.determinant() < 0.0;
        let drawn_side = match (instance.materials[part].double_sided, mirrored) {
            (true, _) => None,
            (false, mirrored) => Some(if mirrored { -1.0 } else { 1.0 }),
        };
        for triangle in instance.mesh.data().parts[part].triangles.clone() {
            let corners = instance.mesh.triangle(triangle as usize).map(|vertex| clip[vertex as usize]);
            self.add_triangle(corners, drawn_side);
        }
    }

    fn add_triangle(&mut self, corners: [DVec4; 3], drawn_side: Option<f64>) {
        let (polygon, count) = before_near(corners);
        let to_px = |c: DVec4| {
            let ndc = c.truncate() / c.w;
            [(ndc.x + 1.0) * 0.5 * self.width as f64, (1.0 - ndc.y) * 0.5 * self.height as f64]
        };
        let mut corners_px = [[0.0; 2]; 4];
        for (px, corner) in corners_px.iter_mut().zip(&polygon[..count]) {
            *px = to_px(*corner);
        }
        let corners_px = &corners_px[..count];
        // NaN and what is infinite covers everything, to be safe.
        if corners_px.iter().flatten().any(|c| !c.is_finite()) {
            return self.add_rows(0, self.height, |_| Some([f64::NEG_INFINITY, f64::INFINITY]));
        }
        if let Some(side) = drawn_side {
            let edges = corners_px.iter().zip(corners_px.iter().cycle().skip(1));
            let (mut doubled_area, mut around) = (0.0, 0.0);
            for ([x0, y0], [x1, y1]) in edges {
                doubled_area -= x0 * y1 - x1 * y0;
                around += (x1 - x0).abs() + (y1 - y0).abs();
            }
            // Turned away by more than snapping can turn it back.
            if doubled_area * side < -SNAP_PX * (around + SNAP_PX) {
                return;
            }
        }
        let top = corners_px.iter().map(|c| c[1]).fold(f64::INFINITY, f64::min);
        let bottom = corners_px.iter().map(|c| c[1]).fold(f64::NEG_INFINITY, f64::max);
        let first = (top - SNAP_PX - 0.5).ceil().max(0.0) as usize;
        let end = ((bottom + SNAP_PX - 0.5).floor() + 1.0).clamp(0.0, self.height as f64) as usize;
        self.add_rows(first, end, |y| span(corners_px, y));
    }

    /// Counts one more in each row from `first` to before `end`, from `span` of its middle.
    fn add_rows(&mut self, first: usize, end: usize, span: impl Fn(f64) -> Option<[f64; 2]>) {
        for row in first..end.min(self.height) {
            let Some([left, right]) = span(row as f64 + 0.5) else { continue };
            let start = (left - SNAP_PX - 0.5).ceil().clamp(0.0, self.width as f64) as usize;
            let stop = ((right + SNAP_PX - 0.5).floor() + 1.0).clamp(0.0, self.width as f64) as usize;
            if start < stop {
                let line = &mut self.differences[row * (self.width + 1)..(row + 1) * (self.width + 1)];
                line[start] += 1;
                line[stop] -= 1;
            }
        }
    }

    fn most(&self) -> u32 {
        let mut most = 0;
        for row in self.differences.chunks_exact(self.width + 1) {
            let mut count = 0;
            for difference in row {
                count += difference;
                most = most.max(count);
            }
        }
        most.unsigned_abs()
    }
}

/// What of a convex polygon lies within a snap of row middle `y`: its left and right ends.
fn span(corners_px: &[[f64; 2]], y: f64) -> Option<[f64; 2]> {
    let (low, high) = (y - SNAP_PX, y + SNAP_PX);
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for ([x0, y0], [x1, y1]) in corners_px.iter().zip(corners_px.iter().cycle().skip(1)) {
        if y0.max(*y1) < low || y0.min(*y1) > high {
            continue;
        }
        let at = |y: f64| {
            let share = if y1 == y0 { 0.0 } else { ((y - y0) / (y1 - y0)).clamp(0.0, 1.0) };
            x0 + (x1 - x0) * share
        };
        let ends = if y1 == y0 { [*x0, *x1] } else { [at(low), at(high)] };
        left = left.min(ends[0]).min(ends[1]);
        right = right.max(ends[0]).max(ends[1]);
    }
    (left <= right).then_some([left, right])
}

/// The part of a triangle before the near plane (z ≤ w in clip space), at most four corners.
fn before_near(corners: [DVec4; 3]) -> ([DVec4; 4], usize) {
    let mut polygon = [DVec4::ZERO; 4];
    let mut count = 0;
    let mut push = |corner| {
        if count < 4 {
            polygon[count] = corner;
            count += 1;
        }
    };
    for i in 0..3 {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        let (da, db) = (a.w - a.z, b.w - b.z);
        if da >= 0.0 {
            push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            push(a + (b - a) * (da / (da - db)));
        }
    }
    (polygon, count)
}
