//! Lights with a size of which part is below the receiver's horizon, and nothing that casts.
//!
//! How much of a disc is above a plane is known in closed form: of a light of radius r (as an angle's tangent) whose centre
//! stands d above the horizon, ½ + (asin(d/r) + d/r·√(1 − d²/r²))/π.

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::shapes::plane;

use super::Expect;
use super::glass::glass;
use super::stage::{Stage, p};
use super::ties::{Cut, level, patch};

/// The share of a disc that is above a line, by the line's height over its centre in units of its radius.
fn share_above(height: f64) -> f32 {
    (0.5 + (height.asin() + height * (1.0 - height * height).sqrt()) / std::f64::consts::PI) as f32
}

/// The sun at this elevation, seen with this half-angle over level ground: where it shines to, and the share that is up.
fn low_sun(elevation_deg: f64, half_angle_deg: f64) -> (DVec3, f32) {
    let (sin, cos) = elevation_deg.to_radians().sin_cos();
    let share = share_above(elevation_deg.to_radians().tan() / half_angle_deg.to_radians().tan());
    (DVec3::new(0.96 * cos, -sin, 0.28 * cos), share)
}

/// A lamp of this radius as high over the ground as `height_m`: what of it a point sees `away_m` beside its foot.
fn low_lamp(height_m: f64, radius_m: f64, away_m: f64) -> f32 {
    // The disc of its tangent points faces the point: it rises as steeply as the line to the lamp falls.
    let distance = height_m.hypot(away_m);
    let disc = radius_m * distance / (distance * distance - radius_m * radius_m).sqrt();
    share_above((height_m / (away_m / distance) / disc).min(1.0))
}

fn judged(stage: Stage, share: f32) -> Stage {
    stage.expects(Expect::Matches).factor(&[p(0.4, 0.0, 0.3), p(-0.8, 0.0, 0.5)], [share; 3])
}

pub(super) fn soft_no_caster() -> Vec<Stage> {
    let sun = |name: &str, elevation_deg: f64, half_angle_deg: f64| {
        let (way, share) = low_sun(elevation_deg, half_angle_deg);
        (Stage::small(name).sun(way).half_angle(half_angle_deg), share)
    };
    let pane = || patch(level(1.0, 1.0), Cut::First).named("pane");
    let (bare, bare_share) = sun("sun", 1.1, 5.0);
    let (below, below_share) = sun("mostly-below", -2.0, 5.0);
    let (glazed, _) = sun("only-glass", 1.1, 5.0);
    let (gridded, gridded_share) = sun("grid", 3.0, 4.0);
    let (leaning, _) = sun("tilted", 10.0, 12.0);
    let lamp = |name: &str| Stage::small(name).floor().point(p(-3.0, 0.2, 1.0)).radius(1.0);
    let foot = |x: f64, z: f64| low_lamp(0.2, 1.0, DVec3::new(x + 3.0, 0.0, z - 1.0).length());
    let tilt = DAffine3::from_quat(DQuat::from_rotation_z(0.12));
    vec![
        judged(bare.floor().casting_nothing(), bare_share),
        judged(below.floor(), below_share),
        judged(gridded.caster(patch(level(4.0, 0.0), Cut::Grid(3, 3))), gridded_share),
        // Seen through it or beside it, the floor is not under it for a sun so low.
        glazed
            .floor()
            .casting_nothing()
            .worn_at(pane(), glass(Vec3::new(0.9, 0.3, 0.3), 0.5), DAffine3::IDENTITY)
            .expects(Expect::Matches),
        lamp("lamp")
            .casting_nothing()
            .expects(Expect::Matches)
            .factor(&[p(0.4, 0.0, 0.3)], [foot(0.4, 0.3); 3])
            .factor(&[p(-0.8, 0.0, 0.5)], [foot(-0.8, 0.5); 3]),
        lamp("ortho")
            .ortho(2.2, 0.1, 30.0)
            .expects(Expect::Matches)
            .factor(&[p(0.4, 0.0, 0.3)], [foot(0.4, 0.3); 3]),
        leaning.caster_at(plane(Vec2::splat(2.0)).named("floor"), tilt).expects(Expect::Matches),
    ]
}

pub(super) fn planar_no_caster() -> Vec<Stage> {
    let ground = || plane(Vec2::splat(4.0)).named("floor");
    let sun = |name: &str, elevation_deg: f64, half_angle_deg: f64| {
        let (way, share) = low_sun(elevation_deg, half_angle_deg);
        judged(Stage::small(name).receiver(ground()).sun(way).half_angle(half_angle_deg), share)
    };
    let foot = low_lamp(0.2, 1.0, DVec3::new(3.4, 0.0, -0.7).length());
    let pane = patch(level(1.0, 1.0), Cut::Other).named("pane");
    vec![
        sun("sun", 1.1, 5.0).casting_nothing(),
        sun("mostly-below", -2.0, 5.0),
        Stage::small("lamp")
            .receiver(ground())
            .point(p(-3.0, 0.2, 1.0))
            .radius(1.0)
            .expects(Expect::Matches)
            .factor(&[p(0.4, 0.0, 0.3)], [foot; 3]),
        sun("only-glass", 1.1, 5.0).worn_at(pane, glass(Vec3::new(0.9, 0.3, 0.3), 0.5), DAffine3::IDENTITY),
        // A second receiver, upright and turned to the light, is lit as a whole.
        sun("two-receivers", 3.0, 4.0).receiver(
            patch(
                [
                    Vec3::new(2.0, 0.0, -2.0),
                    Vec3::new(2.0, 1.5, -2.0),
                    Vec3::new(2.0, 1.5, 2.0),
                    Vec3::new(2.0, 0.0, 2.0),
                ],
                Cut::First,
            )
            .flipped(),
        ),
    ]
}
