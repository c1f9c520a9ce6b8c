//! What a photo itself shows of a surface, however little: the last resort, for surfaces of which no photo shows
//! anything well inside.

use super::cells::{Cells, Field};
use super::donor::Donor;
use super::region::Region;
use crate::geometry::PixelRect;

/// Colours for all of a region, in linear light of the photo, spread from the pixels that show its surface.
pub enum Remnant {
    /// From pixels beside it.
    Spread(Field),
    /// Of one colour: what shows the surface is far away, or there is nothing.
    Plain([f32; 3]),
}

impl Remnant {
    /// Of the item of a region's surface.
    pub fn of(own: &Donor, item: u32, region: &Region, cells: &Cells) -> Self {
        let mut sums = std::collections::BTreeMap::<usize, ([f32; 3], f32)>::new();
        let mut all = ([0.0; 3], 0.0);
        let bounds = own.seen(item).bounds;
        for (x, y) in pixels(bounds).filter(|(x, y)| own.owns(item, *x, *y)) {
            let colour = own.pixel(x, y);
            let add = |(sum, count): &mut ([f32; 3], f32)| {
                (0..3).for_each(|c| sum[c] += colour[c]);
                *count += 1.0;
            };
            add(&mut all);
            if let Some(place) = cells.place(x, y) {
                add(sums.entry(place).or_default());
            }
        }
        let mean = |(sum, count): ([f32; 3], f32)| sum.map(|sum| sum / count);
        let known = sums.into_iter().map(|(place, sum)| (place, mean(sum), 1.0));
        if let Some(field) = cells.spread(known) {
            return Self::Spread(field);
        }
        if all.1 == 0.0 {
            all = around(own, region.rect());
        }
        Self::Plain(mean(all))
    }

    /// The colour at a pixel.
    pub fn colour(&self, x: u32, y: u32) -> [f32; 3] {
        match self {
            Self::Spread(field) => field.at(x, y),
            Self::Plain(colour) => *colour,
        }
    }
}

/// The sum of the pixels at a place of which nothing is shown, and their number: what stands before it is as near as
/// can be. What is masked says nothing; where all is, one looks farther around.
fn around(own: &Donor, rect: PixelRect) -> ([f32; 3], f32) {
    let photo = own.camera.rect();
    let mut wide = rect;
    loop {
        let mut all = ([0.0; 3], 0.0);
        for (x, y) in pixels(wide).filter(|(x, y)| own.shows_any(*x, *y)) {
            (0..3).for_each(|c| all.0[c] += own.pixel(x, y)[c]);
            all.1 += 1.0;
        }
        if all.1 > 0.0 {
            return all;
        }
        if wide == photo {
            return ([0.0; 3], 1.0);
        }
        wide = wide.grown(wide.w.max(wide.h).max(1)).intersection(&photo);
    }
}

fn pixels(rect: PixelRect) -> impl Iterator<Item = (u32, u32)> {
    (rect.y..rect.bottom()).flat_map(move |y| (rect.x..rect.right()).map(move |x| (x as u32, y as u32)))
}
