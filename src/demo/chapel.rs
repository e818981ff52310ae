//! A chapel: sun through windows of coloured glass, candles with a size on the altar, a spot on the crucifix.
//!
//! Three shadow nodes share the sun and what stands in it. `sun on stone` takes shell and furniture, exactly; `sun through
//! glass` takes the panes, which colour what they let pass; `candlelight` is soft, since a flame has a size.

use std::f32::consts::TAU;

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{Ends, cylinder, extruded, icosphere, lathe, plane};
use shadowgraph_engine::scene::{
    Camera, Light, Material, MaterialKey, NodeKey, ParamValue, Scene, ShadowNode, placed,
};
use shadowgraph_measure::cases::strewn::noise;

use super::set::{Set, slab, slabs, stand};

const HOME: DAffine3 = DAffine3::IDENTITY;
/// The middles of the windows along the nave, in metres.
const WINDOWS_Z: [f32; 3] = [-4.4, -1.4, 1.6];
const WINDOW_HALF_WIDTH: f32 = 0.75;
const SILL: f32 = 1.3;
/// Where the arch of a window begins.
const SPRING: f32 = 3.6;
/// The inner face of the window wall, and how thick the wall is.
const WALL_X: f32 = -3.0;
const THICKNESS: f32 = 0.4;

pub(super) fn chapel() -> Scene {
    let mut set = Set::new();
    let shell = set.scene.add_group("shell");
    let glass = set.scene.add_group("glass");
    let furniture = set.scene.add_group("furniture");
    build_shell(&mut set, shell);
    WINDOWS_Z.iter().enumerate().for_each(|(i, z)| window(&mut set, (shell, glass), i as u32, *z));
    let flames = altar(&mut set, furniture);
    pews(&mut set, furniture);

    let scene = &mut set.scene;
    let sun = Light::directional("sun", 30.0).with_color(Vec3::new(1.0, 0.9, 0.72));
    let sun = scene.add_light(sun, DVec3::ZERO, DVec3::new(0.8, -0.85, 0.12));
    let candles: Vec<NodeKey> = flames
        .into_iter()
        .enumerate()
        .map(|(i, at)| {
            let candle = Light::point(&format!("candle {i}"), 16.0).with_color(Vec3::new(1.0, 0.62, 0.28));
            scene.add_light(candle, at, DVec3::ZERO)
        })
        .collect();
    scene.set_ambient(Vec3::new(0.21, 0.215, 0.25));
    scene.set_background(Vec3::new(0.6, 0.72, 0.9));
    scene.add_camera(
        Camera::perspective("main", 0.9),
        DVec3::new(1.9, 2.15, 6.0),
        DVec3::new(-0.5, 1.45, -2.6),
    );
    let hard = ShadowNode::new("ShadowVolumeHard").with_lights([sun]).with_casters([shell, furniture]);
    scene.add_shadow("sun on stone", hard);
    // Nobody sees on a pane of glass what falls on it from behind.
    let through =
        ShadowNode::new("TransparentShadow").with_param("selfShadow", ParamValue::Text("none".into()));
    scene.add_shadow("sun through glass", through.with_lights([sun]).with_casters([glass]));
    let soft = ShadowNode::new("ShadowVolumeSoft").with_param("radius", ParamValue::Number(0.04));
    scene.add_shadow("candlelight", soft.with_lights(candles).with_casters([furniture]));
    set.scene
}

/// The outline of a pointed window from the middle of its sill, counter-clockwise as seen along +z, `inset` smaller on all sides.
fn lancet(inset: f32) -> Vec<Vec2> {
    let half = WINDOW_HALF_WIDTH - inset;
    let rise = SPRING - SILL;
    // Each side of the arch is an arc about the foot of the other.
    let radius = 2.0 * WINDOW_HALF_WIDTH - inset;
    let arc = |mirrored: f32| {
        let last = (WINDOW_HALF_WIDTH / radius).acos();
        (0..=8).map(move |step| {
            let turn = last * step as f32 / 8.0;
            Vec2::new(mirrored * (radius * turn.cos() - WINDOW_HALF_WIDTH), rise + radius * turn.sin())
        })
    };
    let right = arc(1.0);
    let left: Vec<Vec2> = arc(-1.0).collect();
    let mut outline = vec![Vec2::new(-half, inset), Vec2::new(half, inset)];
    outline.extend(right);
    outline.extend(left.into_iter().rev().skip(1));
    outline
}

/// From a window's own plane to its place in the wall: x along the nave, z out of the room.
fn in_wall(z: f32, x: f32) -> DAffine3 {
    placed(
        DVec3::new(f64::from(x), f64::from(SILL), f64::from(z)),
        DQuat::from_rotation_y(-std::f64::consts::FRAC_PI_2),
        DVec3::ONE,
    )
}

fn build_shell(set: &mut Set, shell: NodeKey) {
    let stone = set.picture("stone", [512, 512], 0.95, |x, y| {
        let row = y / 32;
        let shifted = x + (row % 2) * 16;
        let joint = if y % 32 < 1 || shifted % 32 < 1 { 0.85 } else { 1.0 };
        let tone = 0.9 + 0.1 * noise(row * 37 + shifted / 32);
        [196.0, 184.0, 164.0].map(|c: f32| (c * tone * joint).min(255.0) as u8)
    });
    let flags = set.picture("flagstones", [512, 512], 0.7, |x, y| {
        let dark = (x / 32 + y / 32) % 2 == 0;
        let tone = (if dark { 0.72 } else { 1.0 }) * (0.92 + 0.1 * noise((x / 32) * 53 + (y / 32) * 97));
        let joint = if x % 32 < 1 || y % 32 < 1 { 0.8 } else { 1.0 };
        [190.0, 178.0, 160.0].map(|c: f32| (c * tone * joint) as u8)
    });
    let timber = set.paint("timber", [0.18, 0.1, 0.05], 0.7);
    let limewash = set.paint("limewash", [0.62, 0.58, 0.5], 0.95);
    set.put(shell, "foundation", slab([-3.4, -0.3, -8.0], [3.4, -0.01, 7.0]), stone, HOME);
    set.put(shell, "floor", plane(Vec2::new(3.0, 7.0)), flags, stand(0.0, 0.0, -0.5, 0.0));
    for (name, min, max) in [
        ("end wall", [-3.4, -0.01, -8.0], [3.4, 6.4, -7.5]),
        ("right wall", [3.0, -0.01, -7.5], [3.4, 6.4, 6.5]),
        ("entrance wall", [-3.4, -0.01, 6.5], [3.4, 6.4, 7.0]),
        ("roof", [-3.4, 6.4, -8.0], [3.4, 6.7, 7.0]),
    ] {
        let material = if name == "end wall" { stone } else { limewash };
        set.put(shell, name, slab(min, max), material, HOME);
    }
    window_wall(set, shell, limewash);
    // Beams under the roof and half columns between the windows.
    for z in [-5.9_f32, -2.9, 0.1, 3.1] {
        set.put(shell, "beam", slab([-3.0, 5.95, z - 0.14], [3.0, 6.25, z + 0.14]), timber, HOME);
        for x in [-2.93_f64, 2.93] {
            let column = cylinder(0.2, 5.95, 24, Ends::Closed);
            set.put(shell, "column", column, limewash, stand(x, 0.0, f64::from(z), 0.0));
        }
    }
}

/// The wall with the windows: piers between them, and over and under each what its outline leaves.
fn window_wall(set: &mut Set, shell: NodeKey, stone: MaterialKey) {
    let (outer, top) = (WALL_X - THICKNESS, 6.4);
    let mut piers = Vec::new();
    let mut from = -7.5;
    for z in WINDOWS_Z {
        piers.push(([outer, -0.01, from], [WALL_X, top, z - WINDOW_HALF_WIDTH]));
        piers.push(([outer, -0.01, z - WINDOW_HALF_WIDTH], [WALL_X, SILL, z + WINDOW_HALF_WIDTH]));
        from = z + WINDOW_HALF_WIDTH;
    }
    piers.push(([outer, -0.01, from], [WALL_X, top, 6.5]));
    set.put(shell, "window wall", slabs("", &piers), stone, HOME);
    // Over an arch the wall is one outline with the arch cut out of its lower side.
    let arch: Vec<Vec2> = lancet(0.0).into_iter().skip(2).collect();
    let mut outline =
        vec![Vec2::new(WINDOW_HALF_WIDTH, top - SILL), Vec2::new(-WINDOW_HALF_WIDTH, top - SILL)];
    outline.extend(arch.into_iter().rev());
    for z in WINDOWS_Z {
        let spandrel = extruded(&outline, 0.0, THICKNESS);
        set.put(shell, "arch", spandrel, stone, in_wall(z, WALL_X));
    }
}

/// Coloured panes between leads, in a frame of stone.
fn window(set: &mut Set, (shell, glass): (NodeKey, NodeKey), number: u32, z: f32) {
    let lead = set.paint("lead", [0.05, 0.05, 0.055], 0.6);
    const COLORS: [[f32; 3]; 6] = [
        [0.85, 0.06, 0.05],
        [0.05, 0.16, 0.85],
        [0.95, 0.62, 0.06],
        [0.06, 0.55, 0.16],
        [0.5, 0.08, 0.6],
        [0.75, 0.85, 0.9],
    ];
    let panes: Vec<MaterialKey> =
        COLORS.iter().enumerate().map(|(i, c)| pane(set, number, i, (*c).into())).collect();
    let (columns, height) = (4, SPRING - SILL + 1.3);
    let width = 2.0 * WINDOW_HALF_WIDTH / columns as f32;
    let rows = (height / 0.42).ceil() as u32;
    let outline = lancet(0.02);
    // Half the outline's width at a height over the sill.
    let half_at = |y: f32| {
        let beyond = outline.windows(2).filter_map(|ends| {
            let [a, b] = [ends[0], ends[1]];
            let within = a.x > 0.0 && b.x >= -1e-6 && (a.y..=b.y).contains(&y) && b.y > a.y;
            within.then(|| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y))
        });
        beyond.fold(0.0, f32::max)
    };
    let at_height = |y: f32| y.min(outline.iter().map(|p| p.y).fold(0.0, f32::max) - 0.01);
    let mut colored: Vec<Vec<MeshData>> = vec![Vec::new(); COLORS.len()];
    let mut leads = Vec::new();
    for row in 0..rows {
        let (low, high) = (at_height(0.02 + 0.42 * row as f32), at_height(0.02 + 0.42 * (row + 1) as f32));
        if high - low < 0.03 {
            break;
        }
        for column in 0..columns {
            let (left, right) = (
                -WINDOW_HALF_WIDTH + width * column as f32,
                -WINDOW_HALF_WIDTH + width * (column + 1) as f32,
            );
            let cut = |x: f32, y: f32| Vec2::new(x.clamp(-half_at(y), half_at(y)), y);
            let corners = [cut(left, low), cut(right, low), cut(right, high), cut(left, high)];
            let area: f32 = (0..4).map(|i| corners[i].perp_dot(corners[(i + 1) % 4])).sum::<f32>() * 0.5;
            if area < 0.004 {
                continue;
            }
            let which = (noise(number * 977 + row * 31 + column) * 5.999) as usize;
            // A medallion in the middle of each window is pale.
            let which = if (row == 3 || row == 4) && (column == 1 || column == 2) { 5 } else { which };
            colored[which].push(extruded(&dedup(&corners), -0.006, 0.006));
        }
        let half = half_at(low);
        if row > 0 && half > 0.05 {
            leads.push(slab([-half, low - 0.012, -0.015], [half, low + 0.012, 0.015]));
        }
    }
    for column in 1..columns {
        let x = -WINDOW_HALF_WIDTH + width * column as f32;
        let top =
            (0..200).map(|i| height * i as f32 / 200.0).filter(|y| half_at(*y) > x.abs()).fold(0.0, f32::max);
        leads.push(slab([x - 0.012, 0.02, -0.015], [x + 0.012, top, 0.015]));
    }
    let place = in_wall(z, WALL_X - 0.25);
    for (parts, material) in colored.into_iter().zip(panes).filter(|(parts, _)| !parts.is_empty()) {
        set.put(glass, "panes", MeshData::merged("", parts), material, place);
    }
    set.put(shell, "leads", MeshData::merged("", leads), lead, place);
}

/// Corners without those that coincide.
fn dedup(corners: &[Vec2; 4]) -> Vec<Vec2> {
    let mut kept: Vec<Vec2> = Vec::new();
    for corner in corners {
        if kept.iter().all(|other| other.distance(*corner) > 1e-3) {
            kept.push(*corner);
        }
    }
    kept
}

/// Glass of a colour; it glows as panes do before the sky.
fn pane(set: &mut Set, window: u32, number: usize, color: Vec3) -> MaterialKey {
    let name = format!("glass {window}-{number}");
    set.scene.add_material(Material {
        transmission: 0.95,
        emissive: color * 0.5,
        roughness: 0.1,
        ..Material::matt(&name, color)
    })
}

/// The altar with its cloth, two candlesticks and a bowl; where the flames are.
fn altar(set: &mut Set, group: NodeKey) -> Vec<DVec3> {
    let marble = set.paint("marble", [0.72, 0.7, 0.66], 0.4);
    let cloth = set.paint("altar cloth", [0.72, 0.68, 0.6], 0.95);
    let brass = set.metal("brass", [0.83, 0.6, 0.28], 0.3);
    let wax = set.paint("wax", [0.86, 0.8, 0.66], 0.6);
    let steps = [([-2.2, 0.0, -7.4], [2.2, 0.16, -4.9]), ([-1.8, 0.16, -7.4], [1.8, 0.32, -5.3])];
    set.put(group, "steps", slabs("", &steps), marble, HOME);
    set.put(group, "altar", slab([-1.1, 0.321, -6.6], [1.1, 1.22, -5.9]), marble, HOME);
    set.put(group, "cloth", slab([-1.2, 1.221, -6.66], [1.2, 1.25, -5.84]), cloth, HOME);
    let cross = [([-0.06, 0.0, -0.05], [0.06, 1.9, 0.05]), ([-0.55, 1.15, -0.05], [0.55, 1.27, 0.05])];
    set.put(group, "cross", slabs("", &cross), brass, stand(0.0, 2.1, -7.42, 0.0));
    let profile = [
        [0.0, 0.0],
        [0.1, 0.0],
        [0.09, 0.03],
        [0.025, 0.06],
        [0.02, 0.2],
        [0.045, 0.24],
        [0.02, 0.28],
        [0.06, 0.42],
        [0.0, 0.42],
    ];
    let stick = set.shape(lathe(&profile.map(Vec2::from), 24).named("candlestick"));
    let candle = set.shape(cylinder(0.022, 0.24, 16, Ends::Closed).named("candle"));
    let mut flames = Vec::new();
    for x in [-0.85, 0.85] {
        set.place(group, "candlestick", stick, brass, stand(x, 1.251, -6.2, 0.0));
        set.place(group, "candle", candle, wax, stand(x, 1.672, -6.2, 0.0));
        flames.push(DVec3::new(x, 1.99, -6.2));
    }
    let bowl = [[0.0, 0.0], [0.07, 0.0], [0.03, 0.05], [0.03, 0.12], [0.12, 0.2], [0.13, 0.3]];
    set.put(group, "chalice", lathe(&bowl.map(Vec2::from), 32), brass, stand(0.0, 1.251, -6.15, 0.0));
    // A ring of iron under the roof.
    let ring = (0..12).map(|i| {
        let turn = TAU * i as f32 / 12.0;
        icosphere(0.05, 2).moved(Vec3::new(0.8 * turn.cos(), 0.0, 0.8 * turn.sin()))
    });
    let iron = set.metal("iron", [0.2, 0.2, 0.21], 0.5);
    let torus = shadowgraph_engine::geometry::shapes::torus(0.8, 0.03, 48, 8);
    set.put(group, "ring", MeshData::merged("", ring.chain([torus])), iron, stand(0.0, 3.9, -2.0, 0.0));
    let chain = cylinder(0.012, 2.1, 8, Ends::Closed);
    for (x, z) in [(0.8, 0.0), (-0.4, 0.69), (-0.4, -0.69)] {
        let lean = DQuat::from_rotation_arc(DVec3::Y, DVec3::new(-x, 2.05, -z).normalize());
        set.put(group, "chain", chain.clone(), iron, placed(DVec3::new(x, 3.9, z - 2.0), lean, DVec3::ONE));
    }
    flames
}

/// Two rows of pews.
fn pews(set: &mut Set, group: NodeKey) {
    let oak = set.paint("oak", [0.26, 0.14, 0.07], 0.5);
    let pew = slabs(
        "pew",
        &[
            ([-1.0, 0.42, -0.2], [1.0, 0.46, 0.22]),
            ([-1.0, 0.5, 0.2], [1.0, 0.95, 0.24]),
            ([-1.05, 0.0, -0.24], [-1.0, 1.0, 0.28]),
            ([1.0, 0.0, -0.24], [1.05, 1.0, 0.28]),
            ([-1.0, 0.05, 0.1], [1.0, 0.3, 0.13]),
        ],
    );
    let pew = set.shape(pew);
    for row in 0..4 {
        set.place(group, "pew", pew, oak, stand(1.85, 0.0, -3.9 + 1.2 * f64::from(row), 0.0));
        if row < 2 {
            set.place(group, "pew", pew, oak, stand(-1.75, 0.0, -3.9 + 1.2 * f64::from(row), 0.0));
        }
    }
}
