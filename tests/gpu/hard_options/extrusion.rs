//! `extrusion`: volumes end on a plane where that is exact, and only there.

use shadowgraph::prelude::*;

use super::stage::{errors, open_box, p, request, scene, with_node};

/// A receiver that does not cast: a square of half side `half` at this height.
fn shelf(half: f32, y: f32) -> MeshData {
    let corners = [[-half, y, half], [half, y, half], [half, y, -half], [-half, y, -half]];
    shapes::quad(corners.map(Vec3::from)).named("shelf")
}

/// An upright square behind the caster.
fn wall() -> MeshData {
    let corners = [[-4.0, 0.0, -1.2], [4.0, 0.0, -1.2], [4.0, 4.0, -1.2], [-4.0, 4.0, -1.2]];
    shapes::quad(corners.map(Vec3::from)).named("wall")
}

fn room(half: f32) -> MeshData {
    open_box("room", [0.0, half, 0.0], half, &[]).flipped()
}

fn small(y: f32) -> MeshData {
    open_box("small", [0.0, y, 0.0], 0.3, &[])
}

struct Shown {
    name: &'static str,
    meshes: Vec<MeshData>,
    light: DVec3,
    view: FrameRequest,
    /// Where the volume of "small" ends.
    ends: &'static str,
}

fn shown() -> Vec<Shown> {
    let eye = || request(p(2.5, 3.0, 4.5), p(0.0, 0.3, 0.0));
    let row = |name, meshes, light, view, ends| Shown { name, meshes, light, view, ends };
    // A ring of posts around the lamp: whatever the plane, some post is not between it and the lamp.
    let posts = MeshData::merged(
        "small",
        [[1.0_f32, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]
            .map(|[x, z]| shapes::cuboid(Vec3::new(x - 0.1, 0.0, z - 0.1), Vec3::new(x + 0.1, 3.0, z + 0.1))),
    );
    let above = || p(0.4, 4.0, 0.3);
    vec![
        row("one floor below", vec![shelf(4.0, 0.0), small(1.2)], above(), eye(), "to a plane"),
        // The plane lies below the lowest receiver, not the nearest.
        row(
            "a second floor far below the first",
            vec![shelf(0.9, 0.0), small(1.2), shelf(9.0, -4.0)],
            above(),
            request(p(2.5, 4.0, 4.5), p(0.0, -1.0, 0.0)),
            "to a plane",
        ),
        // Receivers above the caster and below it, the lamp between caster and ceiling.
        row(
            "receivers on both sides",
            vec![shelf(4.0, 0.0), small(1.2), shelf(4.0, 3.2)],
            p(0.2, 2.4, 0.1),
            request(p(3.0, 1.5, 3.5), p(0.0, 1.2, 0.0)),
            "to a plane",
        ),
        // The lamp below the caster: the plane is above the ceiling.
        row(
            "lit from below",
            vec![shelf(4.0, 0.0), small(1.5), shelf(4.0, 3.2)],
            p(0.2, 0.4, 0.1),
            request(p(3.0, 1.5, 3.5), p(0.0, 1.8, 0.0)),
            "to a plane",
        ),
        row(
            "a room all round",
            vec![room(3.0), small(1.0)],
            p(0.5, 4.5, 0.4),
            request(p(2.0, 2.0, 2.4), p(0.0, 1.0, 0.0)),
            "to a plane",
        ),
        // Nothing is below but the eye: its view enters the volume far down, and leaves it before a wall in light.
        row(
            "the eye behind all receivers",
            vec![small(1.2), wall()],
            p(1.0, 4.0, 0.6),
            request(p(-0.6, -3.0, 0.3), p(-0.5, 1.5, -1.0)),
            "to a plane",
        ),
        row(
            "the lamp amid the caster",
            vec![shelf(4.0, 0.0), posts],
            p(0.0, 1.5, 0.0),
            request(p(3.5, 4.5, 3.5), DVec3::ZERO),
            "to infinity",
        ),
    ]
}

#[test]
fn ends_are_exact_where_they_are_taken_and_taken_only_where_they_are_exact() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for Shown { name, meshes, light, view, ends } in shown() {
        let mut base = scene(meshes, &[light]);
        // Only "small" casts, so that the end is that of its volume.
        let keys: Vec<_> = base.nodes().map(|(key, _)| key).collect();
        for key in keys {
            let node = base.node_mut(key).unwrap();
            let casts = node.name == "small";
            if let Content::Mesh(mesh) = &mut node.content {
                mesh.shadow.casts = casts;
            }
        }
        let auto = with_node(&base, ShadowVolumeHard::default());
        let plan = renderer.plan(&auto, &view).unwrap();
        let volumes: Vec<_> = plan.passes_named("volumes of").flat_map(|pass| &pass.draws).collect();
        assert!(
            !volumes.is_empty() && volumes.iter().all(|draw| draw.name.ends_with(ends)),
            "{name}:\n{plan}"
        );
        let errors = errors(&mut renderer, name, &auto, &view);
        assert!(errors[0].passes(), "{name}");
        // `toBounds` is refused exactly where there is no such plane, by name and with what is accepted.
        let forced = ShadowVolumeHard { extrusion: Extrusion::ToBounds, ..Default::default() };
        match (ends, renderer.plan(&with_node(&base, forced), &view)) {
            ("to a plane", result) => assert!(result.is_ok(), "{name}"),
            (_, Err(error)) => {
                let text = error.to_string();
                assert!(text.contains("'small'") && text.contains("auto, infinite"), "{name}: {text}");
            }
            (_, Ok(plan)) => panic!("{name}: not refused\n{plan}"),
        }
    }
}
