//! `common/disc_coverage.wgsl` written out in Rust, once in f64 and once in f32: so that its mathematics and its rounding
//! are judged apart, and without a device.

#![allow(clippy::excessive_precision, reason = "the shader's constants, in f64 too")]

macro_rules! twin {
    ($name:ident, $f:ident, $vec2:ident, $vec3:ident) => {
        pub mod $name {
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

            pub fn edge_share(a: $vec3, b: $vec3, line: $vec3, left: bool) -> $f {
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

            pub fn share_above(offset: $f) -> $f {
                let q = offset.clamp(-1.0, 1.0);
                let half_chord = (1.0 - q * q).max(0.0).sqrt();
                0.5 + (q * half_chord + direction($vec2::new(half_chord, q))) / PI
            }

            #[derive(Clone, Copy)]
            pub struct DiscView {
                pub horizon: $vec3,
                pub far: $f,
                pub dips: bool,
                pub margin: $f,
                pub lift: $f,
            }

            fn height_over(disc: DiscView, corner: $vec3) -> $f {
                let height = disc.horizon.dot(corner);
                if height.abs() <= disc.margin { -disc.margin } else { height }
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
                    way = cut_way(way, height_over(disc, a), height_over(disc, b));
                }
                if way[0] >= way[1] {
                    return 0.0;
                }
                let first = if way[0] == 0.0 { a } else { a.lerp(b, way[0]) };
                let last = if way[1] == 1.0 { b } else { a.lerp(b, way[1]) };
                edge_share(first, last, line, left)
            }

            fn sector_share(a: $vec2, b: $vec2) -> $f {
                let way = b - a;
                let length_squared = way.length_squared().max(NOTHING);
                let cross = a.perp_dot(way);
                let foot = -a.dot(way) / length_squared;
                let half = (length_squared - cross * cross).max(0.0).sqrt() / length_squared;
                let (enters, leaves) = ((foot - half).clamp(0.0, 1.0), (foot + half).clamp(0.0, 1.0));
                if enters >= leaves {
                    return angle_between(a, b) * (0.5 / PI);
                }
                let before = if enters > 0.0 { angle_between(a, a + way * enters) } else { 0.0 };
                let after = if leaves < 1.0 { angle_between(a + way * leaves, b) } else { 0.0 };
                (before + cross * (leaves - enters) + after) * (0.5 / PI)
            }

            fn angle_between(a: $vec2, b: $vec2) -> $f {
                direction($vec2::new(a.dot(b), a.perp_dot(b)))
            }

            fn cut_outline(outline: &[$vec3], inside: impl Fn($vec3) -> $f) -> Vec<$vec3> {
                let mut cut = Vec::new();
                for (i, &a) in outline.iter().enumerate() {
                    let b = outline[(i + 1) % outline.len()];
                    let ends = [inside(a), inside(b)];
                    if ends[0] >= 0.0 {
                        cut.push(a);
                    }
                    if (ends[0] >= 0.0) != (ends[1] >= 0.0) {
                        cut.push(a.lerp(b, ends[0] / (ends[0] - ends[1])));
                    }
                }
                assert!(cut.len() <= 9, "the shader has no room for more");
                cut
            }

            pub fn triangle_share(disc: DiscView, corners: [$vec3; 3]) -> $f {
                let mut outline = corners.to_vec();
                for side in [$vec3::X, -$vec3::X, $vec3::Y, -$vec3::Y] {
                    outline = cut_outline(&outline, |corner| side.dot(corner) + 4.0 * corner.z);
                }
                outline = cut_outline(&outline, |corner| disc.far - corner.z);
                if disc.dips {
                    outline = cut_outline(&outline, |corner| height_over(disc, corner));
                }
                let corner = |i: usize| in_disc_plane(outline[i % outline.len()]);
                (0..outline.len()).map(|i| sector_share(corner(i), corner(i + 1))).sum()
            }

            #[derive(Clone, Copy)]
            pub struct Chord {
                up: $vec2,
                along: $vec2,
                offset: $f,
                reach: $f,
            }

            pub fn chord_of(horizon: $vec3) -> Chord {
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
                let in_plane =
                    [a, b].iter().all(|p| (disc.horizon.dot(*p) + disc.lift * p.z).abs() <= disc.margin);
                let at_middle = line.dot((-chord.offset * chord.up).extend(1.0));
                let middle_left = if in_plane { line.truncate().dot(chord.up) } else { at_middle } >= 0.0;
                let aside = [a, b].map(|corner| corner.truncate().dot(chord.along));
                let mut terms = $vec2::ZERO;
                let at = aside[0] / (aside[0] - aside[1]);
                if middle_left != left
                    && (aside[0] >= 0.0) != (aside[1] >= 0.0)
                    && a.z + (b.z - a.z) * at > 0.0
                {
                    terms.x = if middle_left { 1.0 } else { -1.0 };
                }
                let heights = [a, b].map(|corner| height_over(disc, corner));
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
            pub fn chain_share(disc: DiscView, over_centre: $f, edges: &[([$vec3; 2], $f)]) -> $f {
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
