//! The hash of a filling's inputs: while it is unchanged, the filling is up to date.

use std::path::Path;

use crate::document::paint::{PaintBook, PaintEntry};
use crate::document::{Decisions, Stack};
use crate::error::Result;
use crate::geometry::Plane;
use crate::geometry::polygon::{extent, fit_plane};
use crate::io::hash::hash_bytes;
use crate::io::paint_store::PaintStore;
use crate::layers::fill::{FillOptions, MOST_DONORS};
use crate::recipe::gains;
use crate::recipe::open::Opened;
use crate::recipe::paint::parts::points;

/// A counter of changes in how the same inputs are filled.
const VERSION: u32 = 2;

/// The distance, as a share of a surface's size, beyond which paint on another plane does not concern the surface.
/// Surfaces that count as one are much closer to each other.
const SAME_PLACE: f64 = 0.05;

/// The inputs of all fillings: every photo, and its paint, may contribute to every other photo.
pub struct FillInputs {
    /// The hash of stacks, together with options and decisions about colour.
    common: String,
    /// All paint of the project.
    book: PaintBook,
}

impl FillInputs {
    /// Collects the inputs of the project in `folder`; `stacks` are in the site's order.
    ///
    /// # Errors
    /// Returns an error when the paint book cannot be read.
    pub fn new(
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

    /// Returns the project's paint.
    pub fn book(&self) -> &PaintBook {
        &self.book
    }

    /// Returns the hash of everything except the paint, where at most `donors` photos are used at once.
    pub fn without_paint(&self, donors: usize) -> String {
        hash_bytes(format!("{} {}", self.common, donors.min(MOST_DONORS)).as_bytes())
    }

    /// Returns the hash for one photo's stack. Of all paint, only that on its surfaces or in their planes counts.
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

/// Returns the exclusions, because photos do not fill faces for which they are excluded; empty where there are
/// none.
fn excluded(decisions: &Decisions) -> String {
    let of_photo = decisions.photos.iter().filter(|(_, decided)| !decided.exclude.is_empty());
    let of_photo: Vec<_> = of_photo.map(|(photo, decided)| (photo, &decided.exclude)).collect();
    if of_photo.is_empty() {
        return String::new();
    }
    serde_json::to_string(&of_photo).expect("plain data is JSON")
}

/// Returns true when an entry's surface lies in one of the planes.
fn is_level(entry: &PaintEntry, planes: &[(Plane, f64)]) -> bool {
    let outline = points(&entry.outline);
    let size = extent(&outline);
    planes.iter().any(|(plane, extent)| {
        let near = SAME_PLACE * size.max(*extent);
        outline.iter().all(|point| plane.signed_distance(*point).abs() <= near)
    })
}
