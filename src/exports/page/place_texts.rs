//! Texts at places of the site: what a visitor reads there.

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use quadratura_base::error::{Error, Result};
use quadratura_files::json::read_json;

/// The most bytes of the file.
const LARGEST: u64 = 1 << 22;
const REMEDY: &str = "docs/page.md says what the file holds";

/// A text as it is in the file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlaceText {
    title: String,
    text: String,
    at: [f64; 3],
    #[serde(default)]
    link: Option<String>,
    #[serde(default)]
    view: Option<String>,
}

/// A text as the page has it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DescribedText {
    /// The title.
    pub title: String,
    /// Plain text.
    pub text: String,
    /// The place, relative to the page's origin.
    pub at: [f64; 3],
    /// Where more is to be read.
    pub link: Option<String>,
    /// The number of the viewpoint, from 0, from which one looks at it.
    pub view: Option<usize>,
}

/// Reads the texts of a file; `views` are the names of the page's viewpoints.
///
/// # Errors
/// [`Error::Io`], and [`Error::Input`] for what is no text, for links of other schemes and for viewpoints that the page does not have.
pub fn read_texts(file: &Path, views: &[&str], origin: DVec3) -> Result<Vec<DescribedText>> {
    let texts: Vec<PlaceText> = read_json(file, LARGEST, REMEDY)?;
    let described = |(number, text): (usize, PlaceText)| {
        let fault = |field: &str, found: String| {
            Error::input(file, format!("text {} (\"{}\"), {field}", number + 1, text.title), found, REMEDY)
        };
        if text.at.iter().any(|value| !value.is_finite()) {
            return Err(fault("at", "a coordinate that is no number".into()));
        }
        if let Some(link) = text.link.as_ref().filter(|link| !is_harmless(link)) {
            return Err(fault(
                "link",
                format!("\"{link}\", expected an address with http, https or mailto, or a relative one"),
            ));
        }
        let view =
            match &text.view {
                None => None,
                Some(name) => Some(views.iter().position(|view| view == name).ok_or_else(|| {
                    fault("view", format!("\"{name}\", which is no bookmark of the project"))
                })?),
            };
        let at = (DVec3::from_array(text.at) - origin).to_array();
        Ok(DescribedText {
            at,
            view,
            title: text.title.clone(),
            text: text.text.clone(),
            link: text.link.clone(),
        })
    };
    texts.into_iter().enumerate().map(described).collect()
}

/// Returns whether an address can do no harm: one of the web or of mail, or a relative one.
pub fn is_harmless(link: &str) -> bool {
    let end = link.find(['/', '?', '#']).unwrap_or(link.len());
    match link[..end].split_once(':') {
        None => !link.is_empty() && !link.starts_with("//"),
        Some((scheme, _)) => {
            ["http", "https", "mailto"].iter().any(|known| scheme.eq_ignore_ascii_case(known))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_that_could_run_something_are_refused() {
        for good in ["https://example.org/a:b", "http://x", "mailto:a@b.c", "more/text.html", "#photo=2"] {
            assert!(is_harmless(good), "{good}");
        }
        for bad in
            ["javascript:alert(1)", "JavaScript:x", "data:text/html,x", "//example.org", "", " javascript:x"]
        {
            assert!(!is_harmless(bad), "{bad}");
        }
    }

    #[test]
    fn a_fault_in_a_text_names_the_text_and_the_field() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("texts.json");
        let read = |content: &str| {
            std::fs::write(&file, content).unwrap();
            read_texts(&file, &["gate"], DVec3::X)
        };
        let found = read(r#"[{"title": "A", "text": "b", "at": [1, 2, 3], "view": "gate"}]"#).unwrap();
        assert_eq!((found[0].at, found[0].view), ([0.0, 2.0, 3.0], Some(0)));
        let link = read(r#"[{"title": "A", "text": "b", "at": [1, 2, 3], "link": "javascript:x"}]"#)
            .unwrap_err()
            .to_string();
        assert!(link.contains("text 1 (\"A\"), link") && link.contains("javascript:x"), "{link}");
        let view = read(r#"[{"title": "A", "text": "b", "at": [1, 2, 3], "view": "door"}]"#)
            .unwrap_err()
            .to_string();
        assert!(view.contains("\"door\""), "{view}");
        assert!(read(r#"[{"title": "A"}]"#).unwrap_err().to_string().contains("text"), "a field is missing");
    }
}
