//! The command `colour`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde_json::json;

use super::Outcome;
use super::args::{ColourArgs, GroupArg, Switch};
use super::lock::read_with_lock_if;
use super::table::{Table, counted};
use crate::words::{command_for_project, error_text};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::colour::REST;
use quadratura_document::{ColourDecisions, Project};
use quadratura_io::project::write_project;
use quadratura_projection::exposure::{ExposureRule, GroupSupport};
use quadratura_sites::open::{Opened, OpeningProblems, open_site};
use quadratura_views::colour::{
    ColourEdit, ColourReport, PhotoColour, colour_report, edited, estimate, keeping_found, known_report,
    lead_in_words, report_from_estimate,
};
use quadratura_views::written_exposure::{CameraReport, WrittenExposure};

/// Runs `colour`: changes exposures as the arguments ask, and reports the exposures of all photos.
pub fn run(args: &ColourArgs, task: &Task) -> Result<Outcome> {
    args.refuse_contradictions()?;
    let edits = edits(args);
    let (_lock, project) = read_with_lock_if(!edits.is_empty(), &args.project, task)?;
    let mut opened = open_site(&args.project, project, task)?;
    args.refuse_photos_in_two_groups(&opened)?;
    let edits = keeping_groups(&args.project, &opened.project, &opened.site, edits, task)?;
    let colour = edited(&opened.project.colour, &edits, &opened.site)?;
    let before = known_report(&args.project, &opened.project, &opened.site);
    if colour != opened.project.colour {
        opened.project.colour = colour;
        write_project(&args.project, &opened.project)?;
        note_both(&opened.project.colour, task);
    }
    let report = colour_report(&args.project, &opened.project, &opened.site, task)?;
    let is_asked = |edit: &ColourEdit| matches!(edit, ColourEdit::Rule(_) | ColourEdit::Reset);
    if let Some(switched) = before.and_then(|before| switched(&before, &report))
        && !edits.iter().any(is_asked)
    {
        task.note(switched);
    }
    Ok(outcome(&opened.problems, &report))
}

/// Says that another change has changed the rule by which pictures are exposed, and how to keep the former one; `None`
/// where it has not, or the user has set the rule.
fn switched(before: &ColourReport, now: &ColourReport) -> Option<String> {
    let is_chosen = |report: &ColourReport| report.even && !report.rule_set;
    let (old, new) = (before.rule, now.rule);
    (is_chosen(before) && is_chosen(now) && old != new).then(|| {
        let keep = command_for_project(&format!("colour --exposure {}", old.name()));
        format!(
            "with these settings, pictures have {} instead of {}, because that predicts left-out photos better now; {keep} \
             keeps the former rule",
            rule_words(new),
            rule_words(old)
        )
    })
}

/// Keeps found groups of light where photos are taken out of theirs: otherwise nothing would be left of the groups.
fn keeping_groups(
    folder: &Path,
    project: &Project,
    site: &Site,
    mut edits: Vec<ColourEdit>,
    task: &Task,
) -> Result<Vec<ColourEdit>> {
    let takes_out = |edit: &ColourEdit| matches!(edit, ColourEdit::Group(name, _) if name == REST);
    let Some(first) = edits.iter().position(takes_out) else { return Ok(edits) };
    let before = edited(&project.colour, &edits[..first], site)?;
    if before.groups.is_none() {
        let report = report_from_estimate(&estimate(folder, site, &before, task)?, &before, site);
        edits.splice(first..first, keeping_found(&report));
    }
    Ok(edits)
}

impl ColourArgs {
    /// Checks that no value of `--group` takes back another one.
    ///
    /// # Errors
    /// Returns [`Error::Request`] with the values that contradict each other.
    fn refuse_contradictions(&self) -> Result<()> {
        let is_whole = |group: &GroupArg| matches!(group, GroupArg::Auto | GroupArg::Off);
        let has = |wanted: GroupArg| self.group.contains(&wanted);
        let first_named = self.group.iter().position(|group| !is_whole(group));
        let undone = first_named.and_then(|at| self.group[at..].iter().find(|group| is_whole(group)));
        let refused = match (has(GroupArg::Auto) && has(GroupArg::Off), undone) {
            (true, _) => "auto and off cannot be given together".to_owned(),
            (false, Some(undone)) => {
                let word = if *undone == GroupArg::Auto { "auto" } else { "off" };
                format!("{word} after a named group would take that group back")
            }
            (false, None) => return Ok(()),
        };
        Err(Error::Request(format!(
            "--group: {refused}; expected auto or off once at most, before groups such as evening=0004,0007: leave one out"
        )))
    }

    /// Checks that no photo is put into two groups.
    ///
    /// # Errors
    /// Returns [`Error::Request`] with the photos; the errors of names that the site does not have come with the edits.
    fn refuse_photos_in_two_groups(&self, opened: &Opened) -> Result<()> {
        let mut groups = BTreeMap::<&str, BTreeSet<&str>>::new();
        for group in &self.group {
            let GroupArg::Named(name, photos) = group else { continue };
            for photo in opened.photos_named(photos).into_iter().flatten() {
                groups.entry(&photo.name).or_default().insert(name);
            }
        }
        let twice = groups.iter().filter(|(_, names)| names.len() > 1);
        let refused = twice.map(|(photo, names)| {
            let names = names.iter().copied().collect::<Vec<_>>().join(" and ");
            Error::Request(format!(
                "--group: {photo} cannot be in {names}; expected each photo in one group: leave it out of the others"
            ))
        });
        Error::of_all(refused.collect()).map_or(Ok(()), Err)
    }
}

/// Notes photos that are both fixed and left out, and what that means.
fn note_both(colour: &ColourDecisions, task: &Task) {
    for photo in colour.left_out.iter().filter(|photo| colour.fixed.contains_key(*photo)) {
        task.with_subject(photo).note(
            "this photo is both fixed and left out: its gain is the given one, and the others' gains are estimated \
             without it; --free removes both settings",
        );
    }
}

/// Returns the edits that were requested: removals first, then settings.
fn edits(args: &ColourArgs) -> Vec<ColourEdit> {
    let mut edits: Vec<ColourEdit> = args.reset.then_some(ColourEdit::Reset).into_iter().collect();
    edits.extend(args.free.iter().cloned().map(ColourEdit::Free));
    edits.extend(args.leave_out.iter().cloned().map(ColourEdit::LeaveOut));
    edits.extend(args.fix.iter().cloned().map(|(photo, stops)| ColourEdit::Fix(photo, stops)));
    let reference = args.reference.as_ref();
    edits.extend(reference.map(|name| ColourEdit::Reference((name != "none").then(|| name.clone()))));
    edits.extend(args.group.iter().cloned().map(|group| match group {
        GroupArg::Auto => ColourEdit::FindGroups,
        GroupArg::Off => ColourEdit::OneGroup,
        GroupArg::Named(name, photos) => ColourEdit::Group(name, photos),
    }));
    edits.extend(args.exposure.map(|exposure| ColourEdit::Rule(exposure.rule())));
    edits.extend(args.off.then_some(ColourEdit::Even(false)));
    edits.extend(args.vignetting.map(|vignetting| ColourEdit::Vignetting(vignetting.removed())));
    edits.extend(args.offset.map(|switch| ColourEdit::Offset(switch == Switch::On)));
    edits.extend(args.on.then_some(ColourEdit::Even(true)));
    edits
}

fn outcome(problems: &OpeningProblems, report: &ColourReport) -> Outcome {
    let problems: Vec<String> = problems.errors.iter().map(error_text).collect();
    let (cameras, rule) = (cameras(report), rule(report));
    let text = format!("{}\n{}{cameras}{}\n{rule}", photos(report), legend(report), groups(report));
    let mut json = json!(report);
    json["problems"] = json!(problems);
    Outcome { text, json, problems }
}

fn photos(report: &ColourReport) -> String {
    let headings = ["photo", "R", "G", "B", "points", "residual", "gain", ""];
    let of_optics: &[&str] = if report.optics { &["corner", "offset"] } else { &[] };
    let of_groups: &[&str] = if report.light.len() > 1 { &["group"] } else { &[] };
    let is_written = report.photos.iter().any(|photo| photo.camera.is_some());
    let of_cameras: &[&str] = if is_written { &["camera"] } else { &[] };
    let mut table = Table::new(&[&headings[..4], of_optics, of_groups, of_cameras, &headings[4..]].concat());
    for photo in &report.photos {
        let residual = if photo.points > 0 { format!("{:.3}", photo.residual) } else { "-".into() };
        let reference = if photo.reference { "reference" } else { "" };
        let rest = [photo.points.to_string(), residual, origin(photo, report.even), reference.into()];
        let mut row = vec![photo.photo.clone()];
        row.extend(photo.stops.map(signed));
        if report.optics {
            row.extend([signed(-photo.corner), format!("{:+.4}", photo.offset)]);
        }
        if report.light.len() > 1 {
            row.push(report.light[photo.group].name.clone());
        }
        if is_written {
            row.push(photo.camera.as_ref().map_or_else(|| "-".into(), written));
        }
        table.row(row.into_iter().chain(rest));
    }
    table.render()
}

/// Describes an exposure that a camera wrote down, with what it makes of the gain.
fn written(camera: &WrittenExposure) -> String {
    let WrittenExposure { seconds, f_number, iso, flash, stops } = *camera;
    let time = if seconds < 0.3 { format!("1/{:.0}", seconds.recip()) } else { format!("{seconds:.1}") };
    let use_of_it = match (flash, stops) {
        (true, _) => "flash".into(),
        (false, Some(stops)) => signed(stops),
        (false, None) => "not used".into(),
    };
    format!("{time} s f/{f_number:.1} ISO {iso:.0}: {use_of_it}")
}

/// Says what became of the exposures that cameras wrote down; nothing where none did.
fn cameras(report: &ColourReport) -> String {
    let CameraReport { written, used, off, lead, suits_views } = report.camera;
    if written == 0 {
        return String::new();
    }
    let stops = off.map_or("nothing can be compared with them".into(), |off| {
        format!("the median difference from what common points say is {off:.2} stops")
    });
    let of =
        format!("Cameras wrote down the exposures of {written} of {} photos; {stops}", report.photos.len());
    if used == 0 {
        return format!(
            "{of}: they are not used. Filters, a sensitivity set by hand and developed raw files are not written down.\n"
        );
    }
    let unused = if used < written {
        format!(" {} do not agree and are not used.", written - used)
    } else {
        String::new()
    };
    let views = match (suits_views, lead) {
        (true, Some(lead)) => format!(
            " Pictures that have the name of another photo get the exposure that its camera wrote down: {lead:+.2} dB at \
             left-out photos."
        ),
        (false, Some(lead)) => format!(" Pictures do not get them: {lead:+.2} dB at left-out photos."),
        (_, None) => String::new(),
    };
    format!("{of}.{unused}{views}\n")
}

/// Returns the source of a photo's gain.
fn origin(photo: &PhotoColour, even: bool) -> String {
    let estimated = photo.estimated.map(|stops| stops.map(signed).join(" "));
    match (even, photo.fixed, photo.left_out, estimated) {
        (false, ..) => "off".into(),
        (_, true, true, _) => "fixed, left out of the estimate".into(),
        (_, true, false, Some(estimated)) => format!("fixed; estimate {estimated}"),
        (_, true, false, None) => "fixed; shares no points".into(),
        (_, false, true, _) => "left out".into(),
        (_, false, false, Some(_)) => "estimated".into(),
        (_, false, false, None) => "shares no points".into(),
    }
}

/// Says which groups of light there are, and why; nothing where there is one, as usual.
pub(super) fn groups(report: &ColourReport) -> String {
    let GroupSupport { within, between, lead } = report.light_support;
    if report.light.len() < 2 {
        return if report.light_set {
            "All photos are one group of light, as set with --group.\n".into()
        } else {
            String::new()
        };
    }
    let mut text = format!("{} groups of light:\n", report.light.len());
    for group in &report.light {
        text.push_str(&format!("  {}: {}\n", group.name, group.photos.join(", ")));
    }
    let reason = match (report.light_set, lead) {
        (true, _) => "They are set with --group.".into(),
        (false, lead) => format!(
            "What no gain explains differs by {between:.2} stops between groups and by {within:.2} within; left-out photos are \
             predicted with errors at least {:.0} % smaller. --group changes groups, --group off makes them one.",
            100.0 * lead.unwrap_or(0.0)
        ),
    };
    let surfaces = match (report.surfaces, report.surfaces_lead) {
        (true, Some(lead)) => {
            format!(
                "In the light of one group, the others are matched surface by surface: {}.\n",
                lead_in_words(lead)
            )
        }
        (false, Some(lead)) => {
            format!(
                "Other groups are not matched surface by surface: that is not clearly better ({}).\n",
                lead_in_words(lead)
            )
        }
        (_, None) => String::new(),
    };
    let leaning = report.leaning_in_words("--like PHOTO shows the light of one group.");
    format!("{text}{reason}\n{leaning}\n{surfaces}")
}

/// Says by which rule pictures are exposed, and why.
pub(super) fn rule(report: &ColourReport) -> String {
    if !report.even {
        return String::new();
    }
    let words = rule_words(report.rule);
    let reason = match (report.rule_set, report.rules.is_empty()) {
        (true, _) => ", as set with --exposure",
        (false, true) => "; nothing can be compared",
        (false, false) => ", which predicts them well enough or best",
    };
    let reference = match report.photos.iter().find(|photo| photo.reference) {
        Some(photo) => format!("The reference {} takes precedence.\n", photo.photo),
        None => String::new(),
    };
    let scores = report.rules.iter().map(|score| format!("{} {:.2} dB", score.rule.name(), score.psnr));
    let scores = scores.collect::<Vec<_>>().join(", ");
    let scores = if scores.is_empty() {
        scores
    } else {
        format!("Whole photos that are left out are predicted with {scores}.\n")
    };
    let vignetting = match (report.keeps_vignetting, report.vignetting_lead) {
        (true, Some(lead)) => format!("Pictures keep the vignetting of the lenses: {lead:+.2} dB.\n"),
        (false, Some(lead)) => format!("Vignetting is ignored: keeping it would bring {lead:+.2} dB.\n"),
        _ => String::new(),
    };
    format!("{scores}Pictures have {words}{reason}.\n{vignetting}{reference}")
}

/// Describes a rule.
fn rule_words(rule: ExposureRule) -> &'static str {
    match rule {
        ExposureRule::Near => "the exposure of photos taken nearby (near)",
        ExposureRule::Metered => "the exposure that a meter would choose (metered)",
        ExposureRule::Common => "the common exposure (common)",
        ExposureRule::Raw => "the photos' own exposures, as they are (raw)",
    }
}

fn signed(stops: f64) -> String {
    // Adding zero turns -0.0 into 0.0.
    let rounded = (stops * 100.0).round() / 100.0 + 0.0;
    format!("{rounded:+.2}")
}

fn legend(report: &ColourReport) -> String {
    let three = |stops: [f64; 3]| stops.map(|stops| format!("{stops:.3}")).join(" ");
    let off = if report.even { "" } else { "Off: photos are shown and filled without exposure matching.\n" };
    let all_left_out = report.photos.iter().all(|photo| photo.left_out);
    let groups = match report.groups {
        0 if all_left_out => {
            "All photos are left out, so nothing is estimated: `--free PHOTO` includes one again, `--reset` all.\n".to_owned()
        }
        0 => "No two photos share a point, so exposures are unknown.\n".to_owned(),
        1 => String::new(),
        groups => format!("{groups} groups of photos share no points with each other: the mean gain of each is 0.\n"),
    };
    let optics = if report.optics {
        "corner: vignetting in stops, from the centre to the corners\noffset: light added everywhere, as a share of white\n"
    } else {
        ""
    };
    format!(
        "R, G, B: stops by which a photo is brighter than the common exposure\n\
         {optics}residual: median difference at a point after matching, in stops\n\
         {off}{groups}{} and {}: the median difference in R, G, B is {} stops without matching, {} with estimated gains.\n",
        counted(report.points, "point"),
        counted(report.pairs, "comparison"),
        three(report.before),
        three(report.after),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::{Model, Site};
    use quadratura_projection::Gains;
    use quadratura_projection::exposure::Estimate;

    #[test]
    fn a_rule_that_another_setting_changes_is_told_and_one_that_is_set_stays() {
        let site = Site { photos: Vec::new(), model: Model::default().into() };
        let report = |rule: ExposureRule, set: Option<ExposureRule>| {
            let estimate = Estimate {
                gains: Gains { rule, ..Gains::none(0) },
                rules: Vec::new(),
                left_out_psnr: Vec::new(),
                leaning_lead: None,
                surfaces_lead: None,
                vignetting_lead: None,
                camera_lead: None,
                gain_support: Vec::new(),
                reach: 1.0,
                points: 0,
                pairs: 0,
                group_support: GroupSupport::default(),
                alone: Vec::new(),
                components: 0,
                before: [0.0; 3],
                after: [0.0; 3],
            };
            let colour = ColourDecisions { exposure: set, ..ColourDecisions::default() };
            report_from_estimate(&estimate, &colour, &site)
        };
        let near = report(ExposureRule::Near, None);
        let note = switched(&near, &report(ExposureRule::Common, None)).unwrap();
        assert!(note.contains("the common exposure (common) instead of the exposure of photos taken nearby"));
        assert!(note.contains("colour --exposure near"), "{note}");
        assert_eq!(switched(&near, &near), None);
        let set = Some(ExposureRule::Near);
        assert_eq!(switched(&near, &report(ExposureRule::Common, set)), None);
    }
}
