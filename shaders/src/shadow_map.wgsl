// What of a light reaches each pixel, as its maps tell: comparisons first, and the mean of them after.

#import common/map_taps
#import common/shadow_maps

// The share of a square around the receiver that is lit: as wide as the texels asked along a side, less one, so that it moves on
// without a step. One texel is asked alone.
fn lit_share(in: Asking, receiver: Receiver) -> f32 {
    let asked = question(in, receiver);
    const WIDTH: f32 = f32(TAPS - 1);
    let low = clamp(asked.at.xy - 0.5 * WIDTH, vec2f(-1e6), vec2f(1e6));
    let first = floor(low);
    let rest = low - first;
    // Most pixels are lit: nothing that is asked lies before them.
    var is_hidden = false;
    for (var y = 0; y < TAPS; y += 1) {
        for (var x = 0; x < TAPS; x += 1) {
            is_hidden = is_hidden | is_before(vec2i(first) + vec2i(x, y), asked);
        }
    }
    if !is_hidden {
        return 1.0;
    }
    var dark = 0.0;
    for (var y = 0; y < TAPS; y += 1) {
        let row = select(select(1.0, rest.y, y == TAPS - 1), 1.0 - rest.y, y == 0);
        for (var x = 0; x < TAPS; x += 1) {
            let column = select(select(1.0, rest.x, x == TAPS - 1), 1.0 - rest.x, x == 0);
            let weight = select(row * column, 1.0, TAPS == 1);
            dark += select(0.0, weight, is_dark(vec2i(first) + vec2i(x, y), asked));
        }
    }
    return saturate(1.0 - dark / max(WIDTH * WIDTH, 1.0));
}

@fragment
fn darken(in: Asking) -> @location(0) vec4f {
    let seen = seen_at(in.position.xy);
    if !seen.is_there || !shows(in, seen.p) {
        discard;
    }
#if CASCADES
    let receiver = receiver_of(in, in.position.xy, seen.p);
    if !receiver.receives {
        discard;
    }
    var number = 0u;
    for (var i = 0u; i + 1u < maps.view_count; i += 1u) {
        number += select(0u, 1u, receiver.distance_m > maps.views[i].end_m);
    }
    var lit = lit_share(about_view(in, number), receiver);
    let view = maps.views[number];
    let into = saturate((receiver.distance_m - (view.end_m - view.blend_m)) / max(view.blend_m, 1e-30));
    if into > 0.0 && number + 1u < maps.view_count {
        lit = mix(lit, lit_share(about_view(in, number + 1u), receiver), into);
    }
    return vec4f(lit);
#else
    if !is_near_map(in, seen.p, f32(TAPS)) {
        discard;
    }
    let receiver = receiver_of(in, in.position.xy, seen.p);
    if !receiver.receives {
        discard;
    }
    return vec4f(lit_share(in, receiver));
#endif
}
