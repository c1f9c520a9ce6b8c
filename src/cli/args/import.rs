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
    /// Leave out paint where a photo, this one or another, shows the surface
    #[arg(long, conflicts_with_all = ["undo", "history"])]
    pub only_unseen: bool,
    /// Import a file in which most pixels of most layers have changed at once
    #[arg(long, conflicts_with_all = ["undo", "history"])]
    pub all: bool,
    /// Show this paint only in its photo: project it to no other one
    #[arg(long, conflicts_with_all = ["undo", "history"])]
    pub only_here: bool,
    /// Undo the last import, or the one with this number, on which no later one depends
    #[arg(long, value_name = "NUMBER", num_args = 0..=1, conflicts_with_all = ["files", "history"])]
    pub undo: Option<Option<u32>>,
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
    /// Leave out paint where a photo shows the surface, as for import
    #[arg(long)]
    pub only_unseen: bool,
    /// Import files in which most pixels of most layers have changed at once, too
    #[arg(long)]
    pub all: bool,
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
