//! The image editor that opens exports: the chosen one, or one that is installed.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use quadratura_document::export_record::ExportFormat;
use quadratura_io::programs::ImageEditor;

/// The choice of the image editor, stored from run to run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct EditorChoice {
    /// A supported image editor, which is located automatically; none for the program below.
    pub editor: Option<ImageEditor>,
    /// The path of another program.
    pub program: String,
    /// The format that the other program reads.
    pub format: ExportFormat,
}

impl Default for EditorChoice {
    fn default() -> Self {
        Self { editor: Some(ImageEditor::Gimp), program: String::new(), format: ExportFormat::Psd }
    }
}

/// A program that opens exports.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EditingProgram {
    /// The name for display.
    pub name: String,
    /// The path of its executable.
    pub program: PathBuf,
    /// The format of the file that it opens.
    pub format: ExportFormat,
}

impl EditorChoice {
    /// Returns the program to use: the chosen one if it is installed, otherwise the first one found.
    pub fn tool(&self, found: &[(ImageEditor, PathBuf)]) -> Option<EditingProgram> {
        let known = |(editor, program): &(ImageEditor, PathBuf)| EditingProgram {
            name: editor.name().into(),
            program: program.clone(),
            format: editor.format(),
        };
        let Some(chosen) = self.editor else {
            let program = PathBuf::from(&self.program);
            let name = program.file_stem()?.to_string_lossy().into_owned();
            return Some(EditingProgram { name, program, format: self.format });
        };
        found.iter().find(|(editor, _)| *editor == chosen).or_else(|| found.first()).map(known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chosen_editor_is_used_if_it_is_there_else_the_first_one_found_or_the_own_program() {
        let found: Vec<(ImageEditor, PathBuf)> =
            vec![(ImageEditor::Krita, "/bin/krita".into()), (ImageEditor::Photoshop, "/bin/ps".into())];
        let choice = |editor, program: &str| EditorChoice {
            editor,
            program: program.into(),
            format: ExportFormat::Psd,
        };
        let name = |choice: EditorChoice| choice.tool(&found).map(|tool| (tool.name, tool.format));
        let krita = Some(("Krita".to_owned(), ExportFormat::Ora));
        assert_eq!(name(choice(Some(ImageEditor::Krita), "")), krita);
        assert_eq!(name(choice(Some(ImageEditor::Gimp), "")), krita, "GIMP is not there");
        assert_eq!(name(choice(None, "/opt/paint")), Some(("paint".to_owned(), ExportFormat::Psd)));
        assert_eq!(name(choice(None, "")), None);
        assert_eq!(choice(Some(ImageEditor::Gimp), "").tool(&[]), None);
    }
}
