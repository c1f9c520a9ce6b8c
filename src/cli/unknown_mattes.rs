//! What `info` says of mattes: how much of see-through surfaces nobody knows, photo by photo.

use std::path::Path;

use serde_json::{Value, json};

use super::words::command_for_project;
use quadratura_document::Stack;
use quadratura_document::paint::PaintBook;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_stacks::fill::unknown_matte_pixels;
use quadratura_stacks::paint::PhotoPaint;

/// The pixels of see-through surfaces in the fillings of photos.
#[derive(Default)]
pub struct UnknownMattes {
    /// The photo, its pixels of see-through surfaces, and those of which nobody knows what they show.
    rows: Vec<(String, u64, u64)>,
}

impl UnknownMattes {
    /// Adds the stack of a photo. One without a filling, or without see-through surfaces, adds nothing. What is painted is
    /// known.
    pub fn add(&mut self, stack: &Stack, folder: &Path, book: &PaintBook) {
        let Some(fill) = stack.fill.as_ref().filter(|fill| fill.matte_pixels > 0) else { return };
        let paint = PhotoPaint::new(book, PaintStore::new(folder), stack);
        let files = StackStore::new(folder).folder(&stack.photo.name);
        // Files that cannot be read are told elsewhere.
        let unknown = unknown_matte_pixels(stack, &files, &paint).unwrap_or(fill.matte_unknown);
        self.rows.push((stack.photo.name.clone(), fill.matte_pixels, unknown));
    }

    /// Returns a sentence; empty where all is known.
    pub fn text(&self) -> String {
        let share = |of: u64, all: u64| format!("{:.0} %", 100.0 * of as f64 / all.max(1) as f64);
        let [all, unknown] =
            self.rows.iter().fold([0, 0], |[all, unknown], row| [all + row.1, unknown + row.2]);
        if unknown == 0 {
            return String::new();
        }
        let photos = self.rows.iter().filter(|(.., unknown)| *unknown > 0);
        let photos: Vec<String> =
            photos.map(|(photo, all, unknown)| format!("{photo} {}", share(*unknown, *all))).collect();
        format!(
            "\nof {} of the pixels that show see-through surfaces it is not known how much is the surface; they stay solid: \
             {}\n{} tells it object by object\n",
            share(unknown, all),
            photos.join(", "),
            command_for_project("matte")
        )
    }

    /// Returns the counts as JSON.
    pub fn into_json(self) -> Value {
        let row = |(photo, pixels, unknown)| json!({ "photo": photo, "pixels": pixels, "unknown": unknown });
        self.rows.into_iter().map(row).collect()
    }
}
