//! Names and numbers from files, as messages show them.

use std::borrow::Cow;

/// The most letters of a name that a message shows.
const MOST: usize = 80;

/// A name that is shortened in its middle if it is very long: both ends tell similar names apart.
pub fn shown(name: &str) -> Cow<'_, str> {
    // Letters are at most as many as bytes.
    if name.len() <= MOST || name.chars().count() <= MOST {
        return name.into();
    }
    let kept = MOST / 2;
    let head: String = name.chars().take(kept).collect();
    let tail: Vec<char> = name.chars().rev().take(MOST - kept - 1).collect();
    format!("{head}…{}", tail.into_iter().rev().collect::<String>()).into()
}

/// A number in four digits at most, and no more of them than it needs.
pub fn few_digits(number: f64) -> String {
    let size = number.abs();
    if !number.is_finite() {
        return number.to_string();
    }
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        let text = format!("{number:.3e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let mantissa = if mantissa.contains('.') { mantissa.trim_end_matches('0') } else { mantissa };
        return format!("{}e{exponent}", mantissa.trim_end_matches('.'));
    }
    // The place of the first digit: 0 for ones, -1 for tenths.
    let first = if size == 0.0 { 0 } else { size.log10().floor() as i32 };
    let text = format!("{number:.*}", (3 - first).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::{few_digits, shown};

    #[test]
    fn numbers_have_few_digits() {
        let texts =
            [0.0, 1.0, -2.5, 0.1, 1.0 / 3.0, 12345.678, 1e200, -1.23456e-7, 1e6, 0.00123456, f64::INFINITY];
        let shown =
            ["0", "1", "-2.5", "0.1", "0.3333", "12346", "1e200", "-1.235e-7", "1e6", "0.001235", "inf"];
        assert_eq!(texts.map(few_digits), shown);
    }

    #[test]
    fn long_names_keep_both_ends() {
        assert_eq!(shown("lamp"), "lamp");
        let exact = "é".repeat(80);
        assert_eq!(shown(&exact), exact);
        let long = format!("first{}last", "é".repeat(1000));
        let short = shown(&long);
        assert_eq!(short.chars().count(), 80);
        assert!(short.starts_with("first") && short.ends_with("last") && short.contains('…'));
    }
}
