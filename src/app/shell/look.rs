//! The visual style of the window, as set in the settings.

use eframe::egui::{Context, FontId, TextStyle, Theme, ThemePreference};

use crate::state::settings::{Colours, Settings};
use crate::widget::look::{dark, light};

/// Applies the colours and scale of the settings to the window.
pub fn apply_look(settings: &Settings, context: &Context) {
    context.set_theme(match settings.colours {
        Colours::System => ThemePreference::System,
        Colours::Dark => ThemePreference::Dark,
        Colours::Light => ThemePreference::Light,
    });
    // Commands use these keys.
    context.options_mut(|options| options.zoom_with_keyboard = false);
    context.set_zoom_factor(settings.scale.clamp(Settings::SMALLEST, Settings::LARGEST));
    context.set_visuals_of(Theme::Dark, dark());
    context.set_visuals_of(Theme::Light, light());
    context.all_styles_mut(|style| {
        // No text is smaller than 12 points, to be readable.
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
