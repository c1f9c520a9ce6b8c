//! Arguments of `tree`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::cli::view_args::PictureArgs;
use crate::io::cameras::accepted;

#[derive(Debug, Args)]
pub struct TreeArgs {
    #[command(subcommand)]
    pub command: TreeCommand,
}

#[derive(Debug, Subcommand)]
pub enum TreeCommand {
    /// Show what a plant holds: sub-objects, polygons, bounds and materials
    Info(TreeInfoArgs),
    /// Render pictures of a plant, without a project
    Render(TreeRenderArgs),
}

/// A plant, and how it is grown.
#[derive(Debug, Args)]
pub struct PlantArgs {
    /// The plant: a file of the keyword format (.plant), of glTF (.gltf, .glb) or of Rayshade (.ray), a species to be
    /// grown (.json), or `maple` or `oak` (for files of these names give ./maple)
    #[arg(value_name = "PLANT")]
    pub plant: PathBuf,
    /// Grow another plant of the species [default: the species' own number]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

#[derive(Debug, Args)]
pub struct TreeInfoArgs {
    #[command(flatten)]
    pub plant: PlantArgs,
}

#[derive(Debug, Args)]
pub struct TreeRenderArgs {
    #[command(flatten)]
    pub plant: PlantArgs,
    #[arg(long, value_name = "PATH", help = format!(
        "The viewpoints, in the plant's frame and unit: the word `orbit` for eight views around the plant, 600 x 600 unless \
         --size says otherwise (for a folder of that name give ./orbit), a camera path (.json), or cameras: {}",
        accepted()
    ))]
    pub cameras: PathBuf,
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// How the plant is drawn
    #[arg(long, value_enum, default_value_t)]
    pub method: TreeMethod,
}

/// How plants are drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum TreeMethod {
    /// Every polygon of every instance, with 16 sub-pixels a pixel
    #[default]
    Polygons,
}
