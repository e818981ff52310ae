//! Draws: shader, geometry, state, and what the shader reads.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use wgpu::{
    BlendComponent, BlendFactor, BlendOperation, BlendState, CompareFunction, StencilFaceState,
    StencilOperation,
};

pub use shadowgraph_shaders::ShaderError;

use super::SlotId;

/// The target times the fragment's value: how techniques draw into visibilities.
pub const MULTIPLY: BlendState = {
    let multiply = BlendComponent {
        src_factor: BlendFactor::Dst,
        dst_factor: BlendFactor::Zero,
        operation: BlendOperation::Add,
    };
    BlendState { color: multiply, alpha: multiply }
};

/// The target plus the fragment's value: how techniques add up in float targets.
pub const ADD: BlendState = {
    let add = BlendComponent {
        src_factor: BlendFactor::One,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    };
    BlendState { color: add, alpha: add }
};

/// A shader: composed WGSL and its entry points.
#[derive(Clone, Debug, PartialEq)]
pub struct Shader {
    /// Its name in texts and errors. Shaders with one name and equal flags have one text.
    pub name: Arc<str>,
    /// The composed WGSL.
    pub source: Arc<str>,
    /// The vertex entry point.
    pub vertex: Cow<'static, str>,
    /// The fragment entry point; `None` for draws that write depth or stencil only.
    pub fragment: Option<Cow<'static, str>>,
}

impl Shader {
    /// A shader of this workspace by its name, composed with `flags`.
    ///
    /// # Errors
    /// What cannot be composed: see [`shadowgraph_shaders::compose`].
    pub fn composed(
        name: &'static str,
        flags: &[&str],
        vertex: &'static str,
        fragment: Option<&'static str>,
    ) -> Result<Self, ShaderError> {
        let Text { name, source } =
            Text::known(name, flags, || shadowgraph_shaders::compose_named(name, flags))?;
        Ok(Self::of(name, source, vertex, fragment))
    }

    /// The same with the text that `write` gives in place of the module `replaced`. `variant` tells what is written from what else
    /// `write` might: equal variants have one text, and it is written once.
    ///
    /// # Errors
    /// What cannot be composed or written: see [`shadowgraph_shaders::compose_replacing`].
    pub fn replacing(
        (name, variant): (&'static str, &str),
        flags: &[&str],
        (replaced, write): (&str, impl FnOnce() -> Result<String, ShaderError>),
        vertex: &'static str,
        fragment: Option<&'static str>,
    ) -> Result<Self, ShaderError> {
        let compose = || shadowgraph_shaders::compose_replacing(name, flags, replaced, &write()?);
        let Text { name, source } = Text::known(&format!("{name} {variant}"), flags, compose)?;
        Ok(Self::of(name, source, vertex, fragment))
    }

    /// A shader of one's own: WGSL that may import every common module of this workspace, composed with `flags`.
    ///
    /// # Errors
    /// What cannot be composed: see [`shadowgraph_shaders::compose`].
    pub fn written(
        name: &str,
        text: &str,
        flags: &[&str],
        vertex: &'static str,
        fragment: Option<&'static str>,
    ) -> Result<Self, ShaderError> {
        let source = shadowgraph_shaders::compose(name, text, flags)?;
        Ok(Self::of([&[name], flags].concat().join(" "), source, vertex, fragment))
    }

    /// A shader of WGSL that is composed already.
    pub fn of(
        name: impl Into<Arc<str>>,
        source: impl Into<Arc<str>>,
        vertex: &'static str,
        fragment: Option<&'static str>,
    ) -> Self {
        let (name, source) = (name.into(), source.into());
        Self { name, source, vertex: vertex.into(), fragment: fragment.map(Into::into) }
    }
}

/// A composed text of this workspace.
#[derive(Clone)]
struct Text {
    /// The module's name and its flags.
    name: Arc<str>,
    source: Arc<str>,
}

impl Text {
    /// The text of a module with these flags, composed once in a process: that takes as long as planning a light, and the executor
    /// tells texts apart by where they are.
    fn known(
        name: &str,
        flags: &[&str],
        compose: impl FnOnce() -> Result<String, ShaderError>,
    ) -> Result<Self, ShaderError> {
        static KNOWN: Mutex<BTreeMap<Arc<str>, Text>> = Mutex::new(BTreeMap::new());
        let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let name = [&[name], flags].concat().join(" ");
        if let Some(text) = known().get(&*name) {
            return Ok(text.clone());
        }
        let text = Self { name: name.into(), source: compose()?.into() };
        known().insert(Arc::clone(&text.name), text.clone());
        Ok(text)
    }
}

/// The stencil value beside the receivers' depth where nothing has counted. Entering a volume counts one up, leaving
/// it one down; what ends above this value, up to 223, is dark. What ends below is lit: no volume is left that was
/// not entered, so there rounding placed a side before the surface that it touches, as happens at surfaces thinner
/// than a pixel.
pub const STENCIL_AT_REST: u8 = 32;

/// How a draw tests and changes the stencil, for both faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stencil {
    /// Front faces (counter-clockwise as the eye sees them).
    pub front: StencilFaceState,
    /// Back faces.
    pub back: StencilFaceState,
    /// Which bits the comparison reads.
    pub read_mask: u8,
    /// Which bits the operations change.
    pub write_mask: u8,
    /// The reference value.
    pub reference: u8,
}

impl Stencil {
    /// Whether it sets counts back to [`STENCIL_AT_REST`].
    pub fn frees(&self) -> bool {
        [self.front.fail_op, self.front.pass_op] == [StencilOperation::Replace; 2]
            && self.reference == STENCIL_AT_REST
            && self.write_mask == 0xff
    }
}

/// The fixed-function state of a draw.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawState {
    /// The depth comparison: passes when `fragment` *compare* `stored`. Near is 1.
    pub depth_compare: CompareFunction,
    /// Whether depth is written.
    pub depth_write: bool,
    /// Whether depths beyond near and far are clamped instead of clipped.
    pub depth_clamp: bool,
    /// What is added to depth after interpolation, in units of its rounding error; negative is farther. The unit is
    /// the last digit of the triangle's largest depth, and the depth's change over 2⁻¹⁹ pixel: over a target of a
    /// thousand pixels a rasteriser's depth of a plane loses some 2⁻²⁴ of its slope a pixel.
    pub depth_bias: i32,
    /// What happens in the stencil; `None` leaves it alone.
    pub stencil: Option<Stencil>,
    /// For each colour attachment of the pass: how it is blended, or `None` to leave it alone.
    pub targets: Vec<Option<BlendState>>,
    /// The blend constant.
    pub blend_constant: [f64; 4],
    /// The pixels of the target that clip space is spread over: x, y, width, height; `None` for all.
    pub viewport_px: Option<[u32; 4]>,
}

impl DrawState {
    /// Replaces colour, tests depth by `compare`, writes neither depth nor stencil.
    pub fn new(depth_compare: CompareFunction, targets: Vec<Option<BlendState>>) -> Self {
        Self {
            depth_compare,
            depth_write: false,
            depth_clamp: false,
            depth_bias: 0,
            stencil: None,
            targets,
            blend_constant: [0.0; 4],
            viewport_px: None,
        }
    }
}

/// How the engine draws the scene's surfaces, with shaders of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SurfaceStyle {
    /// Depth only.
    Depth,
    /// Shaded and opaque.
    Opaque,
    /// Shaded and blended over what is there, far to near; where the draw reads a depth (binding 9), only what is behind
    /// it.
    Blended,
    /// Multiplies what is there by what passes the surface; binding 9 as for [`SurfaceStyle::Blended`].
    Tint,
    /// Depth only, of transparent surfaces, where they are before the depth that the draw reads (binding 0); binding 9 as
    /// for [`SurfaceStyle::Blended`].
    Before,
}

/// What a shader that pulls the scene's surfaces by index needs of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PulledStyle {
    /// Positions: enough to know instance and triangle.
    Pulled,
    /// Materials too: for surfaces with holes.
    PulledMasked,
}

/// What a draw draws, and with which shader.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry<R = SlotId> {
    /// Parts of the scene's own meshes with their materials, by a shader that the engine composes for each.
    Surfaces {
        /// Which shading.
        style: SurfaceStyle,
        /// (instance, part) in drawing order.
        parts: Vec<(u32, u32)>,
        /// Vertices in all, for the plan's text.
        vertices: u64,
    },
    /// Parts of the scene's own meshes, whose vertices the shader pulls by index.
    PulledSurfaces {
        /// The shader.
        shader: Shader,
        /// What it gets.
        style: PulledStyle,
        /// (instance, part) in drawing order.
        parts: Vec<(u32, u32)>,
        /// Vertices in all, for the plan's text.
        vertices: u64,
    },
    /// Indices into one instance's vertex positions, read by the shader from binding 0 of group 1.
    Indexed {
        /// The shader.
        shader: Shader,
        /// The instance whose mesh the positions are of.
        instance: u32,
        /// The index buffer.
        indices: R,
        /// The first index.
        first: u32,
        /// The number of indices.
        count: u32,
        /// The shader's `instance_index`.
        record: u32,
    },
    /// Vertices by their numbers; the shader makes them from one instance's vertex positions, which it reads from binding 0 of
    /// group 1, and from what the draw binds.
    Numbered {
        /// The shader.
        shader: Shader,
        /// The instance whose mesh the positions are of.
        instance: u32,
        /// The first number.
        first: u32,
        /// The number of vertices.
        count: u32,
        /// The shader's `instance_index`.
        record: u32,
    },
    /// Indices; the shader makes the vertices from what the draw binds.
    IndexedProcedural {
        /// The shader.
        shader: Shader,
        /// The index buffer.
        indices: R,
        /// The first index.
        first: u32,
        /// The number of indices.
        count: u32,
        /// The shader's `instance_index`.
        record: u32,
    },
    /// Vertices that the shader makes from their numbers.
    Procedural {
        /// The shader.
        shader: Shader,
        /// The number of vertices.
        vertices: u32,
        /// The number of instances.
        instances: u32,
    },
}

impl<R> Geometry<R> {
    /// One triangle over the whole target; the shader makes its corners.
    pub fn fullscreen(shader: Shader) -> Self {
        Self::Procedural { shader, vertices: 3, instances: 1 }
    }

    /// The shader; `None` for surfaces, whose shaders the engine composes.
    pub fn shader(&self) -> Option<&Shader> {
        match self {
            Self::Surfaces { .. } => None,
            Self::PulledSurfaces { shader, .. }
            | Self::Indexed { shader, .. }
            | Self::Numbered { shader, .. }
            | Self::IndexedProcedural { shader, .. }
            | Self::Procedural { shader, .. } => Some(shader),
        }
    }

    /// Whether the shader reads an instance's positions from binding 0 of group 1.
    pub(crate) fn brings_positions(&self) -> bool {
        matches!(self, Self::Indexed { .. } | Self::Numbered { .. })
    }

    /// The number of vertices that are processed.
    pub fn vertices(&self) -> u64 {
        match self {
            Self::Surfaces { vertices, .. } | Self::PulledSurfaces { vertices, .. } => *vertices,
            Self::Indexed { count, .. }
            | Self::Numbered { count, .. }
            | Self::IndexedProcedural { count, .. } => u64::from(*count),
            Self::Procedural { vertices, instances, .. } => u64::from(*vertices) * u64::from(*instances),
        }
    }
}

/// What a shader reads from group 1, in addition to what its geometry brings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binding<R = SlotId> {
    /// `var<storage, read>`.
    Storage(R),
    /// `texture_2d<f32>` (`texture_depth_2d` for a depth format, `texture_2d<u32>` for whole numbers) over layer 0;
    /// `texture_multisampled_2d` and `texture_depth_multisampled_2d` for a slot of several samples.
    Texture(R),
    /// `texture_2d_array<f32>` over all layers; `texture_depth_2d_array` for a depth format.
    TextureArray(R),
    /// `texture_2d_array<f32>` over one layer, which the shader sees as layer 0; `texture_depth_2d_array` for a depth
    /// format.
    TextureLayer(R, u32),
    /// `texture_2d<u32>` over the stencil aspect; `texture_multisampled_2d<u32>` for a slot of several samples.
    StencilOf(R),
    /// `sampler_comparison`: 1 where the reference *compare* the texel, blended linearly between four, clamped to the edge.
    Comparison(CompareFunction),
}

impl<R: Copy> Binding<R> {
    /// The texture or buffer that is read; `None` for a sampler.
    pub fn resource(&self) -> Option<R> {
        match self {
            Self::Storage(read)
            | Self::Texture(read)
            | Self::TextureArray(read)
            | Self::TextureLayer(read, _)
            | Self::StencilOf(read) => Some(*read),
            Self::Comparison(_) => None,
        }
    }
}

/// One draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw<R = SlotId> {
    /// What it is called in the plan's text.
    pub name: String,
    /// What is drawn, and by which shader.
    pub geometry: Geometry<R>,
    /// The state.
    pub state: DrawState,
    /// What the shader reads, as (binding number in group 1, what).
    pub bindings: Vec<(u32, Binding<R>)>,
    /// The pixels it is confined to: x, y, width, height; `None` for all.
    pub scissor_px: Option<[u32; 4]>,
}

impl<R> Draw<R> {
    /// A draw over all pixels that reads nothing.
    pub fn new(name: impl Into<String>, geometry: Geometry<R>, state: DrawState) -> Self {
        Self { name: name.into(), geometry, state, bindings: vec![], scissor_px: None }
    }

    /// The same draw, reading `bindings`.
    #[must_use]
    pub fn reading(self, bindings: Vec<(u32, Binding<R>)>) -> Self {
        Self { bindings, ..self }
    }

    /// The number of vertices the draw processes.
    pub fn vertices(&self) -> u64 {
        self.geometry.vertices()
    }
}
