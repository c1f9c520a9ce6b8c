//! Arguments of `matte`.

use std::path::PathBuf;

use clap::Args;

use super::{MemoryArg, PhotoArgs};

#[derive(Debug, Args)]
pub struct MatteArgs {
    /// The project folder
    pub project: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    /// Show only this object (may be given several times; `*` stands for any characters)
    #[arg(long = "object", value_name = "NAME")]
    pub objects: Vec<String>,
    #[command(flatten)]
    pub memory: MemoryArg,
    /// Find mattes that are up to date again, too
    #[arg(long)]
    pub force: bool,
}
