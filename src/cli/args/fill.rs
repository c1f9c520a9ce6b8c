//! Arguments of `fill`.

use std::path::PathBuf;

use clap::Args;

use super::{MemoryArg, PartArg, PhotoArgs, one_of};
use quadratura_layers::fill::{FillOptions, Invent, Propagation};

#[derive(Debug, Args)]
pub struct FillArgs {
    /// The project folder
    pub project: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    #[command(flatten)]
    pub part: PartArg,
    /// Do not fill this object (may be given several times; `*` stands for any characters)
    /// [default: the project's]
    #[arg(long, value_name = "OBJECT")]
    pub without: Vec<String>,
    /// How to inpaint what no photo shows [default: the project's]
    #[arg(long, value_parser = one_of(INVENT))]
    pub invent: Option<Invent>,
    /// Project paint of other photos to what photos show of the same surfaces: paint of all photos, or of
    /// this one (`--propagate=NAME`, may be given several times; `*` stands for any characters).
    /// A photo's own paint stays; conflicts are reported. In a project for which nobody has chosen yet, this is the
    /// choice, and is saved [default: the project's]
    #[arg(long, value_name = "PHOTO", num_args = 0..=1, require_equals = true, default_missing_value = "*",
          conflicts_with = "no_propagate")]
    pub propagate: Vec<String>,
    /// Project no paint to what other photos show, and remove it again, whatever the project's options say. In a
    /// project for which nobody has chosen yet, this is the choice, and is saved
    #[arg(long)]
    pub no_propagate: bool,
    /// Leave billboards and other see-through surfaces solid; do not find out where one sees through them
    #[arg(long, conflicts_with = "mattes")]
    pub no_mattes: bool,
    /// Find out where one sees through see-through surfaces, whatever the project's options say
    #[arg(long)]
    pub mattes: bool,
    /// Preview what paint would be projected to which photos; nothing is filled or written
    #[arg(long, conflicts_with_all = ["save_options", "force"])]
    pub dry_run: bool,
    /// Save these options in project.json. Without this they apply only once, and the next fill without them
    /// fills these photos again
    #[arg(long)]
    pub save_options: bool,
    #[command(flatten)]
    pub memory: MemoryArg,
    /// Fill photos that are up to date, too
    #[arg(long)]
    pub force: bool,
}

/// The methods of inpainting.
const INVENT: &[(&str, Invent, &str)] = &[
    ("exemplar", Invent::Exemplar, "Patch-based, with patches of what photos show of the surface"),
    ("diffusion", Invent::Diffusion, "Smooth"),
];

impl FillArgs {
    /// Returns `options` with those that were given replaced.
    pub fn applied_to(&self, options: &FillOptions) -> FillOptions {
        let invent = self.invent.unwrap_or(options.invent);
        let without = if self.without.is_empty() { &options.without } else { &self.without };
        let propagate = match (self.no_propagate, self.propagate.is_empty()) {
            (true, _) => Propagation::None,
            (_, true) => options.propagate.clone(),
            _ => self.propagate.clone().into(),
        };
        let no_mattes = (self.no_mattes || options.no_mattes) && !self.mattes;
        FillOptions { without: without.clone(), invent, propagate, no_mattes, ..options.clone() }
    }
}
