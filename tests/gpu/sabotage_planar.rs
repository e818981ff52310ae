//! `SoftShadow` broken on purpose, drawn in the picture and in textures: conformance turns red.

use std::sync::Arc;

use crate::broken::{PlanOf, Spoil};
use crate::slips::{each_turns_red, slips};
use glam::DVec3;
use shadowgraph::engine::plan::{Access, CompareFunction, Load};
use shadowgraph::engine::scene::Instance;
use shadowgraph::engine::shadow::{Draw, Pass, ShadowTechnique};
use shadowgraph::prelude::*;

/// Whether a pass marks the points that casters hide.
fn marks(pass: &Pass) -> bool {
    pass.name.starts_with("shadows on ")
}

/// A point of the light marks nothing.
const LOST_POINT: Spoil = Spoil::Draws(|draw| {
    if draw.name == "point 3" {
        draw.state.targets = vec![None];
    }
});

/// The bit of the first point is left over from something else.
const UNCLEARED_BIT: Spoil = Spoil::Passes(|pass| {
    if marks(pass) {
        pass.colors[0].load = Load::Clear([1.0 / 255.0, 0.0, 0.0, 0.0]);
    }
});

/// Every fourth point marks nothing: of textures a single one is less than what they owe.
const LOST_POINTS: Spoil = Spoil::Draws(|draw| {
    let number = draw.name.strip_prefix("point ").and_then(|number| number.parse::<u32>().ok());
    if number.is_some_and(|number| number % 4 == 3) {
        draw.state.targets = vec![None];
    }
});

/// Half of all bits are left over from something else.
const UNCLEARED_BITS: Spoil = Spoil::Passes(|pass| {
    if marks(pass) {
        pass.colors[0].load = Load::Clear([15.0 / 255.0; 4]);
    }
});

/// A point marks a pixel once for every layer of a caster.
fn mark_again(draw: &mut Draw) {
    if let (true, Some(stencil)) = (draw.name.starts_with("point "), &mut draw.state.stencil) {
        stencil.front.compare = CompareFunction::Always;
        stencil.back.compare = CompareFunction::Always;
    }
}

/// The points of the ball all count the same.
const UNWEIGHED: Spoil = Spoil::Text("w = weight(point * seen.rim, seen.towards, seen.rim);", "w = 1.0;");
/// What of the light is under the plane counts as light.
const NO_HORIZON: Spoil = Spoil::Text("select(w * point.w, 0.0, is_shadowed)", "select(w, 0.0, is_shadowed)");
/// What is behind the light throws its shadow the other way.
const MIRRORED: Spoil = Spoil::Text(
    "out.clip = clip_from_caster[first_caster + bitcast<u32>(corner.w)] * vec4f(corner.xyz, 1.0);",
    "let once = clip_from_caster[first_caster + bitcast<u32>(corner.w)] * vec4f(corner.xyz, 1.0);
     out.clip = select(-once, once, once.z >= 0.0);",
);
/// A light without size in its place.
const HARD: Spoil = Spoil::Plan(|_, light, out| {
    SoftShadow { radius_m: 0.0, angle_deg: 0.0, ..SoftShadow::default() }.plan(light, out)
});

/// Casters are not cut at the floor, y = 0: what lies under it throws its shadow up. A projection does the same to a corner
/// under the floor as to one just over the place on the floor that the light sees it behind.
const UNCUT: PlanOf = |technique, light, out| {
    let lamp = light.light().position.truncate();
    let raised = |instance: &Instance| {
        let world_from_local = instance.world_from_local;
        let corner = |p: &Vec3| {
            let p = world_from_local.transform_point3(p.as_dvec3());
            if p.y >= 0.0 {
                return p.as_vec3();
            }
            let on_floor = p.lerp(lamp, p.y / (p.y - lamp.y));
            on_floor.lerp(lamp, 1e-3).as_vec3()
        };
        let data = instance.mesh.data();
        let positions = data.positions.iter().map(corner).collect();
        let mesh = Mesh::new(MeshData { positions, ..data.clone() }).unwrap();
        Instance {
            mesh: Arc::new(mesh),
            world_from_local: DAffine3::IDENTITY,
            pose_key: instance.pose_key + 1,
            world_bounds: instance.world_bounds.union(&shadowgraph::engine::math::Aabb::from_points([
                DVec3::new(-1.0, 0.0, -1.0),
                DVec3::new(1.0, 1.0, 1.0),
            ])),
            ..instance.clone()
        }
    };
    let mut snapshot = light.snapshot.clone();
    for instance in snapshot.instances.iter_mut().filter(|instance| instance.name != "floor") {
        *instance = raised(instance);
    }
    // A plan holds on to its scene for good, so the changed one is never dropped.
    let mut light = *light;
    light.snapshot = Box::leak(Box::new(snapshot));
    technique.plan(&light, out)
};

#[test]
fn direct() {
    let slips = slips!(SoftShadow::ENTRY;
        "a point that hides nothing", "penumbra-width/middle": LOST_POINT;
        "a bit left over", "penumbra-width/middle": UNCLEARED_BIT;
        "double darkening", "penumbra-width/middle": Spoil::Draws(mark_again);
        "double darkening", "planar-overlap/lamp": Spoil::Draws(mark_again);
        "the horizon left out", "planar-no-caster/lamp": NO_HORIZON;
        "shadows of what is behind the light", "planar-crossing/leaf": MIRRORED;
        "casters not cut at the plane", "planar-below/under": Spoil::Plan(UNCUT);
        "a light without size", "penumbra-width/middle": HARD;
    );
    each_turns_red(SoftShadow::ENTRY, "direct 16", &slips);
}

/// Sixteen points are too few to tell how each of them weighs.
#[test]
fn direct_with_many_points() {
    let slips = slips!(SoftShadow::ENTRY;
        "the ball's weights left out", "receiver-inside-light": UNWEIGHED;
        "the ball's weights left out", "planar-no-caster/lamp": UNWEIGHED;
    );
    each_turns_red(SoftShadow::ENTRY, "direct 256", &slips);
}

#[test]
fn texture() {
    let slips = slips!(SoftShadow::ENTRY;
        "points that hide nothing", "edge-through-centre/lamp": LOST_POINTS;
        "bits left over", "edge-through-centre/lamp": UNCLEARED_BITS;
        "double darkening", "planar-overlap/lamp": Spoil::Draws(mark_again);
        "nothing marked as the receiver's", "planar-below/under": Spoil::Passes(|pass| {
            if let (true, Some(depth)) = (marks(pass), &mut pass.depth) {
                depth.stencil = Some(Access::Clear(0.0));
            }
        });
        "half of a texture", "edge-through-centre/lamp": Spoil::Text(
            "clamp(floor(texel), vec2f(0.0), vec2f(size) - 1.0)",
            "clamp(floor(texel), vec2f(0.0), vec2f(size) * 0.5)",
        );
        "the horizon left out", "planar-no-caster/lamp": NO_HORIZON;
        "shadows of what is behind the light", "planar-crossing/leaf": MIRRORED;
        "casters not cut at the plane", "planar-below/under": Spoil::Plan(UNCUT);
        "a light without size", "edge-through-centre/lamp": HARD;
    );
    each_turns_red(SoftShadow::ENTRY, "default", &slips);
}
