//! Skins and animations: what moves the nodes and bends the meshes.

use std::cell::OnceCell;
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DMat4};

use super::GltfError;
use super::accessors::{Accessors, Integers};
use super::fields::Item;
use super::hierarchy::Hierarchy;
use super::limits::{Budget, Warnings};
use super::nodes::Builder;
use super::transforms::parts;
use crate::scene::{
    Animation, Channel, Content, Interpolation, NodeKey, Property, Scene, SceneError, Skin, SkinKey, Track,
};

impl Builder<'_> {
    /// Reads what moves nodes and bends meshes, once every node has its key.
    pub(super) fn bend(
        &mut self,
        nodes: &[Item<'_>],
        hierarchy: &Hierarchy,
        order: &[usize],
        keys: &[Option<NodeKey>],
        instanced: &[bool],
    ) -> Result<(), GltfError> {
        let document = self.document;
        let mut reader = Reader {
            accessors: &self.accessors,
            budget: &mut self.budget,
            warnings: &mut self.warnings,
            scene: &mut self.scene,
            nodes,
            hierarchy,
            keys,
            instanced,
            skins: HashMap::new(),
            spans: OnceCell::new(),
        };
        for &index in order.iter().filter(|index| !instanced[**index]) {
            let Some(skin) = nodes[index].index("skin", "skin", document.skins.len())? else { continue };
            let Some(key) = keys[index] else { continue };
            reader.wear(&nodes[index], key, skin)?;
        }
        let index_of: HashMap<NodeKey, usize> =
            order.iter().filter_map(|index| Some((keys[*index]?, *index))).collect();
        for (index, value) in document.animations.iter().enumerate() {
            let item = Item::new("animation", index, value)?;
            if let Some(animation) = reader.animation(&item)? {
                reader.add_animation(&item, animation, &index_of)?;
            }
        }
        Ok(())
    }
}

/// What the scene refuses of an item; the loader says itself which item it is about.
fn refused(item: &Item<'_>, error: SceneError) -> GltfError {
    let problem = match error {
        SceneError::BadContent { problem, .. } => problem,
        other => other.to_string(),
    };
    GltfError::Content { item: item.label(), problem }
}

/// What skins and animations are read with.
struct Reader<'r, 'a> {
    accessors: &'r Accessors<'a>,
    budget: &'r mut Budget,
    warnings: &'r mut Warnings,
    scene: &'r mut Scene,
    nodes: &'r [Item<'r>],
    hierarchy: &'r Hierarchy,
    /// The scene's node, for glTF nodes that are in the scene.
    keys: &'r [Option<NodeKey>],
    /// Whether a node's mesh was spread over instances.
    instanced: &'r [bool],
    /// The skins read so far.
    skins: HashMap<usize, SkinKey>,
    /// See [`Hierarchy::spans`]; only skins need them.
    spans: OnceCell<Vec<(usize, Range<usize>)>>,
}

impl Reader<'_, '_> {
    /// Gives a node's mesh its skin. One without a mesh, or with a mesh whose vertices name no joint, is ignored with a warning.
    fn wear(&mut self, node: &Item<'_>, key: NodeKey, skin: usize) -> Result<(), GltfError> {
        let Some(Content::Mesh(mut content)) = self.scene.node(key).map(|node| node.content.clone()) else {
            self.warnings.add(format!("{}: a skin without a mesh is ignored", node.label()));
            return Ok(());
        };
        let Some(highest) = self.scene.mesh(content.mesh).and_then(|mesh| mesh.highest_joint()) else {
            let label = node.label();
            self.warnings.add(format!("{label}: its skin is ignored, since no vertex names a joint"));
            return Ok(());
        };
        let skin_key = match self.skins.get(&skin) {
            Some(key) => *key,
            None => self.add_skin(skin)?,
        };
        let joints = self.scene.skin(skin_key).map_or(0, |skin| skin.joints.len());
        if highest >= joints {
            let (item, field) = (node.label(), "skin".into());
            let problem =
                format!("{skin} has {joints} joints, but a vertex names joint {highest} (counted from 0)");
            return Err(GltfError::Field { item, field, problem });
        }
        content.skin = Some(skin_key);
        if let Some(node) = self.scene.node_mut(key) {
            node.content = Content::Mesh(content);
        }
        Ok(())
    }

    fn add_skin(&mut self, index: usize) -> Result<SkinKey, GltfError> {
        let item = Item::new("skin", index, &self.accessors.document.skins[index])?;
        self.compare_roots(&item)?;
        let skin = self.skin(&item)?;
        let key = self.scene.add_skin(skin).map_err(|error| refused(&item, error))?;
        self.skins.insert(index, key);
        Ok(key)
    }

    /// Adds an animation. The nodes that it moves keep translation, rotation and scale as they stand in the file, not as they
    /// are found again in a matrix.
    fn add_animation(
        &mut self,
        item: &Item<'_>,
        animation: Animation,
        index_of: &HashMap<NodeKey, usize>,
    ) -> Result<(), GltfError> {
        for channel in &animation.channels {
            let Some(&index) = index_of.get(&channel.node) else { continue };
            if self.scene.node(channel.node).is_some_and(|node| node.rest().is_none())
                && let Some(parts) = parts(&self.nodes[index])?
            {
                self.scene.set_transform(channel.node, parts).map_err(|error| refused(item, error))?;
            }
        }
        self.scene.add_animation(animation).map_err(|error| refused(item, error))?;
        Ok(())
    }

    /// Remarks on joints without a common root, and a skeleton that is none.
    fn compare_roots(&self, item: &Item<'_>) -> Result<(), GltfError> {
        let spans = self.spans.get_or_init(|| self.hierarchy.spans());
        let joints = item.indices("joints", "node", self.keys.len())?;
        let document = self.accessors.document;
        if joints.windows(2).any(|pair| spans[pair[0]].0 != spans[pair[1]].0) {
            document.note(format!("{}: its joints have no common root", item.label()));
        }
        let skeleton = item.get("skeleton").and_then(serde_json::Value::as_u64);
        let skeleton = skeleton.map(|node| spans.get(node as usize).map_or(0..0, |(_, span)| span.clone()));
        if skeleton.is_some_and(|under| joints.iter().any(|joint| !under.contains(&spans[*joint].1.start))) {
            document.note(format!("{}: its skeleton is no node above all its joints", item.label()));
        }
        Ok(())
    }

    /// Reads a skin, all of whose joints must be in the scene.
    fn skin(&mut self, item: &Item<'_>) -> Result<Skin, GltfError> {
        let content = |problem: String| GltfError::Content { item: item.label(), problem };
        let joints = item.indices("joints", "node", self.keys.len())?;
        if joints.is_empty() {
            return Err(content("it has no joints (at least 1 is needed)".into()));
        }
        let key = |joint: &usize| {
            self.keys[*joint].ok_or_else(|| {
                content(format!(
                    "joint node {joint} is not in the loaded scene (nodes of that scene are accepted)"
                ))
            })
        };
        let keys: Vec<NodeKey> = joints.iter().map(key).collect::<Result<_, _>>()?;
        let accessors = self.accessors.document.accessors.len();
        let Some(binds) = item.index("inverseBindMatrices", "accessor", accessors)? else {
            return Ok(Skin::new(item.name().unwrap_or_default(), keys, Vec::new()));
        };
        let binds = self.accessors.matrices(binds, "inverseBindMatrices", self.budget)?;
        if binds.len() < keys.len() {
            return Err(content(format!(
                "it has {} inverse bind matrices for {} joints",
                binds.len(),
                keys.len()
            )));
        }
        let affine = |(joint, bind): (usize, [f32; 16])| {
            let matrix = bind.map(f64::from);
            if [matrix[3], matrix[7], matrix[11], matrix[15] - 1.0].iter().any(|x| x.abs() > 1e-5) {
                let row = "0 0 0 1 is needed as its last row";
                return Err(content(format!("inverse bind matrix {joint} is not affine ({row})")));
            }
            Ok(DAffine3::from_mat4(DMat4::from_cols_array(&matrix)))
        };
        let binds = binds.into_iter().take(keys.len()).enumerate().map(affine).collect::<Result<_, _>>()?;
        Ok(Skin::new(item.name().unwrap_or_default(), keys, binds))
    }

    /// Reads an animation; `None` for one that moves nothing of the scene.
    fn animation(&mut self, item: &Item<'_>) -> Result<Option<Animation>, GltfError> {
        let samplers = item.objects("samplers")?;
        let mut tracks: HashMap<(usize, Property), Arc<Track>> = HashMap::new();
        let mut channels = Vec::new();
        let mut moved = HashSet::new();
        for channel in item.objects("channels")? {
            let target = channel.inner("target")?.ok_or_else(|| channel.wrong("target", "is missing"))?;
            let path = target.get("path").and_then(|path| path.as_str()).unwrap_or_default();
            let property = match path {
                "translation" => Property::Translation,
                "rotation" => Property::Rotation,
                "scale" => Property::Scale,
                "weights" => Property::Weights,
                _ => {
                    let path: String = path.chars().take(40).collect();
                    self.warnings.add(format!("{}: channels for '{path}' are ignored", item.label()));
                    continue;
                }
            };
            let sampler = channel.index("sampler", "sampler", samplers.len())?;
            let sampler = sampler.ok_or_else(|| channel.wrong("sampler", "is missing"))?;
            // Extensions may move other things than nodes.
            let Some(node) = target.index("node", "node", self.keys.len())? else {
                self.warnings.add(format!("{}: channels without a node are ignored", item.label()));
                continue;
            };
            let Some(key) = self.keys[node] else { continue };
            if property == Property::Weights && self.instanced[node] {
                self.warnings.add(format!("{}: weights of instanced meshes are not animated", item.label()));
                continue;
            }
            let document = self.accessors.document;
            if !moved.insert((node, property)) {
                document.note(format!("{}: it moves one property of node {node} twice", item.label()));
            }
            if property != Property::Weights && document.nodes[node].get("matrix").is_some() {
                document.note(format!("{}: it moves node {node}, which has a matrix", item.label()));
            }
            let track = match tracks.get(&(sampler, property)) {
                Some(track) => Arc::clone(track),
                None => {
                    let track = Arc::new(self.track(item, sampler, &samplers[sampler], property)?);
                    tracks.insert((sampler, property), Arc::clone(&track));
                    track
                }
            };
            channels.push(Channel { node: key, track });
        }
        let name = item.name().map_or_else(|| format!("animation{}", item.index), str::to_owned);
        Ok((!channels.is_empty()).then_some(Animation { name, channels }))
    }

    fn track(
        &mut self,
        item: &Item<'_>,
        index: usize,
        sampler: &Item<'_>,
        property: Property,
    ) -> Result<Track, GltfError> {
        let accessors = self.accessors.document.accessors.len();
        let needed = |field: &str| {
            sampler.index(field, "accessor", accessors)?.ok_or_else(|| sampler.wrong(field, "is missing"))
        };
        let (input, output) = (needed("input")?, needed("output")?);
        let interpolation = match sampler.get("interpolation").map(|word| word.as_str()) {
            None | Some(Some("LINEAR")) => Interpolation::Linear,
            Some(Some("STEP")) => Interpolation::Step,
            Some(Some("CUBICSPLINE")) => Interpolation::CubicSpline,
            Some(_) => return Err(sampler.wrong("interpolation", "must be LINEAR, STEP or CUBICSPLINE")),
        };
        let (of, budget) = (self.accessors, &mut *self.budget);
        let times = of.floats::<1>(input, "animation times", Integers::AsDeclared, budget)?;
        let values = match property {
            Property::Translation | Property::Scale => {
                of.floats::<3>(output, "animation values", Integers::Normalized, budget)?.into_flattened()
            }
            Property::Rotation => {
                of.floats::<4>(output, "animation values", Integers::Normalized, budget)?.into_flattened()
            }
            Property::Weights => {
                of.floats::<1>(output, "animation values", Integers::Normalized, budget)?.into_flattened()
            }
        };
        let document = of.document;
        if times.windows(2).any(|pair| pair[0] >= pair[1]) {
            document.note(format!("{}: the times of sampler {index} do not grow", item.label()));
        }
        if !of.has_bounds(input) {
            document.note(format!("{}: the times of sampler {index} have no min and max", item.label()));
        }
        let is_off = |q: &[f32]| (q.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() > 0.01;
        if property == Property::Rotation
            && interpolation != Interpolation::CubicSpline
            && values.chunks(4).any(is_off)
        {
            document.note(format!("{}: rotations of sampler {index} have not length 1", item.label()));
        }
        Track::new(property, interpolation, times.into_flattened(), values).map_err(|error| {
            GltfError::Content {
                item: format!("{}, sampler {index}", item.label()),
                problem: error.to_string(),
            }
        })
    }
}
