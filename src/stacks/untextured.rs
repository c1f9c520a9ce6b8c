//! The reasons for which a photo gives a face no texture: from the sort, from masks and from decisions.

use std::collections::BTreeSet;

use quadratura_base::scene::{Face, FaceId, FaceIndex, Model, PhotoPixels};
use quadratura_document::stack::{Untextured, UntexturedReason};
use quadratura_document::{PhotoDecisions, Stack};
use quadratura_layers::leftovers::BarelyVisible;
use quadratura_layers::projected_model::Absence;
use quadratura_layers::rasteriser::Presence;
use quadratura_layers::runs::{is_visible, item_of};
use quadratura_layers::{LayerIndex, Sorted};

/// Lists the faces that a photo gives no texture: those in its stack, then those that are excluded.
pub fn untextured(stack: &Stack, decisions: &PhotoDecisions) -> Vec<Untextured> {
    let mut faces: Vec<Untextured> = stack.untextured.iter().collect();
    faces.extend(excluded(stack, decisions));
    faces
}

/// All reasons, in the order of lists: those that can be mended first.
pub const REASONS: [UntexturedReason; 8] = [
    UntexturedReason::Hidden,
    UntexturedReason::Masked,
    UntexturedReason::BarelyVisible,
    UntexturedReason::TooSmall,
    UntexturedReason::Outside,
    UntexturedReason::Behind,
    UntexturedReason::Excluded,
    UntexturedReason::Degenerate,
];

/// Returns the reason in words, for the window.
pub fn words(reason: UntexturedReason) -> &'static str {
    match reason {
        UntexturedReason::Hidden => "hidden",
        UntexturedReason::Masked => "masked",
        UntexturedReason::BarelyVisible => "barely visible",
        UntexturedReason::TooSmall => "too small or edge-on",
        UntexturedReason::Outside => "outside the photo",
        UntexturedReason::Behind => "behind the camera",
        UntexturedReason::Excluded => "excluded by hand",
        UntexturedReason::Degenerate => "without area",
    }
}

/// Lists the faces without texture with their reasons, in the model's order.
pub fn of_sort(model: &Model, sorted: &Sorted) -> Vec<Untextured> {
    let mut why: Vec<(FaceId, Untextured)> = Vec::new();
    let mut add = |face: FaceId, reason: UntexturedReason, by: Option<String>, at: Option<[u32; 2]>| {
        let f = model.face(face);
        let object = model.object(f.object).name.clone();
        why.push((face, Untextured { object, face: f.index, reason, by, at, px: None }));
    };
    for &(face, absence) in &sorted.view.absent {
        let reason = match absence {
            Absence::Outside => UntexturedReason::Outside,
            Absence::Behind => UntexturedReason::Behind,
            Absence::EdgeOn => UntexturedReason::TooSmall,
            Absence::Degenerate => UntexturedReason::Degenerate,
        };
        add(face, reason, None, None);
    }
    let items = &sorted.view.items;
    let mut first = 0;
    // All triangles of a non-planar face count as one face.
    for group in items.chunk_by(|a, b| a.face == b.face) {
        let states = &sorted.presence[first..first + group.len()];
        first += group.len();
        if states.contains(&Presence::Working) {
            continue;
        }
        let hidden = states.iter().find_map(|s| match *s {
            Presence::Hidden { x, y, by } => Some((x, y, by)),
            _ => None,
        });
        match hidden {
            Some((x, y, by)) => {
                let by = model.face_name(items[by as usize].face);
                add(group[0].face, UntexturedReason::Hidden, Some(by), Some([x, y]));
            }
            None => add(group[0].face, UntexturedReason::TooSmall, None, None),
        }
    }
    why.extend(
        sorted.leftovers.faces.iter().map(|leftover| (leftover.face, barely_visible(model, leftover))),
    );
    why.sort_by_key(|(face, _)| *face);
    why.into_iter().map(|(_, u)| u).collect()
}

/// Describes a face that the photo barely shows.
fn barely_visible(model: &Model, leftover: &BarelyVisible) -> Untextured {
    let Face { object, index, .. } = *model.face(leftover.face);
    Untextured {
        object: model.object(object).name.clone(),
        face: index,
        reason: UntexturedReason::BarelyVisible,
        by: None,
        at: Some(leftover.first_px),
        px: Some([leftover.visible_px, leftover.covered_px]),
    }
}

/// Lists the faces in image layers that are visible only at invalid pixels.
pub fn of_mask(model: &Model, sorted: &Sorted, pixels: &PhotoPixels) -> Vec<Untextured> {
    let items = &sorted.view.items;
    let mut textured: BTreeSet<FaceId> = BTreeSet::new();
    for (y, run, entries) in sorted.runs.iter() {
        let visible = entries.iter().filter(|&&e| is_visible(e)).map(|&e| items[item_of(e) as usize].face);
        let fresh: Vec<FaceId> = visible.filter(|f| !textured.contains(f)).collect();
        if !fresh.is_empty() && (run.x0..run.x1).any(|x| pixels.is_valid(x, y)) {
            textured.extend(fresh);
        }
    }
    let nodes = sorted.nodes.list.iter().zip(&sorted.leftovers.nodes).filter(|(_, left_over)| !**left_over);
    let working: BTreeSet<FaceId> = nodes.map(|(n, _)| items[n.item as usize].face).collect();
    let masked = working.difference(&textured).map(|&face| {
        let Face { object, index, .. } = *model.face(face);
        let object = model.object(object).name.clone();
        let reason = UntexturedReason::Masked;
        Untextured { object, face: index, reason, by: None, at: None, px: None }
    });
    masked.collect()
}

/// Returns the faces that a photo could texture and that are excluded.
pub fn excluded(stack: &Stack, decisions: &PhotoDecisions) -> Vec<Untextured> {
    if decisions.exclude.is_empty() {
        return Vec::new();
    }
    let mut found: Vec<(String, FaceIndex)> = Vec::new();
    for element in stack.visibility_layers.iter().flatten() {
        let faces = element.all_faces().into_iter().filter(|face| decisions.excludes(&element.object, *face));
        found.extend(faces.map(|face| (element.object.clone(), face)));
    }
    found.sort_unstable();
    found.dedup();
    let is_listed =
        |object: &str, face: FaceIndex| stack.untextured.iter().any(|u| u.object == object && u.face == face);
    found.retain(|(object, face)| !is_listed(object, *face));
    let reason = UntexturedReason::Excluded;
    let untextured = |(object, face)| Untextured { object, face, reason, by: None, at: None, px: None };
    found.into_iter().map(untextured).collect()
}

/// The state of a face in a stack.
#[derive(Debug, PartialEq)]
pub enum FaceInStack {
    /// The face has texture in these image layers (indices in [`Stack::image_layers`]), seen from behind or not.
    Textured {
        /// The indices of the image layers, in [`Stack::image_layers`].
        image_layers: Vec<LayerIndex>,
        /// Whether the photo sees the face from behind.
        back: bool,
    },
    /// The face has no texture, for the given reason.
    Untextured(Untextured),
    /// The stack was made from a model without this face.
    Unknown,
}

/// Looks up the face `index` of `object` in a stack.
pub fn face_in_stack(stack: &Stack, object: &str, index: FaceIndex) -> FaceInStack {
    if let Some(untextured) = stack.untextured.iter().find(|u| u.object == object && u.face == index) {
        return FaceInStack::Untextured(untextured);
    }
    let holding: Vec<_> = stack
        .numbered_elements()
        .filter(|(_, element)| element.object == object)
        .filter(|(_, element)| {
            element.faces.contains(&index) || element.pieces.iter().any(|(face, _)| *face == index)
        })
        .collect();
    if holding.is_empty() {
        return FaceInStack::Unknown;
    }
    let holds =
        |layer: LayerIndex| holding.iter().any(|(index, _)| stack.layer(layer).elements.contains(index));
    FaceInStack::Textured {
        image_layers: stack.layer_indices().filter(|layer| holds(*layer)).collect(),
        back: holding.iter().any(|(_, element)| element.back.contains(&index)),
    }
}

/// The texture that a photo has for a face.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FaceTexture {
    /// The photo's layers are not built, so nothing is known.
    NotBuilt,
    /// There is texture in this number of image layers, seen from behind or not.
    Texture {
        /// The number of image layers.
        image_layers: usize,
        /// Whether the photo sees the face from behind.
        back: bool,
    },
    /// There is no texture, for the given reason, which may be a decision.
    Nothing(Untextured),
    /// The photo's layers were made from a model without this face.
    Unknown,
}

/// Returns the texture that a photo has for a face, by its stack and the decisions about it.
pub fn given(stack: &Stack, decided: &PhotoDecisions, object: &str, index: FaceIndex) -> FaceTexture {
    match face_in_stack(stack, object, index) {
        FaceInStack::Untextured(why) => FaceTexture::Nothing(why.clone()),
        FaceInStack::Unknown => FaceTexture::Unknown,
        FaceInStack::Textured { image_layers, back } => {
            let is_it = |why: &Untextured| why.object == object && why.face == index;
            let by_hand = match decided.excludes(object, index) {
                true => excluded(stack, decided).into_iter().find(is_it),
                false => None,
            };
            by_hand
                .map_or(FaceTexture::Texture { image_layers: image_layers.len(), back }, FaceTexture::Nothing)
        }
    }
}
