//! Families of opaque casters under lights of every kind.

use glam::{DAffine3, DVec3, Vec2, Vec3};

use super::{Draft, HARD, MAP, SOFT, TRANSPARENT};
use crate::search::bodies::{self, Corners};
use crate::search::lamps::{self, Kinds};
use crate::search::options::Sizes;
use crate::search::recipe::Body;

impl Draft<'_> {
    pub(super) fn open(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 4) {
            let body = self.anything();
            self.placed(body);
        }
        self.open_lamps(1, 3);
        self.one_of(&[HARD, HARD, HARD, TRANSPARENT], Sizes::None);
    }

    pub(super) fn maps(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 4) {
            let mut body = self.anything();
            if !body.uvs.is_empty() && self.random.chance(0.2) {
                body.wear = bodies::mask(&mut self.random);
            }
            self.placed(body);
        }
        self.open_lamps(1, 3);
        self.one_of(&[MAP], Sizes::None);
    }

    pub(super) fn soup(&mut self) {
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
    pub(super) fn ties(&mut self) {
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

    pub(super) fn lamp_beside(&mut self) {
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

    pub(super) fn stretched(&mut self) {
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

    pub(super) fn inner_walls(&mut self) {
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

    pub(super) fn close_eye(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 3) {
            let body = self.anything();
            self.placed(body);
        }
        self.look_from_close();
        self.open_lamps(1, 2);
        self.one_of(&[HARD, HARD, TRANSPARENT], Sizes::None);
    }

    pub(super) fn turned(&mut self) {
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

    pub(super) fn bent(&mut self) {
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
}
