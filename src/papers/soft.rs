//! Soft shadow volumes of paper 002: its Fig. 7, a light of two sizes, and its Fig. 12, a furnished room under soft and hard
//! shadows.

use shadowgraph_engine::render::Exposure;
use shadowgraph_engine::scene::{Content, Scene, ShadowNode};
use shadowgraph_measure::KnownReferences;
use shadowgraph_measure::report::{Entry, Figure, Table};
use shadowgraph_nodes::{Quality, ShadowVolumeHard, ShadowVolumeSoft};

use super::harness::{Bench, Made, PaperError, shadowed};
use super::open_casters::knot;
use crate::demo;

const QUALITIES: [(&str, Quality); 3] =
    [("wedge", Quality::Wedge), ("perReceiver", Quality::PerReceiver), ("sampled", Quality::Sampled)];

pub(super) fn fig_7(bench: &mut Bench<'_>) -> Made<Entry> {
    let knot = knot();
    let soft = |quality, radius_m| {
        shadowed(&knot, ShadowVolumeSoft { quality, radius_m, ..ShadowVolumeSoft::default() })
    };
    let radii_m = [0.1, 0.4];
    let mut scenes = vec![shadowed(&knot, ShadowVolumeHard::default())];
    let rows: Vec<(&str, Quality, f64)> = radii_m
        .iter()
        .flat_map(|radius_m| QUALITIES.map(|(name, quality)| (name, quality, *radius_m)))
        .collect();
    scenes.extend(rows.iter().map(|(_, quality, radius_m)| soft(*quality, *radius_m)));
    bench.tell("frames in turn");
    let rounds = bench.rounds(&scenes)?;
    let (mut figures, mut table) = (Vec::new(), Vec::new());
    let mut penumbra_px = Vec::new();
    for (row, (name, _, radius_m)) in rows.iter().enumerate() {
        bench.tell(&format!("{name}, {radius_m} m"));
        let mut references = KnownReferences::with_samples(bench.effort.light_samples);
        let off = bench.judge_soft(&scenes[row + 1], &mut references)?;
        let ratio = rounds.ratio(row + 1, 0);
        let cells = [rounds.ms(row + 1).median, ratio.median, off.penumbra_rmse];
        table.push([(*name).into(), (*radius_m).into()].into_iter().chain(cells.map(Into::into)).collect());
        let place = format!("{name}-{radius_m}");
        let (time, error) = (
            format!("{name}, {radius_m} m: frame, of hard's"),
            format!("{name}, {radius_m} m: RMSE in the penumbra"),
        );
        figures.push(Figure::spread(format!("{place}.of-hard"), time, ratio));
        figures.push(Figure::new(format!("{place}.rmse"), error, off.penumbra_rmse));
        if *name == "sampled" {
            let what = format!("{name}, {radius_m} m: pixels that are not what its 64 samples give");
            figures.push(Figure::new(format!("{place}.off-samples"), what, off.off_its_samples as f64));
            penumbra_px.push(off.penumbra_px as f64);
        }
    }
    figures.push(
        Figure::new(
            "wider",
            "pixels in the penumbra of the wide light, of the narrow one's",
            penumbra_px[1] / penumbra_px[0],
        )
        .beside_words("“the wider the penumbra”"),
    );
    let pictures = radii_m.map(|radius_m| {
        let caption = format!("64 samples of a lamp of {radius_m} m");
        let name = format!("002-fig7-{}", (radius_m * 10.0).round());
        bench.picture(&soft(Quality::Sampled, radius_m), Exposure::default(), (&name, caption))
    });
    Ok(Entry {
        sentence: "The larger the lamp, the wider the penumbra and the dearer the frame, as they found of wedges, which are the \
                   dearest and the furthest off of the three ways; samples are exactly what the same samples of the light give."
            .into(),
        figures,
        tables: vec![Table {
            caption: "The knot under a lamp of two sizes".into(),
            columns: vec!["quality", "radius, m", "ms", "of hard", "penumbra RMSE"],
            rows: table,
        }],
        pictures: pictures.into_iter().collect::<Made<_>>()?,
        ..Entry::default()
    })
}

pub(super) fn fig_12(bench: &mut Bench<'_>) -> Made<Entry> {
    let mut rows = vec![("hard", None)];
    rows.extend(QUALITIES.map(|(name, quality)| (name, Some(quality))));
    if bench.effort.ends_only {
        // The others are slow however small the picture; Fig. 7 has them all.
        rows.retain(|(name, _)| ["hard", "sampled"].contains(name));
    }
    let scenes = rows.iter().map(|(_, quality)| room(*quality)).collect::<Made<Vec<_>>>()?;
    bench.tell("frames in turn");
    // Frames of a minute would tell no more.
    let size_px = bench.effort.picture_px;
    let rounds = bench.rounds_at(&scenes, size_px)?;
    let mut references = KnownReferences::with_samples(bench.effort.light_samples / 4);
    let (mut table, mut figures, mut pictures) = (Vec::new(), Vec::new(), Vec::new());
    for (row, ((name, quality), scene)) in rows.iter().zip(&scenes).enumerate() {
        bench.tell(name);
        let ratio = rounds.ratio(row, 0);
        let off = match quality {
            Some(_) => Some(bench.judge_soft(scene, &mut references)?),
            None => None,
        };
        let rmse = off.map(|off| off.penumbra_rmse);
        table.push(vec![(*name).into(), rounds.ms(row).median.into(), ratio.median.into(), rmse.into()]);
        if let Some(off) = off {
            let what = format!("{name}: frame, of hard's");
            let figure = Figure::spread(format!("{name}.of-hard"), what, ratio);
            figures.push(figure.beside(60.0 / 4.0));
            let what = format!("{name}: RMSE in the penumbrae of five lights");
            figures.push(Figure::new(format!("{name}.rmse"), what, off.penumbra_rmse));
        }
        let picture = format!("002-fig12-{}", name.to_lowercase());
        pictures.push(bench.plain_picture(scene, Exposure::default(), (&picture, *name))?);
    }
    Ok(Entry {
        sentence: "Soft shadows of five lights in a furnished room take many times as long as hard ones, as theirs did (4 frames \
                   a second to 60)."
            .into(),
        figures,
        tables: vec![Table {
            caption: format!(
                "The room under five lights, {}×{} pixels; error beside whole lights, which of hard shadows is none",
                size_px[0], size_px[1]
            ),
            columns: vec!["shadows", "ms", "of hard", "penumbra RMSE"],
            rows: table,
        }],
        pictures,
        ..Entry::default()
    })
}

/// The room with soft shadows of this quality; `None` leaves the hard ones.
fn room(quality: Option<Quality>) -> Made<Scene> {
    let (_, _, mut scene) =
        demo::all().into_iter().find(|(stem, ..)| *stem == "room").ok_or(PaperError::Missing("the room"))?;
    let Some(quality) = quality else { return Ok(scene) };
    let shadows: Vec<_> = scene
        .nodes()
        .filter_map(|(_, node)| match node.content {
            Content::Shadow(key) => Some((key, node.name.clone())),
            _ => None,
        })
        .collect();
    for (key, name) in shadows {
        // A window's worth of sky, and bulbs; the sun is as wide as it is.
        let radius_m = if name == "daylight" { 0.3 } else { 0.05 };
        let soft = ShadowNode::from(ShadowVolumeSoft { quality, radius_m, ..ShadowVolumeSoft::default() });
        let node = scene.shadow_mut(key).ok_or(PaperError::Missing("a shadow node's content"))?;
        (node.technique, node.params) = (soft.technique, soft.params);
    }
    Ok(scene)
}
