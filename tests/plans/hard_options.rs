//! What the options of `ShadowVolumeHard` change in a plan, and what they refuse; no GPU.

use glam::{DAffine3, DVec3, Vec3};
use shadowgraph_engine::geometry::{Chain, capped, doubled, facing_signs};
use shadowgraph_engine::plan::{CompareFunction, FactorAt, FramePlan, SlotKind, TextureFormat};
use shadowgraph_engine::render::{Adapter, FrameError, FrameRequest, PictureFormat};
use shadowgraph_engine::scene::{Light, Material, ParamValue, Scene, ShadowNode};
use shadowgraph_engine::shadow::{Cache, Features, OptionError, ShadowError};
use shadowgraph_testing::*;

fn refusal(scene: &Scene, request: &FrameRequest) -> ShadowError {
    match try_plan(scene, request) {
        Err(FrameError::Shadow(error)) => error,
        Err(error) => panic!("expected a shadow's refusal, got {error}"),
        Ok(plan) => panic!("expected a refusal, got\n{plan}"),
    }
}

fn names_all(error: &ShadowError, names: &[&str]) {
    let text = error.to_string();
    assert!(!text.contains('\n'), "one line: {text}");
    names.iter().for_each(|name| assert!(text.contains(name), "'{name}' is not named in: {text}"));
}

/// Half a box: five of its faces, open at the top, which the lamp looks into.
fn cup(name: &str) -> shadowgraph_engine::geometry::Mesh {
    let whole = unit_box(name);
    let mut data = whole.data().clone();
    let top = |corners: &[u32]| corners.iter().all(|v| data.positions[*v as usize].y > 0.0);
    data.indices = data.indices.chunks_exact(3).filter(|c| !top(c)).flatten().copied().collect();
    data.parts.clear();
    shadowgraph_engine::geometry::Mesh::new(data).expect("a cup")
}

fn cup_yard(options: &[(&str, &str)]) -> Scene {
    let mut scene = with_floor();
    scene.add_mesh(cup("cup"), Material::default(), at(0.0, 1.5, 0.0));
    add_lamp(&mut scene, "lamp");
    scene.add_shadow("shadows", hard(options));
    scene
}

fn names(plan: &FramePlan) -> Vec<&str> {
    plan.passes.iter().map(|pass| pass.name.as_str()).collect()
}

fn drawn(plan: &FramePlan) -> u64 {
    index_count(&volume_draws(plan, "lamp"))
}

#[test]
fn every_value_of_every_option_is_planned() {
    for (option, values) in [
        ("closure", &["none", "cap", "backfaces"][..]),
        ("passes", &["multi", "single"]),
        ("counter", &["auto", "stencil8", "float"]),
        ("terminator", &["geometric", "smooth"]),
    ] {
        for value in values {
            let plan = plan(&cup_yard(&[(option, value)]), &request());
            assert!(drawn(&plan) > 0, "{option}={value}");
        }
        let error = refusal(&cup_yard(&[(option, "maybe")]), &request());
        names_all(&error, &["'shadows'", &format!("'{option}'"), "'maybe'", &values.join(", ")]);
    }
}

#[test]
fn values_that_do_not_go_together_are_refused() {
    let node = |options: &[(&str, &str)], weight: Option<ParamValue>| {
        let mut scene = yard();
        let node = hard(options);
        scene.add_shadow("shadows", weight.into_iter().fold(node, |n, w| n.with_param("weight", w)));
        scene
    };
    let weight = |number: f64| Some(ParamValue::Number(number));
    let error = refusal(&node(&[], weight(0.5)), &request());
    names_all(&error, &["'shadows'", "'weight'", "0.5", "with passes=single only"]);
    for number in [-0.1, 1.5, f64::NAN] {
        let error = refusal(&node(&[("passes", "single")], weight(number)), &request());
        names_all(&error, &["'weight'", "a number from 0 to 1"]);
    }
    let error = refusal(&node(&[("passes", "single"), ("counter", "float")], None), &request());
    assert!(matches!(&error, ShadowError::Option { source: OptionError::BadValue { .. }, .. }));
    names_all(&error, &["'counter'", "'float'", "auto, stencil8 with passes=single"]);
    for number in [0.0, 0.25, 1.0] {
        assert!(try_plan(&node(&[("passes", "single")], weight(number)), &request()).is_ok());
    }
}

#[test]
fn options_survive_being_saved() {
    let catalog = shadowgraph_nodes::catalog();
    let entry = catalog.find("hard").unwrap();
    let base = ShadowNode::from(shadowgraph_nodes::ShadowVolumeHard::default());
    let mut tried = 0;
    for setting in entry.all_settings() {
        let technique = (entry.from_params)(&(setting.params)()).unwrap();
        let again = (entry.from_params)(&technique.params()).unwrap();
        assert_eq!(technique.params(), again.params(), "{}", setting.name);
        // A given value comes back as it was given.
        (setting.params)().iter().for_each(|(name, value)| assert_eq!(&again.params()[name], value));
        tried += 1;
    }
    assert!(tried >= 9 && base.params.len() == 7, "{:?}", base.params);
    let weighted = [("passes", ParamValue::Text("single".into())), ("weight", ParamValue::Number(0.3))];
    let params = weighted.map(|(name, value)| (name.to_owned(), value)).into();
    assert_eq!((entry.from_params)(&params).unwrap().params()["weight"], ParamValue::Number(0.3));
}

#[test]
fn a_closed_caster_is_not_closed_again() {
    let plain = plan(&shadowed_yard(&[]), &request());
    for closure in ["cap", "backfaces"] {
        let closed = plan(&shadowed_yard(&[("closure", closure)]), &request());
        assert_eq!(drawn(&closed), drawn(&plain), "{closure}");
    }
}

#[test]
fn a_capped_cup_casts_like_a_box() {
    // The lid is what the lamp sees: its four edges, of weight 1, and nobody sees the lid but it counts.
    let plan = plan(&cup_yard(&[("closure", "cap")]), &request());
    assert_eq!(drawn(&plan), 4 * 6 + 2 * 3, "{plan}");
    assert_eq!(drawn(&self::plan(&shadowed_yard(&[]), &request())), 4 * 6);
    // `geometry=closed` takes it now; without the cap it does not.
    let closed = [("geometry", "closed"), ("closure", "cap")];
    assert!(try_plan(&cup_yard(&closed), &request()).is_ok());
    names_all(&refusal(&cup_yard(&closed[..1]), &request()), &["'cup'", "4 unpaired edges"]);
}

#[test]
fn loops_too_long_to_cap_are_refused_by_name() {
    let count = shadowgraph_engine::geometry::MAX_CAPPED_EDGES as u32 + 1;
    let rim = (0..count).map(|i| {
        let angle = std::f32::consts::TAU * i as f32 / count as f32;
        Vec3::new(angle.cos(), 0.0, angle.sin())
    });
    let data = shadowgraph_engine::geometry::MeshData {
        name: "disc".into(),
        positions: rim.chain([Vec3::ZERO]).collect(),
        indices: (0..count).flat_map(|i| [i, (i + 1) % count, count]).collect(),
        ..Default::default()
    };
    let mut scene = with_floor();
    let mesh = shadowgraph_engine::geometry::Mesh::new(data).unwrap();
    scene.add_mesh(mesh, Material::default(), at(0.0, 1.0, 0.0));
    add_lamp(&mut scene, "lamp");
    scene.add_shadow("shadows", hard(&[("closure", "cap")]));
    let error = refusal(&scene, &request());
    names_all(&error, &["'shadows'", "closure=cap", "'disc'", "16385 edges", "none, backfaces"]);
}

/// Doubling every face and casting the lit half is what the open mode draws, term by term: Bergeron's weights are
/// backfaces with everything that cancels left out.
#[test]
fn backfaces_draw_what_open_casters_draw() {
    for request in [request(), request_in_shadow()] {
        let [open, doubled] =
            ["none", "backfaces"].map(|closure| plan(&cup_yard(&[("closure", closure)]), &request));
        assert_eq!(drawn(&open), drawn(&doubled));
        let sorted = |plan: &FramePlan| {
            let indices: Vec<u32> = bytemuck::pod_collect_to_vec(buffer(plan, "volume indices of lamp").0);
            let mut triangles: Vec<[u32; 3]> =
                indices.chunks_exact(3).map(|t| rotated([t[0], t[1], t[2]])).collect();
            triangles.sort_unstable();
            triangles
        };
        assert_eq!(sorted(&open), sorted(&doubled));
    }
}

/// The same triangle, its lowest corner first.
fn rotated([a, b, c]: [u32; 3]) -> [u32; 3] {
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or([a, b, c])
}

/// Lindrud & Löfgren 2004 Fig. 3: two faces with one edge in common. The edge is "closed"; where it is a silhouette its
/// quad counts 2, where it is none it has no quad. The other edges are "open" and count 1.
#[test]
fn open_edges_weigh_one_and_closed_silhouettes_two() {
    let roof = shadowgraph_engine::geometry::MeshData {
        name: "roof".into(),
        positions: vec![
            Vec3::new(0.0, 1.0, -1.0),
            Vec3::new(0.0, 1.0, 1.0),
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(-1.0, 0.0, 0.0),
        ],
        indices: vec![0, 1, 2, 1, 0, 3],
        ..Default::default()
    };
    let mesh = shadowgraph_engine::geometry::Mesh::new(roof).unwrap();
    let positions: Vec<DVec3> = mesh.positions().iter().map(|p| p.as_dvec3()).collect();
    let weights = |light: glam::DVec4| {
        let topology = mesh.topology();
        let chain = Chain::extract(topology, &facing_signs(&positions, topology.triangles(), light));
        let mut weights = std::collections::BTreeMap::<[u32; 2], u32>::new();
        for &[p, q] in &chain.sides {
            *weights.entry([p.min(q), p.max(q)]).or_default() += 1;
        }
        (weights, chain.caps_front.len() + chain.caps_back.len())
    };
    let open = [[0, 2], [1, 2], [0, 3], [1, 3]];
    // From above both faces are lit: the ridge is no silhouette. "The near cap is the complete geometry."
    let (from_above, caps) = weights(glam::DVec4::new(0.0, 5.0, 0.0, 1.0));
    assert_eq!((from_above, caps), (open.map(|edge| (edge, 1)).into(), 2));
    // From the side one is lit, one turned away: the ridge is a closed silhouette.
    let (from_aside, caps) = weights(glam::DVec4::new(5.0, 0.5, 0.0, 1.0));
    let mut expected: std::collections::BTreeMap<_, _> = open.map(|edge| (edge, 1)).into();
    expected.insert([0, 1], 2);
    assert_eq!((from_aside, caps), (expected, 2));
    // Without the modification: one face alone has three open edges, and its own volume.
    assert_eq!(capped(&mesh).unwrap().topology.closedness().unbalanced_edges, 0);
    assert_eq!(doubled(&mesh).closedness().unbalanced_edges, 0);
}

#[test]
fn single_pass_counts_all_lights_at_once_and_darkens_once() {
    let mut scene = yard();
    add_lamp(&mut scene, "second");
    add_lamp(&mut scene, "third");
    let multi = {
        let mut scene = scene.clone();
        scene.add_shadow("shadows", hard(&[]));
        plan(&scene, &request())
    };
    scene.add_shadow("shadows", hard(&[("passes", "single")]));
    let single = plan(&scene, &request());
    assert_eq!(
        names(&single),
        ["depth prepass", "shading", "volumes of lamp", "volumes of second", "volumes of third", "darkening"]
    );
    assert!(single.lights.iter().all(|light| light.factor == FactorAt::Darkening));
    assert!(multi.slots.iter().any(|slot| slot.name == "light mask"));
    assert!(single.slots.iter().all(|slot| slot.name != "light mask") && single.bytes() < multi.bytes());
    let darkening = &single.passes.last().unwrap().draws[0];
    assert_eq!(darkening.state.blend_constant, [0.5, 0.5, 0.5, 0.0]);
    // The sky, at depth 0, is not before the draw at depth 0.
    assert_eq!(darkening.state.depth_compare, CompareFunction::Less);
    // Factors are taken from each light alone, before the shading.
    let with_factors = plan(&scene, &FrameRequest { factors: true, ..request() });
    let counted = names(&with_factors).iter().filter(|name| **name == "volumes of lamp").count();
    assert_eq!(counted, 2, "{with_factors}");
    assert_eq!(with_factors.passes_named("forget counts").count(), 3);
}

#[test]
fn counts_of_several_lights_share_one_bound() {
    let mut scene = with_floor();
    for index in 0..100 {
        add_box(&mut scene, &format!("crate{index}"), at(0.0, 1.5 + 0.001 * f64::from(index), 0.0));
    }
    add_lamp(&mut scene, "lamp");
    add_lamp(&mut scene, "second");
    let folds = |passes: &str| {
        let mut scene = scene.clone();
        scene.add_shadow("shadows", hard(&[("passes", passes)]));
        plan(&scene, &request()).passes_named("fold counts").count()
    };
    // 100 boxes fit the stencil; for two lights together they do not.
    assert_eq!(folds("multi"), 0);
    assert!(folds("single") > 0);
}

#[test]
fn there_is_one_darkening_with_one_weight() {
    let mut scene = yard();
    let (lamp, second) = (scene.find("lamp").unwrap(), add_lamp(&mut scene, "second"));
    let single = |weight: f64| hard(&[("passes", "single")]).with_param("weight", ParamValue::Number(weight));
    let mut differing = scene.clone();
    differing.add_shadow("first", single(0.5).with_lights([lamp]));
    differing.add_shadow("other", single(0.7).with_lights([second]));
    names_all(&refusal(&differing, &request()), &["'first'", "0.5", "'other'", "0.7", "one weight"]);
    // One light both ways.
    let (own, other) = (scene.find("crate").unwrap(), add_box(&mut scene, "other", at(2.0, 1.5, 0.0)));
    for (first, then) in [("single", "multi"), ("multi", "single")] {
        let mut mixed = scene.clone();
        let node = |passes| hard(&[("passes", passes)]).with_lights([lamp]);
        mixed.add_shadow(&format!("{first} node"), node(first).with_casters([own]));
        mixed.add_shadow(&format!("{then} node"), node(then).with_casters([other]));
        let error = refusal(&mixed, &request());
        names_all(&error, &["'lamp'", "'single node', which darkens", "'multi node', which takes"]);
    }
    // Two lights, one each way: the mask frees the stencil for the darkening.
    let mut both = scene.clone();
    both.add_shadow("first", hard(&[]).with_lights([lamp]));
    both.add_shadow("other", single(0.5).with_lights([second]));
    let plan = plan(&both, &request());
    assert_eq!(
        plan.lights.iter().map(|light| light.factor).collect::<Vec<_>>(),
        [FactorAt::MaskBit(0), FactorAt::Darkening]
    );
}

#[test]
fn what_the_adapter_lacks_for_an_option_is_named() {
    let without = |features: Features| Adapter {
        name: "Old GPU",
        features: Features::all() - features,
        max_size_px: 4096,
        ..Adapter::imagined()
    };
    let try_without = |scene: &Scene, features, request: &FrameRequest| {
        let catalog = shadowgraph_nodes::catalog();
        match try_plan_with(scene, request, &catalog, &without(features), &Cache::new()) {
            Err(FrameError::Shadow(error)) => Err(error),
            other => Ok(other.unwrap()),
        }
    };
    // Half floats hold what a box draws; what 300 draw needs 32 bits to be blended.
    let small = shadowed_yard(&[("counter", "float")]);
    let format = |plan: &FramePlan| {
        plan.slots.iter().find(|slot| slot.name == "counts of lamp").map(|slot| match slot.kind {
            SlotKind::Texture { format, .. } => format,
            _ => panic!("counts are a texture"),
        })
    };
    let plan = try_without(&small, Features::FLOAT32_BLENDABLE, &request()).unwrap();
    assert_eq!(format(&plan), Some(TextureFormat::R16Float));
    assert_eq!(plan.lights[0].factor, FactorAt::Visibility(0));
    assert!(!has_stencil(&plan), "counts in floats need no stencil: {plan}");
    // Nor the feature that has one.
    assert!(try_without(&small, Features::DEPTH32FLOAT_STENCIL8, &request()).is_ok());
    let mut large = small.clone();
    for index in 0..300 {
        add_box(&mut large, &format!("crate{index}"), at(0.0, 1.5 + 0.001 * f64::from(index), 0.0));
    }
    assert_eq!(
        format(&try_without(&large, Features::empty(), &request()).unwrap()),
        Some(TextureFormat::R32Float)
    );
    let error = try_without(&large, Features::FLOAT32_BLENDABLE, &request()).unwrap_err();
    assert!(matches!(&error, ShadowError::MissingFeature { .. }));
    names_all(&error, &["'shadows'", "FLOAT32_BLENDABLE", "counter=float", "'Old GPU'"]);
    // A picture of 32-bit floats is darkened by blending too.
    let single = shadowed_yard(&[("passes", "single")]);
    let linear = FrameRequest { picture: PictureFormat::LinearF32, ..request() };
    let error = try_without(&single, Features::FLOAT32_BLENDABLE, &linear).unwrap_err();
    names_all(&error, &["'shadows'", "FLOAT32_BLENDABLE", "darkening", "'Old GPU'"]);
    assert!(try_without(&single, Features::FLOAT32_BLENDABLE, &request()).is_ok());
}

#[test]
fn weights_are_blended_and_not_drawn_again() {
    let open = [("geometry", "open")];
    let float = [("geometry", "open"), ("counter", "float")];
    let [stencil, float] = [&open[..], &float[..]].map(|options| plan(&shadowed_yard(options), &request()));
    // Four silhouette edges of weight 2: eight quads, or four.
    assert_eq!((drawn(&stencil), drawn(&float)), (8 * 6, 4 * 6));
    let draws = volume_draws(&float, "lamp");
    assert!(draws.iter().all(|draw| draw.state.blend_constant[0] == 2.0 && draw.state.stencil.is_none()));
    // z-fail is drawn with the inverse comparison and sign.
    let float = plan(&shadowed_yard(&[("counter", "float")]), &request_in_shadow());
    let draws = volume_draws(&float, "lamp");
    assert!(draws.iter().all(|draw| draw.state.depth_compare == CompareFunction::LessEqual));
    assert!(draws.iter().all(|draw| draw.state.blend_constant[0] == -1.0));
}

#[test]
fn solids_with_a_smooth_terminator_cast_from_their_far_side() {
    let scene = shadowed_yard(&[("terminator", "smooth")]);
    let snapshot = scene.snapshot().unwrap();
    let crate_index = snapshot.instances.iter().position(|i| i.name == "crate").unwrap() as u32;
    let smooth = plan(&scene, &request());
    assert_eq!(smooth.lights[0].smooth_terminators, [crate_index]);
    assert!(smooth.to_string().contains("smooth terminators: 1"), "{smooth}");
    // Sides twice, for leaving and for entering, and the caps of the ten triangles that the lamp does not see.
    let draws = volume_draws(&smooth, "lamp");
    assert!(draws.iter().all(|draw| draw.name.contains("closed from its far side")));
    assert_eq!(drawn(&smooth), 2 * 4 * 6 + 10 * 3);
    let ahead = draws.iter().filter(|draw| draw.state.depth_bias > 0);
    assert_eq!(ahead.map(|draw| draw.vertices()).sum::<u64>(), 10 * 3);
    // Open casters, and a light within the bounds, keep theirs, and the plan says so.
    let mut open = yard();
    open.add_mesh(quad("sheet", 1.0), Material::default(), at(3.0, 1.0, 0.0));
    let inside = open.add_light(Light::point("inside", 1.0), DVec3::new(0.0, 1.5, 0.0), DVec3::ZERO);
    open.add_shadow("shadows", hard(&[("terminator", "smooth")]));
    let plan = plan(&open, &request());
    let inside = light_snapshot(&open, inside);
    assert!(plan.lights[inside].smooth_terminators.is_empty());
    assert!(has_note(&plan, "'sheet'") && has_note(&plan, "terminator=smooth leaves it as it is"), "{plan}");
    // Beyond 32 lights there is no bit left to say it with.
    let mut many = yard();
    (0..40).for_each(|index| {
        add_lamp(&mut many, &format!("lamp{index}"));
    });
    many.add_shadow("shadows", hard(&[("terminator", "smooth")]));
    let plan = self::plan(&many, &request());
    assert_eq!(plan.lights.iter().filter(|light| !light.smooth_terminators.is_empty()).count(), 32);
    assert!(has_note(&plan, "only the first 32 lights"));
}

fn light_snapshot(scene: &Scene, node: shadowgraph_engine::scene::NodeKey) -> usize {
    scene.snapshot().unwrap().lights.iter().position(|light| light.node == node).unwrap()
}

#[test]
fn the_catalogs_settings_are_planned() {
    let catalog = shadowgraph_nodes::catalog();
    for setting in catalog.find("hard").unwrap().all_settings() {
        let mut scene = yard();
        let node = ShadowNode { params: (setting.params)(), ..ShadowNode::new("ShadowVolumeHard") };
        scene.add_shadow("shadows", node);
        scene.add_mesh(quad("sheet", 1.0), Material::default(), DAffine3::from_translation(DVec3::Y));
        assert!(try_plan(&scene, &request()).is_ok(), "{}", setting.name);
    }
}
