//! The depth pixels of one row of a stack: all surfaces that cover each pixel's centre, nearest first.

use std::ops::Range;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::covered_planes::{CoveredPlane, CoveredPlanes};
use super::planes::SurfacePlane;
use super::texels::{LayerTexel, LayerTexels};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::raster::in_8_bits;
use quadratura_base::scene::{FaceId, Model, PhotoPixels};
use quadratura_layers::is_behind;
use quadratura_ldi::DepthPixelOrigin;
use quadratura_ldi::finish::SampleCounts;
use quadratura_projection::relief::Relief;

/// The largest number of depth pixels at one position, which files count in one byte.
const MOST_LAYERS: usize = u8::MAX as usize;

/// A depth pixel that was found, with the number of its plane, or [`super::figures::UNKNOWN_PLANE`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundPixel {
    pub column: u16,
    pub origin: DepthPixelOrigin,
    pub inverse_depth: f32,
    pub colour: [u8; 4],
    pub plane: u32,
}

/// The photo's pixels that show only faces in no image layer.
#[derive(Debug)]
pub struct LeftoverPixels {
    /// These faces.
    pub surfaces: CoveredPlanes,
    /// The columns of such pixels by row.
    pub columns: Vec<Vec<Range<u32>>>,
    /// The photo, without what is masked; `None` where there are no such pixels.
    pub photo: Option<PhotoPixels>,
    /// The plane of the surroundings where some of the pixels show these.
    pub surroundings: Option<u32>,
}

/// The relief that surfaces are moved to.
pub struct OnRelief {
    pub camera: Pinhole,
    pub pose: Pose,
    /// The model as the photo sees it.
    pub model: Arc<Model>,
    pub relief: Arc<Relief>,
}

impl OnRelief {
    /// Returns the inverse depth of a point of a face at the centre of a pixel, moved along its ray to the relief.
    pub fn moved(&self, face: Option<FaceId>, [x, y]: [u32; 2], inverse_depth: f32) -> f32 {
        let Some((face, relief)) = face.and_then(|face| Some((face, self.relief.of(face)?))) else {
            return inverse_depth;
        };
        let ray = self.camera.ray_in_camera(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let on_plane: DVec3 = self.pose.world_from_camera(ray / f64::from(inverse_depth));
        let normal = self.model.face(face).plane.normal;
        let met = relief.meet(self.pose.center_in_world(), on_plane, normal);
        let depth = self.pose.camera_from_world(met).z;
        if depth > 0.0 { (1.0 / depth) as f32 } else { inverse_depth }
    }
}

/// A stack, prepared for the walk over its rows.
pub struct Cover {
    /// The image layers: surfaces and texels.
    pub layers: Vec<(CoveredPlanes, LayerTexels)>,
    pub leftovers: LeftoverPixels,
    pub planes: Vec<SurfacePlane>,
    /// The relative tolerance within which surfaces are level.
    pub tolerance: f32,
    /// `None` leaves surfaces flat.
    pub relief: Option<OnRelief>,
}

/// A surface at a pixel with its texel.
#[derive(Debug, Clone, Copy)]
struct SurfaceTexel {
    column: u16,
    inverse_depth: f32,
    rank: u32,
    plane: u32,
    texel: LayerTexel,
    sees_through: bool,
}

impl Cover {
    /// Returns the depth pixels of a row, by column, in a column nearest first.
    pub fn row(&self, y: u32) -> (Vec<FoundPixel>, SampleCounts) {
        let mut samples = Vec::new();
        for (surfaces, texels) in &self.layers {
            if (texels.rect.y..texels.rect.bottom()).contains(&(y as i32)) {
                self.sample_layer(surfaces, texels, y, &mut samples);
            }
        }
        self.sample_leftovers(y, &mut samples);
        let falling = |a: &SurfaceTexel, b: &SurfaceTexel| b.inverse_depth.total_cmp(&a.inverse_depth);
        samples.sort_by(|a, b| {
            a.column.cmp(&b.column).then(falling(a, b)).then(a.rank.cmp(&b.rank)).then(a.plane.cmp(&b.plane))
        });
        let mut counts = SampleCounts { samples: samples.len() as u64, ..SampleCounts::default() };
        let mut found = Vec::with_capacity(samples.len());
        for pixel in samples.chunk_by(|a, b| a.column == b.column) {
            self.find(pixel, y, &mut found, &mut counts);
        }
        (found, counts)
    }

    /// Adds the samples of an image layer in a row: one at each pixel that it covers, of its nearest surface there.
    fn sample_layer(
        &self,
        surfaces: &CoveredPlanes,
        texels: &LayerTexels,
        y: u32,
        samples: &mut Vec<SurfaceTexel>,
    ) {
        let (left, right) = (texels.rect.x, texels.rect.right());
        // The nearest inverse depth, and the surface that is shown with its own.
        let mut owners: Vec<Option<(f32, f32, &CoveredPlane)>> = vec![None; texels.rect.w as usize];
        for surface in surfaces.in_row(y as i32) {
            let plane = &self.planes[surface.plane as usize];
            for run in surface.covered.row(y as i32) {
                for x in run.start.max(left)..run.end.min(right) {
                    let Some(new) = plane.at(x as u32, y) else { continue };
                    let owner = &mut owners[(x - left) as usize];
                    match owner {
                        Some((nearest, ..)) if is_behind(new, *nearest, self.tolerance) => (),
                        // Of level ones the last in the model's order stays.
                        Some((nearest, ..)) => *owner = Some((nearest.max(new), new, surface)),
                        None => *owner = Some((new, new, surface)),
                    }
                }
            }
        }
        for (x, owner) in (left..right).zip(owners).filter(|(x, _)| texels.covers(*x, y as i32)) {
            let owner = owner.map(|(_, inverse_depth, surface)| (inverse_depth, surface));
            let Some((inverse_depth, surface)) = owner.or_else(|| self.beside(surfaces, x, y)) else {
                continue;
            };
            samples.push(SurfaceTexel {
                column: x as u16,
                inverse_depth,
                rank: surface.rank,
                plane: surface.plane,
                texel: texels.at(x, y as i32),
                sees_through: texels.sees_through,
            });
        }
    }

    /// Returns the surface next to a pixel, with its inverse depth at the pixel.
    fn beside<'a>(&self, surfaces: &'a CoveredPlanes, x: i32, y: u32) -> Option<(f32, &'a CoveredPlane)> {
        let surface = surfaces.beside(x, y as i32)?;
        Some((self.planes[surface.plane as usize].at(x as u32, y)?, surface))
    }

    /// Adds the samples of pixels that show only faces in no image layer: the photo's colour at the nearest of these faces.
    fn sample_leftovers(&self, y: u32, samples: &mut Vec<SurfaceTexel>) {
        let LeftoverPixels { surfaces, columns, photo, surroundings } = &self.leftovers;
        let (Some(photo), Some(runs)) = (photo, columns.get(y as usize)) else { return };
        for x in runs.iter().cloned().flatten().filter(|&x| photo.is_valid(x, y)) {
            let here = surfaces.in_row(y as i32).filter(|surface| surface.covered.holds(x as i32, y as i32));
            let with_depth =
                here.filter_map(|surface| Some((self.planes[surface.plane as usize].at(x, y)?, surface)));
            let nearest = with_depth.max_by(|a, b| a.0.total_cmp(&b.0));
            let face = || nearest.or_else(|| self.beside(surfaces, x as i32, y));
            let around = surroundings.map(|plane| (0.0, plane, u32::MAX));
            let of_face =
                |(inverse_depth, surface): (f32, &CoveredPlane)| (inverse_depth, surface.plane, surface.rank);
            let place = match nearest {
                Some(nearest) => Some(of_face(nearest)),
                None => around.or_else(|| face().map(of_face)),
            };
            let Some((inverse_depth, plane, rank)) = place else { continue };
            let [r, g, b, _] = photo.rgba16(x, y).map(in_8_bits);
            let texel =
                LayerTexel { colour: [r, g, b, u8::MAX], visible: true, origin: DepthPixelOrigin::Photo };
            samples.push(SurfaceTexel {
                column: x as u16,
                inverse_depth,
                rank,
                plane,
                texel,
                sees_through: false,
            });
        }
    }

    /// Makes the depth pixels of one position of its samples, which are sorted by falling inverse depth.
    fn find(&self, samples: &[SurfaceTexel], y: u32, found: &mut Vec<FoundPixel>, counts: &mut SampleCounts) {
        let level = |first: &SurfaceTexel, other: &SurfaceTexel| {
            !is_behind(other.inverse_depth, first.inverse_depth, self.tolerance)
        };
        let mut kept: Vec<&SurfaceTexel> = Vec::new();
        let mut rest = samples;
        while let Some(first) = rest.first() {
            let (group, farther) = rest.split_at(rest.partition_point(|sample| level(first, sample)));
            rest = farther;
            counts.merged += group.len() as u64 - 1;
            let best =
                |sample: &&SurfaceTexel| (sample.texel.visible, sample.texel.colour[3] > 0, sample.rank);
            kept.extend(group.iter().max_by_key(best));
        }
        // Where an overlap was forgiven, what is hidden does not cover what the photo shows.
        let farthest_visible = kept.iter().rposition(|sample| sample.texel.visible).unwrap_or(0);
        let mut before = 0;
        kept.retain(|sample| {
            before += 1;
            sample.texel.visible || before > farthest_visible
        });
        let is_empty = |sample: &&SurfaceTexel| sample.texel.colour[3] == 0;
        counts.empty += kept.iter().filter(|sample| is_empty(sample) && !sample.sees_through).count() as u64;
        kept.retain(|sample| !is_empty(sample));
        if kept.len() > MOST_LAYERS {
            counts.dropped += (kept.len() - MOST_LAYERS) as u64;
            kept.drain(MOST_LAYERS - 1..kept.len() - 1);
        }
        let mut nearer = f32::INFINITY;
        for sample in kept {
            let SurfaceTexel { column, inverse_depth, plane, texel, .. } = *sample;
            let flat = || inverse_depth;
            let face = self.planes[plane as usize].id;
            let place = [u32::from(column), y];
            let moved = self.relief.as_ref().map_or_else(flat, |on| on.moved(face, place, inverse_depth));
            // The order is the model's: relief does not move a surface in front of a nearer one.
            nearer = moved.min(nearer.next_down()).max(0.0);
            found.push(FoundPixel {
                column,
                origin: texel.origin,
                inverse_depth: nearer,
                colour: texel.colour,
                plane,
            });
        }
    }
}
