//! The pixels of a photo that a score compares, by the surface that the photo's camera sees there.

use super::ScoreOptions;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Model;
use quadratura_base::task::Task;
use quadratura_layers::fill::options::matches_pattern;
use quadratura_projection::{Renders, TREE, shown_face};
use quadratura_sites::named::objects_named;
use quadratura_view::Shot;

/// Which objects, and whether the background, are compared.
pub(super) struct ComparedObjects {
    /// The names of the model's objects, then of the trees.
    names: Vec<String>,
    /// Whether the pixels of each of these are compared, and last those without a surface.
    compared: Vec<bool>,
}

impl ComparedObjects {
    /// Finds the objects that the options name.
    ///
    /// # Errors
    /// [`Error::Request`] for objects that the model does not have, all of them together.
    pub fn new(model: &Model, options: &ScoreOptions) -> Result<Self> {
        let of_model = model.objects.iter().map(|object| object.name.clone());
        let names: Vec<String> = of_model.chain(options.trees.iter().cloned()).collect();
        let background = names.len();
        let mut compared = vec![options.only.is_empty(); background + 1];
        compared[background] &= !options.ignore_background;
        let named = |patterns: &[String]| -> (Vec<usize>, Vec<Error>) {
            let mut unknown = Vec::new();
            let mut found = Vec::new();
            for pattern in patterns {
                let meant = (0..background).filter(|object| matches_pattern(&names[*object], pattern));
                let before = found.len();
                found.extend(meant);
                if found.len() == before {
                    unknown.extend(objects_named(model, pattern).err());
                }
            }
            (found, unknown)
        };
        let (only, mut unknown) = named(&options.only);
        let (ignored, more) = named(&options.ignored);
        unknown.extend(more);
        only.into_iter().for_each(|object| compared[object] = true);
        ignored.into_iter().for_each(|object| compared[object] = false);
        Error::of_all(unknown).map_or(Ok(Self { names, compared }), Err)
    }

    /// Returns the names of the objects and trees.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the number of objects and trees, and one more for the background.
    pub fn count(&self) -> usize {
        self.compared.len()
    }

    /// Returns whether pixels of an object or tree are compared; of the background for the number of these.
    pub fn contains(&self, object: u32) -> bool {
        self.compared[object as usize]
    }
}

/// Returns the object that a camera sees at each pixel, that of the nearest surface of the model; where a tree is nearer, the
/// number of the model's objects and that of the tree, and `nothing` where there is none. What a score compares follows from this alone, and not from what a prediction draws.
///
/// # Errors
/// As [`Renders::faces`].
pub(super) fn objects_in_view(
    model: &Model,
    shot: &Shot,
    renders: &mut dyn Renders,
    nothing: u32,
    task: &Task,
) -> Result<Vec<u32>> {
    let object = |number: u32| match shown_face(number) {
        Some(face) => model.face(face).object.0,
        None if number & TREE != 0 => (model.objects.len() as u32 + (number & !TREE)).min(nothing),
        None => nothing,
    };
    Ok(renders.faces(shot, task)?.into_iter().map(object).collect())
}
