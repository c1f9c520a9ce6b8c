//! Objects of the model that are switched off: for a project they are as if they were not there.

use std::collections::BTreeSet;

use serde::Serialize;

use super::masks::object::objects_named;
use crate::error::{Error, Result};
use crate::scene::Model;

/// One change. Objects are named, or by the beginning of their names with `*` behind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ObjectEdit {
    /// They are not there.
    Off(String),
    /// They are there again.
    On(String),
}

/// The objects that are off after the edits, one after the other. `whole` is the model with all of them.
///
/// # Errors
/// [`Error::Request`] for names that the model does not have, all at once, and when nothing would be left.
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

fn apply(off: &mut BTreeSet<String>, edit: &ObjectEdit, whole: &Model) -> Result<()> {
    let names = |pattern: &str| {
        let objects = objects_named(whole, pattern)?;
        Ok(objects.into_iter().map(|id| whole.object(id).name.clone()).collect::<Vec<_>>())
    };
    match edit {
        ObjectEdit::Off(pattern) => off.extend(names(pattern)?),
        // What was decided about an object that has left the model may be taken back by its whole name.
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
    /// Its name.
    pub object: String,
    /// Its faces.
    pub faces: usize,
    /// A flat stand-in for foliage and the like.
    pub billboard: bool,
    /// It is switched off.
    pub off: bool,
}

/// The objects of the model with all of them, in its order.
pub fn listed(whole: &Model, off: &BTreeSet<String>) -> Vec<ListedObject> {
    let object = |object: &crate::scene::Object| ListedObject {
        object: object.name.clone(),
        faces: object.faces.len(),
        billboard: object.billboard,
        off: off.contains(&object.name),
    };
    whole.objects.iter().map(object).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::closed_form;

    #[test]
    fn objects_go_off_and_on_by_name_and_by_the_beginning_of_names() {
        let model = closed_form::two_quads().model;
        let name = model.objects[0].name.clone();
        let off = edited(&BTreeSet::new(), &[ObjectEdit::Off(name.clone())], &model).unwrap();
        assert_eq!(off.iter().collect::<Vec<_>>(), [&name]);
        assert_eq!(listed(&model, &off).iter().filter(|object| object.off).count(), 1);
        assert!(edited(&off, &[ObjectEdit::On("*".into())], &model).unwrap().is_empty());
        assert!(edited(&off, &[ObjectEdit::On(name)], &model).unwrap().is_empty());
    }

    #[test]
    fn strangers_are_told_all_at_once_and_something_must_be_left() {
        let model = closed_form::two_quads().model;
        let wrong = [ObjectEdit::Off("x".into()), ObjectEdit::On("y".into())];
        let told = edited(&BTreeSet::new(), &wrong, &model).unwrap_err().to_string();
        assert!(told.contains("\"x\"") && told.contains("\"y\""), "{told}");
        let told = edited(&BTreeSet::new(), &[ObjectEdit::Off("*".into())], &model).unwrap_err().to_string();
        assert!(told.contains("remove all objects"), "{told}");
        let gone = BTreeSet::from(["gone".to_owned()]);
        assert!(edited(&gone, &[ObjectEdit::On("gone".into())], &model).unwrap().is_empty());
    }
}
