//! What fields of one thing must fit together.

use std::f64::consts::FRAC_PI_4;

use serde_json::{Map, Value};

use super::document::Section;

/// Takes what does not fit.
type Odd<'a> = &'a mut dyn FnMut(&str);

/// Compares the fields of one thing of a section; `odd` takes what does not fit.
pub(super) fn check(section: Section, thing: &Map<String, Value>, odd: Odd<'_>) {
    match section {
        Section::Accessors => accessor(thing, odd),
        Section::BufferViews if whole(thing, "byteStride").is_some_and(|stride| stride % 4 != 0) => {
            odd("its byteStride is no multiple of 4");
        }
        Section::Buffers => uri(thing, false, odd),
        Section::Images => image(thing, odd),
        Section::Nodes => node(thing, odd),
        Section::Cameras => camera(thing, odd),
        Section::Lights => light(thing, odd),
        _ => {}
    }
}

fn has(thing: &Map<String, Value>, field: &str) -> bool {
    thing.get(field).is_some_and(|value| !value.is_null())
}

fn whole(thing: &Map<String, Value>, field: &str) -> Option<u64> {
    thing.get(field).and_then(Value::as_u64)
}

fn number(value: &Value, field: &str) -> Option<f64> {
    value.get(field).and_then(Value::as_f64)
}

fn accessor(thing: &Map<String, Value>, odd: Odd<'_>) {
    if has(thing, "byteOffset") && !has(thing, "bufferView") {
        odd("it has a byteOffset, but no bufferView");
    }
    let component = whole(thing, "componentType");
    let size = match component {
        Some(5120 | 5121) => 1,
        Some(5122 | 5123) => 2,
        _ => 4,
    };
    if whole(thing, "byteOffset").is_some_and(|offset| offset % size != 0) {
        odd("its byteOffset is no multiple of its components' size");
    }
    if thing.get("normalized") == Some(&Value::Bool(true)) && matches!(component, Some(5125 | 5126)) {
        odd("components of this type cannot be normalized");
    }
}

/// The media type of a data URI.
fn uri(thing: &Map<String, Value>, of_image: bool, odd: Odd<'_>) {
    let uri = thing.get("uri").and_then(Value::as_str);
    if let Some(problem) = uri.and_then(|uri| super::uri::problem(uri, of_image)) {
        odd(&problem);
    }
}

fn image(thing: &Map<String, Value>, odd: Odd<'_>) {
    uri(thing, true, odd);
    match (has(thing, "uri"), has(thing, "bufferView")) {
        (true, true) => odd("it has a uri and a bufferView; the bufferView is taken"),
        (false, false) => odd("it has neither uri nor bufferView"),
        (false, true) if !has(thing, "mimeType") => odd("it has a bufferView, but no mimeType"),
        _ => {}
    }
}

fn node(thing: &Map<String, Value>, odd: Odd<'_>) {
    if has(thing, "matrix") && ["translation", "rotation", "scale"].iter().any(|part| has(thing, part)) {
        odd("its transform is given twice");
    }
    for field in ["skin", "weights"] {
        if has(thing, field) && !has(thing, "mesh") {
            odd(&format!("it has {field}, but no mesh"));
        }
    }
    let rotation = thing.get("rotation").and_then(Value::as_array);
    let squares = rotation.map(|all| all.iter().filter_map(Value::as_f64).map(|x| x * x).sum::<f64>());
    if squares.is_some_and(|squares| (squares - 1.0).abs() > 1e-3) {
        odd("its rotation has not length 1, and is brought to it");
    }
    if thing.get("matrix").is_some_and(shears) {
        odd("its matrix is no translation, rotation and scale");
    }
}

/// Whether a matrix is none that translation, rotation and scale make.
fn shears(matrix: &Value) -> bool {
    let Some(all) = matrix.as_array().filter(|all| all.len() == 16) else { return false };
    let column =
        |i: usize| glam::DVec3::from_array([0, 1, 2].map(|j| all[i * 4 + j].as_f64().unwrap_or(0.0)));
    let [x, y, z] = [0, 1, 2].map(column);
    [(x, y), (y, z), (z, x)].iter().any(|(a, b)| a.dot(*b).abs() > 1e-3 * a.length() * b.length())
        || x.cross(y).dot(z) == 0.0
}

fn camera(thing: &Map<String, Value>, odd: Odd<'_>) {
    let kinds = ["perspective", "orthographic"];
    if !kinds.iter().any(|kind| has(thing, kind)) {
        odd("it has neither perspective nor orthographic");
    } else if kinds.iter().all(|kind| has(thing, kind)) {
        odd("it has both perspective and orthographic");
    }
    for lens in kinds.iter().filter_map(|kind| thing.get(*kind)) {
        if number(lens, "zfar").zip(number(lens, "znear")).is_some_and(|(far, near)| far <= near) {
            odd("its zfar is not beyond its znear");
        }
        if ["xmag", "ymag"].iter().any(|field| number(lens, field) == Some(0.0)) {
            odd("its xmag or ymag is 0");
        }
    }
}

fn light(thing: &Map<String, Value>, odd: Odd<'_>) {
    let is_spot = thing.get("type").and_then(Value::as_str) == Some("spot");
    match thing.get("spot") {
        None if is_spot => odd("it is a spot without 'spot'"),
        Some(cone) => {
            let outer = number(cone, "outerConeAngle").unwrap_or(FRAC_PI_4);
            if number(cone, "innerConeAngle").unwrap_or(0.0) >= outer {
                odd("its inner cone is not within its outer cone");
            }
        }
        None => {}
    }
}
