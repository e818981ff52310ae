//! Animations as data: clips of channels, each a track of keys for one property of one node, as glTF 2.0 has them.
//!
//! *Sampling.* Between keys a track steps, runs linearly (rotations: slerp, the short way round) or follows the cubic
//! spline of glTF 2.0, appendix C; before the first key and after the last it keeps their values. All in f64.
//!
//! *Bad data.* A [`Track`] cannot be made from keys out of order, numbers that are not finite or rotations without
//! direction. Rotations of other lengths than 1 are normalised; of keys at the same time the last counts.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use thiserror::Error;

use super::NodeKey;

/// What a channel moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Property {
    /// A node's translation: 3 values a key.
    Translation,
    /// A node's rotation, a quaternion x, y, z, w.
    Rotation,
    /// A node's scale: 3 values a key.
    Scale,
    /// The weights of the morph targets of a node's mesh: one value a key for each target.
    Weights,
}

/// How a track runs between two keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// It keeps the earlier key's value.
    Step,
    /// Linearly; rotations turn at even speed, the short way round.
    #[default]
    Linear,
    /// Along the cubic spline through the keys with their tangents: for each key in-tangent, value, out-tangent.
    CubicSpline,
}

/// Why keys make no track.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum TrackError {
    #[error("it has no keys (at least 1 is needed)")]
    NoKeys,
    #[error("key {key} is at {time_s} s; finite times are needed")]
    BadTime { key: usize, time_s: f32 },
    #[error("key {key} at {time_s} s comes before the one at {before_s} s; ascending times are needed")]
    Unsorted { key: usize, time_s: f32, before_s: f32 },
    #[error("{values} values for {keys} keys; {needed} are needed")]
    Count { values: usize, keys: usize, needed: String },
    #[error("value {place} is {value}; finite numbers are needed")]
    BadValue { place: usize, value: f32 },
    #[error("the rotation of key {key} is (0, 0, 0, 0), which has no direction")]
    NoDirection { key: usize },
}

/// The keys of one property. Validated when made, and shared by channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    property: Property,
    interpolation: Interpolation,
    times_s: Vec<f32>,
    values: Vec<f32>,
    width: usize,
}

impl Track {
    /// A track of `values` at `times_s`, each key as many as the property has (three times as many for splines).
    ///
    /// # Errors
    /// [`TrackError`] names the key.
    pub fn new(
        property: Property,
        interpolation: Interpolation,
        times_s: Vec<f32>,
        values: Vec<f32>,
    ) -> Result<Self, TrackError> {
        let keys = times_s.len();
        if keys == 0 {
            return Err(TrackError::NoKeys);
        }
        if let Some(key) = times_s.iter().position(|time_s| !time_s.is_finite()) {
            return Err(TrackError::BadTime { key, time_s: times_s[key] });
        }
        if let Some(key) = (1..keys).find(|key| times_s[*key] < times_s[key - 1]) {
            let (time_s, before_s) = (times_s[key], times_s[key - 1]);
            return Err(TrackError::Unsorted { key, time_s, before_s });
        }
        let parts = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let width = match property {
            Property::Translation | Property::Scale => 3,
            Property::Rotation => 4,
            Property::Weights => values.len() / (keys * parts),
        };
        if width == 0 || values.len() != keys * parts * width {
            let needed = match property {
                Property::Weights => format!("a multiple of {}", keys * parts),
                _ => (keys * parts * width).to_string(),
            };
            return Err(TrackError::Count { values: values.len(), keys, needed });
        }
        if let Some(place) = values.iter().position(|value| !value.is_finite()) {
            return Err(TrackError::BadValue { place, value: values[place] });
        }
        let track = Self { property, interpolation, times_s, values, width };
        let directionless = |key: &usize| track.value(*key).iter().all(|value| *value == 0.0);
        if property == Property::Rotation
            && let Some(key) = (0..keys).find(directionless)
        {
            return Err(TrackError::NoDirection { key });
        }
        Ok(track)
    }

    /// What it moves.
    pub fn property(&self) -> Property {
        self.property
    }

    /// How it runs between keys.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// The times of the keys, ascending, in seconds.
    pub fn times_s(&self) -> &[f32] {
        &self.times_s
    }

    /// The values, key after key.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// How many numbers its property has at one moment.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The values at `seconds`; rotations have length 1.
    pub fn sample(&self, seconds: f64) -> Vec<f64> {
        let after = self.times_s.partition_point(|time_s| f64::from(*time_s) <= seconds);
        let last = self.times_s.len() - 1;
        let mut values = if after == 0 || after > last || self.interpolation == Interpolation::Step {
            wide(self.value(after.saturating_sub(1)))
        } else {
            let (from, to) = (f64::from(self.times_s[after - 1]), f64::from(self.times_s[after]));
            let t = (seconds - from) / (to - from);
            match (self.interpolation, self.property) {
                (Interpolation::CubicSpline, _) => self.spline(after - 1, t, to - from),
                (_, Property::Rotation) => {
                    let [a, b] = [after - 1, after].map(|key| self.rotation(key));
                    slerp(a, b, t).to_array().to_vec()
                }
                _ => {
                    let pairs = self.value(after - 1).iter().zip(self.value(after));
                    pairs.map(|(a, b)| f64::from(*a) * (1.0 - t) + f64::from(*b) * t).collect()
                }
            }
        };
        if self.property == Property::Rotation {
            let q = DQuat::from_slice(&values);
            // A spline may pass through zero; there the earlier key's direction is kept.
            let usable = q.length_squared() > 1e-30;
            let q = if usable { q.normalize() } else { self.rotation(after.saturating_sub(1)) };
            values = q.to_array().to_vec();
        }
        values
    }

    /// The value of a key, without its tangents.
    fn value(&self, key: usize) -> &[f32] {
        match self.interpolation {
            Interpolation::CubicSpline => self.third(key, 1),
            _ => &self.values[key * self.width..][..self.width],
        }
    }

    /// In-tangent (0), value (1) or out-tangent (2) of a key of a spline.
    fn third(&self, key: usize, part: usize) -> &[f32] {
        &self.values[(key * 3 + part) * self.width..][..self.width]
    }

    fn rotation(&self, key: usize) -> DQuat {
        let q = DQuat::from_slice(&wide(self.value(key)));
        // Divided first, so that the squares of tiny numbers do not vanish.
        let largest = q.to_array().into_iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        DQuat::from_array(q.to_array().map(|value| value / largest)).normalize()
    }

    /// The Hermite spline from `key` to the next, `span_s` later; tangents are per second.
    fn spline(&self, key: usize, t: f64, span_s: f64) -> Vec<f64> {
        let (t2, t3) = (t * t, t * t * t);
        let weights = [
            (self.third(key, 1), 2.0 * t3 - 3.0 * t2 + 1.0),
            (self.third(key, 2), span_s * (t3 - 2.0 * t2 + t)),
            (self.third(key + 1, 1), -2.0 * t3 + 3.0 * t2),
            (self.third(key + 1, 0), span_s * (t3 - t2)),
        ];
        (0..self.width)
            .map(|i| weights.iter().map(|(part, weight)| f64::from(part[i]) * weight).sum())
            .collect()
    }
}

fn wide(values: &[f32]) -> Vec<f64> {
    values.iter().map(|value| f64::from(*value)).collect()
}

/// From unit quaternion `a` to `b` the short way round, at even speed.
fn slerp(a: DQuat, b: DQuat, t: f64) -> DQuat {
    let b = if a.dot(b) < 0.0 { -b } else { b };
    // The angle between them, precise for small ones, where the arc cosine is not.
    let angle_rad = 2.0 * (b - a).length().atan2((b + a).length());
    if angle_rad < 1e-9 {
        return (a * (1.0 - t) + b * t).normalize();
    }
    (a * ((1.0 - t) * angle_rad).sin() + b * (t * angle_rad).sin()) * angle_rad.sin().recip()
}

/// One property of one node over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The node.
    pub node: NodeKey,
    /// Property and keys.
    pub track: Arc<Track>,
}

impl Channel {
    /// A channel that moves `node` along `track`.
    pub fn new(node: NodeKey, track: Track) -> Self {
        Self { node, track: Arc::new(track) }
    }
}

/// A clip: channels that run together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// Its name; need not be unique.
    pub name: String,
    /// What it moves. Of several channels for one property of one node the last counts.
    pub channels: Vec<Channel>,
}

impl Animation {
    /// A clip of `channels`.
    pub fn new(name: &str, channels: Vec<Channel>) -> Self {
        Self { name: name.into(), channels }
    }

    /// The time of its last key, in seconds; 0 for a clip without keys.
    pub fn duration_s(&self) -> f64 {
        let last = |channel: &Channel| channel.track.times_s.last().copied().unwrap_or(0.0);
        f64::from(self.channels.iter().map(last).fold(0.0, f32::max))
    }

    /// `seconds` of playing the clip over and over, as a time within it.
    pub fn looped(&self, seconds: f64) -> f64 {
        let duration_s = self.duration_s();
        if duration_s > 0.0 { seconds.rem_euclid(duration_s) } else { 0.0 }
    }
}

/// A transform as translation, rotation and scale, which animations move one by one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Its translation.
    pub translation: DVec3,
    /// Its rotation.
    pub rotation: DQuat,
    /// Its scale along its own axes.
    pub scale: DVec3,
}

impl Default for Transform {
    fn default() -> Self {
        Self { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE }
    }
}

impl Transform {
    /// The transform as one affine map.
    pub fn matrix(&self) -> glam::DAffine3 {
        super::placed(self.translation, self.rotation, self.scale)
    }

    /// The parts of an affine map; `None` for one that shears or flattens, which has no such parts.
    pub fn of(matrix: &glam::DAffine3) -> Option<Self> {
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        let parts = Self { translation, rotation, scale };
        let size = scale.abs().max_element();
        let finite = translation.is_finite() && rotation.is_finite() && scale.is_finite();
        let same =
            finite && (parts.matrix().matrix3 - matrix.matrix3).abs_diff_eq(glam::DMat3::ZERO, 1e-9 * size);
        (same && scale.abs().min_element() > 0.0).then_some(parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(property: Property, interpolation: Interpolation, times: &[f32], values: &[f32]) -> Track {
        Track::new(property, interpolation, times.to_vec(), values.to_vec()).expect("a valid track")
    }

    #[test]
    fn keys_are_met_and_ends_are_kept() {
        let keys = [1.0, 2.0, 4.0];
        let values = [0.0, 0.0, 0.0, 2.0, 4.0, 8.0, 2.0, 0.0, 0.0];
        let linear = track(Property::Translation, Interpolation::Linear, &keys, &values);
        assert_eq!(linear.sample(-9.0), [0.0, 0.0, 0.0]);
        assert_eq!(linear.sample(1.5), [1.0, 2.0, 4.0]);
        assert_eq!(linear.sample(2.0), [2.0, 4.0, 8.0]);
        assert_eq!(linear.sample(3.0), [2.0, 2.0, 4.0]);
        assert_eq!(linear.sample(1e300), [2.0, 0.0, 0.0]);
        let step = track(Property::Scale, Interpolation::Step, &keys, &values);
        assert_eq!(step.sample(1.999), [0.0, 0.0, 0.0]);
        assert_eq!(step.sample(2.0), [2.0, 4.0, 8.0]);
        // Two keys at one time: the later counts from there on.
        let jump =
            track(Property::Weights, Interpolation::Linear, &[0.0, 1.0, 1.0, 2.0], &[0.0, 1.0, 5.0, 6.0]);
        assert_eq!(jump.sample(0.5), [0.5]);
        assert_eq!(jump.sample(1.0), [5.0]);
        assert_eq!(jump.sample(1.5), [5.5]);
    }

    /// A cubic through four Hermite conditions is that cubic: glTF's spline must reproduce any cubic polynomial.
    #[test]
    fn splines_reproduce_cubic_polynomials() {
        let p = |t: f64| [0.5 * t * t * t - t * t + 2.0, -t * t * t + 3.0 * t, 7.0 - t];
        let slope = |t: f64| [1.5 * t * t - 2.0 * t, -3.0 * t * t + 3.0, -1.0];
        let times = [0.0_f32, 0.5, 2.0, 2.25];
        let values: Vec<f32> = times
            .iter()
            .flat_map(|t| [slope(f64::from(*t)), p(f64::from(*t)), slope(f64::from(*t))].concat())
            .map(|value| value as f32)
            .collect();
        let spline = track(Property::Translation, Interpolation::CubicSpline, &times, &values);
        for step in 0..=90 {
            let t = f64::from(step) / 40.0;
            for (got, wanted) in spline.sample(t).iter().zip(p(t)) {
                assert!((got - wanted).abs() < 1e-12, "{t} s: {got}, not {wanted}");
            }
        }
        // Wrong by any of the usual slips: tangents swapped, or not scaled by the span.
        assert!((spline.sample(1.25)[1] - p(1.25)[1]).abs() < 1e-12);
    }

    #[test]
    fn rotations_take_the_short_way_at_even_speed() {
        let about_y = |degrees: f64| DQuat::from_rotation_y(degrees.to_radians());
        let (a, b) = (about_y(10.0), about_y(170.0));
        // The same rotation with the other sign, and neither of length 1.
        let values: Vec<f32> =
            (a * 2.0).to_array().into_iter().chain((-b * 0.5).to_array()).map(|x| x as f32).collect();
        let turning = track(Property::Rotation, Interpolation::Linear, &[0.0, 1.0], &values);
        for step in 0..=16 {
            let t = f64::from(step) / 16.0;
            let got = DQuat::from_slice(&turning.sample(t));
            assert!((got.length() - 1.0).abs() < 1e-12);
            let wanted = about_y(10.0 + 160.0 * t);
            assert!(1.0 - got.dot(wanted).abs() < 1e-12, "{t}: {got:?}, not {wanted:?}");
        }
        // Almost the same rotation: no division by a vanishing sine.
        let near = (a * DQuat::from_rotation_x(1e-12)).to_array().map(|x| x as f32);
        let values: Vec<f32> = a.to_array().map(|x| x as f32).into_iter().chain(near).collect();
        let still = track(Property::Rotation, Interpolation::Linear, &[0.0, 1.0], &values);
        assert!(DQuat::from_slice(&still.sample(0.5)).angle_between(a) < 1e-6);
        // A spline that passes through zero keeps a direction.
        let mut values = vec![0.0; 24];
        (values[7], values[19]) = (1.0, -1.0);
        let spline = track(Property::Rotation, Interpolation::CubicSpline, &[0.0, 1.0], &values);
        assert_eq!(spline.sample(0.5), [0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn bad_keys_make_no_track() {
        use Interpolation::{CubicSpline, Linear};
        let made = |property, interpolation, times: &[f32], values: &[f32]| {
            Track::new(property, interpolation, times.to_vec(), values.to_vec()).expect_err("bad keys")
        };
        let weights = |times: &[f32], values: &[f32]| made(Property::Weights, Linear, times, values);
        assert_eq!(weights(&[], &[]), TrackError::NoKeys);
        assert!(matches!(weights(&[0.0, f32::NAN], &[0.0; 2]), TrackError::BadTime { key: 1, .. }));
        assert!(matches!(weights(&[0.0, 2.0, 1.0], &[0.0; 3]), TrackError::Unsorted { key: 2, .. }));
        assert!(matches!(weights(&[0.0, 1.0], &[0.0; 3]), TrackError::Count { .. }));
        assert!(matches!(weights(&[0.0, 1.0], &[]), TrackError::Count { .. }));
        assert!(matches!(weights(&[0.0], &[f32::INFINITY]), TrackError::BadValue { place: 0, .. }));
        assert!(matches!(
            made(Property::Rotation, Linear, &[0.0], &[0.0; 4]),
            TrackError::NoDirection { key: 0 }
        ));
        assert!(matches!(made(Property::Scale, CubicSpline, &[0.0], &[1.0; 3]), TrackError::Count { .. }));
    }

    #[test]
    fn clips_last_to_their_last_key_and_loop() {
        let node = NodeKey::default();
        let channel = |times: &[f32]| {
            let values = vec![0.0; times.len()];
            Channel::new(node, track(Property::Weights, Interpolation::Linear, times, &values))
        };
        let clip = Animation::new("clip", vec![channel(&[0.0, 2.0]), channel(&[0.5, 1.0])]);
        assert_eq!(clip.duration_s(), 2.0);
        assert_eq!((clip.looped(4.5), clip.looped(-0.5), clip.looped(2.0)), (0.5, 1.5, 0.0));
        assert_eq!(Animation::default().looped(3.0), 0.0);
    }

    #[test]
    fn only_transforms_with_parts_have_parts() {
        let transform = Transform {
            translation: DVec3::new(1.0, -2.0, 1e6),
            rotation: DQuat::from_rotation_z(2.0),
            scale: DVec3::new(-1.0, 2.0, 0.001),
        };
        let parts = Transform::of(&transform.matrix()).expect("it has parts");
        assert!(parts.matrix().abs_diff_eq(transform.matrix(), 1e-9));
        let shear = glam::DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::Z);
        for matrix in [shear, glam::DMat3::ZERO, glam::DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0))] {
            assert_eq!(Transform::of(&glam::DAffine3::from_mat3(matrix)), None);
        }
    }
}
