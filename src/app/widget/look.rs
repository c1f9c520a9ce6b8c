//! The colours of the window, and the focus outline.

use eframe::egui::containers::menu::menu_style;
use eframe::egui::{Color32, Stroke, Style, Visuals};

// One colour, one meaning. Orange is what is selected, in lists and in the views. A switch that is on, which egui calls a
// selection, is grey, and the focus is white (black in the light theme). Yellow warns, red is a problem, green is good, blue is
// a link.

/// Returns the dark theme.
pub fn dark() -> Visuals {
    let mut visuals = Visuals::dark();
    visuals.panel_fill = Color32::from_gray(32);
    visuals.window_fill = Color32::from_gray(38);
    visuals.extreme_bg_color = Color32::from_gray(20);
    visuals.selection.bg_fill = Color32::from_gray(93);
    visuals.selection.stroke.color = Color32::WHITE;
    visuals.hyperlink_color = Color32::from_rgb(0x78, 0xb8, 0xff);
    visuals.override_text_color = Some(Color32::from_gray(214));
    visuals.weak_text_color = Some(Color32::from_gray(150));
    visuals.warn_fg_color = Color32::from_rgb(0xf2, 0xd0, 0x2e);
    // Pure red is hard to read on dark.
    visuals.error_fg_color = Color32::from_rgb(0xff, 0x6e, 0x60);
    with_borders(visuals, 116)
}

/// Returns the light theme.
pub fn light() -> Visuals {
    let mut visuals = Visuals::light();
    visuals.selection.bg_fill = Color32::from_gray(156);
    // A field with the focus has this border.
    visuals.selection.stroke.color = Color32::from_gray(16);
    visuals.hyperlink_color = Color32::from_rgb(0x0a, 0x5c, 0xb8);
    visuals.override_text_color = Some(Color32::from_gray(30));
    visuals.warn_fg_color = Color32::from_rgb(0x6f, 0x5f, 0x00);
    visuals.error_fg_color = Color32::from_rgb(0xbe, 0x1a, 0x1a);
    visuals.weak_text_color = Some(Color32::from_gray(88));
    // This colours slider rails and checkboxes; egui's default is hardly visible on panels.
    visuals.widgets.inactive.bg_fill = Color32::from_gray(198);
    with_borders(visuals, 128)
}

/// Adds the borders of fields and buttons in this grey, and the focus outline, which egui draws like that of a pressed widget.
fn with_borders(mut visuals: Visuals, grey: u8) -> Visuals {
    visuals.widgets.inactive.bg_stroke = Stroke::new(1.0, Color32::from_gray(grey));
    visuals.widgets.active.bg_stroke = focus_stroke(&visuals);
    visuals
}

/// Returns the focus outline: two points wide, with a contrast of at least 3 to 1 to panels, selected rows and buttons.
pub fn focus_stroke(visuals: &Visuals) -> Stroke {
    Stroke::new(2.0, Color32::from_gray(if visuals.dark_mode { 240 } else { 16 }))
}

/// Returns the colours of a name that is selected: of its background, and of its text.
pub fn selected(visuals: &Visuals) -> (Color32, Color32) {
    match visuals.dark_mode {
        true => (Color32::from_rgb(0x8a, 0x56, 0x1e), Color32::from_rgb(0xff, 0xe2, 0xb8)),
        false => (Color32::from_rgb(0xf6, 0xc8, 0x8c), Color32::from_rgb(0x50, 0x2c, 0x00)),
    }
}

/// Gives buttons that are on the colours of a selected name.
pub fn selection_look(visuals: &mut Visuals) {
    (visuals.selection.bg_fill, visuals.selection.stroke.color) = selected(visuals);
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

    fn contrast(one: Color32, other: Color32) -> f32 {
        let (one, other) = (luminance(one) + 0.05, luminance(other) + 0.05);
        (one / other).max(other / one)
    }

    fn assert_contrast(least: f32, what: &str, one: Color32, other: Color32) {
        let contrast = contrast(one, other);
        assert!(contrast >= least, "{what}: {one:?} on {other:?} has {contrast}, less than {least}");
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
                selected(&visuals).0,
                visuals.widgets.inactive.weak_bg_fill,
            ];
            backgrounds.into_iter().for_each(|fill| assert_contrast(3.0, "the focus", stroke.color, fill));
        }
    }

    #[test]
    fn texts_are_read_and_borders_of_fields_are_seen_in_both_themes() {
        for visuals in [dark(), light()] {
            let text = visuals.override_text_color.unwrap();
            let field = visuals.text_edit_bg_color();
            let border = visuals.widgets.inactive.bg_stroke;
            assert!(border.width >= 1.0);
            for fill in [visuals.panel_fill, visuals.window_fill, field] {
                assert_contrast(3.0, "the border of a field", border.color, fill);
                assert_contrast(4.5, "text", text, fill);
                assert_contrast(4.5, "a hint", visuals.weak_text_color(), fill);
                let of_meaning = [visuals.warn_fg_color, visuals.error_fg_color, visuals.hyperlink_color];
                of_meaning.into_iter().for_each(|color| assert_contrast(4.5, "a meaning", color, fill));
            }
            assert_contrast(4.5, "good", good(&visuals), visuals.panel_fill);
            let (fill, text) = selected(&visuals);
            assert_contrast(4.5, "a selected name", text, fill);
            // The colour of texts goes before that of what is selected.
            let (fill, text) = (visuals.selection.bg_fill, visuals.override_text_color.unwrap());
            assert_contrast(4.5, "a switch that is on", text, fill);
            assert_contrast(2.4, "a switch that is on, beside one that is off", fill, visuals.panel_fill);
            let stroke = visuals.selection.stroke.color;
            assert_contrast(4.5, "the border of a field with the focus", stroke, field);
        }
    }

    #[test]
    fn one_colour_has_one_meaning() {
        /// Returns the hue in degrees; `None` for a grey.
        fn hue(color: Color32) -> Option<f32> {
            let [r, g, b] = [color.r(), color.g(), color.b()].map(f32::from);
            let (most, least) = (r.max(g).max(b), r.min(g).min(b));
            let range = most - least;
            let sixth = if r >= g.max(b) {
                ((g - b) / range).rem_euclid(6.0)
            } else if g >= b {
                (b - r) / range + 2.0
            } else {
                (r - g) / range + 4.0
            };
            (range >= 12.0).then_some(60.0 * sixth)
        }
        for visuals in [dark(), light()] {
            let colours = [
                ("selection", selected(&visuals).0),
                ("warning", visuals.warn_fg_color),
                ("problem", visuals.error_fg_color),
                ("link", visuals.hyperlink_color),
                ("good", good(&visuals)),
            ];
            for (index, (one, color)) in colours.iter().enumerate() {
                for (other, second) in &colours[..index] {
                    let (a, b) = (hue(*color).expect(one), hue(*second).expect(other));
                    let apart = (a - b).abs().min(360.0 - (a - b).abs());
                    assert!(apart >= 14.0, "{one} and {other} are {apart} degrees apart");
                }
            }
            assert_eq!(hue(visuals.selection.bg_fill), None, "a switch");
            assert_eq!(hue(focus_stroke(&visuals).color), None, "the focus");
        }
    }
}
