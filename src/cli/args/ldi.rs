//! Arguments of `ldi`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::PhotoArgs;
use crate::cli::view_args::PictureArgs;
use crate::io::cameras::accepted;
use crate::io::ldi_file::Packing;
use crate::ldi::SplatKind;

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
}

#[derive(Debug, Args)]
pub struct LdiBuildArgs {
    /// The project folder
    pub project: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    /// What they are made from
    #[arg(long, value_enum, default_value_t)]
    pub from: LdiFrom,
    /// Leave faces flat, as modelled, without depth detail from photos
    #[arg(long)]
    pub flat: bool,
    /// Leave occluded areas empty, without their filling
    #[arg(long)]
    pub unfilled: bool,
    /// What is where no surface is: the photo's surroundings, infinitely far away, or nothing
    #[arg(long, value_enum, default_value_t)]
    pub background: LdiBackground,
    /// Write the layered depth image of one photo to this file, to keep or hand on [default: into the project's cache].
    /// A file that is no image of the same photo with the same options stays, and NAME-2.ldi is written
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// How files are packed [default: deflate with --out, else none]
    #[arg(long, value_enum)]
    pub packing: Option<PackingArg>,
}

#[derive(Debug, Args)]
pub struct LdiInfoArgs {
    /// A file, or a project folder
    #[arg(value_name = "FILE|PROJECT")]
    pub path: PathBuf,
}

#[derive(Debug, Args)]
pub struct LdiRenderArgs {
    /// The files; with several, each view is made from the one whose camera is nearest to it
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
    /// How a depth pixel is drawn
    #[arg(long, value_enum, default_value_t)]
    pub splat: SplatArg,
    /// Draw as the published system does (Gortler et al. 1997): --splat over, sized by its table
    #[arg(long, conflicts_with = "splat")]
    pub published: bool,
    /// Show what a file holds that is cut short
    #[arg(long)]
    pub partial: bool,
}

/// What layered depth images are made from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum LdiFrom {
    /// The image layers of each photo
    #[default]
    Stack,
}

/// What is where no surface of the model is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum LdiBackground {
    #[default]
    Surroundings,
    None,
}

/// How files are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PackingArg {
    /// As they are in memory: fast
    None,
    /// Compressed: small
    Deflate,
}

impl From<PackingArg> for Packing {
    fn from(arg: PackingArg) -> Self {
        match arg {
            PackingArg::None => Self::None,
            PackingArg::Deflate => Self::Deflate,
        }
    }
}

/// How depth pixels are drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum SplatArg {
    /// As soft squares as large as the gaps between them, summed up
    #[default]
    Sums,
    /// With the published masks, one over the other
    Over,
    /// As one pixel each, with gaps
    Pixel,
}

impl From<SplatArg> for SplatKind {
    fn from(arg: SplatArg) -> Self {
        match arg {
            SplatArg::Sums => Self::Sums,
            SplatArg::Over => Self::Over,
            SplatArg::Pixel => Self::Pixel,
        }
    }
}
