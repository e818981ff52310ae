//! The WGSL of Shadowgraph and the small step that composes it.
//!
//! A shader is plain WGSL with two kinds of lines of its own:
//!
//! * `#import common/frame` puts that module's text there, once;
//! * `#if NAME` … `#else` … `#endif` keeps the lines between only when `NAME` is among the chosen flags, or, after
//!   the optional `#else`, only when it is not.
//!
//! Everything else is what the compiler sees. Techniques outside this workspace compose their own text with
//! [`compose`] and may import every common module.

use std::collections::HashSet;

use thiserror::Error;

/// A module that can be imported or composed by name.
struct Module {
    name: &'static str,
    source: &'static str,
}

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        const MODULES: &[Module] = &[$(Module { name: $name, source: include_str!(concat!($name, ".wgsl")) }),*];
    };
}

modules![
    "average_pixels",
    "common/alpha_mask",
    "common/attributes",
    "common/disc_coverage",
    "common/frame",
    "common/fullscreen",
    "common/light_grid_lists",
    "common/light_samples",
    "common/light_tiles",
    "common/lights",
    "common/map_taps",
    "common/material",
    "common/positions",
    "common/receiver_depth",
    "common/shadow_maps",
    "common/soft_light",
    "common/soft_lists",
    "common/soft_masks",
    "common/soft_near",
    "common/soft_question",
    "common/soft_seen",
    "common/surface",
    "common/tone",
    "common/transmission",
    "common/triangle_plane",
    "common/volume",
    "common/volume_caps",
    "common/volume_faces",
    "darken_picture",
    "layer_images",
    "masked_volume",
    "nothing",
    "pack_words",
    "penumbra_wedge",
    "per_receiver",
    "resolve_mask",
    "sample_images",
    "shadow_map",
    "shadow_map_casters",
    "shadow_volume_hard",
    "shadow_volume_soft",
    "silhouette_map",
    "silhouette_points",
    "soft_shadow",
    "surface_before",
    "surface_depth",
    "surface_factor",
    "surface_measure",
    "surface_peel",
    "surface_shade",
    "transparent_panes",
    "transparent_shadow",
];

/// The WGSL that a material's own surface function can use: the text of `common/surface`.
pub const SURFACE: &str = include_str!("common/surface.wgsl");

/// Why a shader could not be composed.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum ShaderError {
    #[error("shader '{shader}' imports '{import}', which is none of: {known}")]
    UnknownImport { shader: String, import: String, known: String },
    #[error("shader '{shader}' line {line}: '{text}' has no partner (#if needs an #endif after it)")]
    Unbalanced { shader: String, line: usize, text: String },
}

/// The names of all modules of this crate.
pub fn names() -> impl Iterator<Item = &'static str> {
    MODULES.iter().map(|module| module.name)
}

/// The text of a module of this crate as it was written, imports unresolved.
pub fn source(name: &str) -> Option<&'static str> {
    MODULES.iter().find(|module| module.name == name).map(|module| module.source)
}

/// Composes a module of this crate with `flags`.
///
/// # Errors
/// As [`compose`]; an unknown `name` is an unknown import of itself.
pub fn compose_named(name: &str, flags: &[&str]) -> Result<String, ShaderError> {
    match source(name) {
        Some(text) => compose(name, text, flags),
        None => Err(unknown_import(name, name)),
    }
}

/// Composes a module of this crate with `flags`, with `text` in place of the module `replaced` that it imports: for text that
/// a program writes.
///
/// # Errors
/// As [`compose_named`]; an unknown `replaced` is an unknown import too.
pub fn compose_replacing(
    name: &str,
    flags: &[&str],
    replaced: &str,
    text: &str,
) -> Result<String, ShaderError> {
    let own = source(name).ok_or_else(|| unknown_import(name, name))?;
    let module = MODULES.iter().find(|module| module.name == replaced);
    let replaced = module.ok_or_else(|| unknown_import(name, replaced))?.name;
    let mut composed = text.to_owned();
    append(name, own, flags, &mut HashSet::from([replaced]), &mut composed)?;
    Ok(composed)
}

/// Composes `text`, called `name` in errors, with `flags`.
///
/// # Errors
/// [`ShaderError`] names the shader, the line and what is accepted.
pub fn compose(name: &str, text: &str, flags: &[&str]) -> Result<String, ShaderError> {
    let mut composed = String::new();
    append(name, text, flags, &mut HashSet::new(), &mut composed)?;
    Ok(composed)
}

fn unknown_import(shader: &str, import: &str) -> ShaderError {
    let known = names().collect::<Vec<_>>().join(", ");
    ShaderError::UnknownImport { shader: shader.into(), import: import.into(), known }
}

fn append(
    name: &str,
    text: &str,
    flags: &[&str],
    imported: &mut HashSet<&'static str>,
    composed: &mut String,
) -> Result<(), ShaderError> {
    // One entry per open #if: whether its lines are kept, and the line it opened on.
    let mut open: Vec<(bool, usize)> = Vec::new();
    for (line, text) in text.lines().enumerate() {
        let unbalanced =
            || ShaderError::Unbalanced { shader: name.into(), line: line + 1, text: text.into() };
        let keeping = open.iter().all(|(kept, _)| *kept);
        let directive = text.trim();
        if let Some(flag) = directive.strip_prefix("#if ") {
            open.push((flags.contains(&flag.trim()), line + 1));
        } else if directive == "#else" {
            let (kept, _) = open.last_mut().ok_or_else(unbalanced)?;
            *kept = !*kept;
        } else if directive == "#endif" {
            open.pop().ok_or_else(unbalanced)?;
        } else if !keeping {
        } else if let Some(import) = directive.strip_prefix("#import ") {
            let module = MODULES.iter().find(|module| module.name == import.trim());
            let module = module.ok_or_else(|| unknown_import(name, import.trim()))?;
            if imported.insert(module.name) {
                append(module.name, module.source, flags, imported, composed)?;
            }
        } else {
            composed.push_str(text);
            composed.push('\n');
        }
    }
    match open.first() {
        Some((_, line)) => {
            Err(ShaderError::Unbalanced { shader: name.into(), line: *line, text: "#if".into() })
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn imports_come_once_and_flags_choose_lines() {
        let text = "#import common/fullscreen\n#import common/fullscreen\n#if A\nlet a = 1;\n#endif\n#if B\nlet b = 1;\n#endif\n";
        let composed = compose("t", text, &["B"]).unwrap();
        assert_eq!(composed.matches("fn fullscreen_vertex").count(), 1);
        assert!(!composed.contains("let a") && composed.contains("let b"));
        let text = "#if A\nlet a = 1;\n#else\nlet b = 1;\n#endif\n";
        assert_eq!(compose("t", text, &["A"]).unwrap(), "let a = 1;\n");
        assert_eq!(compose("t", text, &[]).unwrap(), "let b = 1;\n");
    }

    #[test]
    fn an_import_is_replaced() {
        let composed = compose_replacing("resolve_mask", &[], "common/fullscreen", "// mine\n").unwrap();
        assert!(composed.starts_with("// mine\n") && !composed.contains("fn fullscreen_vertex"));
        assert!(compose_replacing("resolve_mask", &[], "common/nothing", "").is_err());
        assert!(compose_replacing("nowhere", &[], "common/fullscreen", "").is_err());
    }

    #[test]
    fn errors_name_both_parties() {
        let error = compose("mine", "#import common/nothing", &[]).unwrap_err().to_string();
        assert!(
            error.contains("'mine'") && error.contains("'common/nothing'") && error.contains("common/frame")
        );
        assert!(matches!(compose("mine", "#if A", &[]), Err(ShaderError::Unbalanced { line: 1, .. })));
        assert!(matches!(compose("mine", "#else", &[]), Err(ShaderError::Unbalanced { line: 1, .. })));
        assert!(matches!(compose("mine", "#endif", &[]), Err(ShaderError::Unbalanced { line: 1, .. })));
    }
}
