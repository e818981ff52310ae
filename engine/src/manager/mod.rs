//! The render manager: collects shadow nodes, plans the frame, has it executed. The only room that sees all others.

mod exposure;
mod frame;
mod surfaces;

pub use exposure::Exposure;
pub use frame::{Adapter, FrameError, FrameRequest, PictureFormat, plan_frame};
