//! Combination of all layers with one token, because an artist may have painted on a copy.

use std::sync::Arc;

use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_layered_files::composite::lay_over;
use quadratura_layered_files::{BlendMode, EditedLayer, EditedMask, Grey, Raster};

/// The combined layers of one token.
#[derive(Debug)]
pub struct Gathered {
    /// The rectangle in canvas pixels.
    pub rect: PixelRect,
    /// The pixels, as large as `rect`.
    pub pixels: Raster,
    /// Notes about what was ignored or assumed.
    pub notes: Vec<String>,
}

/// Composites the layers of one token from bottom to top.
///
/// Invisible layers are left out, unless all are invisible; but below a copy that contains only strokes an
/// invisible original stays. The lowest layer is the image layer itself: its opacity, visibility and blend mode are
/// only viewing aids while painting, but its mask counts, and so does what groups around it do. Copies above it are
/// composited with mask and opacity; copies with another blend mode than normal are left out.
///
/// # Errors
/// Returns the errors of reading the layers' pixels.
pub fn gathered(layers: &[&EditedLayer]) -> Result<Gathered> {
    let (mut visible, mut notes) = visible(layers);
    if !std::ptr::eq(visible[0], layers[0]) && !replaces(visible[0], layers[0])? {
        visible.insert(0, layers[0]);
        notes.push(format!("\"{}\" is hidden, but the copy above it contains little of it", layers[0].name));
    }
    let (lowest, copies) = visible.split_first().expect("a token is known because a layer has it");
    // Notes are listed below the name of the image layer.
    let whose = match std::ptr::eq(*lowest, layers[0]) {
        true => "its".to_owned(),
        false => format!("of \"{}\" the", lowest.name),
    };
    if lowest.opacity < 1.0 {
        notes.push(format!("{whose} opacity only affects the display and is ignored"));
    }
    if let BlendMode::Other(blend) = &lowest.blend {
        let what = match blend.strip_prefix("normal with ") {
            Some(display) => display.to_owned(),
            None => format!("mode {blend}"),
        };
        notes.push(format!("{whose} {what} only affects the display and is ignored"));
    }
    let mut rect = lowest.rect;
    let mut pixels = masked(lowest.pixels.read()?, lowest.rect, &lowest.masks, 1.0)?;
    for copy in copies {
        if let BlendMode::Other(blend) = &copy.blend {
            notes.push(format!(
                "\"{}\" is left out: its blend mode is {blend}; merge it down first",
                copy.name
            ));
            continue;
        }
        let above = masked(copy.pixels.read()?, copy.rect, &copy.masks, copy.opacity)?;
        (pixels, rect) = united(pixels, rect, copy.rect);
        let at = PixelRect { x: copy.rect.x - rect.x, y: copy.rect.y - rect.y, ..copy.rect };
        lay_over(&mut pixels, &above, at);
    }
    Ok(Gathered { rect, pixels, notes })
}

/// Selects the layers that count, and writes a note for each of the others.
fn visible<'a>(layers: &[&'a EditedLayer]) -> (Vec<&'a EditedLayer>, Vec<String>) {
    let picked = |wanted: &dyn Fn(&EditedLayer) -> bool| {
        layers.iter().copied().filter(|layer| wanted(layer)).collect::<Vec<_>>()
    };
    let mut visible = picked(&|layer| layer.visible && !layer.hidden_by_group);
    if visible.is_empty() {
        visible = picked(&|layer| layer.visible);
    }
    if visible.is_empty() {
        visible = picked(&|_| true);
    }
    let is_visible = |layer: &EditedLayer| visible.iter().any(|other| std::ptr::eq(*other, layer));
    let hidden = layers.iter().filter(|layer| !is_visible(layer));
    let notes = hidden.map(|layer| format!("\"{}\" is left out: it is hidden", layer.name)).collect();
    (visible, notes)
}

/// Returns true when a copy replaces an invisible original: it contains at least half of the original's pixels.
fn replaces(copy: &EditedLayer, original: &EditedLayer) -> Result<bool> {
    let (above, below) = (copy.pixels.read()?, original.pixels.read()?);
    let mut all = 0u64;
    let mut held = 0u64;
    for y in 0..below.height() {
        for x in (0..below.width()).filter(|x| below.has_colour(*x, y)) {
            let (u, v) = (original.rect.x + x as i32 - copy.rect.x, original.rect.y + y as i32 - copy.rect.y);
            let inside = u >= 0 && v >= 0 && u < copy.rect.w as i32 && v < copy.rect.h as i32;
            all += 1;
            held += u64::from(inside && above.has_colour(u as u32, v as u32));
        }
    }
    Ok(2 * held >= all)
}

/// Extends pixels to a rectangle that contains another one, too.
fn united(pixels: Raster, rect: PixelRect, other: PixelRect) -> (Raster, PixelRect) {
    let both = rect.hull(&other);
    if both == rect || other.is_empty() {
        return (pixels, rect);
    }
    let mut larger = Raster::blank(both.w, both.h, pixels.depth());
    lay_over(&mut larger, &pixels, PixelRect { x: rect.x - both.x, y: rect.y - both.y, ..rect });
    (larger, both)
}

/// Multiplies masks and opacity into the pixels' alpha.
fn masked(mut pixels: Raster, rect: PixelRect, masks: &[Arc<EditedMask>], opacity: f32) -> Result<Raster> {
    let on = masks.iter().filter(|mask| mask.enabled);
    let on = on.map(|mask| ReadMask::new(mask)).collect::<Result<Vec<_>>>()?;
    if on.is_empty() && opacity >= 1.0 {
        return Ok(pixels);
    }
    for (u, v) in rect.pixels() {
        let share = on.iter().fold(opacity, |share, mask| share * mask.through(u, v));
        if share < 1.0 {
            let (x, y) = ((u - rect.x) as u32, (v - rect.y) as u32);
            let [r, g, b, a] = pixels.rgba16(x, y);
            pixels.set_rgba16(x, y, [r, g, b, (f32::from(a) * share).round() as u16]);
        }
    }
    Ok(pixels)
}

/// A mask with its pixels.
struct ReadMask<'a> {
    mask: &'a EditedMask,
    grey: Grey,
    lowest_with: Option<Box<Self>>,
}

impl<'a> ReadMask<'a> {
    fn new(mask: &'a EditedMask) -> Result<Self> {
        let other = mask.lowest_with.as_deref().filter(|other| other.enabled);
        let lowest_with = other.map(|other| Self::new(other).map(Box::new)).transpose()?;
        Ok(Self { mask, grey: mask.pixels.read()?, lowest_with })
    }

    /// Returns the share of a canvas pixel that the mask lets through, 0..=1.
    fn through(&self, x: i32, y: i32) -> f32 {
        let rect = self.mask.rect;
        let own = match rect.contains(x, y) {
            true => self.grey.at((x - rect.x) as u32, (y - rect.y) as u32),
            false => self.mask.outside,
        };
        self.lowest_with.as_ref().map_or(own, |other| own.min(other.through(x, y)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::Samples;
    use quadratura_layered_files::{Depth, Lazy};

    /// Makes a layer of one row at `x` with these opaque grey levels.
    fn layer(name: &str, x: i32, shades: &[u8]) -> EditedLayer {
        let samples: Vec<u8> = shades.iter().flat_map(|&shade| [shade, shade, shade, 255]).collect();
        let width = shades.len() as u32;
        let pixels = Lazy::new(move || Ok(Raster::new(width, 1, Samples::U8(samples.clone()))));
        EditedLayer::plain(name, PixelRect { x, y: 0, w: width, h: 1 }, pixels)
    }

    fn shades(gathered: &Gathered) -> Vec<(u8, u8)> {
        let Samples::U8(samples) = gathered.pixels.samples() else { panic!("8 bits") };
        samples.chunks_exact(4).map(|pixel| (pixel[0], pixel[3])).collect()
    }

    #[test]
    fn a_single_layer_is_taken_as_it_is_whatever_its_opacity_and_visibility() {
        let seen_through = EditedLayer { opacity: 0.5, visible: false, ..layer("a", 3, &[7, 8]) };
        let found = gathered(&[&seen_through]).unwrap();
        assert_eq!((shades(&found), found.rect.x), (vec![(7, 255), (8, 255)], 3));
        assert!(found.notes[0].contains("opacity"), "{:?}", found.notes);
    }

    #[test]
    fn a_copy_is_laid_over_the_layer_with_its_opacity() {
        let copy = EditedLayer { opacity: 0.2, ..layer("a copy", 1, &[100, 100]) };
        let found = gathered(&[&layer("a", 0, &[0, 0]), &copy]).unwrap();
        assert_eq!(shades(&found), [(0, 255), (20, 255), (100, 51)]);
        assert_eq!(found.rect, PixelRect::of_size(3, 1));
    }

    #[test]
    fn a_mask_takes_away_where_it_is_black_and_outside_as_it_says() {
        let mask = |enabled| EditedMask {
            rect: PixelRect::of_size(2, 1),
            outside: 0.0,
            enabled,
            lowest_with: None,
            pixels: Lazy::new(|| Ok(Grey::new(2, 1, Samples::U8(vec![255, 0])))),
        };
        let masked = EditedLayer { masks: vec![Arc::new(mask(true))], ..layer("a", 0, &[5, 5, 5]) };
        assert_eq!(shades(&gathered(&[&masked]).unwrap()), [(5, 255), (5, 0), (5, 0)]);
        let half = |value: u8| EditedMask {
            pixels: Lazy::new(move || Ok(Grey::new(2, 1, Samples::U8(vec![value, 255])))),
            ..mask(true)
        };
        let both =
            EditedLayer { masks: vec![Arc::new(mask(true)), Arc::new(half(51))], ..layer("a", 0, &[5, 5]) };
        assert_eq!(shades(&gathered(&[&both]).unwrap()), [(5, 51), (5, 0)], "those of groups count, too");
        let lower =
            EditedMask { lowest_with: Some(Arc::new(EditedMask { outside: 1.0, ..half(51) })), ..half(127) };
        let two_in_one = EditedLayer { masks: vec![Arc::new(lower)], ..layer("a", 0, &[5, 5]) };
        assert_eq!(shades(&gathered(&[&two_in_one]).unwrap()), [(5, 51), (5, 255)], "the lower one counts");
        let off = EditedLayer { masks: vec![Arc::new(mask(false))], ..layer("a", 0, &[5, 5, 5]) };
        assert_eq!(shades(&gathered(&[&off]).unwrap()), [(5, 255); 3]);
    }

    #[test]
    fn hidden_copies_and_other_blends_are_left_out_and_said() {
        let hidden = EditedLayer { visible: false, ..layer("draft", 0, &[9]) };
        let blended = EditedLayer { blend: BlendMode::Other("multiply".into()), ..layer("shade", 0, &[9]) };
        let found = gathered(&[&layer("a", 0, &[1]), &hidden, &blended]).unwrap();
        assert_eq!(shades(&found), [(1, 255)]);
        assert!(found.notes.iter().any(|note| note.contains("draft")), "{:?}", found.notes);
        assert!(found.notes.iter().any(|note| note.contains("multiply")), "{:?}", found.notes);
    }

    #[test]
    fn an_original_that_is_hidden_under_its_copy_gives_way_to_it_but_not_to_strokes() {
        let original = EditedLayer { visible: false, ..layer("a", 0, &[1, 1, 1]) };
        let found = gathered(&[&original, &layer("a copy", 1, &[2, 2])]).unwrap();
        assert_eq!(shades(&found), [(2, 255), (2, 255)]);
        let strokes = gathered(&[&original, &layer("strokes", 1, &[2])]).unwrap();
        assert_eq!(shades(&strokes), [(1, 255), (2, 255), (1, 255)]);
        assert_eq!(found.pixels.depth(), Depth::Eight);
    }
}
