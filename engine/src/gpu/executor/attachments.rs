//! Texture views, and attachments as the API wants them.

use super::encode::Scene;
use crate::plan::{Access, Binding, ColorTarget, DepthTarget, Load};

pub(super) fn binding_view(scene: &Scene<'_>, binding: &Binding) -> Option<wgpu::TextureView> {
    let mut descriptor = wgpu::TextureViewDescriptor::default();
    match binding {
        Binding::Storage(_) => return None,
        Binding::Texture(slot) => {
            descriptor.dimension = Some(wgpu::TextureViewDimension::D2);
            descriptor.array_layer_count = Some(1);
            if scene.format(*slot).is_depth_stencil_format() {
                descriptor.aspect = wgpu::TextureAspect::DepthOnly;
            }
        }
        Binding::TextureArray(_) => descriptor.dimension = Some(wgpu::TextureViewDimension::D2Array),
        Binding::TextureLayer(_, layer) => {
            descriptor.dimension = Some(wgpu::TextureViewDimension::D2Array);
            descriptor.base_array_layer = *layer;
            descriptor.array_layer_count = Some(1);
        }
        Binding::StencilOf(_) => descriptor.aspect = wgpu::TextureAspect::StencilOnly,
    }
    scene.view(binding.slot(), &descriptor)
}

/// The view that is drawn into, and the one it is resolved into.
pub(super) fn color_views(
    scene: &Scene<'_>,
    color: &ColorTarget,
) -> Option<(wgpu::TextureView, Option<wgpu::TextureView>)> {
    let layer = |slot, base_array_layer| {
        scene.view(
            slot,
            &wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer,
                array_layer_count: Some(1),
                ..Default::default()
            },
        )
    };
    Some((layer(color.slot, color.layer)?, color.resolve.and_then(|slot| layer(slot, 0))))
}

pub(super) fn color_attachment<'a>(
    color: &ColorTarget,
    (view, resolve): &'a (wgpu::TextureView, Option<wgpu::TextureView>),
) -> wgpu::RenderPassColorAttachment<'a> {
    let load = match color.load {
        Load::Clear([r, g, b, a]) => wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }),
        Load::Keep | Load::Anything => wgpu::LoadOp::Load,
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
