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
    // Corners within this of the receiver's plane lie in it: below the horizon.
    margin: f32,
    // By how much the horizon is taken to lie above the receiver's plane, where Z is 1.
    lift: f32,
}

// Of a corner, over the horizon.
fn height_over(disc: DiscView, corner: vec3f) -> f32 {
    let height = dot(disc.horizon, corner);
    return select(height, -disc.margin, abs(height) <= disc.margin);
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
        way = cut_way(way, height_over(disc, a), height_over(disc, b));
    }
    if way.x >= way.y {
        return 0.0;
    }
    return edge_share(select(mix(a, b, way.x), a, way.x == 0.0), select(mix(a, b, way.y), b, way.y == 1.0), line, left);
}

// The share of the disc within the triangle of the centre, a and b; negative where they are clockwise.
fn sector_share(a: vec2f, b: vec2f) -> f32 {
    let way = b - a;
    let length_squared = max(dot(way, way), NOTHING);
    let cross = a.x * way.y - a.y * way.x;
    let foot = -dot(a, way) / length_squared;
    let half = sqrt(max(length_squared - cross * cross, 0.0)) / length_squared;
    let enters = clamp(foot - half, 0.0, 1.0);
    let leaves = clamp(foot + half, 0.0, 1.0);
    if enters >= leaves {
        return angle_between(a, b) * (0.5 / PI);
    }
    let inside = cross * (leaves - enters);
    // From an end within the disc there is no way outside: not even a rounded one.
    let before = select(0.0, angle_between(a, a + way * enters), enters > 0.0);
    let after = select(0.0, angle_between(a + way * leaves, b), leaves < 1.0);
    return (before + inside + after) * (0.5 / PI);
}

// −π ... π.
fn angle_between(a: vec2f, b: vec2f) -> f32 {
    return direction(vec2f(dot(a, b), a.x * b.y - a.y * b.x));
}

// A convex polygon: a triangle, cut by six planes.
struct Outline {
    count: u32,
    corners: array<vec3f, 9>,
}

// What of an outline lies where inside·(x, 1) is not negative; corners within `margin` do not.
fn cut_outline(outline: Outline, inside: vec4f, margin: f32) -> Outline {
    var whole = outline;
    var cut: Outline;
    for (var i = 0u; i < whole.count; i += 1u) {
        let a = whole.corners[i];
        let b = whole.corners[select(i + 1u, 0u, i + 1u == whole.count)];
        var ends = vec2f(dot(inside.xyz, a), dot(inside.xyz, b)) + inside.w;
        ends = select(ends, vec2f(-margin), abs(ends) <= vec2f(margin));
        if ends.x >= 0.0 && cut.count < 9u {
            cut.corners[cut.count] = a;
            cut.count += 1u;
        }
        if (ends.x >= 0.0) != (ends.y >= 0.0) && cut.count < 9u {
            cut.corners[cut.count] = mix(a, b, ends.x / (ends.x - ends.y));
            cut.count += 1u;
        }
    }
    return cut;
}

// Beyond this many radii from the centre nothing is followed: what is far out would cost the digits of what is near.
const WIDEST: f32 = 4.0;

// The share of the disc that one triangle hides, wherever it lies; negative where its corners are clockwise. All of its
// outline is followed, outside the disc too, so that nothing need be known about the centre.
fn triangle_share(disc: DiscView, a: vec3f, b: vec3f, c: vec3f) -> f32 {
    var outline: Outline;
    outline.count = 3u;
    outline.corners[0] = a;
    outline.corners[1] = b;
    outline.corners[2] = c;
    let reach = max(max(abs(a.xy), abs(b.xy)), abs(c.xy));
    let is_wide = max(reach.x, reach.y) > WIDEST * min(a.z, min(b.z, c.z));
    let is_beyond = max(a.z, max(b.z, c.z)) > disc.far;
    // Plane by plane, and only those that cut: a loop, since pixels that are drawn together skip only loops.
    for (var i = 0u; i < 6u; i += 1u) {
        var cuts = select(select(is_wide, is_beyond, i == 4u), disc.dips, i == 5u);
        let out = select(-1.0, 1.0, (i & 1u) == 0u);
        var inside = vec4f(select(vec2f(0.0, out), vec2f(out, 0.0), i < 2u), WIDEST, 0.0);
        inside = select(inside, vec4f(0.0, 0.0, -1.0, disc.far), i == 4u);
        inside = select(inside, vec4f(disc.horizon, 0.0), i == 5u);
        let margin = select(0.0, disc.margin, i == 5u);
        while cuts {
            outline = cut_outline(outline, inside, margin);
            cuts = false;
        }
    }
    var share = 0.0;
    for (var i = 0u; i < outline.count; i += 1u) {
        let next = select(i + 1u, 0u, i + 1u == outline.count);
        share += sector_share(in_disc_plane(outline.corners[i]), in_disc_plane(outline.corners[next]));
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
    // The middle lies above an edge in the receiver's plane, whatever rounding makes of it.
    let over_plane = vec2f(dot(disc.horizon, a), dot(disc.horizon, b)) + disc.lift * vec2f(a.z, b.z);
    let in_plane = all(abs(over_plane) <= vec2f(disc.margin));
    let middle_left = select(dot(line, vec3f(-chord.offset * chord.up, 1.0)), dot(line.xy, chord.up), in_plane) >= 0.0;
    let aside = vec2f(dot(a.xy, chord.along), dot(b.xy, chord.along));
    var terms = vec2f(0.0);
    if middle_left != left && (aside.x >= 0.0) != (aside.y >= 0.0) && mix(a.z, b.z, aside.x / (aside.x - aside.y)) > 0.0 {
        terms.x = select(-1.0, 1.0, middle_left);
    }
    let heights = vec2f(height_over(disc, a), height_over(disc, b));
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
