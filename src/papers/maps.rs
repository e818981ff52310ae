//! Table 1 of paper 004: maps, silhouette maps and volumes on its scenes: what they read, what they take, and how wrong they are
//! against their texels.

use std::time::Instant;

use glam::{DAffine3, DVec2, DVec3, DVec4};
use shadowgraph_engine::geometry::{Chain, facing_signs};
use shadowgraph_engine::gpu::Timing;
use shadowgraph_engine::render::{Exposure, FrameRequest, RenderOptions, Renderer};
use shadowgraph_engine::scene::{CameraSnapshot, Content, NodeKey, Scene, ShadowNode};
use shadowgraph_measure::report::{
    Drawn, Entry, Figure, Plotted, PlottedLine, PlottedPoint, Table, TableCell,
};
use shadowgraph_measure::timing::Spread;
use shadowgraph_measure::{KnownReferences, LightError, measured};
use shadowgraph_nodes::common::cut_casters::cut_outline;
use shadowgraph_nodes::{PointFormat, ShadowMap, ShadowVolumeHard, SilhouetteMap};

use super::harness::{Bench, Made, PaperError, camera, shadowed};
use super::map_scenes::{castle, crowd, strike, vehicle};
use super::models::ModelError;
use crate::demo;

type MakeScene = fn() -> Result<Scene, ModelError>;

/// What their table says of a scene.
#[derive(Clone, Copy)]
struct Printed {
    triangles: f64,
    edges: f64,
    /// The share of the scene's pixels on silhouettes, in percent.
    on_silhouettes_percent: f64,
}

/// Their three scenes and, printed nowhere, their bowling pins and three scenes that the report times.
const SCENES: [(&str, MakeScene, Option<Printed>); 7] = [
    ("crowd", crowd, Some(Printed { triangles: 14_836.0, edges: 4_800.0, on_silhouettes_percent: 13.3 })),
    ("vehicle", vehicle, Some(Printed { triangles: 1_732.0, edges: 729.0, on_silhouettes_percent: 12.6 })),
    ("castle", castle, Some(Printed { triangles: 1_204.0, edges: 466.0, on_silhouettes_percent: 7.2 })),
    ("strike", strike, None),
    ("knot13k", || Ok(speed("knot13k")), None),
    ("boxes1k", || Ok(speed("boxes1k")), None),
    ("plant", || Ok(speed("plant")), None),
];

/// A scene of the report, without its shadow node.
fn speed(name: &str) -> Scene {
    let found = demo::speed().into_iter().find(|(stem, ..)| *stem == name);
    found.map_or_else(Scene::new, |(_, _, scene)| scene.without_shadows())
}

/// The resolution of their maps, in texels.
const THEIR_TEXELS: u32 = 512;
const TEXELS: [u32; 6] = [128, 256, 512, 1024, 2048, 4096];
const FEW_TEXELS: [u32; 2] = [128, 512];

pub(super) fn table_1(bench: &mut Bench<'_>) -> Made<Entry> {
    let mut entry = Entry {
        sentence: "On edges silhouettes beat maps of as many texels in every scene, and read about as much memory; volumes are \
                   exact and read more. What is fastest depends on the scene and on the adapter, and on whether anything moves."
            .into(),
        ..Entry::default()
    };
    let scenes = if bench.effort.ends_only { &SCENES[1..3] } else { &SCENES[..] };
    let [mut traffic, mut errors, mut times] = [const { Vec::new() }; 3];
    for (name, make, printed) in scenes {
        let scene = make()?;
        bench.tell(&format!("{name}, errors"));
        traffic.push(traffic_of(bench, (name, &scene, *printed), &mut entry)?);
        let right_enough = errors_of(bench, (name, &scene), &mut entry, &mut errors)?;
        bench.tell(&format!("{name}, frames in turn"));
        times_of(bench, (name, &scene), right_enough, &mut entry, &mut times)?;
    }
    let table = |caption: &str, columns: &[&'static str], rows| Table {
        caption: caption.into(),
        columns: columns.to_vec(),
        rows,
    };
    entry.tables = vec![
        table(
            "Their model of memory traffic at 512 texels (theirs in brackets): fragments of volumes for each pixel (O), pixels on \
             silhouettes (P), bytes for each pixel",
            &["scene", "triangles", "silhouette edges", "O", "P, %", "map", "silhouettes", "volumes"],
            traffic,
        ),
        table(
            "Wrong pixels in percent, and how far edges are off: wrong pixels over pixels of the edge",
            &["scene", "texels", "technique", "wrong, %", "edge off, px", "farthest, px"],
            errors,
        ),
        table(
            "Whole frames as multiples of the frame without shadows: kept maps, and drawn anew as the lamp moves",
            &["scene", "technique", "still ms", "still", "moved ms", "moved"],
            times,
        ),
    ];
    Ok(entry)
}

/// The model of 004 §4: a map reads 4 bytes for each pixel of the scene, a silhouette map 24 more for each on a silhouette, and
/// volumes 5.5 for each of their fragments.
fn traffic_of(
    bench: &mut Bench<'_>,
    (name, scene, printed): (&str, &Scene, Option<Printed>),
    entry: &mut Entry,
) -> Made<Vec<TableCell>> {
    let camera = camera(scene)?;
    // Where the four texels around a pixel do not agree, the mean of them is neither 0 nor 1.
    let corners = ShadowMap { resolution: THEIR_TEXELS, pcf: 2, ..ShadowMap::default() };
    let size_px = bench.effort.picture_px;
    let frame = bench.frame(&shadowed(scene, corners), |request| request.factors = true)?;
    let measured = measured(&frame, size_px)?;
    let pixels = measured.ids.iter().filter(|ids| ids[0] != u32::MAX).count() as f64;
    let between = measured.lights[0].1.iter().filter(|factor| **factor > 0.0 && **factor < 1.0).count();
    let share = between as f64 / pixels;
    let (edges, fragments) = volume_fill(scene, &camera, size_px)?;
    let overdraw = fragments / pixels;
    let instances = scene.snapshot()?.instances;
    let triangles: usize = instances.iter().map(|instance| instance.mesh.triangle_count()).sum();
    let beside = |ours: f64, theirs: fn(&Printed) -> f64| match &printed {
        Some(printed) => TableCell::Text(format!("{ours:.3} ({})", theirs(printed)).replace(".000", "")),
        None => ours.into(),
    };
    let figure = |key: &str, what: &str, ours: f64| {
        Figure::new(format!("{name}.{key}"), format!("{name}: {what}"), ours)
    };
    let percent = figure("on-silhouettes", "pixels on silhouettes, at 512 texels, in percent", 100.0 * share);
    entry
        .figures
        .push(printed.iter().fold(percent, |figure, printed| figure.beside(printed.on_silhouettes_percent)));
    entry.figures.push(
        figure("overdraw", "fragments of volumes for each pixel of the scene", overdraw)
            .beside_words("between 4 and 155"),
    );
    Ok(vec![
        name.into(),
        beside(triangles as f64, |printed| printed.triangles),
        beside(edges as f64, |printed| printed.edges),
        overdraw.into(),
        beside(100.0 * share, |printed| printed.on_silhouettes_percent),
        4.0.into(),
        (4.0 + 24.0 * share).into(),
        (5.5 * overdraw).into(),
    ])
}

/// The silhouette edges of all casters, and the pixels that the sides of their volumes cover, each side from its edge to infinity.
fn volume_fill(scene: &Scene, camera: &CameraSnapshot, size_px: [u32; 2]) -> Made<(usize, f64)> {
    let snapshot = scene.snapshot()?;
    let light = snapshot.lights[0].position;
    let [width, height] = size_px.map(f64::from);
    let clip_from_world = camera.clip_from_world(size_px);
    let (mut edges, mut fragments) = (0, 0.0);
    for instance in snapshot.instances.iter().filter(|instance| instance.shadow.casts) {
        let topology = instance.mesh.topology();
        let vertices = 0..instance.mesh.positions().len() as u32;
        let p_in_world: Vec<DVec3> = vertices.map(|vertex| instance.world_position(vertex)).collect();
        let signs = facing_signs(&p_in_world, topology.triangles(), light);
        let signs = match topology.orientation(&instance.world_from_local) {
            Some(orientation) => orientation.lit_only(&signs),
            None => signs,
        };
        let chain = Chain::extract(topology, &signs);
        edges += chain.silhouette_edges;
        for side in &chain.sides {
            let [a, b] = side.map(|vertex| p_in_world[vertex as usize].extend(1.0));
            let far = |p: DVec4| (p * light.w - light).truncate().extend(0.0);
            let side = [a, b, far(b), far(a)].map(|corner| clip_from_world * corner);
            fragments += visible_share(side.to_vec()) * width * height;
        }
    }
    Ok((edges, fragments))
}

/// The share of the picture that a polygon in clip space covers.
fn visible_share(polygon: Vec<DVec4>) -> f64 {
    let planes = [DVec4::X, DVec4::NEG_X, DVec4::Y, DVec4::NEG_Y, DVec4::NEG_Z].map(|side| side + DVec4::W);
    let polygon = cut_outline(polygon, &planes);
    let corners: Vec<DVec2> = polygon.iter().map(|corner| corner.truncate().truncate() / corner.w).collect();
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    // Twice the area of triangles from the middle; the picture's area is 4.
    ends.map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs() / 8.0
}

/// The share of wrong pixels with which a technique is right enough.
const RIGHT_ENOUGH: f64 = 0.001;

/// The techniques whose errors are asked for, with so many texels.
fn techniques(resolution: u32) -> [(&'static str, ShadowNode); 4] {
    let map = |pcf| ShadowNode::from(ShadowMap { resolution, pcf, ..ShadowMap::default() });
    let silhouette =
        |point_format| SilhouetteMap { resolution, point_format, ..SilhouetteMap::default() }.into();
    [
        ("map", map(1)),
        ("map, pcf 3", map(3)),
        ("silhouette", silhouette(PointFormat::TwoBytes)),
        ("silhouette, one byte", silhouette(PointFormat::OneByte)),
    ]
}

/// How far edges are off on average.
pub(super) fn edge_off_px(error: &LightError) -> f64 {
    error.wrong as f64 / error.boundary_pixels.max(1) as f64
}

/// Adds rows, a plot and pictures; returns the first resolution that is right enough, of maps and of silhouettes.
fn errors_of(
    bench: &mut Bench<'_>,
    (name, scene): (&str, &Scene),
    entry: &mut Entry,
    rows: &mut Vec<Vec<TableCell>>,
) -> Made<[Option<u32>; 2]> {
    let texels: &[u32] = if bench.effort.ends_only { &FEW_TEXELS } else { &TEXELS };
    let mut references = KnownReferences::default();
    let mut right_enough = [None; 2];
    let mut lines =
        techniques(1).map(|(label, _)| PlottedLine { name: label.into(), ..PlottedLine::default() });
    for &resolution in texels {
        for (index, (label, node)) in techniques(resolution).into_iter().enumerate() {
            let error = bench.judge(&shadowed(scene, node), &mut references)?.errors.swap_remove(0);
            let share = error.wrong as f64 / error.compared.max(1) as f64;
            let off_px = edge_off_px(&error);
            rows.push(vec![
                name.into(),
                f64::from(resolution).into(),
                label.into(),
                (100.0 * share).into(),
                off_px.into(),
                error.boundary_distance_max_px.into(),
            ]);
            let place = [f64::from(resolution), off_px];
            lines[index].points.push(PlottedPoint { at: place, quartiles: None });
            if index.is_multiple_of(2) && share <= RIGHT_ENOUGH {
                right_enough[index / 2].get_or_insert(resolution);
            }
            if resolution == THEIR_TEXELS && index.is_multiple_of(2) {
                let key = format!("{name}.{label}.edge-off");
                let what = format!("{name}: edges off at 512 texels, {label}");
                entry.figures.push(Figure::new(key, what, off_px).in_unit("px"));
            }
        }
    }
    let volumes = shadowed(scene, ShadowVolumeHard::default());
    let error = bench.judge(&volumes, &mut references)?.errors.swap_remove(0);
    let key = format!("{name}.volumes.wrong");
    let what = format!("{name}: wrong pixels of volumes, outside the band");
    entry.figures.push(Figure::new(key, what, error.wrong_outside_band as f64));
    entry.plots.push(Plotted {
        name: format!("004-table1-{name}"),
        title: format!("{name}: how far edges are off against texels"),
        axes: ["texels along a side", "px"],
        is_log: [true; 2],
        lines: lines.map(|line| PlottedLine { drawn: Drawn::Joined, ..line }).into(),
    });
    for (label, node) in techniques(THEIR_TEXELS).into_iter().step_by(2) {
        let caption = format!("{name}, {label} of 512 texels");
        let picture = format!("004-table1-{name}-{label}");
        entry.pictures.push(bench.picture(
            &shadowed(scene, node),
            Exposure::default(),
            (&picture, caption),
        )?);
    }
    Ok(right_enough)
}

/// Times of whole frames in turns, still and as the lamp moves; of maps also at the resolutions that are right enough.
fn times_of(
    bench: &Bench<'_>,
    (name, scene): (&str, &Scene),
    [map_texels, silhouette_texels]: [Option<u32>; 2],
    entry: &mut Entry,
    rows: &mut Vec<Vec<TableCell>>,
) -> Made<()> {
    let map = |resolution| ShadowMap { resolution, pcf: 1, ..ShadowMap::default() };
    let silhouette = |resolution| SilhouetteMap { resolution, ..SilhouetteMap::default() };
    let mut timed: Vec<(String, Option<ShadowNode>)> = vec![
        ("no shadows".into(), None),
        ("volumes".into(), Some(ShadowVolumeHard::default().into())),
        ("map 512".into(), Some(map(THEIR_TEXELS).into())),
        ("silhouette 512".into(), Some(silhouette(THEIR_TEXELS).into())),
        ("map 2048".into(), Some(map(2048).into())),
        ("silhouette 2048".into(), Some(silhouette(2048).into())),
    ];
    timed.extend(map_texels.map(|n| (format!("map {n}: 0.1 % wrong"), Some(map(n).into()))));
    timed.extend(
        silhouette_texels.map(|n| (format!("silhouette {n}: 0.1 % wrong"), Some(silhouette(n).into()))),
    );
    let mut runners = Vec::new();
    for (_, node) in &timed {
        let scene = node.as_ref().map_or(scene.clone(), |node| shadowed(scene, node.clone()));
        runners.push(Moving::new(bench, scene)?);
    }
    let times_ms = in_turns(bench, &mut runners)?;
    for ((label, _), own) in timed.iter().zip(&times_ms) {
        let [still, moved] = [0, 1].map(|how| {
            let ratios = own[how].iter().zip(&times_ms[0][how]).map(|(own, bare)| own / bare).collect();
            (Spread::of(own[how].clone()), Spread::of(ratios))
        });
        rows.push(vec![
            name.into(),
            label.as_str().into(),
            still.0.median.into(),
            still.1.median.into(),
            moved.0.median.into(),
            moved.1.median.into(),
        ]);
        if ["volumes", "map 512", "silhouette 512"].contains(&label.as_str()) {
            let key = format!("{name}.{}.moved", label.replace(' ', "-"));
            let what = format!("{name}: frame with all drawn anew, of that without shadows, {label}");
            entry.figures.push(Figure::spread(key, what, moved.1));
        }
    }
    Ok(())
}

/// A scene whose lamp moves a little and back.
struct Moving {
    renderer: Renderer,
    scene: Scene,
    request: FrameRequest,
    lamp: NodeKey,
}

impl Moving {
    fn new(bench: &Bench<'_>, scene: Scene) -> Made<Self> {
        let request = FrameRequest::new(camera(&scene)?, bench.effort.size_px);
        let lamp = scene.nodes().find(|(_, node)| matches!(node.content, Content::Light(_)));
        let lamp = lamp.map(|(key, _)| key).ok_or(PaperError::Missing("a light"))?;
        Ok(Self { renderer: bench.another_renderer(), scene, request, lamp })
    }

    fn frame_ms(&mut self) -> Made<f64> {
        let options = RenderOptions { timing: Timing::Off, ..RenderOptions::default() };
        let start = Instant::now();
        self.renderer.render(&self.scene, &self.request, &options)?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }

    fn shift(&mut self, x_m: f64) -> Made<()> {
        let node = self.scene.node_mut(self.lamp).ok_or(PaperError::Missing("a light"))?;
        node.parent_from_local = DAffine3::from_translation(DVec3::X * x_m) * node.parent_from_local;
        Ok(())
    }
}

/// Rounds in which every scene draws one frame as it was and one with its lamp moved; the first two are not counted.
fn in_turns(bench: &Bench<'_>, runners: &mut [Moving]) -> Made<Vec<[Vec<f64>; 2]>> {
    let pace = bench.effort.pace;
    let mut times_ms = vec![[const { Vec::new() }; 2]; runners.len()];
    let mut start = Instant::now();
    for round in 0..pace.max_rounds + 2 {
        if round == 2 {
            start = Instant::now();
        }
        if round >= pace.min_rounds + 2 && start.elapsed() >= pace.budget {
            break;
        }
        for (runner, times_ms) in runners.iter_mut().zip(&mut times_ms) {
            let still_ms = runner.frame_ms()?;
            runner.shift(if round % 2 == 0 { 1e-3 } else { -1e-3 })?;
            let moved_ms = runner.frame_ms()?;
            // What moved is drawn once more, so that the next frame is still.
            runner.frame_ms()?;
            if round >= 2 {
                times_ms[0].push(still_ms);
                times_ms[1].push(moved_ms);
            }
        }
    }
    Ok(times_ms)
}
