//! The command `info`.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use super::Outcome;
use super::args::InfoArgs;
use super::colour;
use super::fill_table::FillTable;
use super::layer_table::LayerTable;
use super::masked::MaskReport;
use super::painted::PaintReport;
use super::photo_state_table::PhotoStateTable;
use super::propagation_table::PropagatedTable;
use super::stacks::StackTable;
use super::table::{Table, counted};
use super::unknown_mattes::UnknownMattes;
use super::untextured::UntexturedReport;
use super::words::{command_for_project, error_text, worded};
use quadratura_base::error::Result;
use quadratura_base::scene::impostor::NoImpostor;
use quadratura_base::scene::{FaceIndex, ObjectId, Photo, Site};
use quadratura_base::task::Task;
use quadratura_document::{Project, Stack};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_sites::impostors::RefusedImpostors;
use quadratura_sites::objects::listed_object;
use quadratura_sites::open::{Opened, OpeningProblems, open};
use quadratura_stacks::decide::{stale as stale_decisions, state_of_face};
use quadratura_stacks::fill::seen::{SeenReport, exceptions_in_words, propagation_in_words};
use quadratura_stacks::fill::{FillInputs, FillState};
use quadratura_stacks::survey::{StackState, Survey, face_named};
use quadratura_stacks::untextured::{FaceInStack, face_in_stack};
use quadratura_views::colour::{ColourReport, known_report};

/// The state of photos whose file or mask cannot be used.
const LEFT_OUT: &str = "left out";

/// Runs `info`: reports on one face, on the faces of an object, or on the photos of a project.
pub fn run(args: &InfoArgs, task: &Task) -> Result<Outcome> {
    let opened = open(&args.project, task)?;
    let store = StackStore::new(&args.project);
    let survey = Survey::new(&opened.project, &opened.site, &store);
    let photos = opened.photos_named(&args.photos.names)?;
    let mut problems = args.photos.problems_of(&opened.problems, task);
    let (text, mut json) = match &args.face {
        Some(name) => match opened.site.model.object_like(name) {
            Some(object) => about_object(object, &opened, &survey, &photos, task)?,
            None => about_face(name, &opened.project, &opened.site, &survey, &photos, task)?,
        },
        None => about_photos(args, &opened, &store, &survey, &photos, &mut problems, task)?,
    };
    json["problems"] = json!(problems);
    Ok(Outcome { text, json, problems })
}

fn about_photos(
    args: &InfoArgs,
    opened: &Opened,
    store: &StackStore,
    survey: &Survey<'_>,
    photos: &[&Photo],
    problems: &mut Vec<String>,
    task: &Task,
) -> Result<(String, Value)> {
    let mut overview = PhotoStateTable::default();
    let mut table = StackTable::default();
    let in_detail = !args.photos.names.is_empty();
    let mut untextured = UntexturedReport::new(in_detail);
    let mut filling = FillTable::default();
    let mut layers = LayerTable::default();
    let mut mattes = UnknownMattes::default();
    let fill_inputs = fill_inputs_now(&args.project, &opened.project, &opened.site, store)?;
    let mut propagated = PropagatedTable::default();
    for (photo, done) in photos.iter().zip(0..) {
        task.step("read stacks", done, photos.len() as u64)?;
        let state = survey.state(photo)?;
        let damage = store.damage(&photo.name);
        let (name, word) = match damage {
            Some(_) => ("broken", "broken"),
            None => (state.word(), worded_state(&state)),
        };
        table.add_worded(&photo.name, name, word, state.stack());
        let of_filling = state.stack().map(|stack| FillState::new(stack, &fill_inputs).word());
        overview.add(&photo.name, word, state.stack(), of_filling);
        if let Some(stack) = state.stack() {
            untextured.add(stack, &opened.project.decisions.of(&photo.name));
            stack.unsatisfied.iter().for_each(|unsatisfied| task.with_subject(&photo.name).note(unsatisfied));
            layers.add(stack);
            mattes.add(stack, &args.project, fill_inputs.book());
            filling.add(stack, of_filling.unwrap_or_default());
            propagated.add(&photo.name, stack.fill.as_ref().map_or(&[], |fill| &fill.propagated));
        }
        if let StackState::Broken(error) = &state {
            problems.push(format!("{}: {}", photo.name, error_text(error)));
        } else if let Some(damage) = &damage {
            problems.push(format!("{}: {}", photo.name, error_text(damage)));
        }
    }
    if args.photos.names.is_empty() {
        opened.problems.left_out.iter().for_each(|(photo, _)| {
            overview.add(photo, LEFT_OUT, None, None);
            table.add(photo, LEFT_OUT, None);
        });
    }
    let model = &opened.site.model;
    let missing = stale_decisions(&opened.project.decisions, &opened.site);
    missing.iter().for_each(|note| task.note(note.clone()));
    let missing: Vec<String> = missing.iter().map(worded).collect();
    let mut text = format!(
        "{}, {} in {}\n\n{}\n{}{}\n",
        photos_counted(&opened.site, &opened.problems),
        counted(model.faces.len(), "face"),
        counted(model.objects.len(), "object"),
        overview.text(),
        layers.text(in_detail, &opened.project.options),
        propagated.text("paint of other photos, projected to what a photo shows"),
    );
    text.push_str(&untextured.text());
    let stale = stale(&opened.site, store)?;
    if !stale.is_empty() {
        text.push_str(&format!("\nstacks of photos that are not in the project: {}\n", stale.join(", ")));
    }
    let refused = opened.refused_impostors();
    text.push_str(&cannot_turn(&refused));
    text.push_str(&mattes.text());
    let masked = MaskReport::new(&opened.project, &opened.site)?;
    text.push_str(&masked.text());
    let painted = PaintReport::new(&opened.site, store)?;
    text.push_str(&painted.text());
    let seen = seen_report(&args.project, &opened.project, &opened.site)?;
    if painted.is_there() || !seen.options.is_default() {
        text.push_str(&format!("{}\n", propagation_in_words(&opened.project.fill)));
        exceptions_in_words(&opened.project.fill)
            .iter()
            .for_each(|line| text.push_str(&format!("  {line}\n")));
    }
    seen.gone.iter().for_each(|line| task.note(line));
    let exposure = known_report(&args.project, &opened.project, &opened.site);
    text.push_str(&exposure_text(exposure.as_ref()));
    text.push_str(&match in_detail {
        true => format!("\nthe filling:\n{}\nthe sort:\n{}", filling.text(), table.text()),
        false => format!(
            "\n{} shows the small layers, all untextured faces, and figures of the sort and the filling\n",
            command_for_project("info --photo NAME")
        ),
    });
    problems.extend(painted.problems());
    let json = json!({
        "faces": model.faces.len(),
        "objects": model.objects.len(),
        "photos": table.into_json(),
        "layers": layers.into_json(),
        "filling": filling.into_json(),
        "mattes": mattes.into_json(),
        "cannot_turn": refused.iter().map(|(name, why)| (name, why.to_string())).collect::<BTreeMap<_, _>>(),
        "propagated": propagated.into_json(),
        "untextured": untextured.to_json(),
        "masks": masked.to_json(),
        "objects_off": opened.project.objects_off,
        "paint": painted.to_json(),
        "paint_seen": seen,
        "exposure": exposure.map(|report| json!({
            "rule": report.rule,
            "rule_set": report.rule_set,
            "rules": report.rules,
            "light": report.light,
            "light_set": report.light_set,
            "light_support": report.light_support,
            "leans": report.leans,
            "leaning_lead": report.leaning_lead,
            "surfaces": report.surfaces,
            "surfaces_lead": report.surfaces_lead,
        })),
        "stacks_without_photo": stale,
        "decisions": opened.project.decisions,
        "decisions_about_what_is_gone": missing,
    });
    Ok((text, json))
}

/// Returns the number of photos in words, with those that cannot be used.
fn photos_counted(site: &Site, problems: &OpeningProblems) -> String {
    let count = counted(site.photos.len(), "photo");
    match problems.left_out.len() {
        0 => count,
        left_out => format!("{count} (and {left_out} left out)"),
    }
}

/// Says which objects cannot turn towards cameras although their names or decisions say so.
fn cannot_turn(refused: &RefusedImpostors) -> String {
    let line = |(name, why): (&String, &NoImpostor)| format!("{name} cannot turn towards cameras: {why}\n");
    let lines: String = refused.iter().map(line).collect();
    if lines.is_empty() { lines } else { format!("\n{lines}") }
}

/// Returns the present inputs of fillings. A stack that cannot be read is left out here and reported
/// elsewhere.
fn fill_inputs_now(folder: &Path, project: &Project, site: &Site, store: &StackStore) -> Result<FillInputs> {
    let stamp =
        |photo: &Photo| store.current(&photo.name).ok().flatten().map(|stack| stack.inputs().to_owned());
    let stamps: Vec<Option<String>> = site.photos.iter().map(stamp).collect();
    FillInputs::of_stamps(folder, project, site, &stamps, &project.fill)
}

/// Reports where paint is seen.
fn seen_report(folder: &Path, project: &Project, site: &Site) -> Result<SeenReport> {
    Ok(SeenReport::new(&project.fill, site, &PaintStore::new(folder).read()?))
}

/// Returns the photos of stacks that are no longer in the project.
fn stale(site: &Site, store: &StackStore) -> Result<Vec<String>> {
    let belongs = |name: &String| site.photos.iter().any(|photo| photo.name == *name);
    Ok(store.photos()?.into_iter().filter(|name| !belongs(name)).collect())
}

/// Returns the word for a state in tables, as the window has it.
fn worded_state(state: &StackState) -> &'static str {
    match state {
        StackState::Current(_) => "built",
        other => other.word(),
    }
}

/// Lists the faces of an object, each with the photos that texture it, and with the reasons why others do not.
fn about_object(
    object: ObjectId,
    opened: &Opened,
    survey: &Survey<'_>,
    photos: &[&Photo],
    task: &Task,
) -> Result<(String, Value)> {
    let model = &opened.site.model;
    let object = model.object(object);
    let mut stacks = Vec::with_capacity(photos.len());
    for (photo, done) in photos.iter().zip(0..) {
        task.step("read stacks", done, photos.len() as u64)?;
        stacks.push((*photo, survey.state(photo)?));
    }
    let mut table = Table::new(&["face", "textured by", "not textured"]);
    let mut rows = Vec::new();
    for &id in &object.faces {
        let (face, in_stacks) = (model.face(id), model.index_in_stacks(id));
        let (mut textured, mut reasons) = (Vec::new(), BTreeMap::<&str, usize>::new());
        for (photo, state) in &stacks {
            let decided = state_of_face(&opened.project.decisions.of(&photo.name), &object.name, face.index);
            let found = state.stack().map(|stack| face_in_stack(stack, &object.name, in_stacks));
            let why = match (decided, found) {
                (Some("excluded"), _) => "excluded",
                (_, Some(FaceInStack::Textured { .. })) => {
                    textured.push(photo.name.as_str());
                    continue;
                }
                (_, Some(FaceInStack::Untextured(untextured))) => untextured.reason.word(),
                (_, Some(FaceInStack::Unknown)) => "not in the stack",
                (_, None) => "not built",
            };
            *reasons.entry(why).or_default() += 1;
        }
        let reasons_text: Vec<String> =
            reasons.iter().map(|(why, count)| format!("{why} in {count}")).collect();
        let name = format!("{}[{}]", object.name, face.index);
        let by = if textured.is_empty() { "no photo".to_owned() } else { textured.join(", ") };
        table.row([name.clone(), by, reasons_text.join(", ")]);
        rows.push(json!({ "face": name, "textured": textured, "untextured": reasons }));
    }
    let hint = command_for_project(&format!("info --face '{}[0]'", object.name));
    let whole = opened.whole.object_named(&object.name).map_or(object, |id| opened.whole.object(id));
    let listed = listed_object(whole, &opened.project, &opened.refused_impostors());
    let nature = match listed.nature() {
        nature if nature.is_empty() => nature,
        nature => format!("{}: {nature}\n\n", object.name),
    };
    let text = format!("{nature}{}\n{hint} says more about one face, photo by photo\n", table.render());
    let mut json = json!({ "object": object.name, "faces": rows, "turns": listed.turns });
    if let Some(reason) = listed.cannot_turn {
        json["cannot_turn"] = json!(reason);
    }
    Ok((text, json))
}

fn about_face(
    name: &str,
    project: &Project,
    site: &Site,
    survey: &Survey<'_>,
    photos: &[&Photo],
    task: &Task,
) -> Result<(String, Value)> {
    let model = &site.model;
    let id = face_named(model, name)?;
    let face = model.face(id);
    let object = &model.object(face.object).name;
    let mut table = Table::new(&["photo", "state", name]);
    let mut rows = Vec::new();
    for (photo, done) in photos.iter().zip(0..) {
        task.step("read stacks", done, photos.len() as u64)?;
        let state = survey.state(photo)?;
        let what = state.stack().map(|stack| describe_face(stack, object, model.index_in_stacks(id)));
        let (mut text, mut row) = what.unwrap_or_default();
        if let Some(decided) = state_of_face(&project.decisions.of(&photo.name), object, face.index) {
            text = if text.is_empty() { decided.into() } else { format!("{decided}; {text}") };
            row["decided"] = json!(decided);
        }
        table.row([photo.name.clone(), worded_state(&state).to_owned(), text]);
        row["photo"] = json!(photo.name);
        row["state"] = json!(state.word());
        rows.push(row);
    }
    Ok((table.render(), json!({ "face": model.face_name(id), "photos": rows })))
}

/// Says how pictures are exposed, and what that was decided by.
fn exposure_text(report: Option<&ColourReport>) -> String {
    match report {
        Some(report) => format!("\n{}{}", colour::groups(report), colour::rule(report)),
        None => format!(
            "\nthe exposure of pictures is decided when the photos are compared; {} does it now\n",
            command_for_project("colour")
        ),
    }
}

/// Describes a face in a photo's stack, as text and as JSON.
fn describe_face(stack: &Stack, object: &str, index: FaceIndex) -> (String, Value) {
    match face_in_stack(stack, object, index) {
        FaceInStack::Textured { image_layers, back } => {
            let layers: Vec<_> = image_layers.iter().map(|layer| stack.layer(*layer)).collect();
            let names: Vec<_> = layers.iter().map(|layer| format!("{} [{}]", layer.name, layer.id)).collect();
            let side = if back { ", back side" } else { "" };
            let files: Vec<_> = layers.iter().map(|layer| &layer.file).collect();
            let behind: Vec<_> =
                stack.tolerated.iter().filter(|t| t.object == object && t.face == index).collect();
            let mut text = format!("in {}{side}", names.join(", "));
            if !behind.is_empty() {
                let px: u64 = behind.iter().map(|overlap| overlap.px).sum();
                text.push_str(&format!("; not at {px} pixels, where it is behind its own object"));
            }
            let mut json = json!({ "textured": true, "back": back, "files": files });
            if !behind.is_empty() {
                json["behind_its_own_object"] = json!(behind);
            }
            (text, json)
        }
        FaceInStack::Untextured(untextured) => {
            let text = untextured.in_words();
            (text, json!({ "textured": false, "untextured": untextured }))
        }
        FaceInStack::Unknown => ("not in this stack, which was built from another model".into(), json!({})),
    }
}
