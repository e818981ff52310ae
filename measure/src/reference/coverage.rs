//! What one convex caster leaves visible of a light's disc, in closed form.
//!
//! Seen from a point, a convex caster covers a convex polygon of the disc's plane; the area of a polygon within a circle is
//! a sum over its edges. No samples, no band: what an analytic technique is measured against where one caster stands
//! before the light.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, DVec4};
use shadowgraph_engine::shadow::LightSize;

/// The visible share of the light at `light`, (position, 1) or (direction towards it, 0), for `point`, when nothing but
/// the convex hull of `caster` (points of the world) stands between. With `receiver_normal`, which points to the side of the
/// eye, what is behind the receiver's plane is not visible either.
///
/// Where only the light's centre counts, the share is 0 or 1. A caster without volume is a polygon; one that the point
/// touches counts as if it were 1e-7 of the light's distance away.
pub fn convex_visible_share(
    caster: &[DVec3],
    point: DVec3,
    receiver_normal: Option<DVec3>,
    light: DVec4,
    size: LightSize,
) -> f64 {
    let to_center = light.truncate() - point * light.w;
    let distance = to_center.length();
    let disc = size.disc(to_center.extend(light.w));
    // Where only the centre counts, a disc too small to be cut stands for it.
    let radius = if disc.radius > 0.0 { disc.radius } else { distance * 1e-12 };
    let towards = to_center / distance;
    // Coordinates across the disc, in its radius, and along the way to it: 0 at the point, 1 at the disc.
    let placed: Vec<DVec3> = caster
        .iter()
        .map(|corner| {
            let way = *corner - point;
            DVec3::new(way.dot(disc.u) / radius, way.dot(disc.v) / radius, way.dot(towards) / distance)
        })
        .collect();
    let near = 1e-7;
    let far = if light.w == 0.0 { f64::INFINITY } else { 1.0 };
    let mut shadow: Vec<DVec2> = Vec::new();
    let mut project = |p: DVec3| shadow.push(p.truncate() / p.z);
    for (index, a) in placed.iter().enumerate() {
        if (near..=far).contains(&a.z) {
            project(*a);
        }
        // A convex hull meets a plane in the hull of what the ways between its corners meet it in.
        for b in &placed[index + 1..] {
            for depth in [near, far] {
                if (a.z - depth) * (b.z - depth) < 0.0 {
                    let met = a.lerp(*b, (depth - a.z) / (b.z - a.z));
                    project(DVec3::new(met.x, met.y, depth));
                }
            }
        }
    }
    let mut covered = hull(shadow);
    let mut visible = PI;
    if let Some(normal) = receiver_normal {
        let slope = DVec2::new(normal.dot(disc.u), normal.dot(disc.v)) * radius;
        let above = |sample: DVec2| normal.dot(to_center) + slope.dot(sample);
        covered = clipped(&covered, above);
        let reach = 4.0;
        let square = [(-reach, -reach), (reach, -reach), (reach, reach), (-reach, reach)].map(DVec2::from);
        visible = area_in_unit_disc(&clipped(&square, above));
    }
    let share = (visible - area_in_unit_disc(&covered)) / PI;
    // What is rounding is no penumbra.
    if share < 1e-12 {
        0.0
    } else if share > 1.0 - 1e-12 {
        1.0
    } else {
        share
    }
}

/// The corners of the convex hull, counter-clockwise (Andrew's monotone chain).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return Vec::new();
    }
    let chain = |points: &mut dyn Iterator<Item = &DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(*point - b) <= 0.0
            {
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    };
    let mut corners = chain(&mut points.iter());
    corners.extend(chain(&mut points.iter().rev()));
    corners
}

/// The part of a convex polygon where `height` is not negative.
fn clipped(polygon: &[DVec2], height: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::new();
    for (index, a) in polygon.iter().enumerate() {
        let b = polygon[(index + 1) % polygon.len()];
        let heights = [height(*a), height(b)];
        if heights[0] >= 0.0 {
            kept.push(*a);
        }
        if heights[0] * heights[1] < 0.0 {
            kept.push(a.lerp(b, heights[0] / (heights[0] - heights[1])));
        }
    }
    kept
}

/// The area that a polygon, its corners counter-clockwise, has in common with the unit disc.
fn area_in_unit_disc(polygon: &[DVec2]) -> f64 {
    let edges = (0..polygon.len()).map(|index| (polygon[index], polygon[(index + 1) % polygon.len()]));
    edges.map(|(a, b)| wedge_in_unit_disc(a, b)).sum::<f64>().max(0.0)
}

/// The signed area that the triangle of the centre, `a` and `b` has in common with the unit disc: a circle's sector
/// where the edge is outside, a triangle where it is inside.
fn wedge_in_unit_disc(a: DVec2, b: DVec2) -> f64 {
    let sector = |a: DVec2, b: DVec2| 0.5 * a.perp_dot(b).atan2(a.dot(b));
    let way = b - a;
    let (square, half) = (way.length_squared(), a.dot(way));
    let root = half * half - square * (a.length_squared() - 1.0);
    if square == 0.0 || root <= 0.0 {
        return sector(a, b);
    }
    let [enter, leave] = [-root.sqrt(), root.sqrt()].map(|root| ((root - half) / square).clamp(0.0, 1.0));
    if enter >= leave {
        return sector(a, b);
    }
    let [p, q] = [a + way * enter, a + way * leave];
    let before = if enter > 0.0 { sector(a, p) } else { 0.0 };
    let after = if leave < 1.0 { sector(q, b) } else { 0.0 };
    before + 0.5 * p.perp_dot(q) + after
}

#[cfg(test)]
mod tests {
    use shadowgraph_engine::shadow::disc_samples;

    use super::*;

    #[test]
    fn polygons_in_the_disc_have_the_area_of_geometry() {
        let square = |half: f64, at: DVec2| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|c| DVec2::from(c) * half + at)
        };
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} is not {b}");
        near(area_in_unit_disc(&square(0.5, DVec2::ZERO)), 1.0);
        near(area_in_unit_disc(&square(2.0, DVec2::ZERO)), PI);
        near(area_in_unit_disc(&square(2.0, DVec2::new(2.0, 0.0))), PI / 2.0);
        near(area_in_unit_disc(&square(2.0, DVec2::new(2.0, 2.0))), PI / 4.0);
        near(area_in_unit_disc(&square(1.0, DVec2::new(3.0, 0.0))), 0.0);
        // A segment beyond x = 1/2.
        let segment = PI / 3.0 - 0.5 * 0.75_f64.sqrt();
        near(area_in_unit_disc(&square(4.0, DVec2::new(4.5, 0.0))), segment);
    }

    fn cube(center: DVec3, half: DVec3) -> Vec<DVec3> {
        let corner = |bits: u32| {
            let sign = |bit: u32| if bits & bit == 0 { -1.0 } else { 1.0 };
            center + half * DVec3::new(sign(1), sign(2), sign(4))
        };
        (0..8).map(corner).collect()
    }

    /// Whether the way from `point` to `light` meets the box, by its slabs.
    fn is_hidden(center: DVec3, half: DVec3, point: DVec3, light: DVec4) -> bool {
        let way = light.truncate() - point * light.w;
        let (mut enter, mut leave) = (0.0_f64, if light.w == 0.0 { f64::INFINITY } else { 1.0 });
        for axis in 0..3 {
            let ends = [-1.0, 1.0].map(|side| (center[axis] + side * half[axis] - point[axis]) / way[axis]);
            enter = enter.max(ends[0].min(ends[1]));
            leave = leave.min(ends[0].max(ends[1]));
        }
        enter < leave
    }

    #[test]
    fn a_box_hides_what_samples_say_it_hides() {
        let samples = [disc_samples(4096, 1), disc_samples(65_536, 1)];
        let half = DVec3::new(0.5, 0.2, 0.4);
        let (mut worst, mut squares, mut count) = ([0.0_f64; 2], [0.0; 2], 0);
        let sizes = [0.05, 0.3, 1.0].map(|radius_m| LightSize { radius_m, half_angle_rad: 0.4 * radius_m });
        for size in sizes {
            for light in [DVec4::new(-0.7, 3.0, 0.4, 1.0), DVec4::new(-0.6, 2.0, 0.3, 0.0)] {
                for height in [0.21, 0.8, 1.6] {
                    let center = DVec3::new(0.0, height, 0.0);
                    let caster = cube(center, half);
                    for step in 0..40 {
                        let point = DVec3::new(-0.9 + 0.061 * f64::from(step), 0.0, 0.13);
                        let share = convex_visible_share(&caster, point, Some(DVec3::Y), light, size);
                        let disc = size.disc((light.truncate() - point * light.w).extend(light.w));
                        for (of, samples) in samples.iter().enumerate() {
                            let lit = samples.iter().filter(|sample| {
                                let offset = (disc.u * sample.x + disc.v * sample.y) * disc.radius;
                                let position = light + offset.extend(0.0);
                                let above = position.truncate() - point * light.w;
                                above.y > 0.0 && !is_hidden(center, half, point, position)
                            });
                            let difference = (lit.count() as f64 / samples.len() as f64 - share).abs();
                            worst[of] = worst[of].max(difference);
                            squares[of] += difference * difference;
                        }
                        count += usize::from(share > 0.0 && share < 1.0);
                    }
                }
            }
        }
        let rmse = squares.map(|sum| (sum / count as f64).sqrt());
        assert!(count > 200, "{count} points in penumbrae");
        assert!(worst[0] < 0.006 && rmse[0] < 0.0012, "4096 samples: {worst:?}, rmse {rmse:?}");
        assert!(worst[1] < 0.0012 && rmse[1] < 0.0002, "65536 samples: {worst:?}, rmse {rmse:?}");
    }

    #[test]
    fn without_size_it_is_the_hard_shadow() {
        let caster = cube(DVec3::new(0.0, 1.0, 0.0), DVec3::splat(0.25));
        let light = DVec4::new(0.0, 3.0, 0.0, 1.0);
        let share =
            |x: f64| convex_visible_share(&caster, DVec3::new(x, 0.0, 0.0), None, light, LightSize::NONE);
        assert_eq!((share(0.0), share(0.3), share(0.5)), (0.0, 0.0, 1.0));
        // Beyond the light, and behind the point, nothing hides.
        let above = DVec4::new(0.0, 0.5, 0.0, 1.0);
        let size = LightSize { radius_m: 0.1, half_angle_rad: 0.0 };
        assert_eq!(convex_visible_share(&caster, DVec3::ZERO, None, above, size), 1.0);
        assert_eq!(convex_visible_share(&caster, DVec3::Y * 2.0, None, light, size), 1.0);
    }
}
