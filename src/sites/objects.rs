//! Objects of the model that are removed in a project, as if they did not exist.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::impostors::{RefusedImpostors, turns};
use crate::named::objects_named;
use crate::see_through::sees_through;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Model, Object};
use quadratura_document::masks::{MaskOrigin, MaskedObject};
use quadratura_document::{Masks, Project};
use quadratura_layers::fill::options::matches_pattern;

/// A removal or its reversal. Objects are given by name, or by a pattern in which `*` stands for any
/// characters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ObjectEdit {
    /// Removes the objects from the model.
    Off(String),
    /// Restores the objects.
    On(String),
}

/// Returns the removed objects after the edits, applied in order. `whole` is the model with all objects.
///
/// # Errors
/// Returns [`Error::Request`] for names that the model does not have, all of them together, and when no object
/// would remain.
pub fn edited(off: &BTreeSet<String>, edits: &[ObjectEdit], whole: &Model) -> Result<BTreeSet<String>> {
    let mut edited = off.clone();
    let errors = edits.iter().filter_map(|edit| apply(&mut edited, edit, whole).err()).collect();
    if let Some(error) = Error::of_all(errors) {
        return Err(error);
    }
    if whole.objects.iter().all(|object| edited.contains(&object.name)) {
        return Err(Error::Request("this would remove all objects from the model".into()));
    }
    Ok(edited)
}

/// Applies one edit.
fn apply(off: &mut BTreeSet<String>, edit: &ObjectEdit, whole: &Model) -> Result<()> {
    let names = |pattern: &str| {
        let objects = objects_named(whole, pattern)?;
        Ok(objects.into_iter().map(|id| whole.object(id).name.clone()).collect::<Vec<_>>())
    };
    match edit {
        ObjectEdit::Off(pattern) => off.extend(names(pattern)?),
        // The model may no longer have an object that was removed; its full name restores it nevertheless.
        ObjectEdit::On(name) if off.remove(name) => (),
        ObjectEdit::On(pattern) => {
            let on = names(pattern)?;
            off.retain(|name| !on.contains(name));
        }
    }
    Ok(())
}

/// An object as it is listed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ListedObject {
    /// The object's name.
    pub object: String,
    /// The number of its faces.
    pub faces: usize,
    /// Whether it is a billboard.
    pub billboard: bool,
    /// Whether it turns towards cameras: as billboards do, or as was decided.
    pub turns: bool,
    /// Why it does not turn although its name or a decision says so; left out where it turns, and where nothing says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cannot_turn: Option<String>,
    /// Whether one may see through it in places: as through what turns, or as was decided.
    pub see_through: bool,
    /// Whether it is removed.
    pub off: bool,
}

impl ListedObject {
    /// Returns what the object is other than solid and fixed, in words; empty where it is nothing else.
    pub fn nature(&self) -> String {
        let how = match (&self.cannot_turn, self.turns) {
            (Some(reason), _) => format!("cannot turn: {reason}"),
            (None, true) => "turns".to_owned(),
            (None, false) if self.billboard => "stays as it is modelled".to_owned(),
            (None, false) => String::new(),
        };
        let matter = if self.see_through { "see-through" } else { "solid" };
        let name = if self.billboard { "billboard" } else { "" };
        // What turns is see-through unless something else was decided.
        let matter = if self.see_through == self.turns { "" } else { matter };
        let parts = [name, &how, matter].into_iter().filter(|part| !part.is_empty());
        parts.collect::<Vec<_>>().join(", ")
    }
}

/// Returns all objects of the complete model, in its order, as the project has them; `refused` are those that cannot turn.
pub fn listed(whole: &Model, project: &Project, refused: &RefusedImpostors) -> Vec<ListedObject> {
    whole.objects.iter().map(|object| listed_object(object, project, refused)).collect()
}

/// Returns one object of the complete model as it is listed.
pub fn listed_object(object: &Object, project: &Project, refused: &RefusedImpostors) -> ListedObject {
    let refused = refused.get(&object.name);
    let turns = refused.is_none() && turns(object, &project.impostors);
    ListedObject {
        object: object.name.clone(),
        faces: object.faces.len(),
        billboard: object.billboard,
        turns,
        cannot_turn: refused.map(ToString::to_string),
        see_through: sees_through(&object.name, turns, &project.see_through),
        off: project.objects_off.contains(&object.name),
    }
}

/// Returns the object masks that cover some of these objects: the names that they were made for, each with the number of
/// photos that have one.
pub fn masks_of(masks: &Masks, objects: &[&str]) -> BTreeMap<String, usize> {
    let mut found = BTreeMap::new();
    for mask in masks.photos().flat_map(|(_, masks)| masks) {
        let MaskOrigin::Object(MaskedObject { name, .. }) = &mask.from else { continue };
        if objects.iter().any(|object| matches_pattern(object, name)) {
            *found.entry(name.clone()).or_default() += 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::impostors::refused;
    use quadratura_base::scene::synthetic::Modeller;
    use quadratura_document::masks::Mask;

    #[test]
    fn the_masks_of_an_object_are_those_of_its_name_and_of_beginnings_of_it() {
        let mut masks = Masks::default();
        let mut put = |photo: &str, from| masks.put(photo, Mask { from, file: "f.png".into(), pixels: 3 });
        let object = |name: &str| MaskOrigin::Object(MaskedObject { name: name.into(), margin: 2 });
        put("a.jpg", object("tree*"));
        put("b.jpg", object("tree*"));
        put("b.jpg", object("tree 2"));
        put("b.jpg", object("tre"));
        put("b.jpg", MaskOrigin::Suggested);
        let of = |objects: &[&str]| masks_of(&masks, objects).into_iter().collect::<Vec<_>>();
        assert_eq!(of(&["tree 1"]), [("tree*".to_owned(), 2)]);
        assert_eq!(of(&["tree 2"]), [("tree 2".to_owned(), 1), ("tree*".to_owned(), 2)]);
        assert!(of(&["tower"]).is_empty() && of(&[]).is_empty());
    }
    use quadratura_base::scene::synthetic::closed_form;

    #[test]
    fn objects_go_off_and_on_by_name_and_by_the_beginning_of_names() {
        let model = closed_form::two_quads().model;
        let name = model.objects[0].name.clone();
        let off = edited(&BTreeSet::new(), &[ObjectEdit::Off(name.clone())], &model).unwrap();
        assert_eq!(off.iter().collect::<Vec<_>>(), [&name]);
        let project = Project { objects_off: off.clone(), ..Project::default() };
        let listed = listed(&model, &project, &RefusedImpostors::new());
        assert_eq!(listed.iter().filter(|object| object.off).count(), 1);
        assert!(edited(&off, &[ObjectEdit::On("*".into())], &model).unwrap().is_empty());
        assert!(edited(&off, &[ObjectEdit::On(name)], &model).unwrap().is_empty());
    }

    #[test]
    fn an_object_that_cannot_turn_is_listed_with_the_reason_and_is_solid() {
        let mut m = Modeller::new();
        m.object("ground").quad(DVec3::ZERO, DVec3::X, DVec3::Y);
        m.object("tree").quad(DVec3::ZERO, DVec3::X, DVec3::Z);
        m.object("wall").quad(DVec3::Y, DVec3::X, DVec3::Z);
        let model = m.finish();
        let impostors = [("ground".to_owned(), true), ("tree".to_owned(), true)].into();
        let project = Project { impostors, ..Project::default() };
        let refused = refused(&model, DVec3::Z, &project.world_from_model, &project.impostors);
        let listed = listed(&model, &project, &refused);
        let natures: Vec<String> = listed.iter().map(ListedObject::nature).collect();
        assert_eq!(natures, ["cannot turn: it has no height: it lies on the ground", "turns", ""]);
        let facts: Vec<_> = listed.iter().map(|it| (it.turns, it.see_through)).collect();
        assert_eq!(facts, [(false, false), (true, true), (false, false)]);
        // A decision about what one sees through holds for it as for any other object.
        let project = Project { see_through: [("ground".to_owned(), true)].into(), ..project };
        let ground = listed_object(&model.objects[0], &project, &refused);
        assert!(ground.nature().ends_with("ground, see-through"), "{}", ground.nature());
    }

    #[test]
    fn strangers_are_told_all_at_once_and_something_must_be_left() {
        let model = closed_form::two_quads().model;
        let wrong = [ObjectEdit::Off("x".into()), ObjectEdit::On("y".into())];
        let message = edited(&BTreeSet::new(), &wrong, &model).unwrap_err().to_string();
        assert!(message.contains("\"x\"") && message.contains("\"y\""), "{message}");
        let message =
            edited(&BTreeSet::new(), &[ObjectEdit::Off("*".into())], &model).unwrap_err().to_string();
        assert!(message.contains("remove all objects"), "{message}");
        let gone = BTreeSet::from(["gone".to_owned()]);
        assert!(edited(&gone, &[ObjectEdit::On("gone".into())], &model).unwrap().is_empty());
    }
}
