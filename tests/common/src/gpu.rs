//! One renderer on the adapter of the machine.

use shadowgraph::measure::{Measured, measured};
use shadowgraph::prelude::*;
use shadowgraph_engine::shadow::TechniqueEntry;

use crate::{catalog_with, skip};

/// A renderer on the chosen adapter. Without an adapter the test is skipped with a word, unless `REQUIRE_GPU` is
/// set: then it fails.
pub fn renderer() -> Option<Renderer> {
    let choice = std::env::var("SHADOWGRAPH_ADAPTER").map_or(AdapterChoice::Auto, AdapterChoice::Named);
    match Gpu::open(&choice) {
        Ok(gpu) => Some(Renderer::new(gpu, shadowgraph_nodes::catalog())),
        Err(error) if std::env::var_os("REQUIRE_GPU").is_none_or(|value| value == "0") => {
            skip(&error.to_string());
            None
        }
        Err(error) => panic!("REQUIRE_GPU is set, but {error}"),
    }
}

/// [`renderer`] with further techniques in its catalog.
pub fn renderer_with(entries: &[TechniqueEntry]) -> Option<Renderer> {
    Some(Renderer::new(renderer()?.gpu().clone(), catalog_with(entries)))
}

/// Renders `scene` with its factors, as the measures want them.
pub fn measure(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
) -> Result<Measured, RenderError> {
    let request = FrameRequest { factors: true, ..request.clone() };
    let frame = renderer.render(scene, &request, &RenderOptions::default())?;
    measured(&frame, request.size_px)
}

/// A mesh of generated data, which a test gets right or ends.
pub fn mesh(data: MeshData) -> Mesh {
    Mesh::new(data).unwrap_or_else(|error| panic!("a test generates an invalid mesh: {error}"))
}
