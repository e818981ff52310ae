//! `EXT_mesh_gpu_instancing`: one mesh at many places. Each instance becomes a node under the one that names them, and
//! all of them share the mesh, on the GPU too.

use glam::{DQuat, DVec3};

use super::GltfError;
use super::accessors::{Accessors, Integers};
use super::fields::Item;
use super::limits::Budget;
use super::nodes::Builder;
use super::transforms::check_reach;
use crate::scene::{Content, NodeKey, Transform};

/// The extension's name.
pub(super) const GPU_INSTANCING: &str = "EXT_mesh_gpu_instancing";

impl Builder<'_> {
    /// Puts a node's mesh at each of its instances, and says whether it has any.
    pub(super) fn spread(&mut self, node: &Item<'_>, key: NodeKey) -> Result<bool, GltfError> {
        if node.extension(GPU_INSTANCING).is_none() {
            return Ok(false);
        }
        let content = self.scene.node(key).map(|node| node.content.clone());
        let Some(Content::Mesh(mesh)) = content else {
            self.warnings.add(format!("{}: instances of a node without a mesh are ignored", node.label()));
            return Ok(false);
        };
        if node.get("skin").is_some() {
            self.warnings.add(format!("{}: instances of a skinned mesh are ignored", node.label()));
            return Ok(false);
        }
        let Some(places) = read(node, &self.accessors, &mut self.budget)? else {
            self.warnings.add(format!(
                "{}: its instances have no TRANSLATION, ROTATION or SCALE; the mesh is shown once",
                node.label()
            ));
            return Ok(false);
        };
        if let Some(added) = self.scene.node_mut(key) {
            added.content = Content::Group;
        }
        let name = node.name().map_or_else(|| node.label(), str::to_owned);
        for (index, place) in places.into_iter().enumerate() {
            let name = format!("{name}[{index}]");
            check_reach(&place.matrix())
                .map_err(|problem| GltfError::Transform { node: name.clone(), problem })?;
            self.scene.add(Some(key), &name, place.matrix(), Content::Mesh(mesh.clone()));
        }
        Ok(true)
    }
}

/// The places of a node's instances relative to it; `None` where the extension names none, but attributes of a program
/// of its own.
fn read(
    node: &Item<'_>,
    accessors: &Accessors<'_>,
    budget: &mut Budget,
) -> Result<Option<Vec<Transform>>, GltfError> {
    let Some(value) = node.extension(GPU_INSTANCING) else { return Ok(None) };
    let wrong =
        |problem: String| GltfError::Content { item: format!("the instances of {}", node.label()), problem };
    let attributes = value.get("attributes").filter(|attributes| attributes.is_object());
    let attributes = attributes.ok_or_else(|| wrong("'attributes' must be a JSON object".into()))?;
    if attributes.as_object().is_some_and(serde_json::Map::is_empty) {
        return Err(wrong("TRANSLATION, ROTATION or SCALE is needed".into()));
    }
    let named = |name: &str| {
        let Some(value) = attributes.get(name).filter(|value| !value.is_null()) else { return Ok(None) };
        let index = value.as_u64().and_then(|index| usize::try_from(index).ok());
        index.map(Some).ok_or_else(|| wrong(format!("'{name}' must be the index of an accessor")))
    };
    let [translations, rotations, scales] = ["TRANSLATION", "ROTATION", "SCALE"].map(named);
    let translations =
        translations?.map(|index| accessors.floats::<3>(index, "TRANSLATION", Integers::AsDeclared, budget));
    let translations = translations.transpose()?;
    let rotations =
        rotations?.map(|index| accessors.floats::<4>(index, "ROTATION", Integers::Normalized, budget));
    let rotations = rotations.transpose()?;
    let scales = scales?.map(|index| accessors.floats::<3>(index, "SCALE", Integers::AsDeclared, budget));
    let scales = scales.transpose()?;

    let counts = [
        translations.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
    ];
    let Some(count) = counts.into_iter().flatten().next() else { return Ok(None) };
    if let Some(other) = counts.into_iter().flatten().find(|other| *other != count) {
        return Err(wrong(format!("their attributes have {count} and {other} entries; as many are needed")));
    }
    budget.charge_instances(count as u64)?;
    let wide = |values: [f32; 3]| DVec3::from(values.map(f64::from));
    let place = |index: usize| {
        let rotation =
            rotations.as_ref().map_or(DQuat::IDENTITY, |all| DQuat::from_array(all[index].map(f64::from)));
        let length = rotation.length();
        if !(length > 0.0 && length.is_finite()) {
            return Err(wrong(format!("instance {index} has a rotation without direction")));
        }
        Ok(Transform {
            translation: translations.as_ref().map_or(DVec3::ZERO, |all| wide(all[index])),
            rotation: rotation.normalize(),
            scale: scales.as_ref().map_or(DVec3::ONE, |all| wide(all[index])),
        })
    };
    (0..count).map(place).collect::<Result<_, _>>().map(Some)
}
