//! Which triangles can block which light rays: lists of triangles, one for each cell of a grid the light looks through.
//!
//! A receiver looks up the cell its light ray meets, and asks the triangles listed there, those nearest to the light
//! first: from the first that is further from the light than the receiver, none can block it.
//!
//! *Nothing is lost.* [`LightGrid`] lists a triangle wherever it may be seen, by f64. The receiver's cell is found in
//! f32 by the shader, which bounds its own rounding and asks every cell within it, so no margin here depends on the
//! eye, and lists are kept until a caster or the light moves.

use glam::DVec3;
use shadowgraph_engine::geometry::LightGrid;

/// The most cells along a side: their rounding is below the grid's margin, in f32 too.
const FINEST: usize = 1024;
/// Cells and entries of lists may be as many as these, or as many for each triangle: below what every adapter can bind.
const LEAST_BUDGET: usize = 1 << 19;
const BUDGET_PER_TRIANGLE: usize = 16;
const LARGEST_BUDGET: usize = 1 << 23;

/// Lists over the planes of `grid` as the shader reads them: the number of cells along a side; for every cell, row by
/// row and plane by plane, where its list begins, and at last where the last one ends; the lists, with two words for
/// each triangle: its number and how far along the plane's direction its nearest point lies (an f32).
///
/// Cells are as small as the budget allows, for small cells have short lists.
pub fn light_grid_lists(grid: &LightGrid, triangles: &[[DVec3; 3]]) -> Vec<u32> {
    let grid = fitted(grid, triangles);
    let (side, planes) = (grid.cells_per_side(), grid.planes());
    let cells = planes.len() * side * side;
    // (cell, triangle, nearest) in the order of the lists.
    let mut found: Vec<(u32, u32, f32)> = Vec::new();
    for (number, plane) in planes.iter().enumerate() {
        let mut nearest: Vec<(f32, u32)> =
            (0..).zip(triangles).map(|(i, corners)| (plane.nearest(*corners) as f32, i)).collect();
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (nearest, triangle) in nearest {
            grid.for_each_cell(number, triangles[triangle as usize], |[x, y]| {
                found.push((((number * side + y) * side + x) as u32, triangle, nearest));
            });
        }
    }
    let first = cells + 2;
    let mut words = vec![0; first + 2 * found.len()];
    words[0] = side as u32;
    // First how long each list is, one place on; then where it begins; filling moves that to where it ends.
    for (cell, ..) in &found {
        words[*cell as usize + 2] += 2;
    }
    words[1] = first as u32;
    for cell in 0..cells {
        words[cell + 2] += words[cell + 1];
    }
    let mut next: Vec<u32> = words[1..=cells].to_vec();
    for (cell, triangle, nearest) in found {
        let place = &mut next[cell as usize];
        words[*place as usize] = triangle;
        words[*place as usize + 1] = nearest.to_bits();
        *place += 2;
    }
    words
}

/// `grid` with the smallest cells within the budget.
fn fitted(grid: &LightGrid, triangles: &[[DVec3; 3]]) -> LightGrid {
    let budget = (triangles.len() * BUDGET_PER_TRIANGLE).clamp(LEAST_BUDGET, LARGEST_BUDGET);
    let mut best = grid.clone();
    while best.cells_per_side() < FINEST {
        let finer = best.clone().with_cells_per_side(best.cells_per_side() * 2);
        let cells = finer.planes().len() * finer.cells_per_side() * finer.cells_per_side();
        let entries =
            |corners: &[DVec3; 3]| finer.cells_of(*corners).map(|(_, cells)| cells.count()).sum::<usize>();
        if cells.saturating_add(triangles.iter().map(entries).sum()) > budget {
            break;
        }
        best = finer;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec4;
    use shadowgraph_engine::math::Aabb;

    /// A number from 0 to 1 for each `i`.
    fn random(i: u32) -> f64 {
        f64::from(i.wrapping_mul(2_654_435_761) ^ (i << 7).wrapping_mul(40_503)) / f64::from(u32::MAX)
    }

    fn point(i: u32) -> DVec3 {
        DVec3::new(random(3 * i), random(3 * i + 1), random(3 * i + 2))
    }

    /// Every point of every triangle finds it in the list of the one cell its ray meets.
    #[test]
    fn no_ray_misses_a_triangle_it_meets() {
        let triangles: Vec<[DVec3; 3]> =
            (0..300).map(|i| [0, 1, 2].map(|k| point(10 * i) + 0.2 * point(10 * i + 1 + k))).collect();
        let bounds = Aabb::from_points(triangles.iter().flatten().copied());
        for light in
            [DVec4::new(0.3, 1.0, 0.2, 0.0), DVec4::new(1.0, 5.0, 2.0, 1.0), DVec4::new(0.5, 0.6, 0.5, 1.0)]
        {
            let grid = LightGrid::new(light, &bounds);
            let words = light_grid_lists(&grid, &triangles);
            let side = words[0] as usize;
            let mut asked = 0;
            assert!(side > 1);
            for (number, corners) in triangles.iter().enumerate() {
                for k in 0..20 {
                    let weights = point(number as u32 * 20 + k);
                    let weights = weights / weights.element_sum();
                    let p = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
                    let seen = grid.planes().iter().enumerate().find_map(|(i, plane)| {
                        let d = p - plane.origin;
                        let h = DVec3::new(
                            d.dot(plane.x_axis),
                            d.dot(plane.y_axis),
                            d.dot(plane.z_axis) + plane.z_offset,
                        );
                        let inside = h.z > 0.0 && h.truncate().abs().max_element() <= h.z * (1.0 + 1e-9);
                        inside.then_some((i, h.truncate() / h.z))
                    });
                    let (plane, ndc) = seen.expect("some plane shows it");
                    let cell =
                        ((ndc * 0.5 + 0.5) * side as f64).to_array().map(|x| (x as usize).min(side - 1));
                    let cell = (plane * side + cell[1]) * side + cell[0];
                    let list = &words[words[cell + 1] as usize..words[cell + 2] as usize];
                    let lists: Vec<(u32, f32)> =
                        list.chunks_exact(2).map(|entry| (entry[0], f32::from_bits(entry[1]))).collect();
                    assert!(lists.iter().any(|(triangle, _)| *triangle == number as u32), "{light}");
                    assert!(lists.is_sorted_by_key(|(_, nearest)| *nearest));
                    asked += lists.len();
                }
            }
            // Far fewer than all 300 for each of 6000 points.
            assert!(asked < 6000 * 100, "{light}: {asked}");
        }
    }

    #[test]
    fn nothing_and_nonsense_do_not_panic() {
        let light = DVec4::new(0.0, 1.0, 0.0, 0.0);
        let empty = light_grid_lists(&LightGrid::new(light, &Aabb::from_points([])), &[]);
        assert_eq!(empty.len(), empty[0] as usize * empty[0] as usize + 2);
        let nonsense = [[DVec3::NAN, DVec3::X, DVec3::Y], [DVec3::MAX, DVec3::MIN, DVec3::ZERO]];
        for light in [light, DVec4::W, DVec4::new(f64::NAN, 1e300, 0.0, 1.0)] {
            light_grid_lists(
                &LightGrid::new(light, &Aabb::from_points([DVec3::ZERO, DVec3::ONE])),
                &nonsense,
            );
        }
    }
}
