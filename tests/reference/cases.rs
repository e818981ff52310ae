//! The table of hard cases is complete, and every scene of it shows what it is about.
//!
//! A small tracer (see `soup`) checks that the camera sees every probe, that the probes' hand-made answers are right
//! (through glass and for lights with a size, too), and that frames which must show a shadow do.

use crate::soup::Soup;
use glam::DVec3;
use shadowgraph::cases::sweeps::{self, Axis};
use shadowgraph::cases::{self, Case, Expect};
use shadowgraph::measure::LightSize;
use shadowgraph_engine::scene::{CameraSnapshot, SceneSnapshot};

/// Every id of the documentation.
const IDS: &[&str] = &[
    "light-in-plane",
    "light-on-edge",
    "light-on-vertex",
    "light-in-closed",
    "light-in-open-box",
    "eye-in-shadow",
    "near-clips-side",
    "near-clips-corner",
    "eye-in-cap-plane",
    "light-in-near-plane",
    "light-behind-eye",
    "light-at-eye",
    "sliver",
    "zero-area",
    "duplicate-vertex",
    "duplicate-face",
    "opposite-duplicate",
    "t-junction",
    "fins",
    "two-cubes-one-edge",
    "inconsistent-winding",
    "moebius",
    "single-quad",
    "open-cylinder",
    "material-split",
    "uv-seam",
    "closed-inside-out",
    "closed-open-mixed",
    "casters-around-light",
    "alpha-mask",
    "terminator",
    "nested-shells",
    "coplanar-receiver",
    "touching-receiver",
    "offset-1e4",
    "offset-1e5",
    "offset-1e6",
    "scale-1e-4",
    "scale-1e4",
    "mirrored",
    "non-uniform",
    "sheared",
    "singular",
    "overlap-256",
    "overlap-512",
    "overlap-open-128",
    "overlap-2049",
    "overlap-4096",
    "overlap-seen-through",
    "count-figure",
    "directional-parallel",
    "low-sun",
    "directional-offscreen",
    "offscreen-caster",
    "light-crosses-frustum",
    "index-65536",
    "skinned-extreme",
    "morph",
    "instanced-1000",
    "animated",
    "alpha-0",
    "alpha-1",
    "channel-0",
    "glass-order",
    "glass-deep",
    "tinted-bottle",
    "stained-glass",
    "glass-self",
    "panes-intersecting",
    "opaque-behind-glass",
    "radius-0",
    "receiver-inside-light",
    "light-touches-caster",
    "caster-in-light",
    "edge-at-centre",
    "edge-through-centre",
    "penumbra-overlap",
    "tripod",
    "penumbra-width",
    "planar-behind",
    "planar-crossing",
    "planar-below",
    "planar-overhang",
    "planar-overlap",
    "map-acne",
    "map-peter-panning",
    "map-cube-seam",
    "map-grazing",
    "msaa",
    "lights-1",
    "lights-4",
    "lights-16",
    "lights-64",
    "sky",
    "ortho-camera",
    "resize",
    "1x1",
    "4096",
    "culled-underside",
    "two-sided-leaf",
    "back-to-back-panels",
    "glass-on-floor",
    "glass-on-box",
    "glass-on-glass",
    "coincident-panes",
    "wide-band",
    "room-through-culled-walls",
    "inward-shell",
    "soft-no-caster",
    "planar-no-caster",
    "turned-from-centre",
    "strip-500m",
    "strip-5km",
    "road-50km",
    "stretched-at-grazing",
    "cracked-2e-6",
    "thin-receiver",
    "lamp-1e-9-over-face",
    "lamp-1e-9-over-edge",
    "lamp-1e-9-over-vertex",
    "soft-lamp-on-edge",
    "soft-lamp-on-corner",
    "soft-lamp-in-floor",
    "lamp-in-far-plane",
    "ortho-lamp-beside",
    "folded-glass",
    "leaf-on-floor",
];

fn primary_ray(camera: &CameraSnapshot, size_px: [u32; 2], ndc: [f64; 2]) -> (DVec3, DVec3) {
    let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
    let (origin, direction) = camera.projection.view_ray(ndc[0], ndc[1], aspect);
    (camera.world_from_view.transform_point3(origin), camera.world_from_view.transform_vector3(direction))
}

/// Normalised device coordinates of a point; `None` before the near plane.
fn project(camera: &CameraSnapshot, size_px: [u32; 2], point: DVec3) -> Option<[f64; 2]> {
    let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
    let clip = camera.projection.clip_from_view(aspect)
        * camera.world_from_view.inverse().transform_point3(point).extend(1.0);
    (clip.w > 0.0 && clip.z <= clip.w).then(|| [clip.x / clip.w, clip.y / clip.w])
}

/// Dark and lit samples for each light over a coarse grid of the frame.
fn count_samples(case: &Case, snapshot: &SceneSnapshot, soup: &Soup) -> Vec<[usize; 2]> {
    let triangles: usize = soup.instances.iter().map(|(_, t)| t.len()).sum();
    let side = if triangles > 20_000 { 12 } else { 40 };
    let mut counts = vec![[0; 2]; snapshot.lights.len()];
    for i in 0..side * side {
        let to_ndc = |k: usize| (k as f64 + 0.5) / side as f64 * 2.0 - 1.0;
        let (origin, direction) =
            primary_ray(&case.camera, case.size_px, [to_ndc(i % side), to_ndc(i / side)]);
        let limits = [case.camera.projection.near_m(), case.camera.projection.far_m()];
        let Some((t, surface)) = soup.seen(origin, direction, limits) else {
            continue;
        };
        for (light, count) in snapshot.lights.iter().zip(&mut counts) {
            if let Some(factor) = soup.factor(light, origin + direction * t, surface, -direction) {
                count[usize::from(factor == [1.0; 3])] += 1;
            }
        }
    }
    counts
}

fn check(case: &Case) -> Vec<String> {
    let mut wrong = Vec::new();
    let snapshot = case.scene.snapshot().expect("every case poses");
    assert!(!snapshot.lights.is_empty(), "{}: no light", case.name());
    let tried = snapshot.shadow_nodes.iter().filter(|node| node.shadow.technique == "ShadowVolumeHard");
    assert_eq!(tried.count(), 1, "{}: one shadow node to be tried", case.name());
    assert_eq!(
        snapshot.shadow_nodes[0].shadow.technique,
        "ShadowVolumeHard",
        "{}: it is the first",
        case.name()
    );
    assert!(case.camera.projection.is_valid(), "{}", case.name());
    let frustum = case.camera.frustum(case.size_px);
    let seen = snapshot.instances.iter().any(|i| frustum.may_see(&i.world_bounds));
    assert!(seen || case.name() == "sky/empty", "{}: the camera sees nothing", case.name());

    let soup = Soup::new(&snapshot);
    for probe in &case.probes {
        let point = probe.p_in_world;
        let light = snapshot.lights.iter().find(|l| l.name == probe.light).expect("the probe's light exists");
        let Some(ndc) =
            project(&case.camera, case.size_px, point).filter(|n| n.iter().all(|c| c.abs() < 1.0))
        else {
            wrong.push(format!("{}: {point} is outside the frame", case.name()));
            continue;
        };
        let (origin, direction) = primary_ray(&case.camera, case.size_px, ndc);
        let hit = soup.seen(origin, direction, [case.camera.projection.near_m(), f64::INFINITY]);
        let distance = (point - origin).length();
        match hit {
            Some((t, surface)) if (origin + direction * t - point).length() < 1e-4 * distance => {
                let size = LightSize::of(&case.options);
                let factor =
                    soup.soft_factor(light, size, point, surface, -direction).unwrap_or([f64::NAN; 3]);
                // A disc is sampled.
                let within = if size == LightSize::NONE { 1e-4 } else { 0.02 };
                let expected = probe.factor.map(f64::from);
                if !(0..3).all(|channel| (factor[channel] - expected[channel]).abs() <= within) {
                    wrong.push(format!("{}: {point} is {factor:?}, not {expected:?}", case.name()));
                }
            }
            Some((t, _)) => {
                wrong.push(format!("{}: {point} hidden by {}", case.name(), origin + direction * t));
            }
            None => wrong.push(format!("{}: {point} is on no surface", case.name())),
        }
    }
    for (light, [dark, lit]) in snapshot.lights.iter().zip(count_samples(case, &snapshot, &soup)) {
        let fits = match case.expect {
            Expect::Shadow => dark > 0 && lit > 0,
            Expect::NoShadow => dark == 0,
            Expect::Matches | Expect::Refused { .. } => true,
        };
        if !fits {
            wrong.push(format!("{}: {} has {dark} dark and {lit} lit samples", case.name(), light.name));
        }
    }
    wrong
}

#[test]
fn the_table_lists_every_id_once() {
    let listed: Vec<_> = cases::all().iter().map(|entry| entry.id).collect();
    assert_eq!(listed, IDS);
    let unique: std::collections::HashSet<_> = listed.iter().collect();
    assert_eq!(unique.len(), IDS.len());
}

#[test]
fn every_row_says_what_it_is_about_and_builds() {
    for entry in cases::all() {
        assert!(!entry.what_breaks.is_empty() && !entry.right_answer.is_empty(), "{}", entry.id);
        assert!(!entry.build(&shadowgraph::CAST).is_empty(), "{}", entry.id);
    }
}

#[test]
fn variants_have_names_of_their_own() {
    let mut taken = std::collections::HashSet::new();
    for case in cases::all().iter().flat_map(|entry| entry.build(&shadowgraph::CAST)) {
        assert!(taken.insert(case.name()), "{} is there twice", case.name());
    }
}

#[test]
fn every_scene_shows_what_it_is_about() {
    let wrong: Vec<_> = cases::all()
        .iter()
        .flat_map(|entry| entry.build(&shadowgraph::CAST))
        .flat_map(|case| check(&case))
        .collect();
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn every_step_of_every_sweep_shows_what_it_is_about() {
    let sweeps = sweeps::all();
    let unique: std::collections::HashSet<_> = sweeps.iter().map(|sweep| sweep.id).collect();
    assert_eq!(unique.len(), sweeps.len());
    let mut wrong = Vec::new();
    for sweep in &sweeps {
        let steps = sweep.steps(&shadowgraph::CAST);
        let rising = steps.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let falling = steps.windows(2).all(|pair| pair[0].0 > pair[1].0);
        assert!(rising || falling, "{}: the steps are in no order", sweep.id);
        assert!(sweep.axis == Axis::Linear || steps.iter().all(|(value, _)| *value > 0.0), "{}", sweep.id);
        assert!(!sweep.parameter.is_empty() && !sweep.what_breaks.is_empty(), "{}", sweep.id);
        wrong.extend(steps.iter().flat_map(|(_, case)| check(case)));
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// How many of the near rectangle's corners lie in the shadow of the first light.
fn dark_near_corners(case: &Case) -> usize {
    let snapshot = case.scene.snapshot().expect("every case poses");
    let soup = Soup::new(&snapshot);
    let light = snapshot.lights[0].position.truncate();
    let corners = case.camera.frustum(case.size_px).near_corners;
    corners.iter().filter(|corner| soup.hit(**corner, light - **corner, [0.0, 1.0]).is_some()).count()
}

#[test]
fn near_rectangles_are_cut_where_their_cases_say() {
    for case in cases::all().iter().flat_map(|entry| entry.build(&shadowgraph::CAST)) {
        let expected = match (case.id, case.variant.as_str()) {
            ("near-clips-side", _) => 2..=2,
            ("near-clips-corner", variant) if !variant.ends_with("edge") => 1..=1,
            ("near-clips-corner", _) => 1..=3,
            ("eye-in-shadow", _) => 4..=4,
            _ => continue,
        };
        assert!(
            expected.contains(&dark_near_corners(&case)),
            "{}: {}",
            case.name(),
            dark_near_corners(&case)
        );
    }
}
