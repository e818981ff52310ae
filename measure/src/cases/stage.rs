//! The stage every hard case is set on: a scene under construction, with its camera and what is right.

use glam::{DAffine3, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::shapes::{cuboid, plane};
use shadowgraph_engine::geometry::{Mesh, MeshData};
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::plan::Antialias;
use shadowgraph_engine::scene::{
    Camera, CameraSnapshot, Content, Image, Light, Material, MeshNode, NodeKey, ParamValue, Params, Scene,
    ShadowNode, TextureRef,
};
use std::sync::Arc;

use super::{About, Case, Cast, Expect, Probe};

/// A case under construction.
#[derive(Clone, Debug)]
pub(super) struct Stage {
    variant: String,
    scene: Scene,
    eye: DVec3,
    target: DVec3,
    projection: Projection,
    size_px: [u32; 2],
    antialias: Antialias,
    options: Params,
    receivers: Vec<NodeKey>,
    beside: Vec<(NodeKey, f64)>,
    expect: Expect,
    probes: Vec<Probe>,
    lights: usize,
}

/// A point of world space.
pub(super) fn p(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A vertex.
pub(super) fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A shift.
pub(super) fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(p(x, y, z))
}

/// The box around `center` reaching `half` to each side.
pub(super) fn block(center: Vec3, half: Vec3) -> MeshData {
    cuboid(center - half, center + half)
}

/// A mesh from bare vertices and triangles; its normals are computed later.
pub(super) fn triangles(name: &str, positions: &[Vec3], indices: &[u32]) -> MeshData {
    MeshData {
        name: name.into(),
        positions: positions.to_vec(),
        indices: indices.to_vec(),
        ..MeshData::default()
    }
}

/// A generated mesh. Invalid data here is a mistake in a case's own code, so it ends the program with the reason.
fn mesh(data: MeshData) -> Mesh {
    Mesh::new(data).unwrap_or_else(|error| panic!("a case generates an invalid mesh: {error}"))
}

impl Stage {
    /// An empty stage seen from above at an angle; shadows expected.
    pub(super) fn new(variant: impl Into<String>) -> Self {
        Self {
            variant: variant.into(),
            scene: Scene::new(),
            eye: p(3.0, 4.0, 6.0),
            target: p(0.0, 0.5, 0.0),
            projection: Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1 },
            size_px: [256, 256],
            antialias: Antialias::None,
            options: Params::new(),
            receivers: Vec::new(),
            beside: Vec::new(),
            expect: Expect::Shadow,
            probes: Vec::new(),
            lights: 0,
        }
    }

    /// A square floor at height 0, 4 m to each side.
    pub(super) fn floor(self) -> Self {
        self.caster(plane(Vec2::splat(4.0)).named("floor"))
    }

    /// A mesh that casts and receives, in world coordinates.
    pub(super) fn caster(self, data: MeshData) -> Self {
        self.caster_at(data, DAffine3::IDENTITY)
    }

    /// A mesh that casts and receives, under a transform.
    pub(super) fn caster_at(mut self, data: MeshData, world_from_local: DAffine3) -> Self {
        let shade = if data.name == "floor" { 0.6 } else { 0.8 };
        let material = Material::matt("matt", Vec3::new(shade, shade, 0.75));
        self.scene.add_mesh(mesh(data), material, world_from_local);
        self
    }

    /// The meshes so far receive only.
    pub(super) fn casting_nothing(mut self) -> Self {
        for key in self.scene.depth_first() {
            if let Some(node) = self.scene.node_mut(key)
                && let Content::Mesh(mesh) = &mut node.content
            {
                mesh.shadow.casts = false;
            }
        }
        self
    }

    /// A mesh in a material of its own, under a transform.
    pub(super) fn worn_at(mut self, data: MeshData, material: Material, world_from_local: DAffine3) -> Self {
        self.scene.add_mesh(mesh(data), material, world_from_local);
        self
    }

    /// One mesh under many transforms.
    pub(super) fn instances(mut self, data: MeshData, places: impl IntoIterator<Item = DAffine3>) -> Self {
        let name = data.name.clone();
        let mesh = self.scene.add_mesh_data(Arc::new(mesh(data)));
        let material = self.scene.add_material(Material::default());
        for place in places {
            self.scene.add(None, &name, place, Content::Mesh(MeshNode::new(mesh, material)));
        }
        self
    }

    /// Anything else that the scene needs.
    pub(super) fn with(mut self, change: impl FnOnce(&mut Scene)) -> Self {
        change(&mut self.scene);
        self
    }

    /// A mesh whose parts wear the given materials.
    pub(super) fn caster_in(mut self, data: MeshData, materials: Vec<Material>) -> Self {
        let name = data.name.clone();
        let mesh = self.scene.add_mesh_data(Arc::new(mesh(data)));
        let materials = materials.into_iter().map(|material| self.scene.add_material(material)).collect();
        let node = MeshNode { materials, ..MeshNode::new(mesh, Default::default()) };
        self.scene.add(None, &name, DAffine3::IDENTITY, Content::Mesh(node));
        self
    }

    /// A picture for a material, by a function of the texel.
    pub(super) fn texture(&mut self, size: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> TextureRef {
        let rgba8 = (0..size * size).flat_map(|i| texel(i % size, i / size)).collect();
        let image = Image { name: "generated".into(), width: size, height: size, rgba8 };
        TextureRef::new(self.scene.add_image(Arc::new(image)))
    }

    fn next_light(&mut self) -> String {
        self.lights += 1;
        format!("light{}", self.lights - 1)
    }

    /// A point light; bright enough to read at its distance from the origin.
    pub(super) fn point(mut self, position: DVec3) -> Self {
        let candela = (position.length_squared() as f32 * 2.0).max(1e-9);
        let name = self.next_light();
        self.scene.add_light(Light::point(&name, candela), position, p(0.0, 0.0, 0.0));
        self
    }

    /// A directional light that shines along `direction`.
    pub(super) fn sun(mut self, direction: DVec3) -> Self {
        let name = self.next_light();
        self.scene.add_light(Light::directional(&name, 3.0), DVec3::ZERO, direction);
        self
    }

    /// A spot light of 40 cd opening `outer_rad` to each side.
    pub(super) fn spot(mut self, position: DVec3, target: DVec3, outer_rad: f64) -> Self {
        let name = self.next_light();
        self.scene.add_light(Light::spot(&name, 40.0, outer_rad), position, target);
        self
    }

    /// The same, with nothing lit beyond `range_m`.
    pub(super) fn spot_within(
        mut self,
        position: DVec3,
        target: DVec3,
        outer_rad: f64,
        range_m: f64,
    ) -> Self {
        let name = self.next_light();
        let light = Light::spot(&name, 40.0, outer_rad).with_range(range_m);
        self.scene.add_light(light, position, target);
        self
    }

    /// Where the camera stands and looks.
    pub(super) fn eye(mut self, eye: DVec3, target: DVec3) -> Self {
        (self.eye, self.target) = (eye, target);
        self
    }

    /// The camera's opening angle in degrees and its near distance.
    pub(super) fn lens(mut self, fov_y_deg: f64, near_m: f64) -> Self {
        self.projection = Projection::Perspective { fov_y_rad: fov_y_deg.to_radians(), near_m };
        self
    }

    /// An orthographic camera.
    pub(super) fn ortho(mut self, half_height_m: f64, near_m: f64, far_m: f64) -> Self {
        self.projection = Projection::Orthographic { half_height_m, near_m, far_m };
        self
    }

    /// A frame of another size.
    pub(super) fn size(mut self, width: u32, height: u32) -> Self {
        self.size_px = [width, height];
        self
    }

    /// A frame with smoothed edges.
    pub(super) fn antialias(mut self, antialias: Antialias) -> Self {
        self.antialias = antialias;
        self
    }

    /// Something else than a shadow is expected.
    pub(super) fn expects(mut self, expect: Expect) -> Self {
        self.expect = expect;
        self
    }

    /// An option of the case's own.
    pub(super) fn option(mut self, name: &str, value: ParamValue) -> Self {
        self.options.insert(name.into(), value);
        self
    }

    /// A mesh that casts and that the shadow node names as a receiver.
    pub(super) fn receiver(mut self, data: MeshData) -> Self {
        let material = Material::matt("matt", Vec3::new(0.6, 0.6, 0.75));
        let key = self.scene.add_mesh(mesh(data), material, DAffine3::IDENTITY);
        self.receivers.push(key);
        self
    }

    /// A mesh that casts through a node of its own, to which lights have this radius in metres, whatever technique is tried.
    pub(super) fn beside(mut self, data: MeshData, world_from_local: DAffine3, radius_m: f64) -> Self {
        let key = self.scene.add_mesh(mesh(data), Material::default(), world_from_local);
        self.beside.push((key, radius_m));
        self
    }

    /// The node that is tried, over all meshes that no node beside it has.
    fn tried(&self, technique: &str) -> ShadowNode {
        let node = ShadowNode::new(technique);
        let node = if self.receivers.is_empty() { node } else { node.with_receivers(self.receivers.clone()) };
        if self.beside.is_empty() {
            return node;
        }
        let is_mesh = |key: &NodeKey| {
            self.scene.node(*key).is_some_and(|node| matches!(node.content, Content::Mesh(_)))
        };
        let is_beside = |key: &NodeKey| self.beside.iter().any(|(other, _)| other == key);
        let keys = self.scene.depth_first().into_iter();
        node.with_casters(keys.filter(|key| is_mesh(key) && !is_beside(key)))
    }

    /// These points are lit by the first light.
    pub(super) fn lit(self, points: &[DVec3]) -> Self {
        self.factor(points, [1.0; 3])
    }

    /// These points are dark for the first light.
    pub(super) fn dark(self, points: &[DVec3]) -> Self {
        self.factor(points, [0.0; 3])
    }

    /// At these points the first light has this factor.
    pub(super) fn factor(self, points: &[DVec3], factor: [f32; 3]) -> Self {
        self.probes(0, points, factor)
    }

    /// At these points the light of this number has this factor.
    pub(super) fn probes(mut self, light: usize, points: &[DVec3], factor: [f32; 3]) -> Self {
        let probe = |point: &DVec3| Probe { p_in_world: *point, light: format!("light{light}"), factor };
        self.probes.extend(points.iter().map(probe));
        self
    }

    /// The control: a small box floating to the right, whose shadow under the light must be there whatever the case
    /// is about, so that a technique that draws nothing fails.
    pub(super) fn control(self) -> Self {
        self.caster(block(v(2.0, 1.0, 1.0), v(0.3, 0.3, 0.3)).named("control"))
    }

    /// The finished case; every scene's shadow nodes are added here, the one that is tried first.
    pub(super) fn into_case(
        mut self,
        id: &'static str,
        what_breaks: &'static str,
        about: About,
        cast: &Cast,
    ) -> Case {
        let node = self.tried(cast.tried);
        self.scene.add_shadow("shadows", node);
        for (caster, radius_m) in self.beside {
            let node = ShadowNode::new(cast.sized).with_param("radius", ParamValue::Number(radius_m));
            self.scene.add_shadow("beside", node.with_casters([caster]));
        }
        let camera = Camera { name: "main".into(), projection: self.projection };
        self.scene.add_camera(camera.clone(), self.eye, self.target);
        Case {
            id,
            variant: self.variant,
            what_breaks,
            scene: self.scene,
            camera: CameraSnapshot::looking(camera, self.eye, self.target),
            size_px: self.size_px,
            antialias: self.antialias,
            options: self.options,
            about,
            expect: self.expect,
            probes: self.probes,
            is_heavy: false,
        }
    }
}
