//! Where the world lies and how it is stretched: far from the origin, tiny, huge, mirrored, sheared, flattened.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{icosphere, plane, quad, torus_knot};
use shadowgraph_engine::scene::placed;

use super::Expect;
use super::stage::{Stage, at, block, p, v};

/// The base scene, whose coordinates are all multiples of 1/16 m: f32 holds them exactly up to 2²⁰ m away.
fn base_shapes() -> Vec<MeshData> {
    let leaf = quad([v(-1.5, 0.75, 0.5), v(-0.75, 0.75, 0.5), v(-0.75, 1.5, -0.25), v(-1.5, 1.5, -0.25)]);
    vec![
        plane(Vec2::splat(4.0)).named("floor"),
        block(v(0.25, 1.0, 0.0), v(0.5, 0.375, 0.5)),
        block(v(1.5, 0.25, 1.0), v(0.25, 0.25, 0.25)),
        leaf,
    ]
}

/// The base scene under `world_from_base`, either by each mesh's node or baked into its vertices.
fn base_under(name: &str, world_from_base: DAffine3, baked: bool) -> Stage {
    let to_world = |point: DVec3| world_from_base.transform_point3(point);
    let scale = world_from_base.matrix3.x_axis.length();
    let mut stage = Stage::new(name)
        .point(to_world(p(-1.0, 4.0, 1.0)))
        .eye(to_world(p(3.0, 4.0, 6.0)), to_world(p(0.0, 0.5, 0.0)))
        .lens(45.0, 0.125 * scale)
        .dark(&[p(0.6, 0.0, -0.3), p(1.8, 0.0, 0.95)].map(to_world))
        .lit(&[p(-0.5, 0.0, 1.6), p(0.9, 0.0, 1.6)].map(to_world));
    for shape in base_shapes() {
        stage = if baked {
            stage.caster(shape.transformed(&world_from_base))
        } else {
            stage.caster_at(shape, world_from_base)
        };
    }
    stage
}

/// The base scene shifted by about `distance` along every axis, in whole metres. "origin" is the twin to compare with.
fn offset(distance: f64) -> Vec<Stage> {
    let shift = at(distance, (distance * 0.25).round(), -distance);
    let home = base_under("origin", DAffine3::IDENTITY, false);
    vec![home, base_under("by-node", shift, false), base_under("baked", shift, true)]
}

pub(super) fn offset_1e4() -> Vec<Stage> {
    offset(1e4)
}

pub(super) fn offset_1e5() -> Vec<Stage> {
    offset(1e5)
}

pub(super) fn offset_1e6() -> Vec<Stage> {
    offset(1e6)
}

fn scaled(scale: f64) -> Vec<Stage> {
    let scale = DAffine3::from_scale(DVec3::splat(scale));
    let home = base_under("unscaled", DAffine3::IDENTITY, false);
    vec![home, base_under("by-node", scale, false), base_under("baked", scale, true)]
}

pub(super) fn scale_tiny() -> Vec<Stage> {
    scaled(1e-4)
}

pub(super) fn scale_huge() -> Vec<Stage> {
    scaled(1e4)
}

fn knot() -> MeshData {
    torus_knot([2, 3], 0.5, 0.125, [64, 8])
}

fn ball() -> MeshData {
    icosphere(0.5, 2)
}

fn under(name: &str, data: MeshData, transform: DAffine3) -> Stage {
    Stage::new(name).floor().caster_at(data, transform).point(p(-1.0, 4.0, 1.0))
}

pub(super) fn mirrored() -> Vec<Stage> {
    let turn = DQuat::from_rotation_y(0.4) * DQuat::from_rotation_x(0.3);
    let place = |x: f64, y: f64, z: f64| placed(p(0.0, 1.2, 0.0), turn, DVec3::new(x, y, z));
    vec![
        under("x", knot(), place(-1.0, 1.0, 1.0)),
        under("xyz", knot(), place(-1.0, -1.0, -1.0)),
        under("two-axes", knot(), place(-1.0, 1.0, -1.0)),
        under("ball", ball(), place(1.0, -1.2, 1.0)).dark(&[p(0.4, 0.0, -0.4)]),
        under(
            "quad",
            quad([v(-0.5, 0.0, 0.5), v(0.5, 0.0, 0.5), v(0.5, 0.0, -0.5), v(-0.5, 0.0, -0.5)]),
            place(1.0, 1.0, -1.0),
        )
        .dark(&[p(0.4, 0.0, -0.4)]),
    ]
}

pub(super) fn non_uniform() -> Vec<Stage> {
    let turn = DQuat::from_rotation_z(0.5) * DQuat::from_rotation_x(0.3);
    vec![
        under("flat", ball(), placed(p(0.0, 1.2, 0.0), turn, DVec3::new(2.0, 0.1, 1.0)))
            .dark(&[p(0.4, 0.0, -0.4)]),
        under("thin", knot(), placed(p(0.0, 1.2, 0.0), turn, DVec3::new(1.0, 2.0, 0.05))),
        under("thousand-to-one", ball(), placed(p(0.0, 1.2, 0.0), turn, DVec3::new(2.0, 1.0, 1e-3))),
    ]
}

pub(super) fn sheared() -> Vec<Stage> {
    let shear = |xy: f64, zy: f64| {
        let matrix = DMat3::from_cols(DVec3::X, DVec3::new(xy, 1.0, zy), DVec3::Z);
        DAffine3::from_mat3_translation(matrix, p(0.0, 1.2, 0.0))
    };
    vec![
        under("box", block(v(0.0, 0.0, 0.0), v(0.4, 0.4, 0.4)), shear(0.8, -0.3)).dark(&[p(0.4, 0.0, -0.4)]),
        under("knot", knot(), shear(-1.5, 0.5)),
    ]
}

pub(super) fn singular() -> Vec<Stage> {
    let place = |scale: DVec3| placed(p(0.0, 1.2, 0.0), DQuat::from_rotation_z(0.3), scale);
    vec![
        // A ball flattened to a disc: every surface lies on another.
        under("disc", ball(), place(DVec3::new(1.2, 0.0, 1.2))).dark(&[p(0.4, 0.0, -0.4)]),
        under("box-to-quad", block(v(0.0, 0.0, 0.0), v(0.5, 0.5, 0.5)), place(DVec3::new(1.0, 0.0, 1.0)))
            .dark(&[p(0.4, 0.0, -0.4)]),
        under("line", ball(), place(DVec3::new(1.0, 0.0, 0.0))).control().lit(&[p(0.4, 0.0, -0.42)]),
        under("point", ball(), place(DVec3::ZERO)).control().lit(&[p(0.4, 0.0, -0.4)]),
        under("almost", ball(), place(DVec3::new(1.2, 1e-9, 1.2))).expects(Expect::Matches),
    ]
}
