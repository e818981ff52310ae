//! What a light's shadows are at a point of a surface: the parts of a [`LightQuery`], judged and multiplied.
//!
//! Opaque surfaces and layers of transparent ones are judged alike, but for one thing: an opaque surface is dark where
//! eye and light are on opposite sides of it; of a transparent one no side is dark by itself, since light passes it.
//! That holds sample by sample for a light with a size.

use glam::{DVec3, DVec4, Vec3};

use super::area::{SizedCasters, SizedQuery, boundary_px};
use super::disc::DiscTracer;
use super::moved::{MOVES, Moved};
use super::render::{GRAZED, LightQuery, PixelReference};
use super::surface::Triangle;
use super::tracer::{CasterSet, Probe, Reference, Tracer};
use super::view::View;

/// A [`LightQuery`] of one reference.
pub(crate) struct Query {
    pub(crate) light: usize,
    /// Whether anything casts as if the light had no size, or nothing casts at all.
    is_hard: bool,
    pub(crate) casters: CasterSet,
    pub(crate) sized: Vec<SizedQuery>,
    /// Whether some part, asked about here or not, gives the light a size.
    has_size: bool,
    /// Where some transparent surface casts.
    pub(crate) transparent: Option<CasterSet>,
}

/// What casters leave of a light at a point, but for transparent ones that cast as if it had no size.
#[derive(Clone, Copy)]
pub(crate) struct Judged {
    /// Red, green and blue.
    pub(crate) factor: Vec3,
    pub(crate) compared: bool,
    pub(crate) ambiguous: bool,
    /// The least and the largest factor that is right.
    pub(crate) bounds: [Vec3; 2],
}

impl Judged {
    /// Where nothing stands before the light.
    pub(crate) fn lit(compared: bool) -> Self {
        Self { factor: Vec3::ONE, compared, ambiguous: false, bounds: [Vec3::ONE; 2] }
    }
}

/// A query and what one thread needs for asking it.
pub(crate) struct Asker<'a> {
    pub(crate) query: &'a Query,
    tracer: Tracer<'a>,
    disc: DiscTracer<'a>,
}

impl Query {
    pub(crate) fn new(reference: &Reference, asked: &LightQuery) -> Self {
        let position = reference.lights[asked.light].position;
        let (sized, points): (Vec<_>, Vec<_>) =
            asked.sized.iter().partition(|part| part.size.is_wide(position));
        // What has no size at this light is what has none at all.
        let with = |own: &[usize], of: fn(&SizedCasters) -> &Vec<usize>| -> Vec<usize> {
            points.iter().flat_map(|part| of(part)).chain(own).copied().collect()
        };
        let casters = with(&asked.casters, |part| &part.casters);
        let transparent = with(&asked.transparent, |part| &part.transparent);
        Self {
            light: asked.light,
            is_hard: sized.is_empty() || !casters.is_empty(),
            has_size: !sized.is_empty() || asked.beside_size,
            casters: reference.caster_set(&casters),
            transparent: reference.transparent_set(&transparent),
            sized: sized.into_iter().map(|part| SizedQuery::new(reference, part)).collect(),
        }
    }

    /// An asker of `reference`, whose query this is.
    pub(crate) fn asker<'a>(&'a self, reference: &'a Reference) -> Asker<'a> {
        Asker { query: self, tracer: reference.tracer(), disc: reference.disc_tracer() }
    }

    /// How many values a factor has.
    pub(crate) fn channels(&self) -> usize {
        let is_colored =
            self.transparent.is_some() || self.sized.iter().any(|part| part.transparent.is_some());
        if is_colored { 3 } else { 1 }
    }

    /// How many of `light_samples` all sized parts take, if all do: the most of them.
    pub(crate) fn same_samples(&self) -> Option<u32> {
        self.sized
            .iter()
            .map(|part| part.same_samples)
            .reduce(|a, b| a.zip(b).map(|(a, b)| a.max(b)))
            .flatten()
    }

    /// For each sized part, and for what casts as if the light had no size, how many words say which of its samples are
    /// lit; none for a light that has no size.
    pub(crate) fn words(&self) -> Vec<usize> {
        let hard = (self.is_hard && !self.sized.is_empty()).then_some(1);
        self.sized.iter().map(SizedQuery::words).chain(hard).collect()
    }

    /// The boundary pixels of all parts' samples, given each part's lit samples.
    pub(crate) fn boundary_px(&self, lit: &[Vec<u64>], compared: &[bool], width: usize) -> f64 {
        let samples = self.sized.iter().map(|part| part.samples.len()).chain(self.is_hard.then_some(1));
        let parts = lit.iter().zip(self.words()).zip(samples);
        parts.map(|((lit, words), samples)| boundary_px(lit, words, samples, compared, width)).sum()
    }

    /// Whether the same is said of the same point on either of two surfaces that lie in one plane: what casts on one
    /// casts on the other, since neither they nor anything else in their plane casts on them.
    pub(crate) fn says_same(&self, reference: &Reference, [a, b]: [&Moved<'_>; 2]) -> bool {
        let light = reference.lights[self.light].position;
        let faces = |moved: &Moved<'_>| moved.surface.facing(light) * moved.eye_side;
        a.surface.receives == b.surface.receives
            && a.surface.lets_light_pass == b.surface.lets_light_pass
            && faces(a) == faces(b)
    }
}

impl Asker<'_> {
    /// What is right at a point. `lit` has for each of [`Query::words`] a list that ends with as many words, or is empty:
    /// which samples are lit goes there.
    pub(crate) fn judge(&mut self, moved: &Moved<'_>, lit: &mut [Vec<u64>]) -> PixelReference {
        let judged = self.past_parts(moved, lit);
        let Judged { factor, compared, mut ambiguous, bounds } = judged;
        let (mut tint, mut changes) = (DVec3::ONE, false);
        if let Some(casters) = self.query.transparent.as_ref().filter(|_| bounds[1] != Vec3::ZERO) {
            (tint, changes) = self.query.tint(&mut self.tracer, moved, casters);
            ambiguous |= changes;
        }
        let tinted = |value: Vec3| (tint * value.as_dvec3()).as_vec3().to_array();
        let ([least, largest], factor) = (bounds.map(tinted), tinted(factor));
        // Without a size, an ambiguous factor may be anything; so may one whose tint is.
        let anything = changes || (ambiguous && self.query.sized.is_empty());
        let bounds = |channel: usize| if anything { [0.0, 1.0] } else { [least[channel], largest[channel]] };
        let bounds = [bounds(0), bounds(1), bounds(2)];
        // Where nothing of the light is seen, and at edges by the very reason for being in it, the band is no wider than it may be.
        let light = self.tracer.reference.lights[self.query.light].position;
        let mut casters = self.query.transparent.iter().chain([&self.query.casters]);
        let uncounted = ambiguous
            && (moved.at_edge
                || moved.is_tilted
                || casters.any(|casters| moved.is_at_rim(light, casters))
                || self.is_grazed(moved, light));
        PixelReference { factor, bounds, tint: tint.as_vec3().to_array(), compared, ambiguous, uncounted }
    }

    /// Whether no more than [`GRAZED`] of the light can reach the surface: the sine of its height, and of its radius.
    fn is_grazed(&self, moved: &Moved<'_>, light: DVec4) -> bool {
        let offset = light - moved.points[0].extend(0.0) * light.w;
        let distance = offset.truncate().length();
        let height = moved.surface.normal().normalize_or_zero().dot(offset.truncate()).abs();
        let radius = self.query.sized.iter().map(|part| part.size.disc(offset).radius).fold(0.0, f64::max);
        height + radius <= GRAZED * distance
    }

    /// The factor alone, where the ray through a place of the target meets `surface` at distance `t`; 1 where the light does
    /// not reach.
    pub(crate) fn factor(&mut self, surface: &Triangle, view: &View<'_>, place: [f64; 2], t: f64) -> Vec3 {
        let Self { query, tracer, .. } = self;
        if query.has_size {
            return Vec3::from(self.judge(&Moved::on(surface, view, place, t), &mut []).factor);
        }
        let light = &tracer.reference.lights[query.light];
        let (from, direction) = view.ray(place);
        let point = surface.onto_plane(from + direction * t);
        if !light.reaches(point) {
            return Vec3::ONE;
        }
        let hit = surface.as_hit();
        let factor = tracer.visibility_at(point, hit, view.eye, light.position, &query.casters);
        query.tint_at(tracer, point, surface) * factor
    }

    /// All parts' factors, multiplied.
    fn past_parts(&mut self, moved: &Moved<'_>, lit: &mut [Vec<u64>]) -> Judged {
        let Self { query, tracer, disc } = self;
        let hard = query.is_hard.then(|| query.judge(tracer, moved));
        if let (Some(hard), Some(word)) =
            (hard, lit.get_mut(query.sized.len()).and_then(|words| words.last_mut()))
        {
            *word = u64::from(hard.factor != Vec3::ZERO);
        }
        let parts = query.sized.iter().enumerate().map(|(index, part)| {
            let words = lit.get_mut(index).map_or(&mut [][..], |words| {
                let first = words.len() - part.words();
                &mut words[first..]
            });
            part.judge(disc, query.light, moved, words)
        });
        let whole = hard.into_iter().chain(parts).reduce(|a, b| Judged {
            factor: a.factor * b.factor,
            compared: a.compared && b.compared,
            ambiguous: a.ambiguous || b.ambiguous,
            bounds: [a.bounds[0] * b.bounds[0], a.bounds[1] * b.bounds[1]],
        });
        whole.unwrap_or(Judged::lit(false))
    }
}

impl Query {
    /// What casts as if the light had no size.
    fn judge(&self, tracer: &mut Tracer<'_>, moved: &Moved<'_>) -> Judged {
        let light = &tracer.reference.lights[self.light];
        // A surface that lies in the light's own direction gets no light from it, shadowed or not: along its plane
        // every edge it shares with a caster is grazed, and which side a ray passes is rounding.
        let facing = moved.surface.facing(light.position);
        let compared = light.reaches(moved.points[0]) && facing != 0;
        let reached =
            (0..MOVES).filter(|i| light.reaches(moved.points[*i])).fold(0_u8, |bits, i| bits | 1 << i);
        if !moved.surface.receives || reached == 0 {
            return Judged::lit(compared);
        }
        // The horizon is decided once: for a light with a size, sample by sample.
        let turned_away = facing * moved.eye_side < 0 && !self.has_size && !moved.surface.lets_light_pass;
        let dark = if turned_away { reached } else { tracer.blocked(&self.probe(tracer, moved)) & reached };
        // Every move agrees when all are dark or none is. A surface turned away stays so wherever the point moves.
        let all = (1_u8 << MOVES) - 1;
        let factor = if dark & 1 == 0 { Vec3::ONE } else { Vec3::ZERO };
        let mut ambiguous = (dark != 0 && dark != all) || (moved.lost && !turned_away);
        if !ambiguous && !turned_away {
            ambiguous = moved.is_at_rim(light.position, &self.casters);
        }
        if !ambiguous && !turned_away && facing * moved.eye_side > 0 {
            ambiguous = self.leaves_its_own_shadow(tracer, moved);
        }
        if !ambiguous && !turned_away {
            ambiguous = tracer.may_miss(moved, light.position, &self.casters);
        }
        let bounds = if ambiguous { [Vec3::ZERO, Vec3::ONE] } else { [factor; 2] };
        Judged { factor, compared, ambiguous, bounds }
    }

    /// Whether the point, moved away from the eye, comes out of the shadow that its own surface casts behind it, which
    /// faces the light: see [`super::moved`].
    fn leaves_its_own_shadow(&self, tracer: &mut Tracer<'_>, moved: &Moved<'_>) -> bool {
        let casts = moved.surface.casts && !moved.surface.lets_light_pass;
        let [.., deeper, _] = &moved.points;
        casts
            && moved.is_tilted
            && self.casters.contains(moved.surface.instance)
            && tracer.blocked(&Probe {
                points: std::slice::from_ref(deeper),
                receiver: None,
                light: tracer.reference.lights[self.light].position,
                casters: &self.casters,
            }) == 0
    }

    /// The question whether what has no size is in the way.
    pub(crate) fn probe<'a>(&'a self, tracer: &Tracer<'_>, moved: &'a Moved<'_>) -> Probe<'a> {
        Probe {
            points: &moved.points,
            receiver: Some(moved.surface),
            light: tracer.reference.lights[self.light].position,
            casters: &self.casters,
        }
    }
}

impl Reference {
    /// The queries whose lights the scene has.
    pub(crate) fn resolve(&self, lights: &[LightQuery]) -> Vec<Query> {
        let known = lights.iter().filter(|query| query.light < self.lights.len());
        known.map(|query| Query::new(self, query)).collect()
    }

    /// The set of the instances with these indices, if any of them is transparent.
    pub(crate) fn transparent_set(&self, instances: &[usize]) -> Option<CasterSet> {
        let set = self.caster_set(instances);
        let panes = self.panes.as_ref()?;
        let casts = |triangle: &Triangle| triangle.casts && set.contains(triangle.instance);
        panes.triangles.iter().any(casts).then_some(set)
    }
}
