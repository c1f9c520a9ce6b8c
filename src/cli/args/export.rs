//! Arguments of `export`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{MemoryArg, PhotoArgs};

#[derive(Debug, Args)]
pub struct ExportArgs {
    /// The project folder
    pub project: PathBuf,
    /// The format to write
    #[arg(long, value_enum, default_value_t = FormatArg::Psd)]
    pub format: FormatArg,
    /// The folder to write to
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
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

/// The formats of exports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FormatArg {
    /// One layered PSD per photo, for Photoshop, GIMP and Krita
    Psd,
    /// A folder of PNG files with stack.json
    Folder,
    /// OpenRaster, for Krita
    Ora,
    /// XCF, for GIMP: opens fastest, and locks are kept
    Xcf,
}
