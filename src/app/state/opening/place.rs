//! A path that is typed, chosen or suggested.

use std::path::{Path, PathBuf};

/// A typed path, with alternatives.
#[derive(Debug, Default, Clone)]
pub struct PathField {
    /// The path as typed.
    pub typed: String,
    /// The alternatives, the likeliest first.
    pub offered: Vec<PathBuf>,
    /// Whether a search has been made for it.
    pub searched: bool,
    /// The errors of using it.
    pub errors: Vec<String>,
}

impl PathField {
    /// Sets the path.
    pub fn set(&mut self, path: &Path) {
        self.typed = path.display().to_string();
        self.errors.clear();
    }

    /// Returns the path; empty when nothing is typed.
    pub fn path(&self) -> PathBuf {
        typed_path(&self.typed)
    }
}

/// Parses a path as it is typed or pasted: with quotes, as a file URL, relative to the home folder.
pub fn typed_path(typed: &str) -> PathBuf {
    let text = typed.trim().trim_matches(['"', '\'']);
    let text = text.strip_prefix("file://").unwrap_or(text);
    match (text.strip_prefix("~/"), std::env::home_dir()) {
        (Some(below), Some(home)) => home.join(below),
        _ => PathBuf::from(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_understood_as_people_paste_them() {
        assert_eq!(typed_path(" \"a b/c\" "), Path::new("a b/c"));
        assert_eq!(typed_path("file:///a/b"), Path::new("/a/b"));
        assert_eq!(typed_path(""), Path::new(""));
        assert!(std::env::home_dir().is_none_or(|home| typed_path("~/site") == home.join("site")));
    }
}
