//! The table: every hard case by id, with what breaks, what is right and how its scenes are made.

use super::stage::Stage;
use super::{
    About, CaseEntry, counts, eyes, found, glass, lights, many, maps, masks, moving, planar, repairs,
    samples, soft, topology, transforms,
};

pub(super) const fn row(
    id: &'static str,
    what_breaks: &'static str,
    right_answer: &'static str,
    stages: fn() -> Vec<Stage>,
) -> CaseEntry {
    CaseEntry { id, what_breaks, right_answer, about: About::Anything, stages }
}

/// A row about what passes transparent casters.
pub(super) const fn glassy(row: CaseEntry) -> CaseEntry {
    CaseEntry { about: About::Glass, ..row }
}

/// Every hard case, in the order of the documentation. Listing is cheap; scenes are made by [`CaseEntry::build`].
pub fn all() -> Vec<CaseEntry> {
    [ROWS, found::ROWS].concat()
}

const ROWS: &[CaseEntry] = &[
    // Where the light stands.
    row(
        "light-in-plane",
        "sign noise when the light lies in a triangle's plane",
        "that triangle casts nothing",
        lights::light_in_plane,
    ),
    row(
        "light-on-edge",
        "NaN and (0, 0, 0, 0) vertices",
        "the incident triangles cast nothing, the rest cast",
        lights::light_on_edge,
    ),
    row(
        "light-on-vertex",
        "NaN and (0, 0, 0, 0) vertices",
        "the incident triangles cast nothing, the rest cast",
        lights::light_on_vertex,
    ),
    row(
        "light-in-closed",
        "closed mode casts nothing from a light inside",
        "everything outside is dark",
        lights::light_in_closed,
    ),
    row(
        "light-in-open-box",
        "capping closes the opening",
        "the walls cast, the opening lights",
        lights::light_in_open_box,
    ),
    // Where the eye stands.
    row("eye-in-shadow", "z-pass inverts the frame", "as from outside", eyes::eye_in_shadow),
    row(
        "near-clips-side",
        "holes where the near plane cuts a volume's side",
        "as with a tiny near distance",
        eyes::near_clips_side,
    ),
    row(
        "near-clips-corner",
        "un-closed volumes at the near rectangle's corners",
        "as with a tiny near distance",
        eyes::near_clips_corner,
    ),
    row("eye-in-cap-plane", "a streak along a cap seen edge-on", "no streak", eyes::eye_in_cap_plane),
    row(
        "light-in-near-plane",
        "a degenerate light pyramid chooses the wrong test",
        "as the reference",
        eyes::light_in_near_plane,
    ),
    row(
        "light-behind-eye",
        "a light pyramid behind the eye chooses the wrong test",
        "as the reference",
        eyes::light_behind_eye,
    ),
    row("light-at-eye", "a light pyramid without volume", "nothing visible is dark", eyes::light_at_eye),
    // Bad triangles.
    row("sliver", "NaN and cracks at needles", "any error stays within the sliver", repairs::sliver),
    row("zero-area", "NaN from triangles without area", "as without them", repairs::zero_area),
    row(
        "duplicate-vertex",
        "NaN and cracks from triangles that repeat a vertex",
        "as without them",
        repairs::duplicate_vertex,
    ),
    row("duplicate-face", "two faces in one place count twice", "opaque: dark once", repairs::duplicate_face),
    row(
        "opposite-duplicate",
        "two faces back to back cancel or flicker",
        "opaque: dark once",
        repairs::opposite_duplicate,
    ),
    row(
        "t-junction",
        "a pinhole at a vertex on a neighbour's edge",
        "as the reference with the same crack",
        repairs::t_junction,
    ),
    // How the mesh hangs together.
    row(
        "fins",
        "the first neighbour wins where 3, 4 or 5 triangles share an edge",
        "all cast",
        topology::fins,
    ),
    row("two-cubes-one-edge", "mispaired edges", "all cast", topology::two_cubes_one_edge),
    row(
        "inconsistent-winding",
        "closed mode leaks without a common orientation",
        "exact",
        topology::inconsistent_winding,
    ),
    row("moebius", "no orientation exists", "exact", topology::moebius),
    row("single-quad", "open meshes unsupported", "lit in front, dark behind", topology::single_quad),
    row("open-cylinder", "capped top, open bottom, oblique light", "exact", topology::open_cylinder),
    row(
        "material-split",
        "a closed mesh split by material looks open",
        "welded: closed",
        topology::material_split,
    ),
    row("uv-seam", "a closed mesh with a texture seam looks open", "welded: closed", topology::uv_seam),
    row(
        "closed-inside-out",
        "closed mode keeps the wrong half of a mesh wound inwards",
        "exact",
        topology::closed_inside_out,
    ),
    row("closed-open-mixed", "the counts of two modes mix", "exact", topology::closed_open_mixed),
    row(
        "casters-around-light",
        "one map cannot see a ring of casters",
        "all cast",
        lights::casters_around_light,
    ),
    row("alpha-mask", "a leaf card with holes casts a solid slab", "exact per texel", masks::alpha_mask),
    row(
        "terminator",
        "the shadow's edge on smooth-shaded facets",
        "the geometric truth",
        topology::terminator,
    ),
    row("nested-shells", "order of counts in a sphere in a sphere", "exact", topology::nested_shells),
    row(
        "coplanar-receiver",
        "a caster in the receiver's plane fights with it",
        "unshadowed: blockers are strict",
        repairs::coplanar_receiver,
    ),
    row("touching-receiver", "a gap at the contact", "no gap", repairs::touching_receiver),
    // Where the world lies and how it is stretched.
    row(
        "offset-1e4",
        "cracks far from the origin",
        "as at the origin, down to the input's rounding",
        transforms::offset_1e4,
    ),
    row(
        "offset-1e5",
        "cracks far from the origin",
        "as at the origin, down to the input's rounding",
        transforms::offset_1e5,
    ),
    row(
        "offset-1e6",
        "cracks far from the origin",
        "as at the origin, down to the input's rounding",
        transforms::offset_1e6,
    ),
    row("scale-1e-4", "absolute epsilons in a tiny scene", "as at scale 1", transforms::scale_tiny),
    row("scale-1e4", "absolute epsilons in a huge scene", "as at scale 1", transforms::scale_huge),
    row("mirrored", "winding flips", "exact", transforms::mirrored),
    row("non-uniform", "normals and windings under unequal scales", "exact", transforms::non_uniform),
    row("sheared", "transforms that are no rotation and scale", "exact", transforms::sheared),
    row("singular", "NaN from flattened meshes", "exact and finite", transforms::singular),
    // Counts.
    row("overlap-256", "an 8-bit counter wraps to lit", "dark", counts::overlap_256),
    row("overlap-512", "an 8-bit counter wraps twice to lit", "dark", counts::overlap_512),
    row(
        "overlap-open-128",
        "open casters count both their surfaces: 128 make 256",
        "dark",
        counts::overlap_open_128,
    ),
    row("overlap-2049", "half floats lose integers above 2048", "dark", counts::overlap_2049),
    row("overlap-4096", "wraps 8 bits and exceeds half floats", "dark", counts::overlap_4096),
    row(
        "overlap-seen-through",
        "saturated or rounded counts do not return to zero",
        "the pixel behind the stack is lit",
        counts::overlap_seen_through,
    ),
    glassy(row(
        "count-figure",
        "the counts that caps contribute",
        "the counts worked out with the figure",
        glass::count_figure,
    )),
    // Directions, frames and culling.
    row(
        "directional-parallel",
        "singular matrices when light runs along faces",
        "s = 0, finite",
        lights::directional_parallel,
    ),
    row("low-sun", "near-infinite shadows", "exact", lights::low_sun),
    row(
        "directional-offscreen",
        "casters culled whose shadow is in view",
        "the shadow stays",
        lights::directional_offscreen,
    ),
    row(
        "offscreen-caster",
        "casters culled whose shadow is in view",
        "the shadow stays",
        lights::offscreen_caster,
    ),
    row("light-crosses-frustum", "popping and scissor errors", "no popping", lights::light_crosses_frustum),
    row("index-65536", "16-bit indices", "exact", many::index_65536),
    // Moving geometry.
    row(
        "skinned-extreme",
        "stale silhouettes of a skinned mesh",
        "as the posed reference",
        moving::skinned_extreme,
    ),
    row("morph", "stale silhouettes of a morphed mesh", "as the posed reference", moving::morph),
    row("instanced-1000", "a thousand instances of one mesh", "as the posed reference", many::instanced_1000),
    row("animated", "stale silhouettes of animated nodes", "as the posed reference", moving::animated),
    // Transparent casters.
    glassy(row("alpha-0", "log of nothing", "no shadow", glass::alpha_0)),
    glassy(row("alpha-1", "log 0", "black", glass::alpha_1)),
    glassy(row("channel-0", "log 0 in one channel", "that channel only", glass::channel_0)),
    glassy(row("glass-order", "red and green panes overlapped both ways", "identical", glass::glass_order)),
    glassy(row(
        "glass-deep",
        "8, 32 and 128 volumes leave ghosts in 16 bits",
        "lit pixels exactly lit",
        glass::glass_deep,
    )),
    glassy(row(
        "tinted-bottle",
        "wrong layer count of a closed shell with an opaque core",
        "two surfaces, the core black",
        glass::tinted_bottle,
    )),
    glassy(row("stained-glass", "one average colour for a textured pane", "per texel", glass::stained_glass)),
    glassy(row(
        "glass-self",
        "transparent surfaces lit through others at one depth only",
        "every layer's factor exact",
        glass::glass_self,
    )),
    glassy(row(
        "panes-intersecting",
        "intersecting panes at one depth only",
        "every layer's factor exact",
        glass::panes_intersecting,
    )),
    glassy(row(
        "opaque-behind-glass",
        "passes of opaque and transparent casters overwrite each other",
        "the product",
        glass::opaque_behind_glass,
    )),
    // Soft shadows.
    row("radius-0", "division by a radius of 0", "equals hard", soft::radius_0),
    row("receiver-inside-light", "square root of a negative", "as the centre's", soft::receiver_inside_light),
    row(
        "light-touches-caster",
        "no tangent planes",
        "one fixed light definition, finite",
        soft::light_touches_caster,
    ),
    row("caster-in-light", "no tangent planes", "one fixed light definition, finite", soft::caster_in_light),
    row(
        "edge-at-centre",
        "sparkles where count and angle jump together",
        "finite, continuous",
        soft::edge_at_centre,
    ),
    row(
        "edge-through-centre",
        "sparkles where count and angle jump together",
        "finite, continuous",
        soft::edge_through_centre,
    ),
    row(
        "penumbra-overlap",
        "adding areas of overlapping blockers",
        "as the sampled reference",
        soft::penumbra_overlap,
    ),
    row("tripod", "double penumbrae of thin legs", "as the sampled reference", soft::tripod),
    row(
        "penumbra-width",
        "a penumbra of half its width",
        "width ratio 1.0 within 0.02",
        soft::penumbra_width,
    ),
    // Planar shadows.
    row("planar-behind", "anti-shadow of a caster behind the light", "none", planar::planar_behind),
    row(
        "planar-crossing",
        "false shadow of a caster across the light's plane",
        "none beyond it",
        planar::planar_crossing,
    ),
    row("planar-below", "false shadow of a caster under the receiver", "none", planar::planar_below),
    row(
        "planar-overhang",
        "the shadow floats beyond the receiver's edge",
        "clipped",
        planar::planar_overhang,
    ),
    row("planar-overlap", "double darkening", "darkened once", planar::planar_overlap),
    // Shadow maps.
    row("map-acne", "acne", "bounded by the stated bias error", maps::map_acne),
    row("map-peter-panning", "detached shadows", "bounded by the stated bias error", maps::map_peter_panning),
    row("map-cube-seam", "seams between faces", "bounded by the stated bias error", maps::map_cube_seam),
    row("map-grazing", "bias at grazing light", "bounded by the stated bias error", maps::map_grazing),
    // Targets and sums.
    row("msaa", "a stencil per pixel on edges", "counts per sample", samples::msaa),
    row(
        "lights-1",
        "overlaps too dark, state that leaks between lights",
        "the sum of single-light images",
        many::lights_1,
    ),
    row(
        "lights-4",
        "overlaps too dark, state that leaks between lights",
        "the sum of single-light images",
        many::lights_4,
    ),
    row(
        "lights-16",
        "overlaps too dark, state that leaks between lights",
        "the sum of single-light images",
        many::lights_16,
    ),
    row(
        "lights-64",
        "overlaps too dark, state that leaks between lights",
        "the sum of single-light images",
        many::lights_64,
    ),
    row("sky", "pixels without surface counted as shadow", "skipped", eyes::sky),
    row("ortho-camera", "perspective-only mathematics", "exact", eyes::ortho_camera),
    row("resize", "row padding, stale targets", "exact", eyes::resize),
    row("1x1", "degenerate targets", "exact", eyes::one_pixel),
    row("4096", "limits of size", "exact or a typed error", eyes::four_thousand),
];
