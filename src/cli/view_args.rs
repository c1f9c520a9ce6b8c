//! What may be typed for `render` and `score`.

use std::path::PathBuf;

use clap::builder::RangedU64ValueParser;
use clap::{ArgGroup, Args, ValueEnum};

use crate::error::{Error, Result};
use crate::gpu::Storage;
use crate::io::cameras::accepted;
use crate::projection::{Blend, Exposure, Mode, PhotoId, Quality, Shown};
use crate::recipe::colour::reference;
use crate::recipe::named::place_of_photo;
use crate::recipe::open::Opened;
use crate::recipe::preview::PreviewOptions;
use crate::recipe::render::Look;
use crate::recipe::views::{Size, ViewSource};

/// What `--cameras` takes for the photos themselves.
const PHOTOS: &str = "photos";

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("views").args(["cameras", "through"]).required(true))]
pub struct RenderArgs {
    /// The project's folder
    pub project: PathBuf,
    #[arg(long, value_name = "PATH", help = format!(
        "From where: a list of photos of the project (.txt, one a line), a camera path (.json), the word `photos` for \
         all photos of the project (a folder of that name is ./photos), or cameras: {}",
        accepted()
    ))]
    pub cameras: Option<PathBuf>,
    /// A flight through these photos of the project, two seconds from one to the next
    #[arg(long, value_name = "PHOTO,PHOTO,..", value_delimiter = ',')]
    pub through: Vec<String>,
    /// The folder to write to; camera 0001.jpg gives 0001.png, flights give frame-00001.png and so on
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// The size of pictures [default: the camera's]. Another proportion keeps the vertical field of
    /// view, and cuts or widens evenly left and right
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// Pictures with so many times the camera's pixels along each side
    #[arg(long, value_name = "S", value_parser = parse_scale, conflicts_with = "size")]
    pub scale: Option<f64>,
    /// What to show of the view
    #[arg(long, value_enum, default_value_t)]
    pub show: ShowArg,
    /// A film of all pictures; its name ends with .apng, or where ffmpeg is installed with .mp4, .webm,
    /// .gif or .webp. An old one is replaced
    #[arg(long, value_name = "FILE")]
    pub video: Option<PathBuf>,
    /// Frames a second of a flight and of the film [default: the path's, else 25]
    #[arg(long, value_name = "N", value_parser = parse_fps)]
    pub fps: Option<f64>,
    /// What is behind the model in the film, as red, green and blue in hexadecimal
    #[arg(long, value_name = "RRGGBB", value_parser = parse_colour, default_value = "c9d4de")]
    pub background: [u8; 3],
    /// Write the flight as a camera path, too, to edit it and give it to --cameras
    #[arg(long, value_name = "FILE", requires = "through")]
    pub write_path: Option<PathBuf>,
    #[command(flatten)]
    pub look: LookArgs,
}

#[derive(Debug, Args)]
pub struct ScoreArgs {
    /// The project's folder
    pub project: PathBuf,
    /// Cameras of photos that were held out, in any format that `new` reads [default: each photo of the project is
    /// predicted from the others]
    #[arg(long, value_name = "PATH", requires = "photos")]
    pub cameras: Option<PathBuf>,
    /// The folder of the held-out photos
    #[arg(long, value_name = "DIR", requires = "cameras")]
    pub photos: Option<PathBuf>,
    /// The size at which photos are compared
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// The same as a share of the photo's along each side [default: 0.5]
    #[arg(long, value_name = "S", value_parser = parse_scale, conflicts_with = "size")]
    pub scale: Option<f64>,
    /// Leave out pixels that show this object (may be given several times; `NAME*` for all that begin
    /// so)
    #[arg(long, value_name = "OBJECT")]
    pub ignore: Vec<String>,
    /// Leave out pixels that show no surface of the model
    #[arg(long)]
    pub ignore_background: bool,
    /// Write photo, prediction and difference side by side to this folder
    #[arg(long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
    #[command(flatten)]
    pub look: LookArgs,
}

/// How views look.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "How photos are blended")]
pub struct LookArgs {
    /// How photos share a surface point
    #[arg(long, value_enum, default_value_t)]
    pub mode: ModeArg,
    /// Preview: one sample a pixel; final: smooth edges, sharp slanting surfaces
    #[arg(long, value_enum, default_value_t)]
    pub quality: QualityArg,
    /// At most so many photos share a surface point [default: 4]
    #[arg(long, value_name = "K", value_parser = RangedU64ValueParser::<u32>::new().range(1..=Blend::MOST.into()))]
    pub photos_per_point: Option<u32>,
    /// The exposure of pictures [default of render: reference where `colour` chose one, else near; of
    /// score: near]
    #[arg(long, value_enum)]
    pub exposure: Option<ExposureArg>,
    /// Show faces flat, as they were modelled, without the relief that the photos tell
    #[arg(long)]
    pub flat: bool,
    /// Leave out the backs of faces, which no photo serves: one looks into courtyards from outside
    #[arg(long)]
    pub without_backs: bool,
    /// Show hidden texels empty, as the photos left them, whatever filled them
    #[arg(long)]
    pub unfilled: bool,
    /// Bytes of textures on the GPU, at most, such as 2G: where they do not hold all, textures are coarser
    /// [default: 4G]
    #[arg(long, value_name = "BYTES", value_parser = super::bytes::parse_bytes)]
    pub texture_memory: Option<u64>,
    /// Keep textures compressed on the GPU (BC7): a quarter of the memory, a little worse, slow to load
    #[arg(long)]
    pub compressed: bool,
    /// Leave this photo out (may be given several times)
    #[arg(long, value_name = "PHOTO")]
    pub without: Vec<String>,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub enum ModeArg {
    /// The best photo alone
    Best,
    /// By angles (Debevec 1998)
    Debevec,
    /// Unstructured lumigraph (Buehler 2001)
    Lumigraph,
    /// Once continuously differentiable weights: changes most gradually
    #[default]
    Smooth,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub enum QualityArg {
    Preview,
    #[default]
    Final,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ExposureArg {
    /// That of the photos taken near by
    Near,
    /// That of the photo that `colour --reference` chose
    Reference,
    /// The one that all photos are brought to
    Common,
    /// Photos as they are
    Raw,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum ShowArg {
    /// The blended photos
    #[default]
    Colour,
    /// Which photo paints what, a colour a photo, mixed by weight
    Weights,
    /// The photo of the largest weight, as its colour
    BestPhoto,
    /// Texels of the best photo per pixel, in octaves around one
    Density,
    /// The largest confidence among the photos that serve
    Confidence,
    /// The image layer of the best photo, as a colour
    Layer,
    /// The face, as a colour
    Item,
    /// How many photos serve the point
    Coverage,
    /// Where it comes from: the photo, paint, other photos, or invention
    Provenance,
    /// A photo's layers as sheets one behind the other, seen from the side
    Exploded,
}

impl LookArgs {
    /// How the project is made ready for it.
    pub fn preview(&self) -> PreviewOptions {
        let mut options =
            PreviewOptions { relief: !self.flat, filled: !self.unfilled, ..PreviewOptions::default() };
        options.textures.budget_bytes = self.texture_memory.unwrap_or(options.textures.budget_bytes);
        if self.compressed {
            options.textures.storage = Storage::Compressed;
        }
        options
    }

    /// The look that was asked for; `usual` is the exposure where none was.
    ///
    /// # Errors
    /// [`Error::Request`] for a photo to leave out that the project does not have, when none would be
    /// left, and for the exposure of a reference that was not chosen.
    pub fn look(&self, opened: &Opened, shown: Shown, usual: Exposure) -> Result<Look> {
        let blend = Blend::default();
        let without = self.without.iter().map(|name| place_of_photo(&opened.site, name));
        let without: Vec<_> = without.map(|place| Ok(PhotoId(place? as u32))).collect::<Result<_>>()?;
        if (0..opened.site.photos.len() as u32).all(|photo| without.contains(&PhotoId(photo))) {
            return Err(Error::Request("--without leaves no photo to make a view of".into()));
        }
        Ok(Look {
            blend: Blend {
                mode: self.mode.into(),
                photos: self.photos_per_point.unwrap_or(blend.photos),
                ..blend
            },
            quality: match self.quality {
                QualityArg::Preview => Quality::Preview,
                QualityArg::Final => Quality::Final,
            },
            shown,
            exposure: match self.exposure {
                None => usual,
                Some(ExposureArg::Near) => Exposure::Near,
                Some(ExposureArg::Reference) => exposure_of_reference(opened)?,
                Some(ExposureArg::Common) => Exposure::Common,
                Some(ExposureArg::Raw) => Exposure::Raw,
            },
            flat: self.flat,
            without_backs: self.without_backs,
            without,
        })
    }
}

fn exposure_of_reference(opened: &Opened) -> Result<Exposure> {
    let reference = reference(&opened.project.colour, &opened.site).map(Exposure::Of);
    reference.ok_or_else(|| {
        Error::Request(
            "--exposure reference: there is none; `quadratura colour --reference` chooses one".into(),
        )
    })
}

/// An exposure as it is typed.
pub fn exposure_name(exposure: Exposure) -> &'static str {
    match exposure {
        Exposure::Near => "near",
        Exposure::Of(_) => "reference",
        Exposure::Common => "common",
        Exposure::Raw => "raw",
    }
}

impl RenderArgs {
    /// Where the views come from.
    pub fn source(&self) -> ViewSource {
        match &self.cameras {
            Some(word) if word.as_os_str() == PHOTOS => ViewSource::Photos,
            Some(path) => ViewSource::At(path.clone()),
            None => ViewSource::Through(self.through.clone()),
        }
    }
}

/// What `--size` and `--scale` ask for together.
pub fn size(size: Option<(u32, u32)>, scale: Option<f64>) -> Option<Size> {
    size.map(|(width, height)| Size::Exactly(width, height)).or(scale.map(Size::Scaled))
}

impl From<ModeArg> for Mode {
    fn from(arg: ModeArg) -> Self {
        match arg {
            ModeArg::Best => Self::Best,
            ModeArg::Debevec => Self::Debevec,
            ModeArg::Lumigraph => Self::Lumigraph,
            ModeArg::Smooth => Self::Smooth,
        }
    }
}

impl ShowArg {
    /// What is shown of a shot; none where it is no shot.
    pub fn shown(self) -> Option<Shown> {
        Some(match self {
            Self::Colour => Shown::Colour,
            Self::Weights => Shown::Weights,
            Self::BestPhoto => Shown::BestPhoto,
            Self::Density => Shown::Density,
            Self::Confidence => Shown::Confidence,
            Self::Layer => Shown::Layer,
            Self::Item => Shown::Item,
            Self::Coverage => Shown::Coverage,
            Self::Provenance => Shown::Provenance,
            Self::Exploded => return None,
        })
    }
}

/// Sides of a picture are at most so long.
const LONGEST_SIDE: u32 = 16_384;

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let possible = |side: u32| (1..=LONGEST_SIDE).contains(&side);
    sides
        .filter(|&(width, height)| possible(width) && possible(height))
        .ok_or_else(|| format!("expected a width and a height such as 960x540, {LONGEST_SIDE} at most"))
}

fn parse_scale(text: &str) -> Result<f64, String> {
    let scale = text.parse().ok().filter(|scale: &f64| *scale > 0.0 && *scale <= 8.0);
    scale.ok_or_else(|| "expected a number above 0, such as 0.5, and 8 at most".into())
}

fn parse_fps(text: &str) -> Result<f64, String> {
    let fps = text.parse().ok().filter(|fps: &f64| *fps > 0.0 && *fps <= 240.0);
    fps.ok_or_else(|| "expected a number above 0, such as 25, and 240 at most".into())
}

fn parse_colour(text: &str) -> Result<[u8; 3], String> {
    let digits = text.trim_start_matches('#');
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
    let [_, red, green, blue] = number.ok_or("expected six hexadecimal digits such as c9d4de")?.to_be_bytes();
    Ok([red, green, blue])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_scales_and_colours_are_read_as_they_are_written() {
        assert_eq!(parse_size("960x540"), Ok((960, 540)));
        assert_eq!(parse_colour("#c9d4de"), Ok([0xc9, 0xd4, 0xde]));
        assert_eq!((parse_scale("0.5"), parse_fps("29.97")), (Ok(0.5), Ok(29.97)));
        for text in ["960", "0x540", "960x", "99999x1"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
        assert!(parse_colour("fff").is_err() && parse_scale("0").is_err() && parse_fps("NaN").is_err());
    }
}
