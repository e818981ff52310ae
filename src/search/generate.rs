//! From a seed and a family to a scene.

use glam::{DAffine3, DVec3, Vec2, Vec3};
use shadowgraph_engine::scene::Params;
use shadowgraph_engine::shadow::Catalog;

use super::bodies::{self, Corners};
use super::lamps::{self, Kinds};
use super::options::{self, Sizes};
use super::recipe::{Body, Caster, Recipe, Wear};
use super::{Family, Random};

/// Hard shadows of opaque casters.
const HARD: &str = "ShadowVolumeHard";
/// Lights with a size.
const SOFT: &str = "ShadowVolumeSoft";
/// Coloured shadows.
const TRANSPARENT: &str = "TransparentShadow";
/// Lights with a size, on planes.
const PLANAR: &str = "SoftShadow";

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
    }
    draft.recipe
}

impl Draft<'_> {
    fn open(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 4) {
            let body = self.anything();
            self.placed(body);
        }
        self.open_lamps(1, 3);
        self.one_of(&[HARD, HARD, HARD, TRANSPARENT], Sizes::None);
    }

    fn soup(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 2) {
            let triangles = self.random.whole(2, 24);
            let corners = self.random.pick(&[Corners::Grid, Corners::Grid, Corners::Free]);
            let mut body = bodies::soup(&mut self.random, triangles, corners);
            body.double_sided = self.random.chance(0.6);
            if self.random.chance(0.3) {
                bodies::place(&mut self.random, &mut body);
            } else {
                body.transforms = vec![DAffine3::from_translation(DVec3::Y * 1.3)];
            }
            self.recipe.bodies.push(body);
        }
        self.open_lamps(1, 2);
        self.one_of(&[HARD, HARD, SOFT, TRANSPARENT], Sizes::None);
    }

    /// Sheets in the plane of a floor or of a box's upper face, all under one node that turns them.
    fn ties(&mut self) {
        let mut ground = self.random.pick(&[None, Some(0.5_f32), Some(0.37)]);
        if let Some(height) = ground {
            let mut base = bodies::block(Vec3::new(1.5, height, 1.5));
            base.double_sided = self.random.chance(0.5);
            self.recipe.bodies.push(base);
        } else {
            ground = Some(0.0);
            let floor = bodies::floor(&mut self.random);
            self.recipe.bodies.push(floor);
        }
        let height = ground.map_or(0.0, f64::from);
        for _ in 0..self.random.whole(1, 4) {
            self.lying(height);
        }
        if self.random.chance(0.3) {
            // A box that stands there: its lower face lies in the plane too.
            let half = Vec3::new(0.3, 0.25, 0.4);
            let mut stands = bodies::block(half);
            self.dress(&mut stands);
            let at = DVec3::new(self.random.within(-1.0, 1.0), height + 0.25, 0.0);
            stands.transforms = vec![DAffine3::from_translation(at)];
            self.recipe.bodies.push(stands);
        }
        if self.random.chance(0.4) {
            let turn = DAffine3::from_quat(self.random.turn());
            self.recipe.bodies.iter_mut().for_each(|body| body.transforms.insert(0, turn));
        } else if self.random.chance(0.6) {
            self.recipe.eye = lamps::low_eye(&mut self.random);
            self.recipe.eye.position.y += height;
            self.recipe.eye.target.y += height;
        }
        self.open_lamps(1, 2);
        let soft = self.random.pick(&[Sizes::None, Sizes::None, Sizes::Plain]);
        self.one_of(&[HARD, HARD, HARD, TRANSPARENT, TRANSPARENT, SOFT], soft);
    }

    /// A sheet, pane or mask at `height`, perhaps with another one in its very place.
    fn lying(&mut self, height: f64) {
        let half = Vec2::new(self.random.within_f32(0.2, 1.3), self.random.within_f32(0.2, 1.3));
        let mut sheet = bodies::sheet(&mut self.random, half);
        self.dress(&mut sheet);
        let turned = DAffine3::from_rotation_y(self.random.within(0.0, 6.3));
        let turned = if self.random.chance(0.5) { turned } else { DAffine3::IDENTITY };
        let shift = DVec3::new(self.random.within(-0.5, 0.5), height, self.random.within(-0.5, 0.5));
        sheet.transforms = vec![DAffine3::from_translation(shift) * turned];
        if self.random.chance(0.3) {
            let mut other = bodies::sheet(&mut self.random, half);
            other.transforms.clone_from(&sheet.transforms);
            (other.wear, other.double_sided) = (sheet.wear.clone(), self.random.chance(0.3));
            self.recipe.bodies.push(other);
        }
        self.recipe.bodies.push(sheet);
    }

    fn lamp_beside(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 2) {
            let mut body = match self.random.whole(0, 4) {
                0 => bodies::opened(&mut self.random),
                1 => bodies::soup(&mut self.random, 8, Corners::Grid),
                _ => bodies::solid(&mut self.random),
            };
            if self.random.chance(0.5) {
                bodies::place(&mut self.random, &mut body);
            } else {
                body.transforms = vec![DAffine3::from_translation(DVec3::Y)];
            }
            self.recipe.bodies.push(body);
        }
        self.special_lamp(Kinds::All);
        self.one_of(&[HARD, HARD, HARD, TRANSPARENT, SOFT], Sizes::None);
    }

    fn stretched(&mut self) {
        for _ in 0..self.random.whole(1, 3) {
            let mut strip = bodies::strip(&mut self.random);
            let height = self.random.within(0.0, 0.5);
            let turn = DAffine3::from_rotation_y(self.random.within(0.0, 6.3));
            strip.transforms = vec![DAffine3::from_translation(DVec3::Y * height) * turn];
            self.recipe.bodies.push(strip);
        }
        if self.random.chance(0.6) {
            let body = bodies::solid(&mut self.random);
            self.placed(body);
        }
        if self.random.chance(0.7) {
            self.recipe.eye = lamps::far_look(&mut self.random);
        }
        self.open_lamps(1, 1);
        self.one_of(&[HARD, SOFT, SOFT, TRANSPARENT], Sizes::Plain);
    }

    fn inner_walls(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 3) {
            let mut body = bodies::solid(&mut self.random);
            self.wind(&mut body);
            self.placed(body);
        }
        if self.random.chance(0.4) {
            // A room around everything.
            let half = Vec3::new(3.0, 2.0, 2.5);
            let mut room = bodies::block(half);
            bodies::flip(&mut room);
            self.wind(&mut room);
            room.transforms.insert(0, DAffine3::from_translation(DVec3::Y * 1.5));
            self.recipe.bodies.push(room);
        }
        if self.random.chance(0.3) {
            self.look_from_close();
        }
        self.open_lamps(1, 2);
        self.one_of(&[HARD, HARD, SOFT, TRANSPARENT], Sizes::None);
    }

    /// Single-sided mostly, wound either way, by its triangles or by a node that mirrors.
    fn wind(&mut self, body: &mut Body) {
        body.double_sided = self.random.chance(0.2);
        if self.random.chance(0.5) {
            bodies::flip(body);
        }
        if self.random.chance(0.3) {
            body.transforms.push(DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)));
        }
    }

    fn close_eye(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 3) {
            let body = self.anything();
            self.placed(body);
        }
        self.look_from_close();
        self.open_lamps(1, 2);
        self.one_of(&[HARD, HARD, TRANSPARENT], Sizes::None);
    }

    fn turned(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 3) {
            let body = self.anything();
            self.placed(body);
            if let Some(body) = self.recipe.bodies.last_mut() {
                bodies::distort(&mut self.random, body);
            }
        }
        if self.random.chance(0.4) {
            self.recipe.shift = self.random.direction() * self.random.by_powers(1e2, 1e6);
        }
        self.open_lamps(1, 2);
        self.one_of(&[HARD, HARD, SOFT, TRANSPARENT], Sizes::None);
    }

    fn glass(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 4) {
            let mut pane = match self.random.whole(0, 3) {
                0 => bodies::solid(&mut self.random),
                1 => bodies::soup(&mut self.random, 6, Corners::Free),
                _ => bodies::sheet(&mut self.random, Vec2::new(0.9, 0.6)),
            };
            pane.wear = bodies::glass(&mut self.random);
            pane.double_sided = self.random.chance(0.7);
            self.placed(pane);
            self.coincident_panes();
        }
        if self.random.chance(0.5) {
            let body = bodies::solid(&mut self.random);
            self.placed(body);
        }
        self.open_lamps(1, 2);
        self.one_of(&[TRANSPARENT], Sizes::None);
    }

    /// Now and then the last pane once or twice more, its corners in another order.
    fn coincident_panes(&mut self) {
        let Some(pane) = self.recipe.bodies.last().cloned().filter(|_| self.random.chance(0.25)) else {
            return;
        };
        for _ in 0..self.random.whole(1, 2) {
            let mut again = pane.clone();
            match self.random.whole(0, 2) {
                0 => bodies::flip(&mut again),
                1 => again.triangles.iter_mut().for_each(|corners| corners.rotate_left(1)),
                _ => {}
            }
            if self.random.chance(0.5) {
                again.wear = bodies::glass(&mut self.random);
            }
            self.recipe.bodies.push(again);
        }
    }

    fn masks(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 3) {
            let mut sheet = if self.random.chance(0.3) {
                bodies::solid(&mut self.random)
            } else {
                bodies::sheet(&mut self.random, Vec2::new(0.9, 0.6))
            };
            sheet.wear = bodies::mask(&mut self.random);
            sheet.double_sided = self.random.chance(0.7);
            self.placed(sheet);
        }
        if self.random.chance(0.5) {
            let body = bodies::solid(&mut self.random);
            self.placed(body);
        }
        self.open_lamps(1, 2);
        self.one_of(&[HARD, HARD, TRANSPARENT], Sizes::None);
    }

    fn soft_open(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 3) {
            let body = self.anything_small();
            self.placed(body);
        }
        self.open_lamps(1, 2);
        self.one_of(&[SOFT], Sizes::Plain);
    }

    fn soft_special(&mut self) {
        let floor = bodies::floor(&mut self.random);
        self.recipe.bodies.push(floor);
        if self.random.chance(0.3) {
            // Nothing that casts, or glass alone: the horizon is all there is.
            if self.random.chance(0.5) {
                let mut pane = bodies::sheet(&mut self.random, Vec2::new(0.9, 0.6));
                pane.wear = bodies::glass(&mut self.random);
                self.placed(pane);
            }
            self.open_lamps(1, 1);
            let lamp = &mut self.recipe.lamps[0];
            lamp.direction.y *= 0.05;
            lamp.direction = lamp.direction.normalize();
            lamp.position.y = self.random.by_powers(0.01, 1.0);
        } else {
            let body = self.anything_small();
            self.placed(body);
            self.special_lamp(Kinds::Placed);
        }
        self.one_of(&[SOFT], Sizes::Extreme);
    }

    fn planar(&mut self) {
        let floor = bodies::floor(&mut self.random);
        self.recipe.bodies.push(floor);
        for _ in 0..self.random.whole(1, 3) {
            let body = self.anything_small();
            self.placed(body);
        }
        self.open_lamps(1, 2);
        self.one_of(&[PLANAR], Sizes::Plain);
    }

    /// Each body casts through one of several nodes; on some lights, some of the nodes.
    fn nodes_mixed(&mut self) {
        let floor = bodies::floor(&mut self.random);
        self.recipe.bodies.push(floor);
        for _ in 0..self.random.whole(3, 5) {
            let mut body = self.anything_small();
            if self.random.chance(0.25) {
                body.wear = bodies::glass(&mut self.random);
            }
            self.placed(body);
        }
        self.open_lamps(1, 3);
        let count = self.random.whole(2, 3);
        let mut groups = vec![Vec::new(); count];
        for body in 0..self.recipe.bodies.len() {
            let group = self.random.whole(0, count - 1);
            groups[group].push(body);
        }
        for group in groups.into_iter().filter(|group| !group.is_empty()) {
            let technique = self.random.pick(&[HARD, SOFT, TRANSPARENT, TRANSPARENT]);
            let mut params = self.params(technique, Sizes::Plain);
            // These darken the picture instead of a light, and must agree between nodes.
            for darkening in ["passes", "apply", "weight"] {
                params.remove(darkening);
            }
            let lamps: Vec<usize> =
                (0..self.recipe.lamps.len()).filter(|_| self.random.chance(0.7)).collect();
            let lamps = if lamps.is_empty() { None } else { Some(lamps) };
            self.recipe.nodes.push(Caster {
                technique: technique.into(),
                params,
                lamps,
                bodies: Some(group),
            });
        }
    }

    fn bent(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 2) {
            let mut body = bodies::solid(&mut self.random);
            body.double_sided = self.random.chance(0.6);
            self.placed(body);
            if let Some(body) = self.recipe.bodies.last_mut() {
                bodies::bend(&mut self.random, body);
            }
        }
        self.open_lamps(1, 2);
        self.one_of(&[HARD, HARD, TRANSPARENT, SOFT], Sizes::None);
    }

    // What several families have.

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

    /// One node over everything, of one of these types. Lights with a size do not take holes, by a typed refusal.
    fn one_of(&mut self, techniques: &[&str], sizes: Sizes) {
        let masked = self.recipe.bodies.iter().any(|body| matches!(body.wear, Wear::Mask { .. }));
        let technique = self.random.pick(techniques);
        let technique = if masked && technique == SOFT { HARD } else { technique };
        let mut params = self.params(technique, sizes);
        // Holes are no counts, which is all that a single pass takes: refused as well.
        if masked {
            params.remove("passes");
        }
        let technique = technique.into();
        self.recipe.nodes.push(Caster { technique, params, lamps: None, bodies: None });
    }
}
