//! Filling of a surface from the few pixels that the photo itself shows of it: the last resort, for surfaces
//! that no photo shows well.

use super::cells::{RegionCells, SmoothField};
use super::donor::Donor;
use super::region::Region;
use quadratura_base::geometry::PixelRect;

/// The colours for a whole region, in linear light of the photo, from the photo's pixels of its surface.
pub enum LastResort {
    /// Interpolated from pixels of the surface next to the region.
    Spread(SmoothField),
    /// One colour, because pixels of the surface are far away, or there are none.
    Plain([f32; 3]),
}

impl LastResort {
    /// Gathers the pixels that the photo shows of an item, for a region of its surface.
    pub fn new(own: &Donor, item: u32, region: &Region, cells: &RegionCells) -> Self {
        let mut sums = std::collections::BTreeMap::<usize, ([f32; 3], f32)>::new();
        let mut all = ([0.0; 3], 0.0);
        let bounds = own.seen(item).bounds;
        for (x, y) in pixels(bounds).filter(|(x, y)| own.shows_plane_at(item, *x, *y)) {
            let colour = own.pixel(x, y);
            let add = |(sum, count): &mut ([f32; 3], f32)| {
                (0..3).for_each(|c| sum[c] += colour[c]);
                *count += 1.0;
            };
            add(&mut all);
            if let Some(index) = cells.place(x, y) {
                add(sums.entry(index).or_default());
            }
        }
        let mean = |(sum, count): ([f32; 3], f32)| sum.map(|sum| sum / count);
        let known = sums.into_iter().map(|(index, sum)| (index, mean(sum), 1.0));
        if let Some(field) = cells.propagated(known) {
            return Self::Spread(field);
        }
        if all.1 == 0.0 {
            all = around(own, region.rect());
        }
        Self::Plain(mean(all))
    }

    /// Returns the colour at a pixel.
    pub fn colour(&self, x: u32, y: u32) -> [f32; 3] {
        match self {
            Self::Spread(field) => field.at(x, y),
            Self::Plain(colour) => *colour,
        }
    }
}

/// Sums the photo's pixels within a rectangle where none shows the surface, and counts them: the occluder's
/// colour is the best guess. Masked pixels are ignored; where all are masked, the rectangle is enlarged.
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
