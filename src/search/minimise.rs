//! Taking away from a scene that fails whatever it fails without.

use glam::DVec3;
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::scene::LightKind;

use super::recipe::{Bend, Body, Recipe, Wear};

/// Makes `recipe` smaller for as long as `still_fails` says yes, asking at most `trials` times. Nodes, lights and meshes go
/// first, then triangles, options, transforms; what is left is rounded.
pub fn shrink(recipe: &Recipe, trials: usize, still_fails: &mut dyn FnMut(&Recipe) -> bool) -> Recipe {
    let mut shrinking = Shrinking { smallest: recipe.clone(), trials, still_fails };
    loop {
        let before = shrinking.smallest.clone();
        shrinking.parts();
        shrinking.triangles();
        shrinking.options();
        shrinking.plainer();
        if shrinking.smallest == before || shrinking.trials == 0 {
            break;
        }
    }
    shrinking.rounder();
    shrinking.smallest
}

struct Shrinking<'a> {
    smallest: Recipe,
    trials: usize,
    still_fails: &'a mut dyn FnMut(&Recipe) -> bool,
}

impl Shrinking<'_> {
    /// Keeps what `change` makes if it still fails.
    fn attempt(&mut self, change: impl FnOnce(&mut Recipe)) -> bool {
        let mut changed = self.smallest.clone();
        change(&mut changed);
        if self.trials == 0 || changed == self.smallest {
            return false;
        }
        self.trials -= 1;
        let fails = (self.still_fails)(&changed);
        if fails {
            self.smallest = changed;
        }
        fails
    }

    fn parts(&mut self) {
        for place in (0..self.smallest.nodes.len()).rev() {
            self.attempt(|recipe| drop(recipe.nodes.remove(place)));
        }
        for place in (0..self.smallest.lamps.len()).rev() {
            self.attempt(|recipe| remove_lamp(recipe, place));
        }
        for place in (0..self.smallest.bodies.len()).rev() {
            self.attempt(|recipe| remove_body(recipe, place));
        }
        for place in 0..self.smallest.nodes.len() {
            self.attempt(|recipe| recipe.nodes[place].lamps = None);
            self.attempt(|recipe| recipe.nodes[place].bodies = None);
        }
    }

    /// Drops ever smaller runs of triangles.
    fn triangles(&mut self) {
        for body in 0..self.smallest.bodies.len() {
            let mut run = self.smallest.bodies[body].triangles.len() / 2;
            while run > 0 {
                let mut start = 0;
                while start < self.smallest.bodies[body].triangles.len() {
                    let end = (start + run).min(self.smallest.bodies[body].triangles.len());
                    // Without triangles a body would still be named by nodes: `parts` takes it away as a whole.
                    let is_all = end - start == self.smallest.bodies[body].triangles.len();
                    let gone = !is_all
                        && self.attempt(|recipe| remove_triangles(&mut recipe.bodies[body], start..end));
                    if !gone {
                        start = end;
                    }
                }
                run /= 2;
            }
        }
    }

    fn options(&mut self) {
        for node in 0..self.smallest.nodes.len() {
            let names: Vec<String> = self.smallest.nodes[node].params.keys().cloned().collect();
            for name in names {
                self.attempt(|recipe| drop(recipe.nodes[node].params.remove(&name)));
            }
        }
    }

    /// Plainer surfaces, lights and transforms.
    fn plainer(&mut self) {
        self.attempt(|recipe| recipe.shift = DVec3::ZERO);
        self.attempt(|recipe| {
            if let Projection::Orthographic { near_m, .. } = recipe.eye.projection {
                recipe.eye.projection = Projection::Perspective { fov_y_rad: 0.8, near_m };
            }
        });
        for lamp in 0..self.smallest.lamps.len() {
            self.attempt(|recipe| recipe.lamps[lamp].range_m = None);
            self.attempt(|recipe| {
                if matches!(recipe.lamps[lamp].kind, LightKind::Spot { .. }) {
                    recipe.lamps[lamp].kind = LightKind::Point;
                }
            });
        }
        for body in 0..self.smallest.bodies.len() {
            self.attempt(|recipe| recipe.bodies[body].bend = Bend::None);
            self.attempt(|recipe| recipe.bodies[body].wear = Wear::Matt);
            self.attempt(|recipe| recipe.bodies[body].double_sided = true);
            for transform in (0..self.smallest.bodies[body].transforms.len()).rev() {
                self.attempt(|recipe| {
                    recipe.bodies[body].transforms.remove(transform);
                });
            }
            self.attempt(|recipe| bake(&mut recipe.bodies[body]));
        }
        // A node that turns everything alike may go from all at once.
        self.attempt(|recipe| {
            for body in recipe.bodies.iter_mut().filter(|body| !body.transforms.is_empty()) {
                body.transforms.remove(0);
            }
        });
    }

    /// Fewer digits, as many as it takes.
    fn rounder(&mut self) {
        for digits in [1.0, 10.0, 100.0, 1000.0_f64] {
            let round = |v: DVec3| (v * digits).round() / digits;
            for body in 0..self.smallest.bodies.len() {
                self.attempt(|recipe| {
                    let positions = &mut recipe.bodies[body].positions;
                    positions.iter_mut().for_each(|p| *p = round(p.as_dvec3()).as_vec3());
                });
            }
            for lamp in 0..self.smallest.lamps.len() {
                self.attempt(|recipe| {
                    recipe.lamps[lamp].position = round(recipe.lamps[lamp].position);
                });
                self.attempt(|recipe| {
                    let rounded = round(recipe.lamps[lamp].direction);
                    if rounded != DVec3::ZERO {
                        recipe.lamps[lamp].direction = rounded;
                    }
                });
            }
            self.attempt(|recipe| recipe.eye.target = round(recipe.eye.target));
            self.attempt(|recipe| {
                let rounded = round(recipe.eye.position);
                if rounded != recipe.eye.target {
                    recipe.eye.position = rounded;
                }
            });
        }
    }
}

/// Takes `gone` out of a list of places, which may be all.
fn remap(places: &mut Option<Vec<usize>>, gone: usize) {
    if let Some(places) = places {
        places.retain(|place| *place != gone);
        places.iter_mut().filter(|place| **place > gone).for_each(|place| *place -= 1);
    }
}

/// A node that names nothing any more serves nothing.
fn remove_idle_nodes(recipe: &mut Recipe) {
    let is_idle = |places: &Option<Vec<usize>>| places.as_ref().is_some_and(Vec::is_empty);
    recipe.nodes.retain(|node| !is_idle(&node.lamps) && !is_idle(&node.bodies));
}

fn remove_lamp(recipe: &mut Recipe, place: usize) {
    recipe.lamps.remove(place);
    recipe.nodes.iter_mut().for_each(|node| remap(&mut node.lamps, place));
    remove_idle_nodes(recipe);
}

fn remove_body(recipe: &mut Recipe, place: usize) {
    recipe.bodies.remove(place);
    recipe.nodes.iter_mut().for_each(|node| remap(&mut node.bodies, place));
    remove_idle_nodes(recipe);
}

/// Takes out triangles, and the corners that no other has.
fn remove_triangles(body: &mut Body, gone: std::ops::Range<usize>) {
    body.triangles.drain(gone);
    let mut is_used = vec![false; body.positions.len()];
    body.triangles.iter().flatten().for_each(|corner| is_used[*corner as usize] = true);
    let mut next = 0;
    let mut place_of = Vec::with_capacity(is_used.len());
    for used in &is_used {
        place_of.push(next);
        next += u32::from(*used);
    }
    body.triangles.iter_mut().flatten().for_each(|corner| *corner = place_of[*corner as usize]);
    keep(&mut body.positions, &is_used);
    keep(&mut body.uvs, &is_used);
    match &mut body.bend {
        Bend::None => {}
        Bend::Morph { moves, .. } => keep(moves, &is_used),
        Bend::Skin { shares, .. } => keep(shares, &is_used),
    }
}

fn keep<T>(values: &mut Vec<T>, is_used: &[bool]) {
    let mut used = is_used.iter();
    values.retain(|_| *used.next().unwrap_or(&false));
}

/// Puts the transforms into the corners, as far as f32 holds them.
fn bake(body: &mut Body) {
    if body.bend == Bend::None {
        let frame = body.frame_from_local();
        let mirrors = frame.matrix3.determinant() < 0.0;
        body.positions.iter_mut().for_each(|p| *p = frame.transform_point3(p.as_dvec3()).as_vec3());
        body.transforms.clear();
        if mirrors {
            body.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::{Family, recipe_of};

    #[test]
    fn what_does_not_matter_is_taken_away() {
        let catalog = shadowgraph_nodes::catalog();
        for (seed, family) in (0..).zip(Family::ALL) {
            let recipe = recipe_of(seed, *family, &catalog);
            // It "fails" while the last body has a triangle and some lamp is left.
            let wanted = recipe.bodies.last().map(|body| body.wear.clone());
            let mut fails = |recipe: &Recipe| {
                let has = |body: &Body| Some(&body.wear) == wanted.as_ref() && !body.triangles.is_empty();
                recipe.bodies.iter().any(has) && !recipe.lamps.is_empty()
            };
            let small = shrink(&recipe, 2000, &mut fails);
            assert_eq!((small.triangle_count(), small.lamps.len(), small.nodes.len()), (1, 1, 0), "{family}");
            assert_eq!(small.bodies[0].transforms, []);
            let corners = small.bodies[0].positions.len();
            assert!(corners <= 3, "{family}: {corners} corners of one triangle");
        }
    }
}
