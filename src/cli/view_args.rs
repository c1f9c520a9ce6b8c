//! Arguments of `render` and `score`.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, ValueEnum};

use super::args::{AsArgs, FramesArg, PICTURE_FORMATS, PictureArgs, one_of, whole};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{PhotoId, Site};
use quadratura_document::Project;
use quadratura_images::StackLdiOptions;
use quadratura_import::cameras::accepted;
use quadratura_projection::Storage;
use quadratura_sites::named::index_of_photo;
use quadratura_sites::views::{Size, ViewSource};
use quadratura_trees::PlantParts;
use quadratura_view::hidden::HiddenFaces;
use quadratura_view::{Blend, DisplayMode, Exposure, Mode, Quality, TreeMethod, Unseen};
use quadratura_views::colour::reference;
use quadratura_views::preview::PreviewOptions;
use quadratura_views::render::{Appearance, PictureFormat};

/// The value of `--cameras` that stands for the project's photos.
pub const PHOTOS: &str = "photos";

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("views").args(["cameras", "through", "view"]).required(true))]
pub struct RenderArgs {
    /// The project folder
    pub project: PathBuf,
    #[arg(long, value_name = "PATH", help = format!(
        "The viewpoints: a list of the project's photos (.txt, one per line), a camera path (.json), the word `photos` \
         for all photos of the project (for a folder of that name give ./photos), or cameras: {}",
        accepted()
    ))]
    pub cameras: Option<PathBuf>,
    /// Fly through these photos of the project, two seconds from one to the next
    #[arg(long, value_name = "PHOTO,PHOTO,..", value_delimiter = ',')]
    pub through: Vec<String>,
    /// Render this view that is saved in the project (may be given several times), 1920 x 1080 unless --size says
    /// otherwise
    #[arg(long, value_name = "NAME")]
    pub view: Vec<String>,
    /// Render only these of the views, counted from 1, such as 101-200; or part K of N, such as 3/40
    #[arg(long, value_name = "A-B|K/N", value_parser = FramesArg::parse, conflicts_with = "video")]
    pub frames: Option<FramesArg>,
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// The format of the pictures
    #[arg(long, value_parser = one_of(PICTURE_FORMATS), default_value = "png")]
    pub format: PictureFormat,
    /// Select what is shown
    #[arg(long, value_enum, default_value_t)]
    pub show: ShowArg,
    /// Draw the legend of --show into the pictures; it is printed in any case
    #[arg(long)]
    pub legend: bool,
    /// What is shown where no surface is: the photos' surroundings, a sky that is computed, clear, hazy or overcast as they
    /// show it, nothing (pictures are transparent there), or a colour, red, green and blue in hexadecimal
    #[arg(long, value_name = "surroundings|sky|none|#RRGGBB", value_parser = parse_background,
          default_value = "surroundings")]
    pub background: Background,
    /// Cameras and camera paths of files, --write-path too, are in the site's frame (`quadratura frame`), as exports write them
    #[arg(long)]
    pub in_frame: bool,
    /// Also write the flight as a camera path, to be edited and given to --cameras
    #[arg(long, value_name = "FILE", requires = "through")]
    pub write_path: Option<PathBuf>,
    #[command(flatten)]
    pub look: LookArgs,
    #[command(flatten)]
    pub made: AsArgs,
}

#[derive(Debug, Args)]
pub struct ScoreArgs {
    /// The project folder
    pub project: PathBuf,
    /// Cameras of held-out photos, in any format that `new` reads [default: each photo of the project is
    /// predicted from the others]
    #[arg(long, value_name = "PATH", requires = "photos")]
    pub cameras: Option<PathBuf>,
    /// The folder of the held-out photos
    #[arg(long, value_name = "DIR", requires = "cameras")]
    pub photos: Option<PathBuf>,
    /// The size at which photos are compared
    #[arg(long, value_name = "WxH", value_parser = parse_size, allow_hyphen_values = true)]
    pub size: Option<(u32, u32)>,
    /// The size at which photos are compared, as a factor of the photo's width and height [default: 0.5]
    #[arg(long, value_name = "S", value_parser = parse_scale, conflicts_with = "size")]
    pub scale: Option<f64>,
    /// Compare only pixels that show this object (may be given several times; `*` stands for any characters)
    #[arg(long, value_name = "OBJECT")]
    pub only: Vec<String>,
    /// Leave out pixels that show this object (may be given several times; `*` stands for any characters)
    #[arg(long, value_name = "OBJECT")]
    pub ignore: Vec<String>,
    /// Leave out pixels that show no surface of the model
    #[arg(long)]
    pub ignore_background: bool,
    /// What is predicted where no surface is: the photos' surroundings, or nothing, which counts as black
    #[arg(long, value_enum, default_value_t)]
    pub background: ScoreBackground,
    /// Write photo, prediction and difference side by side to this folder
    #[arg(long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
    #[command(flatten)]
    pub look: LookArgs,
    #[command(flatten)]
    pub made: AsArgs,
}

/// What pictures show where no surface of the model is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Background {
    /// The photos' surroundings.
    Surroundings,
    /// A plain sky.
    Sky,
    /// Nothing.
    None,
    /// A colour, sRGB.
    Colour([u8; 3]),
}

/// What predictions show where no surface of the model is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum ScoreBackground {
    #[default]
    Surroundings,
    None,
}

/// The look of views.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "How photos are blended")]
pub struct LookArgs {
    /// How photos are blended at a surface point
    #[arg(long, value_parser = one_of(MODES), default_value = "smooth")]
    pub mode: Mode,
    /// Preview: one sample per pixel; final: up to 8 x 8 samples, as finely as the photos show what is in the picture,
    /// with smooth edges and sharp surfaces at grazing angles
    #[arg(long, value_parser = one_of(QUALITIES), default_value = "final")]
    pub quality: Quality,
    /// Leave out surfaces and surroundings that no photo shows, instead of continuing them from what photos show
    #[arg(long)]
    pub holes: bool,
    /// Maximum photos blended per point [default: 4]
    #[arg(long, value_name = "K", value_parser = whole::<u32>(1..=Blend::MOST))]
    pub photos_per_point: Option<u32>,
    /// Exposure of the pictures [default: by the rule that predicts the project's own photos best, or that `colour` has
    /// set; of render: reference where `colour` has set one]
    #[arg(long, value_enum)]
    pub exposure: Option<ExposureArg>,
    /// Expose the pictures like this photo of the project, and show the light of its group
    #[arg(long, value_name = "PHOTO", conflicts_with = "exposure")]
    pub like: Option<String>,
    /// Show faces flat, as modelled, without depth detail from photos
    #[arg(long)]
    pub flat: bool,
    /// Whether photos count less where others contradict them
    #[arg(long, value_enum, default_value_t)]
    pub agreement: OnOff,
    /// Show what the other photos show where they contradict a photo, in its own camera, too
    #[arg(long)]
    pub without_transients: bool,
    /// How the trees of the project are drawn
    #[arg(long, value_parser = one_of(TREES), default_value = "flakes")]
    pub trees: TreeMethod,
    /// Leave out back faces, which no photo covers, so that views into courtyards from outside are open
    #[arg(long)]
    pub without_backs: bool,
    /// Show occluded areas empty, without their filling
    #[arg(long)]
    pub unfilled: bool,
    /// Limit on textures in GPU memory, such as 2G; if they do not fit, they are coarser [default: 4G]
    #[arg(long, value_name = "BYTES", value_parser = super::bytes::parse_bytes, allow_hyphen_values = true)]
    pub texture_memory: Option<u64>,
    /// Compress textures in GPU memory (BC7): a quarter of the memory, slightly lower quality, slower to load
    #[arg(long)]
    pub compressed: bool,
    /// Leave out these photos (may be given several times)
    #[arg(long, value_name = "PHOTO,PHOTO,..", value_delimiter = ',')]
    pub without: Vec<String>,
}

/// The ways to draw the trees of a project.
const TREES: &[(&str, TreeMethod, &str)] = &[
    (
        "flakes",
        TreeMethod::Flakes,
        "From images of their parts, which are made the first time (`quadratura tree bake`), and polygons where these are too coarse",
    ),
    ("polygons", TreeMethod::Polygons, "Every polygon of every tree"),
    ("none", TreeMethod::None, "Leave trees out; what they replace does not come back"),
];

/// The ways to blend photos.
const MODES: &[(&str, Mode, &str)] = &[
    ("best", Mode::Best, "The best photo only"),
    ("debevec", Mode::Debevec, "By angle (Debevec 1998)"),
    ("lumigraph", Mode::Lumigraph, "Unstructured lumigraph (Buehler 2001)"),
    ("smooth", Mode::Smooth, "Continuously differentiable weights, which change most gradually"),
];

/// The qualities of pictures.
pub const QUALITIES: &[(&str, Quality, &str)] =
    &[("preview", Quality::Preview, ""), ("final", Quality::Final, "")];

/// The exposures of pictures.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ExposureArg {
    /// The exposure of photos taken nearby
    Near,
    /// As an exposure meter would choose it, where the photos' exposures follow their meters
    Metered,
    /// The exposure of the photo set with `colour --reference`
    Reference,
    /// The common exposure of all photos
    Common,
    /// The photos as they are
    Raw,
}

/// Whether something is done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum OnOff {
    #[default]
    On,
    Off,
}

/// The display modes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum ShowArg {
    /// The blended photos
    #[default]
    Colour,
    /// Which photos contribute: one colour per photo, mixed by weight
    Weights,
    /// The photo with the largest weight, by its colour
    BestPhoto,
    /// The group of light of the best photo (`quadratura colour` lists the groups)
    Group,
    /// Resolution (texels of the best photo per pixel), in octaves around one
    Density,
    /// Confidence: the largest among the photos that cover the point
    Confidence,
    /// Agreement: how far other photos confirm the photo that is nearest in direction and resolution
    Agreement,
    /// The image layer of the best photo, by its colour; of layered depth images how deep a depth pixel lies
    Layer,
    /// The face, by its colour
    Item,
    /// Number of photos that cover the point
    Coverage,
    /// Matte: how much of what is behind them see-through surfaces such as trees cover
    Matte,
    /// Source of the texels: the photo, paint, other photos, or inpainted
    Provenance,
    /// A photo's layers as sheets one behind the other, seen from the side
    Exploded,
    /// Why faces have no colour in views from layered depth images (`--as ldi`, `--as photo`)
    Holes,
}

impl LookArgs {
    /// Returns how the project is prepared for this look.
    pub fn preview(&self) -> PreviewOptions {
        let mut options = PreviewOptions {
            relief: !self.flat,
            agreement: self.agreement == OnOff::On,
            filled: !self.unfilled,
            tree_parts: match self.trees {
                TreeMethod::Flakes => PlantParts::Images,
                TreeMethod::Polygons => PlantParts::Openness,
                TreeMethod::None => PlantParts::Nothing,
            },
            ..PreviewOptions::default()
        };
        options.textures.budget_bytes = self.texture_memory.unwrap_or(options.textures.budget_bytes);
        if self.compressed {
            options.textures.storage = Storage::Compressed;
        }
        options
    }

    /// Returns what layered depth images take from stacks for this look.
    pub fn stack(&self, surroundings: bool) -> StackLdiOptions {
        StackLdiOptions { relief: !self.flat, filled: !self.unfilled, surroundings }
    }

    /// Returns the look for these arguments; `usual` is the exposure if none was given.
    ///
    /// # Errors
    /// [`Error::Request`] for `--without-transients` and `--show agreement` without agreement, for an unknown photo in
    /// `--without`, when no photo is left, and for the exposure of a reference that is not set.
    pub fn look(
        &self,
        project: &Project,
        site: &Site,
        display: DisplayMode,
        usual: Exposure,
    ) -> Result<Appearance> {
        if self.without_transients && self.agreement == OnOff::Off {
            let found = "--without-transients needs the agreement of photos; leave out --agreement off";
            return Err(Error::Request(found.into()));
        }
        if display == DisplayMode::Agreement && self.agreement == OnOff::Off {
            let found = "--show agreement needs the agreement of photos; leave out --agreement off";
            return Err(Error::Request(found.into()));
        }
        let blend = Blend::default();
        let without = self.without.iter().map(|name| index_of_photo(site, name));
        let without: Vec<PhotoId> = without.collect::<Result<_>>()?;
        if site.photo_ids().all(|photo| without.contains(&photo)) {
            return Err(Error::Request("--without leaves no photo to render from".into()));
        }
        Ok(Appearance {
            blend: Blend {
                mode: self.mode,
                photos: self.photos_per_point.unwrap_or(blend.photos),
                agreement: self.agreement == OnOff::On,
                without_transients: self.without_transients,
                ..blend
            },
            quality: self.quality,
            display,
            exposure: match self.exposure {
                None => self.like(site)?.unwrap_or(usual),
                Some(ExposureArg::Near) => Exposure::Near,
                Some(ExposureArg::Metered) => Exposure::Metered,
                Some(ExposureArg::Reference) => exposure_of_reference(project, site)?,
                Some(ExposureArg::Common) => Exposure::Common,
                Some(ExposureArg::Raw) => Exposure::Raw,
            },
            trees: self.trees,
            flat: self.flat,
            without_backs: self.without_backs,
            without_surroundings: false,
            supersampled: self.quality == Quality::Final,
            unseen: if self.holes { Unseen::Empty } else { Unseen::Continued },
            without,
            hidden: HiddenFaces::default(),
        })
    }

    /// Returns the exposure of the photo that pictures are to be like.
    fn like(&self, site: &Site) -> Result<Option<Exposure>> {
        let name = self.like.as_deref();
        name.map(|name| Ok(Exposure::Of(index_of_photo(site, name)?))).transpose()
    }
}

fn exposure_of_reference(project: &Project, site: &Site) -> Result<Exposure> {
    let reference = reference(&project.colour, site).map(Exposure::Of);
    reference.ok_or_else(|| {
        Error::Request(
            "--exposure reference: no reference is set; `quadratura colour --reference` sets one".into(),
        )
    })
}

/// Returns the word for an exposure on the command line.
pub fn exposure_name(exposure: Exposure) -> &'static str {
    match exposure {
        Exposure::Decided => "decided",
        Exposure::Near => "near",
        Exposure::Metered => "metered",
        Exposure::Of(_) => "reference",
        Exposure::AsTaken(_) => "as taken",
        Exposure::Common => "common",
        Exposure::Raw => "raw",
    }
}

impl RenderArgs {
    /// Returns where the views come from.
    pub fn source(&self) -> ViewSource {
        match &self.cameras {
            Some(path) => photos_or_path(path),
            None if !self.view.is_empty() => ViewSource::Saved(self.view.clone()),
            None => ViewSource::Through(self.through.clone()),
        }
    }
}

/// Returns the views of a path, or of the word for all photos.
pub fn photos_or_path(path: &Path) -> ViewSource {
    if path.as_os_str() == PHOTOS { ViewSource::Photos } else { ViewSource::At(path.to_path_buf()) }
}

/// Combines `--size` and `--scale`.
pub fn size(size: Option<(u32, u32)>, scale: Option<f64>) -> Option<Size> {
    size.map(|(width, height)| Size::Exactly(width, height)).or(scale.map(Size::Scaled))
}

impl ShowArg {
    /// Returns the display mode of a shot; `None` for exploded views, which are not shots.
    pub fn display(self) -> Option<DisplayMode> {
        Some(match self {
            Self::Colour => DisplayMode::Colour,
            Self::Weights => DisplayMode::Weights,
            Self::BestPhoto => DisplayMode::BestPhoto,
            Self::Group => DisplayMode::Group,
            Self::Density => DisplayMode::Density,
            Self::Confidence => DisplayMode::Confidence,
            Self::Agreement => DisplayMode::Agreement,
            Self::Layer => DisplayMode::Layer,
            Self::Item => DisplayMode::Item,
            Self::Coverage => DisplayMode::Coverage,
            Self::Matte => DisplayMode::Matte,
            Self::Provenance => DisplayMode::Provenance,
            Self::Exploded | Self::Holes => return None,
        })
    }
}

/// Maximum side of a picture in pixels.
const LONGEST_SIDE: u32 = 16_384;

pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let possible = |side: u32| (1..=LONGEST_SIDE).contains(&side);
    sides
        .filter(|&(width, height)| possible(width) && possible(height))
        .ok_or_else(|| format!("expected a width and a height such as 960x540, at most {LONGEST_SIDE}"))
}

pub fn parse_scale(text: &str) -> Result<f64, String> {
    let scale = text.parse().ok().filter(|scale: &f64| *scale > 0.0 && *scale <= 8.0);
    scale.ok_or_else(|| "expected a number above 0, such as 0.5, and at most 8".into())
}

pub fn parse_fps(text: &str) -> Result<f64, String> {
    let fps = text.parse().ok().filter(|fps: &f64| *fps > 0.0 && *fps <= 240.0);
    fps.ok_or_else(|| "expected a number above 0, such as 25, and at most 240".into())
}

fn parse_colour(text: &str) -> Result<[u8; 3], String> {
    let digits = text.trim_start_matches('#');
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
    let [_, red, green, blue] = number.ok_or("expected six hexadecimal digits such as c9d4de")?.to_be_bytes();
    Ok([red, green, blue])
}

fn parse_background(text: &str) -> Result<Background, String> {
    match text {
        "surroundings" => Ok(Background::Surroundings),
        "sky" => Ok(Background::Sky),
        "none" => Ok(Background::None),
        colour => parse_colour(colour)
            .map(Background::Colour)
            .map_err(|_| "expected surroundings, sky, none, or a colour such as #c9d4de".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_scales_and_colours_are_read_as_they_are_written() {
        assert_eq!(parse_size("960x540"), Ok((960, 540)));
        assert_eq!(parse_colour("#c9d4de"), Ok([0xc9, 0xd4, 0xde]));
        assert_eq!(parse_background("c9d4de"), Ok(Background::Colour([0xc9, 0xd4, 0xde])));
        assert_eq!(parse_background("none"), Ok(Background::None));
        assert_eq!(parse_background("sky"), Ok(Background::Sky));
        assert!(parse_background("blue").unwrap_err().contains("surroundings, sky, none, or a colour"));
        assert_eq!((parse_scale("0.5"), parse_fps("29.97")), (Ok(0.5), Ok(29.97)));
        for text in ["960", "0x540", "960x", "99999x1"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
        assert!(parse_colour("fff").is_err() && parse_scale("0").is_err() && parse_fps("NaN").is_err());
    }
}
