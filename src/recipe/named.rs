//! Photos by the names that people type.

use crate::document::names::without_extension;
use crate::error::{Error, Result};
use crate::scene::{Photo, Site};

/// The photos that `names` ask for, in the site's order; all of them when it asks for none. A name may
/// leave out the folder and the extension where that leaves no doubt.
///
/// # Errors
/// [`Error::Request`] for a name that no photo or more than one answers to; all such names at once.
pub fn photos_named<'a>(site: &'a Site, names: &[String]) -> Result<Vec<&'a Photo>> {
    if names.is_empty() {
        return Ok(site.photos.iter().collect());
    }
    let (mut found, mut errors) = (Vec::new(), Vec::new());
    for name in names {
        match place_of_photo(site, name) {
            Ok(place) => found.push(place),
            Err(error) => errors.push(error),
        }
    }
    found.sort_unstable();
    found.dedup();
    match Error::of_all(errors) {
        Some(error) => Err(error),
        None => Ok(found.into_iter().map(|place| &site.photos[place]).collect()),
    }
}

/// The place in the site's photos of the one that `name` asks for.
///
/// # Errors
/// [`Error::Request`] when none or more than one answers to it.
pub fn place_of_photo(site: &Site, name: &str) -> Result<usize> {
    let photos = || site.photos.iter().map(|photo| photo.name.as_str());
    if let Some(place) = photos().position(|photo| photo == name) {
        return Ok(place);
    }
    let candidates: Vec<_> = photos().enumerate().filter(|(_, photo)| is_short_for(name, photo)).collect();
    match candidates[..] {
        [(place, _)] => Ok(place),
        [] => Err(Error::Request(format!("there is no photo {name}; `quadratura info` lists the photos"))),
        _ => {
            let names: Vec<_> = candidates.iter().map(|(_, photo)| *photo).collect();
            Err(Error::Request(format!("{name} is ambiguous: it matches {}", names.join(", "))))
        }
    }
}

/// Whether `name` is what `photo` may be called for short.
pub fn is_short_for(name: &str, photo: &str) -> bool {
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
            assert_eq!(place_of_photo(&site, name).unwrap(), 0, "{name}");
        }
        assert!(place_of_photo(&site, "2").unwrap_err().to_string().contains("a/2.jpg, b/2.jpg"));
        assert_eq!(place_of_photo(&site, "b/2").unwrap(), 2);
    }

    #[test]
    fn photos_come_once_and_in_the_sites_order_and_all_wrong_names_are_told() {
        let site = site(&["1.jpg", "2.jpg", "3.jpg"]);
        let names = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
        let found = photos_named(&site, &names(&["3", "1", "1.jpg"])).unwrap();
        assert_eq!(found.iter().map(|photo| photo.name.as_str()).collect::<Vec<_>>(), ["1.jpg", "3.jpg"]);
        assert_eq!(photos_named(&site, &[]).unwrap().len(), 3);
        let told = photos_named(&site, &names(&["8", "9"])).unwrap_err().to_string();
        assert!(told.contains('8') && told.contains('9'), "{told}");
    }
}
