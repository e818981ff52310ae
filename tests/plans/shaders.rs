//! Every shader of the project, in every combination of flags, composes, parses and validates without a device.

use std::collections::BTreeSet;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use shadowgraph_engine::scene::SurfaceFunction;

/// Flags that exclude each other: the factor of a light is in one place, and layers have one sample a pixel.
const EXCLUSIVE: &[(&str, [&str; 2])] = &[
    ("surface_factor", ["COUNTS", "VISIBILITY"]),
    ("layer_images", ["COUNTS", "VISIBILITY"]),
    ("sample_images", ["COUNTS", "VISIBILITY"]),
    ("shadow_map_casters", ["CUT", "MASKED"]),
    ("surface_shade", ["FARTHER", "MULTISAMPLED"]),
];

/// What plans, and the engine's own styles, ask of each module: at least these flags and entry points must be there,
/// those with an `if` under that flag.
const USED: &[(&str, &[&str], &[&str])] = &[
    ("average_pixels", &[], &["fullscreen_vertex", "average"]),
    ("darken_picture", &["ONE_CHANNEL"], &["fullscreen_vertex", "darken_by"]),
    ("layer_images", &["COUNTS", "VISIBILITY"], &["fullscreen_vertex", "factor", "rounded"]),
    ("masked_volume", &["BASE_COLOR_TEXTURE"], &["fullscreen_vertex", "darken"]),
    ("nothing", &[], &["nothing"]),
    ("penumbra_wedge", &[], &["vertex", "fullscreen_vertex", "add_share", "darken"]),
    ("per_receiver", &["CASTERS", "CLUSTERS", "ONE_CASTER"], &["soft_vertex", "mark", "per_receiver"]),
    ("resolve_mask", &[], &["fullscreen_vertex", "mark", "darken"]),
    (
        "sample_images",
        &["COUNTS", "OWN_SHADOW", "VISIBILITY"],
        &["fullscreen_vertex", "triangle", "plane", "depth", "factor", "darken if COUNTS"],
    ),
    ("shadow_map", &["BIASED", "CASCADES", "EACH_SAMPLE", "PERSPECTIVE", "POINT"], &["asking", "darken"]),
    (
        "shadow_map_casters",
        &["BASE_COLOR_TEXTURE", "CUT", "MASKED", "PERSPECTIVE"],
        &["vertex", "slope", "holes", "slope_of_piece if CUT", "depth_of_piece if CUT"],
    ),
    (
        "shadow_volume_hard",
        &[],
        &["vertex", "fullscreen_vertex", "count", "count_front", "count_back", "darken_counted"],
    ),
    (
        "silhouette_map",
        &["BIASED", "BYTE", "EACH_SAMPLE", "PERSPECTIVE", "POINT"],
        &["asking", "darken", "show_points"],
    ),
    ("silhouette_points", &["BYTE"], &["vertex", "store"]),
    (
        "soft_shadow",
        &["BASE_COLOR_TEXTURE", "GLASS", "MASKED", "OVERLAPS", "RECEIVER", "SECOND_UV"],
        &[
            "receiver if RECEIVER",
            "mark_receiver if RECEIVER",
            "share if RECEIVER",
            "share_of_texel if RECEIVER",
            "four_texels if RECEIVER",
            "share_from_texture if RECEIVER",
            "tinted_points if RECEIVER",
            "tinted_texel if RECEIVER",
            "tinted_share if RECEIVER",
            "tinted_share_from_texture if RECEIVER",
        ],
    ),
    ("pack_words", &[], &["fullscreen_vertex", "pack"]),
    (
        "shadow_volume_soft",
        &["CASTERS", "CLUSTERS", "DEEP", "LONG_LISTS", "MASKS", "MASKS_ONLY", "ONE_CASTER"],
        &["soft_vertex", "mark", "sampled"],
    ),
    ("surface_before", &["BASE_COLOR_TEXTURE", "FARTHER", "SECOND_UV"], &["vertex", "before"]),
    ("surface_depth", &[], &["vertex"]),
    ("surface_factor", &["COUNTS", "VISIBILITY", "MASKED", "OWN_SHADOW"], &["vertex", "factor"]),
    (
        "surface_measure",
        &["HALVES", "MASKED", "PLANES"],
        &[
            "vertex",
            "visible_triangle",
            "plane_halves if PLANES",
            "receiver_plane if PLANES",
            "triangle_and_plane if PLANES",
        ],
    ),
    ("surface_peel", &["BASE_COLOR_TEXTURE", "BEHIND", "SECOND_UV"], &["vertex", "peel"]),
    ("surface_shade", SHADE_FLAGS, &["vertex", "opaque", "blended", "shine_through", "masked_depth"]),
    ("transparent_panes", &["BASE_COLOR_TEXTURE"], &["fullscreen_vertex", "tint"]),
    (
        "transparent_shadow",
        &["MANY_CLASSES"],
        &[
            "vertex",
            "class_vertex",
            "fullscreen_vertex",
            "add",
            "add_front",
            "add_back",
            "multiply",
            "multiply_front",
            "multiply_back",
            "divide",
            "divide_front",
            "divide_back",
            "transmit_counts",
            "transmit_logarithms",
            "transmit_product",
        ],
    ),
];

const SHADE_FLAGS: &[&str] = &[
    "BASE_COLOR_TEXTURE",
    "COUNTS",
    "EMISSIVE_TEXTURE",
    "FARTHER",
    "LIGHT_TILES",
    "MANY_LIGHTS",
    "MASK",
    "MASKED",
    "METALLIC_ROUGHNESS_TEXTURE",
    "MULTISAMPLED",
    "NORMAL_TEXTURE",
    "OCCLUSION_TEXTURE",
    "ONE_CHANNEL",
    "ONE_FACTOR",
    "ONE_LIGHT",
    "OWN_SHADOW",
    "SECOND_UV",
    "SMOOTH_TERMINATOR",
    "SURFACE_FUNCTION",
    "TINTED",
    "UNLIT",
    "VERTEX_COLOR",
    "VISIBILITY",
];

fn directives(name: &str, directive: &str) -> BTreeSet<String> {
    let source = shadowgraph_shaders::source(name).unwrap_or_else(|| panic!("there is no module '{name}'"));
    let lines = source.lines().filter_map(|line| line.trim().strip_prefix(directive));
    lines.map(|rest| rest.trim().to_owned()).collect()
}

/// The flags that change what a module composes to, those of its imports included.
fn flags_of(name: &str) -> BTreeSet<String> {
    let mut flags = directives(name, "#if ");
    for import in directives(name, "#import ") {
        flags.extend(flags_of(&import));
    }
    flags
}

/// Sets of flags that a module may be composed with: all of up to four flags, and those that lack at most one. Flags
/// interact in pairs and triples; all sets of eighteen would take hours.
fn combinations(name: &str) -> Vec<Vec<String>> {
    let flags: Vec<String> = flags_of(name).into_iter().collect();
    let tried = |set: &usize| set.count_ones() <= 4 || set.count_ones() as usize + 1 >= flags.len();
    let subsets = (0..1_usize << flags.len()).filter(tried).map(|set| {
        let chosen = flags.iter().enumerate().filter(|(bit, _)| set >> bit & 1 == 1);
        chosen.map(|(_, flag)| flag.clone()).collect::<Vec<_>>()
    });
    let excluded = |set: &Vec<String>| {
        EXCLUSIVE.iter().any(|(module, pair)| {
            *module == name && pair.iter().all(|flag| set.iter().any(|chosen| chosen == flag))
        })
    };
    subsets.filter(|set| !excluded(set)).collect()
}

/// What a material's own text brings where the engine's leaves a place for it.
const OWN_SURFACE: &str = "fn reflected(surface: Surface, light: LightArriving) -> vec3f { return light.factor * fwidth(surface.uv.x); }";

/// A module as it reaches the device.
fn composed(name: &str, flags: &[&str]) -> String {
    let text = shadowgraph_shaders::compose_named(name, flags).expect("it composes");
    if name == "surface_shade" && flags.contains(&"SURFACE_FUNCTION") {
        let function = SurfaceFunction::unchecked("own", OWN_SURFACE);
        return function.appended_to(text);
    }
    text
}

/// Validates with no optional feature at all: whatever runs wgpu runs these.
fn validate(text: &str) -> Result<naga::Module, String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|error| error.emit_to_string(text))?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    validator.validate(&module).map_err(|error| error.emit_to_string(text))?;
    Ok(module)
}

#[test]
fn every_module_validates_with_every_flag() {
    let mut checked = 0;
    for name in shadowgraph_shaders::names() {
        for flags in combinations(name) {
            let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
            let text = composed(name, &flags);
            assert!(!text.contains("\n#"), "{name} {flags:?} keeps a directive");
            if let Err(error) = validate(&text) {
                panic!("{name} {flags:?}:\n{error}");
            }
            checked += 1;
        }
    }
    // 8 ways to shade, 3 to measure a factor, and every other module once at least.
    assert!(checked >= 8 + 3 + 8, "only {checked} texts were checked");
}

#[test]
fn the_check_can_fail() {
    assert!(validate("fn f() -> f32 { return 1u; }").is_err());
    assert!(validate("fn f() {").is_err());
    let both = shadowgraph_shaders::compose_named("surface_factor", &["COUNTS", "VISIBILITY"]);
    assert!(
        validate(&both.expect("it composes")).is_err(),
        "these flags share a binding: is the list of exclusions stale?"
    );
}

#[test]
fn every_import_is_known() {
    let known: BTreeSet<String> = shadowgraph_shaders::names().map(str::to_owned).collect();
    let mut imports = 0;
    for name in &known {
        for import in directives(name, "#import ") {
            assert!(known.contains(&import), "'{name}' imports '{import}', known are {known:?}");
            imports += 1;
        }
    }
    assert!(imports > 0);
}

#[test]
fn modules_have_the_flags_and_entry_points_the_engine_names() {
    for (name, flags, entry_points) in USED {
        let has: BTreeSet<String> = flags_of(name);
        let wants: BTreeSet<String> = flags.iter().map(|flag| (*flag).to_owned()).collect();
        assert!(has.is_superset(&wants), "'{name}' has the flags {has:?}, the engine uses {wants:?}");
        for flags in combinations(name) {
            let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
            let text = composed(name, &flags);
            let module = validate(&text).expect("validated above");
            for wanted in *entry_points {
                let (wanted, flag) = wanted.split_once(" if ").unwrap_or((wanted, ""));
                if !flag.is_empty() && !flags.contains(&flag) {
                    continue;
                }
                assert!(
                    module.entry_points.iter().any(|entry| entry.name == wanted),
                    "'{name}' {flags:?} has no entry point '{wanted}'"
                );
            }
        }
    }
}
