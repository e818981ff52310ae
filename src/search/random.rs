//! A small generator of random numbers, so that a seed means the same scene on every machine and in every version.

use glam::{DQuat, DVec3, Vec3};

/// SplitMix64: one word of state, and good enough for drawing scenes.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The numbers of this seed.
    pub fn new(seed: u64) -> Self {
        // Neighbouring seeds must not give neighbouring first numbers.
        let mut random = Self(seed.wrapping_mul(0xd134_2543_de82_ef95) ^ 0x5851_f42d_4c95_7f2d);
        random.word();
        random
    }

    /// 64 random bits.
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ (word >> 31)
    }

    /// A number from 0, below 1.
    pub fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number from `least`, below `most`.
    pub fn within(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.unit()
    }

    /// The same as f32, for vertices.
    pub fn within_f32(&mut self, least: f32, most: f32) -> f32 {
        self.within(least.into(), most.into()) as f32
    }

    /// A number between two positive ones, every power of ten as likely as the next.
    pub fn by_powers(&mut self, least: f64, most: f64) -> f64 {
        10_f64.powf(self.within(least.log10(), most.log10()))
    }

    /// A whole number from `least` to `most`.
    pub fn whole(&mut self, least: usize, most: usize) -> usize {
        least + (self.word() % (most - least + 1) as u64) as usize
    }

    /// Yes with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// One of `values`, which are not empty.
    pub fn pick<T: Clone>(&mut self, values: &[T]) -> T {
        values[self.whole(0, values.len() - 1)].clone()
    }

    /// A direction, none more likely than another.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let point = DVec3::from_array([(); 3].map(|()| self.within(-1.0, 1.0)));
            if (1e-3..=1.0).contains(&point.length_squared()) {
                return point.normalize();
            }
        }
    }

    /// A turn about any axis.
    pub fn turn(&mut self) -> DQuat {
        DQuat::from_axis_angle(self.direction(), self.within(0.0, std::f64::consts::TAU))
    }

    /// A point in the box of this half size about the origin.
    pub fn point(&mut self, half: f32) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| self.within_f32(-half, half)))
    }

    /// The same on a grid of quarters, where points coincide and lie in line.
    pub fn grid_point(&mut self, half: f32) -> Vec3 {
        (self.point(half) * 4.0).round() / 4.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_numbers_and_another_seed_others() {
        let first = |seed| [(); 8].map(|()| Random::new(seed).word());
        assert_eq!(first(7), first(7));
        assert_ne!(first(7), first(8));
        let mut random = Random::new(1);
        for _ in 0..1000 {
            assert!((2.0..3.0).contains(&random.within(2.0, 3.0)));
            assert!((4..=6).contains(&random.whole(4, 6)));
            assert!((random.direction().length() - 1.0).abs() < 1e-12);
        }
    }
}
