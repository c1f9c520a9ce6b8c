//! A renderer of a project's views that moves the pixels of layered depth images, beside the projective renderer.

use std::path::Path;
use std::sync::Arc;

use super::choice::best_photos;
use super::exposed_shot::ExposedShot;
use super::face_depths::{FaceDepths, shown_by_images};
use super::kept::{Kept, ReducedPhotoView};
use super::options::PhotosOptions;
use super::reference_camera::OfPhoto;
use super::site::LdiSite;
use super::{SiteLdiOptions, StackLdiOptions};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_ldi::cracks::closed_blend;
use quadratura_ldi::holes::{HolePixel, holes_of, paint_holes};
use quadratura_ldi::{
    BlendSource, Blended, BlendedSurface, Ldi, Shown, Spacing, SplatKind, WarpOptions, coloured, warp,
    warp_blended,
};
use quadratura_projection::exposure::ViewExposure;
use quadratura_projection::{Renders, shown_face};
use quadratura_sites::budget::default_memory;
use quadratura_view::agreement::AgreementGrid;
use quadratura_view::optics::{Optics, ViewLens};
use quadratura_view::srgb::Srgb;
use quadratura_view::{DisplayMode, Picture, Quality, Shot};
use quadratura_views::preview::Preview;

/// What views are made from.
#[derive(Debug, Clone, PartialEq)]
pub enum LdiViewSource {
    /// The depth image of the best photo alone.
    Photo,
    /// The stacks of the best photos with what is hidden in them, each moved by itself and blended as photos are.
    Stacks,
    /// Several photos, combined into the camera of the best one.
    Photos(PhotosOptions),
    /// All that the photos together show, in the cameras of the best photos, each moved by itself and blended.
    Site(SiteLdiOptions),
}

impl LdiViewSource {
    /// Returns whether several images are blended.
    fn is_blend(&self) -> bool {
        matches!(self, Self::Stacks | Self::Site(_))
    }
}

/// How views are made from layered depth images.
#[derive(Debug, Clone, PartialEq)]
pub struct LdiViewOptions {
    /// What they are made from.
    pub source: LdiViewSource,
    /// What is taken from stacks.
    pub stack: StackLdiOptions,
    /// The largest number of photos that are combined or blended.
    pub best: usize,
    /// The photos that are combined or blended whatever the view; empty lets each view choose.
    pub with: Vec<PhotoId>,
    /// How depth pixels are drawn.
    pub splat: SplatKind,
    /// How their spacing is found.
    pub spacing: Spacing,
    /// What is shown instead of colours.
    pub shown: Option<Shown>,
    /// The bytes that images may take that are kept for later views.
    pub memory: u64,
}

impl LdiViewOptions {
    /// Returns whether surfaces are on the relief.
    fn relief(&self) -> bool {
        match &self.source {
            LdiViewSource::Site(of) => of.relief,
            _ => self.stack.relief,
        }
    }
}

impl Default for LdiViewOptions {
    fn default() -> Self {
        Self {
            source: LdiViewSource::Stacks,
            stack: StackLdiOptions::default(),
            best: 3,
            with: Vec::new(),
            splat: SplatKind::default(),
            spacing: Spacing::default(),
            shown: None,
            memory: default_memory(),
        }
    }
}

/// Renders views of a project from layered depth images, which are made as the views need them. Gains, relief and shares of
/// photos are those of the projective renderer, which also says which face is where.
pub struct LdiView<'a> {
    preview: Preview,
    source: LdiSite<'a>,
    options: LdiViewOptions,
    kept: Kept,
    /// The photos without which what is kept was made; `None` before anything was.
    without: Option<Vec<PhotoId>>,
}

impl<'a> LdiView<'a> {
    /// Prepares views of the project in `folder`, which `preview` shows, too.
    ///
    /// # Errors
    /// Those of [`LdiSite::open`].
    pub fn new(
        folder: &Path,
        project: &'a Project,
        site: &'a Site,
        preview: Preview,
        options: LdiViewOptions,
    ) -> Result<Self> {
        let source = LdiSite::open(folder, project, site)?;
        let kept = Kept::new(options.memory);
        Ok(Self { preview, source, options, kept, without: None })
    }

    /// Returns the projective renderer of the same project.
    pub fn preview(&self) -> &Preview {
        &self.preview
    }

    /// Makes ready for views without some photos.
    fn leave_out(&mut self, photos: &[PhotoId], task: &Task) -> Result<()> {
        if self.without.as_deref() != Some(photos) {
            let (gains, relief) = self.preview.estimates_without(photos, task)?;
            self.source.set_estimates(gains, relief, photos);
            self.kept.clear();
            self.without = Some(photos.to_vec());
        }
        Ok(())
    }

    /// Returns the photos for a view, those that show most of it first, and the exposure of the view. There are none where no
    /// photo shows anything of it.
    fn photos_for(&self, shot: &Shot) -> (Vec<PhotoId>, ViewExposure) {
        let (shares, exposure) = self.preview.shares_and_exposure(shot, &self.source.site().model);
        let photos = match &self.options.with[..] {
            [] => best_photos(&shares, usize::MAX),
            with => with.iter().copied().filter(|photo| !shot.without.contains(photo)).collect(),
        };
        let has_stack = |photo: &PhotoId| !self.options.with.is_empty() || self.source.has_stack(*photo);
        (photos.into_iter().filter(has_stack).collect(), exposure)
    }

    /// Returns the layered depth images of some photos for a view, each with the photo whose exposure its colours have.
    fn images_of(&mut self, photos: &[PhotoId], shot: &Shot, task: &Task) -> Result<Vec<OfPhoto>> {
        let Self { source, options, kept, preview, .. } = self;
        let Some(&first) = photos.first() else { return Ok(Vec::new()) };
        let surroundings = shot.surroundings;
        Ok(match &options.source {
            LdiViewSource::Photo => {
                let stack = StackLdiOptions { surroundings, ..options.stack };
                vec![(Arc::new(kept.stack(source, first, &stack, task)?.depth_image()), first)]
            }
            LdiViewSource::Stacks => {
                let stack = StackLdiOptions { surroundings: false, ..options.stack };
                kept.stacks(source, photos, &stack, task)?
            }
            LdiViewSource::Photos(of) => {
                let camera = &source.site().photo(first).camera;
                let stack = StackLdiOptions { surroundings, ..of.stack };
                let halvings = halvings(camera.fx * of.scale / shot.camera.fx, shot.quality);
                let options = PhotosOptions { stack, ..of.clone() };
                vec![(kept.photos(source, photos, halvings, &options, task)?, first)]
            }
            LdiViewSource::Site(of) => {
                let mut images = Vec::new();
                for &photo in photos {
                    let finer = source.site().photo(photo).camera.fx * of.scale / shot.camera.fx;
                    let of = SiteLdiOptions { surroundings: false, ..*of };
                    let halvings = halvings(finer, shot.quality);
                    let view = ReducedPhotoView { photo, halvings, without: &shot.without };
                    images.push((kept.site(source, preview, view, &of, task)?, photo));
                }
                images
            }
        })
    }

    /// Draws a view from the images of some photos.
    fn picture_of(&mut self, photos: &[PhotoId], view: ExposedShot, task: &Task) -> Result<Blended> {
        let ExposedShot { shot, exposure } = view;
        let mut images = self.images_of(photos, shot, task)?;
        let shown = self.options.shown.filter(|shown| *shown != Shown::Holes);
        if let Some(shown) = shown {
            let coloured = |(ldi, photo): (Arc<Ldi>, PhotoId)| (Arc::new(coloured(&ldi, shot, shown)), photo);
            images = images.into_iter().map(coloured).collect();
        }
        // What all photos show was blended with their agreement and without their optics.
        let is_of_photos = !matches!(self.options.source, LdiViewSource::Site(_));
        let of_photo = |photo: PhotoId| self.preview.agreement(shot, self.source.site().photo(photo), photo);
        let agreement = |photo: PhotoId| Some(photo).filter(|_| is_of_photos).and_then(of_photo);
        let agreement: Vec<Option<AgreementGrid>> =
            images.iter().map(|(_, photo)| agreement(*photo)).collect();
        let sources = images.iter().zip(&agreement).map(|((ldi, photo), agreement)| BlendSource {
            ldi,
            exposure: if shown.is_some() { [0.0; 3] } else { exposure.factor(*photo).map(f64::ln) },
            optics: if is_of_photos && shown.is_none() {
                self.preview.optics(shot, *photo)
            } else {
                Optics::default()
            },
            agreement: agreement.as_ref(),
        });
        let lens = if shown.is_some() { ViewLens::default() } else { exposure.lens };
        self.drawn(&sources.collect::<Vec<_>>(), shot, &lens, task)
    }

    /// Paints why faces have no colour in a view of the images of some photos.
    fn with_holes(
        &mut self,
        mut picture: Picture,
        photos: &[PhotoId],
        faces: &[u32],
        shot: &Shot,
        task: &Task,
    ) -> Result<Picture> {
        let images = self.images_of(photos, shot, task)?;
        let options = self.warp_options();
        let (_, relief) = self.preview.estimates_without(&shot.without, task)?;
        let relief = relief.filter(|_| self.options.relief());
        let depths = FaceDepths::new(&self.source.site().model, relief, shot);
        let pixel = |at: usize| match shown_face(faces[at]) {
            Some(_) if picture.pixels()[at][3] < u8::MAX => {
                depths.at_pixel(at, faces[at]).map_or(HolePixel::Empty, |q| HolePixel::EmptyAt(q as f32))
            }
            _ => HolePixel::Full,
        };
        let holes = holes_of(images.iter().map(|(ldi, _)| &**ldi), shot, &options, &pixel, task)?;
        paint_holes(&mut picture, &holes);
        Ok(picture)
    }

    fn warp_options(&self) -> WarpOptions {
        let LdiViewOptions { splat, spacing, .. } = self.options;
        WarpOptions { splat, spacing, ..WarpOptions::default() }
    }

    /// Completes a view of the best photos' stacks with those of the next ones, where the best leave holes in faces.
    fn complete(
        &mut self,
        best: Blended,
        others: &[PhotoId],
        faces: &[u32],
        view: ExposedShot,
        task: &Task,
    ) -> Result<Blended> {
        let mut blended = best;
        if self.options.source != LdiViewSource::Stacks {
            return Ok(blended);
        }
        for photos in others.chunks(self.options.best.max(1)).take(ROUNDS) {
            if holes(&blended.picture, faces) <= HOLES {
                break;
            }
            match self.picture_of(photos, view, task) {
                Ok(more) => complete_with(&mut blended, &more, faces),
                Err(Error::Request(_)) => (),
                Err(error) => return Err(error),
            }
        }
        Ok(blended)
    }
}

/// The share of the pixels of faces without a colour up to which a view is complete: as many as lie along outlines in views of
/// a thousand pixels.
const HOLES: f64 = 0.002;

/// How often a view is completed with the images of as many photos more. Each time takes as long as the view did.
const ROUNDS: usize = 3;

/// Returns the share of the pixels with a face that have no colour; 0 where there is no face.
fn holes(picture: &Picture, faces: &[u32]) -> f64 {
    let of_faces = || picture.pixels().iter().zip(faces).filter(|(_, face)| shown_face(**face).is_some());
    let missing: f64 = of_faces().map(|(pixel, _)| 1.0 - f64::from(pixel[3]) / 255.0).sum();
    missing / of_faces().count().max(1) as f64
}

/// Lays a view over another one where a face is. What the first one has filled in stays: farther photos, which see it from the
/// side, predict held-out photos worse than the filling does.
fn complete_with(view: &mut Blended, more: &Blended, faces: &[u32]) {
    let srgb = Srgb::tables();
    let pixels = view.picture.rgba.as_chunks_mut::<4>().0.iter_mut().enumerate();
    for ((at, pixel), (other, face)) in pixels.zip(more.picture.pixels().iter().zip(faces)) {
        if shown_face(*face).is_some() {
            let left = u32::from(u8::MAX - pixel[3]) * u32::from(other[3]) / 255;
            if left > u32::from(pixel[3]) {
                view.surfaces[at] = more.surfaces[at];
            }
            *pixel = laid_over(pixel, other, &srgb);
        }
    }
}

/// Lays a pixel over another one, in linear light.
pub(super) fn laid_over(front: &[u8; 4], behind: &[u8; 4], srgb: &Srgb) -> [u8; 4] {
    let share = |pixel: &[u8; 4]| f32::from(pixel[3]) / 255.0;
    let left = share(behind) * (1.0 - share(front));
    let all = share(front) + left;
    if front[3] == u8::MAX || all <= 0.0 {
        return *front;
    }
    let light = |c: usize| (share(front) * srgb.linear(front[c]) + left * srgb.linear(behind[c])) / all;
    let [r, g, b] = [0, 1, 2].map(|c| srgb.encoded(light(c)));
    [r, g, b, (all * 255.0).round() as u8]
}

/// Completes a picture of depth pixels, in which splats reach beyond the outlines of faces. Where `faces` has a face, it is the
/// picture, with a hole where no photo shows the face. On pixels without a face, such as those of trees, that touch one, the picture is laid over what
/// is behind, in linear light; on all others it is what is behind.
pub(super) fn over(front: &Picture, behind: &Picture, faces: &[u32]) -> Picture {
    let srgb = Srgb::tables();
    let width = front.width as usize;
    let mixed = |((at, front), behind): ((usize, &[u8; 4]), &[u8; 4])| {
        if shown_face(faces[at]).is_some() {
            return *front;
        }
        let beside = [(at % width > 0, at.wrapping_sub(1)), ((at + 1) % width > 0, at + 1)];
        let above_and_below = [(true, at.wrapping_sub(width)), (true, at + width)];
        let mut beside = beside.into_iter().chain(above_and_below);
        let is_outline = beside.any(|(is_inside, at)| {
            is_inside && faces.get(at).is_some_and(|face| shown_face(*face).is_some())
        });
        if !is_outline {
            return *behind;
        }
        laid_over(front, behind, &srgb)
    };
    let rgba = front.pixels().iter().enumerate().zip(behind.pixels()).flat_map(mixed).collect();
    Picture { rgba, ..*front }
}

/// Returns an empty picture, and notes that it is one.
fn empty(shot: &Shot, task: &Task) -> Picture {
    task.note("no photo shows anything of the view; the picture is empty");
    let (width, height) = (shot.camera.width, shot.camera.height);
    Picture { width, height, rgba: vec![0; 4 * width as usize * height as usize] }
}

/// Returns how often a camera can be halved that has `finer` times the resolution of a picture, so that its image has the level
/// that the picture is made of: it has more than the picture's resolution for previews, and more than twice as much for final pictures.
pub(super) fn halvings(finer: f64, quality: Quality) -> u32 {
    let spare = match quality {
        Quality::Preview | Quality::Finer => 1.0,
        Quality::Final => 2.0,
    };
    (finer.log2().ceil() - spare).clamp(0.0, 8.0) as u32
}

impl LdiView<'_> {
    /// Draws images, each by itself and blended; one that is several photos alone.
    fn drawn(&self, sources: &[BlendSource], shot: &Shot, lens: &ViewLens, task: &Task) -> Result<Blended> {
        let options = self.warp_options();
        let alone = |picture: Picture| {
            let surfaces = vec![BlendedSurface::default(); picture.pixels().len()];
            Blended { picture, surfaces }
        };
        match sources {
            [] => Ok(alone(empty(shot, task))),
            [one] if !self.options.source.is_blend() => {
                let options = WarpOptions { exposure: one.exposure, ..options };
                warp(one.ldi, shot, &options, task).map(|warped| alone(warped.picture))
            }
            several => warp_blended(several, shot, lens, &options, task),
        }
    }
}

impl Renders for LdiView<'_> {
    fn picture(&mut self, asked: &Shot, task: &Task) -> Result<Picture> {
        let shot = Shot { backs: false, ..asked.clone() };
        if shot.display != DisplayMode::Colour {
            let found = "views of layered depth images do not show this; leave out --show, or --as";
            return Err(Error::Request(found.into()));
        }
        self.leave_out(&shot.without, task)?;
        let (photos, exposure) = self.photos_for(asked);
        let most = if self.options.source == LdiViewSource::Photo { 1 } else { self.options.best };
        let (best, others) = photos.split_at(most.min(photos.len()));
        let view = ExposedShot { shot: &shot, exposure: &exposure };
        let blended = self.picture_of(best, view, task)?;
        let shows_holes = self.options.shown == Some(Shown::Holes);
        if !self.options.source.is_blend() || best.is_empty() {
            if !shows_holes {
                return Ok(blended.picture);
            }
            let faces = self.preview.seen_faces(asked, task)?;
            return self.with_holes(blended.picture, best, &faces, &shot, task);
        }
        let faces = self.preview.seen_faces(asked, task)?;
        let blended = self.complete(blended, others, &faces, view, task)?;
        let model = &self.source.site().model;
        let (_, relief) = self.preview.estimates_without(&shot.without, task)?;
        let relief = relief.filter(|_| self.options.relief());
        let shows = FaceDepths::new(model, relief, &shot).shown(&blended, &faces);
        let picture = closed_blend(&blended.picture, &faces, &shows);
        let of_images = shown_by_images(&faces, &shows, model);
        let picture = match shows_holes {
            true => self.with_holes(picture, best, &faces, &shot, task)?,
            false => picture,
        };
        if self.options.shown.is_some_and(|shown| shown != Shown::Holes) {
            // What the projective renderer adds is of no image.
            let nothing = Picture { rgba: vec![0; picture.rgba.len()], ..picture };
            return Ok(over(&picture, &nothing, &of_images));
        }
        if !shot.surroundings && of_images == faces {
            return Ok(picture);
        }
        // Surroundings that several photos show are one dome, skirts continue faces that are drawn, and billboards turn: the
        // projective renderer has all of them.
        let behind = self.preview.picture(&shot, task)?;
        Ok(over(&picture, &behind, &of_images))
    }

    fn faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        self.preview.faces(shot, task)
    }

    fn seen_faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        self.preview.seen_faces(shot, task)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splats_reach_over_what_is_behind_at_outlines_alone() {
        let row =
            |pixels: [[u8; 4]; 4]| Picture { width: 4, height: 1, rgba: pixels.as_flattened().to_vec() };
        let (red, blue, none) = ([255, 0, 0, 255], [0, 0, 255, 255], [0; 4]);
        let found = over(&row([red, none, red, red]), &row([blue; 4]), &[1, 2, 0, 0]);
        assert_eq!(found, row([red, none, red, blue]), "a hole in a face stays one");
        let soft = over(&row([red, red, [255, 0, 0, 51], red]), &row([blue; 4]), &[1, 1, 0, 0]);
        // A fifth of linear light is 124 in sRGB, four fifths are 231.
        assert_eq!(soft, row([red, red, [124, 0, 231, 255], blue]));
    }

    #[test]
    fn holes_in_faces_are_completed_and_nothing_else() {
        let row =
            |pixels: [[u8; 4]; 5]| Picture { width: 5, height: 1, rgba: pixels.as_flattened().to_vec() };
        let (red, blue, none) = ([255, 0, 0, 255], [0, 0, 255, 255], [0; 4]);
        let picture = row([red, none, none, [255, 0, 0, 51], red]);
        let near = |invented: bool| BlendedSurface { invented, inverse_depth: 0.25 };
        let mut view = Blended { picture, surfaces: [false, false, false, false, true].map(near).to_vec() };
        let faces = [1, 2, 0, 1, 1];
        // All of the second, four fifths of the fourth.
        assert!((holes(&view.picture, &faces) - 1.8 / 4.0).abs() < 1e-6, "{}", holes(&view.picture, &faces));
        let nothing = Blended { picture: row([none; 5]), surfaces: vec![BlendedSurface::default(); 5] };
        let mut same = view.clone();
        complete_with(&mut same, &nothing, &faces);
        assert_eq!(same, view);
        let nearer = BlendedSurface { invented: true, inverse_depth: 0.5 };
        let more = Blended { picture: row([blue; 5]), surfaces: vec![nearer; 5] };
        complete_with(&mut view, &more, &faces);
        assert_eq!(view.picture, row([red, blue, none, [124, 0, 231, 255], red]));
        assert_eq!(view.surfaces, [near(false), nearer, near(false), nearer, near(true)]);
        assert_eq!((holes(&view.picture, &faces), holes(&view.picture, &[0; 5])), (0.0, 0.0));
    }

    #[test]
    fn a_camera_is_halved_as_long_as_it_resolves_more_than_a_preview_and_twice_what_a_final_picture_does() {
        let finer = [0.5, 1.0, 1.9, 2.0, 2.1, 4.0, 4.1, 8.0];
        let of = |quality| finer.map(|finer| halvings(finer, quality));
        assert_eq!(of(Quality::Preview), [0, 0, 0, 0, 1, 1, 2, 2]);
        assert_eq!(of(Quality::Final), [0, 0, 0, 0, 0, 0, 1, 1]);
    }
}
