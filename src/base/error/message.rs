//! Messages that name actions of the program without knowing how a user starts them.

use std::fmt;

use super::Error;

/// An action of the program that helps against a problem. The command line words it as a command to type, the window as
/// the command to click.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Remedy {
    /// Creates a project.
    CreateProject,
    /// Builds the stacks of photos.
    Build,
    /// Fills occluded areas.
    Fill,
    /// Lists photos, faces and image layers.
    List,
    /// Removes the masks of photos.
    ClearMasks,
    /// Reads the mask files beside the photos again.
    FindMasks,
    /// Searches photos for transient objects.
    SuggestMasks,
    /// Lists the objects of the model.
    ListObjects,
    /// Restores a removed object.
    RestoreObject,
    /// Lists the decisions about photos.
    ListDecisions,
    /// Removes all decisions about the photo of this name.
    ResetDecisions(String),
    /// Removes the colour settings of the photo of this name.
    FreeColour(String),
}

/// Remedies are displayed by their names, for readers who know neither the command line nor the window.
impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CreateProject => write!(f, "“create project”"),
            Self::Build => write!(f, "“build”"),
            Self::Fill => write!(f, "“fill”"),
            Self::List => write!(f, "“list”"),
            Self::ClearMasks => write!(f, "“clear masks”"),
            Self::FindMasks => write!(f, "“find masks”"),
            Self::SuggestMasks => write!(f, "“suggest masks”"),
            Self::ListObjects => write!(f, "“list objects”"),
            Self::RestoreObject => write!(f, "“restore object”"),
            Self::ListDecisions => write!(f, "“list decisions”"),
            Self::ResetDecisions(photo) => write!(f, "“reset decisions about {photo}”"),
            Self::FreeColour(photo) => write!(f, "“remove colour settings of {photo}”"),
        }
    }
}

/// A text that may name remedies. It is displayed with their names; [`Message::worded`] words them for one face.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Message(Vec<MessagePart>);

#[derive(Debug, Clone, PartialEq, Eq)]
enum MessagePart {
    Text(String),
    Remedy(Remedy),
}

impl Message {
    /// Appends a text or another message.
    #[must_use]
    pub fn and(mut self, more: impl Into<Self>) -> Self {
        self.0.extend(more.into().0);
        self
    }

    /// Returns the text with the remedies in the given words.
    pub fn worded(&self, words: &dyn Fn(&Remedy) -> String) -> String {
        let text = |part: &MessagePart| match part {
            MessagePart::Text(text) => text.clone(),
            MessagePart::Remedy(remedy) => words(remedy),
        };
        self.0.iter().map(text).collect()
    }

    /// Returns true for a message without text.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|part| matches!(part, MessagePart::Text(text) if text.is_empty()))
    }

    /// Joins messages with a text between each two.
    pub fn join(messages: impl IntoIterator<Item = Self>, between: &str) -> Self {
        let mut messages = messages.into_iter();
        let first = messages.next().unwrap_or_default();
        messages.fold(first, |joined, next| joined.and(between).and(next))
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.worded(&Remedy::to_string))
    }
}

impl From<&str> for Message {
    fn from(text: &str) -> Self {
        Self(vec![MessagePart::Text(text.to_owned())])
    }
}

impl From<&String> for Message {
    fn from(text: &String) -> Self {
        text.as_str().into()
    }
}

impl From<String> for Message {
    fn from(text: String) -> Self {
        Self(vec![MessagePart::Text(text)])
    }
}

/// The message of an error, in which each face words the remedies.
impl From<&Error> for Message {
    fn from(error: &Error) -> Self {
        error.message()
    }
}

impl From<Remedy> for Message {
    fn from(remedy: Remedy) -> Self {
        Self(vec![MessagePart::Remedy(remedy)])
    }
}

/// A remedy with the text before and after it: `("run ", Remedy::Build, " to make it again")`.
impl<Before: Into<String>> From<(Before, Remedy, &str)> for Message {
    fn from((before, remedy, after): (Before, Remedy, &str)) -> Self {
        Self(vec![
            MessagePart::Text(before.into()),
            MessagePart::Remedy(remedy),
            MessagePart::Text(after.to_owned()),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_face_words_the_remedies_of_one_message() {
        let missing = Message::from(("no photo has a stack yet; ", Remedy::Build, " builds them"));
        let typed = |remedy: &Remedy| format!("`{}`", remedy.to_string().trim_matches(['“', '”']));
        assert_eq!(missing.worded(&typed), "no photo has a stack yet; `build` builds them");
        assert_eq!(missing.to_string(), "no photo has a stack yet; “build” builds them");
        let all = Message::join([missing.clone(), "b".into(), Remedy::Fill.into()], "\n");
        assert_eq!(all.worded(&typed), "no photo has a stack yet; `build` builds them\nb\n`fill`");
        assert!(Message::default().is_empty() && Message::from("").is_empty() && !missing.is_empty());
        assert_eq!(Message::join([], ", "), Message::default());
    }
}
