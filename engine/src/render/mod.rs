//! Rendering: collects shadow nodes, plans the frame, has it executed. The only room that sees all others.
//!
//! [`plan_frame`] is the frame, stage by stage: each has a file. Techniques and stages write to *symbols* (the receivers'
//! depth, this light's visibility); `lower` gives these their textures once all passes are known.

mod darkening;
mod exposure;
mod factor_images;
mod factors;
mod frame;
mod layer_count;
mod layer_images;
mod layered;
mod layers;
mod light_passes;
mod light_tiles;
mod lights;
mod lower;
mod picture;
mod planner;
mod prepass;
mod reach;
mod renderer;
mod request;
mod resolve;
mod samples;
mod schedule;
mod seen;
mod shading;
mod sorted;
mod states;
mod surface_functions;
mod surfaces;

pub use exposure::Exposure;
pub use frame::plan_frame;
pub use planner::Planner;
pub use renderer::{FactorImage, Frame, FrameLayer, RenderError, RenderOptions, Renderer};
pub use request::{Adapter, FrameError, FrameRequest, PictureFormat};
