//! Arguments of `decide`.

use std::path::PathBuf;

use clap::Args;

use super::method;
use super::number::whole;

#[derive(Debug, Args)]
#[command(
    after_help = "WHAT is an object, faces of an object as 'OBJECT[3, 5-8]', or the token of an image layer. \
                  Decisions hold for every photo named; `quadratura update` applies them to the layers."
)]
pub struct DecideArgs {
    /// The project folder
    pub project: PathBuf,
    /// The photo to decide about (may be given several times); without a decision: list only its decisions
    #[arg(long = "photo", value_name = "NAME")]
    pub photos: Vec<String>,
    /// List the photos' image layers with their tokens, and with which others each can be merged
    #[arg(long)]
    pub list: bool,
    /// Put these into one image layer, whatever its size; refused where one lies in front of and behind
    /// another, but parts of one object are linked there
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "photos")]
    pub merge: Vec<String>,
    /// With --merge: put parts of one object together although they occlude each other; other photos texture what is
    /// behind
    #[arg(long, requires = "merge")]
    pub tolerate: bool,
    /// Separate these from everything else in image layers, or from what --from names
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "photos")]
    pub split: Vec<String>,
    /// Separate the faces of --split from these
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "split")]
    pub from: Vec<String>,
    /// Name the image layer of --of; an empty name restores its own
    #[arg(long, value_name = "NAME", requires = "of", requires = "photos")]
    pub name: Option<String>,
    /// Contents of the image layer to be named
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "name")]
    pub of: Vec<String>,
    /// Do not texture these from the photo
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "photos")]
    pub exclude: Vec<String>,
    /// Texture these from this photo only, as far as it shows them
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "photos")]
    pub pin: Vec<String>,
    /// Remove exclusions and pins of these for the photo
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "photos")]
    pub free: Vec<String>,
    /// The photo's own tolerance; `project`: use the project's
    #[arg(long, value_name = "T", value_parser = or_project(method::tolerance), requires = "photos")]
    pub tolerance: Option<OptionOverride<f32>>,
    /// The photo's own min_support; `project`: use the project's
    #[arg(long, value_name = "N", value_parser = or_project(number), requires = "photos")]
    pub min_support: Option<OptionOverride<u32>>,
    /// The photo's own margin, in pixels; `project`: use the project's
    #[arg(long, value_name = "N", value_parser = or_project(number), requires = "photos")]
    pub margin: Option<OptionOverride<u32>>,
    /// The photo's own min_visible, in pixels; `project`: use the project's
    #[arg(long, value_name = "N", value_parser = or_project(number), requires = "photos")]
    pub min_visible: Option<OptionOverride<u32>>,
    /// The photo's own min_share; `project`: use the project's
    #[arg(long, value_name = "S", value_parser = or_project(method::share), requires = "photos")]
    pub min_share: Option<OptionOverride<f32>>,
    /// The photo's own tolerated; `project`: use the project's
    #[arg(long, value_name = "S", value_parser = or_project(method::share), requires = "photos")]
    pub tolerated: Option<OptionOverride<f32>>,
    /// Turn these objects towards each photo and each viewer, as billboards turn; `*` stands for any
    /// characters
    #[arg(long, value_name = "OBJECT", num_args = 1..)]
    pub impostor: Vec<String>,
    /// Do not turn these objects, although their names say billboard
    #[arg(long, value_name = "OBJECT", num_args = 1..)]
    pub no_impostor: Vec<String>,
    /// Remove decisions by --impostor and --no-impostor about these objects: those whose names say billboard turn; `*` stands for
    /// any characters
    #[arg(long, value_name = "OBJECT", num_args = 1..)]
    pub free_impostor: Vec<String>,
    /// One may see through these objects in places, as through a fence: mattes of them are found, and views show what is
    /// behind their gaps; `*` stands for any characters
    #[arg(long, value_name = "OBJECT", num_args = 1..)]
    pub see_through: Vec<String>,
    /// These objects are solid; without a decision one may see through what turns towards the camera
    #[arg(long, value_name = "OBJECT", num_args = 1..)]
    pub no_see_through: Vec<String>,
    /// Remove decisions by --see-through and --no-see-through about these objects: one may see through what turns towards the
    /// camera; `*` stands for any characters
    #[arg(long, value_name = "OBJECT", num_args = 1..)]
    pub free_see_through: Vec<String>,
    /// Remove the decision with this number first, before applying others (may be given several times)
    #[arg(long, value_name = "N", requires = "photos", value_parser = whole::<usize>(1..=1_000_000))]
    pub forget: Vec<usize>,
    /// Remove all decisions about the photos, or all decisions about photos, before applying others
    #[arg(long)]
    pub reset: bool,
}

/// An option of a photo: `Some` for its own value, `None` for the project's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OptionOverride<T>(pub Option<T>);

/// Returns a parser that also accepts the word `project`.
fn or_project<T>(
    parse: impl Fn(&str) -> Result<T, String> + Clone,
) -> impl Fn(&str) -> Result<OptionOverride<T>, String> + Clone {
    move |text| {
        if text == "project" {
            Ok(OptionOverride(None))
        } else {
            parse(text).map(|own| OptionOverride(Some(own)))
        }
    }
}

fn number(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| "expected a whole number of 0 or more, or `project`".into())
}
