//! What may be typed for `export`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::{MemoryArg, PhotoArgs};
use crate::document::export_record::ExportFormat;
use crate::io::layered::FORMATS;
use crate::io::layered::format::LayeredFormat;

#[derive(Debug, Args)]
pub struct ExportArgs {
    /// The project's folder
    pub project: PathBuf,
    /// What to write
    #[arg(long, value_parser = formats(), default_value_t = ExportFormat::Psd)]
    pub format: ExportFormat,
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
    #[command(flatten)]
    pub memory: MemoryArg,
}

/// Those of the table, with what it says of them.
fn formats() -> impl TypedValueParser<Value = ExportFormat> {
    let value = |entry: &LayeredFormat| PossibleValue::new(entry.format.name()).help(entry.about);
    let names = PossibleValuesParser::new(FORMATS.iter().map(value));
    names.map(|name| name.parse().expect("the table names formats as they are parsed"))
}
