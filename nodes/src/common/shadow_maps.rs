//! The maps of one light: drawn once and kept, and what a shader needs to ask them (common/shadow_maps.wgsl).

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use glam::{DAffine3, DVec4};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::plan::{
    Access, BufferDesc, DrawState, Lifetime, Load, Resource, Shader, TextureDesc, TextureFormat,
};
use shadowgraph_engine::shadow::{
    Binding, ColorTarget, DepthTarget, Draw, Geometry, LightContext, Pass, PassList, ShadowError, hash_of,
};

use super::extrusion::end_in_view;
use super::light_views::{
    CasterBox, Depth, LightView, MapSize, axes_towards, directional_view, narrow_view, point_views,
    seen_corners, seen_range, splits, spot_opening, spot_views,
};
use super::map_casters::{CasterBuffers, MATRICES, MapCaster, bounds_along};
use super::ray_candidates::Layout;
use super::screen_bounds::{united, volume_pixels};
use crate::layout;

/// `struct MapView` of common/shadow_maps.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct MapViewRecord {
    pub texel_x: [f32; 4],
    pub texel_y: [f32; 4],
    pub depth: [f32; 4],
    pub w: [f32; 4],
    pub plane_x: [f32; 4],
    pub plane_y: [f32; 4],
    pub plane_depth: [f32; 4],
    pub texels_per_m: f32,
    pub depth_per_m: f32,
    pub relative_loss: f32,
    pub absolute_loss: f32,
    pub position_loss_m: f32,
    pub end_m: f32,
    pub blend_m: f32,
    pub layer: u32,
}

/// The head of `struct ShadowMaps` of common/shadow_maps.wgsl, which its views follow.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct ShadowMapsRecord {
    pub light: [f32; 4],
    pub world_x: [f32; 4],
    pub world_y: [f32; 4],
    pub world_z: [f32; 4],
    pub texels: u32,
    pub view_count: u32,
    pub constant_m: f32,
    pub slope_texels: f32,
    pub normal_texels: f32,
    pub pad_0: u32,
    pub pad_1: u32,
    pub pad_2: u32,
}

/// The structures of common/shadow_maps.wgsl as they are here: what the layout test compares.
pub fn layouts() -> [(&'static str, Layout); 2] {
    let view = layout!(MapViewRecord: texel_x, texel_y, depth, w, plane_x, plane_y, plane_depth, texels_per_m,
        depth_per_m, relative_loss, absolute_loss, position_loss_m, end_m, blend_m, layer);
    let mut maps = layout!(ShadowMapsRecord: light, world_x, world_y, world_z, texels, view_count, constant_m,
        slope_texels, normal_texels, pad_0, pad_1, pad_2);
    // A runtime-sized array counts as one element.
    maps.0.push(("views", maps.1));
    maps.1 += size_of::<MapViewRecord>();
    [("MapView", view), ("ShadowMaps", maps)]
}

/// No layer of the maps: nothing casts there.
const NO_LAYER: u32 = u32::MAX;
/// Roundings that a rasteriser loses of a depth: a dozen and more.
const DEPTH_ROUNDINGS: f64 = 16.0 / (1 << 24) as f64;
/// And f32 of a caster's positions, as a share of its size.
const POSITION_ROUNDINGS: f64 = 4.0 / (1 << 24) as f64;
/// The share of a cascade on which the next one is blended in.
const BLENDED: f64 = 0.1;

/// Biases that somebody has set, in place of asking both planes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Biases {
    /// Along the light, in metres.
    pub constant_m: f64,
    /// Texels times the tangent of the angle between the light and the surface's normal.
    pub slope_texels: f64,
    /// Texels along the surface's normal.
    pub normal_texels: f64,
}

/// One layer and when it is asked.
#[derive(Clone, Copy, Debug)]
struct MapView {
    view: Option<LightView>,
    /// How far along the eye's view it is used, and on how much of that the next one as well.
    end_m: f64,
    blend_m: f64,
}

/// What a light sees, layer by layer.
#[derive(Clone, Debug)]
pub struct MapViews {
    views: Vec<MapView>,
    size: MapSize,
    /// Six, in the order of the axes.
    around: bool,
}

impl MapViews {
    /// The views in which `casters` can shadow something that is in view of the eye (for a directional light, in `cascades`), or
    /// anywhere (for others).
    pub fn new(light: &LightContext<'_>, casters: &[MapCaster<'_>], size: MapSize, cascades: u32) -> Self {
        let position = light.light().position;
        if position.w == 0.0 {
            return Self::directional(light, casters, size, cascades);
        }
        let boxes: Vec<CasterBox> = casters.iter().map(MapCaster::bounds).collect();
        let receivers = light.snapshot.instances.iter().filter(|instance| instance.shadow.receives);
        let receivers = receivers.fold(Aabb::EMPTY, |all, instance| all.union(&instance.world_bounds));
        let is_point = !matches!(light.light().light.kind, shadowgraph_engine::scene::LightKind::Spot { .. });
        let origin = position.truncate();
        let narrow = if is_point { narrow_view(origin, &boxes, &receivers, size) } else { None };
        let around = narrow.is_none() && (is_point || spot_opening(light.light()).is_none());
        let views = match narrow {
            Some(view) => vec![view],
            None if is_point => point_views(origin, &boxes, &receivers, size).to_vec(),
            None => spot_views(light.light(), &boxes, &receivers, size),
        };
        let whole = |view| MapView { view, end_m: f64::INFINITY, blend_m: 0.0 };
        Self { views: views.into_iter().map(whole).collect(), size, around }
    }

    fn directional(
        light: &LightContext<'_>,
        casters: &[MapCaster<'_>],
        size: MapSize,
        cascades: u32,
    ) -> Self {
        let axes = axes_towards(light.light().position.truncate());
        let along = |bounds: Aabb| Aabb::from_points(bounds.corners().map(|corner| axes * corner));
        let boxes = casters.iter().map(|caster| CasterBox {
            whole: bounds_along(light, caster.instance, &axes),
            shadows: caster.shadows.map(along),
        });
        let boxes: Vec<CasterBox> = boxes.collect();
        let top_within = |number: usize, view: &LightView| {
            casters[number].top_m(light, view).unwrap_or(boxes[number].whole.max.z)
        };
        let bounds = &light.view.receiver_bounds;
        let Some([nearest_m, farthest_m]) = seen_range(light.view, bounds) else {
            return Self { views: Vec::new(), size, around: false };
        };
        let ends = splits([nearest_m, farthest_m], cascades, light.view.frustum.eye.w > 0.0);
        let mut from_m = f64::NEG_INFINITY;
        let mut views = Vec::new();
        for (number, end_m) in ends.iter().enumerate() {
            let is_last = number + 1 == ends.len();
            let begin_m = if number == 0 { nearest_m } else { ends[number - 1] };
            let blend_m = if is_last { 0.0 } else { BLENDED * (end_m - begin_m) };
            let to_m = if is_last { f64::INFINITY } else { *end_m };
            let corners = seen_corners(light.view, bounds, [from_m, to_m]);
            let corners: Vec<_> = corners.into_iter().map(|corner| axes * corner).collect();
            views.push(MapView {
                view: directional_view(axes, &boxes, top_within, &corners, size),
                end_m: to_m,
                blend_m,
            });
            from_m = end_m - blend_m;
        }
        Self { views, size, around: false }
    }

    /// The flags under which common/shadow_maps asks them.
    pub fn flags(&self) -> Vec<&'static str> {
        let perspective = |view: &MapView| view.view.is_some_and(|view| view.is_perspective());
        let wanted = [
            ("POINT", self.around),
            ("CASCADES", self.has_cascades()),
            ("PERSPECTIVE", self.views.iter().any(perspective)),
        ];
        wanted.into_iter().filter(|(_, wanted)| *wanted).map(|(flag, _)| flag).collect()
    }

    /// Whether there is one behind the other, as the eye sees.
    pub fn has_cascades(&self) -> bool {
        !self.around && self.views.len() > 1
    }

    /// Whether something is seen in any of them.
    pub fn is_empty(&self) -> bool {
        self.views.iter().all(|view| view.view.is_none())
    }
}

/// The maps of a light, drawn.
#[derive(Clone, Debug)]
pub struct ShadowMaps {
    /// Depth, a layer for each view that shows something.
    pub depths: Resource,
    /// How depth changes; none where biases are set.
    pub slopes: Option<Resource>,
    /// What common/shadow_maps reads at binding 0.
    pub records: Resource,
    /// A hash of everything the maps depend on.
    pub key: u64,
    /// The views that have layers, in their order.
    pub layers: Vec<LightView>,
    /// Where each of them is among the records.
    numbers: Vec<u32>,
    /// The pixels of the picture on which their casters' shadows may fall.
    pixels: Vec<[u32; 4]>,
}

impl ShadowMaps {
    /// Adds the passes that draw the maps, which run again only when a light, a caster or a window has changed; `None` where nothing
    /// is drawn.
    ///
    /// # Errors
    /// What is wrong with a shader.
    pub fn new(
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        casters: &CasterBuffers<'_>,
        views: &MapViews,
        biases: Option<Biases>,
    ) -> Result<Option<Self>, ShadowError> {
        let texels = views.size.texels;
        let with_slopes = biases.is_none();
        let (mut matrices, mut drawn, mut layers) = (Vec::new(), Vec::new(), Vec::new());
        let (mut records, mut numbers, mut pixels) = (Vec::new(), Vec::new(), Vec::new());
        for view in &views.views {
            let mut record = MapViewRecord { layer: NO_LAYER, texels_per_m: 1.0, ..Default::default() };
            (record.end_m, record.blend_m) =
                (view.end_m.min(f64::from(f32::MAX)) as f32, view.blend_m as f32);
            if let Some(seen) = view.view {
                let draws = casters.draws((light, &mut *out), (&seen, texels), with_slopes, &mut matrices)?;
                if !draws.is_empty() {
                    fill(&mut record, &seen, light, texels, casters.largest_m(&seen));
                    record.layer = layers.len() as u32;
                    layers.push(seen);
                    drawn.push(draws);
                    numbers.push(records.len() as u32);
                    pixels.push(shadowed_pixels(light, casters, &seen, views.size));
                }
            }
            records.push(record);
        }
        if layers.is_empty() {
            return Ok(None);
        }
        let key = hash_of((
            casters.key,
            layers.iter().map(LightView::bits).collect::<Vec<_>>(),
            texels,
            with_slopes,
        ));
        let name = light.light().name.clone();
        let mut texture = |what: &str, format, reason: &str| {
            let label = format!("{what} of {name}");
            out.texture(TextureDesc {
                layers: layers.len() as u32,
                lifetime: Lifetime::Kept(key),
                ..TextureDesc::new(&label, format, [texels; 2], reason)
            })
        };
        let reason = "how far the light sees, kept until something moves that it sees";
        let depths = texture("map", TextureFormat::Depth32Float, reason);
        let reason = "the plane of what the light sees, by which nothing shadows itself";
        let slopes = with_slopes.then(|| texture("map slopes", TextureFormat::Rg16Float, reason));
        // On transparent layers too the maps are those that were drawn for the opaque surfaces.
        if light.layer().is_none() {
            let passes =
                drawn.into_iter().zip(&layers).map(|(draws, view)| (draws, view.description(texels)));
            draw_maps(out, &name, (depths, slopes), &matrices, passes);
        }
        let records = upload(light, out, texels, biases.unwrap_or_default(), &records);
        Ok(Some(Self { depths, slopes, records, key, layers, numbers, pixels }))
    }

    /// Draws over the picture by a shader whose vertices are `asking` of common/shadow_maps, and which reads `bindings`: one for each
    /// view, where its shadows may fall; for cascades one for all.
    pub fn look_up(
        &self,
        out: &mut PassList<'_>,
        (shader, state): (&Shader, &DrawState),
        bindings: &[(u32, Binding)],
        cascades: bool,
    ) -> Vec<Draw> {
        let corners: Vec<u8> = [0_u32, 1, 2].iter().flat_map(|index| index.to_ne_bytes()).collect();
        let key = hash_of(("corners", &corners));
        let reason = "three corners around the picture";
        let indices = out.buffer(BufferDesc::index("corners", key, Arc::new(corners), reason));
        let draw = |record: u32, pixels: Option<[u32; 4]>| {
            let shader = shader.clone();
            let geometry = Geometry::IndexedProcedural { shader, indices, first: 0, count: 3, record };
            let draw = Draw::new("look up", geometry, state.clone()).reading(bindings.to_vec());
            Draw { scissor_px: pixels, ..draw }
        };
        if cascades {
            let pixels = self.pixels.iter().fold(None, |all, pixels| united(all, Some(*pixels)));
            return vec![draw(0, pixels)];
        }
        self.numbers.iter().zip(&self.pixels).map(|(number, pixels)| draw(*number, Some(*pixels))).collect()
    }

    /// What common/shadow_maps reads, with the receivers.
    pub fn bindings(&self, out: &PassList<'_>) -> Vec<(u32, Binding)> {
        let mut bindings = vec![(0, Binding::Storage(self.records)), (1, Binding::TextureArray(self.depths))];
        bindings.extend(self.slopes.map(|slopes| (2, Binding::TextureArray(slopes))));
        bindings.push((3, Binding::Texture(out.receiver_depth())));
        bindings.push((4, Binding::Texture(out.receiver_planes())));
        bindings
    }
}

/// The pixels on which shadows of what a view shows may fall, with those that are averaged beside them.
fn shadowed_pixels(
    light: &LightContext<'_>,
    casters: &CasterBuffers<'_>,
    view: &LightView,
    size: MapSize,
) -> [u32; 4] {
    let position = light.light().position;
    let [low, high] = view.window;
    let share = (high - low).max_element() * size.margin / f64::from(size.texels);
    let seen = casters.casters.iter().map(|caster| caster.instance.world_bounds);
    let pixels = seen.filter(|bounds| view.may_show(bounds)).fold(None, |all, bounds| {
        let farthest_m = bounds.radius() + (bounds.center() - position.truncate()).length();
        let grown = bounds.expanded(share * if position.w > 0.0 { farthest_m } else { 1.0 });
        let end = end_in_view(light.view, position, &grown);
        united(all, volume_pixels(light.view, position, &grown, end))
    });
    pixels.unwrap_or([0; 4])
}

/// The passes that draw maps: the depths that the light sees, and the slopes of it where there is a texture for them. `passes` has
/// for each layer what is drawn and why; `matrices` is where the light sees each caster.
fn draw_maps(
    out: &mut PassList<'_>,
    light: &str,
    (depths, slopes): (Resource, Option<Resource>),
    matrices: &[[f32; 16]],
    passes: impl Iterator<Item = (Vec<Draw>, String)>,
) {
    let bytes: Arc<Vec<u8>> = Arc::new(cast_slice(matrices).to_vec());
    let (label, reason) = (format!("map matrices of {light}"), "where the light sees each caster");
    let matrices = (!bytes.is_empty())
        .then(|| out.buffer(BufferDesc::storage(&label, hash_of(("map matrices", &bytes)), bytes, reason)));
    for (layer, (draws, reason)) in (0..).zip(passes) {
        let draws = draws.into_iter().map(|mut draw| {
            // What is cut to the view is there already.
            let is_placed = !matches!(draw.geometry, Geometry::Procedural { .. });
            draw.bindings.extend(matrices.filter(|_| is_placed).map(|m| (MATRICES, Binding::Storage(m))));
            draw
        });
        let slopes =
            slopes.map(|slopes| ColorTarget { layer, ..ColorTarget::new(slopes, Load::Clear([0.0; 4])) });
        out.pass(Pass {
            name: format!("map of {light}"),
            reason,
            colors: slopes.into_iter().collect(),
            depth: Some(DepthTarget { layer, ..DepthTarget::new(depths, Access::Clear(0.0)) }),
            draws: draws.collect(),
        });
    }
}

/// What the shader needs to know of a view.
fn fill(record: &mut MapViewRecord, view: &LightView, light: &LightContext<'_>, texels: u32, largest_m: f64) {
    let world_from_eye: DAffine3 = light.view.camera.world_from_view;
    let map_from_eye = view.map_from_local(&world_from_eye, texels);
    let rows = map_from_eye.transpose();
    let row = |row: DVec4| row.as_vec4().to_array();
    record.texel_x = row(rows.x_axis);
    record.texel_y = row(rows.y_axis);
    record.depth = row(rows.z_axis);
    record.w = row(rows.w_axis);
    // Planes go by the inverse's transpose, of which these are the rows.
    let eye_from_map = map_from_eye.inverse();
    record.plane_x = row(eye_from_map.x_axis);
    record.plane_y = row(eye_from_map.y_axis);
    record.plane_depth = row(eye_from_map.z_axis);
    let [low, high] = view.window;
    record.texels_per_m = (f64::from(texels) / (high - low).max_element()) as f32;
    record.position_loss_m = (POSITION_ROUNDINGS * largest_m) as f32;
    match view.depth {
        Depth::Orthographic { range_m, .. } => {
            record.depth_per_m = (1.0 / range_m) as f32;
            record.absolute_loss = DEPTH_ROUNDINGS as f32;
        }
        Depth::Perspective { near_m, far_m } => {
            record.depth_per_m = (near_m * far_m / (far_m - near_m)) as f32;
            // Of near / distance, which is this share of depth and so much more.
            record.relative_loss = DEPTH_ROUNDINGS as f32;
            record.absolute_loss = (DEPTH_ROUNDINGS * near_m / far_m) as f32;
        }
    }
}

fn upload(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    texels: u32,
    biases: Biases,
    records: &[MapViewRecord],
) -> Resource {
    let position = light.light().position;
    let eye = light.view.camera.world_from_view;
    let rotation = eye.matrix3.transpose();
    let to_light = position.truncate() - eye.translation * position.w;
    // From view space to the axes of the world, from the light: the rows of the eye's own rotation.
    let row = |axis: usize| {
        let row = rotation.col(axis);
        row.extend(-to_light[axis]).as_vec4().to_array()
    };
    let head = ShadowMapsRecord {
        light: (rotation * to_light).extend(position.w).as_vec4().to_array(),
        world_x: row(0),
        world_y: row(1),
        world_z: row(2),
        texels,
        view_count: records.len() as u32,
        constant_m: biases.constant_m as f32,
        slope_texels: biases.slope_texels as f32,
        normal_texels: biases.normal_texels as f32,
        ..ShadowMapsRecord::default()
    };
    let bytes = [bytes_of(&head), cast_slice(records)].concat();
    let key = hash_of(("shadow maps", &bytes));
    let label = format!("map views of {}", light.light().name);
    out.buffer(BufferDesc::storage(&label, key, Arc::new(bytes), "where the light sees what the eye sees"))
}
