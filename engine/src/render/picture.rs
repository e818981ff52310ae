//! What is drawn into, and how the finished picture comes of it.

use super::request::{FrameError, PictureFormat};
use super::resolve::fullscreen;
use super::schedule::{Inputs, Needs, Schedule, Scope};
use crate::plan::{
    Antialias, BlendState, CompareFunction, DrawState, Load, ShaderError, SlotId, TextureDesc, TextureFormat,
};
use crate::shadow::{Binding, ColorTarget, Pass};

/// The textures of a picture in the making. Where nothing is to be averaged or rounded, they are one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Picture {
    /// What was asked for.
    pub(super) finished: SlotId,
    /// What it is averaged from: several samples a pixel, or twice the size.
    pub(super) averaged: SlotId,
    /// What is drawn into: where layers are blended, in more digits than eight bits, which every layer would round.
    pub(super) drawn: SlotId,
}

impl Picture {
    /// The textures that are asked for.
    ///
    /// # Errors
    /// What the adapter cannot do with four samples a pixel.
    pub(super) fn new(inputs: &Inputs<'_>, needs: &mut Needs) -> Result<Self, FrameError> {
        let (request, drawn_px) = (inputs.request, inputs.view.size_px);
        let format = match request.picture {
            PictureFormat::Srgb8 => TextureFormat::Rgba8UnormSrgb,
            PictureFormat::LinearF32 => TextureFormat::Rgba32Float,
        };
        let finished = needs.texture("picture", format, request.size_px, "what was asked for");
        let averaged = match request.antialias {
            Antialias::None => finished,
            Antialias::Multisample4 => {
                inputs.adapter.check_multisampled("the picture", format)?;
                let desc =
                    TextureDesc::new("picture in samples", format, drawn_px, "msaa4: edges of surfaces");
                needs.slots.texture(TextureDesc { samples: request.antialias.samples(), ..desc })
            }
            Antialias::Supersample4 => {
                let reason = "ssaa4: every sample is drawn in full";
                needs.texture("picture at twice the size", format, drawn_px, reason)
            }
        };
        Ok(Self { finished, averaged, drawn: averaged })
    }

    /// The same picture, into which so many layers are blended.
    pub(super) fn of_layers(mut self, inputs: &Inputs<'_>, needs: &mut Needs, layers: u32) -> Self {
        if layers > 1 && inputs.request.picture == PictureFormat::Srgb8 {
            let reason = "blended into layer by layer, in more digits than pictures have";
            let (format, size_px) = (TextureFormat::Rgba16Float, inputs.view.size_px);
            self.drawn = needs.texture("picture in layers", format, size_px, reason);
        }
        self
    }

    /// Rounds and averages what was drawn. (Samples are resolved by the last pass that draws into them.)
    pub(super) fn finish(self, inputs: &Inputs<'_>, schedule: &mut Schedule<'_>) -> Result<(), ShaderError> {
        let mut copy = |(name, reason): (&str, &str), into, from: SlotId, draw: &str, shader, binding| {
            let state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
            let draw =
                fullscreen(draw, shader, state)?.reading(vec![(binding, Binding::Texture(from.into()))]);
            schedule.push(
                &Scope::default(),
                Pass {
                    name: name.into(),
                    reason: reason.into(),
                    colors: vec![ColorTarget::new(into, Load::Clear([0.0; 4]))],
                    depth: None,
                    draws: vec![draw],
                },
            );
            Ok(())
        };
        if self.drawn != self.averaged {
            let what = ("picture of all layers", "in the digits that it was asked for");
            copy(what, self.averaged, self.drawn, "rounded", ("layer_images", &[], "rounded"), 2)?;
        }
        if inputs.request.antialias == Antialias::Supersample4 {
            let what = ("average", "ssaa4: the mean of four pixels, in tone-mapped linear light");
            copy(what, self.finished, self.averaged, "average", ("average_pixels", &[], "average"), 0)?;
        }
        Ok(())
    }
}
