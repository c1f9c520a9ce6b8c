//! Options of filling, shared by the command line, the project file and the editor.

use serde::{Deserialize, Serialize};

/// The method for texels that no photo shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Invent {
    /// By example where the known part is large enough, else by diffusion.
    #[default]
    Exemplar,
    /// By diffusion everywhere.
    Diffusion,
}

/// Options of filling.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FillOptions {
    /// Objects that are not filled: names, or prefixes of names followed by `*`. The option refers to objects
    /// and not to image layers, so that it remains valid when a build forms other layers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
    /// The method for texels that no photo shows.
    pub invent: Invent,
    /// Photos whose paint replaces the pixels that other photos show of the same surfaces: names, or prefixes
    /// of names followed by `*`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub propagate: Vec<String>,
}

impl FillOptions {
    /// Returns true when the object with this name is filled.
    pub fn fills(&self, object: &str) -> bool {
        !self.without.iter().any(|pattern| matches_pattern(object, pattern))
    }

    /// Returns true when paint of the photo with this name is propagated to other photos.
    pub(crate) fn propagates(&self, photo: &str) -> bool {
        self.propagate.iter().any(|pattern| matches_pattern(photo, pattern))
    }

    /// Returns true when all options have their default values.
    pub(crate) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Returns true when a name equals the pattern, or begins with the part of the pattern before its final `*`.
pub fn matches_pattern(name: &str, pattern: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(beginning) => name.starts_with(beginning),
        None => name == pattern,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_object_is_left_out_by_its_name_or_by_how_its_name_begins() {
        let options = FillOptions { without: vec!["tractor".into(), "tree_*".into()], ..Default::default() };
        let fills = ["tractor", "tractor.cab", "tree_1", "tree"].map(|name| options.fills(name));
        assert_eq!(fills, [false, true, false, true]);
        assert!(!options.propagates("a.jpg"), "nothing is laid over a photo unless that is asked for");
        let all = FillOptions { propagate: vec!["*".into()], ..options };
        assert!(all.propagates("a.jpg"));
    }
}
