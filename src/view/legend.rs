//! The meaning of the colours of diagnostic views. Images and legends use the same numbers: the shader's
//! constants are generated from these (`gpu/renderer/program.rs`).

use super::DisplayMode;
use quadratura_base::scene::light::{linear_of_srgb, srgb_from_linear};

/// The source of a texel's colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Origin {
    /// The photo itself.
    Photo,
    /// Paint on the photo.
    Paint,
    /// Paint on another photo, propagated.
    Propagated,
    /// Another photo.
    OtherPhoto,
    /// Patch-based inpainting.
    Example,
    /// Smooth inpainting.
    Diffused,
}

impl Origin {
    /// All sources, the most reliable first.
    pub const ALL: [Self; 6] =
        [Self::Photo, Self::Paint, Self::Propagated, Self::OtherPhoto, Self::Example, Self::Diffused];

    /// Returns the name shown to users.
    pub fn name(self) -> &'static str {
        match self {
            Self::Photo => "the photo itself",
            Self::Paint => "paint",
            Self::Propagated => "paint of another photo",
            Self::OtherPhoto => "filled from other photos",
            Self::Example => "inpainted (patch-based)",
            Self::Diffused => "inpainted (smooth)",
        }
    }

    /// Returns the colour, sRGB.
    pub fn colour(self) -> [u8; 3] {
        match self {
            Self::Photo => [0x5b, 0x8d, 0xb8],
            Self::Paint => [0xf2, 0xb1, 0x34],
            Self::Propagated => [0xd9, 0x5f, 0x02],
            Self::OtherPhoto => [0x66, 0xa6, 0x1e],
            Self::Example => [0xc8, 0x5c, 0x8e],
            Self::Diffused => [0x8a, 0x5b, 0xa6],
        }
    }
}

/// A colour ramp: sRGB colours at equal distances, interpolated in linear light.
pub type ColourRamp = &'static [[u8; 3]];

/// The ramp of confidence, from 0 to 1.
pub const CONFIDENCE: ColourRamp =
    &[[0x7a, 0x1f, 0x2e], [0xd8, 0x74, 0x3a], [0xe9, 0xd2, 0x6a], [0x4f, 0xa3, 0x6b]];

/// The ramp of agreement with the other photos, 0 to 1: what they contradict stands out from what they confirm.
pub const AGREEMENT: ColourRamp = &[[0xd0, 0x1c, 0x8b], [0xe8, 0xa8, 0xcf], [0xee, 0xf2, 0xe8]];

/// The ramp of mattes, 0 to 1; what has none has its first colour.
pub const MATTE: ColourRamp = &[[0x1c, 0x1f, 0x2b], [0xff, 0xff, 0xff]];

/// The ramp of coverage, the number of photos that show a point: 1, 2, 4, 8 and more.
pub const COVERAGE: ColourRamp =
    &[[0x6e, 0x14, 0x24], [0xd9, 0x66, 0x2e], [0xf0, 0xd0, 0x64], [0xf7, 0xf7, 0xf0]];

/// The ramp of resolution, in octaves of the photo's resolution over the view's, from -[`DENSITY_OCTAVES`] to
/// +[`DENSITY_OCTAVES`].
pub const DENSITY: ColourRamp = &[[0xe4, 0x33, 0x28], [0xf0, 0xf0, 0xf0], [0x2a, 0x5c, 0xe4]];
/// The half width of [`DENSITY`] in octaves.
pub const DENSITY_OCTAVES: u32 = 3;
/// The number of doublings of the number of photos that [`COVERAGE`] covers.
pub const COVERAGE_DOUBLINGS: u32 = 3;

/// The colour of surfaces that continue where no photo shows them, where a view shows the sources of texels; sRGB.
pub const CONTINUED: [u8; 3] = [0x3c, 0x3c, 0x46];
/// The meaning of [`CONTINUED`], for users.
pub const CONTINUED_NAME: &str = "shown by no photo, continued";
/// The colour of surfaces that no photo covers, sRGB: grey, as the background, with alpha 0 in pictures.
pub const UNCOVERED: [u8; 3] = [128; 3];
/// The colour of trees that stand in the site, where a view shows the sources of texels, which they do not have; sRGB.
pub const TREE: [u8; 3] = [0x1f, 0x78, 0x6e];
/// The meaning of [`TREE`], for users.
pub const TREE_NAME: &str = "a tree";
/// The meaning of [`UNCOVERED`], for users.
pub const UNCOVERED_NAME: &str = "not covered by any photo";

/// Interpolates a ramp at a share (0 to 1) of its length; sRGB.
pub fn colour_at(ramp: ColourRamp, share: f32) -> [u8; 3] {
    let position = share.clamp(0.0, 1.0) * (ramp.len() - 1) as f32;
    let mut mixed = linear(ramp[0]);
    for (before, stop) in ramp[1..].iter().enumerate() {
        let part = f64::from((position - before as f32).clamp(0.0, 1.0));
        let stop = linear(*stop);
        mixed = [0, 1, 2].map(|i| mixed[i] + (stop[i] - mixed[i]) * part);
    }
    stored(mixed)
}

/// Returns the colour that identifies a number, such as a photo's index: sRGB. The steps of hue, lightness and
/// saturation were chosen by a random search for the largest least distance in CIELAB: 15 among the first 19 colours
/// and 11 among the first 40 (hues a golden angle apart with nearly equal lightness had 8 and 3).
pub fn colour_of_number(number: u32) -> [u8; 3] {
    let number = number as f32;
    let hue = (number * 0.4607).fract();
    let light = 0.16 + 0.785 * (number * 0.7446).fract();
    let saturation = 0.5745 + 0.3955 * (number * 0.9868).fract();
    stored([0.0, 2.0 / 3.0, 1.0 / 3.0].map(|turn: f32| {
        let wheel = ((((hue + turn).fract() * 6.0) - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        f64::from((0.03 + (wheel - 0.03) * saturation) * light + 0.04)
    }))
}

/// Converts an sRGB colour to linear light.
pub fn linear(colour: [u8; 3]) -> [f64; 3] {
    colour.map(|byte| linear_of_srgb(f64::from(byte) / 255.0))
}

fn stored(light: [f64; 3]) -> [u8; 3] {
    light.map(|light| (srgb_from_linear(light.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

/// The legend of a view, for users.
#[derive(Debug, Clone, PartialEq)]
pub enum Legend {
    /// A list of colours, each with its meaning.
    Entries {
        /// The heading.
        title: &'static str,
        /// The meanings with their colours, sRGB.
        entries: Vec<(String, [u8; 3])>,
    },
    /// A scale along which colours vary with a value.
    Scale {
        /// The quantity, with its unit.
        title: &'static str,
        /// The colours, from left to right.
        ramp: ColourRamp,
        /// Labels at equal distances along the scale.
        marks: &'static [&'static str],
    },
    /// An explanation, where there are too many colours to list.
    Words(&'static str),
}

/// Returns the legend of a display mode; `None` where colours are those of the photos. `photos` are the
/// photos' names in the site's order, `groups` describes the groups of light.
pub fn legend(display: DisplayMode, photos: &[&str], groups: &[String]) -> Option<Legend> {
    let scale = |title, ramp, marks| Some(Legend::Scale { title, ramp, marks });
    let photo_entries = |title| {
        let entry = |(number, name): (u32, &&str)| ((*name).to_owned(), colour_of_number(number));
        Some(Legend::Entries { title, entries: (0..).zip(photos).map(entry).collect() })
    };
    match display {
        DisplayMode::Colour => None,
        DisplayMode::Weights => photo_entries("Photos by weight; stripes: several, as wide as their weights"),
        DisplayMode::BestPhoto => photo_entries("Photo with the highest weight"),
        DisplayMode::Group => {
            let entry = |(number, name): (u32, &String)| (name.clone(), colour_of_number(number));
            Some(Legend::Entries {
                title: "Groups of light",
                entries: (0..).zip(groups).map(entry).collect(),
            })
        }
        DisplayMode::Coverage => scale("Photos that cover a point", COVERAGE, &["1", "2", "4", "8 and more"]),
        DisplayMode::Density => scale("Resolution (texels per pixel)", DENSITY, &["1/8", "1", "8"]),
        DisplayMode::Confidence => scale("Confidence", CONFIDENCE, &["0 %", "33 %", "67 %", "100 %"]),
        DisplayMode::Agreement => {
            scale("Agreement of other photos", AGREEMENT, &["contradicted", "50 %", "not contradicted"])
        }
        DisplayMode::Matte => {
            scale("Covered by see-through surfaces", MATTE, &["0 %", "25 %", "50 %", "75 %", "100 %"])
        }
        DisplayMode::Provenance => {
            let origins = Origin::ALL.map(|origin| (origin.name(), origin.colour()));
            let all = origins.into_iter().chain([(CONTINUED_NAME, CONTINUED), (TREE_NAME, TREE)]);
            let entries = all.map(|(name, colour)| (name.to_owned(), colour)).collect();
            Some(Legend::Entries { title: "Source", entries })
        }
        DisplayMode::Layer => Some(Legend::Words("Every image layer has a colour of its own.")),
        DisplayMode::Item => Some(Legend::Words("Every face and every tree has a colour of its own.")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_goes_through_its_colours_and_does_not_leave_them() {
        for ramp in [CONFIDENCE, AGREEMENT, MATTE, COVERAGE, DENSITY] {
            for (index, stop) in ramp.iter().enumerate() {
                assert_eq!(colour_at(ramp, index as f32 / (ramp.len() - 1) as f32), *stop);
            }
            assert_eq!([colour_at(ramp, -1.0), colour_at(ramp, 2.0)], [ramp[0], ramp[ramp.len() - 1]]);
        }
    }

    #[test]
    fn neighbouring_photos_have_colours_that_are_told_apart() {
        let far = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > 40);
        assert!((0..40).all(|number| far(colour_of_number(number), colour_of_number(number + 1))));
        let distance =
            |a: [u8; 3], b: [u8; 3]| -> u32 { a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(b))).sum() };
        let pairs = (0..19).flat_map(|a| (0..a).map(move |b| (a, b)));
        let least = pairs.map(|(a, b)| distance(colour_of_number(a), colour_of_number(b))).min().unwrap();
        assert!(least >= 36, "{least} of 765: two photos of a site look alike");
    }

    #[test]
    fn all_but_the_photos_themselves_have_a_legend() {
        assert_eq!(legend(DisplayMode::Colour, &[], &[]), None);
        let others = [
            DisplayMode::Weights,
            DisplayMode::Coverage,
            DisplayMode::Density,
            DisplayMode::Provenance,
            DisplayMode::Item,
        ];
        assert!(others.into_iter().all(|display| legend(display, &["a.jpg"], &[]).is_some()));
        let groups = ["evening".to_owned(), "rest".to_owned()];
        let Some(Legend::Entries { entries, .. }) = legend(DisplayMode::Group, &["a.jpg"], &groups) else {
            panic!("groups are listed");
        };
        assert_eq!(entries[1], ("rest".to_owned(), colour_of_number(1)));
    }
}
