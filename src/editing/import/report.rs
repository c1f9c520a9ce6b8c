//! The report of an import, by file and layer.

use std::path::PathBuf;

use serde::Serialize;

use super::question::Question;

/// The report of one edited file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FileReport {
    /// The file or folder.
    pub file: PathBuf,
    /// The photo to which it belongs.
    pub photo: String,
    /// The key of the export from which it comes.
    pub key: String,
    /// How the image was mirrored or turned, if it was; its paint is imported as if it had been turned back.
    pub turned: Option<&'static str>,
    /// The position of the photo's top-left pixel on the canvas, if the canvas was cropped or enlarged.
    pub offset: [i32; 2],
    /// The number of canvas pixels per photo pixel, if the image was scaled.
    pub scale: f64,
    /// Why nothing of the file was imported: so much has changed at once that it may be a mistake.
    pub question: Option<Question>,
    /// The layers from bottom to top as in the file, then the missing ones.
    pub layers: Vec<LayerImportReport>,
    /// Notes about what was ignored or assumed.
    pub notes: Vec<String>,
}

impl FileReport {
    /// Returns a message about layers that were left out although they may contain paint, for the exit status.
    pub fn problem(&self) -> Option<String> {
        let left_out = self.layers.iter().filter(|layer| layer.state == LayerState::LeftOut);
        let reasons = left_out.map(|layer| format!("{}: {}", layer.name, layer.notes.join("; ")));
        let reasons: Vec<String> = reasons.collect();
        let file = self.file.display();
        (!reasons.is_empty()).then(|| format!("{file}: left out: {}", reasons.join("\n")))
    }
}

/// The report of an image layer, or of another layer of the file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerImportReport {
    /// The layer's name in the file, or that in the export for a missing layer.
    pub name: String,
    /// The token of the image layer.
    pub token: Option<String>,
    /// The layer's state.
    pub state: LayerState,
    /// The number of painted (for a mask: masked) pixels, including those that were imported before.
    pub painted: u64,
    /// The number of painted pixels that were erased.
    pub erased: u64,
    /// The number of painted pixels at which this photo does not show the surface, and other photos do, so that paint
    /// replaces what they really show; `None` where that is not known, because the photo is not filled.
    pub over_photos: Option<u64>,
    /// The number of pixels whose paint (for a mask: masking) differs from the project's.
    pub changed: u64,
    /// The offset in pixels by which the layer was moved against all others; its paint is imported to its proper
    /// position.
    pub moved: Option<[i32; 2]>,
    /// How the layer was mirrored or turned by itself; its paint is imported to its proper position.
    pub turned: Option<&'static str>,
    /// Whether the layer was cropped or enlarged.
    pub resized: bool,
    /// Whether the layer's name was changed, apart from the token.
    pub renamed: bool,
    /// Conflicting paint of other files, above which it is placed.
    pub conflicts: Vec<Conflict>,
    /// Notes about what was left out.
    pub notes: Vec<String>,
}

/// The state of a layer in an edited file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LayerState {
    /// The layer is as it was exported.
    Unchanged,
    /// The layer was painted on.
    Painted,
    /// The layer is as it was exported, and its paint of an earlier import was undone in the editor.
    Restored,
    /// The layer is not in the file; its paint in the project stays.
    Missing,
    /// The layer masks pixels of the photo.
    Mask,
    /// The layer is not an image layer that this project has exported.
    Unknown,
    /// The layer is the photo or a guide and was painted on, which is not imported.
    PaintedHelper,
    /// The layer could not be understood and is not imported.
    LeftOut,
}

/// Paint from another file at the same pixels with other colours.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Conflict {
    /// The face as `object[index]`.
    pub face: String,
    /// The number of the import from which it comes.
    pub import: u32,
    /// The key of the document in which it was painted.
    pub document: String,
    /// The number of conflicting pixels.
    pub pixels: u64,
}

impl LayerImportReport {
    /// Makes a report with a state and nothing else.
    pub fn new(name: &str, token: Option<&str>, state: LayerState) -> Self {
        Self {
            name: name.to_owned(),
            token: token.map(str::to_owned),
            state,
            painted: 0,
            erased: 0,
            over_photos: None,
            changed: 0,
            moved: None,
            turned: None,
            resized: false,
            renamed: false,
            conflicts: Vec::new(),
            notes: Vec::new(),
        }
    }
}

impl LayerState {
    /// Returns the word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Unchanged => "unchanged",
            Self::Painted => "painted",
            Self::Restored => "paint removed",
            Self::Missing => "missing",
            Self::Mask => "mask",
            Self::Unknown => "unknown",
            Self::PaintedHelper => "helper, painted on",
            Self::LeftOut => "left out",
        }
    }
}
