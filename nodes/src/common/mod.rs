//! What several techniques share: which casters matter, how volumes end, their vertices and draws, and how many layers they count.

pub mod beside_light;
pub mod boxes;
mod cap_planes;
mod coplanar;
pub mod culling;
pub mod cut_casters;
pub mod extrusion;
pub mod facing;
pub mod flat_casters;
mod front_caps;
pub mod layer_groups;
pub mod light_grid_lists;
pub mod light_maps;
pub mod light_views;
pub mod map_casters;
pub mod mask_vertices;
pub mod masked;
pub mod parting;
pub mod ray_candidates;
pub mod screen_bounds;
pub mod shadow_maps;
pub mod volume;
pub mod volume_draws;
pub mod volume_options;
