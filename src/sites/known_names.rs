//! Names of photos and objects as the project knows them: cameras and a model that come back from another system may have them in
//! another Unicode form.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde_json::Value;

use quadratura_base::error::Result;
use quadratura_base::scene::Model;
use quadratura_base::scene::alike::nfc;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_import::cameras::{CameraOptions, Cameras, read_cameras_as};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::project::resolved;

/// Gives objects the names that the project and its paint have for them, where these differ in Unicode form alone. Returns a note
/// about them.
pub(super) fn as_known(folder: &Path, project: &Project, model: &mut Model) -> Option<String> {
    respelled(
        folder,
        project,
        "objects have their names",
        model.objects.iter_mut().map(|object| &mut object.name),
    )
}

/// Reads the cameras of a project. Photos have the names that the project and its paint have for them, where these differ in
/// Unicode form alone, which is noted.
///
/// # Errors
/// Returns the errors of [`read_cameras_as`].
pub fn cameras_of(folder: &Path, project: &Project, task: &Task) -> Result<Cameras> {
    let (photos, file) = (resolved(folder, &project.photos), resolved(folder, &project.cameras));
    let options = CameraOptions { chunk: project.chunk.clone(), rolling_shutter: project.rolling_shutter };
    let mut cameras = read_cameras_as(&photos, &file, &options, task)?;
    let names = cameras.photos.iter_mut().map(|photo| &mut photo.name);
    cameras.notes.extend(respelled(folder, project, "photos have their names in the cameras", names));
    Ok(cameras)
}

/// Gives things their known names; `have` are the words for them in the note.
fn respelled<'a>(
    folder: &Path,
    project: &Project,
    have: &str,
    names: impl Iterator<Item = &'a mut String>,
) -> Option<String> {
    let mut names: Vec<&mut String> = names.collect();
    if names.iter().all(|name| name.is_ascii()) {
        return None;
    }
    let paint = PaintStore::new(folder).read().unwrap_or_default();
    let mut texts = BTreeSet::new();
    // Whatever names a photo or an object is a text in one of the two.
    for value in [serde_json::to_value(project), serde_json::to_value(&paint)].into_iter().flatten() {
        texts_in(&value, &mut texts);
    }
    let own: BTreeSet<String> = names.iter().map(|name| (*name).clone()).collect();
    let mut forms: BTreeMap<String, Vec<&String>> = BTreeMap::new();
    for text in texts.iter().filter(|text| !own.contains(*text)) {
        forms.entry(nfc(text).into_owned()).or_default().push(text);
    }
    let (mut first, mut count) = (None, 0);
    for name in names.iter_mut().filter(|name| !texts.contains(**name)) {
        if let Some([known]) = forms.remove(&*nfc(name)).as_deref() {
            name.clone_from(known);
            first = first.or(Some(*known));
            count += 1;
        }
    }
    first.map(|first| {
        format!(
            "{count} {have} in another Unicode form than project.json; they are the same, such as {first:?}"
        )
    })
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
    use quadratura_base::scene::ModelBuilder;
    use quadratura_document::masks::{Mask, MaskOrigin};

    #[test]
    fn a_masked_photo_keeps_its_mask_when_the_cameras_have_its_name_in_another_form() {
        let folder = tempfile::tempdir().unwrap();
        let mut names = ["mu\u{308}r.jpg", "a.jpg", "to\u{302}t.jpg"].map(str::to_owned);
        let mut project = Project::default();
        project.masks.put("m\u{fc}r.jpg", Mask::unread(MaskOrigin::Drawn));
        let note = respelled(folder.path(), &project, "photos are", names.iter_mut()).unwrap();
        assert_eq!(names, ["m\u{fc}r.jpg", "a.jpg", "to\u{302}t.jpg"]);
        assert!(note.starts_with("1 photos are"), "{note}");
    }

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
