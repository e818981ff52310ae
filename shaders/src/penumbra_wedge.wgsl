// Penumbra wedges: for every silhouette edge the volume in which it may cut the disc of the light, and how much of the
// disc lies between the edge and the light's centre.

#import common/frame
#import common/fullscreen
#import common/disc_coverage

// A silhouette edge and the four planes that bound its wedge. Directions are those of the world.
struct WedgeEdge {
    // The ends, relative to the caster's centre; what is hidden lies to the left as receivers see it.
    a: vec3f,
    // How many layers it bounds.
    weight: f32,
    b: vec3f,
    caster: u32,
    // Outward normals of the planes: two through the edge, one through a, one through b. Without planes all are zero.
    normals: array<vec4f, 4>,
    // Along which the wedge's edges go: from a and b in the first plane, then in the second.
    rays: array<vec4f, 4>,
}

struct WedgeCasters {
    // The columns of the rotation that takes directions from view space to the world.
    world_x: vec3f,
    // The radius of the light in metres; the tangent of its half-angle for a direction.
    size: f32,
    world_y: vec3f,
    // How far from an edge its wedge ends, for views that have no place for points at infinity; else 0.
    end_m: f32,
    world_z: vec3f,
    pad_0: f32,
    // The light from the eye, (position, 1) or (unit direction towards it, 0).
    light: vec4f,
    // From the eye to the middle of each caster's bounds.
    centers: array<vec4f>,
}

@group(1) @binding(0) var<storage, read> casters: WedgeCasters;
@group(1) @binding(1) var<storage, read> edges: array<WedgeEdge>;
@group(1) @binding(2) var receiver_depth: texture_depth_2d;
@group(1) @binding(3) var counts: texture_2d<f32>;

fn world_from_view(d: vec3f) -> vec3f {
    return casters.world_x * d.x + casters.world_y * d.y + casters.world_z * d.z;
}

fn view_from_world(d: vec3f) -> vec3f {
    return vec3f(dot(casters.world_x, d), dot(casters.world_y, d), dot(casters.world_z, d));
}

struct Varyings {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat, first) edge: u32,
}

// Views from infinity see wedges without depth: at the far plane, where nothing is cut off.
fn behind_all(clip: vec4f) -> vec4f {
    return vec4f(clip.xy, select(0.0, clip.z, frame.eye_w > 0.0), clip.w);
}

// The corners of a wedge's faces: 0 and 1 are a and b, 2 to 5 the far ends of `rays`.
const FACES = array<u32, 24>(
    0u, 1u, 3u, 0u, 3u, 2u,
    0u, 1u, 5u, 0u, 5u, 4u,
    0u, 2u, 4u,
    1u, 3u, 5u,
    2u, 3u, 5u, 2u, 5u, 4u,
);

// The faces through which views leave the wedge: every ray meets one of them at most. The far end is one of them.
@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) number: u32) -> Varyings {
    let edge = edges[number];
    let center = casters.centers[edge.caster].xyz;
    if all(edge.normals[0].xyz == vec3f(0.0)) {
        // No planes: the whole view, behind everything.
        let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
        return Varyings(vec4f(select(corner * 2.0 - 1.0, vec2f(-1.0), index > 2u), 0.0, 1.0), number);
    }
    let face = select(select(select(min(index / 6u, 1u), 2u, index >= 12u), 3u, index >= 15u), 4u, index >= 18u);
    if face < 4u {
        let normal = edge.normals[face].xyz;
        let on_plane = center + select(edge.a, edge.b, face == 3u);
        // How far the eye is on the outer side; of a view from infinity, how much it looks inwards.
        let outside = select(dot(normal, casters.world_z), -dot(normal, on_plane), frame.eye_w > 0.0);
        if outside > 0.0 {
            return Varyings(vec4f(0.0, 0.0, 0.0, 1.0), number);
        }
    }
    var faces = FACES;
    let corner = faces[index];
    let start = center + select(edge.a, edge.b, (corner & 1u) == 1u);
    if corner < 2u {
        return Varyings(behind_all(frame.clip_from_view * vec4f(view_from_world(start), 1.0)), number);
    }
    let ray = edge.rays[corner - 2u].xyz;
    if casters.end_m == 0.0 {
        return Varyings(frame.clip_from_view * vec4f(view_from_world(ray), 0.0), number);
    }
    return Varyings(behind_all(frame.clip_from_view * vec4f(view_from_world(start + ray * casters.end_m), 1.0)), number);
}

// What the edge adds to the layers over the light's centre; 0 where it does not cut the disc.
@fragment
fn add_share(in: Varyings) -> @location(0) vec4f {
    let depth = textureLoad(receiver_depth, vec2u(in.clip.xy), 0);
    if depth == 0.0 {
        discard;
    }
    let p = world_from_view(view_from_pixel(in.clip.xy, depth));
    let to_light = casters.light.xyz - p * casters.light.w;
    let distance = length(to_light);
    let towards = to_light / max(distance, NOTHING);
    // Within the light only its centre counts.
    var scale = 1.0 / casters.size;
    var far = 1e20;
    if casters.light.w > 0.0 {
        let tangent_squared = distance * distance - casters.size * casters.size;
        if tangent_squared <= 0.0 {
            discard;
        }
        scale = sqrt(tangent_squared) / casters.size;
        far = distance;
    }
    let edge = edges[in.edge];
    let to_caster = casters.centers[edge.caster].xyz - p;
    // Axes across, so that what is counter-clockwise as the receiver sees it is so here.
    let across = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(towards.x) > 0.7);
    let v = normalize(cross(across, towards));
    let u = cross(towards, v);
    let rows = mat3x3f(u * scale, v * scale, towards);
    let a = off_centre((to_caster + edge.a) * rows);
    let b = off_centre((to_caster + edge.b) * rows);
    let line = cross(a, b);
    let share = cut_edge_share(DiscView(vec3f(0.0), far, false, 0.0, 0.0), a, b, line, line.z >= 0.0);
    return vec4f(edge.weight * share);
}

// The light that is left.
@fragment
fn darken(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(saturate(1.0 - textureLoad(counts, vec2u(position.xy), 0).x));
}
