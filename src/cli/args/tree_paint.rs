//! Arguments of `tree export` and `tree import`.

use std::path::PathBuf;

use clap::Args;

use super::export::formats;
use quadratura_document::export_record::ExportFormat;

#[derive(Debug, Args)]
pub struct TreeExportArgs {
    /// The project folder
    pub project: PathBuf,
    /// The species: one of the project's
    pub species: String,
    /// Paint a part of the plant, by its name in `tree info`: all of its instances, in all trees of the species [default: the whole plant]
    #[arg(long, value_name = "NAME")]
    pub part: Option<String>,
    /// The format to write
    #[arg(long, value_parser = formats(), default_value_t = ExportFormat::Psd)]
    pub format: ExportFormat,
    /// The folder to write to
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

#[derive(Debug, Args)]
pub struct TreeImportArgs {
    /// The project folder
    pub project: PathBuf,
    /// Edited files, exported folders, or folders that contain them
    #[arg(value_name = "PATH", required_unless_present_any = ["undo", "history"])]
    pub files: Vec<PathBuf>,
    /// Preview what would be imported
    #[arg(long, conflicts_with_all = ["undo", "history"])]
    pub dry_run: bool,
    /// Import an image that was scaled in the editor; paint fainter than the errors of scaling is lost
    #[arg(long, conflicts_with_all = ["undo", "history"])]
    pub scaled: bool,
    /// Undo the last import
    #[arg(long, conflicts_with_all = ["files", "history"])]
    pub undo: bool,
    /// List the imports that can be undone
    #[arg(long, conflicts_with = "files")]
    pub history: bool,
}
