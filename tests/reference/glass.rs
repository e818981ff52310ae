//! The reference for transparent casters: hand-made answers, edges that are met exactly, textures and vertex colours.

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use shadowgraph::cases::{self, Case, sweeps};
use shadowgraph::measure::{LightQuery, LightSize, Reference, ReferenceImage};
use shadowgraph_engine::geometry::shapes::{icosphere, quad};
use shadowgraph_engine::geometry::{Mesh, MeshData};
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::scene::{
    AlphaMode, Camera, CameraSnapshot, Image, Light, Material, Scene, SceneSnapshot, TextureRef,
};

/// Everything casts, glass in its colours.
fn query(snapshot: &SceneSnapshot) -> LightQuery {
    let all: Vec<usize> = (0..snapshot.instances.len()).collect();
    LightQuery { casters: all.clone(), transparent: all, ..LightQuery::default() }
}

fn render(snapshot: &SceneSnapshot, camera: &CameraSnapshot, size_px: [u32; 2]) -> ReferenceImage {
    Reference::new(snapshot).render(camera, size_px, &[query(snapshot)], &|_, _| {})
}

fn at(image: &ReferenceImage, pixel: usize) -> Vec3 {
    let factor = &image.lights[0].factor;
    if factor.len() == image.hits.len() {
        Vec3::splat(factor[pixel])
    } else {
        Vec3::from_slice(&factor[pixel * 3..pixel * 3 + 3])
    }
}

/// The probes that the reference gets wrong.
fn wrong_probes(case: &Case) -> Vec<String> {
    let snapshot = case.scene.snapshot().unwrap();
    let image = render(&snapshot, &case.camera, case.size_px);
    let [width, height] = case.size_px.map(f64::from);
    let clip_from_world = case.camera.projection.clip_from_view(width / height)
        * glam::DMat4::from(case.camera.world_from_view.inverse());
    let check = |probe: &cases::Probe| {
        let ndc = clip_from_world.project_point3(probe.p_in_world);
        let (x, y) = ((ndc.x + 1.0) / 2.0 * width, (1.0 - ndc.y) / 2.0 * height);
        let pixel = y as usize * case.size_px[0] as usize + x as usize;
        let (factor, expected) = (at(&image, pixel), Vec3::from(probe.factor));
        let right = (factor - expected).abs().max_element() < 1e-5 && !image.lights[0].ambiguous[pixel];
        (!right).then(|| format!("{}: {} is {factor}, not {expected}", case.name(), probe.p_in_world))
    };
    case.probes.iter().filter_map(check).collect()
}

#[test]
fn hand_made_answers_are_its_own() {
    let transparent = |case: &Case| {
        let snapshot = case.scene.snapshot().unwrap();
        snapshot.instances.iter().flat_map(|i| &i.materials).any(|material| material.is_transparent())
    };
    let cases = cases::all().into_iter().flat_map(|entry| entry.build(&shadowgraph::CAST));
    let steps =
        sweeps::all().into_iter().flat_map(|sweep| sweep.steps(&shadowgraph::CAST)).map(|(_, case)| case);
    // Points of lights with a size are judged elsewhere: here every light is its centre.
    let is_hard = |case: &Case| LightSize::of(&case.options) == LightSize::NONE;
    let cases: Vec<Case> = cases.chain(steps).filter(transparent).filter(is_hard).collect();
    let probes: usize = cases.iter().map(|case| case.probes.len()).sum();
    assert!(cases.len() > 30 && probes > 90, "{} cases, {probes} probes", cases.len());
    let wrong: Vec<String> = cases.iter().flat_map(wrong_probes).collect();
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

fn blended(color: Vec4) -> Material {
    Material { base_color: color, alpha_mode: AlphaMode::Blend, ..Material::default() }
}

/// A floor seen from straight above, pixel by pixel of 1/16 m, under a sun that stands there too.
struct Level {
    scene: Scene,
    camera: CameraSnapshot,
}

const SIZE: [u32; 2] = [64, 64];

impl Level {
    fn new() -> Self {
        let mut scene = Scene::new();
        scene.add_mesh(Mesh::new(level(-1.0, 4.0)).unwrap(), Material::default(), DAffine3::IDENTITY);
        scene.add_light(Light::directional("sun", 1.0), DVec3::ZERO, DVec3::NEG_Y);
        let projection = Projection::Orthographic { half_height_m: 2.0, near_m: 0.0, far_m: 20.0 };
        let camera = Camera { name: "eye".into(), projection };
        let camera = CameraSnapshot::looking(camera, DVec3::Y * 10.0, DVec3::ZERO);
        Self { scene, camera }
    }

    fn with(mut self, data: MeshData, material: Material) -> Self {
        self.scene.add_mesh(Mesh::new(data).unwrap(), material, DAffine3::IDENTITY);
        self
    }

    fn render(&self) -> ReferenceImage {
        render(&self.scene.snapshot().unwrap(), &self.camera, SIZE)
    }
}

/// A level square of two triangles, `half` to each side.
fn level(y: f32, half: f32) -> MeshData {
    let corner = |x: f32, z: f32| Vec3::new(x * half, y, z * half);
    quad([corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)])
}

/// The factors met, with how many pixels have each; those in the band are left out.
fn met(image: &ReferenceImage) -> Vec<([f32; 3], usize)> {
    let mut met: Vec<([f32; 3], usize)> = Vec::new();
    for pixel in (0..image.hits.len()).filter(|pixel| !image.lights[0].ambiguous[*pixel]) {
        let factor = at(image, pixel).to_array();
        match met.iter_mut().find(|(known, _)| *known == factor) {
            Some((_, count)) => *count += 1,
            None => met.push((factor, 1)),
        }
    }
    met.sort_by(|a, b| b.0[0].total_cmp(&a.0[0]));
    met
}

#[test]
fn a_pane_counts_once_along_its_diagonal() {
    // Its diagonal passes through the centres of 32 pixels; the light's rays are parallel to the eye's.
    let image = Level::new().with(level(0.0, 1.0), blended(Vec4::new(1.0, 0.5, 0.25, 0.5))).render();
    // 32 × 32 pixels, no band: the edges lie between pixel centres.
    assert_eq!(met(&image), [([1.0; 3], 3072), ([0.5, 0.25, 0.125], 1024)]);
    assert!(!image.lights[0].ambiguous.contains(&true));
    // A ball has corners of five and six triangles, one of them in the light's very axis.
    let ball = icosphere(1.0, 2).moved(Vec3::new(0.03125, 1.0, 0.03125));
    let image = Level::new().with(ball, blended(Vec4::new(1.0, 0.5, 0.25, 0.5))).render();
    let factors: Vec<[f32; 3]> = met(&image).into_iter().map(|(factor, _)| factor).collect();
    assert_eq!(factors, [[1.0; 3], [0.25, 0.0625, 0.015_625]]);
}

#[test]
fn only_what_is_claimed_as_transparent_colours() {
    let level = Level::new().with(level(0.0, 1.0), blended(Vec4::new(1.0, 0.5, 0.25, 0.5)));
    let snapshot = level.scene.snapshot().unwrap();
    let opaque_only = LightQuery { transparent: vec![0], ..query(&snapshot) };
    let image = Reference::new(&snapshot).render(&level.camera, SIZE, &[opaque_only], &|_, _| {});
    // One channel, since nothing transparent casts.
    assert!(image.lights[0].factor.iter().all(|factor| *factor == 1.0));
    assert_eq!(image.lights[0].factor.len(), 4096);
}

#[test]
fn every_kind_of_material_lets_its_share_pass() {
    let share = |material: Material| {
        let met = met(&Level::new().with(level(0.0, 1.0), material).render());
        assert_eq!(met[0], ([1.0; 3], 3072));
        met.get(1).map_or([1.0; 3], |(factor, count)| {
            assert_eq!(*count, 1024);
            *factor
        })
    };
    let color = Vec4::new(1.0, 0.5, 0.25, 0.5);
    let opaque = Material { base_color: color, transmission: 0.5, ..Material::default() };
    assert_eq!(share(opaque.clone()), [0.5, 0.25, 0.125]);
    assert_eq!(share(Material { alpha_mode: AlphaMode::Blend, ..opaque.clone() }), [0.75, 0.375, 0.1875]);
    let mask = AlphaMode::Mask { cutoff: 0.5 };
    assert_eq!(share(Material { alpha_mode: mask, ..opaque.clone() }), [0.5, 0.25, 0.125]);
    assert_eq!(share(blended(color.with_w(1.0))), [0.0; 3]);
    // No surface, or none that casts. (`met` sees one factor only.)
    let lit = |material: Material| met(&Level::new().with(level(0.0, 1.0), material).render());
    assert_eq!(lit(Material { alpha_mode: AlphaMode::Mask { cutoff: 0.75 }, ..opaque }), [([1.0; 3], 4096)]);
    assert_eq!(lit(blended(color.with_w(0.0))), [([1.0; 3], 4096)]);
    assert_eq!(lit(Material { unlit: true, ..blended(color) }), [([1.0; 3], 4096)]);
}

#[test]
fn colours_are_looked_up_where_light_crosses() {
    // Vertex colours run from black to white along x; a texture of two texels blends along z.
    let mut data = level(0.0, 1.0);
    data.colors = data.positions.iter().map(|p| Vec4::new(p.x * 0.5 + 0.5, 1.0, 1.0, 1.0)).collect();
    data.uvs = data.positions.iter().map(|p| Vec2::new(0.5, p.z * 0.5 + 0.5)).collect();
    let mut level = Level::new();
    let rgba8 = vec![255, 0, 255, 0, 255, 255, 255, 255];
    let image = Image { name: "two".into(), width: 1, height: 2, rgba8 };
    let mut texture = TextureRef::new(level.scene.add_image(image.into()));
    texture.wrap = [shadowgraph_engine::scene::Wrap::Clamp; 2];
    let material = Material { base_color_texture: Some(texture), ..blended(Vec4::ONE) };
    let level = level.with(data, material);
    let image = level.render();
    let mut compared = 0;
    for pixel in 0..image.hits.len() {
        let (x, z) =
            ((pixel % 64) as f32 / 16.0 - 2.0 + 1.0 / 32.0, (pixel / 64) as f32 / 16.0 - 2.0 + 1.0 / 32.0);
        let mut expected = Vec3::ONE;
        let texel = (z + 0.5).clamp(0.0, 1.0);
        if x.abs() < 1.0 && z.abs() < 1.0 && texel > 0.0 {
            expected = Vec3::new(x * 0.5 + 0.5, texel, 1.0) * (1.0 - texel);
            compared += 1;
        }
        let factor = at(&image, pixel);
        assert!((factor - expected).abs().max_element() < 1e-6, "({x}, {z}): {factor}, not {expected}");
        // A change from pixel to pixel is no ambiguity; the step where alpha becomes 0 may be.
        let ambiguous = image.lights[0].ambiguous[pixel];
        assert!(!ambiguous || (z + 0.5).abs() < 0.1, "({x}, {z}) is ambiguous");
    }
    assert!(compared > 700, "{compared}");
}
