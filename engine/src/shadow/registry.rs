//! Collecting shadow nodes and regrouping them by light, since passes run once for each light and not for each node.

use std::collections::HashMap;
use std::sync::Arc;

use super::{Catalog, Layers, LightSize, ShadowError, ShadowTechnique};
use crate::scene::{Params, SceneSnapshot};

/// What one node casts for one light.
#[derive(Clone, Debug)]
pub struct Claim {
    /// The node's name.
    pub node: String,
    /// Its technique.
    pub technique: Arc<dyn ShadowTechnique>,
    /// The technique's type name.
    pub type_name: &'static str,
    /// The technique's type name, and after it every option that is not at its default.
    pub label: String,
    /// Indices into [`SceneSnapshot::instances`], ascending; none is claimed twice for the same light.
    pub casters: Vec<usize>,
    /// Indices into [`SceneSnapshot::instances`], ascending.
    pub receivers: Vec<usize>,
}

impl Claim {
    /// How large the technique takes the light to be: what its part of the factor is compared with.
    pub fn light_size(&self) -> LightSize {
        self.technique.traits().light_size
    }
}

/// All claims of a scene, by light.
#[derive(Clone, Debug)]
pub struct Registry {
    /// One entry for each of [`SceneSnapshot::lights`]; empty where no node serves the light.
    pub lights: Vec<Vec<Claim>>,
    /// What was left out, and why.
    pub notes: Vec<String>,
}

impl Registry {
    /// Collects every shadow node of `snapshot`.
    ///
    /// # Errors
    /// Unknown techniques and options, refused casters, and casters that two techniques, or one with two sets of
    /// options, claim for one light.
    pub fn collect(snapshot: &SceneSnapshot, catalog: &Catalog) -> Result<Self, ShadowError> {
        let mut registry = Self { lights: vec![Vec::new(); snapshot.lights.len()], notes: Vec::new() };
        // For each light, which claim already has which caster.
        let mut taken: Vec<HashMap<usize, usize>> = vec![HashMap::new(); snapshot.lights.len()];
        for node in &snapshot.shadow_nodes {
            let (type_name, technique) = catalog.technique(&node.name, &node.shadow)?;
            let (label, traits) = (label(catalog, type_name, technique.as_ref()), technique.traits());
            let mut casters = Vec::new();
            for &index in &node.casters {
                let instance = &snapshot.instances[index];
                let casts = technique.casts(instance).map_err(|reason| ShadowError::CasterRefused {
                    node: node.name.clone(),
                    technique: type_name,
                    caster: instance.name.clone(),
                    reason,
                })?;
                if casts {
                    casters.push(index);
                } else {
                    registry.notes.push(format!(
                        "'{}' casts nothing through '{}': {type_name} leaves surfaces of its kind to other techniques",
                        instance.name, node.name
                    ));
                }
            }
            let named = node.receivers.iter().filter(|_| traits.shades_receivers_only);
            for instance in named.map(|index| &snapshot.instances[*index]) {
                technique.receives(instance).map_err(|reason| ShadowError::ReceiverRefused {
                    node: node.name.clone(),
                    technique: type_name,
                    receiver: instance.name.clone(),
                    reason,
                })?;
            }
            for &light in &node.lights {
                let claims = &mut registry.lights[light];
                let mut own = Vec::new();
                for &caster in &casters {
                    match taken[light].get(&caster) {
                        None => own.push(caster),
                        // Named twice, counted once.
                        Some(&first) if claims[first].label == label => {}
                        Some(&first) if claims[first].type_name == type_name => {
                            return Err(ShadowError::OptionsDiffer {
                                light: snapshot.lights[light].name.clone(),
                                caster: snapshot.instances[caster].name.clone(),
                                first: claims[first].node.clone(),
                                first_options: claims[first].label.clone(),
                                second: node.name.clone(),
                                second_options: label,
                            });
                        }
                        Some(&first) => {
                            return Err(ShadowError::ClaimedTwice {
                                light: snapshot.lights[light].name.clone(),
                                caster: snapshot.instances[caster].name.clone(),
                                first: claims[first].node.clone(),
                                first_technique: claims[first].type_name,
                                second: node.name.clone(),
                                second_technique: type_name,
                            });
                        }
                    }
                }
                taken[light].extend(own.iter().map(|caster| (*caster, claims.len())));
                claims.push(Claim {
                    node: node.name.clone(),
                    technique: Arc::clone(&technique),
                    type_name,
                    label: label.clone(),
                    casters: own,
                    receivers: node.receivers.clone(),
                });
            }
        }
        Ok(registry)
    }

    /// The casters of `light`, over all claims, ascending.
    pub fn casters_of(&self, light: usize) -> Vec<usize> {
        let mut casters: Vec<usize> =
            self.lights[light].iter().flat_map(|claim| claim.casters.clone()).collect();
        casters.sort_unstable();
        casters
    }

    /// The casters of `light` whose transparent surfaces cast too, ascending.
    pub fn transparent_casters_of(&self, light: usize) -> Vec<usize> {
        let claims = self.lights[light].iter().filter(|claim| claim.technique.traits().casts_transparent);
        let mut casters: Vec<usize> = claims.flat_map(|claim| claim.casters.clone()).collect();
        casters.sort_unstable();
        casters
    }

    /// On which transparent surfaces shadows of `light` fall.
    pub fn receiver_layers(&self, light: usize) -> Layers {
        self.lights[light]
            .iter()
            .map(|claim| claim.technique.traits().receiver_layers)
            .max()
            .unwrap_or_default()
    }
}

/// The technique's type name, and every option that differs from what an empty list of options gives.
fn label(catalog: &Catalog, name: &str, technique: &dyn ShadowTechnique) -> String {
    let default = catalog.find(name).and_then(|entry| (entry.from_params)(&Params::new()).ok());
    let default = default.map(|technique| technique.params()).unwrap_or_default();
    let options = technique.params().into_iter().filter(|(option, value)| default.get(option) != Some(value));
    let options: Vec<String> = options.map(|(option, value)| format!("{option}={value}")).collect();
    if options.is_empty() { name.into() } else { format!("{name} {}", options.join(" ")) }
}
