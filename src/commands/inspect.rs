//! `shadowgraph inspect`: what a scene is made of, and what a frame of it would do. Needs no GPU.

use std::collections::HashSet;

use clap::Args;
use shadowgraph::engine::gltf::Loaded;
use shadowgraph::engine::manager::{Adapter, plan_frame};
use shadowgraph::engine::scene::{NodeKey, Posed};
use shadowgraph::engine::shadow::{Cache, Registry};
use shadowgraph::prelude::*;

use super::Failure;
use super::output::out;
use super::scenes::{SceneArgs, catalog, load};

/// The arguments of `inspect`.
#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    scene: SceneArgs,
}

pub(crate) fn run(args: &InspectArgs) -> Result<(), Failure> {
    let loaded = load(&args.scene.scene, args.scene.which_scene.as_deref())?;
    print_scenes(&loaded);
    let (scene, camera) = args.scene.prepare_loaded(loaded.scene)?;
    let posed = scene.pose().map_err(RenderError::from)?;
    print_animations(&scene);
    out!("nodes");
    for root in scene.roots() {
        print_node(&scene, *root, 1);
    }
    print_casters(&posed);
    let registry = Registry::collect(&posed, &catalog()).map_err(RenderError::from)?;
    print_claims(&posed, &registry);
    let request = FrameRequest::new(camera, args.scene.size.0);
    let plan = plan_frame(&posed, &registry, &request, &Adapter::imagined(), &mut Cache::new())
        .map_err(RenderError::from)?;
    out!("{plan}");
    Ok(())
}

/// The file's scenes, where there are several to choose from.
fn print_scenes(loaded: &Loaded) {
    if loaded.scene_names.len() < 2 {
        return;
    }
    out!("scenes");
    for (index, name) in loaded.scene_names.iter().enumerate() {
        let shown = if loaded.scene_index == Some(index) { ", shown" } else { "" };
        out!("  {index} '{}'{shown}", name.escape_debug());
    }
}

/// What moves: clips with how long they last, and skins.
fn print_animations(scene: &Scene) {
    if scene.animations().next().is_some() {
        out!("animations");
    }
    for (_, animation) in scene.animations() {
        let nodes: HashSet<NodeKey> = animation.channels.iter().map(|channel| channel.node).collect();
        out!(
            "  '{}' {:.3} s, {} channels, {} nodes",
            animation.name.escape_debug(),
            animation.duration_s(),
            animation.channels.len(),
            nodes.len()
        );
    }
    if scene.skins().next().is_some() {
        out!("skins");
    }
    for (_, skin) in scene.skins() {
        out!("  '{}' {} joints", skin.name.escape_debug(), skin.joints.len());
    }
}

/// What bends a mesh, in a few words; nothing for one that nothing bends.
fn bending(scene: &Scene, content: &MeshNode, mesh: &Mesh) -> String {
    let skin = content.skin.and_then(|key| scene.skin(key));
    let skin = skin.map_or(String::new(), |skin| format!(", skin '{}'", skin.name.escape_debug()));
    let morphs = &mesh.data().morphs;
    if morphs.is_empty() {
        return skin;
    }
    let names: Vec<&str> = morphs.iter().map(|morph| morph.name.as_str()).collect();
    let own: Vec<f64> = morphs.iter().map(|morph| f64::from(morph.weight)).collect();
    let weights = if content.weights.is_empty() { &own } else { &content.weights };
    format!("{skin}, morph targets {names:?} at {weights:?}")
}

fn print_node(scene: &Scene, key: NodeKey, depth: usize) {
    let Some(node) = scene.node(key) else { return };
    let what = match &node.content {
        Content::Group => "group".to_owned(),
        Content::Mesh(content) => scene.mesh(content.mesh).map_or_else(String::new, |mesh| {
            let materials: Vec<&str> = content
                .materials
                .iter()
                .filter_map(|m| scene.material(*m))
                .map(|m| m.name.as_str())
                .collect();
            format!(
                "mesh '{}', {} triangles, materials {materials:?}{}",
                mesh.name().escape_debug(),
                mesh.triangle_count(),
                bending(scene, content, mesh)
            )
        }),
        Content::Light(light) => scene.light(*light).map_or_else(String::new, |light| {
            let range = light.range_m.map_or(String::new(), |m| format!(", range {m} m"));
            format!("light {:?}, intensity {}{range}", light.kind, light.intensity)
        }),
        Content::Camera(camera) => {
            scene.camera(*camera).map_or_else(String::new, |camera| format!("camera {:?}", camera.projection))
        }
        Content::Shadow(shadow) => scene.shadow(*shadow).map_or_else(String::new, |shadow| {
            let scope = |scope: &Scope| match scope {
                Scope::All => "all".to_owned(),
                Scope::Nodes(nodes) => {
                    let names = nodes.iter().filter_map(|n| scene.node(*n)).map(|n| n.name.as_str());
                    names.collect::<Vec<_>>().join(" ")
                }
            };
            format!(
                "shadow {} {:?}, lights: {}, casters: {}",
                shadow.technique,
                shadow.params,
                scope(&shadow.lights),
                scope(&shadow.casters)
            )
        }),
    };
    out!("{:indent$}'{}' {what}", "", node.name.escape_debug(), indent = depth * 2);
    for child in node.children() {
        print_node(scene, *child, depth + 1);
    }
}

fn print_casters(posed: &Posed) {
    out!("casters");
    for instance in &posed.instances {
        let closedness = instance.mesh.topology().closedness();
        let solid = instance.mesh.topology().orientation(&instance.world_from_local).is_some();
        let kind = if solid { "closed" } else { "open" };
        let alpha = match (instance.is_opaque(), instance.is_masked()) {
            (false, _) => "; has blended or transmissive parts, which cast only through a coloured technique",
            (true, true) => "; has alpha-masked parts",
            (true, false) => "",
        };
        out!(
            "  '{}' {kind}: {} boundary, {} non-manifold, {} inconsistent edges, {} degenerate triangles, \
             {} components, signed volume {:.4e} m3{alpha}",
            instance.name.escape_debug(),
            closedness.boundary_edges,
            closedness.non_manifold_edges,
            closedness.inconsistent_edges,
            closedness.degenerate_triangles,
            closedness.components,
            closedness.signed_volume
        );
    }
}

fn print_claims(posed: &Posed, registry: &Registry) {
    out!("lights");
    for (light, claims) in posed.lights.iter().zip(&registry.lights) {
        if claims.is_empty() {
            out!("  '{}' casts no shadow", light.name);
        }
        for claim in claims {
            let technique = &claim.technique;
            out!(
                "  '{}' from '{}': {} {:?}, {} casters; known error: {}",
                light.name,
                claim.node.escape_debug(),
                technique.type_name(),
                technique.params(),
                claim.casters.len(),
                technique.known_error()
            );
        }
    }
}
