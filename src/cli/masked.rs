//! What `mask` and `info` say of masks and of objects that are off.

use serde_json::{Value, json};

use super::table::Table;
use crate::error::Result;
use crate::recipe::masks::list::{MaskedPhoto, masked_photos};
use crate::recipe::open::Opened;

/// What is masked in a project.
pub struct Masked {
    photos: Vec<MaskedPhoto>,
    off: Vec<String>,
}

impl Masked {
    /// Of an opened project.
    pub fn of(opened: &Opened) -> Result<Self> {
        let photos = masked_photos(&opened.site, &opened.project.masks)?;
        Ok(Self { photos, off: opened.project.objects_off.iter().cloned().collect() })
    }

    /// Photos with masks.
    pub fn photos(&self) -> usize {
        self.photos.len()
    }

    /// For people; nothing where nothing is masked and no object is off.
    pub fn text(&self) -> String {
        let mut text = String::new();
        if !self.photos.is_empty() {
            text.push_str(&format!("\n{}", self.table()));
        }
        if !self.off.is_empty() {
            text.push_str(&format!("\nobjects switched off: {}\n", self.off.join(", ")));
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

    /// For programs: a list of photos.
    pub fn to_json(&self) -> Value {
        json!(self.photos)
    }
}
