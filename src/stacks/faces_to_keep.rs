//! The faces that keep their image layers however little a photo shows of them: those with paint, and those that a
//! decision names.

use std::collections::BTreeSet;

use quadratura_base::scene::FaceIndex;
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_document::paint::PaintBook;
use quadratura_document::stack::UntexturedReason;
use quadratura_document::{Decisions, Stack};
use quadratura_layers::{Faces, LayerConstraints};

/// The decisions and the paint of a project, as far as they keep faces in image layers.
#[derive(Debug)]
pub(super) struct FacesToKeep<'a> {
    decisions: &'a Decisions,
    painted: BTreeSet<(&'a str, &'a str, Option<FaceIndex>)>,
}

impl<'a> FacesToKeep<'a> {
    /// Collects decisions and paint.
    pub fn new(decisions: &'a Decisions, paint: &'a PaintBook) -> Self {
        let face = |entry: &'a quadratura_document::paint::PaintEntry| {
            (entry.photo.as_str(), entry.object.as_str(), entry.face)
        };
        Self { decisions, painted: paint.entries.iter().map(face).collect() }
    }

    /// Returns the constraints of a photo: its decisions, and its painted faces as faces to keep.
    pub fn constraints(&self, photo: &str) -> LayerConstraints {
        let mut constraints = self.decisions.of(photo).constraints();
        let painted = self.painted.iter().filter(|(painted, ..)| *painted == photo);
        constraints.keep.extend(
            painted.map(|(_, object, face)| Faces {
                object: (*object).to_owned(),
                faces: Vec::from_iter(*face),
            }),
        );
        constraints
    }

    /// Returns true when the stack leaves out no face that has to be kept now, and keeps none that only earlier paint
    /// or decisions kept.
    pub fn agrees(&self, stack: &Stack) -> bool {
        let constraints = self.constraints(&stack.photo.name);
        let keeps = |object: &str, face: FaceIndex| {
            let mut all = constraints.keep.iter().chain(constraints.merge.iter().flatten());
            all.any(|faces| faces.holds(object, face))
        };
        let mut left_out = stack.untextured.iter().filter(|u| u.reason == UntexturedReason::BarelyVisible);
        let mut spared =
            stack.spared.iter().flat_map(|of| of.faces.iter().map(move |face| (&of.object, *face)));
        let keeps_surroundings = || constraints.keep.iter().any(|faces| faces.object == SURROUNDINGS);
        let surroundings_agree = match stack.spared.iter().any(|of| of.object == SURROUNDINGS) {
            true => keeps_surroundings(),
            false => !stack.surroundings_left_over || !keeps_surroundings(),
        };
        surroundings_agree
            && !left_out.any(|u| keeps(&u.object, u.face))
            && spared.all(|(object, face)| keeps(object, face))
    }
}
