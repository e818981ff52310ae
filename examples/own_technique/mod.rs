//! A technique of one's own, written as any user of the library would: it is not part of the library, and the library
//! was not changed for it. One file is the technique, one its shader, one knows what a disc is.

mod disc;
mod disc_shadow;

use shadowgraph::engine::shadow::Catalog;

pub(crate) use disc::disc_mesh;
pub(crate) use disc_shadow::DiscShadow;
#[allow(unused_imports, reason = "for the test, which checks the shader without a device")]
pub(crate) use disc_shadow::{SHADER, layouts};

/// Every technique of the library, and this one.
pub(crate) fn catalog() -> Catalog {
    let mut catalog = shadowgraph::nodes::catalog();
    catalog.register(DiscShadow::ENTRY);
    catalog
}
