//! The documents of the program.

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
