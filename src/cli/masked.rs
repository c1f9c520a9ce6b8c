//! Reports masks and removed objects for `mask` and `info`.

use serde_json::{Value, json};

use super::table::Table;
use quadratura_base::error::Result;
use quadratura_base::scene::Site;
use quadratura_document::Project;
use quadratura_sites::masks::list::{MaskedPhoto, masked_photos};

/// The masks of a project and its removed objects.
pub struct MaskReport {
    photos: Vec<MaskedPhoto>,
    off: Vec<String>,
}

impl MaskReport {
    /// Collects them from a project and its site.
    pub fn new(project: &Project, site: &Site) -> Result<Self> {
        let photos = masked_photos(site, &project.masks)?;
        Ok(Self { photos, off: project.objects_off.iter().cloned().collect() })
    }

    /// Returns the number of photos with masks.
    pub fn photos(&self) -> usize {
        self.photos.len()
    }

    /// Returns a table as text; empty where nothing is masked and no object is removed.
    pub fn text(&self) -> String {
        let mut text = String::new();
        if !self.photos.is_empty() {
            text.push_str(&format!("\n{}", self.table()));
        }
        if !self.off.is_empty() {
            text.push_str(&format!("\nobjects removed from the model: {}\n", self.off.join(", ")));
        }
        text
    }

    fn table(&self) -> String {
        let mut table = Table::new(&["photo", "masked", "pixels", "by"]);
        for photo in &self.photos {
            let makers: Vec<&str> = photo.masks.iter().map(|mask| mask.from.as_str()).collect();
            let share = format!("{:.2} %", 100.0 * photo.share);
            table.row([photo.photo.clone(), share, photo.pixels.to_string(), makers.join("; ")]);
        }
        table.render()
    }

    /// Returns the list of masked photos as JSON.
    pub fn to_json(&self) -> Value {
        json!(self.photos)
    }
}
