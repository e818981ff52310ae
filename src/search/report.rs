//! What a search found: counts by family, and a file for each failure.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::path::{Path, PathBuf};

use shadowgraph_engine::gltf;
use shadowgraph_engine::shadow::Catalog;

use super::recipe::{Bend, Recipe, Wear};
use super::{Failure, FailureKind, Family, RecipeError, Verdict};

/// What came of the scenes of one family.
#[derive(Clone, Debug, Default, PartialEq)]
struct Count {
    scenes: usize,
    empty: usize,
    in_shadow: usize,
    refused: usize,
    wrong: BTreeMap<FailureKind, usize>,
}

/// What came of all scenes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    families: BTreeMap<Family, Count>,
    techniques: BTreeMap<String, usize>,
    refusals: BTreeMap<String, usize>,
    wrong: Vec<(Family, u64)>,
}

impl Tally {
    /// Counts one scene.
    pub fn count(&mut self, recipe: &Recipe, verdict: &Verdict) {
        let count = self.families.entry(recipe.family).or_default();
        count.scenes += 1;
        match verdict {
            Verdict::Right { in_shadow, .. } => count.in_shadow += usize::from(*in_shadow > 0),
            Verdict::Empty => count.empty += 1,
            Verdict::Refused { kind, .. } => {
                count.refused += 1;
                *self.refusals.entry(kind.clone()).or_default() += 1;
            }
            Verdict::Wrong(failure) => {
                *count.wrong.entry(failure.kind).or_default() += 1;
                self.wrong.push((recipe.family, recipe.seed));
            }
        }
        for node in &recipe.nodes {
            *self.techniques.entry(node.technique.clone()).or_default() += 1;
        }
    }

    /// The scenes counted.
    pub fn scenes(&self) -> usize {
        self.families.values().map(|count| count.scenes).sum()
    }

    /// Those refused.
    pub fn refused(&self) -> usize {
        self.families.values().map(|count| count.refused).sum()
    }

    /// Family and seed of those that are wrong.
    pub fn wrong(&self) -> &[(Family, u64)] {
        &self.wrong
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<13} {:>6} {:>8} {:>6} {:>8} {:>6}",
            "kind", "scenes", "shadowed", "empty", "refused", "wrong"
        )?;
        let mut row = |name: &str, count: &Count| {
            let wrong: usize = count.wrong.values().sum();
            let Count { scenes, in_shadow, empty, refused, .. } = count;
            write!(f, "{name:<13} {scenes:>6} {in_shadow:>8} {empty:>6} {refused:>8} {wrong:>6}")?;
            let how: Vec<String> = count.wrong.iter().map(|(kind, n)| format!("{kind:?} {n}")).collect();
            writeln!(f, "{}{}", if how.is_empty() { "" } else { "  " }, how.join(", "))
        };
        let mut all = Count::default();
        for (family, count) in &self.families {
            row(family.name(), count)?;
            all.scenes += count.scenes;
            all.in_shadow += count.in_shadow;
            all.empty += count.empty;
            all.refused += count.refused;
            for (kind, n) in &count.wrong {
                *all.wrong.entry(*kind).or_default() += n;
            }
        }
        row("all", &all)?;
        for (technique, count) in &self.techniques {
            writeln!(f, "{count} nodes of {technique}")?;
        }
        for (refusal, count) in &self.refusals {
            writeln!(f, "{count} refused: {refusal}")?;
        }
        Ok(())
    }
}

/// Writes a failing scene to `folder` as `FAMILY-SEED.glb`, and beside it as text how to see the failure and what was
/// measured. Returns where the scene is.
///
/// # Errors
/// When the scene cannot be saved; the text is a help, and where it cannot be written that is an error too.
pub fn write_failure(
    folder: &Path,
    recipe: &Recipe,
    failure: &Failure,
    catalog: &Catalog,
) -> Result<PathBuf, RecipeError> {
    let name = format!("{}-{}", recipe.family, recipe.seed);
    let path = folder.join(format!("{name}.glb"));
    let scene = recipe.build(catalog)?;
    gltf::save(&scene, &path)?;
    let text = folder.join(format!("{name}.txt"));
    std::fs::write(&text, describe(&name, recipe, failure))
        .map_err(|source| gltf::GltfError::Io { path: text.display().to_string(), source })?;
    Ok(path)
}

fn describe(name: &str, recipe: &Recipe, failure: &Failure) -> String {
    let [width, height] = recipe.size_px;
    let mut text = format!("shadowgraph render {name}.glb -o out.png --size {width}x{height} --error\n");
    // Writing into a string does not fail.
    let _ = writeln!(text, "{:?}", failure.kind);
    for line in &failure.lines {
        let _ = writeln!(text, "{line}");
    }
    let _ = writeln!(text, "seed {} of {}; eye {:?}", recipe.seed, recipe.family, recipe.eye);
    for lamp in &recipe.lamps {
        let _ = writeln!(text, "{lamp:?}");
    }
    for node in &recipe.nodes {
        let options: Vec<String> =
            node.params.iter().map(|(name, value)| format!("{name}={value}")).collect();
        let scopes = format!("lamps {:?} bodies {:?}", node.lamps, node.bodies);
        let _ = writeln!(text, "{}:{} {scopes}", node.technique, options.join(","));
    }
    for body in &recipe.bodies {
        let wear = match body.wear {
            Wear::Matt => "matt",
            Wear::Glass { .. } => "glass",
            Wear::Mask { .. } => "mask",
        };
        let bent = if body.bend == Bend::None { "" } else { ", bent" };
        let sides = if body.double_sided { "double" } else { "single" };
        let (triangles, transforms) = (body.triangles.len(), body.transforms.len());
        let _ = writeln!(
            text,
            "{}: {triangles} triangles, {wear}, {sides}-sided, under {transforms} transforms{bent}",
            body.name
        );
        if triangles <= 4 {
            for triangle in 0..triangles {
                let _ = writeln!(text, "  {:?}", body.corners(triangle));
            }
        }
    }
    text
}
