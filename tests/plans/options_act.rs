//! Every option of every technique acts or is refused, beside every value of every other option; no GPU.

use shadowgraph::measure::ReferenceShadow;
use shadowgraph::prelude::*;
use shadowgraph_engine::plan::FramePlan;
use shadowgraph_engine::render::Adapter;
use shadowgraph_engine::scene::{AlphaMode, ParamValue, Params};
use shadowgraph_engine::shadow::{Accepts, Cache, OptionSpec, Options, TechniqueEntry};
use shadowgraph_testing::*;

/// Values that are what the default chooses, on every scene as yet.
const SAME_AS_DEFAULT: &[(&str, &str)] = &[("counter", "stencil8"), ("faces", "both")];

/// Values that demand what the default takes where it can, and are refused where it cannot: they act by that refusal, for
/// which another option may leave no room.
const DEMANDING: &[(&str, &str)] = &[("extrusion", "toBounds"), ("geometry", "closed")];

/// What numbers are tried at; none of them is a default.
fn numbers(option: &str) -> &'static [f64] {
    match option {
        "radius" | "angle" => &[0.0, 0.5],
        "samples" => &[32.0],
        "resolution" => &[512.0],
        "weight" => &[0.25],
        "pcf" => &[1.0, 4.0],
        "cascades" => &[3.0],
        "constantBias" | "slopeBias" | "normalBias" => &[0.5],
        _ => panic!("say at which value '{option}' is to be tried"),
    }
}

/// An option and its value.
type Given = (String, ParamValue);

fn choices(entry: &TechniqueEntry) -> Vec<Given> {
    let values = |option: &OptionSpec| match &option.accepts {
        Accepts::Words(words) => words.iter().map(|word| ParamValue::Text(word.name.clone())).collect(),
        Accepts::Number { .. } => numbers(&option.name).iter().copied().map(ParamValue::Number).collect(),
        Accepts::Numbers { .. } => vec![ParamValue::Numbers(vec![0.2, 0.1, 0.3])],
        Accepts::Flag => [false, true].map(ParamValue::Flag).to_vec(),
    };
    let pairs =
        |option: OptionSpec| values(&option).into_iter().map(move |value| (option.name.clone(), value));
    (entry.options)().options.into_iter().flat_map(pairs).collect()
}

/// Scenes on which some value of every option makes a difference: lamp and sun; open, closed, masked and transparent
/// casters; eyes in shadow and outside.
fn witnesses() -> Vec<(Scene, FrameRequest, Cache)> {
    let mut scene = yard();
    let solids = scene.clone();
    scene.add_mesh(quad("sheet", 1.0), Material::default(), DAffine3::from_translation(DVec3::Y * 3.0));
    let glass = Material {
        alpha_mode: AlphaMode::Blend,
        base_color: [0.9, 0.5, 0.5, 0.5].into(),
        ..Material::default()
    };
    for (name, x) in [("pane", 2.0), ("other pane", 2.2)] {
        scene.add_mesh(quad(name, 0.5), glass.clone(), at(x, 1.0, 0.0));
    }
    let by_sun = |scene: &Scene| {
        let mut scene = scene.clone();
        let lamp = scene.find("lamp").unwrap();
        scene.remove(lamp).unwrap();
        scene.add_light(Light::directional("sun", 3.0), DVec3::ZERO, DVec3::new(0.2, -1.0, 0.1));
        scene
    };
    let mut masked = yard();
    let leaves = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..Material::default() };
    masked.add_mesh(quad("leaves", 0.5), leaves, at(-2.0, 1.0, 0.0));
    // No plane lies between a lamp and what is all around it.
    let mut room = yard();
    room.add_mesh(cuboid("room", Vec3::splat(9.0)), Material::default(), DAffine3::IDENTITY);
    let scenes = [by_sun(&solids), by_sun(&scene), solids, scene, masked, room];
    let views = [request(), request_in_shadow()];
    scenes
        .iter()
        .flat_map(|scene| views.iter().map(|view| (scene.clone(), view.clone(), Cache::new())))
        .collect()
}

/// What a technique does with these options: what is drawn into what, without a word of why.
fn plans(
    entry: &TechniqueEntry,
    params: &Params,
    witnesses: &mut [(Scene, FrameRequest, Cache)],
) -> Vec<Result<FramePlan, String>> {
    let plan = |(scene, request, cache): &mut (Scene, FrameRequest, Cache)| {
        let mut scene = scene.clone();
        let mut node = ShadowNode { params: params.clone(), ..ShadowNode::new(entry.type_name) };
        let made = (entry.from_params)(params).unwrap();
        node.receivers = shadowgraph_engine::shadow::receivers_for(&scene.snapshot().unwrap(), made.as_ref());
        scene.add_shadow("shadows", node);
        let catalog = shadowgraph_nodes::catalog();
        let plan = try_plan_with(&scene, request, &catalog, &Adapter::imagined(), cache);
        plan.map(without_words).map_err(|error| error.to_string())
    };
    witnesses.iter_mut().map(plan).collect()
}

fn without_words(mut plan: FramePlan) -> FramePlan {
    plan.notes.clear();
    plan.passes.iter_mut().for_each(|pass| pass.reason.clear());
    plan.lights.iter_mut().for_each(|light| light.techniques.clear());
    plan.slots.iter_mut().for_each(|slot| slot.reason.clear());
    plan
}

#[test]
fn every_option_acts_or_is_refused_beside_every_other() {
    let mut witnesses = witnesses();
    let mut idle = Vec::new();
    let mut tried = 0;
    for entry in shadowgraph_nodes::catalog().entries() {
        let accepted = |params: &Params| (entry.from_params)(params).is_ok();
        let defaults: Params =
            (entry.options)().options.into_iter().map(|option| (option.name, option.default)).collect();
        let choices = choices(entry);
        // Beside nothing, and beside every value of another option.
        let contexts: Vec<Option<&Given>> = std::iter::once(None).chain(choices.iter().map(Some)).collect();
        for context in contexts {
            let base: Params = context.into_iter().cloned().collect();
            if !accepted(&base) {
                continue;
            }
            let before = plans(entry, &base, &mut witnesses);
            for (option, value) in &choices {
                let is_one_of = |list: &[(&str, &str)]| {
                    list.iter()
                        .any(|(name, word)| name == option && ParamValue::Text((*word).into()) == *value)
                };
                let may_be_idle = is_one_of(SAME_AS_DEFAULT) || (context.is_some() && is_one_of(DEMANDING));
                let is_default = defaults.get(option) == Some(value);
                if base.contains_key(option) || is_default || may_be_idle {
                    continue;
                }
                let mut with = base.clone();
                with.insert(option.clone(), value.clone());
                if !accepted(&with) {
                    continue;
                }
                tried += 1;
                if plans(entry, &with, &mut witnesses) == before {
                    idle.push(format!(
                        "{} with {base:?}: {option}={value} changes nothing",
                        entry.short_name
                    ));
                }
            }
        }
    }
    assert!(tried > 400, "{tried}");
    assert!(idle.is_empty(), "{} of {tried}:\n{}", idle.len(), idle.join("\n"));
}

/// What is refused names the option, its value and beside what it would be accepted; and a node made in code is held to it
/// when it is planned.
#[test]
fn options_without_effect_are_refused_by_name() {
    let soft = ShadowVolumeSoft::default();
    let nodes: [(ShadowNode, &str, &str); 9] = [
        (ShadowVolumeHard { weight: 0.3, ..Default::default() }.into(), "'weight' is 0.3", "passes=single"),
        (
            ShadowVolumeHard {
                geometry: GeometryMode::Open,
                terminator: Terminator::Smooth,
                ..Default::default()
            }
            .into(),
            "'terminator' is 'smooth'",
            "geometry=open",
        ),
        (
            ShadowVolumeSoft { samples: 32, quality: Quality::PerReceiver, ..soft }.into(),
            "'samples' is 32",
            "quality=sampled",
        ),
        (
            ShadowVolumeSoft { samples: 32, quality: Quality::Wedge, ..soft }.into(),
            "'samples' is 32",
            "quality=sampled",
        ),
        (
            ShadowVolumeSoft { depth_test: DepthTest::ZFail, ..soft }.into(),
            "'depthTest' is 'zfail'",
            "quality=wedge",
        ),
        (
            ShadowVolumeSoft { depth_test: DepthTest::ZFail, quality: Quality::PerReceiver, ..soft }.into(),
            "'depthTest' is 'zfail'",
            "quality=wedge",
        ),
        (
            ShadowVolumeSoft { counter: CounterKind::Float, ..soft }.into(),
            "'counter' is 'float'",
            "angle of 0",
        ),
        (
            ShadowVolumeSoft { counter: CounterKind::Float, quality: Quality::Wedge, ..soft }.into(),
            "'counter' is 'float'",
            "angle of 0",
        ),
        (SoftShadow { resolution: 512, ..SoftShadow::DIRECT }.into(), "'resolution' is 512", "mode=texture"),
    ];
    for (node, option, beside) in nodes {
        let mut scene = yard();
        scene.add_shadow("shadows", node);
        let error = try_plan(&scene, &request()).unwrap_err().to_string();
        assert!(error.contains("'shadows'") && error.contains(option) && error.contains(beside), "{error}");
    }
}

/// A default that was written down is refused where it does nothing, like any other value; but no node in code writes it.
#[test]
fn only_what_is_in_force_is_written() {
    let catalog = shadowgraph_nodes::catalog();
    for entry in catalog.entries() {
        for setting in entry.all_settings() {
            let technique = (entry.from_params)(&(setting.params)()).unwrap();
            assert!((entry.from_params)(&technique.params()).is_ok(), "{} {}", entry.type_name, setting.name);
        }
    }
    let wedge = Params::from([
        ("quality".to_owned(), ParamValue::Text("wedge".into())),
        ("samples".to_owned(), ParamValue::Number(64.0)),
    ]);
    let error = ShadowVolumeSoft::from_params(&wedge).unwrap_err().to_string();
    assert!(error.contains("'samples' is 64") && error.contains("quality=sampled"), "{error}");
    assert!(
        !ShadowVolumeSoft { quality: Quality::Wedge, ..Default::default() }
            .to_params()
            .contains_key("samples")
    );
}

/// The sizes of lights have one name and one limit everywhere.
#[test]
fn a_lights_size_is_said_alike_everywhere() {
    let mut catalog = shadowgraph_nodes::catalog();
    catalog.register(ReferenceShadow::ENTRY);
    for entry in catalog.entries() {
        let table = (entry.options)();
        let accepts = ["radius", "angle"].map(|name| table.find(name).map(|option| option.accepts.clone()));
        let number = |max| Some(Accepts::Number { min: 0.0, max, whole: false });
        assert!(accepts == [None, None] || accepts == [number(1e9), number(60.0)], "{}", entry.type_name);
    }
}
