//! Reports a project's paint for `build` and `info`.

use serde_json::{Value, json};

use super::table::counted;
use quadratura_base::error::Result;
use quadratura_base::scene::Site;
use quadratura_io::stack_store::StackStore;
use quadratura_stacks::paint::lost::{LostPaint, PaintSurvey, survey_paint};

/// The paint of a project.
pub struct PaintReport(PaintSurvey);

impl PaintReport {
    /// Surveys the paint of a site.
    pub fn new(site: &Site, store: &StackStore) -> Result<Self> {
        let photos: Vec<&str> = site.photos.iter().map(|photo| photo.name.as_str()).collect();
        Ok(Self(survey_paint(store, &photos)?))
    }

    /// Returns true when there is paint.
    pub fn is_there(&self) -> bool {
        !self.0.photos.is_empty()
    }

    /// Returns all paint as text; empty where there is none.
    pub fn text(&self) -> String {
        if self.0.photos.is_empty() {
            return String::new();
        }
        let of_photo = |(photo, faces, pixels): &(String, usize, u64)| {
            format!("  {photo}: {} on {}\n", counted(*pixels as usize, "pixel"), counted(*faces, "face"))
        };
        let photos: String = self.0.photos.iter().map(of_photo).collect();
        format!("\npaint:\n{photos}{}", self.lost())
    }

    /// Returns the paint that currently belongs to no surface as text; empty where there is none.
    pub fn lost(&self) -> String {
        if self.0.lost.is_empty() {
            return String::new();
        }
        let line = |lost: &LostPaint| {
            let pixels = counted(lost.pixels as usize, "pixel");
            format!("  {}, {}: {pixels}; {}\n", lost.photo, lost.face, lost.reason)
        };
        let lines: String = self.0.lost.iter().map(line).collect();
        format!("\npaint on surfaces that no longer exist in these stacks (it is kept):\n{lines}")
    }

    /// Returns pictures of paint that are damaged or missing, for the exit status.
    pub fn problems(&self) -> Vec<String> {
        self.0.damaged.clone()
    }

    /// Returns all paint as JSON.
    pub fn to_json(&self) -> Value {
        let photos: Vec<Value> = self
            .0
            .photos
            .iter()
            .map(|(photo, faces, pixels)| json!({ "photo": photo, "faces": faces, "pixels": pixels }))
            .collect();
        json!({ "photos": photos, "without_place": self.0.lost, "damaged": self.0.damaged })
    }
}
