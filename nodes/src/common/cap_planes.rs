//! What lies in a cap's own plane is not in its shadow: how that is told.

use std::sync::Arc;

use shadowgraph_engine::math::Projection;
use shadowgraph_engine::plan::{BufferDesc, Resource};
use shadowgraph_engine::shadow::{LightContext, PassList, hash_of};

use super::coplanar::casters_on_glass;
use super::volume::{CastShape, Half, VolumeIndices};
use super::volume_draws::Volume;

/// How it is told what lies in the plane of a volume's caps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OwnPlane {
    /// Nothing does but the surfaces themselves, which have the very depth of their caps.
    Empty,
    /// By its depth: a cap is moved behind itself, or ahead.
    Depth,
    /// By its plane, at every pixel.
    Planes,
}

impl OwnPlane {
    /// For each of the volumes.
    pub(super) fn of_each<'a>(
        light: &LightContext<'_>,
        volumes: impl Iterator<Item = &'a Volume<'a>>,
    ) -> Vec<Self> {
        let on_glass = light.layer().map(|_| casters_on_glass(light));
        let of_one = |volume: &Volume<'_>| match &on_glass {
            Some(on_glass) => Self::on_layer(light, on_glass.contains(&volume.caster.index)),
            None => Self::on_opaque(light, volume),
        };
        volumes.map(of_one).collect()
    }

    /// Layers of transparent surfaces are lit from behind as well, and next to the fold between two panes less is between them than
    /// depths in one plane differ by: planes tell, where triangles lie in one.
    fn on_layer(light: &LightContext<'_>, lies_on_glass: bool) -> Self {
        match lies_on_glass {
            false => Self::Empty,
            true if light.view.samples == 1 => Self::Planes,
            true => Self::Depth,
        }
    }

    /// Depth tells it of opaque surfaces, but before caps that are in no depth buffer, under an orthographic eye. Next to where the
    /// picture's edges cut a floor, a rasteriser's depth is off by what it changes over half the 1/256 pixel on which corners lie,
    /// which is more than roundings where the view is steep; and a depth bias with that share of the slope loses what a fold's
    /// nearer side casts on the other. (Under a perspective eye neither was found in some ten thousand scenes.)
    ///
    /// In the plane of a far side there may be other surfaces, too; but they are turned away from the light as it is, and dark whatever
    /// is counted. What touches it otherwise, as a floor does at the foot of a wall, is not to be taken for a part of it.
    fn on_opaque(light: &LightContext<'_>, volume: &Volume<'_>) -> Self {
        if volume.half == Half::Unlit {
            return Self::Empty;
        }
        let is_orthographic = matches!(light.view.camera.projection, Projection::Orthographic { .. });
        let is_capped = matches!(volume.caster.shape, CastShape::Capped(_));
        let hidden = volume.hidden_caps_count || volume.falls_on_itself || is_capped;
        if is_orthographic && hidden && light.view.samples == 1 { Self::Planes } else { Self::Depth }
    }
}

/// What caps read whose planes are compared with those of what is seen.
pub(super) struct CapPlanes {
    /// The corners of all caps.
    pub(super) corners: Resource,
    /// For each record: where its caps begin among them; `None` where depth tells what lies in them.
    first: Vec<Option<u32>>,
    /// The planes of what is seen.
    pub(super) seen: Resource,
}

impl CapPlanes {
    /// For volumes with these indices, of which planes tell for some; `None` if for none.
    pub(super) fn new(
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        volumes: &[(OwnPlane, Arc<VolumeIndices>)],
    ) -> Option<Self> {
        let mut corners: Vec<u32> = Vec::new();
        let mut first = Vec::new();
        for (own_plane, indices) in volumes {
            let asks = *own_plane == OwnPlane::Planes;
            first.push(asks.then_some(corners.len() as u32));
            if asks {
                corners.extend(&indices.indices[indices.caps()]);
            }
        }
        if corners.is_empty() {
            return None;
        }
        let bytes: &[u8] = bytemuck::cast_slice(&corners);
        let name = format!("caps of {}", light.light().name);
        let reason = "in which planes caps lie: what is seen there is not in their shadow";
        let (key, contents) = (hash_of(("cap corners", bytes)), Arc::new(bytes.to_vec()));
        let corners = out.buffer(BufferDesc::storage(&name, key, contents, reason));
        Some(Self { corners, first, seen: out.receiver_planes() })
    }

    /// Where the caps of a record begin; `None` where depth tells what lies in them.
    pub(super) fn first(&self, record: u32) -> Option<u32> {
        self.first[record as usize]
    }
}

/// How far front caps lie behind themselves, or ahead, in last digits of the largest depth of a triangle.
///
/// A triangle that lies in a surface's own plane casts nothing on it. Rasterised from other corners, or in another order, the
/// same plane has other depths, by some tens of roundings of the largest depth on it: so a cap counts as before what it is
/// before by more than that. The measures allow for 64; what cap and surface are themselves rounded by must fit in, too. (Of 300
/// scenes of ties and of glass one is wrong with 16, none with 32; with 56 a fold of 4 degrees lost a pixel.) A bias with a share
/// of the slope would hold for steeper views, but a cap and a side that meet at an edge would no longer agree there.
const CAP_BIAS: i32 = 48;

/// The same for orthographic depth: a difference of two numbers up to 1 loses no more at one end of a triangle than at the other.
const ORTHOGRAPHIC_CAP_BIAS: i32 = 24;

/// Where nothing else lies in a cap's plane: enough to be behind itself, or ahead.
const LONE_CAP_BIAS: i32 = 4;

/// How far the caps of a volume are moved.
pub(super) fn cap_bias(projection: &Projection, own_plane: OwnPlane) -> i32 {
    match projection {
        _ if own_plane == OwnPlane::Empty => LONE_CAP_BIAS,
        Projection::Perspective { .. } => CAP_BIAS,
        Projection::Orthographic { .. } => ORTHOGRAPHIC_CAP_BIAS,
    }
}
