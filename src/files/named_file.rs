//! Files by names that may be spelled differently on the disk ([`alike`]).

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use quadratura_base::scene::alike::{self, Alike};

/// What was found for a name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NamedFile {
    /// No file has the name.
    Missing,
    /// The file's path below the folder, with `/`.
    Found(String),
    /// Files that are equally like it, likewise.
    Several(Vec<String>),
}

/// Looks up files; each folder is listed once.
#[derive(Debug, Default)]
pub struct NamedFiles {
    listed: BTreeMap<PathBuf, Vec<String>>,
}

impl NamedFiles {
    /// Finds the file of a name, which may lead through folders, below `root`.
    pub fn find(&mut self, root: &Path, name: &str) -> NamedFile {
        if root.join(name).is_file() {
            return NamedFile::Found(name.to_owned());
        }
        let name = alike::composed(name);
        let mut path = String::new();
        for part in name.split('/').filter(|part| !matches!(*part, "" | ".")) {
            let join = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}/{name}") };
            let exact = join(part);
            if root.join(&exact).exists() {
                path = exact;
                continue;
            }
            let names = self.names_in(&root.join(&path));
            match alike::find(part, names) {
                Alike::None => return NamedFile::Missing,
                Alike::One(index) => path = join(&names[index]),
                Alike::Several(all) => {
                    return NamedFile::Several(all.into_iter().map(|index| join(&names[index])).collect());
                }
            }
        }
        if root.join(&path).is_file() { NamedFile::Found(path) } else { NamedFile::Missing }
    }

    /// Returns the path of a file under its own name, where there is one that is meant.
    pub fn path(&mut self, file: &Path) -> Option<PathBuf> {
        let root = file.ancestors().skip(1).find(|folder| folder.is_dir()).unwrap_or(Path::new(""));
        match self.find(root, file.strip_prefix(root).ok()?.to_str()?) {
            NamedFile::Found(name) => Some(root.join(name)),
            NamedFile::Missing | NamedFile::Several(_) => None,
        }
    }

    /// Returns the file that a path from `root` means; the path itself where there is none.
    pub fn path_below(&mut self, root: &Path, path: &Path) -> PathBuf {
        match path.to_str().filter(|_| path.is_relative()).map(|path| self.find(root, path)) {
            Some(NamedFile::Found(path)) => root.join(path),
            _ => root.join(path),
        }
    }

    /// Returns the files whose names differ from that of `file`, a path below `root`, in Unicode form alone.
    pub fn look_alikes(&mut self, root: &Path, file: &str) -> Vec<String> {
        let (folder, name) = file.rsplit_once('/').map_or(("", file), |(folder, name)| (folder, name));
        let below =
            |other: &String| if folder.is_empty() { other.clone() } else { format!("{folder}/{other}") };
        let key = alike::composed(name);
        let names = self.names_in(&root.join(folder)).iter();
        names.filter(|other| *other != name && alike::composed(other) == key).map(below).collect()
    }

    /// Returns the path of a file or folder under the name that it has on the disk, where its own is another Unicode form of that;
    /// the path itself where there is none.
    pub fn respelled(&mut self, path: &Path) -> PathBuf {
        let mut found = PathBuf::new();
        for part in path.components() {
            let exact = found.join(part);
            let (Component::Normal(name), false) = (part, exact.exists()) else {
                found = exact;
                continue;
            };
            let same = name.to_str().map(alike::composed).and_then(|name| {
                let mut names = self.names_in(&found).iter().filter(|other| alike::composed(other) == name);
                names.next().filter(|_| names.next().is_none()).cloned()
            });
            match same {
                Some(same) => found.push(same),
                None => return path.to_path_buf(),
            }
        }
        found
    }

    fn names_in(&mut self, folder: &Path) -> &[String] {
        self.listed.entry(folder.to_path_buf()).or_insert_with(|| {
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
            let mut names: Vec<String> =
                entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
            names.sort_unstable();
            names
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_found_in_another_unicode_form_and_look_alikes_of_a_file_are_listed() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        std::fs::create_dir_all(root.join("Pla\u{308}ne/Ost")).unwrap();
        for name in ["Pla\u{308}ne/\u{e9}.png", "Pla\u{308}ne/e\u{301}.png"] {
            std::fs::write(root.join(name), "").unwrap();
        }
        let mut named = NamedFiles::default();
        let there = root.join("Pla\u{308}ne/Ost");
        assert_eq!(named.respelled(&root.join("Pl\u{e4}ne/x/../Ost")), root.join("Pl\u{e4}ne/x/../Ost"));
        assert_eq!(named.respelled(&root.join("Pl\u{e4}ne/Ost")), there);
        assert_eq!(named.respelled(&there), there);
        assert_eq!(named.respelled(&root.join("pl\u{e4}ne")), root.join("pl\u{e4}ne"), "another letter case");
        assert_eq!(named.look_alikes(root, "Pla\u{308}ne/\u{e9}.png"), ["Pla\u{308}ne/e\u{301}.png"]);
    }

    #[test]
    fn a_file_is_found_under_any_spelling_of_its_path_and_none_is_guessed_among_several() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let found = |name: &str| NamedFiles::default().find(root, name);
        std::fs::create_dir(root.join("Co\u{302}te\u{301}")).unwrap();
        for name in ["Co\u{302}te\u{301}/a.PNG", "b.bin", "x.Jpg", "x.jPg"] {
            std::fs::write(root.join(name), "").unwrap();
        }
        let there = NamedFile::Found("Co\u{302}te\u{301}/a.PNG".into());
        assert_eq!(found("C\u{f4}t\u{e9}\\a.png"), there);
        assert_eq!(found(".\\b.bin"), NamedFile::Found("b.bin".into()));
        assert_eq!(found("x.Jpg"), NamedFile::Found("x.Jpg".into()));
        assert_eq!(found("x.jpg"), NamedFile::Several(vec!["x.Jpg".into(), "x.jPg".into()]));
        assert_eq!(found("c.bin"), NamedFile::Missing);
        assert_eq!(found("C\u{f4}t\u{e9}"), NamedFile::Missing, "a folder is no file");
        assert_eq!(
            NamedFiles::default().find(&root.join("Co\u{302}te\u{301}"), "../B.BIN"),
            NamedFile::Found("../b.bin".into())
        );
    }
}
