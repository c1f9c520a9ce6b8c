//! A project as commands see it: on disk, where other programs may change it between two photos.

use std::any::Any;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::turns::UpdateSource;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_files::lock::refuse_open_in_window;
use quadratura_io::project::read_project;
use quadratura_sites::open::{Opened, open_site};
use quadratura_sites::site_stamp::SiteStamp;

/// A project on disk, read again whenever its file or the files of its site have changed.
pub struct ProjectOnDisk {
    folder: PathBuf,
    known: Mutex<Option<(Arc<Opened>, SiteStamp)>>,
}

impl ProjectOnDisk {
    /// Returns the source of updates of the project in `folder`; nothing is read yet.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_path_buf(), known: Mutex::default() }
    }
}

impl UpdateSource for ProjectOnDisk {
    /// Each photo has a lock of its own, and what is authored may change at any time: what was made of an older state is made
    /// again. A window updates its project itself.
    fn right(&self, _: &Task) -> Result<Box<dyn Any>> {
        refuse_open_in_window(&self.folder)?;
        Ok(Box::new(()))
    }

    fn project(&self, task: &Task) -> Result<Arc<Opened>> {
        // A half-finished reading is not kept, so this is valid after a panic elsewhere.
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let project = read_project(&self.folder)?;
        // The stamp is taken before reading, so that changes during reading are noticed.
        let stamp = SiteStamp::new(&self.folder, &project);
        if let Some((opened, seen)) = &*known
            && opened.project == project
            && *seen == stamp
        {
            return Ok(opened.clone());
        }
        let opened = Arc::new(open_site(&self.folder, project, task)?);
        *known = Some((opened.clone(), stamp));
        Ok(opened)
    }
}
