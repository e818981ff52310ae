//! The render manager: collects shadow nodes, plans the frame, has it executed. The only room that sees all others.

mod antialias;
mod assembly;
mod confine;
mod darkening;
mod exposure;
mod factors;
mod frame;
mod layer_count;
mod layer_images;
mod layers;
mod renderer;
mod request;
mod segments;
mod shading;
mod sorted;
mod states;
mod surface_functions;
mod surfaces;

pub use exposure::Exposure;
pub use frame::plan_frame;
pub use renderer::{FactorImage, Frame, FrameLayer, RenderError, RenderOptions, Renderer};
pub use request::{Adapter, FrameError, FrameRequest, PictureFormat};
