// The vertices of shadow volumes: sides, front caps and far caps of one caster for one light, drawn from the caster's own
// vertices.

#import common/frame
#import common/positions

// One caster of one light.
struct Volume {
    // The light in the caster's local space, (position, 1) or (direction towards it, 0), as the sum of two f32:
    // vertex − light stays exact to the last digit even for a light that touches the caster.
    light_high: vec4f,
    light_low: vec4f,
    // Where volumes end, in local space: {x : normal·x = offset}.
    end_normal: vec3f,
    end_offset: f32,
    // How they end: 0 at infinity, 1 on the end plane, 2 as a copy scaled about the light by 1 + `end_scale`, 3 as far as
    // `end_scale` from where they begin.
    end_kind: u32,
    end_scale: f32,
    instance: u32,
    // Where its cut vertices begin.
    first_cut: u32,
}

@group(1) @binding(1) var<storage, read> volumes: array<Volume>;

#if CUT_EDGES
// Where an edge or a face is cut that the light all but touches, in local space; and from there the direction away from the
// light, which positions of f32 would not tell.
struct CutVertex {
    position: vec3f,
    pad_0: u32,
    away: vec3f,
    pad_1: u32,
}

@group(1) @binding(4) var<storage, read> cut_vertices: array<CutVertex>;

// Vertices from this number on are cut vertices.
const FIRST_CUT: u32 = 0x20000000u;
#endif

// Sides lie 16 roundings behind where they are, or less: more would lose what is dark right behind a short side. The side that
// hangs from an edge of a visible, lit triangle lies behind that triangle, but next to the edge by less than rounding can
// tell, and a side mistaken to be in front could cancel another caster's count. (For a triangle turned away from the light
// it lies in front; but such a surface is dark whatever the count.) Caps are moved by the draw's depth bias, once their
// depth is interpolated: from the corners of the visible surface, in its order, they have its very depth until then.
const SIDE_SHIFT: f32 = 9.5367431640625e-7;

// As much before the surface: for sides that begin at a visible triangle, which must not be before them by rounding.
const AHEAD_SHIFT: f32 = 9.5367431640625e-7;

// A corner moved towards the eye by a share of its depth; under an orthographic eye, whose depth loses as much everywhere, by
// half that share of 1.
fn moved_nearer(clip: vec4f, share: f32) -> vec4f {
    let depth_unit = select(0.5 * clip.w, clip.z, frame.eye_w > 0.0);
    return vec4f(clip.xy, clip.z + depth_unit * share, clip.w);
}

#if CUT_EDGES
// The cut vertex that has this number; any, if none has.
fn cut_vertex(vertex: u32, volume: Volume) -> CutVertex {
    return cut_vertices[select(0u, volume.first_cut + vertex - FIRST_CUT, vertex >= FIRST_CUT)];
}
#endif

// A vertex of a volume in local space.
fn volume_vertex(vertex: u32, volume: Volume) -> vec3f {
#if CUT_EDGES
    let is_cut = vertex >= FIRST_CUT;
    let own = local_position(select(vertex, 0u, is_cut));
    return select(own, cut_vertex(vertex, volume).position, is_cut);
#else
    return local_position(vertex);
#endif
}

// Where a corner of a volume goes. Each index is 4·vertex + what is meant: 0 a corner of a cap, 2 a near corner of a side,
// 1 such a corner a little before the surface, 3 the vertex's extruded twin.
fn volume_clip(index: u32, volume_index: u32) -> vec4f {
    let volume = volumes[volume_index];
    let kind = index & 3u;
    let vertex = index >> 2u;
    let p = volume_vertex(vertex, volume);
    let clip = clip_from_local(volume.instance, p);
    if kind == 0u {
        return clip;
    }
    if kind != 3u {
        return moved_nearer(clip, select(-SIDE_SHIFT, AHEAD_SHIFT, kind == 1u));
    }
    // The direction in which the vertex is extruded: w·v − l.
    var away = (p * volume.light_high.w - volume.light_high.xyz) - volume.light_low.xyz;
#if CUT_EDGES
    away = select(away, cut_vertex(vertex, volume).away, vertex >= FIRST_CUT);
#endif
    let away_in_view = view_direction_from_local(volume.instance, away);
    if volume.end_kind == 0u {
        return frame.clip_from_view * vec4f(away_in_view, 0.0);
    }
    var stretch = volume.end_scale;
    if volume.end_kind == 1u {
        stretch = (volume.end_offset - dot(volume.end_normal, p)) / dot(volume.end_normal, away);
    }
    if volume.end_kind == 3u {
        stretch = volume.end_scale / max(length(away_in_view), 1e-37);
    }
    let end_in_view = view_from_local(volume.instance, p) + away_in_view * stretch;
    return moved_nearer(frame.clip_from_view * vec4f(end_in_view, 1.0), -SIDE_SHIFT);
}
