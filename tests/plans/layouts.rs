//! Structures that Rust writes and WGSL reads, compared field by field: names, offsets and whole size.

use naga::proc::Layouter;
use shadowgraph_engine::gpu::{FrameUniform, InstanceUniform, LightUniform, MaterialUniform, TintUniform};
use shadowgraph_nodes::common::beside_light::CutVertex;
use shadowgraph_nodes::common::volume::VolumeUniform;

/// Fields with their byte offsets, in order, and the whole size.
type Layout = (Vec<(String, usize)>, usize);

/// The layout of `structure` in WGSL, and the distance of its copies in an array.
fn wgsl_layout(module: &naga::Module, structure: &str) -> (Layout, usize) {
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).expect("sizes are known");
    let (handle, ty) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some(structure))
        .unwrap_or_else(|| panic!("no struct {structure}"));
    let naga::TypeInner::Struct { members, span } = &ty.inner else {
        panic!("{structure} is no struct");
    };
    let name = |member: &naga::StructMember| member.name.clone().expect("fields have names");
    let fields = members.iter().map(|member| (name(member), member.offset as usize)).collect();
    assert_eq!(layouter[handle].size, *span, "{structure}");
    ((fields, *span as usize), layouter[handle].to_stride() as usize)
}

fn owned((fields, size): (Vec<(&'static str, usize)>, usize)) -> Layout {
    (fields.into_iter().map(|(name, offset)| (name.to_owned(), offset)).collect(), size)
}

fn parse(module: &str, flags: &[&str]) -> naga::Module {
    let text = shadowgraph_shaders::compose_named(module, flags).expect("it composes");
    naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)))
}

fn assert_same(module: &str, structure: &str, rust: (Vec<(&'static str, usize)>, usize)) {
    assert_same_with(module, &[], structure, rust);
}

fn assert_same_with(
    module: &str,
    flags: &[&str],
    structure: &str,
    rust: (Vec<(&'static str, usize)>, usize),
) {
    let rust = owned(rust);
    let (wgsl, stride) = wgsl_layout(&parse(module, flags), structure);
    assert!(!rust.0.is_empty());
    assert_eq!(rust, wgsl, "{structure}: Rust left, {module}.wgsl right");
    assert_eq!(rust.1, stride, "{structure} in an array");
}

#[test]
fn frame() {
    assert_same("common/frame", "Frame", FrameUniform::layout());
}

#[test]
fn instance() {
    assert_same("common/frame", "Instance", InstanceUniform::layout());
}

#[test]
fn light() {
    assert_same("common/lights", "Light", LightUniform::layout());
}

#[test]
fn material() {
    assert_same("common/material", "Material", MaterialUniform::layout());
}

#[test]
fn tint() {
    let (wgsl, stride) = wgsl_layout(&parse("surface_shade", &["TINTED"]), "TintedFactor");
    assert_eq!(owned(TintUniform::layout()), wgsl);
    assert_eq!(wgsl.1, stride);
}

#[test]
fn volume() {
    assert_same("common/volume", "Volume", VolumeUniform::layout());
    assert_same_with("common/volume", &["CUT_EDGES"], "CutVertex", CutVertex::layout());
}

#[test]
fn masked_volumes() {
    for (structure, rust) in shadowgraph_nodes::common::masked::layouts() {
        assert_same("masked_volume", structure, rust);
    }
}

#[test]
fn light_grid_lists() {
    for (structure, rust) in shadowgraph_nodes::common::ray_candidates::layouts() {
        assert_same("common/light_grid_lists", structure, rust);
    }
}

#[test]
fn transparent_shadows() {
    for (module, structure, rust) in shadowgraph_nodes::transparent_layouts() {
        assert_same(module, structure, rust);
    }
}

#[test]
fn planar_shadows() {
    for (flag, structure, rust) in shadowgraph_nodes::planar_layouts() {
        assert_same_with("soft_shadow", &[flag], structure, rust);
    }
}

#[test]
fn soft_lights() {
    for (structure, rust) in shadowgraph_nodes::soft_layouts() {
        let rust = owned(rust);
        let (wgsl, stride) = wgsl_layout(&parse("shadow_volume_soft", &["CASTERS", "CLUSTERS"]), structure);
        assert_eq!(rust, wgsl, "{structure}: Rust left, WGSL right");
        assert_eq!(rust.1, stride, "{structure} in an array");
    }
}

#[test]
fn penumbra_wedges() {
    for (structure, rust) in shadowgraph_nodes::wedge_layouts() {
        assert_same("penumbra_wedge", structure, rust);
    }
}

#[test]
fn shadow_maps() {
    for (structure, rust) in shadowgraph_nodes::common::shadow_maps::layouts() {
        assert_same("common/shadow_maps", structure, rust);
    }
    let (structure, rust) = shadowgraph_nodes::common::map_casters::corner_layout();
    assert_same_with("shadow_map_casters", &["MASKED"], structure, rust);
    let (structure, rust) = shadowgraph_nodes::common::cut_casters::cut_layout();
    assert_same_with("shadow_map_casters", &["CUT"], structure, rust);
}

#[test]
fn silhouettes() {
    let (structure, rust) = shadowgraph_nodes::silhouette_layout();
    assert_same("silhouette_points", structure, rust);
}

/// A structure that a shader binds and no test compares would drift unseen.
#[test]
fn every_structure_bound_as_data_is_compared() {
    let compared = [
        "Class",
        "CutCorner",
        "Edge",
        "Frame",
        "GlassCorner",
        "Instance",
        "Light",
        "ListView",
        "ListedCone",
        "MaskedCaster",
        "MaskedCorner",
        "MaskedTriangle",
        "Material",
        "PaneCaster",
        "PaneTriangle",
        "PlanarLight",
        "PlanarTexture",
        "ShadowMaps",
        "SoftHead",
        "Volume",
        "WedgeCasters",
        "WedgeEdge",
    ];
    for name in shadowgraph_shaders::names() {
        let module = parse(name, &[]);
        for (_, variable) in module.global_variables.iter() {
            let mut ty = variable.ty;
            if let naga::TypeInner::Array { base, .. } = module.types[ty].inner {
                ty = base;
            }
            if let naga::TypeInner::Struct { .. } = module.types[ty].inner {
                let structure = module.types[ty].name.as_deref().unwrap_or("a struct without a name");
                assert!(
                    compared.contains(&structure),
                    "{name}.wgsl binds {structure}, which no test compares"
                );
            }
        }
    }
}
