//! Views of a single image layer: its pixels, their confidence, or their provenance.

use std::path::Path;

use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::in_8_bits;
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_document::stack::origins;
use quadratura_document::stack::origins::origin_of;
use quadratura_io::layer_reader::{read_grey, read_layer, read_mask};
use quadratura_io::stack_store::StackStore;
use quadratura_layered_files::Raster;
use quadratura_layers::LayerIndex;
use quadratura_projection::hatching::PixelMask;
use quadratura_stacks::layer_pixels::{layer_pixels, unfilled_pixels};
use quadratura_stacks::paint::PhotoPaint;
use quadratura_view::Picture;
use quadratura_view::legend::{CONFIDENCE, Origin, colour_at};

/// The content of a layer's view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LayerViewContent {
    /// The pixels: the photo's, optionally with filling and paint.
    Pixels {
        /// Whether the filling is included.
        filling: bool,
        /// Whether paint is included.
        paint: bool,
    },
    /// The confidence of each texel.
    Confidence,
    /// The source of each texel.
    Provenance,
}

/// A legend: name, colour and number of texels of each entry.
pub type LegendEntries = Vec<(String, [u8; 3], u64)>;

/// A view of a layer, as large as its rectangle.
#[derive(Debug)]
pub struct LayerView {
    /// The picture, transparent where there is nothing.
    pub picture: Picture,
    /// The texels that are needed and empty, in photo pixels.
    pub hidden: PixelMask,
    /// The legend of confidence or provenance; empty for pixels.
    pub legend: LegendEntries,
}

/// The colours that other photos get in turn.
const OTHERS: [[u8; 3]; 8] = [
    [0x66, 0xa6, 0x1e],
    [0x1b, 0x9e, 0x77],
    [0x7f, 0xc9, 0xa8],
    [0xa6, 0x76, 0x1d],
    [0x4d, 0xaf, 0xc4],
    [0xe4, 0x8a, 0x72],
    [0x9a, 0xb9, 0x73],
    [0x73, 0x70, 0xb3],
];
/// Makes the view of the image layer with index `layer` of `stack`, in the project folder `project`.
///
/// # Errors
/// Returns the errors of reading the layer's files and paint, or [`quadratura_base::Error::Cancelled`].
pub fn layer_view(
    project: &Path,
    stack: &Stack,
    layer: LayerIndex,
    look: LayerViewContent,
    task: &Task,
) -> Result<LayerView> {
    let folder = StackStore::new(project).folder(&stack.photo.name);
    let painted = PhotoPaint::open(project, stack)?;
    let files = LayerFiles { folder: &folder, stack, layer };
    task.check_cancelled()?;
    let needed = files.needed()?;
    task.check_cancelled()?;
    let (picture, legend) = match look {
        LayerViewContent::Pixels { filling, paint } => {
            let paint = if paint { &painted } else { &PhotoPaint::default() };
            let read = if filling { layer_pixels } else { unfilled_pixels };
            (in_bytes(&read(stack, &folder, paint, layer)?), Vec::new())
        }
        LayerViewContent::Confidence => files.confidence(&painted, &needed)?,
        LayerViewContent::Provenance => files.provenance(&painted, &needed)?,
    };
    let hidden = files.hidden(&picture, &needed);
    Ok(LayerView { picture, hidden, legend })
}

/// Converts a raster to 8 bits.
fn in_bytes(raster: &Raster) -> Picture {
    let (width, height) = (raster.width(), raster.height());
    let pixels = PixelRect::of_size(width, height).pixels();
    // Colours of transparent pixels are stored for filtering only and must not be visible.
    let seen = |(x, y)| match raster.rgba16(x as u32, y as u32).map(in_8_bits) {
        [.., 0] => [0; 4],
        pixel => pixel,
    };
    Picture { width, height, rgba: pixels.flat_map(seen).collect() }
}

/// The files of one image layer.
struct LayerFiles<'a> {
    folder: &'a Path,
    stack: &'a Stack,
    layer: LayerIndex,
}

/// The legend entry of each texel, 0 for none.
type Numbered = Vec<u16>;

impl LayerFiles<'_> {
    fn rect(&self) -> PixelRect {
        self.stack.layer(self.layer).rect
    }

    /// Reads the mask of needed texels.
    fn needed(&self) -> Result<Vec<u8>> {
        let layer = self.stack.layer(self.layer);
        read_mask(&self.folder.join(&layer.needed_file), layer.rect, layer.rect)
    }

    /// Returns for each texel whether it is needed and visible in the photo.
    fn visible(&self, needed: &[u8]) -> Result<Vec<bool>> {
        let layer = self.stack.layer(self.layer);
        let texels = read_layer(&self.folder.join(&layer.file), layer.rect, layer.rect)?;
        Ok(texels
            .as_chunks::<4>()
            .0
            .iter()
            .zip(needed)
            .map(|(texel, needed)| texel[3] > 0 && *needed > 0)
            .collect())
    }

    /// Returns the texels that are needed and empty in a picture.
    fn hidden(&self, picture: &Picture, needed: &[u8]) -> PixelMask {
        let rect = self.rect();
        let texels = picture.pixels().iter().zip(needed);
        PixelMask::new(rect, texels.map(|(texel, needed)| texel[3] == 0 && *needed > 0).collect())
    }

    /// Returns the indices of the painted texels.
    fn painted(&self, paint: &PhotoPaint) -> Result<Vec<usize>> {
        let rect = self.rect();
        let patch = paint.on(self.stack, self.layer)?;
        Ok(patch.iter().filter(|(.., colour)| colour[3] > 0).map(|(x, y, _)| rect.offset(x, y)).collect())
    }

    /// Makes the picture and the legend of the texels' confidence.
    fn confidence(&self, paint: &PhotoPaint, needed: &[u8]) -> Result<(Picture, LegendEntries)> {
        let layer = self.stack.layer(self.layer);
        let mut trust: Vec<Option<u8>> =
            self.visible(needed)?.into_iter().map(|visible| visible.then_some(u8::MAX)).collect();
        if let Some(fill) = &layer.fill {
            let grey = read_grey(&self.folder.join(&fill.confidence_file), layer.rect, layer.rect)?;
            // This includes paint that was propagated from other photos over visible texels.
            let filled = trust.iter_mut().zip(grey).filter(|(_, grey)| *grey > 0);
            filled.for_each(|(trust, grey)| *trust = Some(grey.min(255) as u8));
        }
        self.painted(paint)?.into_iter().for_each(|at| trust[at] = Some(u8::MAX));
        let colour = |trust: &Option<u8>| trust.map(|trust| colour_at(CONFIDENCE, f32::from(trust) / 255.0));
        let picture = self.picture(trust.iter().map(colour));
        let names = ["none", "a third", "two thirds", "full"];
        let third = |trust: &Option<u8>| trust.map(|trust| (f32::from(trust) / 85.0).round() as usize);
        let count = |at: usize| trust.iter().filter(|trust| third(trust) == Some(at)).count() as u64;
        let legend = names.into_iter().zip(CONFIDENCE).enumerate();
        Ok((picture, legend.map(|(at, (name, colour))| (name.to_owned(), *colour, count(at))).collect()))
    }

    /// Makes the picture and the legend of the texels' sources.
    fn provenance(&self, paint: &PhotoPaint, needed: &[u8]) -> Result<(Picture, LegendEntries)> {
        let layer = self.stack.layer(self.layer);
        let entry = |name: &str, origin: Origin| (name.to_owned(), origin.colour());
        let names = self.stack.fill.as_ref().map_or(&[][..], |fill| &fill.origins);
        let mut entries =
            vec![(String::new(), [0; 3]), entry("this photo", Origin::Photo), entry("paint", Origin::Paint)];
        let first = entries.len() as u16;
        entries.extend(names.iter().enumerate().map(|(at, name)| origin(name, at)));
        let mut from: Numbered = self.visible(needed)?.into_iter().map(u16::from).collect();
        if let Some(fill) = &layer.fill {
            let grey = read_grey(&self.folder.join(&fill.provenance_file), layer.rect, layer.rect)?;
            // Visible texels under paint from another photo are shown as that paint.
            let filled = from.iter_mut().zip(grey).filter(|(_, grey)| *grey > 0);
            filled.for_each(|(from, grey)| *from = (first + grey).min(entries.len() as u16 - 1));
        }
        self.painted(paint)?.into_iter().for_each(|at| from[at] = 2);
        let colour = |from: &u16| (*from > 0).then(|| entries[usize::from(*from)].1);
        let picture = self.picture(from.iter().map(colour));
        let mut counts = vec![0u64; entries.len()];
        from.iter().for_each(|from| counts[usize::from(*from)] += 1);
        let legend = entries.into_iter().zip(counts).skip(1).filter(|(_, count)| *count > 0);
        Ok((picture, legend.map(|((name, colour), count)| (name, colour, count)).collect()))
    }

    /// Makes a picture of the layer's size; texels without a colour are transparent.
    fn picture(&self, colours: impl Iterator<Item = Option<[u8; 3]>>) -> Picture {
        let pixel = |colour: Option<[u8; 3]>| colour.map_or([0; 4], |[r, g, b]| [r, g, b, u8::MAX]);
        let rect = self.rect();
        Picture { width: rect.w, height: rect.h, rgba: colours.flat_map(pixel).collect() }
    }
}

/// Returns the name of a filling's source, and its colour. Other photos get distinct colours by their number `at`.
fn origin(name: &str, at: usize) -> (String, [u8; 3]) {
    match origin_of(name) {
        Origin::Photo => (String::new(), [0; 3]),
        Origin::OtherPhoto => (name.to_owned(), OTHERS[at % OTHERS.len()]),
        Origin::Propagated => {
            let photo = origins::painter(name).unwrap_or(name);
            (format!("paint in {photo}"), Origin::Propagated.colour())
        }
        origin => (origin.name().to_owned(), origin.colour()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_origin_has_a_name_of_its_own() {
        assert_eq!(origin("[exemplar]", 2).0, "inpainted (patch-based)");
        assert_eq!(
            origin(&origins::painted_in("a.jpg"), 5),
            ("paint in a.jpg".into(), Origin::Propagated.colour())
        );
        assert_ne!(origin("a.jpg", 4).1, origin("b.jpg", 5).1);
    }
}
