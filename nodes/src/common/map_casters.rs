//! What is drawn into a light's maps: which casters can shadow anything, which of their triangles, and the draws of one view.
//!
//! Facing is decided once per triangle, in f64, as for shadow volumes; triangles the light sees edge-on are not drawn. Masked
//! parts are drawn with the corners of their own, and holes are looked up by the function that gives the visible surface its
//! holes. A flat caster before which everything lies that receives (a floor, usually) shadows nothing and is left out, so that
//! maps need not show it. Casters with triangles larger than a view are cut to it: see [`super::cut_casters`].

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, cast_slice};
use glam::{DAffine3, DMat3};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::plan::{
    BlendState, BufferDesc, CompareFunction, DrawState, Resource, Shader, ShaderError,
};
use shadowgraph_engine::scene::{ImageKey, Instance, Material};
use shadowgraph_engine::shadow::{Binding, Draw, Geometry, LightContext, PassList, hash_of};

use super::cut_casters::{CutCorner, is_large, longest_edge_m, pieces_in, top_m};
use super::facing::CasterFacing;
use super::flat_casters::{Behind, behind};
use super::light_views::{CasterBox, LightView};
use super::mask_vertices::MaskVertices;
use super::ray_candidates::Layout;
use super::volume::{CastShape, Half};
use crate::layout;

/// `struct MapCorner` of shadow_map_casters.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct MapCorner {
    pub position: [f32; 3],
    pub alpha: f32,
    pub uv: [f32; 2],
    pub cutoff: f32,
    pub reading: u32,
}

/// The structure of shadow_map_casters.wgsl as it is here: what the layout test compares.
pub fn corner_layout() -> (&'static str, Layout) {
    ("MapCorner", layout!(MapCorner: position, alpha, uv, cutoff, reading))
}

/// Which triangles of a caster are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Drawn {
    /// All that are not edge-on.
    Both,
    /// Those whose front is towards the light.
    Front,
    /// The others.
    Back,
}

/// A caster that can shadow something.
#[derive(Clone, Debug)]
pub struct MapCaster<'a> {
    /// Its number in the scene's snapshot.
    pub index: usize,
    /// It.
    pub instance: &'a Instance,
    /// Which of its triangles are drawn.
    pub drawn: Drawn,
    /// The box around what its shadows may fall on, where that is known: it is flat, and they fall on what is behind it.
    pub shadows: Option<Aabb>,
    /// The longest edge of its triangles.
    longest_edge_m: f64,
}

/// The casters of a light that can shadow something anywhere in the scene; of those left out, why.
pub fn casters_of<'a>(
    light: &LightContext<'a>,
    out: &mut PassList<'_>,
    drawn: impl Fn(&Instance) -> Drawn,
) -> Vec<MapCaster<'a>> {
    let receivers: Vec<(usize, Aabb)> = light
        .snapshot
        .instances
        .iter()
        .enumerate()
        .filter(|(_, instance)| instance.shadow.receives)
        .map(|(index, instance)| (index, instance.world_bounds))
        .collect();
    let name = &light.light().name;
    let (mut kept, mut flat, mut beyond) = (Vec::new(), Vec::new(), Vec::new());
    for (index, instance) in light.casters() {
        if !instance.blocks_light() {
            continue;
        }
        if !light.light().may_reach(&instance.world_bounds) {
            beyond.push(instance.name.as_str());
            continue;
        }
        let shadows = match behind(light, (index, instance), &receivers) {
            Behind::Nothing => {
                flat.push(instance.name.as_str());
                continue;
            }
            Behind::Within(bounds) => Some(bounds),
            Behind::Anything => None,
        };
        let longest_edge_m =
            *light.cache.get_or_compute("longest edge", instance.pose_key, || longest_edge_m(instance));
        kept.push(MapCaster { index, instance, drawn: drawn(instance), shadows, longest_edge_m });
    }
    for (names, reason) in [
        (flat, "flat, and nothing that receives lies behind it"),
        (beyond, "outside the light's range or cone"),
    ] {
        if let Some(first) = names.first() {
            let more = if names.len() > 1 { format!(" and {} more", names.len() - 1) } else { String::new() };
            out.note(format!("casters of '{name}' '{first}'{more}: {reason}"));
        }
    }
    kept
}

/// The box around a caster along the axes of a direction.
pub fn bounds_along(light: &LightContext<'_>, instance: &Instance, axes: &DMat3) -> Aabb {
    let bits = axes.to_cols_array().map(f64::to_bits);
    *light.cache.get_or_compute("bounds along a light", hash_of((instance.pose_key, bits)), || {
        let vertices = 0..instance.mesh.positions().len() as u32;
        Aabb::from_points(vertices.map(|vertex| *axes * instance.world_position(vertex)))
    })
}

impl MapCaster<'_> {
    /// Where it is, and what it may shadow.
    pub fn bounds(&self) -> CasterBox {
        CasterBox { whole: self.instance.world_bounds, shadows: self.shadows }
    }

    /// Whether its triangles are so large in a view that they have to be cut to it.
    fn is_large_in(&self, view: &LightView) -> bool {
        is_large(self.longest_edge_m, &self.instance.world_bounds, view)
    }

    /// How high it reaches within an orthographic view, along it, if that is another height than its box has.
    pub fn top_m(&self, light: &LightContext<'_>, view: &LightView) -> Option<f64> {
        self.is_large_in(view).then(|| top_m(light, self.instance, view)).flatten()
    }
}

/// Where the draws of casters find their matrices.
pub const MATRICES: u32 = 1;

/// The parts of a caster that one draw has.
#[derive(Clone, Debug)]
struct Part<'a> {
    caster: usize,
    masked: Option<(usize, &'a Material)>,
    /// Of the index buffer.
    first: u32,
    count: u32,
}

/// The casters of one light as buffers.
pub struct CasterBuffers<'a> {
    /// The casters, as they were given.
    pub casters: Vec<MapCaster<'a>>,
    parts: Vec<Part<'a>>,
    indices: Resource,
    corners: Option<Resource>,
    images: Vec<(ImageKey, Resource)>,
    /// A hash of everything that is drawn, but for the light's views.
    pub key: u64,
}

/// What one part's list is made from.
struct List {
    indices: Vec<u32>,
    corners: Vec<MapCorner>,
}

impl<'a> CasterBuffers<'a> {
    /// Uploads what `casters` draw; none of them twice.
    pub fn new(light: &LightContext<'a>, out: &mut PassList<'_>, casters: Vec<MapCaster<'a>>) -> Self {
        let (mut parts, mut lists, mut keys) = (Vec::new(), Vec::new(), Vec::new());
        let mut images: Vec<(ImageKey, Resource)> = Vec::new();
        let (mut first, mut corners) = (0, 0);
        for (number, caster) in casters.iter().enumerate() {
            let instance = caster.instance;
            let masked = instance.materials.iter().enumerate().filter(|(_, m)| m.casts_by_texel());
            let has_whole = instance.materials.iter().any(|material| material.casts_whole());
            let all = has_whole.then_some(None).into_iter();
            for masked in all.chain(masked.map(|(part, material)| Some((part, &**material)))) {
                let (list, key) = list_of(light, caster, masked);
                if let Some(texture) = masked.and_then(|(_, material)| material.base_color_texture) {
                    let image = texture.image;
                    if images.iter().all(|(known, _)| *known != image) {
                        images.push((image, out.image(image, "holes are looked up where light would pass")));
                    }
                }
                let count = list.indices.len() as u32;
                parts.push(Part { caster: number, masked, first, count });
                keys.push((key, corners));
                first += count;
                corners += list.corners.len() as u32;
                lists.push(list);
            }
        }
        let key = hash_of(("map casters", &keys));
        let bytes = light.cache.get_or_compute("map caster bytes", key, || {
            let (mut indices, mut corners): (Vec<u32>, Vec<MapCorner>) = (Vec::new(), Vec::new());
            for list in &lists {
                let base = if list.corners.is_empty() { 0 } else { corners.len() as u32 };
                indices.extend(list.indices.iter().map(|index| base + index));
                corners.extend_from_slice(&list.corners);
            }
            [cast_slice(&indices).to_vec(), cast_slice(&corners).to_vec()].map(Arc::new)
        });
        let [indices, corners] = &*bytes;
        let name = &light.light().name;
        let reason = format!("{} triangles that {name} sees", first / 3);
        let label = format!("map casters of {name}");
        let indices =
            out.buffer(BufferDesc::index(&label, hash_of((key, "indices")), Arc::clone(indices), &reason));
        let corners = (!corners.is_empty()).then(|| {
            let (label, reason) = (format!("masked corners of {name}"), "triangles that may have holes");
            let (key, contents) = (hash_of((key, "corners")), Arc::clone(corners));
            out.buffer(BufferDesc::storage(&label, key, contents, reason))
        });
        Self { casters, parts, indices, corners, images, key }
    }

    /// The draws of one view into the texture of depth, and into that of slopes if there is one. The matrices that they read are
    /// added to `matrices`, which the caller binds at [`MATRICES`].
    ///
    /// # Errors
    /// What is wrong with a shader.
    pub fn draws(
        &self,
        (light, out): (&LightContext<'_>, &mut PassList<'_>),
        (view, texels): (&LightView, u32),
        with_slopes: bool,
        matrices: &mut Vec<[f32; 16]>,
    ) -> Result<Vec<Draw>, ShaderError> {
        let mut draws = Vec::new();
        draws.extend(self.cut_draw((light, out), (view, texels), with_slopes)?);
        for part in self.parts.iter().filter(|part| part.count > 0) {
            let MapCaster { index, instance, .. } = &self.casters[part.caster];
            if self.is_cut(part, view) || !view.may_show(&instance.world_bounds) {
                continue;
            }
            let world_from_local = match part.masked {
                None => instance.world_from_shader(),
                Some(_) => DAffine3::from_translation(instance.world_bounds.center()),
            };
            let record = matrices.len() as u32;
            matrices.push(view.clip_from_local(&world_from_local).as_mat4().to_cols_array());
            let image = part.masked.and_then(|(_, material)| material.base_color_texture);
            let shader = shader(view, with_slopes, part.masked.is_some(), image.is_some())?;
            let (indices, first, count) = (self.indices, part.first, part.count);
            let geometry = match part.masked {
                None => Geometry::Indexed { shader, instance: *index as u32, indices, first, count, record },
                Some(_) => Geometry::IndexedProcedural { shader, indices, first, count, record },
            };
            let targets = if with_slopes { vec![Some(BlendState::REPLACE)] } else { vec![] };
            let mut state = DrawState::new(CompareFunction::Greater, targets);
            state.depth_write = true;
            let mut draw = Draw::new(instance.name.clone(), geometry, state);
            if let (Some(_), Some(corners)) = (part.masked, self.corners) {
                draw.bindings.push((2, Binding::Storage(corners)));
            }
            if let Some(texture) = image {
                let found = self.images.iter().find(|(key, _)| *key == texture.image);
                draw.bindings.extend(found.map(|(_, image)| (3, Binding::Texture(*image))));
            }
            draws.push(draw);
        }
        Ok(draws)
    }

    /// The draw of all casters that are cut to a view, if there are any.
    fn cut_draw(
        &self,
        (light, out): (&LightContext<'_>, &mut PassList<'_>),
        (view, texels): (&LightView, u32),
        with_slopes: bool,
    ) -> Result<Option<Draw>, ShaderError> {
        let parts = self.parts.iter().filter(|part| part.count > 0 && self.is_cut(part, view));
        let casters = parts.map(|part| &self.casters[part.caster]);
        let large: Vec<_> = casters.filter(|caster| view.may_show(&caster.instance.world_bounds)).collect();
        let key = hash_of(("cut casters", self.key, view.bits(), texels));
        let bytes = light.cache.get_or_compute("cut casters", key, || {
            let pieces = large.iter().flat_map(|caster| {
                let triangles = triangles_of(light, caster, None);
                pieces_in(view, texels, caster.instance, &triangles)
            });
            cast_slice(&pieces.collect::<Vec<CutCorner>>()).to_vec()
        });
        let vertices = (bytes.len() / size_of::<CutCorner>()) as u32;
        if vertices == 0 {
            return Ok(None);
        }
        let (label, reason) = (
            format!("cut casters of {}", light.light().name),
            format!("{} pieces of casters with triangles larger than the view", vertices / 3),
        );
        let corners = out.buffer(BufferDesc::storage(&label, key, bytes, &reason));
        let mut flags = vec!["CUT"];
        flags.extend(view.is_perspective().then_some("PERSPECTIVE"));
        let fragment = if with_slopes { "slope_of_piece" } else { "depth_of_piece" };
        let shader = Shader::composed("shadow_map_casters", &flags, "vertex", Some(fragment))?;
        let geometry = Geometry::Procedural { shader, vertices, instances: 1 };
        let targets = if with_slopes { vec![Some(BlendState::REPLACE)] } else { vec![] };
        let mut state = DrawState::new(CompareFunction::Greater, targets);
        state.depth_write = true;
        let draw = Draw::new(names_of(&large), geometry, state);
        Ok(Some(draw.reading(vec![(4, Binding::Storage(corners))])))
    }

    /// Whether a part is cut to a view; masked ones are not, whose holes go by the corners that they have.
    fn is_cut(&self, part: &Part<'_>, view: &LightView) -> bool {
        part.masked.is_none() && self.casters[part.caster].is_large_in(view)
    }

    /// How far casters that are not cut to a view reach from their own middles, at most: what rounding loses of their positions
    /// goes by that.
    pub fn largest_m(&self, view: &LightView) -> f64 {
        let parts = self.parts.iter().filter(|part| part.count > 0 && !self.is_cut(part, view));
        parts.map(|part| self.casters[part.caster].instance.world_bounds.radius()).fold(0.0, f64::max)
    }
}

/// What is cut, as the plan's text has it.
fn names_of(casters: &[&MapCaster<'_>]) -> String {
    const NAMED: usize = 3;
    let names: Vec<&str> = casters.iter().take(NAMED).map(|caster| caster.instance.name.as_str()).collect();
    match casters.len().checked_sub(NAMED + 1) {
        None => format!("{}, cut to the view", names.join(", ")),
        Some(rest) => format!("{} and {} more, cut to the view", names.join(", "), rest + 1),
    }
}

/// The index list of a caster's whole parts, or of a masked one with its corners; and a hash of what it was made from.
fn list_of(
    light: &LightContext<'_>,
    caster: &MapCaster<'_>,
    masked: Option<(usize, &Material)>,
) -> (Arc<List>, u64) {
    let instance = caster.instance;
    let bits = light.light().position.to_array().map(f64::to_bits);
    let whole: Vec<bool> = instance.materials.iter().map(|material| material.casts_whole()).collect();
    let worn = masked.map(|(part, material)| {
        // An image that was changed is another one.
        let image = material.base_color_texture.and_then(|t| light.snapshot.images.get(&t.image));
        let image = image.map(|image| Arc::as_ptr(image) as usize);
        let cutoff = material.cutoff().unwrap_or_default().to_bits();
        (part, image, format!("{:?}", material.base_color_texture), material.base_color.w.to_bits(), cutoff)
    });
    let key = hash_of((instance.pose_key, bits, caster.drawn, whole, worn));
    let list = light.cache.get_or_compute("map triangles", key, || {
        let triangles = triangles_of(light, caster, masked.map(|(part, _)| part));
        match masked {
            None => List {
                indices: triangles.into_iter().flat_map(|t| instance.mesh.triangle(t as usize)).collect(),
                corners: Vec::new(),
            },
            Some((_, material)) => {
                let corners = masked_corners(instance, material, &triangles);
                List { indices: (0..corners.len() as u32).collect(), corners }
            }
        }
    });
    (list, key)
}

/// The triangles of a caster's whole parts, or of its masked part, that are drawn.
fn triangles_of(light: &LightContext<'_>, caster: &MapCaster<'_>, part: Option<usize>) -> Vec<u32> {
    let instance = caster.instance;
    let topology = instance.mesh.topology();
    let shape = CastShape::Own(topology);
    let of_parts = |half| match part {
        None => CasterFacing::new(light, instance, &shape, half),
        Some(part) => CasterFacing::of_parts(light, instance, &shape, half, |other| other == part),
    };
    let is_solid = topology.orientation(&instance.world_from_local).is_some();
    let (half, wanted) = match (caster.drawn, is_solid) {
        (Drawn::Both, _) => (Half::Both, 0),
        (Drawn::Front, true) => (Half::Lit, 0),
        (Drawn::Back, true) => (Half::Unlit, 0),
        // Of what is no solid, the front is where triangles are counter-clockwise.
        (Drawn::Front, false) => (Half::Both, 1),
        (Drawn::Back, false) => (Half::Both, -1),
    };
    let facing = of_parts(half);
    facing.cast.iter().copied().filter(|t| wanted == 0 || facing.signs[*t as usize] == wanted).collect()
}

fn masked_corners(instance: &Instance, material: &Material, triangles: &[u32]) -> Vec<MapCorner> {
    let texture = material.base_color_texture;
    let worn = MaskVertices::new(instance, texture.as_ref());
    let center = instance.world_bounds.center();
    let corner = |vertex: u32| MapCorner {
        position: (instance.world_position(vertex) - center).as_vec3().to_array(),
        alpha: material.base_color.w * worn.alpha(vertex) as f32,
        uv: worn.uv(vertex).as_vec2().to_array(),
        cutoff: material.cutoff().unwrap_or_default(),
        reading: texture.map_or(0, |texture| texture.reading_bits()),
    };
    triangles.iter().flat_map(|triangle| instance.mesh.triangle(*triangle as usize)).map(corner).collect()
}

fn shader(view: &LightView, with_slopes: bool, masked: bool, image: bool) -> Result<Shader, ShaderError> {
    let perspective = matches!(view.depth, super::light_views::Depth::Perspective { .. });
    let wanted =
        [("MASKED", masked), ("BASE_COLOR_TEXTURE", image), ("PERSPECTIVE", perspective && with_slopes)];
    let flags: Vec<&str> = wanted.into_iter().filter(|(_, wanted)| *wanted).map(|(flag, _)| flag).collect();
    let fragment = match (with_slopes, masked) {
        (true, _) => Some("slope"),
        (false, true) => Some("holes"),
        (false, false) => None,
    };
    Shader::composed("shadow_map_casters", &flags, "vertex", fragment)
}
