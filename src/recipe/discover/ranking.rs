//! Which of the things found are meant, judged by names, places and sizes alone.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::listing::{Folder, Listing};

/// Folders that people and programs put photos into.
const OF_PHOTOS: [&str; 6] = ["images", "photos", "photo", "pictures", "jpg", "img"];
/// Folders with pictures that are no photos, and what dense reconstructions leave.
const OF_OTHERS: [&str; 12] = [
    "mask", "depth", "normal", "thumb", "stereo", "texture", "preview", "render", "heldout", "layers",
    "exports", "cache",
];
/// What names of dense meshes hold; a coarse model is wanted.
const DENSE: [&str; 6] = ["dense", "poisson", "delaunay", "fused", "mesh", "points"];
/// A coarse model of some thousand faces has less bytes than this by far.
const COARSE_BYTES: u64 = 64 << 20;

/// Folders that may be the photos', the likeliest first: those with images in them, and those above several of
/// these, from which cameras of a rig are named (`left/0001.jpg`).
pub(super) fn photos(listing: &Listing) -> Vec<PathBuf> {
    let with_images: Vec<&Folder> = listing.folders.iter().filter(|folder| folder.images > 0).collect();
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

fn common(a: &Path, b: &Path) -> PathBuf {
    a.components().zip(b.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
}

/// Folders with cameras: those of the format that tells most first, the nearest to the root, of several reconstructions
/// side by side the one with most photos.
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

/// Models' files: coarse ones first, then the nearest to the root, then OBJ, which keeps polygons as they are.
pub(super) fn models(listing: &Listing) -> Vec<PathBuf> {
    let of_folder = |folder: &Folder| {
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

fn is_any(name: &str, words: &[&str]) -> bool {
    words.iter().any(|word| name.eq_ignore_ascii_case(word))
}

fn holds_any(name: &str, words: &[&str]) -> bool {
    let name = name.to_lowercase();
    words.iter().any(|word| name.contains(word))
}
