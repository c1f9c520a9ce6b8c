//! Arguments of `export`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::baked::BakedArgs;
use super::page::PageArgs;
use super::{MemoryArg, PartArg, PhotoArgs};
use quadratura_document::export_record::ExportFormat;
use quadratura_exports::handover::HandoverFormat;
use quadratura_layered_files::FORMATS;
use quadratura_layered_files::format::LayeredFormat;

#[derive(Debug, Args)]
pub struct ExportArgs {
    /// The project folder
    pub project: PathBuf,
    /// The format to write: a layered file per photo, or a folder with the site for another program
    #[arg(long, value_parser = targets(), default_value = "psd")]
    pub format: ExportTarget,
    /// The folder to write to
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    #[command(flatten)]
    pub part: PartArg,
    /// Also write the source of every filled texel: a coloured PNG per image layer and a legend
    #[arg(long)]
    pub provenance: bool,
    /// Export with matched exposures: to the reference set with `colour`, else to the common exposure. For
    /// viewing only: such files cannot be imported
    #[arg(long)]
    pub even_colour: bool,
    #[command(flatten)]
    pub memory: MemoryArg,
    // Last, because their headings are those of all that follows.
    #[command(flatten)]
    pub handover: HandoverArgs,
    #[command(flatten)]
    pub baked: BakedArgs,
    #[command(flatten)]
    pub page: PageArgs,
}

/// Options of the formats of other programs.
#[derive(Debug, Args)]
#[command(next_help_heading = "Other programs")]
pub struct HandoverArgs {
    /// The most photos that texture a face, chosen so that their directions spread; for --format blender [default: 8]
    #[arg(long, value_name = "N", value_parser = counted)]
    pub photos_per_face: Option<usize>,
    /// Write coordinates of the cameras' world, although the site has a frame (`quadratura frame`)
    #[arg(long)]
    pub world: bool,
    /// Also make site.blend, with Blender or the Python module bpy where one of them is found; for --format blender
    #[arg(long)]
    pub blend: bool,
}

/// Parses a number of things, at least one.
fn counted(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) | Err(_) => Err("expected a whole number from 1".to_owned()),
        Ok(count) => Ok(count),
    }
}

/// What `export` writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportTarget {
    /// A layered file or folder per photo, for image editors.
    Layered(ExportFormat),
    /// The site in a format of another program.
    Handover(HandoverFormat),
    /// The site as a page for browsers.
    Page,
}

/// The name of pages, and what they are.
const PAGE: (&str, &str) =
    ("page", "The whole site as a web page in which one walks: a folder that any browser opens");

/// Returns a parser for all that `export` writes.
fn targets() -> impl TypedValueParser<Value = ExportTarget> {
    let layered = FORMATS.iter().map(value);
    let handover =
        HandoverFormat::TABLE.iter().map(|(name, _, about)| PossibleValue::new(*name).help(*about));
    let page = std::iter::once(PossibleValue::new(PAGE.0).help(PAGE.1));
    PossibleValuesParser::new(layered.chain(handover).chain(page)).map(|typed| match typed.parse() {
        Ok(format) => ExportTarget::Layered(format),
        Err(_) if typed == PAGE.0 => ExportTarget::Page,
        Err(_) => {
            let found = HandoverFormat::TABLE.iter().find(|(name, ..)| *name == typed);
            ExportTarget::Handover(found.expect("the parser knows the names of the two tables alone").1)
        }
    })
}

/// Returns a parser for the layered formats in the table.
pub fn formats() -> impl TypedValueParser<Value = ExportFormat> {
    let names = PossibleValuesParser::new(FORMATS.iter().map(value));
    names.map(|name| name.parse().expect("the table names formats as they are parsed"))
}

fn value(entry: &LayeredFormat) -> PossibleValue {
    PossibleValue::new(entry.format.name()).help(entry.about)
}
