//! Change detection for the files of a site: model, cameras, photos and masks, without reading them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_files::stamp::Stamp;
use quadratura_import::cameras::camera_files;
use quadratura_import::photo::PhotoFolder;
use quadratura_io::mask_store::MaskStore;
use quadratura_io::project::resolved;

/// The lengths and modification times of the files that a site was read from.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SiteStamp {
    model: Stamp,
    cameras: Stamp,
    photos: Stamp,
    /// The stamps of mask files; this program never changes these files.
    masks: BTreeMap<String, Stamp>,
}

impl SiteStamp {
    /// Takes the stamps of the files of the project in `folder`. Files that cannot be accessed count as empty.
    pub fn new(folder: &Path, project: &Project) -> Self {
        let together = |files: Vec<PathBuf>| {
            files
                .iter()
                .map(|file| Stamp::from_path(file))
                .fold(Stamp::default(), |all, stamp| all.and(stamp))
        };
        let store = MaskStore::new(folder);
        let mask = |file: &str| (file.to_owned(), Stamp::from_path(&store.path(file)));
        Self {
            model: together(model_files(&resolved(folder, &project.model))),
            cameras: together(camera_files(&resolved(folder, &project.cameras))),
            photos: together(photo_files(folder, &resolved(folder, &project.photos))),
            masks: project.masks.files().into_iter().map(mask).collect(),
        }
    }

    /// Returns the names of the parts that differ in `now`, for messages. Only masks that are in both are compared.
    pub fn changes(&self, now: &Self) -> Vec<&'static str> {
        let other_masks =
            self.masks.iter().any(|(file, stamp)| now.masks.get(file).is_some_and(|it| it != stamp));
        let parts = [
            ("the model", self.model != now.model),
            ("the cameras", self.cameras != now.cameras),
            ("photos", self.photos != now.photos),
            ("masks", other_masks),
        ];
        parts.into_iter().filter(|(_, is_other)| *is_other).map(|(part, _)| part).collect()
    }
}

/// Returns the model's files: a glTF file has its vertex data in files beside it.
fn model_files(model: &Path) -> Vec<PathBuf> {
    let has =
        |file: &Path, extension: &str| file.extension().is_some_and(|it| it.eq_ignore_ascii_case(extension));
    let mut files = vec![model.to_path_buf()];
    if has(model, "gltf") {
        let beside = model.parent().and_then(|folder| std::fs::read_dir(folder).ok()).into_iter().flatten();
        files.extend(beside.flatten().map(|entry| entry.path()).filter(|file| has(file, "bin")));
    }
    files.sort();
    files
}

/// Folders that this program writes to; a project may be inside the photo folder.
const OURS: [&str; 9] =
    ["stacks", "cache", "exports", "editing", "inbox", "layers", "pictures", "paint", "masks"];

/// Returns the photo files, without those that this program writes.
fn photo_files(project: &Path, photos: &Path) -> Vec<PathBuf> {
    let Ok(found) = PhotoFolder::scan(photos, &Task::silent()) else { return Vec::new() };
    let project = project.canonicalize().unwrap_or_else(|_| project.to_path_buf());
    let ours = OURS.map(|name| project.join(name));
    let is_ours = |file: &PathBuf| ours.iter().any(|folder| file.starts_with(folder));
    (0..found.len()).map(|file| found.path(file)).filter(|file| !is_ours(file)).collect()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use quadratura_document::masks::{Mask, MaskOrigin};

    #[test]
    fn whatever_of_a_site_is_changed_added_or_removed_is_named_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| {
            let file = folder.path().join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        };
        for name in ["site/a.gltf", "site/a.bin", "site/sparse/cameras.txt", "site/sparse/images.txt"] {
            put(name, "x");
        }
        put("site/photos/of/one.jpg", "x");
        put("masks/one.jpg/drawn-1.png", "x");
        let text = r#"{"version": 1, "photos": "site/photos", "cameras": "site", "model": "site/a.gltf"}"#;
        let mut project: Project = serde_json::from_str(text).unwrap();
        let mask = Mask { from: MaskOrigin::Drawn, file: "one.jpg/drawn-1.png".into(), pixels: 1 };
        project.masks.put("one.jpg", mask.clone());
        let stamp = |project: &Project| SiteStamp::new(folder.path(), project);
        let before = stamp(&project);
        let changes = |before: &SiteStamp| before.changes(&stamp(&project));
        assert!(changes(&before).is_empty());
        for ours in ["stacks/a.png", "project.json", "site/photos/notes.txt", "layers/b.psd"] {
            put(ours, "ours");
        }
        assert!(changes(&before).is_empty());
        put("site/a.bin", "another");
        assert_eq!(changes(&before), ["the model"]);
        put("site/sparse/points3D.txt", "more");
        put("site/photos/two.jpg", "more");
        assert_eq!(changes(&before), ["the model", "the cameras", "photos"]);
        let before = stamp(&project);
        fs::remove_file(folder.path().join("masks/one.jpg/drawn-1.png")).unwrap();
        assert_eq!(changes(&before), ["masks"]);
        // A project inside the photo folder writes pictures of its own.
        let within = Project { photos: ".".into(), ..project.clone() };
        let among = stamp(&within);
        put("stacks/b.png", "ours");
        assert!(among.changes(&stamp(&within)).is_empty());
        put("three.jpg", "theirs");
        assert_eq!(among.changes(&stamp(&within)), ["photos"]);
        // A new mask drawn in this program is not a change on disk.
        let mut drawn = project.clone();
        drawn.masks.put("one.jpg", Mask { file: "one.jpg/drawn-2.png".into(), ..mask });
        assert!(before.changes(&stamp(&drawn)).is_empty());
    }
}
