//! Paper 002 on casters that are open: its Fig. 3 with and without its modification, what overlaps, what a closed caster saves,
//! and its Fig. 6 with both ways to count.

use glam::{DVec3, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{self, Ends};
use shadowgraph_engine::render::{Exposure, FrameRequest};
use shadowgraph_engine::scene::{Scene, ShadowNode};
use shadowgraph_measure::report::{Entry, Figure, Table, TableCell};
use shadowgraph_measure::{Evaluation, KnownReferences, LightError, pictures};
use shadowgraph_nodes::{DepthTest, GeometryMode, ShadowVolumeHard};

use super::harness::{Bench, Made, PaperError, camera, shadowed};
use super::models::{ModelError, add, block, matt, open_box, stage};
use super::unmodified;
use crate::demo;

pub(super) fn fig_3(bench: &mut Bench<'_>) -> Made<Entry> {
    let (open, closed) = (three_casters(Ends::Open)?, three_casters(Ends::Closed)?);
    let unmodified = || ShadowNode::new(unmodified::ENTRY.type_name);
    let rows: [(&str, &str, &Scene, ShadowNode); 4] = [
        ("without", "open casters, without the modification", &open, unmodified()),
        ("with", "open casters, with the modification", &open, ShadowVolumeHard::default().into()),
        ("closed-without", "closed casters, without the modification", &closed, unmodified()),
        ("closed-with", "closed casters, with the modification", &closed, ShadowVolumeHard::default().into()),
    ];
    let mut entry = Entry {
        sentence: "Without the modification volumes stay open where a mesh ends: shadows are missing, and streaks of them lie \
                   where nothing casts. With it every pixel is right. Closed casters need none."
            .into(),
        ..Entry::default()
    };
    for (key, what, scene, node) in rows {
        let scene = shadowed(scene, node);
        let judged = bench.judge(&scene, &mut KnownReferences::default())?;
        let error = &judged.errors[0];
        let wrong = wrong(key, what, error);
        let said = match key {
            "without" => wrong.beside_words("shown to be wrong"),
            "with" => wrong.beside_words("shown to be right"),
            _ => wrong,
        };
        entry.figures.push(said);
        entry.figures.extend((key == "without").then(|| {
            Figure::new(
                "without.leak",
                "of these lit where they should be dark",
                error.leak_outside_band as f64,
            )
        }));
        if key.starts_with("closed") {
            continue;
        }
        let name = format!("002-fig3-{key}");
        entry.pictures.push(bench.picture(&scene, Exposure::default(), (&name, what))?);
        if key == "without" {
            entry.pictures.push(error_map(&judged, "002-fig3-map")?);
        }
    }
    Ok(entry)
}

fn wrong(key: &str, what: &str, error: &LightError) -> Figure {
    let what = format!("wrong pixels of {}: {what}", error.compared);
    Figure::new(format!("{key}.wrong"), what, error.wrong_outside_band as f64)
}

/// Where a picture is wrong.
fn error_map(judged: &Evaluation, name: &str) -> Made<shadowgraph_measure::report::Picture> {
    let light = &judged.errors[0].name;
    let png = pictures::error_map_png(name.as_ref(), &judged.measured, &judged.reference, light)?;
    let caption = "where it is wrong: red too light, blue too dark, yellow what rasterisation excuses".into();
    Ok(shadowgraph_measure::report::Picture { name: name.into(), caption, png })
}

/// A box without its lid, a tube and a cone, or their solids.
fn three_casters(ends: Ends) -> Result<Scene, ModelError> {
    let mut scene =
        stage(6.0, DVec3::new(-1.8, 4.6, 1.4), [DVec3::new(2.0, 2.5, 4.0), DVec3::new(0.55, 0.4, 0.0)])?;
    let (min, max) = ([-1.2, 0.5, -0.4], [-0.4, 1.1, 0.4]);
    let case = if ends == Ends::Open { open_box(min, max) } else { block(min, max) };
    let tilt = glam::DAffine3::from_rotation_z(0.7);
    let tube = shapes::cylinder(0.3, 0.9, 24, ends).transformed(&tilt).moved(Vec3::new(0.5, 0.7, -0.5));
    let shade = shapes::frustum(0.5, 0.2, 0.5, 24, ends).moved(Vec3::new(1.3, 0.9, 0.6));
    let colors = [Vec3::new(0.8, 0.45, 0.2), Vec3::new(0.25, 0.5, 0.75), Vec3::new(0.85, 0.8, 0.55)];
    for (data, color) in
        [case.named("case"), tube.named("tube"), shade.named("shade")].into_iter().zip(colors)
    {
        add(&mut scene, data, matt(color))?;
    }
    Ok(scene)
}

/// Sheets over each other: below and at their limits, and beyond.
const SHEETS: [u32; 5] = [64, 127, 128, 256, 512];

pub(super) fn overlap(bench: &mut Bench<'_>) -> Made<Entry> {
    let mut entry = Entry {
        sentence: "They expected artefacts from 128 volumes on, with open casters, and from 256 with closed ones, since an \
                   eight-bit count wraps. Counted in groups, as many as there are, none is wrong."
            .into(),
        ..Entry::default()
    };
    let counts = if bench.effort.ends_only { vec![128, 256] } else { SHEETS.to_vec() };
    for count in counts {
        let open = ShadowVolumeHard { geometry: GeometryMode::Open, ..ShadowVolumeHard::default() };
        for (kind, theirs, node) in [("open", 128, open), ("closed", 256, ShadowVolumeHard::default())] {
            let scene = shadowed(&over_each_other(count, kind)?, node);
            let judged = bench.judge(&scene, &mut KnownReferences::default())?;
            let what = format!("{count} {kind} volumes over each other");
            let figure = wrong(&format!("{kind}-{count}"), &what, &judged.errors[0]);
            let fails = count >= theirs;
            entry.figures.push(figure.beside_words(if fails {
                "“artefacts may appear”"
            } else {
                "right"
            }));
            if (count, kind) == (256, "open") {
                let caption = "256 sheets over each other: a shadow behind all of them";
                entry.pictures.push(bench.picture(&scene, Exposure::default(), ("002-overlap", caption))?);
            }
        }
    }
    Ok(entry)
}

/// So many sheets or boxes, one above the other, seen from the side through all of their volumes.
fn over_each_other(count: u32, kind: &str) -> Result<Scene, ModelError> {
    let mut scene =
        stage(5.0, DVec3::new(0.0, 6.0, 0.3), [DVec3::new(1.2, 1.6, 3.4), DVec3::new(0.0, 0.6, 0.0)])?;
    let pitch = 1.0 / count as f32;
    let one = |i: u32| {
        let y = 0.6 + i as f32 * pitch;
        if kind == "open" {
            shapes::quad([[-0.4, y, 0.4], [0.4, y, 0.4], [0.4, y, -0.4], [-0.4, y, -0.4]].map(Vec3::from))
        } else {
            block([-0.4, y, -0.4], [0.4, y + pitch * 0.5, 0.4])
        }
    };
    add(&mut scene, MeshData::merged("sheets", (0..count).map(one)), matt(Vec3::new(0.3, 0.5, 0.7)))?;
    Ok(scene)
}

/// The knot of the report, without shadows.
pub(super) fn knot() -> Scene {
    demo::speed().swap_remove(0).2.without_shadows()
}

pub(super) fn fig_6(bench: &mut Bench<'_>) -> Made<Entry> {
    let auto = ShadowVolumeHard::default();
    let rows = [
        ("no shadows", None),
        ("zpass", Some(ShadowVolumeHard { depth_test: DepthTest::ZPass, ..auto })),
        ("zfail", Some(ShadowVolumeHard { depth_test: DepthTest::ZFail, ..auto })),
    ];
    let knot = knot();
    let scene_of = |node: Option<ShadowVolumeHard>| node.map_or(knot.clone(), |node| shadowed(&knot, node));
    let scenes: Vec<Scene> = rows.iter().map(|(_, node)| scene_of(*node)).collect();
    let rounds = bench.rounds(&scenes)?;
    let mut references = KnownReferences::default();
    let mut figures = Vec::new();
    for (row, (key, node)) in rows.iter().enumerate().filter(|(_, (_, node))| node.is_some()) {
        let judged = bench.judge(&scene_of(*node), &mut references)?;
        figures.push(wrong(key, &format!("the knot, {key}"), &judged.errors[0]));
        let of = Figure::spread(
            format!("{key}.of-unshadowed"),
            format!("{key}: frame, of that without shadows"),
            rounds.ratio(row, 0),
        );
        figures.push(of);
    }
    let ratio = Figure::spread("zfail.of-zpass", "zfail: frame, of zpass's", rounds.ratio(2, 1));
    figures.push(ratio.beside_words("z-pass “is faster”"));
    Ok(Entry {
        sentence: "Shadows fall on everything, casters themselves included, and end where they end at every pixel. Counting \
                   from the eye, which must then be outside of them, spares the caps that counting from infinity draws."
            .into(),
        figures,
        pictures: vec![bench.picture(&scenes[1], Exposure::default(), ("002-fig6", "hard shadow volumes"))?],
        ..Entry::default()
    })
}

pub(super) fn open_against_closed(bench: &mut Bench<'_>) -> Made<Entry> {
    let knot = knot();
    let mode = |geometry| shadowed(&knot, ShadowVolumeHard { geometry, ..ShadowVolumeHard::default() });
    let scenes = [knot.clone(), mode(GeometryMode::Closed), mode(GeometryMode::Open)];
    let rounds = bench.rounds(&scenes)?;
    let request = FrameRequest::new(camera(&knot)?, bench.effort.size_px);
    let mut references = KnownReferences::default();
    let (mut figures, mut rows, mut factors, mut drawn) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (row, name) in ["none", "closed", "open"].into_iter().enumerate() {
        let plan = bench.renderer.plan(&scenes[row], &request)?;
        let volumes = plan.passes_named("volumes of").flat_map(|pass| &pass.draws);
        let vertices = volumes.map(|draw| draw.vertices()).sum::<u64>() as f64;
        rows.push(vec![
            TableCell::from(name),
            rounds.ms(row).median.into(),
            rounds.adds(row, 0).median.into(),
            vertices.into(),
            (plan.bytes() as f64).into(),
        ]);
        if row > 0 {
            let mut judged = bench.judge(&scenes[row], &mut references)?;
            figures.push(wrong(name, &format!("the knot, {name}"), &judged.errors[0]));
            factors.push(judged.measured.lights.swap_remove(0).1);
            drawn.push(vertices);
        }
    }
    let [closed, open] = &factors[..] else { return Err(PaperError::Missing("a picture")) };
    let differs = |(a, b): &(&f32, &f32)| a.to_bits() != b.to_bits() && !(a.is_nan() && b.is_nan());
    let different = closed.iter().zip(open).filter(differs).count();
    figures.extend([
        Figure::new("different", "pixels whose factor differs between open and closed", different as f64),
        Figure::new("vertices", "vertices of volumes, open, of closed", drawn[1] / drawn[0])
            .beside_words("quads twice, caps whole"),
        Figure::spread("open.of-closed", "open: frame, of closed", rounds.ratio(2, 1))
            .beside_words("closed is faster"),
    ]);
    let caption = "the knot, taken as an open caster: as when taken as a solid";
    Ok(Entry {
        sentence: "Taken as open, a solid casts with all of its triangles and twice from every silhouette: the same shadow, \
                   from more volumes."
            .into(),
        figures,
        tables: vec![Table {
            caption: "The knot of 13 056 triangles".into(),
            columns: vec!["geometry", "ms", "adds ms", "vertices", "bytes"],
            rows,
        }],
        pictures: vec![bench.picture(&scenes[2], Exposure::default(), ("002-open-closed", caption))?],
        ..Entry::default()
    })
}
