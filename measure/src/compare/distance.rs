//! How far every pixel is from the nearest of some marked ones.

/// For every pixel the Euclidean distance to the nearest marked one, in pixels: the exact transform by lower envelopes
/// of parabolas, along columns and then along rows (Felzenszwalb and Huttenlocher).
pub(super) fn distances(marked: &[bool], width: usize) -> Vec<f64> {
    let height = marked.len() / width;
    let mut squared: Vec<f64> = marked.iter().map(|m| if *m { 0.0 } else { f64::INFINITY }).collect();
    for x in 0..width {
        let column: Vec<f64> = (0..height).map(|y| squared[y * width + x]).collect();
        for (y, value) in lower_envelope(&column).into_iter().enumerate() {
            squared[y * width + x] = value;
        }
    }
    for row in squared.chunks_exact_mut(width) {
        let envelope = lower_envelope(row);
        row.copy_from_slice(&envelope);
    }
    squared.into_iter().map(f64::sqrt).collect()
}

/// min over j of (i − j)² + `heights[j]`, for every i.
fn lower_envelope(heights: &[f64]) -> Vec<f64> {
    // Each parabola of the envelope: its apex, and from where on it is the lowest.
    let mut envelope: Vec<(usize, f64)> = Vec::new();
    for (apex, height) in heights.iter().enumerate().filter(|(_, height)| height.is_finite()) {
        let mut from = f64::NEG_INFINITY;
        while let Some(&(last, last_from)) = envelope.last() {
            let (p, q) = (last as f64, apex as f64);
            from = ((height + q * q) - (heights[last] + p * p)) / (2.0 * (q - p));
            if from > last_from {
                break;
            }
            // The last parabola is nowhere the lowest any more.
            envelope.pop();
            from = f64::NEG_INFINITY;
        }
        envelope.push((apex, from));
    }
    let mut current = 0;
    (0..heights.len())
        .map(|i| {
            while envelope.get(current + 1).is_some_and(|(_, from)| *from <= i as f64) {
                current += 1;
            }
            envelope.get(current).map_or(f64::INFINITY, |(apex, _)| {
                let distance = i as f64 - *apex as f64;
                distance * distance + heights[*apex]
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_brute_force() {
        let (width, height) = (13, 9);
        let marked: Vec<bool> = (0..width * height).map(|i| (i * 7919) % 23 == 3).collect();
        let transform = distances(&marked, width);
        for (pixel, distance) in transform.iter().enumerate() {
            let nearest = (0..marked.len())
                .filter(|other| marked[*other])
                .map(|other| {
                    let (dx, dy) =
                        ((pixel % width).abs_diff(other % width), (pixel / width).abs_diff(other / width));
                    ((dx * dx + dy * dy) as f64).sqrt()
                })
                .fold(f64::INFINITY, f64::min);
            assert_eq!(*distance, nearest, "pixel {pixel}");
        }
        assert!(distances(&[false; 6], 3).iter().all(|d| d.is_infinite()));
    }
}
