//! Texture views, and attachments as the API wants them.

use super::scene::Scene;
use crate::plan::{
    Access, Binding, BlendComponent, BlendFactor, BlendOperation, BlendState, ColorTarget, CompareFunction,
    DepthTarget, Draw, DrawState, Geometry, Load, Pass, Shader, ShaderError, SlotId,
};

pub(super) fn binding_view(scene: &Scene<'_>, binding: &Binding) -> Option<wgpu::TextureView> {
    let mut descriptor = wgpu::TextureViewDescriptor::default();
    match binding {
        Binding::Storage(_) | Binding::Comparison(_) => return None,
        Binding::Texture(slot) => {
            descriptor.dimension = Some(wgpu::TextureViewDimension::D2);
            descriptor.array_layer_count = Some(1);
            if scene.format(*slot).is_depth_stencil_format() {
                descriptor.aspect = wgpu::TextureAspect::DepthOnly;
            }
        }
        Binding::TextureArray(slot) => {
            descriptor.dimension = Some(wgpu::TextureViewDimension::D2Array);
            if scene.format(*slot).is_depth_stencil_format() {
                descriptor.aspect = wgpu::TextureAspect::DepthOnly;
            }
        }
        Binding::TextureLayer(slot, layer) => {
            if scene.format(*slot).is_depth_stencil_format() {
                descriptor.aspect = wgpu::TextureAspect::DepthOnly;
            }
            descriptor.dimension = Some(wgpu::TextureViewDimension::D2Array);
            descriptor.base_array_layer = *layer;
            descriptor.array_layer_count = Some(1);
        }
        Binding::StencilOf(_) => descriptor.aspect = wgpu::TextureAspect::StencilOnly,
    }
    scene.view(binding.resource()?, &descriptor)
}

/// The view that is drawn into, and the one it is resolved into.
pub(super) fn color_views(
    scene: &Scene<'_>,
    color: &ColorTarget,
) -> Option<(wgpu::TextureView, Option<wgpu::TextureView>)> {
    let resolve = color.resolve.and_then(|slot| layer_view(scene, slot, 0));
    Some((layer_view(scene, color.slot, color.layer)?, resolve))
}

/// One layer of a texture, all its aspects.
pub(super) fn layer_view(
    scene: &Scene<'_>,
    slot: SlotId,
    base_array_layer: u32,
) -> Option<wgpu::TextureView> {
    let dimension = Some(wgpu::TextureViewDimension::D2);
    let array_layer_count = Some(1);
    let descriptor =
        wgpu::TextureViewDescriptor { dimension, base_array_layer, array_layer_count, ..Default::default() };
    scene.view(slot, &descriptor)
}

pub(super) fn color_attachment<'a>(
    color: &ColorTarget,
    (view, resolve): &'a (wgpu::TextureView, Option<wgpu::TextureView>),
) -> wgpu::RenderPassColorAttachment<'a> {
    let load = match color.load {
        Load::Clear([r, g, b, a]) => wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }),
        // What is cleared in part is drawn over.
        Load::Keep | Load::ClearWithin(..) => wgpu::LoadOp::Load,
    };
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: resolve.as_ref(),
        ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
    }
}

pub(super) fn depth_attachment<'a>(
    depth: &DepthTarget,
    view: &'a wgpu::TextureView,
) -> wgpu::RenderPassDepthStencilAttachment<'a> {
    let store = wgpu::StoreOp::Store;
    let depth_ops = match depth.depth {
        Access::ReadOnly => None,
        Access::Keep => Some(wgpu::Operations { load: wgpu::LoadOp::Load, store }),
        Access::Clear(value) => Some(wgpu::Operations { load: wgpu::LoadOp::Clear(value), store }),
    };
    let stencil_ops = match depth.stencil {
        None | Some(Access::ReadOnly) => None,
        Some(Access::Keep) => Some(wgpu::Operations { load: wgpu::LoadOp::Load, store }),
        Some(Access::Clear(value)) => {
            Some(wgpu::Operations { load: wgpu::LoadOp::Clear(value as u32), store })
        }
    };
    wgpu::RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops }
}

/// Passes that clear what is cleared in part: no interface does, so that it is drawn.
pub(super) fn partial_clears(colors: &[ColorTarget]) -> Result<Vec<Pass>, ShaderError> {
    let clear = |color: &ColorTarget| {
        let Load::ClearWithin(value, within) = color.load else { return None };
        Some(Shader::composed("resolve_mask", &[], "fullscreen_vertex", Some("mark")).map(|shader| {
            let mut state = DrawState::new(CompareFunction::Always, vec![Some(BLEND_CONSTANT)]);
            state.blend_constant = value;
            let draw = Draw::new("clear", Geometry::fullscreen(shader), state);
            let draws = vec![Draw { scissor_px: Some(within), ..draw }];
            Pass { name: "clear".into(), reason: String::new(), colors: vec![*color], depth: None, draws }
        }))
    };
    colors.iter().filter_map(clear).collect()
}

/// The blend constant, whatever the shader says: what resolve_mask says is 1.
const BLEND_CONSTANT: BlendState = {
    let constant = BlendComponent {
        src_factor: BlendFactor::Constant,
        dst_factor: BlendFactor::Zero,
        operation: BlendOperation::Add,
    };
    BlendState { color: constant, alpha: constant }
};
