//! The state of a project's photos: which have a stack, which are out of date, which layers have a face.

use crate::faces_to_keep::FacesToKeep;
use crate::inputs::Inputs;
use crate::layer_names::rename;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::{FaceId, Model, Object, Photo, Site};
use quadratura_document::paint::PaintBook;
use quadratura_document::{Decisions, Project, Stack};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_sites::unknown_name::no_such;

/// The state of a photo's stack in relation to the project.
#[derive(Debug)]
pub enum StackState {
    /// The stack was made from the project as it is.
    Current(Stack),
    /// Something has changed since: photo, camera, model, options or program.
    Stale(Stack),
    /// There is no stack.
    Missing,
    /// The stack or its photo cannot be read.
    Broken(Error),
}

impl StackState {
    /// Returns the state's name in JSON.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Current(_) => "current",
            Self::Stale(_) => "stale",
            Self::Missing => "not built",
            Self::Broken(_) => "broken",
        }
    }

    /// Returns the stack, if there is one.
    pub fn stack(&self) -> Option<&Stack> {
        match self {
            Self::Current(stack) | Self::Stale(stack) => Some(stack),
            Self::Missing | Self::Broken(_) => None,
        }
    }
}

/// A comparison of stacks on disk with the project that they belong to.
pub struct Survey<'a> {
    store: &'a StackStore,
    decisions: &'a Decisions,
    inputs: Inputs<'a>,
    paint: PaintBook,
}

impl<'a> Survey<'a> {
    /// Prepares the comparison for one project.
    pub fn new(project: &'a Project, site: &'a Site, store: &'a StackStore) -> Self {
        let inputs = Inputs::new(&site.model, &project.options, &project.decisions);
        // Paint that cannot be read is reported where it is shown.
        let paint = PaintStore::new(store.project()).read().unwrap_or_default();
        Self { store, decisions: &project.decisions, inputs, paint }
    }

    /// Returns the state of a photo's stack, with its layers named as decided. It is broken where the photo cannot
    /// be read any more, so that the others can still be used.
    ///
    /// # Errors
    /// Returns [`Error::Cancelled`] only.
    pub fn state(&self, photo: &Photo) -> Result<StackState> {
        let mut stack = match self.store.current(&photo.name) {
            Ok(Some(stack)) => stack,
            Ok(None) => return Ok(StackState::Missing),
            Err(error) => return Ok(StackState::Broken(error)),
        };
        // Renaming takes effect at once, before the file is written again.
        rename(&mut stack, &self.decisions.of(&photo.name).names);
        match self.inputs.hash(photo) {
            Ok(inputs) if inputs == stack.inputs && self.keeps_its_faces(&stack) => {
                Ok(StackState::Current(stack))
            }
            Ok(_) => Ok(StackState::Stale(stack)),
            Err(Error::Cancelled) => Err(Error::Cancelled),
            Err(error) => Ok(StackState::Broken(error)),
        }
    }

    /// Returns true when the stack has the image layers that paint and decisions ask for.
    fn keeps_its_faces(&self, stack: &Stack) -> bool {
        FacesToKeep::new(self.decisions, &self.paint).agrees(stack)
    }
}

/// Returns the number of an object's faces in words.
fn faces_of(object: &Object) -> String {
    match object.faces.len() {
        1 => "1 face".into(),
        count => format!("{count} faces"),
    }
}

/// Returns the face that a name of the form `object[index]` refers to.
///
/// # Errors
/// Returns [`Error::Request`] when the model has no such object, or the object no such face.
pub fn face_named(model: &Model, name: &str) -> Result<FaceId> {
    let expected = || {
        let found = format!("{name:?} is not a face; write OBJECT[INDEX], as in the list of ");
        Error::missing((found, Remedy::List, ""))
    };
    if let Some(object) = model.object_like(name) {
        let faces = faces_of(model.object(object));
        return Err(Error::Request(format!(
            "{name:?} is an object with {faces}; write {name}[0] for its first face"
        )));
    }
    let (object, rest) = name.rsplit_once('[').ok_or_else(expected)?;
    let index: usize = rest.strip_suffix(']').and_then(|index| index.parse().ok()).ok_or_else(expected)?;
    let Some(object) = model.object_like(object).map(|object| model.object(object)) else {
        let known = model.objects.iter().map(|object| object.name.as_str());
        return Err(no_such("object", object, known, Some(Remedy::ListObjects)));
    };
    object.faces.get(index).copied().ok_or_else(|| {
        let (name, faces) = (&object.name, faces_of(object));
        Error::Request(format!("{name:?} has {faces}, numbered from 0; there is no face {index}"))
    })
}
