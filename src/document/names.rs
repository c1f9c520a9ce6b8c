//! File names made from photo names, by the one rule for stacks, exports and renders.

use std::collections::BTreeSet;

/// Returns a name for a file or folder that stands for `photo`: every byte outside `A-Za-z0-9._-` becomes `%XX`
/// (upper-case hexadecimal). Different photos get different names, and [`photo_of_file_name`] is the inverse. The
/// result never contains `/`, `\`, `+` or `~`, so that a caller may add its own suffix after one of these.
///
/// Three names would not be valid file names although the rule keeps them: the empty name becomes `%`, `.` becomes
/// `%2E` and `..` becomes `%2E%2E`.
pub fn file_name_of_photo(photo: &str) -> String {
    match photo {
        "" => return "%".into(),
        "." => return "%2E".into(),
        ".." => return "%2E%2E".into(),
        _ => (),
    }
    let mut name = String::with_capacity(photo.len());
    for byte in photo.bytes() {
        if byte.is_ascii_alphanumeric() || b"._-".contains(&byte) {
            name.push(byte.into());
        } else {
            name.push_str(&format!("%{byte:02X}"));
        }
    }
    name
}

/// Returns distinct names without extensions for the pictures of photos: `nord/1.jpg` gives `nord%2F1`. Photos that
/// differ only in their extensions keep them: `1.jpg` and `1.png`.
pub fn picture_names(photos: &[&str]) -> Vec<String> {
    let short: Vec<String> =
        photos.iter().map(|photo| file_name_of_photo(without_extension(photo))).collect();
    let full: Vec<String> = photos.iter().map(|photo| file_name_of_photo(photo)).collect();
    let mixed: Vec<String> = short
        .iter()
        .zip(&full)
        .map(|(name, full)| if short.iter().filter(|other| *other == name).count() > 1 { full } else { name })
        .cloned()
        .collect();
    let distinct: BTreeSet<&String> = mixed.iter().collect();
    if distinct.len() == mixed.len() { mixed } else { full }
}

/// Returns a photo's name without its file extension; a dot in a folder's name does not start an extension.
pub fn without_extension(photo: &str) -> &str {
    match photo.rsplit_once('.') {
        Some((stem, extension)) if !stem.is_empty() && !stem.ends_with('/') && !extension.contains('/') => {
            stem
        }
        _ => photo,
    }
}

/// Returns the photo that `name` stands for; `None` for a name that [`file_name_of_photo`] does not produce.
pub fn photo_of_file_name(name: &str) -> Option<String> {
    let photo = if name == "%" { String::new() } else { String::from_utf8(decoded(name)?).ok()? };
    (file_name_of_photo(&photo) == name).then_some(photo)
}

/// Decodes `%XX` sequences.
fn decoded(name: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(name.len());
    let mut rest = name.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(if byte == b'%' {
            16 * hex_digit(rest.next()?)? + hex_digit(rest.next()?)?
        } else {
            byte
        });
    }
    Some(bytes)
}

fn hex_digit(byte: u8) -> Option<u8> {
    char::from(byte).to_digit(16).map(|digit| digit as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_plain_name_stays_as_it_is() {
        assert_eq!(file_name_of_photo("IMG_0001-b.JPG"), "IMG_0001-b.JPG");
    }

    #[test]
    fn pictures_have_no_extensions_unless_these_tell_photos_apart() {
        assert_eq!(picture_names(&["0001.jpg", "a/b.c/d"]), ["0001", "a%2Fb.c%2Fd"]);
        assert_eq!(picture_names(&["1.jpg", "1.png", "2.jpg"]), ["1.jpg", "1.png", "2"]);
        assert_eq!(picture_names(&["1.jpg", "1.png", "1.jpg.tif"]), ["1.jpg", "1.png", "1.jpg.tif"]);
        assert_eq!(picture_names(&["a/.jpg"]), ["a%2F.jpg"]);
    }

    #[test]
    fn slashes_spaces_percents_and_umlauts_are_escaped_byte_by_byte() {
        assert_eq!(file_name_of_photo("nord/tür 1%.png"), "nord%2Ft%C3%BCr%201%25.png");
    }

    #[test]
    fn no_photo_becomes_the_folder_itself_or_the_one_above() {
        for photo in ["", ".", ".."] {
            let name = file_name_of_photo(photo);
            assert!(!["", ".", ".."].contains(&name.as_str()));
            assert_eq!(photo_of_file_name(&name).as_deref(), Some(photo));
        }
    }

    #[test]
    fn a_name_of_another_making_stands_for_no_photo() {
        for name in ["", ".", "..", "a b", "a/b", "%4", "%zz", "%2f", "%41", "%FF", "a+new"] {
            assert_eq!(photo_of_file_name(name), None, "{name}");
        }
    }

    proptest! {
        #[test]
        fn every_name_comes_back(photo in ".*") {
            let name = file_name_of_photo(&photo);
            prop_assert!(name.bytes().all(|b| b.is_ascii_alphanumeric() || b"._-%".contains(&b)));
            prop_assert_eq!(photo_of_file_name(&name), Some(photo));
        }
    }
}
