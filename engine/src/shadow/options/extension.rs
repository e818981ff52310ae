//! The JSON schema of the glTF extension: what every shadow node has, and what each technique's options accept.

use serde_json::{Map, Value, json};

use crate::shadow::Catalog;

/// The JSON schema of `SHADOWGRAPH_shadow_node` for the techniques of `catalog`. Nodes of other types may have any
/// options.
pub fn extension_schema(catalog: &Catalog) -> Value {
    let mut definitions =
        Map::from_iter([("nodes".to_owned(), nodes()), ("params".to_owned(), any_params())]);
    let mut rules = Vec::new();
    for entry in catalog.entries() {
        let mut options = (entry.options)().schema;
        options["description"] = entry.summary.into();
        definitions.insert(entry.type_name.to_owned(), options);
        rules.push(json!({
            "if": { "properties": { "type": { "const": entry.type_name } } },
            "then": { "properties": { "params": { "$ref": format!("#/$defs/{}", entry.type_name) } } },
        }));
    }
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "SHADOWGRAPH_shadow_node.schema.json",
        "title": "SHADOWGRAPH_shadow_node glTF node extension",
        "description": "Makes a glTF node a shadow node: one technique that computes the shadows of some lights by some \
            casters. The extension belongs in extensionsUsed and never needs to be in extensionsRequired.",
        "type": "object",
        "properties": {
            "type": {
                "description": "The technique, by its registered type name.",
                "type": "string",
                "minLength": 1,
            },
            "lights": {
                "description": "Nodes whose subtrees hold the lights it shadows, each with at least one light. Left out: every light.",
                "$ref": "#/$defs/nodes",
            },
            "casters": {
                "description": "Nodes whose subtrees cast, each with at least one mesh. Left out: every mesh.",
                "$ref": "#/$defs/nodes",
            },
            "receivers": {
                "description": "Nodes whose subtrees receive, each with at least one mesh. Left out: every mesh.",
                "$ref": "#/$defs/nodes",
            },
            "params": { "$ref": "#/$defs/params" },
            "extensions": { "type": "object" },
            "extras": {},
        },
        "required": ["type"],
        "additionalProperties": false,
        "allOf": rules,
        "$defs": definitions,
    })
}

/// Indices of glTF nodes.
fn nodes() -> Value {
    json!({
        "type": "array",
        "items": { "description": "The index of a node of the loaded scene.", "type": "integer", "minimum": 0 },
    })
}

/// Options of any technique.
fn any_params() -> Value {
    json!({
        "description": "The technique's options by their camelCase names; what is left out has its default.",
        "type": "object",
        "additionalProperties": {
            "oneOf": [
                { "type": "string" },
                { "type": "number" },
                { "type": "boolean" },
                { "type": "array", "items": { "type": "number" } },
            ],
        },
    })
}
