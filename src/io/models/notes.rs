//! What a user is told about the faces of a model.

use crate::geometry::polygon::Flaw;
use crate::scene::{FaceFlaw, FaceId, Model};

/// Names that a note gives before it says how many more there are.
const NAMED: usize = 5;

/// One note for each kind of flaw, in a fixed order: how many faces have it, the first of them by
/// name, and what becomes of them.
pub(super) fn about_faces(model: &Model, flaws: &[(FaceId, FaceFlaw)]) -> Vec<String> {
    let mut kinds: Vec<FaceFlaw> = flaws.iter().map(|&(_, kind)| kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let note = |kind: FaceFlaw| {
        let faces: Vec<FaceId> = flaws.iter().filter(|(_, k)| *k == kind).map(|&(id, _)| id).collect();
        let count = match faces.len() {
            1 => "1 face".to_owned(),
            n => format!("{n} faces"),
        };
        format!("{count} {} ({})", meaning(kind), names(model, &faces))
    };
    kinds.into_iter().map(note).collect()
}

fn meaning(kind: FaceFlaw) -> &'static str {
    match kind {
        FaceFlaw::Outline(Flaw::TooFewPoints) => "with fewer than three different corners: no texture",
        FaceFlaw::Outline(Flaw::NoArea) => "without area: no texture",
        FaceFlaw::Outline(Flaw::SelfCrossing) => {
            "with an outline that crosses itself: taken apart at the crossings"
        }
        FaceFlaw::Outline(Flaw::Tangled) => {
            "with an outline that crosses itself everywhere or has more than 100,000 corners: no texture"
        }
        FaceFlaw::RepeatedPoint => "with the same corner twice in a row: taken as one corner",
        FaceFlaw::NotPlanar => "not planar: treated triangle by triangle",
    }
}

fn names(model: &Model, faces: &[FaceId]) -> String {
    let mut names: Vec<String> = faces.iter().take(NAMED).map(|&id| model.face_name(id)).collect();
    if faces.len() > NAMED {
        names.push(format!("and {} more", faces.len() - NAMED));
    }
    names.join(", ")
}
