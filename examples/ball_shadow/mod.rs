//! `BallShadow`: hard shadows of balls, computed at every pixel: a whole technique in one file, options, shader and all.
//!
//! A ball hides the light from a point if the way to it passes nearer to the ball's centre than its radius. However coarse
//! the mesh, its shadow is round; meshes that are no balls are refused.

use std::sync::Arc;

use bytemuck::cast_slice;
use glam::{DMat4, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shadowgraph::technique::*;

/// The shader; its imports are the engine's. All positions are in view space.
pub(crate) const SHADER: &str = "
#import common/frame
#import common/fullscreen

struct Casters {
    light: vec4f, // (position, 1), or (unit direction towards the light, 0).
    balls: array<vec4f>, // (centre, radius).
}

@group(1) @binding(0) var<storage, read> casters: Casters;
@group(1) @binding(1) var receiver_depth: texture_depth_2d;

@fragment
fn visibility(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    // Where nothing is visible depth is 0 and the point infinitely far; whatever this says is not looked at.
    let point = view_from_pixel(pixel.xy, textureLoad(receiver_depth, vec2u(pixel.xy), 0));
    let to_light = casters.light.xyz - point * casters.light.w;
    var visible = 1.0;
    for (var i = 0u; i < arrayLength(&casters.balls); i++) {
        let ball = casters.balls[i];
        // The share of the way to the light at which it comes nearest to the centre; the way to a sun has no end.
        let nearest = dot(ball.xyz - point, to_light) / dot(to_light, to_light);
        let end = select(nearest, 1.0, casters.light.w > 0.0);
        let miss_m = length(ball.xyz - point - min(nearest, end) * to_light);
        visible *= select(1.0, 0.0, nearest > 0.0 && miss_m < ball.w);
    }
    return vec4f(visible);
}
";

/// The node and its options.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub(crate) struct BallShadow {
    /// How much larger than its mesh each ball is, in metres.
    #[serde(rename = "margin")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(crate) margin_m: f64,
}

impl BallShadow {
    /// How the catalog knows it.
    pub(crate) const ENTRY: TechniqueEntry =
        TechniqueEntry::of::<Self>("ball", "shadows of balls, computed at every pixel", &[]);
}

impl Options for BallShadow {
    const TYPE_NAME: &'static str = "BallShadow";
}

/// The centre and radius of the ball on which all vertices of `instance` lie, to a thousandth of the radius. Its facets
/// may be as deep inside as those of an icosahedron, but no deeper: the corners of a cube lie on a ball as well.
fn ball(instance: &Instance) -> Option<(DVec3, f64)> {
    let center = instance.world_bounds.center();
    let corners =
        |triangle| instance.mesh.triangle(triangle).map(|vertex| instance.world_position(vertex) - center);
    let radius_m = corners(0)[0].length();
    let fits = |triangle| {
        let [a, b, c] = corners(triangle);
        let is_on = |corner: DVec3| (corner.length() - radius_m).abs() < 1e-3 * radius_m;
        is_on(a) && is_on(b) && is_on(c) && (a + b + c).length() > 3.0 * 0.75 * radius_m
    };
    (0..instance.mesh.triangle_count()).all(fits).then_some((center, radius_m))
}

impl ShadowTechnique for BallShadow {
    fn params(&self) -> Params {
        self.to_params()
    }

    fn traits(&self) -> Traits {
        Traits { known_error: "meshes are taken for balls", approximates: true, ..Traits::default() }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        if !instance.is_opaque() {
            return Ok(false);
        }
        let is_ball = !instance.is_masked() && ball(instance).is_some();
        is_ball.then_some(true).ok_or_else(|| "it is no ball without holes".into())
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        let view_from_world = light.view.camera.world_from_view.inverse();
        let light_in_view = DMat4::from(view_from_world) * light.light().position;
        let mut records = vec![light_in_view.as_vec4().to_array()];
        let known =
            |instance: &Instance| *light.cache.get_or_compute("ball", instance.pose_key, || ball(instance));
        for (center, radius_m) in light.casters().filter_map(|(_, instance)| known(instance)) {
            let radius_m = radius_m + self.margin_m;
            records.push(view_from_world.transform_point3(center).extend(radius_m).as_vec4().to_array());
        }
        let (name, bytes) = (format!("balls of {}", light.light().name), cast_slice(&records).to_vec());
        let key = hash_of((Self::TYPE_NAME, &bytes));
        let casters =
            out.buffer(BufferDesc::storage(&name, key, Arc::new(bytes), "the light, and where they are"));
        let shader = Shader::written(Self::TYPE_NAME, SHADER, &[], "fullscreen_vertex", Some("visibility"))?;
        let state = DrawState::new(CompareFunction::Always, vec![Some(MULTIPLY)]);
        let draw = Draw::new("balls", Geometry::fullscreen(shader), state);
        let read = vec![(0, Binding::Storage(casters)), (1, Binding::Texture(out.receiver_depth()))];
        let (colors, draws) = (vec![ColorTarget::VISIBILITY], vec![draw.reading(read)]);
        out.pass(Pass { name, reason: "asked at every pixel".into(), colors, depth: None, draws });
        Ok(Contribution::visibility(Channels::One))
    }
}
