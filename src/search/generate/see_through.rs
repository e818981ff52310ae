//! Families of casters that light passes: glass and masks.

use glam::Vec2;

use super::{Draft, HARD, TRANSPARENT};
use crate::search::bodies::{self, Corners};
use crate::search::options::Sizes;

impl Draft<'_> {
    pub(super) fn glass(&mut self) {
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

    pub(super) fn masks(&mut self) {
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
}
