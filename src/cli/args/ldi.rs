//! Arguments of `ldi`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::number::whole;
use super::one_of::one_of;
use super::{PartArg, PhotoArgs, PictureArgs};
use crate::view_args::{QUALITIES, parse_scale};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{PhotoId, Site};
use quadratura_images::export::MeshOptions;
use quadratura_images::{PhotosOptions, SiteLdiOptions, StackLdiOptions};
use quadratura_import::cameras::accepted;
use quadratura_ldi::file::{MOST_IMAGES, Packing};
use quadratura_ldi::merge::Merging;
use quadratura_ldi::{Combining, Shown, SplatKind};
use quadratura_sites::named::index_of_photo;
use quadratura_view::Quality;

/// The largest number of triangles that may be asked for, more than a program shows.
const MOST_TRIANGLES: usize = 1_000_000_000;

#[derive(Debug, Args)]
pub struct LdiArgs {
    #[command(subcommand)]
    pub command: LdiCommand,
}

#[derive(Debug, Subcommand)]
pub enum LdiCommand {
    /// Make layered depth images of the photos' stacks: everything that the layers hold, with depths, in one file
    Build(LdiBuildArgs),
    /// Show what is in a layered depth image, or which of a project's are up to date
    Info(LdiInfoArgs),
    /// Render pictures from new viewpoints from layered depth images alone, without a project
    Render(LdiRenderArgs),
    /// Write a layered depth image for other programs: as a page that one can lean into, or as a mesh
    Export(LdiExportArgs),
}

#[derive(Debug, Args)]
pub struct LdiBuildArgs {
    /// The project folder; none with --depth-images
    #[arg(required_unless_present = "depth_images", conflicts_with = "depth_images")]
    pub project: Option<PathBuf>,
    #[command(flatten)]
    pub photos: PhotoArgs,
    #[command(flatten)]
    pub part: PartArg,
    /// Make one image of depth images from elsewhere, which this list names (JSON, see docs/formats.md), instead of a
    /// project's photos
    #[arg(long, value_name = "LIST.json", requires = "out", requires = "reference")]
    pub depth_images: Option<PathBuf>,
    /// The picture of the list in whose camera the image is
    #[arg(long, value_name = "NAME", requires = "depth_images")]
    pub reference: Option<String>,
    /// Use depth images whose scale contradicts the sparse points
    #[arg(long, requires = "depth_images")]
    pub force: bool,
    /// What they are made from: each photo's image layers, or the whole site
    #[arg(long, value_enum, default_value_t)]
    pub from: LdiFrom,
    #[command(flatten)]
    pub combined: CombinedArgs,
    /// Make the image in the camera of this saved view instead of a photo's
    #[arg(long, value_name = "VIEW")]
    pub at: Option<String>,
    /// Make a cube: six images of 90 degrees around the place of one photo, in one file, so that views can turn anywhere.
    /// The sides of its faces are twice the photo's focal length in pixels, rounded up to a multiple of 64
    #[arg(long, requires = "out", conflicts_with_all = ["set", "depth_images", "guard", "published", "at"])]
    pub cube: bool,
    /// Make a set: images of as many photos as together show 99 % of what all photos show, N at most, in one file
    #[arg(long, value_name = "N", requires = "out", conflicts_with = "depth_images", value_parser = whole::<u32>(1..=MOST_IMAGES as u32))]
    pub set: Option<u32>,
    /// Leave faces flat, as modelled, without depth detail from photos
    #[arg(long)]
    pub flat: bool,
    /// Leave occluded areas empty, without their filling
    #[arg(long)]
    pub unfilled: bool,
    /// What is where no surface is: the photo's surroundings, infinitely far away, or nothing
    #[arg(long, value_enum, default_value_t)]
    pub background: LdiBackground,
    /// Write the layered depth image of one photo to this file (.ldi), to keep or hand on [default: into the project's cache].
    /// A file that is no image of the same photo with the same options stays, and NAME-2.ldi is written
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// How files are packed [default: deflate with --out, else none]
    #[arg(long, value_parser = one_of(PACKINGS))]
    pub packing: Option<Packing>,
}

impl LdiBuildArgs {
    /// Refuses arguments about projects where depth images from elsewhere are combined.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Usage`] that names the arguments.
    pub fn refuse_of_projects(&self) -> Result<()> {
        let Self { photos, part, from, combined, at, flat, unfilled, background, .. } = self;
        let given = [
            (!photos.names.is_empty(), "--photo"),
            (part.part.is_some(), "--part"),
            (*from != LdiFrom::default(), "--from"),
            (at.is_some(), "--at"),
            (combined.best.is_some(), "--best"),
            (!combined.with.is_empty(), "--with"),
            (*flat, "--flat"),
            (*unfilled, "--unfilled"),
            (*background != LdiBackground::default(), "--background"),
        ];
        refuse(&given, "a project")
    }
}

#[derive(Debug, Args)]
pub struct LdiInfoArgs {
    /// A file or a project folder
    #[arg(value_name = "FILE|PROJECT")]
    pub path: PathBuf,
}

#[derive(Debug, Args)]
pub struct LdiRenderArgs {
    /// The files, of single images, cubes or sets; with several, each view is made from the one with the camera that is nearest to it
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    #[arg(long, value_name = "PATH", help = format!(
        "The viewpoints: a camera path (.json), the word `photos` for the files' own cameras (for a folder of that name give \
         ./photos), or cameras: {} [default: photos]",
        accepted()
    ))]
    pub cameras: Option<PathBuf>,
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// Select what is shown
    #[arg(long, value_enum, default_value_t)]
    pub show: LdiShow,
    /// Preview: quick; final: sharp also where surfaces are seen from the side, from up to four times as many depth pixels
    #[arg(long, value_parser = one_of(QUALITIES), default_value = "final")]
    pub quality: Quality,
    /// How a depth pixel is drawn
    #[arg(long, value_parser = one_of(SPLATS), default_value = "sums")]
    pub splat: SplatKind,
    /// Draw as the published system does (Gortler et al. 1997): --splat over, sized by its table
    #[arg(long, conflicts_with = "splat")]
    pub published: bool,
    /// Render each view for two eyes with parallel axes, this far apart in world units, side by side in one picture
    #[arg(long, value_name = "DISTANCE", value_parser = parse_distance)]
    pub stereo: Option<f64>,
    /// Show what a file holds that is cut short
    #[arg(long)]
    pub partial: bool,
}

/// What views of a layered depth image show.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum LdiShow {
    /// The image itself
    #[default]
    Colour,
    /// Why pixels are empty: outside the frame, hidden or empty, or too near; the others keep their colours
    Holes,
    /// The layer, by its colour
    Layer,
    /// Source of the colours: the photo, paint, other photos, or inpainted
    Provenance,
    /// Resolution (depth pixels per pixel), in octaves around one
    Density,
}

impl LdiShow {
    /// Returns the quantity; `None` for the image itself.
    pub fn shown(self) -> Option<Shown> {
        match self {
            Self::Colour => None,
            Self::Holes => Some(Shown::Holes),
            Self::Layer => Some(Shown::Layer),
            Self::Provenance => Some(Shown::Provenance),
            Self::Density => Some(Shown::Density),
        }
    }
}

/// How several photos become one layered depth image.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Layered depth images of several photos")]
pub struct CombinedArgs {
    /// Take this many photos: those that show most of the view, or, to build images with --published, the reference photo and
    /// those that show most of what it shows [default: 3; 5 for views from stacks]
    #[arg(long, value_name = "K", value_parser = whole::<u32>(1..=64))]
    pub best: Option<u32>,
    /// Take these photos; with --published the first one is the reference [default: those that show most]
    #[arg(long, value_name = "PHOTO,..", value_delimiter = ',', conflicts_with = "best")]
    pub with: Vec<String>,
    /// Grow the reference photo's frame on each side by this share of its sides, so that what moves into the picture is
    /// there [default: 0.3]
    #[arg(long, value_name = "SHARE", value_parser = parse_guard)]
    pub guard: Option<f64>,
    /// Factor of the reference camera's resolution [default: 1]
    #[arg(long = "ldi-scale", value_name = "S", value_parser = parse_scale)]
    pub ldi_scale: Option<f64>,
    /// Maximum layers at a pixel; beyond it the nearest ones and the farthest one stay [default: 10]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=64))]
    pub layers: Option<u32>,
    /// Samples of one pixel share a layer where their depths differ by no more than this share; with --published or
    /// --depth-images [default: 0.01]
    #[arg(long, value_name = "E", value_parser = parse_epsilon)]
    pub epsilon: Option<f64>,
    /// Combine depth images of several photos in one camera, and draw them, as the published system does (Gortler et al.
    /// 1997): one sample a source pixel, in the order of the photos, means of stored values, no guard band, its masks sized by
    /// its table
    #[arg(long, conflicts_with_all = ["from", "guard"])]
    pub published: bool,
}

impl CombinedArgs {
    /// Returns how photos are combined, taking `stack` of each.
    pub fn options(&self, stack: StackLdiOptions) -> PhotosOptions {
        let usual = if self.published { PhotosOptions::published() } else { PhotosOptions::default() };
        let merging = usual.combining.merging;
        let merging = Merging {
            epsilon: self.epsilon.unwrap_or(merging.epsilon),
            layers: self.layers.map_or(merging.layers, |layers| layers as usize),
            ..merging
        };
        PhotosOptions {
            stack,
            hidden: false,
            guard: self.guard.unwrap_or(usual.guard),
            scale: self.ldi_scale.unwrap_or(usual.scale),
            combining: Combining { merging, ..usual.combining },
        }
    }

    /// Returns how the image of a site is made, with what `stack` says of relief, filling and surroundings.
    pub fn site_options(&self, stack: StackLdiOptions) -> SiteLdiOptions {
        let usual = SiteLdiOptions::default();
        SiteLdiOptions {
            relief: stack.relief,
            filled: stack.filled,
            surroundings: stack.surroundings,
            guard: self.guard.unwrap_or(usual.guard),
            scale: self.ldi_scale.unwrap_or(usual.scale),
            layers: self.layers.map_or(usual.layers, |layers| layers as usize),
        }
    }

    /// Refuses arguments of one image of several photos where something else is made.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Usage`] that names the arguments.
    pub fn refuse_of_photos(&self) -> Result<()> {
        refuse(&[(self.guard.is_some(), "--guard")], "--from site")?;
        let given = [(self.ldi_scale.is_some(), "--ldi-scale"), (self.layers.is_some(), "--layers")];
        refuse(&given, "--from site or --published")?;
        self.refuse_of_merging()
    }

    /// Refuses arguments about how photos are merged where nothing is merged.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Usage`] that names the arguments.
    pub fn refuse_of_merging(&self) -> Result<()> {
        refuse(&[(self.epsilon.is_some(), "--epsilon")], "--published")
    }

    /// Refuses `--best` and `--with` where a single photo is meant, or none.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Usage`] that names the arguments.
    pub fn refuse_choice(&self, needed: &str) -> Result<()> {
        refuse(&[(self.best.is_some(), "--best"), (!self.with.is_empty(), "--with")], needed)
    }

    /// Returns the photos of `--with`.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] for an unknown photo.
    pub fn with(&self, site: &Site) -> Result<Vec<PhotoId>> {
        self.with.iter().map(|name| index_of_photo(site, name)).collect()
    }

    /// Returns how many photos are taken, `usual` where nothing is said, but all that are named.
    pub fn best(&self, usual: usize) -> usize {
        if self.with.is_empty() { self.best.map_or(usual, |best| best as usize) } else { usize::MAX }
    }
}

/// Refuses arguments that are given, because they have an effect with another one alone.
///
/// # Errors
/// [`quadratura_base::Error::Usage`] that names the arguments.
pub fn refuse(given: &[(bool, &str)], needed: &str) -> Result<()> {
    let given: Vec<&str> = given.iter().filter(|(is_given, _)| *is_given).map(|(_, name)| *name).collect();
    if given.is_empty() {
        return Ok(());
    }
    Err(Error::Usage(format!("{} has no effect without {needed}; give both, or neither", given.join(", "))))
}

fn parse_distance(text: &str) -> std::result::Result<f64, String> {
    let distance = text.parse().ok().filter(|distance: &f64| *distance > 0.0 && distance.is_finite());
    distance.ok_or_else(|| format!("{text} is not a distance above 0, in world units"))
}

fn parse_guard(text: &str) -> std::result::Result<f64, String> {
    within(text, 0.0, 2.0, "a share of the sides, 0 to 2")
}

fn parse_epsilon(text: &str) -> std::result::Result<f64, String> {
    within(text, 0.0, 1.0, "a share of the depth, 0 to 1")
}

fn within(text: &str, low: f64, high: f64, expected: &str) -> std::result::Result<f64, String> {
    let value = text.parse().ok().filter(|value| (low..=high).contains(value));
    value.ok_or_else(|| format!("{text} is not {expected}"))
}

#[derive(Debug, Args)]
pub struct LdiExportArgs {
    /// The file
    pub file: PathBuf,
    /// What to write
    #[arg(long, value_enum)]
    pub format: LdiExportFormat,
    /// The folder (page) or file (.glb, .ply) to write. One that this program did not write, or that was changed since, stays, and
    /// NAME-2 is written
    #[arg(long, value_name = "PATH")]
    pub out: PathBuf,
    #[arg(long, value_name = "N", value_parser = whole::<usize>(2..=MOST_TRIANGLES), help = format!(
        "The number of triangles above which meshes become coarser [default: {}]",
        MeshOptions::default().triangles
    ))]
    pub triangles: Option<usize>,
    #[arg(long, value_name = "Q", value_parser = whole::<u8>(1..=100), help = format!(
        "The quality of JPEG pictures, 1 to 100 [default: {}]",
        MeshOptions::default().quality
    ))]
    pub quality: Option<u8>,
    /// The text below the picture of a page [default: the photo's name]
    #[arg(long, value_name = "TEXT")]
    pub caption: Option<String>,
}

/// What a layered depth image is exported as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LdiExportFormat {
    /// A folder with a web page that opens from disk and shows a photo that one can lean into
    Page,
    /// Binary glTF: textured meshes without lighting, and the camera
    Glb,
    /// A cloud of points with colours and normals, binary PLY
    Ply,
}

/// What layered depth images are made from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum LdiFrom {
    /// The image layers of each photo, with what is hidden in it
    #[default]
    Stack,
    /// All that the photos together show, layer by layer behind one camera
    Site,
}

impl LdiFrom {
    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stack => "stack",
            Self::Site => "site",
        }
    }
}

/// What is where no surface of the model is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum LdiBackground {
    #[default]
    Surroundings,
    None,
}

/// How files are packed.
const PACKINGS: &[(&str, Packing, &str)] = &[
    ("none", Packing::None, "As they are in memory: fast"),
    ("deflate", Packing::Deflate, "Compressed: small"),
];

/// How depth pixels are drawn.
pub const SPLATS: &[(&str, SplatKind, &str)] = &[
    ("sums", SplatKind::Sums, "As soft squares as large as the gaps between them, summed up"),
    ("over", SplatKind::Over, "With the published masks, one over the other"),
    ("pixel", SplatKind::Pixel, "As one pixel each, with gaps"),
];
