//! Names that are spelled differently and mean the same: the one rule for photos, masks, files that a model names, objects, and
//! names that are typed.
//!
//! A name that is spelled exactly so goes first. Else the one that has the same composed Unicode form (NFC; macOS stores names of
//! files decomposed) and `/` for `\`; else the one whose extension differs in letter case only; else in letter case anywhere. Of
//! several that are equally near, none is taken.

use std::borrow::Cow;

use unicode_normalization::{UnicodeNormalization, is_nfc};

/// A name among others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Alike {
    /// No name is like it.
    None,
    /// The index of the name.
    One(usize),
    /// The indices of names that are equally like it; two at least.
    Several(Vec<usize>),
}

impl Alike {
    /// Returns the index of the only name.
    pub fn one(self) -> Option<usize> {
        match self {
            Self::One(index) => Some(index),
            Self::None | Self::Several(_) => None,
        }
    }
}

/// Finds a name among others.
pub fn find<N: AsRef<str>>(name: &str, others: impl IntoIterator<Item = N>) -> Alike {
    let others: Vec<N> = others.into_iter().collect();
    if let Some(index) = others.iter().position(|other| other.as_ref() == name) {
        return Alike::One(index);
    }
    for key in [composed, extension_folded, folded] {
        let wanted = key(name);
        let same = |index: &usize| key(others[*index].as_ref()) == wanted;
        let found: Vec<usize> = (0..others.len()).filter(same).collect();
        match found[..] {
            [] => {}
            [index] => return Alike::One(index),
            _ => return Alike::Several(found),
        }
    }
    Alike::None
}

/// Returns a text in composed form.
pub fn nfc(text: &str) -> Cow<'_, str> {
    if is_nfc(text) { text.into() } else { text.nfc().collect::<String>().into() }
}

/// Returns a name in composed form, with `/` between folders.
pub fn composed(name: &str) -> Cow<'_, str> {
    let name = nfc(name);
    if name.contains('\\') { name.replace('\\', "/").into() } else { name }
}

/// Returns a composed name whose extension is in lower case.
pub fn extension_folded(name: &str) -> Cow<'_, str> {
    let name = composed(name);
    match name.rsplit_once('.') {
        Some((stem, extension)) if !extension.contains('/') => {
            format!("{stem}.{}", extension.to_lowercase()).into()
        }
        _ => name,
    }
}

/// Returns a composed name in lower case. Names that mean the same are equal in it.
pub fn folded(name: &str) -> Cow<'_, str> {
    // Lower case letters may have another composed form.
    composed(&composed(name).to_lowercase()).into_owned().into()
}

/// Says how a name that was found differs from the one that was looked for; empty where it does not.
pub fn difference(name: &str, found: &str) -> &'static str {
    if name == found {
        ""
    } else if name.replace('\\', "/") == found.replace('\\', "/") {
        "with another sign between folders"
    } else if composed(name) == composed(found) {
        "under another Unicode form"
    } else {
        "in another letter case"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COMPOSED: &str = "toit_\u{e9}glise.jpg";
    const DECOMPOSED: &str = "toit_e\u{301}glise.jpg";

    #[test]
    fn the_exact_name_goes_first_then_form_extension_and_case() {
        let names = [DECOMPOSED, COMPOSED, "b/Mur.JPG", "b/mur.jpg", "c\\x.png"];
        assert_eq!(find(COMPOSED, names), Alike::One(1));
        assert_eq!(find(DECOMPOSED, names), Alike::One(0));
        assert_eq!(find(COMPOSED, &names[..1]), Alike::One(0));
        assert_eq!(find("b/Mur.jpg", names), Alike::One(2), "the extension before the whole name");
        assert_eq!(find("B\\MUR.JPG", names), Alike::Several(vec![2, 3]));
        assert_eq!(find("c/x.png", names), Alike::One(4));
        assert_eq!(find("c/y.png", names), Alike::None);
    }

    #[test]
    fn two_names_in_two_forms_are_several_for_a_third_form() {
        // The letter has three spellings: composed, half composed and decomposed.
        let names = ["\u{1ed9}.jpg", "o\u{302}\u{323}.jpg"];
        assert_eq!(find("\u{f4}\u{323}.jpg", names), Alike::Several(vec![0, 1]));
    }

    #[test]
    fn what_differs_is_said_in_words() {
        assert_eq!(difference("a", "a"), "");
        assert_eq!(difference(COMPOSED, DECOMPOSED), "under another Unicode form");
        assert_eq!(difference("a\\b.jpg", "a/b.jpg"), "with another sign between folders");
        assert_eq!(difference("a.jpg", "a.JPG"), "in another letter case");
        assert_eq!(folded("STRASSE/\u{c9}.JPG"), folded("strasse\\E\u{301}.jpg"));
    }
}
