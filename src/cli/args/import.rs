//! Arguments of `import`, `watch` and `stroke`.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub struct ImportArgs {
    /// The project folder
    pub project: PathBuf,
    /// Edited files, exported folders, or folders that contain them
    #[arg(value_name = "PATH", required_unless_present_any = ["undo", "history"])]
    pub files: Vec<PathBuf>,
    /// Preview what would be imported
    #[arg(long, conflicts_with_all = ["undo", "history"])]
    pub dry_run: bool,
    /// Import an image that was scaled in the editor; paint fainter than the errors of scaling is lost
    #[arg(long)]
    pub scaled: bool,
    /// Show this paint only in its photo: project it to no other one
    #[arg(long, conflicts_with_all = ["undo", "history"])]
    pub only_here: bool,
    /// Undo the last import
    #[arg(long, conflicts_with_all = ["files", "history"])]
    pub undo: bool,
    /// List the imports that can be undone
    #[arg(long, conflicts_with = "files")]
    pub history: bool,
}

#[derive(Debug, Args)]
pub struct WatchArgs {
    /// The project folder
    pub project: PathBuf,
    /// The folder in which the image editor saves
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Stop after the first import that changes something
    #[arg(long)]
    pub once: bool,
    /// Import images that were scaled in the editor, as for import
    #[arg(long)]
    pub scaled: bool,
    /// Show this paint only in its photo, as for import
    #[arg(long)]
    pub only_here: bool,
}

#[derive(Debug, Args)]
pub struct StrokeArgs {
    /// The project folder
    pub project: PathBuf,
    /// The stroke as a JSON file: view, brush and positions
    pub file: PathBuf,
    /// Preview how many pixels would change
    #[arg(long)]
    pub dry_run: bool,
    /// Show this paint only in its photos, as for import
    #[arg(long)]
    pub only_here: bool,
    /// Paint on flat faces, as modelled, without depth detail from photos
    #[arg(long)]
    pub flat: bool,
}
