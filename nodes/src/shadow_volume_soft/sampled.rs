//! Quality `sampled`: every sample of the light is blocked or not, exactly.
//!
//! A first draw over the picture marks the pixels that may see a part of the light only. The second rebuilds their points,
//! looks up the edges that may cross the light's disc and the triangles that may hide its centre, and keeps a count for each
//! sample: see shadow_volume_soft.wgsl.

use glam::Vec2;
use shadowgraph_engine::plan::{Shader, ShaderError};
use shadowgraph_engine::scene::Instance;
use shadowgraph_engine::shadow::{Contribution, LightContext, PassList, ShadowError, light_samples};

use super::ShadowVolumeSoft;
use super::light_data::{LightData, Parts};
use super::penumbra_mask::mark_and_ask;

impl ShadowVolumeSoft {
    pub(super) fn plan_sampled(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
    ) -> Result<Contribution, ShadowError> {
        let data = self.light_data(light, out, Parts::All)?;
        self.ask_samples(light, out, data, false)
    }

    /// Adds what parts with holes leave of the light that other passes do.
    pub(super) fn plan_masks(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
    ) -> Result<Contribution, ShadowError> {
        let has_masks = |instance: &Instance| instance.materials.iter().any(|m| m.casts_by_texel());
        if !light.casters().any(|(_, instance)| has_masks(instance)) {
            return Ok(Contribution::default());
        }
        let data = self.light_data(light, out, Parts::Masked)?;
        if data.masks.is_empty() {
            return Ok(Contribution::default());
        }
        self.ask_samples(light, out, data, true)
    }

    fn ask_samples(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        data: LightData,
        masks_only: bool,
    ) -> Result<Contribution, ShadowError> {
        // In each round the pixels that are drawn together, eight say, find their edges in turns, and count them in others.
        let long_lists = data.has_long_lists(9 * self.samples.div_ceil(64) as usize);
        let LightData { mut bindings, clusters, beside, on_layer, masks, casters, edges, triangles, .. } =
            data;
        if light.view.receiver_bounds.is_empty() {
            return Ok(Contribution::default());
        }
        let name = light.light().name.clone();
        let wanted = [
            ("CASTERS", casters > 0),
            ("CLUSTERS", clusters),
            ("BESIDE", beside),
            ("ON_LAYER", on_layer),
            ("ONE_CASTER", casters == 1),
            ("DEEP", triangles >= 1 << 16),
            ("LONG_LISTS", long_lists),
            ("MASKS", !masks.is_empty()),
            ("MASKS_ONLY", masks_only),
        ];
        bindings.extend(masks);
        let flags: Vec<&str> = wanted.iter().filter(|(_, wanted)| *wanted).map(|(flag, _)| *flag).collect();
        let shader = |fragment| shader(self.samples, &flags, fragment);
        let shaders = [shader("mark")?, shader("sampled")?];
        let reason = format!("{} samples of {name} before {casters} casters", self.samples);
        let asked = format!("{edges} edges, {triangles} triangles");
        Ok(mark_and_ask(light, out, bindings, shaders, (reason, asked)))
    }
}

/// The shader for so many samples.
fn shader(samples: u32, flags: &[&str], fragment: &'static str) -> Result<Shader, ShaderError> {
    let name = ("shadow_volume_soft", &*format!("of {samples} samples"));
    let code = ("common/light_samples", || samples_as_code(samples));
    Shader::replacing(name, flags, code, "soft_vertex", Some(fragment))
}

/// The module `common/light_samples` for so many samples: no loop, no look-up.
fn samples_as_code(count: u32) -> Result<String, ShaderError> {
    use std::fmt::Write;
    let samples: Vec<Vec2> = light_samples(count).iter().map(|sample| sample.as_vec2()).collect();
    let rounds: Vec<&[Vec2]> = samples.chunks(64).collect();
    let mut code = format!("const SAMPLE_COUNT: u32 = {count}u;\nconst ROUNDS: u32 = {}u;\n", rounds.len());
    let mut function = |head: &str, words: &dyn Fn(&[Vec2]) -> [String; 2]| {
        let _ = writeln!(code, "fn {head} -> vec2u {{");
        for (round, samples) in rounds.iter().enumerate() {
            let [low, high] = words(samples);
            // The last round needs no question.
            let (open, close) = if round + 1 < rounds.len() {
                (format!("if round == {round}u {{"), "}")
            } else {
                Default::default()
            };
            let _ = writeln!(
                code,
                "{open}\nvar low = 0u;\n{low}var high = 0u;\n{high}return vec2u(low, high);\n{close}"
            );
        }
        code.push_str("}\n");
    };
    let halves = |samples: &[Vec2], line: &dyn Fn(&str, Vec2) -> String| {
        let (low, high) = samples.split_at(samples.len().min(32));
        [("low", low), ("high", high)].map(|(word, samples)| {
            let lines: String = samples.iter().map(|sample| line(word, *sample)).collect();
            // Each sample moved those before it down by a bit.
            let shift = if samples.is_empty() || samples.len() == 32 {
                String::new()
            } else {
                format!("{word} >>= {}u;\n", 32 - samples.len())
            };
            lines + &shift
        })
    };
    function("samples_of(round: u32)", &|samples| {
        let ones = |count: usize| if count == 0 { 0 } else { u32::MAX >> (32 - count.min(32)) };
        let [low, high] = [ones(samples.len()), ones(samples.len().saturating_sub(32))];
        [format!("low = {low}u;\n"), format!("high = {high}u;\n")]
    });
    function("samples_not_below(heights: vec3f, round: u32)", &|samples| {
        halves(samples, &|word, s| {
            format!(
                "{word} = ({word} >> 1u) | (~bitcast<u32>(fma({:?}, heights.y, fma({:?}, heights.z, heights.x))) & 0x80000000u);\n",
                s.x, s.y
            )
        })
    });
    let head = "samples_crossed(heights: vec3f, a: vec2f, b: vec2f, flip: u32, round: u32)";
    function(head, &|samples| {
        halves(samples, &|word, s| {
            format!(
                "{word} = ({word} >> 1u) | sample_crossed(vec2f({:?}, {:?}), heights, a, b, flip);\n",
                s.x, s.y
            )
        })
    });
    // The one that is written by hand.
    let own = shadowgraph_shaders::compose_named("common/light_samples", &[])?;
    Ok(code + own.find("fn sample_crossed").map_or("", |place| &own[place..]))
}
