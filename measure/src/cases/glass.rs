//! Casters that let light through: none, all, one channel of it; in every order, in stacks, around other things.
//!
//! A surface of colour c and alpha α lets (1 − α)·c pass, and light counts every surface it meets. Factors are those of
//! the opaque surfaces seen, through the glass too.

use glam::Vec3;
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{icosphere, quad};
use shadowgraph_engine::scene::{AlphaMode, Material};

use super::stage::{Stage, at, block, p, v};

const RED: Vec3 = Vec3::new(1.0, 0.2, 0.2);
const GREEN: Vec3 = Vec3::new(0.2, 1.0, 0.2);

/// A material that lets (1 − `alpha`)·`color` pass.
pub(super) fn glass(color: Vec3, alpha: f32) -> Material {
    Material { base_color: color.extend(alpha), alpha_mode: AlphaMode::Blend, ..Material::default() }
}

impl Stage {
    fn pane(self, data: MeshData, color: Vec3, alpha: f32) -> Self {
        self.caster_in(data, vec![glass(color, alpha)])
    }
}

/// A level sheet around (x, y, z), `half` to each side.
fn level(x: f32, y: f32, z: f32, half: f32) -> MeshData {
    let corner = |dx: f32, dz: f32| v(x + dx * half, y, z + dz * half);
    quad([corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)]).named("pane")
}

fn under_lamp(name: &str) -> Stage {
    Stage::new(name).floor().point(p(0.0, 4.0, 0.0)).lit(&[p(-1.8, 0.0, 1.5)])
}

pub(super) fn alpha_0() -> Vec<Stage> {
    // α = 0 is no surface at all, whatever its colour.
    vec![
        under_lamp("alone").pane(level(0.0, 1.5, 0.0, 0.5), RED, 0.0).control().lit(&[p(0.4, 0.0, 0.3)]),
        under_lamp("over-a-pane")
            .pane(level(0.0, 1.7, 0.0, 0.5), Vec3::ZERO, 0.0)
            .pane(level(0.0, 1.5, 0.0, 0.5), RED, 0.5)
            .factor(&[p(0.4, 0.0, 0.3)], [0.5, 0.1, 0.1]),
    ]
}

pub(super) fn alpha_1() -> Vec<Stage> {
    vec![
        under_lamp("alone").pane(level(0.0, 1.5, 0.0, 0.5), RED, 1.0).dark(&[p(0.4, 0.0, 0.3)]),
        under_lamp("under-a-pane")
            .pane(level(0.0, 1.5, 0.0, 0.5), RED, 1.0)
            .pane(level(0.3, 1.8, 0.0, 0.5), GREEN, 0.2)
            .dark(&[p(0.4, 0.0, 0.3)])
            .factor(&[p(1.2, 0.0, 0.3)], [0.16, 0.8, 0.16]),
    ]
}

pub(super) fn channel_0() -> Vec<Stage> {
    vec![
        under_lamp("one")
            .pane(level(0.0, 1.5, 0.0, 0.5), Vec3::new(1.0, 0.0, 0.5), 0.2)
            .factor(&[p(0.4, 0.0, 0.3)], [0.8, 0.0, 0.4]),
        // Another pane brings nothing back, and a zero more takes nothing away.
        under_lamp("stacked")
            .pane(level(0.0, 1.5, 0.0, 0.5), Vec3::new(1.0, 0.0, 0.5), 0.0625)
            .pane(level(0.0, 1.6, 0.0, 0.5), Vec3::new(1.0, 0.0, 1.0), 0.0625)
            .pane(level(0.0, 1.7, 0.0, 0.5), Vec3::ONE, 0.0625)
            .factor(&[p(0.4, 0.0, 0.3)], [0.823_975, 0.0, 0.411_987]),
    ]
}

pub(super) fn glass_order() -> Vec<Stage> {
    let overlap = [p(0.3, 0.0, 0.3), p(-0.2, 0.0, 0.3)];
    let stage = |name: &str, red_first: bool, red_above: bool| {
        let [red_y, green_y] = if red_above { [1.8, 1.5] } else { [1.5, 1.8] };
        let panes = [(level(-0.2, red_y, 0.0, 0.5), RED), (level(0.2, green_y, 0.0, 0.5), GREEN)];
        let order = if red_first { [0, 1] } else { [1, 0] };
        order
            .into_iter()
            .fold(under_lamp(name), |stage, i| stage.pane(panes[i].0.clone(), panes[i].1, 0.2))
            .factor(&overlap, [0.128, 0.128, 0.0256])
    };
    vec![
        stage("red-above", true, true),
        stage("green-above", true, false),
        stage("red-above-drawn-last", false, true),
        stage("green-above-drawn-last", false, false),
    ]
}

/// Boxes above each other, two surfaces each; what passes all of them is a half of red, a quarter of green and a
/// sixteenth of blue, however many they are.
pub(super) fn tinted_stack(boxes: u32) -> Stage {
    let per_surface = |rest: f32| rest.powf(0.5 / boxes as f32);
    let color = Vec3::new(per_surface(0.5), per_surface(0.25), per_surface(0.0625)) / (1.0 - 0.001);
    Stage::new(format!("{boxes}-boxes"))
        .floor()
        .pane(super::counts::boxes(boxes), color, 0.001)
        .point(p(0.0, 6.0, 0.0))
        .eye(p(1.5, 2.5, 3.0), p(0.0, 0.4, 0.0))
        .factor(&[p(0.1, 0.0, 0.15), p(-0.15, 0.0, 0.1)], [0.5, 0.25, 0.0625])
        // Seen through the stack, and lit.
        .lit(&[p(0.6, 0.0, 0.0), p(-0.8, 0.0, -0.9)])
}

pub(super) fn glass_deep() -> Vec<Stage> {
    [8, 32, 128].map(tinted_stack).to_vec()
}

/// Two panes one above the other, each of which lets this share of green and of red pass, and nine tenths of blue.
pub(super) fn dimmed(name: &str, share: f32) -> Stage {
    let color = Vec3::new(share, share, 0.9);
    under_lamp(name)
        .pane(level(0.0, 1.5, 0.0, 0.5), color / (1.0 - 1.0 / 1024.0), 1.0 / 1024.0)
        .pane(level(0.2, 1.8, 0.0, 0.5), color / (1.0 - 1.0 / 1024.0), 1.0 / 1024.0)
        .factor(&[p(0.4, 0.0, 0.3)], [share * share, share * share, 0.81])
}

pub(super) fn tinted_bottle() -> Vec<Stage> {
    vec![
        Stage::new("")
            .floor()
            .pane(icosphere(0.7, 3).moved(v(0.0, 1.0, 0.0)).named("bottle"), GREEN, 0.2)
            .caster_at(icosphere(0.25, 2).named("core"), at(0.0, 1.0, 0.0))
            .point(p(0.0, 4.0, 0.0))
            .dark(&[p(0.1, 0.0, 0.2)])
            .factor(&[p(0.65, 0.0, 0.2), p(-0.3, 0.0, 0.6)], [0.0256, 0.64, 0.0256])
            .lit(&[p(1.4, 0.0, 0.8)]),
    ]
}

pub(super) fn stained_glass() -> Vec<Stage> {
    let mut stage = Stage::new("window").floor().point(p(0.0, 3.0, 0.0));
    // Four fields: red, green, blue and clear, in sRGB; the last texel's alpha is 0, no surface at all.
    let fields = [[255, 0, 0, 51], [0, 255, 0, 51], [0, 0, 255, 51], [255, 255, 255, 0]];
    let mut texture = stage.texture(2, |x, y| fields[(x + 2 * y) as usize]);
    texture.smooth = false;
    let material = Material { base_color_texture: Some(texture), ..glass(Vec3::ONE, 1.0) };
    let window = level(0.0, 1.5, 0.0, 0.6).named("window");
    vec![
        stage
            .caster_in(window, vec![material])
            // The picture's first row lies at −z, half-way to the light: twice as large on the floor.
            .factor(&[p(-0.7, 0.0, -0.5)], [0.8, 0.0, 0.0])
            .factor(&[p(0.7, 0.0, -0.5)], [0.0, 0.8, 0.0])
            .factor(&[p(-0.7, 0.0, 0.5)], [0.0, 0.0, 0.8])
            .lit(&[p(0.7, 0.0, 0.5)]),
    ]
}

pub(super) fn glass_self() -> Vec<Stage> {
    vec![
        Stage::new("shell")
            .floor()
            .pane(icosphere(0.7, 3).moved(v(0.0, 1.0, 0.0)).named("shell"), RED, 0.2)
            .pane(icosphere(0.4, 2).moved(v(0.0, 1.0, 0.0)).named("inner shell"), GREEN, 0.2)
            .point(p(-1.0, 4.0, 1.0))
            .factor(&[p(0.37, 0.0, -0.3)], [0.016_384, 0.016_384, 0.000_655])
            .lit(&[p(-1.5, 0.0, 1.5)]),
    ]
}

pub(super) fn panes_intersecting() -> Vec<Stage> {
    let tilted = |slope: f32| {
        let y = 1.5;
        quad([
            v(-0.6, y - slope, 0.5),
            v(0.6, y + slope, 0.5),
            v(0.6, y + slope, -0.5),
            v(-0.6, y - slope, -0.5),
        ])
        .named("pane")
    };
    vec![
        under_lamp("")
            .pane(tilted(0.3), RED, 0.2)
            .pane(tilted(-0.3), GREEN, 0.2)
            .factor(&[p(0.5, 0.0, 0.3), p(-0.5, 0.0, 0.3)], [0.128, 0.128, 0.0256]),
    ]
}

pub(super) fn opaque_behind_glass() -> Vec<Stage> {
    let stage = |name: &str, glass_y: f32, box_y: f32| {
        under_lamp(name)
            .pane(level(0.0, glass_y, 0.0, 0.6), RED, 0.2)
            .caster(block(v(0.0, box_y, 0.0), v(0.25, 0.1, 0.25)))
            .dark(&[p(0.2, 0.0, 0.2)])
            .factor(&[p(0.7, 0.0, 0.3)], [0.8, 0.16, 0.16])
    };
    vec![stage("box-below", 1.5, 1.0), stage("box-above", 1.2, 1.7)]
}

pub(super) fn count_figure() -> Vec<Stage> {
    // A soup of half-transparent sheets with an edge of four triangles: none, two, three and three of them lie over
    // the probed points. The last point is seen through the sheets and yet lit.
    let soup = MeshData::merged(
        "soup",
        [
            block(v(0.0, 1.5, 0.0), v(0.4, 0.2, 0.6)),
            // A fin that goes on from the box's upper edge, and another above it.
            quad([v(0.4, 1.7, 0.6), v(0.9, 1.7, 0.6), v(0.9, 1.7, -0.6), v(0.4, 1.7, -0.6)]),
            quad([v(-0.1, 1.9, 0.6), v(0.9, 1.9, 0.6), v(0.9, 1.9, -0.6), v(-0.1, 1.9, -0.6)]),
            quad([v(0.4, 1.5, 0.6), v(0.9, 1.5, 0.6), v(0.9, 1.5, -0.6), v(0.4, 1.5, -0.6)]),
        ],
    );
    let halves = |count: i32| [0.5_f32.powi(count); 3];
    vec![
        Stage::new("")
            .floor()
            .pane(soup, Vec3::ONE, 0.5)
            .sun(p(0.0, -1.0, 0.0))
            .eye(p(2.0, 4.0, 5.0), p(0.0, 0.5, 0.0))
            .lit(&[p(-1.0, 0.0, 0.5), p(-0.6, 0.0, -1.2)])
            .factor(&[p(-0.25, 0.0, 0.3)], halves(2))
            .factor(&[p(0.15, 0.0, 0.3)], halves(3))
            .factor(&[p(0.65, 0.0, 0.3)], halves(3)),
    ]
}
