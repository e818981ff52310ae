//! The scene a command works on: loaded, then changed as the arguments say.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::{DAffine3, DVec3};
use shadowgraph::engine::gltf::{GltfError, LoadOptions, Loaded, SceneChoice, ShadowTypes, load_with};
use shadowgraph::engine::math::{Aabb, Projection};
use shadowgraph::engine::scene::{AnimationKey, look_at};
use shadowgraph::engine::shadow::receivers_for;
use shadowgraph::engine::shadow::{Catalog, ShadowError};
use shadowgraph::measure::ReferenceShadow;
use shadowgraph::prelude::*;

use super::args::{Floor, LightArg, Size, TechniqueArg, seconds, vector};
use super::output::note;
use super::{Failure, other};

/// The field of view where neither the scene nor the arguments name one.
const DEFAULT_FOV_Y_DEG: f64 = 45.0;

/// What every command that looks at a scene accepts.
#[derive(Debug, Default, Args)]
pub(crate) struct SceneArgs {
    /// A .gltf or .glb file.
    pub(crate) scene: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "1280x720", value_name = "WxH")]
    pub(crate) size: Size,
    /// The camera of this name instead of the first.
    #[arg(long, value_name = "NAME")]
    pub(crate) camera: Option<String>,
    /// Where the eye is, instead of the scene's camera.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, requires = "target", conflicts_with = "camera")]
    pub(crate) eye: Option<DVec3>,
    /// What it looks at.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, requires = "eye")]
    pub(crate) target: Option<DVec3>,
    /// The vertical field of view of that eye, or where a scene has no camera, in degrees [default: 45].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, conflicts_with = "camera")]
    pub(crate) fov_y: Option<f64>,
    /// One node of this technique over all lights and meshes, instead of the scene's own; `none` for no shadows.
    #[arg(long, value_name = "NAME[:key=value,..]")]
    pub(crate) technique: Option<TechniqueArg>,
    /// A light instead of the scene's: point:X,Y,Z, directional:X,Y,Z or spot:X,Y,Z:DX,DY,DZ:DEG; repeatable.
    #[arg(long = "light", value_name = "LIGHT", allow_hyphen_values = true)]
    pub(crate) lights: Vec<LightArg>,
    /// Adds a square, matt, light-grey receiver that casts nothing.
    #[arg(long, value_name = "Y:HALF_SIZE", allow_hyphen_values = true)]
    pub(crate) floor: Option<Floor>,
    /// The file's scene of this name or index (counted from 0), instead of its default one.
    #[arg(long = "scene", value_name = "NAME|INDEX", id = "scene-of-file")]
    pub(crate) which_scene: Option<String>,
    /// Shows the scene's first animation at this time; its end is kept after it.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) time: Option<f64>,
    /// The animation of this name instead of the first.
    #[arg(long, value_name = "NAME", requires = "time")]
    pub(crate) animation: Option<String>,
    #[command(flatten)]
    pub(crate) trust: TrustArgs,
}

/// How far a file from elsewhere is trusted.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct TrustArgs {
    /// Reads buffers and images that lie outside the scene's folder as well; they are refused otherwise.
    #[arg(long)]
    pub(crate) outside_files: bool,
    /// The most memory that the scene's meshes and images may take, in MiB, images at most half of it [default: 2048].
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..=1 << 30))]
    pub(crate) memory: Option<u64>,
}

/// Every technique the command line knows: those of the project, and the reference as one more.
pub(crate) fn catalog() -> Catalog {
    let mut catalog = shadowgraph::nodes::catalog();
    catalog.register(ReferenceShadow::ENTRY);
    catalog
}

struct KnownTypes(Catalog);

impl ShadowTypes for KnownTypes {
    fn check(&self, node: &ShadowNode) -> Result<(), String> {
        self.0.technique("", node).map(|_| ()).map_err(|error| match error {
            // The loader says which node it is.
            ShadowError::Option { source, .. } => source.to_string(),
            error => error.to_string().trim_start_matches("shadow node '': ").to_owned(),
        })
    }
}

/// Loads the chosen scene of `path`, checking its shadow nodes; warnings go to stderr.
pub(crate) fn load(path: &Path, which: Option<&str>, trust: TrustArgs) -> Result<Loaded, Failure> {
    let types = KnownTypes(catalog());
    let with = |scene| {
        let options = LoadOptions {
            scene,
            shadow_types: Some(&types),
            outside_files: trust.outside_files,
            memory_budget: trust.memory.map(|mib| mib << 20),
        };
        load_with(path, &options)
    };
    let loaded = match which {
        None => with(SceneChoice::Default),
        // A scene may be called by a number; where none is, it is an index.
        Some(name) => match (with(SceneChoice::Name(name)), name.parse()) {
            (Err(GltfError::NoSuchSceneName { .. }), Ok(index)) => with(SceneChoice::Index(index)),
            (loaded, _) => loaded,
        },
    };
    let loaded = loaded.map_err(|error| {
        if which.is_some()
            && matches!(error, GltfError::NoSuchScene { .. } | GltfError::NoSuchSceneName { .. })
        {
            return Failure::Usage(format!("--scene: {error}"));
        }
        // Whatever is wrong, the file is part of what is named.
        let (shown, said) = (path.display().to_string(), error.to_string());
        if said.contains(&shown) { Failure::Gltf(error) } else { other(format!("'{shown}': {said}")) }
    })?;
    loaded.warnings.iter().for_each(|warning| note!("warning: {warning}"));
    Ok(loaded)
}

impl SceneArgs {
    /// The scene as it is.
    pub(crate) fn plain(scene: PathBuf, trust: TrustArgs) -> Self {
        Self { scene, trust, ..Self::default() }
    }

    /// The scene with everything the arguments change, the camera, and every file that was read.
    pub(crate) fn prepare(&self) -> Result<(Scene, CameraSnapshot, Vec<PathBuf>), Failure> {
        let mut loaded = load(&self.scene, self.which_scene.as_deref(), self.trust)?;
        let files = std::mem::take(&mut loaded.files);
        let (scene, camera) = self.prepare_loaded(loaded.scene)?;
        Ok((scene, camera, files))
    }

    /// [`SceneArgs::prepare`] of a scene that was loaded as these arguments say.
    pub(crate) fn prepare_loaded(&self, mut scene: Scene) -> Result<(Scene, CameraSnapshot), Failure> {
        self.animate(&mut scene)?;
        if scene.meshes().next().is_none() && self.floor.is_none() {
            return Err(Failure::Other(format!(
                "'{}' has no mesh: there is nothing to see",
                self.scene.display()
            )));
        }
        // What is framed is the scene, not the floor put under it.
        let mut framed_bounds = scene.snapshot().map_err(RenderError::from)?.world_bounds;
        if let Some(floor) = &self.floor {
            add_floor(&mut scene, floor)?;
        }
        if let Some(technique) = &self.technique {
            replace_shadows(&mut scene, technique)?;
        }
        if !self.lights.is_empty() {
            replace_lights(&mut scene, &self.lights)?;
        } else if scene.snapshot().map_err(RenderError::from)?.lights.is_empty() {
            let direction = DVec3::new(-0.5, -1.0, -0.35).normalize();
            note!("note: the scene has no light; lit by directional:{direction:.3}");
            replace_lights(&mut scene, &[LightArg::Directional { direction }])?;
        }
        if framed_bounds.is_empty() {
            framed_bounds = scene.snapshot().map_err(RenderError::from)?.world_bounds;
        }
        let camera = self.camera(&scene, &framed_bounds)?;
        Ok((scene, camera))
    }

    /// Shows the animation that was asked for at the time that was asked for.
    fn animate(&self, scene: &mut Scene) -> Result<(), Failure> {
        let Some(seconds) = self.time else { return Ok(()) };
        let clip = self.clip(scene, "--time")?;
        Ok(scene.animate(clip, seconds).map_err(RenderError::from)?)
    }

    /// The animation that was asked for, for what `option` does with it.
    pub(crate) fn clip(&self, scene: &Scene, option: &str) -> Result<AnimationKey, Failure> {
        let names = || {
            let names =
                scene.animations().map(|(_, animation)| format!("'{}'", animation.name.escape_debug()));
            names.collect::<Vec<_>>().join(", ")
        };
        let first = scene.animations().next().map(|(key, _)| key);
        let first = first.ok_or_else(|| Failure::Usage(format!("{option}: the scene has no animation")))?;
        match &self.animation {
            None => Ok(first),
            Some(name) => scene.find_animation(name).ok_or_else(|| {
                Failure::Usage(format!("no animation is called '{name}' (there are: {})", names()))
            }),
        }
    }

    fn camera(&self, scene: &Scene, framed_bounds: &Aabb) -> Result<CameraSnapshot, Failure> {
        let fov_y_deg = self.fov_y.unwrap_or(DEFAULT_FOV_Y_DEG);
        let fov_y_rad = fov_y_deg.to_radians();
        if !(fov_y_deg > 0.0 && fov_y_deg < 180.0) {
            return Err(Failure::Usage(format!("--fov-y is {fov_y_deg}, accepted: above 0 and below 180")));
        }
        if let (Some(eye), Some(target)) = (self.eye, self.target) {
            if (target - eye).try_normalize().is_none() {
                return Err(Failure::Usage("--eye and --target are the same point".into()));
            }
            return Ok(CameraSnapshot::looking(Camera::perspective("eye", fov_y_rad), eye, target));
        }
        let snapshot = scene.snapshot().map_err(RenderError::from)?;
        let names = || match &snapshot.cameras[..] {
            [] => "none".to_owned(),
            all => all.iter().map(|c| format!("'{}'", c.name)).collect::<Vec<_>>().join(", "),
        };
        match &self.camera {
            Some(name) => {
                snapshot.cameras.iter().find(|camera| camera.name == *name).cloned().ok_or_else(|| {
                    Failure::Usage(format!("no camera is called '{name}' (there are: {})", names()))
                })
            }
            // The field of view would be ignored without a word.
            None if self.fov_y.is_some() && !snapshot.cameras.is_empty() => Err(Failure::Usage(
                "--fov-y needs --eye and --target: the scene's own camera has a field of view".into(),
            )),
            None => match snapshot.cameras.first() {
                Some(first) => Ok(first.clone()),
                None => self.framed_camera(framed_bounds, fov_y_rad),
            },
        }
    }

    /// The camera of a scene without one, said on stderr.
    fn framed_camera(&self, bounds: &Aabb, fov_y_rad: f64) -> Result<CameraSnapshot, Failure> {
        let camera = framed(bounds, fov_y_rad, self.size.0);
        if !(camera.projection.is_valid() && camera.world_from_view.is_finite()) {
            return Err(Failure::Other(
                "the scene reaches too far to be framed; --eye and --target say from where to look".into(),
            ));
        }
        let eye = camera.world_from_view.translation;
        note!("note: the scene has no camera; framed from {:.3},{:.3},{:.3}", eye.x, eye.y, eye.z);
        Ok(camera)
    }
}

/// A camera from the front, a little above and beside, that has everything in view.
pub(crate) fn framed(bounds: &Aabb, fov_y_rad: f64, size_px: [u32; 2]) -> CameraSnapshot {
    let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
    let half_angle = (fov_y_rad * 0.5).min(((fov_y_rad * 0.5).tan() * aspect).atan());
    let radius_m = bounds.radius().max(1e-9);
    let distance_m = radius_m / half_angle.sin();
    let target = bounds.center();
    let eye = target + DVec3::new(0.45, 0.4, 1.0).normalize() * distance_m;
    let near_m = (distance_m * 0.01).min(0.1);
    CameraSnapshot {
        key: None,
        name: "framed".into(),
        world_from_view: look_at(eye, target),
        projection: Projection::Perspective { fov_y_rad, near_m },
    }
}

fn add_floor(scene: &mut Scene, floor: &Floor) -> Result<(), Failure> {
    let data = shapes::plane(Vec2::splat(floor.half_size_m as f32)).named("floor");
    let mesh = Mesh::new(data).map_err(other)?;
    let material = Material::matt("floor", Vec3::splat(0.7));
    let at = DAffine3::from_translation(DVec3::Y * floor.y_m);
    let key = scene.add_mesh(mesh, material, at);
    if let Some(node) = scene.node_mut(key)
        && let Content::Mesh(content) = &mut node.content
    {
        content.shadow.casts = false;
    }
    Ok(())
}

/// Takes the scene's shadow nodes out, and puts one of `technique` in.
fn replace_shadows(scene: &mut Scene, technique: &TechniqueArg) -> Result<(), Failure> {
    clear_contents(scene, |content| matches!(content, Content::Shadow(_)));
    if technique.name == "none" {
        return match technique.params.keys().next() {
            None => Ok(()),
            Some(option) => Err(Failure::Usage(format!("technique none has no option '{option}'"))),
        };
    }
    let catalog = catalog();
    let entry = catalog.find(&technique.name).ok_or_else(|| {
        let names: Vec<&str> = catalog.entries().iter().map(|entry| entry.short_name).collect();
        Failure::Usage(format!(
            "no technique is called '{}' (there are: none, {})",
            technique.name,
            names.join(", ")
        ))
    })?;
    let made = (entry.from_params)(&technique.params).map_err(|error| Failure::Usage(error.to_string()))?;
    let mut node = ShadowNode::new(entry.type_name);
    node.params = technique.params.clone();
    node.receivers = receivers_for(&scene.snapshot().map_err(RenderError::from)?, made.as_ref());
    scene.add_shadow(entry.short_name, node);
    Ok(())
}

/// Takes the scene's lights out and puts `lights` in: white, each as bright as the others at the scene's middle.
fn replace_lights(scene: &mut Scene, lights: &[LightArg]) -> Result<(), Failure> {
    clear_contents(scene, |content| matches!(content, Content::Light(_)));
    let bounds = scene.snapshot().map_err(RenderError::from)?.world_bounds;
    let candela = |position: DVec3| {
        let distance_m = position.distance(bounds.center()).max(bounds.radius() * 0.5).max(1e-9);
        (3.0 * distance_m * distance_m) as f32
    };
    for (index, light) in lights.iter().enumerate() {
        let name = format!("light{index}");
        match *light {
            LightArg::Point { position } => {
                scene.add_light(Light::point(&name, candela(position)), position, position + DVec3::NEG_Z)
            }
            LightArg::Directional { direction } => {
                scene.add_light(Light::directional(&name, 3.0), DVec3::ZERO, direction)
            }
            LightArg::Spot { position, direction, outer_rad } => {
                let light = Light::spot(&name, candela(position), outer_rad);
                scene.add_light(light, position, position + direction)
            }
        };
    }
    // Shadow nodes that named lights of the scene now serve those that took their place.
    let shadows: Vec<_> = scene.shadows().map(|(key, _)| key).collect();
    for key in shadows {
        if let Some(shadow) = scene.shadow_mut(key) {
            shadow.lights = Scope::All;
        }
    }
    Ok(())
}

fn clear_contents(scene: &mut Scene, unwanted: impl Fn(&Content) -> bool) {
    let keys: Vec<_> =
        scene.nodes().filter(|(_, node)| unwanted(&node.content)).map(|(key, _)| key).collect();
    for key in keys {
        if let Some(node) = scene.node_mut(key) {
            node.content = Content::Group;
        }
    }
}
