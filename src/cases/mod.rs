//! The hard cases: the small scenes on which shadow techniques have always broken, each with its right answer.
//!
//! [`all`] lists every case; a [`CaseEntry`] is cheap, and [`CaseEntry::build`] makes its scenes. One id may have
//! several variants (both facings of a quad, several lights' positions, a shift by node or baked into the vertices).
//!
//! Every scene carries one shadow node to be tried, `ShadowVolumeHard` with default options over all lights and meshes (but
//! for those of nodes beside it, where a case is about several), and a camera placed so that the failure would be *seen*. What is right is said twice: [`Expect`] for the frame as a
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
pub mod sweeps;
mod table;
mod ties;
mod topology;
mod touching_glass;
mod transforms;

use shadowgraph_engine::manager::FrameRequest;
use shadowgraph_engine::plan::Antialias;
use shadowgraph_engine::scene::{Params, PosedCamera, Scene};
use shadowgraph_engine::shadow::{OptionError, TechniqueEntry};

use crate::receivers_for;
use stage::Stage;

pub use table::all;

/// What a technique that claims a case must produce.
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

/// What a technique says about a case, before it is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The reference's factor: what every technique owes that a row does not name.
    Exact,
    /// Something close to it. The bound is the technique's own; tests hold it to that.
    Approximates {
        /// Why not exactly.
        why: &'static str,
    },
    /// A typed error, never a picture.
    Refuses {
        /// What the technique cannot do.
        why: &'static str,
    },
    /// What the case is about casts nothing through this technique, by design; the reference's factor for what does.
    LeavesOut {
        /// What it leaves to others.
        why: &'static str,
    },
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
    pub camera: PosedCamera,
    /// The frame's size.
    pub size_px: [u32; 2],
    /// How its edges are smoothed.
    pub antialias: Antialias,
    /// Options that belong to the case and not to a technique's quality, a light's radius say.
    pub options: Params,
    /// What single techniques say about it, by type name; the others owe the exact answer.
    pub answers: &'static [(&'static str, Answer)],
    /// What is right for the whole frame.
    pub expect: Expect,
    /// What is right at single points.
    pub probes: Vec<Probe>,
}

impl Case {
    /// The id and the variant: a name no other case has.
    pub fn name(&self) -> String {
        if self.variant.is_empty() { self.id.into() } else { format!("{}/{}", self.id, self.variant) }
    }

    /// What the technique of this type name says about the case.
    pub fn answer(&self, technique: &str) -> Answer {
        self.answers.iter().find(|(name, _)| *name == technique).map_or(Answer::Exact, |(_, answer)| *answer)
    }

    /// The frame to ask for.
    pub fn request(&self) -> FrameRequest {
        FrameRequest { antialias: self.antialias, ..FrameRequest::new(self.camera.clone(), self.size_px) }
    }

    /// The scene with another technique in its first shadow node: with `params`, and with those of the case's own options
    /// that the technique has.
    ///
    /// # Errors
    /// What the technique does not accept.
    pub fn scene_with(&self, technique: &TechniqueEntry, params: &Params) -> Result<Scene, OptionError> {
        let made = (technique.from_params)(params)?;
        let known = (technique.options)();
        let own = self.options.iter().filter(|(name, _)| known.find(name).is_some());
        let own = own.map(|(name, value)| (name.clone(), value.clone()));
        let params: Params = params.clone().into_iter().chain(own).collect();
        let mut scene = self.scene.clone();
        let receivers = scene.pose().map(|posed| receivers_for(&posed, made.as_ref())).unwrap_or_default();
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
    /// What must exist before the case can be built; empty for cases that build.
    pub needs: &'static str,
    /// What single techniques say about it, by type name; the others owe the exact answer.
    pub answers: &'static [(&'static str, Answer)],
    stages: fn() -> Vec<Stage>,
}

impl CaseEntry {
    /// Makes the case's scenes; none while [`CaseEntry::needs`] is not met.
    pub fn build(&self) -> Vec<Case> {
        (self.stages)()
            .into_iter()
            .map(|stage| stage.into_case(self.id, self.what_breaks, self.answers))
            .collect()
    }
}
