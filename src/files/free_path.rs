//! Names for files and folders that are written for good: what a user or another program made is never overwritten.

use std::path::{Path, PathBuf};

/// A name that is free.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FreePath {
    /// The name.
    pub path: PathBuf,
    /// What has the asked name or one before this, and was kept.
    pub spared: Vec<PathBuf>,
}

/// Returns the first of `NAME.ext`, `NAME-2.ext`, `NAME-3.ext` and so on where nothing is, or what may be replaced.
pub fn free_path(asked: &Path, may_be_replaced: impl Fn(&Path) -> bool) -> FreePath {
    let stem = asked.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let extension =
        asked.extension().map_or(String::new(), |extension| format!(".{}", extension.to_string_lossy()));
    let mut spared = Vec::new();
    let mut path = asked.to_path_buf();
    for number in 2u64.. {
        if path.symlink_metadata().is_err() || may_be_replaced(&path) {
            break;
        }
        let next = asked.with_file_name(format!("{stem}-{number}{extension}"));
        spared.push(std::mem::replace(&mut path, next));
    }
    FreePath { path, spared }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_is_kept_unless_it_may_be_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        assert_eq!(free_path(&at("a.ply"), |_| false), FreePath { path: at("a.ply"), spared: Vec::new() });
        std::fs::write(at("a.ply"), "theirs").unwrap();
        std::fs::write(at("a-2.ply"), "ours").unwrap();
        let free = free_path(&at("a.ply"), |path| path.ends_with("a-2.ply"));
        assert_eq!(free, FreePath { path: at("a-2.ply"), spared: vec![at("a.ply")] });
        let free = free_path(&at("a.ply"), |_| false);
        assert_eq!((free.path, free.spared.len()), (at("a-3.ply"), 2));
        std::fs::create_dir(at("layers")).unwrap();
        assert_eq!(free_path(&at("layers"), |_| false).path, at("layers-2"));
    }
}
