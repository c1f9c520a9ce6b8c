//! Paint on other photos before it is in their files: what changed since their filling is projected to their image
//! layers at once, so that novel views show it while the files are still being written.
//!
//! No photo is decoded: paint and geometry suffice. The colours therefore lack the seam to the photo's surrounding
//! pixels, which the filling adds.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::{Arc, Mutex};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::hidden::{NeededPixels, Shaper};
use super::kept::PaintChange;
use super::paint::{SeenBy, SitePaint};
use super::propagation::{PropagationToPhoto, propagation_entries};
use super::servers::{keeps_pixels, serving};
use crate::gains::{self, photo_gains};
use crate::projected_paint::{ProjectedPaint, ProjectedTexel};
use crate::relief::SiteRelief;
use crate::sources::sources;
use quadratura_base::error::Result;
use quadratura_base::geometry::{PixelRect, Pose};
use quadratura_base::raster::in_8_bits;
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::paint::PaintBook;
use quadratura_document::stack::{FilledPaint, ImageLayer, SurfaceName};
use quadratura_document::{Project, Stack};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::LayerIndex;
use quadratura_layers::fill::region::{Region, Regions, painted};
use quadratura_layers::fill::{
    Donor, Donors, FillContext, FillOptions, FillSurfaceId, FillSurfaces, FilledRegion, propagate_paint,
};
use quadratura_projection::relief::Relief;
use quadratura_projection::{Gains, Projector};
use quadratura_sites::budget::default_memory;
use quadratura_view::weights::angle_at;

/// The distance in pixels by which projected paint may lie beside where its rectangle's grid of points lies: relief
/// displaces single points between those of the grid.
const MARGIN_PX: u32 = 24;

/// The number of points along each side of the grid by which a rectangle is projected.
const GRID: u32 = 9;

/// The site and its present paint, from which paint is projected.
pub struct PaintProjection<'a> {
    project: &'a Project,
    site: &'a Site,
    surfaces: FillSurfaces,
    store: StackStore,
    stacks: &'a [Option<Arc<Stack>>],
    gains: Gains,
    relief: Arc<Relief>,
    options: FillOptions,
}

impl<'a> PaintProjection<'a> {
    /// Prepares the projection of the paint of the project in `folder` to these stacks, which are in the site's order.
    /// Gains and relief are those in `cache/`.
    ///
    /// # Errors
    /// Returns [`quadratura_base::Error::Cancelled`].
    pub fn new(
        folder: &Path,
        project: &'a Project,
        site: &'a Site,
        stacks: &'a [Option<Arc<Stack>>],
        task: &Task,
    ) -> Result<Self> {
        let memory = default_memory();
        let gains = photo_gains(site, stacks, &project.colour, folder, memory, task)?;
        let relief = SiteRelief::open(site, gains::photo_inputs(site, stacks), folder, memory, task)?;
        Ok(Self {
            project,
            site,
            surfaces: FillSurfaces::from_model(&site.model),
            store: StackStore::new(folder),
            stacks,
            gains,
            relief: relief.whole().clone(),
            options: project.fill.clone(),
        })
    }

    /// Prepares the projection as [`Self::new`] does, but onto flat faces and without gains: no photo is read and nothing
    /// is estimated, whatever is in `cache/`. That is enough to count texels.
    pub fn flat(
        folder: &Path,
        project: &'a Project,
        site: &'a Site,
        stacks: &'a [Option<Arc<Stack>>],
    ) -> Self {
        Self {
            project,
            site,
            surfaces: FillSurfaces::from_model(&site.model),
            store: StackStore::new(folder),
            stacks,
            gains: Gains::none(site.photos.len()),
            relief: Arc::default(),
            options: project.fill.clone(),
        }
    }

    /// Projects the paint in `book` to those of the photos `targets` whose files do not contain it, or contain paint
    /// that is no longer in the book.
    ///
    /// # Errors
    /// Returns [`quadratura_base::Error::Input`] and [`quadratura_base::Error::Io`] for files of stacks and paint, or
    /// [`quadratura_base::Error::Cancelled`].
    pub fn project(&self, book: &PaintBook, targets: &[PhotoId], task: &Task) -> Result<Vec<ProjectedPaint>> {
        let projected = self.project_each(book, targets, task)?;
        Ok(projected.into_iter().flat_map(|of_photo| of_photo.paint).collect())
    }

    /// Counts the texels of all photos on which paint in `book` would be projected that their files do not contain.
    ///
    /// # Errors
    /// As [`Self::project`].
    pub fn count(&self, book: &PaintBook, task: &Task) -> Result<Vec<PropagationToPhoto>> {
        let targets: Vec<PhotoId> = self.site.photo_ids().collect();
        let counted = self.project_each(book, &targets, task)?;
        Ok(counted.into_iter().flat_map(|of_photo| of_photo.counts).collect())
    }

    fn project_each(&self, book: &PaintBook, targets: &[PhotoId], task: &Task) -> Result<Vec<OntoPhoto>> {
        let site = self.site;
        let paint = SitePaint::new(
            &self.options,
            book,
            &PaintStore::new(self.store.project()),
            self.stacks,
            &site.model,
            &self.surfaces,
        );
        let donors = PaintDonors { projection: self, paint: &paint, known: Mutex::default() };
        let sources = sources(site, self.stacks, &self.project.decisions);
        let projectors: Vec<Projector> = site.photos.iter().map(projector).collect();
        let context = FillContext {
            photos: &projectors,
            surfaces: &self.surfaces,
            serving: &serving(&sources),
            painters: &paint.painters(&site.model),
            relief: &self.relief,
            gains: &self.gains,
            options: &self.options,
            source: &donors,
        };
        let now = paint.placed();
        let to_photo = |target: &PhotoId| {
            task.check_cancelled()?;
            let Some(stack) = &self.stacks[target.index()] else { return Ok(OntoPhoto::default()) };
            let before = stack.fill.as_ref().and_then(|fill| fill.basis.as_ref());
            let change = PaintChange::between(before.map_or(&[], |basis| &basis.paint), &now);
            let target =
                TargetPhoto { projection: self, context: &context, paint: &paint, photo: *target, stack };
            target.projected(&change.entries, task)
        };
        targets.par_iter().map(to_photo).collect()
    }
}

/// Paint that is projected to one photo.
#[derive(Default)]
struct OntoPhoto {
    paint: Vec<ProjectedPaint>,
    /// The texels that show the surfaces, by face and painted photo.
    counts: Vec<PropagationToPhoto>,
}

/// Returns all photos, those first that see a point from nearly the same direction as a view from `eye` does, because
/// they have most weight in it. Both points are in world coordinates.
pub fn nearest_first(site: &Site, eye: DVec3, point: DVec3) -> Vec<PhotoId> {
    let angle = |photo: &PhotoId| angle_at(point, eye, site.photo(*photo).pose.center_in_world());
    let mut photos: Vec<PhotoId> = site.photo_ids().collect();
    photos.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    photos
}

fn projector(photo: &Photo) -> Projector {
    Projector { name: photo.name.clone(), camera: photo.camera, pose: photo.pose }
}

/// The photos with their paint alone.
struct PaintDonors<'a> {
    projection: &'a PaintProjection<'a>,
    paint: &'a SitePaint<'a>,
    known: Mutex<BTreeMap<(PhotoId, SeenBy), Arc<Donor>>>,
}

impl PaintDonors<'_> {
    fn prepared(&self, photo: PhotoId, seen_by: SeenBy) -> Result<Option<Arc<Donor>>> {
        const HELD: &str = "no holder of this lock panics";
        if let Some(known) = self.known.lock().expect(HELD).get(&(photo, seen_by)) {
            return Ok(Some(known.clone()));
        }
        let site = self.projection.site;
        let painted = self.paint.of_photo(photo, seen_by)?;
        let projector = projector(site.photo(photo));
        let donor = Donor::of_paint(&projector, &painted, &site.model, &self.projection.surfaces);
        let mut known = self.known.lock().expect(HELD);
        Ok(Some(known.entry((photo, seen_by)).or_insert(Arc::new(donor)).clone()))
    }
}

impl Donors for PaintDonors<'_> {
    fn donor(&self, photo: PhotoId) -> Result<Option<Arc<Donor>>> {
        self.prepared(photo, SeenBy::Others)
    }

    fn own(&self, photo: PhotoId) -> Result<Option<Arc<Donor>>> {
        let seen_by = if self.paint.keeps_some(photo) { SeenBy::Itself } else { SeenBy::Others };
        self.prepared(photo, seen_by)
    }

    fn at_once(&self) -> usize {
        usize::MAX
    }
}

/// A photo to which paint is projected.
struct TargetPhoto<'a> {
    projection: &'a PaintProjection<'a>,
    context: &'a FillContext<'a>,
    paint: &'a SitePaint<'a>,
    photo: PhotoId,
    stack: &'a Stack,
}

/// The part of an image layer that changed paint may concern.
struct ConcernedPart {
    rect: PixelRect,
    surfaces: BTreeSet<FillSurfaceId>,
}

impl TargetPhoto<'_> {
    /// Returns what the changed entries leave on the photo's image layers.
    fn projected(&self, changed: &[&FilledPaint], task: &Task) -> Result<OntoPhoto> {
        let parts = self.parts(changed)?;
        if parts.is_empty() {
            return Ok(OntoPhoto::default());
        }
        let own = self.context.source.own(self.photo)?.expect("paint alone can always be read");
        let model = &self.projection.site.model;
        let shaper = Shaper::new(self.stack, &own, model, &self.projection.surfaces);
        let folder = self.projection.store.folder(&self.stack.photo.name);
        let elements: Vec<_> = self.stack.visibility_layers.iter().flatten().collect();
        let (mut visible, mut hidden) = (Regions::default(), Regions::default());
        let mut projected: Vec<ProjectedPaint> = Vec::with_capacity(parts.len());
        for (&layer, part) in &parts {
            let of_stack = self.stack.layer(layer);
            let pixels = NeededPixels::read(of_stack, &folder, part.rect)?;
            let of_layer: Vec<_> = of_stack.elements.iter().map(|e| elements[e.index()]).collect();
            let shown = painted(&shaper.shapes(&of_layer), pixels.rect);
            let concerned = |at: usize| shown[at].is_some_and(|surface| part.surfaces.contains(&surface));
            let is_visible: Vec<bool> =
                (0..shown.len()).map(|at| pixels.visible[at] && concerned(at)).collect();
            let is_hidden: Vec<bool> = (0..shown.len())
                .map(|at| pixels.needed[at] != 0 && !pixels.visible[at] && concerned(at))
                .collect();
            visible.add(layer, pixels.rect, &shown, &is_visible);
            hidden.add(layer, pixels.rect, &shown, &is_hidden);
            let texel =
                |visible: &bool| if *visible { ProjectedTexel::Bare } else { ProjectedTexel::AsFiled };
            let texels = is_visible.iter().map(texel).collect();
            projected.push(ProjectedPaint { photo: self.photo, layer, rect: pixels.rect, texels });
        }
        let painters: Vec<PhotoId> =
            self.projection.site.photo_ids().filter(|photo| *photo != self.photo).collect();
        let painters: Vec<PhotoId> =
            painters.into_iter().filter(|photo| !self.paint.surfaces_of(*photo).is_empty()).collect();
        let name = |photo: &PhotoId| &self.context.photos[photo.index()].name;
        let options = self.context.options;
        let is_target = options.propagates_to(name(&self.photo));
        let propagates = |photo: &PhotoId| is_target && options.propagates(name(photo));
        let propagating: Vec<PhotoId> = painters.iter().copied().filter(propagates).collect();
        let target = self.projection.site.photo(self.photo);
        let face = |region: &Region| self.projection.surfaces.get(region.surface).face;
        let mut visible = visible.finish();
        visible.retain(|region| {
            !keeps_pixels(self.projection.project, self.projection.site, target, face(region))
        });
        let laid = propagate_paint(self.context, self.photo, visible, &propagating, task)?;
        let filled = propagate_paint(self.context, self.photo, hidden.finish(), &painters, task)?;
        for region in laid.regions.iter().chain(&filled.regions) {
            lay(region, &mut projected);
        }
        let counted = propagation_entries(self.projection.site, self.context, &laid.offers).into_iter();
        let counts = counted.map(|paint| PropagationToPhoto { photo: self.photo, paint }).collect();
        Ok(OntoPhoto { paint: projected, counts })
    }

    /// Returns the parts of image layers that changed entries may concern.
    fn parts(&self, changed: &[&FilledPaint]) -> Result<BTreeMap<LayerIndex, ConcernedPart>> {
        let mut parts: BTreeMap<LayerIndex, ConcernedPart> = BTreeMap::new();
        for entry in changed {
            for name in &entry.surfaces {
                let Some(surface) = self.paint.id(name) else { continue };
                let Some(rect) = self.footprint(entry, surface)? else { continue };
                let layers = self.stack.numbered_layers();
                for (index, layer) in layers.filter(|(_, layer)| self.contains(layer, name)) {
                    let rect = rect.intersection(&layer.needed_rect).intersection(&layer.rect);
                    if rect.is_empty() {
                        continue;
                    }
                    let part = parts
                        .entry(index)
                        .or_insert_with(|| ConcernedPart { rect, surfaces: BTreeSet::new() });
                    part.rect = part.rect.union(&rect);
                    part.surfaces.insert(surface);
                }
            }
        }
        Ok(parts)
    }

    /// Returns whether an image layer contains some of a surface.
    fn contains(&self, layer: &ImageLayer, name: &SurfaceName) -> bool {
        let mut elements = self.stack.visibility_layers.iter().flatten().enumerate();
        elements.any(|(index, element)| {
            let has_face = element.faces.contains(&name.face)
                || element.pieces.iter().any(|(face, _)| *face == name.face);
            element.object == name.object && has_face && layer.elements.iter().any(|e| e.index() == index)
        })
    }

    /// Returns a rectangle of the photo that holds what an entry may show on a surface; `None` where the photo cannot
    /// see the surface.
    fn footprint(&self, entry: &FilledPaint, surface: FillSurfaceId) -> Result<Option<PixelRect>> {
        let site = self.projection.site;
        let own = self.context.source.own(self.photo)?.expect("paint alone can always be read");
        let (Some(item), Some(painter)) = (own.item(surface), site.photo_named(&entry.photo)) else {
            return Ok(None);
        };
        let all = own.seen(item).bounds;
        if painter == self.photo {
            return Ok(Some(entry.rect.intersection(&all)));
        }
        let from = &self.context.photos[painter.index()];
        let on = self.projection.surfaces.get(surface);
        // The surface of an impostor is where no photo sees it; both photos' poses are turned to it.
        let impostor = site.model.impostor(on.face);
        let turned = |pose: &Pose| {
            impostor.map_or(*pose, |it| it.turn(&it.at_rest(), &Facing::of_pose(pose)).before(pose))
        };
        let (from_pose, own_pose) = (turned(&from.pose), turned(&own.pose));
        let eye = from_pose.center_in_world();
        let project = |px: DVec2| {
            let ray = from_pose.rotation.transpose() * from.camera.ray_in_camera(px);
            let along = -on.plane.signed_distance(eye) / on.plane.normal.dot(ray);
            let point = (along > 0.0).then(|| self.context.met(on, eye, eye + ray * along))?;
            own.camera.image_from_camera(own_pose.camera_from_world(point))
        };
        let mut found: Option<(DVec2, DVec2)> = None;
        for (i, j) in (0..GRID).flat_map(|i| (0..GRID).map(move |j| (i, j))) {
            let share = |i: u32| f64::from(i) / f64::from(GRID - 1);
            let px = DVec2::new(
                f64::from(entry.rect.x) + share(i) * f64::from(entry.rect.w),
                f64::from(entry.rect.y) + share(j) * f64::from(entry.rect.h),
            );
            // Beyond the horizon of the plane: what the photo sees of the surface holds all of it.
            let Some(px) = project(px) else { return Ok(Some(all)) };
            found = Some(found.map_or((px, px), |(low, high)| (low.min(px), high.max(px))));
        }
        let Some((low, high)) = found.filter(|(low, high)| low.is_finite() && high.is_finite()) else {
            return Ok(Some(all));
        };
        let edge = |at: f64| at.clamp(-1e6, 1e6) as i32;
        let rect = PixelRect::from_edges(
            edge(low.x.floor()),
            edge(low.y.floor()),
            edge(high.x.ceil()),
            edge(high.y.ceil()),
        );
        Ok(Some(rect.grown(MARGIN_PX).intersection(&all)))
    }
}

/// Puts the texels of a region on the layers that it lies in.
fn lay(region: &FilledRegion, projected: &mut [ProjectedPaint]) {
    for hidden in &region.region.spans {
        let Some(layer) = projected.iter_mut().find(|layer| layer.layer == hidden.layer) else { continue };
        for (x, at) in (hidden.span.x0..hidden.span.x1).zip(hidden.first as usize..) {
            let texel = region.texels[at];
            let place = layer.rect.offset(x as i32, hidden.span.y as i32);
            layer.texels[place] = ProjectedTexel::Paint(texel.rgb.map(in_8_bits), texel.confidence);
        }
    }
}
