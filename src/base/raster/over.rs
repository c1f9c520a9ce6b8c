//! One colour over another: the over operator of Porter and Duff, *Compositing Digital Images*, 1984.

use super::Sample;

/// Composites a premultiplied colour over another one. The last channel is alpha, 0 to 1.
#[inline]
pub fn premultiplied(above: [f32; 4], below: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|c| above[c] + below[c] * (1.0 - above[3]))
}

/// Composites a straight colour, one that is not premultiplied, over another one. The result is exact where `above` is
/// opaque or empty, and rounded to the nearest elsewhere.
#[inline]
pub fn straight<T: Sample>(below: &mut [T; 4], above: &[T; 4]) {
    let full = T::FULL.number();
    let alpha = above[3].number() / full;
    if alpha == 1.0 {
        *below = *above;
    } else if alpha > 0.0 {
        let under = below[3].number() / full * (1.0 - alpha);
        for (below, above) in below[..3].iter_mut().zip(above) {
            *below = T::rounded((above.number() * alpha + below.number() * under) / (alpha + under));
        }
        below[3] = T::rounded((alpha + under) * full);
    }
}

/// Composites a sample with this alpha over one of an opaque background, to the nearest sample. No mean lies half-way
/// between two samples, as their full range is odd: whole numbers and floating point give the same result.
#[inline]
pub fn on_opaque<T: Sample>(above: T, alpha: T, below: T) -> T {
    let (full, alpha) = (T::FULL.whole(), alpha.whole());
    T::narrowed((above.whole() * alpha + below.whole() * (full - alpha) + full / 2) / full)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laid<T: Sample>(above: [T; 4], mut below: [T; 4]) -> [T; 4] {
        straight(&mut below, &above);
        below
    }

    #[test]
    fn an_opaque_colour_replaces_and_an_empty_one_changes_nothing() {
        let below = [1, 2, 3, 200_u8];
        assert_eq!(laid([9, 8, 7, 255], below), [9, 8, 7, 255]);
        assert_eq!(laid([9, 8, 7, 0], below), below);
        assert_eq!(laid([9_u16, 8, 7, 5], [0; 4]), [9, 8, 7, 5]);
        let light = [0.2, 0.3, 0.4, 0.5];
        assert_eq!(premultiplied([0.9, 0.8, 0.7, 1.0], light), [0.9, 0.8, 0.7, 1.0]);
        assert_eq!(premultiplied([0.0; 4], light), light);
    }

    #[test]
    fn straight_over_is_premultiplied_over() {
        let colours = [[250, 3, 77, 255], [10, 200, 30, 128], [0, 0, 255, 1], [90, 90, 90, 77_u8]];
        for (above, below) in colours.iter().flat_map(|a| colours.iter().map(move |b| (*a, *b))) {
            let light = |colour: [u8; 4]| {
                let alpha = f32::from(colour[3]) / 255.0;
                std::array::from_fn(|c| if c == 3 { alpha } else { f32::from(colour[c]) * alpha })
            };
            let expected = premultiplied(light(above), light(below));
            let found = laid(above, below);
            assert!((f32::from(found[3]) - 255.0 * expected[3]).abs() <= 0.501);
            for c in 0..3 {
                assert!(
                    (f32::from(found[c]) - expected[c] / expected[3]).abs() <= 0.501,
                    "{above:?} {below:?}"
                );
            }
        }
    }

    #[test]
    fn on_an_opaque_ground_whole_numbers_say_what_straight_over_says() {
        for (above, below) in [(0, 255), (255, 0), (10, 250), (200, 120), (33, 33_u8)] {
            for alpha in 0..=255 {
                let expected = laid([above, 0, 0, alpha], [below, 0, 0, 255]);
                assert_eq!([on_opaque(above, alpha, below), 255], [expected[0], expected[3]]);
                let [a, b, share] = [above, below, alpha].map(f32::from);
                let mixed = (a * (share / 255.0) + b * (1.0 - share / 255.0)).round();
                assert_eq!(f32::from(on_opaque(above, alpha, below)), mixed);
            }
        }
        assert_eq!(on_opaque(65535_u16, 32768, 0), 32768);
    }
}
