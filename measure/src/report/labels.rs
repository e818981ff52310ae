//! Labels beside their points, none over another.

/// What is to be labelled.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Label {
    /// The point.
    pub(super) at: [f64; 2],
    /// What stands beside it.
    pub(super) text: String,
}

/// A label with its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    /// Left end of the text's base line.
    pub(super) at: [f64; 2],
    /// Where a line from the point meets the text, where that is not obvious.
    pub(super) leader: Option<[f64; 2]>,
}

/// Height of a line of text, and the mean width of a bold letter, for the size that plots are set in.
const LINE_PX: f64 = 13.0;
const LETTER_PX: f64 = 7.2;
/// Half the size of a mark, with a little air.
const MARK_PX: f64 = 6.5;

/// A rectangle that labels keep off.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box2 {
    min: [f64; 2],
    max: [f64; 2],
}

impl Box2 {
    /// Of a mark.
    pub(super) fn mark(at: [f64; 2]) -> Self {
        Self::around(at, MARK_PX)
    }

    /// Of an upright or level line.
    pub(super) fn line(from: [f64; 2], to: [f64; 2]) -> Self {
        let min = [from[0].min(to[0]) - 1.0, from[1].min(to[1]) - 1.0];
        Self { min, max: [from[0].max(to[0]) + 1.0, from[1].max(to[1]) + 1.0] }
    }

    fn around([x, y]: [f64; 2], half: f64) -> Self {
        Self { min: [x - half, y - half], max: [x + half, y + half] }
    }

    fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|i| self.min[i] < other.max[i] && other.min[i] < self.max[i])
    }

    /// Whether a line passes through it, looked at every few pixels.
    fn is_crossed(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        const STEPS: u32 = 48;
        (0..=STEPS).any(|step| {
            let share = f64::from(step) / f64::from(STEPS);
            (0..2).all(|i| {
                let at = from[i] + (to[i] - from[i]) * share;
                at > self.min[i] && at < self.max[i]
            })
        })
    }

    fn is_within(&self, other: &Self) -> bool {
        (0..2).all(|i| self.min[i] >= other.min[i] && self.max[i] <= other.max[i])
    }
}

/// How wide a text is, about.
pub(super) fn width_px(text: &str) -> f64 {
    text.chars().count() as f64 * LETTER_PX
}

/// Finds a place for each label within the corners `bounds`: as near as possible, over none of `obstacles`, not over
/// another label. `None` for a label for which there is none: its point still says what it is when pointed at.
pub(super) fn place(labels: &[Label], obstacles: &[Box2], bounds: [[f64; 2]; 2]) -> Vec<Option<Placed>> {
    let bounds = Box2 { min: bounds[0], max: bounds[1] };
    let mut taken: Vec<Box2> = Vec::new();
    let mut leaders: Vec<[[f64; 2]; 2]> = Vec::new();
    let mut placed = Vec::new();
    for label in labels {
        // Where marks crowd, a line over a label is better than no label; of the fewest, the nearest.
        let free = candidates(label).filter(|c| c.is_free(&bounds, obstacles, &taken));
        let chosen = free.min_by_key(|c| c.crossings(&taken, &leaders));
        if let Some(Candidate { space, leader, .. }) = &chosen {
            taken.push(*space);
            leaders.extend(leader);
        }
        placed.push(chosen.map(|c| c.placed));
    }
    placed
}

/// A place that a label might have.
struct Candidate {
    space: Box2,
    leader: Option<[[f64; 2]; 2]>,
    placed: Placed,
}

impl Candidate {
    fn is_free(&self, bounds: &Box2, obstacles: &[Box2], taken: &[Box2]) -> bool {
        self.space.is_within(bounds)
            && !obstacles.iter().chain(taken).any(|other| other.overlaps(&self.space))
    }

    /// How many labels its line crosses, and how many others' lines cross it.
    fn crossings(&self, taken: &[Box2], leaders: &[[[f64; 2]; 2]]) -> usize {
        let crossed = |[from, to]: [[f64; 2]; 2]| taken.iter().filter(|t| t.is_crossed(from, to)).count();
        let crossing = leaders.iter().filter(|[from, to]| self.space.is_crossed(*from, *to));
        self.leader.map_or(0, crossed) + crossing.count()
    }
}

/// Right, left, then the diagonals, above and below, then between those; further and further away.
fn candidates(label: &Label) -> impl Iterator<Item = Candidate> {
    const DISTANCES_PX: [f64; 11] = [9.0, 18.0, 28.0, 40.0, 54.0, 70.0, 88.0, 108.0, 130.0, 154.0, 180.0];
    const DIRECTIONS: [[f64; 2]; 14] = [
        [1.0, 0.0],
        [0.7, -0.7],
        [0.7, 0.7],
        [-1.0, 0.0],
        [-0.7, -0.7],
        [-0.7, 0.7],
        [0.0, -1.0],
        [0.0, 1.0],
        [0.4, -0.92],
        [-0.4, -0.92],
        [0.92, -0.4],
        [-0.92, -0.4],
        [0.4, 0.92],
        [-0.4, 0.92],
    ];
    let (at, width) = (label.at, width_px(&label.text));
    let near = DISTANCES_PX.iter().flat_map(|distance| DIRECTIONS.iter().map(move |d| (*distance, *d)));
    near.map(move |(distance, [dx, dy])| {
        let near = [at[0] + dx * distance, at[1] + dy * distance];
        let left = match dx {
            d if d > 0.0 => near[0],
            d if d < 0.0 => near[0] - width,
            _ => near[0] - width * 0.5,
        };
        let (top, bottom) = (near[1] - LINE_PX * 0.5, near[1] + LINE_PX * 0.5);
        let leader = (distance > 20.0).then_some(near);
        Candidate {
            space: Box2 { min: [left, top], max: [left + width, bottom] },
            leader: leader.map(|end| [at, end]),
            placed: Placed { at: [left, near[1] + LINE_PX * 0.32], leader },
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twenty_labels_of_one_spot_do_not_overlap() {
        let labels: Vec<Label> = (0..20)
            .map(|i| Label { at: [250.0 + f64::from(i) * 2.0, 150.0], text: format!("label {i}") })
            .collect();
        let marks: Vec<[f64; 2]> = labels.iter().map(|label| label.at).collect();
        let obstacles: Vec<Box2> = marks.iter().map(|mark| Box2::mark(*mark)).collect();
        let placed = place(&labels, &obstacles, [[0.0, 0.0], [560.0, 300.0]]);
        let boxes: Vec<Box2> = placed
            .iter()
            .zip(&labels)
            .map(|(placed, label)| {
                let [x, y] = placed.expect("there is room for all").at;
                Box2 { min: [x, y - LINE_PX], max: [x + width_px(&label.text), y] }
            })
            .collect();
        for (i, a) in boxes.iter().enumerate() {
            for b in &boxes[i + 1..] {
                assert!(!a.overlaps(b), "{a:?} {b:?}");
            }
            assert!(marks.iter().all(|mark| !Box2::around(*mark, 1.0).overlaps(a)));
        }
    }

    #[test]
    fn a_label_without_room_is_left_out() {
        let label = Label { at: [5.0, 5.0], text: "far too long for this".into() };
        assert_eq!(place(&[label], &[], [[0.0, 0.0], [40.0, 40.0]]), [None]);
    }

    #[test]
    fn a_line_over_a_label_is_not_tidy() {
        let label = Label { at: [200.0, 250.0], text: "name".into() };
        let far = || candidates(&label).filter(|c| c.leader.is_some());
        // Straight up and far away, past what lies between.
        let up = far()
            .find(|c| c.leader.is_some_and(|[_, to]| to[0] == 200.0 && to[1] < 200.0))
            .expect("it is there");
        let between = Box2::around([200.0, 225.0], 8.0);
        let beside = Box2::around([230.0, 225.0], 8.0);
        assert_eq!((up.crossings(&[between], &[]), up.crossings(&[beside], &[])), (1, 0));
        // Another label's line through where the text would be.
        let [_, end] = up.leader.expect("it has one");
        assert_eq!(up.crossings(&[], &[[[end[0] - 50.0, end[1]], [end[0] + 50.0, end[1]]]]), 1);
    }
}
