//! The command-line arguments.
//!
//! This file has the commands and the arguments that several of them share. Commands with many arguments have
//! files of their own.

mod baked;
mod colour;
mod decide;
mod export;
mod farm;
mod fill;
mod frame;
mod import;
mod ldi;
mod mask;
mod matte;
mod method;
mod model;
mod number;
mod one_of;
mod ortho;
mod page;
mod paint;
mod pictures;
mod surroundings;
mod text;
mod tree;
mod tree_paint;
mod view_of_ldi;

use std::path::PathBuf;

use clap::{Args, Command, CommandFactory, Parser, Subcommand};

pub use colour::{ColourArgs, GroupArg, Switch};
pub use decide::{DecideArgs, OptionOverride};
pub use export::{ExportArgs, ExportTarget};
pub use farm::{EstimateArgs, FramesArg, PartArg, PlanArgs, Scheduler, StatusArgs};
pub use fill::FillArgs;
pub use frame::FrameArgs;
pub use import::{ImportArgs, StrokeArgs, WatchArgs};
pub use ldi::{
    LdiArgs, LdiBackground, LdiBuildArgs, LdiCommand, LdiExportArgs, LdiExportFormat, LdiFrom, LdiInfoArgs,
    LdiRenderArgs, refuse,
};
pub use mask::{Accepted, MaskArgs, ObjectArgs};
pub use matte::MatteArgs;
pub use method::OptionArgs;
pub use model::{ModelArgs, ModelCommand, ModelSuggestArgs};
pub use ortho::OrthoArgs;
pub use paint::PaintArgs;
pub use pictures::{PICTURE_FORMATS, PictureArgs};
pub use surroundings::SurroundingsArgs;
pub use text::{TextAboutArgs, TextAddArgs, TextArgs, TextCommand, TextRemoveArgs};
pub use tree::{
    Casts, FlakesOf, Shadows, TreeArgs, TreeBakeArgs, TreeChangeArgs, TreeCommand, TreeInfoArgs,
    TreeLightArgs, TreeListArgs, TreeMaskArgs, TreeMethod, TreeMoveArgs, TreePlaceArgs, TreeQuality,
    TreeRemoveArgs, TreeRenderArgs, TreeSpeciesArgs,
};
pub use tree_paint::{TreeExportArgs, TreeImportArgs};
pub use view_of_ldi::{AsArg, AsArgs};

use self::surroundings::direction;
use super::bytes::parse_bytes;
use super::view_args::{RenderArgs, ScoreArgs};
use crate::words::error_text;
pub use number::whole;
pub use one_of::one_of;
use quadratura_base::geometry::Similarity;
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_import::cameras::accepted;
use quadratura_sites::budget::default_memory;
use quadratura_sites::open::OpeningProblems;

/// Turns calibrated photos and a coarse model into editable image layers, sorted by proven visibility.
#[derive(Debug, Parser)]
#[command(name = "quadratura", version, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Exit status: 0 done, 1 failed (also when one photo failed and the others \
                        went on), 2 wrong usage, 130 stopped by Ctrl-C.")]
pub struct Cli {
    #[command(flatten)]
    pub global: Global,
    /// Without a command, the editor opens
    #[command(subcommand)]
    pub command: Option<CommandArgs>,
}

/// Returns the definition of all commands. Negative numbers are values of options, so that messages are about them and their range,
/// not about an unknown option `-5`.
pub fn command() -> Command {
    fn with_negative_numbers(command: Command) -> Command {
        let takes_any = |arg: &clap::Arg| !arg.is_positional() && arg.get_action().takes_values();
        command
            .mut_args(|arg| match takes_any(&arg) && !arg.is_allow_hyphen_values_set() {
                true => arg.allow_negative_numbers(true),
                false => arg,
            })
            .mut_subcommands(with_negative_numbers)
    }
    with_negative_numbers(Cli::command())
}

/// Options of every command.
#[derive(Debug, Args)]
#[command(next_help_heading = "Common options")]
pub struct Global {
    /// Write the result to standard output as JSON
    #[arg(long, global = true)]
    pub json: bool,
    /// Also write the result as JSON to this file, beside the usual output
    #[arg(long, global = true, value_name = "FILE")]
    pub json_file: Option<PathBuf>,
    /// Print only results and errors
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Print more: facts about textures, and how long every step of every photo took
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Number of threads to use [default: one per core]
    #[arg(long, global = true, value_name = "N", value_parser = whole::<usize>(1..=1024))]
    pub threads: Option<usize>,
    /// Print a table of seconds per stage and photo, and the peak memory
    #[arg(long, global = true)]
    pub timings: bool,
}

/// Arguments of `edit`.
#[derive(Debug, Default, Args)]
pub struct EditArgs {
    /// The project folder; without it the window asks for a project
    pub project: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
pub enum CommandArgs {
    /// Open the editor, the window for all of this
    Edit(EditArgs),
    /// Create a project from photos, their cameras and a model
    New(NewArgs),
    /// Suggest a first model from the photos, or what the present model does not explain
    Model(ModelArgs),
    /// Write the sample site, a small invented square, and create its project
    Sample(SampleArgs),
    /// Check the site before work starts: is the model aligned with the photos?
    Check(CheckArgs),
    /// Build and fill every photo that needs it
    Update(UpdateArgs),
    /// Sort the surfaces of every photo by visibility and build its layer stack
    Build(BuildArgs),
    /// Fill occluded areas: from other photos, else by inpainting; builds stacks that need it first
    Fill(FillArgs),
    /// Make the estimates that all photos share (gains, depth detail, agreement, surroundings, mattes); `build` and `fill` do
    /// it where needed, and on several machines it is a job of its own
    Estimate(EstimateArgs),
    /// Write the jobs that make a project on several machines, for a job scheduler
    Plan(PlanArgs),
    /// Show what is done, what is worked on and on which machine, and what failed
    Status(StatusArgs),
    /// Write the stacks as layered files for an image editor, or the site for another program
    Export(ExportArgs),
    /// Show and set how exposures of the photos are matched
    Colour(ColourArgs),
    /// Show, export and replace what is seen around the model: the sky and what is far away
    Surroundings(SurroundingsArgs),
    /// Decide about the layers of photos: merge, split or name them; exclude a photo, or pin to it
    Decide(DecideArgs),
    /// Mask what is in the photos but not in the model, so that it is filled from other photos
    Mask(MaskArgs),
    /// Find what photos show through billboards and fences: a matte for each, by comparison with the other photos
    Matte(MatteArgs),
    /// List the model's objects, remove them in this project, or restore them
    Object(ObjectArgs),
    /// Import edited files: what was painted becomes the project's paint
    Import(ImportArgs),
    /// Import whatever an image editor saves in a folder
    Watch(WatchArgs),
    /// Paint a stroke of the brush in a view of the model: a colour, clone, heal, or erase
    Stroke(StrokeArgs),
    /// List the paint, and decide where it is seen: from everywhere, or only in its photo
    Paint(PaintArgs),
    /// Render pictures from new viewpoints by projecting the stacks onto the model
    Render(RenderArgs),
    /// Show and set the site's frame: level, unit, north, origin and map
    Frame(FrameArgs),
    /// Draw an orthophoto to scale: a facade from straight in front, a plan, or a section
    Ortho(OrthoArgs),
    /// Write texts at places of the site, which its web page shows: add, list, remove; title, credits and licence of the page
    Text(TextArgs),
    /// Predict photos from the others and measure how similar they are
    Score(ScoreArgs),
    /// Build, inspect and render layered depth images: one file per photo that shows new views without the project
    Ldi(LdiArgs),
    /// Render plants, and place trees in a project: list, move, mask, light and paint them
    Tree(TreeArgs),
    /// Show the contents of a project, and why faces have no texture
    Info(InfoArgs),
    /// List the files of other programs that are read and written, with what is kept and what is lost
    Formats,
    /// Print the completions of a shell
    #[command(hide = true)]
    Completions { shell: clap_complete::Shell },
    /// Print the manual page
    #[command(hide = true)]
    Man,
}

#[derive(Debug, Args)]
pub struct NewArgs {
    /// The project folder: new or empty
    pub project: PathBuf,
    /// The folder of the photos
    #[arg(long, value_name = "DIR")]
    pub photos: PathBuf,
    #[arg(long, value_name = "PATH", help = format!("The cameras: {}", accepted()))]
    pub cameras: PathBuf,
    /// The model: .obj, .gltf or .glb; `model suggest` makes a first one from the photos
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// The chunk of Metashape's file to read, by its name [default: the one with most aligned cameras]
    #[arg(long, value_name = "NAME")]
    pub chunk: Option<String>,
    /// Resample photos of rolling shutters row by row, where the cameras' file says how the camera moved (Metashape)
    #[arg(long)]
    pub rolling_shutter: bool,
    /// The transform from the model to the cameras' world: a name such as y-up, axes such as x,-z,y, or the
    /// 16 numbers of a 4 x 4 matrix, row by row
    #[arg(long, value_name = "M", allow_hyphen_values = true, value_parser = Similarity::parse)]
    pub model_transform: Option<Similarity>,
    /// A picture of what is around the site, in all directions: equirectangular, twice as wide as high (PNG, JPEG,
    /// TIFF, WebP or Radiance HDR)
    #[arg(long, value_name = "FILE")]
    pub surroundings: Option<PathBuf>,
    /// The direction of the middle of that picture in the cameras' world [default: the world's Y axis if it is
    /// level, else -Z or X]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = direction, requires = "surroundings")]
    pub middle: Option<[f64; 3]>,
    #[command(flatten)]
    pub options: OptionArgs,
}

#[derive(Debug, Args)]
pub struct SampleArgs {
    /// The folder of the sample: new or empty; the project is the folder `project` in it
    pub folder: PathBuf,
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The project folder
    pub project: PathBuf,
    /// Apply the transform of the model that is found to the project, as *Fix alignment* does in the window, then check
    /// again. With =2, apply the second one of several that fit nearly as well; with =M, apply this transform, given as for
    /// `new --model-transform`: the present one is printed, so that it can be restored
    #[arg(long, value_name = "M", num_args = 0..=1, require_equals = true, default_missing_value = FOUND,
          value_parser = FixArg::parse)]
    pub fix: Option<FixArg>,
    /// Align the model by a corner that a photo shows, where no search finds the alignment: the corner's x,y,z in the model's
    /// file, the photo, and the pixel x,y from the upper left corner of the photo without lens distortion. Give it three times
    /// or more, better five, for corners not on one line in two photos or more
    #[arg(long, num_args = 3, value_names = ["X,Y,Z", "PHOTO", "X,Y"], allow_hyphen_values = true)]
    pub pair: Vec<String>,
    /// Align the model by cameras in the model's own coordinates, of photos with the same names: georeferenced ones, or those of
    /// the reconstruction that the model was made for
    #[arg(long, value_name = "FILE", conflicts_with = "pair")]
    pub model_cameras: Option<PathBuf>,
}

/// The value of `--fix` without a value.
const FOUND: &str = "found";

/// The transform that `check --fix` applies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FixArg {
    /// The one that is found.
    Found,
    /// The n-th one of those that are found, counted from 1.
    Nth(usize),
    /// This one.
    To(Similarity),
}

impl FixArg {
    fn parse(text: &str) -> Result<Self, String> {
        match text.parse::<usize>() {
            _ if text == FOUND => Ok(Self::Found),
            Ok(0) => Err("transforms that are found are counted from 1".into()),
            Ok(number) => Ok(Self::Nth(number)),
            Err(_) => Similarity::parse(text).map(Self::To),
        }
    }
}

#[derive(Debug, Args)]
pub struct UpdateArgs {
    /// The project folder
    pub project: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    /// Skip photos that were never built
    #[arg(long)]
    pub only_existing: bool,
    #[command(flatten)]
    pub memory: MemoryArg,
}

#[derive(Debug, Args)]
pub struct BuildArgs {
    /// The project folder
    pub project: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    #[command(flatten)]
    pub part: PartArg,
    /// Save the options of the method in project.json. Without this they apply only once, and the next build
    /// without them builds these photos again
    #[arg(long)]
    pub save_options: bool,
    #[command(flatten)]
    pub memory: MemoryArg,
    /// Build photos that are up to date, too
    #[arg(long)]
    pub force: bool,
    /// Do not compute exposure gains and relief now: the stacks are ready sooner, but the first picture takes
    /// longer
    #[arg(long)]
    pub stacks_only: bool,
    #[command(flatten)]
    pub options: OptionArgs,
}

#[derive(Debug, Args)]
pub struct InfoArgs {
    /// The project folder
    pub project: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    /// Show only this face, in every photo; named as in the lists. An object's name: list its faces
    #[arg(long, value_name = "OBJECT[INDEX]|OBJECT")]
    pub face: Option<String>,
}

#[derive(Debug, Args)]
pub struct PhotoArgs {
    /// Use only this photo (may be given several times) [default: all]
    #[arg(long = "photo", value_name = "NAME")]
    pub names: Vec<String>,
}

impl PhotoArgs {
    /// Returns the problems with photos of the site that affect the exit status. Where photos were given by
    /// name, the others' problems are only notes.
    pub fn problems_of(&self, problems: &OpeningProblems, task: &Task) -> Vec<String> {
        let problems = problems.errors.iter().map(error_text);
        if self.names.is_empty() {
            return problems.collect();
        }
        problems.for_each(|problem| task.note(problem));
        Vec::new()
    }

    /// Returns how many photos of the cameras are not in the site, of those that are asked for.
    pub fn left_out(&self, site: &Site, problems: &OpeningProblems) -> usize {
        if self.names.is_empty() { problems.listed.saturating_sub(site.photos.len()) } else { 0 }
    }
}

/// The memory limit of a command.
#[derive(Debug, Args)]
pub struct MemoryArg {
    /// Memory to use, such as 4G or 800M [default: a quarter of the machine's]
    #[arg(long = "memory", value_name = "BYTES", value_parser = parse_bytes, allow_hyphen_values = true)]
    pub bytes: Option<u64>,
}

impl MemoryArg {
    /// Returns the limit in bytes: as given, else the default.
    pub fn or_default(&self) -> u64 {
        self.bytes.unwrap_or_else(default_memory)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_contradicts_itself_nowhere() {
        command().debug_assert();
    }

    /// Two fields of one name, such as those of a flattened structure, would read each other's values; clap tells only in
    /// builds with debug assertions.
    #[test]
    fn no_two_arguments_of_a_command_have_one_name() {
        fn check(command: &Command) {
            let mut ids: Vec<_> = command.get_arguments().map(clap::Arg::get_id).collect();
            let count = ids.len();
            ids.sort();
            ids.dedup();
            assert_eq!(ids.len(), count, "{}: {ids:?}", command.get_name());
            command.get_subcommands().for_each(check);
        }
        check(&command());
    }
}
