//! The layered depth image of all that the photos together show, for any camera: the projective renderer peels the model layer by
//! layer, and each layer's colours are its blend of the photos at exactly that point. So colours are resampled once, and
//! surfaces that the camera does not see have colours where any photo shows them.
//!
//! Gortler, He & Cohen 1997, section 2.1, make such images with a ray tracer that keeps every hit.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::cover::{FoundPixel, OnRelief};
use super::figures::named;
use super::options::{SiteLdiOptions, StackLdiOptions};
use super::planes::SurfacePlane;
use super::reference_camera::ReferenceCamera;
use super::site::LdiSite;
use super::site_origins::{find_origins, of_origins};
use super::standing::Standing;
use quadratura_base::error::Result;
use quadratura_base::geometry::{InverseDepth, Pinhole, PixelRect, Pose};
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{Model, PhotoId};
use quadratura_base::task::Task;
use quadratura_files::hash::Hashing;
use quadratura_layers::projected_model::{Item, ProjectedModel};
use quadratura_ldi::finish::{SampleCounts, Unfinished};
use quadratura_ldi::{CommonCamera, DepthPixelOrigin, Ldi, LdiKind};
use quadratura_projection::peeling::{Peeled, PeeledLayer, Peels, PlanarPart};
use quadratura_projection::relief::Relief;
use quadratura_view::agreement::AgreementGrid;
use quadratura_view::{Exposure, Shot};
use quadratura_views::preview::Preview;

/// The least alpha of a depth pixel of a skirt.
const LEAST_ALPHA: u8 = 3;

/// What the layered depth image of a site is made of, besides its renderer.
pub struct SiteSource<'a> {
    /// The camera.
    pub reference: ReferenceCamera,
    /// The names of the photos, the reference photo first.
    pub sources: Vec<String>,
    /// Photos that must not take part.
    pub without: &'a [PhotoId],
    /// The hash of everything that the renderer shows.
    pub inputs: String,
    /// How far the reference photo's surroundings are confirmed to be far away, by positions in the photo as large as it is in the
    /// frame; `None` without such a photo, and where surroundings are not in the image.
    pub agreement: Option<AgreementGrid>,
}

/// Makes the layered depth image of a site.
///
/// # Errors
/// [`quadratura_base::Error::Request`] for a frame that is too large, [`quadratura_base::Error::Gpu`], the errors of reading layers, or
/// [`quadratura_base::Error::Cancelled`].
pub fn ldi_of_site(
    preview: &mut Preview,
    source: &SiteSource,
    options: &SiteLdiOptions,
    task: &Task,
) -> Result<Ldi> {
    let SiteSource { reference, sources, without, inputs, agreement } = source;
    let frame = reference.frame(options.scale, options.guard)?;
    let CommonCamera { camera, pose, photo_rect, gain } = frame;
    let exposure = reference.photo.map_or(Exposure::Common, Exposure::Of);
    let without = without.to_vec();
    let shot = Shot { backs: false, exposure, relief: options.relief, without, ..Shot::new(camera, pose) };
    let shot = preview.beyond_backdrops(&shot);
    let (_, relief) = preview.estimates_without(&shot.without, task)?;
    let relief = relief.filter(|_| options.relief);
    let peels = preview.peels(&shot, task)?;
    let mut peeled = PeeledPixels::new(peels, &frame, relief, options.layers);
    task.timed("peel", || peeled.peel(peels, &shot, options, agreement.is_some(), task))?;
    if !preview.shows_only_photos() {
        let shot = of_origins(&shot);
        let peels = preview.peels(&shot, task)?;
        task.timed("origins", || find_origins(&mut peeled.rows, peeled.surroundings, peels, &shot, task))?;
    }
    let (mut rows, planes, mut counts) = task.timed("cover", || peeled.finish());
    if let (Some(agreement), Some(photo)) = (agreement, photo_rect) {
        let standing = Standing { width: camera.width as usize, photo, agreement, filled: options.filled };
        counts.samples += task.timed("outlines", || standing.moved(&mut rows));
    }
    let named = named(&planes, rows);
    counts.unknown_surfaces = named.unknown;
    let words = options.described();
    let mut hashing = Hashing::default();
    hashing.add(format!("{frame:?} {words:?} {inputs}").as_bytes());
    let unfinished = Unfinished {
        kind: LdiKind::Site,
        inputs: hashing.hash(),
        camera,
        pose,
        photo_rect,
        gain,
        surfaces: named.surfaces,
        sources: sources.clone(),
        rows: named.rows,
        counts,
        options: words,
    };
    unfinished.finish(task)
}

/// The nearest face at a pixel that is not see-through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FrontFace {
    /// There is none.
    Nothing,
    /// One that some photo shows.
    Shown,
    /// One that no photo shows.
    Hole,
}

/// The layers that were peeled off, as depth pixels.
struct PeeledPixels {
    width: usize,
    /// The planes of the parts; `None` where the camera does not see one. The last one is that of the surroundings.
    planes: Vec<Option<SurfacePlane>>,
    /// Whether one sees through each part in places.
    sees_through: Vec<bool>,
    relief: Option<OnRelief>,
    most: usize,
    own_rect: Option<PixelRect>,
    /// The depth pixels of each row, layer after layer.
    rows: Vec<Vec<FoundPixel>>,
    /// What is nearest at each pixel.
    nearest: Vec<FrontFace>,
    counts: SampleCounts,
    /// The first part that is a skirt, of those that were met.
    first_skirt: u32,
    /// The plane of the surroundings where they are in it.
    surroundings: Option<u32>,
}

impl PeeledPixels {
    fn new(peels: &dyn Peels, frame: &CommonCamera, relief: Option<Arc<Relief>>, most: usize) -> Self {
        let CommonCamera { camera, pose, photo_rect, .. } = *frame;
        let (model, parts) = peels.parts();
        let model = model.facing(&Facing::of_pose(&pose));
        let sees_through = |part: &PlanarPart| model.sees_through(part.face);
        let (width, height) = (camera.width as usize, camera.height as usize);
        Self {
            width,
            sees_through: parts.iter().map(sees_through).collect(),
            planes: planes_of(&model, &parts, &camera, &pose),
            relief: relief.map(|relief| OnRelief { camera, pose, model, relief }),
            most,
            own_rect: photo_rect,
            rows: vec![Vec::new(); height],
            nearest: vec![FrontFace::Nothing; width * height],
            counts: SampleCounts::default(),
            first_skirt: u32::MAX,
            surroundings: None,
        }
    }

    /// Peels off the model's layers, and then what is where it has none. `own_rises` tells whether what rises above outlines in the
    /// reference photo will come to their depth.
    fn peel(
        &mut self,
        peels: &mut dyn Peels,
        shot: &Shot,
        options: &SiteLdiOptions,
        own_rises: bool,
        task: &Task,
    ) -> Result<()> {
        let mut number = 0;
        let mut each = |layer: PeeledLayer| {
            self.add_faces(&layer, number == 0);
            number += 1;
            task.step("layers", number, number + 1)?;
            Ok(true)
        };
        peels.peel(shot, Peeled::Faces, &mut each, task)?;
        if !options.surroundings {
            return Ok(());
        }
        // What rises above outlines in the reference photo comes to their depth itself.
        let beside = if own_rises { self.own_rect } else { None };
        let mut each = |layer: PeeledLayer| {
            self.add_skirts(&layer, beside.as_ref());
            Ok(true)
        };
        peels.peel(shot, Peeled::Skirts, &mut each, task)?;
        let picture = peels.surroundings(shot, task)?;
        self.add_surroundings(picture.pixels());
        Ok(())
    }

    /// Adds a layer of the model.
    fn add_faces(&mut self, layer: &PeeledLayer, is_first: bool) {
        let Self { width, planes, relief, own_rect, rows, nearest, sees_through, .. } = self;
        let added = rows.par_iter_mut().zip(nearest.par_chunks_exact_mut(*width)).enumerate();
        let counts = added.map(|(y, (row, nearest))| {
            let mut counts = SampleCounts::default();
            let at = y * *width..(y + 1) * *width;
            let pixels = layer.parts[at.clone()].iter().zip(&layer.colours[at]);
            for (x, ((part, colour), nearest)) in pixels.zip(nearest).enumerate() {
                let Some(plane) = part.checked_sub(1) else { continue };
                let is_hole = colour[3] == 0 && !sees_through[plane as usize];
                if *nearest == FrontFace::Nothing && !sees_through[plane as usize] {
                    *nearest = if is_hole { FrontFace::Hole } else { FrontFace::Shown };
                }
                counts.samples += 1;
                counts.empty += u64::from(is_hole);
                if colour[3] == 0 {
                    continue;
                }
                let own = |rect: &PixelRect| is_first && rect.contains(x as i32, y as i32);
                let is_own = own_rect.as_ref().is_some_and(own);
                let origin = if is_own { DepthPixelOrigin::Photo } else { DepthPixelOrigin::OtherPhotos };
                let place = [x as u32, y as u32];
                let Some(of_part) = &planes[plane as usize] else { continue };
                let Some(flat) = of_part.at(place[0], place[1]) else { continue };
                let inverse_depth = relief.as_ref().map_or(flat, |on| on.moved(of_part.id, place, flat));
                row.push(FoundPixel { column: x as u16, origin, inverse_depth, colour: *colour, plane });
            }
            counts
        });
        self.counts += counts.reduce(SampleCounts::default, |mut sum, counts| {
            sum += counts;
            sum
        });
    }

    /// Adds what stands on the outlines of the model, where no face is, outside of a part of the frame.
    fn add_skirts(&mut self, layer: &PeeledLayer, but: Option<&PixelRect>) {
        let Self { width, planes, rows, nearest, counts, first_skirt, .. } = self;
        for (i, (part, colour)) in layer.parts.iter().zip(&layer.colours).enumerate() {
            let is_shown = nearest[i] == FrontFace::Nothing && colour[3] >= LEAST_ALPHA;
            let Some(plane) = part.checked_sub(1).filter(|_| is_shown) else { continue };
            *first_skirt = (*first_skirt).min(plane);
            let (x, y) = (i % *width, i / *width);
            if but.is_some_and(|rect| rect.contains(x as i32, y as i32)) {
                continue;
            }
            let inverse_depth =
                planes[plane as usize].as_ref().and_then(|plane| plane.at(x as u32, y as u32));
            let Some(inverse_depth) = inverse_depth else { continue };
            counts.samples += 1;
            let origin = DepthPixelOrigin::OtherPhotos;
            rows[y].push(FoundPixel { column: x as u16, origin, inverse_depth, colour: *colour, plane });
        }
    }

    /// Adds the surroundings behind everything but holes that the camera sees, in which they must not appear.
    fn add_surroundings(&mut self, pixels: &[[u8; 4]]) {
        let plane = self.planes.len() as u32;
        self.planes.push(Some(SurfacePlane::of_surroundings()));
        self.surroundings = Some(plane);
        for (i, &[r, g, b, alpha]) in pixels.iter().enumerate() {
            if alpha > 0 && self.nearest[i] != FrontFace::Hole {
                let (x, y) = (i % self.width, i / self.width);
                self.counts.samples += 1;
                // Where no face is, the reference photo shows itself, whatever others show.
                let own = self.nearest[i] == FrontFace::Nothing
                    && self.own_rect.is_some_and(|rect| rect.contains(x as i32, y as i32));
                let origin = if own { DepthPixelOrigin::Photo } else { DepthPixelOrigin::OtherPhotos };
                self.rows[y].push(FoundPixel {
                    column: x as u16,
                    origin,
                    inverse_depth: 0.0,
                    colour: [r, g, b, u8::MAX],
                    plane,
                });
            }
        }
    }

    /// Returns the depth pixels of each row in the order of the layout, the planes that they name, and what was counted.
    fn finish(self) -> (Vec<Vec<FoundPixel>>, Vec<SurfacePlane>, SampleCounts) {
        let Self { rows, planes, mut counts, most, first_skirt, .. } = self;
        // Planes that the camera does not see have no depth pixels.
        let planes: Vec<SurfacePlane> =
            planes.into_iter().map(|plane| plane.unwrap_or_else(SurfacePlane::of_surroundings)).collect();
        let ordered: Vec<(Vec<FoundPixel>, u64)> =
            rows.into_par_iter().map(|row| ordered(row, most, first_skirt)).collect();
        counts.dropped += ordered.iter().map(|(_, dropped)| dropped).sum::<u64>();
        (ordered.into_iter().map(|(row, _)| row).collect(), planes, counts)
    }
}

/// Sorts the depth pixels of a row, which come layer after layer, by column, and keeps `most` layers of the model at each
/// position: the nearest ones and the farthest one. Returns how many were dropped, too. Parts from `first_skirt` on may be before
/// others that came earlier.
fn ordered(mut row: Vec<FoundPixel>, most: usize, first_skirt: u32) -> (Vec<FoundPixel>, u64) {
    row.sort_by_key(|found| found.column);
    for pixel in row.chunk_by_mut(|a, b| a.column == b.column) {
        if pixel.iter().any(|found| found.plane >= first_skirt && found.inverse_depth > 0.0) {
            pixel.sort_by(|a, b| b.inverse_depth.total_cmp(&a.inverse_depth));
        }
    }
    let mut kept = Vec::with_capacity(row.len());
    let mut dropped = 0;
    for pixel in row.chunk_by(|a, b| a.column == b.column) {
        let of_model = pixel.iter().filter(|found| found.inverse_depth > 0.0).count();
        let mut nearer = f32::INFINITY;
        for (k, found) in pixel.iter().enumerate() {
            if (most.saturating_sub(1)..of_model.saturating_sub(1)).contains(&k) {
                dropped += 1;
                continue;
            }
            // The order is the model's: relief does not move a surface in front of a nearer one.
            nearer = found.inverse_depth.min(nearer.next_down()).max(0.0);
            kept.push(FoundPixel { inverse_depth: nearer, ..*found });
        }
    }
    (kept, dropped)
}

/// Returns the planes of a model's parts as a camera sees them.
fn planes_of(
    model: &Arc<Model>,
    parts: &[PlanarPart],
    camera: &Pinhole,
    pose: &Pose,
) -> Vec<Option<SurfacePlane>> {
    let view = ProjectedModel::new(model, camera, pose);
    let of_part = |item: &Item| (PlanarPart { face: item.face, triangle: item.triangle }, item.inverse_depth);
    let planes: BTreeMap<PlanarPart, InverseDepth> = view.items.iter().map(of_part).collect();
    let plane = |part: &PlanarPart| Some(SurfacePlane::of_face(model, part.face, *planes.get(part)?));
    parts.iter().map(plane).collect()
}

/// The camera of a layered depth image of the site.
#[derive(Clone, Copy)]
pub struct SiteCamera<'a> {
    /// The camera.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    /// The photo whose camera it is, if it is one's.
    pub photo: Option<PhotoId>,
    /// The photos that are left out.
    pub without: &'a [PhotoId],
}

impl LdiSite<'_> {
    /// Makes the layered depth image of everything that all photos but some know, for a camera, which may be a photo's.
    ///
    /// # Errors
    /// Those of [`ldi_of_site`].
    pub fn ldi_of_site(
        &mut self,
        preview: &mut Preview,
        camera: SiteCamera,
        options: &SiteLdiOptions,
        task: &Task,
    ) -> Result<Ldi> {
        let SiteCamera { camera, pose, photo, without } = camera;
        let site = self.site();
        let (gains, _) = preview.estimates_without(without, task)?;
        let gain = photo.map_or([0.0; 3], |photo| gains.of_photo[photo.index()]);
        let takes_part = |id: &PhotoId| Some(*id) != photo && !without.contains(id) && self.has_stack(*id);
        let photos: Vec<PhotoId> = photo.into_iter().chain(site.photo_ids().filter(takes_part)).collect();
        let mut hashing = Hashing::default();
        let SiteLdiOptions { relief, filled, .. } = *options;
        let stack = StackLdiOptions { relief, filled, ..StackLdiOptions::default() };
        let inputs = photos.iter().filter_map(|photo| self.inputs(*photo, &stack));
        inputs.for_each(|inputs| hashing.add(inputs.as_bytes()));
        let reference = ReferenceCamera { camera, pose, photo, gain };
        let rect = reference.frame(options.scale, options.guard)?.photo_rect;
        let agreement = match (photo, rect) {
            (Some(photo), Some(rect)) if options.surroundings => {
                self.agreement_of(photo, [rect.w, rect.h], task)?
            }
            _ => None,
        };
        let source = SiteSource {
            agreement,
            reference,
            sources: photos.iter().map(|photo| site.photo(*photo).name.clone()).collect(),
            without,
            inputs: hashing.hash(),
        };
        ldi_of_site(preview, &source, options, task)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(column: u16, inverse_depth: f32, plane: u32) -> FoundPixel {
        let (origin, colour) = (DepthPixelOrigin::OtherPhotos, [plane as u8, 0, 0, 255]);
        FoundPixel { column, origin, inverse_depth, colour, plane }
    }

    fn planes(row: &[FoundPixel]) -> Vec<(u16, u32)> {
        row.iter().map(|found| (found.column, found.plane)).collect()
    }

    #[test]
    fn layers_that_come_one_after_the_other_are_put_together_at_each_position() {
        let layers =
            vec![found(3, 0.9, 0), found(5, 0.8, 1), found(3, 0.5, 2), found(5, 0.0, 9), found(3, 0.0, 9)];
        let (row, dropped) = ordered(layers, 10, u32::MAX);
        assert_eq!((planes(&row), dropped), (vec![(3, 0), (3, 2), (3, 9), (5, 1), (5, 9)], 0));
    }

    #[test]
    fn relief_moves_no_layer_in_front_of_a_nearer_one() {
        let (row, _) = ordered(vec![found(0, 0.5, 0), found(0, 0.6, 1), found(0, 0.0, 9)], 10, u32::MAX);
        assert_eq!(planes(&row), [(0, 0), (0, 1), (0, 9)]);
        assert!(row.is_sorted_by(|a, b| a.inverse_depth > b.inverse_depth));
        assert_eq!(row[1].inverse_depth, 0.5f32.next_down());
    }

    #[test]
    fn a_skirt_is_put_where_its_depth_is() {
        let (row, _) = ordered(vec![found(0, 0.5, 0), found(0, 0.7, 7), found(0, 0.0, 9)], 10, 7);
        assert_eq!(planes(&row), [(0, 7), (0, 0), (0, 9)]);
    }

    #[test]
    fn beyond_the_largest_number_the_nearest_layers_and_the_farthest_one_stay_and_the_surroundings() {
        let layers = (0..5u16).map(|k| found(0, 1.0 / f32::from(k + 1), u32::from(k)));
        let layers: Vec<FoundPixel> = layers.chain([found(0, 0.0, 9)]).collect();
        let kept = |most: usize| {
            let (row, dropped) = ordered(layers.clone(), most, u32::MAX);
            (row.iter().map(|found| found.plane).collect::<Vec<_>>(), dropped)
        };
        assert_eq!(kept(3), (vec![0, 1, 4, 9], 2));
        assert_eq!(kept(1), (vec![4, 9], 4));
        assert_eq!(kept(5), (vec![0, 1, 2, 3, 4, 9], 0));
    }
}
