//! How many layers of a caster can one light ray meet? An upper bound, in one pass over the triangles.
//!
//! The count a shadow volume leaves at a point is the number of cast triangles between the point and the light. An
//! 8-bit stencil wraps, and is wrong exactly where the true count is a multiple of 256 other than 0. So a bound of at
//! most 255 certifies the counter, and a caster beyond it is cast in groups, each certified ([`layer_groups`](super::layer_groups)).
//!
//! The bound is taken in a grid the light looks through: one plane for a directional light, and for a point light one
//! plane fitted around the casters or, when the light stands among them, the six faces of a cube. Each triangle
//! covers the bounding rectangle of its projection, which costs four entries in a table of differences; sums over
//! the table give the triangles over each cell, and the largest is the bound, for a ray meets one cell only.
//!
//! *Never too low.* Rectangles are enlarged by a thousandth of a cell on every side, 2·10⁻⁶ of the plane or more,
//! where the rounding of a projection is below 10⁻⁹. A triangle too near the plane through the light to be projected covers the
//! whole face. Outside the planned bounds coordinates are clamped, triangles and rays alike.

use glam::{DVec2, DVec3, DVec4};

use crate::math::Aabb;

/// By how much of a cell the rectangles are enlarged.
const CELL_MARGIN: f64 = 1e-3;

/// Counts triangles over the cells of one or six planes the light looks through.
#[derive(Clone, Debug)]
pub struct LayerGrid {
    planes: Vec<LightPlane>,
    /// Cells along a side of each plane.
    cells_per_side: usize,
    /// For each plane (cells_per_side + 1)² differences, row by row.
    differences: Vec<Vec<i32>>,
    triangles: u32,
}

impl LayerGrid {
    /// An empty grid for the homogeneous `light`, fitted to casters within `bounds` (in the world) and to about
    /// `triangle_count` of them. Neither has to hold: the bound stays one, and gets less tight.
    pub fn new(light: DVec4, bounds: &Aabb, triangle_count: usize) -> Self {
        Self::with_detail(light, bounds, triangle_count, 1)
    }

    /// As [`LayerGrid::new`], with `detail` times as many cells along a side: slower, and a tighter bound where many
    /// small triangles share a cell.
    pub fn with_detail(light: DVec4, bounds: &Aabb, triangle_count: usize, detail: usize) -> Self {
        let planes = light_planes(light, bounds);
        let finest = if planes.len() == 1 { 1024 } else { 512 } * detail;
        // About two cells to the side of an average triangle of a surface that fills the plane.
        let wanted = 2.0 * detail as f64 * (triangle_count as f64).sqrt();
        let cells_per_side = (wanted as usize).next_power_of_two().clamp(64, finest);
        let differences = vec![vec![0; (cells_per_side + 1) * (cells_per_side + 1)]; planes.len()];
        Self { planes, cells_per_side, differences, triangles: 0 }
    }

    /// Counts one cast triangle, given by its corners in the world.
    pub fn add_triangle(&mut self, corners: [DVec3; 3]) {
        self.triangles = self.triangles.saturating_add(1);
        for (plane, differences) in self.planes.iter().zip(&mut self.differences) {
            let last = self.cells_per_side - 1;
            let (low, high) = match plane.project(corners) {
                Footprint::Nothing => continue,
                Footprint::Everything => ([0, 0], [last, last]),
                Footprint::Rectangle(low, high) => {
                    // `as` saturates, so that far-away coordinates clamp instead of wrapping.
                    let cell = |ndc: f64, margin: f64| {
                        let place = (ndc * 0.5 + 0.5) * self.cells_per_side as f64 + margin;
                        (place.floor().max(0.0) as usize).min(last)
                    };
                    (
                        [cell(low.x, -CELL_MARGIN), cell(low.y, -CELL_MARGIN)],
                        [cell(high.x, CELL_MARGIN), cell(high.y, CELL_MARGIN)],
                    )
                }
            };
            let row = self.cells_per_side + 1;
            differences[low[1] * row + low[0]] += 1;
            differences[low[1] * row + high[0] + 1] -= 1;
            differences[(high[1] + 1) * row + low[0]] -= 1;
            differences[(high[1] + 1) * row + high[0] + 1] += 1;
        }
    }

    /// An upper bound on the triangles added so far that any one light ray crosses. Costs a pass over the cells.
    pub fn max_layers(&self) -> u32 {
        let row_length = self.cells_per_side + 1;
        let mut most = 0;
        for differences in &self.differences {
            let mut column_sums = vec![0; row_length];
            for row in differences.chunks_exact(row_length) {
                let mut layers = 0;
                for (column_sum, difference) in column_sums.iter_mut().zip(row) {
                    *column_sum += difference;
                    layers += *column_sum;
                    most = most.max(layers);
                }
            }
        }
        self.triangles.min(most.unsigned_abs())
    }
}

/// The part of a plane a triangle covers, in coordinates from −1 to 1.
enum Footprint {
    Nothing,
    Everything,
    Rectangle(DVec2, DVec2),
}

/// A plane the light looks through: a point goes to (x, y) = (d·x_axis, d·y_axis) / (d·z_axis + z_offset),
/// d = point − origin, and the part in view is |x|, |y| ≤ 1.
#[derive(Clone, Debug)]
struct LightPlane {
    origin: DVec3,
    x_axis: DVec3,
    y_axis: DVec3,
    z_axis: DVec3,
    /// 0 when looking from a point at `origin`, 1 when looking along a direction (`z_axis` is then 0).
    z_offset: f64,
    /// Whether other planes look where this one does not.
    one_of_six: bool,
}

impl LightPlane {
    fn project(&self, corners: [DVec3; 3]) -> Footprint {
        let to_corners = corners.map(|corner| corner - self.origin);
        let homogeneous = to_corners
            .map(|d| DVec3::new(d.dot(self.x_axis), d.dot(self.y_axis), d.dot(self.z_axis) + self.z_offset));
        let reach = to_corners.iter().map(|d| d.abs().max_element()).fold(0.0, f64::max);
        let all = |is_outside: &dyn Fn(&DVec3) -> bool| homogeneous.iter().all(is_outside);
        if self.one_of_six {
            // Wholly behind the light, or wholly beyond one side of the face's pyramid |x|, |y| ≤ z.
            let margin = 1e-9 * reach;
            let is_outside = all(&|h| h.z < -margin)
                || all(&|h| h.x - h.z > margin)
                || all(&|h| -h.x - h.z > margin)
                || all(&|h| h.y - h.z > margin)
                || all(&|h| -h.y - h.z > margin);
            if is_outside {
                return Footprint::Nothing;
            }
        }
        let nearest = if self.z_offset == 0.0 { 1e-6 * reach } else { 0.0 };
        if !all(&|h| h.z > nearest) {
            return Footprint::Everything;
        }
        let [a, b, c] = homogeneous.map(|h| h.truncate() / h.z);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        if !(low.is_finite() && high.is_finite()) {
            return Footprint::Everything;
        }
        Footprint::Rectangle(low, high)
    }
}

/// One plane where one can see all of `bounds` within 45 degrees of its axis, else the six faces of a cube.
fn light_planes(light: DVec4, bounds: &Aabb) -> Vec<LightPlane> {
    /// The narrowest view, in the sine of its half angle or in radii: what lies within it is not told apart.
    const NARROWEST: f64 = 1e-6;
    let (center, radius_m) = (bounds.center(), bounds.radius());
    if light.w == 0.0 {
        let towards = light.truncate().try_normalize().unwrap_or(DVec3::Y);
        let (x, y) = towards.any_orthonormal_pair();
        let half_extent = |axis: DVec3| {
            let half_m =
                if bounds.is_empty() { 0.0 } else { (bounds.max - bounds.min).dot(axis.abs()) * 0.5 };
            half_m.max(radius_m * NARROWEST).max(f64::MIN_POSITIVE.sqrt())
        };
        return vec![LightPlane {
            origin: center,
            x_axis: x / half_extent(x),
            y_axis: y / half_extent(y),
            z_axis: DVec3::ZERO,
            z_offset: 1.0,
            one_of_six: false,
        }];
    }
    let origin = light.truncate();
    let looking = |x_axis, y_axis, z_axis, one_of_six| LightPlane {
        origin,
        x_axis,
        y_axis,
        z_axis,
        z_offset: 0.0,
        one_of_six,
    };
    let distance_m = center.distance(origin);
    let sine = (radius_m / distance_m).max(NARROWEST);
    if sine < std::f64::consts::FRAC_1_SQRT_2 && !bounds.is_empty() {
        let z_axis = (center - origin) / distance_m;
        let (x, y) = z_axis.any_orthonormal_pair();
        let tangent = sine / (1.0 - sine * sine).sqrt();
        return vec![looking(x / tangent, y / tangent, z_axis, false)];
    }
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let face = |i: usize, sign: f64| looking(axes[(i + 1) % 3], axes[(i + 2) % 3], axes[i] * sign, true);
    (0..3).flat_map(|i| [face(i, 1.0), face(i, -1.0)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `count` unit triangles one above the other.
    fn stack(count: u32) -> Vec<DVec3> {
        (0..count)
            .flat_map(|i| [DVec3::ZERO, DVec3::X, DVec3::Z].map(|p| p + DVec3::Y * f64::from(i)))
            .collect()
    }

    fn bound(light: DVec4, positions: &[DVec3]) -> u32 {
        let bounds = Aabb::from_points(positions.iter().copied());
        let mut grid = LayerGrid::new(light, &bounds, positions.len() / 3);
        for corners in positions.chunks_exact(3) {
            grid.add_triangle([corners[0], corners[1], corners[2]]);
        }
        grid.max_layers()
    }

    #[test]
    fn a_stack_is_counted_from_above_and_not_from_the_side() {
        let stack = stack(300);
        assert_eq!(bound(DVec4::new(0.0, 1.0, 0.0, 0.0), &stack), 300);
        assert_eq!(bound(DVec4::new(0.2, 1e6, 0.2, 1.0), &stack), 300);
        assert_eq!(bound(DVec4::new(0.2, -0.1, 0.2, 1.0), &stack), 300);
        assert!(bound(DVec4::new(1.0, 1.0, 0.0, 0.0), &stack) < 20);
        assert!(bound(DVec4::new(300.0, 150.5, 0.0, 1.0), &stack) < 20);
    }

    /// Splinters from all sides whose tips overlap by a hair: no cell but the tips' own sees them all.
    #[test]
    fn tips_that_meet_in_a_hair_are_all_counted() {
        for shift in 0..50 {
            let middle = DVec3::new(f64::from(shift) * 1e-3, 0.0, f64::from(shift) * 0.7e-3);
            // One triangle that stays, so that the tips wander through their cell.
            let bystander = [DVec3::new(1.9, 0.0, 1.9), DVec3::new(2.0, 0.0, 1.9), DVec3::new(1.9, 0.0, 2.0)];
            let splinters: Vec<DVec3> = (0..64)
                .flat_map(|i| {
                    let outwards = DVec3::new((f64::from(i) * 0.1).cos(), 0.0, (f64::from(i) * 0.1).sin());
                    let aside = outwards.cross(DVec3::Y) * 1e-3;
                    let tip = middle - outwards * 1e-9;
                    [tip, middle + outwards + aside, middle + outwards - aside]
                })
                .chain(bystander)
                .collect();
            for light in [DVec4::Y, DVec4::new(0.1, 3.0, 0.2, 1.0), DVec4::new(0.1, 0.5, 0.2, 1.0)] {
                assert_eq!(bound(light, &splinters), 64);
            }
        }
    }

    #[test]
    fn nothing_and_nonsense_do_not_panic() {
        assert_eq!(bound(DVec4::new(0.0, 1.0, 0.0, 0.0), &[]), 0);
        let point = [DVec3::ONE; 3];
        for light in [DVec4::ZERO, DVec4::W, DVec4::ONE, DVec4::new(0.0, f64::NAN, 1e300, 1.0)] {
            assert_eq!(bound(light, &point), 1);
        }
        assert_eq!(bound(DVec4::W, &[DVec3::NAN, DVec3::X, DVec3::Y]), 1);
    }
}
