//! What a photo's filling was made of, as a hash: when that still holds, nothing is filled again.

use std::path::Path;

use crate::document::paint::{PaintBook, PaintEntry};
use crate::document::{Decisions, Stack};
use crate::error::Result;
use crate::geometry::Plane;
use crate::geometry::polygon::{extent, fit_plane};
use crate::io::hash::hash_bytes;
use crate::io::paint_store::PaintStore;
use crate::layers::fill::FillOptions;
use crate::recipe::gains;
use crate::recipe::open::Opened;
use crate::recipe::paint::parts::points;

/// Changes whenever the same inputs would be filled otherwise.
const VERSION: u32 = 2;

/// Paint on a plane that is off a surface by more than this share of its size is no concern of it. Surfaces that count
/// as one are nearer to each other by far.
const SAME_PLACE: f64 = 0.05;

/// All that fillings are made of: every photo may give to every other, and so may its paint.
pub struct FillInputs {
    /// Of stacks, options, colour.
    common: String,
    /// All paint that there is.
    book: PaintBook,
}

impl FillInputs {
    /// Those of the project in `folder`; `stacks` in the site's order.
    ///
    /// # Errors
    /// When the book of paint cannot be read.
    pub fn of(
        folder: &Path,
        opened: &Opened,
        stacks: &[Option<Stack>],
        options: &FillOptions,
    ) -> Result<Self> {
        let options = serde_json::to_string(options).expect("plain data is JSON");
        let colour = gains::decisions(&opened.project.colour);
        let excluded = excluded(&opened.project.decisions);
        let common = format!("{VERSION} {} {options}{colour}{excluded}", gains::inputs(&opened.site, stacks));
        Ok(Self { common, book: PaintStore::new(folder).read()? })
    }

    /// The paint of the project.
    pub fn book(&self) -> &PaintBook {
        &self.book
    }

    /// The hash for one photo's stack: of all paint only that counts which is on its surfaces or level with them.
    pub fn of_stack(&self, stack: &Stack) -> String {
        let planes: Vec<(Plane, f64)> = stack
            .surfaces
            .iter()
            .filter_map(|surface| {
                let outline = points(&surface.outline);
                Some((fit_plane(&outline)?, extent(&outline)))
            })
            .collect();
        let counts = |entry: &&PaintEntry| {
            let named = stack.surfaces.iter().any(|s| (s.face, &s.object) == (entry.face, &entry.object));
            !entry.beyond && (named || is_level(entry, &planes))
        };
        let paint: Vec<_> = self
            .book
            .entries
            .iter()
            .filter(counts)
            .map(|e| (&e.photo, &e.object, e.face, e.triangle, e.import, &e.view, &e.file))
            .collect();
        let paint = serde_json::to_string(&paint).expect("plain data is JSON");
        hash_bytes(format!("{}{paint}", self.common).as_bytes())
    }
}

/// Photos give nothing to faces that they are excluded for; empty where none is.
fn excluded(decisions: &Decisions) -> String {
    let of_photo = decisions.photos.iter().filter(|(_, decided)| !decided.exclude.is_empty());
    let of_photo: Vec<_> = of_photo.map(|(photo, decided)| (photo, &decided.exclude)).collect();
    if of_photo.is_empty() {
        return String::new();
    }
    serde_json::to_string(&of_photo).expect("plain data is JSON")
}

fn is_level(entry: &PaintEntry, planes: &[(Plane, f64)]) -> bool {
    let outline = points(&entry.outline);
    let size = extent(&outline);
    planes.iter().any(|(plane, extent)| {
        let near = SAME_PLACE * size.max(*extent);
        outline.iter().all(|point| plane.signed_distance(*point).abs() <= near)
    })
}
