//! Small scenes and questions about plans that several tests share. No GPU.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use shadowgraph_engine::geometry::{Mesh, MeshData};
use shadowgraph_engine::plan::{Draw, FramePlan, Geometry, SlotKind, StencilOperation, SurfaceStyle};
use shadowgraph_engine::render::{Adapter, FrameError, FrameRequest, plan_frame};
use shadowgraph_engine::scene::{
    Camera, CameraSnapshot, Content, Light, Material, MeshNode, NodeKey, ParamValue, Scene, ShadowFlags,
    ShadowNode,
};
use shadowgraph_engine::shadow::{Cache, Catalog, Registry};
use shadowgraph_nodes::ShadowVolumeHard;
use shadowgraph_nodes::common::volume::VolumeUniform;

pub const SIZE_PX: [u32; 2] = [64, 48];

/// A box of the given half sides about the origin, facing outwards: closed, 12 triangles.
pub fn cuboid(name: &str, half: Vec3) -> Mesh {
    let side = |i: usize, axis: usize| if i >> axis & 1 == 0 { -half[axis] } else { half[axis] };
    let positions = (0..8).map(|i| Vec3::new(side(i, 0), side(i, 1), side(i, 2))).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices = quads.map(|[a, b, c, d]| [a, b, c, a, c, d]).concat();
    Mesh::new(MeshData { name: name.into(), positions, indices, ..MeshData::default() }).expect("a box")
}

/// A box with sides of 1 m.
pub fn unit_box(name: &str) -> Mesh {
    cuboid(name, Vec3::splat(0.5))
}

/// A square in y = 0, facing up: open, 2 triangles.
pub fn quad(name: &str, half: f32) -> Mesh {
    let positions = [[-half, -half], [-half, half], [half, half], [half, -half]];
    let positions = positions.map(|[x, z]| Vec3::new(x, 0.0, z)).to_vec();
    let indices = vec![0, 1, 2, 0, 2, 3];
    Mesh::new(MeshData { name: name.into(), positions, indices, ..MeshData::default() }).expect("a quad")
}

pub fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

/// A floor of 20 m that receives and casts nothing.
pub fn with_floor() -> Scene {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh_data(Arc::new(quad("floor", 10.0)));
    let material = scene.add_material(Material::default());
    let shadow = ShadowFlags { casts: false, receives: true };
    let node = MeshNode { shadow, ..MeshNode::new(mesh, material) };
    scene.add(None, "floor", DAffine3::IDENTITY, Content::Mesh(node));
    scene
}

pub fn add_box(scene: &mut Scene, name: &str, place: DAffine3) -> NodeKey {
    scene.add_mesh(unit_box(name), Material::default(), place)
}

/// A point light right above the origin, 6 m up.
pub fn add_lamp(scene: &mut Scene, name: &str) -> NodeKey {
    scene.add_light(Light::point(name, 100.0), DVec3::new(0.0, 6.0, 0.0), DVec3::ZERO)
}

/// The floor, a box that floats 1 m above its middle, and a lamp right above: the lamp sees the box's top only.
pub fn yard() -> Scene {
    let mut scene = with_floor();
    add_box(&mut scene, "crate", at(0.0, 1.5, 0.0));
    add_lamp(&mut scene, "lamp");
    scene
}

/// [`yard`] with a hard shadow node of the given options.
pub fn shadowed_yard(options: &[(&str, &str)]) -> Scene {
    let mut scene = yard();
    scene.add_shadow("shadows", hard(options));
    scene
}

/// A `ShadowVolumeHard` node over everything.
pub fn hard(options: &[(&str, &str)]) -> ShadowNode {
    options.iter().fold(ShadowVolumeHard::default().into(), |node: ShadowNode, (name, value)| {
        node.with_param(name, ParamValue::Text((*value).into()))
    })
}

pub fn camera(eye: DVec3, target: DVec3) -> CameraSnapshot {
    CameraSnapshot::looking(Camera::perspective("eye", 0.9), eye, target)
}

/// A request of [`SIZE_PX`] from beside [`yard`]'s box, outside its shadow.
pub fn request() -> FrameRequest {
    FrameRequest::new(camera(DVec3::new(6.0, 5.0, 8.0), DVec3::ZERO), SIZE_PX)
}

/// A request from under [`yard`]'s box, in its shadow.
pub fn request_in_shadow() -> FrameRequest {
    let eye = DVec3::new(0.1, 0.3, 0.1);
    FrameRequest::new(camera(eye, DVec3::new(3.0, 0.0, 3.0)), SIZE_PX)
}

pub fn try_plan_with(
    scene: &Scene,
    request: &FrameRequest,
    catalog: &Catalog,
    adapter: &Adapter<'_>,
    cache: &Cache,
) -> Result<FramePlan, FrameError> {
    let snapshot = scene.snapshot().expect("the scene is valid");
    plan_frame(&snapshot, &Registry::collect(&snapshot, catalog)?, request, adapter, cache)
}

pub fn try_plan(scene: &Scene, request: &FrameRequest) -> Result<FramePlan, FrameError> {
    let catalog = shadowgraph_nodes::catalog();
    try_plan_with(scene, request, &catalog, &Adapter::imagined(), &Cache::new())
}

pub fn plan(scene: &Scene, request: &FrameRequest) -> FramePlan {
    try_plan(scene, request).expect("the scene can be planned")
}

/// The bytes of the buffer called `name`, and its revision key.
pub fn buffer<'a>(plan: &'a FramePlan, name: &str) -> (&'a [u8], u64) {
    let slot = plan.slots.iter().find(|slot| slot.name == name);
    match slot.map(|slot| &slot.kind) {
        Some(SlotKind::Buffer { contents, revision_key, .. }) => (&contents.0, *revision_key),
        other => panic!("'{name}' is {other:?}, not a buffer of\n{plan}"),
    }
}

/// The records of the volumes of `light`.
pub fn records(plan: &FramePlan, light: &str) -> Vec<VolumeUniform> {
    bytemuck::pod_collect_to_vec(buffer(plan, &format!("volumes of {light}")).0)
}

/// The draws of the volumes of `light`, over all its passes.
pub fn volume_draws<'a>(plan: &'a FramePlan, light: &str) -> Vec<&'a Draw> {
    let name = format!("volumes of {light}");
    plan.passes.iter().filter(|pass| pass.name == name).flat_map(|pass| &pass.draws).collect()
}

/// The number of indices drawn.
pub fn index_count(draws: &[&Draw]) -> u64 {
    draws.iter().map(|draw| draw.vertices()).sum()
}

/// Whether the draw counts behind the surface (z-fail) and not before it.
pub fn counts_behind(draw: &Draw) -> bool {
    let stencil = draw.state.stencil.expect("volumes count in the stencil");
    assert_ne!(
        stencil.front.pass_op == StencilOperation::Keep,
        stencil.front.depth_fail_op == StencilOperation::Keep
    );
    stencil.front.depth_fail_op != StencilOperation::Keep
}

/// How often opaque surfaces are drawn.
pub fn opaque_draws(plan: &FramePlan) -> usize {
    let opaque = |draw: &&Draw| match &draw.geometry {
        Geometry::Surfaces { style, .. } => *style != SurfaceStyle::Blended,
        _ => false,
    };
    plan.passes.iter().flat_map(|pass| &pass.draws).filter(opaque).count()
}

pub fn has_stencil(plan: &FramePlan) -> bool {
    plan.slots
        .iter()
        .any(|slot| matches!(slot.kind, SlotKind::Texture { format, .. } if format.has_stencil_aspect()))
}

pub fn has_note(plan: &FramePlan, text: &str) -> bool {
    plan.notes.iter().any(|note| note.contains(text))
}
