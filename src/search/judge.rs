//! Whether a scene is drawn right.
//!
//! Settings that are exact owe what [`LightError::passes`] says. Of the others the table of tolerances in tests/gpu states
//! bounds on the hard cases; on any scene at all they owe what [`Owed`] says, which is no more than the loosest of those rows.
//! Hard scenes are held against [`Brute`] as well.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use shadowgraph_engine::gltf;
use shadowgraph_engine::gpu::GpuError;
use shadowgraph_engine::render::{FrameError, FrameRequest, RenderError, Renderer};
use shadowgraph_engine::scene::{LightSnapshot, ParamValue, Scene, SceneSnapshot};
use shadowgraph_engine::shadow::{Catalog, Claim, Registry, ShadowError, ShadowTechnique};

use super::{Brute, Recipe, RecipeError};
use shadowgraph_measure::{
    BAND_FLOOR_PIXELS, EvaluateError, Evaluation, KnownReferences, LightError, evaluate_again,
    evaluate_layers,
};

/// So many samples stand for a whole light, beside approximations: enough for their loose bounds.
const WHOLE_LIGHT_SAMPLES: u32 = 256;
/// Layers of transparent surfaces that are judged, from the nearest on.
const JUDGED_LAYERS: u32 = 4;

/// What a technique with its options owes for a light, whatever the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Owed {
    /// Nothing outside the band.
    Exact,
    /// Nothing lit that is dark: lids over open casters shadow too much.
    NoLeak,
    /// An error of the whole picture below this, and no larger share of it wrong by more than half.
    Close {
        /// Root of the mean squared difference.
        rmse: f64,
        /// The share of compared pixels that may be wrong outside the band.
        wrong_share: f64,
    },
    /// A picture, with finite factors.
    Drawn,
}

/// What went wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FailureKind {
    /// Factors outside their bounds.
    Outside,
    /// The same on a transparent layer.
    OnLayer,
    /// The ambiguity band is wider than it may be.
    WideBand,
    /// Picture and reference see different triangles in too many pixels.
    OtherTriangles,
    /// The reference says otherwise than brute force.
    Reference,
    /// The picture says otherwise than brute force, and the band excuses it.
    Excused,
    /// An error that is no refusal.
    Error,
    /// A panic.
    Panic,
}

/// A scene that is drawn wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// How.
    pub kind: FailureKind,
    /// In how many pixels, of the light that is worst; 0 for errors.
    pub pixels: usize,
    /// What was measured, a line for each light that fails.
    pub lines: Vec<String>,
}

impl Failure {
    /// Whether the other one may be the same mistake: of one kind, and for errors of one variant.
    pub fn is_like(&self, other: &Self) -> bool {
        let error = |failure: &Self| {
            let is_error = matches!(failure.kind, FailureKind::Error | FailureKind::Panic);
            let line = failure.lines.first().filter(|_| is_error)?;
            line.split(['{', '\'']).next().map(str::to_owned)
        };
        self.kind == other.kind && error(self) == error(other)
    }
}

/// What came of a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Drawn as it should be.
    Right {
        /// Pixels compared, over all lights.
        compared: usize,
        /// Those in shadow.
        in_shadow: usize,
    },
    /// No pixel could be compared.
    Empty,
    /// Refused with a typed error.
    Refused {
        /// The error's variant, and the technique where it names one.
        kind: String,
        /// What it says.
        message: String,
    },
    /// Drawn wrong.
    Wrong(Failure),
}

/// Renders scenes and judges them.
#[derive(Debug)]
pub struct Judge {
    renderer: Renderer,
}

/// Why a scene has no verdict yet.
enum Problem {
    Recipe(RecipeError),
    Evaluate(EvaluateError),
}

impl From<RecipeError> for Problem {
    fn from(error: RecipeError) -> Self {
        Self::Recipe(error)
    }
}

impl From<EvaluateError> for Problem {
    fn from(error: EvaluateError) -> Self {
        Self::Evaluate(error)
    }
}

impl From<RenderError> for Problem {
    fn from(error: RenderError) -> Self {
        Self::Evaluate(error.into())
    }
}

impl Judge {
    /// Judges what `renderer` draws.
    pub fn new(renderer: Renderer) -> Self {
        Self { renderer }
    }

    /// The techniques there are.
    pub fn catalog(&self) -> &Catalog {
        self.renderer.catalog()
    }

    /// The verdict on a recipe's scene. It goes through a `.glb` first, so that whatever is found is found in its file too.
    pub fn judge(&mut self, recipe: &Recipe) -> Verdict {
        let judged = catch_unwind(AssertUnwindSafe(|| self.judge_recipe(recipe)));
        match judged {
            Ok(Ok(verdict)) => verdict,
            Ok(Err(Problem::Recipe(error))) => broken(FailureKind::Error, error.to_string()),
            Ok(Err(Problem::Evaluate(error))) => of_error(&error),
            Err(panic) => {
                // Nothing that a panic left half done may speak for the next scene.
                let (gpu, catalog) = (self.renderer.gpu().clone(), self.renderer.catalog().clone());
                self.renderer = Renderer::new(gpu, catalog);
                let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
                let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
                broken(FailureKind::Panic, text.unwrap_or_else(|| "a panic without a word".into()))
            }
        }
    }

    fn judge_recipe(&mut self, recipe: &Recipe) -> Result<Verdict, Problem> {
        let scene = recipe.build(self.catalog())?;
        let glb = gltf::to_glb(&scene).map_err(RecipeError::from)?;
        let scene = gltf::load_slice(&glb.bytes, None).map_err(RecipeError::from)?.scene;
        self.judge_scene(&scene, recipe.size_px)
    }

    /// Judges a scene through its first camera.
    fn judge_scene(&mut self, scene: &Scene, size_px: [u32; 2]) -> Result<Verdict, Problem> {
        let (snapshot, registry) = self.renderer.snapshot(scene)?;
        let Some(camera) = snapshot.cameras.first() else { return Ok(Verdict::Empty) };
        let request = FrameRequest::new(camera.clone(), size_px);
        let mut references = KnownReferences::with_samples(WHOLE_LIGHT_SAMPLES);
        let evaluation =
            match evaluate_again(&mut self.renderer, scene, &request, &mut references, &|_, _| {}) {
                Err(EvaluateError::NothingToCompare) => return Ok(Verdict::Empty),
                evaluation => evaluation?,
            };
        let mut failures: Vec<Failure> = Vec::new();
        let owed = |name: &str| owed_for(&snapshot, &registry, name);
        for error in &evaluation.errors {
            failures.extend(complaint(error, owed(&error.name), None));
        }
        failures.extend(against_brute_force(&snapshot, &request, &evaluation, &owed));
        failures.extend(self.layer_failures(scene, &request, evaluation.frame.plan.layers, &owed)?);
        if let Some(kind) = failures.iter().map(|failure| failure.kind).min() {
            let pixels = failures.iter().filter(|f| f.kind == kind).map(|f| f.pixels).max().unwrap_or(0);
            let lines = failures.into_iter().flat_map(|failure| failure.lines).collect();
            return Ok(Verdict::Wrong(Failure { kind, pixels, lines }));
        }
        let compared: usize = evaluation.errors.iter().map(|error| error.compared).sum();
        let in_shadow = evaluation.errors.iter().map(|error| error.shadow_pixels).sum();
        Ok(if compared == 0 { Verdict::Empty } else { Verdict::Right { compared, in_shadow } })
    }

    fn layer_failures(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        layers: u32,
        owed: &dyn Fn(&str) -> Owed,
    ) -> Result<Vec<Failure>, Problem> {
        let range = 0..layers.min(JUDGED_LAYERS);
        let layers = evaluate_layers(&mut self.renderer, scene, request, range, &|_, _| {})?;
        let errors = layers.iter().flat_map(|on| on.errors.iter().map(|error| (on.layer, error)));
        Ok(errors.filter_map(|(layer, error)| complaint(error, owed(&error.name), Some(layer))).collect())
    }
}

fn broken(kind: FailureKind, line: String) -> Verdict {
    Verdict::Wrong(Failure { kind, pixels: 0, lines: vec![line] })
}

/// A refusal, if it is one by type; else a failure.
fn of_error(error: &EvaluateError) -> Verdict {
    let is_refusal = match error {
        // A plan that is not valid is a technique's mistake.
        EvaluateError::Render(RenderError::Shadow(error) | RenderError::Frame(FrameError::Shadow(error))) => {
            !matches!(error, ShadowError::Plan(_))
        }
        EvaluateError::Render(RenderError::Frame(error)) => matches!(error, FrameError::TooManyLayers { .. }),
        EvaluateError::Render(RenderError::Gpu(error)) => matches!(
            error,
            GpuError::BufferTooLarge { .. } | GpuError::TextureTooLarge { .. } | GpuError::Budget { .. }
        ),
        _ => false,
    };
    if !is_refusal {
        return broken(FailureKind::Error, format!("{error:?}"));
    }
    let text = format!("{error:?}");
    // The innermost variant's name, and the technique: Render(Shadow(CasterRefused { node: .., technique: "X", ..
    let variant = text.split([' ', '{']).next().unwrap_or_default();
    let variant = variant.rsplit('(').next().unwrap_or_default();
    let technique = text.split("technique: \"").nth(1).and_then(|rest| rest.split('"').next());
    let kind = technique.map_or(variant.to_owned(), |technique| format!("{variant} {technique}"));
    Verdict::Refused { kind, message: error.to_string() }
}

/// The least that the techniques of a light owe.
fn owed_for(snapshot: &SceneSnapshot, registry: &Registry, light: &str) -> Owed {
    let place = snapshot.lights.iter().position(|snapshot| snapshot.name == light);
    let claims = place.map_or(&[][..], |place| &registry.lights[place]);
    let light = place.map(|place| &snapshot.lights[place]);
    let of = |claim: &Claim| light.map_or(Owed::Drawn, |light| owed(&claim.technique, light));
    claims.iter().map(of).fold(Owed::Exact, looser)
}

/// The looser of two: one light's factor is the product of all.
fn looser(a: Owed, b: Owed) -> Owed {
    match (a, b) {
        (Owed::Exact, other) | (other, Owed::Exact) => other,
        (a, b) if a == b => a,
        _ => Owed::Drawn,
    }
}

/// What a technique with its options owes for a light.
pub fn owed(technique: &Arc<dyn ShadowTechnique>, light: &LightSnapshot) -> Owed {
    let params = technique.params();
    let is = |option: &str, value: &str| matches!(params.get(option), Some(ParamValue::Text(text)) if text == value);
    let is_wide = technique.traits().light_size.is_wide(light.position);
    // Areas add up, and silhouettes are the centre's: their rows go up to every pixel wrong by 0.9.
    if is_wide && (is("quality", "perReceiver") || is("quality", "wedge")) {
        return Owed::Drawn;
    }
    // Lids are wrong where light comes through the opening, and where they pass through their mesh.
    if is("closure", "cap") {
        return Owed::Drawn;
    }
    // Behind a few dark surfaces half-float products may be anything, as the technique says of itself.
    if is("accumulate", "product16") {
        return Owed::Drawn;
    }
    // The loosest of half floats' rows.
    if is("accumulate", "log16") {
        return Owed::Close { rmse: 0.2, wrong_share: 0.0 };
    }
    // Texels: of what a map shows by halves (one side of open casters), or with a bias of somebody's own, anything may be wrong.
    if params.contains_key("pcf") {
        let whole = !is("faces", "front") && !is("faces", "back") && !params.contains_key("constantBias");
        return if whole { Owed::Close { rmse: 0.2, wrong_share: 0.02 } } else { Owed::Drawn };
    }
    // Points in a ball: the row of casters within the light's sphere.
    if technique.traits().shades_receivers_only {
        return Owed::Close { rmse: 0.13, wrong_share: 0.02 };
    }
    Owed::Exact
}

/// What is wrong with one light, on the opaque surfaces or on a layer.
fn complaint(error: &LightError, owed: Owed, layer: Option<u32>) -> Option<Failure> {
    if error.compared == 0 {
        return None;
    }
    let failure = |kind, pixels| {
        let on = layer.map_or(String::new(), |layer| format!(" layer {layer}"));
        let lines = vec![format!("{}{on}: {}", error.name, line(error))];
        Some(Failure { kind, pixels, lines })
    };
    let outside = if layer.is_some() { FailureKind::OnLayer } else { FailureKind::Outside };
    let share = |count: usize| count as f64 / error.compared as f64;
    match owed {
        Owed::Drawn => None,
        Owed::NoLeak if error.leak_outside_band > 0 => failure(outside, error.leak_outside_band),
        Owed::NoLeak => None,
        Owed::Close { rmse, wrong_share } => {
            // A handful of pixels says nothing about a picture.
            let wrong = error.wrong_outside_band > 4 && share(error.wrong_outside_band) > wrong_share;
            let is_off = error.compared > 500 && error.rmse > rmse;
            if wrong || is_off { failure(outside, error.wrong_outside_band) } else { None }
        }
        Owed::Exact if error.passes() => None,
        Owed::Exact if error.outside_bounds > 0 || error.wrong_outside_band > 0 => {
            failure(outside, error.outside_bounds)
        }
        Owed::Exact if !error.sees_same() => failure(FailureKind::OtherTriangles, error.different_triangle),
        Owed::Exact => failure(FailureKind::WideBand, error.band_pixels),
    }
}

/// What was measured of a light, as the files of known faults have it.
fn line(error: &LightError) -> String {
    format!(
        "compared {} other {} boundary {} band {} wrong {} outside band {} outside bounds {} rmse {:.5} max {:.3} \
         (shadow: {} exact, {} drawn)",
        error.compared,
        error.different_triangle,
        error.boundary_pixels,
        error.band_pixels,
        error.wrong,
        error.wrong_outside_band,
        error.outside_bounds,
        error.rmse,
        error.max,
        error.shadow_pixels,
        error.measured_shadow_pixels,
    )
}

/// What brute force says about lights whose shadows are hard and exact.
fn against_brute_force(
    snapshot: &SceneSnapshot,
    request: &FrameRequest,
    evaluation: &Evaluation,
    owed: &dyn Fn(&str) -> Owed,
) -> Vec<Failure> {
    let Some(brute) = Brute::new(snapshot) else { return Vec::new() };
    let mut failures = Vec::new();
    for (place, query) in evaluation.queries.iter().enumerate() {
        let light = &snapshot.lights[query.light];
        // Sized parts of lights that have none here are hard.
        let is_hard = query.sized.iter().all(|part| !part.size.is_wide(light.position));
        if !is_hard || owed(&light.name) != Owed::Exact {
            continue;
        }
        let mut query = query.clone();
        query.casters.extend(query.sized.drain(..).flat_map(|part| part.casters));
        query.casters.sort_unstable();
        let found = brute.compare(snapshot, request, evaluation, (place, &query));
        let name = &light.name;
        if found.reference > 0 {
            let text = format!("{name}: brute force contradicts the reference in {} pixels", found.reference);
            failures.push(Failure {
                kind: FailureKind::Reference,
                pixels: found.reference,
                lines: vec![text],
            });
        }
        if found.excused > BAND_FLOOR_PIXELS {
            let text = format!("{name}: {} wrong pixels are excused by the band", found.excused);
            failures.push(Failure { kind: FailureKind::Excused, pixels: found.excused, lines: vec![text] });
        }
    }
    failures
}
