//! Single-sided casters cast from both sides, but only one is drawn: what is seen through them is counted right.

use shadowgraph::prelude::*;

use super::stage::{errors, floor, p, request, scene, with_node};

/// A leaf of one side above a floor, seen through from its undrawn side.
#[test]
fn what_is_seen_through_an_undrawn_side_is_counted() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let quad = |y: f32, flipped: bool| {
        let corners = [[-0.7, y, 0.7], [0.7, y, 0.7], [0.7, y, -0.7], [-0.7, y, -0.7]].map(Vec3::from);
        let quad = shapes::quad(corners);
        if flipped { quad.flipped() } else { quad }
    };
    let above = request(p(1.0, 4.0, 2.0), p(0.0, 0.0, 0.0));
    let below = request(p(2.6, 0.3, 1.2), p(-0.2, 1.3, 0.0));
    for (name, flipped, view, light) in [
        // Seen from above, the leaf faces down: the eye looks through it into its shadow.
        ("into the volume", true, &above, p(-0.6, 4.0, 0.4)),
        // Seen from below, it faces up: the eye looks through the shadow and out of it, at a ceiling in light.
        ("out of the volume", false, &below, p(-0.3, 2.4, 0.2)),
    ] {
        let ceiling = shapes::plane(Vec2::splat(4.0)).flipped().named("ceiling");
        let mut base = scene(vec![floor()], &[light]);
        base.add_mesh(
            shadowgraph_testing::mesh(ceiling),
            Material::default(),
            DAffine3::from_translation(p(0.0, 5.0, 0.0)),
        );
        let one_sided = Material { double_sided: false, ..Material::default() };
        base.add_mesh(
            shadowgraph_testing::mesh(quad(1.2, flipped).named("leaf")),
            one_sided,
            DAffine3::IDENTITY,
        );
        for node in [
            ShadowVolumeHard::default(),
            ShadowVolumeHard { depth_test: DepthTest::ZPass, ..Default::default() },
            ShadowVolumeHard { closure: Closure::Backfaces, ..Default::default() },
        ] {
            let errors = errors(&mut renderer, &format!("{name} {node:?}"), &with_node(&base, node), view);
            assert!(errors[0].passes(), "{name}");
        }
    }
}
