//! The colours of the window, and the focus outline.

use eframe::egui::containers::menu::menu_style;
use eframe::egui::{Color32, Stroke, Style, Visuals};

/// Returns the dark theme.
pub fn dark() -> Visuals {
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

/// Returns the light theme.
pub fn light() -> Visuals {
    let mut visuals = Visuals::light();
    visuals.selection.bg_fill = Color32::from_rgb(0xf6, 0xc8, 0x8c);
    visuals.selection.stroke.color = Color32::from_rgb(0x50, 0x2c, 0x00);
    visuals.hyperlink_color = Color32::from_rgb(0xa8, 0x58, 0x08);
    visuals.override_text_color = Some(Color32::from_gray(30));
    // The contrast to the background is at least 4.5 to 1.
    visuals.warn_fg_color = Color32::from_rgb(0x9a, 0x4f, 0x00);
    visuals.error_fg_color = Color32::from_rgb(0xbe, 0x1a, 0x1a);
    // This colours slider rails and checkboxes; egui's default is hardly visible on panels.
    visuals.widgets.inactive.bg_fill = Color32::from_gray(198);
    with_focus(visuals)
}

/// Returns the focus outline: two points wide, with a contrast of at least 3 to 1 to panels, selected rows and buttons.
pub fn focus_stroke(visuals: &Visuals) -> Stroke {
    let color = match visuals.dark_mode {
        true => Color32::from_rgb(0xff, 0xb0, 0x50),
        false => Color32::from_rgb(0x8a, 0x46, 0x00),
    };
    Stroke::new(2.0, color)
}

/// Adds the focus outline; egui draws a focused widget like a pressed one.
fn with_focus(mut visuals: Visuals) -> Visuals {
    visuals.widgets.active.bg_stroke = focus_stroke(&visuals);
    visuals
}

/// Adds the focus outline, which egui leaves out in menus.
pub fn menu_look(style: &mut Style) {
    menu_style(style);
    style.visuals.widgets.active.bg_stroke = focus_stroke(&style.visuals);
}

/// Returns the colour of a good state, on panels.
pub fn good(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_rgb(0x60, 0xb0, 0x60) } else { Color32::from_rgb(0x1f, 0x74, 0x2b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the relative luminance as defined in WCAG 2.1.
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
            let backgrounds = [
                visuals.panel_fill,
                visuals.window_fill,
                visuals.selection.bg_fill,
                visuals.widgets.inactive.weak_bg_fill,
            ];
            for background in backgrounds {
                let (one, other) = (luminance(stroke.color) + 0.05, luminance(background) + 0.05);
                let contrast = (one / other).max(other / one);
                assert!(contrast >= 3.0, "{contrast} against {background:?}, dark: {}", visuals.dark_mode);
            }
        }
    }
}
