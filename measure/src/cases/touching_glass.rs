//! Glass that touches what it stands on, or other glass.
//!
//! A pane in the receiver's own plane tints nothing of it; of panes in one place each counts on what lies beyond.

use glam::{DAffine3, DVec3, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::quad;
use shadowgraph_engine::scene::Material;

use super::glass::glass;
use super::stage::{Stage, at, block, p, triangles, v};
use super::ties::{Cut, level, patch, tilted, turned_at};

/// Lets a half of it pass.
const ROSE: Vec3 = Vec3::new(0.9, 0.3, 0.3);
/// What one surface of it lets pass.
const ONCE: [f32; 3] = [0.45, 0.15, 0.15];
const LAMP: DVec3 = DVec3::new(-2.0, 3.0, 2.0);

impl Stage {
    fn rose(self, data: MeshData) -> Self {
        self.rose_at(data, DAffine3::IDENTITY)
    }

    fn rose_at(self, data: MeshData, world_from_local: DAffine3) -> Self {
        self.worn_at(data, glass(ROSE, 0.5), world_from_local)
    }
}

pub(super) fn glass_on_floor() -> Vec<Stage> {
    let pane = |cut: Cut| patch(level(1.0, 0.0), cut).named("pane");
    let under = [p(0.4, 0.0, 0.3), p(-0.5, 0.0, 0.7), p(0.7, 0.0, -0.6)];
    let stage = |name: &str| Stage::small(name).floor().control().lit(&under);
    let turned = turned_at(p(0.0, 0.9, 0.0));
    let on_board = [p(0.2, 0.0, 0.1), p(-0.4, 0.0, -0.3)].map(|point| turned.transform_point3(point));
    let single_sided = Material { double_sided: false, ..glass(ROSE, 0.5) };
    vec![
        stage("same-diagonal").rose(pane(Cut::First)).point(LAMP),
        stage("other-diagonal").rose(pane(Cut::Other)).sun(p(0.5, -1.0, -0.4)),
        stage("grid-ortho").rose(pane(Cut::Grid(3, 2))).point(LAMP).ortho(2.2, 0.1, 30.0),
        // Facing down, it is not even seen.
        stage("facing-down").worn_at(pane(Cut::Fan).flipped(), single_sided, DAffine3::IDENTITY).point(LAMP),
        // Its node turns it in its own plane.
        stage("turned-in-plane").rose_at(pane(Cut::Turned), DAffine3::from_rotation_y(0.4)).point(LAMP),
        Stage::small("tilted-board")
            .floor()
            .caster(patch(tilted(0.75), Cut::First))
            .rose(patch(tilted(0.75), Cut::Turned))
            .point(p(1.0, 4.0, 2.0))
            .eye(p(-3.0, 4.5, 4.0), p(0.0, 0.5, 0.0))
            .lit(&[p(0.3, 1.05, 0.1)]),
        Stage::small("turned-board")
            .floor()
            .caster_at(patch(level(0.7, 0.0), Cut::First), turned)
            .rose_at(patch(level(0.7, 0.0), Cut::Grid(2, 3)), turned)
            .sun(p(0.5, -1.0, -0.4))
            .lit(&on_board),
    ]
}

pub(super) fn glass_on_box() -> Vec<Stage> {
    let pedestal = || block(v(0.0, 0.5, 0.0), v(0.5, 0.5, 0.5));
    let cube = || block(v(0.2, 1.25, 0.2), v(0.25, 0.25, 0.25)).named("glass");
    let stage = |name: &str| Stage::small(name).floor().caster(pedestal());
    // Inside of the cube's foot one surface is between the light and the box, the one light comes in through.
    let inside = [p(0.2, 1.0, 0.2), p(0.3, 1.0, 0.1)];
    let place = DAffine3::from_rotation_y(0.5);
    vec![
        stage("lamp").rose(cube()).point(LAMP).factor(&inside, ONCE).lit(&[p(-0.3, 1.0, -0.3)]),
        stage("sun").rose(cube()).sun(p(0.5, -1.0, -0.4)).factor(&inside, ONCE),
        stage("flipped").rose(cube().flipped()).point(LAMP).factor(&inside, ONCE),
        // Without its bottom nothing touches, and the same is right.
        stage("bottomless")
            .rose(cube().without_triangles(|triangle| triangle / 2 == 3))
            .point(LAMP)
            .factor(&inside, ONCE),
        stage("grid-top")
            .caster(patch(level(0.5, 1.0), Cut::Grid(2, 3)))
            .rose(cube())
            .point(LAMP)
            .factor(&inside, ONCE),
        Stage::small("turned-by-node")
            .floor()
            .caster_at(pedestal(), place)
            .rose_at(cube(), place)
            .point(LAMP)
            .factor(&inside.map(|point| place.transform_point3(point)), ONCE),
    ]
}

pub(super) fn glass_on_glass() -> Vec<Stage> {
    let pane = |half: f32, cut: Cut| patch(level(half, 1.2), cut).named("pane");
    let stage = |name: &str| Stage::small(name).floor().point(p(0.0, 3.6, 0.0));
    // Right under the lamp, half as large again on the floor: through both, and through the larger one alone.
    let (both, one) = ([p(0.3, 0.0, 0.2), p(-0.4, 0.0, 0.3)], [p(0.9, 0.0, 0.3)]);
    let twice = ONCE.map(|share| share * share);
    let judged = |stage: Stage| stage.factor(&both, twice).factor(&one, ONCE).lit(&[p(1.5, 0.0, 0.5)]);
    vec![
        judged(stage("other-diagonal").rose(pane(0.8, Cut::First)).rose(pane(0.45, Cut::Other))),
        judged(stage("grid").rose(pane(0.8, Cut::Grid(3, 2))).rose(pane(0.45, Cut::Turned))),
        judged(stage("flipped").rose(pane(0.8, Cut::Fan)).rose(pane(0.45, Cut::First).flipped())),
        // A cube of glass on a pane: its bottom, its top and the pane.
        stage("cube-on-pane")
            .rose(pane(0.8, Cut::First))
            .rose(block(v(0.0, 1.35, 0.0), v(0.3, 0.15, 0.3)).named("glass"))
            .factor(&[p(0.2, 0.0, 0.1)], ONCE.map(|share| share.powi(3)))
            .factor(&one, ONCE),
        stage("cube-on-cube")
            .rose(block(v(0.0, 1.05, 0.0), v(0.4, 0.15, 0.4)).named("glass"))
            .rose(block(v(0.0, 1.35, 0.0), v(0.3, 0.15, 0.3)).named("glass"))
            .factor(&[p(0.2, 0.0, 0.1)], ONCE.map(|share| share.powi(4))),
        stage("turned-by-node")
            .rose_at(patch(level(0.7, 0.0), Cut::First), turned_at(p(0.0, 1.2, 0.0)))
            .rose_at(patch(level(0.7, 0.0), Cut::Grid(2, 2)), turned_at(p(0.0, 1.2, 0.0)))
            .factor(&[p(0.2, 0.0, 0.1)], twice),
    ]
}

pub(super) fn coincident_panes() -> Vec<Stage> {
    let corners = [v(-0.7, 1.5, 0.6), v(0.7, 1.3, 0.5), v(0.1, 1.6, -0.7)];
    // The same three corners: one after another, from another corner on, or the other way round.
    let orders = [[0, 1, 2], [1, 2, 0], [2, 1, 0], [0, 2, 1], [2, 0, 1]];
    let panes = |which: &[usize]| -> MeshData {
        let indices: Vec<u32> = which.iter().flat_map(|order| orders[*order]).collect();
        triangles("panes", &corners, &indices)
    };
    let stage = |name: &str| Stage::small(name).floor().point(p(0.0, 4.0, 0.0)).lit(&[p(-1.5, 0.0, 1.2)]);
    let under = [p(0.05, 0.0, 0.2), p(0.3, 0.0, 0.4)];
    let times = |count: i32| ONCE.map(|share| share.powi(count));
    let of = |name: &str, which: &[usize]| {
        stage(name).rose(panes(which)).factor(&under, times(which.len() as i32))
    };
    let two = stage("two-meshes").rose(panes(&[0, 2])).rose(panes(&[1]));
    let colors = [Vec3::new(1.0, 0.5, 0.5), Vec3::new(0.5, 1.0, 0.5), Vec3::new(0.5, 0.5, 1.0)];
    let tinted = (0..3).fold(stage("three-tints"), |stage, i| {
        stage.worn_at(panes(&[i]), glass(colors[i], 0.5), DAffine3::IDENTITY)
    });
    vec![
        of("three", &[0, 0, 0]),
        of("three-turned", &[0, 1, 4]),
        of("four-both-ways", &[0, 2, 1, 3]),
        of("five", &[2, 0, 3, 1, 4]),
        two.factor(&under, times(3)),
        tinted.factor(&under, [0.031_25; 3]),
        stage("moved-by-node")
            .rose_at(panes(&[0, 3, 1]), at(0.1, 0.05, -0.1))
            .sun(p(0.2, -1.0, 0.1))
            .factor(&under, times(3)),
    ]
}

/// Two panes that share an edge and open by so many radians: next to the edge, less than depths can tell is between the upper one,
/// which tints, and the lower one. Its direction tells it.
fn folded_panes(opening_rad: f32) -> MeshData {
    let rise = opening_rad * 1.25;
    MeshData::merged(
        "fold",
        [
            quad([v(0.0, 0.0, 1.0), v(1.25, 0.0, 1.0), v(1.25, 0.0, -1.0), v(0.0, 0.0, -1.0)]),
            quad([v(0.0, 0.0, 1.0), v(1.25, rise, 1.0), v(1.25, rise, -1.0), v(0.0, 0.0, -1.0)]),
        ],
    )
}

pub(super) fn folded_glass() -> Vec<Stage> {
    let lamp = p(0.3, 4.0, 0.5);
    let over = p(0.35, 5.5, 1.5);
    let stage = |name: &str, opening_rad: f32| {
        let fold = folded_panes(opening_rad);
        Stage::small(name)
            .floor()
            .rose_at(fold, at(0.0, 0.8, 0.0))
            .eye(over, p(0.1, 0.8, 0.0))
            .lens(15.0, 0.1)
    };
    let turned = turned_at(p(0.0, 0.9, 0.0));
    vec![
        stage("opening-0.0006", 6e-4).point(lamp),
        stage("opening-0.001", 1e-3).sun(p(0.1, -1.0, 0.2)),
        stage("opening-0.01", 1e-2).point(lamp),
        stage("from-below", 1e-3).point(lamp).eye(p(0.3, 0.3, 3.0), p(0.1, 0.7, 0.0)).lens(40.0, 0.05),
        stage("ortho", 1e-3).point(lamp).ortho(0.4, 0.1, 30.0),
        Stage::small("turned-by-node")
            .floor()
            .rose_at(folded_panes(1e-3), turned)
            .point(turned.transform_point3(p(0.3, 4.0, 0.5)))
            .eye(turned.transform_point3(p(0.35, 5.0, 1.5)), turned.transform_point3(p(0.1, 0.0, 0.0)))
            .lens(15.0, 0.1),
    ]
}
