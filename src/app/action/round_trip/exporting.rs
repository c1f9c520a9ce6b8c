//! Exports started by the user.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_base::error::Error;
use quadratura_base::scene::{Photo, PhotoId};
use quadratura_document::Project;
use quadratura_editing::export::{ExportOptions, TreesInSite, export, write_provenance};
use quadratura_exports::handover::baked::BakedOptions;
use quadratura_exports::handover::{HandoverFormat, HandoverOptions, hand_over};
use quadratura_gpu::start_device;
use quadratura_io::programs::open_with_system;
use quadratura_sites::budget::default_memory;
use quadratura_views::colour::even_factors;

/// Shows a folder in the system's file manager.
pub fn show_folder_of(state: &mut State, folder: &Path) {
    if let Err(error) = open_with_system(folder) {
        let said = |error: Error| format!("{} could not be shown: {error}", folder.display());
        state.notify(Note::new(Weight::Warning, said(error)));
    }
}

/// Exports with the options of the dialog.
pub fn export_chosen(state: &mut State, work: &mut Work) {
    let (Some(dialog), Some(session)) = (state.round_trip.dialogs.export.clone(), &state.session) else {
        return;
    };
    let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
    let project = session.history.present().clone();
    let out = folder.join(dialog.folder.trim());
    let chosen = |id: &PhotoId| match dialog.photos.is_empty() {
        true => session.stack_of(*id).is_some(),
        false => dialog.photos.contains(id),
    };
    if let Some(format) = dialog.program {
        let udim = dialog.tiles && format.has_tiles();
        return hand_over_chosen(state, work, (format, udim), dialog.photos, out);
    }
    let chosen: Vec<PhotoId> = opened.site.photo_ids().filter(chosen).collect();
    let stacks = work.live.stacks.clone();
    work.jobs.start(&mut state.running, JobKind::Export, "Exporting", move |task| {
        // Files of layers that are being updated are read when they are complete.
        let written = stacks.take();
        let photos: Vec<&Photo> = chosen.iter().map(|id| opened.site.photo(*id)).collect();
        let evened = match dialog.even {
            true => even_factors(&folder, &opened.project, &opened.site, task)?,
            false => BTreeMap::new(),
        };
        let options = ExportOptions {
            format: dialog.format,
            guides: dialog.guides,
            trees: TreesInSite::new(&project.trees, &opened.project, &opened.site),
            evened,
            decisions: Some(project.decisions.clone()),
            ..ExportOptions::default()
        };
        let exported = export(&folder, &photos, &out, &options, task)?;
        if dialog.provenance {
            write_provenance(&folder, &photos, &project.decisions, &out, task)?;
        }
        drop((lock, written));
        Ok(arrival(move |state| state.exported(&exported, out)))
    });
}

/// How many photos a face gets in Blender at most, as on the command line.
const PHOTOS_PER_FACE: usize = 8;

/// Exports the site for another program to a folder, with these photos, or with all where there are none. With the format comes whether
/// its textures are tiles.
fn hand_over_chosen(
    state: &mut State,
    work: &mut Work,
    (format, udim): (HandoverFormat, bool),
    photos: BTreeSet<PhotoId>,
    out: PathBuf,
) {
    let Some(session) = &state.session else { return };
    let (folder, lock) = (session.folder.clone(), session.lock.clone());
    let opened = session.opened.with_project(&folder, Project::clone(session.history.present()));
    let stacks = work.live.stacks.clone();
    work.jobs.start(&mut state.running, JobKind::Export, "Exporting", move |task| {
        let written = stacks.take();
        let is_chosen = |id: &PhotoId| photos.is_empty() || photos.contains(id);
        let chosen = opened.site.photo_ids().filter(is_chosen);
        let photos: Vec<&Photo> = chosen.map(|id| opened.site.photo(id)).collect();
        let memory = default_memory();
        let options = HandoverOptions {
            format,
            photos_per_face: PHOTOS_PER_FACE,
            baked: BakedOptions { memory, udim, ..BakedOptions::default() },
            world: false,
            memory,
        };
        let handed = hand_over(&folder, &opened, &photos, &out, &options, &start_device, task)?;
        drop((lock, written));
        Ok(arrival(move |state| state.handed_over(&handed, out)))
    });
}
