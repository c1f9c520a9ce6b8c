//! Writes the mask edits that wait: one after the other, each a step of the history.

use std::path::{Path, PathBuf};

use crate::state::State;
use crate::state::masking::keeping::{MaskWork, Waiting};
use crate::state::notes::{Note, Weight};
use crate::state::request::{MaskRequest, Request};
use crate::state::running::JobKind;
use crate::work::Work;
use quadratura_base::error::Result;
use quadratura_base::geometry::Spans;
use quadratura_base::scene::{Site, up};
use quadratura_base::task::Task;
use quadratura_document::{Masks, Project};
use quadratura_io::mask_store::MaskStore;
use quadratura_sites::masks::{MaskEdit, edited};
use quadratura_sites::named::index_of_photo;
use quadratura_sites::open::whole_model;
use quadratura_stacks::masks::object::{ObjectMasks, from_object};
use quadratura_trees::mask::tree_masks;
use quadratura_trees::{PlantParts, SiteTrees, site_trees};

/// The result of a change: the masks, and the pixels of the new ones.
struct EditedMasks {
    masks: Masks,
    read: Vec<(String, Spans)>,
}

impl State {
    fn mask_kept(&mut self, folder: &PathBuf, base: &Masks, made: Result<EditedMasks>) -> Vec<Request> {
        let Some(session) = self.session.as_ref().filter(|session| session.folder == *folder) else {
            return Vec::new();
        };
        self.masking.keeping.working = None;
        let present = session.history.present().clone();
        // Where the masks have changed in the meantime, the change is computed again from the current masks.
        if present.masks == *base
            && let Some(waiting) = self.masking.keeping.queue.pop_front()
        {
            match made {
                Ok(EditedMasks { masks, .. }) if masks == *base => {
                    self.masking.cache.revision += 1;
                    let nothing = match waiting.work {
                        MaskWork::Object { photo, object, .. } => {
                            format!("{photo} shows no part of {object} that is not masked already")
                        }
                        MaskWork::Trees { .. } => "the real trees are masked already".into(),
                        MaskWork::Edits(_) => return vec![MaskRequest::WriteNext.into()],
                    };
                    self.notify(Note::new(Weight::Info, nothing));
                }
                Ok(EditedMasks { masks, read }) => {
                    self.masking.cache.add(read, &masks);
                    self.edit(waiting.name, Project { masks, ..Project::clone(&present) }, None);
                }
                Err(error) => {
                    self.masking.cache.revision += 1;
                    self.notify(Note::new(Weight::Problem, format!("The mask was not saved: {error}")));
                }
            }
        }
        vec![MaskRequest::WriteNext.into()]
    }
}

/// Queues a change of masks as a step of the history; `name` is the text for undo.
pub fn queue_mask(state: &mut State, work: &mut Work, name: String, change: MaskWork) {
    state.masking.keeping.queue.push_back(Waiting { name, work: change });
    state.masking.cache.revision += 1;
    keep_masks(state, work);
}

/// Continues with the queue. A job that failed has reported its error, and its change is dropped.
pub fn keep_masks(state: &mut State, work: &mut Work) {
    if let Some(job) = state.masking.keeping.working {
        if state.running.is_running(job) {
            return;
        }
        state.masking.keeping.working = None;
        state.masking.keeping.queue.pop_front();
        state.masking.cache.revision += 1;
    }
    let (Some(session), Some(waiting)) = (&state.session, state.masking.keeping.queue.front()) else {
        return;
    };
    let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
    let (base, change) = (session.history.present().masks.clone(), waiting.work.clone());
    let name = match change {
        MaskWork::Trees { .. } => "Masking real trees",
        MaskWork::Edits(_) | MaskWork::Object { .. } => "Saving a mask",
    };
    let job = work.jobs.start(&mut state.running, JobKind::Mask, name, move |task| {
        let made = kept(&folder, &opened.project, &opened.site, &base, &change, task);
        drop(lock);
        Ok(Box::new(move |state| state.mask_kept(&folder, &base, made)))
    });
    state.masking.keeping.working = Some(job);
}

/// Writes the new masks, and reads all masks back.
fn kept(
    folder: &Path,
    project: &Project,
    site: &Site,
    base: &Masks,
    work: &MaskWork,
    task: &Task,
) -> Result<EditedMasks> {
    let masks = match work {
        MaskWork::Edits(edits) => edited(folder, base, edits, site)?,
        MaskWork::Object { photo, object, margin_px } => {
            let edit = object_edit(folder, project, site, photo, object, *margin_px, task)?;
            edited(folder, base, &[edit], site)?
        }
        MaskWork::Trees { margin_px } => {
            edited(folder, base, &tree_edits(folder, project, site, *margin_px, task)?, site)?
        }
    };
    let (store, before) = (MaskStore::new(folder), base.files());
    let mut read = Vec::new();
    for photo in &site.photos {
        let size = [photo.camera.width, photo.camera.height];
        for mask in masks.of(&photo.name).iter().filter(|mask| !before.contains(mask.file.as_str())) {
            read.push((mask.file.clone(), store.read(&mask.file, size)?));
        }
    }
    Ok(EditedMasks { masks, read })
}

/// Returns the edits for all trees in all photos; trees that cannot be shown are noted.
fn tree_edits(
    folder: &Path,
    project: &Project,
    site: &Site,
    margin_px: u32,
    task: &Task,
) -> Result<Vec<MaskEdit>> {
    let photos: Vec<_> = site.photos.iter().collect();
    let made = site_trees(folder, &project.trees, up(&site.photos), PlantParts::Geometry, task)?;
    let Some(SiteTrees { placed, problems }) = made else { return Ok(Vec::new()) };
    problems.into_iter().for_each(|problem| task.note(problem));
    let names: Vec<String> = project.trees.placed.iter().map(|tree| tree.name.clone()).collect();
    tree_masks(project, site, &photos, &placed, &names, margin_px, task)
}

/// Returns the edit for an object of the whole model: an excluded object can be masked, too.
fn object_edit(
    folder: &Path,
    project: &Project,
    site: &Site,
    photo: &str,
    object: &str,
    margin_px: u32,
    task: &Task,
) -> Result<MaskEdit> {
    let model = whole_model(folder, project, task)?;
    let photo = site.photo(index_of_photo(site, photo)?);
    let mut masks = ObjectMasks::new(folder, project, site, model, &[object.to_owned()], task)?;
    let masked = masks.pixels(photo, object, margin_px)?;
    Ok(MaskEdit::Put { photo: photo.name.clone(), from: from_object(object, margin_px), masked })
}
