//! Surface functions that cannot be: the error names the function, the line in its own text, and what is accepted.

use std::sync::Arc;

use glam::{DAffine3, Vec2, Vec3};
use shadowgraph_engine::geometry::{Mesh, shapes};
use shadowgraph_engine::gltf;
use shadowgraph_engine::scene::{Material, Scene, SurfaceFunction, SurfaceFunctionError};

const PLAIN: &str = "fn reflected(surface: Surface, light: LightArriving) -> vec3f {
    return light.factor * light.irradiance * reflect_light(surface, light.towards_in_view);
}";

fn error(text: &str) -> SurfaceFunctionError {
    SurfaceFunction::new("mine", text).expect_err(text)
}

/// The error of `text` must be at `line` and name all of `names`.
#[track_caller]
fn refused(text: &str, line: usize, names: &[&str]) {
    let error = error(text).to_string();
    assert!(error.contains("'mine'") && error.contains(&format!("line {line}:")), "{error}");
    for name in names {
        assert!(error.contains(name), "'{name}' is not in: {error}");
    }
}

#[test]
fn what_is_right_is_taken() {
    SurfaceFunction::new("plain", PLAIN).unwrap();
    let more = "
        alias Tone = f32;
        const STEPS: Tone = 3.0;
        var<private> calls: u32;
        struct Ink { color: vec3f, position: vec3f }
        fn stepped(x: Tone) -> Tone { calls += 1u; return floor(x * STEPS) / STEPS; }
        fn reflected(at: Surface, arriving: LightArriving) -> vec3<f32> {
            let ink = Ink(at.base_color.rgb, at.p_in_world);
            var frame = fwidth(at.uv.x + at.pixel.x);
            return ink.color * stepped(arriving.factor.r) * frame;
        }
        fn outgoing(at: Surface, lights: vec3f, ambient: vec3f, emitted: vec3f) -> vec3f {
            return at.world_from_view * at.normal_in_view + lights + at.metallic + at.roughness;
        }";
    SurfaceFunction::new("more", more).unwrap();
}

#[test]
fn what_the_compiler_finds_is_told_with_the_line() {
    refused(
        "fn reflected(surface: Surface, light: LightArriving) -> vec3f {\n    return vec3f(1.0)\n}",
        3,
        &["`;`"],
    );
    refused(&PLAIN.replace("light.factor", "light.shadow"), 2, &["shadow"]);
    refused(&PLAIN.replace("light.factor *", "true *"), 2, &[]);
    refused(&format!("\n\n{PLAIN}\nfn more() -> f32 {{\n    return;\n}}"), 7, &[]);
    refused(&format!("{PLAIN}\n{PLAIN}"), 4, &["redefinition", "reflected"]);
    refused(&format!("{PLAIN}\n#if MASK"), 4, &[]);
    refused(&format!("{PLAIN}\nenable f16;"), 4, &[]);
    refused(&format!("{PLAIN}\n/* never closed"), 4, &[]);
    // What is left open.
    refused(&format!("{PLAIN}\n\nfn more(x: f32"), 5, &[]);
    // The engine's own variables are none of its business.
    refused(&PLAIN.replace("light.factor *", "frame.exposure *"), 2, &["frame"]);
}

#[test]
fn the_two_functions_are_as_documented() {
    for text in ["", "// nothing", "fn outgoing() {}", "const x = 1.0;"] {
        assert!(
            matches!(error(text), SurfaceFunctionError::Missing { wanted, .. } if wanted.contains("LightArriving"))
        );
    }
    for text in [
        "fn reflected() -> vec3f { return vec3f(); }",
        "\nfn reflected(light: LightArriving, surface: Surface) -> vec3f { return vec3f(); }",
        "fn reflected(surface: Surface, light: LightArriving) -> vec4f { return vec4f(); }",
        "fn reflected(surface: Surface, light: LightArriving) {}",
    ] {
        refused(
            text,
            1 + usize::from(text.starts_with('\n')),
            &["`reflected`", "fn reflected(surface: Surface"],
        );
    }
    refused(
        &format!("{PLAIN}\nfn outgoing(lights: vec3f) -> vec3f {{ return lights; }}"),
        4,
        &["fn outgoing(surface"],
    );
}

#[test]
fn names_of_the_engine_and_of_the_language_stay_what_they_are() {
    let declared = [
        "const frame = 1.0;",
        "fn shade() {}",
        "struct Surface { a: f32 }",
        "var<private> lights: f32;",
        "fn reflect_light() {}",
        "fn opaque() {}",
        "alias vec3f = vec4<f32>;",
        "alias f32 = i32;",
    ];
    let functions = [
        "dot",
        "cross",
        "select",
        "normalize",
        "dpdx",
        "dpdy",
        "max",
        "min",
        "abs",
        "step",
        "sign",
        "mix",
        "textureLoad",
        "textureSample",
        "saturate",
        "inverseSqrt",
        "sqrt",
        "transpose",
    ];
    let functions = functions.map(|name| format!("fn {name}(x: f32) -> f32 {{ return x; }}"));
    for text in declared.iter().map(|text| (*text).to_owned()).chain(functions) {
        let error = error(&format!("{PLAIN}\n\n{text}"));
        assert!(matches!(error, SurfaceFunctionError::NameTaken { line: 5, .. }), "{text}: {error}");
    }
}

#[test]
fn what_would_be_more_than_shading_is_refused() {
    refused(&format!("{PLAIN}\noverride x: f32;"), 4, &["override", "const"]);
    refused(&format!("{PLAIN}\n@group(3) @binding(0) var more: texture_2d<f32>;"), 4, &["bindings"]);
    refused(&format!("{PLAIN}\n@fragment fn other() {{}}"), 4, &["entry points"]);
    refused(&PLAIN.replace("    return", "    discard;\n    return"), 2, &["discard", "alpha mask"]);
    SurfaceFunction::new("mine", &format!("{PLAIN} // discard @")).unwrap();
}

#[test]
fn texts_of_any_size_end_with_an_answer() {
    let long = " ".repeat(SurfaceFunction::MAX_BYTES + 1);
    assert!(matches!(error(&long), SurfaceFunctionError::TooLong { limit: SurfaceFunction::MAX_BYTES, .. }));
    let room = SurfaceFunction::MAX_BYTES - 200;
    let body =
        |text: &str| format!("fn reflected(surface: Surface, light: LightArriving) -> vec3f {{ {text} }}");
    for text in [
        body(&format!("return vec3f({}1.0{});", "(".repeat(room / 2), ")".repeat(room / 2))),
        body(&format!("return vec3f({}1.0);", "- ".repeat(room / 2))),
        body(&format!("return vec3f(light.factor.x{});", "+1.0".repeat(room / 4))),
        body(&format!("return vec3f({}1.0{});", "abs(".repeat(room / 5), ")".repeat(room / 5))),
        body(&format!("{}{} return vec3f();", "{".repeat(room / 2), "}".repeat(room / 2))),
        body(&format!("if true {{}} {} return vec3f();", "else if true {}".repeat(room / 15))),
        format!("alias a = {}f32{};", "array<".repeat(room / 10), ",2>".repeat(room / 10)),
        format!("{}{}", PLAIN, "/*".repeat(room / 2)),
        "\u{0}é\u{feff}".repeat(100),
    ] {
        let _ = SurfaceFunction::new("mine", &text);
    }
    // What is accepted at most compiles, on the 2 MiB stack of a test's thread.
    for text in [
        body(&format!("return vec3f({}1.0{});", "(".repeat(60), ")".repeat(60))),
        body(&format!("return vec3f({}1.0{});", "abs(".repeat(60), ")".repeat(60))),
        body(&format!("return vec3f(light.factor.x{});", "+light.factor.x".repeat(160))),
        body(&format!("return vec3f({}light.factor.x);", "- ".repeat(900))),
        body(&format!("return vec3f({}light.factor.x);", "1+".repeat(450))),
        body(&format!("if true {{}} {} return vec3f();", "else if true {}".repeat(60))),
    ] {
        SurfaceFunction::new("mine", &text).unwrap();
    }
    refused(&body(&format!("\nreturn vec3f({}1.0{});", "(".repeat(64), ")".repeat(64))), 2, &["64 brackets"]);
}

#[test]
fn materials_are_compared_by_name_and_text_and_saving_says_what_it_leaves_out() {
    let function = || SurfaceFunction::new("mine", PLAIN).unwrap();
    let material = || Material { surface: Some(Arc::new(function())), ..Material::matt("paper", Vec3::ONE) };
    assert_eq!(material(), material().clone());
    assert_ne!(material(), Material::matt("paper", Vec3::ONE));
    assert_ne!(function(), SurfaceFunction::new("other", PLAIN).unwrap());
    assert_ne!(function(), SurfaceFunction::new("mine", &format!("{PLAIN} ")).unwrap());

    let mut scene = Scene::new();
    let floor = || Mesh::new(shapes::plane(Vec2::ONE)).unwrap();
    for material in [material(), material(), Material::default()] {
        scene.add_mesh(floor(), material, DAffine3::IDENTITY);
    }
    let glb = gltf::to_glb(&scene).unwrap();
    assert_eq!(glb.warnings.len(), 1, "each thing once: {:?}", glb.warnings);
    assert!(glb.warnings[0].contains("'paper'") && glb.warnings[0].contains("'mine'"), "{:?}", glb.warnings);
    let again = gltf::load_slice(&glb.bytes, None).unwrap().scene;
    assert!(gltf::to_glb(&again).unwrap().warnings.is_empty());
}
