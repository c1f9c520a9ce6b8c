//! Masks of objects with a margin, for things that the model contains but represents incorrectly.

use std::path::Path;
use std::sync::Arc;

use crate::document::masks::{MaskOrigin, MaskedObject};
use crate::error::{Error, Message, Remedy, Result};
use crate::geometry::Spans;
use crate::layers::View;
use crate::layers::fill::options::matches_pattern;
use crate::layers::matte::Matte;
use crate::layers::software::owners;
use crate::recipe::budget::default_memory;
use crate::recipe::fill::mattes::{SiteMattes, mattes};
use crate::recipe::impostors::with_impostors;
use crate::recipe::open::Opened;
use crate::recipe::unknown_name::no_such;
use crate::scene::impostor::Facing;
use crate::scene::{Model, ObjectId, Photo};
use crate::task::Task;

/// Returns the objects with a name, or with names like a pattern ([`matches_pattern`]).
///
/// # Errors
/// Returns [`Error::Request`](crate::error::Error::Request) when the model has none of that name.
pub fn objects_named(model: &Model, pattern: &str) -> Result<Vec<ObjectId>> {
    let all = (0..).map(ObjectId).zip(&model.objects);
    let meant: Vec<ObjectId> =
        all.filter(|(_, object)| matches_pattern(&object.name, pattern)).map(|(id, _)| id).collect();
    if meant.is_empty() {
        let known = model.objects.iter().map(|object| object.name.as_str());
        return Err(no_such("object", pattern, known, Some(Remedy::ListObjects)));
    }
    Ok(meant)
}

/// Finds the pixels at which photos show objects of the complete model.
pub struct ObjectMasks<'a> {
    opened: &'a Opened,
    /// The complete model, including removed objects, in which impostors turn.
    model: Arc<Model>,
    /// The mattes of the project, if some of the objects may have one.
    mattes: Option<SiteMattes>,
}

impl<'a> ObjectMasks<'a> {
    /// Prepares masks of the objects of some names or patterns. `whole` is the complete model, including removed objects. For
    /// see-through objects the mattes of the project are used, which are found where they are not up to date; without a stack
    /// there are none.
    ///
    /// # Errors
    /// Returns [`Error::Request`] when the model has no such object, and [`Error::Cancelled`]. Mattes that cannot be found for
    /// another reason are noted.
    pub fn new(
        folder: &Path,
        opened: &'a Opened,
        whole: Model,
        patterns: &[String],
        task: &Task,
    ) -> Result<Self> {
        let Opened { project, site, .. } = opened;
        let (photos, transform) = (&site.photos, &project.world_from_model);
        let model = with_impostors(whole.into(), photos, transform, &project.impostors, &Task::silent());
        let sees_through = |pattern: &String| {
            let named = objects_named(&model, pattern)?.into_iter();
            let present = named.filter_map(|id| site.model.object_named(&model.object(id).name));
            Ok(present.into_iter().any(|id| site.model.object(id).see_through))
        };
        let any = patterns.iter().map(sees_through).collect::<Result<Vec<bool>>>()?;
        let mattes = match any.contains(&true) {
            false => None,
            true => match mattes(folder, opened, false, default_memory(), task) {
                Ok(found) => Some(found),
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(Error::Missing(_)) => None,
                Err(error) => {
                    task.note(
                        Message::from("see-through objects are masked as if they were solid: ").and(&error),
                    );
                    None
                }
            },
        };
        Ok(Self { opened, model, mattes })
    }

    /// Returns the pixels at which a photo shows the objects of a name or pattern, grown by `margin` pixels (rows and columns):
    /// of an impostor its rectangle, and of see-through objects what their mattes hold, as far as these are known.
    ///
    /// # Errors
    /// Returns [`Error::Request`] when the model has no such object.
    pub fn pixels(&self, photo: &Photo, pattern: &str, margin: u32) -> Result<Spans> {
        let objects = objects_named(&self.model, pattern)?;
        let own = self.opened.site.photo_named(&photo.name);
        let mattes: Vec<&Matte> = match self.mattes.as_ref().zip(own) {
            None => Vec::new(),
            Some((mattes, own)) => {
                let named = objects.iter().map(|id| &self.model.object(*id).name[..]);
                named.flat_map(|name| mattes.of_object(own, name)).collect()
            }
        };
        let facing = self.model.facing(&Facing::of_pose(&photo.pose));
        let tolerance = self.opened.project.options.tolerance;
        Ok(object_pixels(photo, &facing, &objects, &mattes, (margin, tolerance)))
    }
}

/// Returns the pixels at which a photo shows the objects, as far as their mattes say so, grown by a margin in pixels (rows
/// and columns). `model` is as the photo's camera sees it ([`Model::facing`]); beside the margin stands the occlusion
/// tolerance.
fn object_pixels(
    photo: &Photo,
    model: &Model,
    objects: &[ObjectId],
    mattes: &[&Matte],
    (margin, tolerance): (u32, f32),
) -> Spans {
    let view = View::new(model, &photo.camera, &photo.pose);
    let owners = owners(&view, tolerance);
    let width = photo.camera.width as usize;
    let of_object: Vec<bool> =
        view.items.iter().map(|item| objects.contains(&model.face(item.face).object)).collect();
    let alpha = |matte: &&Matte, x: i32, y: i32| {
        let known = matte.known.get(x, y).is_some_and(|known| known.is_known());
        matte.texels.get(x, y).filter(|_| known).map(|texel| texel[3])
    };
    let visible = |x: i32, y: i32| {
        let owner = owners[y as usize * width + x as usize];
        let is_own = || owner.checked_sub(1).is_some_and(|item| of_object[item as usize]);
        let found = mattes.iter().filter_map(|matte| alpha(matte, x, y)).max();
        found.map_or_else(is_own, |alpha| alpha > 0)
    };
    let whole = photo.camera.rect();
    let grown = Spans::of_pixels(whole, visible).grown(margin as i32);
    grown.intersection(&Spans::of_pixels(whole, |_, _| true))
}

/// Returns the origin of an object mask.
pub fn from_object(pattern: &str, margin: u32) -> MaskOrigin {
    MaskOrigin::Object(MaskedObject { name: pattern.to_owned(), margin })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::matte::Known;
    use crate::raster::Image;
    use crate::scene::synthetic::closed_form;

    #[test]
    fn what_is_seen_of_an_object_is_masked_with_its_margin_and_what_is_hidden_is_not() {
        let scene = closed_form::two_quads();
        let (photo, model) = (scene.photo(), &scene.model);
        let counts: Vec<u64> = model
            .objects
            .iter()
            .map(|object| {
                let objects = objects_named(model, &object.name).unwrap();
                object_pixels(&photo, model, &objects, &[], (0, 1e-4)).count()
            })
            .collect();
        let both = object_pixels(&photo, model, &objects_named(model, "*").unwrap(), &[], (0, 1e-4));
        assert_eq!(counts.iter().sum::<u64>(), both.count(), "no pixel shows two of them");
        let first = objects_named(model, &model.objects[0].name).unwrap();
        let (bare, wide) = (
            object_pixels(&photo, model, &first, &[], (0, 1e-4)),
            object_pixels(&photo, model, &first, &[], (2, 1e-4)),
        );
        assert!(bare.minus(&wide).is_empty() && wide.count() > bare.count());
        assert!(objects_named(model, "no such*").is_err());
    }

    #[test]
    fn where_a_matte_is_found_it_is_masked_and_not_the_surface() {
        let scene = closed_form::two_quads();
        let (photo, model) = (scene.photo(), &scene.model);
        let name = &model.objects[0].name;
        let objects = objects_named(model, name).unwrap();
        let solid = object_pixels(&photo, model, &objects, &[], (0, 1e-4));
        let whole = photo.camera.rect();
        let is_left = |x: i32| x < whole.w as i32 / 2;
        let matte = Matte {
            object: name.clone(),
            texels: Image::from_fn(whole, |(x, _)| [0, 0, 0, if is_left(x) { 0 } else { 90 }]),
            known: Image::from_fn(whole, |(x, y)| match solid.holds(x, y) {
                true if y % 7 == 0 => Known::Unknown,
                true if y % 7 == 1 => Known::Solved,
                true => Known::Found,
                false => Known::NotShown,
            }),
        };
        let masked = object_pixels(&photo, model, &objects, &[&matte], (0, 1e-4));
        for (x, y) in whole.pixels().filter(|(x, y)| solid.holds(*x, *y)) {
            assert_eq!(masked.holds(x, y), y % 7 == 0 || !is_left(x), "{x}, {y}");
        }
        assert!(masked.minus(&solid).is_empty() && !masked.is_empty());
    }
}
