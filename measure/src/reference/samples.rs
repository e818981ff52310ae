//! The samples of a disc, gathered into ever smaller groups of neighbours, so that what is the same for many is asked once.

use std::ops::Range;

use glam::DVec2;

/// Groups of so many are not divided.
const SMALLEST: usize = 8;

/// The groups of some samples.
pub(crate) struct SampleTree {
    /// The first holds them all; each holds its children.
    groups: Vec<Group>,
    /// The samples' numbers; every group is a run of them.
    order: Vec<u32>,
}

impl Group {
    /// The corners of a square around it.
    pub(crate) fn around(&self) -> [DVec2; 4] {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| self.center + DVec2::new(x, y) * self.radius)
    }
}

/// A group of samples, all within `radius` of `center`.
pub(crate) struct Group {
    pub(crate) center: DVec2,
    pub(crate) radius: f64,
    run: Range<usize>,
    children: Option<[u32; 2]>,
}

impl SampleTree {
    pub(crate) fn new(samples: &[DVec2]) -> Self {
        let mut tree = Self { groups: Vec::new(), order: (0..samples.len() as u32).collect() };
        if !samples.is_empty() {
            tree.add(samples, 0..samples.len());
        }
        tree
    }

    /// Adds the group of this run and those within it, and returns its number.
    fn add(&mut self, samples: &[DVec2], run: Range<usize>) -> u32 {
        let at = |index: &u32| samples[*index as usize];
        let members = &mut self.order[run.clone()];
        let low = members.iter().map(at).fold(DVec2::INFINITY, DVec2::min);
        let high = members.iter().map(at).fold(DVec2::NEG_INFINITY, DVec2::max);
        let center = (low + high) * 0.5;
        let radius = members.iter().map(|index| at(index).distance(center)).fold(0.0, f64::max);
        let axis = usize::from((high - low).y > (high - low).x);
        let number = self.groups.len() as u32;
        let (middle, large) = (run.len() / 2, run.len() > SMALLEST);
        if large {
            members.select_nth_unstable_by(middle, |a, b| at(a)[axis].total_cmp(&at(b)[axis]));
        }
        self.groups.push(Group { center, radius, run: run.clone(), children: None });
        if large {
            let children = [run.start..run.start + middle, run.start + middle..run.end];
            self.groups[number as usize].children = Some(children.map(|run| self.add(samples, run)));
        }
        number
    }

    /// The group of all samples; `None` where there are none.
    pub(crate) fn all(&self) -> Option<&Group> {
        self.groups.first()
    }

    /// The numbers of all samples.
    pub(crate) fn all_members(&self) -> &[u32] {
        &self.order
    }

    /// The numbers of a group's samples.
    pub(crate) fn members(&self, group: &Group) -> &[u32] {
        &self.order[group.run.clone()]
    }

    /// The two groups that a group consists of; `None` where it is small.
    pub(crate) fn children(&self, group: &Group) -> Option<[&Group; 2]> {
        Some(group.children?.map(|number| &self.groups[number as usize]))
    }
}

#[cfg(test)]
mod tests {
    use shadowgraph_engine::shadow::disc_samples;

    use super::*;

    #[test]
    fn every_sample_lies_in_its_groups_and_in_one_of_the_smallest() {
        for count in [1, 2, 7, 16, 100, 1024] {
            let samples = disc_samples(count, 1);
            let tree = SampleTree::new(&samples);
            for group in &tree.groups {
                for index in &tree.order[group.run.clone()] {
                    assert!(samples[*index as usize].distance(group.center) <= group.radius);
                }
            }
            // The smallest groups hold every sample once.
            let mut held = vec![0; samples.len()];
            let mut open: Vec<&Group> = tree.all().into_iter().collect();
            while let Some(group) = open.pop() {
                match tree.children(group) {
                    Some(children) => open.extend(children),
                    None => tree.members(group).iter().for_each(|index| held[*index as usize] += 1),
                }
            }
            assert!(held.iter().all(|count| *count == 1), "{count}: {held:?}");
        }
    }
}
