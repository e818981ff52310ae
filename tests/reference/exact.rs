//! The reference against closed forms: shadows whose outline is known by hand.

use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4, Vec3};
use shadowgraph::measure::{Hit, LightQuery, Measured, Reference, ReferenceImage, compare};
use shadowgraph_engine::geometry::{Mesh, MeshData};
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::scene::{
    AlphaMode, Camera, CameraSnapshot, Light, Material, Scene, SceneSnapshot, placed,
};

const SIZE: [u32; 2] = [160, 120];

fn mesh(name: &str, positions: &[[f32; 3]], indices: &[u32]) -> Mesh {
    let positions = positions.iter().copied().map(Vec3::from).collect();
    Mesh::new(MeshData { name: name.into(), positions, indices: indices.to_vec(), ..MeshData::default() })
        .expect("the mesh is valid")
}

/// A square in the plane y = `y`, facing up.
fn square(name: &str, y: f32, half: f32) -> Mesh {
    let corners = [[-half, y, -half], [-half, y, half], [half, y, half], [half, y, -half]];
    mesh(name, &corners, &[0, 1, 2, 0, 2, 3])
}

/// The box from −1 to 1, facing outwards.
fn cube() -> Mesh {
    let corners: Vec<[f32; 3]> =
        (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -1.0 } else { 1.0 })).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    mesh("box", &corners, &quads.map(|[a, b, c, d]| [a, b, c, a, c, d]).concat())
}

/// A sphere of radius 1 plus `bump` along each normal, of 4·`rings`² triangles.
fn sphere(rings: u32, bump: impl Fn(DVec3) -> f64) -> Mesh {
    let around = rings * 2;
    let mut positions = Vec::new();
    for ring in 0..=rings {
        for step in 0..around {
            let (v, u) = (f64::from(ring) / f64::from(rings), f64::from(step) / f64::from(around));
            let (polar, azimuth) = (v * std::f64::consts::PI, u * std::f64::consts::TAU);
            let normal = DVec3::new(polar.sin() * azimuth.cos(), polar.cos(), -polar.sin() * azimuth.sin());
            positions.push((normal * (1.0 + bump(normal))).as_vec3().to_array());
        }
    }
    let mut indices = Vec::new();
    for ring in 0..rings {
        for step in 0..around {
            let at = |r: u32, s: u32| (ring + r) * around + (step + s) % around;
            indices.extend([at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)]);
        }
    }
    mesh("sphere", &positions, &indices)
}

fn matt() -> Material {
    Material::default()
}

fn camera() -> CameraSnapshot {
    CameraSnapshot::looking(Camera::perspective("eye", 0.8), DVec3::new(3.0, 6.0, 7.0), DVec3::ZERO)
}

/// A floor in y = 0, then `casters`, under `light` at `position` and shining at the origin.
fn scene(casters: Vec<(Mesh, Material, DAffine3)>, light: Light, position: DVec3) -> SceneSnapshot {
    let mut scene = Scene::new();
    scene.add_mesh(square("floor", 0.0, 12.0), matt(), DAffine3::IDENTITY);
    for (mesh, material, place) in casters {
        scene.add_mesh(mesh, material, place);
    }
    scene.add_light(light, position, DVec3::ZERO);
    scene.snapshot().expect("the scene is valid")
}

/// Every instance casts.
fn render(snapshot: &SceneSnapshot, camera: &CameraSnapshot) -> ReferenceImage {
    let query = LightQuery { casters: (0..snapshot.instances.len()).collect(), ..LightQuery::default() };
    Reference::new(snapshot).render(camera, SIZE, &[query], &|_, _| {})
}

/// Where the ray through the pixel's centre meets the floor.
fn floor_point(camera: &CameraSnapshot, pixel: usize) -> DVec3 {
    let (origin, direction) = pixel_ray(camera, pixel);
    origin - direction * (origin.y / direction.y)
}

/// The ray through the pixel's centre.
fn pixel_ray(camera: &CameraSnapshot, pixel: usize) -> (DVec3, DVec3) {
    let (width, height) = (f64::from(SIZE[0]), f64::from(SIZE[1]));
    let [x, y] = [pixel % SIZE[0] as usize, pixel / SIZE[0] as usize].map(|n| n as f64 + 0.5);
    let (ndc_x, ndc_y) = (2.0 * x / width - 1.0, 1.0 - 2.0 * y / height);
    let (origin, direction) = camera.projection.view_ray(ndc_x, ndc_y, width / height);
    let origin = camera.world_from_view.transform_point3(origin);
    (origin, camera.world_from_view.transform_vector3(direction))
}

/// Compares every floor pixel outside the band with `is_dark`, which may decline, and checks that the band is narrow.
/// Returns the number of dark floor pixels.
fn check_floor(snapshot: &SceneSnapshot, is_dark: impl Fn(DVec3) -> Option<bool>) -> usize {
    let camera = camera();
    let image = render(snapshot, &camera);
    let light = &image.lights[0];
    let (mut dark, mut lit, mut band) = (0, 0, 0);
    for (pixel, hit) in image.hits.iter().enumerate() {
        assert_eq!(light.factor[pixel].is_nan(), hit.is_none());
        if hit.is_none_or(|hit| hit.instance != 0) {
            continue;
        }
        band += usize::from(light.ambiguous[pixel]);
        let point = floor_point(&camera, pixel);
        if let Some(expected) = is_dark(point).filter(|_| !light.ambiguous[pixel]) {
            assert_eq!(light.factor[pixel] == 0.0, expected, "pixel {pixel} at {point}");
            if expected { dark += 1 } else { lit += 1 }
        }
    }
    assert!(lit > 100, "{lit} lit pixels");
    assert!(band * 10 < dark.max(100), "{band} pixels in the band, {dark} dark");
    dark
}

fn to_light(light: DVec4, point: DVec3) -> DVec3 {
    light.truncate() - point * light.w
}

/// A point light and a directional one; the light, where it stands, and the same homogeneous.
fn two_lights() -> [(Light, DVec3, DVec4); 2] {
    let position = DVec3::new(-1.5, 6.0, 1.0);
    [
        (Light::point("lamp", 100.0), position, DVec4::from((position, 1.0))),
        (Light::directional("sun", 1.0), position, DVec4::from((position.normalize(), 0.0))),
    ]
}

fn lid() -> (Mesh, Material, DAffine3) {
    (square("lid", 0.0, 0.75), matt(), DAffine3::from_translation(DVec3::new(0.2, 1.5, 0.1)))
}

#[test]
fn a_square_casts_its_projection() {
    for (light, position, at) in two_lights() {
        let snapshot = scene(vec![lid()], light, position);
        let dark = check_floor(&snapshot, |p| {
            let d = to_light(at, p);
            let crossing = p + d * (1.5 / d.y);
            Some((crossing.x - 0.2).abs() <= 0.75 && (crossing.z - 0.1).abs() <= 0.75)
        });
        assert!(dark > 200, "{dark}");
    }
}

#[test]
fn a_box_casts_what_its_slabs_cut() {
    for (light, position, at) in two_lights() {
        let (size, middle) = (DVec3::new(0.5, 0.75, 0.25), DVec3::new(0.1, 1.5, 0.0));
        let place = placed(middle, DQuat::from_rotation_y(-0.4), size);
        let snapshot = scene(vec![(cube(), matt(), place)], light, position);
        let local = place.inverse();
        let dark = check_floor(&snapshot, |p| {
            let (from, d) = (local.transform_point3(p), local.transform_vector3(to_light(at, p)));
            let (t0, t1) = ((-1.0 - from) / d, (1.0 - from) / d);
            Some(t0.min(t1).max_element() <= t0.max(t1).min_element())
        });
        assert!(dark > 100, "{dark}");
        // On the box itself, exactly the faces turned to the light are lit: it is convex.
        let image = render(&snapshot, &camera());
        let mut seen = [0, 0];
        for (pixel, hit) in image.hits.iter().enumerate() {
            let Some(hit) = hit.filter(|hit| hit.instance == 1) else { continue };
            let [a, b, c] = snapshot.instances[1].world_triangle(hit.triangle as usize);
            let lit = (b - a).cross(c - a).dot(to_light(at, a)) > 0.0;
            if !image.lights[0].ambiguous[pixel] {
                assert_eq!(image.lights[0].factor[pixel] == 1.0, lit, "pixel {pixel}, {hit:?}");
                seen[usize::from(lit)] += 1;
            }
        }
        assert!(seen[0] > 20 && seen[1] > 20, "{seen:?}");
    }
}

#[test]
fn a_sphere_casts_an_ellipse() {
    for (light, position, at) in two_lights() {
        let center = DVec3::new(0.0, 1.5, 0.0);
        let ball = (sphere(128, |_| 0.0), matt(), DAffine3::from_translation(center));
        let snapshot = scene(vec![ball], light, position);
        // The facets lie between the sphere and its image shrunk by the sagitta of half a step each way.
        let inner = (std::f64::consts::PI / 256.0).cos().powi(2) - 1e-6;
        let dark = check_floor(&snapshot, |p| {
            let distance = to_light(at, p).normalize().cross(center - p).length();
            (!(inner..1.0 + 1e-6).contains(&distance)).then_some(distance < inner)
        });
        assert!(dark > 300, "{dark}");
    }
}

#[test]
fn what_lies_in_the_receivers_plane_casts_nothing() {
    for (light, position, _) in two_lights() {
        let snapshot = scene(vec![(square("rug", 0.0, 1.0), matt(), DAffine3::IDENTITY)], light, position);
        assert_eq!(check_floor(&snapshot, |_| Some(false)), 0);
    }
    // A floor of many triangles that a rotation bends by ulps does not shade itself, far from the origin either.
    let (n, mut corners, mut indices) = (40_u32, Vec::new(), Vec::new());
    for (x, z) in (0..=n).flat_map(|x| (0..=n).map(move |z| (x, z))) {
        corners.push([x as f32 / 8.0 - 2.5, 0.0, z as f32 / 8.0 - 2.5]);
    }
    for (x, z) in (0..n).flat_map(|x| (0..n).map(move |z| (x, z))) {
        let [a, b] = [x * (n + 1) + z, (x + 1) * (n + 1) + z];
        indices.extend([a, a + 1, b + 1, a, b + 1, b]);
    }
    for offset in [DVec3::ZERO, DVec3::new(1000.0, -300.0, 77.0)] {
        let turn = DQuat::from_rotation_z(0.3) * DQuat::from_rotation_y(1.1);
        let mut scene = Scene::new();
        scene.add_mesh(mesh("floor", &corners, &indices), matt(), placed(offset, turn, DVec3::ONE));
        let low = offset + turn * DVec3::new(3.0, 0.01, 1.0);
        scene.add_light(Light::point("low", 1.0), low, offset);
        let eye = offset + DVec3::new(0.0, 6.0, 3.0);
        let camera = CameraSnapshot::looking(Camera::perspective("eye", 0.8), eye, offset);
        let image = render(&scene.snapshot().unwrap(), &camera);
        assert!(image.hits.iter().flatten().count() > 1000);
        assert!(image.lights[0].factor.iter().all(|f| f.is_nan() || *f == 1.0));
        // Only at the rim, where the floor's own shadow begins under it, may depth or the snap of its edge make a difference.
        for (pixel, _) in image.lights[0].ambiguous.iter().enumerate().filter(|(_, is)| **is) {
            let local = placed(offset, turn, DVec3::ONE).inverse();
            let from = local.transform_point3(camera.world_from_view.translation);
            let (_, direction) = pixel_ray(&camera, pixel);
            let direction = local.transform_vector3(direction);
            let p = from - direction * (from.y / direction.y);
            assert!(p.x.abs().max(p.z.abs()) > 2.49, "{pixel}: {p}");
        }
    }
}

#[test]
fn a_receiver_turned_away_is_dark_and_one_in_the_lights_plane_is_not() {
    let count = |light: DVec3, half: f32, middle: DVec3| {
        let caster = (square("caster", 0.0, half), matt(), DAffine3::from_translation(middle));
        let image = render(&scene(vec![caster], Light::point("lamp", 1.0), light), &camera());
        let floor = |f: f32| {
            let pixels = image.hits.iter().zip(&image.lights[0].factor);
            pixels.filter(|(hit, factor)| hit.is_some_and(|h| h.instance == 0) && **factor == f).count()
        };
        (floor(0.0), floor(1.0))
    };
    let aside = DVec3::new(-90.0, 1.0, 0.0);
    let (dark, lit) = count(DVec3::new(0.0, -2.0, 0.0), 0.1, aside);
    assert!(dark > 10_000 && lit == 0, "{dark} dark, {lit} lit");
    let (dark, lit) = count(DVec3::new(40.0, 0.0, 0.0), 0.1, aside);
    assert!(dark == 0 && lit > 10_000, "{dark} dark, {lit} lit");
    // The light lies in the caster's plane: edge-on, it casts nothing.
    let (dark, lit) = count(DVec3::new(5.0, 1.0, 0.0), 1.0, DVec3::Y);
    assert!(dark == 0 && lit > 10_000, "{dark} dark, {lit} lit");
}

#[test]
fn duplicates_change_nothing() {
    let place = lid().2;
    let reversed = || {
        let corners = [[-0.75, 0.0, -0.75], [-0.75, 0.0, 0.75], [0.75, 0.0, 0.75], [0.75, 0.0, -0.75]];
        (mesh("reversed", &corners, &[2, 1, 0, 3, 2, 0]), matt(), place)
    };
    for (light, position, _) in two_lights() {
        let floor = (square("floor again", 0.0, 12.0), matt(), DAffine3::IDENTITY);
        let once = render(&scene(vec![lid()], light.clone(), position), &camera());
        let thrice = render(&scene(vec![lid(), lid(), reversed(), floor], light, position), &camera());
        assert_eq!(once.hits, thrice.hits, "ties go to the first drawn");
        let bits = |image: &ReferenceImage| -> Vec<u32> {
            image.lights[0].factor.iter().map(|f| f.to_bits()).collect()
        };
        assert_eq!(bits(&once), bits(&thrice));
        assert_eq!(once.lights[0].ambiguous, thrice.lights[0].ambiguous);
    }
}

#[test]
fn of_coincident_surfaces_the_one_that_is_seen_is_judged() {
    // A second floor in the plane of the first, its squares cut along the other diagonal.
    let corners = [[-12.0, 0.0, -12.0], [-12.0, 0.0, 12.0], [12.0, 0.0, 12.0], [12.0, 0.0, -12.0]];
    let other = || (mesh("other", &corners, &[1, 2, 3, 1, 3, 0]), matt(), DAffine3::IDENTITY);
    for (light, position, _) in two_lights() {
        let mut snapshot = scene(vec![lid(), other()], light.clone(), position);
        let both = render(&snapshot, &camera());
        let once = render(&scene(vec![lid()], light, position), &camera());
        let floor =
            |image: &ReferenceImage, pixel: usize| image.hits[pixel].is_some_and(|hit| hit.instance == 0);
        let dark =
            (0..both.hits.len()).filter(|pixel| floor(&both, *pixel) && both.lights[0].factor[*pixel] == 0.0);
        let dark: Vec<usize> = dark.collect();
        assert!(dark.len() > 200);
        // Each pixel may show either, and both say what the floor alone says, in the band and out of it.
        assert_eq!(both.lights[0].ambiguous, once.lights[0].ambiguous);
        let ids = |image: &ReferenceImage| -> Vec<[u32; 2]> {
            let other = |pixel: usize| {
                let tie = image.ties.iter().find(|(at, hit)| *at as usize == pixel && hit.instance == 2);
                tie.map(|(_, hit)| *hit)
            };
            let seen = image.hits.iter().enumerate().map(|(pixel, hit)| other(pixel).or(*hit));
            seen.map(|hit| hit.map_or([u32::MAX; 2], |hit| [hit.instance, hit.triangle])).collect()
        };
        let errors = |image: &ReferenceImage, factor: &dyn Fn(usize) -> f32| {
            let light = image.lights[0].name.clone();
            let factor = (0..image.hits.len()).map(factor).collect();
            let measured = Measured { size_px: SIZE, ids: ids(image), lights: vec![(light, factor)] };
            compare(&measured, image).expect("the pictures belong together").remove(0)
        };
        let exact = errors(&both, &|pixel| both.lights[0].factor[pixel]);
        assert!(exact.passes() && exact.different_triangle == 0, "{exact:?}");
        let off = errors(&both, &|pixel| if pixel == dark[40] { 1.0 } else { both.lights[0].factor[pixel] });
        assert!(off.wrong == 1 && !off.passes(), "{off:?}");
        // No shadow falls on the other: what is right depends on which of them is seen.
        snapshot.instances[2].shadow.receives = false;
        let both = render(&snapshot, &camera());
        let on_first = errors(&both, &|pixel| both.lights[0].factor[pixel]);
        assert!(on_first.wrong >= dark.len() && on_first.fails(), "{on_first:?}");
        let on_other =
            errors(&both, &|pixel| if floor(&both, pixel) { 1.0 } else { both.lights[0].factor[pixel] });
        assert!(on_other.passes() && on_other.compared == exact.compared, "{on_other:?}");
    }
}

#[test]
fn materials_and_flags_are_obeyed() {
    let above = DVec3::new(0.0, 6.0, 0.0);
    let lamp = || Light::point("lamp", 1.0);
    let is_lit = |image: &ReferenceImage| image.lights[0].factor.iter().all(|f| f.is_nan() || *f == 1.0);
    let shadows = |material: Material| {
        let (mesh, _, place) = lid();
        let image = render(&scene(vec![(mesh, material, place)], lamp(), above), &camera());
        (!is_lit(&image), image.hits.contains(&Some(Hit { instance: 1, triangle: 0 })))
    };
    assert_eq!(shadows(matt()), (true, true));
    assert_eq!(shadows(Material { unlit: true, ..matt() }), (false, true));
    assert_eq!(shadows(Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..matt() }), (true, true));
    assert_eq!(shadows(Material { alpha_mode: AlphaMode::Blend, ..matt() }), (false, false));
    assert_eq!(shadows(Material { transmission: 0.5, ..matt() }), (false, false));

    let mut snapshot = scene(vec![lid()], lamp(), above);
    let nobody = [LightQuery { casters: vec![], ..LightQuery::default() }];
    assert!(is_lit(&Reference::new(&snapshot).render(&camera(), SIZE, &nobody, &|_, _| {})));
    snapshot.instances[0].shadow.receives = false;
    assert!(is_lit(&render(&snapshot, &camera())));
}

#[test]
fn range_and_cone_bound_the_comparison() {
    let above = DVec3::new(0.0, 6.0, 0.0);
    for light in [Light::point("lamp", 1.0).with_range(6.5), Light::spot("cone", 1.0, 0.3)] {
        let snapshot = scene(vec![], light, above);
        let image = render(&snapshot, &camera());
        for (pixel, hit) in image.hits.iter().enumerate() {
            let reached = snapshot.lights[0].reaches(floor_point(&camera(), pixel));
            assert_eq!(image.lights[0].compared[pixel], hit.is_some() && reached);
            assert!(hit.is_none() || image.lights[0].factor[pixel] == 1.0);
        }
        assert!(image.lights[0].compared.contains(&true) && image.lights[0].compared.contains(&false));
    }
}

#[test]
fn back_faces_and_clip_planes_are_respected() {
    let seen = |place: DAffine3, projection: Projection| {
        let mut scene = Scene::new();
        let single = Material { double_sided: false, ..matt() };
        scene.add_mesh(square("tile", 0.0, 5.0), single, place);
        let camera = Camera { name: "eye".into(), projection };
        let camera = CameraSnapshot::looking(camera, DVec3::new(0.0, 4.0, 0.1), DVec3::ZERO);
        let reference = Reference::new(&scene.snapshot().unwrap());
        reference.render(&camera, SIZE, &[], &|_, _| {}).hits.iter().flatten().count()
    };
    let perspective = |near_m| Projection::Perspective { fov_y_rad: 0.5, near_m };
    let orthographic = |near_m, far_m| Projection::Orthographic { half_height_m: 1.0, near_m, far_m };
    let mirrored = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)));
    let turned = DAffine3::from_quat(DQuat::from_rotation_x(std::f64::consts::PI));
    assert!(seen(DAffine3::IDENTITY, perspective(0.1)) > 10_000);
    assert!(seen(mirrored, perspective(0.1)) > 10_000);
    assert_eq!(seen(turned, perspective(0.1)), 0);
    assert_eq!(seen(mirrored * turned, perspective(0.1)), 0);
    assert_eq!(seen(DAffine3::IDENTITY, perspective(5.0)), 0);
    assert!(seen(DAffine3::IDENTITY, orthographic(1.0, 6.0)) > 10_000);
    assert_eq!(seen(DAffine3::IDENTITY, orthographic(1.0, 3.0)), 0);
    assert_eq!(seen(DAffine3::IDENTITY, orthographic(5.0, 6.0)), 0);
}

#[test]
fn supersampling_gives_the_mean_of_the_factors() {
    let snapshot = scene(vec![lid()], Light::point("lamp", 1.0), DVec3::new(-1.5, 6.0, 1.0));
    let reference = Reference::new(&snapshot);
    let query = [LightQuery { casters: vec![0, 1], ..LightQuery::default() }];
    let fine = reference.render(&camera(), SIZE.map(|n| n * 4), &query, &|_, _| {});
    let mean = reference.render_supersampled(&camera(), SIZE, &query, &|_, _| {}, 4);
    let (width, mut between) = (SIZE[0] as usize, 0);
    for (pixel, factor) in mean.lights[0].1.iter().enumerate() {
        let (x, y) = (pixel % width * 4, pixel / width * 4);
        let subs = (0..16).map(|i| fine.lights[0].factor[(y + i / 4) * width * 4 + x + i % 4]);
        let hits: Vec<f32> = subs.filter(|f| !f.is_nan()).collect();
        let expected = hits.iter().sum::<f32>() / hits.len() as f32;
        assert!(factor.is_nan() && hits.is_empty() || *factor == expected, "pixel {pixel}");
        between += usize::from(*factor > 0.0 && *factor < 1.0);
    }
    assert!(between > 20, "{between}");
}
