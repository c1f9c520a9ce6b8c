//! Opening, creating and relinking projects: the open dialogs with what is typed in them, and their requests.

pub mod assistant;
pub mod held;
pub mod looking;
pub mod place;
pub mod relinking;

use std::path::PathBuf;

use self::assistant::Assistant;
use self::held::Held;
use self::looking::Looking;
use self::place::PathField;
use self::relinking::Relinking;
use quadratura_sites::discover::{SitePart, SiteParts};
use quadratura_sites::open::UnusableMask;

/// The state of opening, creating and leaving projects.
#[derive(Default)]
pub struct Opening {
    /// The dialogs with text fields.
    pub dialogs: OpeningDialogs,
    /// The checks of the paths in the dialogs.
    pub looking: Looking,
    /// The project that is open elsewhere.
    pub held: Option<Held>,
    /// Whether the project that is opened next is new: it is checked then.
    pub check_next: bool,
    /// A counter that grows whenever a project is left: results of earlier rounds are dropped.
    pub round: u64,
    /// Whether the path of a project is typed, where there is no file dialog.
    pub typing: bool,
}

/// The dialogs with text fields, which are edited while they are drawn.
#[derive(Debug, Default, Clone)]
pub struct OpeningDialogs {
    /// The assistant for new projects.
    pub assistant: Option<Assistant>,
    /// The missing parts of a project.
    pub relinking: Option<Relinking>,
    /// The folder of the sample project.
    pub sample: Option<PathField>,
    /// The folder of a copy of the open project.
    pub copy: Option<PathField>,
    /// The path typed where there is no file dialog; the welcome page shows it, too.
    pub typed: String,
}

impl OpeningDialogs {
    /// Returns the paths in the open dialog, where one is open.
    pub fn parts(&self) -> Option<SiteParts> {
        let relinking = self.relinking.as_ref().map(Relinking::parts);
        relinking.or_else(|| self.assistant.as_ref().map(Assistant::parts))
    }
}

/// A request of one of the dialogs.
pub enum DialogRequest {
    /// Opens the assistant, and searches this folder for a site if there is one.
    New(Option<PathBuf>),
    /// Takes a dropped or typed path: a project is opened, anything else starts a new one.
    Take(PathBuf),
    /// Opens a file dialog.
    Choose(Purpose),
    /// Searches the site folder of the assistant.
    Search,
    /// Suggests a model from the photos and cameras of the assistant.
    SuggestModel,
    /// Creates the project that the assistant describes.
    Create,
    /// Closes the open dialog.
    Cancel,
    /// Tries again to open the project.
    TryAgain(PathBuf),
    /// Opens the dialog of the sample project.
    Sample,
    /// Writes the sample project into the folder of its dialog, and opens it.
    OpenSample,
    /// Opens the dialog for a copy of the open project.
    Copy,
    /// Copies the open project to the folder of the dialog.
    SaveCopy,
    /// Updates the project with the new paths of its parts.
    Relink,
}

impl Opening {
    /// Returns whether a dialog is open: keys belong to it then.
    pub fn is_asking(&self) -> bool {
        let fields = [&self.dialogs.sample, &self.dialogs.copy];
        let types = fields.into_iter().any(Option::is_some);
        types || self.dialogs.parts().is_some() || self.held.is_some() || self.typing
    }
}

/// What a file dialog lists. No system has a dialog in which both can be chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathKind {
    /// A file.
    File,
    /// A folder.
    Folder,
}

impl PathKind {
    /// Returns the kinds of paths that a part of a site may be, the usual one first.
    pub fn of_part(part: SitePart) -> &'static [Self] {
        match part {
            SitePart::Photos => &[Self::Folder],
            SitePart::Cameras => &[Self::Folder, Self::File],
            SitePart::Model => &[Self::File],
        }
    }
}

/// The purpose of a file dialog.
#[derive(Debug, Clone, PartialEq)]
pub enum Purpose {
    /// A project to open.
    Project,
    /// The site folder that the assistant searches.
    Site,
    /// A part of a new project, or the new path of a missing part, as a file or as a folder.
    Part(SitePart, PathKind),
    /// The folder of a new project.
    Folder,
    /// The folder of the sample project.
    Sample,
    /// The folder that gets a copy of the project.
    Copy,
    /// The file of a missing photo, by the photo's name.
    Photo(String),
    /// A file that replaces a mask that cannot be used.
    Mask(Box<UnusableMask>),
}

impl Purpose {
    /// Returns the title of the dialog.
    pub fn title(&self) -> String {
        match self {
            Self::Project => "Open a project folder".into(),
            Self::Site => "Choose the site folder: photos, cameras and a model".into(),
            Self::Part(part, _) => format!("{}: {}", part.name(), part.accepted()),
            Self::Folder => "Choose an empty folder for the project".into(),
            Self::Sample => "Choose a folder for the sample project".into(),
            Self::Copy => "Choose a folder for the copy".into(),
            Self::Photo(name) => format!("Choose the file of {name}"),
            Self::Mask(it) => format!("Choose the mask of {}: black is masked", it.photo.name),
        }
    }
}
