//! Collecting shadow nodes and regrouping them by light, since passes run once for each light and not for each node.

use std::collections::HashMap;
use std::sync::Arc;

use super::{Catalog, Layers, LightSize, ShadowError, ShadowTechnique};
use crate::scene::{Params, SceneSnapshot, ShadowNodeSnapshot};

/// What one node casts for one light.
#[derive(Clone, Debug)]
pub struct Claim {
    /// The node's name.
    pub node: String,
    /// Its technique.
    pub technique: Arc<dyn ShadowTechnique>,
    /// The technique's type name.
    pub type_name: &'static str,
    /// The technique's type name, followed by every option that is not at its default.
    pub label: String,
    /// Indices into [`SceneSnapshot::instances`], ascending; none is claimed twice for the same light.
    pub casters: Vec<usize>,
    /// Indices into [`SceneSnapshot::instances`], ascending.
    pub receivers: Vec<usize>,
}

impl Claim {
    /// How large the technique takes the light to be; its part of the factor is compared with that of such a light.
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
            let label = label(catalog, type_name, technique.as_ref());
            let mut claim = Claim {
                node: node.name.clone(),
                technique,
                type_name,
                label,
                casters: Vec::new(),
                receivers: node.receivers.clone(),
            };
            registry.choose_casters(snapshot, node, &mut claim)?;
            check_receivers(snapshot, &claim)?;
            for &light in &node.lights {
                registry.claim(snapshot, light, &claim, &mut taken[light])?;
            }
        }
        Ok(registry)
    }

    /// Chooses the node's casters that its technique takes, and notes the others.
    fn choose_casters(
        &mut self,
        snapshot: &SceneSnapshot,
        node: &ShadowNodeSnapshot,
        claim: &mut Claim,
    ) -> Result<(), ShadowError> {
        let technique = claim.type_name;
        for &index in &node.casters {
            let instance = &snapshot.instances[index];
            let casts = claim.technique.casts(instance).map_err(|reason| ShadowError::CasterRefused {
                node: node.name.clone(),
                technique,
                caster: instance.name.clone(),
                reason,
            })?;
            if casts {
                claim.casters.push(index);
            } else {
                self.notes.push(format!(
                    "'{}' casts nothing through '{}': {technique} leaves surfaces of its kind to other techniques",
                    instance.name, node.name
                ));
            }
        }
        Ok(())
    }

    /// Adds a node's claim to one light, with the casters that no node has claimed before.
    fn claim(
        &mut self,
        snapshot: &SceneSnapshot,
        light: usize,
        claim: &Claim,
        taken: &mut HashMap<usize, usize>,
    ) -> Result<(), ShadowError> {
        let claims = &mut self.lights[light];
        let mut own = Vec::new();
        for &caster in &claim.casters {
            match taken.get(&caster).map(|first| &claims[*first]) {
                None => own.push(caster),
                // Named twice, counted once.
                Some(first) if first.label == claim.label => {}
                Some(first) => {
                    let light = snapshot.lights[light].name.clone();
                    return Err(claimed_twice(light, snapshot.instances[caster].name.clone(), first, claim));
                }
            }
        }
        taken.extend(own.iter().map(|caster| (*caster, claims.len())));
        claims.push(Claim { casters: own, ..claim.clone() });
        Ok(())
    }

    /// The transparent surfaces on which shadows of `light` fall.
    pub fn receiver_layers(&self, light: usize) -> Layers {
        self.lights[light]
            .iter()
            .map(|claim| claim.technique.traits().receiver_layers)
            .max()
            .unwrap_or_default()
    }
}

/// Refuses receivers that a technique which shades named ones only cannot shade.
fn check_receivers(snapshot: &SceneSnapshot, claim: &Claim) -> Result<(), ShadowError> {
    let named = claim.receivers.iter().filter(|_| claim.technique.traits().shades_receivers_only);
    for instance in named.map(|index| &snapshot.instances[*index]) {
        claim.technique.receives(instance).map_err(|reason| ShadowError::ReceiverRefused {
            node: claim.node.clone(),
            technique: claim.type_name,
            receiver: instance.name.clone(),
            reason,
        })?;
    }
    Ok(())
}

/// The error of a caster that two nodes claim for one light, through two techniques or with two sets of options.
fn claimed_twice(light: String, caster: String, first: &Claim, second: &Claim) -> ShadowError {
    if first.type_name == second.type_name {
        ShadowError::OptionsDiffer {
            light,
            caster,
            first: first.node.clone(),
            first_options: first.label.clone(),
            second: second.node.clone(),
            second_options: second.label.clone(),
        }
    } else {
        ShadowError::ClaimedTwice {
            light,
            caster,
            first: first.node.clone(),
            first_technique: first.type_name,
            second: second.node.clone(),
            second_technique: second.type_name,
        }
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
