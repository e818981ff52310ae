//! The committed demo scenes are what the generator makes, and load with their shadow nodes.

use std::path::Path;

use shadowgraph::engine::gltf::{load, to_glb};
use shadowgraph::prelude::*;

/// What a scene shows, coarsely enough to survive another machine's last digit of a sine.
fn outline(scene: &Scene) -> String {
    let snapshot = scene.snapshot().unwrap();
    let mut text = String::new();
    for instance in &snapshot.instances {
        let (min, max) = (instance.world_bounds.min, instance.world_bounds.max);
        text += &format!("{} {} {min:.4} {max:.4}\n", instance.name, instance.mesh.triangle_count());
    }
    for light in &snapshot.lights {
        text += &format!("{} {:.4} {:?}\n", light.name, light.position, light.light.kind);
    }
    for node in &snapshot.shadow_nodes {
        text += &format!(
            "{} {} {:?} {:?} {:?} {:?}\n",
            node.name, node.shadow.technique, node.shadow.params, node.lights, node.casters, node.receivers
        );
    }
    text
}

#[test]
fn committed_scenes_are_what_the_generator_makes() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    for (name, _, scene) in shadowgraph::demo::all().into_iter().chain(shadowgraph::demo::mixed()) {
        let loaded = load(assets.join(format!("{name}.glb"))).unwrap();
        assert_eq!(loaded.warnings, Vec::<String>::new(), "{name}");
        assert_eq!(outline(&loaded.scene), outline(&scene), "{name}: run `cargo run -- assets assets`");
        assert!(loaded.scene.shadows().next().is_some(), "{name} has a shadow node");
        // Saving what was loaded gives the same scene again.
        let again =
            shadowgraph::engine::gltf::load_slice(&to_glb(&loaded.scene).unwrap().bytes, None).unwrap();
        assert_eq!(outline(&again.scene), outline(&scene), "{name}");
    }
}

/// The room is what its description says: four lights of all kinds, open, closed and non-manifold casters.
#[test]
fn the_room_has_every_kind_of_light_and_caster() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let snapshot = load(assets.join("room.glb")).unwrap().scene.snapshot().unwrap();
    let kinds: std::collections::HashSet<_> =
        snapshot.lights.iter().map(|light| std::mem::discriminant(&light.light.kind)).collect();
    assert!(snapshot.lights.len() >= 4 && kinds.len() == 3);
    let closedness: Vec<_> =
        snapshot.instances.iter().map(|i| i.mesh.topology().closedness().clone()).collect();
    assert!(closedness.iter().any(|c| c.unbalanced_edges == 0 && c.signed_volume > 0.0), "closed casters");
    assert!(closedness.iter().any(|c| c.boundary_edges > 0), "open casters");
    assert!(closedness.iter().any(|c| c.non_manifold_edges > 0), "non-manifold casters");
}
