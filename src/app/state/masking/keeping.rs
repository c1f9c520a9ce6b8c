//! The queue of mask edits that wait to be written: one after the other, each a step of the history.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::state::running::JobId;
use quadratura_base::geometry::Spans;
use quadratura_sites::masks::MaskEdit;

/// The queue of mask edits.
#[derive(Default)]
pub struct Keeping {
    /// The steps that wait, the next one at the front.
    pub queue: VecDeque<Waiting>,
    /// The job that writes the next step.
    pub working: Option<JobId>,
}

/// A step that waits to be written.
#[derive(Clone)]
pub struct Waiting {
    /// The name of the step, for undo.
    pub name: String,
    /// The change of the masks.
    pub work: MaskWork,
}

/// A change of masks.
#[derive(Clone)]
pub enum MaskWork {
    /// Applies these edits.
    Edits(Arc<Vec<MaskEdit>>),
    /// Masks the part of an object that is visible in a photo, with a margin.
    Object {
        /// The photo's name.
        photo: String,
        /// The object's name.
        object: String,
        /// The margin, in photo pixels.
        margin_px: u32,
    },
    /// Masks the real trees in all photos, where trees of the project stand, with a margin.
    Trees {
        /// The margin, in photo pixels.
        margin_px: u32,
    },
}

impl Keeping {
    /// Returns whether the queue is empty.
    pub fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// Returns the masked pixels of a photo after this change; `masked` are those before it.
    pub fn applied_to(&self, masked: Spans, photo: &str) -> Spans {
        let edits = self.queue.iter().flat_map(|waiting| match &waiting.work {
            MaskWork::Edits(edits) => edits.as_slice(),
            MaskWork::Object { .. } | MaskWork::Trees { .. } => &[],
        });
        edits.fold(masked, |masked, edit| match edit {
            MaskEdit::Put { photo: of, masked: more, .. } | MaskEdit::Add { photo: of, masked: more, .. }
                if of == photo =>
            {
                masked.union(more)
            }
            MaskEdit::Uncover { photo: of, pixels } if of == photo => masked.minus(pixels),
            MaskEdit::Clear { photo: of } if of == photo => Spans::default(),
            // Which pixels remain after a mask is removed is known once the others have been read.
            _ => masked,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::PixelRect;
    use quadratura_document::masks::MaskOrigin;

    #[test]
    fn what_waits_is_shown_as_if_it_were_done_in_its_photo_alone() {
        let block = |x: i32, w: u32| Spans::of_pixels(PixelRect { x, y: 0, w, h: 1 }, |_, _| true);
        let add =
            |photo: &str, masked| MaskEdit::Add { photo: photo.into(), from: MaskOrigin::Drawn, masked };
        let uncover = MaskEdit::Uncover { photo: "a".into(), pixels: block(2, 2) };
        let edits = vec![add("a", block(0, 9)), add("b", block(20, 5)), uncover];
        let waiting = Waiting { name: String::new(), work: MaskWork::Edits(Arc::new(edits)) };
        let keeping = Keeping { queue: VecDeque::from([waiting]), working: None };
        assert_eq!(keeping.applied_to(block(30, 1), "a").count(), 1 + 9 - 2);
        assert_eq!(keeping.applied_to(block(30, 1), "b").count(), 1 + 5);
        assert_eq!(keeping.applied_to(block(30, 1), "c").count(), 1);
    }
}
