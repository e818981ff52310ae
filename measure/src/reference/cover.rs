//! Which parts of a masked texture are all solid or all hole, so that many points of it are decided at once.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec2;
use shadowgraph_engine::scene::{Image, TextureRef, Wrap};

use super::surface::Triangle;

/// What is within this of the cutoff is decided point by point.
const DOUBT: f64 = 1e-6;

/// How many texels of a texture are holes for certain, and how many are not: sums over all rectangles from the first texel.
#[derive(Debug)]
pub(crate) struct Cover {
    size: [usize; 2],
    /// One more along each side than there are texels.
    holes: Vec<u32>,
    solids: Vec<u32>,
}

impl Cover {
    /// `least` and `largest` are what a texel's alpha is multiplied with.
    pub(crate) fn new(image: &Image, [least, largest]: [f64; 2], cutoff: f32) -> Self {
        let size = [image.width as usize, image.height as usize];
        let alpha = |x: usize, y: usize| {
            image.rgba8.get((y * size[0] + x) * 4 + 3).map_or(1.0, |byte| f64::from(*byte) / 255.0)
        };
        let cutoff = f64::from(cutoff);
        let is_hole = |x: usize, y: usize| alpha(x, y) * largest < cutoff - DOUBT;
        let is_solid = |x: usize, y: usize| alpha(x, y) * least > cutoff + DOUBT;
        Self { size, holes: sums(size, is_hole), solids: sums(size, is_solid) }
    }

    /// Whether all of `texture` between two places is hole (true) or solid; `None` where neither is sure.
    pub(crate) fn over(&self, texture: &TextureRef, low: DVec2, high: DVec2) -> Option<bool> {
        let mut from = [0; 2];
        let mut to = [0; 2];
        for axis in 0..2 {
            let size = self.size[axis] as f64;
            // A blend reaches the texels whose middles are on either side.
            let first = (low[axis] * size - 0.5 - DOUBT).floor();
            let last = (high[axis] * size - 0.5 + DOUBT).floor() + 2.0;
            let period = if texture.wrap[axis] == Wrap::Repeat { (first / size).floor() * size } else { 0.0 };
            let (first, last) = (first - period, last - period);
            if !(first >= 0.0 && last <= size) {
                return None;
            }
            (from[axis], to[axis]) = (first as usize, last as usize);
        }
        let count = |sums: &[u32]| {
            let at = |x: usize, y: usize| sums[y * (self.size[0] + 1) + x];
            (at(to[0], to[1]) + at(from[0], from[1])) - (at(from[0], to[1]) + at(to[0], from[1]))
        };
        let all = ((to[0] - from[0]) * (to[1] - from[1])) as u32;
        if count(&self.holes) == all { Some(true) } else { (count(&self.solids) == all).then_some(false) }
    }
}

fn sums([width, height]: [usize; 2], counts: impl Fn(usize, usize) -> bool) -> Vec<u32> {
    let mut sums = vec![0; (width + 1) * (height + 1)];
    for y in 0..height {
        let mut row = 0;
        for x in 0..width {
            row += u32::from(counts(x, y));
            sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
        }
    }
    sums
}

/// Gives every mask among `triangles` what its texture covers, made once for all that wear it alike.
pub(crate) fn share_covers(triangles: &mut [Triangle]) {
    let mut known: HashMap<(usize, [u64; 2], u32), Arc<Cover>> = HashMap::new();
    for mask in triangles.iter_mut().filter_map(|triangle| triangle.mask.as_mut()) {
        let Some((image, factors, cutoff)) = mask.texture_alphas() else { continue };
        let key = (Arc::as_ptr(image) as usize, factors.map(f64::to_bits), cutoff.to_bits());
        let cover = known.entry(key).or_insert_with(|| Arc::new(Cover::new(image, factors, cutoff)));
        let cover = Arc::clone(cover);
        mask.set_cover(cover);
    }
}

#[cfg(test)]
mod tests {
    use shadowgraph_engine::scene::ImageKey;
    use slotmap::Key;

    use super::*;

    #[test]
    fn only_what_is_all_alike_is_decided() {
        // The left half is solid, the right one a hole.
        let rgba8 = (0..64 * 8).flat_map(|i| [0, 0, 0, if i % 64 < 32 { 255 } else { 0 }]).collect();
        let image = Image { name: "half".into(), width: 64, height: 8, rgba8 };
        let cover = Cover::new(&image, [1.0, 1.0], 0.5);
        let texture = TextureRef::new(ImageKey::null());
        let over = |x: [f64; 2]| cover.over(&texture, DVec2::new(x[0], 0.4), DVec2::new(x[1], 0.6));
        assert_eq!(over([0.1, 0.4]), Some(false));
        assert_eq!(over([1.1, 1.4]), Some(false));
        assert_eq!(over([0.6, 0.9]), Some(true));
        assert_eq!(over([0.4, 0.6]), None);
        assert_eq!((over([0.1, 0.49]), over([0.1, 0.499])), (Some(false), None));
        // Half of a solid texel is less than the cutoff.
        let thin = Cover::new(&image, [0.4, 1.0], 0.5);
        assert_eq!(thin.over(&texture, DVec2::new(0.1, 0.4), DVec2::new(0.4, 0.6)), None);
    }
}
