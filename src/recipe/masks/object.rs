//! Masks of objects with a margin, for things that the model contains but represents incorrectly.

use crate::document::masks::{MaskOrigin, MaskedObject};
use crate::error::{Remedy, Result};
use crate::geometry::Spans;
use crate::layers::View;
use crate::layers::fill::options::matches_pattern;
use crate::layers::software::owners;
use crate::recipe::unknown_name::no_such;
use crate::scene::{Model, ObjectId, Photo};

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

/// Returns the pixels at which a photo shows the objects, grown by `margin` pixels (rows and columns). `model` is
/// the complete one, including removed objects; `tolerance` is the occlusion tolerance.
pub fn object_pixels(
    photo: &Photo,
    model: &Model,
    objects: &[ObjectId],
    margin: u32,
    tolerance: f32,
) -> Spans {
    let view = View::new(model, &photo.camera, &photo.pose);
    let owners = owners(&view, tolerance);
    let width = photo.camera.width as usize;
    let of_object: Vec<bool> =
        view.items.iter().map(|item| objects.contains(&model.face(item.face).object)).collect();
    let visible = |x: i32, y: i32| {
        let owner = owners[y as usize * width + x as usize];
        owner.checked_sub(1).is_some_and(|item| of_object[item as usize])
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
                object_pixels(&photo, model, &objects, 0, 1e-4).count()
            })
            .collect();
        let both = object_pixels(&photo, model, &objects_named(model, "*").unwrap(), 0, 1e-4);
        assert_eq!(counts.iter().sum::<u64>(), both.count(), "no pixel shows two of them");
        let first = objects_named(model, &model.objects[0].name).unwrap();
        let (bare, wide) =
            (object_pixels(&photo, model, &first, 0, 1e-4), object_pixels(&photo, model, &first, 2, 1e-4));
        assert!(bare.minus(&wide).is_empty() && wide.count() > bare.count());
        assert!(objects_named(model, "no such*").is_err());
    }
}
