//! Paper 002 on shadows that are flattened onto planes: its Fig. 5, what their points are worth, and what they save beside hard
//! volumes.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::shapes;
use shadowgraph_engine::render::{Exposure, FrameRequest};
use shadowgraph_engine::scene::{
    AlphaMode, Camera, Image, Light, Material, NodeKey, Scene, ShadowNode, TextureRef,
};
use shadowgraph_measure::KnownReferences;
use shadowgraph_measure::report::{Drawn, Entry, Figure, Plotted, PlottedLine, PlottedPoint, Table};
use shadowgraph_nodes::{PlanarMode, ShadowVolumeHard, SoftShadow};

use super::harness::{Bench, Effort, Made, PaperError, shadowed};
use super::models::{ModelError, add, matt};

/// Half the floor's side, in metres, and the texels along a whole one.
const FLOOR_HALF_M: f32 = 4.0;
const TEXELS: u32 = 1024;

/// A knot over a floor, and the node over both that has `shadow`.
struct Stage {
    scene: Scene,
    floor: NodeKey,
    knot: NodeKey,
}

impl Stage {
    fn new(effort: &Effort) -> Result<Self, ModelError> {
        Self::seen(effort, [DVec3::new(3.2, 3.6, 6.2), DVec3::new(0.0, 0.9, 0.0)])
    }

    /// The same from an eye towards a target.
    fn seen(effort: &Effort, [eye, target]: [DVec3; 2]) -> Result<Self, ModelError> {
        let mut scene = Scene::new();
        let floor = super::models::floor(&mut scene, FLOOR_HALF_M)?;
        // Drawn directly, a caster is drawn once for every point.
        let segments = if effort.ends_only { [128, 12] } else { [271, 24] };
        let knot = shapes::torus_knot([2, 3], 0.8, 0.2, segments).moved(Vec3::Y * 1.3).named("knot");
        let knot = add(&mut scene, knot, matt(Vec3::new(0.8, 0.4, 0.2)))?;
        scene.add_lamp(Light::point("lamp", 160.0), DVec3::new(3.0, 6.5, 2.0));
        let camera = Camera::perspective("main", 45.0_f64.to_radians());
        scene.add_camera(camera, eye, target);
        Ok(Self { scene, floor, knot })
    }

    fn with(&self, shadow: SoftShadow) -> Scene {
        let node = ShadowNode::from(shadow).with_casters([self.knot]).with_receivers([self.floor]);
        shadowed(&self.scene, node)
    }
}

/// Points that stand for the light; with 128 and 256, where they put the limits of an eight-bit count.
const POINTS: [u32; 6] = [1, 4, 16, 64, 128, 256];
const TEXTURES: [u32; 3] = [64, 256, 1024];
const FEW_TEXTURES: [u32; 2] = [64, 256];

pub(super) fn fig_5(bench: &mut Bench<'_>) -> Made<Entry> {
    let stage = Stage::new(bench.effort)?;
    let soft = SoftShadow { radius_m: 0.35, samples: 256, ..SoftShadow::DIRECT };
    let mut references = KnownReferences::with_samples(bench.effort.light_samples);
    let (mut rows, mut line, mut figures) = (Vec::new(), PlottedLine::default(), Vec::new());
    for samples in if bench.effort.ends_only { vec![4, 16, 128, 256] } else { POINTS.to_vec() } {
        bench.tell(&format!("{samples} points"));
        let off = bench.judge_soft(&stage.with(SoftShadow { samples, ..soft }), &mut references)?;
        line.points.push(PlottedPoint { at: [f64::from(samples), off.penumbra_rmse], quartiles: None });
        rows.push(vec![format!("{samples} points, direct").into(), off.penumbra_rmse.into()]);
        figures.push(Figure::new(
            format!("points-{samples}"),
            format!("{samples} points: RMSE in the penumbra, beside the whole light"),
            off.penumbra_rmse,
        ));
    }
    line.name = "direct".into();
    let textures: &[u32] = if bench.effort.ends_only { &FEW_TEXTURES } else { &TEXTURES };
    for &resolution in textures {
        let texture = SoftShadow { mode: PlanarMode::Texture, resolution, samples: 64, ..soft };
        let off = bench.judge_soft(&stage.with(texture), &mut references)?;
        rows.push(vec![
            format!("64 points, texture of {resolution} texels").into(),
            off.penumbra_rmse.into(),
        ]);
        figures.push(Figure::new(
            format!("texels-{resolution}"),
            format!("texture of {resolution} texels: RMSE in the penumbra"),
            off.penumbra_rmse,
        ));
    }
    let over = changed_off_the_board(bench)?;
    figures.push(
        Figure::new("overhang", "pixels beside a receiver smaller than the shadow that change", over as f64)
            .beside_words("“may extend over the edges”"),
    );
    let few = SoftShadow { samples: 4, ..soft };
    let jagged = SoftShadow { mode: PlanarMode::Texture, resolution: 64, samples: 64, ..soft };
    let near = Stage::seen(bench.effort, [DVec3::new(0.4, 1.5, 1.9), DVec3::new(-0.8, 0.0, -0.6)])?;
    Ok(Entry {
        sentence: "More points make a smoother penumbra; drawn into a texture, edges are as coarse as its texels, as they say. Here \
                   no shadow reaches beyond its receiver, as theirs may."
            .into(),
        figures,
        tables: vec![Table {
            caption: "Error in the penumbra of a lamp of 0.35 m, beside the whole light".into(),
            columns: vec!["how", "RMSE"],
            rows,
        }],
        plots: vec![Plotted {
            name: "002-fig5".into(),
            title: "Error in the penumbra against points".into(),
            axes: ["points", "RMSE"],
            is_log: [true; 2],
            lines: vec![PlottedLine { drawn: Drawn::Joined, ..line }],
        }],
        pictures: vec![
            bench.picture(&near.with(soft), Exposure::default(), ("002-fig5", "256 points, direct"))?,
            bench.picture(&near.with(few), Exposure::default(), ("002-fig5-few", "4 points: steps"))?,
            bench.picture(&near.with(jagged), Exposure::default(), ("002-fig5-texels", "a texture of 64 texels, from near"))?,
        ],
        ..Entry::default()
    })
}

/// Pixels of other surfaces that change by a shadow on a board that is smaller than it.
fn changed_off_the_board(bench: &mut Bench<'_>) -> Made<usize> {
    let mut stage = Stage::new(bench.effort)?;
    let board = shapes::plane(Vec2::splat(0.5)).moved(Vec3::new(-0.4, 0.2, -0.3)).named("board");
    let board = add(&mut stage.scene, board, matt(Vec3::new(0.5, 0.6, 0.7)))?;
    let soft = SoftShadow { radius_m: 0.35, samples: 64, ..SoftShadow::DIRECT };
    let node = ShadowNode::from(soft).with_casters([stage.knot]).with_receivers([board]);
    let ask = |request: &mut FrameRequest| request.factors = true;
    let with = bench.frame(&shadowed(&stage.scene, node), ask)?;
    let without = bench.frame(&stage.scene, |_| {})?;
    let missing = PaperError::Missing("a frame's picture");
    let (Some(with_px), Some(without_px), Some(seen)) =
        (with.picture, without.picture, with.visible_triangles)
    else {
        return Err(missing);
    };
    // Floor and knot come first: the board is instance 2.
    let pixels = with_px.bytes.chunks_exact(4).zip(without_px.bytes.chunks_exact(4)).zip(seen);
    let changed = pixels.filter(|((a, b), _)| a != b).map(|(_, id)| id[0]);
    let (on, off): (Vec<u32>, Vec<u32>) = changed.partition(|instance| *instance == 2);
    if on.is_empty() {
        return Err(PaperError::Missing("a shadow on the board"));
    }
    Ok(off.len())
}

pub(super) fn hard_against_planar(bench: &mut Bench<'_>) -> Made<Entry> {
    let stage = Stage::new(bench.effort)?;
    let planar = |mode, samples, radius_m| {
        let resolution = if mode == PlanarMode::Texture { TEXELS } else { SoftShadow::default().resolution };
        stage.with(SoftShadow { mode, samples, radius_m, resolution, ..SoftShadow::default() })
    };
    let (many, points) = match bench.effort.ends_only {
        true => ("planar, 32 points, texture, nothing moves", 32),
        false => ("planar, 256 points, texture, nothing moves", 256),
    };
    let mut rectangle = stage.scene.clone();
    add_rectangle(&mut rectangle)?;
    let volumes = ShadowNode::from(ShadowVolumeHard::default()).with_casters([stage.knot]);
    let rows = [
        ("no shadows", "none", stage.scene.clone()),
        ("hard volumes", "volumes", shadowed(&stage.scene, volumes)),
        ("planar, hard, direct", "direct", planar(PlanarMode::Direct, 16, 0.0)),
        ("planar, hard, texture, nothing moves", "texture", planar(PlanarMode::Texture, 16, 0.0)),
        ("planar, 16 points, direct", "direct-16", planar(PlanarMode::Direct, 16, 0.1)),
        ("planar, 64 points, direct", "direct-64", planar(PlanarMode::Direct, 64, 0.1)),
        (many, "texture-many", planar(PlanarMode::Texture, points, 0.1)),
        ("a textured rectangle, no shadow", "rectangle", rectangle),
    ];
    let scenes: Vec<Scene> = rows.iter().map(|(_, _, scene)| scene.clone()).collect();
    let rounds = bench.rounds(&scenes)?;
    let mut references = KnownReferences::default();
    let (mut table, mut figures) = (Vec::new(), Vec::new());
    for (row, (what, key, scene)) in rows.iter().enumerate() {
        let adds = rounds.adds(row, 0);
        // Hard ones, of which volumes shade the knot as well.
        let wrong = if [1, 2, 3].contains(&row) {
            let error = bench.judge(scene, &mut references)?.errors.swap_remove(0);
            Some(error.wrong_outside_band as f64)
        } else {
            None
        };
        table.push(vec![(*what).into(), rounds.ms(row).median.into(), adds.median.into(), wrong.into()]);
        if row > 0 {
            let what = format!("{what}: adds to a frame");
            figures.push(Figure::spread(format!("{key}.adds"), what, adds).in_unit("ms"));
        }
    }
    let ratio =
        Figure::spread("volumes.of-direct", "hard volumes: frame, of hard planar direct", rounds.ratio(1, 2));
    figures.push(ratio.beside_words("“significantly higher”"));
    let ratio =
        Figure::spread("volumes.of-texture", "hard volumes: frame, of a kept texture's", rounds.ratio(1, 3));
    figures.push(ratio.beside_words("“very fast”"));
    Ok(Entry {
        sentence: "Flattened casters shade the planes that are named and nothing else; volumes shade everything, the caster too. \
                   What stays in a texture while nothing moves costs a look-up, however many points it took."
            .into(),
        figures,
        tables: vec![Table {
            caption: format!("{} rounds; pixels wrong outside the band of hard ones", rounds.count()),
            columns: vec!["what", "ms", "adds ms", "wrong"],
            rows: table,
        }],
        pictures: vec![
            bench.picture(&scenes[1], Exposure::default(), ("002-hard", "hard volumes: on the knot as well"))?,
            bench.picture(&scenes[2], Exposure::default(), ("002-planar", "hard planar: on the floor only"))?,
        ],
        ..Entry::default()
    })
}

/// A rectangle where the floor's texture would be, with as many texels.
fn add_rectangle(scene: &mut Scene) -> Result<(), ModelError> {
    let spots = (0..TEXELS * TEXELS).flat_map(|i| [0, 0, 0, ((i / 64 + i / TEXELS / 64) % 2 * 128) as u8]);
    let spots = Image { name: "spots".into(), width: TEXELS, height: TEXELS, rgba8: spots.collect() };
    let image = scene.add_image(Arc::new(spots));
    let material = Material {
        base_color_texture: Some(TextureRef::new(image)),
        alpha_mode: AlphaMode::Blend,
        unlit: true,
        ..Material::default()
    };
    let quad = shapes::plane(Vec2::splat(FLOOR_HALF_M)).moved(Vec3::Y * 0.001).named("rectangle");
    add(scene, quad, material)?;
    Ok(())
}
