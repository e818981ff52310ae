// The coloured shadow of transparent triangles that are not evenly tinted, texel by texel: as masked_volume, but every
// triangle that the segment to the light crosses lets its own colour pass.

#import common/light_grid_lists
#import common/fullscreen
#import common/transmission

// A listed triangle; corners a, b, c are counter-clockwise as the light sees them.
struct PaneTriangle {
    // Corner a relative to the caster's centre.
    corner: vec3f,
    // Vertex colours, 8 bits of red, green, blue and alpha.
    color_a: u32,
    // The unit normal on the side turned away from the light.
    away: vec3f,
    color_b: u32,
    // Texture coordinates, transformed.
    uv_a: vec2f,
    uv_b: vec2f,
    uv_c: vec2f,
    color_c: u32,
    pad_0: u32,
}

// The triangles of one instance with one material, as the eye sees them.
struct PaneCaster {
    // From the eye to the middle of its bounds.
    center: vec3f,
    // How alpha says what is there: 0 all of it, 1 what is not below the cutoff, 2 as much as alpha says.
    alpha_mode: u32,
    // What the colours of texture and vertices are multiplied by.
    base_color: vec4f,
    cutoff: f32,
    // The share of light that passes what is there: `KHR_materials_transmission`.
    transmission: f32,
    // How texels are read: see common/alpha_mask.
    reading: u32,
    pad_0: u32,
}

@group(1) @binding(2) var<storage, read> triangles: array<PaneTriangle>;
#if BASE_COLOR_TEXTURE
@group(1) @binding(5) var base_color_image: texture_2d<f32>;
#endif
@group(1) @binding(6) var<storage, read> casters: array<PaneCaster>;

@fragment
fn tint(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let depth = textureLoad(receiver_depth, vec2u(position.xy), 0);
    let receiver = receiver_at(position.xy, depth);
    // Depth is reversed: 0 is infinitely far, where nothing is.
    if depth == 0.0 {
        discard;
    }
    let passing = passing_all(receiver);
    if all(passing == vec3f(1.0)) {
        discard;
    }
    return vec4f(passing, 1.0);
}

// What passes all triangles between a receiver and the light.
fn passing_all(receiver: Receiver) -> vec3f {
    var passing = vec3f(1.0);
    var is_first = true;
    for (var plane = 0u; plane < lists_seen.plane_count; plane += 1u) {
        let cells = cells_of(receiver, plane);
        if cells.none {
            continue;
        }
        for (var y = cells.low.y; y <= cells.high.y; y += 1u) {
            for (var x = cells.low.x; x <= cells.high.x; x += 1u) {
                let cell = cell_number(plane, x, y);
                let end = lists[cell + 2u];
                for (var place = lists[cell + 1u]; place < end; place += 2u) {
                    if bitcast<f32>(lists[place + 1u]) > cells.distance {
                        break;
                    }
                    let number = lists[place];
                    let tint = passing_one(number, receiver);
                    // A triangle that several of the cells list counts once.
                    if any(tint != vec3f(1.0)) && (is_first || !is_listed_before(number, receiver, cell)) {
                        passing *= tint;
                    }
                }
                is_first = false;
            }
        }
    }
    return passing;
}

// Whether one of the cells that are asked before number `cell` lists a triangle.
fn is_listed_before(number: u32, receiver: Receiver, cell: u32) -> bool {
    for (var plane = 0u; plane < lists_seen.plane_count; plane += 1u) {
        let cells = cells_of(receiver, plane);
        if cells.none {
            continue;
        }
        for (var y = cells.low.y; y <= cells.high.y; y += 1u) {
            for (var x = cells.low.x; x <= cells.high.x; x += 1u) {
                let asked = cell_number(plane, x, y);
                if asked == cell {
                    return false;
                }
                for (var place = lists[asked + 1u]; place < lists[asked + 2u]; place += 2u) {
                    if bitcast<f32>(lists[place + 1u]) > cells.distance {
                        break;
                    }
                    if lists[place] == number {
                        return true;
                    }
                }
            }
        }
    }
    return false;
}

// What one triangle lets pass of a receiver's light: all, unless it stands between the two.
fn passing_one(number: u32, receiver: Receiver) -> vec3f {
    let cone = cones[number];
    let caster = casters[cone.caster];
    let e = inside_edges(cone, receiver.p - caster.center);
    // A line through an edge that two triangles share crosses one of them.
    let owned = (vec3u(cone.owned_edges) & vec3u(1u, 2u, 4u)) != vec3u(0u);
    let sum = e.x + e.y + e.z;
    if !all((e > vec3f(0.0)) | ((e == vec3f(0.0)) & owned)) || sum <= 0.0 {
        return vec3f(1.0);
    }
    let t = triangles[number];
    if !is_behind(receiver, caster.center + t.corner, t.away) {
        return vec3f(1.0);
    }
    let weights = e / sum;
    let vertex_color = unpack4x8unorm(t.color_a) * weights.x + unpack4x8unorm(t.color_b) * weights.y
        + unpack4x8unorm(t.color_c) * weights.z;
    var color = caster.base_color * vertex_color;
#if BASE_COLOR_TEXTURE
    let uv = t.uv_a * weights.x + t.uv_b * weights.y + t.uv_c * weights.z;
    color *= color_at(base_color_image, uv, caster.reading);
#endif
    return passing_surface(color, caster.alpha_mode, caster.cutoff, caster.transmission);
}
