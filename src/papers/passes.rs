//! Paper 002 on the picture that is darkened once when it is finished: single pass against multi pass, and the highlights that
//! darkening leaves.

use glam::{DVec3, Vec3};
use shadowgraph_engine::geometry::shapes;
use shadowgraph_engine::render::{Exposure, FrameRequest, PictureFormat};
use shadowgraph_engine::scene::{Camera, Light, Material, Scene};
use shadowgraph_measure::report::{Drawn, Entry, Figure, Plotted, PlottedLine, PlottedPoint};
use shadowgraph_measure::{Evaluation, KnownReferences};
use shadowgraph_nodes::{Apply, Passes, ShadowVolumeHard, ShadowVolumeSoft};

use super::harness::{Bench, Made, PaperError, shadowed};
use super::models::{ModelError, add, block, floor, matt};
use super::open_casters::knot;
use crate::demo;

/// Linear green of every pixel.
fn linear(bench: &mut Bench<'_>, scene: &Scene) -> Made<Vec<f64>> {
    let frame =
        bench.frame(scene, |request: &mut FrameRequest| request.picture = PictureFormat::LinearF32)?;
    let pixels = frame.picture.ok_or(PaperError::Missing("a frame's picture"))?;
    let floats = pixels.floats().map_err(shadowgraph_engine::render::RenderError::from)?;
    Ok(floats.chunks_exact(4).map(|rgba| f64::from(rgba[1])).collect())
}

/// The mean over pixels of how much of `whole` is left in `part`.
fn share(part: &[f64], whole: &[f64], of: &[usize]) -> f64 {
    let sum = |values: &[f64]| of.iter().map(|pixel| values[*pixel]).sum::<f64>();
    sum(part) / sum(whole)
}

const LAMPS: [u32; 4] = [1, 2, 4, 8];

pub(super) fn single_against_multi(bench: &mut Bench<'_>) -> Made<Entry> {
    let scene = crossing()?;
    let single = ShadowVolumeHard { passes: Passes::Single, ..ShadowVolumeHard::default() };
    let [multi_scene, single_scene] =
        [ShadowVolumeHard::default(), single].map(|node| shadowed(&scene, node));
    let Evaluation { reference, .. } = bench.judge(&multi_scene, &mut KnownReferences::default())?;
    // On the floor, which is instance 0, away from edges.
    let clear = |pixel: &usize| {
        reference.hits[*pixel].is_some_and(|hit| hit.instance == 0)
            && reference.lights.iter().all(|light| light.compared[*pixel] && !light.ambiguous[*pixel])
    };
    let dark = |count: usize| -> Vec<usize> {
        let darkened =
            |pixel: &usize| reference.lights.iter().filter(|light| light.factor[*pixel] == 0.0).count();
        (0..reference.hits.len()).filter(clear).filter(|pixel| darkened(pixel) == count).collect()
    };
    let (whole, multi, single_picture) =
        (linear(bench, &scene)?, linear(bench, &multi_scene)?, linear(bench, &single_scene)?);
    let mut figures = Vec::new();
    for (key, count, what) in [("once", 1, "one lamp is hidden"), ("crossing", 2, "both lamps are hidden")] {
        let pixels = dark(count);
        if pixels.is_empty() {
            return Err(PaperError::Missing("a pixel where shadows are"));
        }
        for (name, picture) in [("multi", &multi), ("single", &single_picture)] {
            let left = share(picture, &whole, &pixels);
            let figure = Figure::new(
                format!("{key}.{name}"),
                format!("light left on the floor where {what}, {name} pass"),
                left,
            );
            let said = match (key, name) {
                ("crossing", "multi") => figure.beside_words("“a darker shadowed region”"),
                _ => figure,
            };
            figures.push(said);
        }
    }
    let (plot, costs) = against_lamps(bench, single)?;
    figures.extend(costs);
    Ok(Entry {
        sentence: "A single pass darkens the picture once, however many lights are hidden: where shadows cross it is too light, \
                   and a shadow is as dark under a weak lamp as under a strong one. Several passes are right; counting is the \
                   same work either way, and only the shading differs."
            .into(),
        figures,
        plots: vec![plot],
        pictures: vec![
            bench.picture(&multi_scene, Exposure::default(), ("002-multi", "multi pass: darker where shadows cross"))?,
            bench.picture(&single_scene, Exposure::default(), ("002-single", "single pass: one tone of shadow"))?,
        ],
        ..Entry::default()
    })
}

/// Frames of both against lamps.
fn against_lamps(bench: &mut Bench<'_>, single: ShadowVolumeHard) -> Made<(Plotted, Vec<Figure>)> {
    let lamps = bench.effort.of(&LAMPS);
    let lit: Vec<Scene> = lamps.iter().map(|count| demo::under_lamps(&knot(), *count)).collect();
    let multi = lit.iter().map(|scene| shadowed(scene, ShadowVolumeHard::default()));
    let single = lit.iter().map(|scene| shadowed(scene, single));
    let scenes: Vec<Scene> = multi.chain(single).collect();
    bench.tell("frames in turn");
    let rounds = bench.rounds(&scenes)?;
    let few = lamps.len();
    let line = |name: &str, first: usize| {
        let point = |(row, count): (usize, &u32)| {
            let ms = rounds.ms(first + row);
            PlottedPoint { at: [f64::from(*count), ms.median], quartiles: Some([ms.lower, ms.upper]) }
        };
        let points = lamps.iter().enumerate().map(point).collect();
        PlottedLine { name: name.into(), drawn: Drawn::Joined, points }
    };
    let plot = Plotted {
        name: "002-single-multi".into(),
        title: "Time of a frame against lamps".into(),
        axes: ["lamps", "ms"],
        is_log: [false; 2],
        lines: vec![line("multi", 0), line("single", few)],
    };
    let ratio = |row: usize| {
        let ratio = rounds.ratio(row, few + row);
        Figure::spread(
            format!("multi-of-single.{}", lamps[row]),
            format!("lamps: {}; multi: frame, of single's", lamps[row]),
            ratio,
        )
        .beside_words("“much more expensive”")
    };
    Ok((plot, vec![ratio(0), ratio(few - 1)]))
}

/// A post and a beam under two lamps whose shadows cross.
fn crossing() -> Result<Scene, ModelError> {
    let mut scene = Scene::new();
    floor(&mut scene, 6.0)?;
    add(
        &mut scene,
        block([-0.25, 0.0, -0.25], [0.25, 1.4, 0.25]).named("post"),
        matt(Vec3::new(0.3, 0.5, 0.75)),
    )?;
    add(
        &mut scene,
        block([-1.4, 0.7, 0.9], [1.4, 0.85, 1.05]).named("beam"),
        matt(Vec3::new(0.8, 0.5, 0.3)),
    )?;
    for (name, x) in [("left", -1.6), ("right", 1.6)] {
        scene.add_lamp(Light::point(name, 70.0), DVec3::new(x, 4.2, -2.4));
    }
    scene.set_ambient(Vec3::splat(0.05));
    scene.add_camera(Camera::perspective("main", 0.75), DVec3::new(0.5, 4.6, 6.0), DVec3::new(0.0, 0.2, 0.8));
    Ok(scene)
}

/// How much of the picture a shadow takes that darkens it.
const WEIGHT: f64 = 0.7;

pub(super) fn highlight(bench: &mut Bench<'_>) -> Made<Entry> {
    let scene = polished()?;
    let soft = ShadowVolumeSoft { radius_m: 0.03, ..ShadowVolumeSoft::default() };
    let per_pixel = shadowed(&scene, soft);
    let darkened = shadowed(&scene, ShadowVolumeSoft { apply: Apply::Darken, weight: WEIGHT, ..soft });
    // All of the lamp is hidden there; the floor is instance 0.
    let hard =
        bench.judge(&shadowed(&scene, ShadowVolumeHard::default()), &mut KnownReferences::default())?;
    let hidden = |pixel: &usize| {
        let light = &hard.reference.lights[0];
        let on_floor = hard.reference.hits[*pixel].is_some_and(|hit| hit.instance == 0);
        on_floor && light.compared[*pixel] && !light.ambiguous[*pixel] && light.factor[*pixel] == 0.0
    };
    let hidden: Vec<usize> = (0..hard.reference.hits.len()).filter(hidden).collect();
    let whole = linear(bench, &scene)?;
    let brightest = hidden.iter().copied().max_by(|a, b| whole[*a].total_cmp(&whole[*b]));
    let brightest = brightest.ok_or(PaperError::Missing("a pixel in shadow"))?;
    // How much brighter than the shadow around it the lamp's mirror image is.
    let stands_out = |picture: &[f64]| {
        let mut around: Vec<f64> = hidden.iter().map(|pixel| picture[*pixel]).collect();
        around.sort_by(f64::total_cmp);
        picture[brightest] - around[around.len() / 2]
    };
    let (right, left) = (linear(bench, &per_pixel)?, linear(bench, &darkened)?);
    let figures = vec![
        Figure::new(
            "whole",
            "radiance of the highlight's brightest pixel, without the shadow",
            whole[brightest],
        ),
        Figure::new(
            "right",
            "the same where the shadow is applied to the light: what else there is",
            right[brightest],
        ),
        Figure::new("darkened", "the same where the picture is darkened by 0.7", left[brightest])
            .beside_words("“still visible, albeit darkened”"),
        Figure::new(
            "whole-contrast",
            "how much brighter than around it, without the shadow",
            stands_out(&whole),
        ),
        Figure::new("right-contrast", "the same, applied to the light", stands_out(&right)),
        Figure::new("darkened-contrast", "the same, the picture darkened", stands_out(&left)),
        Figure::new(
            "darkened-share",
            "of the highlight's contrast darkening leaves",
            stands_out(&left) / stands_out(&whole),
        )
        .beside(1.0 - WEIGHT),
    ];
    Ok(Entry {
        sentence: "Darkening the finished picture dims the lamp's mirror image, which a shadow should hide: a highlight stays in the \
                   middle of it. Taking the light itself away leaves no trace."
            .into(),
        figures,
        pictures: vec![
            bench.picture(&scene, Exposure::Fixed(1.0), ("002-highlight-none", "no shadow: the lamp's highlight"))?,
            bench.picture(&per_pixel, Exposure::Fixed(1.0), ("002-highlight-right", "applied to the light"))?,
            bench.picture(&darkened, Exposure::Fixed(1.0), ("002-highlight-darkened", "the picture darkened"))?,
        ],
        ..Entry::default()
    })
}

/// A polished floor that mirrors a lamp, and a board that hides the lamp from where it does.
fn polished() -> Result<Scene, ModelError> {
    let mut scene = Scene::new();
    let polished = Material { roughness: 0.25, ..Material::matt("polished", Vec3::splat(0.25)) };
    add(&mut scene, shapes::plane(glam::Vec2::splat(6.0)).named("floor"), polished)?;
    add(
        &mut scene,
        block([-0.8, 1.2, -1.3], [0.8, 1.3, -0.4]).named("board"),
        matt(Vec3::new(0.7, 0.4, 0.25)),
    )?;
    scene.add_lamp(Light::point("lamp", 30.0), DVec3::new(0.0, 3.0, -2.4));
    scene.set_ambient(Vec3::splat(0.15));
    scene.add_camera(
        Camera::perspective("main", 0.75),
        DVec3::new(0.0, 2.0, 2.6),
        DVec3::new(0.0, 0.3, -0.4),
    );
    Ok(scene)
}
