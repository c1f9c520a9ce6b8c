//! Objects become drafts of sub-objects, one for each surface that they are placed with.

use std::path::Path;

use glam::DAffine3;
use rustc_hash::FxHashMap;

use super::super::remedies::COARSER;
use super::objects::{Object, ObjectId};
use super::surfaces::{SurfaceId, Surfaces};
use crate::{Draft, DraftUse, MOST_CORNERS, MOST_USES, Primitive};
use quadratura_base::error::{Error, Result};

/// An object, and the surface of what has none in it.
type Kind = (ObjectId, Option<SurfaceId>);

/// The drafts so far.
struct Graph {
    objects: Vec<Object>,
    /// True for objects in which something has no surface of its own.
    open: Vec<bool>,
    known: FxHashMap<Kind, usize>,
    /// The kinds in the order of their drafts.
    kinds: Vec<Kind>,
    uses: usize,
    corners: u64,
}

/// Makes drafts of what the last object uses. Returns them, and which one is the whole plant: the only object that is
/// placed there, if it is not moved and nothing stands beside it, else the last object itself.
///
/// # Errors
/// [`Error::Input`] for too much of anything.
pub fn drafts(path: &Path, objects: Vec<Object>, surfaces: &mut Surfaces) -> Result<(Vec<Draft>, usize)> {
    let mut open: Vec<bool> = Vec::with_capacity(objects.len());
    for object in &objects {
        let of_parts = object.parts.iter().any(|part| part.surface.is_none());
        open.push(of_parts || object.placed.iter().any(|of| of.surface.is_none() && open[of.object.0]));
    }
    let last = ObjectId(objects.len() - 1);
    let mut graph =
        Graph { objects, open, known: FxHashMap::default(), kinds: Vec::new(), uses: 0, corners: 0 };
    graph.draft_of((last, None));
    let mut drafts: Vec<Draft> = Vec::new();
    while let Some(kind) = graph.kinds.get(drafts.len()).copied() {
        let draft = graph.draft(kind, surfaces);
        let draft = draft.map_err(|found| Error::input(path, "", found, COARSER))?;
        drafts.push(draft);
    }
    let root = match (&drafts[0].primitives[..], &drafts[0].uses[..]) {
        ([], [of]) if of.parent_from_child == DAffine3::IDENTITY => of.child,
        _ => 0,
    };
    Ok((drafts, root))
}

impl Graph {
    /// Returns the draft of a kind, which is made later.
    fn draft_of(&mut self, kind: Kind) -> usize {
        let kind = (kind.0, kind.1.filter(|_| self.open[kind.0.0]));
        *self.known.entry(kind).or_insert_with(|| {
            self.kinds.push(kind);
            self.kinds.len() - 1
        })
    }

    /// Makes a draft.
    ///
    /// # Errors
    /// What is too much.
    fn draft(&mut self, (object, inherited): Kind, surfaces: &mut Surfaces) -> Result<Draft, String> {
        let of = &mut self.objects[object.0];
        // Where everything has a surface there is no other draft of the object.
        let parts = if self.open[object.0] { of.parts.clone() } else { std::mem::take(&mut of.parts) };
        let (name, placed) = (of.name.clone(), of.placed.clone());
        let mut draft = Draft { name, ..Draft::default() };
        for part in parts {
            let material = surfaces.material(part.surface.or(inherited), part.picture.as_ref());
            self.corners = self.corners.saturating_add(part.shape.corners());
            draft.primitives.push(Primitive { shape: part.shape, material });
        }
        self.uses += placed.len();
        if self.corners > MOST_CORNERS || self.uses > MOST_USES {
            return Err(format!(
                "more than {MOST_CORNERS} corners or {MOST_USES} uses, with a sub-object for each surface"
            ));
        }
        for of in placed {
            let child = self.draft_of((of.object, of.surface.or(inherited)));
            draft.uses.push(DraftUse { child, parent_from_child: of.parent_from_child });
        }
        Ok(draft)
    }
}
