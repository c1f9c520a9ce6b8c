//! What an import found, layer by layer.

use std::path::PathBuf;

use serde::Serialize;

/// What became of one edited file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FileReport {
    /// The file or folder.
    pub file: PathBuf,
    /// The photo that it is of.
    pub photo: String,
    /// Key of the export that it came from.
    pub key: String,
    /// Where the photo's top left pixel lies on the canvas, when the canvas was cropped or enlarged.
    pub offset: [i32; 2],
    /// Pixels of the canvas per pixel of the photo, when the image was scaled.
    pub scale: f64,
    /// From the bottom to the top as in the file, then those that are missing.
    pub layers: Vec<LayerReport>,
    /// What was not understood, and what was taken for granted.
    pub notes: Vec<String>,
}

impl FileReport {
    /// The layers of which nothing is taken home although they may have been painted on, for the exit status.
    pub fn problem(&self) -> Option<String> {
        let left_out = self.layers.iter().filter(|layer| layer.state == LayerState::LeftOut);
        let reasons = left_out.map(|layer| format!("{}: {}", layer.name, layer.notes.join("; ")));
        let reasons: Vec<String> = reasons.collect();
        let file = self.file.display();
        (!reasons.is_empty()).then(|| format!("{file}: left out: {}", reasons.join("\n")))
    }
}

/// What became of one image layer, or of a layer that is none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerReport {
    /// Its name in the file; that of the export, when it is missing.
    pub name: String,
    /// Token of the image layer.
    pub token: Option<String>,
    /// In one word.
    pub state: LayerState,
    /// Painted (of a mask: masked) pixels, also those that were imported before.
    pub painted: u64,
    /// Those of them that were painted away.
    pub erased: u64,
    /// Pixels whose paint (of a mask: whether they are masked) is other than it was in the project.
    pub changed: u64,
    /// By how many pixels it was moved, against all others; taken home from where it belongs.
    pub moved: Option<[i32; 2]>,
    /// Cropped or enlarged.
    pub resized: bool,
    /// Its name is another one, but for the token.
    pub renamed: bool,
    /// Paint of other files that it contradicts; it lies on top.
    pub conflicts: Vec<Conflict>,
    /// What was left out.
    pub notes: Vec<String>,
}

/// How a layer came back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LayerState {
    /// As it was exported.
    Unchanged,
    /// With paint on it.
    Painted,
    /// Not in the file; its paint in the project stays.
    Missing,
    /// It says what is masked in the photo.
    Mask,
    /// Of no image layer that this project has exported.
    Unknown,
    /// The photo or a guide, painted on: nothing of that is taken home.
    PaintedHelper,
    /// Something about it could not be understood; nothing of it is taken home.
    LeftOut,
}

/// Paint from another file at the same pixels, with other colours.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Conflict {
    /// `object[index]`.
    pub face: String,
    /// Number of the import that brought it.
    pub import: u32,
    /// Key of the document that it was painted in.
    pub document: String,
    /// Pixels.
    pub pixels: u64,
}

impl LayerReport {
    /// A layer about which nothing more is known yet.
    pub fn new(name: &str, token: Option<&str>, state: LayerState) -> Self {
        Self {
            name: name.to_owned(),
            token: token.map(str::to_owned),
            state,
            painted: 0,
            erased: 0,
            changed: 0,
            moved: None,
            resized: false,
            renamed: false,
            conflicts: Vec::new(),
            notes: Vec::new(),
        }
    }
}

impl LayerState {
    /// As a table says it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Unchanged => "unchanged",
            Self::Painted => "painted",
            Self::Missing => "missing",
            Self::Mask => "mask",
            Self::Unknown => "unknown",
            Self::PaintedHelper => "helper, painted on",
            Self::LeftOut => "left out",
        }
    }
}
