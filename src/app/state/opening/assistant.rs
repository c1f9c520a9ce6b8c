//! The assistant for new projects: typed paths and detected contents.

use std::path::{Path, PathBuf};

use super::place::PathField;
use quadratura_base::error::Error;
use quadratura_io::project::check_is_empty;
use quadratura_sites::discover::{Candidates, SitePart, SiteParts, folder_beside};

/// The state of the assistant.
#[derive(Debug, Default, Clone)]
pub struct Assistant {
    /// The site folder that is searched.
    pub root: String,
    /// The error of the search.
    pub root_error: Option<String>,
    /// Whether the search of the site folder stopped at its limit.
    pub cut_short: bool,
    /// The paths of photos, cameras and model, in the order of [`SitePart::ALL`].
    pub places: [PathField; 3],
    /// The project folder.
    pub folder: PathField,
    /// Whether the user chose the project folder: it is not replaced by a suggestion any more.
    folder_is_theirs: bool,
    /// The project folder that was checked last, and the reason why the project cannot be created there.
    judged: (PathBuf, Option<String>),
}

impl Assistant {
    /// Returns the parts as typed.
    pub fn parts(&self) -> SiteParts {
        let [photos, cameras, model] = [0, 1, 2].map(|part: usize| self.places[part].path());
        SiteParts { photos, cameras, model }
    }

    /// Sets the project folder that the user chose.
    pub fn goes_to(&mut self, folder: &Path) {
        self.folder.set(folder);
        self.folder_is_theirs = true;
    }

    /// Marks the project folder as typed by the user.
    pub fn folder_typed(&mut self) {
        self.folder.errors.clear();
        self.folder_is_theirs = true;
    }

    /// Checks whether the project can be created in its folder, once for each folder.
    pub fn judge_folder(&mut self) {
        let folder = self.folder.path();
        if folder != self.judged.0 {
            let refused = check_is_empty(&folder).err().map(|error| error.to_string());
            self.judged = (folder, refused);
        }
    }

    /// Returns the reason why the project cannot be created in its folder.
    pub fn objection(&self) -> Option<&str> {
        match self.judged.0.as_os_str().is_empty() {
            true => Some("Enter a new or empty folder."),
            false => self.judged.1.as_deref(),
        }
    }

    /// Removes what a search found, because the folder of the site is another one now. What the user typed or chose
    /// stays.
    pub fn forget_found(&mut self) {
        for place in &mut self.places {
            let is_found = place.offered.iter().any(|offered| *offered == place.path());
            if is_found {
                *place = PathField::default();
            }
            place.offered.clear();
            place.searched = false;
        }
        if !self.folder_is_theirs {
            self.folder = PathField::default();
        }
    }

    /// Fills in the detected parts; parts that were not found are empty, unless the user typed or chose them.
    pub fn take(&mut self, root: &Path, candidates: Candidates) {
        self.forget_found();
        self.cut_short = candidates.cut_short;
        for part in SitePart::ALL {
            let found = candidates.of(part);
            self.places[part as usize].searched = true;
            if let Some(best) = found.first() {
                self.places[part as usize].set(best);
                self.places[part as usize].offered = found.to_vec();
            }
        }
        if !self.folder_is_theirs {
            self.folder.set(&folder_beside(root));
        }
    }

    /// Shows each error beside the path that it is about.
    pub fn refuse(&mut self, parts: &SiteParts, error: &Error) {
        let errors = match error {
            Error::Several(errors) => errors.as_slice(),
            error => std::slice::from_ref(error),
        };
        let of = |wanted: Option<SitePart>| {
            let errors: Vec<&Error> =
                errors.iter().filter(|error| parts.part_of_error(error) == wanted).collect();
            Error::gathered(&errors).into_iter().map(|message| message.to_string())
        };
        for part in SitePart::ALL {
            self.places[part as usize].errors.extend(of(Some(part)));
        }
        self.folder.errors.extend(of(None));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_stand_at_the_part_that_they_speak_of_and_the_rest_at_the_folder() {
        let parts =
            SiteParts { photos: "s/images".into(), cameras: "s/sparse".into(), model: "s/a.obj".into() };
        let errors = Error::Several(vec![
            Error::input("s/a.obj", "line 3", "no faces", "export them"),
            Error::input("s/images/1.jpg", "", "too small", "give the right one"),
            Error::Request("the folder is not empty".into()),
        ]);
        let mut assistant = Assistant::default();
        assistant.refuse(&parts, &errors);
        let counts = assistant.places.each_ref().map(|place| place.errors.len());
        assert_eq!((counts, assistant.folder.errors.len()), ([1, 0, 1], 1));
        assert!(assistant.places[2].errors[0].contains("line 3: no faces; export them"));
    }

    #[test]
    fn many_photos_of_the_wrong_size_are_one_line() {
        let parts =
            SiteParts { photos: "s/images".into(), cameras: "s/sparse".into(), model: "s/a.obj".into() };
        let photo =
            |number| Error::input(format!("s/images/{number}.jpg"), "", "too small", "give the right one");
        let mut assistant = Assistant::default();
        assistant.refuse(&parts, &Error::Several((0..19).map(photo).collect()));
        let [line] = &assistant.places[SitePart::Photos as usize].errors[..] else { panic!() };
        assert!(
            line.starts_with("19 files in s/images: too small") && line.contains("0.jpg, 1.jpg and 17 more"),
            "{line}"
        );
    }

    #[test]
    fn a_second_search_keeps_what_it_did_not_find_and_the_folder_that_was_chosen() {
        let mut assistant = Assistant::default();
        assistant.places[2].set(Path::new("mine.obj"));
        assistant.goes_to(Path::new("here"));
        let candidates = Candidates { photos: vec!["a".into(), "b".into()], ..Candidates::default() };
        assistant.take(Path::new("root"), candidates);
        assert_eq!(
            assistant.parts(),
            SiteParts { photos: "a".into(), cameras: "".into(), model: "mine.obj".into() }
        );
        assert_eq!((assistant.folder.typed.as_str(), assistant.places[0].offered.len()), ("here", 2));
    }

    #[test]
    fn what_was_found_in_another_folder_goes_and_what_was_chosen_stays() {
        let mut assistant = Assistant::default();
        let found = Candidates { photos: vec!["a".into()], ..Candidates::default() };
        assistant.take(Path::new("one"), found);
        assistant.places[SitePart::Model as usize].set(Path::new("mine.obj"));
        assert!(!assistant.folder.typed.is_empty());
        assistant.forget_found();
        let typed = assistant.places.each_ref().map(|place| place.typed.clone());
        assert_eq!(typed, ["", "", "mine.obj"]);
        assert!(assistant.folder.typed.is_empty(), "it was suggested beside the other folder");
        assistant.take(Path::new("two"), Candidates::default());
        let photos = &assistant.places[SitePart::Photos as usize];
        assert!(photos.searched && photos.typed.is_empty(), "it is said that none were found");
    }
}
