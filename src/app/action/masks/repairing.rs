//! Masks that cannot be used: files are missing, damaged, or of another size. The message offers remedies, each a step
//! of the history.

use std::path::PathBuf;
use std::time::SystemTime;

use crate::state::State;
use crate::state::masking::origin_words;
use crate::state::notes::{Note, NoteRemedy, Weight, ago};
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_base::scene::{Photo, Site};
use quadratura_document::Project;
use quadratura_document::masks::{Mask, MaskChange};
use quadratura_io::mask_file::read_mask;
use quadratura_io::mask_store::MaskStore;
use quadratura_sites::open::UnusableMask;

impl State {
    /// Replaces a mask by another one, or removes it, as a step of the history.
    pub fn set_mask(&mut self, MaskChange { photo, from, after, .. }: &MaskChange) {
        let Some(session) = &self.session else { return };
        let mut project = Project::clone(session.history.present());
        project.masks.set(photo, from, after.clone());
        let what = if after.is_some() { "replacement of a mask" } else { "removal of a mask" };
        self.edit(format!("{what} of {photo}"), project, None);
    }

    /// Reports where the mask's file belongs, where no dialog is available.
    pub fn tell_place_of_mask(&mut self, it: &UnusableMask) {
        let Some(session) = &self.session else { return };
        let position = MaskStore::new(&session.folder).path(&it.mask.file);
        let text = format!(
            "This desktop has no file dialog: save the mask as {}, then choose “Reload from disk” (F5)",
            position.display()
        );
        self.notify(Note::about(Weight::Warning, &it.photo.name, text));
    }
}

/// Reports the parts of the site that could not be read; for masks, with remedies.
pub fn tell_problems(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let opened = session.opened.clone();
    let of_masks: Vec<String> = opened.problems.unmasked.iter().map(|it| it.error().to_string()).collect();
    let others = opened.problems.errors.iter().map(ToString::to_string);
    for problem in others.filter(|problem| !of_masks.contains(problem)) {
        state.notes.add(Note::new(Weight::Problem, problem));
    }
    tell_masks(state, work, opened.problems.unmasked.to_vec(), "is left out");
}

/// Reports masks that cannot be used, with the consequence `therefore` and remedies.
pub fn tell_masks(state: &mut State, work: &mut Work, unusable: Vec<UnusableMask>, therefore: &'static str) {
    let Some(session) = state.session.as_ref().filter(|_| !unusable.is_empty()) else { return };
    let folder = session.folder.clone();
    work.jobs.start(&mut state.running, JobKind::Look, "Finding previous masks", move |_| {
        let store = MaskStore::new(&folder);
        let note = |it: UnusableMask| {
            let size = [it.photo.camera.width, it.photo.camera.height];
            let older = store.older(&it.photo.name, it.mask.from.stem(), &it.mask.file, size);
            note_of(it, therefore, older)
        };
        let notes: Vec<Note> = unusable.into_iter().map(note).collect();
        Ok(arrival(move |state| {
            if state.session.as_ref().is_some_and(|session| session.folder == folder) {
                notes.into_iter().for_each(|note| state.notify(note));
            }
        }))
    });
}

/// Uses a file as the mask.
pub fn bring_mask(state: &mut State, work: &mut Work, it: UnusableMask, path: PathBuf) {
    let Some(session) = &state.session else { return };
    let (folder, lock) = (session.folder.clone(), session.lock.clone());
    work.jobs.start(&mut state.running, JobKind::Mask, "Saving a mask", move |_| {
        let size = [it.photo.camera.width, it.photo.camera.height];
        let masked = read_mask(&path, size)?;
        let file = MaskStore::new(&folder).add(&it.photo.name, it.mask.from.stem(), &masked, size)?;
        drop(lock);
        let UnusableMask { photo, mask, .. } = it;
        let after = Mask { from: mask.from.clone(), file, pixels: masked.count() };
        let change = changed(&photo, mask, Some(after));
        Ok(arrival(move |state| {
            if state.session.as_ref().is_some_and(|session| session.folder == folder) {
                state.set_mask(&change);
            }
        }))
    });
}

/// Returns the damaged masks of these photos: damage is only found by decoding a mask completely.
pub fn damaged_masks<'a>(
    project: &Project,
    site: &Site,
    photos: impl Iterator<Item = &'a String>,
) -> Vec<UnusableMask> {
    let photos = photos.filter_map(|name| site.photos.iter().find(|photo| photo.name == *name));
    let masks_of = |photo: &'_ Photo| {
        let size = [photo.camera.width, photo.camera.height];
        let masks = project.masks.of(&photo.name).iter().zip(&photo.masks);
        let damaged = masks.filter_map(|(mask, file)| {
            let problem = read_mask(file, size).err()?.to_string();
            Some(UnusableMask { photo: photo.clone(), mask: mask.clone(), problem })
        });
        damaged.collect::<Vec<_>>()
    };
    photos.flat_map(masks_of).collect()
}

fn note_of(it: UnusableMask, therefore: &str, older: Option<(String, u64, SystemTime)>) -> Note {
    let words = origin_words(&it.mask.from);
    let text = format!("{therefore}: its mask, {words}, cannot be used: {}.", it.problem);
    let note = Note::about(Weight::Problem, &it.photo.name, text);
    let away = changed(&it.photo, it.mask.clone(), None);
    let mut note = note.with("Remove this mask", NoteRemedy::SetMask(Box::new(away)));
    if let Some((file, pixels, made)) = older {
        let mask = Mask { from: it.mask.from.clone(), file, pixels };
        let when = made.elapsed().map(ago).unwrap_or_default();
        let back = changed(&it.photo, it.mask.clone(), Some(mask));
        note = note.with(format!("Restore the version of {when}"), NoteRemedy::SetMask(Box::new(back)));
    }
    note.with("Choose a file…", NoteRemedy::ChooseMask(Box::new(it)))
}

fn changed(photo: &Photo, before: Mask, after: Option<Mask>) -> MaskChange {
    MaskChange { photo: photo.name.clone(), from: before.from.clone(), before: Some(before), after }
}
