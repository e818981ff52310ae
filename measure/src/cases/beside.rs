//! Lamps on and beside surfaces, edges and corners, from a hundredth of a millimetre down to nothing; of no size, and of any.
//!
//! Decimals are no binary fractions: a lamp that is put on a box's face stands 1e-17 m off it. From a lamp that all but touches
//! an edge, the edge spans a half circle, and directions lose their digits.

use glam::{DAffine3, DVec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::quad;

use super::Expect;
use super::stage::{Stage, at, block, p, triangles, v};
use super::ties::turned_at;

/// A box over the floor and a wall beside it that is higher: the lamp is about the box's upper side.
fn beside(name: impl Into<String>) -> Stage {
    let wall =
        quad([v(-2.0, 0.0, 2.0), v(-2.0, 0.0, -2.0), v(-2.0, 4.0, -2.0), v(-2.0, 4.0, 2.0)]).named("wall");
    Stage::small(name).floor().caster(wall).caster(block(v(0.0, 1.0, 0.0), v(0.5, 0.5, 0.5)))
}

/// How far off the box lamps are, and what that is called.
const GAPS_M: [(&str, f64); 5] =
    [("1e-5-m", 1e-5), ("1e-7-m", 1e-7), ("1e-9-m", 1e-9), ("1e-12-m", 1e-12), ("on-it", 0.0)];

/// A lamp at `place` on the box and off it by each gap along `out`, seen in perspective and, for some, without; `judged` adds
/// what is right for all of these. Then one just inside the box, and the same turned by a node.
fn at_gaps(place: DVec3, out: DVec3, judged: impl Fn(Stage) -> Stage) -> Vec<Stage> {
    let lamp = |name: &str, gap_m: f64| judged(beside(name).point(place + out * gap_m));
    let mut stages: Vec<Stage> = GAPS_M.iter().map(|(name, gap_m)| lamp(name, *gap_m)).collect();
    let ortho = |name: &str, gap_m: f64| beside(name).point(place + out * gap_m).ortho(3.0, 0.1, 30.0);
    stages.push(ortho("1e-9-m-ortho", 1e-9));
    stages.push(ortho("on-it-ortho", 0.0));
    stages.push(beside("1e-9-m-inside").point(place - out * 1e-9).expects(Expect::Matches));
    let turn = turned_at(p(0.0, 1.2, 0.0));
    let local = place - p(0.0, 1.0, 0.0) + out * 1e-9;
    stages.push(
        Stage::small("1e-9-m-turned")
            .floor()
            .control()
            .caster_at(block(v(0.0, 0.0, 0.0), v(0.5, 0.5, 0.5)), turn)
            .point(turn.transform_point3(local)),
    );
    stages
}

/// Higher than the lamp the wall is lit, below it it is behind the box.
fn on_wall(stage: Stage) -> Stage {
    stage.lit(&[p(-2.0, 2.5, 0.0), p(-2.0, 3.0, 1.0)]).dark(&[p(-2.0, 0.8, 0.2), p(-1.2, 0.0, -0.4)])
}

pub(super) fn lamp_over_face() -> Vec<Stage> {
    // All of the floor is behind the face.
    at_gaps(p(0.1, 1.5, 0.2), DVec3::Y, |stage| on_wall(stage).dark(&[p(1.5, 0.0, 0.5), p(0.3, 0.0, 1.5)]))
}

pub(super) fn lamp_over_edge() -> Vec<Stage> {
    // To the right of the edge the floor is lit.
    at_gaps(p(0.5, 1.5, 0.1), DVec3::Y, |stage| on_wall(stage).lit(&[p(1.5, 0.0, 0.5), p(2.0, 0.0, -0.5)]))
}

pub(super) fn lamp_over_vertex() -> Vec<Stage> {
    let out = DVec3::ONE.normalize();
    at_gaps(p(0.5, 1.5, 0.5), out, |stage| on_wall(stage).lit(&[p(1.5, 0.0, 1.5), p(2.0, 0.0, 0.0)]))
}

/// Two triangles in the air, the lamp on the upper one's lower edge; all that is seen is within its sphere of 5 m.
fn two_triangles(name: &str, lamp: DVec3) -> Stage {
    let corners = [
        v(-1.0, 0.0, -1.0),
        v(1.0, 1.0, -1.0),
        v(-1.0, 1.0, -1.0),
        v(0.0, 2.0, -1.0),
        v(1.0, 1.0, 0.0),
        v(0.0, 2.0, 0.0),
    ];
    Stage::small(name)
        .caster(triangles("two triangles", &corners, &[0, 1, 2, 3, 4, 5]))
        .point(lamp)
        .radius(5.0)
        .eye(p(2.2, -0.08, 0.92), p(-0.2, 0.48, -0.17))
        .lens(90.0, 0.1)
        .expects(Expect::Matches)
}

/// Lamps of these sizes with their centre on the box. Those of 5 m hold all that is seen: it is lit as from their centre.
/// Of those of next to no size, `seen` is the share that is seen from the probed point.
fn sized(place: DVec3, (point, seen): (DVec3, f32)) -> Vec<Stage> {
    let lamp =
        |name: &str, radius_m: f64| beside(name).point(place).radius(radius_m).expects(Expect::Matches);
    let dark = [p(-1.2, 0.0, -0.4), p(-2.0, 0.8, 0.2)];
    let tiny = |name: &str, radius_m: f64| lamp(name, radius_m).dark(&dark).factor(&[point], [seen; 3]);
    vec![
        lamp("5-m", 5.0).dark(&dark).lit(&[point]),
        lamp("1-m", 1.0),
        tiny("1e-4-m", 1e-4),
        tiny("1e-6-m", 1e-6),
        tiny("1e-6-m-ortho", 1e-6).ortho(3.0, 0.1, 30.0),
    ]
}

pub(super) fn soft_lamp_on_edge() -> Vec<Stage> {
    // The disc that faces the point has one half within the box.
    let mut stages = sized(p(0.5, 1.5, 0.1), (p(1.5, 0.0, 0.1), 0.5));
    stages.push(two_triangles("5-m-in-the-air", p(0.5, 1.5, -0.5)));
    stages
}

pub(super) fn soft_lamp_on_corner() -> Vec<Stage> {
    // The disc that faces the point, across (1, −3/2, 1), is within the box between the directions (0, −2/3, −1) and
    // (−1, −2/3, 0): an angle whose cosine is 4/13.
    let hidden = (4.0_f32 / 13.0).acos() / std::f32::consts::TAU;
    let mut stages = sized(p(0.5, 1.5, 0.5), (p(1.5, 0.0, 1.5), 1.0 - hidden));
    stages.push(two_triangles("5-m-in-the-air", p(0.0, 2.0, 0.0)));
    stages
}

/// Lamps sunk half in a floor that casts, with something standing on it: its edges in the floor pass the centre within rounding.
pub(super) fn soft_lamp_in_floor() -> Vec<Stage> {
    let floor =
        || quad([v(-2.0, 0.0, 2.0), v(2.0, 0.0, 2.0), v(2.0, 0.0, -2.0), v(-2.0, 0.0, -2.0)]).named("floor");
    let standing = |name: &str, data: MeshData| {
        Stage::small(name)
            .caster(floor())
            .caster(data)
            .point(p(-0.98, 0.0, -0.57))
            .radius(0.1)
            .expects(Expect::Matches)
    };
    let cube = || block(v(0.0, 0.3, 0.0), v(0.3, 0.3, 0.3));
    let fin = || triangles("fin", &[v(-0.2, 0.0, -0.1), v(0.1, 0.0, 0.08), v(-0.1, 0.6, -0.1)], &[0, 1, 2]);
    let turn = turned_at(p(0.0, 0.6, 0.0));
    let turned = Stage::small("cube-turned")
        .caster_at(floor(), turn)
        .caster_at(cube(), turn)
        .point(turn.transform_point3(p(-0.98, 0.0, -0.57)))
        .radius(0.1)
        .expects(Expect::Matches);
    let on_corner = Stage::small("on-a-cube-level-with-another")
        .floor()
        .caster(block(v(-1.0, 0.5, -1.0), v(0.5, 0.5, 0.5)))
        .caster(block(v(0.75, 0.5, 0.25), v(0.5, 0.5, 0.5)))
        .point(p(-0.5, 1.0, -0.5))
        .radius(0.2)
        .expects(Expect::Matches);
    vec![
        standing("cube", cube()).dark(&[p(0.5, 0.0, 0.25)]),
        standing("fin", fin()),
        standing("cube-ortho", cube()).ortho(2.0, 0.1, 30.0),
        turned,
        on_corner,
    ]
}

pub(super) fn lamp_in_far_plane() -> Vec<Stage> {
    // An upright triangle, from `from` on in the plane z = 0 and `size` large; the lamp is next to that plane, far from it.
    let far = |from: f32, size: f32| {
        triangles("far", &[v(from, 0.2, 0.0), v(from + size, 0.2, 0.0), v(from, 0.2 + size, 0.0)], &[0, 1, 2])
    };
    let lamp = |name: &str, data: MeshData, off_m: f64| {
        Stage::small(name)
            .floor()
            .control()
            .caster(data)
            .point(p(-1.0, 2.5, off_m))
            .lit(&[p(0.4, 0.0, 0.4), p(-0.5, 0.0, -0.6)])
            .dark(&[p(3.3, 0.0, 1.8)])
            .eye(p(3.5, 5.0, 7.0), p(0.5, 0.2, 0.0))
    };
    let leaning = |off_m: f64| {
        let turn = turned_at(DVec3::ZERO);
        let data = far(2.0, 3.0).transformed(&turn);
        let lamp = turn.transform_point3(p(-1.5, 2.5, off_m));
        Stage::small(format!("leaning-{off_m:e}-m")).floor().control().caster(data).point(lamp)
    };
    vec![
        lamp("2-m-1e-4-m", far(2.0, 1.5), 1e-4),
        lamp("2-m-1e-7-m", far(2.0, 1.5), 1e-7),
        lamp("2-m-1e-10-m", far(2.0, 1.5), 1e-10),
        lamp("60-m-1e-6-m", far(60.0, 100.0), 1e-6),
        lamp("ortho-1e-7-m", far(2.0, 1.5), 1e-7).ortho(3.0, 0.1, 30.0),
        leaning(1e-6),
        leaning(1e-9),
    ]
}

pub(super) fn ortho_lamp_beside() -> Vec<Stage> {
    // Volumes that end as a copy scaled about the lamp have no end where the lamp is next to the caster.
    let leaf =
        || quad([v(-0.5, 1.2, 0.5), v(0.5, 1.2, 0.5), v(0.5, 1.2, -0.5), v(-0.5, 1.2, -0.5)]).named("leaf");
    let lamp = |name: &str, data: MeshData, lamp: DVec3| {
        Stage::small(name).floor().control().caster(data).point(lamp).ortho(2.5, 0.1, 40.0)
    };
    let solid = || block(v(0.0, 1.2, 0.0), v(0.5, 0.3, 0.5));
    vec![
        lamp("1e-2-m-over-leaf", leaf(), p(0.1, 1.21, 0.2)).dark(&[p(0.5, 0.0, 0.5)]),
        lamp("1e-6-m-over-leaf", leaf(), p(0.1, 1.200_001, 0.2)).dark(&[p(0.5, 0.0, 0.5)]),
        lamp("1e-4-m-beside-leaf", leaf(), p(0.5001, 1.2, 0.1)).lit(&[p(1.0, 0.0, 0.5)]),
        lamp("1e-3-m-beside-box", solid(), p(0.501, 1.3, 0.1))
            .dark(&[p(-0.3, 0.0, 0.8)])
            .lit(&[p(1.2, 0.0, 0.3)]),
        lamp("1e-6-m-beside-box", solid(), p(0.500_001, 1.3, 0.1)).dark(&[p(-0.3, 0.0, 0.8)]),
        lamp("under-box", solid(), p(0.1, 0.899_99, 0.2)).lit(&[p(0.5, 0.0, 0.5)]),
    ]
}

pub(super) fn turned_from_centre() -> Vec<Stage> {
    // The ball casts through a node that gives the lamp a radius; all else through the one that is tried. Of the leaning
    // board's upper side, the lamp's centre is behind the plane, and a part of its sphere before it.
    let ball = || shadowgraph_engine::geometry::shapes::icosphere(0.2, 1).named("ball");
    let board = || super::ties::patch(super::ties::level(0.8, 0.0), super::ties::Cut::Other).named("board");
    let lean = |degrees: f64| at(-0.3, 1.0, 0.0) * DAffine3::from_rotation_z(degrees.to_radians());
    let stage = |name: &str, place: DAffine3| {
        Stage::small(name)
            .floor()
            .caster_at(board(), place)
            .beside(ball(), at(1.0, 0.8, 0.6), 0.6)
            .point(p(2.5, 1.0, 0.5))
            .expects(Expect::Matches)
            .lit(&[p(2.0, 0.0, 1.5)])
    };
    vec![
        stage("from-behind", lean(4.0)),
        stage("edge-on", lean(0.1)),
        stage("tilted-both-ways", lean(3.0) * DAffine3::from_rotation_x(0.2)),
        stage("with-a-box-on-it", lean(4.0))
            .caster_at(block(v(-0.2, 0.15, 0.1), v(0.15, 0.15, 0.15)), lean(4.0)),
        stage("grid", lean(6.0)).caster_at(
            super::ties::patch(super::ties::level(0.8, 0.0), super::ties::Cut::Grid(2, 3)),
            lean(6.0),
        ),
    ]
}
