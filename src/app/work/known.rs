//! The file that all windows share: recent projects, and those whose updates are paused.

use std::path::PathBuf;
use std::time::SystemTime;

use quadratura_base::error::Result;
use quadratura_io::known_projects::{KnownProjects, change_known, read_known};

/// The time between two looks at what other windows have written, in seconds: shorter than the way to a menu.
const LOOKS_EVERY_S: f64 = 1.0;

/// The shared file, and when it was looked at.
#[derive(Default)]
pub struct KnownFile {
    /// The file; none where settings are not stored.
    file: Option<PathBuf>,
    looked_s: Option<f64>,
    written: Option<SystemTime>,
}

impl KnownFile {
    /// Uses this file.
    pub fn new(file: PathBuf) -> Self {
        Self { file: Some(file), ..Self::default() }
    }

    /// Returns whether no window has written the file yet.
    pub fn is_missing(&self) -> bool {
        self.file.as_ref().is_some_and(|file| !file.exists())
    }

    /// Returns what the file says where another window has changed it since the last look.
    pub fn news(&mut self, now_s: f64) -> Option<KnownProjects> {
        let file = self.file.as_ref()?;
        if self.looked_s.is_some_and(|looked_s| now_s - looked_s < LOOKS_EVERY_S) {
            return None;
        }
        self.looked_s = Some(now_s);
        let written = file.metadata().and_then(|data| data.modified()).ok();
        let is_new = written.is_some() && written != self.written;
        self.written = written;
        is_new.then(|| read_known(file))
    }

    /// Changes what is known, in the file where there is one.
    ///
    /// # Errors
    /// [`quadratura_base::error::Error::Io`] when the file cannot be written; this window knows the change all the same.
    pub fn change(&self, known: &mut KnownProjects, change: impl Fn(&mut KnownProjects)) -> Result<()> {
        change(known);
        if let Some(file) = &self.file {
            *known = change_known(file, change)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn what_one_window_writes_another_one_reads_once() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("projects.json");
        let (one, mut other) = (KnownFile::new(file.clone()), KnownFile::new(file));
        assert!(one.is_missing() && other.news(0.0).is_none());
        one.change(&mut KnownProjects::default(), |known| known.remember(Path::new("no-such-project")))
            .unwrap();
        assert!(other.news(0.5).is_none(), "it looks once a second");
        assert_eq!(other.news(1.5).unwrap().recent, [PathBuf::from("no-such-project")]);
        assert!(other.news(3.0).is_none());
    }
}
