//! The document that the kinds of files are changes of, and their table.

use serde_json::{Value, json};
use shadowgraph_engine::gltf;

use Expect::{Loads, Notes, Refused};

/// What a file must come to.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Expect {
    /// It loads without a word.
    Loads,
    /// It loads, with a warning or remark that says this.
    Notes(&'static str),
    /// It is refused with these words.
    Refused(&'static str),
}

pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) document: Value,
    pub(crate) expect: Expect,
}

impl Row {
    /// The document with a value at each of the paths; appended at `/-`, taken out by `null`.
    pub(crate) fn new(name: &'static str, changes: &[(&str, Value)], expect: Expect) -> Self {
        let mut document = document();
        for (path, value) in changes {
            let (parent, key) = path.rsplit_once('/').unwrap();
            let parent = document.pointer_mut(parent).unwrap_or_else(|| panic!("{name}: no {path}"));
            match parent {
                Value::Array(values) if key == "-" => values.push(value.clone()),
                Value::Array(values) => values[key.parse::<usize>().unwrap()] = value.clone(),
                Value::Object(object) if value.is_null() => drop(object.remove(key)),
                object => object[key] = value.clone(),
            }
        }
        Self { name, document, expect }
    }
}

/// Checks every row, and names all that are not as expected.
#[track_caller]
pub(crate) fn check(rows: Vec<Row>) {
    let mut wrong = Vec::new();
    assert!(!rows.is_empty());
    for Row { name, document, expect } in rows {
        let loaded = gltf::load_slice(document.to_string().as_bytes(), None);
        if let Some(problem) = judge(expect, &loaded) {
            wrong.push(format!("{name}: {problem}"));
        }
    }
    assert!(wrong.is_empty(), "{} kinds:\n{}", wrong.len(), wrong.join("\n"));
}

/// What is wrong with what came of a file, if anything.
pub(crate) fn judge(expect: Expect, loaded: &Result<gltf::Loaded, gltf::GltfError>) -> Option<String> {
    match (expect, loaded) {
        (Loads, Ok(loaded)) if loaded.warnings.is_empty() && loaded.remarks.is_empty() => None,
        (Notes(text), Ok(loaded))
            if loaded.warnings.iter().chain(&loaded.remarks).any(|n| n.contains(text)) =>
        {
            None
        }
        (Refused(text), Err(error)) if error.to_string().contains(text) => None,
        (expect, Ok(loaded)) => {
            Some(format!("{expect:?}, but it loaded: {:?} {:?}", loaded.warnings, loaded.remarks))
        }
        (expect, Err(error)) => Some(format!("{expect:?}, but: {error}")),
    }
}

/// Rows of changes: a name, values at paths, and what must come of it.
macro_rules! rows {
    ($($name:literal { $($path:literal = $value:tt),* } $expect:expr;)*) => {
        vec![$($crate::kinds::Row::new($name, &[$(($path, json!($value))),*], $expect)),*]
    };
}

pub(crate) use rows;

/// Base64 of bytes, padded.
pub(crate) fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits =
            group.iter().fold(0_u32, |bits, byte| bits << 8 | u32::from(*byte)) << (8 * (3 - group.len()));
        for i in 0..4 {
            let letter = char::from(LETTERS[(bits >> (18 - 6 * i) & 63) as usize]);
            text.push(if i > group.len() { '=' } else { letter });
        }
    }
    text
}

fn encoded(format: image::ImageFormat) -> String {
    let picture = image::RgbaImage::from_pixel(2, 2, image::Rgba([200, 100, 50, 255]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    format!("data:{};base64,{}", format.to_mime_type(), base64(bytes.get_ref()))
}

/// A textured square, a square bent by two joints, a lamp, an eye, a shadow node and an animation.
pub(crate) fn document() -> Value {
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let mut identity = [0.0; 16];
    [0, 5, 10, 15].iter().for_each(|i| identity[*i] = 1.0);
    let parts: [(usize, Vec<u8>); 9] = [
        (34962, floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0])),
        (34962, floats(&[0.0, 0.0, 1.0].repeat(4))),
        (34962, floats(&[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0])),
        (0, floats(&[0.0, 1.0, 2.0])),
        // Two triangles, and two bytes more.
        (34963, vec![0, 1, 2, 0, 2, 3, 0, 0, 0, 0, 0, 0]),
        (34962, [0, 1, 0, 0].repeat(4)),
        (34962, floats(&[0.5, 0.5, 0.0, 0.0].repeat(4))),
        (0, [vec![1, 2, 3, 0], floats(&[0.0; 6]), floats(&identity.repeat(2))].concat()),
        (0, floats(&[-1.0, 0.0, 0.0, 0.0])),
    ];
    let (mut bin, mut views) = (Vec::new(), Vec::new());
    for (target, bytes) in parts {
        let mut view = json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len() });
        if target != 0 {
            view["target"] = target.into();
        }
        views.push(view);
        bin.extend(bytes);
    }
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual", "SHADOWGRAPH_shadow_node"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 9 }] } },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2, 3, 4] }],
        "nodes": [
            { "name": "square", "mesh": 0 },
            { "name": "flag", "mesh": 1, "skin": 0 },
            { "name": "lamp", "translation": [0, 0, 5], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "name": "eye", "camera": 0, "extensions": { "SHADOWGRAPH_shadow_node": { "type": "Any", "lights": [2] } } },
            { "name": "lower", "children": [5] },
            { "name": "upper" }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1, "zfar": 10 } }],
        "meshes": [
            { "name": "square", "primitives": [{
                "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 }, "indices": 4, "material": 0 }] },
            { "name": "flag", "primitives": [{ "attributes": { "POSITION": 0, "JOINTS_0": 5, "WEIGHTS_0": 6 }, "indices": 4 }] }],
        "materials": [{ "name": "wood", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "samplers": [{ "wrapS": 33071, "magFilter": 9728 }],
        "images": [{ "name": "grain", "uri": encoded(image::ImageFormat::Png) }, { "uri": encoded(image::ImageFormat::WebP) }],
        "skins": [{ "joints": [4, 5] }],
        "animations": [{
            "channels": [{ "sampler": 0, "target": { "node": 5, "path": "translation" } }],
            "samplers": [{ "input": 3, "output": 8 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": 3, "componentType": 5126, "count": 3, "type": "SCALAR", "min": [0], "max": [2] },
            { "bufferView": 4, "componentType": 5121, "count": 6, "type": "SCALAR" },
            { "bufferView": 5, "componentType": 5121, "count": 4, "type": "VEC4" },
            { "bufferView": 6, "componentType": 5126, "count": 4, "type": "VEC4" },
            { "bufferView": 7, "byteOffset": 28, "componentType": 5126, "count": 2, "type": "MAT4" },
            { "componentType": 5126, "count": 3, "type": "VEC3" }],
        "bufferViews": views,
        "buffers": [{ "byteLength": bin.len(), "uri": format!("data:application/octet-stream;base64,{}", base64(&bin)) }],
    })
}

/// Bytes written as hexadecimal digits.
pub(crate) fn bytes_of(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect()
}

/// A document whose only mesh has packed positions and indices, made by the format's own reference encoder.
pub(crate) fn packed() -> Value {
    let positions = "a000000700ffff8080ffffff8080ffffff8080ffff000000ffff808005383e0f837e7f7e7f7e7fe00000007e00000100300c03\
                     ffff8001003008007e000000010003c0007e7d0000000000000000000000000000000000000000000000000000000000000000";
    let triangles =
        "e1fe1e100e100e100ece1e160e150e140ece1e140e140e140eff0f0aff00250e007687566778a9866589689801690000";
    let [positions, triangles] = [positions, triangles].map(|text| bytes_of(&text.replace([' ', '\n'], "")));
    let whole = [positions.clone(), triangles.clone()].concat();
    let view = |offset: usize, packed: &[u8], stride: usize, count: usize, mode: &str| {
        json!({ "buffer": 1, "byteLength": stride * count, "extensions": { "EXT_meshopt_compression": {
            "buffer": 0, "byteOffset": offset, "byteLength": packed.len(), "byteStride": stride, "count": count,
            "mode": mode } } })
    };
    json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "extensionsUsed": ["EXT_meshopt_compression"], "extensionsRequired": ["EXT_meshopt_compression"],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 20, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 75, "type": "SCALAR" }],
        "bufferViews": [
            view(0, &positions, 12, 20, "ATTRIBUTES"), view(positions.len(), &triangles, 2, 75, "TRIANGLES")],
        // The second is where those who cannot unpack would look.
        "buffers": [{ "byteLength": whole.len(), "uri": format!("data:application/octet-stream;base64,{}", base64(&whole)) },
            { "byteLength": 390, "extensions": { "EXT_meshopt_compression": { "fallback": true } } }],
    })
}
