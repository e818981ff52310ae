//! Shadow volumes as they were before paper 002 §3.2: right for closed casters, and for no others.
//!
//! A silhouette is an edge of two triangles of which one faces the light; volumes have sides from these and no others. Where a
//! mesh ends, its volume is left open. Fig. 3 shows what comes of that, and it is drawn here to be measured, not to be used:
//! no catalog but this chapter's has it. Volumes are counted from the eye (z-pass), which must be outside of them; what was
//! entered and left unequally often is dark.

use std::fmt;
use std::sync::Arc;

use glam::{DMat4, DVec4};
use shadowgraph_engine::geometry::facing_signs;
use shadowgraph_engine::plan::{
    BufferDesc, CompareFunction, DrawState, STENCIL_AT_REST, Shader, Stencil, StencilFaceState,
    StencilOperation,
};
use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{
    Binding, Contribution, DepthTarget, Draw, Geometry, LightContext, OptionTable, Pass, PassList,
    ShadowError, ShadowTechnique, TechniqueEntry, Traits, hash_of,
};

/// How the chapter's catalog knows it.
pub(super) const ENTRY: TechniqueEntry = TechniqueEntry {
    type_name: "UnmodifiedVolumes",
    short_name: "unmodified",
    summary: "shadow volumes of closed casters, without paper 002's modification for open ones",
    from_params: |_| Ok(Arc::new(UnmodifiedVolumes)),
    options: OptionTable::none,
    settings: &[],
};

/// The sides in view space, six corners each; those at infinity have w = 0.
const SHADER: &str = "
#import common/frame
#import common/fullscreen

@group(1) @binding(0) var<storage, read> corners: array<vec4f>;

@vertex
fn side(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return frame.clip_from_view * corners[index];
}
";

/// How far sides lie behind the caster that they hang from, in roundings of depth: what is lit beside them is before them.
const BEHIND: i32 = -64;
/// The most volumes that are told apart: counts below rest are found by the bits below this.
const MOST: u32 = 31;

struct UnmodifiedVolumes;

impl fmt::Debug for UnmodifiedVolumes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("UnmodifiedVolumes")
    }
}

impl ShadowTechnique for UnmodifiedVolumes {
    fn params(&self) -> Params {
        Params::new()
    }

    fn traits(&self) -> Traits {
        Traits { known_error: "the shadows of open casters", ..Traits::default() }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        Ok(instance.blocks_light())
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        let view_from_world = DMat4::from(light.view.camera.world_from_view.inverse());
        let position = light.light().position;
        let sides = light.casters().flat_map(|(_, instance)| sides(instance, position));
        let corners: Vec<[f32; 4]> =
            sides.flatten().map(|corner| (view_from_world * corner).as_vec4().to_array()).collect();
        if corners.is_empty() {
            return Ok(Contribution::default());
        }
        let name = &light.light().name;
        let bytes: Vec<u8> = corners.iter().flatten().flat_map(|value| value.to_ne_bytes()).collect();
        let key = hash_of((ENTRY.type_name, &bytes));
        let buffer = BufferDesc::storage("unmodified sides", key, Arc::new(bytes), "sides of silhouettes");
        let buffer = out.buffer(buffer);
        let shader = |vertex| Shader::written(ENTRY.type_name, SHADER, &[], vertex, None);
        let vertices = corners.len() as u32;
        let geometry = Geometry::Procedural { shader: shader("side")?, vertices, instances: 1 };
        let count = Draw::new("sides", geometry, counting()).reading(vec![(0, Binding::Storage(buffer))]);
        let fold = Draw::new("unequal", Geometry::fullscreen(shader("fullscreen_vertex")?), unequal());
        out.pass(Pass {
            name: format!("unmodified volumes of {name}"),
            reason: "sides from silhouettes between two triangles only".into(),
            colors: vec![],
            depth: Some(DepthTarget::COUNT),
            draws: vec![count, fold],
        });
        Ok(Contribution::counts(MOST))
    }
}

/// The corners of the sides of a caster's silhouettes: of edges with two triangles that run along it opposite ways, of which
/// one faces the light.
fn sides(instance: &Instance, light: DVec4) -> Vec<[DVec4; 6]> {
    let topology = instance.mesh.topology();
    let p_in_world: Vec<_> =
        (0..instance.mesh.positions().len() as u32).map(|vertex| instance.world_position(vertex)).collect();
    let signs = facing_signs(&p_in_world, topology.triangles(), light);
    let side = |(index, edge): (usize, &shadowgraph_engine::geometry::Edge)| {
        let [a, b] = topology.uses(index) else { return None };
        let facing = [a, b].map(|using| signs[using.triangle as usize] > 0);
        if a.sigma == b.sigma || facing[0] == facing[1] {
            return None;
        }
        let lit = if facing[0] { a } else { b };
        let [p, q] = if lit.sigma > 0 { [edge.p, edge.q] } else { [edge.q, edge.p] };
        let [p, q] = [p, q].map(|vertex| p_in_world[vertex as usize].extend(1.0));
        let far = |corner: DVec4| (corner * light.w - light).truncate().extend(0.0);
        Some([q, p, far(p), q, far(p), far(q)])
    };
    topology.edges().iter().enumerate().filter_map(side).collect()
}

/// +1 where the view enters before the surface, −1 where it leaves.
fn counting() -> DrawState {
    let face = |pass_op| StencilFaceState {
        compare: CompareFunction::Always,
        fail_op: StencilOperation::Keep,
        depth_fail_op: StencilOperation::Keep,
        pass_op,
    };
    let mut state = DrawState::new(CompareFunction::Greater, vec![]);
    state.depth_bias = BEHIND;
    state.stencil = Some(Stencil {
        front: face(StencilOperation::IncrementWrap),
        back: face(StencilOperation::DecrementWrap),
        read_mask: 0xff,
        write_mask: 0xff,
        reference: 0,
    });
    state
}

/// What was left more often than entered is dark as well: below rest, it goes far above.
fn unequal() -> DrawState {
    let face = StencilFaceState {
        compare: CompareFunction::Greater,
        fail_op: StencilOperation::Keep,
        depth_fail_op: StencilOperation::Keep,
        pass_op: StencilOperation::Replace,
    };
    let mut state = DrawState::new(CompareFunction::Always, vec![]);
    // Read are the bits up to that of rest, so that the reference is rest where it is compared and more where it is written.
    let (read_mask, reference) = (2 * STENCIL_AT_REST - 1, 3 * STENCIL_AT_REST);
    state.stencil = Some(Stencil { front: face, back: face, read_mask, write_mask: 0xff, reference });
    state
}
