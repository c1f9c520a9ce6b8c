//! What is kept of the editor from run to run.

use std::path::{Path, PathBuf};

use eframe::egui::containers::menu::menu_style;
use eframe::egui::{Color32, Context, FontId, Stroke, Style, TextStyle, Theme, ThemePreference, Visuals};
use serde::{Deserialize, Serialize};

use super::lists::LayerList;
use super::panel::side::Tab;
use super::panel::sized::Sizes;
use super::trip::editing::EditorChoice;

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

    /// Colours and sizes of the window.
    pub fn apply_to(&self, context: &Context) {
        context.set_theme(match self.colours {
            Colours::System => ThemePreference::System,
            Colours::Dark => ThemePreference::Dark,
            Colours::Light => ThemePreference::Light,
        });
        // The commands have these keys.
        context.options_mut(|options| options.zoom_with_keyboard = false);
        context.set_zoom_factor(self.scale.clamp(Self::SMALLEST, Self::LARGEST));
        context.set_visuals_of(Theme::Dark, dark());
        context.set_visuals_of(Theme::Light, light());
        context.all_styles_mut(|style| {
            // Nothing smaller than 12 points: what cannot be read is no help.
            let sizes = [
                (TextStyle::Small, 12.0),
                (TextStyle::Body, 14.0),
                (TextStyle::Button, 14.0),
                (TextStyle::Monospace, 13.0),
                (TextStyle::Heading, 19.0),
            ];
            for (text, size) in sizes {
                let family = style.text_styles.get(&text).map(|font| font.family.clone()).unwrap_or_default();
                style.text_styles.insert(text, FontId::new(size, family));
            }
            style.spacing.item_spacing = [8.0, 5.0].into();
            style.spacing.button_padding = [8.0, 3.0].into();
        });
    }
}

fn dark() -> Visuals {
    let mut visuals = Visuals::dark();
    visuals.panel_fill = Color32::from_gray(32);
    visuals.window_fill = Color32::from_gray(38);
    visuals.extreme_bg_color = Color32::from_gray(20);
    visuals.selection.bg_fill = Color32::from_rgb(0x8a, 0x56, 0x1e);
    visuals.selection.stroke.color = Color32::from_rgb(0xff, 0xe2, 0xb8);
    visuals.hyperlink_color = Color32::from_rgb(0xf0, 0xa0, 0x50);
    visuals.override_text_color = Some(Color32::from_gray(214));
    // Pure red is hard to read on dark.
    visuals.error_fg_color = Color32::from_rgb(0xff, 0x6e, 0x60);
    with_focus(visuals)
}

fn light() -> Visuals {
    let mut visuals = Visuals::light();
    visuals.selection.bg_fill = Color32::from_rgb(0xf6, 0xc8, 0x8c);
    visuals.selection.stroke.color = Color32::from_rgb(0x50, 0x2c, 0x00);
    visuals.hyperlink_color = Color32::from_rgb(0xa8, 0x58, 0x08);
    visuals.override_text_color = Some(Color32::from_gray(30));
    // Of 4.5 to 1 against the ground, at least.
    visuals.warn_fg_color = Color32::from_rgb(0x9a, 0x4f, 0x00);
    visuals.error_fg_color = Color32::from_rgb(0xbe, 0x1a, 0x1a);
    // Rails of sliders and boxes of checks; egui's own are lost on panels.
    visuals.widgets.inactive.bg_fill = Color32::from_gray(198);
    with_focus(visuals)
}

/// The outline of what has the keyboard's focus: two points wide, of 3 to 1 at least against panels, rows that are
/// selected and buttons.
pub fn focus_stroke(visuals: &Visuals) -> Stroke {
    let color = match visuals.dark_mode {
        true => Color32::from_rgb(0xff, 0xb0, 0x50),
        false => Color32::from_rgb(0x8a, 0x46, 0x00),
    };
    Stroke::new(2.0, color)
}

/// egui draws what has the focus as it draws what is pressed.
fn with_focus(mut visuals: Visuals) -> Visuals {
    visuals.widgets.active.bg_stroke = focus_stroke(&visuals);
    visuals
}

/// Menus as egui draws them, but for the outline of what has the focus, which it leaves out.
pub fn menu_look(style: &mut Style) {
    menu_style(style);
    style.visuals.widgets.active.bg_stroke = focus_stroke(&style.visuals);
}

/// What is as it should be, on the ground of panels.
pub fn good(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_rgb(0x60, 0xb0, 0x60) } else { Color32::from_rgb(0x1f, 0x74, 0x2b) }
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

    /// Relative luminance, as WCAG 2.1 has it.
    fn luminance(color: Color32) -> f32 {
        let linear = eframe::egui::Rgba::from(color);
        0.2126 * linear.r() + 0.7152 * linear.g() + 0.0722 * linear.b()
    }

    #[test]
    fn the_focus_is_seen_in_both_themes() {
        for visuals in [dark(), light()] {
            let stroke = visuals.widgets.active.bg_stroke;
            assert!(stroke.width >= 2.0 && stroke == focus_stroke(&visuals));
            let mut style = Style { visuals: visuals.clone(), ..Style::default() };
            menu_look(&mut style);
            assert_eq!(style.visuals.widgets.active.bg_stroke, stroke, "in menus, too");
            let grounds = [
                visuals.panel_fill,
                visuals.window_fill,
                visuals.selection.bg_fill,
                visuals.widgets.inactive.weak_bg_fill,
            ];
            for ground in grounds {
                let (one, other) = (luminance(stroke.color) + 0.05, luminance(ground) + 0.05);
                let contrast = (one / other).max(other / one);
                assert!(contrast >= 3.0, "{contrast} against {ground:?}, dark: {}", visuals.dark_mode);
            }
        }
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
