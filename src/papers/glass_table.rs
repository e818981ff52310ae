//! Table 1 of paper 000: whole frames with opaque casters and with transparent ones, on casters of as many triangles as theirs.

use glam::{DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::{MeshData, shapes};
use shadowgraph_engine::render::Exposure;
use shadowgraph_engine::scene::{Camera, Light, Scene, ShadowNode};
use shadowgraph_measure::KnownReferences;
use shadowgraph_measure::report::{Entry, Figure, Table, TableCell};
use shadowgraph_nodes::{Accumulate, SelfShadow, ShadowVolumeHard, TransparentShadow};

use super::harness::{Bench, Made};
use super::models::{ModelError, add, block, floor, glass, matt};

/// A row of their table: its name here, its casters, and their frames a second: opaque, transparent, with partial shadows on
/// these.
type Model = (&'static str, fn() -> Vec<MeshData>, [f64; 3]);

const MODELS: [Model; 4] = [
    ("ball and cubes", ball_and_cubes, [703.4, 512.5, 288.4]),
    ("text", letters, [193.1, 98.7, 56.0]),
    ("jellyfish", jellyfish, [35.0, 24.9, 14.9]),
    ("knot", knot, [41.4, 21.7, 12.9]),
];

/// What casts, and what stands in their table for it.
#[derive(Clone, Copy, PartialEq)]
enum Row {
    Opaque,
    Glass(Accumulate, SelfShadow),
}

/// The first is what the others are multiples of.
const ROWS: [(&str, Row); 6] = [
    ("opaque", Row::Opaque),
    ("none", Row::Glass(Accumulate::Counts, SelfShadow::None)),
    ("none, log16", Row::Glass(Accumulate::Log16, SelfShadow::None)),
    ("partial", Row::Glass(Accumulate::Counts, SelfShadow::Partial)),
    ("partial, log16", Row::Glass(Accumulate::Log16, SelfShadow::Partial)),
    ("full", Row::Glass(Accumulate::Counts, SelfShadow::Full)),
];

pub(super) fn table_1(bench: &mut Bench<'_>) -> Made<Entry> {
    let mut entry = Entry {
        sentence: "Glass casters cost more than opaque ones, partial shadows on the glass more than none, and full ones, which \
                   they could not have, the most; their logarithms in half floats (log16) cost about what exact counts cost, \
                   and are further off."
            .into(),
        ..Entry::default()
    };
    let mut rows = Vec::new();
    let models = if bench.effort.ends_only { &MODELS[..1] } else { &MODELS[..] };
    for (name, casters, theirs) in models {
        bench.tell(name);
        model(bench, (name, &casters(), *theirs), &mut entry, &mut rows)?;
    }
    entry.tables.push(Table {
        caption: "Whole frames; error of the factor on the floor, whatever band it is in".into(),
        columns: vec!["casters", "triangles", "shadows on glass", "ms", "of opaque", "theirs", "RMSE", "max"],
        rows,
    });
    Ok(entry)
}

fn model(
    bench: &mut Bench<'_>,
    (name, casters, [opaque, none, partial]): (&str, &[MeshData], [f64; 3]),
    entry: &mut Entry,
    rows: &mut Vec<Vec<TableCell>>,
) -> Made<()> {
    let scenes = ROWS.iter().map(|(_, row)| scene(casters, *row)).collect::<Result<Vec<_>, _>>()?;
    let rounds = bench.rounds(&scenes)?;
    let key = name.replace(' ', "-");
    let triangles: usize = casters.iter().map(|data| data.indices.len() / 3).sum();
    let mut references = KnownReferences::default();
    for (index, ((label, row), scene)) in ROWS.iter().zip(&scenes).enumerate() {
        let theirs = match row {
            Row::Opaque => Some(1.0),
            Row::Glass(Accumulate::Log16, SelfShadow::None) => Some(opaque / none),
            Row::Glass(Accumulate::Log16, SelfShadow::Partial) => Some(opaque / partial),
            _ => None,
        };
        let error = bench.judge(scene, &mut references)?.errors.swap_remove(0);
        let ratio = rounds.ratio(index, 0);
        rows.push(vec![
            name.into(),
            (triangles as f64).into(),
            (*label).into(),
            rounds.ms(index).median.into(),
            ratio.median.into(),
            theirs.into(),
            error.rmse.into(),
            error.max_outside_band.into(),
        ]);
        let id = label.replace(", ", "-");
        if *row != Row::Opaque {
            let figure = Figure::spread(
                format!("{key}.{id}.of-opaque"),
                format!("{name}, shadows on glass {label}: frame time, as a multiple of opaque casters'"),
                ratio,
            );
            entry.figures.push(theirs.into_iter().fold(figure, Figure::beside));
        }
    }
    let caption = format!("{name}: glass with full shadows on it");
    entry.pictures.push(bench.picture(
        &scenes[5],
        Exposure::default(),
        (&format!("000-table1-{key}"), caption),
    )?);
    Ok(())
}

/// The casters over a floor under a lamp, with a shadow node over them all.
fn scene(casters: &[MeshData], row: Row) -> Result<Scene, ModelError> {
    let mut scene = Scene::new();
    floor(&mut scene, 12.0)?;
    let tints = [Vec3::new(0.9, 0.35, 0.25), Vec3::new(0.3, 0.6, 0.95), Vec3::new(0.5, 0.85, 0.4)];
    let mut keys = Vec::new();
    for (data, tint) in casters.iter().zip(tints) {
        let material = if row == Row::Opaque { matt(tint) } else { glass(tint, 0.3) };
        keys.push(add(&mut scene, data.clone(), material)?);
    }
    scene.add_lamp(Light::point("lamp", 160.0), DVec3::new(3.0, 6.5, 2.0));
    let camera = Camera::perspective("main", 45.0_f64.to_radians());
    scene.add_camera(camera, DVec3::new(3.2, 3.6, 6.2), DVec3::new(0.0, 0.9, 0.0));
    let node = match row {
        Row::Opaque => ShadowNode::from(ShadowVolumeHard::default()),
        Row::Glass(accumulate, self_shadow) => TransparentShadow { accumulate, self_shadow }.into(),
    };
    scene.add_shadow("shadows", node.with_casters(keys));
    Ok(scene)
}

/// A ball over a field of cubes: 1 116 triangles.
fn ball_and_cubes() -> Vec<MeshData> {
    let cube = |i: i32| {
        let (x, z) = ((i % 6) as f32 * 0.6 - 1.5, (i / 6) as f32 * 0.6 - 1.5);
        block([x - 0.15, 0.1, z - 0.15], [x + 0.15, 0.4, z + 0.15])
    };
    let cubes = MeshData::merged("cubes", (0..33).map(cube));
    vec![shapes::uv_sphere(0.7, 24, 16).moved(Vec3::Y * 1.6).named("ball"), cubes]
}

/// Rows of rings and bars, much as extruded letters are: about 13 600 triangles.
fn letters() -> Vec<MeshData> {
    let ring = |i: i32| {
        let (x, y) = ((i % 7) as f32 * 0.5 - 1.5, 0.5 + (i / 7) as f32 * 0.5);
        shapes::torus(0.16, 0.05, 32, 10).moved(Vec3::new(x, y, 0.0))
    };
    let bar = |i: i32| {
        let (x, y) = ((i % 7) as f32 * 0.5 - 1.25, 0.5 + (i / 7) as f32 * 0.5);
        block([x - 0.03, y - 0.2, -0.05], [x + 0.03, y + 0.2, 0.05])
    };
    let line = |name: &str, i: i32| {
        let (rings, bars) = ((i * 7..i * 7 + 7).map(ring), (i * 7..i * 7 + 7).map(bar));
        MeshData::merged(name, rings.chain(bars))
    };
    vec![line("first line", 0), line("second line", 1), line("third line", 2)]
}

/// Open bells over many thin arms: about 27 700 triangles.
fn jellyfish() -> Vec<MeshData> {
    let bell = |radius: f32| {
        let rim = |t: f32| {
            let angle = t * std::f32::consts::FRAC_PI_2;
            Vec2::new(angle.sin() * radius, 1.6 + angle.cos() * radius * 0.7)
        };
        shapes::lathe(&(0..=24).map(|i| rim(i as f32 / 24.0)).collect::<Vec<_>>(), 96)
    };
    let arm = |i: u32| {
        let turn = i as f32 / 24.0 * std::f32::consts::TAU;
        let at = |s: f32, t: f32| {
            let (wave, around) = ((s * 9.0 + turn * 3.0).sin() * 0.12, t * std::f32::consts::TAU);
            let r = 0.5 + wave + around.cos() * 0.025;
            Vec3::new(turn.cos() * r, 1.55 - s * 1.3, turn.sin() * r + around.sin() * 0.025)
        };
        shapes::sheet(64, 6, at)
    };
    let arms = MeshData::merged("arms", (0..24).map(arm));
    vec![bell(0.8).named("bell"), bell(0.55).named("inner bell"), arms]
}

/// A torus knot of 62 976 triangles.
fn knot() -> Vec<MeshData> {
    vec![shapes::torus_knot([2, 3], 0.8, 0.2, [656, 48]).moved(Vec3::Y * 1.3).named("knot")]
}
