//! What may be typed.
//!
//! Here: the commands, and what several of them take. The arguments of a command that has many stand in a file
//! of its own.

mod colour;
mod decide;
mod export;
mod fill;
mod import;
mod mask;
mod method;

use std::path::PathBuf;

use clap::builder::RangedU64ValueParser;
use clap::{Args, Parser, Subcommand};

pub use colour::{ColourArgs, Switch};
pub use decide::{DecideArgs, OwnOption};
pub use export::ExportArgs;
pub use fill::FillArgs;
pub use import::{ImportArgs, WatchArgs};
pub use mask::{Accepted, MaskArgs, ObjectArgs};
pub use method::OptionArgs;

use super::bytes::parse_bytes;
use super::view_args::{RenderArgs, ScoreArgs};
use crate::geometry::Similarity;
use crate::io::cameras::accepted;
use crate::recipe::budget::default_memory;
use crate::recipe::open::Opened;
use crate::task::Task;

/// Calibrated photos and a coarse model become editable image layers, sorted by proven visibility.
#[derive(Debug, Parser)]
#[command(name = "quadratura", version, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Exit status: 0 done, 1 failed (also when one photo failed and the others \
                        went on), 2 wrong usage, 130 stopped by Ctrl-C.")]
pub struct Cli {
    #[command(flatten)]
    pub global: Global,
    /// Without one, the editor opens
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// What every command takes.
#[derive(Debug, Args)]
pub struct Global {
    /// Write the result to standard output as JSON
    #[arg(long, global = true)]
    pub json: bool,
    /// Say nothing but results and errors
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Say more: how long every step of every photo took
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Use so many threads [default: one a core]
    #[arg(long, global = true, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub threads: Option<usize>,
    /// Print a table of seconds by stage and photo, and the peak memory
    #[arg(long, global = true)]
    pub timings: bool,
}

/// What the editor is given.
#[derive(Debug, Default, Args)]
pub struct EditArgs {
    /// The project's folder; without one the window asks
    pub project: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Open the editor: the window in which all of it is done
    Edit(EditArgs),
    /// Make a project of photos, their cameras and a model
    New(NewArgs),
    /// Judge the site before work starts: does the model fit the photos
    Check(CheckArgs),
    /// Sort the surfaces of every photo by visibility and make its layer stack
    Build(BuildArgs),
    /// Fill what the photos did not show: from other photos, by example, or smoothly
    Fill(FillArgs),
    /// Write the stacks as files for an image editor
    Export(ExportArgs),
    /// Show and decide how the photos' exposures are evened out
    Colour(ColourArgs),
    /// Decide about photos' layers: merge, split, name; exclude a photo, or pin to it
    Decide(DecideArgs),
    /// Say what in the photos is not in the model: it is filled from other photos
    Mask(MaskArgs),
    /// Switch objects of the model off and on, and list them
    Object(ObjectArgs),
    /// Take edited files home: what was painted becomes the project's paint
    Import(ImportArgs),
    /// Import whatever an image editor saves in a folder
    Watch(WatchArgs),
    /// Project the stacks back onto the model: pictures from new viewpoints
    Render(RenderArgs),
    /// Predict photos from the others and measure how like they are
    Score(ScoreArgs),
    /// Show what a project holds, and why a face has no texture
    Info(InfoArgs),
    /// Print the completions of a shell
    #[command(hide = true)]
    Completions { shell: clap_complete::Shell },
    /// Print the manual page
    #[command(hide = true)]
    Man,
}

#[derive(Debug, Args)]
pub struct NewArgs {
    /// The project's folder: new or empty
    pub project: PathBuf,
    /// The folder of the photos
    #[arg(long, value_name = "DIR")]
    pub photos: PathBuf,
    #[arg(long, value_name = "PATH", help = format!("The cameras: {}", accepted()))]
    pub cameras: PathBuf,
    /// The model: .obj, .gltf or .glb
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// Takes the model into the cameras' world: a name such as y-up, axes such as x,-z,y, or the 16
    /// numbers of a 4 x 4 matrix, row by row
    #[arg(long, value_name = "M", allow_hyphen_values = true, value_parser = Similarity::parse)]
    pub model_transform: Option<Similarity>,
    #[command(flatten)]
    pub options: OptionArgs,
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The project's folder
    pub project: PathBuf,
}

#[derive(Debug, Args)]
pub struct BuildArgs {
    /// The project's folder
    pub project: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    /// Keep the options of the method in project.json. Without it they hold for this time only, and
    /// the next build without them builds these photos again
    #[arg(long)]
    pub save_options: bool,
    #[command(flatten)]
    pub memory: MemoryArg,
    /// Build again what is up to date
    #[arg(long)]
    pub force: bool,
    /// Leave exposure gains and relief to whoever needs them first: the stacks are ready sooner, the first
    /// picture later
    #[arg(long)]
    pub stacks_only: bool,
    #[command(flatten)]
    pub options: OptionArgs,
}

#[derive(Debug, Args)]
pub struct InfoArgs {
    /// The project's folder
    pub project: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    /// Show this face only, in every photo; named as in the lists
    #[arg(long, value_name = "OBJECT[INDEX]")]
    pub face: Option<String>,
}

#[derive(Debug, Args)]
pub struct PhotoArgs {
    /// This photo only (may be given several times) [default: all]
    #[arg(long = "photo", value_name = "NAME")]
    pub names: Vec<String>,
}

impl PhotoArgs {
    /// Why photos are missing from the site, for the exit status. Whoever asked for photos by name
    /// and got them is only told.
    pub fn problems_of(&self, opened: &Opened, task: &Task) -> Vec<String> {
        let problems = opened.problems.iter().map(ToString::to_string);
        if self.names.is_empty() {
            return problems.collect();
        }
        problems.for_each(|problem| task.note(problem));
        Vec::new()
    }
}

/// What one command may take of the machine.
#[derive(Debug, Args)]
pub struct MemoryArg {
    /// Memory to use, such as 4G or 800M [default: a quarter of the machine's]
    #[arg(long = "memory", value_name = "BYTES", value_parser = parse_bytes)]
    pub bytes: Option<u64>,
}

impl MemoryArg {
    /// In bytes: what was given, else the default.
    pub fn or_default(&self) -> u64 {
        self.bytes.unwrap_or_else(default_memory)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_contradicts_itself_nowhere() {
        Cli::command().debug_assert();
    }
}
