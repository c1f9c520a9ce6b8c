//! The dialog that publishes the site as a web page: what the page says, the photos that leave the house, and where it is written.

use std::collections::BTreeSet;
use std::path::PathBuf;

use quadratura_base::scene::PhotoId;
use quadratura_document::{PageDecisions, PlaceText, Project};
use quadratura_exports::page::{MOST_SIDE, PageOptions, published_size};

/// The folder of a page unless another one is given.
const PAGE: &str = "page";
/// Choices of the longest side of published photos, in pixels.
pub const SIDES: [u32; 4] = [MOST_SIDE, 3072, 2048, 1024];

/// A text at a place, as it is being typed; empty lines for what it has not.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TypedText {
    /// The title.
    pub title: String,
    /// The text.
    pub text: String,
    /// The place, as points are written on the command line.
    pub at: String,
    /// Where more is to be read.
    pub link: String,
    /// The bookmark from which one looks at it.
    pub view: String,
    /// The language.
    pub language: String,
}

impl TypedText {
    fn new(text: &PlaceText) -> Self {
        Self {
            title: text.title.clone(),
            text: text.text.clone(),
            at: text.at.map(|value| value.to_string()).join(","),
            link: text.link.clone().unwrap_or_default(),
            view: text.view.clone().unwrap_or_default(),
            language: text.language.clone().unwrap_or_default(),
        }
    }

    /// Returns the text at a position in the cameras' world.
    pub fn placed(&self, at: [f64; 3]) -> PlaceText {
        PlaceText {
            title: self.title.trim().to_owned(),
            text: self.text.clone(),
            at,
            link: said(&self.link),
            view: said(&self.view),
            language: said(&self.language),
        }
    }
}

/// A photo, as it would be published.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OfferedPhoto {
    /// The photo.
    pub id: PhotoId,
    /// Its name.
    pub name: String,
    /// The size of its picture, in pixels.
    pub size: [u32; 2],
}

/// The dialog, as it is being edited.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PublishDialog {
    /// The folder of the project that it belongs to.
    pub project: PathBuf,
    /// The title.
    pub title: String,
    /// Who is named, one in each line.
    pub credits: String,
    /// The licence of the photos.
    pub licence: String,
    /// The texts.
    pub texts: Vec<TypedText>,
    /// The text whose fields are shown.
    pub open_text: Option<usize>,
    /// The last point of the measuring tool, as a place.
    pub measured: Option<String>,
    /// The names of the project's bookmarks.
    pub bookmarks: Vec<String>,
    /// The bookmark at which a visit starts; empty for the first one.
    pub viewpoint: String,
    /// The photos that have stacks.
    pub photos: Vec<OfferedPhoto>,
    /// Those of them that stay at home.
    pub without: BTreeSet<PhotoId>,
    /// The longest side of published photos, in pixels.
    pub longest: u32,
    /// The quality of JPEGs, 1 to 100.
    pub quality: u8,
    /// The most megabytes that the page should have.
    pub budget: u64,
    /// The folder as typed or chosen; relative paths start at the project folder.
    pub folder: String,
    /// Why the last attempt failed.
    pub problem: Option<String>,
    /// What there is to say about the page that was written, in sentences.
    pub report: Vec<String>,
    /// The folder of the page that was written.
    pub done: Option<PathBuf>,
}

impl PublishDialog {
    /// Opens the dialog on what the project keeps.
    pub fn new(
        folder: PathBuf,
        project: &Project,
        photos: Vec<OfferedPhoto>,
        measured: Option<String>,
    ) -> Self {
        let (page, usual) = (&project.page, PageOptions::default());
        Self {
            project: folder,
            title: page.title.clone().unwrap_or_default(),
            credits: page.credits.join("\n"),
            licence: page.licence.clone().unwrap_or_default(),
            texts: project.texts.iter().map(TypedText::new).collect(),
            measured,
            bookmarks: project.views.iter().map(|bookmark| bookmark.name.clone()).collect(),
            photos,
            longest: usual.longest,
            quality: usual.quality,
            budget: usual.budget / 1_000_000,
            folder: PAGE.into(),
            ..Self::default()
        }
    }

    /// Returns what the page says beside its texts.
    pub fn page(&self) -> PageDecisions {
        PageDecisions {
            title: said(&self.title),
            credits: self.credits.lines().filter_map(said).collect(),
            licence: said(&self.licence),
        }
    }

    /// Returns the options of the page. What is said is in the project.
    pub fn options(&self, memory: u64) -> PageOptions {
        PageOptions {
            longest: self.longest,
            quality: self.quality,
            budget: self.budget.saturating_mul(1_000_000),
            viewpoint: said(&self.viewpoint),
            memory,
            ..PageOptions::default()
        }
    }

    /// Returns the photos that are published.
    pub fn chosen(&self) -> impl Iterator<Item = &OfferedPhoto> {
        self.photos.iter().filter(|photo| !self.without.contains(&photo.id))
    }

    /// Returns the size at which a photo is published, in pixels.
    pub fn published(&self, size: [u32; 2]) -> [u32; 2] {
        published_size(size, self.longest)
    }

    /// Returns the reason why nothing can be published.
    pub fn missing(&self) -> Option<&'static str> {
        if self.folder.trim().is_empty() {
            return Some("Choose a folder for the page.");
        }
        if self.photos.is_empty() {
            return Some("No photo has image layers yet: build and fill the project first.");
        }
        self.chosen().next().is_none().then_some("A page needs one photo at least.")
    }
}

/// Returns what was typed, unless that is nothing.
fn said(text: impl AsRef<str>) -> Option<String> {
    Some(text.as_ref().trim()).filter(|text| !text.is_empty()).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_typed_is_what_the_project_keeps_and_empty_lines_are_nothing() {
        let mut project = Project::default();
        project.page.credits = vec!["Ann".into(), "Bob".into()];
        project.texts =
            vec![TypedText { title: "Gate".into(), ..TypedText::default() }.placed([1.0, -2.5, 3.0])];
        let mut dialog = PublishDialog::new("p".into(), &project, Vec::new(), None);
        assert_eq!(dialog.page(), project.page);
        assert_eq!(dialog.texts[0].at, "1,-2.5,3");
        assert_eq!(dialog.texts[0].placed([1.0, -2.5, 3.0]), project.texts[0]);
        (dialog.title, dialog.credits) = (" The square ".into(), "\n Cy \n\n".into());
        assert_eq!(dialog.page().title.as_deref(), Some("The square"));
        assert_eq!(dialog.page().credits, ["Cy"]);
    }

    #[test]
    fn a_page_needs_a_folder_and_a_photo_and_photos_are_made_smaller_never_larger() {
        let photo = OfferedPhoto { id: PhotoId::new(0), name: "a.jpg".into(), size: [3000, 2000] };
        let mut dialog = PublishDialog::new("p".into(), &Project::default(), vec![photo], None);
        assert_eq!(dialog.missing(), None);
        assert_eq!(dialog.published([3000, 2000]), [3000, 2000]);
        dialog.longest = 1024;
        assert_eq!(dialog.published([3000, 2000]), [1024, 683]);
        dialog.without.insert(PhotoId::new(0));
        assert!(dialog.missing().is_some_and(|why| why.contains("one photo")));
        dialog.folder = " ".into();
        assert!(dialog.missing().is_some_and(|why| why.contains("folder")));
        let none = PublishDialog::new("p".into(), &Project::default(), Vec::new(), None);
        assert!(none.missing().is_some_and(|why| why.contains("build and fill")));
    }
}
