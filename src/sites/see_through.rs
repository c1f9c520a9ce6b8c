//! What one may see through in places: impostors, and objects that the user decided about, such as fences.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::impostors::{self, with_impostors};
use quadratura_base::error::Result;
use quadratura_base::scene::{Model, Object, Photo};
use quadratura_base::task::Task;
use quadratura_document::Project;

/// The decisions about see-through objects by object: true for those that are, false for impostors that are solid.
pub type SeeThroughDecisions = BTreeMap<String, bool>;

/// A decision about what one sees through. Objects are given by name, or by a pattern in which `*` stands for any
/// characters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SeeThroughEdit {
    /// One may see through the objects in places.
    SeeThrough(String),
    /// The objects are solid.
    Solid(String),
    /// One may see through the objects if they turn: decisions about them are removed.
    Free(String),
}

/// Returns a project's decisions after the edits, applied in order. `whole` is the model with all objects, in the world.
///
/// # Errors
/// Returns [`quadratura_base::error::Error::Request`] for names that the model does not have, all of them together.
pub fn edited(
    project: &Project,
    edits: &[SeeThroughEdit],
    whole: &Arc<Model>,
    photos: &[Photo],
) -> Result<SeeThroughDecisions> {
    let transform = &project.world_from_model;
    let turned = with_impostors(whole.clone(), photos, transform, &project.impostors, &Task::silent());
    let edits = edits.iter().map(|edit| match edit {
        SeeThroughEdit::SeeThrough(pattern) => (&pattern[..], Some(true)),
        SeeThroughEdit::Solid(pattern) => (&pattern[..], Some(false)),
        SeeThroughEdit::Free(pattern) => (&pattern[..], None),
    });
    impostors::decided_by_name(&project.see_through, edits, &turned, |object| object.impostor.is_some())
}

/// The share of a model's faces that may be declared see-through without a word: fences are few of the faces of a site.
const MANY: f64 = 0.25;

/// Returns what to expect of decisions by which a large part of the model is see-through, or nothing solid is left; `None` where
/// that is not so, or was so before. A single object was meant.
pub fn expected_work(
    before: &SeeThroughDecisions,
    decided: &SeeThroughDecisions,
    whole: &Model,
) -> Option<String> {
    let declared = |decided: &SeeThroughDecisions| -> (usize, usize) {
        let is_declared = |object: &&Object| decided.get(&object.name) == Some(&true);
        let objects = whole.objects.iter().filter(is_declared);
        (objects.clone().count(), objects.map(|object| object.faces.len()).sum())
    };
    let ((objects, faces), (_, faces_before)) = (declared(decided), declared(before));
    let all = whole.faces.len();
    if objects < 2 || faces <= faces_before || (faces as f64) < MANY * all as f64 {
        return None;
    }
    Some(format!(
        "{objects} objects with {faces} of the model's {all} faces are declared see-through: mattes are looked for face by face \
         in every photo, at every pixel that shows one, so that finding them and filling take many times as long; and what is \
         behind can only be told from surfaces that stay solid; declare only objects that have gaps"
    ))
}

/// Returns true when one may see through an object: as was decided, else when it turns towards cameras.
pub fn sees_through(object: &str, turns: bool, decided: &SeeThroughDecisions) -> bool {
    decided.get(object).copied().unwrap_or(turns)
}

/// Returns the model in which one may see through impostors, and through what was decided.
pub fn with_see_through(model: Arc<Model>, decided: &SeeThroughDecisions, task: &Task) -> Arc<Model> {
    for name in decided.keys().filter(|name| model.object_named(name).is_none()) {
        task.note(format!(
            "project.json decides whether one sees through {name:?}, which the model does not have"
        ));
    }
    let sees_through = |object: &Object| sees_through(&object.name, object.impostor.is_some(), decided);
    if model.objects.iter().all(|object| sees_through(object) == object.see_through) {
        return model;
    }
    Arc::new(Model::clone(&model).with_see_through(sees_through))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use quadratura_base::scene::synthetic::Modeller;

    fn model() -> Arc<Model> {
        let mut m = Modeller::new();
        m.object("fence").quad(DVec3::ZERO, DVec3::X, DVec3::Z);
        m.object("wall").quad(DVec3::Y, DVec3::X, DVec3::Z);
        m.object("tree.billboard").quad(DVec3::ZERO, DVec3::X, DVec3::Z);
        let mut model = (*m.finish()).clone();
        model.objects[2].billboard = true;
        Arc::new(model)
    }

    #[test]
    fn that_a_large_part_of_the_model_is_declared_see_through_is_told_once() {
        let model = model();
        let decided = |names: &[&str]| -> SeeThroughDecisions {
            names.iter().map(|name| ((*name).to_owned(), true)).collect()
        };
        let (none, all) = (decided(&[]), decided(&["fence", "wall", "tree.billboard"]));
        let told = expected_work(&none, &all, &model).unwrap();
        assert!(told.starts_with("3 objects with 3 of the model's 3 faces"), "{told}");
        assert_eq!(expected_work(&all, &all, &model), None, "it was so before");
        assert_eq!(expected_work(&all, &decided(&["fence"]), &model), None, "they become fewer");
        let solid = SeeThroughDecisions::from([("tree.billboard".to_owned(), false)]);
        assert_eq!(expected_work(&none, &solid, &model), None);
    }

    fn seen_through(project: &Project) -> Vec<bool> {
        let turned = Model::clone(&model())
            .with_impostors(DVec3::Z, |object| impostors::turns(object, &project.impostors));
        let model = with_see_through(Arc::new(turned.0), &project.see_through, &Task::silent());
        model.objects.iter().map(|object| object.see_through).collect()
    }

    #[test]
    fn one_sees_through_impostors_and_what_was_declared_until_it_is_declared_solid() {
        let mut project = Project::default();
        assert_eq!(seen_through(&project), [false, false, true]);
        let decide = |project: &Project, edits: &[SeeThroughEdit]| edited(project, edits, &model(), &[]);
        let edits = [SeeThroughEdit::SeeThrough("fen*".into()), SeeThroughEdit::Solid("tree*".into())];
        project.see_through = decide(&project, &edits).unwrap();
        assert_eq!(seen_through(&project), [true, false, false]);
        let edits = [SeeThroughEdit::Solid("fence".into()), SeeThroughEdit::SeeThrough("tree*".into())];
        project.see_through = decide(&project, &edits).unwrap();
        assert_eq!(project.see_through, SeeThroughDecisions::new(), "as without decisions");
        let unknown = [SeeThroughEdit::Solid("gate".into()), SeeThroughEdit::SeeThrough("rail".into())];
        let error = decide(&project, &unknown).unwrap_err().to_string();
        assert!(error.contains("gate") && error.contains("rail"), "{error}");
        // A billboard that stays as it is modelled is solid until it is declared see-through.
        project.impostors.insert("tree.billboard".into(), false);
        assert_eq!(seen_through(&project), [false; 3]);
        project.see_through = decide(&project, &[SeeThroughEdit::SeeThrough("tree*".into())]).unwrap();
        assert_eq!(seen_through(&project), [false, false, true]);
    }
}
