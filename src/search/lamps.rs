//! Where lights and eyes are: in the open, and in every special place that the bodies have.

use glam::{DVec3, Vec3};
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::scene::LightKind;

use super::Random;
use super::recipe::{Body, Eye, Lamp};

/// Which lights may be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kinds {
    /// Points, spots and suns.
    All,
    /// Those that are somewhere.
    Placed,
}

/// A light that no plane, edge or corner knows of, above the ground.
pub(super) fn open(random: &mut Random, kinds: Kinds) -> Lamp {
    let height = random.within(1.5, 6.0);
    let position = DVec3::new(random.within(-4.0, 4.0), height, random.within(-4.0, 4.0));
    let aim = random.point(1.0).as_dvec3();
    let kind = kind(random, kinds);
    let direction = if kind == LightKind::Directional {
        // Down, from straight above to a low sun.
        let down = random.within(0.08, 1.5);
        DVec3::new(random.within(-1.0, 1.0), -down, random.within(-1.0, 1.0)).normalize()
    } else {
        (aim - position).normalize()
    };
    let range_m = (kind != LightKind::Directional && random.chance(0.2)).then(|| random.within(2.0, 8.0));
    Lamp { kind, position, direction, range_m }
}

fn kind(random: &mut Random, kinds: Kinds) -> LightKind {
    let outer_rad = random.within(0.2, 1.5);
    let spot = LightKind::Spot { inner_rad: outer_rad * random.unit(), outer_rad };
    match kinds {
        Kinds::All => random.pick(&[LightKind::Point, LightKind::Point, LightKind::Directional, spot]),
        Kinds::Placed => random.pick(&[LightKind::Point, LightKind::Point, spot]),
    }
}

/// How far off its special place a light is, as a share of the triangle's size: 0, or 1e-3 to 1e-12.
fn beside(random: &mut Random) -> f64 {
    if random.chance(0.3) { 0.0 } else { 10_f64.powi(-(random.whole(3, 12) as i32)) }
}

/// A point on a corner, edge or face of a body, in a triangle's plane, or inside the body; and the triangle.
fn special_point(random: &mut Random, body: &Body) -> (DVec3, [DVec3; 3]) {
    let corners = body.corners(random.whole(0, body.triangles.len() - 1));
    let [a, b, c] = corners;
    let decimal = |t: f64| (t * 10.0).round() / 10.0;
    let (s, t) = (random.unit(), random.unit());
    // Middles and tenths, as people type them, as often as any other place.
    let (s, t) = match random.whole(0, 2) {
        0 => (0.5, 0.5),
        1 => (decimal(s), decimal(t)),
        _ => (s, t),
    };
    let point = match random.whole(0, 4) {
        0 => random.pick(&corners),
        1 => a + (b - a) * s,
        2 => a + (b - a) * (s * t) + (c - a) * (s * (1.0 - t)),
        3 => a + (b - a) * (s * 4.0 - 1.5) + (c - a) * (t * 4.0 - 1.5),
        _ => {
            let all = body.positions.iter().map(|p| p.as_dvec3());
            let middle = all.sum::<DVec3>() / body.positions.len() as f64;
            body.frame_from_local().transform_point3(middle)
        }
    };
    (point, corners)
}

/// A light on, in or beside a corner, an edge, a face or a plane of `body`; a sun along an edge or a plane, or almost.
pub(super) fn special(random: &mut Random, body: &Body, kinds: Kinds) -> Lamp {
    let mut lamp = open(random, kinds);
    let (point, corners) = special_point(random, body);
    let off = beside(random);
    if lamp.kind == LightKind::Directional {
        let [a, b, c] = corners;
        let along =
            if random.chance(0.5) { b - a } else { (b - a) * random.unit() + (c - a) * random.unit() };
        let along = along.try_normalize().unwrap_or(lamp.direction);
        let along = if along.y > 0.0 { -along } else { along };
        lamp.direction = (along + random.direction() * off).normalize();
        return lamp;
    }
    let [a, b, c] = corners;
    let size = (b - a).length().max((c - a).length()).max(1e-3);
    let normal = (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::Y);
    let way = if random.chance(0.6) { normal } else { random.direction() };
    let way = if random.chance(0.7) { way } else { -way };
    lamp.position = point + way * (off * size);
    lamp.range_m = None;
    lamp
}

/// An eye that looks at the middle of things from outside, through any lens.
pub(super) fn eye(random: &mut Random) -> Eye {
    let mut from = random.direction();
    from.y = from.y.abs() + 0.1;
    let target = DVec3::Y * 0.5 + random.point(0.5).as_dvec3();
    if random.chance(0.25) {
        // From so far that the near plane cuts none of what most families have: that is what close eyes are for.
        let half_height_m = random.within(1.0, 4.0);
        let projection =
            Projection::Orthographic { half_height_m, near_m: 0.1, far_m: random.within(40.0, 100.0) };
        return Eye { position: target + from.normalize() * random.within(11.0, 20.0), target, projection };
    }
    let position = target + from.normalize() * random.within(3.0, 8.0);
    let projection = Projection::Perspective { fov_y_rad: random.within(0.5, 1.4), near_m: 0.1 };
    Eye { position, target, projection }
}

/// An eye inside a body, or from a millimetre to a few centimetres before one of its faces; its near plane cuts what it will.
pub(super) fn close_eye(random: &mut Random, body: &Body) -> Eye {
    let mut eye = eye(random);
    let [a, b, c] = body.corners(random.whole(0, body.triangles.len() - 1));
    let all = body.positions.iter().map(|p| p.as_dvec3());
    let middle = all.sum::<DVec3>() / body.positions.len() as f64;
    let middle = body.frame_from_local().transform_point3(middle);
    let (s, t) = (random.unit(), random.unit());
    let on_face = a + (b - a) * (s * t) + (c - a) * (s * (1.0 - t));
    let normal = (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::Y);
    eye.position = match random.whole(0, 2) {
        0 => middle + random.point(0.05).as_dvec3(),
        1 => on_face + normal * random.by_powers(1e-3, 0.2),
        _ => on_face - normal * random.by_powers(1e-3, 0.2),
    };
    eye.target = eye.position + random.direction();
    // Straight up and down leave a camera no side of its own.
    if (eye.target - eye.position).cross(DVec3::Y).length() < 0.05 {
        eye.target += DVec3::X * 0.2;
    }
    let near_m = random.by_powers(1e-3, 0.2);
    eye.projection = match eye.projection {
        Projection::Perspective { .. } => {
            Projection::Perspective { fov_y_rad: random.within(0.8, 1.8), near_m }
        }
        Projection::Orthographic { half_height_m, far_m, .. } => {
            Projection::Orthographic { half_height_m: half_height_m * 0.3, near_m, far_m }
        }
    };
    eye
}

/// An eye near the ground, from where planes are seen at a grazing angle.
pub(super) fn low_eye(random: &mut Random) -> Eye {
    let mut eye = eye(random);
    eye.position.y = random.by_powers(0.02, 1.5);
    eye.target = Vec3::new(0.0, random.within_f32(-0.1, 0.3), 0.0).as_dvec3();
    eye
}

/// An eye a little above the ground that looks into the distance, along roads and past them.
pub(super) fn far_look(random: &mut Random) -> Eye {
    let mut eye = eye(random);
    let far = random.within(20.0, 100.0);
    let way = random.direction() * DVec3::new(far, 0.0, far);
    eye.position = DVec3::Y * random.within(0.5, 4.0) - way * random.unit();
    eye.target = eye.position + way - DVec3::Y * random.within(0.0, 3.0);
    eye.projection = Projection::Perspective { fov_y_rad: random.within(0.5, 1.4), near_m: 0.1 };
    eye
}
