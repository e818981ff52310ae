//! Families of lights with a size, and of several nodes beside one another.

use glam::Vec2;

use super::{Draft, HARD, PLANAR, SOFT, TRANSPARENT};
use crate::search::bodies;
use crate::search::lamps::Kinds;
use crate::search::options::Sizes;
use crate::search::recipe::Caster;

impl Draft<'_> {
    pub(super) fn soft_open(&mut self) {
        self.floor_mostly();
        for _ in 0..self.random.whole(1, 3) {
            let body = self.anything_small();
            self.placed(body);
        }
        self.open_lamps(1, 2);
        self.one_of(&[SOFT], Sizes::Plain);
    }

    pub(super) fn soft_special(&mut self) {
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

    pub(super) fn planar(&mut self) {
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
    pub(super) fn nodes_mixed(&mut self) {
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
}
