//! How factors reach the shading pass: the stencil, the light mask, the visibility array; and who casts for whom.

use shadowgraph::prelude::{DVec3, Light};
use shadowgraph_engine::plan::{
    Access, Binding, BlendFactor, BlendOperation, FactorAt, FramePlan, Load, SlotKind, TextureFormat,
};
use shadowgraph_engine::render::{Adapter, FrameError};
use shadowgraph_engine::scene::{NodeKey, Scene, ShadowNode};
use shadowgraph_engine::shadow::{Cache, Registry, ShadowError};
use shadowgraph_testing::*;

/// The yard under `count` lamps in a row, all shadowed by one node.
fn lamps(count: usize) -> Scene {
    let mut scene = with_floor();
    add_box(&mut scene, "crate", at(0.0, 1.5, 0.0));
    for index in 0..count {
        let lamp = add_lamp(&mut scene, &format!("lamp{index}"));
        let node = scene.node_mut(lamp).expect("it was just added");
        node.parent_from_local.translation.x += index as f64 * 0.03;
    }
    scene.add_shadow("shadows", hard(&[]));
    scene
}

fn mask(plan: &FramePlan) -> Option<(TextureFormat, u32, u64)> {
    let slot = plan.slots.iter().find(|slot| slot.name == "light mask")?;
    match slot.kind {
        SlotKind::Texture { format, layers, size_px, .. } => {
            assert_eq!(size_px, plan.size_px);
            Some((format, layers, slot.bytes()))
        }
        SlotKind::Buffer { .. } | SlotKind::Image { .. } => panic!("the mask is a texture"),
    }
}

fn plan_with_veil(scene: &Scene) -> Result<FramePlan, FrameError> {
    try_plan_with(scene, &request(), &catalog_with(&[VEIL]), &Adapter::imagined(), &Cache::new())
}

#[test]
fn one_light_is_shaded_straight_from_the_stencil() {
    let plan = plan(&lamps(1), &request());
    assert_eq!(plan.lights[0].factor, FactorAt::Counts);
    assert_eq!(mask(&plan), None);
    assert_eq!(plan.passes_named("resolve").count(), 0);
    let names: Vec<&str> = plan.passes.iter().map(|pass| pass.name.as_str()).collect();
    assert_eq!(names, ["depth prepass", "volumes of lamp0", "shading"]);
    let shading = plan.passes.last().unwrap();
    let depth = shading.depth.as_ref().unwrap();
    assert_eq!(shading.draws[0].bindings, [(0, Binding::StencilOf(depth.slot))]);
    assert_eq!((depth.depth, depth.stencil), (Access::ReadOnly, Some(Access::ReadOnly)));
    // Picture 4, depth and stencil 5 bytes a pixel.
    let pixels = u64::from(SIZE_PX[0] * SIZE_PX[1]);
    let textures = plan.slots.iter().filter(|slot| matches!(slot.kind, SlotKind::Texture { .. }));
    assert_eq!(textures.map(|slot| slot.bytes()).sum::<u64>(), pixels * 9);
}

#[test]
fn the_mask_has_a_bit_for_each_light_and_no_more() {
    let pixels = u64::from(SIZE_PX[0] * SIZE_PX[1]);
    for (count, format, layers, bytes) in [
        (2, TextureFormat::R8Unorm, 1, 1),
        (8, TextureFormat::R8Unorm, 1, 1),
        (9, TextureFormat::Rg8Unorm, 1, 2),
        (16, TextureFormat::Rg8Unorm, 1, 2),
        (17, TextureFormat::Rgba8Unorm, 1, 4),
        (32, TextureFormat::Rgba8Unorm, 1, 4),
        (33, TextureFormat::Rgba8Unorm, 2, 8),
    ] {
        let plan = plan(&lamps(count), &request());
        assert_eq!(mask(&plan), Some((format, layers, bytes * pixels)), "{count} lights");
        assert_eq!(plan.passes_named("resolve").count(), count);
        assert_eq!(plan.passes.len(), 2 + 2 * count, "{plan}");
        for (bit, light) in plan.lights.iter().enumerate() {
            assert_eq!(light.factor, FactorAt::MaskBit(bit as u32));
        }
        let slot = plan.slots.iter().find(|slot| slot.name == "light mask").unwrap();
        assert_eq!(slot.reason, format!("one bit for each of {count} lights with counts"));
        assert!(matches!(plan.passes.last().unwrap().draws[0].bindings[..], [(1, Binding::TextureArray(_))]));
    }
}

#[test]
fn each_resolve_adds_its_own_bit_and_frees_the_stencil() {
    let plan = plan(&lamps(33), &request());
    let mut seen = Vec::new();
    for (bit, resolve) in plan.passes_named("resolve").enumerate() {
        assert_eq!(resolve.name, format!("resolve lamp{bit}"));
        let [target] = &resolve.colors[..] else { panic!("one target") };
        let [draw] = &resolve.draws[..] else { panic!("one draw") };
        assert_eq!(target.layer, bit as u32 / 32);
        let expected = if bit % 32 == 0 { Load::Clear([0.0; 4]) } else { Load::Keep };
        assert_eq!(target.load, expected, "bit {bit}");
        let blend = draw.state.targets[0].unwrap().color;
        assert_eq!((blend.src_factor, blend.dst_factor), (BlendFactor::Constant, BlendFactor::One));
        assert_eq!(blend.operation, BlendOperation::Add);
        // One bit in one channel, and no two lights the same.
        let bytes = draw.state.blend_constant.map(|value| (value * 255.0).round() as u32);
        assert_eq!(bytes.iter().map(|byte| byte.count_ones()).sum::<u32>(), 1);
        assert_eq!(bytes[(bit / 8) % 4], 1 << (bit % 8));
        assert!(!seen.contains(&(target.layer, bytes)));
        seen.push((target.layer, bytes));
        let stencil = draw.state.stencil.unwrap();
        assert!(stencil.frees(), "{stencil:?}");
        assert_eq!(draw.scissor_px, None, "the whole picture");
    }
    assert_eq!(seen.len(), 33);
}

#[test]
fn opaque_geometry_is_drawn_at_most_twice() {
    for count in [0, 1, 2, 9, 33] {
        let plan = plan(&lamps(count), &request());
        let expected = if count == 0 { 1 } else { 2 };
        assert_eq!(opaque_draws(&plan), expected, "{count} lights: {plan}");
    }
}

#[test]
fn lights_without_shadows_take_no_bit() {
    let mut scene = lamps(2);
    let shadowless = add_lamp(&mut scene, "shadowless");
    let shadow = scene.shadows().map(|(key, _)| key).next().unwrap();
    let shadowed: Vec<NodeKey> = ["lamp0", "lamp1"].map(|name| scene.find(name).unwrap()).into();
    *scene.shadow_mut(shadow).unwrap() = hard(&[]).with_lights(shadowed);
    let plan = plan(&scene, &request());
    assert_eq!(plan.lights[2].factor, FactorAt::Lit);
    assert_eq!(plan.passes_named("resolve").count(), 2);
    assert!(scene.node(shadowless).is_some() && has_note(&plan, "light 'shadowless' has no shadow node"));
    // A light that may not cast is as one without a node.
    let mut scene = lamps(2);
    let key = scene.lights().map(|(key, _)| key).next().unwrap();
    scene.light_mut(key).unwrap().casts_shadows = false;
    let plan = shadowgraph_testing::plan(&scene, &request());
    assert_eq!(plan.lights[0].factor, FactorAt::Lit);
    assert_eq!((plan.lights[1].factor, mask(&plan)), (FactorAt::Counts, None));
}

#[test]
fn a_caster_named_by_two_nodes_of_one_technique_is_counted_once() {
    let mut scene = shadowed_yard(&[]);
    let once = plan(&scene, &request());
    scene.add_shadow("again", hard(&[]));
    let twice = plan(&scene, &request());
    assert_eq!(volume_draws(&twice, "lamp").len(), 1);
    assert_eq!((twice.passes.len(), twice.bytes()), (once.passes.len(), once.bytes()));
    let snapshot = scene.snapshot().unwrap();
    let registry = Registry::collect(&snapshot, &shadowgraph_nodes::catalog()).unwrap();
    let casters = registry.lights[0].iter().flat_map(|claim| &claim.casters);
    assert!(casters.eq(&[1]));
    assert_eq!(registry.lights[0][1].casters, [] as [usize; 0]);
}

#[test]
fn a_caster_claimed_by_two_techniques_is_an_error() {
    let mut scene = shadowed_yard(&[]);
    scene.add_shadow("veils", ShadowNode::new("Veil"));
    let error = plan_with_veil(&scene).unwrap_err();
    let expected = ShadowError::ClaimedTwice {
        light: "lamp".into(),
        caster: "crate".into(),
        first: "shadows".into(),
        first_technique: "ShadowVolumeHard",
        second: "veils".into(),
        second_technique: "Veil",
    };
    assert_eq!(error, FrameError::Shadow(expected));
    let text = error.to_string();
    for named in ["'lamp'", "'crate'", "'shadows' (ShadowVolumeHard)", "'veils' (Veil)"] {
        assert!(text.contains(named), "{text}");
    }
}

#[test]
fn a_caster_claimed_with_two_sets_of_options_is_an_error() {
    let mut scene = shadowed_yard(&[]);
    scene.add_shadow("again", hard(&[("depthTest", "zfail"), ("extrusion", "infinite")]));
    let error = try_plan(&scene, &request()).unwrap_err();
    let expected = ShadowError::OptionsDiffer {
        light: "lamp".into(),
        caster: "crate".into(),
        first: "shadows".into(),
        first_options: "ShadowVolumeHard".into(),
        second: "again".into(),
        second_options: "ShadowVolumeHard depthTest=zfail extrusion=infinite".into(),
    };
    assert_eq!(error, FrameError::Shadow(expected));
    let text = error.to_string();
    for named in ["'lamp'", "'crate'", "'shadows' (ShadowVolumeHard)", "'again' (ShadowVolumeHard depthTest"]
    {
        assert!(text.contains(named), "{text}");
    }
    // Defaults that are spelled out are the defaults.
    let mut scene = shadowed_yard(&[]);
    scene.add_shadow("again", hard(&[("depthTest", "auto"), ("closure", "none")]));
    assert!(try_plan(&scene, &request()).is_ok());
}

#[test]
fn the_plan_names_the_options_that_are_not_at_their_default() {
    let planned = plan(&shadowed_yard(&[("geometry", "open"), ("depthTest", "auto")]), &request());
    assert_eq!(planned.lights[0].techniques, ["ShadowVolumeHard geometry=open"]);
    assert_eq!(plan(&shadowed_yard(&[]), &request()).lights[0].techniques, ["ShadowVolumeHard"]);
}

#[test]
fn two_techniques_may_share_a_light_or_a_caster_but_not_both() {
    // One caster, two lights.
    let mut scene = yard();
    let (lamp, second) = (scene.find("lamp").unwrap(), add_lamp(&mut scene, "second"));
    scene.add_shadow("shadows", hard(&[]).with_lights([lamp]));
    scene.add_shadow("veils", ShadowNode::new("Veil").with_lights([second]));
    let plan = plan_with_veil(&scene).unwrap();
    assert_eq!(
        plan.lights.iter().map(|l| l.factor).collect::<Vec<_>>(),
        [FactorAt::Counts, FactorAt::Visibility(0)]
    );
    // One light, two casters: counts first, then darkness where they are not zero, in the one visibility target.
    let mut scene = yard();
    let (first, other) = (scene.find("crate").unwrap(), add_box(&mut scene, "other", at(2.0, 1.5, 0.0)));
    scene.add_shadow("shadows", hard(&[]).with_casters([first]));
    scene.add_shadow("veils", ShadowNode::new("Veil").with_casters([other]));
    let plan = plan_with_veil(&scene).unwrap();
    let names: Vec<&str> = plan.passes.iter().map(|pass| pass.name.as_str()).collect();
    assert_eq!(names, ["depth prepass", "volumes of lamp", "veil of lamp", "resolve lamp", "shading"]);
    assert_eq!(plan.lights[0].factor, FactorAt::Visibility(0));
    assert_eq!(mask(&plan), None);
}

#[test]
fn the_visibility_array_has_a_layer_for_each_light_that_needs_one() {
    let mut scene = yard();
    add_lamp(&mut scene, "second");
    scene.add_shadow("veils", ShadowNode::new("Veil"));
    let plan = plan_with_veil(&scene).unwrap();
    let slot = plan.slots.iter().find(|slot| slot.name == "visibility").unwrap();
    let expected =
        SlotKind::Texture { format: TextureFormat::R16Float, size_px: SIZE_PX, layers: 2, samples: 1 };
    assert_eq!(slot.kind, expected);
    let targets: Vec<_> =
        plan.passes_named("veil").map(|pass| (pass.colors[0].layer, pass.colors[0].load)).collect();
    assert_eq!(targets, [(0, Load::Clear([1.0; 4])), (1, Load::Clear([1.0; 4]))]);
    assert!(!has_stencil(&plan), "nothing counts");
}

#[test]
fn factors_asked_for_are_images_and_the_visible_triangles_come_along() {
    let mut wanted = request();
    wanted.factors = true;
    let plan = plan(&lamps(2), &wanted);
    for (index, light) in plan.lights.iter().enumerate() {
        let slot = plan.slot(light.factor_image.unwrap());
        assert_eq!(slot.name, format!("factor of lamp{index}"));
        // Read before the resolve sets the stencil back.
        let place = |name: String| plan.passes.iter().position(|pass| pass.name == name).unwrap();
        assert!(place(format!("volumes of lamp{index}")) < place(format!("factor of lamp{index}")));
        assert!(place(format!("factor of lamp{index}")) < place(format!("resolve lamp{index}")));
    }
    assert_eq!(plan.slot(plan.visible_triangles.unwrap()).name, "visible triangles");
    // Not asked for, not there.
    let plan = shadowgraph_testing::plan(&lamps(2), &request());
    assert!(plan.visible_triangles.is_none() && plan.lights.iter().all(|light| light.factor_image.is_none()));
}

#[test]
fn lights_are_confined_to_the_pixels_they_reach() {
    let mut scene = with_floor();
    add_box(&mut scene, "crate", at(0.0, 0.5, 0.0));
    for (name, x) in [("left", -1.5), ("middle", 0.0), ("right", 1.5)] {
        scene.add_lamp(Light::point(name, 1.0).with_range(1.2), DVec3::new(x, 1.2, 0.0));
    }
    // Behind the eye's back.
    scene.add_lamp(Light::point("behind", 1.0).with_range(1.2), DVec3::new(0.0, 1.2, 40.0));
    scene.add_shadow("shadows", hard(&[]));
    let plan = plan(&scene, &request());
    assert!(
        plan.notes.iter().any(|note| note == "light 'behind' reaches nothing in view: no passes"),
        "{plan}"
    );
    let mut within = Vec::new();
    for name in ["left", "middle", "right"] {
        let [volumes, resolve] = ["volumes of", "resolve"].map(|what| {
            let pass = plan.passes.iter().find(|pass| pass.name == format!("{what} {name}"));
            pass.unwrap_or_else(|| panic!("no {what} {name}: {plan}"))
        });
        let confined: Vec<_> =
            volumes.draws.iter().chain(&resolve.draws).map(|draw| draw.scissor_px).collect();
        let [x, y, width, height] = confined[0].unwrap_or_else(|| panic!("{name}: {plan}"));
        assert!(confined.iter().all(|scissor| *scissor == confined[0]), "{name}: {confined:?}");
        let [frame_width, frame_height] = request().size_px;
        assert!(x + width <= frame_width && y + height <= frame_height, "{name}: {confined:?}");
        within.push(x + width / 2);
    }
    assert!(within.is_sorted() && within[0] < within[2], "{within:?}");
}
