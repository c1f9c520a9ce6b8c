//! Files that documents in memory name. Whoever replaces a document deletes the files that only the former one names,
//! but not while a reader of this program still has that one: then the next writer deletes them.
//!
//! A document gets its hold ([`FilesInUse`]) while it is read, under [`reading`]; files are judged and deleted under
//! [`replacing`]. So no reader has a document whose files are deleted before it holds them.

use std::any::Any;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard, Weak};

use quadratura_document::FilesInUse;

/// The holds, of which some have ended.
static HELD: Mutex<Vec<Weak<dyn Any + Send + Sync>>> = Mutex::new(Vec::new());
static REPLACING: RwLock<()> = RwLock::new(());

/// Lets nobody replace documents until the returned value is dropped.
pub(super) fn reading() -> RwLockReadGuard<'static, ()> {
    REPLACING.read().unwrap_or_else(PoisonError::into_inner)
}

/// Lets nobody read documents until the returned value is dropped.
pub(super) fn replacing() -> RwLockWriteGuard<'static, ()> {
    REPLACING.write().unwrap_or_else(PoisonError::into_inner)
}

/// Holds these files or folders.
pub(super) fn hold(paths: impl IntoIterator<Item = PathBuf>) -> FilesInUse {
    let paths: BTreeSet<PathBuf> = paths.into_iter().collect();
    let held: Arc<dyn Any + Send + Sync> = Arc::new(paths);
    let mut all = holds();
    all.retain(|hold| hold.strong_count() > 0);
    all.push(Arc::downgrade(&held));
    FilesInUse::new(held)
}

/// Returns whether a document in memory names `path`, other than those with one of the holds `but`.
pub(super) fn is_held(path: &Path, but: &[&FilesInUse]) -> bool {
    let others: Vec<_> = holds().iter().filter_map(Weak::upgrade).collect();
    let others = others.iter().filter(|held| !but.iter().any(|but| but.is_that_of(held)));
    others.filter_map(|held| held.downcast_ref::<BTreeSet<PathBuf>>()).any(|paths| paths.contains(path))
}

/// Returns the folder by the one name under which its files are held.
pub(super) fn one_name(folder: &Path) -> PathBuf {
    fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf())
}

fn holds() -> MutexGuard<'static, Vec<Weak<dyn Any + Send + Sync>>> {
    // The list is valid after a panic elsewhere.
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_held_as_long_as_a_copy_of_a_document_names_it() {
        let path = PathBuf::from("a_file_is_held/1.png");
        let document = hold([path.clone()]);
        let copy = document.clone();
        drop(document);
        assert!(is_held(&path, &[]) && !is_held(&path, &[&copy]), "its own copies do not count");
        let other = hold([path.clone()]);
        assert!(is_held(&path, &[&copy]), "another reader has it");
        drop((copy, other));
        assert!(!is_held(&path, &[]));
    }
}
