//! The recipe of one photo: other photos, then what is invented, then the seam.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cells::{CELL_LEVEL, Cells};
use super::donor::{Donor, Donors};
use super::givers::{Given, Giver, Place, given, givers};
use super::plate::{Plate, Plates, Side};
use super::region::{HiddenSpan, Region};
use super::remnant::Remnant;
use super::seam::seam;
use super::surfaces::{Surface, Surfaces};
use super::{DIFFUSED_CONFIDENCE, FillOptions, INVENTED_CONFIDENCE, Origin};
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::projection::relief::Relief;
use crate::projection::srgb::Srgb;
use crate::projection::weights::pixels_per_unit;
use crate::projection::{Gains, PhotoId, Projector};
use crate::scene::light::srgb_of_linear;
use crate::task::Task;

/// What all photos of a site share.
pub struct Ground<'a> {
    /// In the site's order.
    pub photos: &'a [Projector],
    /// Of the model in world coordinates.
    pub surfaces: &'a Surfaces,
    /// By face, the photos that have it in their working set, rising.
    pub serving: &'a [Vec<PhotoId>],
    /// How far the true surface stands off the model's.
    pub relief: &'a Relief,
    /// How much brighter each photo is than the common exposure.
    pub gains: &'a Gains,
    /// What the user decided.
    pub options: &'a FillOptions,
    /// The photos themselves.
    pub source: &'a dyn Donors,
}

impl Ground<'_> {
    /// These photos, ready to give; those that cannot be read are left out.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn donors(&self, photos: &[PhotoId]) -> Result<Vec<(PhotoId, Arc<Donor>)>> {
        let donor = |photo: &PhotoId| Ok(self.source.donor(*photo)?.map(|donor| (*photo, donor)));
        photos.iter().filter_map(|photo| donor(photo).transpose()).collect()
    }

    /// The point of the true surface over a point of the plane.
    pub fn risen(&self, surface: &Surface, on_plane: DVec3) -> DVec3 {
        let height = self.relief.of(surface.face).map_or(0.0, |relief| relief.height(on_plane));
        on_plane + surface.plane.normal * height
    }

    /// The point of the true surface that is seen where the plane would be.
    fn met(&self, surface: &Surface, eye: DVec3, on_plane: DVec3) -> DVec3 {
        let relief = self.relief.of(surface.face);
        relief.map_or(on_plane, |relief| relief.meet(eye, on_plane, surface.plane.normal))
    }
}

/// A filled texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Texel {
    /// In the photo's own encoding, full range of 16 bits.
    pub rgb: [u16; 3],
    /// In 255ths, at least one.
    pub confidence: u8,
    /// Where it comes from.
    pub origin: Origin,
}

/// The texels of a region, as its spans count them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilledRegion {
    /// What was hidden.
    pub region: Region,
    /// One a hidden pixel.
    pub texels: Vec<Texel>,
}

/// What was filled of a photo.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Filled {
    /// In the order of the regions.
    pub regions: Vec<FilledRegion>,
}

/// Photos that give to one photo at most: more give nothing new. Where photos are so large that memory does
/// not hold as many, fewer do.
const MOST_DONORS: usize = 24;

/// A billboard is filled from photos that see it from nearly the same direction, ten degrees or less: what is
/// seen through leaves moves behind them.
const BILLBOARD_ANGLE: f64 = 0.17;

/// Side of a block of pixels that asks the same photos.
const BLOCK: u32 = 32;

/// Fills the hidden regions of a photo. Plates that are needed are made and kept for the next photo.
///
/// # Errors
/// [`Error::Request`] when the photo itself cannot be read, [`Error::Cancelled`].
pub fn fill_photo(
    ground: &Ground,
    photo: PhotoId,
    regions: Vec<Region>,
    plates: &mut Plates,
    task: &Task,
) -> Result<Filled> {
    let own = ground.source.donor(photo)?;
    let own = own.ok_or_else(|| Error::Request("the photo cannot be read, so it cannot be filled".into()))?;
    let donors = ground.donors(&nearest_donors(ground, photo, &regions))?;
    let job = Job { ground, photo, own: &own, donors: &donors };
    let regions: Vec<Region> = regions.into_iter().filter(|region| job.side(region).is_some()).collect();
    let from_photos = task.timed("from photos", || job.ask(&regions, task))?;
    let lacking = regions.iter().zip(&from_photos).filter(|(_, texels)| texels.iter().any(Option::is_none));
    // A billboard has no picture of its own in its plane.
    let flat = lacking.filter(|(region, _)| !ground.surfaces.get(region.surface).billboard);
    let sides: Vec<Side> = flat.filter_map(|(region, _)| job.side(region)).collect();
    task.timed("invent", || plates.make(ground, sides, task))?;
    let finish = |(region, given): (Region, Vec<Option<Given>>)| {
        task.go_on()?;
        Ok(job.finish(region, &given, plates))
    };
    let regions: Vec<_> = regions.into_iter().zip(from_photos).collect();
    let regions = task.timed("seams", || regions.into_par_iter().map(finish).collect::<Result<_>>())?;
    Ok(Filled { regions })
}

/// The photos that have most of what is hidden in their working sets, rising.
fn nearest_donors(ground: &Ground, photo: PhotoId, regions: &[Region]) -> Vec<PhotoId> {
    let mut shared = vec![0usize; ground.photos.len()];
    for region in regions {
        let face = ground.surfaces.get(region.surface).face;
        for other in &ground.serving[face.0 as usize] {
            shared[other.0 as usize] += region.texels();
        }
    }
    shared[photo.0 as usize] = 0;
    let mut order: Vec<usize> = (0..shared.len()).filter(|i| shared[*i] > 0).collect();
    order.sort_by_key(|i| (std::cmp::Reverse(shared[*i]), *i));
    order.truncate(MOST_DONORS.min(ground.source.at_once()));
    order.sort_unstable();
    order.into_iter().map(|i| PhotoId(i as u32)).collect()
}

struct Job<'a> {
    ground: &'a Ground<'a>,
    photo: PhotoId,
    own: &'a Donor,
    donors: &'a [(PhotoId, Arc<Donor>)],
}

/// The place of a row's first texel in its region, and what is given to each.
type GivenRow = (usize, Vec<Option<Given>>);

/// Hidden pixels of one region within one block.
struct Block<'a> {
    region: usize,
    corner: [u32; 2],
    spans: Vec<&'a HiddenSpan>,
}

impl Job<'_> {
    /// The surface of a region and which side of it the photo sees.
    fn side(&self, region: &Region) -> Option<Side> {
        let item = self.own.item(region.surface)?;
        Some((region.surface, self.own.seen(item).back))
    }

    /// What other photos give, a value a hidden pixel.
    fn ask(&self, regions: &[Region], task: &Task) -> Result<Vec<Vec<Option<Given>>>> {
        let blocks: Vec<Block> =
            regions.iter().enumerate().flat_map(|(index, region)| blocks(index, region)).collect();
        let ask = |block: &Block| {
            task.go_on()?;
            Ok((block.region, self.ask_block(&regions[block.region], block)))
        };
        let found: Vec<(usize, Vec<GivenRow>)> = blocks.par_iter().map(ask).collect::<Result<_>>()?;
        let mut texels: Vec<Vec<Option<Given>>> = regions.iter().map(|r| vec![None; r.texels()]).collect();
        for (region, rows) in found {
            for (first, row) in rows {
                texels[region][first..first + row.len()].copy_from_slice(&row);
            }
        }
        Ok(texels)
    }

    /// The rows of one block.
    fn ask_block(&self, region: &Region, block: &Block) -> Vec<GivenRow> {
        let Some(asker) = Asker::new(self, region, block.corner) else { return Vec::new() };
        let mut rows = Vec::new();
        for hidden in &block.spans {
            let x0 = hidden.span.x0.max(block.corner[0]);
            let x1 = hidden.span.x1.min(block.corner[0] + BLOCK);
            let row = (x0..x1).map(|x| asker.given(centre(x, hidden.span.y), 0)).collect();
            rows.push(((hidden.first + x0 - hidden.span.x0) as usize, row));
        }
        rows
    }

    /// Invents what no photo gave, and closes the seam.
    fn finish(&self, region: Region, from_photos: &[Option<Given>], plates: &Plates) -> FilledRegion {
        let side = self.side(&region).expect("regions that the photo does not see were left out");
        let item = self.own.item(region.surface).expect("it has a side, so it is seen");
        let plate = plates.get(side).map(Arc::as_ref);
        let cells = Cells::around(&region, self.frame());
        let seam = seam(&cells, &self.all_differences(&region, item, &cells, plate));
        let lacking = plate.is_none() && from_photos.iter().any(Option::is_none);
        let remnant = lacking.then(|| Remnant::of(self.own, item, &region, &cells));
        let gains = self.ground.gains.of_photo[self.photo.0 as usize].map(|gain| gain.exp() as f32);
        let mut texels = Vec::with_capacity(region.texels());
        for hidden in &region.spans {
            let y = hidden.span.y;
            for (x, at) in (hidden.span.x0..hidden.span.x1).zip(hidden.first as usize..) {
                let factor = || seam.as_ref().map_or([0.0; 3], |seam| seam.at(x, y)).map(f32::exp);
                let (colour, factor, confidence, origin) = match (from_photos[at], plate, &remnant) {
                    (Some(given), _, _) => {
                        (given.colour, factor(), given.confidence, Origin::Photo(given.photo))
                    }
                    (None, Some(plate), _) => {
                        let point = self.met(&region, centre(x, y));
                        (plate.colour(point), factor(), confidence_of(plate.origin), plate.origin)
                    }
                    (None, None, remnant) => {
                        let colour = remnant.as_ref().expect("made where it is asked for").colour(x, y);
                        let origin = Origin::Diffused;
                        (colour, gains.map(f32::recip), confidence_of(origin), origin)
                    }
                };
                let rgb = self.stored([0, 1, 2].map(|c| colour[c] * factor[c] * gains[c]));
                let confidence = (confidence * 255.0).round().clamp(1.0, 255.0) as u8;
                texels.push(Texel { rgb, confidence, origin });
            }
        }
        FilledRegion { region, texels }
    }

    fn frame(&self) -> PixelRect {
        PixelRect { x: 0, y: 0, w: self.own.camera.width, h: self.own.camera.height }
    }

    /// Compares what the photo shows around a region with what would fill it there.
    fn all_differences(
        &self,
        region: &Region,
        item: u32,
        cells: &Cells,
        plate: Option<&Plate>,
    ) -> Vec<(usize, [f32; 3])> {
        let mut by_block: BTreeMap<[u32; 2], Vec<(usize, DVec2)>> = BTreeMap::new();
        for (place, px) in cells.near().filter(|(_, px)| self.own.shows(item, *px)) {
            let corner = [px.x, px.y].map(|at| at as u32 / BLOCK * BLOCK);
            by_block.entry(corner).or_default().push((place, px));
        }
        by_block
            .into_par_iter()
            .flat_map_iter(|(corner, cells)| self.differences(region, corner, &cells, plate))
            .collect()
    }

    fn differences(
        &self,
        region: &Region,
        corner: [u32; 2],
        cells: &[(usize, DVec2)],
        plate: Option<&Plate>,
    ) -> Vec<(usize, [f32; 3])> {
        let asker = Asker::new(self, region, corner);
        let difference = |&(place, px): &(usize, DVec2)| {
            let given =
                asker.as_ref().and_then(|asker| asker.given(px, CELL_LEVEL)).map(|given| given.colour);
            let filling = given.or_else(|| Some(plate?.colour(self.met(region, px))))?;
            let shown = self.own.colour(px, CELL_LEVEL.min(self.own.level_for(f64::INFINITY)));
            let gain = self.ground.gains.of_photo[self.photo.0 as usize].map(|gain| gain as f32);
            let log = |value: f32| value.max(1e-3).ln();
            Some((place, [0, 1, 2].map(|c| log(shown[c]) - gain[c] - log(filling[c]))))
        };
        cells.iter().filter_map(difference).collect()
    }

    fn met(&self, region: &Region, px: DVec2) -> DVec3 {
        let surface = self.ground.surfaces.get(region.surface);
        let eye = self.own.pose.center_in_world();
        self.ground.met(surface, eye, self.on_plane(surface, px))
    }

    /// The point of a surface's plane at a photo position.
    fn on_plane(&self, surface: &Surface, px: DVec2) -> DVec3 {
        let eye = self.own.pose.center_in_world();
        let ray = self.own.pose.rotation.transpose() * self.own.camera.ray_in_camera(px);
        let plane = &surface.plane;
        eye - ray * (plane.signed_distance(eye) / plane.normal.dot(ray))
    }

    /// Linear light as the photo's own samples.
    fn stored(&self, linear: [f32; 3]) -> [u16; 3] {
        let srgb = Srgb::tables();
        linear.map(|light| match self.own.bits {
            16 => (srgb_of_linear(f64::from(light).clamp(0.0, 1.0)) * 65535.0).round() as u16,
            _ => u16::from(srgb.encoded(light)) * 257,
        })
    }
}

fn confidence_of(invented: Origin) -> f32 {
    if invented == Origin::Exemplar { INVENTED_CONFIDENCE } else { DIFFUSED_CONFIDENCE }
}

fn centre(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// The blocks that a region's spans touch.
fn blocks(index: usize, region: &Region) -> Vec<Block<'_>> {
    let mut found: BTreeMap<[u32; 2], Vec<&HiddenSpan>> = BTreeMap::new();
    for hidden in &region.spans {
        let row = hidden.span.y / BLOCK * BLOCK;
        for column in hidden.span.x0 / BLOCK..=(hidden.span.x1 - 1) / BLOCK {
            found.entry([row, column * BLOCK]).or_default().push(hidden);
        }
    }
    let block = |([y, x], spans): ([u32; 2], Vec<_>)| Block { region: index, corner: [x, y], spans };
    found.into_iter().map(block).collect()
}

/// The photos that may give in a block, asked point by point.
struct Asker<'a> {
    job: &'a Job<'a>,
    surface: &'a Surface,
    givers: Vec<Giver<'a>>,
}

impl<'a> Asker<'a> {
    /// None where no photo may give anything.
    fn new(job: &'a Job<'a>, region: &Region, [x, y]: [u32; 2]) -> Option<Self> {
        let (id, back) = job.side(region)?;
        let surface = job.ground.surfaces.get(id);
        let eye = job.own.pose.center_in_world();
        let (low, high) = (0.5, f64::from(BLOCK) - 0.5);
        let middle = f64::from(BLOCK) / 2.0;
        let offsets = [(middle, middle), (low, low), (high, low), (low, high), (high, high)];
        let probes = offsets.map(|(dx, dy)| {
            let px = DVec2::new(f64::from(x) + dx, f64::from(y) + dy);
            job.ground.met(surface, eye, job.on_plane(surface, px))
        });
        let depth = job.own.pose.camera_from_world(probes[0]).z;
        // Behind the horizon of the plane: the block's middle meets it nowhere.
        let depth =
            if depth > 0.0 { depth } else { job.own.pose.camera_from_world(surface.outline[0]).z.abs() };
        let density = pixels_per_unit(&job.own.camera, &surface.plane, eye, depth.max(f64::MIN_POSITIVE));
        let most_angle = if surface.billboard { BILLBOARD_ANGLE } else { std::f64::consts::PI };
        let plane = surface.plane;
        let place = Place { surface: id, plane, back, viewpoint: eye, most_angle, density, probes: &probes };
        let givers = givers(job.donors, job.ground.gains, &place);
        (!givers.is_empty()).then_some(Self { job, surface, givers })
    }

    fn given(&self, px: DVec2, coarser: usize) -> Option<Given> {
        let eye = self.job.own.pose.center_in_world();
        let point = self.job.ground.met(self.surface, eye, self.job.on_plane(self.surface, px));
        given(&self.givers, point, coarser)
    }
}
