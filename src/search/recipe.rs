//! A scene of the search as plain data: what it holds can be compared, counted and taken away piece by piece, which a scene
//! graph of keys does not make easy.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use shadowgraph_engine::geometry::{Influences, Mesh, MeshData, MeshError, MorphTarget};
use shadowgraph_engine::gltf::GltfError;
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::scene::{
    AlphaMode, Camera, Content, Image, Light, LightKind, Material, MeshNode, NodeKey, Params, Scene,
    SceneError, ShadowNode, Skin, TextureRef,
};
use shadowgraph_engine::shadow::Catalog;
use thiserror::Error;

use super::{Family, Random};
use shadowgraph_engine::shadow::receivers_for;

/// Why a recipe makes no scene: a mistake of the generator, never an answer.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "each is explained where it is defined")]
pub enum RecipeError {
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Gltf(#[from] GltfError),
}

/// A random scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// What it was drawn from.
    pub seed: u64,
    /// What kind of scene it is.
    pub family: Family,
    /// The frame.
    pub size_px: [u32; 2],
    /// Where it is looked at from.
    pub eye: Eye,
    /// The meshes.
    pub bodies: Vec<Body>,
    /// The lights.
    pub lamps: Vec<Lamp>,
    /// The shadow nodes.
    pub nodes: Vec<Caster>,
    /// Where all of it stands in the world.
    pub shift: DVec3,
}

/// The camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Eye {
    /// Where it is.
    pub position: DVec3,
    /// What it looks at.
    pub target: DVec3,
    /// How it projects.
    pub projection: Projection,
}

/// A mesh at its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// What it is.
    pub name: String,
    /// Corners.
    pub positions: Vec<Vec3>,
    /// Texture coordinates; empty where nothing is worn that needs them.
    pub uvs: Vec<Vec2>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Its surface.
    pub wear: Wear,
    /// Whether back faces are drawn.
    pub double_sided: bool,
    /// The nodes it hangs from, the outermost first; the last is its own.
    pub transforms: Vec<DAffine3>,
    /// How it is bent.
    pub bend: Bend,
}

/// A surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Wear {
    /// Opaque.
    Matt,
    /// Blended: light passes in this colour, the last number being alpha.
    Glass {
        /// Base colour.
        color: [f32; 4],
        /// The share of `KHR_materials_transmission`; 0 for blending alone.
        transmission: f32,
    },
    /// Opaque, with holes where a picture of 8×8 texels drawn from this seed has none.
    Mask {
        /// The picture's seed.
        pattern: u64,
        /// Whether texels blend.
        smooth: bool,
    },
}

/// How a body is bent.
#[derive(Clone, Debug, PartialEq)]
pub enum Bend {
    /// Not at all.
    None,
    /// By a morph target.
    Morph {
        /// How far each corner moves.
        moves: Vec<Vec3>,
        /// How much of it is shown.
        weight: f64,
    },
    /// By two joints, the second hanging from the first.
    Skin {
        /// How much of each corner follows the second.
        shares: Vec<f32>,
        /// Where the second is.
        tip: DAffine3,
    },
}

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamp {
    /// What it is.
    pub kind: LightKind,
    /// Where it is, for those that are somewhere.
    pub position: DVec3,
    /// Where it shines to.
    pub direction: DVec3,
    /// Where it ends.
    pub range_m: Option<f64>,
}

/// A shadow node. Places are those in [`Recipe::bodies`] and [`Recipe::lamps`]; `None` is all.
#[derive(Clone, Debug, PartialEq)]
pub struct Caster {
    /// The technique's type name.
    pub technique: String,
    /// Its options.
    pub params: Params,
    /// Which lights.
    pub lamps: Option<Vec<usize>>,
    /// Which meshes cast.
    pub bodies: Option<Vec<usize>>,
}

impl Body {
    /// A double-sided opaque body of these corners and triangles.
    pub fn new(name: &str, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        Self {
            name: name.into(),
            positions,
            uvs: Vec::new(),
            triangles,
            wear: Wear::Matt,
            double_sided: true,
            transforms: Vec::new(),
            bend: Bend::None,
        }
    }

    /// A body of a shape's triangles.
    pub fn of(data: MeshData) -> Self {
        let (triangles, _) = data.indices.as_chunks::<3>();
        Self { uvs: data.uvs, ..Self::new(&data.name, data.positions, triangles.to_vec()) }
    }

    /// To the scene's frame from the body's own.
    pub fn frame_from_local(&self) -> DAffine3 {
        self.transforms.iter().fold(DAffine3::IDENTITY, |frame, next| frame * *next)
    }

    /// The corners of a triangle as the body stands, unbent.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        let frame = self.frame_from_local();
        self.triangles[triangle].map(|i| frame.transform_point3(self.positions[i as usize].as_dvec3()))
    }

    fn mesh(&self) -> Result<Mesh, MeshError> {
        let mut data = MeshData {
            name: self.name.clone(),
            positions: self.positions.clone(),
            uvs: self.uvs.clone(),
            indices: self.triangles.concat(),
            ..MeshData::default()
        };
        match &self.bend {
            Bend::None => {}
            Bend::Morph { moves, .. } => {
                let name = "bent".into();
                data.morphs = vec![MorphTarget { name, positions: moves.clone(), ..MorphTarget::default() }];
            }
            Bend::Skin { shares, .. } => {
                let influences = |share: &f32| Influences::new([(0, 1.0 - share), (1, *share)]);
                data.influences = shares.iter().map(influences).collect();
            }
        }
        Mesh::new(data)
    }

    fn material(&self, scene: &mut Scene) -> Material {
        let plain = Material { double_sided: self.double_sided, ..Material::matt("matt", Vec3::splat(0.7)) };
        match self.wear {
            Wear::Matt => plain,
            Wear::Glass { color, transmission } => Material {
                name: "glass".into(),
                base_color: Vec4::from(color),
                transmission,
                alpha_mode: AlphaMode::Blend,
                ..plain
            },
            Wear::Mask { pattern, smooth } => {
                let image = scene.add_image(Arc::new(picture(pattern)));
                let texture = TextureRef { smooth, ..TextureRef::new(image) };
                Material {
                    name: "mask".into(),
                    base_color_texture: Some(texture),
                    alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
                    ..plain
                }
            }
        }
    }

    /// Puts the body into `scene` under `parent`.
    fn add_to(&self, scene: &mut Scene, parent: Option<NodeKey>) -> Result<NodeKey, RecipeError> {
        let mesh = scene.add_mesh_data(Arc::new(self.mesh()?));
        let material = self.material(scene);
        let material = scene.add_material(material);
        let mut content = MeshNode::new(mesh, material);
        let (own, above) = self.transforms.split_last().unwrap_or((&DAffine3::IDENTITY, &[]));
        let mut parent = parent;
        for transform in above {
            parent = Some(scene.add(parent, "turned", *transform, Content::Group));
        }
        match &self.bend {
            Bend::None => {}
            Bend::Morph { weight, .. } => content.weights = vec![*weight],
            Bend::Skin { tip, .. } => {
                let root = scene.add(parent, "root", *own, Content::Group);
                let tip = scene.add(Some(root), "tip", *tip, Content::Group);
                content.skin = Some(scene.add_skin(Skin::new("bones", vec![root, tip], Vec::new()))?);
            }
        }
        Ok(scene.add(parent, &self.name, *own, Content::Mesh(content)))
    }
}

/// The picture of a mask: full or empty texels, and some between.
fn picture(pattern: u64) -> Image {
    let mut random = Random::new(pattern);
    let mut texel = || [200, 200, 200, random.pick(&[0_u8, 0, 60, 190, 255, 255])];
    let rgba8 = (0..64).flat_map(|_| texel()).collect();
    Image { name: "holes".into(), width: 8, height: 8, rgba8 }
}

impl Lamp {
    fn light(&self, name: &str) -> Light {
        let light = match self.kind {
            LightKind::Directional => Light::directional(name, 3.0),
            LightKind::Point => Light::point(name, 40.0),
            LightKind::Spot { outer_rad, .. } => Light::spot(name, 40.0, outer_rad),
        };
        Light { range_m: self.range_m, kind: self.kind, ..light }
    }
}

impl Recipe {
    /// The number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.bodies.iter().map(|body| body.triangles.len()).sum()
    }

    /// The scene: meshes, lights, one camera and the shadow nodes, in that order. A node whose technique shades receivers
    /// only gets those that it accepts, as on the command line.
    ///
    /// # Errors
    /// [`RecipeError`].
    pub fn build(&self, catalog: &Catalog) -> Result<Scene, RecipeError> {
        let mut scene = Scene::new();
        let shift = DAffine3::from_translation(self.shift);
        let root = (self.shift != DVec3::ZERO).then(|| scene.add(None, "shift", shift, Content::Group));
        let bodies: Vec<NodeKey> =
            self.bodies.iter().map(|body| body.add_to(&mut scene, root)).collect::<Result<_, _>>()?;
        let mut lamps = Vec::new();
        for (index, lamp) in self.lamps.iter().enumerate() {
            let (name, position) = (format!("light{index}"), lamp.position + self.shift);
            lamps.push(scene.add_light(lamp.light(&name), position, position + lamp.direction));
        }
        let Eye { position, target, projection } = self.eye;
        let camera = Camera { name: "main".into(), projection };
        scene.add_camera(camera, position + self.shift, target + self.shift);
        for (index, caster) in self.nodes.iter().enumerate() {
            let mut node = ShadowNode::new(caster.technique.clone());
            node.params = caster.params.clone();
            let keys = |all: &[NodeKey], places: &[usize]| places.iter().map(|i| all[*i]).collect::<Vec<_>>();
            if let Some(places) = &caster.lamps {
                node = node.with_lights(keys(&lamps, places));
            }
            if let Some(places) = &caster.bodies {
                node = node.with_casters(keys(&bodies, places));
            }
            // An unknown type or option is for the frame to refuse.
            if let Ok((_, technique)) = catalog.technique("", &node) {
                node.receivers = receivers_for(&scene.snapshot()?, technique.as_ref());
            }
            scene.add_shadow(&format!("shadows{index}"), node);
        }
        Ok(scene)
    }
}
