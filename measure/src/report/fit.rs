//! How cost grows: the exponent of a power law, and straight lines.

/// `y ∝ x^exponent` over the upper decade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The exponent.
    pub exponent: f64,
    /// Its standard error; `None` with two points, which any power law goes through.
    pub standard_error: Option<f64>,
    /// The fitted value at x = 1.
    pub at_one: f64,
    /// The smallest and the largest x that took part.
    pub range: [f64; 2],
    /// How many points took part.
    pub points: usize,
}

impl Fit {
    /// The fitted value at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.at_one * x.powf(self.exponent)
    }
}

/// Fits a line through the logarithms of the points whose x is within the upper decade, by least squares. Points that
/// have no logarithm (a cost lost in the noise) take no part; with fewer than two left there is nothing to fit.
pub fn fit(points: &[(f64, f64)]) -> Option<Fit> {
    let largest = points.iter().map(|(x, _)| *x).fold(0.0, f64::max);
    let in_decade = |(x, y): &&(f64, f64)| *x >= largest / 10.0 * (1.0 - 1e-9) && *x > 0.0 && *y > 0.0;
    let logs: Vec<(f64, f64)> = points.iter().filter(in_decade).map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| logs.iter().map(value).sum::<f64>() / count;
    let (mean_x, mean_y) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = logs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    if logs.len() < 2 || spread <= 0.0 {
        return None;
    }
    let exponent = logs.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>() / spread;
    let offset = mean_y - exponent * mean_x;
    let residual: f64 = logs.iter().map(|(x, y)| (y - offset - exponent * x).powi(2)).sum();
    let standard_error = (logs.len() > 2).then(|| (residual / (count - 2.0) / spread).sqrt());
    let xs = || logs.iter().map(|(x, _)| x.exp());
    let range = [xs().fold(f64::INFINITY, f64::min), xs().fold(0.0, f64::max)];
    Some(Fit { exponent, standard_error, at_one: offset.exp(), range, points: logs.len() })
}

/// `y = at_zero + slope·x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// What y gains for each x.
    pub slope: f64,
    /// Its standard error; `None` with two points, which any line goes through.
    pub standard_error: Option<f64>,
    /// The fitted value at x = 0.
    pub at_zero: f64,
    /// The share of y's variance that the line explains: 1 for points on it.
    pub r_squared: f64,
    /// How far the points are from the line, root mean square, in the units of y.
    pub residual: f64,
}

impl Line {
    /// The fitted value at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.at_zero + self.slope * x
    }
}

/// Fits a line through the points by least squares; `None` with fewer than two different x.
pub fn line(points: &[(f64, f64)]) -> Option<Line> {
    let count = points.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / count;
    let (mean_x, mean_y) = (mean(|p| p.0), mean(|p| p.1));
    let spread_x: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    let spread_y: f64 = points.iter().map(|(_, y)| (y - mean_y).powi(2)).sum();
    if points.len() < 2 || spread_x <= 0.0 {
        return None;
    }
    let slope = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>() / spread_x;
    let at_zero = mean_y - slope * mean_x;
    let squares: f64 = points.iter().map(|(x, y)| (y - at_zero - slope * x).powi(2)).sum();
    Some(Line {
        slope,
        standard_error: (points.len() > 2).then(|| (squares / (count - 2.0) / spread_x).sqrt()),
        at_zero,
        r_squared: if spread_y > 0.0 { 1.0 - squares / spread_y } else { 1.0 },
        residual: (squares / count).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_again_with_its_error() {
        let exact = line(&[(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)]).expect("three points");
        assert!((exact.slope - 2.0).abs() < 1e-12 && (exact.at(10.0) - 23.0).abs() < 1e-12);
        assert!((exact.r_squared - 1.0).abs() < 1e-12 && exact.residual < 1e-12);
        // x = 0, 1, 2 and y = 0, 1, 3, as below: slope 1.5, residuals 1/6, −1/3, 1/6.
        let bent = line(&[(0.0, 0.0), (1.0, 1.0), (2.0, 3.0)]).expect("three points");
        assert!((bent.standard_error.expect("three points") - (1.0_f64 / 12.0).sqrt()).abs() < 1e-12);
        assert!((bent.residual - (1.0_f64 / 18.0).sqrt()).abs() < 1e-12);
        assert_eq!(line(&[(1.0, 2.0), (1.0, 3.0)]), None);
    }

    #[test]
    fn a_power_law_is_found_again_and_only_the_upper_decade_counts() {
        let law = |x: f64| 3.0 * x.powf(1.5);
        let mut points: Vec<_> = [10.0, 20.0, 50.0, 100.0].map(|x| (x, law(x))).to_vec();
        points.push((1.0, 1e9));
        let found = fit(&points).expect("four points are enough");
        assert!((found.exponent - 1.5).abs() < 1e-12 && (found.at(7.0) - law(7.0)).abs() < 1e-9);
        assert!(found.standard_error.is_some_and(|error| error < 1e-9) && found.points == 4);
        assert!((found.range[0] - 10.0).abs() < 1e-9 && (found.range[1] - 100.0).abs() < 1e-9);
    }

    #[test]
    fn the_standard_error_is_that_of_least_squares() {
        // ln x = 0, 1, 2 and ln y = 0, 1, 3: slope 1.5, residuals 1/6, −1/3, 1/6, so s² = 1/6 and se = √(1/12).
        let e = std::f64::consts::E;
        let found = fit(&[(1.0, 1.0), (e, e), (e * e, e.powi(3))]).expect("three points");
        assert!((found.exponent - 1.5).abs() < 1e-12);
        assert!((found.standard_error.expect("three points") - (1.0_f64 / 12.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_has_no_logarithm_takes_no_part() {
        assert_eq!(fit(&[(1.0, 2.0), (2.0, -1.0)]), None);
        assert_eq!(fit(&[]), None);
        let two = fit(&[(1.0, 2.0), (2.0, 4.0), (3.0, 0.0)]).expect("two are left");
        assert_eq!((two.points, two.standard_error), (2, None));
    }
}
