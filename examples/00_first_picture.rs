//! The program of the README: a box, a floor, a lamp, and a shadow as a picture, `out/first_picture.png`.

use shadowgraph::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    let floor = Mesh::new(shapes::plane(Vec2::splat(20.0)))?;
    let body = Mesh::new(shapes::cuboid(Vec3::splat(-0.5), Vec3::splat(0.5)))?;
    scene.add_mesh(floor, Material::default(), DAffine3::IDENTITY);
    scene.add_mesh(body, Material::default(), DAffine3::from_translation(DVec3::Y));
    scene.add_lamp(Light::point("lamp", 40.0), DVec3::new(2.0, 5.0, 1.0));
    scene.add_shadow("shadows", ShadowVolumeHard::default());

    let camera = Camera::perspective("eye", 0.8);
    let camera = CameraSnapshot::looking(camera, DVec3::new(4.0, 3.0, 5.0), DVec3::ZERO);
    let picture = Renderer::open()?.picture(&scene, &camera, [640, 480])?;
    picture.save("out/first_picture.png")?;
    Ok(())
}
