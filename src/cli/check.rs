//! `quadratura check`.

use serde_json::json;

use super::Outcome;
use super::args::CheckArgs;
use super::table::{Table, counted};
use crate::error::Result;
use crate::gpu::{Gpu, GpuRasteriser};
use crate::recipe::check::mistake::without_mend;
use crate::recipe::check::{CheckOptions, CheckReport, FaceReport, Names, Suggestion, Verdict, check_site};
use crate::recipe::open::open;
use crate::task::Task;

/// So many names of a list are shown; `--json` has more.
const SHOWN: usize = 6;

pub fn run(args: &CheckArgs, task: &Task) -> Result<Outcome> {
    let opened = open(&args.project, task)?;
    let pictures = args.project.join("cache/check");
    let options = CheckOptions {
        world_from_model: opened.project.world_from_model,
        tolerance: opened.project.options.tolerance,
        pictures: Some(pictures.clone()),
    };
    let rasteriser = GpuRasteriser::new(&Gpu::headless()?)?;
    let report = check_site(&opened.site, &opened.points, &options, &rasteriser, task)?;
    let mut problems: Vec<_> = opened.problems.iter().map(ToString::to_string).collect();
    problems
        .extend(report.photos.iter().filter_map(|p| Some(format!("{}: {}", p.name, p.problem.as_ref()?))));
    if report.verdict == Verdict::Misses {
        problems.push("the model does not stand where the photos are".into());
    }
    let text = format!(
        "{}{}\n{}\n{}\npictures with the model's edges: {}\n",
        judgement(&report),
        report.suggestion.as_ref().map_or_else(|| unmended(report.verdict), suggested),
        photos(&report),
        faces(&report.faces),
        pictures.display(),
    );
    let json = json!({ "report": report, "left_out": problems });
    Ok(Outcome { text, json, problems })
}

fn judgement(report: &CheckReport) -> String {
    let verdict = match report.verdict {
        Verdict::Fits => "The model fits the photos",
        Verdict::Poor => "The model fits the photos in part",
        Verdict::Misses => "The model does not stand where the photos are",
    };
    let agreement = report.agreement.map_or(String::new(), |share| {
        format!(", and meets {} of the sparse points' sightings within 1 % of the distance", percent(share))
    });
    format!("{verdict}: it covers {} of a photo{agreement}.\n", percent(report.covered))
}

fn unmended(verdict: Verdict) -> String {
    match without_mend(verdict) {
        "" => String::new(),
        text => format!("{text}\n"),
    }
}

fn suggested(suggestion: &Suggestion) -> String {
    let reach = match (suggestion.agreement, suggestion.covered) {
        (Some(share), _) => format!("meets {} of the sightings", percent(share)),
        (None, Some(share)) => format!("covers {} of a photo", percent(share)),
        (None, None) => "does better".into(),
    };
    let mut text = format!(
        "This transform {reach}; make the project anew with it:\n  --model-transform {}\n",
        suggestion.transform
    );
    if !suggestion.alternatives.is_empty() {
        let others = suggestion.alternatives.join("  ");
        text.push_str(&format!("Nearly as well, so look at the pictures: {others}\n"));
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
        "{}\nin front, inside: share of the model's vertices; covered: share of the photo\n",
        table.render()
    )
}

fn faces(faces: &FaceReport) -> String {
    let mut text = format!("{}:\n", counted(faces.count, "face"));
    for (what, names) in [
        ("without area, so without texture", &faces.degenerate),
        ("not planar, treated by their triangles", &faces.not_planar),
        ("the same as an earlier one", &faces.duplicate),
        ("seen from behind by most photos that see them", &faces.flipped),
        ("seen by no photo", &faces.unseen),
    ] {
        text.push_str(&list(what, names));
    }
    let pairs = faces.crossing.iter().take(SHOWN).map(|pair| pair.faces.join(" and "));
    let count = if faces.crossing_gave_up { "too many".into() } else { faces.crossing_pairs.to_string() };
    let named = named(pairs, faces.crossing_pairs);
    format!("{text}  {count} pairs that run through each other{named}\n")
}

fn list(what: &str, names: &Names) -> String {
    let shown = names.names.iter().take(SHOWN).cloned();
    format!("  {} {what}{}\n", names.count, named(shown, names.count))
}

/// `: a, b, ...`, or nothing where there is nothing.
fn named(shown: impl Iterator<Item = String>, count: usize) -> String {
    let shown: Vec<_> = shown.collect();
    let more = if count > shown.len() { ", ..." } else { "" };
    if shown.is_empty() { String::new() } else { format!(": {}{more}", shown.join(", ")) }
}

fn percent(share: f64) -> String {
    format!("{:.0} %", share * 100.0)
}
