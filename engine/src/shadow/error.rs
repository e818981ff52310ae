//! Why shadows were refused.

use thiserror::Error;
use wgpu::TextureFormat;

use super::OptionError;
use crate::plan::{PlanError, ShaderError};

/// Why a shadow node, or the frame it stands in, was refused. Nothing is drawn in its place.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum ShadowError {
    #[error("shadow node '{node}': unknown type '{technique}' (known: {known})")]
    UnknownTechnique { node: String, technique: String, known: String },
    #[error("shadow node '{node}': {source}")]
    Option { node: String, source: OptionError },
    #[error("shadow node '{node}' ({technique}) refuses caster '{caster}': {reason}")]
    CasterRefused { node: String, technique: &'static str, caster: String, reason: String },
    #[error("shadow node '{node}' ({technique}) refuses receiver '{receiver}': it {reason}")]
    ReceiverRefused { node: String, technique: &'static str, receiver: String, reason: String },
    #[error(
        "light '{light}': caster '{caster}' is claimed by '{first}' ({first_technique}) and by '{second}' ({second_technique}); one light may have each caster from one technique only"
    )]
    ClaimedTwice {
        light: String,
        caster: String,
        first: String,
        first_technique: &'static str,
        second: String,
        second_technique: &'static str,
    },
    #[error(
        "light '{light}': caster '{caster}' is claimed by '{first}' ({first_options}) and by '{second}' ({second_options}); one light may have each caster with one set of options only"
    )]
    OptionsDiffer {
        light: String,
        caster: String,
        first: String,
        first_options: String,
        second: String,
        second_options: String,
    },
    #[error(
        "'{first}' darkens the finished picture by {first_weight} and '{second}' by {second_weight}; there is one darkening, with one weight"
    )]
    WeightsDiffer { first: String, first_weight: f64, second: String, second_weight: f64 },
    #[error(
        "light '{light}' is served by '{darkening}', which darkens the finished picture, and by '{other}', which takes away the light itself; one light may have one of the two"
    )]
    DarkenedTwice { light: String, darkening: String, other: String },
    #[error(
        "light '{light}' is served by '{once}', which darkens the finished picture once for all lights, and by '{apart}', which darkens it by itself; one light may have one of the two"
    )]
    DarkeningsDiffer { light: String, once: String, apart: String },
    #[error(
        "the shadow nodes of light '{light}' weight or colour their shadows on a layer of transparent surfaces otherwise than on opaque ones; accepted is the same on all"
    )]
    LayersDiffer { light: String },
    #[error("shadow node '{node}' ({technique}) needs {needed}, which adapter '{adapter}' does not have")]
    MissingFeature { node: String, technique: &'static str, needed: String, adapter: String },
    #[error("shadow node '{node}' ({technique}): {reason}")]
    Unsupported { node: String, technique: &'static str, reason: String },
    #[error(
        "shadow node '{node}' ({technique}) computes one factor for each fragment, in {format:?}; antialias msaa4 needs one for each sample (accepted for it: antialias none, ssaa4)"
    )]
    NotPerSample { node: String, technique: &'static str, format: TextureFormat },
    #[error(transparent)]
    Shader(#[from] ShaderError),
    #[error("the frame plan is not valid: {0}")]
    Plan(#[from] PlanError),
}
