//! The making of single layered depth images of a project, whatever they are made from.

use std::path::Path;

use super::of_site::SiteCamera;
use super::options::{BuildFrom, SiteLdiOptions};
use super::site::{LdiSite, no_stack};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::{Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_layers::device::StartDevice;
use quadratura_ldi::Ldi;
use quadratura_sites::views::RequestedView;
use quadratura_views::preview::{self, Preview};

/// The camera in which an image is made.
#[derive(Debug, Clone)]
pub struct BuildCamera {
    /// The name of the photo, or of the view.
    pub name: String,
    /// The photo; `None` for another view.
    pub photo: Option<PhotoId>,
    /// The camera, without a guard band.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
}

impl BuildCamera {
    /// Returns the camera of a photo.
    pub fn of_photo(site: &Site, id: PhotoId) -> Self {
        let Photo { name, camera, pose, .. } = site.photo(id).clone();
        Self { name, photo: Some(id), camera, pose }
    }

    /// Returns the camera of a view that is no photo's.
    pub fn of_view(view: &RequestedView) -> Self {
        let RequestedView { name, camera, pose, .. } = view.clone();
        Self { name, photo: None, camera, pose }
    }

    /// Returns the photo.
    ///
    /// # Errors
    /// [`Error::Request`] where it is another view: only images of the whole site have other cameras.
    pub fn photo(&self) -> Result<PhotoId> {
        let other = || Error::Request(format!("{} is no photo; give --from site", self.name));
        self.photo.ok_or_else(other)
    }
}

/// A project of which images are made, with its renderer where they need it.
pub struct Maker<'a> {
    /// The stacks that images are made of.
    pub source: LdiSite<'a>,
    preview: Option<Preview>,
}

impl<'a> Maker<'a> {
    /// Opens what images need that are made `from` this. The device is started where they are made of the whole site.
    ///
    /// # Errors
    /// Those of [`LdiSite::open`], of `start` and of [`preview::open`].
    pub fn open(
        folder: &Path,
        project: &'a Project,
        site: &'a Site,
        from: &BuildFrom,
        start: StartDevice,
        task: &Task,
    ) -> Result<Self> {
        let source = task.timed("read stacks", || LdiSite::open(folder, project, site))?;
        let preview = match from {
            BuildFrom::Site { preview, .. } => {
                let device = task.timed("start the GPU", start)?;
                Some(preview::open(folder, project, site, &*device, preview, task)?)
            }
            BuildFrom::Stack(_) | BuildFrom::Photos { .. } => None,
        };
        Ok(Self { source, preview })
    }

    /// Makes the image of a camera.
    ///
    /// # Errors
    /// Those of the way in which it is made.
    pub fn image_of(&mut self, camera: &BuildCamera, from: &BuildFrom, task: &Task) -> Result<Ldi> {
        match from {
            BuildFrom::Stack(options) => self.source.ldi_of_stack(camera.photo()?, options, task),
            BuildFrom::Photos { options, best, with } => {
                let photo = camera.photo()?;
                let photos = match &with[..] {
                    [] => self.source.with_best(photo, *best),
                    with => self.usable(first_of(photo, with)),
                };
                if with.is_empty() && photos.len() < *best {
                    let (found, subject) = (photos.len(), task.with_subject(&camera.name));
                    subject.note(format!(
                        "no more than {found} photos show what it shows; {best} were to be combined"
                    ));
                }
                self.source.ldi_of_photos(&photos, options, task)
            }
            BuildFrom::Site { options, .. } => self.image_of_site(camera, options, task),
        }
    }

    /// Returns why photos that were named to be combined cannot be.
    pub fn unusable(&self, from: &BuildFrom) -> Vec<Error> {
        let BuildFrom::Photos { with, .. } = from else { return Vec::new() };
        let missing = with.iter().filter(|photo| !self.source.has_stack(**photo));
        missing.map(|photo| no_stack(&self.source.site().photo(*photo).name)).collect()
    }

    /// Returns the first one of some photos, and those of the others that have a stack.
    fn usable(&self, photos: Vec<PhotoId>) -> Vec<PhotoId> {
        let others = photos.iter().skip(1).copied().filter(|photo| self.source.has_stack(*photo));
        photos.iter().take(1).copied().chain(others).collect()
    }

    /// Makes the image of the whole site for a camera.
    ///
    /// # Errors
    /// [`Error::Request`] where the maker was opened for something else, and those of [`LdiSite::ldi_of_site`].
    pub fn image_of_site(
        &mut self,
        camera: &BuildCamera,
        options: &SiteLdiOptions,
        task: &Task,
    ) -> Result<Ldi> {
        let without = || Error::Request("images of the site need its renderer".into());
        let preview = self.preview.as_mut().ok_or_else(without)?;
        let BuildCamera { camera, pose, photo, .. } = *camera;
        let camera = SiteCamera { camera, pose, photo, without: &[] };
        self.source.ldi_of_site(preview, camera, options, task)
    }
}

/// Returns a photo, and then the others of some, each once.
fn first_of(photo: PhotoId, photos: &[PhotoId]) -> Vec<PhotoId> {
    let mut all = vec![photo];
    for &other in photos {
        if !all.contains(&other) {
            all.push(other);
        }
    }
    all
}

/// Stands in for a device where none is needed.
#[cfg(test)]
pub(super) fn no_device() -> Result<Box<dyn quadratura_layers::device::SiteDevice>> {
    Err(Error::Gpu("images of stacks need no device".into()))
}
