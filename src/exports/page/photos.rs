//! The photos of a page as chunks.

use glam::{DVec2, DVec3};

use super::description::{DescribedPhoto, by_rows};
use super::labels::ByteLabels;
use super::options::{MOST_SIDE, PageOptions};
use super::photo::ComposedPhoto;
use super::plane::{PhotoCells, differences};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::PhotoId;
use quadratura_layers::fill::push_pull::WeightedGrid;
use quadratura_page::chunk::Chunk;
use quadratura_page::pictures::{photo_jpeg, reduced};
use quadratura_projection::Gains;
use quadratura_view::optics::squared_radius;
use quadratura_view::srgb::Srgb;

/// The most pixels along a side of coarse photos: of up to [`MANY`] ones, and of any number.
const COARSE: u32 = 576;
const LEAST_COARSE: u32 = 192;
/// From this number of photos on, coarse ones together keep their number of pixels, because all of them are on the device.
const MANY: usize = 64;
/// Their quality, below that of the others by this.
const COARSE_LOWER: u8 = 10;
/// The number of coarse photos in a chunk.
pub const IN_A_CHUNK: usize = 32;

/// A photo that is ready to be written.
pub struct PackedPhoto {
    /// The fine picture with what is known of its pixels, as a chunk.
    pub near: Chunk,
    /// The coarse picture, and the planes of what is known of its pixels, at half of its size.
    far_picture: Vec<u8>,
    far_planes: PackedPlanes,
    /// What the description says of it.
    pub described: DescribedPhoto,
}

/// Labels, confidence, agreement and outlines of the pixels of a picture, ready to be packed.
type PackedPlanes = [Vec<u8>; 4];
/// The names of their parts.
const PLANES: [&str; 4] = ["labels", "trust", "agreement", "outlines"];

/// How photos are packed.
#[derive(Debug, Clone, Copy)]
pub struct PhotoPacking {
    /// The quality of JPEGs.
    pub quality: u8,
    /// The longest side, in pixels.
    pub longest: u32,
    /// The longest side of coarse photos, in pixels.
    pub longest_coarse: u32,
    /// Whether all pictures are upright ones, which are not turned.
    pub upright: bool,
}

impl PhotoPacking {
    /// Packs so many photos as these options say.
    pub fn new(options: &PageOptions, photos: usize, upright: bool) -> Self {
        let share = (MANY as f64 / photos.max(MANY) as f64).sqrt();
        let longest_coarse = ((f64::from(COARSE) * share).round() as u32).max(LEAST_COARSE);
        Self { quality: options.quality, longest: options.longest.min(MOST_SIDE), longest_coarse, upright }
    }
}

/// A photo with its camera.
#[derive(Debug, Clone, Copy)]
pub struct PhotoToPack<'a> {
    /// Its number in the site.
    pub id: PhotoId,
    /// The name under which it is published.
    pub name: &'a str,
    /// Its camera.
    pub camera: &'a Pinhole,
    /// See [`Self::camera`].
    pub pose: &'a Pose,
    /// The point of the world that is zero on the page.
    pub origin: DVec3,
}

impl PackedPhoto {
    /// Packs a photo. What no layer shows of it has the colours of what is around, out of focus.
    pub fn new(
        photo: &PhotoToPack,
        composed: &ComposedPhoto,
        labels: &ByteLabels,
        gains: &Gains,
        packing: &PhotoPacking,
    ) -> Self {
        let turned = !packing.upright && composed.size[1] > composed.size[0];
        let rgb = surrounded(composed.size, composed.rgb.clone(), |at| composed.labels.is_claimed(at));
        let colour = mean(&rgb);
        let (picture, stored) = reduced(rgb, composed.size, packing.longest);
        let turn = |bytes: &[u8], size: [u32; 2], parts: usize| {
            if turned { turned_right(bytes, size, parts) } else { bytes.to_vec() }
        };
        let size_of = |size: [u32; 2]| if turned { [size[1], size[0]] } else { size };
        let mut near = Chunk::default();
        near.add("colours", &photo_jpeg(&turn(&picture, stored, 3), size_of(stored), packing.quality));
        let (rgb, known) = composed.with_see_through();
        let (small, far) =
            reduced(surrounded(composed.size, rgb, |at| known[at]), composed.size, packing.longest_coarse);
        let coarse_quality = packing.quality.saturating_sub(COARSE_LOWER).max(1);
        let far_picture = photo_jpeg(&turn(&small, far, 3), size_of(far), coarse_quality);
        let plane =
            |bytes: &[u8], size: [u32; 2]| differences(&turn(bytes, size, 1), size_of(size)[0] as usize);
        let planes = |size: [u32; 2], of_weights: [u32; 2], weights: [Vec<u8>; 3]| -> PackedPlanes {
            let of_cells = PhotoCells::new(composed.size, size).map(|middle, _| labels.of_pixel[middle]);
            let [trust, agreement, outlines] = weights.map(|weights| plane(&weights, of_weights));
            [plane(&of_cells, size), trust, agreement, outlines]
        };
        let half = stored.map(|side| side.div_ceil(2));
        let fine = planes(stored, half, composed.weights(PhotoCells::new(composed.size, half)));
        add_planes(&mut near, "", &fine);
        let coarse = far.map(|side| side.div_ceil(2));
        let of_coarse = composed.weights_of_mixed(PhotoCells::new(composed.size, coarse), &labels.of_pixel);
        let optics = gains.optics.get(photo.id.index()).copied().unwrap_or_default();
        let camera = photo.camera;
        let per_px2 = squared_radius(camera, DVec2::new(camera.cx + 1.0, camera.cy));
        let [a, b] = optics.falloff;
        let sky = gains.surroundings.of_photo.get(photo.id.index()).and_then(Option::as_ref);
        let described = DescribedPhoto {
            name: photo.name.to_owned(),
            size: composed.size,
            lens: [camera.fx, camera.fy, camera.cx, camera.cy],
            rotation: by_rows(&photo.pose.rotation),
            centre: (photo.pose.center_in_world() - photo.origin).to_array(),
            stored,
            turned,
            far,
            gain: gains.of_photo.get(photo.id.index()).copied().unwrap_or_default(),
            optics: [optics.offset, a * per_px2, b * per_px2 * per_px2],
            colour,
            sky: sky.map(|sky| sky.offset),
        };
        Self { near, far_picture, far_planes: planes(coarse, coarse, of_coarse), described }
    }

    /// Adds the coarse picture and what is known of its pixels to the chunk of several.
    pub fn add_far(&self, chunk: &mut Chunk) {
        let name = &self.described.name;
        chunk.add(format!("{name}/far"), &self.far_picture);
        add_planes(chunk, &format!("{name}/"), &self.far_planes);
    }
}

/// Adds planes to a chunk, with this before their names.
fn add_planes(chunk: &mut Chunk, before: &str, planes: &PackedPlanes) {
    for (name, plane) in PLANES.into_iter().zip(planes) {
        chunk.add_packed(format!("{before}{name}"), plane);
    }
}

/// Returns the colours of a photo, continued over the pixels that no layer shows.
fn surrounded(size: [u32; 2], mut rgb: Vec<u8>, is_known: impl Fn(usize) -> bool) -> Vec<u8> {
    let count = rgb.len() / 3;
    if (0..count).all(&is_known) {
        return rgb;
    }
    // Colours are continued at a quarter of the size: out of focus by intent, since they may stand for what must not be seen.
    let size = size.map(|side| side as usize);
    let small = size.map(|side| side.div_ceil(4));
    let srgb = Srgb::tables();
    let mut grid = WeightedGrid::new(small);
    for at in (0..count).filter(|at| is_known(*at)) {
        let cell = at / size[0] / 4 * small[0] + at % size[0] / 4;
        (0..3).for_each(|c| grid.values[cell][c] += srgb.linear(rgb[3 * at + c]));
        grid.weights[cell] += 1.0;
    }
    for (value, weight) in grid.values.iter_mut().zip(&mut grid.weights).filter(|(_, weight)| **weight > 0.0)
    {
        value.iter_mut().for_each(|part| *part /= *weight);
        *weight = 1.0;
    }
    let filled = grid.filled().unwrap_or_else(|| vec![[0.2; 3]; small[0] * small[1]]);
    for at in (0..count).filter(|at| !is_known(*at)) {
        let cell = filled[at / size[0] / 4 * small[0] + at % size[0] / 4];
        rgb[3 * at..3 * at + 3].copy_from_slice(&cell.map(|light| srgb.encoded(light)));
    }
    rgb
}

/// Returns a picture of `parts` bytes a pixel, turned by 90 degrees clockwise.
fn turned_right(bytes: &[u8], size: [u32; 2], parts: usize) -> Vec<u8> {
    let [width, height] = size.map(|side| side as usize);
    let mut out = Vec::with_capacity(bytes.len());
    for x in 0..width {
        for y in (0..height).rev() {
            let at = parts * (y * width + x);
            out.extend_from_slice(&bytes[at..at + parts]);
        }
    }
    out
}

/// Returns the mean colour of pixels, as `#rrggbb`.
fn mean(rgb: &[u8]) -> String {
    let mut sums = [0u64; 3];
    rgb.as_chunks::<3>().0.iter().for_each(|pixel| (0..3).for_each(|c| sums[c] += u64::from(pixel[c])));
    let count = (rgb.len() / 3).max(1) as u64;
    let [r, g, b] = sums.map(|sum| sum / count);
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_layer_shows_is_not_published() {
        let size = [40, 30];
        let secret = |at: usize| (15..25).contains(&(at % 40)) && (10..20).contains(&(at / 40));
        let colour = |at: usize| if secret(at) { [255, 0, 255] } else { [100, 120, 140] };
        let rgb: Vec<u8> = (0..1200).flat_map(colour).collect();
        let published = surrounded(size, rgb, |at| !secret(at));
        let far = |pixel: &[u8; 3]| (0..3).any(|c| pixel[c].abs_diff([100, 120, 140][c]) > 2);
        assert_eq!(published.as_chunks::<3>().0.iter().filter(|pixel| far(pixel)).count(), 0);
    }

    #[test]
    fn coarse_photos_together_stop_growing_with_their_number() {
        let pixels = |photos: usize| {
            let side = f64::from(PhotoPacking::new(&PageOptions::default(), photos, false).longest_coarse);
            photos as f64 * side * side
        };
        assert!((pixels(400) / pixels(MANY) - 1.0).abs() < 0.01, "rounding a side changes less");
        assert!(pixels(9) < pixels(MANY));
    }

    #[test]
    fn a_turned_picture_has_its_left_column_as_first_row_from_the_bottom() {
        // a b
        // c d
        // e f
        assert_eq!(turned_right(b"abcdef", [2, 3], 1), b"ecafdb");
    }
}
