//! Files and folders chosen in system dialogs, each of which blocks a thread of its own.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};

use super::waker::Waker;
use crate::state::round_trip::dialogs::DialogPurpose;

/// A dialog that is open.
pub struct Choosing {
    wanted: DialogPurpose,
    receive: Receiver<Vec<PathBuf>>,
}

impl Choosing {
    /// Opens the dialog in `folder`; none where the system cannot start a thread for it.
    pub fn start(wanted: DialogPurpose, folder: &Path, waker: Waker) -> Option<Self> {
        let (send, receive) = channel();
        let dialog = rfd::FileDialog::new().set_directory(folder);
        let request = move || {
            // The receiver may be gone.
            let _ = send.send(asked(wanted, dialog));
            waker.wake();
        };
        std::thread::Builder::new().name("dialog".into()).spawn(request).ok()?;
        Some(Self { wanted, receive })
    }

    /// Returns the purpose and the chosen paths once the dialog is answered; no paths where it was cancelled.
    pub fn answer(&self) -> Option<(DialogPurpose, Vec<PathBuf>)> {
        self.receive.try_recv().ok().map(|chosen| (self.wanted, chosen))
    }
}

fn asked(wanted: DialogPurpose, dialog: rfd::FileDialog) -> Vec<PathBuf> {
    match wanted {
        DialogPurpose::Layered => dialog
            .set_title("Import edited files")
            .add_filter("Layered files", &quadratura_layered_files::format::extensions())
            .pick_files()
            .unwrap_or_default(),
        DialogPurpose::ExportFolder => {
            dialog.set_title("Export to this folder").pick_folder().into_iter().collect()
        }
        DialogPurpose::RenderFolder => {
            dialog.set_title("Render to this folder").pick_folder().into_iter().collect()
        }
        DialogPurpose::ImageFile => dialog
            .set_title("Export layered depth image")
            .add_filter("Layered depth images", &["ldi"])
            .save_file()
            .into_iter()
            .collect(),
        DialogPurpose::PageFolder => {
            dialog.set_title("Save the page to this folder").pick_folder().into_iter().collect()
        }
        DialogPurpose::OrthoFolder => {
            dialog.set_title("Save orthophotos to this folder").pick_folder().into_iter().collect()
        }
        DialogPurpose::PublishFolder => {
            dialog.set_title("Publish the page in this folder").pick_folder().into_iter().collect()
        }
        DialogPurpose::Program => {
            dialog.set_title("The image editor's program").pick_file().into_iter().collect()
        }
    }
}
