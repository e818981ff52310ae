//! A random search for scenes that are drawn wrong.
//!
//! [`recipe_of`] draws a scene from a seed: the same one on every machine. [`Judge`] renders it and holds it against the
//! reference and, where shadows are hard, against a tracer that asks every triangle. [`shrink`] takes away from a scene
//! that fails whatever it fails without, and [`write_failure`] leaves it as a `.glb` that shows the failure by itself.
//!
//! Scenes come in families (see [`Family`]), one after the other, so that a part of the search can be run alone and what was
//! searched can be counted.

mod bodies;
mod brute;
mod families;
mod generate;
mod judge;
mod lamps;
mod minimise;
mod options;
mod random;
mod recipe;
mod report;

pub use brute::Brute;
pub use families::Family;
pub use generate::recipe_of;
pub use judge::{Failure, FailureKind, Judge, Owed, Verdict, owed};
pub use minimise::shrink;
pub use options::Sizes;
pub use random::Random;
pub use recipe::{Bend, Body, Caster, Eye, Lamp, Recipe, RecipeError, Wear};
pub use report::{Tally, write_failure};
