//! Decisions about the photos' exposures: `colour` of `project.json`.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use quadratura_projection::exposure::ExposureRule;

/// The largest permitted gain in stops, up or down. Moonlight and noon are 18 stops apart, so no photo needs more.
pub const MOST_STOPS: f64 = 20.0;

/// The name of the group of light of all photos that are in no other.
pub const REST: &str = "rest";

/// Returns true when a group of light can have this name: the others have a meaning on the command line.
fn is_name_of_group(name: &str) -> bool {
    !name.trim().is_empty() && !name.contains(['=', ',']) && !["auto", "off", REST].contains(&name)
}

/// Decisions about colour, by the photos' names. They affect how photos are shown and how fillings are made, never
/// a photo or paint. Without them, and with [`ColourDecisions::even`] off, colours are as photographed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ColourDecisions {
    /// Whether differences of exposure between photos are matched; if not, photos are shown as they are.
    #[serde(skip_serializing_if = "is_true")]
    pub even: bool,
    /// The photo whose exposure all views have; if none, each view has one by the rule.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    /// The rule by which views are exposed; if none, the one that predicts left-out photos best.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<ExposureRule>,
    /// Gains that replace the estimated ones, in stops (factors of 2 in linear light) for R, G, B: how much
    /// brighter the photo is than the common exposure.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub fixed: BTreeMap<String, [f64; 3]>,
    /// Photos that the estimation of gains ignores; their gains are 0 unless they are fixed.
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    pub left_out: BTreeSet<String>,
    /// The groups of light by name, each with its photos; all others are one more group. Without groups all photos are one;
    /// if this is none, groups are found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub groups: Option<BTreeMap<String, BTreeSet<String>>>,
    /// Whether the darkening of corners by lenses is removed from views (true) or ignored (false); if none, views keep it where
    /// that predicts left-out photos better.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vignetting: Option<bool>,
    /// Whether light that is added everywhere in a photo (haze, a wrong black level) is estimated and subtracted.
    #[serde(skip_serializing_if = "is_false")]
    pub offset: bool,
}

impl Default for ColourDecisions {
    fn default() -> Self {
        Self {
            even: true,
            reference: None,
            exposure: None,
            fixed: BTreeMap::new(),
            left_out: BTreeSet::new(),
            groups: None,
            vignetting: None,
            offset: false,
        }
    }
}

fn is_false(value: &bool) -> bool {
    !*value
}

fn is_true(value: &bool) -> bool {
    *value
}

impl ColourDecisions {
    /// Returns true when nothing was decided.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Returns a sentence about a gain that is out of range, or a group that cannot be, if any.
    pub fn problem(&self) -> Option<String> {
        self.problem_of_groups().or_else(|| self.problem_of_gains())
    }

    fn problem_of_groups(&self) -> Option<String> {
        let groups = self.groups.as_ref()?;
        if let Some(name) = groups.keys().find(|name| !is_name_of_group(name)) {
            return Some(format!(
                "{name:?} cannot be the name of a group of light; expected a name without = and commas, other than \
                 auto, off and {REST}"
            ));
        }
        let photos: Vec<&String> = groups.values().flatten().collect();
        let twice = photos.iter().enumerate().find(|(at, photo)| photos[..*at].contains(photo));
        twice.map(|(_, photo)| format!("{photo} is in two groups of light; expected one"))
    }

    fn problem_of_gains(&self) -> Option<String> {
        let wrong = |stops: &&[f64; 3]| !stops.iter().all(|s| s.abs() <= MOST_STOPS);
        let (photo, stops) = self.fixed.iter().find(|(_, stops)| wrong(stops))?;
        Some(format!("{photo} is fixed at {stops:?} stops; expected {MOST_STOPS} at most, up or down"))
    }

    /// Removes what was decided about a photo's gain.
    pub fn free(&mut self, photo: &str) {
        self.fixed.remove(photo);
        self.left_out.remove(photo);
    }

    /// Moves photos to a group of light, and out of all others; to none of them for [`REST`], which decides nothing where
    /// groups are found. Groups without photos are removed.
    pub fn put_in_group(&mut self, group: &str, photos: &[String]) {
        if group == REST && self.groups.is_none() {
            return;
        }
        let groups = self.groups.get_or_insert_default();
        groups.values_mut().for_each(|members| members.retain(|photo| !photos.contains(photo)));
        if group != REST {
            groups.entry(group.to_owned()).or_default().extend(photos.iter().cloned());
        }
        groups.retain(|_, members| !members.is_empty());
    }

    /// Removes everything about a photo that no longer exists.
    pub fn forget(&mut self, photo: &str) {
        self.free(photo);
        if let Some(groups) = &mut self.groups {
            groups.values_mut().for_each(|members| members.retain(|member| member != photo));
            groups.retain(|_, members| !members.is_empty());
        }
    }

    /// Returns the photos that decisions name, each once, in alphabetical order.
    pub fn named(&self) -> BTreeSet<&str> {
        let grouped = self.groups.iter().flat_map(BTreeMap::values).flatten();
        let names = self.fixed.keys().chain(&self.left_out).chain(&self.reference).chain(grouped);
        names.map(String::as_str).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_decided_is_written_and_comes_back() {
        assert_eq!(serde_json::to_string(&ColourDecisions::default()).unwrap(), "{}");
        let mut colour = ColourDecisions { reference: Some("a.jpg".into()), ..ColourDecisions::default() };
        colour.fixed.insert("b.jpg".into(), [0.5, 0.25, -1.0]);
        colour.left_out.insert("c.jpg".into());
        let text = serde_json::to_string(&colour).unwrap();
        let expected = r#"{"reference":"a.jpg","fixed":{"b.jpg":[0.5,0.25,-1.0]},"left_out":["c.jpg"]}"#;
        assert_eq!(text, expected);
        assert_eq!(serde_json::from_str::<ColourDecisions>(&text).unwrap(), colour);
        assert_eq!(colour.named().into_iter().collect::<Vec<_>>(), ["a.jpg", "b.jpg", "c.jpg"]);
        colour.free("b.jpg");
        colour.free("c.jpg");
        colour.reference = None;
        colour.exposure = Some(ExposureRule::Raw);
        assert_eq!(serde_json::to_string(&colour).unwrap(), r#"{"exposure":"raw"}"#);
        colour.exposure = None;
        assert!(colour.is_default());
    }

    #[test]
    fn a_photo_is_in_one_group_of_light_and_a_group_without_photos_is_none() {
        let mut colour = ColourDecisions::default();
        let [a, b] = ["a.jpg", "b.jpg"].map(String::from);
        colour.put_in_group(REST, std::slice::from_ref(&a));
        assert!(colour.is_default(), "nothing is taken out of groups that are not decided");
        colour.put_in_group("evening", &[a.clone(), b.clone()]);
        colour.put_in_group("night", std::slice::from_ref(&b));
        let text = r#"{"groups":{"evening":["a.jpg"],"night":["b.jpg"]}}"#;
        assert_eq!(serde_json::to_string(&colour).unwrap(), text);
        assert_eq!(serde_json::from_str::<ColourDecisions>(text).unwrap(), colour);
        assert_eq!((colour.problem(), colour.named().len()), (None, 2));
        colour.put_in_group(REST, &[a]);
        colour.forget("b.jpg");
        assert_eq!(colour.groups, Some(BTreeMap::new()), "all photos are one group");
        colour.put_in_group("auto", &[b]);
        assert!(colour.problem().unwrap().contains("\"auto\""));
        let twice = r#"{"groups":{"evening":["a.jpg"],"night":["a.jpg"]}}"#;
        assert!(
            serde_json::from_str::<ColourDecisions>(twice).unwrap().problem().unwrap().contains("two groups")
        );
    }

    #[test]
    fn a_gain_out_of_range_is_told_with_its_photo() {
        let mut colour = ColourDecisions::default();
        colour.fixed.insert("b.jpg".into(), [0.0, 21.0, 0.0]);
        assert!(colour.problem().unwrap().contains("b.jpg"));
        colour.fixed.insert("b.jpg".into(), [0.0, f64::NAN, 0.0]);
        assert!(colour.problem().is_some());
        colour.fixed.insert("b.jpg".into(), [0.0, -20.0, 0.0]);
        assert_eq!(colour.problem(), None);
    }
}
