// Coloured shadows of transparent casters: sums over the faces of shadow volumes in float targets, and what they say of
// the light that arrives.

#import common/volume_faces
#import common/fullscreen

// +1 where the view enters a volume, −1 where it leaves it. What that adds to which channel, the blend constant says.
@fragment
fn add(in: Varyings, @builtin(front_facing) entering: bool) -> Counted {
    return counted(in, vec4f(select(-1.0, 1.0, entering)));
}

// The same of front faces only.
@fragment
fn add_front(in: Varyings, @builtin(front_facing) entering: bool) -> Counted {
    return counted(in, vec4f(select(0.0, 1.0, entering)));
}

// The same of back faces only.
@fragment
fn add_back(in: Varyings, @builtin(front_facing) entering: bool) -> Counted {
    return counted(in, vec4f(select(-1.0, 0.0, entering)));
}

// What a surface of each volume lets pass, red, green and blue.
@group(1) @binding(2) var<storage, read> transmissions: array<vec4f>;

// Multiplied where the view enters a volume, divided where it leaves it: equation 2 of Kim, Kim & Turk.
@fragment
fn multiply(in: Varyings, @builtin(front_facing) entering: bool) -> Counted {
    let transmission = transmissions[in.volume];
    return counted(in, select(1.0 / transmission, transmission, entering));
}

// The same for triangles that are wound against the chain, or counted behind the surface.
@fragment
fn divide(in: Varyings, @builtin(front_facing) entering: bool) -> Counted {
    let transmission = transmissions[in.volume];
    return counted(in, select(transmission, 1.0 / transmission, entering));
}

// Of one side's faces only.
@fragment
fn multiply_front(in: Varyings, @builtin(front_facing) front: bool) -> Counted {
    return counted(in, select(vec4f(1.0), transmissions[in.volume], front));
}

@fragment
fn divide_front(in: Varyings, @builtin(front_facing) front: bool) -> Counted {
    return counted(in, select(vec4f(1.0), 1.0 / transmissions[in.volume], front));
}

@fragment
fn multiply_back(in: Varyings, @builtin(front_facing) front: bool) -> Counted {
    return counted(in, select(transmissions[in.volume], vec4f(1.0), front));
}

@fragment
fn divide_back(in: Varyings, @builtin(front_facing) front: bool) -> Counted {
    return counted(in, select(1.0 / transmissions[in.volume], vec4f(1.0), front));
}

// One class of material, and where its count is kept.
struct Class {
    // What one surface lets pass.
    transmission: vec3f,
    // The channel of the sums.
    channel: u32,
    // Moved up by `offset`, the channel holds SLACK and this count in `bits` bits from `first_bit`.
    first_bit: u32,
    bits: u32,
    offset: u32,
    pad_0: u32,
}

@group(1) @binding(1) var<storage, read> classes: array<Class>;
@group(1) @binding(3) var sums: texture_2d<f32>;

// At the very edge of a shadow rounding may take one side of a volume to be before what is seen, and not the other: counts
// this far below 0 borrow nothing from their neighbours.
const SLACK: u32 = 4u;

// What fragments need of some classes: from the vertices, since software adapters read storage lane by lane. Of each class
// the bits of its transmission, and first bit, mask and channel in one number; 0 for a class that is not there.
struct ClassVaryings {
    @builtin(position) clip: vec4f,
    // What each channel is moved up by.
    @location(0) @interpolate(flat, first) offsets: vec4u,
    @location(1) @interpolate(flat, first) class_0: vec4u,
    @location(2) @interpolate(flat, first) class_1: vec4u,
#if MANY_CLASSES
    @location(3) @interpolate(flat, first) class_2: vec4u,
    @location(4) @interpolate(flat, first) class_3: vec4u,
    @location(5) @interpolate(flat, first) class_4: vec4u,
    @location(6) @interpolate(flat, first) class_5: vec4u,
    @location(7) @interpolate(flat, first) class_6: vec4u,
    @location(8) @interpolate(flat, first) class_7: vec4u,
#endif
}

fn packed_class(index: u32) -> vec4u {
    if index >= arrayLength(&classes) {
        return vec4u(0u);
    }
    let c = classes[index];
    let place = c.first_bit | (c.channel << 5u) | (((1u << c.bits) - 1u) << 7u);
    return vec4u(bitcast<vec3u>(c.transmission), place);
}

@vertex
fn class_vertex(@builtin(vertex_index) index: u32) -> ClassVaryings {
    var out: ClassVaryings;
    out.clip = fullscreen_corner(index);
    for (var i = 0u; i < arrayLength(&classes); i += 1u) {
        let channel = classes[i].channel;
        out.offsets = select(out.offsets, vec4u(classes[i].offset), vec4u(channel) == vec4u(0u, 1u, 2u, 3u));
    }
    out.class_0 = packed_class(0u);
    out.class_1 = packed_class(1u);
#if MANY_CLASSES
    out.class_2 = packed_class(2u);
    out.class_3 = packed_class(3u);
    out.class_4 = packed_class(4u);
    out.class_5 = packed_class(5u);
    out.class_6 = packed_class(6u);
    out.class_7 = packed_class(7u);
#endif
    return out;
}

// What the surfaces of one class let pass: rⁿ, by squaring, since logarithms lose digits.
fn passing(class_: vec4u, moved: vec4u) -> vec3f {
    let channel = (class_.w >> 5u) & 3u;
    let fields = select(select(moved.x, moved.y, channel == 1u), select(moved.z, moved.w, channel == 3u), channel > 1u);
    let count = max((fields >> (class_.w & 31u)) & (class_.w >> 7u), SLACK) - SLACK;
    var result = vec3f(1.0);
    var square = bitcast<vec3f>(class_.xyz);
    for (var rest = count; rest != 0u; rest >>= 1u) {
        result *= select(vec3f(1.0), square, (rest & 1u) == 1u);
        square *= square;
    }
    return result;
}

// What all counted surfaces let pass: Π rⁿ.
@fragment
fn transmit_counts(in: ClassVaryings) -> @location(0) vec4f {
    let sum = textureLoad(sums, vec2u(in.clip.xy), 0);
    let moved = vec4u(vec4i(sum) + vec4i(in.offsets));
    // Channels that hold no class have no offset.
    if all((moved == in.offsets) | (in.offsets == vec4u(0u))) {
        discard;
    }
    var product = passing(in.class_0, moved) * passing(in.class_1, moved);
#if MANY_CLASSES
    product *= passing(in.class_2, moved) * passing(in.class_3, moved) * passing(in.class_4, moved);
    product *= passing(in.class_5, moved) * passing(in.class_6, moved) * passing(in.class_7, moved);
#endif
    return vec4f(product, 1.0);
}

// The grid's step, for sums of binary logarithms.
@group(1) @binding(1) var<storage, read> log_unit: array<f32>;

// Equation 3 of Kim, Kim & Turk, for plain logarithms and for those on a grid, whose sums are exact. At the very edge of a
// shadow rounding may place only one side of a volume before what is seen; a sum above 0 then counts as 0.
@fragment
fn transmit_logarithms(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let sum = textureLoad(sums, vec2u(position.xy), 0).rgb;
    if all(sum >= vec3f(0.0)) {
        discard;
    }
    return vec4f(exp2(min(sum, vec3f(0.0)) * log_unit[0]), 1.0);
}

// Equation 2 of Kim, Kim & Turk. A product beyond the format's range is infinite or NaN and counts as dark. A product above 1, from
// rounding at a shadow's edge, counts as 1.
@fragment
fn transmit_product(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let product = textureLoad(sums, vec2u(position.xy), 0).rgb;
    if all(product == vec3f(1.0)) {
        discard;
    }
    let is_number = (bitcast<vec3u>(product) & vec3u(0x7f800000u)) != vec3u(0x7f800000u);
    return vec4f(select(vec3f(0.0), min(product, vec3f(1.0)), is_number), 1.0);
}
