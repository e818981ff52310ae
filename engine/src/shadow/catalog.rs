//! The technique trait, and the catalog that finds techniques by the names scenes use.

use std::fmt;
use std::sync::Arc;

use super::{Contribution, LightContext, LightSize, OptionError, OptionTable, PassList, ShadowError};
use crate::scene::{Instance, Params, ShadowNode};

/// The transparent surfaces at a pixel for which a technique wants its light's factor, beside the opaque surface. Of
/// several techniques of one light the one that wants most decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Layers {
    /// None: transparent surfaces are lit without shadows.
    #[default]
    OpaqueOnly,
    /// The nearest; those behind it are lit without shadows.
    First,
    /// All of them.
    All,
}

/// One of the transparent surfaces at a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layer {
    /// The n-th from the eye; 0 is the nearest.
    FromEye(u32),
    /// The n-th from behind of those that are not the nearest; 0 is the farthest.
    FromBehind(u32),
}

/// What holds for a technique with its options in every scene. The default is a technique for lights without size
/// that takes opaque casters and opaque receivers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traits {
    /// The error that the technique has by design, in one sentence.
    pub known_error: &'static str,
    /// How large the technique takes its lights to be. Its factors are compared with those of such lights.
    pub light_size: LightSize,
    /// The number of [`light_samples`](super::light_samples) of which its factor is the visible share, if it is one:
    /// it is then compared sample by sample. `None` for techniques that approximate the whole light.
    pub light_samples: Option<u32>,
    /// Whether its factors come near the right ones and no more: what is then off is no mistake, as long as `known_error` tells of it.
    pub approximates: bool,
    /// Whether its casters' transparent surfaces cast too, in the colours that they let pass
    /// ([`Material::transmission_at`](crate::scene::Material::transmission_at)); otherwise they cast nothing.
    pub casts_transparent: bool,
    /// The transparent surfaces on which its shadows fall. [`ShadowTechnique::plan`] is called once more for each of
    /// these layers.
    pub receiver_layers: Layers,
    /// Whether it shades only the receivers that its node names. Elsewhere its factor is 1 and is not compared.
    pub shades_receivers_only: bool,
    /// Whether every draw of its into the visibility asks for each texel by itself, at `place_px` of `common/frame`, and
    /// its shaders are composed with [`View::sample_flags`](super::View::sample_flags). With four samples a pixel it is then
    /// asked for every sample, and without that refused.
    pub asks_each_sample: bool,
}

/// A way to compute shadows.
///
/// Implementations hold their options and nothing else. What persists between frames lives in the
/// [`Cache`](super::Cache) and in the plan's slots, so a technique leaves no state for its successor. Its names are
/// in its [`TechniqueEntry`].
pub trait ShadowTechnique: fmt::Debug + Send + Sync {
    /// All options with their values.
    fn params(&self) -> Params;

    /// What holds for it in every scene.
    fn traits(&self) -> Traits;

    /// Whether `instance` casts through this technique; `Ok(false)` leaves it to others.
    ///
    /// # Errors
    /// The reason why it would have to cast but cannot.
    fn casts(&self, instance: &Instance) -> Result<bool, String>;

    /// Whether `instance` can be a receiver; asked of techniques that shade receivers only.
    ///
    /// # Errors
    /// The reason why it cannot.
    fn receives(&self, _instance: &Instance) -> Result<(), String> {
        Ok(())
    }

    /// Adds the passes to `out` that leave the light's factor in the stencil or in its visibility, and returns what
    /// they leave. It requires a feature of the adapter through `light` only where it needs it, so that a frame asks
    /// for no more than it takes.
    ///
    /// # Errors
    /// What the technique refuses, naming node and caster.
    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError>;
}

/// A quality setting of a technique: options that reports and tests try beside its defaults.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// A short name that no other setting of the technique has.
    pub name: &'static str,
    /// What it is tried for, in one line.
    pub why: &'static str,
    /// The options; what is left out has its default.
    pub params: fn() -> Params,
}

impl Setting {
    /// Every option at its default: the one setting that every technique has.
    pub const DEFAULT: Self =
        Self { name: "default", why: "every option at its default", params: Params::new };
}

/// A technique as the catalog knows it.
#[derive(Clone, Copy, Debug)]
pub struct TechniqueEntry {
    /// The type name in scenes, `ShadowMap` say.
    pub type_name: &'static str,
    /// The short name on the command line, `map` say.
    pub short_name: &'static str,
    /// One line for help texts.
    pub summary: &'static str,
    /// Makes the technique from its options.
    pub from_params: fn(&Params) -> Result<Arc<dyn ShadowTechnique>, OptionError>,
    /// What its options accept.
    pub options: fn() -> OptionTable,
    /// Its quality settings beside the default.
    pub settings: &'static [Setting],
}

impl TechniqueEntry {
    /// The default, and then every setting of the technique.
    pub fn all_settings(&self) -> impl Iterator<Item = Setting> {
        std::iter::once(Setting::DEFAULT).chain(self.settings.iter().copied())
    }
}

/// The techniques a renderer knows.
#[derive(Clone, Debug, Default)]
pub struct Catalog {
    entries: Vec<TechniqueEntry>,
}

impl Catalog {
    /// A catalog without techniques.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a technique; one of the same type name is replaced.
    pub fn register(&mut self, entry: TechniqueEntry) {
        self.entries.retain(|known| known.type_name != entry.type_name);
        self.entries.push(entry);
    }

    /// Every technique, in the order of registration.
    pub fn entries(&self) -> &[TechniqueEntry] {
        &self.entries
    }

    /// The entry whose type name or short name is `name`.
    pub fn find(&self, name: &str) -> Option<&TechniqueEntry> {
        self.entries.iter().find(|entry| entry.type_name == name || entry.short_name == name)
    }

    /// Makes the technique that `shadow` asks for, and returns its type name with it; `node` names the node in
    /// errors.
    ///
    /// # Errors
    /// [`ShadowError::UnknownTechnique`] lists the known types; [`ShadowError::Option`] says what is accepted.
    pub fn technique(
        &self,
        node: &str,
        shadow: &ShadowNode,
    ) -> Result<(&'static str, Arc<dyn ShadowTechnique>), ShadowError> {
        let entry =
            self.entries.iter().find(|entry| entry.type_name == shadow.technique).ok_or_else(|| {
                let known: Vec<&str> = self.entries.iter().map(|entry| entry.type_name).collect();
                ShadowError::UnknownTechnique {
                    node: node.into(),
                    technique: shadow.technique.clone(),
                    known: known.join(", "),
                }
            })?;
        let technique = (entry.from_params)(&shadow.params)
            .map_err(|source| ShadowError::Option { node: node.into(), source })?;
        Ok((entry.type_name, technique))
    }
}
