//! Sweeps: one thing of a scene goes from harmless to extreme, and nothing may be wrong on the way.
//!
//! [`all`] lists them; [`Sweep::steps`] makes the scenes, each with the value of what is swept. Like hard cases, they
//! carry one shadow node over everything; [`Case::scene_with`] puts another technique in its place. A new parameter,
//! of a light, a material or a technique's own option ([`Case::options`]), is one more row of the table.
//!
//! The reference judges the very f32 vertices that the GPU gets, so a step is right when the engine lost nothing
//! *more* than its input had lost. [`Sweep::f32_loses`] says where that input is no longer the scene that was meant.

mod stages;

use glam::DVec3;
use shadowgraph_engine::scene::Params;
use shadowgraph_engine::shadow::{Setting, TechniqueEntry};

use super::stage::{Stage, p};
use super::{About, Case, Cast, counts};

/// How a sweep's parameter is best plotted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Equal steps.
    Linear,
    /// Equal ratios; every value is positive.
    Log,
}

/// An option of techniques that is swept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Swept {
    /// Its name.
    pub option: &'static str,
    /// Where its settings differ.
    pub shows_in: ShowsIn,
}

/// Where the settings of an option differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShowsIn {
    /// In the penumbrae of lights with a size.
    Penumbrae,
    /// In how far the edges of shadows are off, where there are no penumbrae.
    Edges,
}

/// One parameter of a scene over its range.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// A name no other sweep has.
    pub id: &'static str,
    /// What is swept.
    pub parameter: &'static str,
    /// Its unit; empty for plain numbers.
    pub unit: &'static str,
    /// How to plot it.
    pub axis: Axis,
    /// What breaks in techniques that get it wrong.
    pub what_breaks: &'static str,
    /// Where f32 must lose, and why; empty where it need not lose anywhere.
    pub f32_loses: &'static str,
    /// Which casters it is about. Of techniques through which transparent ones cast, a sweep about glass compares every quality
    /// setting.
    pub about: About,
    /// The option that is swept, where it is one.
    pub option: Option<Swept>,
    /// From which value on steps are [heavy](Case::is_heavy).
    pub heavy_from: f64,
    /// From which value on a report in small frames leaves steps out.
    pub slow_from: f64,
    stages: fn() -> Vec<(f64, Stage)>,
}

impl Sweep {
    /// Makes the scenes, each with the parameter's value. Cases are called after the sweep and the value.
    pub fn steps(&self, cast: &Cast) -> Vec<(f64, Case)> {
        let case = |(value, stage): (f64, Stage)| {
            let case = stage.into_case(self.id, self.what_breaks, self.about, cast);
            (value, Case { is_heavy: value >= self.heavy_from, ..case })
        };
        (self.stages)().into_iter().map(case).collect()
    }

    /// Whether every quality setting of a technique is tried, not its default only.
    pub fn tries_all_of(&self, technique: &TechniqueEntry) -> bool {
        self.compares(technique) || (self.option.is_some() && self.concerns(technique))
    }

    /// Those of a technique's settings that the sweep tells apart: of an option that is swept, those on which it acts, and of
    /// settings that differ in this option only the first.
    pub fn told_apart(
        &self,
        technique: &TechniqueEntry,
        settings: impl Iterator<Item = Setting>,
    ) -> Vec<Setting> {
        let steps =
            self.option.filter(|_| self.concerns(technique)).map(|swept| (swept, self.steps(&Cast::NOBODY)));
        let Some((swept, (_, first))) =
            steps.and_then(|(swept, steps)| Some((swept, steps.into_iter().next()?)))
        else {
            return settings.collect();
        };
        let mut seen: Vec<Params> = Vec::new();
        let is_new = |setting: &Setting| {
            let params = first.params_with(technique, &(setting.params)());
            let acts = params.get(swept.option) == first.options.get(swept.option);
            let is_new = acts && !seen.contains(&params);
            seen.push(params);
            is_new
        };
        settings.filter(is_new).collect()
    }

    /// Whether it is there to compare the quality settings of a technique.
    pub fn compares(&self, technique: &TechniqueEntry) -> bool {
        self.about == About::Glass && casts_transparent(technique)
    }

    /// Whether the sweep says anything about a technique: whether it has the option that is swept, and does not leave
    /// to others what is swept.
    pub fn concerns(&self, technique: &TechniqueEntry) -> bool {
        let left_out = self.about == About::Glass && !casts_transparent(technique);
        !left_out && self.option.is_none_or(|swept| (technique.options)().find(swept.option).is_some())
    }
}

/// Whether transparent surfaces cast through a technique with default options.
fn casts_transparent(technique: &TechniqueEntry) -> bool {
    (technique.from_params)(&Params::new()).is_ok_and(|technique| technique.traits().casts_transparent)
}

/// Every sweep. Listing is cheap; scenes are made by [`Sweep::steps`].
pub fn all() -> Vec<Sweep> {
    SWEEPS.to_vec()
}

const OFFSET: &str = "cracks far from the origin";
const TOUCH: &str = "directions of extrusion that lose their digits when light and caster almost touch";

/// What most sweeps have in common.
const BASE: Sweep = Sweep {
    id: "",
    parameter: "",
    unit: "m",
    axis: Axis::Log,
    what_breaks: "",
    f32_loses: "",
    about: About::Anything,
    option: None,
    heavy_from: f64::INFINITY,
    slow_from: f64::INFINITY,
    stages: Vec::new,
};

const SWEEPS: &[Sweep] = &[
    Sweep {
        id: "offset-by-node",
        parameter: "distance from the origin, by a node's transform",
        what_breaks: OFFSET,
        stages: stages::offset_by_node,
        ..BASE
    },
    Sweep {
        id: "offset-exact",
        parameter: "distance from the origin, in vertices of whole metres",
        what_breaks: OFFSET,
        stages: stages::offset_exact,
        ..BASE
    },
    Sweep {
        id: "offset-rounded",
        parameter: "distance from the origin, in vertices of sixteenths of a metre",
        what_breaks: OFFSET,
        f32_loses: "from 2\u{b2}\u{2070} m (1.05e6) on an f32 no longer holds sixteenths, at 1e7 only whole metres: the \
                    vertices themselves are elsewhere, some on top of each other. That scene, not the one meant, is \
                    drawn exactly",
        stages: stages::offset_rounded,
        ..BASE
    },
    Sweep {
        id: "scale",
        parameter: "size of the scene",
        unit: "",
        what_breaks: "absolute epsilons",
        stages: stages::scale,
        ..BASE
    },
    Sweep {
        id: "light-far",
        parameter: "distance of a lamp",
        what_breaks: "a far lamp's position swamps the vertices it is subtracted from",
        stages: stages::light_far,
        ..BASE
    },
    Sweep {
        id: "light-near-face",
        parameter: "distance of a lamp from a box's face",
        what_breaks: TOUCH,
        stages: || stages::light_near(p(0.2, 1.375, 0.1), DVec3::Y),
        ..BASE
    },
    Sweep {
        id: "light-near-edge",
        parameter: "distance of a lamp from a box's edge",
        what_breaks: TOUCH,
        stages: || stages::light_near(p(0.75, 1.375, 0.1), DVec3::Y),
        ..BASE
    },
    Sweep {
        id: "light-near-corner",
        parameter: "distance of a lamp from a box's corner",
        what_breaks: TOUCH,
        stages: || stages::light_near(p(0.75, 1.375, 0.5), DVec3::ONE.normalize()),
        ..BASE
    },
    Sweep {
        id: "light-near-side",
        parameter: "distance of a lamp from a box's side",
        what_breaks: TOUCH,
        stages: || stages::light_near(p(0.75, 1.0, 0.1), DVec3::X),
        ..BASE
    },
    Sweep {
        id: "grazing-sun",
        parameter: "height of the sun",
        unit: "deg",
        what_breaks: "near-infinite shadows and all but parallel planes",
        stages: stages::grazing_sun,
        ..BASE
    },
    Sweep {
        id: "grazing-lamp",
        parameter: "height of a lamp over the floor",
        what_breaks: "near-infinite shadows and all but parallel planes",
        stages: stages::grazing_lamp,
        ..BASE
    },
    Sweep {
        id: "overlap-closed",
        parameter: "boxes between light and floor",
        unit: "",
        what_breaks: "counts wrap at multiples of 256 and lose integers above 2048",
        heavy_from: 1000.0,
        slow_from: 400.0,
        stages: || stages::overlap(counts::boxes),
        ..BASE
    },
    Sweep {
        id: "overlap-open",
        parameter: "sheets between light and floor",
        unit: "",
        what_breaks: "counts wrap at multiples of 256 and lose integers above 2048",
        heavy_from: 1000.0,
        slow_from: 400.0,
        stages: || stages::overlap(counts::quads),
        ..BASE
    },
    Sweep {
        id: "near-plane",
        parameter: "near distance, the eye in the light",
        what_breaks: "holes where the near plane cuts a volume; depth without digits",
        stages: || stages::near_plane(stages::yard_eye(), 1.0),
        ..BASE
    },
    Sweep {
        id: "near-plane-in-shadow",
        parameter: "near distance, the eye in the shadow",
        what_breaks: "z-pass chosen for a near rectangle that is partly in shadow",
        stages: || stages::near_plane([p(0.6, 0.3, -0.2), p(-1.5, 0.0, 2.5)], 0.7),
        ..BASE
    },
    Sweep {
        id: "field-of-view",
        parameter: "opening angle, the eye in the light",
        unit: "deg",
        axis: Axis::Linear,
        what_breaks: "bounds of the near rectangle",
        stages: || stages::field_of_view([stages::yard_eye()[0], p(0.8, 0.0, -0.5)]),
        ..BASE
    },
    Sweep {
        id: "field-of-view-in-shadow",
        parameter: "opening angle, the eye in the shadow",
        unit: "deg",
        axis: Axis::Linear,
        what_breaks: "bounds of the near rectangle",
        // Looks at the edge of the shadow it stands in.
        stages: || stages::field_of_view([p(0.6, 0.3, -0.2), p(-0.19, 0.0, 0.3)]),
        ..BASE
    },
    Sweep {
        id: "cone-width",
        parameter: "half-angle of a spot's cone",
        unit: "deg",
        what_breaks: "scissors and culling by the cone",
        stages: stages::cone_width,
        ..BASE
    },
    Sweep {
        id: "cone-across",
        parameter: "where a spot's axis meets the scene",
        axis: Axis::Linear,
        what_breaks: "casters culled at the cone's edge",
        stages: stages::cone_across,
        ..BASE
    },
    Sweep {
        id: "light-radius",
        parameter: "radius of a lamp",
        what_breaks: "a light larger than its casters, than the scene, than the distance to them",
        option: Some(Swept { option: "radius", shows_in: ShowsIn::Penumbrae }),
        stages: stages::light_radius,
        ..BASE
    },
    Sweep {
        id: "light-angle",
        parameter: "half-angle of the sun",
        unit: "deg",
        what_breaks: "a light larger than its casters",
        option: Some(Swept { option: "angle", shows_in: ShowsIn::Penumbrae }),
        stages: stages::light_angle,
        ..BASE
    },
    Sweep {
        id: "texels",
        parameter: "texels along a side of what a technique looks up",
        unit: "",
        what_breaks: "edges as coarse as texels, and features narrower than two of them",
        option: Some(Swept { option: "resolution", shows_in: ShowsIn::Edges }),
        stages: stages::texels,
        ..BASE
    },
    Sweep {
        id: "glass-depth",
        parameter: "tinted boxes between light and floor",
        unit: "",
        what_breaks: "logarithms and products lose digits with every layer",
        about: About::Glass,
        slow_from: 100.0,
        stages: stages::glass_depth,
        ..BASE
    },
    Sweep {
        id: "glass-transmission",
        parameter: "what a surface lets pass",
        unit: "",
        axis: Axis::Linear,
        what_breaks: "logarithms of next to nothing",
        about: About::Glass,
        stages: stages::glass_transmission,
        ..BASE
    },
];
