//! Opaque surfaces in one plane: rugs and books on floors, sheets modelled twice.
//!
//! A triangle in the receiver's own plane casts nothing on it, however either is cut into triangles, wound, culled, turned
//! by a node or split over meshes. Depths of one plane rasterised from other corners differ by roundings, so a technique
//! that compares them stripes such surfaces.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{quad, sheet};
use shadowgraph_engine::scene::Material;

use super::lights::open_block;
use super::stage::{Stage, block, p, triangles, v};

/// How a flat rectangle is cut into triangles.
#[derive(Clone, Copy)]
pub(super) enum Cut {
    /// Along the first and third corner.
    First,
    /// The same triangles, each from another corner on.
    Turned,
    /// Along the other diagonal.
    Other,
    /// Four triangles around a point inside, off its middle.
    Fan,
    /// So many columns and rows.
    Grid(u32, u32),
}

/// The rectangle a, b, c, d, counter-clockwise seen from its front, in one of the ways to cut it.
pub(super) fn patch(corners: [Vec3; 4], cut: Cut) -> MeshData {
    let [a, b, c, d] = corners;
    let indices: &[u32] = match cut {
        Cut::First => return quad(corners).named("patch"),
        Cut::Grid(columns, rows) => {
            return sheet(columns, rows, |s, t| a + (b - a) * s + (d - a) * t).named("patch");
        }
        Cut::Turned => &[1, 2, 0, 2, 3, 0],
        Cut::Other => &[0, 1, 3, 1, 2, 3],
        Cut::Fan => &[0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4],
    };
    triangles("patch", &[a, b, c, d, a + (b - a) * 0.375 + (d - a) * 0.625], indices)
}

/// A level rectangle at height `y` reaching `half` to each side, facing up.
pub(super) fn level(half: f32, y: f32) -> [Vec3; 4] {
    [v(-half, y, half), v(half, y, half), v(half, y, -half), v(-half, y, -half)]
}

/// A plane that is level in neither direction. Its corners and halves are binary fractions: with others, f32 would round corners
/// off the plane, and another tessellation of them would be another surface, which shadows and is shadowed by 1e-8 m.
pub(super) fn tilted(half: f32) -> [Vec3; 4] {
    let y = |x: f32, z: f32| 1.0 + 0.25 * x - 0.25 * z;
    level(half, 0.0).map(|corner| v(corner.x, y(corner.x, corner.z), corner.z))
}

/// Turned about two axes, so that what is flat in its own space is level in none of the world's.
pub(super) fn turned_at(center: DVec3) -> DAffine3 {
    DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(0.4), center)
}

impl Stage {
    /// An orthographic eye 15° over the floor: its plane is steep, and the picture's edges cut it far from its corners.
    pub(super) fn seen_low(self) -> Self {
        self.ortho(2.2, 0.1, 90.0).eye(p(-7.2, 5.3, 17.7), p(-0.2, 0.4, 0.3))
    }

    /// A small frame: what breaks here breaks in whole regions.
    pub(super) fn small(name: impl Into<String>) -> Self {
        Self::new(name).size(64, 48)
    }

    /// A single-sided mesh: seen from its front only, and casting whole.
    pub(super) fn culled(self, data: MeshData) -> Self {
        self.culled_at(data, DAffine3::IDENTITY)
    }

    /// The same under a transform.
    pub(super) fn culled_at(self, data: MeshData, world_from_local: DAffine3) -> Self {
        let green = Material::matt("single-sided", Vec3::new(0.5, 0.8, 0.4));
        self.worn_at(data, Material { double_sided: false, ..green }, world_from_local)
    }
}

const LAMP: DVec3 = DVec3::new(-2.0, 3.0, 2.0);
const SUN: DVec3 = DVec3::new(0.5, -1.0, -0.4);

pub(super) fn culled_underside() -> Vec<Stage> {
    // A metre of rug: the floor is seen where its underside is not, and is lit there.
    let rug = |cut: Cut| patch(level(1.0, 0.0), cut).flipped().named("rug");
    let on_rug = [p(0.4, 0.0, 0.3), p(-0.5, 0.0, 0.7), p(0.7, 0.0, -0.6)];
    let stage = |name: &str, data: MeshData| Stage::small(name).floor().control().culled(data).lit(&on_rug);
    let open = || open_block(v(0.0, 0.1, 0.0), v(0.6, 0.1, 0.6), &[2]);
    let board = |stage: Stage, place: DAffine3, cuts: [Cut; 2]| {
        let under = |cut: Cut| patch(level(0.7, 0.0), cut);
        stage.floor().caster_at(under(cuts[0]), place).culled_at(under(cuts[1]).flipped(), place)
    };
    let turned = turned_at(p(0.0, 0.9, 0.0));
    vec![
        stage("same-diagonal", rug(Cut::First)).point(LAMP),
        stage("other-diagonal", rug(Cut::Other)).sun(SUN),
        stage("grid", rug(Cut::Grid(3, 2))).point(LAMP),
        stage("fan-spot", rug(Cut::Fan)).spot(LAMP, p(0.3, 0.0, 0.0), 0.6),
        stage("ortho", rug(Cut::Turned)).point(LAMP).ortho(2.2, 0.1, 30.0),
        stage("ortho-low", rug(Cut::Other)).point(p(1.1, 4.0, 0.3)).seen_low().size(256, 256),
        // The seam of the floor's two triangles passes through the middles of pixels.
        stage("along-the-seam", rug(Cut::Other))
            .point(p(1.1, 4.0, 0.3))
            .eye(p(3.0, 0.8, -3.0), p(0.0, 0.0, 0.0))
            .lens(50.0, 0.05)
            .size(129, 97),
        // Turned by a node, the board shows, and the sheet on its back's own plane does not.
        board(Stage::small("turned-by-node"), turned, [Cut::First, Cut::Grid(2, 3)])
            .sun(SUN)
            .lit(&[turned.transform_point3(p(0.2, 0.0, 0.1)), turned.transform_point3(p(-0.4, 0.0, -0.3))]),
        // The bottom of a box whose lid is off: its inside is not drawn, the floor under it is.
        Stage::small("box-without-lid")
            .floor()
            .culled(open())
            .point(p(0.0, 1.2, 0.1))
            .lit(&[p(0.0, 0.0, 0.1), p(0.3, 0.0, -0.2)])
            .dark(&[p(0.66, 0.0, 0.0)]),
    ]
}

/// Front and back of a sheet that is modelled twice, in one mesh.
fn both_sides(corners: [Vec3; 4], [front, back]: [Cut; 2]) -> MeshData {
    MeshData::merged("leaf", [patch(corners, front), patch(corners, back).flipped()])
}

pub(super) fn two_sided_leaf() -> Vec<Stage> {
    let leaf = |name: &str, back: Cut| {
        let stage = Stage::small(name).floor().eye(p(-3.0, 4.5, 4.0), p(0.0, 0.5, 0.0));
        stage.culled(both_sides(tilted(0.75), [Cut::First, back]))
    };
    // On the leaf, and on the floor behind it.
    let judged =
        |stage: Stage| stage.lit(&[p(0.3, 1.05, 0.1), p(-0.5, 0.95, -0.3)]).dark(&[p(-0.8, 0.0, -0.2)]);
    let lamp = p(1.0, 3.0, 2.0);
    let turned = turned_at(p(0.0, 1.2, 0.0));
    vec![
        judged(leaf("same-corners", Cut::First).point(lamp)),
        judged(leaf("corners-turned", Cut::Turned).point(lamp)),
        judged(leaf("other-diagonal", Cut::Other).point(lamp)),
        judged(leaf("fan", Cut::Fan).point(lamp)),
        judged(leaf("grid", Cut::Grid(2, 4)).point(lamp)),
        leaf("sun-ortho", Cut::Other).sun(p(-0.3, -1.0, -0.5)).ortho(2.2, 0.1, 30.0),
        Stage::small("turned-by-node")
            .floor()
            .culled_at(both_sides(level(0.7, 0.0), [Cut::Grid(2, 2), Cut::Other]), turned)
            .point(lamp)
            .lit(&[turned.transform_point3(p(0.2, 0.0, 0.1))])
            .dark(&[p(-0.5, 0.0, -0.8)]),
    ]
}

pub(super) fn back_to_back_panels() -> Vec<Stage> {
    let panel = || [v(-0.8, 0.4, 0.0), v(0.8, 0.4, 0.0), v(0.8, 1.6, 0.0), v(-0.8, 1.6, 0.0)];
    // Half a turn about the upright axis: the sine of π is no 0 in f64, and its corners lie next to the plane.
    let half_turn = DAffine3::from_rotation_y(std::f64::consts::PI);
    let stage = |name: &str, cuts: [Cut; 2]| {
        let [front, back] = cuts.map(|cut| patch(panel(), cut).named("panel"));
        Stage::small(name).floor().culled(front).culled_at(back, half_turn)
    };
    let judged = |stage: Stage| stage.lit(&[p(0.3, 1.0, 0.0), p(-0.5, 0.7, 0.0)]).dark(&[p(0.9, 0.0, -0.8)]);
    let lamp = p(-0.6, 2.5, 2.5);
    let wide = [v(-1.2, 0.2, 0.0), v(1.2, 0.2, 0.0), v(1.2, 1.8, 0.0), v(-1.2, 1.8, 0.0)];
    vec![
        judged(stage("two-meshes", [Cut::First, Cut::First]).point(lamp)),
        judged(stage("other-diagonal", [Cut::First, Cut::Other]).point(lamp)),
        judged(stage("grid", [Cut::Grid(3, 2), Cut::Fan]).point(lamp)),
        // Seen and lit from behind as well.
        stage("from-behind", [Cut::Grid(3, 2), Cut::Other])
            .point(p(0.5, 2.5, -2.5))
            .eye(p(2.0, 3.0, -5.0), p(0.0, 0.5, 0.0))
            .lit(&[p(0.3, 1.0, 0.0)]),
        judged(stage("double-sided", [Cut::First, Cut::Turned]).caster(patch(panel(), Cut::Fan)).point(lamp)),
        // The panel behind is larger, and reaches out on all sides.
        judged(Stage::small("larger-behind").floor().culled(patch(panel(), Cut::Other)).point(lamp))
            .culled_at(patch(wide, Cut::Fan), half_turn),
        stage("sun", [Cut::Turned, Cut::Grid(1, 4)]).sun(p(0.4, -0.8, -1.0)).lit(&[p(0.3, 1.0, 0.0)]),
    ]
}

/// A box standing with its faces in the planes of others: pairs of coplanar sheets, and lamps all but in a plane.
pub(super) fn wide_band() -> Vec<Stage> {
    let over = |name: &str, gap_m: f64| {
        // The control's shadow is endless, and everything near the floor's plane is next to dark.
        Stage::small(name)
            .size(72, 54)
            .floor()
            .caster(block(v(0.6, 0.3, -0.4), v(0.3, 0.3, 0.3)))
            .point(p(-0.5, gap_m, 0.5))
    };
    let pair = |name: &str, cuts: [Cut; 2]| {
        let floors = cuts.map(|cut| patch(level(4.0, 0.0), cut));
        floors.into_iter().fold(Stage::small(name), Stage::caster).control()
    };
    vec![
        over("lamp-1e-6-over-floor", 1e-6).dark(&[p(1.6, 0.0, -1.2)]).lit(&[p(-1.5, 0.0, 0.0)]),
        over("lamp-1e-4-over-floor", 1e-4).dark(&[p(1.6, 0.0, -1.2)]).lit(&[p(-1.5, 0.0, 0.0)]),
        over("lamp-1e-6-ortho", 1e-6).ortho(2.2, 0.1, 30.0).dark(&[p(1.6, 0.0, -1.2)]),
        pair("two-floors", [Cut::First, Cut::Other]).point(p(0.0, 4.0, 0.0)).lit(&[p(0.3, 0.0, 0.2)]),
        pair("two-floors-grid", [Cut::Grid(3, 4), Cut::Fan]).sun(SUN).lit(&[p(0.3, 0.0, 0.2)]),
        // The light is next to the pair's plane as well.
        pair("two-floors-low-lamp", [Cut::Other, Cut::Grid(2, 2)])
            .caster(block(v(0.6, 0.3, -0.4), v(0.3, 0.3, 0.3)))
            .point(p(-0.5, 1e-6, 0.5)),
    ]
}
