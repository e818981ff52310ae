//! Every claim of the README and of ARCHITECTURE.md that a number or an "every" stands in has something behind it:
//! tests/CLAIMS.md says what. Here that table is held against the documents and the tests; and numbers that can be counted are.

use shadowgraph::cases;
use shadowgraph::measure::{BAND_FLOOR_PIXELS, BAND_PIXELS_PER_BOUNDARY_PIXEL, DEPTH_ULPS, PIXEL_MOVE};
use shadowgraph_testing::docs::text;

/// A row of the table: a claim as it stands there, where, and what is behind it.
struct Claim {
    quote: String,
    document: String,
    behind: String,
}

/// The rows of tests/CLAIMS.md.
fn claims() -> Vec<Claim> {
    let table = text("tests/CLAIMS.md");
    let rows = table.lines().filter(|line| line.starts_with("| “"));
    let claim = |line: &str| {
        let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        let [quote, document, behind] = cells[..] else { panic!("not three cells: {line}") };
        let quote = quote.strip_prefix('“').and_then(|quote| quote.strip_suffix('”'));
        let quote = quote.unwrap_or_else(|| panic!("not in quotation marks: {line}"));
        Claim { quote: quote.into(), document: document.into(), behind: behind.into() }
    };
    rows.map(claim).collect()
}

/// A text without its line breaks.
fn on_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Whether `source` has a test of this name that runs.
fn has_test(source: &str, name: &str) -> bool {
    let head = format!("fn {name}(");
    let Some(place) = source.find(&head) else { return false };
    let attributes = source[..place].rsplit("\n\n").next().unwrap_or_default();
    attributes.contains("#[test]") && !attributes.contains("#[ignore")
}

#[test]
fn every_claim_stands_where_it_is_said_to_and_has_a_test_or_a_command() {
    let (mut by_test, mut by_command, mut once) = (0, 0, 0);
    let mut wrong = Vec::new();
    for Claim { quote, document, behind } in claims() {
        if !on_one_line(&text(&document)).contains(&on_one_line(&quote)) {
            wrong.push(format!("{document} does not say “{quote}”"));
        }
        let behind_it = behind.trim_matches('`');
        if let Some((file, name)) = behind_it.split_once("::") {
            by_test += 1;
            if !has_test(&text(file), name) {
                wrong.push(format!("{file} has no test called {name}"));
            }
        } else if ["./x ", "cargo ", "shadowgraph "].iter().any(|start| behind_it.starts_with(start)) {
            by_command += 1;
        } else if behind == "measured once" {
            once += 1;
        } else {
            wrong.push(format!("“{quote}” has neither a test nor a command: {behind}"));
        }
    }
    println!("{by_test} claims have a test, {by_command} a command, {once} were measured once");
    assert!(by_test > 40, "{by_test} claims");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_can_be_counted_is() {
    let entries = cases::all();
    let variants: usize = entries.iter().map(|entry| entry.build(&shadowgraph::CAST).len()).sum();
    let said = format!("{variants} variants of {} cases", entries.len());
    assert!(on_one_line(&text("README.md")).contains(&said), "the README does not say '{said}'");
}

#[test]
fn the_band_is_as_wide_as_it_is_said_to_be() {
    assert_eq!((PIXEL_MOVE, DEPTH_ULPS), (1.0 / 256.0, 64));
    assert_eq!((BAND_PIXELS_PER_BOUNDARY_PIXEL, BAND_FLOOR_PIXELS), (3, 16));
}
