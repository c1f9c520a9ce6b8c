//! Converts colours between ICC profiles.

use std::sync::Arc;

use moxcms::{ColorProfile, Layout, Transform16BitExecutor, TransformOptions};

use quadratura_files::guarded::guarded_bytes;
use quadratura_layered_files::srgb::srgb_profile;

/// Two profiles count as equal if their colours differ by less than this (of 65535; two steps of 8 bits).
/// Editors write sRGB in several ways that differ by up to one step (220 between ours and that of moxcms).
const SAME: u16 = 514;

/// A conversion from one ICC profile to another, for R, G, B, A of 16 bits.
pub struct Conversion {
    transform: Arc<Transform16BitExecutor>,
}

impl Conversion {
    /// Builds the conversion between two profiles; `None` as an argument stands for sRGB. Returns `None`
    /// where the profiles are equivalent.
    ///
    /// # Errors
    /// A sentence that says why a profile cannot be used.
    pub fn between(from: Option<&[u8]>, to: Option<&[u8]>) -> Result<Option<Self>, String> {
        if from == to {
            return Ok(None);
        }
        let (from, to) = (parsed(from)?, parsed(to)?);
        let options = TransformOptions::default();
        let unusable = |why: String| format!("a colour profile cannot be converted: {why}");
        let transform =
            guarded_bytes(|| from.create_transform_16bit(Layout::Rgba, &to, Layout::Rgba, options));
        let transform = transform.map_err(unusable)?.map_err(|error| unusable(format!("{error:?}")))?;
        let conversion = Self { transform };
        Ok((!conversion.changes_nothing()).then_some(conversion))
    }

    /// Converts colours to the other profile; alpha stays as it is.
    pub fn converted(&self, colours: &[[u16; 4]]) -> Vec<[u16; 4]> {
        let mut out = vec![[0u16; 4]; colours.len()];
        // Both slices are as long as the layout requires, which is the only error that it reports.
        if self.transform.transform(colours.as_flattened(), out.as_flattened_mut()).is_err() {
            return colours.to_vec();
        }
        out.iter_mut().zip(colours).for_each(|(out, colour)| out[3] = colour[3]);
        out
    }

    fn changes_nothing(&self) -> bool {
        let steps: Vec<u16> = (0..=16u32).map(|i| (i * 65535 / 16) as u16).collect();
        let lattice: Vec<[u16; 4]> = steps
            .iter()
            .flat_map(|&r| steps.iter().map(move |&g| (r, g)))
            .flat_map(|(r, g)| steps.iter().map(move |&b| [r, g, b, u16::MAX]))
            .collect();
        let converted = self.converted(&lattice);
        lattice.as_flattened().iter().zip(converted.as_flattened()).all(|(a, b)| a.abs_diff(*b) < SAME)
    }
}

fn parsed(profile: Option<&[u8]>) -> Result<ColorProfile, String> {
    let own = profile.is_none().then(srgb_profile);
    let bytes = profile.or(own.as_deref()).expect("one of the two is there");
    let unreadable = |why: String| format!("a colour profile cannot be read: {why}");
    let parsed = guarded_bytes(|| ColorProfile::new_from_slice(bytes)).map_err(unreadable)?;
    parsed.map_err(|error| unreadable(format!("{error:?}")))
}

/// Returns a profile other than sRGB, for tests.
pub fn adobe_rgb() -> Vec<u8> {
    ColorProfile::new_adobe_rgb().encode().expect("a profile of our own making can be written")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_of_srgb_by_different_authors_are_equivalent() {
        let theirs = ColorProfile::new_srgb().encode().unwrap();
        assert!(Conversion::between(Some(&theirs), None).unwrap().is_none());
        assert!(Conversion::between(None, Some(&srgb_profile())).unwrap().is_none());
    }

    #[test]
    fn colours_go_to_another_profile_and_back_within_a_step_of_8_bits() {
        let adobe = adobe_rgb();
        let there = Conversion::between(None, Some(&adobe)).unwrap().expect("it is another one");
        let back = Conversion::between(Some(&adobe), None).unwrap().expect("it is another one");
        let colours: Vec<[u16; 4]> = (0..64u32)
            .map(|i| [i * 1000 % 65536, i * 3000 % 65536, i * 7000 % 65536, 500].map(|v| v as u16))
            .collect();
        let found = back.converted(&there.converted(&colours));
        for (colour, found) in colours.iter().zip(&found) {
            let worst = (0..3).map(|i| colour[i].abs_diff(found[i])).max().unwrap();
            assert!(worst <= 257 && found[3] == 500, "{colour:?} {found:?}");
        }
        assert_ne!(
            there.converted(&[[0, 65535, 0, 65535]])[0][0],
            0,
            "the green of sRGB is no primary there"
        );
    }

    #[test]
    fn a_broken_profile_is_an_error_in_words() {
        assert!(Conversion::between(Some(b"no profile"), None).err().unwrap().contains("cannot be read"));
    }
}
