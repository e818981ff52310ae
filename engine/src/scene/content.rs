//! What a node can hold: meshes, lights, cameras and shadow nodes.

use std::collections::BTreeMap;
use std::fmt;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use super::{CameraKey, LightKey, MaterialKey, MeshKey, NodeKey, ShadowKey, SkinKey};
use crate::math::Projection;

/// The one thing a node holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Content {
    /// Nothing but its children.
    #[default]
    Group,
    /// A mesh with its materials.
    Mesh(MeshNode),
    /// A light; it shines along the node's −z axis.
    Light(LightKey),
    /// A camera; it looks along the node's −z axis with +y up.
    Camera(CameraKey),
    /// A shadow node.
    Shadow(ShadowKey),
}

/// Whether a mesh casts and receives shadows at all, whatever the shadow nodes say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShadowFlags {
    /// The mesh may cast.
    pub casts: bool,
    /// Shadows may fall on the mesh; otherwise its factor is 1.
    pub receives: bool,
}

impl Default for ShadowFlags {
    fn default() -> Self {
        Self { casts: true, receives: true }
    }
}

/// A mesh at a node. Many nodes may share one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshNode {
    /// The shape.
    pub mesh: MeshKey,
    /// One material for each material slot of the mesh's parts; slots beyond the end wear the default material.
    pub materials: Vec<MaterialKey>,
    /// Whether it casts and receives.
    pub shadow: ShadowFlags,
    /// The joints that move it, for a mesh with influences. The node's own transform is then ignored.
    pub skin: Option<SkinKey>,
    /// The weights of the mesh's morph targets; empty for the weights that the mesh itself has.
    pub weights: Vec<f64>,
}

impl MeshNode {
    /// A mesh that casts and receives, all in one material.
    pub fn new(mesh: MeshKey, material: MaterialKey) -> Self {
        Self::in_materials(mesh, vec![material])
    }

    /// A mesh that casts and receives, in these materials.
    pub fn in_materials(mesh: MeshKey, materials: Vec<MaterialKey>) -> Self {
        Self { mesh, materials, shadow: ShadowFlags::default(), skin: None, weights: Vec::new() }
    }
}

/// The three kinds of `KHR_lights_punctual`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light along the node's −z axis; intensity in lux.
    Directional,
    /// Light from the node's origin in every direction; intensity in candela.
    Point,
    /// Light from the node's origin within a cone around −z; intensity in candela.
    Spot {
        /// Full intensity within this angle from the axis, in radians.
        inner_rad: f64,
        /// No light beyond this angle from the axis, in radians (0 < inner ≤ outer ≤ π/2).
        outer_rad: f64,
    },
}

/// A light source.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Its name; pictures and tables of the light are called after it.
    pub name: String,
    /// What it is.
    pub kind: LightKind,
    /// Linear colour.
    pub color: Vec3,
    /// Intensity: lux (directional) or candela (point and spot).
    pub intensity: f32,
    /// The distance beyond which it lights nothing, in metres; `None` for no limit. Directional lights have no range.
    pub range_m: Option<f64>,
    /// Whether it may cast shadows at all, whatever the shadow nodes say.
    pub casts_shadows: bool,
}

impl Light {
    fn of(name: &str, kind: LightKind, intensity: f32) -> Self {
        Self { name: name.into(), kind, color: Vec3::ONE, intensity, range_m: None, casts_shadows: true }
    }

    /// A white directional light of `lux`.
    pub fn directional(name: &str, lux: f32) -> Self {
        Self::of(name, LightKind::Directional, lux)
    }

    /// A white point light of `candela`.
    pub fn point(name: &str, candela: f32) -> Self {
        Self::of(name, LightKind::Point, candela)
    }

    /// A white spot light of `candela` whose cone opens `outer_rad` to each side, the outer fifth of it soft.
    pub fn spot(name: &str, candela: f32, outer_rad: f64) -> Self {
        Self::of(name, LightKind::Spot { inner_rad: outer_rad * 0.8, outer_rad }, candela)
    }

    /// The same light in another linear colour.
    #[must_use]
    pub fn with_color(mut self, color: Vec3) -> Self {
        self.color = color;
        self
    }

    /// The same light, ending at `range_m` metres.
    #[must_use]
    pub fn with_range(mut self, range_m: f64) -> Self {
        self.range_m = Some(range_m);
        self
    }
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Its name, for choosing it.
    pub name: String,
    /// How it projects.
    pub projection: Projection,
}

impl Camera {
    /// A perspective camera with near plane at 0.1 m and no far plane.
    pub fn perspective(name: &str, fov_y_rad: f64) -> Self {
        Self { name: name.into(), projection: Projection::Perspective { fov_y_rad, near_m: 0.1 } }
    }
}

/// The transform of something that stands at `eye`, looks at `target` along −z and keeps y up as far as it can.
pub fn look_at(eye: DVec3, target: DVec3) -> DAffine3 {
    let back = (eye - target).try_normalize().unwrap_or(DVec3::Z);
    let side = DVec3::Y.cross(back).try_normalize().unwrap_or(DVec3::X);
    DAffine3::from_mat3_translation(DMat3::from_cols(side, back.cross(side), back), eye)
}

/// A transform from translation, rotation and scale.
pub fn placed(translation: DVec3, rotation: DQuat, scale: DVec3) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}

/// Which nodes a shadow node is about.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Scope {
    /// All that the scene has.
    #[default]
    All,
    /// These nodes and everything under them.
    Nodes(Vec<NodeKey>),
}

/// The value of one option of a shadow node.
#[derive(Clone, Debug, PartialEq)]
pub enum ParamValue {
    /// A word.
    Text(String),
    /// A number.
    Number(f64),
    /// Yes or no.
    Flag(bool),
    /// Several numbers, a colour say.
    Numbers(Vec<f64>),
}

impl fmt::Display for ParamValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Number(number) => number.fmt(f),
            Self::Flag(flag) => flag.fmt(f),
            Self::Numbers(numbers) => write!(f, "{numbers:?}"),
        }
    }
}

/// The options of a shadow node, by their camelCase names; what is left out has its default.
pub type Params = BTreeMap<String, ParamValue>;

/// A shadow node: which technique, with which options, from which lights, casters and receivers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowNode {
    /// The technique's type name, as registered in the catalog.
    pub technique: String,
    /// The options.
    pub params: Params,
    /// The lights it shadows.
    pub lights: Scope,
    /// What casts.
    pub casters: Scope,
    /// What receives, for techniques that shade named receivers only.
    pub receivers: Scope,
}

impl ShadowNode {
    /// A node of `technique` with default options, over all lights and meshes.
    pub fn new(technique: impl Into<String>) -> Self {
        Self { technique: technique.into(), ..Self::default() }
    }

    /// The same node with one option set.
    #[must_use]
    pub fn with_param(mut self, name: &str, value: ParamValue) -> Self {
        self.params.insert(name.into(), value);
        self
    }

    /// The same node for these lights only.
    #[must_use]
    pub fn with_lights(mut self, nodes: impl IntoIterator<Item = NodeKey>) -> Self {
        self.lights = Scope::Nodes(nodes.into_iter().collect());
        self
    }

    /// The same node with these casters (and what is under them) only.
    #[must_use]
    pub fn with_casters(mut self, nodes: impl IntoIterator<Item = NodeKey>) -> Self {
        self.casters = Scope::Nodes(nodes.into_iter().collect());
        self
    }

    /// The same node with these receivers (and what is under them) only.
    #[must_use]
    pub fn with_receivers(mut self, nodes: impl IntoIterator<Item = NodeKey>) -> Self {
        self.receivers = Scope::Nodes(nodes.into_iter().collect());
        self
    }
}
