//! Printing. Whoever reads may stop reading (`| head`) and the disk may be full: neither is a reason to panic, as the
//! standard macros do.

use std::borrow::Cow;
use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::sync::OnceLock;

use shadowgraph::engine::gltf::shown_name;

use super::Failure;

/// A line without more than this has no name that needs to be shortened.
const MOST_READ: usize = 80;

/// The first thing that went wrong on stdout.
static FAILED: OnceLock<io::Error> = OnceLock::new();

/// Prints a line, or several, on stdout.
macro_rules! out {
    ($($text:tt)*) => { $crate::commands::output::to_stdout(format_args!($($text)*)) };
}

/// Prints one line on stderr.
macro_rules! note {
    ($($text:tt)*) => { $crate::commands::output::to_stderr(format_args!($($text)*)) };
}

pub(crate) use {note, out};

pub(crate) fn to_stdout(text: Arguments<'_>) {
    let text = text.to_string();
    let text = short_names(&text);
    let text: String = text.chars().map(|c| if c == '\n' { c } else { visible(c) }).collect();
    check(writeln!(io::stdout().lock(), "{text}"));
}

pub(crate) fn to_stderr(text: Arguments<'_>) {
    // Where stderr itself fails there is nobody left to tell.
    let _ = writeln!(io::stderr().lock(), "{}", one_line(&short_names(&text.to_string())));
}

/// What failed to be printed, if anything; a reader that has seen enough is no failure.
pub(crate) fn finish() -> Result<(), Failure> {
    check(io::stdout().lock().flush());
    FAILED
        .get()
        .map_or(Ok(()), |error| Err(Failure::Other(format!("cannot write to standard output: {error}"))))
}

fn check(written: io::Result<()>) {
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            // Only the first is kept.
            let _ = FAILED.set(error);
        }
        _ => {}
    }
}

/// Messages hold names from files, which may hold anything; a message stays one line and steers no terminal.
pub(crate) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").chars().map(visible).collect()
}

/// Shortens in their middle the names, which stand between quotes, that are longer than anybody reads.
fn short_names(text: &str) -> Cow<'_, str> {
    // Where no name can be too long, nothing is done: plans have a line for everything.
    if !text.contains('\'') || !text.lines().any(|line| line.len() > MOST_READ) {
        return text.into();
    }
    let mut short = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let mut rest = line;
        while let Some((before, name, after)) = next_quoted(rest) {
            short.push_str(before);
            short.push_str(&shown_name(name));
            short.push('\'');
            rest = after;
        }
        short.push_str(rest);
    }
    short.into()
}

/// The text up to and with the next opening quote, what is quoted, and the rest after the closing one. The quotes of
/// words ("the scene's") stand between letters.
fn next_quoted(text: &str) -> Option<(&str, &str, &str)> {
    let letter = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
    let mut quotes = text.match_indices('\'').map(|(place, _)| place);
    let open = quotes.find(|place| !letter(text[..*place].chars().next_back()))?;
    let close = quotes.find(|place| !letter(text[place + 1..].chars().next()))?;
    Some((&text[..=open], &text[open + 1..close], &text[close + 1..]))
}

fn visible(c: char) -> char {
    if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_shortened_where_they_stand() {
        let long = "n".repeat(500);
        let text = format!("node '{long}' names '{long}' and 'lamp': {}", "reason ".repeat(30));
        let short = short_names(&text);
        assert!(short.contains("and 'lamp': reason reason") && short.contains('…'), "{short}");
        assert!(short.split('\'').nth(1).unwrap_or_default().chars().count() == 80, "{short}");
        let own = format!("outside the scene's folder ({}); it's so", "reason ".repeat(30));
        assert_eq!(short_names(&own), own);
    }

    #[test]
    fn messages_are_one_line_without_control_characters() {
        assert_eq!(one_line("a\n  b\u{1b}[2J\r\nc"), "a b\u{fffd}[2J c");
    }
}
