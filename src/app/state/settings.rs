//! What is kept of the editor from run to run.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::app::lists::LayerList;
use crate::app::panel::side::Tab;
use crate::app::panel::sized::Sizes;
use crate::app::trip::editing::EditorChoice;

/// So many projects are remembered.
const MOST_RECENT: usize = 12;

/// How the mouse moves through space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Navigation {
    /// Left button turns, right button moves.
    Simple,
    /// Middle button turns, with Shift moves; left button selects.
    Blender,
}

impl Navigation {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Simple, Self::Blender];

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Simple => "Simple: left turns, right moves",
            Self::Blender => "Blender: middle turns, Shift+middle moves",
        }
    }
}

/// The colours of the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Colours {
    /// As the system has it.
    System,
    /// Light on dark.
    Dark,
    /// Dark on light.
    Light,
}

impl Colours {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::System, Self::Dark, Self::Light];

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::System => "As the system",
            Self::Dark => "Dark",
            Self::Light => "Light",
        }
    }
}

/// Choices of the user that belong to no project.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Dark or light.
    pub colours: Colours,
    /// The size of text and buttons; 1 as the system has it.
    pub scale: f32,
    /// Hints for the first steps are shown.
    pub hints: bool,
    /// How the mouse moves through space.
    pub navigation: Navigation,
    /// The panel of notes is shown.
    pub notes_shown: bool,
    /// Photos and lists are shown on the left.
    pub lists_shown: bool,
    /// What is known of the selection is shown on the right.
    pub side_shown: bool,
    /// Sizes of the panels.
    pub sizes: Sizes,
    /// How the layers of a photo are listed.
    pub layer_list: LayerList,
    /// What the right side shows.
    pub side: Tab,
    /// Who opens photos to paint on them.
    pub image_editor: EditorChoice,
    /// Folders of projects, the one opened last first.
    pub recent: Vec<PathBuf>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            colours: Colours::Dark,
            scale: 1.0,
            hints: true,
            navigation: Navigation::Simple,
            notes_shown: false,
            lists_shown: true,
            side_shown: true,
            sizes: Sizes::default(),
            layer_list: LayerList::default(),
            side: Tab::default(),
            image_editor: EditorChoice::default(),
            recent: Vec::new(),
        }
    }
}

impl Settings {
    /// Smaller text cannot be read.
    pub const SMALLEST: f32 = 0.8;
    /// Larger, and no panel has room for itself.
    pub const LARGEST: f32 = 2.5;

    /// Text and buttons larger or smaller by so many steps of a tenth.
    pub fn resize(&mut self, steps: f32) {
        self.scale = ((self.scale * 10.0).round() + steps) / 10.0;
        self.scale = self.scale.clamp(Self::SMALLEST, Self::LARGEST);
    }

    /// All panels are where they were at first, as large as then.
    pub fn lay_out_anew(&mut self) {
        (self.lists_shown, self.side_shown, self.sizes) = (true, true, Sizes::default());
    }

    /// A project was opened.
    pub fn remember(&mut self, project: &Path) {
        let project = project.canonicalize().unwrap_or_else(|_| project.to_path_buf());
        self.recent.retain(|other| *other != project);
        self.recent.insert(0, project);
        self.recent.truncate(MOST_RECENT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_goes_by_tenths_and_stays_readable() {
        let mut settings = Settings::default();
        settings.resize(1.0);
        assert_eq!(settings.scale, 1.1);
        (0..40).for_each(|_| settings.resize(-1.0));
        assert_eq!(settings.scale, Settings::SMALLEST);
        (0..40).for_each(|_| settings.resize(1.0));
        assert_eq!(settings.scale, Settings::LARGEST);
    }

    #[test]
    fn a_project_opened_again_comes_first_and_is_listed_once() {
        let mut settings = Settings::default();
        (0..20).for_each(|i| settings.remember(Path::new(&format!("no-such-project-{i}"))));
        settings.remember(Path::new("no-such-project-15"));
        assert_eq!(settings.recent.len(), MOST_RECENT);
        assert_eq!(settings.recent[0], Path::new("no-such-project-15"));
        assert_eq!(settings.recent.iter().filter(|path| path.ends_with("no-such-project-15")).count(), 1);
    }
}
