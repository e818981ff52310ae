//! Where shadows may fall on a receiver, and how finely a view shows it.

use glam::{DAffine3, DMat3, DMat4, DVec2, DVec3, DVec4};
use shadowgraph_engine::math::Plane;
use shadowgraph_engine::scene::SceneSnapshot;
use shadowgraph_engine::shadow::View;

use super::Lit;
use super::canvas::Canvas;
use super::casters::Casters;
use super::receivers::Receiver;
use crate::common::boxes::cut;

/// So many texels, along each axis, does a pixel have: what a texel blurs of an edge is then a small part of what the pixel shows.
const TEXELS_OF_A_PIXEL: f64 = 4.0;
/// So many texels along the border are left lit: those beyond it repeat them.
const MARGIN_TEXELS: u32 = 2;
/// No texture is halved below this, along its longer side.
const FEWEST_TEXELS: u32 = 16;

/// The rectangle of a receiver's plane in which it may have shadows.
#[derive(Clone, Debug)]
pub(super) struct ShadowedArea {
    /// The plane's axes and its normal.
    world_from_axes: DMat3,
    /// How far along the normal it is.
    offset: f64,
    /// The receiver's rectangle, in metres along the axes.
    low: DVec2,
    high: DVec2,
    /// That of the shadows, which may reach beyond it.
    shadow_low: DVec2,
    shadow_high: DVec2,
}

impl ShadowedArea {
    /// That of these casters' shadows; `None` where none fall.
    pub(super) fn new(
        snapshot: &SceneSnapshot,
        (receiver, lit, casters): (&Receiver, &Lit, &Casters),
    ) -> Option<Self> {
        let Plane { normal, offset } = receiver.flat.plane;
        let (u, v) = receiver.axes(snapshot);
        let (low, high) = receiver.extent(snapshot, u, v);
        // Beyond what shadows reach, all is lit: unless part of the light is under the plane.
        let (shadow_low, shadow_high) = match lit.is_cut() {
            true => EVERYWHERE,
            false => shadow_extent(receiver, lit, casters, [u, v]),
        };
        let world_from_axes = DMat3::from_cols(u, v, normal);
        let area = Self { world_from_axes, offset, low, high, shadow_low, shadow_high };
        let (low, high) = area.within(0.0);
        let half = (high - low) * 0.5;
        (half.cmpgt(DVec2::ZERO).all() && half.is_finite()).then_some(area)
    }

    /// Its corners, the shadows' part of it made larger by `margin_m`.
    fn within(&self, margin_m: f64) -> (DVec2, DVec2) {
        (self.low.max(self.shadow_low - margin_m), self.high.min(self.shadow_high + margin_m))
    }

    fn in_world(&self, place: DVec2) -> DVec3 {
        self.world_from_axes * place.extend(self.offset)
    }

    /// How many texels its longer side needs for the pixels of the view, where it shows it largest: `most`, halved as often as may
    /// be. So a texture that is kept is drawn anew only where what is shown doubles or halves.
    pub(super) fn texels_shown(&self, view: &View, most: u32) -> u32 {
        let (low, high) = self.within(0.0);
        let pixels = self.pixels_per_meter(view, (low, high)) * (high - low).max_element();
        let needed = TEXELS_OF_A_PIXEL * pixels;
        // Without end where the view shows nothing of it.
        let halvings = (f64::from(most) / needed).log2().round().clamp(0.0, 31.0);
        (most >> halvings as u32).max(FEWEST_TEXELS.min(most))
    }

    /// How finely the view shows what it sees of a rectangle, where that is finest; 0 where it sees none of it.
    fn pixels_per_meter(&self, view: &View, (low, high): (DVec2, DVec2)) -> f64 {
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let whole = vec![corners.map(|corner| self.in_world(corner)).to_vec()];
        let seen = view.frustum.planes.iter().fold(whole, |faces, plane| cut(&faces, plane));
        let [width, height] = view.size_px.map(f64::from);
        let clip_from_world = view.camera.clip_from_world(view.size_px);
        // From the plane to the picture is a homography; at a place whose w is this, it scales areas by its determinant / w³.
        let on_picture = |v: DVec4| DVec3::new(v.x * 0.5 * width, v.y * 0.5 * height, v.w);
        let [u, v] = [self.world_from_axes.x_axis, self.world_from_axes.y_axis].map(|axis| axis.extend(0.0));
        let origin = self.in_world(DVec2::ZERO).extend(1.0);
        let homography = DMat3::from_cols_array_2d(
            &[u, v, origin].map(|column| on_picture(clip_from_world * column).to_array()),
        );
        let w = seen.iter().flatten().map(|place| (clip_from_world * place.extend(1.0)).w).reduce(f64::min);
        w.map_or(0.0, |w| (homography.determinant().abs() / (w * w * w)).sqrt())
    }

    /// A canvas over it, its longer side of `resolution` texels, kept under `key`.
    pub(super) fn canvas(&self, resolution: u32, key: u64) -> Canvas {
        let (low, high) = self.within(0.0);
        let inner_texels = resolution.saturating_sub(2 * MARGIN_TEXELS).max(1);
        let texel_m = (high - low).max_element() / f64::from(inner_texels);
        let (low, high) = self.within(f64::from(MARGIN_TEXELS) * texel_m);
        let half = (high - low) * 0.5;
        let middle = (low + high) * 0.5;
        let longest = half.max_element();
        let texels = |half: f64| ((half / longest * f64::from(resolution)).ceil() as u32).max(1);
        let origin = self.in_world(middle);
        let axes_from_world = self.world_from_axes.transpose();
        let view_from_world = DAffine3 { matrix3: axes_from_world, translation: -(axes_from_world * origin) };
        // w is that of the flattened point, and z half of it.
        let clip_from_view = DMat4::from_cols(
            DVec4::new(1.0 / half.x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, 1.0 / half.y, 0.0, 0.0),
            DVec4::ZERO,
            DVec4::new(0.0, 0.0, 0.5, 1.0),
        );
        let size_px = [texels(half.x), texels(half.y)];
        Canvas { size_px, view_from_world, clip_from_view, half_m: Some(half), key: Some(key) }
    }
}

const EVERYWHERE: (DVec2, DVec2) = (DVec2::NEG_INFINITY, DVec2::INFINITY);

/// The rectangle, in the plane's axes, in which the casters' boxes throw their shadows; without end where one does.
fn shadow_extent(receiver: &Receiver, lit: &Lit, casters: &Casters, [u, v]: [DVec3; 2]) -> (DVec2, DVec2) {
    let plane = &receiver.flat.plane;
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for (point, light_height) in lit.points.positions.iter().zip(&lit.heights) {
        for bounds in &casters.bounds {
            let heights = bounds.corners().map(|corner| plane.height(corner));
            let is_cut = heights.iter().any(|height| *height < 0.0);
            for (corner, height) in bounds.corners().into_iter().zip(heights) {
                let w = light_height - height * point.w;
                if w <= 1e-9 * light_height {
                    return EVERYWHERE;
                }
                let on =
                    |axis: DVec3| (axis.dot(corner) * light_height - axis.dot(point.truncate()) * height) / w;
                // The cut through a box lies between its corners, right under or over it.
                let under = is_cut.then(|| DVec2::new(u.dot(corner), v.dot(corner)));
                let shadow = (height >= 0.0).then(|| DVec2::new(on(u), on(v)));
                for place in under.into_iter().chain(shadow) {
                    (low, high) = (low.min(place), high.max(place));
                }
            }
        }
    }
    (low, high)
}
