//! How bright the picture is.

use crate::scene::SceneSnapshot;

/// How scene radiance becomes picture brightness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Exposure {
    /// A white surface facing all lights at the middle of the scene becomes about as bright as white paper.
    #[default]
    Auto,
    /// Radiance is multiplied by this.
    Fixed(f32),
}

impl Exposure {
    /// The factor for `snapshot`.
    pub fn factor(self, snapshot: &SceneSnapshot) -> f32 {
        match self {
            Self::Fixed(factor) => factor,
            Self::Auto => auto_factor(snapshot),
        }
    }
}

/// Meters the lights at the middle of the scene: 1.6 π divided by the summed irradiance of surfaces that face them, so
/// that a white Lambert surface facing all lights has radiance 1.6: few surfaces are white or face every light. Lights
/// count from half the scene's radius away at least: a lamp in the middle must not black out the rest.
fn auto_factor(snapshot: &SceneSnapshot) -> f32 {
    let center = snapshot.world_bounds.center();
    let nearest_m = (snapshot.world_bounds.radius() * 0.5).max(1e-9);
    let mut irradiance = 0.0;
    for light in &snapshot.lights {
        let peak = f64::from(light.light.intensity * light.light.color.max_element());
        let distance_m = (center * light.position.w - light.position.truncate()).length().max(nearest_m);
        irradiance += if light.position.w == 0.0 { peak } else { peak / (distance_m * distance_m) };
    }
    if irradiance > 0.0 && irradiance.is_finite() {
        (1.6 * std::f64::consts::PI / irradiance) as f32
    } else {
        1.0
    }
}
