//! What does not move is not extracted again: the cache, and the revision keys of buffers.

use glam::DVec3;
use shadowgraph_engine::plan::{FramePlan, SlotKind};
use shadowgraph_engine::render::{Adapter, FrameRequest};
use shadowgraph_engine::scene::{NodeKey, Scene};
use shadowgraph_engine::shadow::Cache;
use shadowgraph_testing::*;

/// Three boxes and two lamps apart from each other.
struct Yard {
    scene: Scene,
    boxes: Vec<NodeKey>,
    lamps: [NodeKey; 2],
    cache: Cache,
}

impl Yard {
    fn new() -> Self {
        let mut scene = with_floor();
        let boxes =
            (0..3).map(|i| add_box(&mut scene, &format!("box {i}"), at(2.0 * f64::from(i), 1.5, 0.0)));
        let boxes = boxes.collect();
        let lamps = ["left", "right"].map(|name| add_lamp(&mut scene, name));
        scene.node_mut(lamps[1]).expect("it was just added").parent_from_local.translation.x += 3.0;
        scene.add_shadow("shadows", hard(&[]));
        Self { scene, boxes, lamps, cache: Cache::new() }
    }

    /// Plans a frame, and counts what had to be computed for it.
    fn frame(&mut self, request: &FrameRequest) -> (FramePlan, u64) {
        self.cache.begin_frame();
        let before = self.cache.computed();
        let catalog = shadowgraph_nodes::catalog();
        let plan = try_plan_with(&self.scene, request, &catalog, &Adapter::imagined(), &self.cache);
        (plan.expect("the scene can be planned"), self.cache.computed() - before)
    }

    fn shift(&mut self, node: NodeKey) {
        self.scene.node_mut(node).expect("it is in the scene").parent_from_local.translation +=
            DVec3::new(0.125, 0.0, 0.25);
    }
}

/// Name and revision key of every buffer.
fn keys(plan: &FramePlan) -> Vec<(String, u64)> {
    let buffers = plan.slots.iter().filter_map(|slot| match slot.kind {
        SlotKind::Buffer { revision_key, .. } => Some((slot.name.clone(), revision_key)),
        SlotKind::Texture { .. } | SlotKind::Image { .. } => None,
    });
    buffers.collect()
}

fn index_key(plan: &FramePlan, light: &str) -> u64 {
    buffer(plan, &format!("volume indices of {light}")).1
}

/// What one light costs beside its casters' poses: their facing and indices, the bound on its layers and the bytes of its buffer.
const fn computed_for(casters_moved: u64) -> u64 {
    casters_moved * 2 + 2
}

#[test]
fn nothing_moved_nothing_extracted() {
    let mut yard = Yard::new();
    let (first, computed) = yard.frame(&request());
    assert_eq!(computed, 3 + 2 * computed_for(3), "three poses; two lights, three casters each");
    let (second, computed) = yard.frame(&request());
    assert_eq!(computed, 0);
    assert_eq!(keys(&first), keys(&second));
    assert_eq!(keys(&first).len(), 4);
    assert_eq!(first, second);
}

#[test]
fn what_was_not_asked_for_lately_is_dropped() {
    let mut yard = Yard::new();
    yard.frame(&request());
    for _ in 0..20 {
        yard.cache.begin_frame();
    }
    assert_eq!(yard.frame(&request()).1, 3 + 2 * computed_for(3));
}

#[test]
fn a_moved_camera_extracts_nothing() {
    let mut yard = Yard::new();
    let (first, _) = yard.frame(&request());
    let moved = FrameRequest::new(camera(DVec3::new(-5.0, 4.0, 9.0), DVec3::ZERO), [80, 40]);
    let (second, computed) = yard.frame(&moved);
    assert_eq!(computed, 0);
    for light in ["left", "right"] {
        assert_eq!(index_key(&first, light), index_key(&second, light));
    }
    // Into the shadow of a box: other draws, from the same indices.
    let (third, computed) = yard.frame(&request_in_shadow());
    assert_eq!(computed, 0);
    assert_eq!(index_key(&first, "left"), index_key(&third, "left"));
    assert_ne!(index_count(&volume_draws(&first, "left")), index_count(&volume_draws(&third, "left")));
}

#[test]
fn a_moved_light_extracts_its_own_casters_only() {
    let mut yard = Yard::new();
    let (first, _) = yard.frame(&request());
    yard.shift(yard.lamps[0]);
    let (second, computed) = yard.frame(&request());
    assert_eq!(computed, computed_for(3));
    assert_ne!(index_key(&first, "left"), index_key(&second, "left"));
    assert_eq!(index_key(&first, "right"), index_key(&second, "right"));
    assert_eq!(buffer(&first, "volumes of right").1, buffer(&second, "volumes of right").1);
}

#[test]
fn a_moved_caster_is_extracted_alone() {
    let mut yard = Yard::new();
    let (first, _) = yard.frame(&request());
    yard.shift(yard.boxes[1]);
    let (second, computed) = yard.frame(&request());
    assert_eq!(computed, 1 + 2 * computed_for(1), "its pose, and once for each light");
    for light in ["left", "right"] {
        assert_ne!(index_key(&first, light), index_key(&second, light));
    }
}

#[test]
fn what_only_looks_different_extracts_nothing() {
    let mut yard = Yard::new();
    yard.frame(&request());
    // Colour and intensity cast no shadows; a group in between moves nothing.
    yard.scene.lights().map(|(key, _)| key).collect::<Vec<_>>().into_iter().for_each(|key| {
        yard.scene.light_mut(key).unwrap().intensity = 7.0;
    });
    let group = yard.scene.add_group("group");
    yard.scene.reparent(yard.boxes[0], Some(group)).unwrap();
    let (plan, computed) = yard.frame(&request());
    // The box is now last in the scene's order, so the buffers' order is another; no caster is computed anew.
    assert_eq!(computed, 4, "layers and bytes of two lights: {plan}");
}

#[test]
fn equal_contents_are_one_buffer() {
    let mut scene = shadowed_yard(&[]);
    add_lamp(&mut scene, "twin");
    let plan = plan(&scene, &request());
    let buffers = keys(&plan);
    assert_eq!(buffers.len(), 2, "two lights at one place share indices and records: {plan}");
    assert!(volume_draws(&plan, "lamp").len() == 1 && volume_draws(&plan, "twin").len() == 1);
}
