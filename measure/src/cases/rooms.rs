//! Solids wound inwards and single-sided: rooms seen through the walls that are culled, the usual doll's-house view.
//!
//! Closed casters may cast with half their triangles, those the light meets from outside; the inside of such a solid is
//! seen, and it is dark only by the other half.

use glam::{DAffine3, DQuat, DVec3, Vec2};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{Ends, cylinder, icosphere, plane, torus};
use shadowgraph_engine::scene::placed;

use super::Expect;
use super::stage::{Stage, at, block, p, v};

const SUN: DVec3 = DVec3::new(-0.4, -1.0, -0.3);

/// A room of 3 by 2 by 3 metres, its walls facing inwards.
fn room() -> MeshData {
    block(v(0.0, 1.0, 0.0), v(1.5, 1.0, 1.5)).flipped().named("room")
}

/// Ground below the room's floor, so that something is lit.
fn ground(name: &str) -> Stage {
    let below = plane(Vec2::splat(4.0)).moved(v(0.0, -0.25, 0.0)).named("floor");
    Stage::small(name).caster(below).eye(p(3.0, 4.0, 5.0), p(0.0, 1.0, 0.0))
}

pub(super) fn room_through_culled_walls() -> Vec<Stage> {
    let table = || block(v(0.0, 0.5, 0.0), v(0.25, 0.25, 0.25));
    let inside = [p(0.8, 0.0, 0.5), p(-0.9, 0.0, -0.6), p(-1.5, 0.5, 0.3)];
    let turned = placed(p(0.0, 0.0, 0.0), DQuat::from_rotation_y(0.3), DVec3::ONE);
    let mirrored = placed(p(0.0, 0.0, 0.0), DQuat::from_rotation_y(0.3), DVec3::new(-1.0, 1.0, 1.0));
    let in_node = |name: &str, place: DAffine3| {
        ground(name).culled_at(room(), place).dark(&inside.map(|point| place.transform_point3(point)))
    };
    vec![
        ground("sun").culled(room()).caster(table()).sun(SUN).dark(&inside),
        ground("lamp-outside").culled(room()).caster(table()).point(p(2.0, 4.0, 1.0)).dark(&inside),
        // The lamp hangs inside: its light falls on the walls, and nowhere else.
        ground("lamp-inside")
            .culled(room())
            .caster(table())
            .point(p(0.3, 1.6, 0.2))
            .lit(&[p(0.8, 0.0, 0.5), p(-1.5, 0.5, 0.3)])
            .dark(&[p(-0.1, 0.0, 0.0)]),
        in_node("turned-by-node", turned).sun(SUN),
        in_node("mirrored-by-node", mirrored).point(p(2.0, 4.0, 1.0)),
        // Two rooms that share a wall, in one mesh.
        ground("two-rooms")
            .culled(MeshData::merged(
                "rooms",
                [
                    block(v(-0.75, 1.0, 0.0), v(0.75, 1.0, 1.5)).flipped(),
                    block(v(0.75, 1.0, 0.0), v(0.75, 1.0, 1.5)).flipped(),
                ],
            ))
            .sun(SUN)
            .dark(&[p(0.8, 0.0, 0.5), p(-1.5, 0.5, 0.3)]),
        // Without its ceiling it is open, and light falls in.
        ground("no-ceiling")
            .culled(room().without_triangles(|triangle| triangle / 2 == 2))
            .caster(table())
            .sun(SUN)
            .lit(&[p(-0.8, 0.0, -0.5)])
            .dark(&[p(1.2, 0.0, 0.3)]),
    ]
}

pub(super) fn inward_shell() -> Vec<Stage> {
    let ball = || icosphere(0.8, 2).flipped();
    let drum = || cylinder(0.8, 1.2, 12, Ends::Closed).flipped();
    let up = at(0.0, 1.0, 0.0);
    let mirror = placed(p(0.0, 1.0, 0.0), DQuat::from_rotation_x(0.4), DVec3::new(1.0, 1.0, -1.0));
    vec![
        Stage::small("ball-lamp")
            .floor()
            .culled_at(ball(), up)
            .point(p(-1.0, 4.0, 1.0))
            .dark(&[p(0.3, 0.0, -0.3)]),
        Stage::small("drum-sun")
            .floor()
            .culled_at(drum(), at(0.0, 0.4, 0.0))
            .sun(SUN)
            .dark(&[p(-0.3, 0.4, 0.1)]),
        Stage::small("ring-mirrored").floor().culled_at(torus(0.6, 0.25, 12, 8).flipped(), mirror).sun(SUN),
        Stage::small("ball-ortho")
            .floor()
            .culled_at(ball(), up)
            .point(p(-1.0, 4.0, 1.0))
            .ortho(2.2, 0.1, 30.0)
            .dark(&[p(0.3, 0.0, -0.3)]),
        Stage::small("lamp-inside")
            .floor()
            .culled_at(drum(), at(0.0, 0.4, 0.0))
            .point(p(0.1, 1.0, 0.2))
            .expects(Expect::Matches),
        // A shell in a shell, facing each other.
        Stage::small("shell-in-shell")
            .floor()
            .culled_at(ball(), up)
            .culled_at(icosphere(0.5, 2), up)
            .sun(SUN),
        // Wound outwards, with the eye inside: its walls are not drawn, and what is seen past them is in its shadow.
        Stage::small("eye-inside")
            .floor()
            .culled_at(icosphere(0.8, 2), up)
            .point(p(0.3, 4.0, 0.2))
            .eye(p(0.1, 1.1, 0.2), p(1.5, 0.0, 0.0))
            .lens(70.0, 0.02)
            .lit(&[p(2.0, 0.0, 0.0)])
            .dark(&[p(0.7, 0.0, 0.0)]),
    ]
}
