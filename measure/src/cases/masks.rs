//! Casters with holes: where the texture is not, light passes.

use glam::{DAffine3, Vec2, Vec3, Vec4};
use shadowgraph_engine::geometry::shapes::quad;
use shadowgraph_engine::geometry::{MeshData, Part};
use shadowgraph_engine::scene::{AlphaMode, Material, TexCoord, TextureRef, UvTransform, Wrap};

use super::Expect;
use super::stage::{Stage, block, p, v};
use super::ties::{Cut, level, patch, turned_at};

/// A leaf-green material with holes where the texture's alpha is below one half.
fn leaf(texture: TextureRef) -> Material {
    Material {
        base_color_texture: Some(texture),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..Material::matt("leaf", Vec3::ONE)
    }
}

fn green(there: bool) -> [u8; 4] {
    [60, 120, 40, if there { 255 } else { 0 }]
}

/// A window of a quarter of the width in a whole card: 32 texels a side.
fn round_hole(stage: &mut Stage) -> TextureRef {
    stage.texture(32, |x, y| green(Vec2::new(x as f32 - 15.5, y as f32 - 15.5).length() > 8.0))
}

/// Squares of two texels in a disc: many corners.
fn squares(stage: &mut Stage) -> TextureRef {
    stage.texture(16, |x, y| {
        let inside = Vec2::new(x as f32 - 7.5, y as f32 - 7.5).length() < 7.0;
        green(inside && (x / 2 + y / 2) % 2 == 0)
    })
}

/// A level card of 1.6 m a side.
fn level_card(height: f32) -> MeshData {
    let at = |x: f32, z: f32| v(0.8 * x, height, 0.8 * z);
    quad([at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0), at(-1.0, -1.0)]).named("card")
}

/// An upright card in the vertical plane through the origin along `side`.
fn upright_card(side: Vec3, foot: f32) -> MeshData {
    let at = |u: f32, y: f32| side * u + Vec3::Y * y;
    let top = foot + 1.4;
    quad([at(-0.7, foot), at(0.7, foot), at(0.7, top), at(-0.7, top)]).named("card")
}

/// `data` in a masked material over a floor.
fn card(name: &str, data: MeshData, texture: fn(&mut Stage) -> TextureRef) -> Stage {
    let mut stage = Stage::new(name).floor();
    let material = leaf(texture(&mut stage));
    stage.caster_in(data, vec![material])
}

/// The level card with a window under lights that throw it onto the floor half as large again.
fn windows() -> Vec<Stage> {
    let window = |name: &str| card(name, level_card(1.5), round_hole);
    let (lit, dark) = (p(0.0, 0.0, 0.0), [p(0.9, 0.0, 0.0), p(-0.9, 0.0, 0.0), p(0.0, 0.0, -0.9)]);
    vec![
        window("point").point(p(0.0, 4.5, 0.0)).lit(&[lit, p(1.5, 0.0, 0.0)]).dark(&dark),
        window("spot").spot(p(0.0, 4.5, 0.0), p(0.0, 0.0, 0.0), 0.5).lit(&[lit]).dark(&dark),
        window("sun").sun(p(0.0, -1.0, 0.0)).lit(&[lit]).dark(&[p(0.6, 0.0, 0.0), p(0.0, 0.0, -0.6)]),
        window("low-sun").sun(p(-1.0, -0.35, -0.2)).eye(p(1.0, 4.0, 7.0), p(-1.5, 0.0, 0.0)),
        window("ortho").point(p(0.0, 4.5, 0.0)).ortho(3.0, 0.1, 30.0).lit(&[lit]).dark(&dark),
        // The eye is in the shadow, and looks out of it past its edge.
        window("eye-in-shadow")
            .point(p(0.0, 4.5, 0.0))
            .eye(p(0.62, 0.7, 0.5), p(-0.6, 0.0, -0.4))
            .lens(70.0, 0.05)
            .lit(&[lit])
            .dark(&[p(-0.9, 0.0, -0.3)]),
        // From right under the card: receivers are its own other side.
        window("light-close").point(p(0.1, 1.52, 0.1)).eye(p(2.5, 1.0, 3.0), p(0.0, 0.6, 0.0)),
    ]
}

/// How a texture is read decides where the holes are.
fn readings() -> Vec<Stage> {
    let reading = |name: &str, read: &dyn Fn(TextureRef) -> TextureRef| {
        let mut stage = Stage::new(name).floor().point(p(0.3, 4.5, 0.4));
        let texture = read(squares(&mut stage));
        stage.caster_in(level_card(1.2), vec![leaf(texture)])
    };
    let turned = UvTransform { offset: Vec2::new(0.3, -0.2), rotation_rad: 0.5, scale: Vec2::new(2.5, 1.7) };
    vec![
        reading("linear", &|texture| texture),
        reading("nearest", &|texture| TextureRef { smooth: false, ..texture }),
        reading("repeat", &|texture| TextureRef { transform: turned, ..texture }),
        reading("mirror", &|texture| TextureRef { transform: turned, wrap: [Wrap::Mirror; 2], ..texture }),
        reading("clamp", &|texture| TextureRef { transform: turned, wrap: [Wrap::Clamp; 2], ..texture }),
        second_uvs(),
        vertex_alpha(),
    ]
}

/// The texture lies on the second coordinates; the first would show one texel only.
fn second_uvs() -> Stage {
    let mut stage = Stage::new("second-uvs").floor().point(p(0.0, 4.5, 0.0));
    let texture = TextureRef { tex_coord: TexCoord::Second, ..round_hole(&mut stage) };
    let mut data = level_card(1.5);
    data.second_uvs = std::mem::replace(&mut data.uvs, vec![Vec2::splat(0.1); 4]);
    let (lit, dark) = (p(0.0, 0.0, 0.0), p(0.9, 0.0, 0.0));
    stage.caster_in(data, vec![leaf(texture)]).lit(&[lit]).dark(&[dark])
}

/// No texture: alpha runs over the vertices, from 1 at x = −0.8 to 0 at x = 0.8.
fn vertex_alpha() -> Stage {
    let mut data = level_card(1.5);
    data.colors = [1.0, 0.0, 0.0, 1.0].map(|alpha| Vec4::new(1.0, 1.0, 1.0, alpha)).to_vec();
    let material = Material {
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..Material::matt("leaf", Vec3::new(0.2, 0.5, 0.1))
    };
    let stage = Stage::new("vertex-alpha").floor().point(p(0.0, 4.5, 0.0));
    stage.caster_in(data, vec![material]).lit(&[p(0.6, 0.0, 0.0)]).dark(&[p(-0.6, 0.0, 0.0)])
}

/// Cards that cross, stand on the floor, fold, or are one face of a solid.
fn shapes() -> Vec<Stage> {
    let crossing = |name: &str| {
        let across = [Vec3::new(0.8, 0.0, 0.6), Vec3::new(-0.6, 0.0, 0.8)];
        card(name, MeshData::merged("cross", across.map(|side| upright_card(side, 0.0))), squares)
    };
    // Two leaves at an angle, opening upwards: each shadows the other.
    let folded = MeshData::merged(
        "folded",
        [
            quad([v(-0.9, 1.2, 0.6), v(0.0, 0.5, 0.6), v(0.0, 0.5, -0.6), v(-0.9, 1.2, -0.6)]),
            quad([v(0.0, 0.5, 0.6), v(0.9, 1.2, 0.6), v(0.9, 1.2, -0.6), v(0.0, 0.5, -0.6)]),
        ],
    );
    let mut boxed = Stage::new("face-of-box").floor();
    let holes = leaf(round_hole(&mut boxed));
    let mut solid = block(v(0.0, 1.0, 0.0), v(0.6, 0.6, 0.6)).named("box");
    solid.parts = [(0..4, 0), (4..6, 1), (6..12, 0)]
        .map(|(triangles, material_slot)| Part { triangles, material_slot })
        .to_vec();
    let wood = Material::matt("wood", Vec3::new(0.6, 0.45, 0.3));
    vec![
        crossing("crossing").point(p(1.5, 3.0, 1.0)),
        crossing("crossing-sun").sun(p(-0.6, -1.0, -0.3)),
        card("standing", upright_card(Vec3::X, 0.0), round_hole).point(p(0.4, 2.5, -2.0)),
        card("folded", folded.clone(), squares).point(p(1.2, 3.0, 0.4)),
        card("folded-sun", folded, round_hole).sun(p(-1.0, -0.8, -0.1)),
        boxed
            .caster_in(solid, vec![wood, holes])
            .point(p(0.2, 4.0, 0.3))
            .eye(p(2.0, 4.0, 3.0), p(0.0, 0.8, 0.0)),
        card("many-lights", level_card(1.0), round_hole)
            .caster(block(v(1.4, 0.5, -0.6), v(0.3, 0.3, 0.3)))
            .point(p(1.5, 3.0, 1.0))
            .sun(p(-0.3, -1.0, 0.2)),
        // Nothing is there, and nothing casts.
        card("all-holes", level_card(1.5), |stage| stage.texture(2, |_, _| green(false)))
            .point(p(0.0, 4.5, 0.0))
            .expects(Expect::NoShadow),
    ]
}

pub(super) fn alpha_mask() -> Vec<Stage> {
    [windows(), readings(), shapes()].concat()
}

/// Fallen leaves: cards with holes in the very plane of what they lie on. They cast nothing on it, however the picture's edges cut
/// either.
pub(super) fn leaf_on_floor() -> Vec<Stage> {
    let lies =
        |name: &str, texture: fn(&mut Stage) -> TextureRef| card(name, level_card(0.0), texture).control();
    let on_leaf = [p(0.4, 0.0, 0.3), p(-0.5, 0.0, 0.7), p(0.7, 0.0, -0.6)];
    let turned = turned_at(p(0.0, 0.9, 0.0));
    let mut on_board = Stage::small("turned-board").floor();
    let holes = leaf(squares(&mut on_board));
    let mut below = Stage::small("facing-down").floor().control();
    let facing_down = Material { double_sided: false, ..leaf(squares(&mut below)) };
    let near = |stage: Stage| stage.eye(p(0.5, 0.6, 1.0), p(0.0, 0.0, -0.4)).lens(40.0, 0.05);
    vec![
        lies("lamp", squares).point(p(-2.0, 3.0, 2.0)).lit(&on_leaf),
        lies("sun", round_hole).sun(p(0.5, -1.0, -0.4)).lit(&on_leaf),
        // The floor reaches beyond the picture on all sides.
        near(lies("cut-by-picture", squares).point(p(1.1, 4.0, 0.3))).expects(Expect::NoShadow),
        lies("ortho", squares).point(p(1.1, 4.0, 0.3)).seen_low().lit(&[p(0.1, 0.0, 0.1)]),
        below.worn_at(level_card(0.0).flipped(), facing_down, DAffine3::IDENTITY).point(p(-2.0, 3.0, 2.0)),
        on_board
            .caster_at(patch(level(0.7, 0.0), Cut::First), turned)
            .worn_at(patch(level(0.7, 0.0), Cut::Fan), holes, turned)
            .sun(p(0.5, -1.0, -0.4))
            .lit(&[p(0.2, 0.0, 0.1), p(-0.4, 0.0, -0.3)].map(|point| turned.transform_point3(point))),
    ]
}
