//! Decisions about the photos' exposures: `colour` of `project.json`.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::projection::exposure::ExposureRule;

/// The largest permitted gain in stops, up or down. Moonlight and noon are 18 stops apart, so no photo needs more.
pub const MOST_STOPS: f64 = 20.0;

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

    /// Returns a sentence about a gain that is out of range, if any.
    pub fn problem(&self) -> Option<String> {
        let wrong = |stops: &&[f64; 3]| !stops.iter().all(|s| s.abs() <= MOST_STOPS);
        let (photo, stops) = self.fixed.iter().find(|(_, stops)| wrong(stops))?;
        Some(format!("{photo} is fixed at {stops:?} stops; expected {MOST_STOPS} at most, up or down"))
    }

    /// Removes what was decided about a photo's gain.
    pub fn free(&mut self, photo: &str) {
        self.fixed.remove(photo);
        self.left_out.remove(photo);
    }

    /// Returns the photos that decisions name, each once, in alphabetical order.
    pub fn named(&self) -> BTreeSet<&str> {
        let names = self.fixed.keys().chain(&self.left_out).chain(&self.reference);
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
