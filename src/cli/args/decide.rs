//! What may be typed for `decide`.

use std::path::PathBuf;

use clap::Args;

use super::method;

#[derive(Debug, Args)]
#[command(
    after_help = "WHAT is an object, faces of one as 'OBJECT[3, 5-8]', or the token of an image layer. Decisions \
                        hold for every photo that is named, and `quadratura build` makes what they change."
)]
pub struct DecideArgs {
    /// The project's folder
    pub project: PathBuf,
    /// About this photo (may be given several times); without a decision: show only its decisions
    #[arg(long = "photo", value_name = "NAME")]
    pub photos: Vec<String>,
    /// These share one image layer, whatever it costs; refused where they lie before and behind each other
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "photos")]
    pub merge: Vec<String>,
    /// These share an image layer with nothing else, or with nothing of --from
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "photos")]
    pub split: Vec<String>,
    /// What --split keeps apart from
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "split")]
    pub from: Vec<String>,
    /// Call the image layer of --of so; an empty name gives it its own back
    #[arg(long, value_name = "NAME", requires = "of", requires = "photos")]
    pub name: Option<String>,
    /// What the image layer to be named holds most of
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "name")]
    pub of: Vec<String>,
    /// The photo gives these no texture
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "photos")]
    pub exclude: Vec<String>,
    /// The photo alone gives these texture, as far as it shows them
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "photos")]
    pub pin: Vec<String>,
    /// The photo neither excludes these nor are they pinned to it, whatever was decided before
    #[arg(long, value_name = "WHAT", num_args = 1.., requires = "photos")]
    pub free: Vec<String>,
    /// The photo's own tolerance; `project`: that of the project again
    #[arg(long, value_name = "T", value_parser = or_project(method::tolerance), requires = "photos")]
    pub tolerance: Option<OwnOption<f32>>,
    /// The photo's own min_support; `project`: that of the project again
    #[arg(long, value_name = "N", value_parser = or_project(number), requires = "photos")]
    pub min_support: Option<OwnOption<u32>>,
    /// The photo's own margin, in pixels; `project`: that of the project again
    #[arg(long, value_name = "N", value_parser = or_project(number), requires = "photos")]
    pub margin: Option<OwnOption<u32>>,
    /// Take the decision with this number back, before others of this command (may be given several times)
    #[arg(long, value_name = "N", requires = "photos")]
    pub forget: Vec<usize>,
    /// Take all decisions about the photos back, or all there are, before others of this command
    #[arg(long)]
    pub reset: bool,
}

/// An option of a photo: its own, or the project's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnOption<T>(pub Option<T>);

fn or_project<T>(
    parse: impl Fn(&str) -> Result<T, String> + Clone,
) -> impl Fn(&str) -> Result<OwnOption<T>, String> + Clone {
    move |text| {
        if text == "project" { Ok(OwnOption(None)) } else { parse(text).map(|own| OwnOption(Some(own))) }
    }
}

fn number(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| "expected a number, or `project`".into())
}
