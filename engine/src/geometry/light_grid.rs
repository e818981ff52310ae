//! A grid the light looks through: which triangles can a light ray meet at all?
//!
//! One plane for a directional light; for a point light one plane fitted around the casters or, when the light stands
//! among them, the six faces of a cube. Every plane is split into square cells. A ray meets one cell only, so what
//! lies over other cells need not be asked.
//!
//! *Nothing is lost.* Footprints are enlarged by a thousandth of a cell on every side, 2·10⁻⁶ of the plane or more for
//! up to 1024 cells a side, where the rounding of a projection in f64 is below 10⁻⁹. A triangle too near the plane
//! through the light to be projected covers the whole face. Outside the planned bounds coordinates are clamped,
//! triangles and rays alike.

use glam::{DVec2, DVec3, DVec4};

use crate::math::Aabb;

/// By how much of a cell footprints are enlarged.
const CELL_MARGIN: f64 = 1e-3;

/// What is this near to the border of one of six planes is on both, as a share of the farthest corner's distance.
const BESIDE_FACE: f64 = 1e-9;
/// What is this near to the plane through the light is not projected, as a share of the same.
const NEAREST: f64 = 1e-6;

/// One or six planes a light looks through, split into cells.
#[derive(Clone, Debug)]
pub struct LightGrid {
    planes: Vec<LightPlane>,
    cells_per_side: usize,
}

/// A rectangle of cells of one plane: (column, row) of its first and last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellRange {
    /// The lowest column and row.
    pub low: [usize; 2],
    /// The highest column and row, which belong to the range.
    pub high: [usize; 2],
}

impl CellRange {
    /// How many cells it has.
    pub fn count(&self) -> usize {
        (self.high[0] - self.low[0] + 1) * (self.high[1] - self.low[1] + 1)
    }
}

impl LightGrid {
    /// A grid for the homogeneous `light`, fitted to casters within `bounds` (in the world), of one cell a plane.
    /// Casters may leave the bounds: cells at the edge then hold more.
    pub fn new(light: DVec4, bounds: &Aabb) -> Self {
        Self { planes: light_planes(light, bounds), cells_per_side: 1 }
    }

    /// A grid over these planes.
    pub fn from_planes(planes: &[LightPlane], cells_per_side: usize) -> Self {
        Self { planes: planes.to_vec(), cells_per_side: cells_per_side.max(1) }
    }

    /// The same planes with `cells_per_side` cells (1 at least) along a side of each.
    #[must_use]
    pub fn with_cells_per_side(self, cells_per_side: usize) -> Self {
        Self { cells_per_side: cells_per_side.max(1), ..self }
    }

    /// The planes: one, or six.
    pub fn planes(&self) -> &[LightPlane] {
        &self.planes
    }

    /// Cells along a side of each plane.
    pub fn cells_per_side(&self) -> usize {
        self.cells_per_side
    }

    /// For each plane the triangle may be seen on: its number, and the cells of the footprint's bounding rectangle.
    pub fn cells_of(&self, corners: [DVec3; 3]) -> impl Iterator<Item = (usize, CellRange)> + use<'_> {
        let planes = self.planes.iter().enumerate();
        planes.filter_map(move |(i, plane)| {
            Some((i, self.rectangle(&plane.project(corners, 0.0), CELL_MARGIN)?))
        })
    }

    /// Calls `visit` with (column, row) of every cell of plane number `plane` that the triangle may be seen in: those
    /// of its bounding rectangle that none of its edges leaves outside.
    pub fn for_each_cell(&self, plane: usize, corners: [DVec3; 3], visit: impl FnMut([usize; 2])) {
        self.for_each_cell_within(plane, corners, CELL_MARGIN, 0.0, visit);
    }

    /// The same with the triangle's footprint enlarged by `margin` of a cell, and by as much as the triangle may be elsewhere,
    /// in metres.
    pub fn for_each_cell_within(
        &self,
        plane: usize,
        corners: [DVec3; 3],
        margin: f64,
        elsewhere_m: f64,
        mut visit: impl FnMut([usize; 2]),
    ) {
        let margin =
            margin + self.planes[plane].shift(corners, elsewhere_m) * 0.5 * self.cells_per_side as f64;
        let footprint = self.planes[plane].project(corners, elsewhere_m);
        let Some(CellRange { low, high }) = self.rectangle(&footprint, margin) else { return };
        let edges = match footprint {
            Footprint::Triangle(projected) => self.edges(projected, margin),
            Footprint::Nothing | Footprint::Everything => [(DVec2::ZERO, 0.0); 3],
        };
        let last = self.cells_per_side - 1;
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                // Cells at the edge go on without end.
                let at_edge = [x, y].iter().any(|place| *place == 0 || *place == last);
                let middle = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                if at_edge || edges.iter().all(|(normal, offset)| normal.dot(middle) <= *offset) {
                    visit([x, y]);
                }
            }
        }
    }

    /// For each edge of a projected triangle the outward normal, and how far along it a cell's middle may lie for the
    /// cell to reach over the edge; in cells.
    fn edges(&self, projected: [DVec2; 3], margin: f64) -> [(DVec2, f64); 3] {
        let [a, b, c] = projected.map(|p| (p * 0.5 + 0.5) * self.cells_per_side as f64);
        let turn = (b - a).perp_dot(c - a);
        [(a, b), (b, c), (c, a)].map(|(p, q)| {
            let normal = (q - p).perp() * -turn.signum();
            let reach = (0.5 + margin) * (normal.x.abs() + normal.y.abs());
            (normal, normal.dot(p) + reach)
        })
    }

    fn rectangle(&self, footprint: &Footprint, margin: f64) -> Option<CellRange> {
        let last = self.cells_per_side - 1;
        // `as` saturates, so that far-away coordinates clamp instead of wrapping.
        let cell = |ndc: f64, margin: f64| {
            let place = (ndc * 0.5 + 0.5) * self.cells_per_side as f64 + margin;
            (place.floor().max(0.0) as usize).min(last)
        };
        match footprint {
            Footprint::Nothing => None,
            Footprint::Everything => Some(CellRange { low: [0, 0], high: [last, last] }),
            Footprint::Triangle([a, b, c]) => {
                let (low, high) = (a.min(*b).min(*c), a.max(*b).max(*c));
                Some(CellRange {
                    low: low.to_array().map(|ndc| cell(ndc, -margin)),
                    high: high.to_array().map(|ndc| cell(ndc, margin)),
                })
            }
        }
    }
}

/// Where a vertex is on the grid, for triangles that share their vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenVertex {
    /// The plane that shows it; [`SeenVertex::ALONE`] where triangles at it have to be looked at by themselves.
    plane: u32,
    /// Column and row, with fractions.
    place: [f32; 2],
}

impl SeenVertex {
    const ALONE: Self = Self { plane: u32::MAX, place: [0.0; 2] };
}

impl LightGrid {
    /// Where vertices are.
    pub(super) fn see(&self, p_in_world: &[DVec3]) -> Vec<SeenVertex> {
        let Some(LightPlane { origin, .. }) = self.planes.first() else {
            return vec![SeenVertex::ALONE; p_in_world.len()];
        };
        let reach = p_in_world.iter().map(|p| (*p - *origin).abs().max_element()).fold(0.0, f64::max);
        let number_of = |p: &DVec3| if self.planes.len() == 1 { 0 } else { face_towards(*p - *origin) };
        let see = |p: &DVec3| {
            let number = number_of(p);
            match self.planes[number].place(*p, reach) {
                Some(place) => {
                    let place = (place * 0.5 + 0.5) * self.cells_per_side as f64;
                    SeenVertex { plane: number as u32, place: place.as_vec2().to_array() }
                }
                None => SeenVertex::ALONE,
            }
        };
        p_in_world.iter().map(see).collect()
    }

    /// The plane and the cells of the triangle between three of these; `None` where it has to be [asked](LightGrid::cells_of)
    /// by itself.
    pub(super) fn cells_between(&self, [a, b, c]: [SeenVertex; 3]) -> Option<(usize, CellRange)> {
        if a.plane != b.plane || a.plane != c.plane || a.plane == SeenVertex::ALONE.plane {
            return None;
        }
        // Places are rounded to a sixteenth of the margin at most.
        let last = self.cells_per_side - 1;
        let cell = |place: f32| (place.max(0.0) as usize).min(last);
        let low = |i: usize| cell(a.place[i].min(b.place[i]).min(c.place[i]) - CELL_MARGIN as f32);
        let high = |i: usize| cell(a.place[i].max(b.place[i]).max(c.place[i]) + CELL_MARGIN as f32);
        Some((a.plane as usize, CellRange { low: [low(0), low(1)], high: [high(0), high(1)] }))
    }
}

/// The number of the plane, of six, that shows what lies at `d` from the light.
fn face_towards(d: DVec3) -> usize {
    let size = d.abs();
    let axis = if size.z > size.x.max(size.y) { 2 } else { usize::from(size.y > size.x) };
    axis * 2 + usize::from(d[axis] < 0.0)
}

/// The part of a plane a triangle covers, in coordinates from −1 to 1.
enum Footprint {
    Nothing,
    Everything,
    Triangle([DVec2; 3]),
}

/// A plane the light looks through: a point goes to (x, y) = (d·x_axis, d·y_axis) / (d·z_axis + z_offset),
/// d = point − origin, and the part in view is |x|, |y| ≤ 1.
#[derive(Clone, Debug, PartialEq)]
pub struct LightPlane {
    /// What places are taken from: where it looks from; for a directional light the middle of the casters.
    pub origin: DVec3,
    /// Across, scaled to the part in view.
    pub x_axis: DVec3,
    /// Up, scaled to the part in view.
    pub y_axis: DVec3,
    /// Away from a light, of length 1; 0 for a directional light.
    pub z_axis: DVec3,
    /// How far before `origin` the point lies that it looks from: 0 when that is `origin` itself; 1 when looking along a
    /// direction.
    pub z_offset: f64,
    /// The direction along which things lie further from the light, of length 1.
    pub away: DVec3,
    /// Whether other planes look where this one does not: it then shows what lies within the pyramid |x|, |y| ≤ z.
    pub one_of_six: bool,
}

impl LightPlane {
    /// How far along `away` the nearest point of a triangle lies from the origin.
    pub fn nearest(&self, corners: [DVec3; 3]) -> f64 {
        corners.iter().map(|corner| (*corner - self.origin).dot(self.away)).fold(f64::INFINITY, f64::min)
    }

    /// Where `p` is on it, from −1 to 1 within the part in view, with the margins that [`LightPlane::project`] has for what is `reach`
    /// from the light or nearer: `None` where triangles at it may be seen on another plane too, or from too near.
    fn place(&self, p: DVec3, reach: f64) -> Option<DVec2> {
        let d = p - self.origin;
        let (x, y) = (d.dot(self.x_axis), d.dot(self.y_axis));
        let z = d.dot(self.z_axis) + self.z_offset;
        let nearest = if self.z_axis == DVec3::ZERO { 0.0 } else { NEAREST * reach };
        let is_within = !self.one_of_six || x.abs().max(y.abs()) + BESIDE_FACE * reach < z;
        let place = DVec2::new(x, y) / z;
        (z > nearest && is_within && place.is_finite()).then_some(place)
    }

    /// How far a triangle's image moves within the part in view, which is 2 wide, when the triangle moves by `moves_m`.
    fn shift(&self, corners: [DVec3; 3], moves_m: f64) -> f64 {
        if moves_m == 0.0 {
            return 0.0;
        }
        let z = |corner: DVec3| (corner - self.origin).dot(self.z_axis) + self.z_offset;
        let z_moves = moves_m * self.z_axis.length();
        let nearest = corners.map(z).into_iter().fold(f64::INFINITY, f64::min) - z_moves;
        let moves = moves_m * self.x_axis.length().max(self.y_axis.length()) + z_moves;
        // No infinity: some of it is multiplied by 0.
        if nearest > 0.0 { (moves / nearest).min(1e30) } else { 1e30 }
    }

    /// The part of the plane that a triangle covers, or covers when it moves by `moves_m` next to a plane's border.
    fn project(&self, corners: [DVec3; 3], moves_m: f64) -> Footprint {
        let to_corners = corners.map(|corner| corner - self.origin);
        let homogeneous = to_corners
            .map(|d| DVec3::new(d.dot(self.x_axis), d.dot(self.y_axis), d.dot(self.z_axis) + self.z_offset));
        let reach = to_corners.iter().map(|d| d.abs().max_element()).fold(0.0, f64::max);
        let all = |is_outside: &dyn Fn(&DVec3) -> bool| homogeneous.iter().all(is_outside);
        if self.one_of_six {
            // Wholly behind the light, or wholly beyond one side of the face's pyramid |x|, |y| ≤ z.
            let margin = BESIDE_FACE * reach + moves_m * std::f64::consts::SQRT_2;
            let is_outside = all(&|h| h.z < -margin)
                || all(&|h| h.x - h.z > margin)
                || all(&|h| -h.x - h.z > margin)
                || all(&|h| h.y - h.z > margin)
                || all(&|h| -h.y - h.z > margin);
            if is_outside {
                return Footprint::Nothing;
            }
        }
        let nearest = if self.z_axis == DVec3::ZERO { 0.0 } else { NEAREST * reach };
        if !all(&|h| h.z > nearest) {
            return Footprint::Everything;
        }
        let projected = homogeneous.map(|h| h.truncate() / h.z);
        if !projected.iter().all(|p| p.is_finite()) {
            return Footprint::Everything;
        }
        Footprint::Triangle(projected)
    }
}

/// One plane where one can see all of `bounds` within 45 degrees of its axis, else the six faces of a cube.
fn light_planes(light: DVec4, bounds: &Aabb) -> Vec<LightPlane> {
    /// The narrowest view, in the sine of its half angle or in radii: what lies within it is not told apart.
    const NARROWEST: f64 = 1e-6;
    let (center, radius_m) = (bounds.center(), bounds.radius());
    if light.w == 0.0 {
        let towards = light.truncate().try_normalize().unwrap_or(DVec3::Y);
        let (x, y) = towards.any_orthonormal_pair();
        let half_extent = |axis: DVec3| {
            let half_m =
                if bounds.is_empty() { 0.0 } else { (bounds.max - bounds.min).dot(axis.abs()) * 0.5 };
            half_m.max(radius_m * NARROWEST).max(f64::MIN_POSITIVE.sqrt())
        };
        return vec![LightPlane {
            origin: center,
            x_axis: x / half_extent(x),
            y_axis: y / half_extent(y),
            z_axis: DVec3::ZERO,
            z_offset: 1.0,
            away: -towards,
            one_of_six: false,
        }];
    }
    let origin = light.truncate();
    let looking = |x_axis, y_axis, z_axis: DVec3, one_of_six| LightPlane {
        origin,
        x_axis,
        y_axis,
        z_axis,
        z_offset: 0.0,
        away: z_axis,
        one_of_six,
    };
    let distance_m = center.distance(origin);
    let sine = (radius_m / distance_m).max(NARROWEST);
    if sine < std::f64::consts::FRAC_1_SQRT_2 && !bounds.is_empty() {
        let z_axis = (center - origin) / distance_m;
        let (x, y) = z_axis.any_orthonormal_pair();
        let tangent = sine / (1.0 - sine * sine).sqrt();
        return vec![looking(x / tangent, y / tangent, z_axis, false)];
    }
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let face = |i: usize, sign: f64| looking(axes[(i + 1) % 3], axes[(i + 2) % 3], axes[i] * sign, true);
    (0..3).flat_map(|i| [face(i, 1.0), face(i, -1.0)]).collect()
}
