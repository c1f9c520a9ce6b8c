//! The impostors of a project: billboards by name, and objects that the user decided about.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;

use crate::named::objects_named;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Similarity;
use quadratura_base::scene::impostor::{Impostor, NoImpostor};
use quadratura_base::scene::up;
use quadratura_base::scene::{Model, Object, ObjectId, Photo};
use quadratura_base::task::Task;
use quadratura_layers::fill::options::matches_pattern;

/// The decisions about impostors by object: true for those that turn, false for billboards that stay polygons.
pub type ImpostorDecisions = BTreeMap<String, bool>;

/// A decision about impostors. Objects are given by name, or by a pattern in which `*` stands for any
/// characters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ImpostorEdit {
    /// The objects turn.
    Turns(String),
    /// The objects stay polygons.
    Stays(String),
    /// The objects turn if their names say billboard: decisions about them are removed.
    Free(String),
}

/// Returns the decisions after the edits, applied in order. `whole` is the model with all objects.
///
/// # Errors
/// Returns [`Error::Request`] for names that the model does not have, all of them together.
pub fn edited(
    decided: &ImpostorDecisions,
    edits: &[ImpostorEdit],
    whole: &Model,
) -> Result<ImpostorDecisions> {
    let edits = edits.iter().map(|edit| match edit {
        ImpostorEdit::Turns(pattern) => (&pattern[..], Some(true)),
        ImpostorEdit::Stays(pattern) => (&pattern[..], Some(false)),
        ImpostorEdit::Free(pattern) => (&pattern[..], None),
    });
    // What the name says already needs no decision.
    decided_by_name(decided, edits, whole, |object| object.billboard)
}

/// Returns decisions about objects after edits, each of a name or pattern with what is decided, applied in order; `None` removes
/// decisions. `of_itself` tells what holds for an object without a decision: then none is kept.
///
/// # Errors
/// Returns [`Error::Request`] for names that the model does not have, all of them together.
pub(super) fn decided_by_name<'a>(
    decided: &BTreeMap<String, bool>,
    edits: impl Iterator<Item = (&'a str, Option<bool>)>,
    whole: &Model,
    of_itself: impl Fn(&Object) -> bool,
) -> Result<BTreeMap<String, bool>> {
    let mut edited = decided.clone();
    let mut apply = |(pattern, holds): (&str, Option<bool>)| -> Result<()> {
        // The model may no longer have an object that was decided about.
        let is_gone = whole.object_named(pattern).is_none();
        if is_gone && edited.remove(pattern).is_some() {
            return Ok(());
        }
        let Some(holds) = holds else {
            let count = edited.len();
            edited.retain(|name, _| !matches_pattern(name, pattern));
            return if edited.len() < count { Ok(()) } else { objects_named(whole, pattern).map(drop) };
        };
        for id in objects_named(whole, pattern)? {
            let object = whole.object(id);
            match holds == of_itself(object) {
                true => edited.remove(&object.name),
                false => edited.insert(object.name.clone(), holds),
            };
        }
        Ok(())
    };
    let errors = edits.filter_map(|edit| apply(edit).err()).collect();
    Error::of_all(errors).map_or(Ok(edited), Err)
}

/// Returns true when an object is to turn.
pub fn turns(object: &Object, decided: &ImpostorDecisions) -> bool {
    decided.get(&object.name).copied().unwrap_or(object.billboard)
}

/// Returns the model in which billboards turn, and reports those that cannot.
pub fn with_impostors(
    model: Arc<Model>,
    photos: &[Photo],
    world_from_model: &Similarity,
    decided: &ImpostorDecisions,
    task: &Task,
) -> Arc<Model> {
    let all = || model.objects.iter();
    for name in decided.keys().filter(|name| all().all(|object| object.name != **name)) {
        task.note(format!("project.json decides about the impostor {name:?}, which the model does not have"));
    }
    if !all().any(|object| turns(object, decided)) {
        return model;
    }
    let up = up_axis(world_from_model, up(photos));
    let (model, refused) = Model::clone(&model).with_impostors(up, |object| turns(object, decided));
    for (name, reason) in refused {
        task.note(format!("{name} cannot turn towards the camera and stays as it is modelled: {reason}"));
    }
    Arc::new(model)
}

/// The objects that are to turn towards cameras but cannot, by name, with the reasons.
pub type RefusedImpostors = BTreeMap<String, NoImpostor>;

/// Returns which objects of the complete model cannot turn. `of_photos` is the photos' mean up direction.
pub fn refused(
    whole: &Model,
    of_photos: DVec3,
    world_from_model: &Similarity,
    decided: &ImpostorDecisions,
) -> RefusedImpostors {
    let up = up_axis(world_from_model, of_photos);
    let ids = (0..whole.objects.len()).map(ObjectId::new);
    let turning = ids.filter(|id| turns(whole.object(*id), decided));
    let refused = turning.filter_map(|id| Some((id, Impostor::of_object(whole, id, up).err()?)));
    refused.map(|(id, reason)| (whole.object(id).name.clone(), reason)).collect()
}

/// The cosine of the largest angle, 20 degrees, between an axis of the model and the photos' mean up direction.
const LEAST_UPRIGHT: f64 = 0.94;

/// Returns the up direction: the axis of the model that points most nearly up in the photos, or the photos' mean up
/// direction where no axis does.
fn up_axis(world_from_model: &Similarity, of_photos: DVec3) -> DVec3 {
    let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let axes = axes.map(|axis| (world_from_model.rotation * axis).normalize());
    let upright = axes.max_by(|a, b| a.dot(of_photos).total_cmp(&b.dot(of_photos)));
    upright.filter(|axis| axis.dot(of_photos) >= LEAST_UPRIGHT).unwrap_or(of_photos)
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use quadratura_base::scene::synthetic::{Modeller, centred, look_at};

    fn photo(eye: DVec3, target: DVec3) -> Photo {
        let pose = look_at(eye, target);
        Photo {
            name: "a".into(),
            camera: centred(64, 48, 50.0),
            pose,
            file: "a".into(),
            masks: Vec::new(),
            exposure: None,
        }
    }

    #[test]
    fn up_is_the_axis_of_the_model_that_photos_are_level_by() {
        let level =
            [photo(DVec3::new(0.0, -9.0, 1.0), DVec3::ZERO), photo(DVec3::new(5.0, -9.0, 3.0), DVec3::ZERO)];
        assert_eq!(up_axis(&Similarity::IDENTITY, up(&level)), DVec3::Z);
        let leaning = Similarity { rotation: DMat3::from_rotation_x(0.1), ..Similarity::IDENTITY };
        assert!(up_axis(&leaning, up(&level)).distance(leaning.rotation * DVec3::Z) < 1e-9);
        let askew = Similarity { rotation: DMat3::from_rotation_x(0.7), ..Similarity::IDENTITY };
        assert!(up_axis(&askew, up(&level)).distance(up(&level)) < 1e-9, "no axis of the model is upright");
    }

    #[test]
    fn names_decide_until_somebody_does() {
        let mut m = Modeller::new();
        m.object("hedge").quad(DVec3::ZERO, DVec3::X, DVec3::Z);
        m.object("tree.billboard").quad(DVec3::ZERO, DVec3::X, DVec3::Z);
        let mut model = (*m.finish()).clone();
        model.objects[1].billboard = true;
        let turning = |decided: &ImpostorDecisions| -> Vec<bool> {
            model.objects.iter().map(|object| turns(object, decided)).collect()
        };
        let none = ImpostorDecisions::new();
        assert_eq!(turning(&none), [false, true]);
        let edits = [ImpostorEdit::Turns("hedge".into()), ImpostorEdit::Stays("tree*".into())];
        let decided = edited(&none, &edits, &model).unwrap();
        assert_eq!(turning(&decided), [true, false]);
        let edits = [ImpostorEdit::Stays("hedge".into()), ImpostorEdit::Turns("tree*".into())];
        assert_eq!(edited(&decided, &edits, &model).unwrap(), none, "as their names say");
        let gone = ImpostorDecisions::from([("fern".to_owned(), true)]);
        assert_eq!(edited(&gone, &[ImpostorEdit::Stays("fern".into())], &model).unwrap(), none);
        let both = ImpostorDecisions::from([("fern".to_owned(), true), ("hedge".to_owned(), true)]);
        let free = |pattern: &str| edited(&both, &[ImpostorEdit::Free(pattern.into())], &model);
        assert_eq!((free("*").unwrap(), free("fern").unwrap().len()), (none.clone(), 1), "also what is gone");
        assert_eq!(free("tree*").unwrap(), both, "nothing was decided about it");
        assert!(free("shrub").is_err(), "the model has none, and nothing was decided about it");
        let unknown = [ImpostorEdit::Turns("shrub".into()), ImpostorEdit::Stays("bush".into())];
        let error = edited(&none, &unknown, &model).unwrap_err().to_string();
        assert!(error.contains("shrub") && error.contains("bush"), "{error}");
    }
}
