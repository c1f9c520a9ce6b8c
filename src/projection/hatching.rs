//! Hatching of areas that a photo does not show: lines at 45 degrees, aligned to the photo's frame, so that
//! those of adjoining areas meet.

use glam::DVec2;

use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;

/// A pixel mask within a rectangle of the photo, in photo pixels; the rectangle may reach outside the photo.
pub type PixelMask = Image<bool>;

/// Computes the hatching lines of a mask within `window`, as segments in photo pixels that fall to the left,
/// `pitch_px` pixels apart along a row. The running time is proportional to the pixels that the lines cross.
pub fn stripes(mask: &PixelMask, window: PixelRect, pitch_px: u32) -> Vec<[DVec2; 2]> {
    let window = window.intersection(&mask.rect());
    let mut segments = Vec::new();
    if window.is_empty() {
        return segments;
    }
    let (first, last) = (window.x + window.y, window.right() + window.bottom() - 2);
    let pitch = pitch_px.max(1) as i32;
    let mut sum = first.div_euclid(pitch) * pitch;
    while sum <= last {
        stripe(mask, window, sum, &mut segments);
        sum += pitch;
    }
    segments
}

/// Computes the segments of one diagonal, whose columns and rows add up to `sum`.
fn stripe(mask: &PixelMask, window: PixelRect, sum: i32, segments: &mut Vec<[DVec2; 2]>) {
    let rows = window.y.max(sum - window.right() + 1)..window.bottom().min(sum - window.x + 1);
    let corner = |y: i32| DVec2::new(f64::from(sum - y + 1), f64::from(y));
    let mut begun: Option<i32> = None;
    for y in rows.clone() {
        match (mask.holds(sum - y, y), begun) {
            (true, None) => begun = Some(y),
            (false, Some(from)) => {
                segments.push([corner(from), corner(y)]);
                begun = None;
            }
            _ => (),
        }
    }
    segments.extend(begun.map(|from| [corner(from), corner(rows.end)]));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn box_of(rect: PixelRect, within: PixelRect) -> PixelMask {
        let mut mask = PixelMask::filled(rect, false);
        within.pixels().for_each(|(x, y)| mask.put(x, y, true));
        mask
    }

    #[test]
    fn stripes_cover_what_is_set_and_end_at_its_border() {
        let rect = PixelRect { x: -2, y: 0, w: 20, h: 20 };
        let mask = box_of(rect, PixelRect { x: 2, y: 4, w: 6, h: 5 });
        assert_eq!(mask.count(), 30);
        let all = stripes(&mask, rect, 4);
        // Of the sums 6 to 15, those that are multiples of 4.
        let expected = [[(5.0, 4.0), (2.0, 7.0)], [(9.0 - 1.0, 5.0), (4.0, 9.0)]];
        let expected = expected.map(|ends| ends.map(|(x, y)| DVec2::new(x, y)));
        assert_eq!(all, expected);
        let length: f64 = stripes(&mask, rect, 1).iter().map(|[from, to]| to.y - from.y).sum();
        assert_eq!(length, 30.0, "every pixel is passed once when stripes are a pixel apart");
    }

    #[test]
    fn a_window_shows_the_same_stripes_cut_off() {
        let rect = PixelRect::of_size(32, 32);
        let mask = box_of(rect, rect);
        let window = PixelRect { x: 9, y: 3, w: 7, h: 11 };
        let within = stripes(&mask, window, 1).iter().map(|[from, to]| to.y - from.y).sum::<f64>();
        assert_eq!(within, 77.0);
        assert!(stripes(&mask, PixelRect { x: 40, y: 0, w: 5, h: 5 }, 1).is_empty());
    }
}
