//! Texts at places of the site as a page has them.

use glam::DVec3;
use serde::Serialize;

use quadratura_base::error::{Error, Result};
use quadratura_document::PlaceText;

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
    /// The language, as BCP 47 writes it.
    pub language: Option<String>,
}

/// Describes the texts of a project; `views` are the names of the page's viewpoints.
///
/// # Errors
/// [`Error::Request`] for a viewpoint that the page does not have.
pub fn described_texts(texts: &[PlaceText], views: &[&str], origin: DVec3) -> Result<Vec<DescribedText>> {
    let described = |text: &PlaceText| {
        let number = |name: &String| {
            views.iter().position(|view| view == name).ok_or_else(|| {
                Error::Request(format!(
                    "the text {:?} is seen from {name:?}, which is no bookmark of the project; store it, or add the text anew \
                     without it",
                    text.title
                ))
            })
        };
        Ok(DescribedText {
            at: (DVec3::from_array(text.at) - origin).to_array(),
            view: text.view.as_ref().map(number).transpose()?,
            title: text.title.clone(),
            text: text.text.clone(),
            link: text.link.clone(),
            language: text.language.clone(),
        })
    };
    texts.iter().map(described).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_at_its_place_and_a_viewpoint_that_is_not_there_is_named() {
        let text = PlaceText {
            title: "A".into(),
            text: "b".into(),
            at: [1.0, 2.0, 3.0],
            link: None,
            view: Some("gate".into()),
            language: None,
        };
        let found = described_texts(std::slice::from_ref(&text), &["door", "gate"], DVec3::X).unwrap();
        assert_eq!((found[0].at, found[0].view), ([0.0, 2.0, 3.0], Some(1)));
        let error = described_texts(&[text], &["door"], DVec3::X).unwrap_err().to_string();
        assert!(error.contains("\"A\"") && error.contains("\"gate\""), "{error}");
    }
}
