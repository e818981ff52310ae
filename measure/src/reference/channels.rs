//! Factors as pictures of one channel or three: how they are read, and where they change.

/// What an exact factor may lose to the half floats it is kept in, with some products on the way. Between hard
/// shadows there is nothing so small: it matters for fractional and coloured factors only.
pub const HALF_FLOAT_LOSS: f64 = 1e-3;

/// The channels of a picture of so many pixels: one or three.
pub(crate) fn channels(factor: &[f32], pixels: usize) -> usize {
    if factor.len() == pixels { 1 } else { 3 }
}

/// Red, green and blue of a pixel; of a one-channel picture three times the same.
pub(crate) fn at(factor: &[f32], pixels: usize, pixel: usize) -> impl Iterator<Item = f32> {
    let of = |channel: usize| {
        if channels(factor, pixels) == 1 { factor[pixel] } else { factor[pixel * 3 + channel] }
    };
    [of(0), of(1), of(2)].into_iter()
}

/// Which compared pixels differ in `factor` from their right or lower compared neighbour.
pub(crate) fn boundary(factor: &[f32], compared: &[bool], width: usize) -> Vec<bool> {
    let pixels = compared.len();
    let differs = |a: usize, b: usize| {
        b < pixels
            && compared[a]
            && compared[b]
            && at(factor, pixels, a).zip(at(factor, pixels, b)).any(|(a, b)| a.to_bits() != b.to_bits())
    };
    (0..pixels).map(|i| ((i + 1) % width != 0 && differs(i, i + 1)) || differs(i, i + width)).collect()
}
