//! `shadowgraph report`: what it writes, what it says, and what it leaves when it cannot write.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use crate::own_technique::{DiscShadow, disc_mesh};
use crate::program::{Folder, names_all};
use serde_json::Value;
use shadowgraph::engine::scene::{ParamValue, Params};
use shadowgraph::engine::shadow::{Catalog, Setting, TechniqueEntry};
use shadowgraph::measure::ReferenceShadow;
use shadowgraph::measure::report::{self, Effort, Outcome, Parts, References, Report, ReportScene, Steps};
use shadowgraph::measure::timing::Pace;
use shadowgraph::prelude::*;
use shadowgraph_testing::{renderer, shadowed_yard};

const SCENES: Parts = Parts { scenes: true, scaling: false, motion: false, sweeps: false };
const PACE: Pace = Pace { min_rounds: 3, max_rounds: 3, budget: Duration::ZERO };
/// Everything, as little of it as can be.
const TINY: Effort = Effort {
    name: "tiny",
    size_px: [64, 48],
    soft_size_px: [48, 36],
    whole_light_samples: [256, 64],
    parts: SCENES,
    scene_pace: PACE,
    pass_frames: 2,
    axis_size_px: [32, 24],
    axis_pace: PACE,
    steps: Steps {
        triangles: &[200, 1_000],
        lights: &[1, 2, 3],
        casters: &[1, 4],
        sizes_px: &[[16, 16], [32, 32]],
    },
    sweep_stride: 1_000,
    sweep_shrink: 8,
    ..Effort::QUICK
};

/// A floor that casts nothing, a disc over it, and whatever else is to cast.
fn disc_scene(others: &[MeshData]) -> Result<(Scene, CameraSnapshot), String> {
    let mut scene = Scene::new();
    let floor = Mesh::new(shapes::plane(Vec2::splat(4.0)).named("floor")).unwrap();
    let floor = scene.add_mesh(floor, Material::default(), DAffine3::IDENTITY);
    if let Some(Content::Mesh(mesh)) = scene.node_mut(floor).map(|node| &mut node.content) {
        mesh.shadow.casts = false;
    }
    for data in [disc_mesh("plate", 0.9, 256)].iter().chain(others) {
        let mesh = Mesh::new(data.clone()).unwrap();
        scene.add_mesh(mesh, Material::default(), DAffine3::from_translation(DVec3::Y));
    }
    scene.add_light(Light::point("lamp", 40.0), DVec3::new(-1.0, 4.5, 1.5), DVec3::ZERO);
    let eye = Camera::perspective("eye", 0.8);
    Ok((scene, CameraSnapshot::looking(eye, DVec3::new(2.0, 3.0, 5.0), DVec3::ZERO)))
}

fn named(name: &str, scene: Result<(Scene, CameraSnapshot), String>) -> ReportScene {
    ReportScene { name: name.into(), shows: "a scene of the tests".into(), scene }
}

/// A report with the technique from outside beside the built-in ones; `None` without an adapter.
fn report_on(scenes: &[ReportScene], effort: &Effort) -> Option<Report> {
    let renderer = renderer()?;
    let catalog = crate::own_technique::catalog();
    let mut references = References::in_memory();
    Some(report::run(renderer.gpu(), &catalog, scenes, effort, &mut references, &|_, _, _| {}))
}

fn text(files: &[(PathBuf, Vec<u8>)], name: &str) -> String {
    let (_, bytes) = files.iter().find(|(path, _)| path == std::path::Path::new(name)).unwrap();
    String::from_utf8(bytes.clone()).unwrap()
}

#[test]
fn a_technique_from_outside_appears_with_its_settings() {
    let Some(report) = report_on(&[named("plate", disc_scene(&[]))], &TINY) else { return };
    assert_eq!(report.failures(), Vec::<String>::new());
    let settings: Vec<&str> =
        report.scenes[0].points.iter().filter(|p| p.short_name == "disc").map(|p| p.setting).collect();
    let mut wanted = vec!["default"];
    wanted.extend(DiscShadow::ENTRY.settings.iter().map(|setting| setting.name));
    assert_eq!(settings, wanted);
    for point in &report.scenes[0].points {
        let measurement = point.measurement().unwrap_or_else(|| panic!("{} was not measured", point.label()));
        assert!(
            measurement.shadowed_ms.median > 0.0 && measurement.gpu_bytes > 0 && !measurement.plan.is_empty()
        );
        assert!(measurement.totals.compared > 0 && !measurement.passes.is_empty());
        // A rim that fades is wrong for a point light, and the report must see it; hard volumes are exact.
        match point.short_name {
            "disc" if point.setting == "soft rim" => assert!(measurement.totals.rmse_outside_band > 0.0),
            "hard" => assert!(measurement.totals.is_exact && measurement.totals.rmse_outside_band == 0.0),
            _ => {}
        }
    }
    let none = report.scenes[0].none.as_ref().unwrap();
    assert!(none.leak > 0 && none.false_shadow == 0 && !none.is_exact, "no shadows leak: {none:?}");
    let files = report::files(&report);
    let page = text(&files, "index.html");
    names_all(&page, &["disc soft rim", "DiscShadow", "hard z-fail", "reference", "none"]);
    let rows: Vec<String> = text(&files, "report.csv").lines().map(String::from).collect();
    assert!(rows.iter().any(|row| row.starts_with("plate,DiscShadow,soft rim,edge=0.05,measured,,64,48,")));
}

/// The reference as a technique with a quality: exact for its samples, an approximation of the light.
const SOFT: TechniqueEntry = TechniqueEntry {
    settings: &[Setting {
        name: "soft",
        why: "a lamp of half a metre by few samples",
        params: || {
            let option = |name: &str, value: f64| (name.to_owned(), ParamValue::Number(value));
            Params::from([option("radius", 0.5), option("samples", 16.0)])
        },
    }],
    ..ReferenceShadow::ENTRY
};

#[test]
fn lights_with_a_size_are_judged_beside_the_whole_light_and_beside_their_samples() {
    let Some(renderer) = renderer() else { return };
    let mut catalog = Catalog::new();
    catalog.register(SOFT);
    let scenes = [named("plate", disc_scene(&[]))];
    let effort = Effort { parts: Parts { sweeps: true, ..SCENES }, ..TINY };
    let mut references = References::in_memory();
    let report = report::run(renderer.gpu(), &catalog, &scenes, &effort, &mut references, &|_, _, _| {});
    assert_eq!(report.failures(), Vec::<String>::new());
    let [hard, soft] = &report.scenes[0].points[..] else { panic!("two settings") };
    let [hard, soft] = [hard, soft].map(|point| point.measurement().unwrap());
    assert!(hard.totals.is_exact && hard.same_samples.is_none() && hard.judged_size_px == [64, 48]);
    assert_eq!((soft.same_samples, soft.judged_size_px), (Some((16, 0)), [48, 36]));
    let totals = &soft.totals;
    assert!(!totals.is_exact && totals.penumbra_pixels > 30, "{totals:?}");
    assert!(totals.penumbra_rmse > 0.005 && totals.penumbra_rmse < 0.06, "{totals:?}");
    assert!(totals.rmse_outside_band > 0.0 && totals.leak_mean > 0.0 && totals.false_mean > 0.0);
    // Every quality is tried where its own option is swept, and only the default elsewhere.
    let settings = |id: &str| {
        let sweep = report.sweeps.iter().find(|sweep| sweep.id == id).unwrap();
        sweep.techniques.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>()
    };
    assert_eq!(settings("light-radius"), ["reference", "reference soft"]);
    assert_eq!(settings("grazing-sun"), ["reference"]);
    let files = report::files(&report);
    names_all(&text(&files, "index.html"), &["off its samples", "the more the stronger", "48×36"]);
    assert!(text(&files, "plots/quality-light-radius.svg").contains("penumbra RMSE"));
    if let Some(folder) = std::env::var_os("DUMP") {
        for (path, bytes) in &files {
            let path = std::path::Path::new(&folder).join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        }
    }
}

#[test]
fn refusals_show_their_reason_and_failures_do_not_stop_the_rest() {
    let cuboid = shapes::cuboid(Vec3::splat(-0.2), Vec3::splat(0.2)).named("crate");
    let scenes = [
        named("gone", Err("'gone.glb' is not there".into())),
        named("boxed", disc_scene(&[cuboid])),
        named("<b>&\"x\"", disc_scene(&[])),
    ];
    let Some(report) = report_on(&scenes, &TINY) else { return };
    assert_eq!(report.failures(), ["scene 'gone': 'gone.glb' is not there"]);
    let refused = |short_name: &str| {
        let points = report.scenes[1].points.iter().filter(|p| p.short_name == short_name);
        points
            .filter_map(|p| match &p.outcome {
                Outcome::Refused(why) => Some(why.clone()),
                _ => None,
            })
            .collect::<Vec<_>>()
    };
    assert!(refused("disc").iter().all(|why| why.contains("crate")) && refused("disc").len() == 2);
    assert!(refused("hard").is_empty() && report.scenes[2].points.iter().all(|p| p.measurement().is_some()));
    let files = report::files(&report);
    let page = text(&files, "index.html");
    names_all(&page, &["refuses caster", "'crate'", "'gone.glb' is not there", "&lt;b&gt;&amp;"]);
    assert!(!page.contains("<b>&"), "a scene's name became markup");
    let csv = text(&files, "report.csv");
    assert!(csv.lines().any(|row| row.starts_with("gone,,,,failed,'gone.glb' is not there,")));
    assert!(csv.lines().any(|row| row.starts_with("boxed,DiscShadow,default,,refused,")));
    let json: Value = serde_json::from_str(&text(&files, "report.json")).unwrap();
    assert_eq!(json["scenes"][0]["status"], "failed");
    let points = json["scenes"][1]["points"].as_array().unwrap();
    assert!(
        points.iter().any(|p| p["status"] == "refused" && p["reason"].as_str().unwrap().contains("crate"))
    );
}

#[test]
fn cost_motion_and_sweeps_are_measured_for_every_technique() {
    let effort = Effort { parts: Parts { scenes: false, scaling: true, motion: true, sweeps: true }, ..TINY };
    let Some(report) = report_on(&[], &effort) else { return };
    let grows = report.axes.iter().map(|axis| axis.parameter);
    assert!(grows.eq(["triangles", "lights", "casters", "pixels"]));
    for axis in &report.axes {
        let of = |name: &str| &axis.techniques.iter().find(|(known, _)| known == name).unwrap().1;
        assert!(of("hard").iter().all(|step| step.outcome.measured().is_some()), "{}", axis.parameter);
        // Discs take neither knots nor boxes.
        assert!(of("disc").iter().all(|step| matches!(&step.outcome, Outcome::Refused(_))));
        assert_eq!(axis.unshadowed_ms.len(), of("hard").len());
    }
    let moves = report.motions.iter().map(|motion| motion.moves);
    assert!(moves.eq([["nothing", "the eye", "the lights", "a caster"]; 2].concat()));
    for motion in &report.motions {
        let of = |name: &str| &motion.techniques.iter().find(|(known, _)| known == name).unwrap().1;
        let hard = of("hard").measured().unwrap();
        assert!(hard.plan_ms.min > 0.0 && hard.plan_ms.min + hard.encode_ms.min < hard.wall_ms.max);
        assert!(matches!(of("disc"), Outcome::Refused(_)));
    }
    assert!(report.sweeps.len() > 10);
    for sweep in &report.sweeps {
        let (_, steps) = sweep.techniques.iter().find(|(name, _)| name == "hard").unwrap();
        // The first and the last step, whatever the stride.
        assert_eq!(steps.len(), 2, "{}", sweep.id);
        for step in steps {
            let totals =
                step.outcome.measured().unwrap_or_else(|| panic!("{}: {:?}", sweep.id, step.outcome));
            // Whether it is right is for tests/gpu/stability.rs.
            assert!(totals.compared > 0, "{} at {}", sweep.id, step.value);
        }
    }
    let files = report::files(&report);
    names_all(&text(&files, "index.html"), &["Cost against size", "exponent", "a caster", "offset-exact"]);
    assert!(files.iter().any(|(path, _)| path.ends_with("plots/cost-lights.svg")));
}

/// `attribute="value"` of every element of a page or plot.
pub(crate) fn attributes<'a>(markup: &'a str, attribute: &str) -> Vec<&'a str> {
    let start = format!(" {attribute}=\"");
    let values = markup.split(start.as_str()).skip(1);
    values.map(|rest| rest.split('"').next().unwrap_or_default()).collect()
}

/// Asserts that every element that is opened is closed, in order.
pub(crate) fn assert_balanced(markup: &str) {
    const VOID: [&str; 4] = ["meta", "img", "br", "!DOCTYPE"];
    let mut open: Vec<&str> = Vec::new();
    for tag in markup.split('<').skip(1) {
        let (tag, _) = tag.split_once('>').unwrap_or_else(|| panic!("no end: {tag:.60}"));
        let name = tag.trim_start_matches('/').split([' ', '/', '\n']).next().unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "closed out of order");
        } else if !tag.ends_with('/') && !VOID.contains(&name) {
            open.push(name);
        }
    }
    assert_eq!(open, Vec::<&str>::new());
}

#[test]
fn the_command_writes_one_page_with_everything_it_links() {
    if renderer().is_none() {
        return;
    }
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    let ran =
        folder.run("report yard.glb -o out/new --quick --size 64x48 --parts scenes --plot main.svg").ok();
    assert_eq!(ran.stdout, "out/new/index.html\n");
    assert!(ran.stderr.contains("adapter: "));
    let page = fs::read_to_string(folder.path("out/new/index.html")).unwrap();
    assert_balanced(&page);
    let links: Vec<&str> = [attributes(&page, "href"), attributes(&page, "src")].concat();
    for link in links.iter().filter(|link| !link.starts_with('#')) {
        assert!(folder.path("out/new").join(link).is_file(), "{link} is not there");
    }
    for link in links.iter().filter_map(|link| link.strip_prefix('#')) {
        assert!(attributes(&page, "id").contains(&link), "#{link} is not there");
    }
    for picture in attributes(&page, "src") {
        assert!(
            image::open(folder.path("out/new").join(picture)).is_ok_and(|p| p.width() == 64),
            "{picture}"
        );
    }
    // No network: no address but the name space that SVG files must bear.
    for name in ["index.html", "plots/speed-error.svg"] {
        let text = fs::read_to_string(folder.path("out/new").join(name)).unwrap();
        let text = text.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
        assert!(!text.contains("http:") && !text.contains("https:") && !text.contains("<script"), "{name}");
    }
    let main = fs::read(folder.path("main.svg")).unwrap();
    assert_eq!(main, fs::read(folder.path("out/new/plots/speed-error.svg")).unwrap());
    assert_balanced(std::str::from_utf8(&main).unwrap());
}

#[test]
fn csv_and_json_have_what_they_promise() {
    let Some(report) = report_on(&[named("plate", disc_scene(&[]))], &TINY) else { return };
    let files = report::files(&report);
    let csv = text(&files, "report.csv");
    let mut rows = csv.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    names_all(
        &head.join(" "),
        &[
            "scene",
            "technique",
            "setting",
            "unshadowed_median_ms",
            "shadowed_lower_quartile_ms",
            "ratio_median",
            "gpu_bytes",
            "leak_px",
            "false_px",
            "wrong_outside_band_px",
            "rmse",
            "signed_mean",
            "p99",
            "max",
            "boundary_distance_max_px",
            "penumbra_rmse",
        ],
    );
    let rows: Vec<BTreeMap<&str, &str>> = rows
        .filter(|row| row.len() == head.len())
        .map(|row| head.iter().copied().zip(row).collect())
        .collect();
    // Options with commas are quoted, so that splitting at commas finds only rows without: the defaults.
    assert!(rows.iter().any(|row| row["technique"] == "ShadowVolumeHard" && row["setting"] == "default"));
    for row in &rows {
        assert_eq!((row["scene"], row["status"], row["width_px"]), ("plate", "measured", "64"));
        for number in ["shadowed_median_ms", "ratio_median", "gpu_bytes", "compared_px"] {
            assert!(row[number].parse::<f64>().is_ok_and(|n| n > 0.0), "{number}: {}", row[number]);
        }
    }
    let json: Value = serde_json::from_str(&text(&files, "report.json")).unwrap();
    assert_eq!(json["adapter"], report.adapter.as_str());
    let point = &json["scenes"][0]["points"][0];
    for key in ["median_ms", "min_ms", "max_ms", "count"] {
        assert!(point["frames"][key].is_number(), "{key}");
    }
    assert!(point["frames"]["wall"]["median_ms"].is_number() && point["gpu_bytes"].is_u64());
    for key in ["name", "draws", "vertices"] {
        assert!(!point["passes"][0][key].is_null(), "{key}");
    }
    let light = &point["lights"][0];
    assert_eq!((&light["name"], &light["technique"]), (&"lamp".into(), &"ShadowVolumeHard".into()));
    assert!(light["error"]["rmse"].is_number() && point["plan"].as_str().unwrap().contains("frame 64x48"));
}

#[test]
fn a_failing_scene_is_listed_and_the_exit_code_tells() {
    if renderer().is_none() {
        return;
    }
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    folder.write("broken.glb", b"no glTF at all");
    let ran = folder.run("report broken.glb yard.glb missing.glb -o out --quick --size 64x48 --parts scenes");
    let page = fs::read_to_string(folder.path("out/index.html")).unwrap();
    names_all(&page, &["broken.glb", "missing.glb", "hard"]);
    let json: Value = serde_json::from_slice(&fs::read(folder.path("out/report.json")).unwrap()).unwrap();
    assert_eq!(json["failures"].as_array().unwrap().len(), 2);
    assert_eq!(json["scenes"][1]["status"], "measured");
    let error = ran.error(1);
    names_all(&error, &["2 things failed", "broken.glb", "report is written"]);
}

#[test]
fn what_cannot_be_written_leaves_nothing() {
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    folder.write("file", b"a file, no folder");
    let error = folder.refuses(1, "report yard.glb -o file/report --quick");
    assert!(error.contains("file/report"), "{error}");
    let error = folder.refuses(1, "report yard.glb -o /proc/nowhere --quick");
    assert!(error.contains("/proc/nowhere"), "{error}");
    // The report is not begun when the plot has no place: half an hour later would be too late.
    let error = folder.refuses(1, "report yard.glb -o out --quick --plot nowhere/main.svg");
    assert!(error.contains("nowhere/main.svg"), "{error}");
    folder.refuses(2, "report yard.glb -o out --quick --full");
    folder.refuses(2, "report yard.glb -o out --parts shapes");
    folder.refuses(2, "report yard.glb");
}

/// A folder on a disk of 64 KiB; `None` where this user may not mount one.
#[cfg(target_os = "linux")]
struct TinyDisk(PathBuf);

#[cfg(target_os = "linux")]
impl TinyDisk {
    fn at(path: PathBuf) -> Option<Self> {
        fs::create_dir_all(&path).unwrap();
        let arguments = ["-t", "tmpfs", "-o", "size=64k", "tmpfs"];
        let mounted = std::process::Command::new("mount").args(arguments).arg(&path).output();
        mounted.is_ok_and(|output| output.status.success()).then_some(Self(path))
    }
}

#[cfg(target_os = "linux")]
impl Drop for TinyDisk {
    fn drop(&mut self) {
        // A mount that stays is a nuisance, not a failure.
        let _ = std::process::Command::new("umount").arg(&self.0).status();
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_leaves_nothing() {
    if renderer().is_none() {
        return;
    }
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    let Some(disk) = TinyDisk::at(folder.path("disk")) else {
        shadowgraph_testing::skip("this user may not mount a small disk");
        return;
    };
    let error = folder.refuses(1, "report yard.glb -o disk/report --quick --size 320x180 --parts scenes");
    assert!(error.contains("cannot write 'disk/report/") && error.contains("pace"), "{error}");
    assert_eq!(fs::read_dir(&disk.0).unwrap().count(), 0, "the disk is as empty as before");
}

#[test]
fn references_are_kept_and_found_again() {
    let Some(renderer) = renderer() else { return };
    let folder = Folder::new();
    let kept = folder.path("kept");
    let run = || {
        let mut references = References::in_folder(&kept);
        let scenes = [named("plate", disc_scene(&[]))];
        // Hard shadows alone: lights with a size ask for references of their own.
        let mut catalog = Catalog::new();
        catalog.register(ShadowVolumeHard::ENTRY);
        let report = report::run(renderer.gpu(), &catalog, &scenes, &TINY, &mut references, &|_, _, _| {});
        assert_eq!(references.warning(), None);
        report.scenes[0].clone()
    };
    let first = run();
    let names = folder.names("kept");
    assert_eq!(names.len(), 1, "one reference serves every setting: {names:?}");
    let file = kept.join(&names[0]);
    let bytes = fs::read(&file).unwrap();
    let second = run();
    assert_eq!(first.reference_ms, second.reference_ms, "it was traced again");
    let totals = |scene: &report::SceneReport| scene.points[0].measurement().unwrap().totals.clone();
    assert_eq!(totals(&first), totals(&second));
    // A damaged file is traced anew and replaced.
    fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    assert_eq!(totals(&run()), totals(&first));
    assert_eq!(fs::read(&file).unwrap().len(), bytes.len());
}
