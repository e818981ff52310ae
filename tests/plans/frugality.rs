//! "Model only what a scene needs": what plans contain, and what they leave out, without a GPU.

use glam::{DVec3, Vec3};
use shadowgraph_engine::plan::{Access, Draw, FramePlan, STENCIL_AT_REST, SlotKind, TextureFormat};
use shadowgraph_engine::render::{FrameRequest, PictureFormat};
use shadowgraph_engine::scene::{Light, Material, Scene};
use shadowgraph_testing::*;

const PIXELS: u64 = SIZE_PX[0] as u64 * SIZE_PX[1] as u64;

fn pass_names(plan: &FramePlan) -> Vec<&str> {
    plan.passes.iter().map(|pass| pass.name.as_str()).collect()
}

#[test]
fn without_a_shadow_node_there_is_one_pass_and_no_stencil() {
    let plan = plan(&yard(), &request());
    assert_eq!(pass_names(&plan), ["shading"]);
    assert!(!has_stencil(&plan));
    // Picture and depth, 4 bytes a pixel each, and nothing else.
    assert_eq!((plan.slots.len(), plan.bytes()), (2, PIXELS * 8), "{plan}");
    assert_eq!(opaque_draws(&plan), 1);
    assert!(plan.passes[0].draws[0].bindings.is_empty(), "shading reads no factor");
    assert!(has_note(&plan, "light 'lamp' has no shadow node"), "{plan}");
}

#[test]
fn a_scene_without_lights_or_meshes_is_one_pass_too() {
    let mut scene = Scene::new();
    scene.add_shadow("shadows", hard(&[]));
    let plan = plan(&scene, &request());
    assert_eq!(pass_names(&plan), ["shading"]);
    assert_eq!(plan.passes[0].reason, "ambient light only");
    assert_eq!(plan.bytes(), PIXELS * 8);
}

#[test]
fn a_closed_caster_casts_with_its_lit_half_only() {
    let drawn = |options: &[(&str, &str)], request: &FrameRequest| {
        let plan = plan(&shadowed_yard(options), request);
        let bytes = buffer(&plan, "volume indices of lamp").0.len();
        (index_count(&volume_draws(&plan, "lamp")), bytes)
    };
    // Closed: 4 silhouette edges of weight 1 (two triangles each), and two lit triangles with two caps each.
    let (sides, caps) = (4 * 6, 2 * 2 * 3);
    assert_eq!(drawn(&[], &request_in_shadow()), (sides + caps, 4 * (sides + caps) as usize));
    // Open: the same edges with weight 2, and caps for all twelve triangles.
    let (open_sides, open_caps) = (2 * sides, 12 * 2 * 3);
    let open = &[("geometry", "open")];
    assert_eq!(
        drawn(open, &request_in_shadow()),
        (open_sides + open_caps, 4 * (open_sides + open_caps) as usize)
    );
    // Outside the shadow there are no caps to save, but half of the sides.
    assert_eq!(drawn(&[], &request()).0, sides);
    assert_eq!(drawn(open, &request()).0, open_sides);
    // `auto` took the mode that `closed` asks for.
    assert_eq!(drawn(&[("geometry", "closed")], &request_in_shadow()), drawn(&[], &request_in_shadow()));
}

#[test]
fn an_eye_inside_a_solid_sees_all_its_triangles_cast() {
    let inside = FrameRequest::new(camera(DVec3::new(0.0, 1.5, 0.0), DVec3::new(3.0, 1.0, 0.0)), SIZE_PX);
    let plan = plan(&shadowed_yard(&[]), &inside);
    assert_eq!(index_count(&volume_draws(&plan, "lamp")), 2 * 4 * 6 + 12 * 2 * 3, "{plan}");
}

#[test]
fn an_open_caster_casts_with_all_its_triangles() {
    let mut scene = with_floor();
    scene.add_mesh(quad("sheet", 1.0), Material::default(), at(0.0, 2.0, 0.0));
    add_lamp(&mut scene, "lamp");
    scene.add_shadow("shadows", hard(&[]));
    let draws = plan(&scene, &request());
    assert_eq!(index_count(&volume_draws(&draws, "lamp")), 4 * 6);
    let draws = plan(&scene, &request_in_shadow());
    assert_eq!(index_count(&volume_draws(&draws, "lamp")), 4 * 6 + 2 * 2 * 3);
}

#[test]
fn caps_are_drawn_only_for_an_eye_in_the_volume() {
    let scene = shadowed_yard(&[]);
    let outside = plan(&scene, &request());
    let inside = plan(&scene, &request_in_shadow());
    let (outside, inside) = (volume_draws(&outside, "lamp"), volume_draws(&inside, "lamp"));
    assert!(!outside.is_empty() && outside.iter().all(|draw| !counts_behind(draw)), "z-pass outside");
    assert!(!inside.is_empty() && inside.iter().all(|draw| counts_behind(draw)), "z-fail inside");
    assert_eq!((index_count(&outside), index_count(&inside)), (4 * 6, 4 * 6 + 2 * 2 * 3));
    // Sides and far caps lie one after the other: one draw. Front caps, which lie behind themselves, are another.
    assert_eq!((outside.len(), inside.len()), (1, 2));
}

#[test]
fn the_depth_test_is_chosen_for_each_caster() {
    let mut scene = shadowed_yard(&[]);
    add_box(&mut scene, "aside", at(4.0, 1.5, 4.0));
    let plan = plan(&scene, &request_in_shadow());
    let behind: Vec<(&str, bool)> =
        volume_draws(&plan, "lamp").iter().map(|draw| (draw.name.as_str(), counts_behind(draw))).collect();
    let crate_draws = [("crate closed z-fail to a plane", true); 2];
    assert_eq!(behind, [&crate_draws[..], &[("aside closed z-pass to a plane", false)]].concat());
}

#[test]
fn volumes_end_on_a_plane_behind_all_that_receives() {
    let scene = shadowed_yard(&[]);
    let snapshot = scene.snapshot().unwrap();
    let crate_index = snapshot.instances.iter().position(|i| i.name == "crate").unwrap();
    let plan = plan(&scene, &request());
    let [record] = records(&plan, "lamp")[..] else { panic!("one caster, one record") };
    assert_eq!((record.end_kind, record.instance), (1, crate_index as u32));
    // The plane, given in the caster's own space, has light, receivers and caster on its positive side.
    let to_shader = snapshot.instances[crate_index].world_from_shader().inverse();
    let normal = Vec3::from(record.end_normal).as_dvec3();
    let height = |p: DVec3| normal.dot(to_shader.transform_point3(p)) - f64::from(record.end_offset);
    assert!(height(snapshot.lights[0].position.truncate()) > 0.0);
    for instance in &snapshot.instances {
        assert!(
            instance.world_bounds.corners().iter().all(|corner| height(*corner) > 0.0),
            "{}",
            instance.name
        );
    }
    // It follows closely: a hundredth of the floor's size below the floor is beyond it.
    assert!(height(DVec3::new(0.0, -0.1, 0.0)) < 0.0, "the plane is far below the floor");
}

#[test]
fn a_receiver_further_down_moves_the_end_and_one_out_of_view_does_not() {
    let end = |depth_m: Option<f64>, behind: bool| {
        let mut scene = shadowed_yard(&[]);
        if let Some(depth_m) = depth_m {
            let z = if behind { 300.0 } else { 0.0 };
            scene.add_mesh(unit_box("pit"), Material::default(), at(0.0, -depth_m, z));
        }
        let plan = plan(&scene, &request());
        let record = records(&plan, "lamp")[0];
        assert_eq!(record.end_kind, 1);
        record.end_offset
    };
    assert!(end(Some(5.0), false) < end(None, false) - 4.0);
    assert_eq!(end(Some(5.0), true), end(None, false));
}

#[test]
fn volumes_run_to_infinity_where_no_plane_is_exact() {
    // A lamp in a hollow box, and the eye with it: whatever the axis, some wall is beyond the lamp.
    let mut scene = Scene::new();
    scene.add_mesh(cuboid("room", Vec3::splat(3.0)), Material::default(), at(0.0, 0.0, 0.0));
    scene.add_light(Light::point("lamp", 100.0), DVec3::new(0.0, 1.0, 0.0), DVec3::ZERO);
    scene.add_shadow("shadows", hard(&[]));
    let request = FrameRequest::new(camera(DVec3::new(1.0, 0.0, 2.0), DVec3::ZERO), SIZE_PX);
    let plan = plan(&scene, &request);
    let [record] = records(&plan, "lamp")[..] else { panic!("one caster, one record") };
    assert_eq!((record.end_kind, record.end_normal, record.end_scale), (0, [0.0; 3], 0.0));
}

#[test]
fn infinite_volumes_of_directional_lights_have_no_far_ends() {
    let mut scene = with_floor();
    add_box(&mut scene, "crate", at(0.0, 1.5, 0.0));
    scene.add_light(Light::directional("sun", 1.0), DVec3::new(0.0, 6.0, 0.0), DVec3::ZERO);
    scene.add_shadow("shadows", hard(&[("extrusion", "infinite")]));
    // One triangle for each of four sides: both its far corners are the one point at infinity.
    assert_eq!(index_count(&volume_draws(&plan(&scene, &request()), "sun")), 4 * 3);
    // In the shadow, front caps; there is nothing to cap at infinity.
    assert_eq!(index_count(&volume_draws(&plan(&scene, &request_in_shadow()), "sun")), 4 * 3 + 2 * 3);
}

#[test]
fn a_light_that_reaches_nothing_in_view_has_no_passes() {
    let mut scene = with_floor();
    add_box(&mut scene, "crate", at(0.0, 1.5, 0.0));
    let light = Light::point("glow", 1.0).with_range(1.0);
    scene.add_light(light, DVec3::new(0.0, 30.0, 0.0), DVec3::ZERO);
    scene.add_shadow("shadows", hard(&[]));
    let plan = plan(&scene, &request());
    assert_eq!(pass_names(&plan), ["shading"]);
    assert!(!has_stencil(&plan) && plan.bytes() == PIXELS * 8);
    assert!(has_note(&plan, "light 'glow' reaches nothing in view: no passes"), "{plan}");
}

#[test]
fn a_light_whose_casters_miss_the_view_has_no_passes() {
    // Lit from above: one box beyond all that receives, one over the floor where nobody looks.
    for (place, reason) in [
        (at(-40.0, 90.0, -60.0), "its shadow misses all receivers in view"),
        (at(8.5, 0.6, 9.0), "its shadow misses the view"),
    ] {
        let mut scene = with_floor();
        add_box(&mut scene, "unseen", place);
        scene.add_light(Light::directional("sun", 1.0), DVec3::new(0.0, 6.0, 0.0), DVec3::ZERO);
        scene.add_shadow("shadows", hard(&[]));
        let missed = plan(&scene, &request());
        assert_eq!(pass_names(&missed), ["shading"]);
        assert!(!has_stencil(&missed) && missed.bytes() == PIXELS * 8);
        assert!(missed.notes.contains(&format!("casters of 'sun' 'unseen': {reason}")), "{missed}");
        // With another caster in view, only that one is drawn.
        add_box(&mut scene, "crate", at(0.0, 1.5, 0.0));
        let seen = plan(&scene, &request());
        let names: Vec<&str> = volume_draws(&seen, "sun").iter().map(|draw| draw.name.as_str()).collect();
        assert_eq!(names.len(), 1);
        assert!(names[0].starts_with("crate "));
    }
}

#[test]
fn a_caster_behind_the_eye_counts_when_its_shadow_is_in_view() {
    let mut scene = with_floor();
    add_box(&mut scene, "behind", at(8.0, 7.0, 11.0));
    scene.add_light(Light::directional("sun", 1.0), DVec3::new(8.0, 7.0, 11.0), DVec3::ZERO);
    scene.add_shadow("shadows", hard(&[]));
    let plan = plan(&scene, &request());
    assert!(has_note(&plan, "1 meshes outside the view are not drawn"), "{plan}");
    // Its sides, and its front caps.
    assert_eq!(volume_draws(&plan, "sun").len(), 2);
}

/// The float formats among the textures of `plan`.
fn floats(plan: &FramePlan) -> Vec<(&str, TextureFormat)> {
    let float = |format: TextureFormat| format!("{format:?}").contains("Float") && !format.has_depth_aspect();
    let textures = plan.slots.iter().filter_map(|slot| match slot.kind {
        SlotKind::Texture { format, .. } if float(format) => Some((slot.name.as_str(), format)),
        _ => None,
    });
    textures.collect()
}

#[test]
fn without_transparent_casters_nothing_is_counted_in_floats() {
    let mut scene = shadowed_yard(&[]);
    add_lamp(&mut scene, "second");
    assert_eq!(floats(&plan(&scene, &request())), []);
    // What is asked for is there, and only that.
    let mut wanted = request();
    wanted.picture = PictureFormat::LinearF32;
    wanted.factors = true;
    let expected = [
        ("picture", TextureFormat::Rgba32Float),
        ("factor of lamp", TextureFormat::R32Float),
        ("factor of second", TextureFormat::R32Float),
    ];
    assert_eq!(floats(&plan(&scene, &wanted)), expected);
}

/// `count` boxes above each other in the lamp's light.
fn tower(count: u32) -> Scene {
    let mut scene = with_floor();
    for storey in 0..count {
        add_box(&mut scene, &format!("box {storey}"), at(0.0, 1.0 + 1.5 * f64::from(storey), 0.0));
    }
    let top = 10.0 + 1.5 * f64::from(count);
    scene.add_light(Light::directional("sun", 1.0), DVec3::new(0.0, top, 0.0), DVec3::ZERO);
    scene.add_shadow("shadows", hard(&[]));
    scene
}

fn write_masks(plan: &FramePlan) -> Vec<u8> {
    let masks = volume_draws(plan, "sun")
        .into_iter()
        .map(|draw| draw.state.stencil.expect("volumes count").write_mask);
    let mut masks: Vec<u8> = masks.collect();
    masks.dedup();
    masks
}

#[test]
fn few_layers_take_the_smaller_counter() {
    for count in [1, 60, 110] {
        let plan = plan(&tower(count), &request());
        assert_eq!(pass_names(&plan), ["depth prepass", "volumes of sun", "shading"], "{count} boxes");
        assert_eq!(volume_draws(&plan, "sun").len(), count as usize);
        assert_eq!(write_masks(&plan), [0xff]);
        assert!(!has_note(&plan, "wider counter"), "{plan}");
    }
}

#[test]
fn many_layers_are_folded_and_the_plan_says_so() {
    let plan = plan(&tower(300), &request());
    let groups = plan.passes.iter().filter(|pass| pass.name == "volumes of sun").count();
    let folds: Vec<_> = plan.passes.iter().filter(|pass| pass.name == "fold counts of sun").collect();
    // 300 layers at 95 a group.
    assert!(groups >= 4, "{plan}");
    assert_eq!(folds.len(), groups - 1, "a fold between groups, none before the first");
    assert_eq!(volume_draws(&plan, "sun").len(), 300, "every caster is counted once");
    assert_eq!(write_masks(&plan), [0x7f], "the sticky bit is left alone");
    for fold in folds {
        let masks = |draw: &Draw| {
            let stencil = draw.state.stencil.unwrap();
            (stencil.read_mask, stencil.write_mask, stencil.reference)
        };
        let masks: Vec<_> = fold.draws.iter().map(masks).collect();
        assert_eq!(masks, [(0x7f, 0x7f, STENCIL_AT_REST), (0x7f, 0xff, 0x80 | STENCIL_AT_REST)]);
        assert_eq!(fold.depth.as_ref().unwrap().stencil, Some(Access::Keep));
        assert!(fold.reason.contains("more layers than the stencil can count"));
    }
    assert!(has_note(&plan, "a wider counter for 'sun'"), "{plan}");
    // Folding is all there is: the counter is still the 8-bit stencil.
    let few = shadowgraph_testing::plan(&tower(1), &request());
    let textures = |plan: &FramePlan| {
        plan.slots
            .iter()
            .filter(|s| matches!(s.kind, SlotKind::Texture { .. }))
            .map(|s| s.bytes())
            .sum::<u64>()
    };
    assert_eq!(textures(&plan), textures(&few));
}

#[test]
fn nodes_that_serve_one_light_share_its_counter() {
    let mut scene = tower(0);
    let lower: Vec<_> =
        (0..3).map(|i| add_box(&mut scene, "a", at(0.0, 1.0 + 1.5 * f64::from(i), 0.0))).collect();
    let upper = add_box(&mut scene, "b", at(0.0, 8.0, 0.0));
    let all = scene.find("shadows").unwrap();
    scene.remove(all).unwrap();
    scene.add_shadow("lower", hard(&[]).with_casters(lower));
    scene.add_shadow("upper", hard(&[]).with_casters([upper]));
    let plan = plan(&scene, &request());
    assert_eq!(pass_names(&plan), ["depth prepass", "volumes of sun", "volumes of sun", "shading"]);
    assert_eq!(volume_draws(&plan, "sun").len(), 4);
}
