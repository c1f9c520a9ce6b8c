//! Names of objects as the project knows them: a model that comes back from another system may have them in another Unicode form.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde_json::Value;

use crate::document::Project;
use crate::io::paint_store::PaintStore;
use crate::scene::Model;
use crate::scene::alike::nfc;

/// Gives objects the names that the project and its paint have for them, where these differ in Unicode form alone. Returns a note
/// about them.
pub(super) fn as_known(folder: &Path, project: &Project, model: &mut Model) -> Option<String> {
    if model.objects.iter().all(|object| object.name.is_ascii()) {
        return None;
    }
    let paint = PaintStore::new(folder).read().unwrap_or_default();
    let mut texts = BTreeSet::new();
    // Whatever names an object is a text in one of the two.
    for value in [serde_json::to_value(project), serde_json::to_value(&paint)].into_iter().flatten() {
        texts_in(&value, &mut texts);
    }
    let own: BTreeSet<String> = model.objects.iter().map(|object| object.name.clone()).collect();
    let mut forms: BTreeMap<String, Vec<&String>> = BTreeMap::new();
    for text in texts.iter().filter(|text| !own.contains(*text)) {
        forms.entry(nfc(text).into_owned()).or_default().push(text);
    }
    let mut renamed = Vec::new();
    for object in model.objects.iter_mut().filter(|object| !texts.contains(&object.name)) {
        if let Some([known]) = forms.remove(&*nfc(&object.name)).as_deref() {
            object.name.clone_from(known);
            renamed.push(object.name.as_str());
        }
    }
    let first = renamed.first()?;
    Some(format!(
        "{} objects have their names in another Unicode form than project.json; they are the same, such as {first:?}",
        renamed.len()
    ))
}

fn texts_in(value: &Value, texts: &mut BTreeSet<String>) {
    match value {
        Value::String(text) => drop(texts.insert(text.clone())),
        Value::Array(items) => items.iter().for_each(|item| texts_in(item, texts)),
        Value::Object(fields) => fields.iter().for_each(|(key, field)| {
            texts.insert(key.clone());
            texts_in(field, texts);
        }),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ModelBuilder;
    use crate::task::Task;

    #[test]
    fn a_decided_object_keeps_its_decision_in_another_unicode_form() {
        let folder = tempfile::tempdir().unwrap();
        let mut builder = ModelBuilder::new();
        let names = ["mur", "che\u{302}ne", "porte_e\u{301}", "fene\u{302}tre", "fen\u{ea}tre"];
        for name in names {
            builder.object(name);
        }
        let (mut model, _) = builder.finish(&Task::silent()).unwrap();
        let off = ["ch\u{ea}ne", "fen\u{ea}tre"].map(str::to_owned);
        let project = Project { objects_off: BTreeSet::from(off), ..Project::default() };
        let note = as_known(folder.path(), &project, &mut model).unwrap();
        assert!(note.starts_with("1 objects") && note.contains("ch\u{ea}ne"), "{note}");
        let now: Vec<&str> = model.objects.iter().map(|object| object.name.as_str()).collect();
        assert_eq!(now, ["mur", "ch\u{ea}ne", "porte_e\u{301}", "fene\u{302}tre", "fen\u{ea}tre"]);
        assert_eq!(as_known(folder.path(), &project, &mut model), None);
    }
}
