//! What the planner once got wrong: each test failed before its cause was mended.

use glam::{DVec3, Vec3};
use shadowgraph_engine::geometry::{Mesh, MeshData};
use shadowgraph_engine::plan::{
    ColorTarget, FactorAt, Load, Pass, PlanError, Slot, SlotId, SlotKind, StencilOperation, TextureFormat,
};
use shadowgraph_engine::render::{Adapter, FrameRequest};
use shadowgraph_engine::scene::{Camera, CameraSnapshot, ParamValue, ShadowNode, placed};
use shadowgraph_engine::shadow::Cache;
use shadowgraph_testing::*;

/// One light with counts only, and one whose counts meet a visibility target: the second counts in the stencil that
/// the first is still to be shaded from, and its resolve erases the first light's shadow.
#[test]
fn a_light_shaded_from_the_stencil_has_it_for_itself() {
    let mut scene = yard();
    let (lamp, second) = (scene.find("lamp").unwrap(), add_lamp(&mut scene, "second"));
    let (first, other) = (scene.find("crate").unwrap(), add_box(&mut scene, "other", at(2.0, 1.5, 0.0)));
    scene.add_shadow("shadows", hard(&[]).with_lights([lamp, second]).with_casters([first]));
    scene.add_shadow("veils", ShadowNode::new("Veil").with_lights([second]).with_casters([other]));
    let catalog = catalog_with(&[VEIL]);
    let plan = try_plan_with(&scene, &request(), &catalog, &Adapter::imagined(), &Cache::new()).unwrap();
    assert_eq!(plan.lights[1].factor, FactorAt::Visibility(0));
    if plan.lights[0].factor == FactorAt::Counts {
        let after = plan.passes.iter().skip_while(|pass| pass.name != "volumes of lamp").skip(1);
        let counting = after.flat_map(|pass| &pass.draws).any(|draw| {
            draw.state.stencil.is_some_and(|stencil| stencil.front.pass_op != StencilOperation::Keep)
        });
        assert!(!counting, "another light counts in the stencil that 'lamp' is shaded from:\n{plan}");
    }
}

/// A mesh flattened to a sheet by its transform still casts, but its record holds the light in the mesh's own space,
/// which a singular transform does not have.
#[test]
fn a_flattened_caster_has_a_finite_record() {
    let mut scene = with_floor();
    let flat = placed(DVec3::new(0.0, 1.5, 0.0), glam::DQuat::IDENTITY, DVec3::new(1.0, 0.0, 1.0));
    scene.add_mesh(cuboid("flattened", Vec3::splat(0.5)), Default::default(), flat);
    add_lamp(&mut scene, "lamp");
    scene.add_shadow("shadows", hard(&[]));
    let Ok(plan) = try_plan(&scene, &request()) else { return };
    for record in records(&plan, "lamp") {
        let finite = record.light_high.iter().chain(&record.light_low).all(|value| value.is_finite());
        assert!(finite, "the record of a flattened caster is not finite: {record:?}");
    }
}

/// A pass into a texture of its own size, with a scissor of that size.
fn pass_confined_to(target_px: [u32; 2], scissor_px: [u32; 4]) -> Result<(), PlanError> {
    let mut plan = plan(&shadowed_yard(&[]), &request());
    let slot = SlotId(plan.slots.len());
    let kind =
        SlotKind::Texture { format: TextureFormat::R32Float, size_px: target_px, layers: 1, samples: 1 };
    plan.slots.push(Slot { name: "map".into(), kind, reason: "a test".into(), kept: None });
    let mut draw = plan.passes[0].draws[0].clone();
    draw.state.depth_write = false;
    draw.state.targets = vec![None];
    draw.scissor_px = Some(scissor_px);
    let colors = vec![ColorTarget { slot, layer: 0, load: Load::Clear([0.0; 4]), resolve: None }];
    plan.passes.insert(
        0,
        Pass { name: "map".into(), reason: "a test".into(), colors, depth: None, draws: vec![draw] },
    );
    plan.validate()
}

#[test]
fn a_scissor_within_a_target_larger_than_the_picture_is_valid() {
    let result = pass_confined_to([256, 256], [0, 0, 256, 256]);
    assert_eq!(result, Ok(()), "the scissor lies within its target");
}

#[test]
fn a_scissor_beyond_a_target_smaller_than_the_picture_is_found() {
    assert!(pass_confined_to([16, 16], [0, 0, 32, 32]).is_err(), "the scissor leaves its target");
}

#[test]
fn a_factor_image_that_nothing_writes_is_found() {
    let mut wanted = request();
    wanted.factors = true;
    let mut plan = plan(&shadowed_yard(&[]), &wanted);
    plan.passes.retain(|pass| pass.name != "factor of lamp");
    assert!(plan.validate().is_err(), "no pass writes the factor image of 'lamp'");
}

#[test]
fn a_picture_that_nothing_writes_is_found() {
    let mut plan = plan(&shadowed_yard(&[]), &request());
    plan.passes.retain(|pass| pass.name != "shading");
    assert!(plan.validate().is_err(), "no pass writes the picture");
}

/// Without its resolve, the counts of the last light reach no mask and nobody notices.
#[test]
fn a_light_that_is_never_resolved_is_found() {
    let mut scene = shadowed_yard(&[]);
    add_lamp(&mut scene, "second");
    let mut plan = plan(&scene, &request());
    plan.passes.retain(|pass| pass.name != "resolve second");
    assert!(plan.validate().is_err(), "no pass writes the bit of 'second'");
}

/// Cameras of a scene are checked when it is posed; one given from outside is not.
#[test]
fn a_camera_from_outside_the_scene_is_checked() {
    let blind = CameraSnapshot::looking(Camera::perspective("blind", 0.0), DVec3::ONE, DVec3::ZERO);
    let result = try_plan(&shadowed_yard(&[]), &FrameRequest::new(blind, SIZE_PX));
    assert!(result.is_err(), "planned with an opening angle of 0");
}

/// The node asks for the picture to be darkened before it finds that its only caster has no area.
#[test]
fn casters_that_come_to_nothing_leave_nothing_to_darken() {
    for (type_name, options) in [
        ("ShadowVolumeHard", vec![("passes", "single")]),
        ("ShadowVolumeSoft", vec![("apply", "darken"), ("radius", "0")]),
        ("ShadowVolumeSoft", vec![("apply", "darken"), ("radius", "0.1")]),
        ("TransparentShadow", vec![]),
    ] {
        let mut scene = with_floor();
        let corners = vec![Vec3::new(-1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(-1.0, 1.0, 0.0)];
        let line = MeshData { positions: corners, indices: vec![0, 1, 2], ..MeshData::default() };
        scene.add_mesh(Mesh::new(line).unwrap(), Default::default(), at(0.0, 0.0, 0.0));
        add_lamp(&mut scene, "lamp");
        let mut node = ShadowNode::new(type_name);
        for (option, value) in &options {
            let value = value.parse().map_or_else(|_| text(value), ParamValue::Number);
            node.params.insert((*option).into(), value);
        }
        scene.add_shadow("shadows", node);
        let wanted = FrameRequest { factors: true, ..request() };
        let planned = try_plan(&scene, &wanted);
        assert!(planned.is_ok(), "{type_name} {options:?}: {:?}", planned.err());
    }
}

fn text(value: &str) -> ParamValue {
    ParamValue::Text(value.into())
}
