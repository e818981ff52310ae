//! The whole of a scene for `inspect --tree`: every node and every caster, a line each.

use std::collections::HashMap;

use shadowgraph::engine::gltf::few_digits;
use shadowgraph::engine::scene::{NodeKey, ParamValue, Params, SceneSnapshot};
use shadowgraph::prelude::*;

use super::output::out;

/// Levels that are shown by indenting; deeper ones are said by number, or a deep tree would be mostly blanks.
const INDENTED: usize = 20;

/// Names of a list that are written out.
const LISTED: usize = 8;

/// A name between quotes, without what could end a line.
pub(crate) fn quoted(name: &str) -> String {
    format!("'{}'", name.escape_debug())
}

/// Options as the command line takes them: `depthTest=zfail samples=16`.
pub(crate) fn options(params: &Params) -> String {
    let option = |(name, value): (&String, &ParamValue)| {
        let value = match value {
            ParamValue::Text(text) => text.clone(),
            ParamValue::Flag(flag) => flag.to_string(),
            ParamValue::Number(number) => few_digits(*number),
            ParamValue::Numbers(numbers) => {
                numbers.iter().map(|n| few_digits(*n)).collect::<Vec<_>>().join("/")
            }
        };
        format!(" {name}={value}")
    };
    params.iter().map(option).collect()
}

/// The first of many names, and how many more there are.
pub(crate) fn listed(names: impl ExactSizeIterator<Item = String>) -> String {
    let more = names.len().saturating_sub(LISTED);
    let shown = names.take(LISTED).collect::<Vec<_>>().join(", ");
    if more > 0 { format!("{shown} and {more} more") } else { shown }
}

/// Every node, parents first.
pub(crate) fn print_nodes(scene: &Scene) {
    out!("nodes");
    // Sibling after sibling, never by recursion: a hierarchy may be as deep as a file is long.
    let mut open: Vec<(NodeKey, usize)> = scene.roots().iter().rev().map(|root| (*root, 1)).collect();
    while let Some((key, depth)) = open.pop() {
        let Some(node) = scene.node(key) else { continue };
        open.extend(node.children().iter().rev().map(|child| (*child, depth + 1)));
        let level = if depth > INDENTED { format!("({depth}) ") } else { String::new() };
        let hidden = if node.visible { "" } else { ", hidden" };
        let indent = 2 * depth.min(INDENTED);
        out!("{:indent$}{level}{} {}{hidden}", "", quoted(&node.label()), content(scene, &node.content));
    }
}

/// What a node holds.
fn content(scene: &Scene, content: &Content) -> String {
    match content {
        Content::Group => "group".into(),
        Content::Mesh(content) => scene.mesh(content.mesh).map_or_else(String::new, |mesh| {
            let materials: Vec<_> = content.materials.iter().filter_map(|key| scene.material(*key)).collect();
            let materials = listed(materials.iter().map(|material| quoted(&material.name)));
            let (name, triangles) = (quoted(mesh.name()), mesh.triangle_count());
            format!(
                "mesh {name}, {triangles} triangles, materials {materials}{}",
                bending(scene, content, mesh)
            )
        }),
        Content::Light(light) => scene.light(*light).map_or_else(String::new, light_text),
        Content::Camera(key) => {
            scene.camera(*key).map_or_else(String::new, |camera| lens(&camera.projection))
        }
        Content::Shadow(shadow) => scene.shadow(*shadow).map_or_else(String::new, |shadow| {
            let scope = |scope: &Scope| match scope {
                Scope::All => "all".to_owned(),
                Scope::Nodes(nodes) => {
                    let label = |key: &NodeKey| scene.node(*key).map(|node| quoted(&node.label()));
                    listed(nodes.iter().map(|key| label(key).unwrap_or_else(|| "gone".into())))
                }
            };
            format!(
                "shadow {}{}, lights: {}, casters: {}",
                shadow.technique,
                options(&shadow.params),
                scope(&shadow.lights),
                scope(&shadow.casters)
            )
        }),
    }
}

/// A light's kind and strength.
pub(crate) fn light_text(light: &Light) -> String {
    use shadowgraph::engine::scene::LightKind;
    let (kind, unit) = match light.kind {
        LightKind::Directional => ("directional light".to_owned(), "lx"),
        LightKind::Point => ("point light".to_owned(), "cd"),
        LightKind::Spot { outer_rad, .. } => {
            (format!("spot light of {} degrees to each side", few_digits(outer_rad.to_degrees())), "cd")
        }
    };
    let range = light.range_m.map_or(String::new(), |range_m| format!(", range {} m", few_digits(range_m)));
    format!("{kind}, {} {unit}{range}", few_digits(f64::from(light.intensity)))
}

/// What a camera's lens is like.
pub(crate) fn lens(projection: &shadowgraph::engine::math::Projection) -> String {
    use shadowgraph::engine::math::Projection;
    match *projection {
        Projection::Perspective { fov_y_rad, near_m } => {
            format!(
                "perspective camera, {} degrees high, near {} m",
                few_digits(fov_y_rad.to_degrees()),
                few_digits(near_m)
            )
        }
        Projection::Orthographic { half_height_m, near_m, far_m } => format!(
            "orthographic camera, {} m high, from {} m to {} m",
            few_digits(2.0 * half_height_m),
            few_digits(near_m),
            few_digits(far_m)
        ),
    }
}

/// What bends a mesh, in a few words; nothing for one that nothing bends.
fn bending(scene: &Scene, content: &MeshNode, mesh: &Mesh) -> String {
    let skin = content.skin.and_then(|key| scene.skin(key));
    let skin = skin.map_or(String::new(), |skin| format!(", skin {}", quoted(&skin.name)));
    let morphs = &mesh.data().morphs;
    if morphs.is_empty() {
        return skin;
    }
    let weight = |index: usize| match content.weights.get(index) {
        Some(weight) => *weight,
        None => f64::from(morphs[index].weight),
    };
    let target = |index: usize| format!("{} at {}", quoted(&morphs[index].name), few_digits(weight(index)));
    format!("{skin}, morph targets {}", listed((0..morphs.len()).map(target)))
}

/// Every mesh in the scene, with all that is known of how closed it is.
pub(crate) fn print_casters(snapshot: &SceneSnapshot) {
    out!("casters");
    let mut seen: HashMap<u64, bool> = HashMap::new();
    for instance in &snapshot.instances {
        let closedness = instance.mesh.topology().closedness();
        let solid = *seen
            .entry(instance.pose_key)
            .or_insert_with(|| instance.mesh.topology().orientation(&instance.world_from_local).is_some());
        let alpha = match (instance.is_opaque(), instance.is_masked()) {
            (false, _) => "; has blended or transmissive parts, which cast only through a coloured technique",
            (true, true) => "; has alpha-masked parts",
            (true, false) => "",
        };
        out!(
            "  {} {}: {} boundary, {} non-manifold, {} inconsistent edges, {} degenerate triangles, {} components, \
             signed volume {} m3{alpha}",
            quoted(&instance.name),
            if solid { "closed" } else { "open" },
            closedness.boundary_edges,
            closedness.non_manifold_edges,
            closedness.inconsistent_edges,
            closedness.degenerate_triangles,
            closedness.components,
            few_digits(closedness.signed_volume)
        );
    }
}
