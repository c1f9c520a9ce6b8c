//! Arguments of `model`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use quadratura_import::cameras::accepted;

#[derive(Debug, Args)]
pub struct ModelArgs {
    #[command(subcommand)]
    pub command: ModelCommand,
}

#[derive(Debug, Subcommand)]
pub enum ModelCommand {
    /// Suggest a first model from photos, cameras and sparse points, or what the project's model does not explain
    Suggest(ModelSuggestArgs),
}

#[derive(Debug, Args)]
pub struct ModelSuggestArgs {
    /// The project folder; without a project, give --photos and --cameras
    #[arg(required_unless_present = "photos", conflicts_with_all = ["photos", "cameras"])]
    pub project: Option<PathBuf>,
    /// The folder of the photos, where there is no project yet
    #[arg(long, value_name = "DIR", requires = "cameras")]
    pub photos: Option<PathBuf>,
    #[arg(long, value_name = "PATH", requires = "photos", help = format!("The cameras: {}", accepted()))]
    pub cameras: Option<PathBuf>,
    /// The chunk of Metashape's file to read, by its name [default: the one with most aligned cameras]
    #[arg(long, value_name = "NAME", requires = "photos")]
    pub chunk: Option<String>,
    /// The file to write, an OBJ [default: suggested.obj in the project's folder, else in the working folder]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// A dense mesh to take planes from instead of sparse points: PLY, OBJ, glTF or GLB, in the cameras' coordinates
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Keep the project's model, and suggest only what it does not explain, in the coordinates of the model's file
    #[arg(long, requires = "project")]
    pub add: bool,
    /// Write an earlier suggestion anew, if nobody has changed its file
    #[arg(long)]
    pub replace: bool,
}
