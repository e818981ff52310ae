//! The demo scenes: what the project's first pictures, its report and its viewer show.
//!
//! Each is made in code from generated shapes, has a camera called "main" and its own shadow nodes, and mixes open,
//! closed and non-manifold casters the way real models do. Intensities are physical (lux and candela) and chosen
//! relative to one another; the renderer sets the exposure.

mod columns;
mod furniture;
mod knots;
mod plant;
mod room;
mod set;

use shadowgraph_engine::scene::Scene;

/// Every demo scene: file stem, what it shows, the scene.
pub fn all() -> Vec<(&'static str, &'static str, Scene)> {
    vec![
        (
            "room",
            "a furnished room: sun and sky through a window, a floor lamp, a picture spot and a spot behind a plant",
            room::room(),
        ),
        ("knots", "torus knots and spheres over a floor under three coloured lamps", knots::knots()),
        ("columns", "a colonnade in low sun: long shadows of open and closed casters", columns::columns()),
        ("leaves", "open leaves of either winding close up under a spot", plant::leaves()),
    ]
}
