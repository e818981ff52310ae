//! Meshes that a modeller would call broken: slivers, no area, doubled faces, T-junctions, and casters that lie in
//! or stand on what receives.

use glam::Vec3;
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::quad;

use super::Expect;
use super::stage::{Stage, block, p, triangles, v};

fn lamp(name: &str) -> Stage {
    Stage::new(name).floor().point(p(0.0, 4.0, 0.0))
}

/// A horizontal square at height 1.2, wound upwards.
fn leaf() -> MeshData {
    quad([v(-0.5, 1.2, 0.5), v(0.5, 1.2, 0.5), v(0.5, 1.2, -0.5), v(-0.5, 1.2, -0.5)])
}

/// The square from `indices` into its corners (0–3), the middles of its edges (4–7) and whatever is added.
fn square_from(name: &str, extra: &[Vec3], indices: &[u32]) -> MeshData {
    let mut positions = vec![v(-0.5, 1.2, 0.5), v(0.5, 1.2, 0.5), v(0.5, 1.2, -0.5), v(-0.5, 1.2, -0.5)];
    positions.extend([v(0.0, 1.2, 0.5), v(0.5, 1.2, 0.0), v(0.0, 1.2, -0.5), v(-0.5, 1.2, 0.0)]);
    positions.extend(extra);
    triangles(name, &positions, indices)
}

fn square(stage: Stage) -> Stage {
    stage.dark(&[p(0.5, 0.0, 0.3), p(-0.4, 0.0, 0.5)]).lit(&[p(1.0, 0.0, 0.0)])
}

pub(super) fn sliver() -> Vec<Stage> {
    // A needle 1.2 m long, as wide as an ulp of its coordinates, then a thousandth of a pixel, then a pixel's tenth.
    let needle = |width: f32| {
        triangles("needle", &[v(-0.6, 1.0, 0.0), v(0.6, 1.0, 0.0), v(0.6, 1.0, width)], &[0, 1, 2])
    };
    let mut stages: Vec<Stage> = [1e-7_f32, 1e-5, 1e-3]
        .iter()
        .map(|&width| {
            lamp(&format!("width={width:e}")).control().caster(needle(width)).dark(&[p(2.6, 0.0, 1.3)])
        })
        .collect();
    // A square cut into two halves along a sliver: no crack may show.
    let extra = [v(1e-6, 1.2, -0.5), v(1e-6, 1.2, 0.5)];
    let halves = square_from("halves", &extra, &[0, 4, 6, 0, 6, 3, 4, 9, 6, 9, 8, 6, 9, 1, 2, 9, 2, 8]);
    stages.push(square(lamp("in-square").caster(halves)));
    stages
}

pub(super) fn zero_area() -> Vec<Stage> {
    // Collinear, along an edge the other triangles use and across the square.
    let collinear = square_from("collinear", &[], &[0, 1, 2, 0, 2, 3, 0, 4, 1, 5, 7, 5, 4, 6, 4]);
    let alone = triangles("line", &[v(-0.6, 1.0, 0.0), v(0.0, 1.0, 0.0), v(0.6, 1.0, 0.0)], &[0, 1, 2]);
    let point = triangles("point", &[v(0.0, 1.0, 0.0); 3], &[0, 1, 2]);
    vec![
        square(lamp("in-square").caster(collinear)),
        lamp("alone")
            .control()
            .caster(alone)
            .caster(point)
            .lit(&[p(0.0, 0.0, 0.1)])
            .dark(&[p(2.6, 0.0, 1.3)]),
    ]
}

pub(super) fn duplicate_vertex() -> Vec<Stage> {
    let repeated =
        square_from("repeated", &[v(0.5, 1.2, -0.5)], &[0, 1, 2, 0, 8, 3, 1, 1, 2, 8, 2, 1, 3, 3, 3]);
    vec![square(lamp("").caster(repeated))]
}

pub(super) fn duplicate_face() -> Vec<Stage> {
    let twice = MeshData::merged("twice", [leaf(), leaf()]);
    let half = MeshData::merged("half twice", [leaf(), leaf().without_triangles(|t| t == 0)]);
    let mut solid = block(v(0.0, 1.2, 0.0), v(0.5, 0.2, 0.5));
    solid.indices.extend_from_within(12..18);
    vec![
        square(lamp("one-mesh").caster(twice)),
        square(lamp("two-meshes").caster(leaf()).caster(leaf())),
        square(lamp("half").caster(half)),
        square(lamp("box-with-double-top").caster(solid)),
    ]
}

pub(super) fn opposite_duplicate() -> Vec<Stage> {
    let both = MeshData::merged("two-sided", [leaf(), leaf().flipped()]);
    vec![
        square(lamp("one-mesh").caster(both)),
        square(lamp("two-meshes").caster(leaf()).caster(leaf().flipped())),
    ]
}

pub(super) fn t_junction() -> Vec<Stage> {
    // The right half has a vertex on the middle of the left half's edge; then one that f32 cannot put there.
    let skew = v(0.02, 1.2, 0.1);
    let exact = square_from("exact", &[v(0.0, 1.2, 0.0)], &[0, 4, 6, 0, 6, 3, 4, 1, 8, 8, 1, 2, 8, 2, 6]);
    let ends = [v(-0.13, 1.2, 0.5), v(0.17, 1.2, -0.5)];
    let on_edge = ends[0] + (ends[1] - ends[0]) * 0.37;
    let rounded = square_from(
        "rounded",
        &[ends[0], ends[1], on_edge],
        &[0, 8, 9, 0, 9, 3, 8, 1, 10, 10, 1, 2, 10, 2, 9],
    );
    let gaping = square_from("gaping", &[skew], &[0, 4, 6, 0, 6, 3, 4, 1, 8, 8, 1, 2, 8, 2, 6]);
    vec![
        square(lamp("exact").caster(exact)),
        square(lamp("rounded").caster(rounded)),
        square(lamp("gaping").caster(gaping)),
    ]
}

pub(super) fn coplanar_receiver() -> Vec<Stage> {
    let mat = quad([v(-0.5, 0.0, 0.5), v(0.5, 0.0, 0.5), v(0.5, 0.0, -0.5), v(-0.5, 0.0, -0.5)]);
    // The wall's plane holds a caster too, and part of that hangs over the wall's edge.
    let wall =
        quad([v(-4.0, 0.0, -2.0), v(4.0, 0.0, -2.0), v(4.0, 2.0, -2.0), v(-4.0, 2.0, -2.0)]).named("wall");
    let poster = quad([v(-1.5, 1.0, -2.0), v(-0.5, 1.0, -2.0), v(-0.5, 2.5, -2.0), v(-1.5, 2.5, -2.0)]);
    vec![
        lamp("mat").control().caster(mat.clone()).lit(&[p(0.3, 0.0, 0.2), p(0.8, 0.0, 0.0)]),
        lamp("mat-flipped").control().caster(mat.flipped()).lit(&[p(0.3, 0.0, 0.2), p(0.8, 0.0, 0.0)]),
        lamp("poster").control().caster(wall).caster(poster).lit(&[p(-1.0, 1.5, -2.0), p(1.0, 1.0, -2.0)]),
    ]
}

pub(super) fn touching_receiver() -> Vec<Stage> {
    let standing = block(v(0.0, 0.5, 0.0), v(0.5, 0.5, 0.5));
    let light = p(-3.0, 3.0, 1.0);
    let stage = |name: &str| Stage::new(name).floor().point(light).lit(&[p(0.0, 0.0, 0.6)]);
    vec![
        stage("box").caster(standing.clone()).dark(&[p(0.51, 0.0, -0.1), p(0.9, 0.0, -0.2)]),
        // Without its bottom the box is open, and its lower boundary lies in the floor.
        stage("bottomless")
            .caster(standing.without_triangles(|t| t / 2 == 3))
            .dark(&[p(0.51, 0.0, -0.1), p(0.9, 0.0, -0.2)]),
        Stage::new("wall-foot")
            .floor()
            .point(light)
            .caster(quad([v(0.0, 0.0, 2.0), v(0.0, 0.0, -2.0), v(0.0, 0.6, -2.0), v(0.0, 0.6, 2.0)]))
            .dark(&[p(0.01, 0.0, 0.0), p(0.3, 0.0, 0.0)])
            .lit(&[p(-0.6, 0.0, 0.0)]),
        stage("tilted-into-floor")
            .caster_at(block(v(0.0, 0.0, 0.0), v(0.4, 0.4, 0.4)), glam::DAffine3::from_rotation_z(0.6))
            .expects(Expect::Matches)
            .dark(&[p(0.6, 0.0, 0.0)]),
    ]
}
