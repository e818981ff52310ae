// How much of a light's disc triangles hide from a receiver, exactly: what penumbra wedges and coverage per receiver share.
//
// Points are homogeneous coordinates (X, Y, Z) of the receiver's own frame: Z along the way to the light's centre, and
// (X, Y)/Z where the unit disc is 1 in radius. What lies behind the receiver (Z <= 0) needs no clipping: a line meets
// the cone over the disc in one interval, and only that counts.
//
// A polygon hides H + Σ dC of the disc: H is 1 if it covers the centre, and an edge from a to b, cut to a′b′ by the disc,
// adds dC = −(φ − a′ × b′)/2π, where φ is the angle from a′ to b′ about the centre. H and φ both turn with the sign of
// N.z, N = A × B, which is therefore decided once for each edge; and φ is a difference of directions that the edges of a
// corner share. So both jump together, and the sum is continuous where edges and corners pass the centre.

const PI: f32 = 3.14159265358979;
const NOTHING: f32 = 1e-30;

// The arc tangent of 0 ... 1, within 2e-7 (WGSL promises no more than 4096 ulps of its own).
fn atan_unit(x: f32) -> f32 {
    let s = x * x;
    var sum = 0.0028662257;
    sum = sum * s - 0.0161657367;
    sum = sum * s + 0.0429096138;
    sum = sum * s - 0.0752896400;
    sum = sum * s + 0.1065626393;
    sum = sum * s - 0.1420889944;
    sum = sum * s + 0.1999355085;
    sum = sum * s - 0.3333314528;
    return x + x * s * sum;
}

// The direction of (x, y), −π ... π; that of (0, 0) is 0.
fn direction(p: vec2f) -> f32 {
    let size = abs(p);
    let low = min(size.x, size.y);
    let first = atan_unit(low / max(max(size.x, size.y), NOTHING));
    let quarter = select(first, 0.5 * PI - first, size.y > size.x);
    let half = select(quarter, PI - quarter, p.x < 0.0);
    return select(half, -half, p.y < 0.0);
}

// The angle from a to b about the centre, 0 ... π where `left` says that the centre is to the left of the way.
fn turn(a: vec2f, b: vec2f, left: bool) -> f32 {
    var angle = direction(b) - direction(a);
    if angle > PI {
        angle -= 2.0 * PI;
    } else if angle < -PI {
        angle += 2.0 * PI;
    }
    // Where the centre is within rounding of the way, its side is as `left` says.
    if left && angle < -1.0 {
        angle += 2.0 * PI;
    } else if !left && angle > 1.0 {
        angle -= 2.0 * PI;
    }
    return angle;
}

// A corner in the plane of the disc; far outside the disc where it is not before the receiver.
fn in_disc_plane(corner: vec3f) -> vec2f {
    return corner.xy / max(corner.z, 1e-6 * max(abs(corner.x), abs(corner.y)) + NOTHING);
}

// A corner that is the centre has no direction: it is moved by nothing that shows, for all its edges alike.
fn off_centre(corner: vec3f) -> vec3f {
    return select(corner, vec3f(1e-12, 0.0, corner.z), all(corner.xy == vec2f(0.0)));
}

// What the edge from a to b adds, beside H. `line` is A × B or a multiple of it; `left` whether line.z counts as positive.
fn edge_share(a: vec3f, b: vec3f, line: vec3f, left: bool) -> f32 {
    let across_squared = dot(line.xy, line.xy);
    if line.z * line.z >= across_squared || max(a.z, b.z) <= 0.0 {
        return 0.0;
    }
    let normal = line.xy * inverseSqrt(across_squared);
    let along = vec2f(normal.y, -normal.x);
    let height = line.z * inverseSqrt(across_squared);
    let reach = sqrt(max(1.0 - height * height, 0.0));
    let a_in_plane = in_disc_plane(a);
    let b_in_plane = in_disc_plane(b);
    // From behind the receiver the line comes from, or goes to, its end.
    let start = select(-1e30, dot(a_in_plane, along), a.z > 0.0);
    let end = select(1e30, dot(b_in_plane, along), b.z > 0.0);
    if start >= reach || end <= -reach || end <= start {
        return 0.0;
    }
    let foot = -height * normal;
    let first = select(foot - reach * along, a_in_plane, start > -reach);
    let last = select(foot + reach * along, b_in_plane, end < reach);
    let cross = height * (min(end, reach) - max(start, -reach));
    return (cross - turn(first, last, left)) * (0.5 / PI);
}

// The share of the disc where g·x + offset >= 0, for a unit g.
fn share_above(offset: f32) -> f32 {
    let q = clamp(offset, -1.0, 1.0);
    let half_chord = sqrt(max(1.0 - q * q, 0.0));
    return 0.5 + (q * half_chord + direction(vec2f(half_chord, q))) / PI;
}

// What is seen of the light from a receiver.
struct DiscView {
    // Points x with horizon·x < 0 lie below the receiver's own plane.
    horizon: vec3f,
    // How far away the light's disc is, along Z.
    far: f32,
    // Whether the plane cuts the disc.
    dips: bool,
}

// What of the way 0 ... 1 is left where a value that goes from `at_start` to `at_end` is not negative.
fn cut_way(way: vec2f, at_start: f32, at_end: f32) -> vec2f {
    if at_start < 0.0 && at_end < 0.0 {
        return vec2f(1.0, 0.0);
    }
    let crossing = at_start / (at_start - at_end);
    return vec2f(select(way.x, max(way.x, crossing), at_start < 0.0), select(way.y, min(way.y, crossing), at_end < 0.0));
}

// As edge_share, of what of the edge lies before the light, and not below the horizon.
fn cut_edge_share(disc: DiscView, a: vec3f, b: vec3f, line: vec3f, left: bool) -> f32 {
    var way = cut_way(vec2f(0.0, 1.0), disc.far - a.z, disc.far - b.z);
    if disc.dips {
        way = cut_way(way, dot(disc.horizon, a), dot(disc.horizon, b));
    }
    if way.x >= way.y {
        return 0.0;
    }
    return edge_share(select(mix(a, b, way.x), a, way.x == 0.0), select(mix(a, b, way.y), b, way.y == 1.0), line, left);
}

// Where the outline of a triangle leaves the side where `values` (of a, b, c) are not negative, and where it comes back.
struct Cut {
    out_at: vec3f,
    back_at: vec3f,
}

fn cut_outline(a: vec3f, b: vec3f, c: vec3f, values: vec3f) -> Cut {
    let ab = mix(a, b, values.x / (values.x - values.y));
    let bc = mix(b, c, values.y / (values.y - values.z));
    let ca = mix(c, a, values.z / (values.z - values.x));
    let inside = values >= vec3f(0.0);
    var cut: Cut;
    cut.out_at = select(select(ca, bc, inside.y && !inside.z), ab, inside.x && !inside.y);
    cut.back_at = select(select(ca, bc, !inside.y && inside.z), ab, !inside.x && inside.y);
    return cut;
}

// A triangle as it is seen from a receiver: corners, the lines of its edges, and whether the centre of the light is to the
// left of each. Edges that do not count are those of neighbours that hide the light on their other side.
struct SeenTriangle {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    ab: vec3f,
    bc: vec3f,
    ca: vec3f,
    // For ab, bc, ca.
    left: vec3<bool>,
    counts: vec3<bool>,
}

// The share of the disc that a triangle hides; negative where its corners are clockwise. Edges that do not count are left
// out, so that only sums over triangles mean something.
fn triangle_share(disc: DiscView, t: SeenTriangle) -> f32 {
    let volume = dot(t.a, t.bc);
    let ccw = volume > 0.0;
    // Where the way to the centre meets the triangle's plane, times this, is `volume`.
    let weight = t.ab.z + t.bc.z + t.ca.z;
    let before_light = volume * sign(weight) <= disc.far * abs(weight);
    let above = !disc.dips || disc.horizon.z >= 0.0;
    let meets_centre = select(!any(t.left), all(t.left), ccw) && volume != 0.0;
    var share = select(0.0, select(-1.0, 1.0, ccw), meets_centre && before_light && above);
    if t.counts.x {
        share += cut_edge_share(disc, t.a, t.b, t.ab, t.left.x);
    }
    if t.counts.y {
        share += cut_edge_share(disc, t.b, t.c, t.bc, t.left.y);
    }
    if t.counts.z {
        share += cut_edge_share(disc, t.c, t.a, t.ca, t.left.z);
    }
    // The edges along which it is cut.
    let before = vec3f(disc.far) - vec3f(t.a.z, t.b.z, t.c.z);
    if any(before < vec3f(0.0)) && any(before >= vec3f(0.0)) {
        let cut = cut_outline(t.a, t.b, t.c, before);
        let line = cross(cut.out_at, cut.back_at);
        share += cut_edge_share(DiscView(disc.horizon, 2.0 * disc.far, disc.dips), cut.out_at, cut.back_at, line,
            select(line.z >= 0.0, before_light == ccw, meets_centre));
    }
    if disc.dips {
        let heights = vec3f(dot(disc.horizon, t.a), dot(disc.horizon, t.b), dot(disc.horizon, t.c));
        if any(heights < vec3f(0.0)) && any(heights >= vec3f(0.0)) {
            let cut = cut_outline(t.a, t.b, t.c, heights);
            // Along the horizon itself nothing lies below it.
            share += cut_edge_share(DiscView(disc.horizon, disc.far, false), cut.out_at, cut.back_at,
                select(-disc.horizon, disc.horizon, ccw), above == ccw);
        }
    }
    return share;
}

// The horizon's chord of the disc. Edges alone do not say what of it a chain of triangles covers; they say where that
// changes: so much is known along it as is known at its middle, and that follows from the centre.
struct Chord {
    // The unit normal of the horizon, and along it, with what is above to the left.
    up: vec2f,
    along: vec2f,
    // How far the centre lies above it, and half its length.
    offset: f32,
    reach: f32,
}

fn chord_of(horizon: vec3f) -> Chord {
    let steep = length(horizon.xy);
    let up = horizon.xy / steep;
    let offset = clamp(horizon.z / steep, -1.0, 1.0);
    return Chord(up, vec2f(up.y, -up.x), offset, sqrt(max(1.0 - offset * offset, 0.0)));
}

// What the chord adds from its middle to `place` along it, where it is covered.
fn chord_share(chord: Chord, place: f32) -> f32 {
    let angle = direction(vec2f(abs(chord.offset), place));
    return (chord.offset * place - select(-angle, angle, chord.offset >= 0.0)) * (0.5 / PI);
}

// What an edge changes: by how much more its left side covers the middle of the chord than the centre, and what the
// change of cover along the chord adds. For an edge that weighs 1 and has a, b in canonical order.
fn chord_terms(disc: DiscView, chord: Chord, a: vec3f, b: vec3f, line: vec3f, left: bool) -> vec2f {
    let middle_left = dot(line, vec3f(-chord.offset * chord.up, 1.0)) >= 0.0;
    let aside = vec2f(dot(a.xy, chord.along), dot(b.xy, chord.along));
    var terms = vec2f(0.0);
    if middle_left != left && (aside.x >= 0.0) != (aside.y >= 0.0) && mix(a.z, b.z, aside.x / (aside.x - aside.y)) > 0.0 {
        terms.x = select(-1.0, 1.0, middle_left);
    }
    let heights = vec2f(dot(disc.horizon, a), dot(disc.horizon, b));
    if (heights.x >= 0.0) != (heights.y >= 0.0) {
        let crossing = mix(a, b, heights.x / (heights.x - heights.y));
        if crossing.z > 0.0 && crossing.z <= disc.far {
            let upwards = heights.x < 0.0;
            let place = dot(in_disc_plane(crossing), chord.along);
            // On which side of the middle it is, its line says: so that both jump together.
            var rest = chord_share(chord, chord.reach);
            if middle_left == upwards {
                rest -= chord_share(chord, clamp(place, 0.0, chord.reach));
            } else {
                rest = -(rest + chord_share(chord, clamp(place, -chord.reach, 0.0)));
            }
            terms.y = select(rest, -rest, upwards);
        }
    }
    return terms;
}
