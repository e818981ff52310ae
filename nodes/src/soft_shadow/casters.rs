//! What casts onto a plane: the casters above it that may shadow something of the receiver.
//!
//! What lies above the plane is found in f64 on the CPU (`above_plane`), and kept until caster or plane move. What reaches
//! beyond the light is left to the clipping of the projected triangle: there its w is negative (see [`clip_from_caster`]).

use std::sync::Arc;

use glam::{DAffine3, DMat4, DVec3, DVec4};
use shadowgraph_engine::math::{Aabb, Plane};
use shadowgraph_engine::scene::{Instance, TexCoord};
use shadowgraph_engine::shadow::{LightContext, PassList, hash_of};

use super::above_plane::AbovePlane;
use super::batches::{Batch, Kind, Run, Runs};
use super::points::LightPoints;
use super::receivers::{Flat, Receiver, height_of};

/// What casts onto one receiver.
#[derive(Clone, Debug, Default)]
pub(super) struct Casters {
    /// The middle of each, from which its corners are counted.
    pub(super) centers: Vec<DVec3>,
    /// The box around each.
    pub(super) bounds: Vec<Aabb>,
    /// Their triangles.
    pub(super) batches: Vec<Batch>,
    /// A hash of all of them: equal keys, equal shadows.
    pub(super) key: u64,
}

impl Casters {
    /// The batches that stop light.
    pub(super) fn opaque(&self) -> impl Iterator<Item = &Batch> {
        self.batches.iter().filter(|batch| batch.kind != Kind::Glass)
    }

    /// The batches that tint light.
    pub(super) fn glass(&self) -> impl Iterator<Item = &Batch> {
        self.batches.iter().filter(|batch| batch.kind == Kind::Glass)
    }

    /// The casters that may shadow something of `receiver`; where it is in view only, if `in_picture`.
    pub(super) fn of(
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        receiver: &Receiver,
        points: &LightPoints,
        in_picture: bool,
    ) -> Self {
        let mut casters = Self::default();
        let mut groups: Vec<Runs> = Vec::new();
        for (_, instance) in light.casters() {
            let number = casters.centers.len() as u32;
            let casts = may_shadow(light, receiver, (points, in_picture), &instance.world_bounds)
                .and_then(|()| add_parts(light, receiver, instance, number, &mut groups));
            match casts {
                Ok(()) => {
                    casters.centers.push(instance.world_bounds.center());
                    casters.bounds.push(instance.world_bounds);
                }
                Err(reason) => out.note(format!(
                    "'{}' on '{}' for '{}': {reason}",
                    instance.name,
                    receiver.name,
                    light.light().name
                )),
            }
        }
        let mut keys = Vec::new();
        for group in groups {
            let (batch, key) = group.upload(light, out, receiver, points);
            casters.batches.push(batch);
            // An image that was changed is another one.
            let image = group.image.and_then(|image| light.snapshot.images.get(&image));
            keys.push((key, image.map(|image| Arc::as_ptr(image) as usize)));
        }
        casters.key = hash_of(keys);
        casters
    }
}

/// Adds what of a caster lies above the receiver's plane to the groups that its materials belong to.
///
/// # Errors
/// The reason why none of it lies above.
fn add_parts(
    light: &LightContext<'_>,
    receiver: &Receiver,
    instance: &Instance,
    caster: u32,
    groups: &mut Vec<Runs>,
) -> Result<(), &'static str> {
    let flat = receiver.flat;
    let plane_bits = flat.plane.normal.extend(flat.plane.offset).to_array();
    let plane_bits = (plane_bits.map(f64::to_bits), flat.tolerance_m.to_bits());
    let mut casts = false;
    for (part, material) in instance.materials.iter().enumerate() {
        let Some(kind) = Kind::of(material) else { continue };
        let texture = material.base_color_texture.filter(|_| kind != Kind::Whole);
        let reading = texture.map(|texture| {
            let rows = texture.transform.rows().map(|row| row.to_array().map(f32::to_bits));
            (texture.tex_coord == TexCoord::Second, rows)
        });
        let key = hash_of((instance.pose_key, part, plane_bits, reading));
        let above = light.cache.get_or_compute("above plane", key, || AbovePlane::new(instance, part, &flat));
        if above.indices.is_empty() {
            continue;
        }
        casts = true;
        let image = texture.map(|texture| texture.image);
        let run = Run {
            caster,
            above,
            key,
            material: Arc::clone(material),
            center: instance.world_bounds.center(),
            bounds: instance.world_bounds.expanded(1e-9 * instance.world_bounds.radius()),
        };
        match groups.iter_mut().find(|group| (group.kind, group.image) == (kind, image)) {
            Some(group) => group.runs.push(run),
            None => groups.push(Runs { kind, image, runs: vec![run] }),
        }
    }
    if casts { Ok(()) } else { Err("lies in the plane or under it") }
}

/// Whether a caster within `bounds` may shadow something of `receiver` in view from some point of the light.
///
/// # Errors
/// The reason why it cannot.
fn may_shadow(
    light: &LightContext<'_>,
    receiver: &Receiver,
    (points, in_picture): (&LightPoints, bool),
    bounds: &Aabb,
) -> Result<(), &'static str> {
    let Flat { plane, tolerance_m } = receiver.flat;
    let corners = bounds.corners();
    if corners.iter().all(|corner| plane.height(*corner) <= tolerance_m) {
        return Err("lies in the plane or under it");
    }
    let above = || points.positions.iter().filter(|point| height_of(&plane, **point) > 0.0);
    if above()
        .all(|point| point.w > 0.0 && corners.iter().all(|c| plane.height(*c) >= height_of(&plane, *point)))
    {
        return Err("lies beyond the light");
    }
    // What it shadows is within range and cone of the centre, and it lies between that and the light.
    if !light.light().may_reach(&bounds.expanded(points.radius_m)) {
        return Err("outside the light's range or cone");
    }
    // What it shadows and the light span a hull, which it must meet: see the engine's own test for lights without size.
    let separates = |plane: &Plane| {
        above().all(|point| height_of(plane, *point) >= 0.0) && corners.iter().all(|c| plane.height(*c) < 0.0)
    };
    if in_picture && light.view.frustum.planes.iter().any(separates) {
        return Err("its shadow misses the view");
    }
    let mut sides = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| {
        let low = Plane { normal: axis, offset: axis.dot(receiver.bounds.min) };
        [low, Plane { normal: -axis, offset: -axis.dot(receiver.bounds.max) }]
    });
    if sides.any(|side| separates(&side)) {
        return Err("its shadow misses the receiver");
    }
    Ok(())
}

/// From a place relative to `center`, along the axes of the world, onto the plane as `light` sees it there, and from
/// there to clip space.
///
/// M = (π·L)·I − L·πᵀ maps a point to where its shadow falls; divided by π·L, the light's height, w is 1 − h/h_L. It is
/// negative for what is farther from the plane than the light. Such shadows are no shadows, and never drawn: z in clip
/// space is a positive multiple of that w (of the eye's distance for orthographic cameras, where w is the same sign as
/// that distance's weight), so z ≥ 0 clips them.
pub(super) fn clip_from_caster(
    clip_from_view: &DMat4,
    view_from_world: &DAffine3,
    (plane, light): (&Plane, DVec4),
    center: DVec3,
) -> DMat4 {
    // In view space, where the eye is the origin: nothing is lost where the picture needs it.
    let normal = view_from_world.transform_vector3(plane.normal);
    let offset = plane.offset - plane.normal.dot(view_from_world.inverse().translation);
    let plane_in_view = normal.extend(-offset);
    let light_in_view = if light.w == 0.0 {
        view_from_world.transform_vector3(light.truncate()).extend(0.0)
    } else {
        view_from_world.transform_point3(light.truncate()).extend(1.0)
    };
    let light_in_view = light_in_view / plane_in_view.dot(light_in_view);
    let flatten = DMat4::from_cols(
        DVec4::X - light_in_view * plane_in_view.x,
        DVec4::Y - light_in_view * plane_in_view.y,
        DVec4::Z - light_in_view * plane_in_view.z,
        DVec4::W - light_in_view * plane_in_view.w,
    );
    *clip_from_view * flatten * DMat4::from(*view_from_world) * DMat4::from_translation(center)
}
