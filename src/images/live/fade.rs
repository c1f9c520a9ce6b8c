//! The change from one layered depth image to the next: for a moment their pictures are mixed, so that nothing pops.

use std::time::Duration;

use quadratura_view::Picture;

/// How long pictures are mixed: long enough that nothing jumps, too short to look at.
pub const FADE: Duration = Duration::from_millis(200);

/// Returns the share of the new picture after a time: it rises from 0 to 1.
pub fn share_after(time: Duration) -> f32 {
    (time.as_secs_f32() / FADE.as_secs_f32()).min(1.0)
}

/// Mixes two pictures of one size by their coverage; `share` is that of the new one. For this moment, stored values stand for
/// light.
pub fn mixed(old: &Picture, new: &Picture, share: f32) -> Picture {
    let pixel = |(old, new): (&[u8; 4], &[u8; 4])| {
        let weight = |pixel: &[u8; 4], share: f32| share * f32::from(pixel[3]);
        let (before, after) = (weight(old, 1.0 - share), weight(new, share));
        let alpha = before + after;
        if alpha <= 0.0 {
            return [0; 4];
        }
        let value = |c: usize| (before * f32::from(old[c]) + after * f32::from(new[c])) / alpha;
        [value(0), value(1), value(2), alpha].map(|value| value.round() as u8)
    };
    let rgba = old.pixels().iter().zip(new.pixels()).flat_map(pixel).collect();
    Picture { rgba, ..*new }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(pixels: &[[u8; 4]]) -> Picture {
        Picture { width: pixels.len() as u32, height: 1, rgba: pixels.as_flattened().to_vec() }
    }

    #[test]
    fn a_picture_fades_from_the_old_one_to_the_new_one() {
        let old = picture(&[[100, 0, 0, 255], [10, 20, 30, 255], [0; 4], [0; 4]]);
        let new = picture(&[[200, 0, 0, 255], [0; 4], [10, 20, 30, 255], [0; 4]]);
        assert_eq!(mixed(&old, &new, 0.0), old);
        assert_eq!(mixed(&old, &new, 1.0), new);
        let middle = picture(&[[150, 0, 0, 255], [10, 20, 30, 128], [10, 20, 30, 128], [0; 4]]);
        assert_eq!(mixed(&old, &new, 0.5), middle, "colours are not darkened by what is empty");
    }

    #[test]
    fn the_new_picture_is_alone_after_a_fifth_of_a_second() {
        let shares = [0, 50, 100, 200, 900].map(|ms| share_after(Duration::from_millis(ms)));
        assert_eq!(shares, [0.0, 0.25, 0.5, 1.0, 1.0]);
    }
}
