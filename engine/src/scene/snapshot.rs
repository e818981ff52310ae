//! The scene at one moment, flattened: what the frame plan, the executor and the reference all work from.

use std::cell::OnceCell;
use std::collections::{HashMap, HashSet};
use std::f64::consts::FRAC_PI_2;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use glam::{DAffine3, DVec3, DVec4, Vec3};

use super::deform::is_placed;
use super::{
    Camera, CameraKey, Content, Image, ImageKey, Light, LightKey, LightKind, Material, Node, NodeKey, Scene,
    SceneError, Scope, ShadowFlags, ShadowKey, ShadowNode,
};
use crate::geometry::Mesh;
use crate::math::{Aabb, Projection, ViewFrustum};

/// A mesh at its place in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The node it comes from.
    pub node: NodeKey,
    /// The node's name.
    pub name: String,
    /// The shape.
    pub mesh: Arc<Mesh>,
    /// One material for each of the mesh's parts, in order.
    pub materials: Vec<Arc<Material>>,
    /// Where it stands.
    pub world_from_local: DAffine3,
    /// The box around it in the world.
    pub world_bounds: Aabb,
    /// Whether it casts and receives (materials taken into account: unlit parts do neither).
    pub shadow: ShadowFlags,
    /// A hash of the shape and the transform: equal keys, equal world geometry.
    pub pose_key: u64,
}

impl Instance {
    /// Vertex `vertex` in the world, in f64: the f32 input under the f64 transform.
    pub fn world_position(&self, vertex: u32) -> DVec3 {
        self.world_from_local.transform_point3(self.mesh.positions()[vertex as usize].as_dvec3())
    }

    /// The transform to the world from the space in which shaders see the vertex positions.
    pub fn world_from_shader(&self) -> DAffine3 {
        self.world_from_local * DAffine3::from_translation(self.mesh.shader_origin())
    }

    /// The corners of `triangle` in the world.
    pub fn world_triangle(&self, triangle: usize) -> [DVec3; 3] {
        self.mesh.triangle(triangle).map(|vertex| self.world_position(vertex))
    }

    /// The material of `triangle`.
    pub fn material_of(&self, triangle: usize) -> &Arc<Material> {
        let part = self.mesh.data().parts.partition_point(|part| part.triangles.end as usize <= triangle);
        &self.materials[part]
    }

    /// Whether every part of it is opaque (hidden surfaces, depth, black shadows).
    pub fn is_opaque(&self) -> bool {
        self.materials.iter().all(|material| material.is_opaque())
    }

    /// Whether any part of it is alpha-masked.
    pub fn is_masked(&self) -> bool {
        self.materials.iter().any(|material| material.cutoff().is_some())
    }
}

/// A light at its place in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSnapshot {
    /// The node it comes from.
    pub node: NodeKey,
    /// Its key.
    pub key: LightKey,
    /// A name that no other light of this frame has and that is a plain file name.
    pub name: String,
    /// Colour, intensity, kind, range.
    pub light: Light,
    /// Homogeneous: (position, 1), or (unit direction *towards* the light, 0).
    pub position: DVec4,
    /// The unit direction in which it shines (for a point light, its node's −z).
    pub direction: DVec3,
}

impl LightSnapshot {
    /// Whether `point` lies within the light's range and cone; beyond them the factor is 1 and not compared.
    pub fn reaches(&self, point: DVec3) -> bool {
        if self.position.w == 0.0 {
            return true;
        }
        let from_light = point - self.position.truncate();
        let distance_m = from_light.length();
        if self.light.range_m.is_some_and(|range_m| distance_m > range_m) {
            return false;
        }
        match self.light.kind {
            LightKind::Spot { outer_rad, .. } => {
                from_light.dot(self.direction) >= distance_m * outer_rad.min(FRAC_PI_2).cos()
            }
            _ => true,
        }
    }

    /// Whether some point of `bounds` may lie within range and cone; false only when certainly none does.
    pub fn may_reach(&self, bounds: &Aabb) -> bool {
        if bounds.is_empty() {
            return false;
        }
        if self.position.w == 0.0 {
            return true;
        }
        let origin = self.position.truncate();
        if self.light.range_m.is_some_and(|range_m| bounds.distance(origin) > range_m) {
            return false;
        }
        let LightKind::Spot { outer_rad, .. } = self.light.kind else { return true };
        // A sphere misses the cone when the angle to its centre exceeds the cone's by more than its own.
        let (to_center, radius_m) = (bounds.center() - origin, bounds.radius());
        let distance_m = to_center.length();
        if distance_m <= radius_m {
            return true;
        }
        let off_axis_rad = (to_center.dot(self.direction) / distance_m).clamp(-1.0, 1.0).acos();
        off_axis_rad - (radius_m / distance_m).asin() <= outer_rad
    }
}

/// A camera at its place in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSnapshot {
    /// Its key; `None` for a camera that is not in the scene.
    pub key: Option<CameraKey>,
    /// Its name.
    pub name: String,
    /// Where it stands: a rigid transform, scale removed.
    pub world_from_view: DAffine3,
    /// How it projects.
    pub projection: Projection,
}

impl CameraSnapshot {
    /// A camera outside any scene, at `eye` looking at `target`.
    pub fn looking(camera: Camera, eye: DVec3, target: DVec3) -> Self {
        let world_from_view = super::content::look_at(eye, target);
        Self { key: None, name: camera.name, world_from_view, projection: camera.projection }
    }

    /// The same camera, seeing no farther than a scene with these bounds goes: an orthographic depth is as coarse everywhere
    /// as its whole range is long, and `zfar` is often a guess. A perspective depth gains nothing from it.
    pub fn fitted_to(&self, world_bounds: &Aabb) -> Self {
        let mut fitted = self.clone();
        if let Projection::Orthographic { near_m, far_m, .. } = &mut fitted.projection
            && !world_bounds.is_empty()
        {
            let view_from_world = self.world_from_view.inverse();
            let corners = world_bounds.corners().map(|corner| -view_from_world.transform_point3(corner).z);
            let farthest_m = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
            // What is farthest away is not to have the depth of where nothing is.
            let end_m = *near_m + (farthest_m - *near_m) * (1.0 + 1.0 / 64.0);
            if end_m > *near_m {
                *far_m = far_m.min(end_m);
            }
        }
        fitted
    }

    /// The frustum for a target of this size in pixels.
    pub fn frustum(&self, size_px: [u32; 2]) -> ViewFrustum {
        let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
        ViewFrustum::new(&self.world_from_view, &self.projection, aspect)
    }
}

/// A shadow node with its scopes resolved to lights and instances of the scene's snapshot.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowNodeSnapshot {
    /// Its key.
    pub key: ShadowKey,
    /// The node's name.
    pub name: String,
    /// Technique and options.
    pub shadow: ShadowNode,
    /// Indices into [`SceneSnapshot::lights`], ascending.
    pub lights: Vec<usize>,
    /// Indices into [`SceneSnapshot::instances`], ascending; only instances that may cast.
    pub casters: Vec<usize>,
    /// Indices into [`SceneSnapshot::instances`], ascending; only instances that may receive.
    pub receivers: Vec<usize>,
}

/// The scene at one moment.
#[derive(Clone, Debug)]
pub struct SceneSnapshot {
    /// Every visible mesh, parents first: also the order of drawing.
    pub instances: Vec<Instance>,
    /// Every visible light.
    pub lights: Vec<LightSnapshot>,
    /// Every camera.
    pub cameras: Vec<CameraSnapshot>,
    /// Every visible shadow node.
    pub shadow_nodes: Vec<ShadowNodeSnapshot>,
    /// The box around all instances, in the world.
    pub world_bounds: Aabb,
    /// The images materials refer to.
    pub images: HashMap<ImageKey, Arc<Image>>,
    /// Ambient light, as in [`Scene::ambient`].
    pub ambient: Vec3,
    /// Background, as in [`Scene::background`].
    pub background: Vec3,
}

impl Scene {
    /// Flattens the scene. Traverses the graph once.
    ///
    /// # Errors
    /// [`SceneError`] when a node's transform is not finite, a key leads nowhere, or a light or camera has values
    /// outside what its kind allows; the message names the node.
    pub fn snapshot(&self) -> Result<SceneSnapshot, SceneError> {
        self.deformed.begin_pose();
        let mut snapshot = SceneSnapshot {
            instances: Vec::new(),
            lights: Vec::new(),
            cameras: Vec::new(),
            shadow_nodes: Vec::new(),
            world_bounds: Aabb::EMPTY,
            images: self.images().map(|(key, image)| (key, Arc::clone(image))).collect(),
            ambient: self.ambient(),
            background: self.background(),
        };
        let mut shadow_nodes = Vec::new();
        let places = OnceCell::new();
        let label = |key: NodeKey, node: &Node| self.label(key, node, &places);
        let mut open: Vec<(NodeKey, DAffine3)> =
            self.roots().iter().rev().map(|root| (*root, DAffine3::IDENTITY)).collect();
        while let Some((key, world_from_parent)) = open.pop() {
            let Some(node) = self.node(key).filter(|node| node.visible) else { continue };
            let world_from_local = world_from_parent * node.parent_from_local;
            if !is_placed(&world_from_local) {
                return Err(SceneError::BadTransform { node: label(key, node) });
            }
            open.extend(node.children().iter().rev().map(|child| (*child, world_from_local)));
            let missing = |what, of: String| SceneError::Missing {
                what,
                key: format!("{of} of node '{}'", label(key, node)),
            };
            match &node.content {
                Content::Group => {}
                Content::Mesh(content) => {
                    let mesh = self
                        .mesh(content.mesh)
                        .ok_or_else(|| missing("mesh", format!("{:?}", content.mesh)))?;
                    let materials: Vec<_> = mesh
                        .data()
                        .parts
                        .iter()
                        .map(|part| {
                            let key = content.materials.get(part.material_slot);
                            let material = key.and_then(|key| self.shared_material(*key));
                            Arc::clone(material.unwrap_or(self.default_material()))
                        })
                        .collect();
                    let lit = materials.iter().any(|material| !material.unlit);
                    let (mesh, world_from_local) = self.shaped(node, content, mesh, world_from_local)?;
                    let world_bounds = Aabb::from_points(
                        mesh.positions().iter().map(|p| world_from_local.transform_point3(p.as_dvec3())),
                    );
                    let corners_finite = world_bounds.min.is_finite() && world_bounds.max.is_finite();
                    if !corners_finite && !world_bounds.is_empty() {
                        return Err(SceneError::BadTransform { node: label(key, node) });
                    }
                    snapshot.world_bounds = snapshot.world_bounds.union(&world_bounds);
                    snapshot.instances.push(Instance {
                        node: key,
                        name: label(key, node),
                        pose_key: pose_key(mesh.id(), &world_from_local),
                        mesh,
                        materials,
                        world_from_local,
                        world_bounds,
                        shadow: ShadowFlags {
                            casts: content.shadow.casts && lit,
                            receives: content.shadow.receives && lit,
                        },
                    });
                }
                Content::Light(light_key) => {
                    let light =
                        self.light(*light_key).ok_or_else(|| missing("light", format!("{light_key:?}")))?;
                    snapshot.lights.push(light_snapshot(key, *light_key, light, &world_from_local)?);
                }
                Content::Camera(camera_key) => {
                    let camera = self
                        .camera(*camera_key)
                        .ok_or_else(|| missing("camera", format!("{camera_key:?}")))?;
                    snapshot.cameras.push(camera_snapshot(*camera_key, camera, &world_from_local)?);
                }
                Content::Shadow(shadow_key) => {
                    let shadow = self
                        .shadow(*shadow_key)
                        .ok_or_else(|| missing("shadow node", format!("{shadow_key:?}")))?;
                    shadow_nodes.push((*shadow_key, label(key, node), shadow.clone()));
                }
            }
        }
        name_lights(&mut snapshot.lights);
        snapshot.shadow_nodes = shadow_nodes
            .into_iter()
            .map(|(key, name, shadow)| self.resolve(&snapshot, key, name, shadow))
            .collect();
        Ok(snapshot)
    }

    /// Resolves a shadow node's scopes against the scene's snapshot.
    fn resolve(
        &self,
        snapshot: &SceneSnapshot,
        key: ShadowKey,
        name: String,
        shadow: ShadowNode,
    ) -> ShadowNodeSnapshot {
        let scope = |scope: &Scope| -> Option<HashSet<NodeKey>> {
            match scope {
                Scope::All => None,
                Scope::Nodes(nodes) => Some(self.subtrees(nodes)),
            }
        };
        let (lights, casters, receivers) =
            (scope(&shadow.lights), scope(&shadow.casters), scope(&shadow.receivers));
        let named =
            |scope: &Option<HashSet<NodeKey>>, node| scope.as_ref().is_none_or(|nodes| nodes.contains(&node));
        let pick = |scope, wanted: fn(&Instance) -> bool| {
            let chosen = snapshot.instances.iter().enumerate();
            chosen
                .filter(|(_, i)| wanted(i) && named(scope, i.node))
                .map(|(index, _)| index)
                .collect::<Vec<_>>()
        };
        ShadowNodeSnapshot {
            lights: (0..snapshot.lights.len())
                .filter(|i| {
                    snapshot.lights[*i].light.casts_shadows && named(&lights, snapshot.lights[*i].node)
                })
                .collect(),
            casters: pick(&casters, |instance| instance.shadow.casts),
            receivers: pick(&receivers, |instance| instance.shadow.receives),
            key,
            name,
            shadow,
        }
    }
}

/// The hash behind [`Instance::pose_key`].
fn pose_key(mesh_id: u64, world_from_local: &DAffine3) -> u64 {
    let mut hasher = DefaultHasher::new();
    mesh_id.hash(&mut hasher);
    world_from_local.to_cols_array().map(f64::to_bits).hash(&mut hasher);
    hasher.finish()
}

fn light_snapshot(
    node: NodeKey,
    key: LightKey,
    light: &Light,
    world_from_local: &DAffine3,
) -> Result<LightSnapshot, SceneError> {
    let bad = |problem: &str| SceneError::BadContent {
        what: "light",
        name: light.name.clone(),
        problem: problem.into(),
    };
    if !(light.intensity.is_finite() && light.intensity >= 0.0 && light.color.is_finite()) {
        return Err(bad("intensity and colour must be finite and the intensity not negative"));
    }
    if light.range_m.is_some_and(|range_m| range_m.is_nan() || range_m <= 0.0) {
        return Err(bad("the range must be above 0 m"));
    }
    if let LightKind::Spot { inner_rad, outer_rad } = light.kind
        && !(inner_rad >= 0.0 && inner_rad <= outer_rad && outer_rad > 0.0 && outer_rad <= FRAC_PI_2)
    {
        return Err(bad("cone angles must satisfy 0 <= inner <= outer <= pi/2, outer above 0"));
    }
    let direction = world_from_local.transform_vector3(DVec3::NEG_Z).try_normalize();
    let direction = match (light.kind, direction) {
        (LightKind::Point, direction) => direction.unwrap_or(DVec3::NEG_Z),
        (_, Some(direction)) => direction,
        (_, None) => return Err(bad("its node's transform leaves it no direction")),
    };
    let position = match light.kind {
        LightKind::Directional => DVec4::from((-direction, 0.0)),
        _ => DVec4::from((world_from_local.translation, 1.0)),
    };
    Ok(LightSnapshot { node, key, name: light.name.clone(), light: light.clone(), position, direction })
}

fn camera_snapshot(
    key: CameraKey,
    camera: &Camera,
    world_from_local: &DAffine3,
) -> Result<CameraSnapshot, SceneError> {
    if !camera.projection.is_valid() {
        return Err(SceneError::BadContent {
            what: "camera",
            name: camera.name.clone(),
            problem: "needs 0 < near < far, and a field of view between 0 and pi or a positive height".into(),
        });
    }
    let eye = world_from_local.translation;
    let back = world_from_local.transform_vector3(DVec3::Z).try_normalize().unwrap_or(DVec3::Z);
    let up = world_from_local.transform_vector3(DVec3::Y);
    let side = up.cross(back).try_normalize().unwrap_or_else(|| back.any_orthonormal_vector());
    let rotation = glam::DMat3::from_cols(side, back.cross(side), back);
    Ok(CameraSnapshot {
        key: Some(key),
        name: camera.name.clone(),
        world_from_view: DAffine3::from_mat3_translation(rotation, eye),
        projection: camera.projection,
    })
}

/// Gives every light a name that is a plain file name and that no other light has.
fn name_lights(lights: &mut [LightSnapshot]) {
    let mut taken = HashSet::new();
    for (index, light) in lights.iter_mut().enumerate() {
        let plain: String = light
            .name
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '_' })
            .take(100)
            .collect();
        let plain = plain.trim_matches('.').to_owned();
        let base = if plain.is_empty() { format!("light{index}") } else { plain };
        let mut name = base.clone();
        let mut copy = 2;
        while !taken.insert(name.to_lowercase()) {
            name = format!("{base}_{copy}");
            copy += 1;
        }
        light.name = name;
    }
}
