//! The decisions about a photo one by one, with the numbers by which they are removed.

use serde::Serialize;

use crate::unsatisfied::{list, title_of_split};
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_document::PhotoDecisions;
use quadratura_document::decisions::PhotoOptions;
use quadratura_layers::Faces;

/// The kind of a decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DecisionKind {
    /// A merge: [`PhotoDecisions::merge`].
    Merge,
    /// A split: [`PhotoDecisions::split`].
    Split,
    /// A layer's name: [`PhotoDecisions::names`].
    Name,
    /// An exclusion: [`PhotoDecisions::exclude`].
    Exclude,
    /// A pin: [`PhotoDecisions::pin`].
    Pin,
    /// Overlaps within an object that are left to other photos: [`PhotoDecisions::tolerate`].
    Tolerate,
    /// Options of the method: [`PhotoDecisions::options`].
    Options,
}

/// A decision about a photo.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ListedDecision {
    /// The number, counted from 1 through all kinds.
    pub number: usize,
    /// The kind.
    pub kind: DecisionKind,
    /// The description.
    pub text: String,
    /// The faces that it refers to.
    pub of: Vec<Faces>,
}

/// Lists the decisions about a photo in the order of `project.json`.
pub fn decided(decisions: &PhotoDecisions) -> Vec<ListedDecision> {
    let of = |kind, text: String, of: Vec<Faces>| (kind, text, of);
    let one = |faces: &Faces| vec![faces.clone()];
    let merges =
        decisions.merge.iter().map(|m| of(DecisionKind::Merge, format!("merge of {}", list(m)), m.clone()));
    let splits = decisions.split.iter().map(|s| of(DecisionKind::Split, title_of_split(s), s.concat()));
    let names = decisions.names.iter();
    let names = names.map(|n| {
        of(DecisionKind::Name, format!("{:?} is the layer of {}", n.name, list(&n.of)), n.of.clone())
    });
    let excluded =
        decisions.exclude.iter().map(|f| of(DecisionKind::Exclude, format!("excluded for {f}"), one(f)));
    let pinned = decisions.pin.iter().map(|f| of(DecisionKind::Pin, format!("{f} is pinned to it"), one(f)));
    let tolerated = decisions
        .tolerate
        .iter()
        .map(|f| of(DecisionKind::Tolerate, format!("overlaps within {f} are left to other photos"), one(f)));
    let options = (!decisions.options.is_default())
        .then(|| of(DecisionKind::Options, options_in_words(&decisions.options), Vec::new()));
    let all = merges.chain(splits).chain(names).chain(excluded).chain(pinned).chain(tolerated).chain(options);
    (1..).zip(all).map(|(number, (kind, text, of))| ListedDecision { number, kind, text, of }).collect()
}

/// Describes the options that differ.
fn options_in_words(options: &PhotoOptions) -> String {
    let tolerance = options.tolerance.map(|t| format!("tolerance {t}"));
    let support = options.min_support.map(|n| format!("min_support {n}"));
    let margin = options.margin.map(|n| format!("margin {n}"));
    let visible = options.min_visible.map(|n| format!("min_visible {n}"));
    let share = options.min_share.map(|s| format!("min_share {s}"));
    let tolerated = options.tolerated.map(|s| format!("tolerated {s}"));
    [tolerance, support, margin, visible, share, tolerated]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join(", ")
}

/// Removes the decision with this number.
///
/// # Errors
/// Returns [`Error::Request`] when there is none.
pub fn forget(decisions: &mut PhotoDecisions, photo: &str, number: usize) -> Result<()> {
    let all = decided(decisions);
    let Some(found) = all.iter().find(|decided| decided.number == number) else {
        let count = all.len();
        let found = format!("{photo} has no decision {number}; it has {count}, counted from 1 (");
        return Err(Error::missing((found, Remedy::ListDecisions, " lists them)")));
    };
    let index = all.iter().filter(|other| other.kind == found.kind && other.number < number).count();
    match found.kind {
        DecisionKind::Merge => drop(decisions.merge.remove(index)),
        DecisionKind::Split => drop(decisions.split.remove(index)),
        DecisionKind::Name => drop(decisions.names.remove(index)),
        DecisionKind::Exclude => drop(decisions.exclude.remove(index)),
        DecisionKind::Pin => drop(decisions.pin.remove(index)),
        DecisionKind::Tolerate => drop(decisions.tolerate.remove(index)),
        DecisionKind::Options => decisions.options = PhotoOptions::default(),
    }
    Ok(())
}
