//! `SHADOWGRAPH_shadow_node`: shadow nodes as extensions of glTF nodes.
//!
//! ```json
//! { "type": "Technique", "lights": [3], "casters": [5, 9], "receivers": [2], "params": { "option": "value" } }
//! ```
//!
//! Lights, casters and receivers are glTF node indices and stand for their subtrees; left out, they mean all.

use std::collections::BTreeMap;

use serde_json::Value;

use super::GltfError;
use crate::scene::{NodeKey, ParamValue, Params, Scope, ShadowNode};

/// The extension's name.
pub const SHADOW_NODE: &str = "SHADOWGRAPH_shadow_node";

/// Checks the types and options of the shadow nodes that are loaded.
pub trait ShadowTypes {
    /// Checks that the node's technique exists and takes its parameters.
    ///
    /// # Errors
    /// A sentence that names what is wrong and what is accepted.
    fn check(&self, node: &ShadowNode) -> Result<(), String>;
}

/// The lists of the extension, and what a node in them must have in its subtree.
const LISTS: [&str; 3] = ["lights", "casters", "receivers"];

/// What a shadow node's lists are checked against: by glTF node index.
#[derive(Debug)]
pub(super) struct Targets<'a> {
    /// The scene's node, for glTF nodes that are in the scene.
    pub(super) keys: &'a [Option<NodeKey>],
    /// Whether the subtree has a light.
    pub(super) lights: &'a [bool],
    /// Whether the subtree has a mesh.
    pub(super) meshes: &'a [bool],
}

/// Reads the extension's object, found at the glTF node called `node` in errors.
pub(super) fn read(node: &str, value: &Value, targets: &Targets<'_>) -> Result<ShadowNode, GltfError> {
    let wrong = |problem: String| GltfError::ShadowNode { node: node.into(), problem };
    let object = value.as_object().ok_or_else(|| wrong("it must be a JSON object".into()))?;
    let accepted =
        |key: &str| matches!(key, "type" | "params" | "extras" | "extensions") || LISTS.contains(&key);
    if let Some(key) = object.keys().find(|key| !accepted(key)) {
        let known = "type, lights, casters, receivers and params are accepted";
        return Err(wrong(format!("unknown key '{key}' ({known})")));
    }
    let technique = object.get("type").and_then(Value::as_str).filter(|name| !name.is_empty());
    let technique = technique.ok_or_else(|| wrong("'type' must name a technique".into()))?;
    let mut params = Params::new();
    if let Some(values) = object.get("params") {
        let values = values.as_object().ok_or_else(|| wrong("'params' must be a JSON object".into()))?;
        for (name, value) in values {
            let accepted = "a word, a number, true, false or an array of numbers";
            let value = param(value).ok_or_else(|| wrong(format!("param '{name}' must be {accepted}")))?;
            params.insert(name.clone(), value);
        }
    }
    let scope = |list| match object.get(list) {
        None => Ok(Scope::All),
        Some(value) => nodes(node, list, value, targets).map(Scope::Nodes),
    };
    let [lights, casters, receivers] = LISTS;
    Ok(ShadowNode {
        technique: technique.into(),
        params,
        lights: scope(lights)?,
        casters: scope(casters)?,
        receivers: scope(receivers)?,
    })
}

/// The nodes of one list, each checked for being in the scene and having what the list is about.
fn nodes(
    node: &str,
    list: &'static str,
    value: &Value,
    targets: &Targets<'_>,
) -> Result<Vec<NodeKey>, GltfError> {
    let wrong = |problem: String| GltfError::ShadowNode { node: node.into(), problem };
    let values =
        value.as_array().ok_or_else(|| wrong(format!("'{list}' must be an array of node indices")))?;
    let (has, what) = if list == "lights" { (targets.lights, "light") } else { (targets.meshes, "mesh") };
    let mut keys = Vec::with_capacity(values.len());
    for value in values {
        let target = value.as_u64();
        let target =
            target.ok_or_else(|| wrong(format!("'{list}' must hold node indices, not {}", brief(value))))?;
        let refused = |problem: String| GltfError::ShadowTarget { node: node.into(), list, target, problem };
        let index = usize::try_from(target).ok().filter(|index| *index < targets.keys.len());
        let index = index.ok_or_else(|| {
            refused(format!("but the file has {} nodes (counted from 0)", targets.keys.len()))
        })?;
        let key = targets.keys[index].ok_or_else(|| {
            refused("which is not in the loaded scene (nodes of that scene are accepted)".into())
        })?;
        if !has[index] {
            return Err(refused(format!(
                "which has no {what} in or under it (nodes with a {what} are accepted)"
            )));
        }
        keys.push(key);
    }
    Ok(keys)
}

fn brief(value: &Value) -> String {
    value.to_string().chars().take(40).collect()
}

fn param(value: &Value) -> Option<ParamValue> {
    let is_numbers = |items: &[Value]| items.iter().all(Value::is_number);
    match value {
        Value::String(_) | Value::Number(_) | Value::Bool(_) => Some(value.into()),
        Value::Array(items) if is_numbers(items) => Some(value.into()),
        Value::Array(_) | Value::Null | Value::Object(_) => None,
    }
}

/// The extension's object for a shadow node of the scene, whose nodes have the glTF indices of `index_of`.
pub(super) fn write(
    node: &str,
    shadow: &ShadowNode,
    index_of: &BTreeMap<NodeKey, usize>,
) -> Result<Value, GltfError> {
    let wrong = |problem: String| GltfError::Save { what: format!("shadow node '{node}'"), problem };
    let mut object = serde_json::Map::new();
    object.insert("type".into(), shadow.technique.as_str().into());
    for (list, scope) in LISTS.into_iter().zip([&shadow.lights, &shadow.casters, &shadow.receivers]) {
        let Scope::Nodes(keys) = scope else { continue };
        let indices: Option<Vec<usize>> = keys.iter().map(|key| index_of.get(key).copied()).collect();
        let indices = indices.ok_or_else(|| wrong(format!("has {list} that are no longer in the scene")))?;
        object.insert(list.into(), indices.into());
    }
    let finite = |number: f64| {
        serde_json::Number::from_f64(number)
            .map(Value::Number)
            .ok_or_else(|| wrong("has a parameter that is not finite".into()))
    };
    let mut params = serde_json::Map::new();
    for (name, value) in &shadow.params {
        let value = match value {
            ParamValue::Text(text) => Value::String(text.clone()),
            ParamValue::Flag(flag) => Value::Bool(*flag),
            ParamValue::Number(number) => finite(*number)?,
            ParamValue::Numbers(numbers) => {
                Value::Array(numbers.iter().map(|number| finite(*number)).collect::<Result<_, _>>()?)
            }
        };
        params.insert(name.clone(), value);
    }
    if !params.is_empty() {
        object.insert("params".into(), params.into());
    }
    Ok(object.into())
}
