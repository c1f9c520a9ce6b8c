//! The project file `project.json`: the user's decisions about a project (see `docs/formats.md`).

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::{
    Bookmark, CameraPath, ColourDecisions, Decisions, Masks, PageDecisions, PlaceText, SiteFrame,
    SurroundingsPicture, Trees,
};
use quadratura_base::geometry::Similarity;
use quadratura_layers::Options;
use quadratura_layers::fill::FillOptions;

/// The version of the format that this program writes; it also reads older ones.
pub const PROJECT_VERSION: u32 = 1;

/// The authored part of a project. Paths are relative to the project's folder, with `/`, and absolute only where no
/// relative path exists (another drive).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Project {
    /// The format's version, [`PROJECT_VERSION`].
    pub version: u32,
    /// The folder of the photos.
    pub photos: String,
    /// The cameras: a folder or a file of one of the formats that are read.
    pub cameras: String,
    /// The model's file.
    pub model: String,
    /// The chunk of Metashape's file that the cameras are read from; `None` for the one with most aligned cameras.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chunk: Option<String>,
    /// Whether photos of rolling shutters are resampled row by row.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub rolling_shutter: bool,
    /// The transform from the model to the cameras' world.
    #[serde(default)]
    pub world_from_model: Similarity,
    /// The options for building stacks; missing ones mean what was done before they existed.
    #[serde(default = "Options::of_before")]
    pub options: Options,
    /// The options for filling occluded texels.
    #[serde(default, skip_serializing_if = "FillOptions::is_default")]
    pub fill: FillOptions,
    /// Decisions about the photos' exposures.
    #[serde(default, skip_serializing_if = "ColourDecisions::is_default")]
    pub colour: ColourDecisions,
    /// Decisions about single photos' layers.
    #[serde(default, skip_serializing_if = "Decisions::is_default")]
    pub decisions: Decisions,
    /// Bookmarks: saved views.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub views: Vec<Bookmark>,
    /// The camera path that is being edited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flight: Option<CameraPath>,
    /// The masks of the photos.
    #[serde(default, skip_serializing_if = "Masks::is_empty")]
    pub masks: Masks,
    /// The objects that are removed from the model in this project.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub objects_off: BTreeSet<String>,
    /// Decisions by object about what turns towards cameras: true for objects whose name does not say billboard, false for
    /// billboards that stay as they are modelled.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub impostors: BTreeMap<String, bool>,
    /// Decisions by object about what one may see through in places: true for faces that are no impostor, false for
    /// impostors that are solid.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub see_through: BTreeMap<String, bool>,
    /// The user's picture of the surroundings, which takes the place of the dome made of photos.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surroundings: Option<SurroundingsPicture>,
    /// What makes the site level, metric and oriented, for exports, measurements and orthophotos.
    #[serde(default, skip_serializing_if = "SiteFrame::is_empty")]
    pub frame: SiteFrame,
    /// Texts at places, which a published page shows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub texts: Vec<PlaceText>,
    /// What a published page says beside them.
    #[serde(default, skip_serializing_if = "PageDecisions::is_empty")]
    pub page: PageDecisions,
    /// Trees that stand in the site.
    #[serde(default, skip_serializing_if = "Trees::is_empty")]
    pub trees: Trees,
}

impl Project {
    /// Returns the objects that the model is worked with without: those that are removed, and those that trees replace.
    pub fn objects_left_out(&self) -> BTreeSet<&String> {
        self.objects_off.iter().chain(self.trees.replaced()).collect()
    }
}

/// A project without files, decisions and masks, all options at their defaults.
impl Default for Project {
    fn default() -> Self {
        Self {
            version: PROJECT_VERSION,
            photos: String::new(),
            cameras: String::new(),
            model: String::new(),
            chunk: None,
            rolling_shutter: false,
            world_from_model: Similarity::IDENTITY,
            options: Options::default(),
            fill: FillOptions::default(),
            colour: ColourDecisions::default(),
            decisions: Decisions::default(),
            views: Vec::new(),
            flight: None,
            masks: Masks::default(),
            objects_off: BTreeSet::new(),
            impostors: BTreeMap::new(),
            see_through: BTreeMap::new(),
            surroundings: None,
            frame: SiteFrame::default(),
            texts: Vec::new(),
            page: PageDecisions::default(),
            trees: Trees::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_says_three_paths_at_least_and_the_rest_has_defaults() {
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
        let project: Project = serde_json::from_str(text).unwrap();
        assert_eq!(project.world_from_model, Similarity::IDENTITY);
        assert_eq!(project.options, Options::of_before());
        assert_eq!(project.fill, FillOptions::default());
        assert_eq!(project.colour, ColourDecisions::default());
    }

    #[test]
    fn a_misspelt_field_is_refused_by_name() {
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m", "optoins": {}}"#;
        let error = serde_json::from_str::<Project>(text).unwrap_err().to_string();
        assert!(error.contains("optoins") && error.contains("options"), "{error}");
    }
}
