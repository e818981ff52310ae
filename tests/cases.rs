//! The table of hard cases is complete, and every scene of it shows what it is about.
//!
//! A small tracer of its own (all triangles, no tree, no code shared with the reference) checks that the camera sees
//! every probe, that the probes' hand-made answers are right (through glass and for lights with a size, too), and that frames which must show a shadow do.

use std::sync::Arc;

use glam::{DVec3, DVec4, Vec2, Vec3};
use shadowgraph::cases::sweeps::{self, Axis};
use shadowgraph::cases::{self, Case, Expect};
use shadowgraph::measure::LightSize;
use shadowgraph_engine::math::{Aabb, facing_sign};
use shadowgraph_engine::scene::{
    AlphaMode, Image, Instance, Material, Posed, PosedCamera, PosedLight, TexCoord, TextureRef, Wrap,
};

/// Every id of the documentation.
const IDS: &[&str] = &[
    "light-in-plane",
    "light-on-edge",
    "light-on-vertex",
    "light-in-closed",
    "light-in-open-box",
    "eye-in-shadow",
    "near-clips-side",
    "near-clips-corner",
    "eye-in-cap-plane",
    "light-in-near-plane",
    "light-behind-eye",
    "light-at-eye",
    "sliver",
    "zero-area",
    "duplicate-vertex",
    "duplicate-face",
    "opposite-duplicate",
    "t-junction",
    "fins",
    "two-cubes-one-edge",
    "inconsistent-winding",
    "moebius",
    "single-quad",
    "open-cylinder",
    "material-split",
    "uv-seam",
    "closed-inside-out",
    "closed-open-mixed",
    "casters-around-light",
    "alpha-mask",
    "terminator",
    "nested-shells",
    "coplanar-receiver",
    "touching-receiver",
    "offset-1e4",
    "offset-1e5",
    "offset-1e6",
    "scale-1e-4",
    "scale-1e4",
    "mirrored",
    "non-uniform",
    "sheared",
    "singular",
    "overlap-256",
    "overlap-512",
    "overlap-open-128",
    "overlap-2049",
    "overlap-4096",
    "overlap-seen-through",
    "count-figure",
    "directional-parallel",
    "low-sun",
    "directional-offscreen",
    "offscreen-caster",
    "light-crosses-frustum",
    "index-65536",
    "skinned-extreme",
    "morph",
    "instanced-1000",
    "animated",
    "alpha-0",
    "alpha-1",
    "channel-0",
    "glass-order",
    "glass-deep",
    "tinted-bottle",
    "stained-glass",
    "glass-self",
    "panes-intersecting",
    "opaque-behind-glass",
    "radius-0",
    "receiver-inside-light",
    "light-touches-caster",
    "caster-in-light",
    "edge-at-centre",
    "edge-through-centre",
    "penumbra-overlap",
    "tripod",
    "penumbra-width",
    "planar-behind",
    "planar-crossing",
    "planar-below",
    "planar-overhang",
    "planar-overlap",
    "map-acne",
    "map-peter-panning",
    "map-cube-seam",
    "map-grazing",
    "msaa",
    "lights-1",
    "lights-4",
    "lights-16",
    "lights-64",
    "sky",
    "ortho-camera",
    "resize",
    "1x1",
    "4096",
];

/// A triangle's mask by its nearest texels: enough for points well inside holes and leaves.
struct Mask {
    image: Option<(Arc<Image>, TextureRef)>,
    uvs: [Vec2; 3],
    alphas: [f32; 3],
    cutoff: f32,
}

impl Mask {
    fn of(posed: &Posed, instance: &Instance, triangle: usize) -> Option<Self> {
        let material = instance.material_of(triangle);
        let AlphaMode::Mask { cutoff } = material.alpha_mode else { return None };
        let (data, corners) = (instance.mesh.data(), instance.mesh.triangle(triangle));
        let texture = material.base_color_texture;
        let second = texture.is_some_and(|texture| texture.tex_coord == TexCoord::Second);
        let uvs = if second { &data.second_uvs } else { &data.uvs };
        let alpha = |vertex: u32| data.colors.get(vertex as usize).map_or(1.0, |color| color.w);
        Some(Self {
            image: texture.map(|texture| (Arc::clone(&posed.images[&texture.image]), texture)),
            uvs: corners.map(|vertex| uvs.get(vertex as usize).copied().unwrap_or_default()),
            alphas: corners.map(alpha),
            cutoff,
        })
    }

    /// Whether there is no hole at the point of these weights of the second and third corner.
    fn is_there(&self, [u, v]: [f64; 2]) -> bool {
        let weights = Vec3::new((1.0 - u - v) as f32, u as f32, v as f32);
        let mut alpha = Vec3::from(self.alphas).dot(weights);
        if let Some((image, texture)) = &self.image {
            let [a, b, c] = self.uvs;
            let uv = (a * weights.x + b * weights.y + c * weights.z).extend(1.0);
            let place = texture.transform.rows().map(|row| row.dot(uv));
            let texel = |axis: usize, size: u32| match texture.wrap[axis] {
                Wrap::Clamp => (place[axis].clamp(0.0, 0.9999) * size as f32) as u32,
                Wrap::Repeat => (place[axis].rem_euclid(1.0) * size as f32) as u32 % size,
                Wrap::Mirror => {
                    let within = place[axis].rem_euclid(2.0);
                    (within.min(2.0 - within) * size as f32) as u32 % size
                }
            };
            let (x, y) = (texel(0, image.width), texel(1, image.height));
            alpha *= f32::from(image.rgba8[((y * image.width + x) * 4 + 3) as usize]) / 255.0;
        }
        alpha >= self.cutoff
    }
}

/// Corners, and the holes of the material if it has any.
type BareTriangle = ([DVec3; 3], Option<Mask>);

/// A posed scene as bare triangles, one box for each instance.
struct Soup {
    instances: Vec<(Aabb, Vec<BareTriangle>)>,
    glass: Vec<Glass>,
}

/// A triangle that lets light through.
struct Glass {
    corners: [DVec3; 3],
    uvs: [Vec2; 3],
    material: Arc<Material>,
    image: Option<Arc<Image>>,
}

impl Glass {
    /// What passes at the point of these weights of the second and third corner: (1 − α)·rgb, and all where α is 0.
    fn transmission(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let mut color = self.material.base_color.as_dvec4();
        if let Some(image) = &self.image {
            let [a, b, c] = self.uvs.map(Vec2::as_dvec2);
            let uv = (a * (1.0 - u - v) + b * u + c * v).fract();
            let texel = |coordinate: f64, size: u32| ((coordinate * f64::from(size)) as u32).min(size - 1);
            let index = (texel(uv.y, image.height) * image.width + texel(uv.x, image.width)) as usize * 4;
            let linear = |byte: u8| {
                let value = f64::from(byte) / 255.0;
                if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
            };
            let bytes = &image.rgba8[index..index + 4];
            color *=
                DVec4::new(linear(bytes[0]), linear(bytes[1]), linear(bytes[2]), f64::from(bytes[3]) / 255.0);
        }
        if color.w == 0.0 { [1.0; 3] } else { (color.truncate() * (1.0 - color.w)).to_array() }
    }
}

impl Soup {
    fn new(posed: &Posed) -> Self {
        let of = |i: &Instance| {
            let opaque = (0..i.mesh.triangle_count()).filter(|t| i.material_of(*t).is_opaque());
            let triangles = opaque.map(|t| (i.world_triangle(t), Mask::of(posed, i, t))).collect();
            (i.world_bounds.expanded(i.world_bounds.radius() * 1e-9), triangles)
        };
        let glass = |i: &Instance, triangle: usize| {
            let material = Arc::clone(i.material_of(triangle));
            let uvs = &i.mesh.data().uvs;
            let uv = |vertex: u32| uvs.get(vertex as usize).copied().unwrap_or_default();
            Glass {
                corners: i.world_triangle(triangle),
                uvs: i.mesh.triangle(triangle).map(uv),
                image: material.base_color_texture.map(|texture| Arc::clone(&posed.images[&texture.image])),
                material,
            }
        };
        let panes = posed.instances.iter().flat_map(|i| {
            let through = (0..i.mesh.triangle_count()).filter(|t| !i.material_of(*t).is_opaque());
            through.map(|t| glass(i, t)).collect::<Vec<_>>()
        });
        Self { instances: posed.instances.iter().map(of).collect(), glass: panes.collect() }
    }

    /// The nearest hit along origin + t·direction with t between the limits, and the triangle's corners.
    fn hit(&self, origin: DVec3, direction: DVec3, limits: [f64; 2]) -> Option<(f64, [DVec3; 3])> {
        let mut best: Option<(f64, [DVec3; 3])> = None;
        for (bounds, triangles) in &self.instances {
            if !bounds.intersects_ray(origin, direction, limits[1]) {
                continue;
            }
            for (triangle, mask) in triangles {
                if let Some((t, weights)) = crossing(triangle, origin, direction)
                    && t > limits[0]
                    && t < best.map_or(limits[1], |b| b.0)
                    && mask.as_ref().is_none_or(|mask| mask.is_there(weights))
                {
                    best = Some((t, *triangle));
                }
            }
        }
        best
    }

    /// The factor of `light` at `point` on `surface`, seen from `to_eye`; `None` outside the light's reach.
    fn factor(
        &self,
        light: &PosedLight,
        point: DVec3,
        surface: [DVec3; 3],
        to_eye: DVec3,
    ) -> Option<[f64; 3]> {
        if !light.reaches(point) {
            return None;
        }
        let [a, b, c] = surface;
        let eye_sign = facing_sign(a, b, c, to_eye.extend(0.0));
        if facing_sign(a, b, c, light.position) * eye_sign <= 0 {
            return Some([0.0; 3]);
        }
        let to_light = light.position.truncate() - point * light.position.w;
        let end = if light.position.w == 0.0 { f64::INFINITY } else { 1.0 - 1e-9 };
        let start = if light.position.w == 0.0 { 1e-7 * (1.0 + point.length()) } else { 1e-7 };
        if self.hit(point, to_light, [start, end]).is_some() {
            return Some([0.0; 3]);
        }
        let crossed = self.glass.iter().filter_map(|glass| {
            let (t, weights) = crossing(&glass.corners, point, to_light)?;
            (t > start && t < end).then(|| glass.transmission(weights))
        });
        Some(crossed.fold([1.0; 3], |product, next| [0, 1, 2].map(|i| product[i] * next[i])))
    }

    /// The mean factor over the light's disc: of directions within `half_angle_rad`, or around a point for `radius_m`.
    fn soft_factor(
        &self,
        light: &PosedLight,
        LightSize { radius_m, half_angle_rad }: LightSize,
        point: DVec3,
        surface: [DVec3; 3],
        to_eye: DVec3,
    ) -> Option<[f64; 3]> {
        const SIDE: usize = 48;
        let to_light = light.position.truncate() - point * light.position.w;
        let distance = to_light.length();
        let radius = match light.position.w {
            0.0 => half_angle_rad.tan() * distance,
            _ if distance <= radius_m => 0.0,
            _ => radius_m * distance / (distance * distance - radius_m * radius_m).sqrt(),
        };
        if radius == 0.0 {
            return self.factor(light, point, surface, to_eye);
        }
        light.reaches(point).then_some(())?;
        let (u, v) = to_light.normalize().any_orthonormal_pair();
        let mut sum = [0.0; 3];
        for i in 0..SIDE * SIDE {
            let within = |k: usize| (k as f64 + 0.5) / SIDE as f64;
            let (r, angle) = (radius * within(i % SIDE).sqrt(), within(i / SIDE) * std::f64::consts::TAU);
            let moved = (u * angle.cos() + v * angle.sin()) * r;
            let sample = PosedLight { position: light.position + moved.extend(0.0), ..light.clone() };
            let factor = self.factor(&sample, point, surface, to_eye).unwrap_or_default();
            sum = [0, 1, 2].map(|i| sum[i] + factor[i]);
        }
        Some(sum.map(|sum| sum / (SIDE * SIDE) as f64))
    }
}

/// Where the ray meets the triangle: its parameter, and the weights of the second and third corner.
fn crossing([a, b, c]: &[DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, [f64; 2])> {
    let (ab, ac) = (*b - *a, *c - *a);
    let normal = ab.cross(ac);
    let det = -direction.dot(normal);
    let from_a = origin - *a;
    let t = from_a.dot(normal) / det;
    let moment = from_a.cross(direction);
    let (u, v) = (ac.dot(moment) / det, -ab.dot(moment) / det);
    // Where det is 0 these are NaN or infinite, and every comparison says no.
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some((t, [u, v]))
}

fn primary_ray(camera: &PosedCamera, size_px: [u32; 2], ndc: [f64; 2]) -> (DVec3, DVec3) {
    let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
    let (origin, direction) = camera.projection.view_ray(ndc[0], ndc[1], aspect);
    (camera.world_from_view.transform_point3(origin), camera.world_from_view.transform_vector3(direction))
}

/// Normalised device coordinates of a point; `None` before the near plane.
fn project(camera: &PosedCamera, size_px: [u32; 2], point: DVec3) -> Option<[f64; 2]> {
    let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
    let clip = camera.projection.clip_from_view(aspect)
        * camera.world_from_view.inverse().transform_point3(point).extend(1.0);
    (clip.w > 0.0 && clip.z <= clip.w).then(|| [clip.x / clip.w, clip.y / clip.w])
}

/// Dark and lit samples for each light over a coarse grid of the frame.
fn count_samples(case: &Case, posed: &Posed, soup: &Soup) -> Vec<[usize; 2]> {
    let triangles: usize = soup.instances.iter().map(|(_, t)| t.len()).sum();
    let side = if triangles > 20_000 { 12 } else { 40 };
    let mut counts = vec![[0; 2]; posed.lights.len()];
    for i in 0..side * side {
        let to_ndc = |k: usize| (k as f64 + 0.5) / side as f64 * 2.0 - 1.0;
        let (origin, direction) =
            primary_ray(&case.camera, case.size_px, [to_ndc(i % side), to_ndc(i / side)]);
        let Some((t, surface)) =
            soup.hit(origin, direction, [case.camera.projection.near_m(), case.camera.projection.far_m()])
        else {
            continue;
        };
        for (light, count) in posed.lights.iter().zip(&mut counts) {
            if let Some(factor) = soup.factor(light, origin + direction * t, surface, -direction) {
                count[usize::from(factor == [1.0; 3])] += 1;
            }
        }
    }
    counts
}

fn check(case: &Case) -> Vec<String> {
    let mut wrong = Vec::new();
    let posed = case.scene.pose().expect("every case poses");
    assert!(!posed.lights.is_empty(), "{}: no light", case.name());
    assert_eq!(posed.shadow_nodes.len(), 1, "{}: one shadow node", case.name());
    assert_eq!(posed.shadow_nodes[0].shadow.technique, "ShadowVolumeHard");
    assert!(case.camera.projection.is_valid(), "{}", case.name());
    let frustum = case.camera.frustum(case.size_px);
    let seen = posed.instances.iter().any(|i| frustum.may_see(&i.world_bounds));
    assert!(seen || case.name() == "sky/empty", "{}: the camera sees nothing", case.name());

    let soup = Soup::new(&posed);
    for probe in &case.probes {
        let point = probe.p_in_world;
        let light = posed.lights.iter().find(|l| l.name == probe.light).expect("the probe's light exists");
        let Some(ndc) =
            project(&case.camera, case.size_px, point).filter(|n| n.iter().all(|c| c.abs() < 1.0))
        else {
            wrong.push(format!("{}: {point} is outside the frame", case.name()));
            continue;
        };
        let (origin, direction) = primary_ray(&case.camera, case.size_px, ndc);
        let hit = soup.hit(origin, direction, [case.camera.projection.near_m(), f64::INFINITY]);
        let distance = (point - origin).length();
        match hit {
            Some((t, surface)) if (origin + direction * t - point).length() < 1e-4 * distance => {
                let size = LightSize::of(&case.options);
                let factor =
                    soup.soft_factor(light, size, point, surface, -direction).unwrap_or([f64::NAN; 3]);
                // A disc is sampled.
                let within = if size == LightSize::NONE { 1e-4 } else { 0.02 };
                let expected = probe.factor.map(f64::from);
                if !(0..3).all(|channel| (factor[channel] - expected[channel]).abs() <= within) {
                    wrong.push(format!("{}: {point} is {factor:?}, not {expected:?}", case.name()));
                }
            }
            Some((t, _)) => {
                wrong.push(format!("{}: {point} hidden by {}", case.name(), origin + direction * t));
            }
            None => wrong.push(format!("{}: {point} is on no surface", case.name())),
        }
    }
    for (light, [dark, lit]) in posed.lights.iter().zip(count_samples(case, &posed, &soup)) {
        let fits = match case.expect {
            Expect::Shadow => dark > 0 && lit > 0,
            Expect::NoShadow => dark == 0,
            Expect::Matches | Expect::Refused { .. } => true,
        };
        if !fits {
            wrong.push(format!("{}: {} has {dark} dark and {lit} lit samples", case.name(), light.name));
        }
    }
    wrong
}

#[test]
fn the_table_lists_every_id_once() {
    let listed: Vec<_> = cases::all().iter().map(|entry| entry.id).collect();
    assert_eq!(listed, IDS);
    let unique: std::collections::HashSet<_> = listed.iter().collect();
    assert_eq!(unique.len(), IDS.len());
}

#[test]
fn every_row_says_what_it_needs_or_builds() {
    for entry in cases::all() {
        assert!(!entry.what_breaks.is_empty() && !entry.right_answer.is_empty(), "{}", entry.id);
        assert_eq!(entry.build().is_empty(), !entry.needs.is_empty(), "{}", entry.id);
    }
}

#[test]
fn variants_have_names_of_their_own() {
    let mut taken = std::collections::HashSet::new();
    for case in cases::all().iter().flat_map(|entry| entry.build()) {
        assert!(taken.insert(case.name()), "{} is there twice", case.name());
    }
}

#[test]
fn every_scene_shows_what_it_is_about() {
    let wrong: Vec<_> =
        cases::all().iter().flat_map(|entry| entry.build()).flat_map(|case| check(&case)).collect();
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn every_step_of_every_sweep_shows_what_it_is_about() {
    let sweeps = sweeps::all();
    let unique: std::collections::HashSet<_> = sweeps.iter().map(|sweep| sweep.id).collect();
    assert_eq!(unique.len(), sweeps.len());
    let mut wrong = Vec::new();
    for sweep in &sweeps {
        let steps = sweep.steps();
        let rising = steps.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let falling = steps.windows(2).all(|pair| pair[0].0 > pair[1].0);
        assert!(rising || falling, "{}: the steps are in no order", sweep.id);
        assert!(sweep.axis == Axis::Linear || steps.iter().all(|(value, _)| *value > 0.0), "{}", sweep.id);
        assert!(!sweep.parameter.is_empty() && !sweep.what_breaks.is_empty(), "{}", sweep.id);
        wrong.extend(steps.iter().flat_map(|(_, case)| check(case)));
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// How many of the near rectangle's corners lie in the shadow of the first light.
fn dark_near_corners(case: &Case) -> usize {
    let posed = case.scene.pose().expect("every case poses");
    let soup = Soup::new(&posed);
    let light = posed.lights[0].position.truncate();
    let corners = case.camera.frustum(case.size_px).near_corners;
    corners.iter().filter(|corner| soup.hit(**corner, light - **corner, [0.0, 1.0]).is_some()).count()
}

#[test]
fn near_rectangles_are_cut_where_their_cases_say() {
    for case in cases::all().iter().flat_map(|entry| entry.build()) {
        let expected = match (case.id, case.variant.as_str()) {
            ("near-clips-side", _) => 2..=2,
            ("near-clips-corner", variant) if !variant.ends_with("edge") => 1..=1,
            ("near-clips-corner", _) => 1..=3,
            ("eye-in-shadow", _) => 4..=4,
            _ => continue,
        };
        assert!(
            expected.contains(&dark_near_corners(&case)),
            "{}: {}",
            case.name(),
            dark_near_corners(&case)
        );
    }
}
