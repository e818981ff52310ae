//! Figures 2, 4 and 6 of paper 000: what is counted, what sums and products lose, and the inside that shows in the shadow.

use glam::{DQuat, DVec3, Vec2, Vec3};
use image::{Rgba, RgbaImage};
use shadowgraph_engine::geometry::{Chain, Mesh, MeshData, facing_signs, shapes};
use shadowgraph_engine::render::Exposure;
use shadowgraph_engine::scene::{Camera, Light, Material, Scene, placed};
use shadowgraph_measure::report::{Drawn, Entry, Figure, Plotted, PlottedLine, PlottedPoint, Table};
use shadowgraph_measure::{Evaluation, KnownReferences};
use shadowgraph_nodes::{Accumulate, SelfShadow, ShadowVolumeHard, TransparentShadow};

use super::harness::{Bench, Made, PaperError, camera, picture, pixel_of, shadowed};
use super::models::{ModelError, add, block, floor, glass, matt};

fn on_floor(accumulate: Accumulate) -> TransparentShadow {
    TransparentShadow { accumulate, self_shadow: SelfShadow::None }
}

/// What one surface of Fig. 2 lets pass: half, so that factors are powers of two.
const HALF: f32 = 0.5;

pub(super) fn counted(bench: &mut Bench<'_>) -> Made<Entry> {
    let (scene, soup) = balloon()?;
    let Evaluation { measured, reference, .. } =
        bench.judge(&shadowed(&scene, on_floor(Accumulate::Counts)), &mut KnownReferences::default())?;
    let size_px = measured.size_px;
    let ours: Vec<i32> = counts(&measured.lights[0].1);
    let exact = counts(&reference.lights[0].factor);
    let differs = |pixel: &usize| {
        let light = &reference.lights[0];
        light.compared[*pixel] && !light.ambiguous[*pixel] && ours[*pixel] != exact[*pixel]
    };
    let different = (0..ours.len()).filter(differs).count();
    let camera = camera(&scene)?;
    // Beside the balloon, under its far half, and under the half with a wall in it; then under the fin.
    let places = [("f0", 2.2, 0.0), ("f1", 0.5, 2.0), ("f2", -0.5, 3.0), ("fin", -1.4, 1.0)];
    let mut figures = Vec::new();
    for (key, x, theirs) in places {
        let pixel = pixel_of(&camera, size_px, DVec3::new(x, 0.0, 0.0));
        let count = pixel.map(|pixel| ours[pixel]).ok_or(PaperError::Missing("a place in the picture"))?;
        let figure =
            Figure::new(key, format!("surfaces between light and floor at x = {x} m"), f64::from(count));
        figures.push(if key == "fin" { figure } else { figure.beside(theirs) });
    }
    let chain = Chain::extract(
        soup.topology(),
        &facing_signs(
            &soup.positions().iter().map(|p| p.as_dvec3()).collect::<Vec<_>>(),
            soup.topology().triangles(),
            DVec3::Y.extend(0.0),
        ),
    );
    figures.extend([
        Figure::new("different", "pixels with another count than the tracer's", different as f64),
        Figure::new("edges", "edges of the soup", soup.topology().edges().len() as f64),
        Figure::new(
            "drawn-edges",
            "of which sides are drawn: those whose cap count is not 0",
            chain.silhouette_edges as f64,
        ),
        Figure::new(
            "heaviest",
            "largest cap count: three surfaces before an edge, one behind",
            f64::from(chain.max_edge_weight),
        )
        .beside(2.0),
    ]);
    Ok(Entry {
        sentence: "The sum of cap counts is the number of surfaces between a point and the light, at every pixel, of a soup in \
                   which four surfaces meet in one edge and others end. (A side counts the surfaces before it minus those behind, \
                   as in their example; their text says it the other way round.)"
            .into(),
        figures,
        pictures: vec![
            bench.picture(&shadowed(&scene, on_floor(Accumulate::Counts)), Exposure::Fixed(1.0), (
                "000-fig2",
                "a balloon with a wall inside and a fin outside, each surface letting half the light pass",
            ))?,
            picture("000-fig2-counts", "counts: white 0, then blue 1, green 2, orange 3, red more", &colored(
                size_px, &ours,
            ))?,
        ],
        ..Entry::default()
    })
}

/// How many surfaces leave such a factor.
fn counts(factor: &[f32]) -> Vec<i32> {
    let pixels = factor.chunks_exact(3).map(|rgb| rgb[0]);
    pixels.map(|red| if red > 0.0 { (-red.log2()).round() as i32 } else { -1 }).collect()
}

fn colored([width, height]: [u32; 2], counts: &[i32]) -> RgbaImage {
    RgbaImage::from_fn(width, height, |x, y| {
        Rgba(match counts[(y * width + x) as usize] {
            0 => [245, 245, 245, 255],
            1 => [86, 180, 233, 255],
            2 => [0, 158, 115, 255],
            3 => [230, 159, 0, 255],
            4.. => [213, 94, 0, 255],
            // Nothing is seen there, or it is turned away from the light.
            _ => [40, 40, 40, 255],
        })
    })
}

/// A balloon as their Fig. 2 has it, pulled along z: an outline of 16 sides, a wall from its left corner to its middle, and a
/// fin from that corner outwards: four surfaces share that edge, three of them on one side.
fn balloon() -> Made<(Scene, Mesh)> {
    let corner = |i: u32| {
        let angle = std::f32::consts::PI + i as f32 / 16.0 * std::f32::consts::TAU;
        Vec2::new(angle.cos() * 0.9, 1.3 + angle.sin() * 0.6)
    };
    let mut outline: Vec<Vec2> = (0..16).map(corner).collect();
    let (middle, tip) = (outline.len() as u32, outline.len() as u32 + 1);
    outline.extend([Vec2::new(0.0, 1.3), Vec2::new(-1.9, 1.3)]);
    let lines = (0..16).map(|i| [i, (i + 1) % 16]).chain([[0, middle], [0, tip]]);
    let positions = [-0.8, 0.8].into_iter().flat_map(|z| outline.iter().map(move |p| p.extend(z)));
    let back = outline.len() as u32;
    let data = MeshData {
        name: "balloon".into(),
        positions: positions.collect(),
        indices: lines.flat_map(|[a, b]| [a, b, back + b, a, back + b, back + a]).collect(),
        ..MeshData::default()
    };
    let soup = Mesh::new(data.clone()).map_err(|reason| ModelError { name: data.name.clone(), reason })?;
    let mut scene = Scene::new();
    floor(&mut scene, 6.0)?;
    add(&mut scene, data, glass(Vec3::ONE, 1.0 - HALF))?;
    scene.add_light(Light::directional("sun", 3.2), DVec3::Y, DVec3::ZERO);
    scene.add_camera(
        Camera::perspective("main", 0.75),
        DVec3::new(0.6, 3.0, 4.4),
        DVec3::new(0.0, 0.55, 0.0),
    );
    Ok((scene, soup))
}

/// The boxes over each other: each has two surfaces.
const BOXES: [u32; 6] = [1, 4, 16, 64, 128, 256];
const SUMS: [(&str, Accumulate); 4] = [
    ("product16", Accumulate::Product16),
    ("log16", Accumulate::Log16),
    ("gridLog", Accumulate::GridLog),
    ("counts", Accumulate::Counts),
];

pub(super) fn accumulated(bench: &mut Bench<'_>) -> Made<Entry> {
    let depths = bench.effort.of(&BOXES);
    let mut lines: Vec<PlottedLine> =
        SUMS.map(|(name, _)| PlottedLine { name: name.into(), ..PlottedLine::default() }).into();
    let (mut rows, mut figures, mut pictures) = (Vec::new(), Vec::new(), Vec::new());
    for &boxes in &depths {
        bench.tell(&format!("{boxes} boxes"));
        let scene = tower(boxes)?;
        let mut references = KnownReferences::default();
        let mut row = vec![f64::from(boxes * 2).into()];
        for ((name, accumulate), line) in SUMS.iter().zip(&mut lines) {
            let glassy = shadowed(&scene, on_floor(*accumulate));
            let error = bench.judge(&glassy, &mut references)?.errors.swap_remove(0);
            line.points.push(PlottedPoint { at: [f64::from(boxes * 2), error.rmse], quartiles: None });
            row.push(error.rmse.into());
            if Some(&boxes) != depths.last() {
                continue;
            }
            let surfaces = boxes * 2;
            let figure = Figure::new(
                format!("{name}.rmse"),
                format!("RMSE behind {surfaces} surfaces, {name}"),
                error.rmse,
            );
            figures.push(match *accumulate {
                Accumulate::Product16 => figure.beside_words("“severe artifact”"),
                Accumulate::Log16 => figure.beside_words("“rendered properly”"),
                _ => figure,
            });
            let worst = Figure::new(
                format!("{name}.max"),
                format!("largest error outside the band behind {surfaces} surfaces, {name}"),
                error.max_outside_band,
            );
            figures.push(worst);
            let caption = format!("{surfaces} surfaces, {name}");
            let name = format!("000-fig4-{}", name.to_lowercase());
            pictures.push(bench.picture(&glassy, Exposure::Fixed(1.0), (&name, caption))?);
        }
        rows.push(row);
    }
    Ok(Entry {
        sentence: "Products in half floats fail behind some dozen surfaces, as they found. They call sums of logarithms exact, but \
                   rounded numbers do not cancel there either: behind a deep stack these are wrong as well, where counts are \
                   not."
            .into(),
        figures,
        tables: vec![Table {
            caption: "RMSE of the factor against the surfaces that light passes".into(),
            columns: vec!["surfaces", "product16", "log16", "gridLog", "counts"],
            rows,
        }],
        plots: vec![Plotted {
            name: "000-fig4".into(),
            title: "Error against depth complexity".into(),
            axes: ["surfaces", "RMSE of the factor"],
            is_log: [true; 2],
            lines: lines.into_iter().map(|line| PlottedLine { drawn: Drawn::Joined, ..line }).collect(),
        }],
        pictures,
    ..Entry::default()
    })
}

/// So many thin boxes, turned against each other, under a sun that reaches the floor through them, as much through many as
/// through few.
fn tower(boxes: u32) -> Result<Scene, ModelError> {
    let mut scene = Scene::new();
    floor(&mut scene, 6.0)?;
    let pitch = 1.6 / boxes as f32;
    let one = |i: u32| {
        let turn = glam::DAffine3::from_rotation_y(f64::from(i) * 0.37);
        let slab = block([-0.7, 0.0, -0.7], [0.7, pitch * 0.5, 0.7]);
        slab.transformed(&turn).moved(Vec3::Y * (0.5 + i as f32 * pitch))
    };
    // A third of the light is left in red, more in green and blue.
    let passes = Vec3::new(0.33, 0.45, 0.6).map(|share| share.powf(0.5 / boxes as f32));
    let alpha = 1.0 - passes.max_element();
    let data = MeshData::merged("boxes", (0..boxes).map(one));
    add(&mut scene, data, glass(passes / passes.max_element(), alpha))?;
    scene.add_light(Light::directional("sun", 3.2), DVec3::new(-2.0, 3.0, 1.0), DVec3::ZERO);
    scene.add_camera(Camera::perspective("main", 0.8), DVec3::new(1.0, 4.0, 5.0), DVec3::new(0.5, 0.7, -0.2));
    Ok(scene)
}

pub(super) fn inside(bench: &mut Bench<'_>) -> Made<Entry> {
    let tinted = shadowed(&egg(glass)?, on_floor(Accumulate::Counts));
    let opaque = shadowed(&egg(|color, _| matt(color))?, ShadowVolumeHard::default());
    let Evaluation { reference, errors, .. } = bench.judge(&tinted, &mut KnownReferences::default())?;
    let light = &reference.lights[0];
    let mut tones: Vec<u32> = light
        .factor
        .chunks_exact(3)
        .zip(&light.compared)
        .filter(|(_, seen)| **seen)
        .map(|(rgb, _)| rgb.iter().fold(0, |tone, value| tone << 10 | (value * 1000.0).round() as u32))
        .collect();
    tones.sort_unstable();
    tones.dedup();
    let error = &errors[0];
    Ok(Entry {
        sentence: "Every surface tints what passes it, so the shadow shows the inside of the mesh; a conventional shadow of the \
                   same casters shows their outline only."
            .into(),
        figures: vec![
            Figure::new("tones", "different tones of the shadow on the floor, light included", tones.len() as f64),
            Figure::new("rmse", "RMSE of the factor on the floor", error.rmse),
            Figure::new("outside", "pixels outside the exact factor's bounds", error.outside_bounds as f64),
        ],
        pictures: vec![
            bench.picture(&tinted, Exposure::Fixed(1.0), ("000-fig6", "glass, and its shadow"))?,
            bench.picture(&opaque, Exposure::Fixed(1.0), (
                "000-fig6-opaque",
                "the same casters, opaque: two tones",
            ))?,
        ],
        ..Entry::default()
    })
}

/// An egg with two knots and a core in it, but for the core of what `glass` makes of a colour and an alpha.
fn egg(glass: fn(Vec3, f32) -> Material) -> Result<Scene, ModelError> {
    let mut scene = Scene::new();
    add(&mut scene, shapes::plane(Vec2::splat(14.0)).named("ground"), matt(Vec3::splat(0.8)))?;
    let turned = |turn: f64, data: MeshData| {
        let turn = DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(0.5);
        data.transformed(&placed(DVec3::Y * 1.75, turn, DVec3::ONE))
    };
    let egg = placed(DVec3::Y * 1.75, DQuat::IDENTITY, DVec3::new(1.0, 1.3, 1.0));
    let shell = shapes::icosphere(1.2, 5).transformed(&egg);
    add(&mut scene, shell, glass(Vec3::new(0.86, 0.95, 1.0), 0.08))?;
    let outer = turned(0.4, shapes::torus_knot([2, 3], 0.62, 0.1, [320, 20]));
    add(&mut scene, outer, glass(Vec3::new(1.0, 0.84, 0.62), 0.12))?;
    let inner = turned(-0.3, shapes::torus_knot([3, 4], 0.34, 0.06, [320, 16]));
    add(&mut scene, inner, glass(Vec3::new(0.68, 0.97, 0.8), 0.12))?;
    // Opaque casters of the node cast black, through the glass around them too.
    add(&mut scene, turned(0.0, shapes::icosphere(0.14, 4)), matt(Vec3::new(0.5, 0.1, 0.1)))?;
    scene.add_light(Light::directional("sun", 3.2), DVec3::new(-4.0, 4.2, 1.2), DVec3::ZERO);
    scene.add_camera(Camera::perspective("main", 0.55), DVec3::new(1.9, 4.6, 8.6), DVec3::new(1.3, 0.9, 0.0));
    Ok(scene)
}
