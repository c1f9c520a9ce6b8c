//! The panels around the views, as the user set them: their sizes, and the tab of the right side.

use serde::{Deserialize, Serialize};

/// The sizes of panels as the user set them, in points. Small windows show less; large ones restore the size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PanelSizes {
    /// The width of photos and lists.
    pub left: f32,
    /// The width of the inspector.
    pub right: f32,
    /// The height of the photos on the left side.
    pub photos: f32,
    /// The height of the messages.
    pub notes: f32,
    /// The height of the timeline.
    pub flight: f32,
    /// The width of the list of untextured faces beside a photo.
    #[serde(rename = "faces_beside")]
    pub faces_width: f32,
    /// The height of the list of untextured faces below a photo.
    pub faces_below: f32,
}

impl Default for PanelSizes {
    fn default() -> Self {
        Self {
            left: 290.0,
            right: 310.0,
            photos: 340.0,
            notes: 170.0,
            flight: 150.0,
            faces_width: 300.0,
            faces_below: 180.0,
        }
    }
}

/// A tab of the right side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Tab {
    /// The inspector.
    #[default]
    Selection,
    /// Occluded areas.
    Fill,
    /// Exposures of photos.
    Colour,
    /// Imported paint.
    Paint,
}

impl Tab {
    /// All tabs, in order.
    pub const ALL: [Self; 4] = [Self::Selection, Self::Fill, Self::Colour, Self::Paint];

    /// Returns the name for display.
    pub fn name(self) -> &'static str {
        match self {
            Self::Selection => "Selection",
            Self::Fill => "Fill",
            Self::Colour => "Colour",
            Self::Paint => "Paint",
        }
    }

    /// Returns what the tab shows.
    pub fn tooltip(self) -> &'static str {
        match self {
            Self::Selection => "Properties of the selected photo, layer, object or face.",
            Self::Fill => "Occluded areas: how visible they are, and how they are filled.",
            Self::Colour => "Differences in exposure between photos, and their correction.",
            Self::Paint => "Imported paint, and the imports that can be undone.",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_that_are_not_stored_yet_are_the_usual_ones() {
        let sizes: PanelSizes = serde_json::from_str(r#"{"left": 200.0, "faces_beside": 120.0}"#).unwrap();
        assert_eq!(sizes, PanelSizes { left: 200.0, faces_width: 120.0, ..PanelSizes::default() });
    }

    #[test]
    fn every_tab_has_a_name_of_its_own_and_says_what_it_shows() {
        let names: std::collections::BTreeSet<&str> = Tab::ALL.map(Tab::name).into();
        assert_eq!(names.len(), Tab::ALL.len());
        assert!(Tab::ALL.iter().all(|tab| tab.tooltip().ends_with('.')));
    }
}
