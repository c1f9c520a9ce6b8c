//! The system dialog for files and folders of projects, on a thread of its own.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use super::waker::Waker;
use crate::state::opening::{PathKind, Purpose};
use quadratura_import::cameras::extensions;
use quadratura_sites::discover::SitePart;

/// A dialog that answers faster than a user could click was never shown.
const NEVER_SEEN: Duration = Duration::from_millis(400);

/// The file dialog that is open.
#[derive(Default)]
pub struct Chooser {
    waiting: Option<(Purpose, Instant, Receiver<Option<PathBuf>>)>,
}

/// The answer of a file dialog.
#[derive(Debug, Clone, PartialEq)]
pub enum FileDialogAnswer {
    /// The user chose this path.
    Path(PathBuf),
    /// The user closed the dialog.
    Nothing,
    /// The system shows no dialogs.
    NoDialog,
}

impl Chooser {
    /// Opens a file dialog.
    pub fn choose(&mut self, purpose: Purpose, waker: Waker) {
        let (send, receive) = channel();
        let asked = purpose.clone();
        // The dialog blocks until the user answers, so it has a thread of its own.
        let request = move || {
            let _ = send.send(request(&asked));
            waker.wake();
        };
        if std::thread::Builder::new().name("dialog".into()).spawn(request).is_ok() {
            self.waiting = Some((purpose, Instant::now(), receive));
        }
    }

    /// Takes the answer of the file dialog, once the user has given it.
    pub fn take(&mut self) -> Option<(Purpose, FileDialogAnswer)> {
        let (_, since, receive) = self.waiting.as_ref()?;
        let at_once = since.elapsed() < NEVER_SEEN;
        let answer = match receive.try_recv() {
            Ok(Some(path)) => FileDialogAnswer::Path(path),
            Ok(None) | Err(TryRecvError::Disconnected) if at_once => FileDialogAnswer::NoDialog,
            Ok(None) | Err(TryRecvError::Disconnected) => FileDialogAnswer::Nothing,
            Err(TryRecvError::Empty) => return None,
        };
        self.waiting.take().map(|(purpose, ..)| (purpose, answer))
    }
}

/// Shows a dialog and waits for the user.
fn request(purpose: &Purpose) -> Option<PathBuf> {
    let dialog = rfd::FileDialog::new().set_title(purpose.title());
    match purpose {
        Purpose::Part(SitePart::Model, PathKind::File) => {
            dialog.add_filter("Models", &["obj", "gltf", "glb"]).pick_file()
        }
        // Cameras of any name are recognised by their content.
        Purpose::Part(SitePart::Cameras, PathKind::File) => {
            dialog.add_filter("Cameras", &extensions()).add_filter("All files", &["*"]).pick_file()
        }
        Purpose::Part(SitePart::Photos, PathKind::File) | Purpose::Photo(_) => dialog.pick_file(),
        Purpose::Mask(_) => dialog.add_filter("Masks", &["png"]).pick_file(),
        Purpose::Part(_, PathKind::Folder)
        | Purpose::Project
        | Purpose::Site
        | Purpose::Folder
        | Purpose::Copy
        | Purpose::Sample => dialog.pick_folder(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a chooser whose dialog was opened this long ago, and the other end of it.
    fn waiting(ago: Duration) -> (Chooser, std::sync::mpsc::Sender<Option<PathBuf>>) {
        let (send, receive) = channel();
        let since = Instant::now().checked_sub(ago).unwrap();
        (Chooser { waiting: Some((Purpose::Folder, since, receive)) }, send)
    }

    #[test]
    fn a_path_that_was_chosen_is_taken_once() {
        let (mut chooser, send) = waiting(NEVER_SEEN);
        assert_eq!(chooser.take(), None);
        send.send(Some("site".into())).unwrap();
        assert_eq!(chooser.take(), Some((Purpose::Folder, FileDialogAnswer::Path("site".into()))));
        assert_eq!(chooser.take(), None);
    }

    #[test]
    fn a_dialog_that_is_gone_at_once_was_never_shown_and_a_later_one_was_closed() {
        let (mut chooser, send) = waiting(2 * NEVER_SEEN);
        send.send(None).unwrap();
        assert_eq!(chooser.take(), Some((Purpose::Folder, FileDialogAnswer::Nothing)));
        let (mut chooser, send) = waiting(Duration::ZERO);
        drop(send);
        assert_eq!(chooser.take(), Some((Purpose::Folder, FileDialogAnswer::NoDialog)));
    }
}
