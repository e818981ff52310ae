//! The options of `ShadowVolumeHard`: where each is exact, and where it is not.

mod closure;
mod extrusion;
mod float;
mod single;
mod single_sided;
mod stage;
mod terminator;
