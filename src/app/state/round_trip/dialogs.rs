//! The dialogs of the round trip: files to import, options of an export, and paths chosen for them.

use std::collections::BTreeSet;
use std::path::PathBuf;

use quadratura_base::scene::PhotoId;
use quadratura_document::export_record::ExportFormat;
use quadratura_exports::handover::HandoverFormat;

/// The open dialogs, as they are being edited.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RoundTripDialogs {
    /// The open import dialog.
    pub import: Option<ImportDialog>,
    /// The open export dialog.
    pub export: Option<ExportDialog>,
    /// Whether the dialog for the image editor is open.
    pub choosing_editor: bool,
}

impl RoundTripDialogs {
    /// Returns whether a dialog is open.
    pub fn is_open(&self) -> bool {
        self.import.is_some() || self.export.is_some() || self.choosing_editor
    }
}

/// The import dialog.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ImportDialog {
    /// The paths of files and folders, as typed or chosen.
    pub paths: Vec<String>,
    /// Whether scaled images are accepted.
    pub scaled: bool,
    /// Whether paint is left out where a photo shows the surface.
    pub only_unseen: bool,
}

/// The export dialog.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportDialog {
    /// The format of layered files.
    pub format: ExportFormat,
    /// The format of another program that is written in their place; `None` for layered files.
    pub program: Option<HandoverFormat>,
    /// The folder as typed or chosen; relative paths start at the project folder.
    pub folder: String,
    /// The photos, by index; empty for all, of layered files all that have layers.
    pub photos: BTreeSet<PhotoId>,
    /// Whether guides of hidden areas are exported.
    pub guides: bool,
    /// Whether pictures of provenance are exported beside the files.
    pub provenance: bool,
    /// Whether photos are exported with matched exposure, for viewing.
    pub even: bool,
    /// Whether textures are tiles of one picture (UDIM), where the format has them.
    pub tiles: bool,
    /// The folder of the last export made with this dialog.
    pub done: Option<PathBuf>,
    /// What there is to say about it, in sentences.
    pub report: Vec<String>,
}

/// The folder of layered files unless another one is given.
pub const LAYERS: &str = "layers";

impl ExportDialog {
    /// Chooses a format of another program, or layered files. A folder that was not given by the user follows.
    pub fn choose(&mut self, program: Option<HandoverFormat>) {
        let usual = |program: Option<HandoverFormat>| program.map_or(LAYERS, HandoverFormat::name);
        if self.folder == usual(self.program) {
            self.folder = usual(program).into();
        }
        self.program = program;
        (self.done, self.report) = (None, Vec::new());
    }

    /// Returns the reason why the export is not possible.
    pub fn problem(&self) -> Option<&'static str> {
        if self.folder.trim().is_empty() {
            return Some("choose a folder to export to");
        }
        let odd = self.program.is_none() && self.even && self.format == ExportFormat::Folder;
        odd.then_some(
            "a folder of PNG files is always exported with original colours: choose another format for \
                       matched exposure",
        )
    }
}

/// The purpose of a system dialog.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DialogPurpose {
    /// Layered files to import.
    Layered,
    /// The folder of exports.
    ExportFolder,
    /// The folder of rendered pictures and videos.
    RenderFolder,
    /// The file of a layered depth image to save.
    ImageFile,
    /// The folder of a page to save.
    PageFolder,
    /// The folder of orthophotos.
    OrthoFolder,
    /// The folder of the site's web page.
    PublishFolder,
    /// The program of an image editor.
    Program,
}
