//! Ranking of the candidates by names, locations and sizes alone.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::listing::{FolderContents, Listing};

/// Usual names of folders for photos.
const OF_PHOTOS: [&str; 6] = ["images", "photos", "photo", "pictures", "jpg", "img"];
/// Parts of the names of folders with other pictures, and of what dense reconstruction produces.
const OF_OTHERS: [&str; 12] = [
    "mask", "depth", "normal", "thumb", "stereo", "texture", "preview", "render", "heldout", "layers",
    "exports", "cache",
];
/// Parts of the names of dense meshes; a coarse model is needed.
const DENSE: [&str; 6] = ["dense", "poisson", "delaunay", "fused", "mesh", "points"];
/// The size in bytes that no coarse model of some thousand faces reaches.
const COARSE_BYTES: u64 = 64 << 20;

/// Returns the folders that may contain the photos, the likeliest first: folders with images, and common parents of
/// several of them, because cameras of a rig have names such as `left/0001.jpg`.
pub(super) fn photos(listing: &Listing) -> Vec<PathBuf> {
    let with_images: Vec<&FolderContents> =
        listing.folders.iter().filter(|folder| folder.images > 0).collect();
    let mut all: BTreeSet<PathBuf> = with_images.iter().map(|folder| folder.path.clone()).collect();
    for (i, one) in with_images.iter().enumerate() {
        all.extend(with_images[i + 1..].iter().map(|other| common(&one.path, &other.path)));
    }
    let images = |path: &Path| -> usize {
        with_images.iter().filter(|folder| folder.path.starts_with(path)).map(|folder| folder.images).sum()
    };
    let mut ranked: Vec<_> = all
        .into_iter()
        .map(|path| {
            let odd = path.iter().any(|part| holds_any(&part.to_string_lossy(), &OF_OTHERS));
            let named = path.file_name().is_some_and(|name| is_any(&name.to_string_lossy(), &OF_PHOTOS));
            (odd, !named, path.components().count(), std::cmp::Reverse(images(&path)), path)
        })
        .collect();
    ranked.sort();
    ranked.into_iter().map(|(.., path)| path).collect()
}

/// Returns the common beginning of two paths.
fn common(a: &Path, b: &Path) -> PathBuf {
    a.components().zip(b.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
}

/// Returns the folders with cameras: those of the first format, then those nearest to the root; of several
/// reconstructions side by side, the one with most photos comes first.
pub(super) fn cameras(listing: &Listing) -> Vec<PathBuf> {
    let found = listing.folders.iter().filter_map(|folder| Some((folder.cameras?, &folder.path)));
    let mut ranked: Vec<_> = found
        .map(|(there, path)| {
            (there.format, path.components().count(), std::cmp::Reverse(there.bytes), path.clone())
        })
        .collect();
    ranked.sort();
    ranked.into_iter().map(|(.., path)| path).collect()
}

/// Returns the model files: coarse ones first, then those nearest to the root, then OBJ, which preserves polygons.
pub(super) fn models(listing: &Listing) -> Vec<PathBuf> {
    let of_folder = |folder: &FolderContents| {
        let path = folder.path.clone();
        folder.models.clone().into_iter().map(move |(name, bytes)| (path.join(name), bytes))
    };
    let mut ranked: Vec<_> = listing
        .folders
        .iter()
        .flat_map(of_folder)
        .map(|(path, bytes)| {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let dense = holds_any(&stem, &DENSE) || bytes > COARSE_BYTES;
            let is_obj = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj"));
            (dense, path.components().count(), !is_obj, path)
        })
        .collect();
    ranked.sort();
    ranked.into_iter().map(|(.., path)| path).collect()
}

/// Returns true when the name is one of the words, in upper or lower case.
fn is_any(name: &str, words: &[&str]) -> bool {
    words.iter().any(|word| name.eq_ignore_ascii_case(word))
}

/// Returns true when the name contains one of the words, in upper or lower case.
fn holds_any(name: &str, words: &[&str]) -> bool {
    let name = name.to_lowercase();
    words.iter().any(|word| name.contains(word))
}
