//! The exact reference for lights with a size, sample by sample.
//!
//! **The light** is a disc, as `shadowgraph_engine::shadow` defines it for every technique ([`LightSize::disc`]).
//!
//! **The factor** is the share of samples that nothing blocks, each judged as hard shadows are. Samples on the other side
//! of the receiving triangle than the eye are dark, unless the receiver is transparent: then light passes it, and each sample
//! is only what stands strictly between. *Same samples* ([`light_samples`]) are those that the judged technique takes
//! itself, so that every pixel can be judged; else there are so many stratified ones ([`disc_samples`]) that their share
//! is as good as the integral: an edge's position is then off by a thousandth of the disc.
//!
//! **Bounds.** The moves of the ambiguity band take the disc along: each moved point sees its own. A sample that is
//! dark for some moves and lit for others may count either way, so a pixel's factor must lie in
//! \[lit, lit + ambiguous\]/S, without any band that is left out; hard lights are the case S = 1. Where the disc itself is not
//! settled (its axes turn or its radius grows without bounds within the moves: straight above a lamp, or next to its
//! sphere), a sample counts as settled only if it is so wherever it may lie.

use glam::{DVec2, DVec3, Vec3};
use shadowgraph_engine::shadow::{LightSize, disc_samples, light_samples};

use super::disc::{DiscTracer, Sight};
use super::disc_panes::PanesBefore;
use super::moved::Moved;
use super::query::Judged;
use super::samples::SampleTree;
use super::tracer::{CasterSet, Reference};
use super::way::Way;

/// How many samples stand for the whole light unless another number is asked for.
pub const CONVERGED_SAMPLES: u32 = 4096;

/// The points of a light's disc that the reference tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// So many of [`light_samples`]: those that the technique takes, which is judged sample by sample.
    Same(u32),
    /// So many stratified ones, enough to stand for the whole light.
    Converged(u32),
}

impl Samples {
    /// The points.
    pub fn points(self) -> Vec<DVec2> {
        match self {
            Self::Same(count) => light_samples(count),
            Self::Converged(count) => disc_samples(count, 1),
        }
    }
}

/// What casts for a light with a size.
#[derive(Clone, Debug, PartialEq)]
pub struct SizedCasters {
    /// Indices into `SceneSnapshot::instances`.
    pub casters: Vec<usize>,
    /// Indices into `SceneSnapshot::instances`: their transparent surfaces cast too, sample by sample, and the factor is one of
    /// red, green and blue.
    pub transparent: Vec<usize>,
    /// How large the light is.
    pub size: LightSize,
    /// Which points of it are asked.
    pub samples: Samples,
}

/// What a [`LightReference`](super::LightReference) knows beyond its factor where the light has a size.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SoftBounds {
    /// The samples that the judged technique takes itself; `None` where some stand for the whole light.
    pub same_samples: Option<u32>,
    /// For each value of the factor (one a pixel, or three) the least and the largest that ambiguous samples allow.
    pub bounds: Vec<[f32; 2]>,
    /// The mean, over the samples, of the boundary pixels of each one's own shadow: with it the band is compared, which for
    /// several samples is the mean of their bands. Known for same samples.
    pub boundary_px: f64,
}

/// [`SizedCasters`] of one reference.
pub(crate) struct SizedQuery {
    pub(crate) casters: CasterSet,
    /// Where some transparent surface casts.
    pub(crate) transparent: Option<CasterSet>,
    pub(crate) size: LightSize,
    pub(crate) samples: Vec<DVec2>,
    tree: SampleTree,
    pub(crate) same_samples: Option<u32>,
}

impl SizedQuery {
    pub(crate) fn new(reference: &Reference, sized: &SizedCasters) -> Self {
        let samples = sized.samples.points();
        Self {
            casters: reference.caster_set(&sized.casters),
            transparent: reference.transparent_set(&sized.transparent),
            size: sized.size,
            tree: SampleTree::new(&samples),
            samples,
            same_samples: match sized.samples {
                Samples::Same(count) => Some(count),
                Samples::Converged(_) => None,
            },
        }
    }

    /// How many words a pixel's lit samples take: one bit for each.
    pub(crate) fn words(&self) -> usize {
        if self.same_samples.is_some() { self.samples.len().div_ceil(64) } else { 0 }
    }

    /// The share of samples that reach the point; `lit`, as long as [`SizedQuery::words`], says which.
    pub(crate) fn judge(
        &self,
        tracer: &mut DiscTracer<'_>,
        light: usize,
        moved: &Moved<'_>,
        lit: &mut [u64],
    ) -> Judged {
        lit.fill(u64::MAX);
        let light = &tracer.reference.lights[light];
        let reached = moved.points.map(|point| light.reaches(point));
        let compared = reached[0];
        if !moved.surface.receives || !compared {
            return Judged::lit(compared);
        }
        let way = Way::new(self.size, &self.casters, light.position, moved);
        let center_only = way.disc().radius == 0.0;
        let gathered = tracer.gather(&way);
        // What is dark as a whole needs no glass.
        let set = self.transparent.as_ref().filter(|_| gathered != Some(false));
        let panes = set.map(|set| PanesBefore::new(tracer, &way, set));
        // Within the light all samples are in the centre; their share is 0 or 1.
        let place = |index: u32| if center_only { DVec2::ZERO } else { self.samples[index as usize] };
        let tints =
            |index: u32| panes.as_ref().map_or([DVec3::ONE; 3], |panes| panes.tints(&way, place(index)));
        let of_all = panes.as_ref().map_or(Some(DVec3::ONE), PanesBefore::of_all);
        let mut arriving = Arriving::default();
        let mut darken = |index: usize| {
            if let Some(word) = lit.get_mut(index / 64) {
                *word &= !(1 << (index % 64));
            }
        };
        match gathered {
            Some(true) => {
                let sight = Sight { lit: true, certain: true };
                arriving.add(self.tree.all_members(), sight, of_all, tints);
            }
            Some(false) => (0..self.samples.len()).for_each(darken),
            None => {
                let mut tell = |members: &[u32], Sight { lit, certain }: Sight| {
                    arriving.add(members, Sight { lit, certain }, of_all, tints);
                    if !lit {
                        members.iter().for_each(|index| darken(*index as usize));
                    }
                };
                match center_only {
                    true => tell(self.tree.all_members(), tracer.sees_center(&way)),
                    false => tracer.ask(&way, (&self.tree, &self.samples), &mut tell),
                }
            }
        }
        let share = |sum: DVec3| (sum / self.samples.len() as f64).as_vec3();
        let mut bounds = [share(arriving.least), share(arriving.largest)];
        if moved.lost {
            bounds = [Vec3::ZERO, Vec3::ONE];
        } else if reached.contains(&false) {
            bounds[1] = Vec3::ONE;
        }
        let ambiguous = bounds[0] != bounds[1];
        Judged { factor: share(arriving.exact), compared, ambiguous, bounds }
    }
}

/// What arrives of some samples of a light, each of which counts 1: the least and the largest that is right, and what is exact.
#[derive(Default)]
struct Arriving {
    least: DVec3,
    exact: DVec3,
    largest: DVec3,
}

impl Arriving {
    /// Adds samples that are all seen alike, behind glass that lets the same pass to all of them (`of_all`), or else to each its own.
    fn add(
        &mut self,
        members: &[u32],
        Sight { lit, certain }: Sight,
        of_all: Option<DVec3>,
        tints: impl Fn(u32) -> [DVec3; 3],
    ) {
        if !lit && certain {
            return;
        }
        let mut add = |count: f64, [least, exact, largest]: [DVec3; 3]| {
            self.largest += count * largest;
            if lit {
                self.exact += count * exact;
            }
            if lit && certain {
                self.least += count * least;
            }
        };
        match of_all {
            Some(tint) => add(members.len() as f64, [tint; 3]),
            None => members.iter().for_each(|index| add(1.0, tints(*index))),
        }
    }
}

/// The boundary pixels of every sample's own shadow, on average: `lit` has for each pixel `words` words, a bit for each
/// sample, of which there are `samples`.
pub(crate) fn boundary_px(lit: &[u64], words: usize, samples: usize, compared: &[bool], width: usize) -> f64 {
    let at = |pixel: usize| &lit[pixel * words..(pixel + 1) * words];
    let both = |a: usize, b: usize| b < compared.len() && compared[a] && compared[b];
    let mut differing = 0_u64;
    for pixel in 0..compared.len() {
        let right = (pixel + 1) % width != 0 && both(pixel, pixel + 1);
        let below = both(pixel, pixel + width);
        for (word, own) in at(pixel).iter().enumerate() {
            let differs = |there: bool, other: usize| if there { own ^ at(other)[word] } else { 0 };
            differing += u64::from((differs(right, pixel + 1) | differs(below, pixel + width)).count_ones());
        }
    }
    differing as f64 / samples.max(1) as f64
}
