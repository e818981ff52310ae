//! Lights of `KHR_lights_punctual` and cameras.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::Vec3;

use super::GltfError;
use super::fields::Item;
use crate::math::Projection;
use crate::scene::{Camera, Light, LightKind};

/// The `extras` key under which a saved light or camera keeps a name that differs from its node's.
pub(super) const OWN_NAME: &str = "shadowgraphName";

/// Exporters write π/2 as an f32, which is a little more than π/2.
const ANGLE_SLACK_RAD: f64 = 1e-6;

/// The name of a light or camera: the node's, unless the scene was saved with another one.
pub(super) fn own_name(item: &Item<'_>, node: &str) -> String {
    let own = item.get("extras").and_then(|extras| extras.get(OWN_NAME)?.as_str());
    own.unwrap_or(node).to_owned()
}

/// Reads a light; `node` is the name of the node that carries it. `None` for a type that other extensions may have
/// added.
pub(super) fn light(item: &Item<'_>, node: &str) -> Result<Option<Light>, GltfError> {
    let wrong = |problem: &str| GltfError::Content { item: item.label(), problem: problem.into() };
    let kind = match item.get("type").and_then(|kind| kind.as_str()) {
        Some("directional") => LightKind::Directional,
        Some("point") => LightKind::Point,
        Some("spot") => {
            let cone = item.inner("spot")?;
            let angle = |field| cone.map_or(Ok(None), |cone| cone.number(field));
            let inner_rad = angle("innerConeAngle")?.unwrap_or(0.0);
            let outer_rad = angle("outerConeAngle")?.unwrap_or(FRAC_PI_4);
            if !(0.0 <= inner_rad && inner_rad <= outer_rad && outer_rad > 0.0)
                || outer_rad > FRAC_PI_2 + ANGLE_SLACK_RAD
            {
                return Err(wrong("its cone angles must satisfy 0 <= inner <= outer <= pi/2, outer above 0"));
            }
            LightKind::Spot { inner_rad: inner_rad.min(FRAC_PI_2), outer_rad: outer_rad.min(FRAC_PI_2) }
        }
        Some(_) => return Ok(None),
        None => return Err(wrong("its type must be 'directional', 'point' or 'spot'")),
    };
    let color = Vec3::from(item.numbers("color")?.unwrap_or([1.0; 3]).map(|channel| channel as f32));
    let intensity = item.number("intensity")?.unwrap_or(1.0) as f32;
    if !(intensity.is_finite() && intensity >= 0.0 && color.is_finite() && color.min_element() >= 0.0) {
        return Err(wrong("its intensity and colour must be finite and not negative"));
    }
    let range_m = item.number("range")?;
    if range_m.is_some_and(|range_m| range_m <= 0.0) {
        return Err(wrong("its range must be above 0 m (left out, the light has no end)"));
    }
    Ok(Some(Light {
        name: own_name(item, node),
        kind,
        color,
        intensity,
        range_m: range_m.filter(|_| kind != LightKind::Directional),
        casts_shadows: item.shadow_switches().casts.unwrap_or(true),
    }))
}

/// Reads a camera; the far plane of a perspective one is ignored, since the engine needs none.
pub(super) fn camera(item: &Item<'_>, node: &str) -> Result<Camera, GltfError> {
    let wrong = |problem: &str| GltfError::Content { item: item.label(), problem: problem.into() };
    let kind = item.get("type").and_then(|kind| kind.as_str());
    let Some(kind @ ("perspective" | "orthographic")) = kind else {
        return Err(wrong("its type must be 'perspective' or 'orthographic'"));
    };
    let lens = item.inner(kind)?.ok_or_else(|| item.wrong(kind, "is missing"))?;
    let needed = |field: &str| lens.number(field)?.ok_or_else(|| lens.wrong(field, "is missing"));
    let projection = if kind == "perspective" {
        Projection::Perspective { fov_y_rad: needed("yfov")?, near_m: needed("znear")? }
    } else {
        // Negative magnifications are valid glTF, though not advised: they turn the picture over, which is not intended.
        let half_height_m = needed("ymag")?.abs();
        Projection::Orthographic { half_height_m, near_m: needed("znear")?, far_m: needed("zfar")? }
    };
    if !projection.is_valid() {
        return Err(wrong(
            "it needs 0 < near < far, and a field of view between 0 and pi or a ymag other than 0",
        ));
    }
    Ok(Camera { name: own_name(item, node), projection })
}
