//! The hard cases: the small scenes on which shadow techniques have always broken, each with its right answer.
//!
//! [`all`] lists every case; a [`CaseEntry`] is cheap, and [`CaseEntry::build`] makes its scenes. One id may have
//! several variants (both facings of a quad, several lights' positions, a shift by node or baked into the vertices).
//!
//! Every scene carries one shadow node to be tried, with default options over all lights and meshes (but
//! for those of nodes beside it, where a case is about several; [`Cast`] says which techniques they have), and a camera placed so that the failure would be *seen*. What is right is said twice: [`Expect`] for the frame as a
//! whole, and [`Probe`]s, single surface points whose light or darkness was worked out by hand. The probes keep the
//! reference honest too, since nothing in them was computed by it.
//!
//! Floors cast like everything else: a technique that cannot bear an open quad under every scene should not pass.

mod beside;
mod counts;
mod eyes;
mod found;
mod glass;
mod horizons;
mod lights;
mod many;
mod maps;
mod masks;
mod moving;
mod planar;
mod repairs;
mod rooms;
mod samples;
mod soft;
mod stage;
mod stretched;
pub mod strewn;
pub mod sweeps;
mod table;
mod ties;
mod topology;
mod touching_glass;
mod transforms;

use shadowgraph_engine::plan::Antialias;
use shadowgraph_engine::render::FrameRequest;
use shadowgraph_engine::scene::{CameraSnapshot, Params, Scene};
use shadowgraph_engine::shadow::{OptionError, ShadowTechnique, TechniqueEntry};

use shadowgraph_engine::shadow::receivers_for;
use stage::Stage;

pub use table::all;

/// What a technique must produce for a case that it takes.
#[derive(Clone, Debug, PartialEq)]
pub enum Expect {
    /// The reference's factor, and at least one visible pixel is dark and one lit for every light.
    Shadow,
    /// The reference's factor, and no visible pixel is dark.
    NoShadow,
    /// The reference's factor, whatever it is.
    Matches,
    /// A typed error, never a picture.
    Refused {
        /// What the technique cannot do.
        why: &'static str,
    },
}

/// Which casters a case is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// Casters of every kind.
    Anything,
    /// Transparent ones: techniques through which they cast nothing leave them to others.
    Glass,
}

/// The techniques in the cases' scenes, by type name. [`Case::scene_with`] replaces the one that is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cast {
    /// The technique of the node that is there to be tried.
    pub tried: &'static str,
    /// The technique of nodes beside it that give a light a size, by the option `radius`.
    pub sized: &'static str,
}

impl Cast {
    /// Nobody: for scenes that are looked at without shadows, or into which a technique is put before they are drawn.
    pub const NOBODY: Self = Self { tried: "nobody", sized: "nobody" };
}

/// A visible surface point whose factor was worked out without a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// The point, on an opaque surface that the camera sees, well inside its shadow or light.
    pub p_in_world: glam::DVec3,
    /// The light's name.
    pub light: String,
    /// The light's factor there, red, green and blue: 1 lit, 0 dark.
    pub factor: [f32; 3],
}

/// One scene of a hard case.
#[derive(Clone, Debug)]
pub struct Case {
    /// The case's id.
    pub id: &'static str,
    /// Which of the case's scenes this is; empty when there is only one.
    pub variant: String,
    /// What breaks in techniques that get it wrong.
    pub what_breaks: &'static str,
    /// The scene. Of its shadow nodes the first is the one that techniques are put into; others stay what they are.
    pub scene: Scene,
    /// The camera that sees the problem.
    pub camera: CameraSnapshot,
    /// The frame's size.
    pub size_px: [u32; 2],
    /// How its edges are smoothed.
    pub antialias: Antialias,
    /// Options that belong to the case and not to a technique's quality, a light's radius say.
    pub options: Params,
    /// Which casters it is about.
    pub about: About,
    /// What is right for the whole frame.
    pub expect: Expect,
    /// What is right at single points.
    pub probes: Vec<Probe>,
    /// Whether it takes a software adapter half a minute and more with some techniques: a step of a sweep.
    pub is_heavy: bool,
}

impl Case {
    /// The id and the variant: a name no other case has.
    pub fn name(&self) -> String {
        if self.variant.is_empty() { self.id.into() } else { format!("{}/{}", self.id, self.variant) }
    }

    /// Whether the casters that the case is about cast nothing through this technique, by design.
    pub fn is_left_out_by(&self, technique: &dyn ShadowTechnique) -> bool {
        self.about == About::Glass && !technique.traits().casts_transparent
    }

    /// The frame to ask for.
    pub fn request(&self) -> FrameRequest {
        FrameRequest { antialias: self.antialias, ..FrameRequest::new(self.camera.clone(), self.size_px) }
    }

    /// `params` of a technique and those of the case's own options that it has; without the latter where it does not accept
    /// them beside `params` (texels of a texture, where nothing is kept in one).
    pub fn params_with(&self, technique: &TechniqueEntry, params: &Params) -> Params {
        let known = (technique.options)();
        let own = self.options.iter().filter(|(name, _)| known.find(name).is_some());
        let own = own.map(|(name, value)| (name.clone(), value.clone()));
        let with_own = params.clone().into_iter().chain(own).collect();
        if (technique.from_params)(&with_own).is_ok() { with_own } else { params.clone() }
    }

    /// The scene with another technique in its first shadow node, with [these](Self::params_with) params.
    ///
    /// # Errors
    /// What the technique does not accept.
    pub fn scene_with(&self, technique: &TechniqueEntry, params: &Params) -> Result<Scene, OptionError> {
        let made = (technique.from_params)(params)?;
        let params = self.params_with(technique, params);
        let mut scene = self.scene.clone();
        let receivers =
            scene.snapshot().map(|snapshot| receivers_for(&snapshot, made.as_ref())).unwrap_or_default();
        let tried = scene.shadows().next().map(|(key, _)| key);
        if let Some(node) = tried.and_then(|key| scene.shadow_mut(key)) {
            node.technique = technique.type_name.into();
            node.params = params;
            node.receivers = receivers;
        }
        Ok(scene)
    }
}

/// A row of the table.
#[derive(Clone, Debug)]
pub struct CaseEntry {
    /// The id, as listed in the documentation.
    pub id: &'static str,
    /// What breaks.
    pub what_breaks: &'static str,
    /// What the exact reference says.
    pub right_answer: &'static str,
    /// Which casters it is about.
    pub about: About,
    stages: fn() -> Vec<Stage>,
}

impl CaseEntry {
    /// Makes the case's scenes.
    pub fn build(&self, cast: &Cast) -> Vec<Case> {
        let case = |stage: Stage| stage.into_case(self.id, self.what_breaks, self.about, cast);
        (self.stages)().into_iter().map(case).collect()
    }
}
