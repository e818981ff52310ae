//! A material's own way to reflect light, in WGSL.
//!
//! "Real-time soft shadows" (papers/002, §6.4) wished that a surface's own shader could know the shadow that the engine
//! found. Here the engine hands it over: the surface function gets each light's irradiance and its factor apart, and says
//! what shadow means: less light, other ink, another step of a toon.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, OnceLock};

use thiserror::Error;
use wgpu::naga;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};

use super::wgsl_names::{declared, names, place_of, too_nested};

/// The function every text must define.
const REFLECTED: &str = "fn reflected(surface: Surface, light: LightArriving) -> vec3f";
/// The function it may define, and what stands in for it.
const OUTGOING: &str =
    "fn outgoing(surface: Surface, lights: vec3f, ambient: vec3f, emitted: vec3f) -> vec3f";
const OUTGOING_BODY: &str = "{ return ambient + lights + emitted; }";
/// Both with the types of their parameters and result.
const WANTED: [(&str, &str, &[&str]); 2] = [
    ("reflected", REFLECTED, &["Surface", "LightArriving"]),
    ("outgoing", OUTGOING, &["Surface", "vec3f", "vec3f", "vec3f"]),
];

/// Compilers recurse into brackets, branches and the terms of a sum, and a stack has an end: so deep, and so many names
/// and signs in a statement, is far from it.
const MAX_DEPTH: usize = 64;
const MAX_STATEMENT: usize = 1000;
const TOO_NESTED: &str = "up to 64 brackets within one another, 64 branches in a function and 1000 names and signs in a statement are accepted";

/// Every flag of surface_shade under which it declares a name, but for those of [`ONE_OF`].
const ALL_FLAGS: &[&str] = &[
    "BASE_COLOR_TEXTURE",
    "COUNTS",
    "EMISSIVE_TEXTURE",
    "MASK",
    "MASKED",
    "METALLIC_ROUGHNESS_TEXTURE",
    "NORMAL_TEXTURE",
    "OCCLUSION_TEXTURE",
    "SECOND_UV",
    "SMOOTH_TERMINATOR",
    "SURFACE_FUNCTION",
    "TINTED",
    "VERTEX_COLOR",
    "VISIBILITY",
];

/// Flags under which it declares names, and which exclude one another.
const ONE_OF: [&str; 2] = ["MULTISAMPLED", "FARTHER"];

/// Why a surface function was refused. Lines are those of its own text, counted from 1.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum SurfaceFunctionError {
    #[error("surface function '{function}', line {line}: {message}")]
    Wgsl { function: String, line: usize, message: String },
    #[error("surface function '{function}' does not compile: {message}")]
    Unplaced { function: String, message: String },
    #[error("surface function '{function}' has no `reflected`; it must define `{wanted}`")]
    Missing { function: String, wanted: &'static str },
    #[error("surface function '{function}', line {line}: `{name}` must be `{wanted}`")]
    Signature { function: String, line: usize, name: &'static str, wanted: &'static str },
    #[error(
        "surface function '{function}', line {line}: the name `{name}` is one that the engine's own shader uses; call it otherwise"
    )]
    NameTaken { function: String, line: usize, name: String },
    #[error("surface function '{function}', line {line}: {what}")]
    NotAccepted { function: String, line: usize, what: &'static str },
    #[error("surface function '{function}' has {bytes} bytes, {limit} are accepted")]
    TooLong { function: String, bytes: usize, limit: usize },
}

/// A material's own WGSL, which says what it does with the light that arrives and the part of it that is shadowed.
///
/// The text defines one function, and another if it wants to:
///
/// ```wgsl
/// // The radiance that one light adds. Called for every light, also where `light.factor` is 0.
/// fn reflected(surface: Surface, light: LightArriving) -> vec3f
/// // What leaves the surface in all; left out, it is the sum.
/// fn outgoing(surface: Surface, lights: vec3f, ambient: vec3f, emitted: vec3f) -> vec3f
/// ```
///
/// `Surface` (where, which way it faces, its base colour, ..) and `LightArriving` (direction, irradiance, factor) are
/// documented in [`SurfaceFunction::INTERFACE`], with the engine's own `reflect_light(surface, towards_in_view)`: an
/// ordinary surface reflects `light.factor * light.irradiance * reflect_light(surface, light.towards_in_view)`. Radiances
/// include the picture's exposure and are tone-mapped like all others. Derivatives (`fwidth`) mean something outside of
/// branches that only some pixels take; both functions are called for all.
///
/// Beside these the text may have functions, constants, structures, aliases and private variables of names that the
/// engine's shader does not use. Nothing but shading changes: the surface casts and receives as it would without.
/// Where a shadow node darkens the finished picture, and on transparent surfaces on which no technique lets shadows fall,
/// the factor is that of an unshadowed light.
#[derive(Clone)]
pub struct SurfaceFunction {
    name: String,
    wgsl: Arc<str>,
    hash: u64,
    checked: OnceLock<Result<(), SurfaceFunctionError>>,
}

impl SurfaceFunction {
    /// The most bytes of a text.
    pub const MAX_BYTES: usize = 16 << 10;

    /// What a text can see of the engine, as WGSL (lines with `#` are the engine's own).
    pub const INTERFACE: &str = shadowgraph_shaders::SURFACE;

    /// The function called `name` in plans and errors, checked.
    ///
    /// # Errors
    /// [`SurfaceFunctionError`] with the line in `wgsl` and what is accepted.
    pub fn new(name: &str, wgsl: &str) -> Result<Self, SurfaceFunctionError> {
        let function = Self::unchecked(name, wgsl);
        function.check()?;
        Ok(function)
    }

    /// The function called `name`, checked when a scene with it is first planned: for texts that are still being
    /// written.
    pub fn unchecked(name: &str, wgsl: &str) -> Self {
        let mut hasher = DefaultHasher::new();
        wgsl.hash(&mut hasher);
        Self { name: name.into(), wgsl: wgsl.into(), hash: hasher.finish(), checked: OnceLock::new() }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its text.
    pub fn wgsl(&self) -> &str {
        &self.wgsl
    }

    /// Whether it will compile in every variant of the engine's shader; found out once.
    ///
    /// # Errors
    /// As [`SurfaceFunction::new`].
    pub fn check(&self) -> Result<(), SurfaceFunctionError> {
        self.checked.get_or_init(|| self.checked_anew()).clone()
    }

    /// `shader`, composed with the flag `SURFACE_FUNCTION`, with the text behind it.
    pub fn appended_to(&self, mut shader: String) -> String {
        // The last lines are the text's own: whatever it leaves open ends with it.
        if !declared(&self.wgsl).iter().any(|(_, _, name)| *name == "outgoing") {
            shader.push_str(OUTGOING);
            shader.push_str(OUTGOING_BODY);
            shader.push('\n');
        }
        shader.push_str(&self.wgsl);
        shader
    }

    fn line_at(&self, byte: usize) -> usize {
        self.wgsl.as_bytes()[..byte.min(self.wgsl.len())].iter().filter(|byte| **byte == b'\n').count() + 1
    }

    fn checked_anew(&self) -> Result<(), SurfaceFunctionError> {
        if self.wgsl.len() > Self::MAX_BYTES {
            let (bytes, limit) = (self.wgsl.len(), Self::MAX_BYTES);
            return Err(SurfaceFunctionError::TooLong { function: self.name.clone(), bytes, limit });
        }
        self.check_declarations()?;
        // First beside nothing but what it may see, then within everything it will be compiled with.
        let interface = composed("common/surface", &["SURFACE_FUNCTION"]);
        let module = self.compiled(&interface)?;
        self.check_signatures(&module)?;
        for flag in ONE_OF {
            self.compiled(&shading_with(flag))?;
        }
        Ok(())
    }

    fn check_declarations(&self) -> Result<(), SurfaceFunctionError> {
        let not_accepted = |at: usize, what| {
            Err(SurfaceFunctionError::NotAccepted {
                function: self.name.clone(),
                line: self.line_at(at),
                what,
            })
        };
        if let Some(at) = too_nested(&self.wgsl, MAX_DEPTH, MAX_STATEMENT) {
            return not_accepted(at, TOO_NESTED);
        }
        for (at, kind, name) in declared(&self.wgsl) {
            if kind == "override" {
                return not_accepted(at, "nothing sets an `override`; a `const` is accepted");
            }
            if reserved().contains(name) {
                let (function, line) = (self.name.clone(), self.line_at(at));
                return Err(SurfaceFunctionError::NameTaken { function, line, name: name.into() });
            }
        }
        if let Some(at) = place_of(&self.wgsl, "discard") {
            return not_accepted(
                at,
                "`discard` would leave the shadow of what it takes away; an alpha mask is accepted",
            );
        }
        if let Some(at) = place_of(&self.wgsl, "@") {
            return not_accepted(at, "a surface function has no entry points, bindings or other attributes");
        }
        Ok(())
    }

    /// Parses and validates `shader` with the text behind it, with no optional feature: whatever runs wgpu runs it.
    fn compiled(&self, shader: &str) -> Result<naga::Module, SurfaceFunctionError> {
        let text = self.appended_to(shader.to_owned());
        let before = text.len() - self.wgsl.len();
        let module = naga::front::wgsl::parse_str(&text).map_err(|error| {
            let spans: Vec<_> = error.labels().map(|(span, _)| span).collect();
            let notes: Vec<&str> = error.notes().collect();
            self.wrong(before, &spans, [error.message()].into_iter().chain(notes).collect())
        })?;
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        validator.validate(&module).map_err(|error| {
            // A function, a statement and an expression within it: the shortest says most.
            let mut spans: Vec<_> = error.spans().map(|(span, _)| *span).collect();
            spans.sort_by_key(|span| span.to_range().map(|range| range.len()));
            let mut causes = vec![error.as_inner().to_string()];
            let mut cause = std::error::Error::source(error.as_inner());
            while let Some(deeper) = cause {
                causes.push(deeper.to_string());
                cause = deeper.source();
            }
            self.wrong(before, &spans, causes.iter().map(String::as_str).collect())
        })?;
        Ok(module)
    }

    /// The compiler's message, at the first of its places that lies in this text.
    fn wrong(&self, before: usize, spans: &[naga::Span], messages: Vec<&str>) -> SurfaceFunctionError {
        let (function, message) = (self.name.clone(), messages.join("; "));
        let mut places = spans.iter().filter_map(|span| span.to_range()?.start.checked_sub(before));
        match places.find(|place| *place <= self.wgsl.len()) {
            Some(place) => SurfaceFunctionError::Wgsl { function, line: self.line_at(place), message },
            None => SurfaceFunctionError::Unplaced { function, message },
        }
    }

    fn check_signatures(&self, module: &naga::Module) -> Result<(), SurfaceFunctionError> {
        let is = |ty: naga::Handle<naga::Type>, wanted: &str| match &module.types[ty].inner {
            naga::TypeInner::Vector { size: naga::VectorSize::Tri, scalar } => {
                wanted == "vec3f" && *scalar == naga::Scalar::F32
            }
            _ => module.types[ty].name.as_deref() == Some(wanted),
        };
        for (name, wanted, parameters) in WANTED {
            let found = module.functions.iter().find(|(_, found)| found.name.as_deref() == Some(name));
            let Some((_, found)) = found else {
                return Err(SurfaceFunctionError::Missing { function: self.name.clone(), wanted });
            };
            let takes = found.arguments.len() == parameters.len()
                && found.arguments.iter().zip(parameters).all(|(argument, wanted)| is(argument.ty, wanted));
            if !(takes && found.result.as_ref().is_some_and(|result| is(result.ty, "vec3f"))) {
                let line = self.line_at(place_of(&self.wgsl, name).unwrap_or(0));
                return Err(SurfaceFunctionError::Signature {
                    function: self.name.clone(),
                    line,
                    name,
                    wanted,
                });
            }
        }
        Ok(())
    }
}

impl std::fmt::Debug for SurfaceFunction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SurfaceFunction({:?}, {} bytes)", self.name, self.wgsl.len())
    }
}

impl PartialEq for SurfaceFunction {
    fn eq(&self, other: &Self) -> bool {
        self.hash == other.hash
            && self.name == other.name
            && (Arc::ptr_eq(&self.wgsl, &other.wgsl) || self.wgsl == other.wgsl)
    }
}

impl Eq for SurfaceFunction {}

impl Hash for SurfaceFunction {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.hash);
    }
}

/// A shader of the engine's own; its text is checked by a test, so composing it cannot fail.
fn composed(name: &str, flags: &[&str]) -> String {
    shadowgraph_shaders::compose_named(name, flags).unwrap_or_default()
}

/// The engine's shader with everything it may have, and one of [`ONE_OF`].
fn shading_with(flag: &str) -> String {
    composed("surface_shade", &[ALL_FLAGS, &[flag]].concat())
}

/// Names that mean something in the engine's shader: what it declares for the whole module, and the functions and types
/// of the language that it uses (declared anew, they would change it). Names within its functions and structures do not
/// matter.
fn reserved() -> &'static HashSet<String> {
    static RESERVED: OnceLock<HashSet<String>> = OnceLock::new();
    RESERVED.get_or_init(|| {
        let (mut reserved, mut free) = (HashSet::new(), HashSet::new());
        let texts = ONE_OF.map(shading_with);
        for text in &texts {
            reserved.extend(names(text).into_iter().map(str::to_owned));
            free.extend(free_in(text));
        }
        // What one of the texts calls a variable of a function is no name of the language in another.
        reserved.retain(|name| !free.contains(name));
        // Module-wide names stay, whatever a function calls its own.
        for text in &texts {
            reserved.extend(declared(text).into_iter().map(|(_, _, name)| name.to_owned()));
        }
        reserved
    })
}

/// Names that one composed text gives to what lies within its functions and structs, and those that are asked for.
fn free_in(text: &str) -> HashSet<String> {
    let stub = format!("{REFLECTED} {{ return vec3f(); }} {OUTGOING} {OUTGOING_BODY}");
    let module = naga::front::wgsl::parse_str(&format!("{text}{stub}")).unwrap_or_default();
    let mut free: HashSet<String> = WANTED.map(|(name, ..)| name.to_owned()).into();
    let functions = module.functions.iter().map(|(_, function)| function);
    for function in functions.chain(module.entry_points.iter().map(|entry| &entry.function)) {
        let arguments = function.arguments.iter().filter_map(|argument| argument.name.clone());
        let variables = function.local_variables.iter().filter_map(|(_, variable)| variable.name.clone());
        free.extend(arguments.chain(variables).chain(function.named_expressions.values().cloned()));
    }
    for (_, ty) in module.types.iter() {
        if let naga::TypeInner::Struct { members, .. } = &ty.inner {
            free.extend(members.iter().filter_map(|member| member.name.clone()));
        }
    }
    free
}
