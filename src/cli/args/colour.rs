//! Arguments of `colour`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use quadratura_document::colour::MOST_STOPS;
use quadratura_projection::exposure::ExposureRule;

#[derive(Debug, Args)]
pub struct ColourArgs {
    /// The project folder
    pub project: PathBuf,
    /// Fix this photo's gain, in stops by which it is brighter than the common exposure: red, green and blue,
    /// or one number for all three (may be given several times)
    #[arg(long, value_name = "PHOTO=R,G,B", value_parser = fixed_gain)]
    pub fix: Vec<(String, [f64; 3])>,
    /// Exclude this photo from the estimate: its own gain is 0 unless it is fixed (may be given several
    /// times)
    #[arg(long, value_name = "PHOTO")]
    pub leave_out: Vec<String>,
    /// Remove what was fixed or left out for this photo (may be given several times)
    #[arg(long, value_name = "PHOTO")]
    pub free: Vec<String>,
    /// Render with the exposure of this photo; `none`: by the rule of --exposure
    #[arg(long, value_name = "PHOTO|none")]
    pub reference: Option<String>,
    /// Put these photos into a group of light of their own, such as those of another hour (may be given several times;
    /// `rest=PHOTO` takes a photo out of its group); auto: find groups; off: all photos are one group
    #[arg(long, value_name = "NAME=PHOTO,...|auto|off", value_parser = light_group)]
    pub group: Vec<GroupArg>,
    /// The rule by which pictures are exposed
    #[arg(long, value_enum)]
    pub exposure: Option<RuleArg>,
    /// Show, fill and compare photos without exposure matching, but keep all settings
    #[arg(long, conflicts_with = "on")]
    pub off: bool,
    /// Match exposures again
    #[arg(long)]
    pub on: bool,
    /// Remove vignetting from pictures, for cameras with four or more photos that share enough points; auto: pictures keep it
    /// where that predicts left-out photos better; off: ignore it
    #[arg(long, value_enum)]
    pub vignetting: Option<VignettingArg>,
    /// Estimate and correct light that was added everywhere in a photo (haze, a wrong black level)
    #[arg(long, value_enum)]
    pub offset: Option<Switch>,
    /// Remove all settings first, before applying the others of this command
    #[arg(long)]
    pub reset: bool,
}

/// A change of the groups of light.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum GroupArg {
    /// Groups are found.
    Auto,
    /// All photos are one group.
    Off,
    /// These photos are in the group of this name.
    Named(String, Vec<String>),
}

/// The rules for the exposure of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum RuleArg {
    /// The rule that predicts the project's photos best when each is left out
    Auto,
    /// The exposure of photos taken nearby
    Near,
    /// As an exposure meter would choose it, where the photos' exposures follow their meters
    Metered,
    /// The common exposure of all photos
    Common,
    /// The photos as they are
    Raw,
}

impl RuleArg {
    /// Returns the rule; `None` to decide it by leaving photos out.
    pub fn rule(self) -> Option<ExposureRule> {
        match self {
            Self::Auto => None,
            Self::Near => Some(ExposureRule::Near),
            Self::Metered => Some(ExposureRule::Metered),
            Self::Common => Some(ExposureRule::Common),
            Self::Raw => Some(ExposureRule::Raw),
        }
    }
}

/// What is done about vignetting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum VignettingArg {
    On,
    Off,
    Auto,
}

impl VignettingArg {
    /// Returns whether vignetting is removed or ignored; `None` to decide it by leaving photos out.
    pub fn removed(self) -> Option<bool> {
        match self {
            Self::On => Some(true),
            Self::Off => Some(false),
            Self::Auto => None,
        }
    }
}

/// The value of an option that is switched on or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    On,
    Off,
}

/// Parses `NAME=PHOTO,PHOTO`, `auto` or `off`.
fn light_group(text: &str) -> Result<GroupArg, String> {
    match text {
        "auto" => return Ok(GroupArg::Auto),
        "off" => return Ok(GroupArg::Off),
        _ => (),
    }
    let named = text.split_once('=').map(|(name, photos)| (name.trim(), photos));
    let listed = |photos: &str| -> Vec<String> {
        photos.split(',').map(|photo| photo.trim().to_owned()).filter(|photo| !photo.is_empty()).collect()
    };
    let (name, photos) = named
        .map(|(name, photos)| (name, listed(photos)))
        .filter(|(name, photos)| !name.is_empty() && !photos.is_empty())
        .ok_or("expected a name and photos such as evening=0004,0007, or auto, or off")?;
    Ok(GroupArg::Named(name.to_owned(), photos))
}

/// Parses `PHOTO=R,G,B` or `PHOTO=STOPS`.
fn fixed_gain(text: &str) -> Result<(String, [f64; 3]), String> {
    let expected =
        || format!("expected a photo and stops such as 0001.jpg=0.5,0.4,0.4, {MOST_STOPS} at most");
    // Names may contain a `=`, stops never do.
    let (photo, stops) = text.rsplit_once('=').ok_or_else(expected)?;
    let stops: Vec<f64> =
        stops.split(',').map(|s| s.trim().parse()).collect::<Result<_, _>>().map_err(|_| expected())?;
    let stops = match stops[..] {
        [all] => [all; 3],
        [r, g, b] => [r, g, b],
        _ => return Err(expected()),
    };
    let in_range = !photo.is_empty() && stops.iter().all(|s| s.abs() <= MOST_STOPS);
    if in_range { Ok((photo.to_owned(), stops)) } else { Err(expected()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_have_a_name_and_photos() {
        let photos = ["0004", "0007.jpg"].map(String::from).to_vec();
        assert_eq!(light_group("evening=0004, 0007.jpg"), Ok(GroupArg::Named("evening".into(), photos)));
        assert_eq!((light_group("auto"), light_group("off")), (Ok(GroupArg::Auto), Ok(GroupArg::Off)));
        for text in ["evening", "=0004", "evening=", "evening=,", ""] {
            assert!(light_group(text).is_err(), "{text}");
        }
    }

    #[test]
    fn gains_are_three_numbers_or_one_and_photos_may_have_any_name() {
        assert_eq!(fixed_gain("a=b.jpg=0.5,-1,0"), Ok(("a=b.jpg".into(), [0.5, -1.0, 0.0])));
        assert_eq!(fixed_gain("1.jpg=-0.5"), Ok(("1.jpg".into(), [-0.5; 3])));
        for text in ["1.jpg", "1.jpg=", "1.jpg=1,2", "=1", "1.jpg=NaN", "1.jpg=99"] {
            assert!(fixed_gain(text).is_err(), "{text}");
        }
    }
}
