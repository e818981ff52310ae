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
//! *Never too low.* A [`LightGrid`] loses no triangle.

use glam::{DVec3, DVec4};

use super::{CellRange, LightGrid};
use crate::math::Aabb;

/// Counts triangles over the cells of one or six planes the light looks through.
#[derive(Clone, Debug)]
pub struct LayerGrid {
    grid: LightGrid,
    /// For each plane (cells_per_side + 1)² differences, row by row.
    differences: Vec<Vec<i32>>,
    triangles: u32,
}

impl LayerGrid {
    /// An empty grid for the homogeneous `light`, fitted to casters within `bounds` (in the world) and to about
    /// `triangle_count` triangles. With others the bound still holds, but is less tight.
    pub fn new(light: DVec4, bounds: &Aabb, triangle_count: usize) -> Self {
        Self::with_detail(light, bounds, triangle_count, 1)
    }

    /// As [`LayerGrid::new`], with `detail` times as many cells along a side: slower, and a tighter bound where many
    /// small triangles share a cell.
    pub fn with_detail(light: DVec4, bounds: &Aabb, triangle_count: usize, detail: usize) -> Self {
        let grid = LightGrid::new(light, bounds);
        let finest = if grid.planes().len() == 1 { 1024 } else { 512 } * detail;
        // About two cells to the side of an average triangle of a surface that fills the plane.
        let wanted = 2.0 * detail as f64 * (triangle_count as f64).sqrt();
        let cells_per_side = (wanted as usize).next_power_of_two().clamp(64, finest);
        let differences = vec![vec![0; (cells_per_side + 1) * (cells_per_side + 1)]; grid.planes().len()];
        Self { grid: grid.with_cells_per_side(cells_per_side), differences, triangles: 0 }
    }

    /// Counts one cast triangle, given by its corners in the world.
    pub fn add_triangle(&mut self, corners: [DVec3; 3]) {
        self.triangles = self.triangles.saturating_add(1);
        let Self { grid, differences, .. } = self;
        for (plane, cells) in grid.cells_of(corners) {
            count(&mut differences[plane], grid.cells_per_side(), cells);
        }
    }

    /// Counts those of a mesh's triangles that are `cast`, its vertices given in the world; each as [`LayerGrid::add_triangle`] does,
    /// but that vertices are projected once.
    ///
    /// # Panics
    /// When a triangle or corner is out of range.
    pub fn add_mesh(&mut self, p_in_world: &[DVec3], triangles: &[[u32; 3]], cast: &[u32]) {
        // With few of them it is faster to look at each by itself.
        let seen = if cast.len() > p_in_world.len() / 3 { self.grid.see(p_in_world) } else { vec![] };
        for triangle in cast {
            let corners = triangles[*triangle as usize].map(|corner| corner as usize);
            let between = match &seen[..] {
                [] => None,
                seen => self.grid.cells_between(corners.map(|corner| seen[corner])),
            };
            if let Some((plane, cells)) = between {
                self.triangles = self.triangles.saturating_add(1);
                count(&mut self.differences[plane], self.grid.cells_per_side(), cells);
            } else {
                self.add_triangle(corners.map(|corner| p_in_world[corner]));
            }
        }
    }

    /// An upper bound on the triangles added so far that any one light ray crosses. Costs a pass over the cells.
    pub fn max_layers(&self) -> u32 {
        let row_length = self.grid.cells_per_side() + 1;
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

/// Adds one to what is counted over `cells`, as four differences.
#[inline]
fn count(differences: &mut [i32], cells_per_side: usize, CellRange { low, high }: CellRange) {
    let row = cells_per_side + 1;
    differences[low[1] * row + low[0]] += 1;
    differences[low[1] * row + high[0] + 1] -= 1;
    differences[(high[1] + 1) * row + low[0]] -= 1;
    differences[(high[1] + 1) * row + high[0] + 1] += 1;
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
        let all: Vec<u32> = (0..positions.len() as u32 / 3).collect();
        let triangles: Vec<[u32; 3]> = all.iter().map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mut meshes = LayerGrid::new(light, &bounds, positions.len() / 3);
        meshes.add_mesh(positions, &triangles, &all);
        assert_eq!(meshes.differences, grid.differences, "vertices are seen where triangles are");
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
