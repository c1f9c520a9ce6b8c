//! The command `stroke`: applies a stroke of the brush.

use serde_json::json;

use super::Outcome;
use super::args::StrokeArgs;
use super::fill::note_stale_fillings;
use super::import::{elsewhere_in_words, seen_from};
use super::lock::read_with_lock_if;
use super::table::{Table, counted};
use super::words::command_for_project;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_editing::stroke::{StrokeOptions, StrokeReport, apply};
use quadratura_io::stroke_file::read_stroke;
use quadratura_sites::open::open_site;
use quadratura_views::colour::usual_exposure;
use quadratura_views::render::Appearance;

/// Runs `stroke`.
pub fn run(args: &StrokeArgs, task: &Task) -> Result<Outcome> {
    let stroke = read_stroke(&args.file)?;
    let (_lock, project) = read_with_lock_if(!args.dry_run, &args.project, task)?;
    let fill = project.fill.clone();
    let opened = open_site(&args.project, project, task)?;
    note_stale_fillings(&args.project, &opened.project, &opened.site, task)?;
    let look = Appearance {
        exposure: usual_exposure(&opened.project, &opened.site),
        flat: args.flat,
        ..Appearance::default()
    };
    let (dry_run, only_here) = (args.dry_run, args.only_here);
    let options = StrokeOptions { dry_run, only_here, ..StrokeOptions::default() };
    let report = apply(&args.project, &opened.project, &opened.site, &stroke, &look, options, task)?;
    let number = report.number.filter(|_| !args.dry_run);
    Ok(outcome(args, &report, &seen_from(&args.project, &fill, report.only_here, number)))
}

fn outcome(args: &StrokeArgs, report: &StrokeReport, seen: &str) -> Outcome {
    let mut table = Table::new(&["photo", "layer", "changed"]);
    for layer in &report.layers {
        table.row([layer.photo.clone(), layer.layer.clone(), layer.changed.to_string()]);
    }
    let mut text = if report.layers.is_empty() { String::new() } else { table.render() };
    report.elsewhere.iter().for_each(|paint| text.push_str(&format!("{}\n", elsewhere_in_words(paint))));
    if report.uncovered > 0 {
        let pixels = counted(report.uncovered as usize, "pixel");
        text.push_str(&format!(
            "no photo covers the surface at {pixels} of the view, which cannot be painted\n"
        ));
    }
    if report.without_source > 0 {
        let pixels = counted(report.without_source as usize, "pixel");
        text.push_str(&format!(
            "the view shows nothing at the source of {pixels}, which were left as they are\n"
        ));
    }
    let changed = counted(report.changed as usize, "pixel");
    text.push_str(&match (report.number, args.dry_run) {
        (None, _) => "nothing changed\n".to_owned(),
        (Some(number), false) => {
            let undo = command_for_project("import --undo");
            format!("import {number}: {changed} changed; {undo} undoes it\n{seen}\n")
        }
        (Some(_), true) => format!("{changed} would change; nothing was written\n"),
    });
    let json = json!({
        "import": report.number.filter(|_| !args.dry_run),
        "dry_run": args.dry_run,
        "changed": report.changed,
        "layers": report.layers,
        "uncovered": report.uncovered,
        "without_source": report.without_source,
        "elsewhere": report.elsewhere,
        "seen": seen,
    });
    Outcome { text, json, problems: Vec::new() }
}
