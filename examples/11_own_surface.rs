//! A surface of one's own: WGSL that gets each light with its shadow factor apart, and makes of it what it likes. Here a
//! drawing in ink, whose shadows are cross-hatched; the ball is an ordinary material in the same light. See
//! `own_surface/hatching.wgsl` for the function.
//!
//! `cargo run --example 11_own_surface` draws `out/11_own_surface.png`.

mod common;
mod own_surface;

use std::error::Error;
use std::sync::Arc;

use shadowgraph::prelude::*;

fn main() -> Result<(), Box<dyn Error>> {
    // Compiled here, without a device: an error names the line.
    let hatching = SurfaceFunction::new("hatching", own_surface::HATCHING)?;
    let scene = own_surface::scene(Some(Arc::new(hatching)))?;
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    common::picture(&mut renderer, &scene, &own_surface::camera(), Exposure::Fixed(1.4), "11_own_surface")
}
