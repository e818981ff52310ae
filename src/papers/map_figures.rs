//! Figures 7 to 9 of paper 004: what one point for each texel cannot say, a closeup, and curved objects with the map's points.

use glam::{DVec3, Vec3};
use shadowgraph_engine::geometry::shapes;
use shadowgraph_engine::render::Exposure;
use shadowgraph_engine::scene::{Camera, Light, Scene, ShadowNode};
use shadowgraph_measure::KnownReferences;
use shadowgraph_measure::report::{Entry, Figure};
use shadowgraph_nodes::{ShadowMap, ShadowVolumeHard, Show, SilhouetteMap};

use super::harness::{Bench, Made, shadowed};
use super::map_scenes::{strike_seen, vehicle_seen};
use super::maps::edge_off_px;
use super::models::{ModelError, add, floor, matt};

fn map(resolution: u32) -> ShadowNode {
    ShadowMap { resolution, pcf: 1, ..ShadowMap::default() }.into()
}

fn silhouette(resolution: u32, show: Show) -> ShadowNode {
    SilhouetteMap { resolution, show, ..SilhouetteMap::default() }.into()
}

/// The three ways to the same shadow.
fn three(resolution: u32) -> [(&'static str, ShadowNode); 3] {
    [
        ("map", map(resolution)),
        ("silhouette", silhouette(resolution, Show::Shadows)),
        ("volumes", ShadowVolumeHard::default().into()),
    ]
}

/// How wrong the three are, and how far their edges are off.
fn figures(bench: &mut Bench<'_>, name: &str, scene: &Scene, resolution: u32) -> Made<Vec<Figure>> {
    let mut references = KnownReferences::default();
    let mut figures = Vec::new();
    for (label, node) in three(resolution) {
        let error = bench.judge(&shadowed(scene, node), &mut references)?.errors.swap_remove(0);
        let key = |what: &str| format!("{name}.{label}.{what}");
        let wrong = Figure::new(
            key("wrong"),
            format!("{name}, {label}: wrong pixels, in any band"),
            error.wrong as f64,
        );
        let off = Figure::new(key("edge-off"), format!("{name}, {label}: edges off"), edge_off_px(&error));
        figures.extend([wrong, off.in_unit("px")]);
    }
    Ok(figures)
}

/// The texels of Fig. 7's maps: so few that each is seen.
const COARSE: u32 = 48;

type Shapes = fn(&mut Scene) -> Result<(), ModelError>;

pub(super) fn fig_7(bench: &mut Bench<'_>) -> Made<Entry> {
    let artefacts: [(&str, &str, Shapes); 3] = [
        ("crossing", "two outlines cross in a texel", crossing),
        ("beside", "two outlines pass a texel and do not touch", beside),
        ("corner", "a sharp corner between two samples of depth", corner),
    ];
    let mut entry = Entry {
        sentence: "Where two outlines pass one texel, or a corner is sharper than a texel, one point cannot say both: shadows \
                   bulge, close or lose their tips, within a texel of where they should be."
            .into(),
        ..Entry::default()
    };
    for (name, what, shapes) in artefacts {
        let scene = over_floor(shapes)?;
        let found = figures(bench, name, &scene, COARSE)?;
        let of_silhouettes = |figure: Figure| {
            if figure.key.contains("silhouette.wrong") { figure.beside_words("an artifact") } else { figure }
        };
        entry.figures.extend(found.into_iter().map(of_silhouettes));
        for (label, node) in three(COARSE).into_iter().skip(1) {
            let caption = if label == "volumes" {
                format!("{what}: as it is")
            } else {
                format!("{what}: {label} of 48 texels")
            };
            let picture = format!("004-fig7-{name}-{label}");
            entry.pictures.push(bench.picture(
                &shadowed(&scene, node),
                Exposure::default(),
                (&picture, caption),
            )?);
        }
    }
    Ok(entry)
}

/// Flat shapes high over a floor, the lamp above them, the eye above the shadow.
fn over_floor(shapes: Shapes) -> Result<Scene, ModelError> {
    let mut scene = Scene::new();
    floor(&mut scene, 3.0)?;
    shapes(&mut scene)?;
    scene.add_light(Light::directional("sun", 3.2), DVec3::new(0.9, 2.0, 0.35), DVec3::ZERO);
    scene.add_camera(
        Camera::perspective("main", 0.5),
        DVec3::new(-1.7, 1.9, 0.7),
        DVec3::new(-0.5, 0.0, -0.18),
    );
    Ok(scene)
}

/// A flat shape at a height of 1 m, in metres from the scene's middle.
fn flat(scene: &mut Scene, corners: [[f32; 2]; 4]) -> Result<(), ModelError> {
    let quad = shapes::quad(corners.map(|[x, z]| Vec3::new(x, 1.0, z))).named("shape");
    add(scene, quad, matt(Vec3::new(0.3, 0.5, 0.75)))?;
    Ok(())
}

fn crossing(scene: &mut Scene) -> Result<(), ModelError> {
    flat(scene, [[-0.45, 0.35], [-0.37, 0.43], [0.45, -0.35], [0.37, -0.43]])?;
    flat(scene, [[0.37, 0.43], [0.45, 0.35], [-0.37, -0.43], [-0.45, -0.35]])
}

fn beside(scene: &mut Scene) -> Result<(), ModelError> {
    flat(scene, [[-0.5, 0.4], [-0.02, 0.4], [0.03, -0.4], [-0.5, -0.4]])?;
    flat(scene, [[0.015, 0.4], [0.5, 0.4], [0.5, -0.4], [0.065, -0.4]])
}

fn corner(scene: &mut Scene) -> Result<(), ModelError> {
    flat(scene, [[-0.4, 0.12], [0.5, 0.01], [0.5, -0.01], [-0.4, -0.12]])
}

/// The texels of Fig. 8's maps.
const LOW: u32 = 128;

pub(super) fn fig_8(bench: &mut Bench<'_>) -> Made<Entry> {
    let scene = vehicle_seen([DVec3::new(3.5, 1.7, 1.3), DVec3::new(2.0, 0.0, -0.5)])?;
    let mut pictures = Vec::new();
    for (label, node) in three(LOW) {
        let caption = if label == "volumes" { label.into() } else { format!("{label} of 128 texels") };
        let picture = format!("004-fig8-{label}");
        pictures.push(bench.picture(&shadowed(&scene, node), Exposure::default(), (&picture, caption))?);
    }
    Ok(Entry {
        sentence: "At too few texels a map's edge is stairs; silhouettes are straight but for where thin parts lie within a texel; \
                   volumes are right."
            .into(),
        figures: figures(bench, "vehicle", &scene, LOW)?,
        pictures,
        ..Entry::default()
    })
}

/// The texels of Fig. 9's maps: half of theirs, so that points are seen apart.
const CURVED: u32 = 256;

pub(super) fn fig_9(bench: &mut Bench<'_>) -> Made<Entry> {
    let scene = strike_seen([DVec3::new(1.9, 1.2, 1.3), DVec3::new(0.45, 0.05, -0.3)])?;
    let mut pictures = Vec::new();
    for (name, caption, node) in [
        ("004-fig9-map", "a map of 256 texels", map(CURVED)),
        ("004-fig9-points", "its silhouette points, over the scene", silhouette(CURVED, Show::Points)),
        ("004-fig9-silhouette", "a silhouette map of 256 texels", silhouette(CURVED, Show::Shadows)),
    ] {
        pictures.push(bench.picture(&shadowed(&scene, node), Exposure::default(), (name, caption))?);
    }
    Ok(Entry {
        sentence: "On curved casters too points follow the outline, and edges are off by a part of what a map's are.".into(),
        figures: figures(bench, "strike", &scene, CURVED)?,
        pictures,
        ..Entry::default()
    })
}
