//! Exposure matching as the user sees it: a table of the photos' gains, and edits of `colour` in `project.json`.

use std::collections::BTreeMap;
use std::f64::consts::LN_2;
use std::path::Path;

use serde::Serialize;

use crate::written_exposure::{CameraReport, WrittenExposure};
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::{PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::colour::REST;
use quadratura_document::{ColourDecisions, Project, Stack};
use quadratura_io::stack_store::StackStore;
use quadratura_projection::exposure::{Estimate, ExposureRule, GroupSupport, Lead, LightGroups, RuleScore};
use quadratura_sites::budget::default_memory;
use quadratura_sites::named::index_of_photo;
use quadratura_stacks::gains::{known_estimate, photo_estimate, photo_gains};
use quadratura_view::Exposure;
use quadratura_view::optics::Optics;

/// A decision about colour. Photos may be given by abbreviated names ([`index_of_photo`]).
#[derive(Debug, Clone, PartialEq)]
pub enum ColourEdit {
    /// Removes all decisions.
    Reset,
    /// Fixes the photo's gain, in stops for R, G, B ([`ColourDecisions::fixed`]).
    Fix(String, [f64; 3]),
    /// Excludes the photo from the estimation of gains.
    LeaveOut(String),
    /// Removes the decisions about the photo's gain.
    Free(String),
    /// Sets the photo whose exposure all views have; with `None` each view has one by the rule.
    Reference(Option<String>),
    /// Sets the rule by which views are exposed; with `None` the one that predicts left-out photos best.
    Rule(Option<ExposureRule>),
    /// Moves photos to the group of light of this name, out of all others; to none of them for [`REST`].
    Group(String, Vec<String>),
    /// Makes all photos one group of light.
    OneGroup,
    /// Lets groups of light be found.
    FindGroups,
    /// Turns exposure matching on or off.
    Even(bool),
    /// Removes vignetting from views, or ignores it; with `None` views keep it where that predicts left-out photos better.
    Vignetting(Option<bool>),
    /// Turns the subtraction of added light (haze) on or off.
    Offset(bool),
}

/// Returns `colour` after the edits, applied in order.
///
/// # Errors
/// Returns [`Error::Request`] for photos that the site does not have, all of them together, and for gains out of
/// range.
pub fn edited(colour: &ColourDecisions, edits: &[ColourEdit], site: &Site) -> Result<ColourDecisions> {
    let mut edited = colour.clone();
    let errors = edits.iter().filter_map(|edit| apply(&mut edited, edit, site).err()).collect();
    match (Error::of_all(errors), edited.problem()) {
        (Some(error), _) => Err(error),
        (None, Some(problem)) => Err(Error::Request(problem)),
        (None, None) => Ok(edited),
    }
}

/// Applies one edit.
fn apply(colour: &mut ColourDecisions, edit: &ColourEdit, site: &Site) -> Result<()> {
    let full = |name: &str| Ok(site.photo(index_of_photo(site, name)?).name.clone());
    match edit {
        ColourEdit::Reset => *colour = ColourDecisions::default(),
        ColourEdit::Fix(photo, stops) => drop(colour.fixed.insert(full(photo)?, *stops)),
        ColourEdit::LeaveOut(photo) => drop(colour.left_out.insert(full(photo)?)),
        // Decisions may outlive their photos, so a full name that is written there is accepted as well.
        ColourEdit::Free(photo) if site.photo_named(photo).is_some() => colour.free(photo),
        ColourEdit::Free(photo) if colour.named().contains(photo.as_str()) => colour.forget(photo),
        ColourEdit::Free(photo) => colour.free(&full(photo)?),
        ColourEdit::Reference(photo) => colour.reference = photo.as_deref().map(full).transpose()?,
        ColourEdit::Rule(rule) => colour.exposure = *rule,
        ColourEdit::Group(group, photos) => {
            let (known, unknown): (Vec<_>, Vec<_>) =
                photos.iter().map(|photo| full(photo)).partition(Result::is_ok);
            if let Some(error) = Error::of_all(unknown.into_iter().filter_map(Result::err).collect()) {
                return Err(error);
            }
            let known: Vec<String> = known.into_iter().filter_map(Result::ok).collect();
            colour.put_in_group(group, &known);
        }
        ColourEdit::OneGroup => colour.groups = Some(BTreeMap::new()),
        ColourEdit::FindGroups => colour.groups = None,
        ColourEdit::Even(even) => colour.even = *even,
        ColourEdit::Vignetting(vignetting) => colour.vignetting = *vignetting,
        ColourEdit::Offset(offset) => colour.offset = *offset,
    }
    Ok(())
}

/// Returns the exposure of the project's views unless another is requested: the reference photo's, if there is one,
/// else by the rule that is decided for the site.
pub fn usual_exposure(project: &Project, site: &Site) -> Exposure {
    reference(&project.colour, site).map_or(Exposure::Decided, Exposure::Of)
}

/// Returns the reference photo, if the site has it.
pub fn reference(colour: &ColourDecisions, site: &Site) -> Option<PhotoId> {
    site.photo_named(colour.reference.as_ref()?)
}

/// Returns the factors for R, G, B that match the photos' linear colours, by photo name: to the reference's
/// exposure, if there is one, else to the common exposure.
///
/// # Errors
/// Returns [`Error::Cancelled`] when the task was cancelled.
pub fn even_factors(
    folder: &Path,
    project: &Project,
    site: &Site,
    task: &Task,
) -> Result<BTreeMap<String, [f64; 3]>> {
    let stacks = stacks(folder, site);
    let gains = photo_gains(site, &stacks, &project.colour, folder, default_memory(), task)?.of_photo;
    let names = site.photos.iter().map(|photo| photo.name.clone());
    Ok(names.zip(factors(&gains, &project.colour, site)).collect())
}

/// Returns the factors for R, G, B that match the photos' linear colours, in the site's order. `gains` are the
/// photos' own gains as natural logarithms.
pub fn factors(gains: &[[f64; 3]], colour: &ColourDecisions, site: &Site) -> Vec<[f64; 3]> {
    let target = reference(colour, site).map_or([0.0; 3], |photo| gains[photo.index()]);
    gains.iter().map(|gain| [0, 1, 2].map(|c| (target[c] - gain[c]).exp())).collect()
}

/// A report of the photos' exposures. Logarithms are in stops: factors of 2 in linear light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColourReport {
    /// Whether exposures are matched.
    pub even: bool,
    /// Whether vignetting or offsets are corrected.
    pub optics: bool,
    /// Whether views are darkened towards their corners like the photos.
    pub keeps_vignetting: bool,
    /// By how many dB left-out photos are predicted better so; `None` where no vignetting was found or it was not compared.
    pub vignetting_lead: Option<f64>,
    /// The photos, in the site's order.
    pub photos: Vec<PhotoColour>,
    /// The number of surface points that are visible in at least two photos.
    pub points: usize,
    /// The number of comparisons between two photos at a point.
    pub pairs: usize,
    /// The number of groups of photos that share points; nothing is known between groups.
    pub groups: usize,
    /// The median absolute log ratio in stops for R, G, B, before correction.
    pub before: [f64; 3],
    /// The median absolute log ratio in stops for R, G, B, after the estimated gains are applied.
    pub after: [f64; 3],
    /// The share of the meter reading that exposures follow, for R, G, B: 0 not at all, 1 entirely.
    pub metered: [f64; 3],
    /// The rule by which views are exposed; a reference photo takes precedence.
    pub rule: ExposureRule,
    /// The rule that is used unless the user sets another.
    pub rule_decided: ExposureRule,
    /// Whether the user has set the rule.
    pub rule_set: bool,
    /// How well each rule predicts whole photos that are left out; empty where nothing can be compared.
    pub rules: Vec<RuleScore>,
    /// The exposures that cameras wrote down.
    pub camera: CameraReport,
    /// The groups of light, in the order of their first photos; one group is the normal case.
    pub light: Vec<LightGroupReport>,
    /// Whether the user has set the groups.
    pub light_set: bool,
    /// What speaks for the groups that are found, in stops.
    pub light_support: GroupSupport,
    /// Whether views lean to the groups of light that they show most of.
    pub leans: bool,
    /// By how many dB left-out photos are predicted better so than with all photos in one group; `None` where all photos are one
    /// group, and where nothing can be compared.
    pub leaning_lead: Option<Lead>,
    /// Whether views that lean bring photos of other groups to their light by gains per surface.
    pub surfaces: bool,
    /// By how many dB left-out photos are predicted better so; `None` as for `leaning_lead`.
    pub surfaces_lead: Option<Lead>,
}

impl ColourReport {
    /// Describes each group of light by its name and the number of its photos, for a legend.
    pub fn described_groups(&self) -> Vec<String> {
        let described = |group: &LightGroupReport| {
            let name = if self.light_set { group.name.clone() } else { found_name(group) };
            let photos = group.photos.len();
            format!("{name} ({photos} {})", if photos == 1 { "photo" } else { "photos" })
        };
        match self.light.len() {
            1 => vec!["One for all photos".to_owned()],
            _ => self.light.iter().map(described).collect(),
        }
    }

    /// Says whether views lean to groups of light, and why; `otherwise` says how views show the light of one group where they
    /// do not.
    pub fn leaning_in_words(&self, otherwise: &str) -> String {
        match (self.leans, self.leaning_lead) {
            (_, None) => "Views lean to the groups that they show most of; nothing can be compared.".into(),
            (true, Some(lead)) => format!(
                "Views lean to the groups that they show most of, which predicts left-out photos better than one group: {}.",
                lead_in_words(lead)
            ),
            (false, Some(lead)) => format!(
                "Views blend all groups; leaning to the groups that they show most of does not clearly predict left-out photos \
                 better: {}. {otherwise}",
                lead_in_words(lead)
            ),
        }
    }
}

/// Returns a lead with its standard error.
pub fn lead_in_words(Lead { mean, error }: Lead) -> String {
    format!("{mean:+.2} ± {error:.2} dB")
}

/// A group of light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightGroupReport {
    /// Its name, or its number if it was found.
    pub name: String,
    /// The names of its photos, in the site's order.
    pub photos: Vec<String>,
}

/// The exposure of one photo.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhotoColour {
    /// The photo's name.
    pub photo: String,
    /// How much brighter it is than the common exposure, in stops for R, G, B, as used for showing and filling.
    pub stops: [f64; 3],
    /// The estimated gain in stops; `None` where the photo shares no point with another one.
    pub estimated: Option<[f64; 3]>,
    /// What the camera wrote down; `None` where it did not.
    pub camera: Option<WrittenExposure>,
    /// Whether the gain is fixed by the user.
    pub fixed: bool,
    /// Whether the photo is excluded from the estimation.
    pub left_out: bool,
    /// Whether it is the reference, whose exposure all views have.
    pub reference: bool,
    /// The darkening of its corners relative to its middle, in stops.
    pub corner: f64,
    /// The light that was added everywhere, as a linear share of white.
    pub offset: f64,
    /// The index of its group in [`ColourReport::light`].
    pub group: usize,
    /// The number of surface points that it shares with other photos.
    pub points: u32,
    /// The median absolute log ratio that remains after the estimate, in stops.
    pub residual: f64,
}

/// Estimates the exposures, or reads them from `cache/`, and reports on each photo.
///
/// # Errors
/// Returns [`Error::Cancelled`] when the task was cancelled.
pub fn colour_report(folder: &Path, project: &Project, site: &Site, task: &Task) -> Result<ColourReport> {
    note_absent_photos(&project.colour, site, task);
    let estimate = estimate(folder, site, &project.colour, task)?;
    Ok(report_from_estimate(&estimate, &project.colour, site))
}

/// Makes the report from an estimate and the decisions.
pub fn report_from_estimate(estimate: &Estimate, colour: &ColourDecisions, site: &Site) -> ColourReport {
    let photos = site.photo_ids().map(|id| photo_colour(id, site, colour, estimate));
    let light = &estimate.gains.light;
    ColourReport {
        even: colour.even,
        optics: estimate.gains.optics.iter().any(|optics| *optics != Optics::default())
            || colour.vignetting == Some(true)
            || colour.offset,
        keeps_vignetting: light.blended.as_deref().unwrap_or(&estimate.gains).keeps_vignetting,
        vignetting_lead: estimate.vignetting_lead,
        photos: photos.collect(),
        points: estimate.points,
        pairs: estimate.pairs,
        groups: estimate.components,
        before: estimate.before.map(in_stops),
        after: estimate.after.map(in_stops),
        metered: estimate.gains.follows(),
        rule: colour.exposure.unwrap_or(estimate.gains.rule),
        rule_decided: estimate.gains.rule,
        rule_set: colour.exposure.is_some(),
        rules: estimate.rules.clone(),
        camera: CameraReport::new(estimate),
        light: light_groups(&light.groups, colour, site),
        light_set: colour.groups.is_some(),
        light_support: GroupSupport {
            within: in_stops(estimate.group_support.within),
            between: in_stops(estimate.group_support.between),
            ..estimate.group_support
        },
        leans: !light.groups.is_one() && light.blended.is_none(),
        leaning_lead: estimate.leaning_lead,
        surfaces: !light.surfaces.is_empty(),
        surfaces_lead: estimate.surfaces_lead,
    }
}

/// Returns the edits that make the found groups of light decided ones, so that a single photo can be taken out of its group;
/// the first group is the rest. There are none where one group is found, or groups are decided.
pub fn keeping_found(report: &ColourReport) -> Vec<ColourEdit> {
    let found = report.light.iter().skip(1).filter(|_| !report.light_set);
    found.map(|group| ColourEdit::Group(found_name(group), group.photos.clone())).collect()
}

/// Returns the name by which a found group becomes a decided one.
pub fn found_name(group: &LightGroupReport) -> String {
    format!("Light {}", group.name)
}

/// Lists the groups of light with their photos.
fn light_groups(groups: &LightGroups, colour: &ColourDecisions, site: &Site) -> Vec<LightGroupReport> {
    let of_group = |group: usize| {
        let photos = site.photo_ids().filter(|photo| groups.of(*photo) == group);
        let photos: Vec<String> = photos.map(|photo| site.photo(photo).name.clone()).collect();
        let decided = colour.groups.as_ref().map(|groups| {
            let named =
                groups.iter().find(|(_, members)| photos.first().is_some_and(|p| members.contains(p)));
            named.map_or(REST, |(name, _)| name).to_owned()
        });
        LightGroupReport { name: decided.unwrap_or_else(|| (group + 1).to_string()), photos }
    };
    (0..groups.count()).map(of_group).collect()
}

/// Makes the report of a project from the cached estimate; `None` where there is none. Nothing is computed.
pub fn known_report(folder: &Path, project: &Project, site: &Site) -> Option<ColourReport> {
    let estimate = known_estimate(site, &stacks(folder, site), &project.colour, folder)?;
    Some(report_from_estimate(&estimate, &project.colour, site))
}

/// Estimates the exposures, or reads them from `cache/`, for [`report_from_estimate`] and
/// [`quadratura_stacks::gains::decided_gains`].
///
/// # Errors
/// Returns [`Error::Cancelled`] when the task was cancelled.
pub fn estimate(folder: &Path, site: &Site, colour: &ColourDecisions, task: &Task) -> Result<Estimate> {
    let stacks = stacks(folder, site);
    photo_estimate(site, &stacks, colour, folder, default_memory(), task)
}

/// Converts a natural logarithm to stops.
fn in_stops(log: f64) -> f64 {
    log / LN_2
}

/// Reports on a photo of the site.
fn photo_colour(id: PhotoId, site: &Site, colour: &ColourDecisions, estimate: &Estimate) -> PhotoColour {
    let (name, index) = (&site.photo(id).name, id.index());
    let estimated = estimate.gains.of_photo[index].map(in_stops);
    let fixed = colour.fixed.get(name).copied();
    PhotoColour {
        photo: name.clone(),
        stops: if colour.even { fixed.unwrap_or(estimated) } else { [0.0; 3] },
        estimated: (!estimate.alone.contains(&id)).then_some(estimated),
        camera: WrittenExposure::of_photo(id, site, estimate),
        fixed: fixed.is_some(),
        left_out: colour.left_out.contains(name),
        reference: reference(colour, site) == Some(id),
        corner: in_stops(-estimate.gains.optics[index].log_light(1.0)),
        offset: estimate.gains.optics[index].offset,
        group: estimate.gains.group(id),
        points: estimate.gain_support[index].points,
        residual: in_stops(estimate.gain_support[index].residual),
    }
}

/// Notes decisions about photos that are not in the site. They are kept, and apply again when the photo is back.
fn note_absent_photos(colour: &ColourDecisions, site: &Site, task: &Task) {
    let known = |name: &&str| site.photos.iter().any(|photo| photo.name == *name);
    for name in colour.named().into_iter().filter(|name| !known(name)) {
        let found = format!("project.json has colour settings for {name}, which is not among the photos (");
        task.note((found, Remedy::FreeColour(name.to_owned()), " removes them)"));
    }
}

/// Returns the current stacks, which identify the cached estimate; unreadable stacks count as missing here.
fn stacks(folder: &Path, site: &Site) -> Vec<Option<Stack>> {
    let store = StackStore::new(folder);
    site.photos.iter().map(|photo| store.current(&photo.name).ok().flatten()).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DMat3, DVec3};

    use super::*;
    use quadratura_base::geometry::Pose;
    use quadratura_base::scene::synthetic::centred;
    use quadratura_base::scene::{Model, Photo};
    use quadratura_stacks::gains::decided_groups;

    fn site() -> Site {
        let photo = |name: &str| Photo {
            name: name.into(),
            camera: centred(4, 3, 3.0),
            pose: Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO },
            file: "nowhere".into(),
            masks: Vec::new(),
            exposure: None,
        };
        Site { photos: ["a.jpg", "b.jpg"].map(photo).to_vec(), model: Arc::new(Model::default()) }
    }

    #[test]
    fn edits_are_kept_by_whole_names_and_each_can_be_taken_back() {
        use ColourEdit::{Even, Fix, Free, LeaveOut, Reference, Reset, Rule};
        let edits = [
            Fix("a".into(), [0.5; 3]),
            LeaveOut("b".into()),
            Reference(Some("b".into())),
            Rule(Some(ExposureRule::Raw)),
            Even(false),
        ];
        let all = edited(&ColourDecisions::default(), &edits, &site()).unwrap();
        assert_eq!(all.exposure, Some(ExposureRule::Raw));
        assert!(all.fixed["a.jpg"] == [0.5; 3] && all.left_out.contains("b.jpg") && !all.even);
        assert_eq!(reference(&all, &site()), Some(PhotoId(1)));
        let back = [Free("a".into()), Free("b".into()), Reference(None), Rule(None), Even(true)];
        assert!(edited(&all, &back, &site()).unwrap().is_default());
        assert!(edited(&all, &[Reset], &site()).unwrap().is_default());
    }

    #[test]
    fn groups_of_light_are_made_of_abbreviated_names_and_taken_back() {
        use ColourEdit::{FindGroups, Group, OneGroup};
        let edit = |colour: &ColourDecisions, edits: &[ColourEdit]| edited(colour, edits, &site());
        let evening =
            edit(&ColourDecisions::default(), &[Group("evening".into(), vec!["b".into()])]).unwrap();
        assert!(evening.groups.as_ref().unwrap()["evening"].contains("b.jpg"));
        let groups = decided_groups(&evening, &site()).unwrap();
        let light = light_groups(&groups, &evening, &site());
        let names: Vec<(&str, &[String])> = light.iter().map(|g| (g.name.as_str(), &g.photos[..])).collect();
        assert_eq!(names, [("rest", &["a.jpg".to_owned()][..]), ("evening", &["b.jpg".to_owned()][..])]);
        let one = edit(&evening, &[OneGroup]).unwrap();
        assert!(decided_groups(&one, &site()).unwrap().is_one() && !one.is_default());
        assert!(edit(&one, &[FindGroups]).unwrap().is_default());
        let wrong = [Group("off".into(), vec!["a".into()])];
        assert!(edit(&evening, &wrong).unwrap_err().to_string().contains("\"off\""));
        let absent =
            edit(&evening, &[Group("x".into(), vec!["c".into(), "d".into()])]).unwrap_err().to_string();
        assert!(absent.contains("\"c\"") && absent.contains("\"d\""), "{absent}");
    }

    #[test]
    fn wrong_names_are_told_all_at_once_and_a_photo_that_is_gone_can_be_forgotten() {
        let wrong = [ColourEdit::LeaveOut("x".into()), ColourEdit::Fix("y".into(), [0.0; 3])];
        let message = edited(&ColourDecisions::default(), &wrong, &site()).unwrap_err().to_string();
        assert!(message.contains("no photo \"x\"") && message.contains("no photo \"y\""), "{message}");
        let mut colour = ColourDecisions::default();
        colour.left_out.insert("gone.jpg".into());
        let free = [ColourEdit::Free("gone.jpg".into())];
        assert!(edited(&colour, &free, &site()).unwrap().is_default());
    }
}
