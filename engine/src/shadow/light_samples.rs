//! THE points of a light's disc that stand for it: techniques that sample a light and the reference take the same.
//!
//! A shadow's edge crosses the disc as a straight line or nearly so, so what counts is how evenly the points lie *across
//! every line*: seen along any direction, as far apart as the disc's area asks for. That is what sliced optimal transport
//! makes of points (Paulin and others, "Sliced Optimal Transport Sampling", 2020): it looks at them along many directions
//! and moves each towards where the point of its rank should be. It starts from a sunflower, whose golden angles no
//! line meets twice.
//!
//! Share of points against share of area, over half-planes in all directions: the largest and the RMS deviation. Beside
//! it one random point in each cell of a grid ([`super::disc_samples`]), and the sunflower as it is:
//!
//! | points | these | sunflower | one a cell |
//! |---|---|---|---|
//! | 16 | 0.132, 0.0330 | 0.143, 0.0371 | 0.174, 0.0467 |
//! | 64 | 0.049, 0.0115 | 0.052, 0.0125 | 0.071, 0.0180 |
//! | 256 | 0.019, 0.0040 | 0.022, 0.0042 | 0.030, 0.0060 |
//!
//! Their mean is the centre to a thousandth. For wedges between two such lines the RMS is the same. Regular
//! grids mapped to the disc have as good an RMS, but an edge along their rows meets √n points at once.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::{Mutex, PoisonError};

use glam::DVec2;

/// The most points that [`light_samples`] gives.
pub const MAX_LIGHT_SAMPLES: u32 = 1024;

/// Rounds of moving, and directions looked along in each; more of either no longer shows.
const ROUNDS: u32 = 20;
const DIRECTIONS: u32 = 16;

/// `count` points of the unit disc, 1 to [`MAX_LIGHT_SAMPLES`] (nearest of these otherwise), spread evenly across every line.
/// Equal counts give equal points; a single one is the centre. Computed once for each count, in some milliseconds at most
/// but for several hundred points.
pub fn light_samples(count: u32) -> Vec<DVec2> {
    static KNOWN: Mutex<BTreeMap<u32, Vec<DVec2>>> = Mutex::new(BTreeMap::new());
    let count = count.clamp(1, MAX_LIGHT_SAMPLES);
    let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(points) = known().get(&count) {
        return points.clone();
    }
    let points = spread(count);
    known().insert(count, points.clone());
    points
}

/// The share of the golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

fn spread(count: u32) -> Vec<DVec2> {
    if count == 1 {
        return vec![DVec2::ZERO];
    }
    let of_count = |index: u32| (f64::from(index) + 0.5) / f64::from(count);
    let sunflower = |index: u32| DVec2::from_angle(f64::from(index) * GOLDEN * TAU) * of_count(index).sqrt();
    let mut points: Vec<DVec2> = (0..count).map(sunflower).collect();
    let ideal: Vec<f64> = (0..count).map(|index| quantile(of_count(index))).collect();
    let mut order: Vec<usize> = (0..points.len()).collect();
    let mut along = vec![0.0; points.len()];
    for round in 0..ROUNDS {
        let mut moves = vec![DVec2::ZERO; points.len()];
        for number in 0..DIRECTIONS {
            let turn = f64::from(round * DIRECTIONS + number) * GOLDEN % 1.0;
            let direction = DVec2::from_angle(turn * PI);
            for (along, point) in along.iter_mut().zip(&points) {
                *along = point.dot(direction);
            }
            order.sort_by(|a, b| along[*a].total_cmp(&along[*b]));
            for (ideal, index) in ideal.iter().zip(&order) {
                moves[*index] += direction * (ideal - along[*index]);
            }
        }
        // Of a point's whole way every direction sees, on average, half.
        let share = 2.0 / f64::from(DIRECTIONS);
        for (point, way) in points.iter_mut().zip(moves) {
            *point = (*point + way * share).clamp_length_max(1.0);
        }
    }
    points
}

/// Where a line across the unit disc has `share` of its area on one side: the signed distance from the centre.
fn quantile(share: f64) -> f64 {
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..52 {
        let middle = 0.5 * (low + high);
        if share_below(middle) < share {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The share of the unit disc's area below x = `t`.
fn share_below(t: f64) -> f64 {
    0.5 + (t * (1.0 - t * t).max(0.0).sqrt() + t.asin()) / PI
}

#[cfg(test)]
mod tests {
    use super::super::disc_samples;
    use super::*;

    /// The largest and the RMS difference between the share of points and of area beyond a line, over all lines of
    /// 720 directions; and the most points within a strip as wide as 1/count of the radius.
    fn deviation(points: &[DVec2]) -> (f64, f64, usize) {
        let count = points.len() as f64;
        let (mut max, mut squares, mut most) = (0.0_f64, 0.0, 0);
        for turn in 0..720 {
            let direction = DVec2::from_angle(f64::from(turn) / 720.0 * PI);
            let mut along: Vec<f64> = points.iter().map(|point| point.dot(direction)).collect();
            along.sort_by(f64::total_cmp);
            for (rank, t) in along.iter().enumerate() {
                let below = share_below(*t);
                max = max.max((below - rank as f64 / count).abs());
                max = max.max((below - (rank + 1) as f64 / count).abs());
                most = most.max(along.partition_point(|other| *other <= t + 1.0 / count) - rank);
            }
            for step in 0..200 {
                let t = (f64::from(step) + 0.5) / 100.0 - 1.0;
                let share = along.partition_point(|other| *other < t) as f64 / count;
                squares += (share - share_below(t)).powi(2) / 200.0 / 720.0;
            }
        }
        (max, squares.sqrt(), most)
    }

    #[test]
    fn points_lie_evenly_across_every_line() {
        for (count, largest, rms, most) in
            [(16, 0.134, 0.034, 4), (64, 0.05, 0.0118, 6), (256, 0.021, 0.0042, 8)]
        {
            let found = deviation(&light_samples(count));
            assert!(found.0 < largest && found.1 < rms && found.2 <= most, "{count}: {found:?}");
            let cells = deviation(&disc_samples(count, 0));
            assert!(found.0 < cells.0 * 0.8 && found.1 < cells.1 * 0.75, "{count}: {found:?}, {cells:?}");
        }
    }

    #[test]
    fn every_count_is_in_the_disc_about_its_centre_and_given_again() {
        assert_eq!(light_samples(1), [DVec2::ZERO]);
        assert_eq!(light_samples(0), light_samples(1));
        for count in [2, 3, 4, 7, 16, 17, 61, 64, 100, 256, 1000, 1024] {
            let points = light_samples(count);
            assert_eq!(points.len(), count as usize);
            assert!(points.iter().all(|point| point.length() <= 1.0), "{count}");
            assert_eq!(points, light_samples(count));
            let mean = points.iter().sum::<DVec2>() / f64::from(count);
            assert!(mean.length() < 1e-3, "{count}: {mean}");
            let unique =
                |a: usize| points[..a].iter().all(|b| points[a].distance(*b) > 0.3 / f64::from(count).sqrt());
            assert!((0..points.len()).all(unique), "{count}: two points in one place");
        }
    }
}
