//! From the graph to its snapshot.

use std::cell::OnceCell;
use std::collections::{HashMap, HashSet};
use std::f64::consts::FRAC_PI_2;
use std::fmt::Debug;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, DVec4};

use super::{CameraSnapshot, Instance, LightSnapshot, SceneSnapshot, ShadowNodeSnapshot};
use crate::geometry::Mesh;
use crate::math::Aabb;
use crate::scene::deform::is_placed;
use crate::scene::{
    Camera, CameraKey, Content, Light, LightKey, LightKind, Material, MeshNode, Node, NodeKey, Scene,
    SceneError, Scope, ShadowFlags, ShadowKey, ShadowNode,
};

impl Scene {
    /// Flattens the scene, bends its meshes, and resolves what its shadow nodes name. Traverses the graph once.
    ///
    /// # Errors
    /// [`SceneError`] when a node's transform is not finite, a key leads nowhere, or a light or camera has values
    /// outside what its kind allows; the message names the node.
    pub fn snapshot(&self) -> Result<SceneSnapshot, SceneError> {
        self.deformed.begin_pose();
        let snapshot = SceneSnapshot {
            instances: Vec::new(),
            lights: Vec::new(),
            cameras: Vec::new(),
            shadow_nodes: Vec::new(),
            world_bounds: Aabb::EMPTY,
            images: self.images().map(|(key, image)| (key, Arc::clone(image))).collect(),
            ambient: self.ambient(),
            background: self.background(),
        };
        let mut flattening =
            Flattening { scene: self, snapshot, shadow_nodes: Vec::new(), places: OnceCell::new() };
        let mut open: Vec<(NodeKey, DAffine3)> =
            self.roots().iter().rev().map(|root| (*root, DAffine3::IDENTITY)).collect();
        while let Some((key, world_from_parent)) = open.pop() {
            let Some(node) = self.node(key).filter(|node| node.visible) else { continue };
            let world_from_local = world_from_parent * node.parent_from_local;
            flattening.add(key, node, world_from_local)?;
            open.extend(node.children().iter().rev().map(|child| (*child, world_from_local)));
        }
        let Flattening { mut snapshot, shadow_nodes, .. } = flattening;
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

/// A snapshot while the graph is traversed.
struct Flattening<'s> {
    scene: &'s Scene,
    snapshot: SceneSnapshot,
    /// The visible shadow nodes, with their names; what they refer to is resolved once all instances are known.
    shadow_nodes: Vec<(ShadowKey, String, ShadowNode)>,
    /// See [`Scene::label`].
    places: OnceCell<HashMap<NodeKey, usize>>,
}

impl Flattening<'_> {
    fn label(&self, key: NodeKey, node: &Node) -> String {
        self.scene.label(key, node, &self.places)
    }

    /// Adds what a visible node holds.
    fn add(&mut self, key: NodeKey, node: &Node, world_from_local: DAffine3) -> Result<(), SceneError> {
        if !is_placed(&world_from_local) {
            return Err(SceneError::BadTransform { node: self.label(key, node) });
        }
        let scene = self.scene;
        let missing = |flattening: &Self, what: &'static str, of: &dyn Debug| SceneError::Missing {
            what,
            key: format!("{of:?} of node '{}'", flattening.label(key, node)),
        };
        match &node.content {
            Content::Group => {}
            Content::Mesh(content) => {
                let mesh = scene.mesh(content.mesh).ok_or_else(|| missing(self, "mesh", &content.mesh))?;
                self.add_mesh(key, node, content, mesh, world_from_local)?;
            }
            Content::Light(light_key) => {
                let light = scene.light(*light_key).ok_or_else(|| missing(self, "light", light_key))?;
                let light = light_snapshot(key, *light_key, light, &world_from_local)?;
                self.snapshot.lights.push(light);
            }
            Content::Camera(camera_key) => {
                let camera = scene.camera(*camera_key).ok_or_else(|| missing(self, "camera", camera_key))?;
                let camera = camera_snapshot(*camera_key, camera, &world_from_local)?;
                self.snapshot.cameras.push(camera);
            }
            Content::Shadow(shadow_key) => {
                let shadow =
                    scene.shadow(*shadow_key).ok_or_else(|| missing(self, "shadow node", shadow_key))?;
                self.shadow_nodes.push((*shadow_key, self.label(key, node), shadow.clone()));
            }
        }
        Ok(())
    }

    /// Adds a mesh as it is bent now, at its place in the world.
    fn add_mesh(
        &mut self,
        key: NodeKey,
        node: &Node,
        content: &MeshNode,
        mesh: &Arc<Mesh>,
        world_from_local: DAffine3,
    ) -> Result<(), SceneError> {
        let scene = self.scene;
        let worn = mesh.data().parts.iter().map(|part| {
            let key = content.materials.get(part.material_slot);
            let material = key.and_then(|key| scene.shared_material(*key));
            Arc::clone(material.unwrap_or(scene.default_material()))
        });
        let materials: Vec<Arc<Material>> = worn.collect();
        let lit = materials.iter().any(|material| !material.unlit);
        let (mesh, world_from_local) = scene.shaped(node, content, mesh, world_from_local)?;
        let world_bounds = Aabb::from_points(
            mesh.positions().iter().map(|p| world_from_local.transform_point3(p.as_dvec3())),
        );
        let corners_finite = world_bounds.min.is_finite() && world_bounds.max.is_finite();
        if !corners_finite && !world_bounds.is_empty() {
            return Err(SceneError::BadTransform { node: self.label(key, node) });
        }
        let name = self.label(key, node);
        self.snapshot.world_bounds = self.snapshot.world_bounds.union(&world_bounds);
        self.snapshot.instances.push(Instance {
            node: key,
            name,
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
        Ok(())
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
    let rotation = DMat3::from_cols(side, back.cross(side), back);
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
