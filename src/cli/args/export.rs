//! What may be typed for `export`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{MemoryArg, PhotoArgs};

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
    #[command(flatten)]
    pub memory: MemoryArg,
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
