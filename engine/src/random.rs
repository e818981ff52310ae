//! Random numbers for tests, the same for the same seed.

use glam::DVec3;

/// A number in −1 … 1.
pub(crate) fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// A point within the cube of −1 … 1.
pub(crate) fn random_point(seed: &mut u64) -> DVec3 {
    DVec3::new(random(seed), random(seed), random(seed))
}
