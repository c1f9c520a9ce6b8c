//! A photo with visibility layers taken off, one after the other: what the sort found, to be looked at. Where a layer is
//! gone, the layers behind it show what they have: the photo where it shows them, their filling, paint, or that
//! nothing is known yet.

mod content;
mod shapes;
#[cfg(test)]
mod tests;

use std::path::Path;

use rayon::prelude::*;

use self::content::{Content, Texel};
pub use self::shapes::{Edge, Shape};
use crate::document::Stack;
use crate::error::Result;
use crate::geometry::{Pinhole, PixelRect};
use crate::io::photo::read_photo;
use crate::io::stack_store::StackStore;
use crate::projection::Picture;
use crate::projection::hatching::Mask;
use crate::raster::in_8_bits;
use crate::recipe::paint::PhotoPaint;
use crate::recipe::paint::parts::camera_of;
use crate::scene::Photo;
use crate::task::Task;

/// What is needed and not known yet is of this colour: dark, so that hatching stands out on it.
const HIDDEN: [u8; 4] = [0x3a, 0x2e, 0x24, 0xff];
/// What no surface covers keeps this share of its colour once layers are taken off, to find one's way by.
const AROUND: f32 = 0.3;

/// What is taken off and what is shown of the rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Peeling {
    /// So many visibility layers are gone, from the front.
    pub taken_off: u32,
    /// What fills hidden parts is shown, and paint of other photos, which filling lays over this one.
    pub filling: bool,
    /// Paint is shown.
    pub paint: bool,
}

/// A photo without its front layers.
#[derive(Debug)]
pub struct Peeled {
    /// As large as the photo; transparent where the surfaces that covered a pixel are gone.
    pub picture: Picture,
    /// Where the surface in front has neither photo nor filling nor paint.
    pub hidden: Mask,
}

/// A surface at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Its place in [`PhotoLayers::shapes`].
    pub shape: usize,
    /// Along the camera's axis, in world units.
    pub distance: f64,
    /// The photo shows it there.
    pub visible: bool,
}

/// The layers of one photo in memory.
#[derive(Debug)]
pub struct PhotoLayers {
    /// All surfaces, in no particular order.
    pub shapes: Vec<Shape>,
    camera: Pinhole,
    /// By image layer.
    contents: Vec<Content>,
    /// Places in `shapes`, what is drawn first first: from the last visibility layer to the first, in each as in the
    /// model.
    order: Vec<usize>,
    painted: bool,
    spread_on: bool,
}

/// A photo's own pixels: sRGB as the file has them, in 8 bits, with its valid area as alpha.
///
/// # Errors
/// Those of [`read_photo`].
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
    /// What reading their files and their paint says; [`crate::Error::Cancelled`].
    pub fn read(project: &Path, stack: &Stack, task: &Task) -> Result<Self> {
        let folder = StackStore::new(project).folder(&stack.photo.name);
        let paint = PhotoPaint::open(project, stack)?;
        let shapes = shapes::shapes_of(stack);
        let contents = (0..stack.image_layers.len())
            .into_par_iter()
            .map(|layer| task.go_on().and_then(|()| Content::read(&folder, stack, &paint, layer)))
            .collect::<Result<Vec<_>>>()?;
        let painted = contents.iter().any(Content::is_painted);
        let spread_on = contents.iter().any(Content::is_spread_on);
        let mut order: Vec<usize> = (0..shapes.len()).collect();
        order.sort_by_key(|&at| (std::cmp::Reverse(shapes[at].depth), shapes[at].place));
        let (camera, _) = camera_of(&stack.photo, &stack.camera);
        Ok(Self { shapes, camera, contents, order, painted, spread_on })
    }

    /// Somebody painted on one of them.
    pub fn is_painted(&self) -> bool {
        self.painted
    }

    /// Paint of other photos lies on one of them.
    pub fn is_spread_on(&self) -> bool {
        self.spread_on
    }

    /// Visibility layers.
    pub fn depth(&self) -> u32 {
        self.shapes.iter().map(|shape| shape.depth + 1).max().unwrap_or(0)
    }

    /// The surfaces at a pixel that are left, what is drawn on top first.
    pub fn at(&self, x: i32, y: i32, taken_off: u32) -> Vec<Hit> {
        let here = |&&at: &&usize| {
            let shape = &self.shapes[at];
            shape.depth >= taken_off && shape.covers(x, y)
        };
        let hit = |&at: &usize| {
            let shape = &self.shapes[at];
            let visible = self.contents[shape.layer].is_visible(x, y);
            Hit { shape: at, distance: shape.distance(&self.camera, x, y), visible }
        };
        self.order.iter().rev().filter(here).map(hit).collect()
    }

    /// The pixels of some surfaces that the photo does not show.
    pub fn hidden_of(&self, wanted: impl Fn(&Shape) -> bool) -> Mask {
        let wanted: Vec<&Shape> = self.shapes.iter().filter(|shape| wanted(shape)).collect();
        let bounds = wanted.iter().map(|shape| shape.covered.bounds()).reduce(|all, rect| all.union(&rect));
        let mut mask = Mask::filled(bounds.unwrap_or(PixelRect::EMPTY), false);
        for shape in wanted {
            let content = &self.contents[shape.layer];
            for (y, run) in shape.covered.iter() {
                run.clone().filter(|&x| content.is_hidden(x, y)).for_each(|x| mask.put(x, y, true));
            }
        }
        mask
    }

    /// Takes layers off `photo`, the picture that they are of (as [`photo_picture`] makes it). What is left is drawn
    /// from back to front in the order that the sort found: with nothing taken off it gives the photo back wherever
    /// nobody painted.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn peeled(&self, photo: &Picture, peeling: Peeling, task: &Task) -> Result<Peeled> {
        let mut canvas = Canvas::of(photo);
        if peeling.taken_off > 0 {
            canvas.fade();
            self.shapes.iter().for_each(|shape| canvas.clear(shape));
        }
        let left = self.order.iter().map(|&at| &self.shapes[at]);
        for shape in left.filter(|shape| shape.depth >= peeling.taken_off) {
            task.go_on()?;
            canvas.draw(shape, &self.contents[shape.layer], photo, peeling);
        }
        Ok(Peeled { picture: canvas.picture, hidden: canvas.hidden })
    }
}

/// A picture of a photo's size that is drawn on.
struct Canvas {
    picture: Picture,
    hidden: Mask,
    /// Where the photo shows a surface that is left. Nothing that it hides lies in front of that: where the sort forgave
    /// two surfaces the contact, their layers alone would say so.
    shown: Mask,
}

impl Canvas {
    fn of(photo: &Picture) -> Self {
        let none = Mask::filled(photo.rect(), false);
        Self { picture: photo.clone(), hidden: none.clone(), shown: none }
    }

    fn fade(&mut self) {
        let faded: [u8; 256] = std::array::from_fn(|value| (value as f32 * AROUND).round() as u8);
        self.picture.rgba.as_chunks_mut::<4>().0.iter_mut().for_each(|pixel| {
            pixel[..3].iter_mut().for_each(|value| *value = faded[usize::from(*value)]);
        });
    }

    fn clear(&mut self, shape: &Shape) {
        for (y, run) in shape.covered.iter() {
            let (from, to) = (self.index(run.start, y), self.index(run.end, y));
            self.picture.rgba[4 * from..4 * to].fill(0);
        }
    }

    fn draw(&mut self, shape: &Shape, content: &Content, photo: &Picture, peeling: Peeling) {
        for (y, run) in shape.covered.iter() {
            for x in run.clone() {
                let at = 4 * self.index(x, y);
                let pixel = &mut self.picture.rgba[at..at + 4];
                let texel = content.texel(x, y, peeling.filling, peeling.paint);
                match texel {
                    Texel::Nothing => continue,
                    Texel::Hidden | Texel::Filling(_) if self.shown.holds(x, y) => continue,
                    // What the photo shows there is masked, and still the photo.
                    Texel::Hidden if peeling.taken_off == 0 => continue,
                    Texel::Hidden => pixel.copy_from_slice(&HIDDEN),
                    Texel::Photo => pixel.copy_from_slice(&photo.rgba[at..at + 4]),
                    Texel::Spread(colour) => {
                        pixel.copy_from_slice(&photo.rgba[at..at + 4]);
                        lay_over(colour, pixel);
                    }
                    Texel::Filling(colour) | Texel::Paint(colour) => lay_over(colour, pixel),
                }
                self.hidden.put(x, y, texel == Texel::Hidden);
                self.shown.put(x, y, matches!(texel, Texel::Photo | Texel::Spread(_)));
            }
        }
    }

    fn index(&self, x: i32, y: i32) -> usize {
        y as usize * self.picture.width as usize + x as usize
    }
}

/// A colour over a pixel, neither premultiplied; in gamma, as image editors do it. Not `raster::over::straight`, which is
/// in double precision: where both are soft the two round one pixel in some 10,000 differently, and these pictures stay.
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
