//! Names from files, as messages show them.

use std::borrow::Cow;

/// The most letters of a name that a message shows.
const MOST: usize = 80;

/// A name that is shortened in its middle if it is very long: both ends tell similar names apart.
pub(crate) fn shown(name: &str) -> Cow<'_, str> {
    // Letters are at most as many as bytes.
    if name.len() <= MOST || name.chars().count() <= MOST {
        return name.into();
    }
    let kept = MOST / 2;
    let head: String = name.chars().take(kept).collect();
    let tail: Vec<char> = name.chars().rev().take(MOST - kept - 1).collect();
    format!("{head}…{}", tail.into_iter().rev().collect::<String>()).into()
}

#[cfg(test)]
mod tests {
    use super::shown;

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
