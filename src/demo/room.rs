//! The furnished room: the project's first picture.
//!
//! Six closed slabs make the room (6 × 2.8 × 7 m, the camera stands inside), so daylight comes in through the window
//! only: a low sun that throws the window's bars over table, chairs and floor, and a dim cool sky. At the back an open
//! lampshade cuts the warm lamp's light into two cones, a spot from the ceiling picks out the pictures, and a spot
//! on the floor throws a plant's leaves onto the right wall.
//!
//! Two shadow nodes share the work. `daylight` takes sun and sky and needs the room's shell as a caster; `lamps` takes
//! the three lights inside and leaves the shell out, since behind the walls there is nothing left to shade.

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{Ends, cylinder, icosphere, lathe, plane, quad};
use shadowgraph_engine::scene::{Camera, Content, Light, NodeKey, Scene, ShadowNode, placed};

use shadowgraph_measure::cases::strewn::noise;

use super::furniture::{
    armchair, books, bowl, chair, curtain, feet, frame, shade, shelf, sideboard, table, vase,
};
use super::plant::{Habit, potted};
use super::set::{Set, slab, slabs, stand};

const HOME: DAffine3 = DAffine3::IDENTITY;

pub(super) fn room() -> Scene {
    let mut set = Set::new();
    let shell = set.scene.add_group("shell");
    let furniture = set.scene.add_group("furniture");
    let lights = set.scene.add_group("lights");
    build_shell(&mut set, shell);
    dining(&mut set, furniture);
    back_wall(&mut set, furniture);
    corner(&mut set, furniture);
    let habit = Habit { leaves: 21, length_m: 0.5, width_m: 0.18, height_m: 0.72 };
    potted(&mut set, furniture, &habit, [0.18, 0.32], [2.38, 0.5]);

    let scene = &mut set.scene;
    let mut shine = |light: Light, at: DVec3, target: DVec3| {
        let node = scene.add_light(light, at, target);
        // A light's place does not depend on its parent here: the group stands at the origin.
        let _ = scene.reparent(node, Some(lights));
        node
    };
    let sun = Light::directional("sun", 5.5).with_color(Vec3::new(1.0, 0.83, 0.6));
    let sun = shine(sun, DVec3::ZERO, DVec3::new(0.75, -0.47, 0.06));
    let sky = Light::point("sky", 20.0).with_color(Vec3::new(0.5, 0.68, 1.0));
    let sky = shine(sky, DVec3::new(-3.95, 1.95, -0.1), DVec3::ZERO);
    let lamp = Light::point("lamp", 2.6).with_color(Vec3::new(1.0, 0.66, 0.36));
    let lamp = shine(lamp, DVec3::new(2.35, 1.52, -1.85), DVec3::ZERO);
    let picture = Light::spot("picture spot", 6.0, 0.5).with_color(Vec3::new(1.0, 0.86, 0.68));
    let picture = shine(picture, DVec3::new(0.1, 2.74, -1.2), DVec3::new(0.1, 1.5, -2.5));
    let leaves = Light::spot("plant spot", 6.0, 0.5).with_color(Vec3::new(1.0, 0.8, 0.55));
    let leaves = shine(leaves, DVec3::new(0.75, 0.42, 1.25), DVec3::new(2.7, 0.95, 0.35));

    scene.set_ambient(Vec3::new(0.2, 0.195, 0.2));
    scene.set_background(Vec3::new(0.5, 0.62, 0.8));
    scene.add_camera(
        Camera::perspective("main", 0.82),
        DVec3::new(0.5, 1.45, 4.3),
        DVec3::new(0.0, 1.06, -1.0),
    );
    scene.add_shadow("daylight", ShadowNode::new("ShadowVolumeHard").with_lights([sun, sky]));
    let lamps =
        ShadowNode::new("ShadowVolumeHard").with_lights([lamp, picture, leaves]).with_casters([furniture]);
    scene.add_shadow("lamps", lamps);
    set.scene
}

/// Walls, floor, ceiling, window.
fn build_shell(set: &mut Set, shell: NodeKey) {
    let plaster = set.paint("plaster", [0.78, 0.75, 0.69], 0.95);
    let white = set.paint("white paint", [0.82, 0.81, 0.78], 0.5);
    let oak_floor = set.picture("oak floor", [768, 512], 0.45, oak_plank);
    let foundation = slab([-3.2, -0.2, -2.7], [3.2, -0.01, 4.7]);
    set.put(shell, "foundation", foundation, plaster, HOME);
    set.put(shell, "floor", plane(Vec2::new(3.0, 3.5)), oak_floor, stand(0.0, 0.0, 1.0, 0.0));
    let walls = [
        ("back wall", [-3.2, -0.01, -2.7], [3.2, 2.8, -2.5]),
        ("right wall", [3.0, -0.01, -2.5], [3.2, 2.8, 4.5]),
        ("front wall", [-3.2, -0.01, 4.5], [3.2, 2.8, 4.7]),
        ("ceiling", [-3.2, 2.8, -2.7], [3.2, 3.0, 4.7]),
    ];
    for (name, min, max) in walls {
        set.put(shell, name, slab(min, max), plaster, HOME);
    }
    let window_wall = [
        ([-3.2, -0.01, -2.5], [-3.0, 0.75, 4.5]),
        ([-3.2, 2.4, -2.5], [-3.0, 2.8, 4.5]),
        ([-3.2, 0.75, -2.5], [-3.0, 2.4, -1.45]),
        ([-3.2, 0.75, 1.15], [-3.0, 2.4, 4.5]),
    ];
    set.put(shell, "window wall", slabs("", &window_wall), plaster, HOME);
    let skirting = [([-2.99, 0.0, -2.499], [2.99, 0.09, -2.48]), ([2.98, 0.0, -2.48], [2.999, 0.09, 4.4])];
    set.put(shell, "skirting", slabs("", &skirting), white, HOME);

    // Frame, two mullions and a transom: the bars whose shadows lie across the room.
    let (out, inn) = (-3.13, -3.05);
    let mut bars = vec![
        ([out, 0.75, -1.45], [inn, 0.81, 1.15]),
        ([out, 2.34, -1.45], [inn, 2.4, 1.15]),
        ([out, 0.81, -1.45], [inn, 2.34, -1.39]),
        ([out, 0.81, 1.09], [inn, 2.34, 1.15]),
        ([out + 0.01, 1.86, -1.39], [inn - 0.01, 1.91, 1.09]),
    ];
    for z in [-0.59, 0.26] {
        bars.push(([out + 0.01, 0.81, z], [inn - 0.01, 1.86, z + 0.05]));
        bars.push(([out + 0.01, 1.91, z], [inn - 0.01, 2.34, z + 0.05]));
    }
    set.put(shell, "window bars", slabs("", &bars), white, HOME);
    set.put(shell, "sill", slab([-3.05, 0.72, -1.55], [-2.84, 0.75, 1.25]), white, HOME);
}

/// Oak planks 12 cm wide along x, in tones that vary by plank, with grain.
fn oak_plank(x: u32, y: u32) -> [u8; 3] {
    let row = y / 9;
    let shifted = x + (noise(row) * 512.0) as u32;
    let tone = 0.8 + 0.3 * noise(row * 31 + shifted / 256);
    let grain = 0.94 + 0.12 * noise(y * 977 + shifted / 24);
    let joint = if y.is_multiple_of(9) || shifted % 256 < 2 { 0.62 } else { 1.0 };
    [176.0, 132.0, 88.0].map(|c: f32| (c * tone * grain * joint).min(255.0) as u8)
}

/// Table, chairs, rug and what lies on the table.
fn dining(set: &mut Set, group: NodeKey) {
    let oak = set.paint("oak", [0.42, 0.26, 0.13], 0.5);
    let dark = set.paint("smoked oak", [0.24, 0.13, 0.07], 0.45);
    let rug = set.picture("rug", [96, 64], 0.95, |x, y| {
        let edge = x.min(95 - x).min(y.min(63 - y));
        let zigzag = (x + if (y / 4) % 2 == 0 { y % 4 } else { 4 - y % 4 }) % 12;
        match edge {
            0..=1 => [198, 184, 160],
            4 | 5 => [168, 98, 70],
            _ if edge > 7 && zigzag < 2 => [196, 180, 150],
            _ => [116, 134, 116],
        }
    });
    set.put(group, "rug", slab([-1.6, 0.001, -1.05], [1.6, 0.013, 1.05]), rug, stand(-0.75, 0.0, 0.1, 0.0));
    set.put(group, "table", table(0.85, 0.45, 0.74), oak, stand(-1.0, 0.0, 0.05, 4.0));
    let seat = set.shape(chair());
    for (x, z, turn) in [(-1.45, -0.62, 5.0), (-0.6, -0.66, -8.0), (-1.35, 0.78, 176.0), (0.22, 0.2, -74.0)] {
        set.place(group, "chair", seat, dark, stand(x, 0.0, z, turn));
    }
    let top = 0.74;
    let clay = set.paint("terracotta", [0.46, 0.17, 0.085], 0.75);
    let glaze = set.paint("green glaze", [0.05, 0.14, 0.1], 0.25);
    let orange = set.paint("orange", [0.75, 0.27, 0.03], 0.5);
    set.put(group, "bowl", bowl(0.17), glaze, stand(-0.72, top, 0.08, 0.0));
    let fruit = set.shape(icosphere(0.042, 3).named("orange"));
    for (x, y, z) in [(-0.76, 0.05, 0.05), (-0.67, 0.05, 0.06), (-0.72, 0.05, 0.13), (-0.72, 0.115, 0.08)] {
        set.place(group, "orange", fruit, orange, stand(x, top + y, z, 0.0));
    }
    set.put(group, "vase", vase(0.95), clay, stand(-1.35, top, -0.08, 0.0));
    // Dry twigs in the vase.
    let twigs = (0..7).map(|i| {
        let lean = DQuat::from_rotation_y(f64::from(i) * 0.9)
            * DQuat::from_rotation_z(0.12 + 0.1 * f64::from(noise(i)));
        cylinder(0.0028, 0.42 + 0.12 * noise(i + 5), 6, Ends::Closed).transformed(&placed(
            DVec3::Y * 0.06,
            lean,
            DVec3::ONE,
        ))
    });
    set.put(group, "twigs", MeshData::merged("", twigs), dark, stand(-1.35, top, -0.08, 0.0));
    let volume = set.shape(slab([-0.11, 0.0, -0.08], [0.11, 0.028, 0.08]));
    let covers = [set.paint("linen", [0.62, 0.55, 0.42], 0.9), set.paint("ink", [0.05, 0.09, 0.17], 0.8)];
    for i in 0..3 {
        let turn = 20.0 + f64::from(i) * 11.0;
        set.place(
            group,
            "book",
            volume,
            covers[i as usize % 2],
            stand(-1.05, top + 0.028 * f64::from(i), 0.27, turn),
        );
    }
}

/// Sideboard, pictures and bookcase along the back wall; curtains beside the window.
fn back_wall(set: &mut Set, group: NodeKey) {
    let walnut = set.paint("walnut", [0.17, 0.085, 0.045], 0.45);
    let brass = set.metal("brass", [0.83, 0.6, 0.28], 0.35);
    let clay = set.paint("ochre clay", [0.55, 0.3, 0.1], 0.8);
    let stone = set.paint("white stone", [0.75, 0.73, 0.69], 0.6);
    set.put(group, "sideboard", sideboard(0.95, 0.42, 0.16, 0.72), walnut, stand(0.1, 0.0, -2.49, 0.0));
    set.put(group, "sideboard feet", feet(0.85, 0.16, 0.16), brass, stand(0.1, 0.0, -2.28, 0.0));
    set.put(group, "tall vase", vase(1.2), clay, stand(-0.52, 0.742, -2.27, 0.0));
    set.put(group, "sphere", icosphere(0.095, 4), stone, stand(0.62, 0.837, -2.22, 0.0));
    set.put(group, "small bowl", bowl(0.12), brass, stand(0.3, 0.742, -2.24, 0.0));

    let canvases: [(f64, f64, [f32; 2]); 3] =
        [(-0.42, 1.58, [0.21, 0.29]), (0.2, 1.62, [0.29, 0.38]), (0.76, 1.55, [0.17, 0.22])];
    for (i, (x, y, half)) in canvases.into_iter().enumerate() {
        let art = set.picture(&format!("canvas {i}"), [64, 84], 0.9, |u, v| {
            canvas(i, u as f32 / 64.0, v as f32 / 84.0)
        });
        set.put(
            group,
            "frame",
            frame(half[0], half[1], 0.022),
            [walnut, brass, walnut][i],
            stand(x, y, -2.499, 0.0),
        );
        let [w, h] = half;
        let corners = [[-w, -h], [w, -h], [w, h], [-w, h]].map(|[x, y]| Vec3::new(x, y, 0.008));
        set.put(group, "canvas", quad(corners), art, stand(x, y, -2.499, 0.0));
    }

    let case = set.paint("painted steel", [0.16, 0.21, 0.17], 0.6);
    set.put(group, "bookcase", shelf(0.62, 0.3, 6, 0.34), case, stand(-2.05, 0.05, -2.49, 0.0));
    let tones = [[0.45, 0.14, 0.08], [0.6, 0.52, 0.4], [0.06, 0.14, 0.13]];
    for (tone, color) in tones.into_iter().enumerate() {
        let cover = set.paint(["red books", "pale books", "green books"][tone], color, 0.85);
        let rows = (0..6).flat_map(|row: u32| {
            (0..3).filter(move |cell| (row, *cell) != (3, 1) && (row, *cell) != (5, 2)).map(
                move |cell: u32| {
                    let left = -0.61 + 0.4133 * cell as f32;
                    let filled = 0.22 + 0.17 * noise(row * 3 + cell + 40);
                    books(left, left + filled, 0.27, row * 3 + cell, tone as u32)
                        .moved(Vec3::Y * 0.34 * row as f32)
                },
            )
        });
        set.put(
            group,
            "books",
            MeshData::merged("", rows.collect::<Vec<_>>()),
            cover,
            stand(-2.05, 0.05, -2.49, 0.0),
        );
    }
    set.put(group, "shelf vase", vase(0.75), stone, stand(-2.05, 0.05 + 3.0 * 0.34, -2.33, 0.0));

    let cloth = set.paint("linen curtain", [0.66, 0.6, 0.48], 0.95);
    set.put(group, "curtain", curtain(0.5, 2.55), cloth, stand(-2.86, 0.0, 1.42, 90.0));
    set.put(group, "curtain", curtain(0.42, 2.55), cloth, stand(-2.86, 0.0, -1.7, -90.0));
    let rail = placed(
        DVec3::new(-2.86, 2.58, -2.0),
        DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
        DVec3::ONE,
    );
    set.put(group, "curtain rail", cylinder(0.012, 3.75, 12, Ends::Closed), brass, rail);
}

/// Three quiet abstracts: a sun over hills, stacked fields, an arc.
fn canvas(which: usize, u: f32, v: f32) -> [u8; 3] {
    let inside = |x: f32, y: f32, r: f32| ((u - x) * 0.75).hypot(v - y) < r;
    match which {
        0 if inside(0.6, 0.3, 0.13) => [196, 92, 48],
        0 if v > 0.62 + 0.1 * (u * 5.0).sin() => [58, 84, 70],
        0 if v > 0.52 + 0.08 * (u * 4.0 + 2.0).cos() => [142, 150, 120],
        1 if (0.1..0.9).contains(&u) && (0.1..0.42).contains(&v) => [186, 82, 46],
        1 if (0.1..0.9).contains(&u) && (0.47..0.68).contains(&v) => [34, 62, 74],
        1 if (0.1..0.9).contains(&u) && (0.73..0.9).contains(&v) => [206, 160, 84],
        2 if inside(0.5, 0.75, 0.3) && !inside(0.5, 0.75, 0.18) && v < 0.75 => [40, 66, 58],
        _ => [224, 214, 194],
    }
}

/// Armchair, side table and floor lamp in the right corner.
fn corner(set: &mut Set, group: NodeKey) {
    let velvet = set.paint("green velvet", [0.03, 0.115, 0.075], 0.8);
    let brass = set.metal("lamp brass", [0.83, 0.6, 0.28], 0.3);
    let linen = set.paint("lamp linen", [0.8, 0.72, 0.58], 0.95);
    let oak = set.paint("pale oak", [0.5, 0.34, 0.19], 0.5);
    let chair = set.scene.add(Some(group), "armchair", stand(1.62, 0.0, -1.35, -28.0), Content::Group);
    set.put(chair, "upholstery", armchair(), velvet, HOME);
    set.put(chair, "armchair feet", feet(0.36, 0.3, 0.17), brass, HOME);
    let parts = [cylinder(0.15, 0.02, 40, Ends::Closed), cylinder(0.011, 1.62, 12, Ends::Closed)];
    set.put(group, "lamp stand", MeshData::merged("", parts), brass, stand(2.35, 0.0, -1.96, 0.0));
    set.put(group, "lamp shade", shade(0.24, 0.14, 0.3), linen, stand(2.35, 1.38, -1.85, 0.0));
    let round = [
        cylinder(0.21, 0.02, 40, Ends::Closed).moved(Vec3::Y * 0.47),
        cylinder(0.018, 0.47, 12, Ends::Closed),
        cylinder(0.13, 0.015, 32, Ends::Closed),
    ];
    set.put(group, "side table", MeshData::merged("", round), oak, stand(2.35, 0.0, -1.15, 0.0));
    let cup = [[0.0, 0.0], [0.028, 0.0], [0.036, 0.03], [0.038, 0.08]].map(Vec2::from);
    set.put(group, "cup", lathe(&cup, 32), linen, stand(2.3, 0.49, -1.1, 0.0));
}
