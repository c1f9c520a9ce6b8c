//! The hash of a filling's inputs: while it is unchanged, the filling is up to date.

use std::borrow::Borrow;
use std::collections::BTreeSet;
use std::path::Path;

use crate::gains;
use crate::paint::parts::points;
use crate::survey::StackState;
use quadratura_base::error::Result;
use quadratura_base::geometry::Plane;
use quadratura_base::geometry::polygon::{extent, fit_plane};
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_base::scene::{Photo, PhotoId, Site};
use quadratura_document::paint::{PaintBook, PaintEntry};
use quadratura_document::{Decisions, PhotoDecisions, Project, Stack};
use quadratura_files::hash::hash_bytes;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::Faces;
use quadratura_layers::fill::{FillOptions, MOST_DONORS, OnlyHere, Propagation};
use quadratura_sites::dome_picture::picture_stamp;

/// A counter of changes in how the same inputs are filled.
const VERSION: u32 = 5;

/// A counter of changes in how the same surroundings are filled. It concerns only photos with a layer of them.
const SURROUNDINGS_VERSION: u32 = 1;

/// A counter of changes in the mattes that are found, and in how they take effect. It concerns only sites with see-through
/// surfaces.
const MATTES_VERSION: u32 = 1;

/// A counter of changes in how the same paint is propagated. It concerns only photos to which paint is propagated.
const PROPAGATION_VERSION: u32 = 1;

/// The distance, as a share of a surface's size, beyond which paint on another plane does not concern the surface.
/// Surfaces that count as one are much closer to each other.
const SAME_PLACE: f64 = 0.05;

/// The inputs of all fillings: every photo, and its paint, may contribute to every other photo.
pub struct FillInputs {
    /// The hash of the stacks.
    stacks: String,
    options: FillOptions,
    /// Decisions about colour, and exclusions.
    decided: String,
    /// Pins, by which photos give what others contradict; empty where there are none.
    pins: String,
    /// Pins as they matter where paint is propagated.
    pinned: String,
    /// What says how mattes are found; empty where nothing is see-through.
    mattes: String,
    /// All paint of the project.
    book: PaintBook,
    /// The paint on the surroundings.
    around: PaintAround,
}

/// The paint on the surroundings of all photos: each may fill each.
pub struct PaintAround {
    /// The entries, each with whether it stays in its photo.
    entries: Vec<(PaintEntry, bool)>,
    /// What says that the user's picture of the surroundings is the same.
    picture: String,
}

impl PaintAround {
    fn new(book: &PaintBook, options: &FillOptions, picture: String) -> Self {
        let around = book.entries.iter().filter(|entry| entry.object == SURROUNDINGS);
        let entry = |entry: &PaintEntry| (entry.clone(), options.stays(&entry.place()));
        Self { entries: around.map(entry).collect(), picture }
    }

    /// Returns the hash of what the surroundings of a stack's photo are filled from; empty where it has no layer of
    /// them.
    pub fn of_stack(&self, stack: &Stack) -> String {
        if stack.surroundings().is_none() {
            return String::new();
        }
        let seen = self.entries.iter().filter(|(entry, stays)| !stays || entry.photo == stack.photo.name);
        let seen: Vec<&PaintEntry> = seen.map(|(entry, _)| entry).collect();
        let text = serde_json::to_string(&seen).expect("plain data is JSON");
        hash_bytes(format!("{SURROUNDINGS_VERSION} {text} {}", self.picture).as_bytes())
    }
}

impl FillInputs {
    /// Collects the inputs of the project in `folder`; `stacks` are in the site's order.
    ///
    /// # Errors
    /// Returns an error when the paint book cannot be read.
    pub fn new(
        folder: &Path,
        project: &Project,
        site: &Site,
        stacks: &[Option<impl Borrow<Stack>>],
        options: &FillOptions,
    ) -> Result<Self> {
        Self::of_stamps(folder, project, site, &gains::stamps(stacks), options)
    }

    /// Collects the same from what the photos' stacks were made from ([`Stack::inputs`]), in the site's order.
    ///
    /// # Errors
    /// Returns an error when the paint book cannot be read.
    pub fn of_stamps(
        folder: &Path,
        project: &Project,
        site: &Site,
        stamps: &[Option<String>],
        options: &FillOptions,
    ) -> Result<Self> {
        let decisions = &project.decisions;
        let excluded = decided(decisions, |decided| &decided.exclude);
        let pins = decided(decisions, |decided| &decided.pin);
        let book = PaintStore::new(folder).read()?;
        let has_mattes = !options.no_mattes && site.model.has_see_through();
        Ok(Self {
            mattes: if has_mattes { format!("mattes {MATTES_VERSION}") } else { String::new() },
            around: PaintAround::new(&book, options, picture_stamp(folder, project)),
            stacks: gains::inputs_of_stamps(site, stamps),
            options: options.clone(),
            decided: format!("{}{excluded}", gains::decisions(&project.colour)),
            pinned: format!("propagation {PROPAGATION_VERSION} {pins}"),
            pins,
            book,
        })
    }

    /// Returns the project's paint.
    pub fn book(&self) -> &PaintBook {
        &self.book
    }

    /// Returns the paint on the surroundings.
    pub fn paint_around(&self) -> &PaintAround {
        &self.around
    }

    /// Returns whether other inputs are the same but for the paint.
    pub fn differs_in_paint_alone(&self, other: &Self) -> bool {
        let all = |inputs: &Self| {
            let options = serde_json::to_string(&inputs.options).expect("plain data is JSON");
            [
                inputs.stacks.clone(),
                options,
                inputs.decided.clone(),
                inputs.pins.clone(),
                inputs.mattes.clone(),
            ]
        };
        all(self) == all(other)
    }

    /// Returns the hash of everything except the paint and where it is seen, where at most `donors` photos are used at
    /// once.
    pub fn without_paint(&self, donors: usize) -> String {
        hash_bytes(format!("{} {}{}", self.in_common(donors), self.stacks, self.pins).as_bytes())
    }

    /// Returns the hash of the options and decisions that concern all photos, where at most `donors` photos are used at once.
    pub fn in_common(&self, donors: usize) -> String {
        let Self { decided, mattes, .. } = self;
        let propagate = match self.options.propagate.patterns() {
            [] => Propagation::Undecided,
            _ => self.options.propagate.clone(),
        };
        let (only_here, protected) = (OnlyHere::default(), BTreeSet::new());
        let options = FillOptions { propagate, only_here, protected, ..self.options.clone() };
        let options = serde_json::to_string(&options).expect("plain data is JSON");
        hash_bytes(format!("{VERSION} {options}{decided} {}{mattes}", donors.min(MOST_DONORS)).as_bytes())
    }

    /// Returns the hash for one photo's stack, with those of all photos.
    pub fn of_stack(&self, stack: &Stack) -> String {
        let Self { stacks, decided, mattes, pins, .. } = self;
        hash_bytes(format!("{VERSION} {stacks} {decided}{mattes}{pins} {}", self.of_photo(stack)).as_bytes())
    }

    /// Returns the hash of what concerns the filling of one photo alone. Of all paint, only that on its surfaces or in their
    /// planes counts, and not that which stays in another photo.
    pub fn of_photo(&self, stack: &Stack) -> String {
        let photo = &stack.photo.name;
        let options = serde_json::to_string(&self.options.of_photo(photo)).expect("plain data is JSON");
        let pinned = if self.options.propagates_to(photo) { &self.pinned[..] } else { "" };
        let planes: Vec<(Plane, f64)> = stack
            .surfaces
            .iter()
            .filter_map(|surface| {
                let outline = points(&surface.outline);
                Some((fit_plane(&outline)?, extent(&outline)))
            })
            .collect();
        let counts = |entry: &&PaintEntry| {
            let named =
                stack.surfaces.iter().any(|s| (Some(s.face), &s.object) == (entry.face, &entry.object));
            let stays = entry.photo != *photo && self.options.stays(&entry.place());
            entry.face.is_some() && !entry.beyond && !stays && (named || is_level(entry, &planes))
        };
        let paint: Vec<_> = self
            .book
            .entries
            .iter()
            .filter(counts)
            .map(|e| (&e.photo, &e.object, e.face, e.triangle, e.import, &e.view, &e.file))
            .collect();
        let paint = serde_json::to_string(&paint).expect("plain data is JSON");
        let around = self.around.of_stack(stack);
        hash_bytes(format!("{options}{pinned}{paint}{around}").as_bytes())
    }
}

/// The state of a photo's filling in relation to the project.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FillState {
    /// The filling was made from the present stacks and options.
    Current,
    /// Something has changed since.
    Stale,
    /// There is no filling.
    Missing,
}

impl FillState {
    /// Returns a word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Current => "filled",
            Self::Stale => "stale",
            Self::Missing => "not filled",
        }
    }

    /// Returns the state of a stack's filling.
    pub fn new(stack: &Stack, inputs: &FillInputs) -> Self {
        match &stack.fill {
            None => Self::Missing,
            Some(fill) if fill.inputs == inputs.of_stack(stack) => Self::Current,
            Some(_) => Self::Stale,
        }
    }
}

/// Returns the photos with fillings that are out of date, in the site's order: paint, options or stacks have changed
/// since. Such a filling is shown as it is, with paint that may have been undone since.
///
/// # Errors
/// Returns an error when the paint book cannot be read.
pub fn stale_fillings(folder: &Path, project: &Project, site: &Site) -> Result<Vec<PhotoId>> {
    let store = StackStore::new(folder);
    // A stack that cannot be read is reported where it is used.
    let stack = |photo: &Photo| store.current(&photo.name).ok().flatten();
    let stacks: Vec<Option<Stack>> = site.photos.iter().map(stack).collect();
    stale_among(folder, project, site, &stacks)
}

/// As [`stale_fillings`], of `stacks` that were read already, in the site's order.
///
/// # Errors
/// Returns an error when the paint book cannot be read.
pub fn stale_among(
    folder: &Path,
    project: &Project,
    site: &Site,
    stacks: &[Option<Stack>],
) -> Result<Vec<PhotoId>> {
    let inputs = FillInputs::new(folder, project, site, stacks, &project.fill)?;
    let is_stale = |stack: &Stack| FillState::new(stack, &inputs) == FillState::Stale;
    let photos = PhotoId::all(stacks.len()).zip(stacks);
    Ok(photos.filter(|(_, stack)| stack.as_ref().is_some_and(is_stale)).map(|(photo, _)| photo).collect())
}

/// Returns the photos with stacks whose image layers are not as the project would fill them now, in the site's order.
///
/// # Errors
/// Returns an error when the paint book cannot be read, and of stacks that cannot be compared with the project.
pub fn photos_to_fill(folder: &Path, project: &Project, site: &Site) -> Result<Vec<PhotoId>> {
    let states = super::stacks::states(project, site, &StackStore::new(folder))?;
    let stacks: Vec<Option<&Stack>> = states.iter().map(StackState::stack).collect();
    let inputs = FillInputs::new(folder, project, site, &stacks, &project.fill)?;
    let waits = |state: &StackState| match state {
        StackState::Current(stack) => FillState::new(stack, &inputs) != FillState::Current,
        StackState::Stale(_) => true,
        StackState::Missing | StackState::Broken(_) => false,
    };
    Ok(PhotoId::all(states.len()).zip(&states).filter(|(_, state)| waits(state)).map(|(id, _)| id).collect())
}

/// Returns one list of decisions of all photos, empty where there are none: exclusions, because photos do not fill
/// faces for which they are excluded, or pins, because paint does not replace what was pinned.
fn decided(decisions: &Decisions, list: impl Fn(&PhotoDecisions) -> &Vec<Faces>) -> String {
    let of_photo = decisions.photos.iter().filter(|(_, decided)| !list(decided).is_empty());
    let of_photo: Vec<_> = of_photo.map(|(photo, decided)| (photo, list(decided))).collect();
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
