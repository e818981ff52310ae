//! The Pareto front: what nothing else beats in both speed and error.

/// The indices of the points (cost, error) that no other is better than in one and at least as good as in the other,
/// cheapest first. Of equal points the first counts.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| {
        let ((cost_a, error_a), (cost_b, error_b)) = (points[*a], points[*b]);
        cost_a.total_cmp(&cost_b).then(error_a.total_cmp(&error_b)).then(a.cmp(b))
    });
    let mut least = f64::INFINITY;
    order.retain(|index| {
        let better = points[*index].1 < least;
        least = least.min(points[*index].1);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_has_what_nothing_beats() {
        let points = [(3.0, 1.0), (1.0, 9.0), (2.0, 9.0), (4.0, 1.0), (5.0, 0.0), (1.0, 9.0), (2.5, 4.0)];
        assert_eq!(front(&points), [1, 6, 0, 4]);
        assert_eq!(front(&[]), Vec::<usize>::new());
        // By definition, over all pairs.
        for (i, p) in points.iter().enumerate() {
            let beaten = points
                .iter()
                .enumerate()
                .any(|(j, q)| (q.0 <= p.0 && q.1 <= p.1 && (q.0 < p.0 || q.1 < p.1)) || (q == p && j < i));
            assert_eq!(!beaten, front(&points).contains(&i), "{i}");
        }
    }
}
