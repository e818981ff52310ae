//! Fig. 7 of paper 000: letters in a glass box, whose shadow falls on the box as well, and what partial shadows on glass leave
//! out.

use glam::{DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::shapes;
use shadowgraph_engine::render::{Exposure, FrameRequest, RenderOptions};
use shadowgraph_engine::scene::{Camera, Light, Scene};
use shadowgraph_measure::report::{Entry, Figure, Table};
use shadowgraph_measure::{LayerEvaluation, Measured, compare, evaluate_layers, layer_measured};
use shadowgraph_nodes::{SelfShadow, TransparentShadow};

use super::harness::{Bench, Made, PaperError, camera, shadowed};
use super::models::{ModelError, add, block, glass, matt};

/// The nearest layers of glass that Fig. 7 judges.
const LAYERS: u32 = 4;

pub(super) fn fig_7(bench: &mut Bench<'_>) -> Made<Entry> {
    let scene = letters_in_glass()?;
    let with =
        |self_shadow| shadowed(&scene, TransparentShadow { self_shadow, ..TransparentShadow::default() });
    let request = FrameRequest::new(camera(&scene)?, bench.effort.picture_px);
    bench.tell("layers of glass");
    let full =
        evaluate_layers(&mut bench.renderer, &with(SelfShadow::Full), &request, 0..LAYERS, &|_, _| {})?;
    let (mut figures, mut rows) = (Vec::new(), Vec::new());
    let columns = [SelfShadow::None, SelfShadow::Partial, SelfShadow::Full]
        .into_iter()
        .map(|shadows| off_on_layers(bench, &with(shadows), &request, &full))
        .collect::<Made<Vec<_>>>()?;
    for layer in 0..full.len() {
        let cells = columns.iter().map(|column| column[layer].into());
        rows.push([(layer as f64 + 1.0).into()].into_iter().chain(cells).collect());
    }
    for ((name, column), theirs) in
        [("none", 0), ("partial", 1), ("full", 2)].into_iter().zip([None, Some("“partially correct”"), None])
    {
        for (layer, place) in [(0, "nearest"), (1, "second")] {
            let off = columns[column].get(layer).copied().ok_or(PaperError::Missing("a layer of glass"))?;
            let figure = Figure::new(
                format!("{name}.{place}"),
                format!("RMSE of the factor on the {place} glass surface, shadows on glass {name}"),
                off,
            );
            figures.push(theirs.into_iter().fold(figure, Figure::beside_words));
        }
    }
    let mut pictures = Vec::new();
    for (name, shadows, what) in [
        ("000-fig7-partial", SelfShadow::Partial, "partial: on the nearest glass only, as in the paper"),
        ("000-fig7-full", SelfShadow::Full, "full: on every layer of the glass"),
        ("000-fig7-none", SelfShadow::None, "none: on opaque surfaces only"),
    ] {
        pictures.push(bench.picture(&with(shadows), Exposure::Fixed(1.0), (name, what))?);
    }
    Ok(Entry {
        sentence: "Partial shadows on glass are right on the nearest surface and absent behind it; full ones are right on every \
                   layer."
            .into(),
        figures,
        tables: vec![Table {
            caption: "RMSE of the factor on each glass surface from the eye".into(),
            columns: vec!["layer", "none", "partial", "full"],
            rows,
        }],
        pictures,
        ..Entry::default()
    })
}

/// The RMSE of all lights' factors on each layer, beside what is right there.
fn off_on_layers(
    bench: &mut Bench<'_>,
    scene: &Scene,
    request: &FrameRequest,
    right: &[LayerEvaluation],
) -> Made<Vec<f64>> {
    let request = FrameRequest { factors: true, layer_factors: 0..right.len() as u32, ..request.clone() };
    let frame = bench.renderer.render(scene, &request, &RenderOptions::default())?;
    let mut off = Vec::new();
    for (index, right) in right.iter().enumerate() {
        let mut measured = match frame.layers.get(index) {
            Some(layer) => layer_measured(layer, request.size_px)?,
            None => Measured { lights: vec![], ..right.measured.clone() },
        };
        // Where nothing casts onto glass its light is whole.
        for (name, factor) in &right.measured.lights {
            if !measured.lights.iter().any(|(known, _)| known == name) {
                measured.lights.push((name.clone(), vec![1.0; factor.len()]));
            }
        }
        let errors = compare(&measured, &right.reference)?;
        let squares: f64 = errors.iter().map(|error| error.rmse.powi(2) * error.compared as f64).sum();
        let compared: usize = errors.iter().map(|error| error.compared).sum();
        off.push((squares / compared.max(1) as f64).sqrt());
    }
    Ok(off)
}

/// The outline of a letter in a box of width 1 and height 1.5, counter-clockwise.
fn outline(letter: char) -> Vec<Vec2> {
    let points: &[[f32; 2]] = match letter {
        'T' => &[
            [0.38, 0.0],
            [0.62, 0.0],
            [0.62, 1.26],
            [1.0, 1.26],
            [1.0, 1.5],
            [0.0, 1.5],
            [0.0, 1.26],
            [0.38, 1.26],
        ],
        'I' => &[[0.38, 0.0], [0.62, 0.0], [0.62, 1.5], [0.38, 1.5]],
        _ => &[
            [0.0, 0.0],
            [0.24, 0.0],
            [0.24, 1.02],
            [0.76, 0.0],
            [1.0, 0.0],
            [1.0, 1.5],
            [0.76, 1.5],
            [0.76, 0.48],
            [0.24, 1.5],
            [0.0, 1.5],
        ],
    };
    points.iter().map(|p| Vec2::from(*p)).collect()
}

/// The letters of TINT in a glass box under two lamps.
fn letters_in_glass() -> Result<Scene, ModelError> {
    let mut scene = Scene::new();
    add(&mut scene, shapes::plane(Vec2::splat(14.0)).named("ground"), matt(Vec3::splat(0.8)))?;
    let tints = [
        Vec3::new(1.0, 0.3, 0.2),
        Vec3::new(1.0, 0.85, 0.2),
        Vec3::new(0.3, 0.85, 0.35),
        Vec3::new(0.3, 0.5, 1.0),
    ];
    for ((letter, tint), i) in "TINT".chars().zip(tints).zip(0..) {
        let prism = shapes::extruded(&outline(letter), -0.15, 0.15).named(&letter.to_string());
        let left = -2.35 + 1.2 * i as f32;
        add(&mut scene, prism.moved(Vec3::new(left, 0.35, 0.0)), glass(tint, 0.25))?;
    }
    let case = block([-2.7, 0.02, -0.6], [2.7, 2.2, 0.6]).named("case");
    add(&mut scene, case, glass(Vec3::new(0.85, 0.95, 1.0), 0.08))?;
    scene.add_lamp(Light::point("left lamp", 120.0), DVec3::new(-3.2, 5.2, -3.4));
    scene.add_lamp(Light::point("right lamp", 80.0), DVec3::new(4.4, 4.8, -3.0));
    scene.add_camera(Camera::perspective("main", 0.6), DVec3::new(0.6, 4.6, 8.8), DVec3::new(0.1, 0.5, 0.9));
    Ok(scene)
}
