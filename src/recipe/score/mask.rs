//! The pixels of a photo that a score compares, by the surface that the photo's camera sees there.

use super::ScoreOptions;
use crate::error::{Error, Result};
use crate::projection::{Renders, Shot, shown_face};
use crate::recipe::masks::object::objects_named;
use crate::scene::Model;
use crate::task::Task;

/// Which objects, and whether the background, are compared.
pub(super) struct ComparedObjects {
    /// Whether the pixels of each object are compared, and last those without a surface.
    compared: Vec<bool>,
}

impl ComparedObjects {
    /// Finds the objects that the options name.
    ///
    /// # Errors
    /// [`Error::Request`] for objects that the model does not have, all of them together.
    pub fn new(model: &Model, options: &ScoreOptions) -> Result<Self> {
        let background = model.objects.len();
        let mut compared = vec![options.only.is_empty(); background + 1];
        compared[background] &= !options.ignore_background;
        let named = |patterns: &[String]| -> (Vec<usize>, Vec<Error>) {
            let mut unknown = Vec::new();
            let mut found = Vec::new();
            for pattern in patterns {
                match objects_named(model, pattern) {
                    Ok(objects) => found.extend(objects.iter().map(|object| object.0 as usize)),
                    Err(error) => unknown.push(error),
                }
            }
            (found, unknown)
        };
        let (only, mut unknown) = named(&options.only);
        let (ignored, more) = named(&options.ignored);
        unknown.extend(more);
        only.into_iter().for_each(|object| compared[object] = true);
        ignored.into_iter().for_each(|object| compared[object] = false);
        Error::of_all(unknown).map_or(Ok(Self { compared }), Err)
    }

    /// Returns the number of objects, and one more for the background.
    pub fn count(&self) -> usize {
        self.compared.len()
    }

    /// Returns whether pixels of an object are compared; of the background for the number of objects.
    pub fn contains(&self, object: u32) -> bool {
        self.compared[object as usize]
    }
}

/// Returns the object that a camera sees at each pixel, or the number of objects where there is none: that of the nearest
/// surface of the model. What a score compares follows from this alone, and not from what a prediction draws.
///
/// # Errors
/// As [`Renders::faces`].
pub(super) fn objects_in_view(
    model: &Model,
    shot: &Shot,
    renders: &mut dyn Renders,
    task: &Task,
) -> Result<Vec<u32>> {
    let nothing = model.objects.len() as u32;
    let object = |number: u32| shown_face(number).map_or(nothing, |face| model.face(face).object.0);
    Ok(renders.faces(shot, task)?.into_iter().map(object).collect())
}
