//! What photos show of trees, and what the placed trees show there in the light of the sun and of the sky.

use std::path::Path;

use glam::{DVec2, DVec3, Vec3};

use super::fit::{PixelBlock, ground_of_sky};
use crate::mask::ModelNearness;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, PixelRect, Spans};
use quadratura_base::scene::light::LINEAR_FROM_BYTE;
use quadratura_base::scene::{Photo, PhotoId, PhotoPixels, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::masks::{Mask, MaskOrigin, MaskedTree};
use quadratura_foliage::{
    InLights, OutdoorLight, PlacedSpecies, PlacedTrees, Shades, SunShade, Tree, View, draw_in_lights,
};
use quadratura_import::photo::read_photo;
use quadratura_io::mask_store::MaskStore;
use quadratura_projection::Gains;
use quadratura_view::optics::squared_radius;

/// The side of a block in pixels of the photo.
const BLOCK_PX: u32 = 8;
/// The pixels of a photo in one of the drawing, across and down: each is one of its sub-pixels.
const SUBPIXELS: u32 = 4;
/// The pixels of the drawing in a block, across and down.
const DRAWN: u32 = BLOCK_PX / SUBPIXELS;
/// The least share of a block that the placed tree has to cover: between the outer leaves the photo shows what is behind.
const LEAST_COVERED: f64 = 0.9;
/// Photos in which a tree is drawn: those that show most of it. More of them tell little more.
const MOST_PHOTOS: usize = 8;
/// The highest value, of 255, of a pixel that is not clipped.
const BRIGHTEST: u16 = 249;

/// A tree in a photo that shows the real one.
struct PhotographedTree<'a> {
    /// The index of the tree.
    tree: usize,
    mask: &'a Mask,
}

/// The blocks of a photo that show a tree.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeInPhoto {
    /// The index of the tree.
    pub tree: usize,
    /// The photo.
    pub photo: PhotoId,
    /// The pixels of the photo in which the placed tree is.
    pub rect: PixelRect,
    /// The blocks, each with its middle in the photo.
    pub blocks: Vec<(DVec2, PixelBlock)>,
}

/// Returns the blocks of all photos in which trees are masked, by photo and tree. A photo that cannot be read is noted.
///
/// # Errors
/// [`Error::Cancelled`]; [`Error::Input`] and [`Error::Io`] for masks that cannot be read.
pub fn blocks(
    folder: &Path,
    project: &Project,
    site: &Site,
    placed: &PlacedTrees,
    gains: &Gains,
    task: &Task,
) -> Result<Vec<TreeInPhoto>> {
    let photographed = photographed(project, site, placed);
    let total = photographed.iter().filter(|trees| !trees.is_empty()).count() as u64;
    let (mut found, mut done) = (Vec::new(), 0);
    for (id, photo) in site.numbered_photos().filter(|(id, _)| !photographed[id.index()].is_empty()) {
        task.step("light on trees", done, total)?;
        match read_photo(&photo.file, photo.camera.width, photo.camera.height) {
            Ok(pixels) => {
                let of_photo =
                    PhotoWithTrees { folder, project, site, placed, gains, id, photo, pixels: &pixels };
                found.extend(of_photo.blocks(&photographed[id.index()], task)?);
            }
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => {
                let task = task.with_subject(&photo.name);
                task.note("the photo is not used for the light on trees, because it cannot be read");
                task.detail(error.to_string());
            }
        }
        done += 1;
    }
    Ok(found)
}

/// Returns the trees that are masked in each photo, for each tree in those photos that show most of it.
fn photographed<'a>(
    project: &'a Project,
    site: &'a Site,
    placed: &'a PlacedTrees,
) -> Vec<Vec<PhotographedTree<'a>>> {
    let mut photographed: Vec<Vec<PhotographedTree<'_>>> = site.photos.iter().map(|_| Vec::new()).collect();
    for (index, tree) in placed.trees.iter().enumerate() {
        let is_of_it = |mask: &&Mask| matches!(&mask.from, MaskOrigin::Tree(MaskedTree { name, .. }) if *name == tree.name);
        let in_photo = |(id, photo): (PhotoId, &Photo)| {
            let mask = project.masks.of(&photo.name).iter().find(is_of_it)?;
            (mask.pixels > 0).then_some((id, mask))
        };
        let mut masks: Vec<(PhotoId, &Mask)> = site.numbered_photos().filter_map(in_photo).collect();
        masks.sort_by_key(|(id, mask)| (u64::MAX - mask.pixels, *id));
        for (id, mask) in masks.into_iter().take(MOST_PHOTOS) {
            photographed[id.index()].push(PhotographedTree { tree: index, mask });
        }
    }
    photographed
}

/// A photo that shows trees.
struct PhotoWithTrees<'a> {
    folder: &'a Path,
    project: &'a Project,
    site: &'a Site,
    placed: &'a PlacedTrees,
    gains: &'a Gains,
    id: PhotoId,
    photo: &'a Photo,
    pixels: &'a PhotoPixels,
}

impl PhotoWithTrees<'_> {
    fn blocks(&self, photographed: &[PhotographedTree<'_>], task: &Task) -> Result<Vec<TreeInPhoto>> {
        let small = Photo { camera: drawn_camera(&self.photo.camera), ..self.photo.clone() };
        let tolerance = self.project.options.tolerance;
        let model = ModelNearness::new(&self.site.model, &small, tolerance);
        let quiet = Task::silent().with_stop_flag(task.stop_flag());
        let tree = |photographed: &PhotographedTree<'_>| &self.placed.trees[photographed.tree];
        let draw = |photographed: &PhotographedTree<'_>| {
            drawn(self.placed, tree(photographed), &small, &model, &quiet)
        };
        let drawn: Vec<Vec<InLights>> = photographed.iter().map(draw).collect::<Result<_>>()?;
        let others = self.other_masks()?;
        let mut found = Vec::new();
        for (at, of_tree) in photographed.iter().enumerate() {
            let mask = self.read_mask(of_tree.mask)?;
            let width = small.camera.width;
            let mut blocks = Vec::new();
            for [column, row] in block_places(&small.camera) {
                let sums: Vec<InLights> = drawn.iter().map(|of| in_block(of, width, [column, row])).collect();
                let is_other = |(other, sums): (usize, &InLights)| other != at && sums.covered > 0;
                if sums.iter().enumerate().any(is_other) || !is_covered(&sums[at]) {
                    continue;
                }
                let corner = [column * BLOCK_PX, row * BLOCK_PX];
                if let Some(light) = self.light(corner, &mask, &others) {
                    let part = |of: usize| (sums[at].sums[of] / f32::from(sums[at].covered)).as_dvec3();
                    let block = PixelBlock { photo: self.id.index(), sun: part(0), sky: part(1), light };
                    blocks.push((middle_of_block(corner), block));
                }
            }
            let rect = covered_rect(&drawn[at], &small.camera);
            found.push(TreeInPhoto { tree: of_tree.tree, photo: self.id, rect, blocks });
        }
        Ok(found)
    }

    fn read_mask(&self, mask: &Mask) -> Result<Spans> {
        let size = [self.photo.camera.width, self.photo.camera.height];
        MaskStore::new(self.folder).read(&mask.file, size)
    }

    /// Returns the pixels of masks that are not those of trees: what hides trees there is none of the model.
    fn other_masks(&self) -> Result<Spans> {
        let masks = self.project.masks.of(&self.photo.name).iter();
        let others = masks.filter(|mask| !matches!(mask.from, MaskOrigin::Tree(_)));
        others.map(|mask| self.read_mask(mask)).try_fold(Spans::default(), |all, mask| Ok(all.union(&mask?)))
    }

    /// Returns the mean light of a block in the photos' common exposure; `None` where some pixel is not of the tree, not valid
    /// or clipped.
    fn light(&self, [x, y]: [u32; 2], mask: &Spans, others: &Spans) -> Option<DVec3> {
        let mut sum = DVec3::ZERO;
        for (x, y) in (y..y + BLOCK_PX).flat_map(|y| (x..x + BLOCK_PX).map(move |x| (x, y))) {
            let is_of_tree = mask.holds(x as i32, y as i32) && !others.holds(x as i32, y as i32);
            if !is_of_tree || !self.pixels.is_valid(x, y) {
                return None;
            }
            let [r, g, b, _] = self.pixels.rgba16(x, y).map(|sample| sample >> 8);
            if r.max(g).max(b) > BRIGHTEST {
                return None;
            }
            sum += DVec3::from_array([r, g, b].map(|byte| f64::from(LINEAR_FROM_BYTE[usize::from(byte)])));
        }
        let mean = (sum / f64::from(BLOCK_PX * BLOCK_PX)).to_array();
        Some(in_common_exposure(self.gains, self.id, &self.photo.camera, middle_of_block([x, y]), mean))
    }
}

/// Returns the middle of the block with this corner, in pixels of the photo.
fn middle_of_block([x, y]: [u32; 2]) -> DVec2 {
    DVec2::new(f64::from(x), f64::from(y)) + 0.5 * f64::from(BLOCK_PX)
}

/// Returns the pixels of a photo around all that a drawing with this camera covers.
fn covered_rect(drawn: &[InLights], small: &Pinhole) -> PixelRect {
    let covered = small.rect().pixels().zip(drawn).filter(|(_, pixel)| pixel.covered > 0);
    let pixel = |(x, y): (i32, i32)| {
        let side = SUBPIXELS as i32;
        PixelRect { x: side * x, y: side * y, w: SUBPIXELS, h: SUBPIXELS }
    };
    covered.fold(PixelRect::EMPTY, |all, (at, _)| all.hull(&pixel(at)))
}

/// Brings light of a photo at an image point to the photos' common exposure.
pub fn in_common_exposure(
    gains: &Gains,
    id: PhotoId,
    camera: &Pinhole,
    point_px: DVec2,
    light: [f64; 3],
) -> DVec3 {
    let light = gains.optics[id.index()].undone(light, squared_radius(camera, point_px));
    let gain = gains.of_photo[id.index()];
    DVec3::from_array([0, 1, 2].map(|c| light[c] / gain[c].exp()))
}

/// Returns the camera in whose pictures a pixel is as large as [`SUBPIXELS`] of the photo.
fn drawn_camera(camera: &Pinhole) -> Pinhole {
    let scale = f64::from(SUBPIXELS);
    let Pinhole { width, height, fx, fy, cx, cy } = *camera;
    let pixels = |size: u32| size.div_ceil(SUBPIXELS);
    Pinhole {
        width: pixels(width),
        height: pixels(height),
        fx: fx / scale,
        fy: fy / scale,
        cx: cx / scale,
        cy: cy / scale,
    }
}

/// Draws a tree where the model does not hide it, in sunlight and in skylight that a white surface reflects as 1.
fn drawn(
    placed: &PlacedTrees,
    tree: &Tree,
    small: &Photo,
    model: &ModelNearness,
    task: &Task,
) -> Result<Vec<InLights>> {
    let PlacedSpecies { plant, openness, .. } = &placed.species[tree.species];
    let view = View::of_tree(small.camera, &small.pose, &tree.world_from_plant, &plant.whole().bounds.ball);
    let black = OutdoorLight { sun: Vec3::ZERO, sky: Vec3::ZERO, ground: Vec3::ZERO, ..placed.light };
    let of_sun = OutdoorLight { sun: Vec3::ONE, ..black };
    let sky = OutdoorLight { sky: Vec3::ONE, ground: ground_of_sky().as_vec3(), ..black };
    let sun = SunShade::Crown { towards_sun: placed.light.towards_sun, sunlit: tree.sunlit.as_deref() };
    let shades = openness.as_deref().map(|openness| Shades { sun, openness });
    draw_in_lights(plant, &view, [of_sun, sky], model.inverse_depths(), shades.as_ref(), task)
}

/// Returns the column and row of each whole block of a photo, of whose drawing this is the camera.
fn block_places(small: &Pinhole) -> impl Iterator<Item = [u32; 2]> + use<> {
    // The last pixel of the drawing may reach beyond the photo.
    let (columns, rows) = ((small.width - 1) / DRAWN, (small.height - 1) / DRAWN);
    (0..rows).flat_map(move |row| (0..columns).map(move |column| [column, row]))
}

/// Sums up what a drawing shows in a block.
fn in_block(drawn: &[InLights], width: u32, [column, row]: [u32; 2]) -> InLights {
    let mut all = InLights { covered: 0, sums: [Vec3::ZERO; 2] };
    for y in DRAWN * row..DRAWN * (row + 1) {
        for pixel in &drawn[(y * width + DRAWN * column) as usize..][..DRAWN as usize] {
            all.covered += pixel.covered;
            (0..2).for_each(|of| all.sums[of] += pixel.sums[of]);
        }
    }
    all
}

fn is_covered(block: &InLights) -> bool {
    f64::from(block.covered) >= LEAST_COVERED * f64::from(BLOCK_PX * BLOCK_PX)
}
