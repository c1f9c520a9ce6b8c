//! The command `model`.

use std::path::Path;

use serde_json::json;

use super::Outcome;
use super::args::{ModelArgs, ModelCommand, ModelSuggestArgs};
use super::table::{Table, counted};
use super::words::{as_typed, error_text, worded};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_import::cameras::CameraOptions;
use quadratura_sites::suggest::{ObjectFigures, SuggestFor, SuggestedModel, write_suggestion};

/// The name of the file that is written where none is asked for.
const NAME: &str = "suggested.obj";

/// Runs `model`.
pub fn run(args: &ModelArgs, task: &Task) -> Result<Outcome> {
    match &args.command {
        ModelCommand::Suggest(args) => suggest(args, task),
    }
}

/// Runs `model suggest`.
fn suggest(args: &ModelSuggestArgs, task: &Task) -> Result<Outcome> {
    let folder = args.project.as_deref().unwrap_or(Path::new(""));
    let out = args.out.clone().unwrap_or_else(|| folder.join(NAME));
    let written = write_suggestion(&source(args), args.mesh.as_deref(), &out, args.replace, task)?;
    let figures: Vec<ObjectFigures> = written.objects.iter().map(ObjectFigures::new).collect();
    let problems: Vec<&Error> = written.problems.iter().collect();
    Ok(Outcome {
        text: format!(
            "{}\n{}{}",
            table(&figures).render(),
            summary(&written, &figures, args.mesh.is_some(), &out),
            next(args, &out)
        ),
        json: json!({
            "file": out.display().to_string(),
            "objects": figures,
            "dropped_faces": written.dropped,
            "predicted_psnr_db": written.psnr_db,
            "photos": written.photos,
            "sparse_points": written.points,
            "left_out": written.problems.iter().map(error_text).collect::<Vec<_>>(),
        }),
        problems: Error::gathered(&problems).iter().map(worded).collect(),
    })
}

fn source(args: &ModelSuggestArgs) -> SuggestFor {
    if let (Some(photos), Some(cameras)) = (&args.photos, &args.cameras) {
        let options = CameraOptions { chunk: args.chunk.clone(), rolling_shutter: false };
        return SuggestFor::Folders { photos: photos.clone(), cameras: cameras.clone(), options };
    }
    SuggestFor::Project { folder: args.project.clone().unwrap_or_default(), add: args.add }
}

fn table(objects: &[ObjectFigures]) -> Table {
    let mut table =
        Table::new(&["object", "faces", "corners", "points", "photos for", "against", "gain", "confidence"]);
    for object in objects {
        table.row([
            object.name.clone(),
            object.faces.to_string(),
            object.corners.to_string(),
            object.points.to_string(),
            format!("{:.1}", object.photos_for),
            format!("{:.1}", object.photos_against),
            object.gain.map_or_else(|| "-".to_owned(), |gain| format!("{gain:.1}")),
            format!("{:.2}", object.confidence),
        ]);
    }
    table
}

fn summary(written: &SuggestedModel, objects: &[ObjectFigures], of_mesh: bool, out: &Path) -> String {
    let faces = objects.iter().map(|object| object.faces).sum();
    format!(
        "{} in {} from {} and {}, written to {}; {} dropped that hardly show, or without which \
         left-out photos are predicted better.\n\"photos for\" is how many photos show a place of the object, \"against\" how many see through it, \"gain\" how \
         much it lowers the error of left-out photos there, of 255.\n",
        counted(faces, "face"),
        counted(objects.len(), "object"),
        counted(written.photos, "photo"),
        counted(written.points, if of_mesh { "mesh point" } else { "sparse point" }),
        out.display(),
        counted(written.dropped, "face"),
    )
}

/// Says what comes next.
fn next(args: &ModelSuggestArgs, out: &Path) -> String {
    let out = as_typed(out);
    match (&args.photos, &args.cameras) {
        (Some(photos), Some(cameras)) => format!(
            "\nNext: run `quadratura new PROJECT --photos {} --cameras {} --model {out}` to create a project with it; complete \
             it in Blender or another modelling program.\n",
            as_typed(photos),
            as_typed(cameras),
        ),
        _ if args.add => {
            format!("\nNext: join {out} with the project's model in Blender or another modelling program.\n")
        }
        _ => {
            format!("\nNext: look at {out} in Blender or another modelling program, and complete it there.\n")
        }
    }
}
