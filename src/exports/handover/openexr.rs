//! `--format exr`: the image layers of each photo in one OpenEXR file of several parts, for compositing programs.
//!
//! ```text
//! PHOTO.exr      photo           the photo, as the first part
//!                TOKEN_NAME      an image layer: nearest first; its data window is its rectangle
//!                leftovers       what the photo shows of faces in no image layer
//!                depth           Z: the nearest surface of the model
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use super::folder::HandoverFolder;
use super::origin::Placement;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::{Photo, Samples};
use quadratura_base::task::Task;
use quadratura_document::names::file_name_of_photo;
use quadratura_document::paint::PaintBook;
use quadratura_document::{Decisions, Stack};
use quadratura_import::photo::read_photo;
use quadratura_io::colour::Conversion;
use quadratura_io::layers_exr::{ExrContent, ExrPart, ExrValue, layers_exr, light_of};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_readers::StackReader;
use quadratura_io::stack_store::StackStore;
use quadratura_layered_files::Raster;
use quadratura_sites::open::Opened;
use quadratura_stacks::depths::nearest_depths;
use quadratura_stacks::layer_names::rename;
use quadratura_stacks::layer_pixels::layer_pixels;
use quadratura_stacks::paint::PhotoPaint;
use quadratura_views::colour::even_factors;

/// The longest readable part of a part's name, in characters; channels are shown as `NAME.R` in narrow lists.
const LONGEST_READABLE: usize = 40;

/// What all photos share.
struct Source<'a> {
    store: StackStore,
    book: PaintBook,
    decisions: &'a Decisions,
    gains: BTreeMap<String, [f64; 3]>,
    /// The factor from units of the world to those of the files.
    unit: f64,
}

/// Writes a file for each photo that has a stack.
///
/// # Errors
/// Returns [`Error::Missing`] when no photo has a stack, the errors of writing, or [`Error::Cancelled`]. A photo that cannot be read is left
/// out.
pub fn write(
    folder: &mut HandoverFolder,
    project: &Path,
    opened: &Opened,
    photos: &[&Photo],
    placement: &Placement,
    task: &Task,
) -> Result<()> {
    // Stacks that change meanwhile stay readable as they were.
    let _reader = StackReader::begin(project);
    let source = Source {
        store: StackStore::new(project),
        book: PaintStore::new(project).read()?,
        decisions: &opened.project.decisions,
        gains: even_factors(project, &opened.project, &opened.site, task)?,
        unit: placement.length(1.0),
    };
    let mut has_stack = false;
    for (done, photo) in photos.iter().enumerate() {
        task.step("write layers", done as u64, photos.len() as u64)?;
        let Some(stack) = source.store.current(&photo.name)? else {
            folder.leave_out(format!("{}: it has no stack yet", photo.name));
            continue;
        };
        has_stack = true;
        match source.file(photo, stack, task) {
            Ok(bytes) => folder.write(&format!("{}.exr", file_name_of_photo(&photo.name)), &bytes)?,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => folder.fail(format!("{}: {error}", photo.name)),
        }
    }
    if !has_stack {
        return Err(Error::missing(("no photo has a stack yet; ", Remedy::Build, " builds them")));
    }
    folder.leave_out("guides and needed areas, which the layered files of `--format psd` have, and masks");
    Ok(())
}

impl Source<'_> {
    /// Returns the content of a photo's file.
    fn file(&self, photo: &Photo, mut stack: Stack, task: &Task) -> Result<Vec<u8>> {
        rename(&mut stack, &self.decisions.of(&photo.name).names);
        let size = [stack.photo.width, stack.photo.height];
        let whole = PixelRect::of_size(size[0], size[1]);
        let pixels = read_photo(&photo.file, size[0], size[1])?;
        let conversion = Conversion::between(pixels.icc.as_deref(), None).map_err(Error::Request)?;
        let in_srgb = |pixels: Raster| converted(pixels, conversion.as_ref());
        let plate = in_srgb(Raster::of_photo(pixels));
        let of_photo = || {
            let gain =
                self.gains.get(&photo.name).map(|gain| ("gain", ExrValue::Three(gain.map(|c| c as f32))));
            gain.into_iter().chain([("photo", ExrValue::Text(photo.name.clone()))])
        };
        let leftovers = leftovers(&stack, &plate);
        let mut parts = vec![ExrPart {
            name: "photo".into(),
            rect: whole,
            content: light_of(&plate),
            attributes: of_photo().collect(),
        }];
        drop(plate);
        let folder = self.store.folder(&photo.name);
        let paint = PhotoPaint::new(&self.book, PaintStore::new(self.store.project()), &stack);
        paint.damaged().iter().for_each(|problem| task.note(problem.clone()));
        for index in stack.layer_indices() {
            task.check_cancelled()?;
            let layer = stack.layer(index);
            let of_layer = [
                ("order", ExrValue::Number(layer.order as i32)),
                ("token", ExrValue::Text(layer.id.clone())),
                ("name", ExrValue::Text(layer.name.clone())),
            ];
            parts.push(ExrPart {
                name: part_name(&layer.id, &layer.name),
                rect: layer.rect,
                content: light_of(&in_srgb(layer_pixels(&stack, &folder, &paint, index)?)),
                attributes: of_photo().chain(of_layer).collect(),
            });
        }
        if let Some(content) = leftovers {
            parts.push(ExrPart { name: "leftovers".into(), rect: whole, content, attributes: Vec::new() });
        }
        let unit = self.unit as f32;
        let depths = nearest_depths(&stack).into_iter().map(|depth| depth * unit).collect();
        let content = ExrContent::Depths(depths);
        parts.push(ExrPart { name: "depth".into(), rect: whole, content, attributes: Vec::new() });
        layers_exr(size, parts)
    }
}

/// Returns what a photo shows of faces in no image layer; `None` where that is nothing.
fn leftovers(stack: &Stack, plate: &Raster) -> Option<ExrContent> {
    let mut kept = Raster::blank(plate.width(), plate.height(), plate.depth());
    for &[y, x0, x1] in stack.leftovers.iter().filter(|[y, ..]| *y < plate.height()) {
        for x in x0..x1.min(plate.width()) {
            kept.set_rgba16(x, y, plate.rgba16(x, y));
        }
    }
    (!stack.leftovers.is_empty()).then(|| light_of(&kept))
}

/// Converts colours to sRGB, where they are in another profile.
fn converted(pixels: Raster, conversion: Option<&Conversion>) -> Raster {
    let Some(conversion) = conversion else { return pixels };
    let (width, height) = (pixels.width(), pixels.height());
    let mut samples = Vec::with_capacity(4 * width as usize * height as usize);
    for y in 0..height {
        let row: Vec<[u16; 4]> = (0..width).map(|x| pixels.rgba16(x, y)).collect();
        samples.extend(conversion.converted(&row).into_flattened());
    }
    Raster::new(width, height, Samples::U16(samples))
}

/// Returns the name of a layer's part: its token, and what of its name programs accept in names of channels.
fn part_name(token: &str, name: &str) -> String {
    let readable: String = name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
        .take(LONGEST_READABLE)
        .collect();
    let words: Vec<&str> = readable.split('_').filter(|word| !word.is_empty()).collect();
    std::iter::once(token).chain(words).collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_parts_begin_with_the_token_and_have_only_letters_digits_and_lines() {
        assert_eq!(part_name("k7q2m9", "church.tower, wall 2, 3 more"), "k7q2m9_church_tower_wall_2_3_more");
        assert_eq!(part_name("k7q2m9", "\u{5854}"), "k7q2m9");
        assert_eq!(part_name("k7q2m9", &"long ".repeat(30)).len(), 6 + 5 * 8);
    }
}
