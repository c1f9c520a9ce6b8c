//! The documents of the program, and what it says about itself.

use super::State;
use super::numbers::counted;

/// A document of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Document {
    /// Its name in menus.
    pub name: &'static str,
    /// The name of its file, without the ending.
    pub stem: &'static str,
    /// The text, in Markdown.
    pub text: &'static str,
}

macro_rules! documents {
    ($($constant:ident: $name:literal, $stem:literal;)*) => {
        impl Document {
            $(#[doc = $name]
            pub const $constant: Self = Self {
                name: $name,
                stem: $stem,
                text: include_str!(concat!("../../../docs/", $stem, ".md")),
            };)*
            /// All documents, in the order of the menu.
            pub const ALL: [Self; [$($stem),*].len()] = [$(Self::$constant),*];
        }
    };
}

documents! {
    GUIDE: "Guide", "guide";
    WINDOW: "The window", "window";
    EDITING: "Image editors", "editing";
    PLANTS: "Trees and plants", "trees";
    GLOSSARY: "Glossary", "glossary";
    FORMATS: "Files and formats", "formats";
    METHOD: "The method", "method";
}

impl State {
    /// Returns facts for a report of a fault: program, system, device, project and messages. It has no name of a file
    /// and no picture, except in messages.
    pub fn diagnostics(&self) -> String {
        let mut lines = vec![
            format!("Quadratura {}", env!("CARGO_PKG_VERSION")),
            format!("System: {} {}", std::env::consts::OS, std::env::consts::ARCH),
            format!("Graphics device: {}", self.device.as_deref().unwrap_or("none in use")),
        ];
        if let Some(session) = &self.session {
            let (model, photos) = (session.model(), &session.photos);
            let built = photos.iter().filter(|photo| photo.stack.is_some()).count();
            lines.push(format!(
                "Project: {} ({built} built), {}, {}",
                counted(photos.len() as u64, "photo"),
                counted(model.objects.len() as u64, "object"),
                counted(model.faces.len() as u64, "face"),
            ));
        }
        lines.extend(self.space.trouble.iter().map(|trouble| format!("3D view: {trouble}")));
        let notes =
            self.notes.list().iter().map(|note| format!("{:?}: {} {}", note.weight, note.subject, note.text));
        lines.extend(notes);
        lines.join("\n")
    }
}
