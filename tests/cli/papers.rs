//! `shadowgraph report --papers`: every entry is there with figures and pictures, and what must hold of them on any machine holds.

use std::collections::BTreeMap;
use std::fs;

use crate::program::Folder;
use crate::report::{assert_balanced, attributes};
use serde_json::Value;

const ENTRIES: [&str; 20] = [
    "000-table1",
    "000-fig2",
    "000-fig4",
    "000-fig6",
    "000-fig7",
    "001-fig8",
    "002-fig3",
    "002-overlap",
    "002-fig5",
    "002-fig6",
    "002-open-closed",
    "002-fig7",
    "002-fig12",
    "002-hard-planar",
    "002-single-multi",
    "002-highlight",
    "004-table1",
    "004-fig7",
    "004-fig8",
    "004-fig9",
];

#[test]
fn options_that_would_be_ignored_are_refused() {
    let folder = Folder::new();
    for ignored in [
        "yard.glb",
        "--full",
        "--parts scenes",
        "--plot main.svg",
        "--references kept",
        "--outside-files",
        "--memory 100",
    ] {
        let error = folder.refuses(2, &format!("report --papers -o out {ignored}"));
        assert!(error.contains("--papers") && error.contains("cannot be used with"), "{ignored}: {error}");
    }
    folder.write("file", b"a file, no folder");
    let error = folder.refuses(1, "report --papers -o file/papers --quick");
    assert!(error.contains("file/papers"), "{error}");
}

/// What was measured, by entry and key.
struct Found(BTreeMap<String, f64>);

impl Found {
    fn of(chapter: &Value) -> Self {
        let mut found = BTreeMap::new();
        for entry in chapter["entries"].as_array().unwrap() {
            for figure in entry["figures"].as_array().unwrap() {
                let key = format!("{} {}", entry["id"].as_str().unwrap(), figure["key"].as_str().unwrap());
                let ours = figure["ours"].as_f64().unwrap_or_else(|| panic!("{key} is no number"));
                assert!(found.insert(key.clone(), ours).is_none(), "{key} is there twice");
            }
        }
        Self(found)
    }

    #[track_caller]
    fn at(&self, key: &str) -> f64 {
        *self.0.get(key).unwrap_or_else(|| panic!("{key} is not there: {:?}", self.0.keys()))
    }

    #[track_caller]
    fn is(&self, key: &str, value: f64) {
        assert_eq!(self.at(key), value, "{key}");
    }

    /// Each is larger than the one after it.
    #[track_caller]
    fn falls(&self, keys: &[&str]) {
        for pair in keys.windows(2) {
            let [more, less] = [pair[0], pair[1]].map(|key| self.at(key));
            assert!(more > less, "{}: {more}, {}: {less}", pair[0], pair[1]);
        }
    }
}

#[test]
fn every_entry_is_there_and_what_must_hold_holds() {
    if shadowgraph_testing::renderer().is_none() {
        return;
    }
    let folder = Folder::new();
    let ran = folder.run("report --papers -o out --quick --size 96x54").ok();
    assert!(ran.stdout.starts_with("entry ") && ran.stdout.ends_with("out/papers.html\n"), "{}", ran.stdout);
    let chapter: Value = serde_json::from_slice(&fs::read(folder.path("out/papers.json")).unwrap()).unwrap();
    assert_eq!(chapter["failures"], Value::Array(vec![]));
    let page = fs::read_to_string(folder.path("out/papers.html")).unwrap();
    assert_balanced(&page);
    let ids = attributes(&page, "id");
    for link in [attributes(&page, "href"), attributes(&page, "src")].concat() {
        match link.strip_prefix('#') {
            Some(id) => assert!(ids.contains(&id), "#{id} is not there"),
            None => assert!(folder.path("out").join(link).is_file(), "{link} is not there"),
        }
    }
    let entries = chapter["entries"].as_array().unwrap();
    assert_eq!(entries.iter().map(|entry| &entry["id"]).collect::<Vec<_>>(), ENTRIES);
    for entry in entries {
        let id = entry["id"].as_str().unwrap();
        let list = |name: &str| entry[name].as_array().unwrap();
        assert!(ids.contains(&id) && !list("figures").is_empty() && !list("pictures").is_empty(), "{id}");
        assert!(entry["sentence"].as_str().unwrap().ends_with(['.', ')']), "{id}");
        for picture in list("pictures") {
            let file = picture["file"].as_str().unwrap();
            assert!(attributes(&page, "src").contains(&file), "{file} is not on the page");
            let picture = image::open(folder.path("out").join(file)).unwrap().to_rgb8();
            let first = picture.get_pixel(0, 0);
            assert!(picture.pixels().any(|pixel| pixel != first), "{file} shows nothing");
        }
        for plot in list("plots") {
            assert!(folder.path("out").join(plot["file"].as_str().unwrap()).is_file());
        }
    }
    let found = Found::of(&chapter);
    of_glass(&found);
    of_lights(&found);
    of_studio(&found);
    of_maps(&found);
}

/// Paper 000.
fn of_glass(found: &Found) {
    found.is("000-fig2 f0", 0.0);
    found.is("000-fig2 f1", 2.0);
    found.is("000-fig2 f2", 3.0);
    found.is("000-fig2 heaviest", 2.0);
    found.is("000-fig2 different", 0.0);
    found.falls(&["000-fig4 product16.rmse", "000-fig4 log16.rmse", "000-fig4 counts.rmse"]);
    found.falls(&["000-fig4 log16.max", "000-fig4 counts.max"]);
    assert!(found.at("000-fig4 log16.rmse") > 10.0 * found.at("000-fig4 counts.rmse"));
    assert!(found.at("000-fig4 counts.max") < 1e-3 && found.at("000-fig6 tones") > 4.0);
    found.is("000-fig6 outside", 0.0);
    // Partial shadows on glass are those on the nearest surface.
    assert!(found.at("000-fig7 partial.nearest") < 1e-3 && found.at("000-fig7 full.second") < 1e-3);
    assert!(found.at("000-fig7 partial.second") > 0.1 && found.at("000-fig7 none.nearest") > 0.1);
    assert!(found.at("000-table1 ball-and-cubes.none-log16.of-opaque") > 0.0);
}

/// Paper 001: the line is told with its error.
fn of_lights(found: &Found) {
    let error_ms = found.at("001-fig8 ms.slope-error");
    assert!(error_ms > 0.0 && found.at("001-fig8 ms.residual") > 0.0 && found.at("001-fig8 ms.slope") > 0.0);
    assert!((0.0..=1.0).contains(&found.at("001-fig8 ms.r-squared")));
    assert!((0.0..=1.0).contains(&found.at("001-fig8 fps.r-squared")));
}

/// Paper 002.
fn of_studio(found: &Found) {
    assert!(found.at("002-fig3 without.wrong") > 100.0 && found.at("002-fig3 without.leak") > 50.0);
    for right in ["002-fig3 with.wrong", "002-fig3 closed-without.wrong", "002-fig3 closed-with.wrong"] {
        found.is(right, 0.0);
    }
    for kind in ["open", "closed"] {
        for count in [128, 256] {
            found.is(&format!("002-overlap {kind}-{count}.wrong"), 0.0);
        }
    }
    found.falls(&["002-fig5 points-4", "002-fig5 points-16", "002-fig5 points-128", "002-fig5 points-256"]);
    found.falls(&["002-fig5 texels-64", "002-fig5 texels-256"]);
    found.is("002-fig5 overhang", 0.0);
    found.is("002-fig6 zpass.wrong", 0.0);
    found.is("002-fig6 zfail.wrong", 0.0);
    found.is("002-open-closed different", 0.0);
    found.is("002-open-closed open.wrong", 0.0);
    assert!(found.at("002-open-closed vertices") > 1.5);
    found.falls(&["002-fig7 wedge-0.4.rmse", "002-fig7 sampled-0.4.rmse"]);
    found.is("002-fig7 sampled-0.4.off-samples", 0.0);
    assert!(found.at("002-fig7 wider") > 2.0);
    // Too light where shadows cross, and as dark as that where they do not.
    found.falls(&["002-single-multi crossing.single", "002-single-multi crossing.multi"]);
    assert!((found.at("002-single-multi crossing.single") - 0.5).abs() < 0.01);
    assert!((found.at("002-single-multi once.single") - 0.5).abs() < 0.01);
    assert!(found.at("002-single-multi crossing.multi") < 0.1);
    // The highlight stays, darkened by what they darken by.
    assert!(found.at("002-highlight darkened-contrast") > 0.3);
    assert!(found.at("002-highlight right-contrast").abs() < 0.01);
    assert!((found.at("002-highlight darkened-share") - 0.3).abs() < 0.01);
}

/// Paper 004: on edges silhouettes beat maps of as many texels, and volumes are right.
fn of_maps(found: &Found) {
    for scene in ["vehicle", "castle"] {
        found.falls(&[
            &format!("004-table1 {scene}.map.edge-off"),
            &format!("004-table1 {scene}.silhouette.edge-off"),
        ]);
        found.is(&format!("004-table1 {scene}.volumes.wrong"), 0.0);
        assert!(found.at(&format!("004-table1 {scene}.overdraw")) > 4.0);
    }
    for place in
        ["004-fig7 crossing", "004-fig7 beside", "004-fig7 corner", "004-fig8 vehicle", "004-fig9 strike"]
    {
        found.falls(&[&format!("{place}.map.edge-off"), &format!("{place}.silhouette.edge-off")]);
    }
    assert!(found.at("004-fig7 beside.silhouette.wrong") > 0.0);
}
