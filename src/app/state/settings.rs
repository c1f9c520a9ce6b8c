//! The settings of the editor, which are stored from run to run.

use serde::{Deserialize, Serialize};

use crate::state::lists::layer_list::LayerList;
use crate::state::panels::{PanelSizes, Tab};
use crate::state::round_trip::image_editor::EditorChoice;
use quadratura_io::known_projects::KnownProjects;

/// The mouse functions in the 3D view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Navigation {
    /// The left button orbits, the right button pans.
    Simple,
    /// The middle button orbits, with Shift it pans; the left button selects.
    Blender,
}

impl Navigation {
    /// All choices.
    pub const ALL: [Self; 2] = [Self::Simple, Self::Blender];

    /// Returns the name for display.
    pub fn name(self) -> &'static str {
        match self {
            Self::Simple => "Simple: left orbits, right pans",
            Self::Blender => "Blender: middle orbits, Shift+middle pans",
        }
    }
}

/// The colours of the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Colours {
    /// The system's choice.
    System,
    /// The dark theme.
    Dark,
    /// The light theme.
    Light,
}

impl Colours {
    /// All choices.
    pub const ALL: [Self; 3] = [Self::System, Self::Dark, Self::Light];

    /// Returns the name for display.
    pub fn name(self) -> &'static str {
        match self {
            Self::System => "System",
            Self::Dark => "Dark",
            Self::Light => "Light",
        }
    }
}

/// The user's settings that belong to no project.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// The colours of the window: dark or light.
    pub colours: Colours,
    /// The scale of text and buttons; 1 is the system's size.
    pub scale: f32,
    /// Whether hints for the first steps are shown.
    pub hints: bool,
    /// The mouse functions in the 3D view.
    pub navigation: Navigation,
    /// Whether layered depth images stand in for the model while the 3D view moves.
    pub images_while_moving: bool,
    /// Whether the panel of messages is shown.
    pub notes_shown: bool,
    /// Whether stacks of the open project that are out of date are built and filled in the background. What was chosen is
    /// remembered by project ([`KnownProjects::paused`]).
    #[serde(skip)]
    pub keep_up_to_date: bool,
    /// Whether photos and lists are shown on the left.
    pub lists_shown: bool,
    /// Whether the right side is shown.
    pub side_shown: bool,
    /// The sizes of the panels.
    pub sizes: PanelSizes,
    /// The display options of the list of layers.
    pub layer_list: LayerList,
    /// The tab that the right side shows.
    pub side: Tab,
    /// The image editor that opens photos.
    pub image_editor: EditorChoice,
    /// The recent projects, and those whose updates are paused, as the file says that all windows share.
    #[serde(skip)]
    pub known: KnownProjects,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            colours: Colours::Dark,
            scale: 1.0,
            hints: true,
            navigation: Navigation::Simple,
            images_while_moving: false,
            notes_shown: false,
            keep_up_to_date: true,
            lists_shown: true,
            side_shown: true,
            sizes: PanelSizes::default(),
            layer_list: LayerList::default(),
            side: Tab::default(),
            image_editor: EditorChoice::default(),
            known: KnownProjects::default(),
        }
    }
}

impl Settings {
    /// The smallest scale: smaller text is not readable.
    pub const SMALLEST: f32 = 0.8;
    /// The largest scale: panels do not fit beyond it.
    pub const LARGEST: f32 = 2.5;

    /// Changes the scale by this many steps of a tenth.
    pub fn resize(&mut self, steps: f32) {
        self.scale = ((self.scale * 10.0).round() + steps) / 10.0;
        self.scale = self.scale.clamp(Self::SMALLEST, Self::LARGEST);
    }

    /// Resets visibility and size of all panels.
    pub fn lay_out_anew(&mut self) {
        (self.lists_shown, self.side_shown, self.sizes) = (true, true, PanelSizes::default());
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
}
