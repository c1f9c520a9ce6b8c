//! Corrects the colour profile of an image in linear light. GIMP gives such an image a profile of its own,
//! with the colours of the former one and no tone curve. The pixels are converted with sRGB's curve, so the
//! profile gets that curve, too.

use crate::srgb::tone_curve;

/// Offsets in a profile (ICC.1:2010, 7.2 and 7.3).
const ID: std::ops::Range<usize> = 84..100;
const TAG_COUNT: usize = 128;
const TAGS: usize = 132;

/// Returns the profile with the tone curve of sRGB in each channel; unchanged when it has no curves to
/// replace.
pub fn with_tone_curve(mut profile: Vec<u8>) -> Vec<u8> {
    let count = number(&profile, TAG_COUNT).unwrap_or(0) as usize;
    let curve = tone_curve();
    let at = profile.len().next_multiple_of(4);
    let size = at + curve.len();
    let tags = (0..count).map(|tag| TAGS + 12 * tag).take_while(|tag| tag + 12 <= profile.len());
    let curves: Vec<usize> =
        tags.filter(|tag| matches!(&profile[*tag..tag + 4], b"rTRC" | b"gTRC" | b"bTRC")).collect();
    if curves.is_empty() {
        return profile;
    }
    for tag in curves {
        profile[tag + 4..tag + 8].copy_from_slice(&(at as u32).to_be_bytes());
        profile[tag + 8..tag + 12].copy_from_slice(&(curve.len() as u32).to_be_bytes());
    }
    profile[..4].copy_from_slice(&(size as u32).to_be_bytes());
    profile[ID].fill(0); // a hash of the former content; zeros stand for none
    profile.resize(at, 0);
    profile.extend(curve);
    profile
}

fn number(profile: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_be_bytes(profile.get(at..at + 4)?.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::srgb::srgb_profile;

    /// Where a tag's data lie, and how many they are.
    fn tag(profile: &[u8], name: &[u8; 4]) -> (usize, usize) {
        let count = number(profile, TAG_COUNT).unwrap() as usize;
        let at = (0..count).map(|tag| TAGS + 12 * tag).find(|tag| &profile[*tag..tag + 4] == name).unwrap();
        (number(profile, at + 4).unwrap() as usize, number(profile, at + 8).unwrap() as usize)
    }

    #[test]
    fn a_linear_profile_gets_the_curve_and_keeps_its_colours() {
        let mut linear = srgb_profile();
        let (at, length) = tag(&linear, b"rTRC");
        linear[at..at + length].fill(0);
        let found = with_tone_curve(linear.clone());
        assert_eq!(number(&found, 0), Some(found.len() as u32));
        for name in [b"rTRC", b"gTRC", b"bTRC"] {
            let (at, length) = tag(&found, name);
            assert_eq!(found[at..at + length], tone_curve());
        }
        for name in [b"rXYZ", b"wtpt"] {
            let ((old, length), (new, _)) = (tag(&linear, name), tag(&found, name));
            assert_eq!(linear[old..old + length], found[new..new + length]);
        }
    }

    #[test]
    fn data_that_is_no_profile_is_returned_unchanged() {
        for bytes in [vec![], vec![255; 140], vec![7; 131]] {
            assert_eq!(with_tone_curve(bytes.clone()), bytes);
        }
    }
}
