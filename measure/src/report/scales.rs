//! Scales: values to places on the page, and the ticks beside them.

/// How values become places.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    kind: Kind,
    /// The values at both ends; logarithms for [`Kind::Log`].
    range: [f64; 2],
    /// The places of both ends.
    px: [f64; 2],
    /// Where exact zero is, for a logarithmic scale that has a place for it.
    zero_px: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Linear,
    Log,
}

/// A line of the grid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// Its place.
    pub(super) px: f64,
    /// What stands beside it; empty for lines between labelled ones.
    pub(super) label: String,
}

impl Scale {
    /// A logarithmic scale over `values`, which is widened to `least` (a factor) and a little beyond. Values that are
    /// not positive have no place on it, unless `zero_px` gives them one.
    pub(super) fn log(values: &[f64], least: f64, px: [f64; 2], zero_px: Option<f64>) -> Self {
        let logs = values.iter().filter(|v| **v > 0.0 && v.is_finite()).map(|v| v.log10());
        let (mut low, mut high) =
            logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            (low, high) = (-1.0, 1.0);
        }
        let missing = (least.log10() - (high - low)).max(0.0) * 0.5;
        let margin = (high - low) * 0.06 + 0.02;
        Self { kind: Kind::Log, range: [low - missing - margin, high + missing + margin], px, zero_px }
    }

    /// A linear scale over `values` and a little beyond.
    pub(super) fn linear(values: &[f64], px: [f64; 2]) -> Self {
        let finite = values.iter().filter(|v| v.is_finite());
        let (mut low, mut high) =
            finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let margin = if high > low { (high - low) * 0.05 } else { high.abs().max(1.0) * 0.5 };
        Self { kind: Kind::Linear, range: [low - margin, high + margin], px, zero_px: None }
    }

    /// The place of a value; `None` where it has none.
    pub(super) fn px(&self, value: f64) -> Option<f64> {
        let place = match self.kind {
            Kind::Linear => value,
            Kind::Log if value > 0.0 => value.log10(),
            Kind::Log => return self.zero_px.filter(|_| value == 0.0),
        };
        let share = (place - self.range[0]) / (self.range[1] - self.range[0]);
        Some(self.px[0] + share * (self.px[1] - self.px[0])).filter(|px| px.is_finite())
    }

    /// Where the ticks are.
    pub(super) fn ticks(&self) -> Vec<Tick> {
        match self.kind {
            Kind::Linear => self.linear_ticks(),
            Kind::Log => self.log_ticks(),
        }
    }

    fn linear_ticks(&self) -> Vec<Tick> {
        let span = self.range[1] - self.range[0];
        let rough = span / 5.0;
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].iter().map(|m| m * power).find(|s| *s >= rough).unwrap_or(rough);
        let first = (self.range[0] / step).ceil() as i64;
        let last = (self.range[1] / step).floor() as i64;
        let tick = |i: i64| Some(Tick { px: self.px(i as f64 * step)?, label: number(i as f64 * step) });
        (first..=last).take(20).filter_map(tick).collect()
    }

    fn log_ticks(&self) -> Vec<Tick> {
        let decades = self.range[1] - self.range[0];
        // Few decades: 1, 2, 5 are labelled, or even every digit; many: only every second or third power.
        let labelled: &[u32] = match decades {
            d if d < 0.7 => &[1, 2, 3, 4, 5, 6, 7, 8, 9],
            d if d < 1.2 => &[1, 2, 3, 5, 7],
            d if d < 2.5 => &[1, 2, 5],
            _ => &[1],
        };
        let every = ((decades / 7.0).ceil() as i32).max(1);
        let mut ticks = Vec::new();
        for power in self.range[0].floor() as i32..=self.range[1].ceil() as i32 {
            for digit in 1..10_u32 {
                let value = f64::from(digit) * 10_f64.powi(power);
                let is_outside = !(self.range[0]..=self.range[1]).contains(&value.log10());
                if is_outside || (decades > 3.0 && digit != 1) {
                    continue;
                }
                let has_label = labelled.contains(&digit) && (digit != 1 || power.rem_euclid(every) == 0);
                let label = if has_label { number(value) } else { String::new() };
                ticks.extend(self.px(value).map(|px| Tick { px, label }));
            }
        }
        ticks
    }
}

/// A number for a reader: thin spaces between thousands, powers of ten where there would be many zeros.
pub(super) fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-3..6).contains(&magnitude) {
        let digit = value / 10_f64.powi(magnitude);
        let power = superscript(magnitude);
        let digit = trimmed(format!("{digit:.1}"));
        return if digit == "1" { format!("10{power}") } else { format!("{digit}·10{power}") };
    }
    let decimals = (2 - magnitude).clamp(0, 6) as usize;
    let text = trimmed(format!("{value:.decimals$}"));
    match text.split_once('.') {
        Some((whole, fraction)) => format!("{}.{fraction}", grouped(whole)),
        None => grouped(&text),
    }
}

/// A whole number for a reader, every digit of it.
pub(super) fn count(count: usize) -> String {
    grouped(&count.to_string())
}

fn grouped(whole: &str) -> String {
    let mut grouped = String::new();
    for (i, c) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) && whole.len() > 4 {
            grouped.push('\u{2009}');
        }
        grouped.push(c);
    }
    grouped
}

fn trimmed(text: String) -> String {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

fn superscript(power: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digit = |c: char| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize]);
    power.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_for_readers() {
        let written = [0.0, 1.0, 0.001, 0.25, 13_056.0, 1e6, 2e-5, 1234.0, 0.05].map(number);
        let wanted = ["0", "1", "0.001", "0.25", "13\u{2009}056", "10⁶", "2·10⁻⁵", "1234", "0.05"];
        assert_eq!(written, wanted);
    }

    #[test]
    fn logarithmic_places_are_even_and_zero_has_its_own() {
        let scale = Scale::log(&[1.0, 100.0, 0.0], 1.0, [0.0, 300.0], Some(320.0));
        let px = |value| scale.px(value).expect("it has a place");
        assert!((px(10.0) - px(1.0) - (px(100.0) - px(10.0))).abs() < 1e-9);
        assert_eq!((scale.px(0.0), scale.px(-1.0)), (Some(320.0), None));
        let labels: Vec<String> = scale.ticks().into_iter().map(|tick| tick.label).collect();
        assert!(labels.contains(&"10".to_owned()) && labels.contains(&"50".to_owned()));
    }

    #[test]
    fn one_value_or_none_still_has_a_scale() {
        for values in [&[][..], &[5.0]] {
            assert!(!Scale::log(values, 4.0, [0.0, 100.0], None).ticks().is_empty());
            assert!(!Scale::linear(values, [0.0, 100.0]).ticks().is_empty());
        }
        assert!(
            Scale::log(&[5.0], 4.0, [0.0, 100.0], None).px(5.0).is_some_and(|px| (px - 50.0).abs() < 1e-9)
        );
    }
}
