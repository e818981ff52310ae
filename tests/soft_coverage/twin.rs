//! `common/disc_coverage.wgsl` written out in Rust, once in f64 and once in f32: so that its mathematics and its rounding
//! are judged apart, and without a device.

macro_rules! twin {
    ($name:ident, $f:ident, $vec2:ident, $vec3:ident) => {
        pub(crate) mod $name {
            use glam::{$vec2, $vec3};
            use std::$f::consts::PI;

            const NOTHING: $f = 1e-30;

            /// As the shader has it: its own polynomial is good to 2e-7, which is why f64 takes the library's.
            fn atan_unit(x: $f) -> $f {
                if size_of::<$f>() == 8 {
                    return x.atan();
                }
                let s = x * x;
                let rest = [
                    -0.016_165_736_7,
                    0.042_909_613_8,
                    -0.075_289_64,
                    0.106_562_639_3,
                    -0.142_088_994_4,
                    0.199_935_508_5,
                    -0.333_331_452_8,
                ];
                let sum = rest.into_iter().fold(0.002_866_225_7, |sum, next| sum * s + next);
                x + x * s * sum
            }

            fn direction(p: $vec2) -> $f {
                let size = p.abs();
                let first = atan_unit(size.min_element() / size.max_element().max(NOTHING));
                let quarter = if size.y > size.x { 0.5 * PI - first } else { first };
                let half = if p.x < 0.0 { PI - quarter } else { quarter };
                if p.y < 0.0 { -half } else { half }
            }

            fn turn(a: $vec2, b: $vec2, left: bool) -> $f {
                let mut angle = direction(b) - direction(a);
                if angle > PI {
                    angle -= 2.0 * PI;
                } else if angle < -PI {
                    angle += 2.0 * PI;
                }
                if left && angle < -1.0 {
                    angle += 2.0 * PI;
                } else if !left && angle > 1.0 {
                    angle -= 2.0 * PI;
                }
                angle
            }

            fn in_disc_plane(corner: $vec3) -> $vec2 {
                corner.truncate() / corner.z.max(1e-6 * corner.x.abs().max(corner.y.abs()) + NOTHING)
            }

            fn off_centre(corner: $vec3) -> $vec3 {
                if corner.truncate() == $vec2::ZERO { $vec3::new(1e-12, 0.0, corner.z) } else { corner }
            }

            pub(crate) fn edge_share(a: $vec3, b: $vec3, line: $vec3, left: bool) -> $f {
                let across_squared = line.truncate().length_squared();
                if line.z * line.z >= across_squared || a.z.max(b.z) <= 0.0 {
                    return 0.0;
                }
                let normal = line.truncate() / across_squared.sqrt();
                let along = $vec2::new(normal.y, -normal.x);
                let height = line.z / across_squared.sqrt();
                let reach = (1.0 - height * height).max(0.0).sqrt();
                let (a_in_plane, b_in_plane) = (in_disc_plane(a), in_disc_plane(b));
                let start = if a.z > 0.0 { a_in_plane.dot(along) } else { -1e30 };
                let end = if b.z > 0.0 { b_in_plane.dot(along) } else { 1e30 };
                if start >= reach || end <= -reach || end <= start {
                    return 0.0;
                }
                let foot = -height * normal;
                let first = if start > -reach { a_in_plane } else { foot - reach * along };
                let last = if end < reach { b_in_plane } else { foot + reach * along };
                let cross = height * (end.min(reach) - start.max(-reach));
                (cross - turn(first, last, left)) * (0.5 / PI)
            }

            pub(crate) fn share_above(offset: $f) -> $f {
                let q = offset.clamp(-1.0, 1.0);
                let half_chord = (1.0 - q * q).max(0.0).sqrt();
                0.5 + (q * half_chord + direction($vec2::new(half_chord, q))) / PI
            }

            #[derive(Clone, Copy)]
            pub(crate) struct DiscView {
                pub(crate) horizon: $vec3,
                pub(crate) far: $f,
                pub(crate) dips: bool,
            }

            fn cut_way(way: [$f; 2], at_start: $f, at_end: $f) -> [$f; 2] {
                if at_start < 0.0 && at_end < 0.0 {
                    return [1.0, 0.0];
                }
                let crossing = at_start / (at_start - at_end);
                [
                    if at_start < 0.0 { way[0].max(crossing) } else { way[0] },
                    if at_end < 0.0 { way[1].min(crossing) } else { way[1] },
                ]
            }

            fn cut_edge_share(disc: DiscView, a: $vec3, b: $vec3, line: $vec3, left: bool) -> $f {
                let mut way = cut_way([0.0, 1.0], disc.far - a.z, disc.far - b.z);
                if disc.dips {
                    way = cut_way(way, disc.horizon.dot(a), disc.horizon.dot(b));
                }
                if way[0] >= way[1] {
                    return 0.0;
                }
                let first = if way[0] == 0.0 { a } else { a.lerp(b, way[0]) };
                let last = if way[1] == 1.0 { b } else { a.lerp(b, way[1]) };
                edge_share(first, last, line, left)
            }

            fn cut_outline(corners: [$vec3; 3], values: [$f; 3]) -> [$vec3; 2] {
                let mut cut = [$vec3::ZERO; 2];
                for (i, j) in [(2, 0), (1, 2), (0, 1)] {
                    let at = corners[i].lerp(corners[j], values[i] / (values[i] - values[j]));
                    match (values[i] >= 0.0, values[j] >= 0.0) {
                        (true, false) => cut[0] = at,
                        (false, true) => cut[1] = at,
                        _ => {}
                    }
                }
                cut
            }

            /// A triangle whose edges ab, bc, ca hold, in canonical order, the same numbers for both their triangles.
            #[derive(Clone, Copy)]
            pub(crate) struct SeenTriangle {
                pub(crate) corners: [$vec3; 3],
                pub(crate) lines: [$vec3; 3],
                pub(crate) left: [bool; 3],
                pub(crate) counts: [bool; 3],
            }

            impl SeenTriangle {
                /// `turned` says of which edges the canonical order is the other way round.
                pub(crate) fn new(corners: [$vec3; 3], turned: [bool; 3], counts: [bool; 3]) -> Self {
                    let corners = corners.map(off_centre);
                    let mut seen = Self { corners, lines: [$vec3::ZERO; 3], left: [false; 3], counts };
                    for i in 0..3 {
                        let (a, b) = (corners[i], corners[(i + 1) % 3]);
                        let line = if turned[i] { b.cross(a) } else { a.cross(b) };
                        seen.left[i] = (line.z >= 0.0) != turned[i];
                        seen.lines[i] = if turned[i] { -line } else { line };
                    }
                    seen
                }
            }

            pub(crate) fn triangle_share(disc: DiscView, t: &SeenTriangle) -> $f {
                let volume = t.corners[0].dot(t.lines[1]);
                let ccw = volume > 0.0;
                let weight: $f = t.lines.iter().map(|line| line.z).sum();
                let before_light = volume * weight.signum() <= disc.far * weight.abs();
                let above = !disc.dips || disc.horizon.z >= 0.0;
                let meets_centre = volume != 0.0 && t.left == [ccw; 3];
                let mut share = 0.0;
                if meets_centre && before_light && above {
                    share += if ccw { 1.0 } else { -1.0 };
                }
                for i in 0..3 {
                    if t.counts[i] {
                        let (a, b) = (t.corners[i], t.corners[(i + 1) % 3]);
                        share += cut_edge_share(disc, a, b, t.lines[i], t.left[i]);
                    }
                }
                let cuts =
                    |values: [$f; 3]| values.iter().any(|v| *v < 0.0) && values.iter().any(|v| *v >= 0.0);
                let before = t.corners.map(|corner| disc.far - corner.z);
                if cuts(before) {
                    let [out, back] = cut_outline(t.corners, before);
                    let line = out.cross(back);
                    let left = if meets_centre { before_light == ccw } else { line.z >= 0.0 };
                    share += cut_edge_share(DiscView { far: 2.0 * disc.far, ..disc }, out, back, line, left);
                }
                if disc.dips {
                    let heights = t.corners.map(|corner| disc.horizon.dot(corner));
                    if cuts(heights) {
                        let [out, back] = cut_outline(t.corners, heights);
                        let line = if ccw { disc.horizon } else { -disc.horizon };
                        let level = DiscView { dips: false, ..disc };
                        share += cut_edge_share(level, out, back, line, above == ccw);
                    }
                }
                share
            }

            #[derive(Clone, Copy)]
            pub(crate) struct Chord {
                up: $vec2,
                along: $vec2,
                offset: $f,
                reach: $f,
            }

            pub(crate) fn chord_of(horizon: $vec3) -> Chord {
                let steep = horizon.truncate().length();
                let up = horizon.truncate() / steep;
                let offset = (horizon.z / steep).clamp(-1.0, 1.0);
                let reach = (1.0 - offset * offset).max(0.0).sqrt();
                Chord { up, along: $vec2::new(up.y, -up.x), offset, reach }
            }

            fn chord_share(chord: Chord, place: $f) -> $f {
                let angle = direction($vec2::new(chord.offset.abs(), place));
                let angle = if chord.offset >= 0.0 { angle } else { -angle };
                (chord.offset * place - angle) * (0.5 / PI)
            }

            fn chord_terms(
                disc: DiscView,
                chord: Chord,
                [a, b]: [$vec3; 2],
                line: $vec3,
                left: bool,
            ) -> $vec2 {
                let middle_left = line.dot((-chord.offset * chord.up).extend(1.0)) >= 0.0;
                let aside = [a, b].map(|corner| corner.truncate().dot(chord.along));
                let mut terms = $vec2::ZERO;
                let at = aside[0] / (aside[0] - aside[1]);
                if middle_left != left
                    && (aside[0] >= 0.0) != (aside[1] >= 0.0)
                    && a.z + (b.z - a.z) * at > 0.0
                {
                    terms.x = if middle_left { 1.0 } else { -1.0 };
                }
                let heights = [a, b].map(|corner| disc.horizon.dot(corner));
                if (heights[0] >= 0.0) != (heights[1] >= 0.0) {
                    let crossing = a.lerp(b, heights[0] / (heights[0] - heights[1]));
                    if crossing.z > 0.0 && crossing.z <= disc.far {
                        let upwards = heights[0] < 0.0;
                        let place = in_disc_plane(crossing).dot(chord.along);
                        let end = chord_share(chord, chord.reach);
                        let rest = if middle_left == upwards {
                            end - chord_share(chord, place.clamp(0.0, chord.reach))
                        } else {
                            -(end + chord_share(chord, place.clamp(-chord.reach, 0.0)))
                        };
                        terms.y = if upwards { -rest } else { rest };
                    }
                }
                terms
            }

            /// What a chain hides of the disc: `over_centre` layers over its centre, and edges (a, b) with their weights.
            pub(crate) fn chain_share(disc: DiscView, over_centre: $f, edges: &[([$vec3; 2], $f)]) -> $f {
                let chord = chord_of(disc.horizon);
                let above = !disc.dips || chord.offset >= 0.0;
                let mut share = if above { over_centre } else { 0.0 };
                let mut over_middle = over_centre;
                for (ends, weight) in edges {
                    let [a, b] = ends.map(off_centre);
                    let line = a.cross(b);
                    let left = line.z >= 0.0;
                    share += weight * cut_edge_share(disc, a, b, line, left);
                    if disc.dips {
                        let terms = chord_terms(disc, chord, [a, b], line, left);
                        over_middle += weight * terms.x;
                        share += weight * terms.y;
                    }
                }
                if disc.dips { share + over_middle * 2.0 * chord_share(chord, chord.reach) } else { share }
            }
        }
    };
}

twin!(in_f64, f64, DVec2, DVec3);
twin!(in_f32, f32, Vec2, Vec3);
