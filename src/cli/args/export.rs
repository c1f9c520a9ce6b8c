//! Arguments of `export`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::{MemoryArg, PartArg, PhotoArgs};
use quadratura_document::export_record::ExportFormat;
use quadratura_io::layered::FORMATS;
use quadratura_io::layered::format::LayeredFormat;

#[derive(Debug, Args)]
pub struct ExportArgs {
    /// The project folder
    pub project: PathBuf,
    /// The format to write
    #[arg(long, value_parser = formats(), default_value_t = ExportFormat::Psd)]
    pub format: ExportFormat,
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
}

/// Returns a parser for the formats in the table.
pub fn formats() -> impl TypedValueParser<Value = ExportFormat> {
    let value = |entry: &LayeredFormat| PossibleValue::new(entry.format.name()).help(entry.about);
    let names = PossibleValuesParser::new(FORMATS.iter().map(value));
    names.map(|name| name.parse().expect("the table names formats as they are parsed"))
}
