// A fragment stage for draws that write depth or stencil only, in a render pass that has colour targets.

@fragment
fn nothing() {}
