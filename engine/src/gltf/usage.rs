//! What must fit between things: accessors and their views, views and their buffers, meshes and what uses them.
//!
//! All of it is only remarked upon: whoever reads a thing refuses what does harm.

use std::collections::{HashMap, HashSet};

use serde_json::{Map, Value};

use super::accessors::element_bytes;
use super::buffers::whole;
use super::document::Document;
use super::limits::Warnings;

/// What a buffer view is used for.
#[derive(Debug, Default)]
struct Use {
    vertex_accessors: HashSet<usize>,
    indices: bool,
    other: Option<&'static str>,
}

/// Remarks on what does not fit.
pub(super) fn check(document: &Document, remarks: &mut Warnings) {
    accessors(document, remarks);
    for (index, view) in document.buffer_views.iter().enumerate() {
        let Some(view) = view.as_object() else { continue };
        let buffer = document.buffers.get(whole(view, "buffer") as usize).and_then(Value::as_object);
        let end = whole(view, "byteOffset").saturating_add(whole(view, "byteLength"));
        if let Some(buffer) = buffer.filter(|buffer| end > whole(buffer, "byteLength")) {
            let bytes = whole(buffer, "byteLength");
            remarks.add(format!("buffer view {index} ends at byte {end} of a buffer of {bytes}"));
        }
    }
    for (view, used) in uses(document, remarks) {
        let Some(declared) = document.buffer_views.get(view).and_then(Value::as_object) else { continue };
        let strided = declared.contains_key("byteStride");
        if strided && used.vertex_accessors.is_empty() {
            let what = used.other.unwrap_or("indices");
            remarks.add(format!("buffer view {view} has a byteStride, but holds {what}"));
        }
        if !strided && used.vertex_accessors.len() > 1 {
            remarks.add(format!("buffer view {view} holds several attributes, but has no byteStride"));
        }
        let target = whole(declared, "target");
        if (target == 34963 && !used.vertex_accessors.is_empty()) || (target == 34962 && used.indices) {
            remarks.add(format!("buffer view {view} is used otherwise than its target says"));
        }
        if used.indices && !used.vertex_accessors.is_empty() {
            remarks.add(format!("buffer view {view} holds vertices and indices"));
        }
    }
}

/// Whether accessors fit their views, used or not.
fn accessors(document: &Document, remarks: &mut Warnings) {
    for (index, accessor) in document.accessors.iter().enumerate() {
        let Some(accessor) = accessor.as_object() else { continue };
        let view = accessor.get("bufferView").and_then(Value::as_u64);
        let view = view.and_then(|view| document.buffer_views.get(view as usize)?.as_object());
        let (Some(view), Some((components, size))) = (view, element_bytes(accessor)) else { continue };
        let bytes = (components * size) as u64;
        let stride = view.get("byteStride").and_then(Value::as_u64).unwrap_or(bytes);
        if stride < bytes {
            remarks.add(format!("accessor {index} has elements of {bytes} bytes, {stride} bytes apart"));
        }
        let length = whole(accessor, "count").saturating_sub(1).saturating_mul(stride).saturating_add(bytes);
        if whole(accessor, "byteOffset").saturating_add(length) > whole(view, "byteLength") {
            remarks.add(format!("accessor {index} reaches beyond its buffer view"));
        }
        let offset = whole(view, "byteOffset").saturating_add(whole(accessor, "byteOffset"));
        if !offset.is_multiple_of(size as u64) {
            remarks.add(format!(
                "accessor {index} begins at byte {offset}, no multiple of its components' size"
            ));
        }
        let square = matches!(accessor.get("type").and_then(Value::as_str), Some("MAT2" | "MAT3"));
        if square && size < 4 {
            remarks.add(format!("accessor {index} has matrices of small numbers, whose columns glTF pads"));
        }
        if let Some(sparse) = accessor.get("sparse").and_then(Value::as_object)
            && whole(sparse, "count") > whole(accessor, "count")
        {
            remarks.add(format!("accessor {index} has more sparse values than values"));
        }
    }
}

/// What each buffer view is used for; remarks on what meshes name on the way.
fn uses(document: &Document, remarks: &mut Warnings) -> Vec<(usize, Use)> {
    let mut uses: HashMap<usize, Use> = HashMap::new();
    let view_of = |accessor: &Value| -> Option<(usize, usize)> {
        let accessor = accessor.as_u64()? as usize;
        let view = document.accessors.get(accessor)?.get("bufferView")?.as_u64()?;
        Some((accessor, view as usize))
    };
    let quantized = document.requires("KHR_mesh_quantization");
    for (mesh, value) in document.meshes.iter().enumerate() {
        let primitives = value.get("primitives").and_then(Value::as_array);
        for primitive in primitives.into_iter().flatten().filter_map(Value::as_object) {
            let attributes = primitive.get("attributes").and_then(Value::as_object);
            let targets = primitive.get("targets").and_then(Value::as_array);
            let targets = targets.into_iter().flatten().filter_map(Value::as_object);
            for (name, accessor) in attributes.into_iter().chain(targets.clone()).flatten() {
                if let Some((accessor, view)) = view_of(accessor) {
                    uses.entry(view).or_default().vertex_accessors.insert(accessor);
                }
                types(document, mesh, name, accessor, quantized, remarks);
            }
            if let Some((_, view)) = primitive.get("indices").and_then(view_of) {
                uses.entry(view).or_default().indices = true;
            }
            let has = |name: &str| attributes.is_some_and(|attributes| attributes.contains_key(name));
            if targets.flat_map(Map::keys).any(|name| !has(name)) {
                remarks.add(format!("mesh {mesh}: a morph target moves an attribute that the mesh lacks"));
            }
            texture_coordinates(document, mesh, primitive, &has, remarks);
        }
    }
    let samplers = document.animations.iter().filter_map(|animation| animation.get("samplers")?.as_array());
    for sampler in samplers.flatten() {
        for view in ["input", "output"].iter().filter_map(|field| Some(view_of(sampler.get(*field)?)?.1)) {
            uses.entry(view).or_default().other = Some("keys of an animation");
        }
    }
    for skin in &document.skins {
        if let Some((_, view)) = skin.get("inverseBindMatrices").and_then(view_of) {
            uses.entry(view).or_default().other = Some("bind matrices");
        }
    }
    for view in document.images.iter().filter_map(|image| image.get("bufferView")?.as_u64()) {
        uses.entry(view as usize).or_default().other = Some("an image");
    }
    let mut uses: Vec<(usize, Use)> = uses.into_iter().collect();
    uses.sort_by_key(|(view, _)| *view);
    uses
}

/// Whether an attribute's numbers are of a type that glTF has for it.
fn types(
    document: &Document,
    mesh: usize,
    name: &str,
    accessor: &Value,
    quantized: bool,
    remarks: &mut Warnings,
) {
    let accessor = accessor.as_u64().and_then(|index| document.accessors.get(index as usize));
    let component = accessor.and_then(|accessor| accessor.get("componentType")).and_then(Value::as_u64);
    match component {
        Some(5125) => {
            remarks.add(format!("mesh {mesh}: {name} has 32-bit integers, which no attribute may have"));
        }
        Some(5120..=5123) if matches!(name, "POSITION" | "NORMAL" | "TANGENT") && !quantized => {
            remarks
                .add(format!("mesh {mesh}: {name} has integers, but KHR_mesh_quantization is not required"));
        }
        _ => {}
    }
}

/// Whether a primitive has the texture coordinates that its material's textures want.
fn texture_coordinates(
    document: &Document,
    mesh: usize,
    primitive: &Map<String, Value>,
    has: &dyn Fn(&str) -> bool,
    remarks: &mut Warnings,
) {
    let material = primitive.get("material").and_then(Value::as_u64);
    let Some(material) = material.and_then(|index| document.materials.get(index as usize)) else { return };
    let slots = ["normalTexture", "occlusionTexture", "emissiveTexture"].map(|slot| material.get(slot));
    let pbr = material.get("pbrMetallicRoughness");
    let of_pbr =
        ["baseColorTexture", "metallicRoughnessTexture"].map(|slot| pbr.and_then(|pbr| pbr.get(slot)));
    for slot in slots.into_iter().chain(of_pbr).flatten() {
        let moved = slot.pointer("/extensions/KHR_texture_transform/texCoord");
        let set = moved.or(slot.get("texCoord")).map_or(Some(0), Value::as_u64).unwrap_or(0);
        let name = format!("TEXCOORD_{set}");
        if !has(&name) {
            remarks.add(format!("mesh {mesh}: its material wants {name}, which it lacks"));
        }
    }
}
