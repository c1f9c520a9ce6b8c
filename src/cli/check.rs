//! The command `check`.

mod given;

use std::path::PathBuf;

use serde_json::json;

use self::given::Given;
use super::Outcome;
use super::args::{CheckArgs, FixArg};
use super::lock::read_with_lock_if;
use super::new::reprojection_json;
use super::table::{Table, counted};
use super::tree::note_doubts;
use super::unexplained::unexplained_text;
use crate::words::{command_for_project, error_text};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Similarity;
use quadratura_base::task::Task;
use quadratura_files::writable::check_folder;
use quadratura_gpu::{Gpu, GpuRasteriser};
use quadratura_io::project::write_project;
use quadratura_sites::check::fix::realigned;
use quadratura_sites::check::mistake::{advice_without_fix, likely_mistakes};
use quadratura_sites::check::{
    AlignmentSuggestion, AlternativeTransform, CheckOptions, CheckReport, FaceReport, Names, ObjectDistances,
    Verdict, check_site,
};
use quadratura_sites::open::{Opened, open_site};
use quadratura_trees::list::{listed_species, species_problems};

/// Number of names in a list; `--json` has more.
const LISTED: usize = 6;

/// Runs `check`: examines cameras, model and photos of a project, and reports how well they are aligned; moves the
/// model first where that is asked for.
pub fn run(args: &CheckArgs, task: &Task) -> Result<Outcome> {
    let (_lock, project) = read_with_lock_if(args.fix.is_some(), &args.project, task)?;
    let mut opened = open_site(&args.project, project, task)?;
    let rasteriser = GpuRasteriser::new(&Gpu::headless()?)?;
    let before = opened.project.world_from_model;
    let given = given::by_what_is_given(args, &opened, task)?;
    let there = match (args.fix, &given) {
        (None, _) => None,
        (Some(FixArg::To(there)), _) => Some(there),
        (Some(FixArg::Found | FixArg::Nth(1)), Some(given)) => Some(given.there),
        (Some(fix), _) => found_transform(fix, checked(&opened, None, &rasteriser, task)?.suggestion)?,
    };
    if let Some(there) = there.filter(|there| *there != before) {
        let project = realigned(&opened.project, there);
        write_project(&args.project, &project)?;
        opened = open_site(&args.project, project, task)?;
    }
    // A project on a medium that cannot be written to is checked as well.
    let pictures = args.project.join("cache/check");
    let refused = check_folder(&pictures).err();
    if let Some(error) = &refused {
        task.note(format!("no pictures with the model's edges are written: {error}"));
    }
    let pictures = refused.is_none().then_some(pictures);
    let report = checked(&opened, pictures.clone(), &rasteriser, task)?;
    let mut problems: Vec<_> = opened.problems.errors.iter().map(error_text).collect();
    problems
        .extend(report.photos.iter().filter_map(|p| Some(format!("{}: {}", p.name, p.problem.as_ref()?))));
    if report.verdict == Verdict::Misses {
        problems.push("the model is not aligned with the photos".into());
    }
    if !opened.project.trees.is_empty() {
        note_doubts(&opened.project, &opened.site, task);
        problems.extend(species_problems(&listed_species(&args.project, &opened.project.trees, task)?));
    }
    let shown = pictures.as_ref().map_or_else(String::new, |folder| {
        format!("\npictures with the model's edges: {}\n", folder.display())
    });
    let now = opened.project.world_from_model;
    let fixed = args.fix.as_ref().map_or_else(String::new, |fix| fixed_text(*fix, before, now));
    let suggestion = report.suggestion.as_ref().map(|suggestion| suggestion_text(suggestion, &now));
    let given_text = given.as_ref().map_or_else(String::new, |given| given.text(now));
    let text = format!(
        "{given_text}{fixed}{}{}{}\n{}\n{}{}{}{shown}",
        verdict_text(&report),
        reprojection_text(&opened),
        suggestion.unwrap_or_else(|| no_suggestion(&report)),
        photos(&report),
        faces(&report.faces),
        distances(&report.distances),
        unexplained_text(report.unexplained.as_ref(), pictures.is_some()),
    );
    let fixed = (now != before).then(|| json!({ "before": before.to_string(), "after": now.to_string() }));
    let reprojection = opened.reprojection.as_ref().map(reprojection_json);
    let json = json!({ "report": report, "reprojection": reprojection, "fixed": fixed, "left_out": problems,
                "by_pairs": given.as_ref().and_then(Given::pairs), "by_cameras": given.as_ref().and_then(Given::cameras) });
    Ok(Outcome { text, json, problems })
}

/// Checks an open project.
fn checked(
    opened: &Opened,
    pictures: Option<PathBuf>,
    rasteriser: &GpuRasteriser,
    task: &Task,
) -> Result<CheckReport> {
    let options = CheckOptions {
        world_from_model: opened.project.world_from_model,
        tolerance: opened.project.options.tolerance,
        pictures,
    };
    check_site(&opened.site, &opened.points, &options, rasteriser, task)
}

/// Returns the transform with a number of those that were found; `None` where none was.
///
/// # Errors
/// For a number that no transform has.
fn found_transform(fix: FixArg, found: Option<AlignmentSuggestion>) -> Result<Option<Similarity>> {
    let number = if let FixArg::Nth(number) = fix { number } else { 1 };
    let Some(found) = found else { return Ok(None) };
    let mut all = vec![found.similarity()];
    all.extend(found.alternatives.iter().map(AlternativeTransform::similarity));
    match all.get(number - 1) {
        Some(there) => Ok(Some(*there)),
        None => Err(Error::Request(format!(
            "there is no transform {number}: {} found; give a number from 1 to {}, or the transform itself",
            counted(all.len(), "transform was"),
            all.len()
        ))),
    }
}

/// Says what was done to the model's transform, and how to restore it.
fn fixed_text(fix: FixArg, before: Similarity, now: Similarity) -> String {
    if now == before {
        return match fix {
            FixArg::Found | FixArg::Nth(_) => {
                "Nothing was changed: no other transform aligns the model better.\n\n".into()
            }
            FixArg::To(_) => format!("Nothing was changed: the model's transform is {now} already.\n\n"),
        };
    }
    let restore = command_for_project(&format!("check --fix={before}"));
    let update = command_for_project("update");
    format!(
        "The model's transform in project.json is {now} now; it was {before}.\n{restore} restores it; {update} builds \
         the layers.\n\n"
    )
}

/// Returns the verdict as a sentence.
fn verdict_text(report: &CheckReport) -> String {
    let verdict = match report.verdict {
        Verdict::Fits => "The model is aligned with the photos",
        Verdict::Poor => "The model is partly aligned with the photos",
        Verdict::Misses => "The model is not aligned with the photos",
    };
    let agreement = report.agreement.map_or(String::new(), |share| {
        format!(
            ", and matches {} of the sparse-point observations within 1 % of the distance",
            percent(share)
        )
    });
    let unjudged = match report.agreement {
        Some(_) => "",
        None => {
            "There are no sparse points that photos observe, so coverage alone says so: how exactly the model fits, what it leaves out and \
             how well the cameras fit cannot be judged. Look at the pictures with its edges.\n"
        }
    };
    format!("{verdict}: it covers {} of a photo (median){agreement}.\n{unjudged}", percent(report.covered))
}

/// Says how well the cameras fit their own observations; the warning where they do not is noted when they are read.
fn reprojection_text(opened: &Opened) -> String {
    opened.reprojection.as_ref().map_or_else(String::new, |reprojection| {
        format!("The cameras show their own points with a reprojection error of {reprojection}.\n")
    })
}

fn no_suggestion(report: &CheckReport) -> String {
    match advice_without_fix(report.verdict, report.search) {
        "" => String::new(),
        text => format!("{text}\n"),
    }
}

fn suggestion_text(suggestion: &AlignmentSuggestion, now: &Similarity) -> String {
    let reach = match (suggestion.agreement, suggestion.covered) {
        (Some(share), _) => format!("matches {} of the observations", percent(share)),
        (None, Some(share)) => format!("covers {} of a photo (median)", percent(share)),
        (None, None) => "fits better".into(),
    };
    let mistakes = likely_mistakes(now, &suggestion.similarity());
    let fix = command_for_project("check --fix");
    let mut text = format!(
        "{}\nThis transform {reach}:\n  --model-transform {}\n{fix} applies it to the project, as *Fix alignment* does \
         in the window.\n",
        mistakes.join(" "),
        suggestion.transform
    );
    if !suggestion.alternatives.is_empty() {
        text.push_str("Other transforms fit nearly as well, so compare the pictures after each:\n");
        for (number, other) in (2..).zip(&suggestion.alternatives) {
            let share = percent(other.agreement.or(other.covered).unwrap_or(0.0));
            let fix = command_for_project(&format!("check --fix={number}"));
            text.push_str(&format!("  {share}: {}\n{fix} applies it.\n", other.transform));
        }
    }
    text
}

fn photos(report: &CheckReport) -> String {
    let mut table = Table::new(&["photo", "in front", "inside", "covered", "faces", ""]);
    for photo in &report.photos {
        let shares = [photo.in_front, photo.inside, photo.covered].map(percent);
        let rest = [photo.faces.to_string(), photo.problem.clone().unwrap_or_default()];
        table.row([photo.name.clone()].into_iter().chain(shares).chain(rest));
    }
    format!(
        "{}\nin front, inside: share of the model's vertices in front of the camera, and inside the picture\n\
         covered: share of the photo\n",
        table.render()
    )
}

fn faces(faces: &FaceReport) -> String {
    let mut text = format!("{}:\n", counted(faces.count, "face"));
    for (what, names) in [
        ("without area: not textured", &faces.degenerate),
        ("not planar: treated as separate triangles", &faces.not_planar),
        ("identical with an earlier face", &faces.duplicate),
        ("shown from the back at more pixels than from the front", &faces.flipped),
        ("not covered by any photo", &faces.unseen),
        ("crossed by a billboard when it turns towards the camera", &faces.turning),
    ] {
        text.push_str(&list(what, names));
    }
    let pairs = faces.crossing.iter().take(LISTED).map(|pair| pair.faces.join(" and "));
    let count = if faces.crossing_gave_up { "too many".into() } else { faces.crossing_pairs.to_string() };
    let named = named(pairs, faces.crossing_pairs);
    let sunk = match faces.sunk_pairs {
        0 => String::new(),
        pairs => format!(
            "  {pairs} pairs of which one face ends behind the other where no photo shows it (no problem: a wall that is \
             sunk into the ground)\n"
        ),
    };
    format!("{text}  {count} pairs of intersecting faces{named}\n{sunk}")
}

/// Returns the table of distances between sparse points and faces; empty where there are no points.
fn distances(distances: &[ObjectDistances]) -> String {
    if distances.is_empty() {
        return String::new();
    }
    let mut table = Table::new(&["object", "points", "median", "95 %", "largest"]);
    for of in distances.iter().take(LISTED) {
        let lengths = [of.median, of.most, of.largest].map(|length| format!("{length:.3}"));
        table.row([of.object.clone(), of.points.to_string()].into_iter().chain(lengths));
    }
    let others = match distances.len().saturating_sub(LISTED) {
        0 => String::new(),
        count => format!("; {} with smaller distances", counted(count, "other object")),
    };
    format!(
        "\nlargest distances between sparse points and faces\n{}\nin world units; 95 %: the distance that 95 % of the \
         points do not exceed{others}\n",
        table.render()
    )
}

fn list(what: &str, names: &Names) -> String {
    let listed = names.names.iter().take(LISTED).cloned();
    format!("  {} {what}{}\n", names.count, named(listed, names.count))
}

/// Returns `: a, b, ...`, or nothing where there are no names.
fn named(listed: impl Iterator<Item = String>, count: usize) -> String {
    let listed: Vec<_> = listed.collect();
    let more = if count > listed.len() { ", ..." } else { "" };
    if listed.is_empty() { String::new() } else { format!(": {}{more}", listed.join(", ")) }
}

fn percent(share: f64) -> String {
    format!("{:.0} %", share * 100.0)
}
