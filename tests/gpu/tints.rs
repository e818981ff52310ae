//! What weight and colour of a shadow do to the picture, and never to the factor; and shadows that darken the finished
//! picture instead of taking the light away.

use shadowgraph::engine::plan::{
    CompareFunction, DrawState, FactorAt, FramePlan, MULTIPLY, Shader, Stencil, StencilFaceState,
    StencilOperation,
};
use shadowgraph::engine::render::{Adapter, Frame, FrameError, PictureFormat};
use shadowgraph::engine::scene::{ParamValue, Params, ShadowFlags};
use shadowgraph::engine::shadow::{
    self as shadow, Cache, Channels, ColorTarget, Contribution, DepthTarget, Draw, Features, Geometry,
    LightContext, Pass, PassList, ShadowError, TechniqueEntry,
};
use shadowgraph::prelude::*;
use shadowgraph_testing::{Plain, catalog_with, renderer_with, technique};

/// How a [`Mark`] applies its shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Apply {
    /// It says nothing about it.
    Plainly,
    Light,
    Picture,
}

/// A shadow over the left half of the picture by counts, over its right half by a visibility of 1/2, or both.
#[derive(Clone, Copy, Debug)]
struct Mark {
    counts: bool,
    visibility: bool,
    apply: Apply,
    weight: f64,
    color: [f64; 3],
}

const MARK: Mark =
    Mark { counts: true, visibility: false, apply: Apply::Light, weight: 1.0, color: [0.0; 3] };

const TEXT: &str = "
#import common/fullscreen

@fragment
fn half() -> @location(0) vec4f {
    return vec4f(0.5);
}
";

impl Mark {
    fn params(&self) -> Params {
        let apply = f64::from(self.apply as u8);
        let bits = f64::from(u8::from(self.counts) + 2 * u8::from(self.visibility));
        let [r, g, b] = self.color;
        let all = [("bits", bits), ("apply", apply), ("weight", self.weight), ("r", r), ("g", g), ("b", b)];
        all.into_iter().map(|(name, value)| (name.into(), ParamValue::Number(value))).collect()
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        let (weight, color) = (self.weight, self.color);
        let mut left = Contribution {
            apply: match self.apply {
                Apply::Plainly => shadow::Apply::default(),
                Apply::Light => shadow::Apply::Light { weight, color },
                Apply::Picture => shadow::Apply::DarkenPicture { weight, color },
            },
            ..Contribution::default()
        };
        let [width, height] = light.view.size_px;
        let middle = width / 2;
        let draw = |fragment: Option<&'static str>, state, scissor| {
            let shader = Shader::written("mark", TEXT, &[], "fullscreen_vertex", fragment).unwrap();
            let draw = Draw::new("mark", Geometry::fullscreen(shader), state);
            Draw { scissor_px: Some(scissor), ..draw }
        };
        if self.counts {
            let depth = Some(DepthTarget::COUNT);
            left.counts_bound = Some(1);
            let face = StencilFaceState {
                compare: CompareFunction::Always,
                fail_op: StencilOperation::Keep,
                depth_fail_op: StencilOperation::Keep,
                pass_op: StencilOperation::IncrementWrap,
            };
            let mut state = DrawState::new(CompareFunction::Always, vec![]);
            state.stencil =
                Some(Stencil { front: face, back: face, read_mask: 0xff, write_mask: 0xff, reference: 0 });
            let name = format!("count {}", light.light().name);
            let draws = vec![draw(None, state, [0, 0, middle, height])];
            out.pass(Pass { name, reason: "a test".into(), colors: vec![], depth, draws });
        }
        if self.visibility {
            left.visibility = Some(Channels::One);
            let colors = vec![ColorTarget::VISIBILITY];
            let state = DrawState::new(CompareFunction::Always, vec![Some(MULTIPLY)]);
            let name = format!("veil {}", light.light().name);
            let draws = vec![draw(Some("half"), state, [middle, 0, width - middle, height])];
            out.pass(Pass { name, reason: "a test".into(), colors, depth: None, draws });
        }
        Ok(left)
    }
}

/// The technique of a node's options.
fn mark(params: &Params) -> Plain {
    let number = |name: &str| match params.get(name) {
        Some(ParamValue::Number(value)) => *value,
        _ => 0.0,
    };
    let bits = number("bits") as u8;
    let apply = [Apply::Plainly, Apply::Light, Apply::Picture][number("apply") as usize];
    let color = ["r", "g", "b"].map(number);
    let (counts, visibility) = (bits & 1 == 1, bits & 2 == 2);
    let mark = Mark { counts, visibility, apply, weight: number("weight"), color };
    Plain::new(move |light, out| mark.plan(light, out)).with_params(params)
}

const MARKS: [TechniqueEntry; 1] = [technique!("Mark", mark)];

/// A floor, three boxes, one of which receives nothing, no ambient light; and a lamp for each list of marks, each mark
/// a node over a box of its own.
fn yard(lamps: &[&[Mark]]) -> Scene {
    yard_lit_by(lamps, |_| true)
}

/// [`yard`], of whose lamps only some shine.
fn yard_lit_by(lamps: &[&[Mark]], shines: impl Fn(usize) -> bool) -> Scene {
    let mut scene = shadowgraph_testing::with_floor();
    scene.set_ambient(Vec3::ZERO);
    let boxes = [-1.5, 0.0, 1.5].map(|x| {
        shadowgraph_testing::add_box(
            &mut scene,
            &format!("crate at {x}"),
            shadowgraph_testing::at(x, 1.0, 0.0),
        )
    });
    let deaf = shadowgraph_testing::add_box(&mut scene, "deaf", shadowgraph_testing::at(0.0, 1.0, 2.5));
    if let Content::Mesh(mesh) = &mut scene.node_mut(deaf).unwrap().content {
        mesh.shadow = ShadowFlags { receives: false, casts: false };
    }
    for (index, marks) in lamps.iter().enumerate() {
        let eye = DVec3::new(2.0 + 3.0 * index as f64, 6.0, 5.0);
        let candela = if shines(index) { 90.0 } else { 0.0 };
        let lamp = scene.add_light(Light::point(&format!("lamp {index}"), candela), eye, DVec3::ZERO);
        for (number, mark) in marks.iter().enumerate() {
            let mut node = ShadowNode::new("Mark");
            for (name, value) in mark.params() {
                node = node.with_param(&name, value);
            }
            node.lights = Scope::Nodes(vec![lamp]);
            node.casters = Scope::Nodes(vec![boxes[number]]);
            scene.add_shadow(&format!("mark {number} of lamp {index}"), node);
        }
    }
    scene
}

fn linear(factors: bool, antialias: Antialias) -> FrameRequest {
    FrameRequest { picture: PictureFormat::LinearF32, factors, antialias, ..shadowgraph_testing::request() }
}

fn render(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Frame {
    let exposure = Exposure::Fixed(1.0);
    let options = RenderOptions { read_picture: true, exposure, ..RenderOptions::default() };
    renderer.render(scene, request, &options).unwrap()
}

fn picture(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f32> {
    render(renderer, scene, request).picture.unwrap().floats().unwrap()
}

/// The factor of one mark at a column of the picture.
fn factor(mark: &Mark, x: usize) -> f64 {
    let left = x < shadowgraph_testing::SIZE_PX[0] as usize / 2;
    if left {
        if mark.counts { 0.0 } else { 1.0 }
    } else if mark.visibility {
        0.5
    } else {
        1.0
    }
}

/// What `marks` leave of a light or of the picture, for one channel.
fn left_by(marks: &[Mark], x: usize, channel: usize) -> f64 {
    let one = |mark: &Mark| 1.0 - mark.weight * (1.0 - factor(mark, x)) * (1.0 - mark.color[channel]);
    marks.iter().map(one).product()
}

/// Renders `lamps` and checks every value of the picture: each lamp's light, or the whole picture, times what its marks
/// leave; and every factor, unweighted.
fn check(renderer: &mut Renderer, lamps: &[&[Mark]], antialias: Antialias) {
    let width = shadowgraph_testing::SIZE_PX[0] as usize;
    let none: Vec<&[Mark]> = lamps.iter().map(|_| &[] as &[Mark]).collect();
    let request = linear(false, antialias);
    // Each lamp's own light: the others are there, but dark.
    let alone: Vec<Vec<f32>> = (0..lamps.len())
        .map(|lit| picture(renderer, &yard_lit_by(&none, |lamp| lamp == lit), &request))
        .collect();
    let sky = picture(renderer, &yard(&[]), &request);
    for factors in [false, true] {
        let frame = render(renderer, &yard(lamps), &linear(factors, antialias));
        let seen = frame.visible_triangles.clone();
        let drawn = frame.picture.as_ref().unwrap().floats().unwrap();
        let mut darkened = 0;
        for (index, value) in drawn.iter().enumerate().filter(|(index, _)| index % 4 < 3) {
            let (x, channel) = (index / 4 % width, index % 4);
            let receives = |marks: &[Mark]| left_by(marks, x, channel);
            let light = |marks: &[Mark], lamp: usize, whole: bool| {
                let picture_marks = marks.iter().any(|mark| mark.apply == Apply::Picture);
                let share = if picture_marks || whole { 1.0 } else { receives(marks) };
                f64::from(alone[lamp][index] - sky[index]) * share
            };
            let sum = |whole: bool| -> f64 {
                let lit = lamps.iter().enumerate().map(|(lamp, marks)| light(marks, lamp, whole));
                f64::from(sky[index]) + lit.sum::<f64>()
            };
            let over: Vec<Mark> = lamps.concat().into_iter().filter(|m| m.apply == Apply::Picture).collect();
            // What receives nothing, and the sky, is as if there were no shadow.
            let (shadowed, unshadowed) = (sum(false) * receives(&over), sum(true));
            let fits = |expected: f64| (f64::from(*value) - expected).abs() <= 2e-3 * expected.abs() + 1e-5;
            // At edges, what is smoothed mixes both.
            let (least, most) = (shadowed.min(unshadowed), shadowed.max(unshadowed));
            let between = (least * 0.998 - 1e-5..=most * 1.002 + 1e-5).contains(&f64::from(*value));
            assert!(
                fits(shadowed) || fits(unshadowed) || (antialias != Antialias::None && between),
                "{lamps:?} {antialias} factors {factors}, at {x}: {value} instead of {shadowed} or {unshadowed}"
            );
            if antialias == Antialias::None
                && let Some(seen) = &seen
            {
                // Instance 4 is the deaf box.
                let id = seen[index / 4][0];
                let expected = if id == 4 || id == u32::MAX { unshadowed } else { shadowed };
                assert!(fits(expected), "{lamps:?} at {x} of instance {id}: {value} instead of {expected}");
            }
            darkened += u32::from(fits(shadowed) && !fits(unshadowed));
        }
        assert!(darkened > 300, "{lamps:?}: {darkened}");
        let Some(seen) = seen.filter(|_| antialias == Antialias::None) else { continue };
        for (image, marks) in frame.factors.iter().zip(lamps.iter().filter(|marks| !marks.is_empty())) {
            let floats = image.pixels.floats().unwrap();
            for (index, (value, id)) in floats.iter().zip(&seen).enumerate() {
                let raw: f64 = marks.iter().map(|mark| factor(mark, index % width)).product();
                let raw = if id[0] == 4 || id[0] == u32::MAX { 1.0 } else { raw };
                // Dark, too, where the surface is turned away.
                assert!(f64::from(*value) == raw || *value == 0.0, "{marks:?}: {value} instead of {raw}");
            }
            assert!(marks.iter().any(|mark| mark.counts) || floats.contains(&0.5));
        }
    }
}

/// Four samples a pixel show what one does, but at the edges of surfaces.
fn check_samples(renderer: &mut Renderer, lamps: &[&[Mark]]) {
    let mut bytes = |lamps: &[&[Mark]], antialias| {
        let request = FrameRequest { antialias, ..shadowgraph_testing::request() };
        render(renderer, &yard(lamps), &request).picture.unwrap().bytes
    };
    let one = bytes(lamps, Antialias::None);
    let four = bytes(lamps, Antialias::Multisample4);
    let none: Vec<&[Mark]> = lamps.iter().map(|_| &[] as &[Mark]).collect();
    let unshadowed = bytes(&none, Antialias::Multisample4);
    let differ = |a: &[u8], b: &[u8]| a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    let (at_edges, darkened) = (differ(&one, &four), differ(&four, &unshadowed));
    assert!(at_edges * 6 < one.len() && darkened > 300, "{lamps:?}: {at_edges} and {darkened}");
}

const RED: [f64; 3] = [0.8, 0.1, 0.0];

#[test]
fn weight_and_colour_scale_the_darkening_of_the_picture() {
    let Some(mut renderer) = renderer_with(&MARKS) else { return };
    let counted = Mark { weight: 0.75, color: RED, ..MARK };
    let veiled = Mark { weight: 0.25, counts: false, visibility: true, ..MARK };
    let both = Mark { weight: 0.5, visibility: true, ..MARK };
    let plain = Mark { apply: Apply::Plainly, visibility: true, ..MARK };
    for mark in [counted, veiled, both, MARK, plain] {
        check(&mut renderer, &[&[mark]], Antialias::None);
    }
    // Four samples a pixel keep counts; what is weighted needs nothing else.
    check_samples(&mut renderer, &[&[counted]]);
    check_samples(&mut renderer, &[&[counted, Mark { weight: 0.5, ..MARK }], &[MARK]]);
    check(&mut renderer, &[&[veiled]], Antialias::Supersample4);
    // Lights and nodes apart.
    check(&mut renderer, &[&[counted], &[veiled], &[plain]], Antialias::None);
    check(&mut renderer, &[&[counted, veiled]], Antialias::None);
    check(&mut renderer, &[&[plain, counted, both], &[veiled, MARK]], Antialias::None);
}

#[test]
fn shadows_may_darken_the_finished_picture() {
    let Some(mut renderer) = renderer_with(&MARKS) else { return };
    let counted = Mark { weight: 0.75, apply: Apply::Picture, color: RED, ..MARK };
    let veiled = Mark { weight: 0.25, counts: false, visibility: true, apply: Apply::Picture, ..MARK };
    let both = Mark { weight: 0.5, visibility: true, apply: Apply::Picture, ..MARK };
    for mark in [counted, veiled, both] {
        check(&mut renderer, &[&[mark]], Antialias::None);
    }
    check_samples(&mut renderer, &[&[counted]]);
    check_samples(&mut renderer, &[&[counted, counted], &[MARK]]);
    check(&mut renderer, &[&[counted], &[veiled, both]], Antialias::None);
    check(&mut renderer, &[&[counted, counted], &[MARK], &[both]], Antialias::None);
}

fn try_plan(scene: &Scene, request: &FrameRequest, adapter: &Adapter<'_>) -> Result<FramePlan, FrameError> {
    shadowgraph_testing::try_plan_with(scene, request, &catalog_with(&MARKS), adapter, &Cache::new())
}

fn plan(lamps: &[&[Mark]], factors: bool) -> FramePlan {
    try_plan(&yard(lamps), &linear(factors, Antialias::None), &Adapter::imagined()).unwrap()
}

#[test]
fn full_weight_and_black_add_nothing_to_the_plan() {
    let plain = Mark { apply: Apply::Plainly, ..MARK };
    let unnamed = |mut plan: FramePlan| {
        plan.lights.iter_mut().for_each(|light| light.techniques.clear());
        plan
    };
    for factors in [false, true] {
        for lamps in [&[&[MARK][..]][..], &[&[MARK, MARK], &[MARK]]] {
            let undecided: Vec<Vec<Mark>> = lamps.iter().map(|marks| vec![plain; marks.len()]).collect();
            let undecided: Vec<&[Mark]> = undecided.iter().map(Vec::as_slice).collect();
            assert_eq!(unnamed(plan(lamps, factors)), unnamed(plan(&undecided, factors)));
        }
    }
    // One weighted node: its counts are still read straight from the stencil.
    let weighted = plan(&[&[Mark { weight: 0.5, ..MARK }]], false);
    assert_eq!(weighted.lights[0].factor, FactorAt::Counts);
    assert_eq!(weighted.passes.len(), plan(&[&[MARK]], false).passes.len());
    assert_eq!(weighted.slots.len(), plan(&[&[MARK]], false).slots.len() + 1);
    assert!(weighted.to_string().contains("Counts taking [0.5, 0.5, 0.5]"), "{weighted}");
    assert!(weighted.slots.iter().any(|slot| slot.name == "tints" && slot.reason.contains("weights")));
    // Two: counted apart for the picture, and together once more where the factor is asked for.
    let two: &[&[Mark]] = &[&[Mark { weight: 0.5, ..MARK }, Mark { weight: 0.25, ..MARK }]];
    let counts = |plan: &FramePlan| plan.passes_named("count").count();
    assert_eq!((counts(&plan(two, false)), counts(&plan(two, true))), (2, 4));
    assert!(plan(two, true).to_string().contains("for the factor by itself"));
    assert_eq!(plan(two, false).lights[0].factors().count(), 2);
    // Everything that darkens the picture does so by one layer.
    let veil = Mark { visibility: true, counts: false, apply: Apply::Picture, ..MARK };
    let layers = |plan: &FramePlan| {
        let slot = plan.slots.iter().find(|slot| slot.name == "visibility").unwrap();
        if let shadowgraph::engine::plan::SlotKind::Texture { layers, .. } = slot.kind { layers } else { 0 }
    };
    assert_eq!(layers(&plan(&[&[veil, veil], &[veil]], false)), 1);
}

#[test]
fn a_light_is_darkened_in_one_way_and_odd_values_are_confined() {
    let veil = Mark { visibility: true, apply: Apply::Picture, ..MARK };
    let refused = |scene: &Scene, adapter: &Adapter<'_>| {
        try_plan(scene, &linear(false, Antialias::None), adapter).unwrap_err()
    };
    for marks in [[veil, MARK], [MARK, veil]] {
        let error = refused(&yard(&[&marks]), &Adapter::imagined());
        assert!(matches!(&error, FrameError::Shadow(ShadowError::DarkenedTwice { .. })), "{error}");
    }
    // Once for all lights, and by itself.
    let mut scene = yard(&[&[veil]]);
    let mut hard = shadowgraph_testing::hard(&[("passes", "single")]);
    hard.casters = Scope::Nodes(vec![scene.find("crate at 1.5").unwrap()]);
    scene.add_shadow("hard", hard);
    let error = refused(&scene, &Adapter::imagined());
    assert!(matches!(&error, FrameError::Shadow(ShadowError::DarkeningsDiffer { .. })), "{error}");
    // Pictures of floats need blending.
    let features = Features::all() - Features::FLOAT32_BLENDABLE;
    let error = refused(&yard(&[&[veil]]), &Adapter { features, ..Adapter::imagined() });
    assert!(matches!(&error, FrameError::Shadow(ShadowError::MissingFeature { .. })), "{error}");
    for odd in [f64::NAN, f64::INFINITY, -1.0, 7.0, 1e300] {
        for apply in [Apply::Light, Apply::Picture] {
            let mark = Mark { weight: odd, color: [odd, -odd, 0.5], visibility: true, apply, ..MARK };
            let planned = plan(&[&[mark, mark]], true);
            assert!(
                planned.lights[0]
                    .factors()
                    .all(|part| part.max_darkening.iter().all(|t| (0.0..=1.0).contains(t)))
            );
        }
    }
}
