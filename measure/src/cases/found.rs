//! The rows that ordinary content brought, and the random search after it: kinds that were wrong by whole regions although
//! every older row passed.

use super::table::{glassy, row};
use super::{CaseEntry, beside, horizons, masks, rooms, stretched, ties, touching_glass};

const OWN_PLANE: &str = "what lies in the receiver's own plane casts nothing on it";
const AS_REFERENCE: &str = "as the reference";

pub(super) const ROWS: &[CaseEntry] = &[
    // In one plane.
    row(
        "culled-underside",
        "a cap that no prepass drew rounds otherwise than the floor it lies on",
        OWN_PLANE,
        ties::culled_underside,
    ),
    row(
        "two-sided-leaf",
        "front and back of a leaf, cut into other triangles, stripe each other",
        "as one double-sided sheet",
        ties::two_sided_leaf,
    ),
    row(
        "back-to-back-panels",
        "two meshes in one plane, facing both ways, stripe each other",
        "as one double-sided sheet",
        ties::back_to_back_panels,
    ),
    glassy(row(
        "glass-on-floor",
        "glass caps against the depth of the floor they lie on",
        "the touching face tints nothing of what it touches",
        touching_glass::glass_on_floor,
    )),
    glassy(row(
        "glass-on-box",
        "the foot of a glass cube tints what it stands on",
        "the touching face tints nothing of what it touches",
        touching_glass::glass_on_box,
    )),
    glassy(row(
        "glass-on-glass",
        "panes in one plane stripe each other",
        "each counts on what is beyond, none on the other",
        touching_glass::glass_on_glass,
    )),
    glassy(row(
        "coincident-panes",
        "rounding decides between panes with the very same corners",
        "each counts",
        touching_glass::coincident_panes,
    )),
    row(
        "wide-band",
        "the band of what is ambiguous swallows the error",
        "at most 3 pixels a boundary pixel are ambiguous",
        ties::wide_band,
    ),
    // Solids seen from inside.
    row(
        "room-through-culled-walls",
        "half of a room's walls do not shadow the half that is seen",
        "dark inside",
        rooms::room_through_culled_walls,
    ),
    row("inward-shell", "half of a shell does not shadow its inside", "dark inside", rooms::inward_shell),
    // Horizons.
    row(
        "soft-no-caster",
        "the horizon is in the factor only if something casts",
        "the share of the light that is above the horizon",
        horizons::soft_no_caster,
    ),
    row(
        "planar-no-caster",
        "the horizon is in the factor only if something casts",
        "the share of the light that is above the horizon",
        horizons::planar_no_caster,
    ),
    row(
        "turned-from-centre",
        "a surface turned from the centre of a light that another node gives a size is darkened by its own plane",
        "the part of the light above its horizon",
        beside::turned_from_centre,
    ),
    // Stretched, cracked, thin.
    row("strip-500m", "far corners of long triangles lose their digits", AS_REFERENCE, stretched::strip_500m),
    row("strip-5km", "far corners of long triangles lose their digits", AS_REFERENCE, stretched::strip_5km),
    row("road-50km", "far corners of long triangles lose their digits", AS_REFERENCE, stretched::road_50km),
    row(
        "stretched-at-grazing",
        "depth at a grazing angle has fewer digits than a long caster needs",
        AS_REFERENCE,
        stretched::stretched_at_grazing,
    ),
    row(
        "cracked-2e-6",
        "cracks below a pixel between triangles that share no vertex",
        "as the reference with the same cracks",
        stretched::cracked_2e_6,
    ),
    row(
        "thin-receiver",
        "snapped corners tilt receivers that are thinner than a pixel",
        "the band follows from the snap of this triangle's corners",
        stretched::thin_receiver,
    ),
    // Lamps beside surfaces.
    row(
        "lamp-1e-9-over-face",
        "regions flip below a lamp next to a face",
        "exact, or a typed refusal",
        beside::lamp_over_face,
    ),
    row(
        "lamp-1e-9-over-edge",
        "regions flip behind an edge that spans a half circle",
        "exact, or a typed refusal",
        beside::lamp_over_edge,
    ),
    row(
        "lamp-1e-9-over-vertex",
        "regions flip behind a corner next to the lamp",
        "exact, or a typed refusal",
        beside::lamp_over_vertex,
    ),
    row(
        "soft-lamp-on-edge",
        "triangles in the centre's plane count; tiny radii lose all digits",
        "the definition's; inside the sphere as the centre's",
        beside::soft_lamp_on_edge,
    ),
    row(
        "soft-lamp-on-corner",
        "triangles in the centre's plane count; tiny radii lose all digits",
        "the definition's; inside the sphere as the centre's",
        beside::soft_lamp_on_corner,
    ),
    row(
        "soft-lamp-in-floor",
        "a lamp half sunk in what casts: edges in its plane pass the centre, on one side by one reckoning, on the other by another",
        "the definition's, whatever stands there",
        beside::soft_lamp_in_floor,
    ),
    row(
        "lamp-in-far-plane",
        "a lamp almost in the plane of a far triangle: its edges are all but opposite",
        "a shadow as thin as the triangle looks",
        beside::lamp_in_far_plane,
    ),
    row(
        "ortho-lamp-beside",
        "volumes scaled about a lamp next to their caster have no end",
        "exact",
        beside::ortho_lamp_beside,
    ),
    // Depths that a plane decides.
    glassy(row(
        "folded-glass",
        "next to their fold, less is between two panes than depths in one plane may differ by",
        "the nearer pane tints the other up to the fold",
        touching_glass::folded_glass,
    )),
    row(
        "leaf-on-floor",
        "holes in the plane they lie in, where the picture's edge cuts the floor",
        OWN_PLANE,
        masks::leaf_on_floor,
    ),
];
