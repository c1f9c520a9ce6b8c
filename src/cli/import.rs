//! The commands `import` and `watch`.

use std::path::{Path, PathBuf};
use std::time::Duration;

use serde_json::json;

use super::Outcome;
use super::args::{ImportArgs, WatchArgs};
use super::coarse::coarse_text;
use super::live::follow_locked;
use super::lock::read_with_lock_if;
use super::table::{Table, counted};
use super::words::{command_for_project, error_text};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::paint::PaintImport;
use quadratura_editing::import::elsewhere::PaintElsewhere;
use quadratura_editing::import::report::{FileReport, LayerImportReport, LayerState};
use quadratura_editing::import::{ImportOptions, Imported, history, import_once, take_back_one};
use quadratura_editing::watch::{WatchOptions, project_lock, watch};
use quadratura_io::documents::documents;
use quadratura_io::project::{below, read_project};
use quadratura_layers::fill::{FillOptions, Propagation};
use quadratura_sites::budget::default_memory;
use quadratura_sites::open::open;
use quadratura_stacks::fill::propagation::{CoarsePaint, coarse_paint};
use quadratura_stacks::fill::seen::propagation_in_words;

/// Runs `import`: reads edited files as paint, lists the imports of the past, or undoes one of them.
pub fn run(args: &ImportArgs, task: &Task) -> Result<Outcome> {
    let project = read_project(&args.project)?;
    if args.history {
        return Ok(history_outcome(&args.project, &history(&args.project)?, &project.fill));
    }
    let ImportArgs { dry_run, scaled, only_here, only_unseen, all, .. } = *args;
    let options = ImportOptions { dry_run, scaled, only_whole: false, only_here, only_unseen, all };
    let _lock = read_with_lock_if(!dry_run, &args.project, task)?;
    if let Some(number) = args.undo {
        return Ok(undo_outcome(&args.project, &take_back_one(&args.project, number)?.0));
    }
    let imported = import_once(&args.project, &args.files, options, task)?;
    let number = imported.number.filter(|_| !dry_run);
    let seen = seen_from(&args.project, &project.fill, args.only_here, number);
    let coarse = number.map_or_else(Vec::new, |_| coarse(&args.project, &imported, task));
    Ok(report(&imported, args.dry_run, &seen, &coarse))
}

/// Returns the paint that is too coarse for other photos. It is about what the next `update` does, so nothing that goes
/// wrong here makes the import fail, which has been written; the update reports the same fault.
fn coarse(project: &Path, imported: &Imported, task: &Task) -> Vec<CoarsePaint> {
    // What opening a project notes is no result of the import.
    let silent = Task::silent().with_stop_flag(task.stop_flag());
    let found = open(project, &silent)
        .and_then(|opened| coarse_paint(project, &opened.project, &opened.site, &imported.book, &silent));
    found.unwrap_or_default()
}

/// Runs `watch`: imports files of a folder whenever an image editor has saved them, until it is interrupted.
pub fn run_watch(args: &WatchArgs, task: &Task) -> Result<Outcome> {
    let project = read_project(&args.project)?;
    refuse_no_folder(&args.folder)?;
    let WatchArgs { scaled, only_here, only_unseen, all, .. } = *args;
    let import = ImportOptions { scaled, only_here, only_unseen, all, ..ImportOptions::default() };
    let mut imports = Vec::new();
    let mut problems = Vec::new();
    let there = counted(documents(&args.folder)?.len(), "layered document");
    let folder = args.folder.display();
    task.note(format!("watching {folder} and its sub-folders ({there} now); press Ctrl-C to stop"));
    task.note(seen_from(&args.project, &project.fill, args.only_here, None));
    let options = WatchOptions { import, once: args.once, ..WatchOptions::default() };
    let hold = || project_lock(&args.project, task);
    watch(&args.project, &args.folder, options, hold, task, |imported, spent| {
        note_import(&imported, spent, task);
        if let Err(error) = follow_import(&args.project, &imported, task) {
            problems.push(error_text(&error));
        }
        problems.extend(problems_of(&imported));
        imports.push(json!({
            "import": imported.number,
            "changed": imported.changed,
            "masked": imported.masked,
            "seconds": spent.as_secs_f64(),
            "files": imported.files,
            "questioned": imported.questioned,
            "elsewhere": imported.elsewhere,
        }));
    })?;
    let text = format!("{}\n", counted(imports.len(), "import"));
    Ok(Outcome { text, json: json!({ "imports": imports, "problems": problems }), problems })
}

/// Brings folders for other programs up to date after an import, but for the one in which the file was saved. The watch has the project's lock.
fn follow_import(project: &Path, imported: &Imported, task: &Task) -> Result<()> {
    if imported.changed == 0 {
        return Ok(());
    }
    let silent = Task::silent().with_stop_flag(task.stop_flag());
    let opened = open(project, &silent)?;
    let saved: Vec<PathBuf> = imported.files.iter().map(|file| file.file.clone()).collect();
    follow_locked(project, &opened, &saved, default_memory(), task)
}

fn refuse_no_folder(folder: &Path) -> Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    let remedy = "give the folder that the image editor saves to";
    if !folder.exists() {
        return Err(Error::input(folder, "", "this folder does not exist", remedy));
    }
    let around = folder.parent().filter(|parent| *parent != Path::new("")).unwrap_or(Path::new("."));
    Err(Error::input(folder, "", "this is a file, not a folder", format!("{remedy}: {}", around.display())))
}

/// Returns what was not imported, for the exit status.
fn problems_of(imported: &Imported) -> Vec<String> {
    let refused = imported.failed.iter().map(|(_, problem)| error_text(problem));
    let left_out = imported.files.iter().filter_map(FileReport::problem);
    refused.chain(imported.questioned.iter().filter_map(question)).chain(left_out).collect()
}

/// Returns the question about a file, with the answers.
fn question(file: &FileReport) -> Option<String> {
    let (path, found) = (file.file.display().to_string(), file.question.as_ref()?.found());
    let quoted = if path.contains(' ') { format!("'{path}'") } else { path.clone() };
    let (all, look) = (
        command_for_project(&format!("import --all {quoted}")),
        command_for_project(&format!("import --all --dry-run {quoted}")),
    );
    Some(format!(
        "{path}: {found}; if it is meant, {all} imports it ({look} shows what it would change), otherwise undo it in the \
         editor and save again"
    ))
}

/// Notes the result of an import while watching.
fn note_import(imported: &Imported, spent: Duration, task: &Task) {
    for file in &imported.files {
        let task = task.with_subject(&file.file.display().to_string());
        let layers = file.layers.iter().filter(|layer| layer.changed > 0).count();
        let number = imported.number.map_or(String::new(), |number| format!(", import {number}"));
        let seconds = spent.as_secs_f64();
        let changed = changed_in_words(std::slice::from_ref(file), false);
        task.note(match layers {
            0 => format!("nothing changed ({seconds:.2} s)"),
            _ => format!("{changed} on {}{number} ({seconds:.2} s)", counted(layers, "layer")),
        });
        remarks(file).iter().for_each(|remark| task.note(remark));
    }
    imported.elsewhere.iter().for_each(|paint| task.note(elsewhere_in_words(paint)));
    problems_of(imported).into_iter().for_each(|problem| task.note(problem));
}

/// Returns a line about where imported paint is seen, and the command that changes it.
pub fn seen_from(project: &Path, fill: &FillOptions, only_here: bool, number: Option<u32>) -> String {
    let project = project.display();
    if only_here {
        let import = number.map_or_else(String::new, |number| format!(" --import {number}"));
        return format!(
            "this paint is seen only in its photo; `quadratura paint {project} --everywhere{import}` changes that"
        );
    }
    let state = propagation_in_words(fill);
    // Before it is written, an import has no number.
    let kept = number.map_or_else(String::new, |number| {
        format!("; `quadratura paint {project} --only-here --import {number}` keeps an import in its photo")
    });
    match &fill.propagate {
        Propagation::Undecided => format!(
            "{state}; `quadratura fill {project} --propagate` shows it from everywhere, `--no-propagate` leaves it there"
        ),
        Propagation::None => format!("{state}; `quadratura paint {project} --everywhere` changes that"),
        Propagation::Of(_) => format!(
            "{state} once `quadratura update {project}` has run, where it is at least half as fine as what the other \
             photos show{kept}"
        ),
    }
}

/// Returns a sentence about other paint that a photo keeps.
pub fn elsewhere_in_words(paint: &PaintElsewhere) -> String {
    let PaintElsewhere { photo, face, imported_in, pixels } = paint;
    format!(
        "conflict: {photo} has other paint on {face} at {} of this import's paint in {imported_in}, and keeps it",
        counted(*pixels as usize, "pixel")
    )
}

/// Returns how many pixels of paint and of masks have changed, as `12 pixels changed, 30 pixels of earlier paint removed`.
fn changed_in_words(files: &[FileReport], dry_run: bool) -> String {
    let of = |wanted: fn(LayerState) -> bool| -> u64 {
        let layers = files.iter().flat_map(|file| &file.layers).filter(|layer| wanted(layer.state));
        layers.map(|layer| layer.changed).sum()
    };
    let kinds = [
        (of(|state| !matches!(state, LayerState::Mask | LayerState::Restored)), ["changed", "would change"]),
        (
            of(|state| state == LayerState::Restored),
            ["of earlier paint removed", "of earlier paint would be removed"],
        ),
        (of(|state| state == LayerState::Mask), ["of masks changed", "of masks would change"]),
    ];
    let kinds = kinds.iter().filter(|(pixels, _)| *pixels > 0);
    let in_words = |(pixels, [is, would]): &(u64, [&str; 2])| {
        format!("{} {}", counted(*pixels as usize, "pixel"), if dry_run { would } else { is })
    };
    let words: Vec<String> = kinds.map(in_words).collect();
    if words.is_empty() { "no pixel changed".to_owned() } else { words.join(", ") }
}

fn report(imported: &Imported, dry_run: bool, seen: &str, coarse: &[CoarsePaint]) -> Outcome {
    let mut text = String::new();
    for file in imported.files.iter().chain(&imported.questioned) {
        text.push_str(&format!("{} -> {}\n{}", file.file.display(), file.photo, table(file)));
        remarks(file).iter().for_each(|remark| text.push_str(&format!("  {remark}\n")));
        text.push('\n');
    }
    imported.elsewhere.iter().for_each(|paint| text.push_str(&format!("{}\n", elsewhere_in_words(paint))));
    let changed = changed_in_words(&imported.files, dry_run);
    text.push_str(&match (imported.number, dry_run) {
        (None, _) => "nothing changed\n".to_owned(),
        (Some(number), false) => {
            let undo = command_for_project("import --undo");
            format!("import {number}: {changed}; {undo} undoes it\n")
        }
        (Some(_), true) => format!("{changed}; nothing was written\n"),
    });
    if imported.changed > imported.masked {
        text.push_str(&format!("{seen}\n"));
    }
    text.push_str(&coarse_text(coarse, "will keep"));
    if !dry_run && !imported.masks.is_empty() {
        text.push_str(&masks_changed());
    }
    let problems = problems_of(imported);
    let json = json!({
        "import": imported.number.filter(|_| !dry_run),
        "dry_run": dry_run,
        "changed": imported.changed,
        "masked": imported.masked,
        "files": imported.files,
        "questioned": imported.questioned,
        "elsewhere": imported.elsewhere,
        "seen": seen,
        "too_coarse": coarse,
        "problems": problems,
    });
    Outcome { text, json, problems }
}

/// The note after masks have changed: stacks do not follow by themselves.
fn masks_changed() -> String {
    format!("masks changed: {} fills the masked areas\n", command_for_project("update"))
}

/// Returns a table with a row for every layer that was changed; the others are only counted.
pub fn table(file: &FileReport) -> String {
    let columns = ["layer", "state", "painted", "erased", "over photos", "changed", "conflicts", "also"];
    let mut table = Table::new(&columns);
    for layer in file.layers.iter().filter(|layer| layer.state != LayerState::Unchanged || layer.changed > 0)
    {
        let [painted, erased, changed, conflicts] =
            [layer.painted, layer.erased, layer.changed, conflicts(layer)].map(|n| n.to_string());
        let over_photos = layer.over_photos.map_or_else(|| "-".to_owned(), |pixels| pixels.to_string());
        let cells =
            [layer.name.clone(), layer.state.word().to_owned(), painted, erased, over_photos, changed];
        table.row(cells.into_iter().chain([conflicts, also(layer)]));
    }
    let unchanged = file.layers.iter().filter(|layer| layer.state == LayerState::Unchanged).count();
    let rest = format!("{} unchanged\n", counted(unchanged, "layer"));
    if unchanged == file.layers.len() { rest } else { table.render() + &rest }
}

fn conflicts(layer: &LayerImportReport) -> u64 {
    layer.conflicts.iter().map(|conflict| conflict.pixels).sum()
}

fn also(layer: &LayerImportReport) -> String {
    let moved = layer.moved.map(|[x, y]| format!("moved by {x}, {y}"));
    let turned = layer.turned.map(str::to_owned);
    let resized = layer.resized.then(|| "resized".to_owned());
    let renamed = layer.renamed.then(|| "renamed".to_owned());
    [moved, turned, resized, renamed].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Returns the remarks about a file that are printed as sentences.
pub fn remarks(file: &FileReport) -> Vec<String> {
    let mut remarks = file.notes.clone();
    let over_photos: u64 = file.layers.iter().filter_map(|layer| layer.over_photos).sum();
    if over_photos > 0 {
        remarks.push(format!(
            "{} of paint lie where {} does not see the surface and other photos do, and replace what they show; with \
             --only-unseen they are left out",
            counted(over_photos as usize, "pixel"),
            file.photo
        ));
    }
    // Notes of layers that were left out are reported with the problems.
    for layer in file.layers.iter().filter(|layer| layer.state != LayerState::LeftOut) {
        remarks.extend(layer.notes.iter().map(|note| format!("{}: {note}", layer.name)));
        remarks.extend(layer.conflicts.iter().map(|conflict| {
            let face = &conflict.face;
            let pixels = conflict.pixels;
            let import = conflict.import;
            format!(
                "{}: conflict with paint of import {import} on {face}, {pixels} px; the paint of this file is shown",
                layer.name
            )
        }));
    }
    remarks
}

fn history_outcome(project: &Path, imports: &[PaintImport], fill: &FillOptions) -> Outcome {
    let mut table = Table::new(&["import", "when (UTC)", "pixels", "photos", "files", "seen"]);
    for import in imports {
        let (number, pixels) = (import.number.to_string(), import.pixels.to_string());
        let files = sources_of(project, import);
        let stays = fill.only_here.imports.contains(&import.number);
        let seen = if stays { "only in its photo" } else { "" }.to_owned();
        table.row([number, when(import.time), pixels, import.photos.join(", "), files, seen]);
    }
    let text = match imports.is_empty() {
        true => "there is no import to undo\n".to_owned(),
        false => {
            format!(
                "{}\n{} undoes the last one, --undo NUMBER another\n",
                table.render(),
                command_for_project("import --undo")
            )
        }
    };
    Outcome {
        text,
        json: json!({ "imports": imports.iter().map(|import| facts(project, import)).collect::<Vec<_>>() }),
        problems: vec![],
    }
}

fn undo_outcome(project: &Path, import: &PaintImport) -> Outcome {
    let sources = sources_of(project, import);
    let masks = if import.masks.is_empty() { String::new() } else { masks_changed() };
    let text = format!("import {} of {sources} was undone\n{masks}", import.number);
    Outcome { text, json: json!({ "undone": facts(project, import) }), problems: vec![] }
}

/// Returns the paths of an import's files relative to the current folder; they are stored relative to the
/// project.
fn files_of(project: &Path, import: &PaintImport) -> Vec<String> {
    import.files.iter().map(|file| below(project, file).display().to_string()).collect()
}

/// Returns what an import is of, in words: its files, or a stroke of the brush.
fn sources_of(project: &Path, import: &PaintImport) -> String {
    match import.brush {
        Some(brush) => format!("a brush stroke ({})", brush.word()),
        None => files_of(project, import).join(", "),
    }
}

fn facts(project: &Path, import: &PaintImport) -> serde_json::Value {
    let mut facts = json!({
        "import": import.number,
        "time": import.time,
        "files": files_of(project, import),
        "photos": import.photos,
        "pixels": import.pixels,
    });
    if let Some(brush) = import.brush {
        facts["brush"] = json!(brush);
    }
    facts
}

/// Formats seconds since 1970 as `2026-11-20 10:42` (the civil calendar after Hinnant, *chrono-compatible
/// low-level date algorithms*, 2013).
pub fn when(seconds: u64) -> String {
    let days = seconds / 86400 + 719_468;
    let era = days / 146_097;
    let day_of_era = days % 146_097;
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    let (hour, minute) = (seconds / 3600 % 24, seconds / 60 % 60);
    format!("{year}-{month:02}-{day:02} {hour:02}:{minute:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, date) in [
            (0, "1970-01-01 00:00"),
            (951_782_400, "2000-02-29 00:00"),
            (1_709_251_199, "2024-02-29 23:59"),
            (4_102_444_800, "2100-01-01 00:00"),
        ] {
            assert_eq!(when(seconds), date);
        }
    }
}
