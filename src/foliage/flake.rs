//! What a texel of an image covers in a view, and what is the nearest at each sub-pixel. The shader of flakes does the same for one or
//! four sub-pixels of a pixel, within the reach of [`super::walk::WalkOptions`].

use glam::{Mat2, Vec2};

use super::raster::Fragment;
use quadratura_base::geometry::PixelRect;

/// A texel in a view: a parallelogram of which a mask says what is covered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Flake {
    /// The middle, in sub-pixels from the corner of what is drawn.
    pub middle: Vec2,
    /// The way from the left side to the right one.
    pub across: Vec2,
    /// The way from the upper side to the lower one.
    pub down: Vec2,
    /// Which of its 4 x 4 parts are covered, bit `4 row + column`.
    pub mask: u16,
}

/// Bounds of what is covered are this much wider than computed, in sub-pixels: more than their rounding.
const SLACK: f32 = 1e-3;

impl Flake {
    /// Calls `each` with columns and rows of the sub-pixels in `size` around the texel, by rows, and whether their middles lie in what is
    /// covered. Of two neighbours one has what lies on their side.
    #[inline(always)]
    pub fn cover(&self, size: [i32; 2], mut each: impl FnMut(i32, i32, bool)) {
        let inverse = Mat2::from_cols(self.across, self.down).inverse();
        let reach = 0.5 * (self.across.abs() + self.down.abs());
        let (low, high) = (self.middle - reach, self.middle + reach);
        // Sub-pixel i has its middle at i + 1/2.
        let [first_x, first_y] = [low.x, low.y].map(|low| rounded_down(low + 0.5 - SLACK).max(0));
        let last_x = rounded_down(high.x - 0.5 + SLACK).min(size[0] - 1);
        let last_y = rounded_down(high.y - 0.5 + SLACK).min(size[1] - 1);
        let first = Vec2::new(first_x as f32 + 0.5, first_y as f32 + 0.5);
        // Its place in the texel, in fourths: 0..4 is inside, without branches, which processors would guess wrongly half of the time.
        // What is no number, of a texel seen edge-on, never is.
        let inverse = inverse * 4.0;
        let mut row = inverse * (first - self.middle) + 2.0;
        let mut y = first_y;
        while y <= last_y {
            let (mut at, mut x) = (row, first_x);
            while x <= last_x {
                let inside = (at.x >= 0.0) & (at.x < 4.0) & (at.y >= 0.0) & (at.y < 4.0);
                let bit = 4 * (at.y as i32) + at.x as i32;
                each(x, y, inside & (self.mask >> (bit & 15) & 1 != 0));
                at += inverse.x_axis;
                x += 1;
            }
            row += inverse.y_axis;
            y += 1;
        }
    }
}

/// Rounds down, to -64 at the least; without a call, which processors of the least kind need.
#[inline(always)]
fn rounded_down(value: f32) -> i32 {
    (value.max(-64.0) + 64.0) as i32 - 64
}

/// What is the nearest at each sub-pixel of some rows: by nearness, and of equals the one with the largest index. So it does not matter in which
/// order it comes.
pub(super) struct FlakeBuffer {
    /// The pixels.
    pub rect: PixelRect,
    /// Row by row of sub-pixels: the nearness in the high half, in the order of numbers, the index in the low one; 0 where nothing is.
    keys: Vec<u64>,
}

impl FlakeBuffer {
    /// Makes an empty buffer.
    pub fn new(rect: PixelRect) -> Self {
        Self { rect, keys: vec![0; 16 * rect.area() as usize] }
    }

    /// Returns columns and rows of sub-pixels.
    pub fn size(&self) -> [i32; 2] {
        [4 * self.rect.w as i32, 4 * self.rect.h as i32]
    }

    /// Keeps an index at a sub-pixel if it is nearer than what is there.
    #[inline(always)]
    pub fn put(&mut self, x: i32, y: i32, key: u64) {
        let there = &mut self.keys[y as usize * 4 * self.rect.w as usize + x as usize];
        if key > *there {
            *there = key;
        }
    }

    /// Returns the first sub-pixel of a pixel.
    #[inline]
    fn first(&self, x: i32, y: i32) -> usize {
        4 * ((y - self.rect.y) as usize * 4 * self.rect.w as usize + (x - self.rect.x) as usize)
    }

    /// Returns the sub-pixels of a fragment that are nearer than what is there.
    pub fn visible(&self, fragment: &Fragment) -> u16 {
        let (first, width) = (self.first(fragment.x, fragment.y), 4 * self.rect.w as usize);
        let (mut left, mut visible) = (fragment.mask, 0);
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            let there = self.keys[first + bit / 4 * width + bit % 4];
            visible |= u16::from(key(fragment.nearness[bit], u32::MAX) > there) << bit;
        }
        visible
    }

    /// Keeps an index at some sub-pixels of a fragment.
    pub fn put_fragment(&mut self, fragment: &Fragment, visible: u16, index: u32) {
        let (first, width) = (self.first(fragment.x, fragment.y), 4 * self.rect.w as usize);
        let mut left = visible;
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            let there = &mut self.keys[first + bit / 4 * width + bit % 4];
            *there = (*there).max(key(fragment.nearness[bit], index));
        }
    }

    /// Returns the indices at the 16 sub-pixels of a pixel; `None` where nothing is.
    pub fn pixel(&self, x: i32, y: i32) -> [Option<u32>; 16] {
        let (first, width) = (self.first(x, y), 4 * self.rect.w as usize);
        std::array::from_fn(|bit| {
            let key = self.keys[first + bit / 4 * width + bit % 4];
            (key != 0).then_some(key as u32)
        })
    }
}

/// Returns a number that is larger for what is nearer, and of equals for the larger index; never 0.
#[inline(always)]
pub(super) fn key(nearness: f32, index: u32) -> u64 {
    let bits = nearness.to_bits();
    // All bits of negative numbers are turned, and the sign of others.
    let ordered = bits ^ ((bits as i32 >> 31) as u32 | 1 << 31);
    u64::from(ordered) << 32 | u64::from(index)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn a_square_of_texels_covers_each_sub_pixel_of_it_once_at_any_turn() {
        let mut rng = Rng::new(41);
        for _ in 0..100 {
            // 0.7 pixels are 2.8 sub-pixels.
            let axis = 2.8 * Vec2::from_angle(rng.between(0.0, 6.3) as f32);
            let (across, down) = (axis, axis.perp());
            let corner = Vec2::splat(40.0) - 8.0 * (across + down);
            let size = [80, 80];
            let mut times = vec![0u32; 6400];
            for (i, j) in (0..256).map(|texel| (texel % 16, texel / 16)) {
                let middle = corner + (i as f32 + 0.5) * across + (j as f32 + 0.5) * down;
                let flake = Flake { middle, across, down, mask: u16::MAX };
                flake.cover(size, |x, y, is_covered| times[(80 * y + x) as usize] += u32::from(is_covered));
            }
            let inverse = Mat2::from_cols(across, down).inverse();
            for (index, times) in times.iter().enumerate() {
                let at = inverse * (Vec2::new((index % 80) as f32, (index / 80) as f32) + 0.5 - corner);
                // Rounding decides on a sub-pixel within a thousandth of a texel of a side.
                let to_side = |value: f32| (value - value.round()).abs();
                let is_clear = to_side(at.x) > 1e-3 && to_side(at.y) > 1e-3;
                let inside = at.cmpgt(Vec2::ZERO).all() && at.cmplt(Vec2::splat(16.0)).all();
                assert!(!is_clear || *times == u32::from(inside), "{at}: {times}");
            }
        }
    }

    #[test]
    fn parts_that_the_mask_leaves_out_are_open() {
        let flake =
            |mask| Flake { middle: Vec2::splat(4.0), across: 4.0 * Vec2::X, down: 4.0 * Vec2::Y, mask };
        for bit in 0..16 {
            let mut found = Vec::new();
            flake(1 << bit).cover([9, 9], |x, y, is_covered| found.extend(is_covered.then_some((x, y))));
            assert_eq!(found, [(2 + bit % 4, 2 + bit / 4)]);
        }
        let mut count = 0;
        flake(u16::MAX).cover([3, 9], |_, _, is_covered| count += i32::from(is_covered));
        assert_eq!(count, 4, "one column is in the picture");
        let edge_on = Flake { down: 4.0 * Vec2::X, ..flake(u16::MAX) };
        edge_on.cover([9, 9], |_, _, is_covered| {
            assert!(!is_covered, "a texel that is seen edge-on covers nothing")
        });
    }

    #[test]
    fn the_nearest_stays_in_whatever_order_it_comes_and_of_equals_the_last_index() {
        let mut rng = Rng::new(42);
        let rect = PixelRect::of_size(2, 1);
        let mut puts: Vec<(i32, i32, f32, u32)> = (0..400)
            .map(|index| {
                let mut whole = |end: f64| rng.between(0.0, end) as i32;
                (whole(7.99), whole(3.99), whole(5.0) as f32 - 2.5, index)
            })
            .collect();
        let buffer = |puts: &[(i32, i32, f32, u32)]| {
            let mut buffer = FlakeBuffer::new(rect);
            puts.iter().for_each(|(x, y, nearness, index)| buffer.put(*x, *y, key(*nearness, *index)));
            [buffer.pixel(0, 0), buffer.pixel(1, 0)]
        };
        let found = buffer(&puts);
        let best = puts.iter().filter(|(x, y, ..)| (*x, *y) == (5, 2));
        let best = best.max_by(|a, b| a.2.total_cmp(&b.2).then(a.3.cmp(&b.3))).unwrap();
        assert_eq!(found[1][4 * 2 + 1], Some(best.3));
        puts.reverse();
        assert_eq!(buffer(&puts), found);
        assert_eq!(buffer(&[]), [[None; 16]; 2]);
    }
}
