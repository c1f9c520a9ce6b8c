//! Notes for the user about the faces of a model.

use quadratura_base::geometry::polygon::OutlineFlaw;
use quadratura_base::scene::{FaceFlaw, FaceId, Model};

/// Number of faces that a note names before it gives the number of the others.
const NAMED: usize = 5;

/// Returns one note for each kind of flaw, in a fixed order: the number of faces, the names of the first
/// ones, and how they are handled.
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
        FaceFlaw::Outline(OutlineFlaw::TooFewPoints) => {
            "with fewer than three distinct corners: not textured"
        }
        FaceFlaw::Outline(OutlineFlaw::NoArea) => "without area: not textured",
        FaceFlaw::Outline(OutlineFlaw::SelfCrossing) => {
            "with an outline that crosses itself: split at the crossings"
        }
        FaceFlaw::Outline(OutlineFlaw::Tangled) => {
            "with an outline that crosses itself everywhere or has more than 100,000 corners: not textured"
        }
        FaceFlaw::RepeatedPoint => "with the same corner twice in a row: treated as one corner",
        FaceFlaw::NotPlanar => "not planar: treated as separate triangles",
    }
}

fn names(model: &Model, faces: &[FaceId]) -> String {
    let mut names: Vec<String> = faces.iter().take(NAMED).map(|&id| model.face_name(id)).collect();
    if faces.len() > NAMED {
        names.push(format!("and {} more", faces.len() - NAMED));
    }
    names.join(", ")
}
