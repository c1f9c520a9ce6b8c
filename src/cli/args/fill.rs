//! What may be typed for `fill`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{MemoryArg, PhotoArgs};
use crate::layers::fill::{FillOptions, Invent};

#[derive(Debug, Args)]
pub struct FillArgs {
    /// The project's folder
    pub project: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    /// Leave this object as the photos show it (may be given several times; `NAME*` for all that begin
    /// so) [default: the project's]
    #[arg(long, value_name = "OBJECT")]
    pub without: Vec<String>,
    /// How that is made which no photo shows [default: the project's]
    #[arg(long, value_enum)]
    pub invent: Option<InventArg>,
    /// Lay paint of other photos over what photos show of the same surfaces: that of all photos, or of this one
    /// (`--propagate=NAME`, may be given several times; `NAME*` for all that begin so). Paint of a photo's own
    /// stays; where the two say different things, that is told [default: the project's]
    #[arg(long, value_name = "PHOTO", num_args = 0..=1, require_equals = true, default_missing_value = "*",
          conflicts_with = "no_propagate")]
    pub propagate: Vec<String>,
    /// Take such paint away again, whatever the project says
    #[arg(long)]
    pub no_propagate: bool,
    /// Only tell what paint would be laid over what photos: nothing is filled, and no layer is written
    #[arg(long, conflicts_with_all = ["save_options", "force"])]
    pub dry_run: bool,
    /// Keep these options in project.json. Without it they hold for this time only, and the next fill
    /// without them fills these photos again
    #[arg(long)]
    pub save_options: bool,
    #[command(flatten)]
    pub memory: MemoryArg,
    /// Fill again what is up to date
    #[arg(long)]
    pub force: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum InventArg {
    /// Of patches of what photos show of the surface
    Exemplar,
    /// Smoothly
    Diffusion,
}

impl FillArgs {
    /// `options` with those that were given.
    pub fn applied_to(&self, options: &FillOptions) -> FillOptions {
        let invent = self.invent.map_or(options.invent, |invent| match invent {
            InventArg::Exemplar => Invent::Exemplar,
            InventArg::Diffusion => Invent::Diffusion,
        });
        let without = if self.without.is_empty() { &options.without } else { &self.without };
        let propagate = match (self.no_propagate, self.propagate.is_empty()) {
            (true, _) => Vec::new(),
            (_, true) => options.propagate.clone(),
            _ => self.propagate.clone(),
        };
        FillOptions { without: without.clone(), invent, propagate }
    }
}
