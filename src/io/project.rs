//! Finds, reads, validates and writes `project.json`.

use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::Deserialize;

use quadratura_base::error::{Error, Remedy, Result};
use quadratura_document::project::PROJECT_VERSION;
use quadratura_document::{Bookmark, CameraPath, PlaceText, Project};
use quadratura_files::atomic::write_atomically;
use quadratura_files::json::{read_json, to_json};
use quadratura_files::lock::LOCK_FILE;
use quadratura_files::named_file::NamedFiles;

/// The name of the project's file in the project folder.
pub const PROJECT_FILE: &str = "project.json";
/// The name of the file beside it that holds unsaved changes.
pub const UNSAVED_FILE: &str = "project.unsaved.json";

const LARGEST_PROJECT: u64 = 16 << 20;
/// Returns the advice for a file that cannot be read. Nothing in it destroys data.
fn remedy(file: &Path) -> String {
    let unsaved = file.with_file_name(UNSAVED_FILE);
    let unsaved = match unsaved.is_file() && !file.ends_with(UNSAVED_FILE) {
        true => {
            format!("; {UNSAVED_FILE} beside it holds the whole project with the unsaved changes of a window")
        }
        false => String::new(),
    };
    format!(
        "correct it (docs/formats.md describes it), or restore it from a backup: layers, masks and paint are in \
        files of their own and not affected{unsaved}"
    )
}

/// Reads the project in `folder`.
///
/// # Errors
/// [`Error::Input`] when there is no project, when a newer program wrote it, or when a field is misspelt,
/// missing or out of range; [`Error::Io`].
pub fn read_project(folder: &Path) -> Result<Project> {
    let file = folder.join(PROJECT_FILE);
    if !file.is_file() {
        let found = "there is no project in this folder: the file does not exist";
        return Err(Error::input(
            file,
            "",
            found,
            ("give the folder that ", Remedy::CreateProject, " created"),
        ));
    }
    refuse_other_versions(&file)?;
    judged(&file, read_json(&file, LARGEST_PROJECT, remedy(&file))?)
}

/// Checks the values of a project that was read from `file`, and returns it if all are valid.
///
/// # Errors
/// [`Error::Input`] as for [`read_project`].
pub fn judged(file: &Path, project: Project) -> Result<Project> {
    refuse_version(file, project.version)?;
    let problems = [
        ("options", project.options.problem()),
        ("fill", project.fill.problem()),
        ("colour", project.colour.problem()),
        ("decisions", project.decisions.problem(&project.options)),
        ("views", project.views.iter().find_map(Bookmark::problem)),
        ("flight", project.flight.as_ref().and_then(CameraPath::problem)),
        ("masks", project.masks.problem()),
        ("texts", project.texts.iter().find_map(PlaceText::problem)),
        ("trees", project.trees.problem()),
    ];
    match problems.into_iter().find_map(|(place, problem)| Some((place, problem?))) {
        Some((place, problem)) => Err(Error::input(file, place, problem, remedy(file))),
        None => Ok(project),
    }
}

/// Serialises writers of `project.json` within this program: saving a decision and an import that adds masks
/// may happen at the same time.
static WRITING: Mutex<()> = Mutex::new(());

/// Writes the project into `folder`, whole or not at all.
///
/// # Errors
/// [`Error::Io`]; the old file stays.
pub fn write_project(folder: &Path, project: &Project) -> Result<()> {
    change_project(folder, |_| Ok(project.clone()))
}

/// Writes the project that `change` makes of the current one in `folder`, or of the error with which it was
/// read. No other thread of this program writes the file in between.
///
/// # Errors
/// The error of `change`; [`Error::Io`]. The old file stays.
pub fn change_project(folder: &Path, change: impl FnOnce(Result<Project>) -> Result<Project>) -> Result<()> {
    // A writer that panicked has left the file whole: it changes by one rename.
    let _writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    let project = change(read_project(folder))?;
    write_atomically(folder.join(PROJECT_FILE), &to_json(&project))
}

/// Refuses files of other versions. This is checked first, because a newer file may have fields that would
/// count as misspelt.
fn refuse_other_versions(file: &Path) -> Result<()> {
    #[derive(Deserialize)]
    struct Versioned {
        version: u32,
    }
    let Versioned { version } = read_json(file, LARGEST_PROJECT, remedy(file))?;
    refuse_version(file, version)
}

fn refuse_version(file: &Path, version: u32) -> Result<()> {
    if (1..=PROJECT_VERSION).contains(&version) {
        return Ok(());
    }
    if version == 0 {
        let found = format!("version 0, expected 1 to {PROJECT_VERSION}");
        return Err(Error::input(file, "version", found, "restore the version that the program wrote"));
    }
    let found = format!("version {version}; this program reads versions up to {PROJECT_VERSION}");
    Err(Error::input(file, "version", found, "open it with the newer program that wrote it"))
}

/// Checks that a new project may be created in `folder`: the folder does not exist, or holds nothing but a
/// lock file.
///
/// # Errors
/// [`Error::Request`] when the folder is not empty; [`Error::Io`].
pub fn check_is_empty(folder: &Path) -> Result<()> {
    let path = folder.display();
    if !folder.exists() {
        return Ok(());
    }
    if !folder.is_dir() {
        return Err(Error::Request(format!("{path}: this is a file; give a new folder for the project")));
    }
    for entry in std::fs::read_dir(folder).map_err(Error::io(folder, "read the folder"))? {
        let name = entry.map_err(Error::io(folder, "read the folder"))?.file_name();
        if name != LOCK_FILE {
            let name = name.display();
            return Err(Error::Request(format!(
                "{path}: the folder is not empty (it contains {name}); a new project needs a new or empty folder"
            )));
        }
    }
    Ok(())
}

/// Returns the absolute path of a path in `project.json`, without `..` and links where it exists. It may be spelled in another
/// Unicode form than on the disk.
pub fn resolved(folder: &Path, path: &str) -> PathBuf {
    let joined = folder.join(path);
    joined
        .canonicalize()
        .or_else(|_| NamedFiles::default().respelled(&joined).canonicalize())
        .unwrap_or(joined)
}

/// Returns a note about a path in `project.json` that is found in another Unicode form; `None` where it is as it is written there.
pub fn respelled(folder: &Path, path: &str) -> Option<String> {
    let joined = folder.join(path);
    let found = NamedFiles::default().respelled(&joined);
    (found != joined).then(|| {
        format!(
            "{PROJECT_FILE}: {path} is found under another Unicode form, as {}",
            resolved(folder, path).display()
        )
    })
}

/// Returns `target` as `project.json` stores it: relative to `folder`, with `/`. Both must exist.
///
/// # Errors
/// [`Error::Io`] when one does not exist; [`Error::Input`] when the path is not Unicode, which JSON cannot
/// hold.
pub fn relative_to(folder: &Path, target: &Path) -> Result<String> {
    let from = folder.canonicalize().map_err(Error::io(folder, "find it"))?;
    let to = target.canonicalize().map_err(Error::io(target, "find it"))?;
    let relative = relative_path(&from, &to).unwrap_or(to);
    let Some(text) = relative.to_str() else {
        return Err(Error::input(target, "", "its path is not Unicode", "rename it or the folder it is in"));
    };
    Ok(if cfg!(windows) { text.replace('\\', "/") } else { text.to_owned() })
}

/// Joins a path that is stored relative to the project folder to `folder`, and removes `..` and `.` from it
/// where possible.
pub fn below(folder: &Path, relative: &str) -> PathBuf {
    let mut path = PathBuf::new();
    for part in folder.join(relative).components() {
        match (part, path.components().next_back()) {
            (Component::ParentDir, Some(Component::Normal(_))) => drop(path.pop()),
            (Component::CurDir, _) => (),
            _ => path.push(part),
        }
    }
    path
}

/// Returns the path from one absolute path to another; `None` when they share no root.
fn relative_path(from: &Path, to: &Path) -> Option<PathBuf> {
    let same = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let shares_drive = |path: &Path| {
        let prefixes = path.components().filter(|c| matches!(c, Component::Prefix(_))).count();
        same > prefixes
    };
    if !shares_drive(from) {
        return None;
    }
    let up = from.components().skip(same).map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(to.components().skip(same)).collect();
    Some(if path.as_os_str().is_empty() { PathBuf::from(".") } else { path })
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::Similarity;
    use quadratura_base::scene::FaceIndex;
    use quadratura_document::PageDecisions;
    use quadratura_document::trees::{PlacedTree, PlantAxis, PlantSource, TreeSpecies, Trees};
    use quadratura_document::{ColourDecisions, Decisions, Masks, PhotoDecisions};
    use quadratura_layers::fill::FillOptions;
    use quadratura_layers::{Faces, Options};

    fn project() -> Project {
        Project {
            surroundings: None,
            frame: Default::default(),
            texts: vec![PlaceText {
                title: "The gate".into(),
                text: "It is shut.".into(),
                at: [1.0, -2.0, 0.5],
                link: Some("https://example.org".into()),
                view: None,
                language: Some("en".into()),
            }],
            page: PageDecisions { title: Some("The square".into()), ..PageDecisions::default() },
            version: PROJECT_VERSION,
            photos: "../site/images".into(),
            cameras: "../site/sparse".into(),
            model: "../site/castle.obj".into(),
            world_from_model: Similarity::IDENTITY,
            options: Options { margin: 4, ..Options::default() },
            chunk: None,
            rolling_shutter: false,
            fill: FillOptions { without: vec!["tractor".into()], ..FillOptions::default() },
            colour: ColourDecisions { reference: Some("0001.jpg".into()), ..ColourDecisions::default() },
            decisions: decisions(),
            views: Vec::new(),
            flight: Some(CameraPath::empty([64, 48])),
            masks: Masks::default(),
            objects_off: ["tractor.cab".to_owned()].into(),
            impostors: [("hedge".to_owned(), true)].into(),
            see_through: [("fence".to_owned(), true)].into(),
            trees: trees(),
        }
    }

    fn trees() -> Trees {
        let species =
            TreeSpecies { from: PlantSource::File("../elm.glb".into()), up: Some(PlantAxis::Y), unit: None };
        let tree = PlacedTree {
            name: "elm_1".into(),
            species: "elm".into(),
            at: [1.0, -2.0, 0.5],
            height: Some(9.0),
            width: None,
            turn: 30.0,
            tint: [0.5, 0.0, 0.0],
            replaces: ["elm_1.billboard".to_owned()].into(),
            casts: true,
        };
        Trees { species: [("elm".to_owned(), species)].into(), placed: vec![tree], ..Trees::default() }
    }

    fn decisions() -> Decisions {
        let mut decisions = Decisions::default();
        let exclude = vec![Faces { object: "tower".into(), faces: vec![FaceIndex(2), FaceIndex(3)] }];
        decisions.set("0001.jpg", PhotoDecisions { exclude, ..PhotoDecisions::default() });
        decisions
    }

    fn refused(text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(PROJECT_FILE), text).unwrap();
        read_project(folder.path()).unwrap_err().to_string()
    }

    #[test]
    fn a_project_comes_back_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        write_project(folder.path(), &project()).unwrap();
        assert_eq!(read_project(folder.path()).unwrap(), project());
    }

    #[test]
    fn changes_of_several_threads_are_all_there_in_the_end() {
        let folder = tempfile::tempdir().unwrap();
        write_project(folder.path(), &project()).unwrap();
        std::thread::scope(|scope| {
            for number in 0..8 {
                let folder = folder.path();
                scope.spawn(move || {
                    change_project(folder, |project| {
                        let mut project = project?;
                        project.objects_off.insert(format!("object {number}"));
                        Ok(project)
                    })
                });
            }
        });
        assert_eq!(read_project(folder.path()).unwrap().objects_off.len(), 1 + 8);
    }

    #[test]
    fn a_folder_without_a_project_is_refused_with_a_remedy() {
        let message = read_project(Path::new("no such folder")).unwrap_err().to_string();
        assert!(message.contains("no such folder") && message.contains("“create project”"), "{message}");
    }

    #[test]
    fn a_newer_project_is_refused_even_if_it_has_fields_that_we_do_not_know() {
        assert!(refused(r#"{"version": 0}"#).contains("expected 1"));
        let message = refused(r#"{"version": 99, "sky": []}"#);
        assert!(message.contains("version 99") && message.contains("newer"), "{message}");
    }

    #[test]
    fn broken_text_a_missing_field_and_an_option_out_of_range_are_named() {
        assert!(refused("{").contains("line 1 column 1"));
        assert!(!refused("{").contains("create project"), "nothing that destroys what is there");
        assert!(refused(r#"{"version": 1, "photos": "p", "cameras": "c"}"#).contains("`model`"));
        let text =
            r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m", "options": {"tolerance": 2}}"#;
        assert!(refused(text).contains("tolerance"));
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m",
            "colour": {"fixed": {"a.jpg": [0, 0, 99]}}}"#;
        assert!(refused(text).contains("colour: a.jpg is fixed"), "{}", refused(text));
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m",
            "decisions": {"a.jpg": {"merge": [[]]}}}"#;
        assert!(refused(text).contains("decisions: a.jpg: merge[0] names no object"), "{}", refused(text));
    }

    #[test]
    fn paths_are_relative_to_the_project() {
        let folder = tempfile::tempdir().unwrap();
        let [project, photos] = ["work/castle", "site/images"].map(|name| folder.path().join(name));
        [&project, &photos].iter().for_each(|path| std::fs::create_dir_all(path).unwrap());
        let path = relative_to(&project, &photos).unwrap();
        assert_eq!(path, "../../site/images");
        assert_eq!(relative_to(&project, &project).unwrap(), ".");
        assert!(resolved(&project, &path).is_dir());
    }

    #[test]
    fn paths_are_found_in_another_unicode_form_and_that_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let [project, photos] = ["site", "fotos_u\u{308}ber"].map(|name| folder.path().join(name));
        [&project, &photos].iter().for_each(|path| std::fs::create_dir_all(path).unwrap());
        assert_eq!(resolved(&project, "../fotos_\u{fc}ber"), photos.canonicalize().unwrap());
        let note = respelled(&project, "../fotos_\u{fc}ber").unwrap();
        assert!(note.contains("another Unicode form"), "{note}");
        assert_eq!(respelled(&project, "../fotos_u\u{308}ber"), None);
        assert_eq!(respelled(&project, "../nowhere"), None);
    }

    #[test]
    fn a_path_from_the_project_is_shown_without_a_detour() {
        let shown = |folder: &str, relative: &str| below(Path::new(folder), relative);
        assert_eq!(shown("work/castle", "../layers/a.psd"), Path::new("work/layers/a.psd"));
        assert_eq!(shown("castle", "../layers/a.psd"), Path::new("layers/a.psd"));
        assert_eq!(shown("castle", "../../a.psd"), Path::new("../a.psd"));
        assert_eq!(shown(".", "../a.psd"), Path::new("../a.psd"));
        assert_eq!(shown("castle", "/tmp/a.psd"), Path::new("/tmp/a.psd"));
    }

    #[test]
    fn a_folder_that_is_not_empty_is_refused_by_what_it_holds() {
        let folder = tempfile::tempdir().unwrap();
        let empty = folder.path().join("a/new/one");
        check_is_empty(&empty).unwrap();
        std::fs::create_dir_all(&empty).unwrap();
        std::fs::write(empty.join(LOCK_FILE), "").unwrap();
        check_is_empty(&empty).unwrap();
        let message = check_is_empty(folder.path()).unwrap_err().to_string();
        assert!(message.contains("not empty (it contains a)"), "{message}");
    }
}
