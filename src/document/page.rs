//! What a published page says beside its pictures: texts at places, the title, who is named, and the licence of the photos.

use serde::{Deserialize, Serialize};

/// What stands below and above a page.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PageDecisions {
    /// The title.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Who is to be named, such as photographers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub credits: Vec<String>,
    /// The licence of the photos: an SPDX name, or the address of a text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub licence: Option<String>,
}

impl PageDecisions {
    /// Returns true when nothing is decided.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A text at a place of the site.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceText {
    /// The title.
    pub title: String,
    /// Plain text: markup is shown as it is typed.
    pub text: String,
    /// The place, in the cameras' world.
    pub at: [f64; 3],
    /// Where more is to be read: an address with http, https or mailto, or one relative to the page.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// The bookmark from which one looks at the place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
    /// The language, as BCP 47 writes it, such as `fr`; that of the visitor's page without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub language: Option<String>,
}

impl PlaceText {
    /// Returns a sentence about a value that cannot be, if any.
    pub fn problem(&self) -> Option<String> {
        let of = |what: String| Some(format!("the text {:?} {what}", self.title));
        if self.title.trim().is_empty() {
            return Some("a text has no title; expected one, by which visitors choose it".into());
        }
        if self.at.iter().any(|value| !value.is_finite()) {
            return of("is at a place that is not three finite numbers".into());
        }
        if let Some(link) = self.link.as_ref().filter(|link| !is_harmless(link)) {
            return of(format!(
                "has the link {link:?}; expected an address with http, https or mailto, or a relative one"
            ));
        }
        let language = self.language.as_ref().filter(|language| !is_language(language));
        language.and_then(|language| {
            of(format!("has the language {language:?}; expected one such as fr or pt-BR"))
        })
    }
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

/// Returns whether a text has the form of a language tag of BCP 47: subtags of one to eight letters and digits.
fn is_language(tag: &str) -> bool {
    tag.split('-')
        .all(|part| (1..=8).contains(&part.len()) && part.bytes().all(|byte| byte.is_ascii_alphanumeric()))
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
    fn a_fault_in_a_text_names_the_text_and_what_was_expected() {
        let good = r#"{"title": "A", "text": "b", "at": [1, 2, 3], "view": "gate", "language": "pt-BR"}"#;
        let text: PlaceText = serde_json::from_str(good).unwrap();
        assert_eq!(text.problem(), None);
        let faults = [
            (PlaceText { link: Some("javascript:x".into()), ..text.clone() }, "javascript:x"),
            (PlaceText { language: Some("fr_FR <b>".into()), ..text.clone() }, "expected one such as fr"),
            (PlaceText { at: [0.0, f64::NAN, 0.0], ..text.clone() }, "three finite numbers"),
            (PlaceText { title: " ".into(), ..text }, "has no title"),
        ];
        for (text, expected) in faults {
            let problem = text.problem().unwrap();
            assert!(problem.contains(expected), "{problem}");
        }
    }
}
