//! The README's first program is the example of that name, word for word, and writes a picture in which there is a shadow.

use std::path::Path;
use std::process::Command;

use image::GenericImageView;

/// The program without the line that says what it is.
fn program() -> &'static str {
    let text = include_str!("../../examples/00_first_picture.rs");
    text.split_once("\n\n").unwrap().1
}

#[test]
fn the_readme_shows_the_program() {
    let readme = include_str!("../../README.md");
    assert!(readme.contains(&format!("```rust\n{}```\n", program())), "README.md shows another program");
    assert!(program().lines().count() <= 20, "a first program is short");
}

#[test]
fn the_first_program_writes_a_picture() {
    if shadowgraph_testing::renderer().is_none() {
        return;
    }
    let cargo = Command::new(env!("CARGO"))
        .args(["run", "--quiet", "--example", "00_first_picture"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        // What `./x test` runs tests with would have everything compiled anew.
        .env_remove("RUSTC_BOOTSTRAP")
        .output()
        .unwrap();
    assert!(cargo.status.success(), "{}", String::from_utf8_lossy(&cargo.stderr));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("out/first_picture.png");
    let picture = image::open(&path).unwrap();
    assert_eq!(picture.dimensions(), (640, 480));
    // The floor is in the light on the right of the box, and in its shadow on the left.
    let luma = picture.to_luma8();
    let values: Vec<u8> = luma.pixels().map(|pixel| pixel.0[0]).collect();
    let (dark, bright) = (values.iter().min().unwrap(), values.iter().max().unwrap());
    assert!(bright - dark > 100, "from {dark} to {bright}");
}
