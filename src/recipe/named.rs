//! Photos by abbreviated names, as they are typed.

use super::unknown_name::no_such;
use crate::document::names::without_extension;
use crate::error::{Error, Remedy, Result};
use crate::scene::{Photo, PhotoId, Site};

/// Returns the photos that `names` refer to, in the site's order; all photos for an empty list. A name may omit the
/// folder and the extension where it remains unambiguous.
///
/// # Errors
/// Returns [`Error::Request`] for names that match no photo or several; all of them together.
pub fn photos_named<'a>(site: &'a Site, names: &[String]) -> Result<Vec<&'a Photo>> {
    if names.is_empty() {
        return Ok(site.photos.iter().collect());
    }
    let mut found = Vec::new();
    let mut errors = Vec::new();
    for name in names {
        match index_of_photo(site, name) {
            Ok(index) => found.push(index),
            Err(error) => errors.push(error),
        }
    }
    found.sort_unstable();
    found.dedup();
    match Error::of_all(errors) {
        Some(error) => Err(error),
        None => Ok(found.into_iter().map(|index| site.photo(index)).collect()),
    }
}

/// Returns the id of the photo that `name` refers to.
///
/// # Errors
/// Returns [`Error::Request`] when the name matches no photo or several.
pub fn index_of_photo(site: &Site, name: &str) -> Result<PhotoId> {
    if let Some(id) = site.photo_named(name) {
        return Ok(id);
    }
    let photos = site.numbered_photos().map(|(id, photo)| (id, photo.name.as_str()));
    let candidates: Vec<_> = photos.filter(|(_, photo)| is_abbreviation_of(name, photo)).collect();
    match candidates[..] {
        [(id, _)] => Ok(id),
        [] => {
            let known = site.photos.iter().map(|photo| photo.name.as_str());
            Err(no_such("photo", name, known, Some(Remedy::List)))
        }
        _ => {
            let names: Vec<_> = candidates.iter().map(|(_, photo)| *photo).collect();
            Err(Error::Request(format!("{name:?} is ambiguous: it matches {}", names.join(", "))))
        }
    }
}

/// Returns true when `name` is an abbreviation of `photo`: without its folder, its extension, or both.
pub fn is_abbreviation_of(name: &str, photo: &str) -> bool {
    let file = photo.rsplit('/').next().unwrap_or(photo);
    name == file || name == without_extension(file) || name == without_extension(photo)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DMat3, DVec3};

    use super::*;
    use crate::geometry::Pose;
    use crate::scene::Model;
    use crate::scene::synthetic::centred;

    fn site(names: &[&str]) -> Site {
        let photo = |name: &&str| Photo {
            name: (*name).into(),
            camera: centred(4, 3, 3.0),
            pose: Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO },
            file: "nowhere".into(),
            masks: Vec::new(),
        };
        Site { photos: names.iter().map(photo).collect(), model: Arc::new(Model::default()) }
    }

    #[test]
    fn a_name_may_leave_out_folder_and_extension_where_that_leaves_no_doubt() {
        let site = site(&["a/1.jpg", "a/2.jpg", "b/2.jpg"]);
        for name in ["a/1.jpg", "1.jpg", "1", "a/1"] {
            assert_eq!(index_of_photo(&site, name).unwrap(), PhotoId(0), "{name}");
        }
        assert!(index_of_photo(&site, "2").unwrap_err().to_string().contains("a/2.jpg, b/2.jpg"));
        assert_eq!(index_of_photo(&site, "b/2").unwrap(), PhotoId(2));
    }

    #[test]
    fn photos_come_once_and_in_the_sites_order_and_all_wrong_names_are_told() {
        let site = site(&["1.jpg", "2.jpg", "3.jpg"]);
        let names = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
        let found = photos_named(&site, &names(&["3", "1", "1.jpg"])).unwrap();
        assert_eq!(found.iter().map(|photo| photo.name.as_str()).collect::<Vec<_>>(), ["1.jpg", "3.jpg"]);
        assert_eq!(photos_named(&site, &[]).unwrap().len(), 3);
        let message = photos_named(&site, &names(&["8", "9"])).unwrap_err().to_string();
        assert!(message.contains('8') && message.contains('9'), "{message}");
    }
}
