//! What a device does that is lost, too small or given what it cannot take: typed errors, and frames that go on.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use shadowgraph::engine::gpu::{GpuError, Pixels};
use shadowgraph::engine::plan::Shader;
use shadowgraph::engine::render::Frame;
use shadowgraph::engine::scene::{Image, TextureRef};
use shadowgraph::engine::shadow::{Channels, Contribution, TechniqueEntry};
use shadowgraph::prelude::*;
use shadowgraph_testing::{Plain, catalog_with, over_visibility, technique};

fn scene() -> Scene {
    let mut scene = shadowgraph_testing::shadowed_yard(&[]);
    let rgba8 = (0..64 * 64).flat_map(|i| [(i % 64 * 4) as u8, (i / 64 * 4) as u8, 90, 255]).collect();
    let image = Image { name: "gradient".into(), width: 64, height: 64, rgba8 };
    let texture = TextureRef::new(scene.add_image(Arc::new(image)));
    let material = Material { base_color_texture: Some(texture), ..Material::default() };
    scene.add_mesh(
        shadowgraph_testing::unit_box("painted"),
        material,
        shadowgraph_testing::at(1.5, 0.5, 1.0),
    );
    scene
}

fn request() -> FrameRequest {
    FrameRequest { factors: true, ..shadowgraph_testing::request() }
}

fn render(renderer: &mut Renderer, scene: &Scene) -> Result<Frame, RenderError> {
    let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
    renderer.render(scene, &request(), &options)
}

/// Everything a frame delivers.
fn delivered(frame: &Frame) -> (&Pixels, &[[u32; 2]], Vec<&Pixels>) {
    let picture = frame.picture.as_ref().unwrap();
    let triangles = frame.visible_triangles.as_ref().unwrap();
    (picture, triangles, frame.factors.iter().map(|factor| &factor.pixels).collect())
}

fn open() -> Option<Gpu> {
    // Devices of its own: the renderer of other tests must not be lost with them.
    Some(shadowgraph_testing::renderer()?.gpu().clone())
}

fn assert_names(error: &dyn std::error::Error, parts: &[&str]) {
    let text = error.to_string();
    parts.iter().for_each(|part| assert!(text.contains(part), "'{part}' is not in '{text}'"));
}

#[test]
fn a_lost_device_is_replaced_and_the_picture_is_the_same() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let scene = scene();
    let before = render(&mut renderer, &scene).unwrap();
    assert_eq!(renderer.recoveries(), 0);
    for loss in 1..=3 {
        renderer.gpu().device.destroy();
        let after = render(&mut renderer, &scene).unwrap();
        assert_eq!(renderer.recoveries(), loss);
        assert!(delivered(&before) == delivered(&after), "the picture changed after loss {loss}");
    }
    // And the new device is kept.
    render(&mut renderer, &scene).unwrap();
    assert_eq!(renderer.recoveries(), 3);
}

/// A device of the machine whose successors come from `open`.
fn with_successors(
    open: impl Fn() -> Result<(wgpu::Device, wgpu::Queue), GpuError> + Send + Sync + 'static,
) -> Option<Gpu> {
    let gpu = self::open()?;
    Some(Gpu::from_device(gpu.device, gpu.queue).reopened_by(open))
}

/// A device and queue of the machine.
fn another() -> Result<(wgpu::Device, wgpu::Queue), GpuError> {
    let gpu = open().unwrap();
    Ok((gpu.device, gpu.queue))
}

#[test]
fn devices_lost_while_recovering_are_replaced_too() {
    let opened = Arc::new(AtomicU32::new(0));
    let counted = Arc::clone(&opened);
    let gpu = with_successors(move || {
        let (device, queue) = another()?;
        // The first two successors are dead before they are used.
        if counted.fetch_add(1, Ordering::Relaxed) < 2 {
            device.destroy();
        }
        Ok((device, queue))
    });
    let Some(gpu) = gpu else { return };
    let mut renderer = Renderer::new(gpu, shadowgraph_nodes::catalog());
    let scene = scene();
    let before = render(&mut renderer, &scene).unwrap();
    renderer.gpu().device.destroy();
    let after = render(&mut renderer, &scene).unwrap();
    assert_eq!((renderer.recoveries(), opened.load(Ordering::Relaxed)), (3, 3));
    assert!(delivered(&before) == delivered(&after));
}

#[test]
fn a_loss_that_cannot_be_mended_is_a_typed_error() {
    // Every successor is dead.
    let gpu = with_successors(|| another().inspect(|(device, _)| device.destroy()));
    let Some(gpu) = gpu else { return };
    let mut renderer = Renderer::new(gpu, shadowgraph_nodes::catalog());
    renderer.gpu().device.destroy();
    let Err(RenderError::Gpu(error)) = render(&mut renderer, &scene()) else { panic!("it cannot render") };
    assert!(matches!(error, GpuError::Lost { .. }), "{error}");
    // Nobody said where another comes from.
    let (device, queue) = another().unwrap();
    let mut renderer = Renderer::new(Gpu::from_device(device, queue), shadowgraph_nodes::catalog());
    render(&mut renderer, &scene()).unwrap();
    renderer.gpu().device.destroy();
    let Err(RenderError::Gpu(error)) = render(&mut renderer, &scene()) else { panic!("it cannot render") };
    assert_names(&error, &["lost", "Gpu::reopened_by"]);
}

#[test]
fn a_loss_at_any_moment_panics_nowhere() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let scene = scene();
    let before = render(&mut renderer, &scene).unwrap();
    for delay_us in (0..3000).step_by(100) {
        let device = renderer.gpu().device.clone();
        let killer = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_micros(delay_us));
            device.destroy();
        });
        for _ in 0..2 {
            let after = render(&mut renderer, &scene).unwrap();
            assert!(delivered(&before) == delivered(&after), "lost after {delay_us} us");
        }
        killer.join().unwrap();
    }
    assert!(renderer.recoveries() > 0);
}

#[test]
fn a_frame_beyond_the_budget_is_refused_before_anything_is_allocated() {
    let Some(gpu) = open() else { return };
    let scene = scene();
    let mut renderer = Renderer::new(gpu.clone().with_budget(64 << 10), shadowgraph_nodes::catalog());
    let Err(RenderError::Gpu(error)) = render(&mut renderer, &scene) else { panic!("it is too large") };
    let GpuError::Budget { bytes, ref largest, largest_bytes, budget } = error else { panic!("{error}") };
    assert!(bytes > budget && largest_bytes <= bytes && budget == 64 << 10);
    assert_names(&error, &[largest, "65536", &bytes.to_string()]);
    // Uploads count buffers as they are made.
    assert_eq!(renderer.work_done().1, 0);
    // With just as much it is drawn, and another frame after it: what the first left makes room.
    let mut renderer = Renderer::new(gpu.with_budget(bytes), shadowgraph_nodes::catalog());
    let frame = render(&mut renderer, &scene).unwrap();
    assert!(frame.gpu_bytes <= bytes);
    let mut moved = scene.clone();
    shadowgraph_testing::add_box(&mut moved, "another", shadowgraph_testing::at(-1.5, 0.5, 1.0));
    let Err(RenderError::Gpu(GpuError::Budget { .. })) = render(&mut renderer, &moved) else {
        panic!("one mesh more is too much")
    };
    let again = render(&mut renderer, &scene).unwrap();
    assert!(delivered(&frame) == delivered(&again));
}

#[test]
fn what_exceeds_a_limit_is_named_with_the_limit() {
    let Some(mut gpu) = open() else { return };
    gpu.limits.max_storage_buffer_binding_size = 64;
    let mut renderer = Renderer::new(gpu.clone(), shadowgraph_nodes::catalog());
    let Err(RenderError::Gpu(error)) = render(&mut renderer, &scene()) else {
        panic!("64 bytes hold nothing")
    };
    assert!(matches!(error, GpuError::BufferTooLarge { bytes, limit: 64, .. } if bytes > 64), "{error}");
    gpu.limits.max_storage_buffer_binding_size = 1 << 20;
    gpu.limits.max_buffer_size = 1 << 10;
    let mut renderer = Renderer::new(gpu, shadowgraph_nodes::catalog());
    let Err(RenderError::Gpu(error)) = render(&mut renderer, &scene()) else {
        panic!("a picture needs more")
    };
    assert_names(&error, &["reading back", "1024"]);
}

/// A technique that draws a fullscreen triangle over the light's visibility with a shader.
fn painter(source: &'static str, fragment: &'static str) -> Plain {
    Plain::new(move |_, out| {
        let text = format!("#import common/fullscreen\n{source}");
        let shader = Shader::written("paint", &text, &[], "fullscreen_vertex", Some(fragment))?;
        let blend = Some(shadowgraph::engine::plan::MULTIPLY);
        out.pass(over_visibility("paint", shader, blend, vec![]));
        Ok(Contribution::visibility(Channels::One))
    })
}

const HALF: &str = "@fragment fn paint() -> @location(0) vec4f { return vec4f(0.5); }";
const QUARTER: &str = "@fragment fn paint() -> @location(0) vec4f { return vec4f(0.25); }";
const BROKEN: &str = "@fragment fn paint() -> @location(0) vec4f { return 1u; }";

/// The factor that each of the painters leaves, one light each, at the middle of the picture.
fn painted(painters: &[TechniqueEntry]) -> Result<Vec<f32>, RenderError> {
    let mut scene = shadowgraph_testing::with_floor();
    shadowgraph_testing::add_box(&mut scene, "crate", shadowgraph_testing::at(9.0, 0.5, 0.0));
    for painter in painters {
        let lamp = shadowgraph_testing::add_lamp(&mut scene, &format!("lamp of {}", painter.type_name));
        let mut node = ShadowNode::new(painter.type_name);
        node.lights = Scope::Nodes(vec![lamp]);
        scene.add_shadow(painter.type_name, node);
    }
    let mut renderer = Renderer::new(open().unwrap(), catalog_with(painters));
    let frame = render(&mut renderer, &scene)?;
    let [width, height] = shadowgraph_testing::SIZE_PX.map(|n| n as usize);
    let middle = height / 2 * width + width / 2;
    Ok(frame.factors.iter().map(|factor| factor.pixels.floats().unwrap()[middle]).collect())
}

#[test]
fn shaders_of_one_name_and_different_texts_are_different_shaders() {
    if open().is_none() {
        return;
    }
    let factors = painted(&[
        technique!("Half", |_| painter(HALF, "paint")),
        technique!("Quarter", |_| painter(QUARTER, "paint")),
    ])
    .unwrap();
    assert_eq!(factors, [0.5, 0.25]);
}

#[test]
fn shaders_that_do_not_compile_and_pipelines_that_do_not_fit_name_the_shader() {
    if open().is_none() {
        return;
    }
    let Err(RenderError::Gpu(error)) = painted(&[technique!("Broken", |_| painter(BROKEN, "paint"))]) else {
        panic!("a number is no colour")
    };
    assert!(matches!(error, GpuError::Shader { .. }), "{error}");
    assert_names(&error, &["'paint'"]);
    let Err(RenderError::Gpu(error)) = painted(&[technique!("Lost", |_| painter(HALF, "nowhere"))]) else {
        panic!("there is no such entry point")
    };
    assert!(matches!(error, GpuError::Pipeline { .. }), "{error}");
    assert_names(&error, &["'paint'", "nowhere"]);
}
