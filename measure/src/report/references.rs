//! References kept, in memory for one scene and on disk between runs: soft ones take minutes.
//!
//! A kept reference is found by a hash of all that it depends on: every vertex in the world, materials and their
//! images, lights, casters, camera and size, and the reference's own source text, so that a change to either is never
//! answered with an old picture. A file that is damaged or cut short is traced anew and replaced.

use std::collections::HashMap;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use shadowgraph_engine::render::FrameRequest;
use shadowgraph_engine::scene::SceneSnapshot;

use crate::reference::tracer::Hit;
use crate::{LightQuery, LightReference, PixelReference, Progress, Reference, ReferenceImage, SoftBounds};

/// The reference with what it took.
#[derive(Debug, PartialEq)]
pub(super) struct Traced {
    /// The pictures.
    pub(super) image: ReferenceImage,
    /// How long it was traced, in milliseconds, when it was.
    pub(super) trace_ms: f64,
}

/// References that were traced already.
#[derive(Debug, Default)]
pub struct References {
    folder: Option<PathBuf>,
    kept: HashMap<u64, Arc<Traced>>,
    /// What could not be kept on disk, once.
    warning: Option<String>,
}

impl References {
    /// Kept in memory only.
    pub fn in_memory() -> Self {
        Self::default()
    }

    /// Kept in `folder` as well, which is made when the first is.
    pub fn in_folder(folder: &Path) -> Self {
        Self { folder: Some(folder.into()), ..Self::default() }
    }

    /// Why references are not kept on disk, if they are not: a report is none the worse for it.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Forgets what is kept in memory.
    pub(super) fn forget(&mut self) {
        self.kept.clear();
    }

    pub(super) fn get(
        &mut self,
        snapshot: &SceneSnapshot,
        request: &FrameRequest,
        queries: &[LightQuery],
        progress: &Progress<'_>,
    ) -> Arc<Traced> {
        let key = content_key(snapshot, request, queries);
        if let Some(traced) = self.kept.get(&key) {
            return Arc::clone(traced);
        }
        let path = self.folder.as_ref().map(|folder| folder.join(format!("{key:016x}.reference")));
        let read = path.as_ref().and_then(|path| decode(&fs::read(path).ok()?, key));
        let traced = Arc::new(read.unwrap_or_else(|| {
            let start = Instant::now();
            let image = Reference::new(snapshot).render(&request.camera, request.size_px, queries, progress);
            let traced = Traced { image, trace_ms: start.elapsed().as_secs_f64() * 1e3 };
            if let Some(path) = &path
                && let Err(error) = write(path, &encode(&traced, key))
            {
                let warning = format!("references are not kept in '{}': {error}", path.display());
                self.warning.get_or_insert(warning);
            }
            traced
        }));
        self.kept.insert(key, Arc::clone(&traced));
        traced
    }
}

/// A file appears whole or not at all.
fn write(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let part = path.with_extension(format!("{}.part", std::process::id()));
    fs::write(&part, bytes).and_then(|()| fs::rename(&part, path)).inspect_err(|_| {
        // The first error is the one to tell.
        let _ = fs::remove_file(&part);
    })
}

/// The texts that say what a reference is.
const SOURCES: [&str; 21] = [
    include_str!("../../../engine/src/shadow/area_light.rs"),
    include_str!("../../../engine/src/shadow/light_samples.rs"),
    include_str!("../reference/answers.rs"),
    include_str!("../reference/area.rs"),
    include_str!("../reference/bvh.rs"),
    include_str!("../reference/channels.rs"),
    include_str!("../reference/cover.rs"),
    include_str!("../reference/disc.rs"),
    include_str!("../reference/forms.rs"),
    include_str!("../reference/glass.rs"),
    include_str!("../reference/holes.rs"),
    include_str!("../reference/moved.rs"),
    include_str!("../reference/query.rs"),
    include_str!("../reference/tracer.rs"),
    include_str!("../reference/render.rs"),
    include_str!("../reference/samples.rs"),
    include_str!("../reference/surface.rs"),
    include_str!("../reference/ties.rs"),
    include_str!("../reference/view.rs"),
    include_str!("../reference/way.rs"),
    include_str!("references.rs"),
];

fn content_key(snapshot: &SceneSnapshot, request: &FrameRequest, queries: &[LightQuery]) -> u64 {
    let mut hasher = DefaultHasher::new();
    SOURCES.hash(&mut hasher);
    for instance in &snapshot.instances {
        let vertices = instance.mesh.positions().len() as u32;
        for vertex in 0..vertices {
            instance.world_position(vertex).to_array().map(f64::to_bits).hash(&mut hasher);
        }
        let data = instance.mesh.data();
        data.indices.hash(&mut hasher);
        data.uvs.iter().for_each(|uv| uv.to_array().map(f32::to_bits).hash(&mut hasher));
        data.colors.iter().for_each(|color| color.to_array().map(f32::to_bits).hash(&mut hasher));
        format!("{:?} {:?} {:?}", data.parts, instance.shadow, instance.materials).hash(&mut hasher);
    }
    let mut images: Vec<_> = snapshot.images.iter().collect();
    images.sort_by_key(|(key, _)| **key);
    for (key, image) in images {
        (format!("{key:?}"), image.width, &image.rgba8).hash(&mut hasher);
    }
    for query in queries {
        let light = snapshot.lights.get(query.light);
        // Whatever a query may ask for is part of what it says of itself.
        format!("{light:?} {query:?}").hash(&mut hasher);
    }
    let camera = (&request.camera.world_from_view, &request.camera.projection);
    (format!("{camera:?}"), request.size_px).hash(&mut hasher);
    hasher.finish()
}

const MAGIC: &[u8; 16] = b"SHADOWGRAPH-RF3\n";

fn checksum(bytes: &[u8]) -> [u8; 8] {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytes);
    hasher.finish().to_le_bytes()
}

/// One bit each, from the lowest.
fn flags_of(flags: [bool; 3]) -> u8 {
    flags.iter().rev().fold(0, |bits, flag| bits << 1 | u8::from(*flag))
}

fn encode(traced: &Traced, key: u64) -> Vec<u8> {
    let Traced { image, trace_ms } = traced;
    let mut bytes = MAGIC.to_vec();
    bytes.extend(key.to_le_bytes());
    bytes.extend(trace_ms.to_le_bytes());
    image.size_px.iter().for_each(|side| bytes.extend(side.to_le_bytes()));
    for hit in &image.hits {
        let [instance, triangle] = hit.map_or([u32::MAX; 2], |hit| [hit.instance, hit.triangle]);
        bytes.extend(instance.to_le_bytes());
        bytes.extend(triangle.to_le_bytes());
    }
    bytes.extend((image.ties.len() as u32).to_le_bytes());
    for (pixel, hit) in &image.ties {
        [*pixel, hit.instance, hit.triangle].iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    }
    bytes.extend((image.lights.len() as u32).to_le_bytes());
    for light in &image.lights {
        bytes.extend((light.name.len() as u32).to_le_bytes());
        bytes.extend(light.name.as_bytes());
        bytes.extend((light.factor.len() as u32).to_le_bytes());
        light.factor.iter().for_each(|factor| bytes.extend(factor.to_le_bytes()));
        let flags = light.compared.iter().zip(&light.ambiguous).zip(&light.uncounted);
        bytes.extend(
            flags.map(|((compared, ambiguous), uncounted)| flags_of([*compared, *ambiguous, *uncounted])),
        );
        bytes.push(u8::from(light.soft.is_some()));
        if let Some(soft) = &light.soft {
            bytes.extend(soft.same_samples.unwrap_or(0).to_le_bytes());
            bytes.extend(soft.boundary_px.to_le_bytes());
            soft.bounds.as_flattened().iter().for_each(|bound| bytes.extend(bound.to_le_bytes()));
        }
        bytes.extend((light.tied.len() as u32).to_le_bytes());
        for (tie, answer) in &light.tied {
            bytes.extend(tie.to_le_bytes());
            let values = [answer.factor, answer.tint].concat();
            let values = values.iter().chain(answer.bounds.as_flattened());
            values.for_each(|value| bytes.extend(value.to_le_bytes()));
            bytes.push(flags_of([answer.compared, answer.ambiguous, answer.uncounted]));
        }
    }
    let sum = checksum(&bytes);
    bytes.extend(sum);
    bytes
}

/// Takes values from the front of bytes.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (front, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(front)
    }

    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    fn number(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.bytes()?))
    }

    fn answer(&mut self) -> Option<PixelReference> {
        let mut values = [0.0; 12];
        for value in &mut values {
            *value = f32::from_bits(self.number()?);
        }
        let [flags] = self.bytes()?;
        let three = |first: usize| [values[first], values[first + 1], values[first + 2]];
        let pair = |first: usize| [values[first], values[first + 1]];
        let (factor, tint, bounds) = (three(0), three(3), [pair(6), pair(8), pair(10)]);
        Some(PixelReference {
            factor,
            bounds,
            tint,
            compared: flags & 1 == 1,
            ambiguous: flags >> 1 & 1 == 1,
            uncounted: flags >> 2 & 1 == 1,
        })
    }
}

/// `None` for whatever [`encode`] did not write for this key.
fn decode(bytes: &[u8], key: u64) -> Option<Traced> {
    let (body, sum) = bytes.split_at_checked(bytes.len().checked_sub(8)?)?;
    if checksum(body) != sum {
        return None;
    }
    let mut reader = Reader(body);
    if reader.bytes::<16>()? != *MAGIC || u64::from_le_bytes(reader.bytes()?) != key {
        return None;
    }
    let trace_ms = f64::from_le_bytes(reader.bytes()?);
    let size_px = [reader.number()?, reader.number()?];
    let pixels = size_px[0] as usize * size_px[1] as usize;
    let numbers = |bytes: &[u8]| -> Vec<u32> {
        bytes.chunks_exact(4).map(|four| u32::from_le_bytes([four[0], four[1], four[2], four[3]])).collect()
    };
    let hit = |pair: &[u32]| (pair[0] != u32::MAX).then(|| Hit { instance: pair[0], triangle: pair[1] });
    let hits = numbers(reader.take(pixels.checked_mul(8)?)?).chunks_exact(2).map(hit).collect();
    let count = reader.number()? as usize;
    let tie = |three: &[u32]| (three[0], Hit { instance: three[1], triangle: three[2] });
    let ties = numbers(reader.take(count.checked_mul(12)?)?).chunks_exact(3).map(tie).collect();
    let mut lights = Vec::new();
    for _ in 0..reader.number()? {
        let length = reader.number()? as usize;
        let name = String::from_utf8(reader.take(length)?.to_vec()).ok()?;
        let values = reader.number()? as usize;
        let factor = numbers(reader.take(values.checked_mul(4)?)?).into_iter().map(f32::from_bits).collect();
        let flags = reader.take(pixels)?;
        let flag = |bit: u8| flags.iter().map(|flags| flags >> bit & 1 == 1).collect();
        let (compared, ambiguous, uncounted) = (flag(0), flag(1), flag(2));
        let soft = match reader.bytes::<1>()? {
            [0] => None,
            _ => {
                let same_samples = Some(reader.number()?).filter(|count| *count > 0);
                let boundary_px = f64::from_le_bytes(reader.bytes()?);
                let bounds = numbers(reader.take(values.checked_mul(8)?)?);
                let bounds =
                    bounds.chunks_exact(2).map(|pair| [f32::from_bits(pair[0]), f32::from_bits(pair[1])]);
                Some(SoftBounds { same_samples, bounds: bounds.collect(), boundary_px })
            }
        };
        let mut tied = Vec::new();
        for _ in 0..reader.number()? {
            tied.push((reader.number()?, reader.answer()?));
        }
        lights.push(LightReference { name, factor, compared, ambiguous, uncounted, soft, tied });
    }
    let image = ReferenceImage { size_px, hits, ties, lights };
    reader.0.is_empty().then_some(Traced { image, trace_ms })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn traced() -> Traced {
        let tied = PixelReference {
            factor: [0.5, 0.25, 0.125],
            bounds: [[0.0, 0.5], [0.25, 0.5], [0.125, 1.0]],
            tint: [1.0, 0.75, 0.5],
            compared: false,
            ambiguous: true,
            uncounted: true,
        };
        let light = LightReference {
            name: "lämp".into(),
            factor: vec![0.25, 1.0],
            compared: vec![true, false],
            ambiguous: vec![false, true],
            uncounted: vec![true, false],
            soft: Some(SoftBounds {
                same_samples: Some(16),
                bounds: vec![[0.25, 0.5], [1.0, 1.0]],
                boundary_px: 0.5,
            }),
            tied: vec![(1, tied)],
        };
        let hits = vec![Some(Hit { instance: 3, triangle: 70_000 }), None];
        let ties = [2, 3].map(|instance| (0, Hit { instance, triangle: 1 })).to_vec();
        let image = ReferenceImage { size_px: [2, 1], hits, ties, lights: vec![light] };
        Traced { image, trace_ms: 12.5 }
    }

    #[test]
    fn references_come_back_the_same() {
        assert_eq!(decode(&encode(&traced(), 9), 9), Some(traced()));
    }

    #[test]
    fn damaged_cut_and_foreign_files_are_not_believed() {
        let bytes = encode(&traced(), 9);
        assert_eq!(decode(&bytes, 8), None);
        for end in 0..bytes.len() {
            assert_eq!(decode(&bytes[..end], 9), None, "{end}");
        }
        for place in 0..bytes.len() {
            let mut bytes = bytes.clone();
            bytes[place] ^= 4;
            assert_eq!(decode(&bytes, 9), None, "{place}");
        }
    }
}
