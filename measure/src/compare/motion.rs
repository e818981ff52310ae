//! Frames of a scene in which something moves, so that the cost of motion can be told from that of standing still.

use glam::{DAffine3, DVec3};
use shadowgraph_engine::render::FrameRequest;
use shadowgraph_engine::scene::{AnimationKey, CameraSnapshot, Content, NodeKey, Scene, SceneError};

/// What moves from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Nothing.
    Still,
    /// The camera goes round the scene's middle.
    Eye,
    /// All lights go round it.
    Lights,
    /// The caster with the most triangles turns on the spot.
    Caster,
    /// An animation plays over and over, from a time in seconds on.
    Clip(AnimationKey, f64),
}

impl Motion {
    /// Those that any scene can have.
    pub const OF_ANY_SCENE: [Self; 4] = [Self::Still, Self::Eye, Self::Lights, Self::Caster];

    /// What moves, in a word or two.
    pub fn name(self) -> &'static str {
        match self {
            Self::Still => "nothing",
            Self::Eye => "the eye",
            Self::Lights => "the lights",
            Self::Caster => "a caster",
            Self::Clip(..) => "an animation",
        }
    }
}

/// How far everything turns from one frame to the next: 1°, a round in six seconds.
const STEP_RAD: f64 = std::f64::consts::PI / 180.0;
/// The time between two frames of an animation.
const STEP_S: f64 = 1.0 / 60.0;

/// A scene in motion: of each frame the scene, and from where it is seen.
#[derive(Clone, Debug)]
pub struct Moving {
    /// The scene as the last frame shows it.
    pub scene: Scene,
    /// The request of the last frame.
    pub request: FrameRequest,
    motion: Motion,
    camera: CameraSnapshot,
    /// Where what moves began, in the world.
    nodes: Vec<(NodeKey, DAffine3)>,
    /// What it turns about, upright.
    middle: DVec3,
}

impl Moving {
    /// The first frame: `scene` and `request` as they are.
    ///
    /// # Errors
    /// What is wrong with the scene.
    pub fn new(scene: Scene, request: FrameRequest, motion: Motion) -> Result<Self, SceneError> {
        let snapshot = scene.snapshot()?;
        let mut middle = snapshot.world_bounds.center();
        let nodes: Vec<NodeKey> = match motion {
            Motion::Still | Motion::Eye | Motion::Clip(..) => vec![],
            Motion::Lights => {
                let lights = scene.nodes().filter(|(_, node)| matches!(node.content, Content::Light(_)));
                lights.map(|(key, _)| key).collect()
            }
            Motion::Caster => {
                let casters = snapshot.instances.iter().filter(|instance| instance.shadow.casts);
                let largest = casters.max_by_key(|instance| instance.mesh.triangle_count());
                middle = largest.map_or(middle, |instance| instance.world_bounds.center());
                largest.map(|instance| instance.node).into_iter().collect()
            }
        };
        let placed = nodes.into_iter().filter_map(|key| Some((key, scene.world_from_local(key)?)));
        let nodes = placed.collect();
        Ok(Self { motion, camera: request.camera.clone(), nodes, middle, scene, request })
    }

    /// Moves everything to where frame `number` has it.
    ///
    /// # Errors
    /// What is wrong with an animation.
    pub fn show(&mut self, number: usize) -> Result<(), SceneError> {
        let turn = DAffine3::from_translation(self.middle)
            * DAffine3::from_rotation_y(STEP_RAD * number as f64)
            * DAffine3::from_translation(-self.middle);
        match self.motion {
            Motion::Still => {}
            Motion::Eye => self.request.camera.world_from_view = turn * self.camera.world_from_view,
            Motion::Lights | Motion::Caster => {
                for (key, world_from_local) in &self.nodes {
                    let parent = self.scene.node(*key).and_then(|node| node.parent());
                    let world_from_parent = parent.and_then(|parent| self.scene.world_from_local(parent));
                    let parent_from_world = world_from_parent.unwrap_or(DAffine3::IDENTITY).inverse();
                    if let Some(node) = self.scene.node_mut(*key) {
                        node.parent_from_local = parent_from_world * turn * *world_from_local;
                    }
                }
            }
            Motion::Clip(animation, from_s) => {
                let seconds = from_s + STEP_S * number as f64;
                let looped = self.scene.animation(animation).map_or(seconds, |clip| clip.looped(seconds));
                self.scene.animate(animation, looped)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use shadowgraph_engine::geometry::{Mesh, shapes};
    use shadowgraph_engine::scene::{Camera, Light, Material};

    use super::*;

    fn place(scene: &Scene, name: &str) -> DAffine3 {
        scene.world_from_local(scene.find(name).expect("it is there")).expect("it is there")
    }

    #[test]
    fn what_is_to_move_moves_and_nothing_else() {
        let mut scene = Scene::new();
        let cuboid =
            || Mesh::new(shapes::cuboid(glam::Vec3::ZERO, glam::Vec3::ONE).named("box")).expect("valid");
        let group = scene.add_group("group");
        let caster = scene.add_mesh(cuboid(), Material::default(), DAffine3::from_translation(DVec3::X));
        scene.reparent(caster, Some(group)).expect("both are there");
        let turned = DAffine3::from_rotation_x(0.5) * DAffine3::from_translation(DVec3::Y);
        scene.node_mut(group).expect("it is there").parent_from_local = turned;
        scene.add_lamp(Light::point("lamp", 1.0), DVec3::new(3.0, 4.0, 0.0));
        let camera = CameraSnapshot::looking(Camera::perspective("eye", 0.8), DVec3::splat(5.0), DVec3::ZERO);
        let request = FrameRequest::new(camera, [4, 4]);
        for motion in Motion::OF_ANY_SCENE {
            let mut moving = Moving::new(scene.clone(), request.clone(), motion).expect("the scene is valid");
            let start = moving.clone();
            moving.show(0).expect("it moves");
            let near = |a: DAffine3, b: DAffine3| a.abs_diff_eq(b, 1e-12);
            assert!(near(place(&moving.scene, "box"), place(&scene, "box")), "{motion:?}");
            moving.show(90).expect("it moves");
            let moved = |name: &str| !near(place(&moving.scene, name), place(&start.scene, name));
            assert_eq!(moved("box"), motion == Motion::Caster);
            assert_eq!(moved("lamp"), motion == Motion::Lights);
            assert_eq!(moving.request != start.request, motion == Motion::Eye);
            // On its spot, a quarter of a turn: the box's middle stays.
            let middle = |moving: &Moving| place(&moving.scene, "box").transform_point3(DVec3::splat(0.5));
            assert!(middle(&moving).distance(middle(&start)) < 1e-12, "{motion:?}");
            let height = |moving: &Moving| place(&moving.scene, "lamp").translation.y;
            assert!((height(&moving) - 4.0).abs() < 1e-12, "{motion:?}");
        }
    }
}
