//! Files and folders chosen in system dialogs, each of which blocks a thread of its own.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};

use crate::app::state::State;
use crate::app::work::Work;
use crate::app::work::waker::Waker;

/// The purpose of a dialog.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DialogPurpose {
    /// Layered files to import.
    Layered,
    /// The folder of exports.
    ExportFolder,
    /// The program of an image editor.
    Program,
}

/// A dialog that is open.
pub struct Choosing {
    wanted: DialogPurpose,
    receive: Receiver<Vec<PathBuf>>,
}

impl Choosing {
    /// Opens the dialog in `folder`; none where the system cannot start a thread for it.
    fn start(wanted: DialogPurpose, folder: &Path, waker: Waker) -> Option<Self> {
        let (send, receive) = channel();
        let dialog = rfd::FileDialog::new().set_directory(folder);
        let ask = move || {
            // The receiver may be gone.
            let _ = send.send(asked(wanted, dialog));
            waker.wake();
        };
        std::thread::Builder::new().name("dialog".into()).spawn(ask).ok()?;
        Some(Self { wanted, receive })
    }
}

fn asked(wanted: DialogPurpose, dialog: rfd::FileDialog) -> Vec<PathBuf> {
    match wanted {
        DialogPurpose::Layered => dialog
            .set_title("Import edited files")
            .add_filter("Layered files", &crate::io::layered::format::extensions())
            .pick_files()
            .unwrap_or_default(),
        DialogPurpose::ExportFolder => {
            dialog.set_title("Export to this folder").pick_folder().into_iter().collect()
        }
        DialogPurpose::Program => {
            dialog.set_title("The image editor's program").pick_file().into_iter().collect()
        }
    }
}

/// Opens a system dialog.
pub fn choose_path(state: &mut State, work: &mut Work, wanted: DialogPurpose) {
    let folder = state.session.as_ref().map(|session| session.folder.clone()).unwrap_or_default();
    work.choosing = Choosing::start(wanted, &folder, work.waker.clone());
}

/// Handles the answer of the system dialog.
pub fn take_chosen_files(state: &mut State, work: &mut Work) {
    let Some(choosing) = &work.choosing else { return };
    let Ok(chosen) = choosing.receive.try_recv() else { return };
    let wanted = choosing.wanted;
    work.choosing = None;
    let Some(first) = chosen.first() else { return };
    let text = first.display().to_string();
    match wanted {
        DialogPurpose::Layered => {
            if let Some(dialog) = &mut state.round_trip.import {
                dialog.paths = chosen.iter().map(|path| path.display().to_string()).collect();
            }
        }
        DialogPurpose::ExportFolder => {
            if let Some(dialog) = &mut state.round_trip.export {
                dialog.folder = text;
            }
        }
        DialogPurpose::Program => state.settings.image_editor.program = text,
    }
}
