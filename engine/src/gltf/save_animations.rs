//! Writing skins and animations.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use glam::DMat4;
use serde_json::{Map, Value, json};

use super::GltfError;
use super::save_meshes::Binary;
use crate::scene::{Animation, Interpolation, NodeKey, Property, Skin, Track};

/// The glTF skin; bind matrices become f32, as glTF has them.
pub(super) fn skin(
    skin: &Skin,
    index_of: &BTreeMap<NodeKey, usize>,
    binary: &mut Binary,
) -> Result<Value, GltfError> {
    let joints: Option<Vec<usize>> = skin.joints.iter().map(|joint| index_of.get(joint).copied()).collect();
    let joints = joints.ok_or_else(|| GltfError::Save {
        what: format!("skin '{}'", skin.name),
        problem: "has joints that are no longer in the scene".into(),
    })?;
    let mut value = json!({ "joints": joints });
    if !skin.name.is_empty() {
        value["name"] = skin.name.as_str().into();
    }
    if !skin.joint_from_mesh.is_empty() {
        let columns =
            skin.joint_from_mesh.iter().map(|bind| DMat4::from(*bind).to_cols_array().map(|x| x as f32));
        value["inverseBindMatrices"] = binary.add_floats("MAT4", columns, None).into();
    }
    Ok(value)
}

/// The glTF animation; `None` for one without channels, which glTF does not have.
pub(super) fn animation(
    animation: &Animation,
    index_of: &BTreeMap<NodeKey, usize>,
    binary: &mut Binary,
) -> Option<Value> {
    let mut samplers: Vec<Value> = Vec::new();
    let mut written: HashMap<*const Track, usize> = HashMap::new();
    let mut times: HashMap<Vec<u32>, usize> = HashMap::new();
    let mut channels = Vec::new();
    for channel in &animation.channels {
        let Some(node) = index_of.get(&channel.node) else { continue };
        let track = &channel.track;
        let sampler = *written.entry(Arc::as_ptr(track)).or_insert_with(|| {
            // Clips key many properties at the same times.
            let bits = track.times_s().iter().map(|time| time.to_bits()).collect();
            let input = *times.entry(bits).or_insert_with(|| add_times(track.times_s(), binary));
            samplers.push(json!({
                "input": input, "output": add_values(track, binary),
                "interpolation": match track.interpolation() {
                    Interpolation::Step => "STEP",
                    Interpolation::Linear => "LINEAR",
                    Interpolation::CubicSpline => "CUBICSPLINE",
                },
            }));
            samplers.len() - 1
        });
        let path = match track.property() {
            Property::Translation => "translation",
            Property::Rotation => "rotation",
            Property::Scale => "scale",
            Property::Weights => "weights",
        };
        channels.push(json!({ "sampler": sampler, "target": { "node": node, "path": path } }));
    }
    let mut value = Map::new();
    value.insert("name".into(), animation.name.as_str().into());
    value.insert("samplers".into(), samplers.into());
    value.insert("channels".into(), channels.clone().into());
    (!channels.is_empty()).then_some(value.into())
}

fn add_times(times_s: &[f32], binary: &mut Binary) -> usize {
    let accessor = binary.add_floats("SCALAR", times_s.iter().map(|time| [*time]), None);
    binary.accessors[accessor]["min"] = json!([times_s.first()]);
    binary.accessors[accessor]["max"] = json!([times_s.last()]);
    accessor
}

fn add_values(track: &Track, binary: &mut Binary) -> usize {
    fn grouped<const N: usize>(values: &[f32]) -> impl Iterator<Item = [f32; N]> {
        values.as_chunks::<N>().0.iter().copied()
    }
    match track.property() {
        Property::Translation | Property::Scale => {
            binary.add_floats("VEC3", grouped::<3>(track.values()), None)
        }
        Property::Rotation => binary.add_floats("VEC4", grouped::<4>(track.values()), None),
        Property::Weights => binary.add_floats("SCALAR", grouped::<1>(track.values()), None),
    }
}
