//! One renderer on the adapter of the machine.

use shadowgraph::prelude::*;

/// A renderer on the chosen adapter. Without an adapter the test is skipped with a word, unless `REQUIRE_GPU` is
/// set: then it fails.
pub(crate) fn renderer() -> Option<Renderer> {
    let choice = std::env::var("SHADOWGRAPH_ADAPTER").map_or(AdapterChoice::Auto, AdapterChoice::Named);
    match Gpu::open(&choice) {
        Ok(gpu) => Some(Renderer::new(gpu, shadowgraph_nodes::catalog())),
        Err(error) if std::env::var_os("REQUIRE_GPU").is_none_or(|value| value == "0") => {
            eprintln!("skipped: {error}");
            None
        }
        Err(error) => panic!("REQUIRE_GPU is set, but {error}"),
    }
}
