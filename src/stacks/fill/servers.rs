//! Which photos show a face, and which keep what they show of it.

use quadratura_base::scene::{FaceId, Photo, PhotoId, Site};
use quadratura_document::Project;
use quadratura_projection::Sources;

/// Returns, for each face, the photos that have it in their working set.
pub(super) fn serving(sources: &Sources) -> Vec<Vec<PhotoId>> {
    let of_face = |range: &std::ops::Range<u32>| {
        let servers = &sources.servers[range.start as usize..range.end as usize];
        let mut photos: Vec<PhotoId> = servers.iter().map(|server| server.photo).collect();
        photos.dedup();
        photos
    };
    sources.of_face.iter().map(of_face).collect()
}

/// Returns true when paint of other photos does not replace what a photo shows of a face: the face is pinned to the
/// photo, whose pixels were chosen, or the photo is excluded from it and textures nothing of it.
pub(super) fn keeps_pixels(project: &Project, site: &Site, photo: &Photo, face: FaceId) -> bool {
    let decisions = &project.decisions;
    let face = site.model.face(face);
    let object = &site.model.object(face.object).name;
    let names = site.photos.iter().map(|photo| photo.name.as_str());
    decisions.of(&photo.name).excludes(object, face.index)
        || decisions.pinned(names, object, face.index) == Some(&photo.name)
}
