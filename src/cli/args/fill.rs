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
        FillOptions { without: without.clone(), invent }
    }
}
