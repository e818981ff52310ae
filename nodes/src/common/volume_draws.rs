//! From volumes to draws: the buffers of one light, which runs of indices a view demands, and what each of them counts.

use std::ops::Range;
use std::sync::Arc;

use shadowgraph_engine::geometry::GroupMember;
use shadowgraph_engine::plan::{
    BlendComponent, BlendFactor, BlendOperation, BlendState, BufferDesc, CompareFunction, DrawState,
    Resource, Shader, ShaderError,
};
use shadowgraph_engine::shadow::{Binding, Draw, Geometry, LightContext, PassList, hash_of};

use super::beside_light::CutVertex;
use super::cap_planes::{CapPlanes, OwnPlane, cap_bias};
use super::extrusion::End;
use super::layer_groups::Caster;
use super::volume::{Begin, Half, VolumeIndices, VolumeUniform, Weights};

/// One caster's volume, with everything the view decides about it.
#[derive(Clone, Debug)]
pub struct Volume<'a> {
    /// The caster, with the triangles that cast.
    pub caster: Caster<'a>,
    /// Whether it is counted behind what is seen, not before it.
    pub z_fail: bool,
    /// Whether front caps may lie before what is seen. z-pass needs none where all of the caster is in the depth
    /// buffer; of a single-sided surface only one side is.
    pub hidden_caps_count: bool,
    /// Whether a visible surface may lie in a cap's plane, turned away from the light's centre and yet not dark:
    /// transparent surfaces, and those that see a part of a light with a size. The view leaves the volume at the very
    /// depth of such a surface, which counts as outside.
    pub falls_on_itself: bool,
    /// Where the sides begin through which the view enters it.
    pub begin: Begin,
    /// Where it ends.
    pub end: End,
    /// Whether depths beyond near and far are clamped.
    pub clamp_depth: bool,
    /// Whether the light is a direction.
    pub directional: bool,
    /// Which of the caster's triangles cast.
    pub half: Half,
}

impl Volume<'_> {
    /// The caster's name and what was chosen for it.
    pub fn name(&self) -> String {
        let mode = match self.half {
            Half::Both => "open",
            Half::Lit => "closed",
            Half::Unlit => "closed from its far side",
        };
        let depth_test = if self.z_fail { "z-fail" } else { "z-pass" };
        let end = match self.end {
            End::Infinite => "to infinity",
            End::Plane(_) => "to a plane",
            End::Scaled(_) | End::Reach(_) => "beyond the view",
        };
        format!("{} {mode} {depth_test} {end}", self.caster.instance.name)
    }
}

/// Whether the volumes of a light are to leave alone what lies in their own caps' planes and is turned away from it: see
/// [`Volume::falls_on_itself`].
pub fn falls_on_itself(light: &LightContext<'_>) -> bool {
    light.layer().is_some() || light.has_size()
}

/// Where a volume of `half` a caster's triangles begins: ahead for what may be seen from behind and is not dark for that.
pub fn begin_of(light: &LightContext<'_>, half: Half) -> Begin {
    if half == Half::Unlit || light.layer().is_some() {
        Begin::Ahead
    } else if light.has_size() {
        Begin::AheadOfSlanted
    } else {
        Begin::Behind
    }
}

/// The flag of shaders that draw caps and ask the planes of what is seen; with `AHEAD` they count ahead of themselves.
pub const CAPS: &str = "CAPS";

/// Where shaders find cut vertices.
const CUTS_BINDING: u32 = 4;

/// The buffers of one light's volumes.
pub struct Buffers {
    index_slot: Resource,
    records: Resource,
    /// Vertices that are none of any mesh's, where lamps all but touch casters.
    cuts: Option<Resource>,
    /// For each record: where its indices begin, and their runs.
    indices: Vec<(u32, Arc<VolumeIndices>)>,
    /// For each record: how far caps are moved, in last digits of the largest depth of a triangle.
    cap_bias: Vec<i32>,
    /// What caps ask where planes tell what lies in them.
    caps: Option<CapPlanes>,
}

/// Uploads the indices and records of `groups`, of which every member is a caster's number in `volumes`.
pub fn upload(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    volumes: &[Volume<'_>],
    groups: &[Vec<GroupMember>],
    weights: Weights,
) -> Buffers {
    let position = light.light().position;
    let mut keys = Vec::new();
    let mut indices = Vec::new();
    let mut records: Vec<VolumeUniform> = Vec::new();
    let mut first = 0;
    let mut cuts: Vec<CutVertex> = Vec::new();
    for member in groups.iter().flatten() {
        let volume = &volumes[member.caster];
        let Volume { caster: Caster { index, instance, shape, key, facing }, end, .. } = volume;
        let listed = (weights, volume.begin);
        let key = hash_of((key, &member.triangles, listed, matches!(end, End::Reach(_))));
        let runs = light.cache.get_or_compute("volume indices", key, || {
            let triangles = member.triangles.as_ref().unwrap_or(&facing.cast);
            VolumeIndices::new(instance, shape, facing, triangles, listed, (position, *end))
        });
        records.push(VolumeUniform::new(instance, *index, position, *end, cuts.len() as u32));
        cuts.extend(&runs.cuts);
        keys.push(key);
        let count = runs.indices.len() as u32;
        indices.push((first, runs));
        first += count;
    }
    let name = light.light().name.clone();
    let key = hash_of(("volume indices", &keys));
    let bytes = light.cache.get_or_compute("volume index bytes", key, || {
        let parts: Vec<&[u8]> =
            indices.iter().map(|(_, runs)| bytemuck::cast_slice::<u32, u8>(&runs.indices)).collect();
        parts.concat()
    });
    let edges: usize = indices.iter().map(|(_, runs)| runs.silhouette_edges).sum();
    let reason = format!("{edges} silhouette edges, and the caps for views that need them");
    let index_slot = out.buffer(BufferDesc::index(&format!("volume indices of {name}"), key, bytes, &reason));
    let bytes: &[u8] = bytemuck::cast_slice(&records);
    let key = hash_of(("volumes", bytes));
    let records = out.buffer(BufferDesc::storage(
        &format!("volumes of {name}"),
        key,
        Arc::new(bytes.to_vec()),
        "where the light is, as each caster sees it, and where its volume ends",
    ));
    let cuts = (!cuts.is_empty()).then(|| {
        let bytes: &[u8] = bytemuck::cast_slice(&cuts);
        let reason =
            format!("{} places where edges and faces are cut that the light all but touches", cuts.len());
        let (key, contents) = (hash_of(("cut vertices", bytes)), Arc::new(bytes.to_vec()));
        out.buffer(BufferDesc::storage(&format!("cut vertices of {name}"), key, contents, &reason))
    });
    let own_planes = OwnPlane::of_each(light, groups.iter().flatten().map(|member| &volumes[member.caster]));
    let own_planes: Vec<_> =
        own_planes.into_iter().zip(&indices).map(|(own, (_, runs))| (own, Arc::clone(runs))).collect();
    let cap_bias = own_planes.iter().map(|(own, _)| cap_bias(&light.view.camera.projection, *own)).collect();
    let caps = CapPlanes::new(light, out, &own_planes);
    Buffers { index_slot, records, cuts, indices, cap_bias, caps }
}

/// Neighbouring indices that count alike.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The first index.
    pub start: u32,
    /// The index after the last.
    pub end: u32,
    /// How they count.
    pub how: How,
}

/// How the faces of a run count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct How {
    /// What a face counts that enters a volume; negative when the triangles are wound against the chain.
    pub weight: i32,
    /// Which of them count.
    pub faces: Faces,
    /// Where front caps are drawn; `None` for sides and far caps.
    pub caps: Option<Caps>,
}

impl How {
    /// Which faces count, as triangles are wound: `Some(true)` those that face the eye, `Some(false)` the others.
    pub fn front_faces(&self) -> Option<bool> {
        match self.faces {
            Faces::Both => None,
            Faces::Entering => Some(self.weight >= 0),
            Faces::Leaving => Some(self.weight < 0),
        }
    }

    fn both(weight: i32) -> Self {
        Self { weight, faces: Faces::Both, caps: None }
    }

    fn caps(weight: i32) -> Self {
        Self { caps: Some(Caps::Behind), ..Self::both(weight) }
    }

    /// See [`DrawState::depth_bias`].
    pub fn depth_bias(&self, cap_bias: i32) -> i32 {
        match self.caps {
            None => 0,
            Some(Caps::Behind) => -cap_bias,
            Some(Caps::Ahead) => cap_bias,
        }
    }
}

/// Where caps are drawn, by what depth cannot tell apart: what lies in a cap's own plane is never in its shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Caps {
    /// A little behind: the view has not yet entered the volume where it sees a surface in a cap's plane.
    Behind,
    /// A little ahead: there it has left the volume.
    Ahead,
}

/// The faces of a volume that a draw counts, by what the view does there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Faces {
    /// All.
    Both,
    /// Where the view enters a volume.
    Entering,
    /// Where it leaves one.
    Leaving,
}

/// The runs of a volume that its depth test and end demand, neighbours joined.
pub fn runs(volume: &Volume<'_>, indices: &VolumeIndices) -> Vec<Run> {
    let meets_at_infinity = volume.directional && volume.end == End::Infinite;
    let mut wanted = Vec::new();
    for side in &indices.sides {
        let how = How::both(side.weight as i32);
        // What is seen of a far side lies right behind the sides through which the view enters: they begin before it. So do
        // those of what is seen from behind and not dark, which the view leaves through a cap that is moved ahead. (A
        // side taken to be before what it touches only adds to a count there: it cannot cancel another's, and a move of
        // the receiver by the ambiguity band's ulps would put it in the volume.)
        let begins_ahead = !side.ahead.is_empty();
        let how = if begins_ahead { How { faces: Faces::Leaving, ..how } } else { how };
        wanted.push((&side.near, how));
        if !meets_at_infinity {
            wanted.push((&side.far, how));
        }
        if begins_ahead {
            wanted.push((&side.ahead, How { faces: Faces::Entering, ..how }));
        }
    }
    if volume.z_fail && !meets_at_infinity {
        wanted.push((&indices.far_caps, How::both(1)));
    }
    let front_caps = [(&indices.front_caps, How::caps(1)), (&indices.front_caps_turned, How::caps(-1))];
    if volume.half == Half::Unlit {
        // The far side of the caster itself is not to be in its shadow: there the view leaves the volume at the very
        // depth of what it sees. Where it enters through a cap, the cap is not seen, and depth needs no care.
        let leaving = |how| How { faces: Faces::Leaving, caps: Some(Caps::Ahead), ..how };
        wanted.extend(front_caps.map(|(run, how)| (run, leaving(how))));
        if volume.z_fail {
            wanted.extend(front_caps.map(|(run, how)| (run, How { faces: Faces::Entering, ..how })));
        }
    } else if volume.falls_on_itself {
        wanted.extend(front_caps.into_iter().flat_map(entered_and_left));
    } else if volume.z_fail || volume.hidden_caps_count {
        wanted.extend(front_caps);
    }
    let unseen = [(&indices.unseen_caps, How::caps(1)), (&indices.unseen_caps_turned, How::caps(-1))];
    if volume.falls_on_itself {
        wanted.extend(unseen.into_iter().flat_map(entered_and_left));
    } else {
        wanted.extend(unseen);
    }
    let mut joined: Vec<Run> = Vec::new();
    for (range, how) in wanted {
        match joined.last_mut() {
            Some(last) if last.end == range.start && last.how == how => last.end = range.end,
            _ => joined.push(Run { start: range.start, end: range.end, how }),
        }
    }
    joined.retain(|run| run.start < run.end);
    joined
}

/// Caps by which the view enters a volume, behind themselves; and those by which it leaves one, ahead.
fn entered_and_left((run, how): (&Range<u32>, How)) -> [(&Range<u32>, How); 2] {
    let left = How { faces: Faces::Leaving, caps: Some(Caps::Ahead), ..how };
    [(run, How { faces: Faces::Entering, ..how }), (run, left)]
}

/// The draws of one volume, each with the shader (of these flags) and state that `counting` says for how it counts.
///
/// # Errors
/// What is wrong with a shader.
pub fn volume_draws(
    volume: &Volume<'_>,
    record: u32,
    buffers: &Buffers,
    counting: impl Fn(How, &[&str]) -> Result<(Shader, DrawState), ShaderError>,
) -> Result<Vec<Draw>, ShaderError> {
    let cut_edges = buffers.cuts.is_some().then_some("CUT_EDGES");
    let cuts = buffers.cuts.map(|cuts| (CUTS_BINDING, Binding::Storage(cuts)));
    let bindings: Vec<_> = [(1, Binding::Storage(buffers.records))].into_iter().chain(cuts).collect();
    let (first, indices) = &buffers.indices[record as usize];
    let draw = |run: Run| {
        let mut bindings = bindings.clone();
        let mut flags: Vec<&str> = cut_edges.into_iter().collect();
        let caps = buffers.caps.as_ref().filter(|_| run.how.caps.is_some());
        let caps = caps.and_then(|caps| Some((caps, caps.first(record)?)));
        if caps.is_some() {
            flags.push(CAPS);
            flags.extend((run.how.caps == Some(Caps::Ahead)).then_some("AHEAD"));
        }
        let (shader, mut state) = counting(run.how, &flags)?;
        state.depth_clamp = volume.clamp_depth;
        let (instance, count) = (volume.caster.index as u32, run.end - run.start);
        let geometry = if let Some((caps, first)) = caps {
            bindings.push((5, Binding::Texture(caps.seen)));
            bindings.push((6, Binding::Storage(caps.corners)));
            let first = first + run.start - indices.caps().start as u32;
            Geometry::Numbered { shader, instance, first, count, record }
        } else {
            state.depth_bias = run.how.depth_bias(buffers.cap_bias[record as usize]);
            let (indices, first) = (buffers.index_slot, first + run.start);
            Geometry::Indexed { shader, instance, indices, first, count, record }
        };
        Ok(Draw::new(volume.name(), geometry, state).reading(bindings))
    };
    runs(volume, indices).into_iter().map(draw).collect()
}

/// Adds to a float target: the shader says +1 for a front face and −1 for a back face, the blend constant how much it
/// weighs. Blending knows no operation for fragments that fail the depth test, so z-fail has the inverse comparison.
pub fn float_state(z_fail: bool, how: How) -> DrawState {
    let add = BlendComponent {
        src_factor: BlendFactor::Constant,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    };
    let compare = if z_fail { CompareFunction::LessEqual } else { CompareFunction::Greater };
    let mut state = DrawState::new(compare, vec![Some(BlendState { color: add, alpha: add })]);
    state.blend_constant = [f64::from(if z_fail { -how.weight } else { how.weight }); 4];
    state
}
