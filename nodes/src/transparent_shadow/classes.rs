//! Whole numbers of surfaces, for each class of material, in float targets.
//!
//! All surfaces of a light that let the same share pass are one class. What is added for class k is a whole number times
//! 2^bₖ: classes share a channel, each in bits of its own.
//!
//! *Why it is exact.* A float holds whole numbers up to 2^24 (a half float up to 2^11), and no sum on the way may leave
//! that. Volumes are drawn one after the other, and when one is complete, what it has added is the number of its surfaces
//! between a point and the light, which [`max_layers`](shadowgraph_engine::geometry::max_layers) bounds. Within one, all entries may come before the first exit:
//! half of all that is drawn for it, each face as often as it weighs, and half its layers. So a channel takes classes as
//! long as all layers, and the one volume in the making, fit, each times 2^bₖ. On the way a field may borrow from its
//! neighbours as it likes; in the end it holds its count. The class of the heaviest volume lies lowest.
//!
//! *How many.* As many classes as four channels take are drawn at once; others follow in further passes over the same
//! target, each looked at once. The visibility is multiplied by whole products, never by single surfaces.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, cast_slice};
use glam::DVec3;
use shadowgraph_engine::plan::{BufferDesc, Lifetime, Load, Resource, TextureDesc, TextureFormat};
use shadowgraph_engine::shadow::{
    Binding, ColorTarget, Contribution, DepthTarget, Draw, Features, LightContext, Pass, PassList,
    ShadowError, hash_of,
};

use super::{Tinted, counting_draws, layers_of, shader, transmit, weight_of};
use crate::common::ray_candidates::Layout;
use crate::layout;

/// `struct Class` of transparent_shadow.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct ClassUniform {
    transmission: [f32; 3],
    channel: u32,
    first_bit: u32,
    bits: u32,
    offset: u32,
    pad_0: u32,
}

/// The structure as it is here: what the layout test compares.
pub(super) fn layout() -> Layout {
    layout!(ClassUniform: transmission, channel, first_bit, bits, offset, pad_0)
}

/// `SLACK` of the shader: how far below 0 a count may be by rounding.
const SLACK: u32 = 4;
/// A half float holds every whole number up to 2 to this.
const HALF_BITS: u32 = 11;
/// A float holds every whole number up to 2 to this.
const FLOAT_BITS: u32 = 24;
/// Classes of the small variant of the shader.
const FEW_CLASSES: usize = 2;
/// Classes that one draw turns into light.
const CLASSES_A_DRAW: usize = 8;
/// Channels of a target.
const CHANNELS: usize = 4;

/// One class of material.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Class {
    transmission: DVec3,
    /// The most surfaces of it between any point and the light.
    layers: u32,
    /// What one of its volumes may count on the way beyond that.
    on_the_way: u64,
}

/// Where the count of a class is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Field {
    class: usize,
    first_bit: u32,
    bits: u32,
}

/// The fields of one channel, from its lowest bit on.
type Channel = Vec<Field>;

/// Adds the passes that count the surfaces of `glass`, and that darken the light by what they say.
pub(super) fn count(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    glass: &[Tinted<'_>],
) -> Result<Contribution, ShadowError> {
    let draws = counting_draws(light, out, glass)?;
    let (classes, class_of) = classes(light, glass, &draws);
    let (channels, formats) = packed(light, &classes)?;
    let name = light.light().name.clone();
    let widest = formats[channels.len().min(CHANNELS) - 1];
    let reason =
        "transparent surfaces between a light and the view, as many bits for each material as it takes";
    let desc = TextureDesc::new("surfaces before a light", widest, light.view.size_px, reason);
    let sums = out.texture(TextureDesc { lifetime: Lifetime::Scratch, ..desc });
    let mut left = Contribution::default();
    for channels in channels.chunks(CHANNELS) {
        let fields =
            || channels.iter().enumerate().flat_map(|(c, fields)| fields.iter().map(move |f| (c, f)));
        let mut counted = Vec::new();
        for (volume_draws, class) in draws.iter().zip(&class_of) {
            let Some((channel, field)) = fields().find(|(_, field)| field.class == *class) else { continue };
            let unit = f64::from(1_u32 << field.first_bit);
            counted.extend(volume_draws.iter().cloned().map(|mut draw| {
                let weight = draw.state.blend_constant[channel];
                draw.state.blend_constant = [0.0; 4];
                draw.state.blend_constant[channel] = weight * unit;
                draw
            }));
        }
        out.pass(counting_pass(light, sums, fields().count(), counted));
        let records: Vec<ClassUniform> = fields()
            .map(|(channel, field)| ClassUniform {
                transmission: classes[field.class].transmission.as_vec3().to_array(),
                channel: channel as u32,
                first_bit: field.first_bit,
                bits: field.bits,
                offset: channels[channel].iter().map(|field| SLACK << field.first_bit).sum(),
                pad_0: 0,
            })
            .collect();
        let mut resolves = Vec::new();
        for records in records.chunks(CLASSES_A_DRAW) {
            let bytes: &[u8] = cast_slice(records);
            let (key, contents) = (hash_of(("glass classes", bytes)), Arc::new(bytes.to_vec()));
            let reason = "what a surface of each material lets pass, and where its count is";
            let name = format!("glass of {name}");
            let slot = out.buffer(BufferDesc::storage(&name, key, contents, reason));
            let flags: &[&str] = if records.len() > FEW_CLASSES { &["MANY_CLASSES"] } else { &[] };
            let bindings = vec![(1, Binding::Storage(slot)), (3, Binding::Texture(sums))];
            resolves.push((shader(flags, "class_vertex", "transmit_counts")?, bindings));
        }
        let reason = "counts become what is left of the light: the product of what each surface lets pass";
        left = left.and(transmit(light, out, glass, resolves, reason.into()));
    }
    Ok(left)
}

fn counting_pass(light: &LightContext<'_>, sums: Resource, classes: usize, draws: Vec<Draw>) -> Pass {
    let name = &light.light().name;
    Pass {
        name: format!("transparent volumes of {name}"),
        reason: format!("surfaces of {classes} transparent materials between {name} and the view"),
        colors: vec![ColorTarget::new(sums, Load::Clear([0.0; 4]))],
        depth: Some(DepthTarget::TEST),
        draws,
    }
}

/// The classes of `glass`, and for each of its members which class it belongs to.
fn classes(light: &LightContext<'_>, glass: &[Tinted<'_>], draws: &[Vec<Draw>]) -> (Vec<Class>, Vec<usize>) {
    let mut classes: Vec<Class> = Vec::new();
    let mut members: Vec<Vec<&Tinted<'_>>> = Vec::new();
    let mut class_of = Vec::new();
    for (tinted, draws) in glass.iter().zip(draws) {
        let known = classes.iter().position(|class| class.transmission == tinted.transmission);
        let class = known.unwrap_or(classes.len());
        if known.is_none() {
            classes.push(Class { transmission: tinted.transmission, layers: 0, on_the_way: 0 });
            members.push(vec![]);
        }
        classes[class].on_the_way = classes[class].on_the_way.max(weight_of(draws));
        members[class].push(tinted);
        class_of.push(class);
    }
    for (class, members) in classes.iter_mut().zip(&members) {
        class.layers = layers_of(light, members);
        class.on_the_way = (class.on_the_way + u64::from(class.layers)).div_ceil(2);
    }
    (classes, class_of)
}

/// The channels the classes are counted in, and the formats of one to four of them.
fn packed(
    light: &LightContext<'_>,
    classes: &[Class],
) -> Result<(Vec<Channel>, [TextureFormat; 4]), ShadowError> {
    const HALVES: [TextureFormat; 4] = {
        use TextureFormat::{R16Float, Rg16Float, Rgba16Float};
        [R16Float, Rg16Float, Rgba16Float, Rgba16Float]
    };
    const FLOATS: [TextureFormat; 4] = {
        use TextureFormat::{R32Float, Rg32Float, Rgba32Float};
        [R32Float, Rg32Float, Rgba32Float, Rgba32Float]
    };
    let narrow = pack(classes, HALF_BITS);
    let can_be_wide = light.features.contains(Features::FLOAT32_BLENDABLE);
    if let Some(channels) = &narrow
        && (channels.len() == 1 || !can_be_wide)
    {
        return Ok((channels.clone(), HALVES));
    }
    let heaviest =
        classes.iter().map(|class| class.on_the_way + u64::from(class.layers)).max().unwrap_or_default();
    light.require(
        Features::FLOAT32_BLENDABLE,
        &format!("accumulate=counts, and sums of up to {heaviest} are no whole numbers of half floats"),
    )?;
    match pack(classes, FLOAT_BITS) {
        Some(channels) => Ok((channels, FLOATS)),
        None => Err(light.unsupported(format!(
            "accumulate=counts, but sums of up to {heaviest} are beyond the {} that a float holds exactly",
            1 << FLOAT_BITS
        ))),
    }
}

/// Packs classes into as few channels of numbers up to 2^`capacity_bits` as first-fit finds, the heaviest lowest; `None`
/// when one alone is too heavy.
fn pack(classes: &[Class], capacity_bits: u32) -> Option<Vec<Channel>> {
    let mut order: Vec<usize> = (0..classes.len()).collect();
    order.sort_by_key(|class| std::cmp::Reverse(classes[*class].on_the_way));
    let mut channels: Vec<Channel> = Vec::new();
    for class in order {
        let bits = (classes[class].layers + 2 * SLACK).ilog2() + 1;
        let with = |fields: &[Field]| {
            let first_bit = fields.last().map_or(0, |last| last.first_bit + last.bits);
            let more: Channel = fields.iter().copied().chain([Field { class, first_bit, bits }]).collect();
            let fits = first_bit + bits <= capacity_bits && largest_sum(classes, &more) <= 1 << capacity_bits;
            fits.then_some(more)
        };
        match channels.iter().enumerate().find_map(|(place, fields)| Some((place, with(fields)?))) {
            Some((place, more)) => channels[place] = more,
            None => channels.push(with(&[])?),
        }
    }
    Some(channels)
}

/// What the sum of a channel may reach on the way.
fn largest_sum(classes: &[Class], fields: &[Field]) -> u64 {
    let times = |count: u64, field: &Field| count.saturating_mul(1 << field.first_bit);
    let complete =
        fields.iter().map(|field| times(u64::from(classes[field.class].layers + 2 * SLACK), field));
    let in_the_making = fields.iter().map(|field| times(classes[field.class].on_the_way, field)).max();
    complete.fold(in_the_making.unwrap_or_default(), u64::saturating_add)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn class(on_the_way: u64, layers: u32) -> Class {
        Class { transmission: DVec3::splat(0.5), layers, on_the_way }
    }

    /// Fields are disjoint, hold their counts, and no sum on the way leaves the format.
    fn check(classes: &[Class], capacity_bits: u32) -> Option<Vec<Channel>> {
        let channels = pack(classes, capacity_bits)?;
        let mut seen: Vec<usize> = channels.iter().flatten().map(|field| field.class).collect();
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..classes.len()));
        for channel in &channels {
            let mut free = 0;
            for field in channel {
                assert!(field.first_bit >= free, "{channel:?}");
                free = field.first_bit + field.bits;
                assert!(classes[field.class].layers + 2 * SLACK < 1 << field.bits);
                let others =
                    channel.iter().map(|f| u64::from(classes[f.class].layers) << f.first_bit).sum::<u64>();
                let making = classes[field.class].on_the_way << field.first_bit;
                assert!(others + making <= 1 << capacity_bits, "{channel:?}");
            }
            assert!(free <= capacity_bits, "{channel:?}");
        }
        Some(channels)
    }

    #[test]
    fn classes_share_channels_as_far_as_their_sums_allow() {
        // Panes: each counts at most 1, and draws 12 sides and 6 caps or less.
        assert_eq!(check(&[class(10, 1); 5], FLOAT_BITS).unwrap().len(), 1);
        assert_eq!(check(&[class(10, 1); 5], HALF_BITS).unwrap().len(), 3);
        // What a large mesh draws leaves no room for two more in the same bits.
        assert_eq!(check(&[class(35_000, 40); 2], FLOAT_BITS).unwrap().len(), 1);
        assert_eq!(check(&[class(35_000, 40); 4], FLOAT_BITS).unwrap().len(), 2);
        assert!(check(&[class(10, 1), class(3000, 2)], HALF_BITS).is_none());
        assert!(check(&[class(1 << 24, 2)], FLOAT_BITS).is_none());
        assert!(check(&vec![class(40, 2); 100], FLOAT_BITS).unwrap().len() <= 25);
    }

    /// Sums of signed numbers, read as the shader reads them, whatever was added first.
    #[test]
    fn fields_are_read_back() {
        let classes = [class(40, 5), class(900, 30), class(40, 7), class(8, 2)];
        let channels = check(&classes, FLOAT_BITS).unwrap();
        assert_eq!(channels.len(), 1);
        for counts in [[0, 0, 0, 0], [5, 30, 7, 2], [1, 0, 3, 0], [0, -1, 2, 0], [-1, 3, -2, 1]] {
            let fields = &channels[0];
            let mut sum = 0.0_f32;
            for field in fields {
                // All entries, and then all exits.
                let exits = classes[field.class].on_the_way as i32 - 20;
                for added in [counts[field.class] + exits, -exits] {
                    sum += (added * (1 << field.first_bit)) as f32;
                }
            }
            let offset: u32 = fields.iter().map(|field| SLACK << field.first_bit).sum();
            for field in fields {
                let moved = (sum as i32 + offset as i32) as u32;
                let found = (moved >> field.first_bit & ((1 << field.bits) - 1)).max(SLACK) - SLACK;
                assert_eq!(found as i32, counts[field.class].max(0), "{counts:?} {field:?}");
            }
        }
    }
}
