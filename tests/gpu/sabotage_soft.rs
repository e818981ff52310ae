//! `ShadowVolumeSoft` broken on purpose, in every quality: conformance turns red.

use crate::broken::Spoil;
use crate::slips::{each_turns_red, slips};
use shadowgraph::engine::shadow::{Geometry, ShadowTechnique};
use shadowgraph::prelude::*;

/// Each edge weighs by the first of its triangles alone.
const HALF_AN_EDGE: Spoil = Spoil::Text(" + select(weight_2, -weight_2, (bits & 2u) != 0u)", "");
/// A quarter of the cells have lost what is listed for them.
const LOST_CELLS: Spoil = Spoil::Text(
    "return CellList(list_word(place), list_word(place + 1u));",
    "return CellList(list_word(place), select(list_word(place + 1u), list_word(place), (place & 3u) == 1u));",
);
/// The last triangle of every list of those near the light is lost.
const LOST_NEAR_LIGHT: Spoil = Spoil::Text(
    "return NearWalk(lists.near.first, lists.near.end,",
    "return NearWalk(lists.near.first, max(lists.near.first + 1u, lists.near.end) - 1u,",
);
/// The last cluster of triangles is never asked.
const LOST_CLUSTER: Spoil = Spoil::Text(
    "return NearWalk(lists.near.first, lists.near.end, 0u, lists.clusters,",
    "return NearWalk(lists.near.first, lists.near.end, 0u, max(lists.clusters, 1u) - 1u,",
);
/// A light without size in its place.
const HARD: Spoil = Spoil::Plan(|_, light, out| ShadowVolumeHard::default().plan(light, out));

#[test]
fn sampled() {
    let slips = slips!(ShadowVolumeSoft::ENTRY;
        "half of an edge's weight dropped", "tripod": HALF_AN_EDGE;
        "cells of the lists lost", "tripod": LOST_CELLS;
        "a triangle near the light lost", "caster-in-light/leaf": LOST_NEAR_LIGHT;
        "a cluster lost", "receiver-inside-light": LOST_CLUSTER;
        "the horizon left out", "soft-no-caster/sun":
            Spoil::Text("bits &= ~samples_not_below(-over, round);", "");
        "what hides the centre left out", "tripod":
            Spoil::Text("set_counts(over_center);", "set_counts(0);");
        "edges counted the wrong way round", "tripod":
            Spoil::Text("select(flip, ~flip, edge.weight < 0)", "select(flip, ~flip, edge.weight > 0)");
        "a light without size", "penumbra-width/middle": HARD;
    );
    each_turns_red(ShadowVolumeSoft::ENTRY, "default", &slips);
}

#[test]
fn per_receiver() {
    let slips = slips!(ShadowVolumeSoft::ENTRY;
        "half of an edge's weight dropped", "tripod": HALF_AN_EDGE;
        "cells of the lists lost", "tripod": LOST_CELLS;
        "a triangle near the light lost", "caster-in-light/leaf": LOST_NEAR_LIGHT;
        "a cluster lost", "receiver-inside-light": LOST_CLUSTER;
        "the horizon left out", "soft-no-caster/sun":
            Spoil::Text("seen = share_above(disc.horizon.z / steep);", "seen = 1.0;");
        "what hides the centre left out", "tripod":
            Spoil::Text("var share = select(0.0, over_centre,", "var share = select(0.0, 0.0,");
        "edges counted the wrong way round", "tripod":
            Spoil::Text("select(0.0, -f32(edge.weight), crosses)", "select(0.0, f32(edge.weight), crosses)");
        "a light without size", "penumbra-width/middle": HARD;
    );
    each_turns_red(ShadowVolumeSoft::ENTRY, "per-receiver", &slips);
}

#[test]
fn wedge() {
    let slips = slips!(ShadowVolumeSoft::ENTRY;
        "wedges of half the width", "near-clips-side/closed-left":
            Spoil::Text(
                "let ray = edge.rays[corner - 2u].xyz;",
                "let middle = edge.rays[0].xyz + edge.rays[1].xyz + edge.rays[2].xyz + edge.rays[3].xyz;
                 let ray = normalize(edge.rays[corner - 2u].xyz + 0.25 * middle);",
            );
        "every other edge forgotten", "near-clips-side/closed-left":
            Spoil::Text("edge.weight * share", "edge.weight * share * f32(1u - (in.edge & 1u))");
        "edges counted the wrong way round", "near-clips-side/closed-left":
            Spoil::Text("edge.weight * share", "-edge.weight * share");
        "the horizon left out", "soft-no-caster/sun":
            Spoil::Text("seen = share_above(disc.horizon.z / steep);", "seen = 1.0;");
        "a missing cap of what is counted", "tripod": Spoil::Volumes(|draw| {
            if let Geometry::Indexed { count, .. } = &mut draw.geometry {
                *count = (*count - 6).max(3);
            }
        });
        "a light without size", "near-clips-side/closed-left": HARD;
        "a light without size", "penumbra-width/low": HARD;
        "a light without size", "penumbra-width/high": HARD;
        "a light without size", "tripod": HARD;
        "a light without size", "scale-1e4/unscaled": HARD;
        "a light without size", "mirrored/ball": HARD;
        "a light without size", "nested-shells/window": HARD;
    );
    each_turns_red(ShadowVolumeSoft::ENTRY, "wedge", &slips);
}
