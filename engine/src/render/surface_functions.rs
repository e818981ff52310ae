//! Materials that reflect light by a surface function of their own: what a frame refuses, and what its plan says of them.

use std::collections::BTreeMap;

use super::request::FrameError;
use super::surfaces::Surfaces;
use crate::plan::{FactorAt, LightPlanned};
use crate::scene::SceneSnapshot;

/// Refuses the frame for any material whose surface function cannot be, seen or not: an error that came and went with
/// the camera would be hard to find.
pub(super) fn check(snapshot: &SceneSnapshot) -> Result<(), FrameError> {
    for material in snapshot.instances.iter().flat_map(|instance| &instance.materials) {
        let Some(function) = &material.surface else { continue };
        let name = || material.name.clone();
        function.check().map_err(|source| FrameError::SurfaceFunction { material: name(), source })?;
        if material.unlit {
            let function = function.name().into();
            return Err(FrameError::UnlitFunction { material: name(), function });
        }
    }
    Ok(())
}

/// How many of the frame's surfaces each function reflects light from; by name.
fn used(snapshot: &SceneSnapshot, surfaces: &Surfaces) -> BTreeMap<String, usize> {
    let mut used = BTreeMap::new();
    for (instance, part) in surfaces.opaque.iter().chain(&surfaces.blended) {
        let material = &snapshot.instances[*instance as usize].materials[*part as usize];
        if let Some(function) = &material.surface {
            *used.entry(function.name().to_owned()).or_default() += 1;
        }
    }
    used
}

/// What the shading pass says of them; empty without any.
pub(super) fn reason(snapshot: &SceneSnapshot, surfaces: &Surfaces) -> String {
    let used = used(snapshot, surfaces);
    used.iter().map(|(name, parts)| format!("; {parts} parts reflect by their own '{name}'")).collect()
}

/// The lights whose shadow they do not get to see.
pub(super) fn notes(snapshot: &SceneSnapshot, surfaces: &Surfaces, lights: &[LightPlanned]) -> Vec<String> {
    if used(snapshot, surfaces).is_empty() {
        return vec![];
    }
    let darkening = lights.iter().filter(|light| light.factor == FactorAt::Darkening);
    let note = |light: &LightPlanned| {
        format!(
            "surface functions see light '{}' unshadowed: its shadow darkens the finished picture",
            light.name
        )
    };
    darkening.map(note).collect()
}
