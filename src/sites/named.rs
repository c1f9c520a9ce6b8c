//! Photos and objects by the names by which they are asked for.

use std::borrow::Cow;

use crate::unknown_name::no_such;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::alike::{composed, folded};
use quadratura_base::scene::{Model, ObjectId, Photo, PhotoId, Site};
use quadratura_document::names::without_extension;
use quadratura_layers::fill::options::matches_pattern;

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

/// Returns the id of the photo that `name` refers to: its whole name, or what [`meant`] understands.
///
/// # Errors
/// Returns [`Error::Request`] when the name matches no photo or several.
pub fn index_of_photo(site: &Site, name: &str) -> Result<PhotoId> {
    let names: Vec<&str> = site.photos.iter().map(|photo| photo.name.as_str()).collect();
    let candidates = meant(name, &names);
    match candidates[..] {
        [index] => Ok(PhotoId::new(index)),
        [] => {
            let known = site.photos.iter().map(|photo| photo.name.as_str());
            Err(no_such("photo", name, known, Some(Remedy::List)))
        }
        _ => {
            let names: Vec<_> = candidates.iter().map(|index| names[*index]).collect();
            Err(Error::Request(format!("{name:?} is ambiguous: it matches {}", names.join(", "))))
        }
    }
}

/// Tells whether a typed name can mean a photo of a name.
type Form = fn(&str, &str) -> bool;

/// Maps names that are spelled differently to the same text.
type Spelling = fn(&str) -> Cow<'_, str>;

/// Returns the indices of the photos that a typed name can mean: the one of this whole name; else those of which it is
/// the name without folder, extension, or both; else those that begin or end with this number (`4` for
/// `IMG_0004.jpg` and for `04_gate.jpg`); else those that end with this word (`gate` for `north-gate.jpg`). Each form is looked for
/// exactly first, then in any Unicode form and with `\` for `/`, then in any letter case.
pub fn meant(name: &str, photos: &[&str]) -> Vec<usize> {
    let forms: [Form; 4] = [
        |name, photo| photo == name,
        is_abbreviation_of,
        |name, photo| is_number(name) && numbers_of(file_of(photo)).contains(&Some(significant(name))),
        |name, photo| is_last_word_of(name, file_of(photo)),
    ];
    let spellings: [Spelling; 3] = [|name| name.into(), composed, folded];
    let mut ways = forms.iter().flat_map(|form| spellings.iter().map(move |spelling| (form, spelling)));
    let matching = |(is_meant, spelling): (&Form, &Spelling)| {
        let name = spelling(name);
        let found = (0..photos.len()).filter(|index| is_meant(&name, &spelling(photos[*index])));
        Some(found.collect::<Vec<_>>()).filter(|found| !found.is_empty())
    };
    ways.find_map(matching).unwrap_or_default()
}

/// Returns a photo's name without its folder and extension.
fn file_of(photo: &str) -> &str {
    without_extension(photo.rsplit('/').next().unwrap_or(photo))
}

/// Returns true when `name` is an abbreviation of `photo`: without its folder, its extension, or both.
fn is_abbreviation_of(name: &str, photo: &str) -> bool {
    let file = photo.rsplit('/').next().unwrap_or(photo);
    name == file || name == file_of(photo) || name == without_extension(photo)
}

fn is_number(name: &str) -> bool {
    !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_digit())
}

/// Returns the digits at the end of a file's name, and those at its beginning where no letter follows, without leading
/// zeros.
fn numbers_of(file: &str) -> [Option<&str>; 2] {
    let is_digit = |c: char| c.is_ascii_digit();
    let last = &file[file.trim_end_matches(is_digit).len()..];
    let rest = file.trim_start_matches(is_digit);
    let first = &file[..file.len() - rest.len()];
    let first = if rest.starts_with(char::is_alphabetic) { "" } else { first };
    [last, first].map(|digits| (!digits.is_empty()).then(|| significant(digits)))
}

/// Returns digits without leading zeros, by which numbers of any length are compared.
fn significant(digits: &str) -> &str {
    digits.trim_start_matches('0')
}

/// Returns true when a file's name ends with `name`, and the character before it is neither letter nor digit.
fn is_last_word_of(name: &str, file: &str) -> bool {
    let before = file.strip_suffix(name).filter(|_| !name.is_empty());
    before.and_then(|before| before.chars().next_back()).is_some_and(|c| !c.is_alphanumeric())
}

/// Returns the object with a name, in another spelling where none has exactly this one (`Model::object_like`), or the objects with
/// names like a pattern ([`matches_pattern`]).
///
/// # Errors
/// Returns [`Error::Request`] when the model has none of that name.
pub fn objects_named(model: &Model, pattern: &str) -> Result<Vec<ObjectId>> {
    if let Some(object) = model.object_like(pattern) {
        return Ok(vec![object]);
    }
    let all = (0..).map(ObjectId).zip(&model.objects);
    let meant: Vec<ObjectId> =
        all.filter(|(_, object)| matches_pattern(&object.name, pattern)).map(|(id, _)| id).collect();
    if meant.is_empty() {
        let known = model.objects.iter().map(|object| object.name.as_str());
        return Err(no_such("object", pattern, known, Some(Remedy::ListObjects)));
    }
    Ok(meant)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DMat3, DVec3};

    use super::*;
    use quadratura_base::geometry::Pose;
    use quadratura_base::scene::Model;
    use quadratura_base::scene::synthetic::centred;

    fn site(names: &[&str]) -> Site {
        let photo = |name: &&str| Photo {
            name: (*name).into(),
            camera: centred(4, 3, 3.0),
            pose: Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO },
            file: "nowhere".into(),
            masks: Vec::new(),
            exposure: None,
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
    fn a_number_or_the_last_word_is_enough_where_it_leaves_no_doubt() {
        let photos = ["0000.jpg", "0004.jpg", "0014.jpg", "x/IMG_0020.jpg", "north-gate.jpg", "a/gate.jpg"];
        for (name, found) in [
            ("4", vec![1]),
            ("0", vec![0]),
            ("14", vec![2]),
            ("20", vec![3]),
            ("0020", vec![3]),
            ("gate", vec![5]),
            ("IMG_0020", vec![3]),
            ("te", vec![]),
            ("", vec![]),
            ("40", vec![]),
        ] {
            assert_eq!(meant(name, &photos), found, "{name}");
        }
        assert_eq!(meant("gate", &photos[..5]), [4], "the last word where no photo has the name");
        assert_eq!(meant("1", &["01_church.jpg", "10_arcade.jpg", "1st.jpg"]), [0]);
        assert_eq!(meant("7", &["a7.jpg", "b07.jpg", "77.jpg"]), [0, 1], "two photos have the number");
        assert_eq!(meant("2", &["2.jpg", "b/02.jpg"]), [0], "a name goes before a number");
    }

    #[test]
    fn a_name_is_meant_in_any_unicode_form_and_letter_case_where_no_exact_one_is() {
        let photos = ["Co\u{302}te\u{301}/Mur.JPG", "c\u{f4}t\u{e9}/porte.jpg", "porte.jpg", "PORTE.jpg"];
        for (name, found) in [
            ("c\u{f4}t\u{e9}\\mur.jpg", vec![0]),
            ("mur", vec![0]),
            ("co\u{302}te\u{301}/porte.jpg", vec![1]),
            ("porte.jpg", vec![2]),
            ("PORTE.jpg", vec![3]),
            ("Porte.jpg", vec![2, 3]),
            ("fen\u{ea}tre", vec![]),
        ] {
            assert_eq!(meant(name, &photos), found, "{name}");
        }
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
