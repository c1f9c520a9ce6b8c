//! What may be typed for `import` and `watch`.

use std::path::PathBuf;

use clap::Args;

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
