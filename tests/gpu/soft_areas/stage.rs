//! Casters over a floor under one lamp, with the coverage that convex casters have in closed form.

use std::fmt;

use glam::DVec3;
use shadowgraph::engine::scene::{ParamValue, Params};
use shadowgraph::engine::shadow::{LightDisc, LightSize};
use shadowgraph::prelude::*;

use shadowgraph_testing::twin::in_f64::{DiscView, share_above, triangle_share};

/// A light with a size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lamp {
    pub(crate) p: DVec3,
    pub(crate) radius_m: f64,
}

/// The unit box, a quarter of a metre over the floor.
pub(crate) fn block() -> MeshData {
    shapes::cuboid(Vec3::new(-0.5, 0.25, -0.5), Vec3::new(0.5, 1.25, 0.5))
}

/// Floor pixels: where they are, and the light's factor there.
pub(crate) type Pixels = Vec<(DVec3, f64)>;

/// A scene of closed convex casters over a floor.
pub(crate) struct Stage {
    pub(crate) casters: Vec<MeshData>,
    pub(crate) lamp: Lamp,
    pub(crate) options: Vec<(&'static str, ParamValue)>,
}

/// How far factors are from what is right, over the pixels of penumbrae.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Errors {
    pub(crate) penumbra: usize,
    pub(crate) rmse: f64,
    pub(crate) mean: f64,
    pub(crate) largest: f64,
    /// Over pixels outside penumbrae.
    pub(crate) largest_outside: f64,
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { penumbra, rmse, mean, largest, largest_outside } = self;
        write!(
            f,
            "{penumbra} penumbra pixels, rmse {rmse:.5}, mean {mean:+.5}, largest {largest:.4}, outside {largest_outside:.4}"
        )
    }
}

const SIZE_PX: [u32; 2] = [256, 256];

impl Stage {
    pub(crate) fn new(casters: Vec<MeshData>, lamp: Lamp) -> Self {
        Self { casters, lamp, options: Vec::new() }
    }

    /// The floor, the casters, the lamp and a node of `quality`.
    pub(crate) fn scene(&self, quality: &str) -> Scene {
        let mut scene = Scene::new();
        let floor = shapes::plane(Vec2::splat(6.0));
        scene.add_mesh(Mesh::new(floor).unwrap(), Material::default(), DAffine3::IDENTITY);
        for caster in &self.casters {
            scene.add_mesh(Mesh::new(caster.clone()).unwrap(), Material::default(), DAffine3::IDENTITY);
        }
        scene.add_light(Light::point("lamp", 40.0), self.lamp.p, DVec3::ZERO);
        let mut params = Params::from([
            ("quality".into(), ParamValue::Text(quality.into())),
            ("radius".into(), ParamValue::Number(self.lamp.radius_m)),
        ]);
        params.extend(self.options.iter().map(|(name, value)| ((*name).to_owned(), value.clone())));
        scene.add_shadow(
            "soft",
            ShadowNode { technique: "ShadowVolumeSoft".into(), params, ..ShadowNode::default() },
        );
        scene
    }

    /// What is looked at.
    pub(crate) fn request() -> FrameRequest {
        let camera = Camera::perspective("eye", 0.9);
        FrameRequest::new(CameraSnapshot::looking(camera, DVec3::new(3.5, 5.0, 4.5), DVec3::ZERO), SIZE_PX)
    }

    /// The factors of `quality` at the floor.
    pub(crate) fn factors(&self, renderer: &mut Renderer, quality: &str) -> Pixels {
        let request = Self::request();
        let camera = &request.camera;
        let measured = shadowgraph_testing::measure(renderer, &self.scene(quality), &request).unwrap();
        let world_from_view = camera.world_from_view;
        let mut pixels = Vec::new();
        for (pixel, ids) in measured.ids.iter().enumerate() {
            if ids[0] != 0 {
                continue;
            }
            let at = |n: usize, size: u32| (n as f64 + 0.5) / f64::from(size) * 2.0 - 1.0;
            let (x, y) = (pixel % SIZE_PX[0] as usize, pixel / SIZE_PX[0] as usize);
            let (origin, ray) = camera.projection.view_ray(at(x, SIZE_PX[0]), -at(y, SIZE_PX[1]), 1.0);
            let origin = world_from_view.transform_point3(origin);
            let ray = world_from_view.transform_vector3(ray);
            let p = origin - ray * (origin.y / ray.y);
            pixels.push((p, f64::from(measured.lights[0].1[pixel])));
        }
        pixels
    }

    /// What of the light convex casters leave at `p` of the floor, exactly where they do not overlap, else too little.
    pub(crate) fn right(&self, p: DVec3) -> f64 {
        let to_light = self.lamp.p - p;
        let distance = to_light.length();
        let towards = to_light / distance;
        let scale =
            (distance * distance - self.lamp.radius_m * self.lamp.radius_m).sqrt() / self.lamp.radius_m;
        // Left-handed, so that what the receiver sees counter-clockwise is so here.
        let v = towards.any_orthonormal_vector();
        let u = towards.cross(v);
        let frame = |d: DVec3| DVec3::new(d.dot(u) * scale, d.dot(v) * scale, d.dot(towards));
        let horizon = DVec3::new(u.y / scale, v.y / scale, towards.y);
        let steep = horizon.truncate().length();
        let disc = DiscView { horizon, far: distance, dips: horizon.z < steep, margin: 0.0, lift: 0.0 };
        let mut left = if disc.dips { share_above(horizon.z / steep) } else { 1.0 };
        for caster in &self.casters {
            for t in caster.indices.chunks_exact(3) {
                let corners = [0, 1, 2].map(|k| caster.positions[t[k] as usize].as_dvec3() - p);
                if corners[0].dot((corners[1] - corners[0]).cross(corners[2] - corners[0])) < 0.0 {
                    left -= triangle_share(disc, corners.map(frame));
                }
            }
        }
        left.max(0.0)
    }

    /// What of the light any casters leave at `p` of the floor: the share of samples that none of their triangles hides.
    pub(crate) fn right_by_samples(&self, p: DVec3, samples: &[DVec2]) -> f64 {
        let size = LightSize { radius_m: self.lamp.radius_m, ..LightSize::NONE };
        let LightDisc { radius, u, v } = size.disc((self.lamp.p - p).extend(1.0));
        let corner = |caster: &MeshData, i: u32| caster.positions[i as usize].as_dvec3() - p;
        let triangles: Vec<[DVec3; 3]> = self
            .casters
            .iter()
            .flat_map(|caster| {
                caster.indices.chunks_exact(3).map(|t| [0, 1, 2].map(|k| corner(caster, t[k])))
            })
            .collect();
        let seen = samples.iter().filter(|sample| {
            let way = self.lamp.p - p + (u * sample.x + v * sample.y) * radius;
            let hides = |[a, b, c]: &[DVec3; 3]| {
                let sides = [a.cross(*b).dot(way), b.cross(*c).dot(way), c.cross(*a).dot(way)];
                let volume = a.dot(b.cross(*c));
                sides.iter().all(|side| side * volume > 0.0) && volume / sides.iter().sum::<f64>() < 1.0
            };
            way.y > 0.0 && !triangles.iter().any(hides)
        });
        seen.count() as f64 / samples.len() as f64
    }

    /// How far `quality` is from what is right before convex casters that do not overlap.
    pub(crate) fn errors(&self, renderer: &mut Renderer, quality: &str) -> Errors {
        self.errors_against(renderer, quality, |p| self.right(p))
    }

    /// How far `quality` is from `right`.
    pub(crate) fn errors_against(
        &self,
        renderer: &mut Renderer,
        quality: &str,
        right: impl Fn(DVec3) -> f64,
    ) -> Errors {
        let mut errors = Errors::default();
        for (p, factor) in self.factors(renderer, quality) {
            assert!(factor.is_finite() && (0.0..=1.0).contains(&factor), "{factor} at {p}");
            let right = right(p);
            let error = factor - right;
            if right > 1e-9 && right < 1.0 - 1e-9 {
                errors.penumbra += 1;
                errors.rmse += error * error;
                errors.mean += error;
                errors.largest = errors.largest.max(error.abs());
            } else {
                errors.largest_outside = errors.largest_outside.max(error.abs());
            }
        }
        errors.rmse = (errors.rmse / errors.penumbra as f64).sqrt();
        errors.mean /= errors.penumbra as f64;
        errors
    }
}
