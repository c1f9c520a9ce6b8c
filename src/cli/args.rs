//! What may be typed.

use std::path::PathBuf;

use clap::builder::RangedU64ValueParser;
use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};

use super::bytes::parse_bytes;
use super::view_args::{RenderArgs, ScoreArgs};
use crate::document::colour::MOST_STOPS;
use crate::geometry::Similarity;
use crate::layers::fill::{FillOptions, Invent};
use crate::layers::{BoxShape, Method, Options};
use crate::recipe::open::Opened;
use crate::task::Task;

/// Calibrated photos and a coarse model become editable image layers, sorted by proven visibility.
#[derive(Debug, Parser)]
#[command(name = "quadratura", version, propagate_version = true, subcommand_required = true)]
#[command(arg_required_else_help = true, max_term_width = 100)]
#[command(after_help = "Exit status: 0 done, 1 failed (also when one photo failed and the others \
                        went on), 2 wrong usage, 130 stopped by Ctrl-C.")]
pub struct Cli {
    #[command(flatten)]
    pub global: Global,
    #[command(subcommand)]
    pub command: Command,
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

#[derive(Debug, Subcommand)]
pub enum Command {
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
    /// COLMAP's cameras, text or binary: the folder, or one of its files
    #[arg(long, value_name = "PATH")]
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
    /// Memory to use, such as 4G or 800M [default: a quarter of the machine's]
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    pub memory: Option<u64>,
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
    /// Memory for decoded photos, such as 4G or 800M [default: a quarter of the machine's]
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    pub memory: Option<u64>,
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

#[derive(Debug, Args)]
pub struct ExportArgs {
    /// The project's folder
    pub project: PathBuf,
    /// What to write
    #[arg(long, value_enum, default_value_t = FormatArg::Psd)]
    pub format: FormatArg,
    /// The folder to write to
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    /// Write also where every filled texel comes from: a coloured PNG per image layer and a legend
    #[arg(long)]
    pub provenance: bool,
    /// With exposures evened out: to the reference that `colour` chose, else to the common exposure. For
    /// looking at: such files cannot be imported
    #[arg(long)]
    pub even_colour: bool,
    /// Memory to use, such as 4G or 800M [default: a quarter of the machine's]
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    pub memory: Option<u64>,
}

#[derive(Debug, Args)]
pub struct ColourArgs {
    /// The project's folder
    pub project: PathBuf,
    /// Give this photo a gain, in stops by which it is brighter than the exposure that all are brought to:
    /// red, green and blue, or one number for all three (may be given several times)
    #[arg(long, value_name = "PHOTO=R,G,B", value_parser = fixed_gain)]
    pub fix: Vec<(String, [f64; 3])>,
    /// Do not ask this photo when gains are estimated: its own is 0, unless it is fixed (may be given
    /// several times)
    #[arg(long, value_name = "PHOTO")]
    pub leave_out: Vec<String>,
    /// Take back what was fixed or left out of this photo (may be given several times)
    #[arg(long, value_name = "PHOTO")]
    pub free: Vec<String>,
    /// Pictures come out with the exposure of this photo; `none`: with that of the photos near each view
    #[arg(long, value_name = "PHOTO|none")]
    pub reference: Option<String>,
    /// Show, fill and compare photos as they are, and keep what was decided
    #[arg(long, conflicts_with = "on")]
    pub off: bool,
    /// Even exposures out again
    #[arg(long)]
    pub on: bool,
    /// Estimate how lenses darken the corners, and take it out: where a camera took four photos or more that
    /// share enough
    #[arg(long, value_enum)]
    pub vignetting: Option<Switch>,
    /// Estimate the light that was added everywhere in a photo (haze, a wrong black level), and take it out
    #[arg(long, value_enum)]
    pub offset: Option<Switch>,
    /// Take back all decisions, before others of this command
    #[arg(long)]
    pub reset: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    On,
    Off,
}

#[derive(Debug, Args)]
pub struct ImportArgs {
    /// The project's folder
    pub project: PathBuf,
    /// Edited files, and folders that were exported as such
    #[arg(value_name = "PATH", required_unless_present_any = ["undo", "history"])]
    pub files: Vec<PathBuf>,
    /// Only tell what would be imported
    #[arg(long, conflicts_with_all = ["undo", "history"])]
    pub dry_run: bool,
    /// Take the paint of an image home that was scaled in the editor: what is fainter than scaling's own errors is lost
    #[arg(long)]
    pub scaled: bool,
    /// Take back the last import
    #[arg(long, conflicts_with_all = ["files", "history"])]
    pub undo: bool,
    /// List the imports that can be taken back
    #[arg(long, conflicts_with = "files")]
    pub history: bool,
}

#[derive(Debug, Args)]
pub struct WatchArgs {
    /// The project's folder
    pub project: PathBuf,
    /// The folder that the image editor saves to
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// End after the first import that changed something
    #[arg(long)]
    pub once: bool,
    /// As for import
    #[arg(long)]
    pub scaled: bool,
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

/// The options of the method; those not given are the project's.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Options of the method")]
pub struct OptionArgs {
    /// How visibility layers are found: the occlusion graph, or stencil peeling as published in 2003
    #[arg(long, value_enum)]
    pub method: Option<MethodArg>,
    /// One surface hides another when it is nearer by more than this share of its depth
    #[arg(long, value_name = "T", value_parser = tolerance)]
    pub tolerance: Option<f32>,
    /// A contradiction of at most so many pixels is forgiven as contact noise
    #[arg(long, value_name = "N")]
    pub min_support: Option<u32>,
    /// Pixels added around an image layer on every side
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<u32>::new().range(0..=4096))]
    pub margin: Option<u32>,
    /// Sides of image layers: as they are, or powers of two
    #[arg(long, value_enum)]
    pub boxes: Option<BoxArg>,
    /// Merge image layers within one visibility layer only, the rule of 2003
    #[arg(long, action = ArgAction::Set, num_args = 0..=1, require_equals = true,
          default_missing_value = "true", value_name = "true|false", hide_possible_values = true)]
    pub published: Option<bool>,
    /// Give no image layer a longer side, in pixels: larger surfaces get several, side by side
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<u32>::new().range(64..=1 << 20))]
    pub largest_side: Option<u32>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum MethodArg {
    Graph,
    Stencil,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum BoxArg {
    Exact,
    PowerOfTwo,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FormatArg {
    /// One layered PSD a photo, for Photoshop, GIMP and Krita
    Psd,
    /// A folder of PNG files with stack.json
    Folder,
    /// OpenRaster, for Krita
    Ora,
    /// XCF, for GIMP: opens fastest, and locks hold
    Xcf,
}

impl OptionArgs {
    /// `options` with those that were given.
    pub fn applied_to(&self, options: &Options) -> Options {
        Options {
            method: self.method.map_or(options.method, Method::from),
            tolerance: self.tolerance.unwrap_or(options.tolerance),
            min_support: self.min_support.unwrap_or(options.min_support),
            margin: self.margin.unwrap_or(options.margin),
            boxes: self.boxes.map_or(options.boxes, BoxShape::from),
            published: self.published.unwrap_or(options.published),
            largest_side: self.largest_side.unwrap_or(options.largest_side),
        }
    }
}

impl From<MethodArg> for Method {
    fn from(arg: MethodArg) -> Self {
        match arg {
            MethodArg::Graph => Self::Graph,
            MethodArg::Stencil => Self::Stencil,
        }
    }
}

impl From<BoxArg> for BoxShape {
    fn from(arg: BoxArg) -> Self {
        match arg {
            BoxArg::Exact => Self::Exact,
            BoxArg::PowerOfTwo => Self::PowerOfTwo,
        }
    }
}

fn fixed_gain(text: &str) -> Result<(String, [f64; 3]), String> {
    let expected =
        || format!("expected a photo and stops such as 0001.jpg=0.5,0.4,0.4, {MOST_STOPS} at most");
    // Names may have a `=`, stops have none.
    let (photo, stops) = text.rsplit_once('=').ok_or_else(expected)?;
    let stops: Vec<f64> =
        stops.split(',').map(|s| s.trim().parse()).collect::<Result<_, _>>().map_err(|_| expected())?;
    let stops = match stops[..] {
        [all] => [all; 3],
        [r, g, b] => [r, g, b],
        _ => return Err(expected()),
    };
    let in_range = !photo.is_empty() && stops.iter().all(|s| s.abs() <= MOST_STOPS);
    if in_range { Ok((photo.to_owned(), stops)) } else { Err(expected()) }
}

fn tolerance(text: &str) -> Result<f32, String> {
    let tolerance = text.parse().map_err(|_| "expected a number such as 0.0001".to_string())?;
    let options = Options { tolerance, ..Options::default() };
    options.problem().map_or(Ok(tolerance), Err)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_contradicts_itself_nowhere() {
        Cli::command().debug_assert();
    }

    const NEW: &str = "quadratura new p --photos a --cameras b --model c";

    #[test]
    fn options_that_were_not_given_are_the_projects() {
        let typed = NEW.split(' ').chain(["--margin", "4", "--published", "--boxes", "exact"]);
        let Command::New(args) = Cli::parse_from(typed).command else { unreachable!() };
        let of_project = Options { min_support: 3, ..Options::default() };
        let expected = Options { margin: 4, published: true, boxes: BoxShape::Exact, ..of_project.clone() };
        assert_eq!(args.options.applied_to(&of_project), expected);
    }

    #[test]
    fn gains_are_three_numbers_or_one_and_photos_may_have_any_name() {
        assert_eq!(fixed_gain("a=b.jpg=0.5,-1,0"), Ok(("a=b.jpg".into(), [0.5, -1.0, 0.0])));
        assert_eq!(fixed_gain("1.jpg=-0.5"), Ok(("1.jpg".into(), [-0.5; 3])));
        for text in ["1.jpg", "1.jpg=", "1.jpg=1,2", "=1", "1.jpg=NaN", "1.jpg=99"] {
            assert!(fixed_gain(text).is_err(), "{text}");
        }
    }

    #[test]
    fn what_is_out_of_range_is_wrong_usage() {
        for option in ["--tolerance=1", "--tolerance=NaN", "--margin=-1", "--largest-side=0"] {
            let error = Cli::try_parse_from(NEW.split(' ').chain([option])).unwrap_err();
            assert_eq!(error.exit_code(), 2, "{option}");
        }
    }
}
