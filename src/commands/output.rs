//! Printing. Whoever reads may stop reading (`| head`) and the disk may be full: neither is a reason to panic, as the
//! standard macros do.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::sync::OnceLock;

use super::Failure;

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
    let text: String = text.to_string().chars().map(|c| if c == '\n' { c } else { visible(c) }).collect();
    check(writeln!(io::stdout().lock(), "{text}"));
}

pub(crate) fn to_stderr(text: Arguments<'_>) {
    // Where stderr itself fails there is nobody left to tell.
    let _ = writeln!(io::stderr().lock(), "{}", one_line(&text.to_string()));
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

fn visible(c: char) -> char {
    if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_one_line_without_control_characters() {
        assert_eq!(one_line("a\n  b\u{1b}[2J\r\nc"), "a b\u{fffd}[2J c");
    }
}
