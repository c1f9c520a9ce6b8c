//! Exports started by the user.

use std::collections::BTreeMap;
use std::path::Path;

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_base::error::Error;
use quadratura_base::scene::{Photo, PhotoId};
use quadratura_io::programs::open_with_system;
use quadratura_recipe::colour::even_factors;
use quadratura_recipe::export::{ExportOptions, TreesInSite, export, write_provenance};

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
