//! The commands `tree export` and `tree import`.

use std::path::Path;

use serde_json::json;

use crate::Outcome;
use crate::args::{TreeExportArgs, TreeImportArgs};
use crate::bytes::readable_bytes;
use crate::import::{remarks, table, when};
use crate::lock::{lock_and_read, read_with_lock_if};
use crate::table::{Table, counted};
use crate::words::{command_for_project, error_text};
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_document::tree_paint::TreeImport;
use quadratura_editing::import::report::FileReport;
use quadratura_editing::tree_paint::{
    TreeExportOptions, TreeImportOptions, TreeImported, export_species, import_tree_paint,
    tree_import_history, undo_tree_import,
};
use quadratura_files::writable::check_folder;
use quadratura_io::project::below;

/// Runs `tree export`.
pub fn export(args: &TreeExportArgs, task: &Task) -> Result<Outcome> {
    // What cannot be written is reported before the work, not after it.
    check_folder(&args.out)?;
    let (_lock, project) = lock_and_read(&args.project, task)?;
    let options = TreeExportOptions { format: args.format, part: args.part.clone() };
    let done = export_species(&args.project, &project.trees, &args.species, &args.out, &options, task)?;
    let mut table = Table::new(&["species", "views", "layers", "size", "file"]);
    let (views, layers, size) =
        (done.groups.to_string(), done.layers.to_string(), readable_bytes(done.bytes));
    table.row([done.photo.clone(), views, layers, size, done.path.display().to_string()]);
    let import = command_for_project("tree import");
    let text = format!("{}\npaint on it, save it, and run {import} with the saved file\n", table.render());
    let json = json!({
        "species": args.species,
        "part": args.part,
        "path": done.path,
        "spared": done.spared,
        "key": done.key,
        "views": done.groups,
        "layers": done.layers,
        "bytes": done.bytes,
        "problems": [],
    });
    Ok(Outcome { text, json, problems: Vec::new() })
}

/// Runs `tree import`: reads edited files as paint of species, lists the imports of the past, or undoes the last one.
pub fn import(args: &TreeImportArgs, task: &Task) -> Result<Outcome> {
    let TreeImportArgs { dry_run, scaled, .. } = *args;
    let (_lock, project) = read_with_lock_if(!dry_run && !args.history, &args.project, task)?;
    if args.history {
        return Ok(history(&args.project, &tree_import_history(&args.project)?));
    }
    if args.undo {
        return Ok(undone(&args.project, &undo_tree_import(&args.project)?));
    }
    let options = TreeImportOptions { dry_run, scaled };
    let imported = import_tree_paint(&args.project, &project.trees, &args.files, options, task)?;
    Ok(report(&imported, dry_run))
}

fn report(imported: &TreeImported, dry_run: bool) -> Outcome {
    let mut text = String::new();
    for file in &imported.files {
        text.push_str(&format!("{} -> {}\n{}", file.file.display(), file.photo, table(file)));
        remarks(file).iter().for_each(|remark| text.push_str(&format!("  {remark}\n")));
        text.push('\n');
    }
    let changed = counted(imported.changed as usize, "texel");
    text.push_str(&match (imported.number, dry_run) {
        (None, _) => "nothing changed\n".to_owned(),
        (Some(_), true) => format!("{changed} would change; nothing was written\n"),
        (Some(number), false) => {
            let species = imported.species.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
            let (undo, bake) = (command_for_project("tree import --undo"), command_for_project("tree bake"));
            format!(
                "import {number}: {changed} changed; {undo} undoes it\nthe images of {species} are made again by the next picture, or \
                 by {bake}\n"
            )
        }
    });
    let refused = imported.failed.iter().map(|(_, problem)| error_text(problem));
    let problems: Vec<String> =
        refused.chain(imported.files.iter().filter_map(FileReport::problem)).collect();
    let json = json!({
        "import": imported.number.filter(|_| !dry_run),
        "dry_run": dry_run,
        "changed": imported.changed,
        "species": imported.species,
        "files": imported.files.iter().map(file_facts).collect::<Vec<_>>(),
        "problems": problems,
    });
    Outcome { text, json, problems }
}

/// Returns what programs are told of a file: as of one of a photo, with the species in the place of the photo.
fn file_facts(file: &FileReport) -> serde_json::Value {
    let mut facts = json!(file);
    if let Some(fields) = facts.as_object_mut()
        && let Some(title) = fields.remove("photo")
    {
        fields.insert("species".into(), title);
    }
    facts
}

fn history(project: &Path, imports: &[TreeImport]) -> Outcome {
    let mut table = Table::new(&["import", "when (UTC)", "texels", "species", "files"]);
    for import in imports {
        let species = import.species.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        let (number, texels) = (import.number.to_string(), import.texels.to_string());
        table.row([number, when(import.time), texels, species, files_of(project, import).join(", ")]);
    }
    let text = match imports.is_empty() {
        true => "there is no import of paint of trees to undo\n".to_owned(),
        false => {
            format!("{}\n{} undoes the last one\n", table.render(), command_for_project("tree import --undo"))
        }
    };
    let json = json!({ "imports": imports.iter().map(|import| facts(project, import)).collect::<Vec<_>>() });
    Outcome { text, json, problems: Vec::new() }
}

fn undone(project: &Path, import: &TreeImport) -> Outcome {
    let files = files_of(project, import).join(", ");
    let text = format!("import {} of {files} was undone\n", import.number);
    Outcome { text, json: json!({ "undone": facts(project, import) }), problems: Vec::new() }
}

/// Returns the paths of an import's files relative to the current folder; they are stored relative to the project.
fn files_of(project: &Path, import: &TreeImport) -> Vec<String> {
    import.files.iter().map(|file| below(project, file).display().to_string()).collect()
}

fn facts(project: &Path, import: &TreeImport) -> serde_json::Value {
    json!({
        "import": import.number,
        "time": import.time,
        "files": files_of(project, import),
        "species": import.species,
        "texels": import.texels,
    })
}
