//! The frame plan: a frame as plain data.
//!
//! A [`FramePlan`] lists slots (textures and buffers), then passes in the order in which they run, each with its
//! attachments, its draws and the reason it is there. It holds no closures and needs no device: it can be compared,
//! printed, validated and tested as text. The executor in [`crate::gpu`] does what it says and nothing else.

mod antialias;
mod builder;
mod lights;
mod slots;
mod text;
mod validate;

use std::borrow::Cow;
use std::sync::Arc;

pub use antialias::{Antialias, MULTISAMPLED_EVERYWHERE, STANDARD_SAMPLES_PX, UnknownAntialias};
pub use builder::PlanBuilder;
pub use lights::{ALL_TAKEN, FactorAt, FactorPart, LightPlanned, taken};
pub use validate::PlanError;
/// Plain enumerations of the graphics API that plans are written in.
pub use wgpu::{
    BlendComponent, BlendFactor, BlendOperation, BlendState, ColorWrites, CompareFunction, StencilFaceState,
    StencilOperation, TextureFormat,
};

use crate::scene::ImageKey;

/// dst · src: how techniques draw into visibility targets.
pub const MULTIPLY: BlendState = {
    let multiply = BlendComponent {
        src_factor: BlendFactor::Dst,
        dst_factor: BlendFactor::Zero,
        operation: BlendOperation::Add,
    };
    BlendState { color: multiply, alpha: multiply }
};

/// A slot of the plan, by its place in [`FramePlan::slots`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SlotId(pub usize);

/// A texture or a buffer that passes write and read.
#[derive(Clone, Debug, PartialEq)]
pub struct Slot {
    /// What it is called in the plan's text and in captures.
    pub name: String,
    /// What it is.
    pub kind: SlotKind,
    /// Why the frame needs it.
    pub reason: String,
    /// For a texture whose contents outlive the frame: a hash of all they depend on. The passes that write it run only
    /// when it does not hold the contents of this key yet.
    pub kept: Option<u64>,
}

/// What a slot is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum SlotKind {
    /// A texture the frame draws into; its contents do not outlive the frame, unless [`Slot::kept`] says so.
    Texture {
        /// Texel format.
        format: TextureFormat,
        /// Width and height in pixels.
        size_px: [u32; 2],
        /// Array layers.
        layers: u32,
        /// Samples of a pixel: 1, or those of [`Antialias::Multisample4`].
        samples: u32,
    },
    /// A buffer whose contents were computed while planning.
    Buffer {
        /// What it is for.
        usage: BufferUsage,
        /// A hash of what the contents were computed from. Buffers with equal keys have equal contents, so that a
        /// buffer already on the GPU is neither computed nor uploaded again.
        revision_key: u64,
        /// The contents.
        contents: Contents,
    },
    /// An image of the scene, as materials wear it: base colours in sRGB, alpha as it is.
    Image {
        /// Which.
        image: ImageKey,
    },
}

/// What a buffer is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BufferUsage {
    /// Read by shaders as `var<storage, read>`.
    Storage,
    /// 32-bit indices.
    Index,
}

/// The bytes of a buffer slot, shared between frames.
#[derive(Clone, PartialEq)]
pub struct Contents(pub Arc<Vec<u8>>);

impl std::fmt::Debug for Contents {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} B", self.0.len())
    }
}

impl Slot {
    /// The bytes the slot takes on the GPU.
    pub fn bytes(&self) -> u64 {
        match &self.kind {
            SlotKind::Texture { format, size_px, layers, samples } => {
                let texel =
                    format.block_copy_size(None).map_or_else(|| depth_texel_bytes(*format), u64::from);
                let texels = u64::from(size_px[0]) * u64::from(size_px[1]) * u64::from(*layers);
                texels * u64::from(*samples) * texel
            }
            SlotKind::Buffer { contents, .. } => contents.0.len() as u64,
            // Images are there for the surfaces that wear them, and counted with these.
            SlotKind::Image { .. } => 0,
        }
    }

    /// Samples of a pixel; 1 for buffers.
    pub fn samples(&self) -> u32 {
        if let SlotKind::Texture { samples, .. } = self.kind { samples } else { 1 }
    }
}

/// Depth formats have no copy size over both aspects; these are what implementations allocate.
fn depth_texel_bytes(format: TextureFormat) -> u64 {
    if format == TextureFormat::Depth32FloatStencil8 { 5 } else { 4 }
}

/// What a colour attachment holds when its pass begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// One value everywhere.
    Clear([f64; 4]),
    /// What earlier passes left.
    Keep,
    /// Whatever there was: the pass itself draws all that is read later.
    Anything,
}

/// How a pass uses one aspect of the depth-stencil attachment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Access {
    /// Tested or sampled, never written.
    ReadOnly,
    /// Written over what earlier passes left.
    Keep,
    /// Written over this value.
    Clear(f32),
}

/// A colour attachment.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorTarget {
    /// The texture.
    pub slot: SlotId,
    /// The array layer.
    pub layer: u32,
    /// What it holds at first.
    pub load: Load,
    /// The single-sample texture that gets the mean of each pixel's samples when the pass is done.
    pub resolve: Option<SlotId>,
}

/// The depth-stencil attachment.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthTarget {
    /// The texture.
    pub slot: SlotId,
    /// How depth is used: read-only where the format has none.
    pub depth: Access,
    /// How the stencil is used; `None` when the format has none.
    pub stencil: Option<Access>,
}

/// One render pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// What it is called in the plan's text and in timings.
    pub name: String,
    /// Why the frame needs it.
    pub reason: String,
    /// Colour attachments.
    pub colors: Vec<ColorTarget>,
    /// Depth-stencil attachment.
    pub depth: Option<DepthTarget>,
    /// What is drawn, in order.
    pub draws: Vec<Draw>,
}

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

/// What the stencil beside receivers' depth holds where nothing was counted. Entering a volume counts one up from here, leaving it
/// one down, and what is above is dark, up to 223. What is below is lit: nothing is left that was not entered, so there a side was taken to
/// be before what it touches by the rounding of depths, as happens at surfaces thinner than a pixel.
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
    /// What is added to depth once it is interpolated, in roundings of it; negative is farther. A rounding is the last digit of
    /// the triangle's largest depth, and what depth changes by over 2⁻¹⁹ pixel: over a target of a thousand pixels a plane's
    /// depth is a product that loses some 2⁻²⁴ of its slope a pixel.
    pub depth_bias: i32,
    /// What happens in the stencil; `None` leaves it alone.
    pub stencil: Option<Stencil>,
    /// For each colour attachment of the pass: how it is blended, or `None` to leave it alone.
    pub targets: Vec<Option<BlendState>>,
    /// The blend constant.
    pub blend_constant: [f64; 4],
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
        }
    }
}

/// Which surfaces of the scene a draw of [`Geometry::Surfaces`] shows.
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
    /// Pulled by index, with the shader of the draw: instance and triangle are known.
    Pulled,
    /// As [`SurfaceStyle::Pulled`], with the materials bound: surfaces of which parts may not be there.
    PulledMasked,
}

impl SurfaceStyle {
    /// Whether vertices are pulled by index.
    pub fn is_pulled(self) -> bool {
        matches!(self, Self::Pulled | Self::PulledMasked)
    }
}

/// What a draw draws.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// Parts of the scene's own meshes, with their materials.
    Surfaces {
        /// Which shading.
        style: SurfaceStyle,
        /// (instance, part) in drawing order.
        parts: Vec<(u32, u32)>,
        /// Vertices in all, for the plan's text.
        vertices: u64,
    },
    /// Indices into one instance's vertex positions, read by the shader from binding 0 of group 1.
    Indexed {
        /// The instance whose mesh the positions are of.
        instance: u32,
        /// The index buffer.
        indices: SlotId,
        /// The first index.
        first: u32,
        /// The number of indices.
        count: u32,
        /// The shader's `instance_index`.
        record: u32,
    },
    /// Indices of which the shader makes vertices by itself, from what the draw binds.
    Listed {
        /// The index buffer.
        indices: SlotId,
        /// The first index.
        first: u32,
        /// The number of indices.
        count: u32,
        /// The shader's `instance_index`.
        record: u32,
    },
    /// Vertices that the shader makes up.
    Procedural {
        /// The number of vertices.
        vertices: u32,
        /// The number of instances.
        instances: u32,
    },
}

/// What a shader reads from group 1, in addition to what its geometry brings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binding {
    /// `var<storage, read>`.
    Storage(SlotId),
    /// `texture_2d<f32>` (`texture_depth_2d` for a depth format, `texture_2d<u32>` for whole numbers) over layer 0;
    /// `texture_multisampled_2d` and `texture_depth_multisampled_2d` for a slot of several samples.
    Texture(SlotId),
    /// `texture_2d_array<f32>` over all layers.
    TextureArray(SlotId),
    /// `texture_2d_array<f32>` over one layer, which the shader sees as layer 0.
    TextureLayer(SlotId, u32),
    /// `texture_2d<u32>` over the stencil aspect; `texture_multisampled_2d<u32>` for a slot of several samples.
    StencilOf(SlotId),
}

impl Binding {
    /// The slot that is read.
    pub fn slot(&self) -> SlotId {
        match self {
            Self::Storage(slot)
            | Self::Texture(slot)
            | Self::TextureArray(slot)
            | Self::TextureLayer(slot, _)
            | Self::StencilOf(slot) => *slot,
        }
    }
}

/// One draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// What it is called in the plan's text.
    pub name: String,
    /// The shader; `None` for surfaces in the engine's own styles.
    pub shader: Option<Shader>,
    /// The state.
    pub state: DrawState,
    /// The geometry.
    pub geometry: Geometry,
    /// What the shader reads, as (binding number in group 1, what).
    pub bindings: Vec<(u32, Binding)>,
    /// The pixels it is confined to: x, y, width, height; `None` for all.
    pub scissor_px: Option<[u32; 4]>,
}

impl Draw {
    /// The number of vertices the draw processes.
    pub fn vertices(&self) -> u64 {
        match &self.geometry {
            Geometry::Surfaces { vertices, .. } => *vertices,
            Geometry::Indexed { count, .. } | Geometry::Listed { count, .. } => u64::from(*count),
            Geometry::Procedural { vertices, instances } => u64::from(*vertices) * u64::from(*instances),
        }
    }
}

/// A frame as plain data.
#[derive(Clone, Debug, PartialEq)]
pub struct FramePlan {
    /// Width and height of what is drawn into, in pixels; the picture has half of each with
    /// [`Antialias::Supersample4`].
    pub size_px: [u32; 2],
    /// How edges are smoothed.
    pub antialias: Antialias,
    /// Textures and buffers.
    pub slots: Vec<Slot>,
    /// Passes, in order.
    pub passes: Vec<Pass>,
    /// One entry for each light of the posed scene.
    pub lights: Vec<LightPlanned>,
    /// The slot with the finished picture.
    pub picture: SlotId,
    /// The slot with (instance, triangle) of every pixel, when asked for.
    pub visible_triangles: Option<SlotId>,
    /// How many layers of transparent surfaces are drawn apart, nearest first, because shadows fall on them; an upper
    /// bound on those of any pixel.
    pub layers: u32,
    /// The slots with (instance, triangle) of the layers whose factors were asked for: nearest first.
    pub layer_triangles: Vec<SlotId>,
    /// The pixels (x and y from, x and y to before) outside of which every visibility counts as 1, whatever it holds.
    pub shadowed_px: [u32; 4],
    /// What was left out, and why.
    pub notes: Vec<String>,
}

impl FramePlan {
    /// The slot behind `id`.
    pub fn slot(&self, id: SlotId) -> &Slot {
        &self.slots[id.0]
    }

    /// Width and height of the picture, in pixels.
    pub fn picture_size_px(&self) -> [u32; 2] {
        match self.slot(self.picture).kind {
            SlotKind::Texture { size_px, .. } => size_px,
            SlotKind::Buffer { .. } | SlotKind::Image { .. } => self.size_px,
        }
    }

    /// The bytes of all slots.
    pub fn bytes(&self) -> u64 {
        self.slots.iter().map(Slot::bytes).sum()
    }

    /// The passes whose name begins with `prefix`.
    pub fn passes_named<'a>(&'a self, prefix: &'a str) -> impl Iterator<Item = &'a Pass> {
        self.passes.iter().filter(move |pass| pass.name.starts_with(prefix))
    }
}
