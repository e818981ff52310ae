//! How many surfaces lie between: stacks whose counts are multiples of 256 or lie above the integers of half floats.

use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{cuboid, quad};

use super::lights::open_block;
use super::stage::{Stage, p, v};

/// The stacks stand between these heights; layers are 2⁻ⁿ apart so that f32 holds every one of them.
const FOOT: f32 = 1.0;

fn stack(name: &str, layers: u32, layer: impl Fn(f32, f32) -> MeshData) -> MeshData {
    let pitch = 1.0 / layers.next_power_of_two() as f32;
    MeshData::merged(name, (0..layers).map(|i| layer(FOOT + i as f32 * pitch, pitch * 0.5)))
}

pub(super) fn boxes(layers: u32) -> MeshData {
    stack("boxes", layers, |y, height| cuboid(v(-0.25, y, -0.25), v(0.25, y + height, 0.25)))
}

/// Boxes without their +z face: two surfaces each, and never closed.
fn open_boxes(layers: u32) -> MeshData {
    stack("open boxes", layers, |y, height| {
        open_block(v(0.0, y + height * 0.5, 0.0), v(0.25, height * 0.5, 0.25), &[4])
    })
}

pub(super) fn quads(layers: u32) -> MeshData {
    stack("quads", layers, |y, _| {
        quad([v(-0.25, y, 0.25), v(0.25, y, 0.25), v(0.25, y, -0.25), v(-0.25, y, -0.25)])
    })
}

pub(super) fn under(name: &str, stack: MeshData) -> Stage {
    Stage::new(name)
        .floor()
        .caster(stack)
        .point(p(0.0, 6.0, 0.0))
        .eye(p(1.5, 2.5, 3.0), p(0.0, 0.4, 0.0))
        .dark(&[p(0.1, 0.0, 0.15), p(-0.15, 0.0, 0.1), p(0.2, 0.0, 0.2)])
        .lit(&[p(0.6, 0.0, 0.0)])
}

pub(super) fn overlap_256() -> Vec<Stage> {
    vec![under("", boxes(256))]
}

pub(super) fn overlap_512() -> Vec<Stage> {
    vec![under("", boxes(512))]
}

pub(super) fn overlap_open_128() -> Vec<Stage> {
    vec![
        // 128 open boxes are 256 surfaces, and so are 256 quads.
        under("128-boxes", open_boxes(128)),
        under("256-boxes", open_boxes(256)),
        under("128-quads", quads(128)),
        under("256-quads", quads(256)),
    ]
}

pub(super) fn overlap_2049() -> Vec<Stage> {
    vec![under("", boxes(2049))]
}

pub(super) fn overlap_4096() -> Vec<Stage> {
    vec![under("", boxes(4096))]
}

pub(super) fn overlap_seen_through() -> Vec<Stage> {
    // The view enters and leaves every volume on its way to a wall in full light.
    let through = |name: &str, stack: MeshData| {
        let wall = quad([v(-2.0, 0.0, -2.0), v(2.0, 0.0, -2.0), v(2.0, 2.0, -2.0), v(-2.0, 2.0, -2.0)]);
        Stage::new(name)
            .floor()
            .caster(wall.named("wall"))
            .caster(stack)
            .sun(p(0.1, -1.0, -0.05))
            .eye(p(0.0, 0.7, 3.0), p(0.0, 0.4, 0.0))
            .lens(40.0, 0.1)
            .lit(&[p(0.1, 0.5, -2.0), p(-0.1, 0.2, -2.0)])
            .dark(&[p(0.15, 0.0, -0.05)])
    };
    vec![
        through("256-boxes", boxes(256)),
        through("256-quads", quads(256)),
        through("2049-boxes", boxes(2049)),
    ]
}
