//! From a seed and a family to a scene.

use glam::{DVec3, Vec3};
use shadowgraph_engine::scene::Params;
use shadowgraph_engine::shadow::Catalog;

use super::bodies::{self, Corners};
use super::lamps::{self, Kinds};
use super::options::{self, Sizes};
use super::recipe::{Body, Caster, Recipe, Wear};
use super::{Family, Random};

mod opaque;
mod see_through;
mod soft;

/// Hard shadows of opaque casters.
const HARD: &str = "ShadowVolumeHard";
/// Lights with a size.
const SOFT: &str = "ShadowVolumeSoft";
/// Coloured shadows.
const TRANSPARENT: &str = "TransparentShadow";
/// Lights with a size, on planes.
const PLANAR: &str = "SoftShadow";
/// Hard shadows looked up in maps.
const MAP: &str = "ShadowMap";
/// The same with silhouettes.
const SILHOUETTE: &str = "SilhouetteMap";

/// A scene while it is drawn.
struct Draft<'a> {
    random: Random,
    catalog: &'a Catalog,
    recipe: Recipe,
}

/// The scene of this seed and family, with shadow nodes of the types and options that `catalog` has.
pub fn recipe_of(seed: u64, family: Family, catalog: &Catalog) -> Recipe {
    let mut random = Random::new(seed);
    let size_px = random.pick(&[[160, 120], [160, 90], [128, 128], [121, 97]]);
    let eye = lamps::eye(&mut random);
    let (bodies, lamps, nodes) = (Vec::new(), Vec::new(), Vec::new());
    let recipe = Recipe { seed, family, size_px, eye, bodies, lamps, nodes, shift: DVec3::ZERO };
    let mut draft = Draft { random, catalog, recipe };
    match family {
        Family::Open => draft.open(),
        Family::Soup => draft.soup(),
        Family::Ties => draft.ties(),
        Family::LampBeside => draft.lamp_beside(),
        Family::Stretched => draft.stretched(),
        Family::InnerWalls => draft.inner_walls(),
        Family::CloseEye => draft.close_eye(),
        Family::Turned => draft.turned(),
        Family::Glass => draft.glass(),
        Family::Masks => draft.masks(),
        Family::SoftOpen => draft.soft_open(),
        Family::SoftSpecial => draft.soft_special(),
        Family::Planar => draft.planar(),
        Family::NodesMixed => draft.nodes_mixed(),
        Family::Bent => draft.bent(),
        Family::Maps => draft.maps(),
    }
    draft.recipe
}

/// What several families have.
impl Draft<'_> {
    fn floor_mostly(&mut self) {
        if self.random.chance(0.8) {
            let floor = bodies::floor(&mut self.random);
            self.recipe.bodies.push(floor);
        }
    }

    fn anything(&mut self) -> Body {
        match self.random.whole(0, 5) {
            0 => bodies::opened(&mut self.random),
            1 => {
                let triangles = self.random.whole(1, 20);
                bodies::soup(&mut self.random, triangles, Corners::Free)
            }
            _ => bodies::solid(&mut self.random),
        }
    }

    /// Few triangles: what a reference with many samples can bear.
    fn anything_small(&mut self) -> Body {
        match self.random.whole(0, 4) {
            0 => bodies::wave(&mut self.random),
            1 => bodies::soup(&mut self.random, 6, Corners::Free),
            2 => bodies::solid(&mut self.random),
            _ => {
                let half = [(); 3].map(|()| self.random.within_f32(0.1, 0.8));
                bodies::block(Vec3::from_array(half))
            }
        }
    }

    /// Opaque, glass or masked; of either sidedness.
    fn dress(&mut self, body: &mut Body) {
        body.double_sided = self.random.chance(0.4);
        body.wear = match self.random.whole(0, 5) {
            0 | 1 => bodies::glass(&mut self.random),
            2 if !body.uvs.is_empty() => bodies::mask(&mut self.random),
            _ => Wear::Matt,
        };
    }

    fn placed(&mut self, mut body: Body) {
        let own = std::mem::take(&mut body.transforms);
        bodies::place(&mut self.random, &mut body);
        body.transforms.extend(own);
        self.recipe.bodies.push(body);
    }

    fn open_lamps(&mut self, least: usize, most: usize) {
        for _ in 0..self.random.whole(least, most) {
            let lamp = lamps::open(&mut self.random, Kinds::All);
            self.recipe.lamps.push(lamp);
        }
    }

    /// A light in a special place of some body, and now and then one in the open beside it.
    fn special_lamp(&mut self, kinds: Kinds) {
        let body = self.random.whole(0, self.recipe.bodies.len() - 1);
        let lamp = lamps::special(&mut self.random, &self.recipe.bodies[body], kinds);
        self.recipe.lamps.push(lamp);
        if self.random.chance(0.2) {
            self.open_lamps(1, 1);
        }
    }

    fn look_from_close(&mut self) {
        let body = self.random.whole(0, self.recipe.bodies.len() - 1);
        self.recipe.eye = lamps::close_eye(&mut self.random, &self.recipe.bodies[body]);
    }

    fn params(&mut self, technique: &str, sizes: Sizes) -> Params {
        let entry = self.catalog.find(technique);
        entry.map_or_else(Params::new, |entry| options::draw(&mut self.random, entry, sizes))
    }

    /// One node over everything, of one of these types.
    fn one_of(&mut self, techniques: &[&str], sizes: Sizes) {
        let masked = self.recipe.bodies.iter().any(|body| matches!(body.wear, Wear::Mask { .. }));
        let technique = self.random.pick(techniques);
        let mut params = self.params(technique, sizes);
        // Holes are no counts, which is all that a single pass takes: refused as well.
        if masked {
            params.remove("passes");
        }
        let technique = technique.into();
        self.recipe.nodes.push(Caster { technique, params, lamps: None, bodies: None });
    }
}
