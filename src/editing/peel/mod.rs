//! A view of a photo with visibility layers removed from the front, to inspect the result of the sort. Where a
//! layer is removed, the layers behind it show their content: the photo where they are visible, otherwise filling,
//! paint, or hatching where they are empty.

mod content;
mod shapes;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use self::content::{PeelContent, TexelContent};
pub use self::shapes::{Edge, PeelShape};
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, PixelRect};
use quadratura_base::raster::in_8_bits;
use quadratura_base::scene::Photo;
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_import::photo::read_photo;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::LayerIndex;
use quadratura_projection::hatching::PixelMask;
use quadratura_stacks::paint::PhotoPaint;
use quadratura_stacks::paint::parts::camera_of;
use quadratura_view::Picture;
use quadratura_view::srgb::Srgb;

/// The colour of needed pixels without content: dark, so that hatching is visible on it.
const HIDDEN: [u8; 4] = [0x3a, 0x2e, 0x24, 0xff];
/// The brightness of pixels that no layer covers once layers are removed, as a share, for orientation.
const AROUND: f32 = 0.3;

/// The options of a peeled view.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PeelOptions {
    /// The number of visibility layers that are removed from the front.
    pub hidden_layers: u32,
    /// Whether filling is shown, including paint that was propagated from other photos.
    pub filling: bool,
    /// Whether paint is shown.
    pub paint: bool,
    /// The opacities of image layers, by their index in the stack.
    pub opacities: Opacities,
}

impl PeelOptions {
    /// Returns true when a surface is drawn.
    pub fn shows(&self, shape: &PeelShape) -> bool {
        shape.depth >= self.hidden_layers && self.opacities.of(shape.layer) > 0
    }

    /// Returns true when some surface is not drawn, or not opaque.
    pub fn hides(&self) -> bool {
        self.hidden_layers > 0 || self.opacities != Opacities::default()
    }
}

/// The opacities of a stack's image layers, 0 to 255; all others are opaque.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Opacities(Arc<BTreeMap<LayerIndex, u8>>);

impl Opacities {
    /// Returns the opacity of an image layer.
    pub fn of(&self, layer: LayerIndex) -> u8 {
        self.0.get(&layer).copied().unwrap_or(u8::MAX)
    }
}

impl FromIterator<(LayerIndex, u8)> for Opacities {
    fn from_iter<I: IntoIterator<Item = (LayerIndex, u8)>>(layers: I) -> Self {
        Self(Arc::new(layers.into_iter().filter(|(_, opacity)| *opacity < u8::MAX).collect()))
    }
}

/// A photo without its front layers.
#[derive(Debug)]
pub struct PeeledPhoto {
    /// The picture, as large as the photo; transparent where the surfaces that covered a pixel are removed.
    pub picture: Picture,
    /// The pixels whose front surface has neither photo nor filling nor paint.
    pub hidden: PixelMask,
}

/// A surface at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeelHit {
    /// The index in [`PhotoLayers::shapes`].
    pub shape: usize,
    /// The depth along the camera's axis, in world units.
    pub distance: f64,
    /// Whether it is visible in the photo at this pixel.
    pub visible: bool,
}

/// The layers of one photo in memory.
#[derive(Debug)]
pub struct PhotoLayers {
    /// All surfaces, in the order of the stack's image layers.
    pub shapes: Vec<PeelShape>,
    camera: Pinhole,
    /// The contents by image layer.
    contents: Vec<PeelContent>,
    /// The indices of `shapes` in drawing order: from the last visibility layer to the first, and within each in
    /// the model's order.
    order: Vec<usize>,
    /// The pixels at which the photo shows only faces in no image layer: row, first column, one past the last column.
    leftovers: Vec<[u32; 3]>,
    /// Whether any layer has paint.
    painted: bool,
    /// Whether paint of other photos was propagated to any layer.
    propagated_on: bool,
}

/// Returns a photo's own pixels: sRGB as in its file, in 8 bits, with the valid area as alpha.
///
/// # Errors
/// Returns the errors of [`read_photo`].
pub fn photo_picture(photo: &Photo) -> Result<Picture> {
    let (width, height) = (photo.camera.width, photo.camera.height);
    let pixels = read_photo(&photo.file, width, height)?;
    let mut rgba = vec![0; 4 * width as usize * height as usize];
    rgba.par_chunks_exact_mut(4 * width as usize).zip(0..height).for_each(|(row, y)| {
        let row = row.as_chunks_mut::<4>().0.iter_mut().zip(0..width);
        row.for_each(|(pixel, x)| *pixel = pixels.rgba16(x, y).map(in_8_bits));
    });
    Ok(Picture { width, height, rgba })
}

impl PhotoLayers {
    /// Reads the layers of `stack`, which belongs to the project in the folder `project`.
    ///
    /// # Errors
    /// Returns the errors of reading their files and paint, or [`quadratura_base::Error::Cancelled`].
    pub fn read(project: &Path, stack: &Stack, task: &Task) -> Result<Self> {
        let folder = StackStore::new(project).folder(&stack.photo.name);
        let paint = PhotoPaint::open(project, stack)?;
        let shapes = shapes::shapes_of(stack);
        let contents = (0..stack.image_layers.len())
            .into_par_iter()
            .map(LayerIndex::new)
            .map(|layer| {
                task.check_cancelled().and_then(|()| PeelContent::read(&folder, stack, &paint, layer))
            })
            .collect::<Result<Vec<_>>>()?;
        let painted = contents.iter().any(PeelContent::is_painted);
        let propagated_on = contents.iter().any(PeelContent::is_propagated_on);
        let mut order: Vec<usize> = (0..shapes.len()).collect();
        order.sort_by_key(|&at| (std::cmp::Reverse(shapes[at].depth), shapes[at].rank));
        let (camera, _) = camera_of(&stack.photo, &stack.camera);
        let leftovers = stack.leftovers.clone();
        Ok(Self { shapes, camera, contents, order, leftovers, painted, propagated_on })
    }

    /// Returns true when a layer has paint.
    pub fn is_painted(&self) -> bool {
        self.painted
    }

    /// Returns true when paint of other photos was propagated to a layer.
    pub fn is_propagated_on(&self) -> bool {
        self.propagated_on
    }

    /// Returns the number of visibility layers.
    pub fn depth(&self) -> u32 {
        self.shapes.iter().map(|shape| shape.depth + 1).max().unwrap_or(0)
    }

    /// Returns the remaining surfaces at a pixel, topmost first.
    pub fn at(&self, x: i32, y: i32, peeling: &PeelOptions) -> Vec<PeelHit> {
        let here = |&&at: &&usize| {
            let shape = &self.shapes[at];
            peeling.shows(shape) && shape.covers(x, y)
        };
        let hit = |&at: &usize| {
            let shape = &self.shapes[at];
            let visible = self.contents[shape.layer.index()].is_visible(x, y);
            PeelHit { shape: at, distance: shape.distance(&self.camera, x, y), visible }
        };
        self.order.iter().rev().filter(here).map(hit).collect()
    }

    /// Returns the hidden pixels of the selected surfaces.
    pub fn hidden_of(&self, wanted: impl Fn(&PeelShape) -> bool) -> PixelMask {
        let wanted: Vec<&PeelShape> = self.shapes.iter().filter(|shape| wanted(shape)).collect();
        let bounds = wanted.iter().map(|shape| shape.covered.bounds()).reduce(|all, rect| all.union(&rect));
        let mut mask = PixelMask::filled(bounds.unwrap_or(PixelRect::EMPTY), false);
        for shape in wanted {
            let content = &self.contents[shape.layer.index()];
            for (y, run) in shape.covered.iter() {
                run.clone().filter(|&x| content.is_hidden(x, y)).for_each(|x| mask.put(x, y, true));
            }
        }
        mask
    }

    /// Removes layers from `photo`, the picture to which they belong (see [`photo_picture`]). The remaining ones
    /// are drawn from back to front in the order of the sort. Without any removed layers the result is the photo,
    /// except where paint is.
    ///
    /// # Errors
    /// Returns [`quadratura_base::Error::Cancelled`] when the task was cancelled.
    pub fn peeled(&self, photo: &Picture, peeling: &PeelOptions, task: &Task) -> Result<PeeledPhoto> {
        let mut canvas = PeelCanvas::from_photo(photo);
        if peeling.hides() {
            canvas.fade();
            self.shapes.iter().for_each(|shape| canvas.clear(shape));
        }
        let left = self.order.iter().map(|&at| &self.shapes[at]);
        for shape in left.filter(|shape| peeling.shows(shape)) {
            task.check_cancelled()?;
            canvas.draw(shape, &self.contents[shape.layer.index()], photo, peeling);
        }
        // They are nearer than all image layers, so they go with the first visibility layer.
        if peeling.hidden_layers == 0 {
            canvas.draw_leftovers(&self.leftovers, photo);
        }
        Ok(PeeledPhoto { picture: canvas.picture, hidden: canvas.hidden })
    }
}

/// A picture of the photo's size that is drawn on.
struct PeelCanvas {
    picture: Picture,
    hidden: PixelMask,
    /// The pixels at which a remaining surface is visible in the photo. Hidden surfaces are never drawn over it:
    /// where the sort ignored the contact of two surfaces, the order of their layers alone would permit that.
    visible: PixelMask,
}

impl PeelCanvas {
    /// Starts with the photo.
    fn from_photo(photo: &Picture) -> Self {
        let none = PixelMask::filled(photo.rect(), false);
        Self { picture: photo.clone(), hidden: none.clone(), visible: none }
    }

    /// Darkens all pixels.
    fn fade(&mut self) {
        let faded: [u8; 256] = std::array::from_fn(|value| (value as f32 * AROUND).round() as u8);
        self.picture.rgba.as_chunks_mut::<4>().0.iter_mut().for_each(|pixel| {
            pixel[..3].iter_mut().for_each(|value| *value = faded[usize::from(*value)]);
        });
    }

    /// Makes the pixels of a surface transparent.
    fn clear(&mut self, shape: &PeelShape) {
        for (y, run) in shape.covered.iter() {
            let (from, to) = (self.index(run.start, y), self.index(run.end, y));
            self.picture.rgba[4 * from..4 * to].fill(0);
        }
    }

    /// Draws a surface.
    fn draw(&mut self, shape: &PeelShape, content: &PeelContent, photo: &Picture, peeling: &PeelOptions) {
        let opacity = peeling.opacities.of(shape.layer);
        let lay_over = if content.sees_through() { lay_light_over } else { lay_over };
        for (y, run) in shape.covered.iter() {
            for x in run.clone() {
                let at = 4 * self.index(x, y);
                let whole = &mut self.picture.rgba[at..at + 4];
                let mut own: [u8; 4] = std::array::from_fn(|channel| whole[channel]);
                let pixel = &mut own[..];
                let texel = content.texel(x, y, peeling.filling, peeling.paint);
                match texel {
                    TexelContent::Nothing => continue,
                    TexelContent::Hidden | TexelContent::Filling(_) if self.visible.holds(x, y) => continue,
                    // The photo's pixel is masked there, and remains visible.
                    TexelContent::Hidden if !peeling.hides() => continue,
                    TexelContent::Hidden => pixel.copy_from_slice(&HIDDEN),
                    TexelContent::Photo => pixel.copy_from_slice(&photo.rgba[at..at + 4]),
                    TexelContent::Spread(colour) => {
                        pixel.copy_from_slice(&photo.rgba[at..at + 4]);
                        lay_over(colour, pixel);
                    }
                    TexelContent::Filling(colour)
                    | TexelContent::Mixed(colour)
                    | TexelContent::Paint(colour) => {
                        lay_over(colour, pixel);
                    }
                }
                fade_in(whole, own, opacity);
                self.hidden.put(x, y, texel == TexelContent::Hidden);
                self.visible.put(
                    x,
                    y,
                    matches!(texel, TexelContent::Photo | TexelContent::Mixed(_) | TexelContent::Spread(_)),
                );
            }
        }
    }

    /// Draws the photo's pixels that show only faces in no image layer.
    fn draw_leftovers(&mut self, leftovers: &[[u32; 3]], photo: &Picture) {
        let pixels = leftovers.iter().flat_map(|&[y, x0, x1]| (x0..x1).map(move |x| (x as i32, y as i32)));
        for (x, y) in pixels.filter(|&(x, y)| photo.rect().contains(x, y)) {
            let at = 4 * self.index(x, y);
            self.picture.rgba[at..at + 4].copy_from_slice(&photo.rgba[at..at + 4]);
            self.hidden.put(x, y, false);
        }
    }

    fn index(&self, x: i32, y: i32) -> usize {
        y as usize * self.picture.width as usize + x as usize
    }
}

/// Replaces a pixel by another one as far as that is opaque.
fn fade_in(pixel: &mut [u8], new: [u8; 4], opacity: u8) {
    if opacity == u8::MAX {
        return pixel.copy_from_slice(&new);
    }
    let [r, g, b, a] = new;
    lay_over([r, g, b, (f32::from(a) * f32::from(opacity) / 255.0).round() as u8], pixel);
}

/// Composites a colour over a pixel, neither premultiplied, in gamma space as image editors do. This is not
/// `raster::over::straight`, which has double precision: where both are soft, one sample in some 10,000 is rounded
/// differently, and pictures stay as they were.
fn lay_over([r, g, b, a]: [u8; 4], pixel: &mut [u8]) {
    let (above, below) = (f32::from(a) / 255.0, f32::from(pixel[3]) / 255.0);
    let opacity = above + below * (1.0 - above);
    let mix = |colour: u8, under: u8| {
        let sum = f32::from(colour) * above + f32::from(under) * below * (1.0 - above);
        (sum / opacity.max(f32::MIN_POSITIVE)).round() as u8
    };
    let mixed = [mix(r, pixel[0]), mix(g, pixel[1]), mix(b, pixel[2]), (opacity * 255.0).round() as u8];
    pixel.copy_from_slice(&mixed);
}

/// Composites a colour over a pixel, neither premultiplied, in linear light, as mattes are meant.
fn lay_light_over([r, g, b, a]: [u8; 4], pixel: &mut [u8]) {
    let srgb = Srgb::tables();
    let (above, below) = (f32::from(a) / 255.0, f32::from(pixel[3]) / 255.0);
    let opacity = above + below * (1.0 - above);
    let mix = |colour: u8, under: u8| match a {
        u8::MAX => colour,
        _ => {
            let sum = srgb.linear(colour) * above + srgb.linear(under) * below * (1.0 - above);
            srgb.encoded(sum / opacity.max(f32::MIN_POSITIVE))
        }
    };
    let mixed = [mix(r, pixel[0]), mix(g, pixel[1]), mix(b, pixel[2]), (opacity * 255.0).round() as u8];
    pixel.copy_from_slice(&mixed);
}
