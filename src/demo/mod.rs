//! The demo scenes: what the project's first pictures, its report and its viewer show.
//!
//! Each is made in code from generated shapes, has a camera called "main" and its own shadow nodes, and mixes open,
//! closed and non-manifold casters the way real models do. Intensities are physical (lux and candela) and chosen
//! relative to one another; the renderer sets the exposure.

mod chapel;
mod columns;
mod foliage;
mod furniture;
mod knots;
mod plant;
mod room;
mod set;
pub(crate) mod speed;
mod still_life;
mod tentacles;
mod valley;
mod variants;

use shadowgraph_engine::scene::Scene;

pub use speed::speed;
pub use variants::under_lamps;

/// Every demo scene: file stem, what it shows, the scene.
pub fn all() -> Vec<(&'static str, &'static str, Scene)> {
    vec![
        (
            "room",
            "a furnished room: sun and sky through a window, a floor lamp, a picture spot and a spot behind a plant",
            room::room(),
        ),
        ("knots", "torus knots and spheres over a floor under three coloured lamps", knots::knots()),
        ("columns", "a colonnade in low sun: long shadows of open and closed casters", columns::columns()),
        ("foliage", "leaf cards with holes in sun and lamplight: shadows texel by texel", foliage::foliage()),
        ("leaves", "open leaves of either winding close up under a spot", plant::leaves()),
        (
            "tentacles",
            "skinned tentacles that toss a ball around an opening bud (--time)",
            tentacles::tentacles(),
        ),
    ]
}

/// Scenes in which several kinds of shadow nodes work, each where it is at home: file stem, what it shows, the scene.
pub fn mixed() -> Vec<(&'static str, &'static str, Scene)> {
    vec![
        (
            "chapel",
            "a chapel: sun through coloured glass (hard and transparent nodes on one light), candles with a size",
            chapel::chapel(),
        ),
        (
            "still-life",
            "glass and fruit on a table: planar and transparent nodes on one light, a soft window, a silhouette map",
            still_life::still_life(),
        ),
        (
            "valley",
            "a valley through a day (--time): cascades over the land, exact shadows in the hamlet, a lantern",
            valley::valley(),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use shadowgraph_engine::scene::LightKind;

    #[test]
    fn every_demo_scene_poses_and_has_what_a_picture_needs() {
        for (stem, shows, scene) in super::all() {
            let snapshot = scene.snapshot().expect("demo scenes pose");
            let triangles: usize = snapshot.instances.iter().map(|i| i.mesh.triangle_count()).sum();
            assert!(!shows.is_empty() && (1_000..60_000).contains(&triangles), "{stem}: {triangles}");
            let camera =
                snapshot.cameras.iter().find(|camera| camera.name == "main").expect("a camera 'main'");
            let frustum = camera.frustum([1280, 720]);
            assert!(
                snapshot.instances.iter().filter(|i| frustum.may_see(&i.world_bounds)).count() > 4,
                "{stem}"
            );
            // Every light is shadowed by exactly one node, so that no caster is claimed twice.
            for light in 0..snapshot.lights.len() {
                let claims = snapshot.shadow_nodes.iter().filter(|node| node.lights.contains(&light)).count();
                assert_eq!(claims, 1, "{stem}: {}", snapshot.lights[light].name);
            }
            assert!(snapshot.shadow_nodes.iter().all(|node| node.shadow.technique == "ShadowVolumeHard"));
        }
    }

    /// Together they have every kind of node, and some light that several nodes share.
    #[test]
    fn mixed_scenes_have_every_kind_of_node() {
        let mut techniques = std::collections::BTreeSet::new();
        let mut shared = 0;
        for (stem, shows, scene) in super::mixed() {
            let snapshot = scene.snapshot().expect("demo scenes pose");
            let triangles: usize = snapshot.instances.iter().map(|i| i.mesh.triangle_count()).sum();
            assert!(!shows.is_empty() && (1_000..90_000).contains(&triangles), "{stem}: {triangles}");
            assert!(snapshot.cameras.iter().any(|camera| camera.name == "main"), "{stem}");
            techniques.extend(snapshot.shadow_nodes.iter().map(|node| node.shadow.technique.clone()));
            for light in 0..snapshot.lights.len() {
                let claims = snapshot.shadow_nodes.iter().filter(|node| node.lights.contains(&light)).count();
                assert!(claims > 0, "{stem}: {}", snapshot.lights[light].name);
                shared += usize::from(claims > 1);
            }
        }
        let known: std::collections::BTreeSet<_> =
            shadowgraph_nodes::catalog().entries().iter().map(|entry| entry.type_name.to_owned()).collect();
        assert_eq!(techniques, known);
        assert!(shared >= 3, "{shared} lights are shared");
    }

    #[test]
    fn the_room_has_lights_of_every_kind_and_two_scopes() {
        let snapshot = super::room::room().snapshot().expect("the room poses");
        let has =
            |wanted: fn(&LightKind) -> bool| snapshot.lights.iter().any(|light| wanted(&light.light.kind));
        assert!(has(|k| *k == LightKind::Directional) && has(|k| *k == LightKind::Point));
        assert!(has(|k| matches!(k, LightKind::Spot { .. })) && snapshot.lights.len() >= 4);
        assert_eq!(snapshot.shadow_nodes.len(), 2);
        assert!(snapshot.shadow_nodes[0].casters.len() > snapshot.shadow_nodes[1].casters.len());
    }
}
