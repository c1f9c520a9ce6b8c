//! What the user may decide about filling: the command line's, the project's and the editor's.

use serde::{Deserialize, Serialize};

/// How that is made which no photo shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Invent {
    /// By example, where there is enough to take examples from.
    #[default]
    Exemplar,
    /// Smoothly, everywhere.
    Diffusion,
}

/// Options of filling.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FillOptions {
    /// Objects that are left as the photos show them: names, or beginnings of names with `*` behind. By
    /// object and not by image layer, so that it holds whatever the next build makes of them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
    /// What no photo shows.
    pub invent: Invent,
    /// Photos whose paint is laid over what the others show of the same surfaces: names, or beginnings of names
    /// with `*` behind.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub propagate: Vec<String>,
}

impl FillOptions {
    /// Whether the object with this name is filled.
    pub fn fills(&self, object: &str) -> bool {
        !self.without.iter().any(|pattern| is_named(object, pattern))
    }

    /// Whether paint of the photo with this name is laid over other photos.
    pub fn propagates(&self, photo: &str) -> bool {
        self.propagate.iter().any(|pattern| is_named(photo, pattern))
    }

    /// All of it is as if nothing had been decided.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Whether a name is the pattern's, or begins as it does before its `*`.
pub fn is_named(name: &str, pattern: &str) -> bool {
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
