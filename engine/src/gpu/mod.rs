//! Everything that needs a device: choosing an adapter, keeping meshes and textures on it, executing plans.

mod bindings;
mod context;
mod executor;
mod groups;
mod limits;
mod materials;
mod meshes;
mod pipelines;
mod readback;
mod uniforms;

pub use context::{AdapterChoice, DEFAULT_BUDGET_BYTES, Gpu, GpuError};
pub use executor::{Executed, Executor, FrameInputs, PassTime, Timing};
pub use materials::MaterialUniform;
pub use readback::{Pixels, PixelsError};
pub use uniforms::{FrameUniform, InstanceUniform, Layout, LightUniform, TintUniform};
