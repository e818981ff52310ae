// Which edges and triangles may hide the light of a receiver: lists by the cell that it lies in, as the light sees the cells.

#import common/soft_light

#if CASTERS
// Texel i of a packed texture: it is at (i % 2048, i / 2048).
fn packed(words: texture_2d<u32>, texel: u32) -> vec4u {
    return textureLoad(words, vec2u(texel & 2047u, texel >> 11u), 0);
}

// Words: for each cell (plane by plane, slice by slice, row by row) where its edges' numbers begin, and after the last cell
// where they end; the same for triangles, without slices; then the numbers themselves. Behind them the same for triangles near
// the light, and for those with holes, by slices as edges.
@group(1) @binding(3) var soft_lists: texture_2d<u32>;

fn list_word(place: u32) -> u32 {
    let four = packed(soft_lists, place >> 2u);
    let two = select(four.xy, four.zw, (place & 2u) != 0u);
    return select(two.x, two.y, (place & 1u) != 0u);
}

// A range of soft_lists.
struct CellList {
    first: u32,
    end: u32,
}

// What may hide the light of a receiver.
struct Lists {
    edges: CellList,
    triangles: CellList,
    // Triangles that are in no other list.
    near: CellList,
    // How many clusters to ask, from the first.
    clusters: u32,
#if MASKS
    // Triangles with holes, and whether the range is not one of lists but of the triangles' numbers.
    masked: CellList,
    masked_by_number: bool,
#endif
}

// The receiver's cell on a plane, of `side` cells along a side; nothing is listed where `inside` is false.
struct Cell {
    inside: bool,
    plane: u32,
    // From 0 to 1 across the plane.
    place: vec2f,
}

// Where a direction meets the cube of faces +x, −x, +y, −y, +z, −z: away from the middle first, then across and up.
struct OnCube {
    face: u32,
    place: vec3f,
}

// Where `d` meets the cube around the origin.
fn on_cube(d: vec3f) -> OnCube {
    let size = abs(d);
    let second = size.y > size.x;
    let third = size.z > max(size.x, size.y);
    let axis = select(select(0u, 1u, second), 2u, third);
    let place = select(select(d.xyz, d.yzx, second), d.zxy, third);
    return OnCube(axis * 2u + select(0u, 1u, place.x < 0.0), vec3f(abs(place.x), place.yz));
}

fn cell_of(r: Receiver) -> Cell {
    let d = r.p - soft.origin;
    let cube = on_cube(d);
    let in_plane = vec3f(dot(soft.plane.z_axis, d) + soft.plane.z_offset, dot(soft.plane.x_axis, d), dot(soft.plane.y_axis, d));
    let six = soft.plane_count > 1u;
    let seen = select(in_plane, cube.place, six);
    let inside = seen.x > 0.0 && all(abs(seen.yz) <= vec2f(seen.x * 1.00001));
    return Cell(inside, select(0u, cube.face, six), seen.yz / seen.x * 0.5 + 0.5);
}

fn cell_number(cell: Cell, layer: u32, side: u32) -> u32 {
    let place = vec2u(clamp(cell.place * f32(side), vec2f(0.0), vec2f(f32(side) - 1.0)));
    return (layer * side + place.y) * side + place.x;
}

fn list_at(place: u32) -> CellList {
    return CellList(list_word(place), list_word(place + 1u));
}

// As in near_light_triangles.rs of ShadowVolumeSoft: cells along a side of each face, and how far off (as an angle) a direction
// from the light may be for the lists to be used.
const NEAR_SIDE: u32 = 12u;
const NEAR_MARGIN: f32 = 1e-3;

fn lists_of(r: Receiver) -> Lists {
    // Nothing is listed where nothing is said.
    var lists: Lists;
    // Nearer than two radii to the light, all triangles are tested.
    if soft.light.w > 0.0 && r.light_distance < 2.0 * soft.radius {
        lists.clusters = soft.cluster_count;
#if MASKS
        lists.masked = CellList(soft.first_masked, soft.end_masked);
        lists.masked_by_number = true;
#endif
        return lists;
    }
    // Near triangles are listed by the direction from the light, where that is known well enough.
    let from_light = on_cube(-r.w);
    let near_cell = Cell(true, from_light.face, from_light.place.yz / from_light.place.x * 0.5 + 0.5);
    let lost = ROUNDING * (2.0 * length(r.p) + r.light_distance);
    let is_listed = soft.near_lists > 0u && lost < NEAR_MARGIN * r.light_distance;
    let near_list = list_at(soft.near_lists + cell_number(near_cell, near_cell.plane, NEAR_SIDE));
    lists.near = CellList(select(0u, near_list.first, is_listed), select(0u, near_list.end, is_listed));
    lists.clusters = select(soft.near_clusters, 0u, is_listed);
    let cell = cell_of(r);
    if !cell.inside {
        return lists;
    }
    let along = select(dot(soft.plane.away, r.p - soft.origin), r.light_distance, soft.light.w > 0.0);
    let before = vec4u(vec4f(along) > soft.slice_ends[0]) + vec4u(vec4f(along) > soft.slice_ends[1]);
    let slice = min(before.x + before.y + before.z + before.w, soft.slice_count - 1u);
    lists.edges = list_at(cell_number(cell, cell.plane * soft.slice_count + slice, soft.side));
    lists.triangles = list_at(soft.triangle_lists + cell_number(cell, cell.plane, soft.triangle_side));
#if MASKS
    lists.masked = list_at(soft.masked_lists + cell_number(cell, cell.plane * soft.slice_count + slice, soft.masked_side));
#endif
    return lists;
}
#endif
