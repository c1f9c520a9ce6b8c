//! What is wanted of a page.

use std::path::PathBuf;

/// Options of [`super::publish`].
#[derive(Debug, Clone, PartialEq)]
pub struct PageOptions {
    /// The title; that which the project keeps without one.
    pub title: Option<String>,
    /// The quality of JPEGs, from 1 to 100.
    pub quality: u8,
    /// The longest side of published photos, in pixels.
    pub longest: u32,
    /// The most bytes of all files together.
    pub budget: u64,
    /// Who is to be named below the page; those whom the project keeps where there is nobody.
    pub credits: Vec<String>,
    /// The licence of the photos: an SPDX name, or the address of a text; that which the project keeps without one.
    pub licence: Option<String>,
    /// The bookmark at which a visit starts; without one, the first, or a photo where there are none.
    pub viewpoint: Option<String>,
    /// Whether photos keep their names, and objects theirs.
    pub keep_names: bool,
    /// Whether coordinates are those of the world.
    pub keep_coordinates: bool,
    /// The most bytes of memory for what is not written yet.
    pub memory: u64,
}

impl Default for PageOptions {
    fn default() -> Self {
        Self {
            title: None,
            quality: 80,
            longest: MOST_SIDE,
            budget: 150_000_000,
            credits: Vec::new(),
            licence: None,
            viewpoint: None,
            keep_names: false,
            keep_coordinates: false,
            memory: quadratura_sites::budget::default_memory(),
        }
    }
}

/// The longest side of a published photo, in pixels: the largest texture of phones.
pub const MOST_SIDE: u32 = 4096;

/// A photo that leaves the house.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct LeavingPhoto {
    /// Its name in the project.
    pub photo: String,
    /// The name under which it is published.
    pub published: String,
    /// The size of the published picture, in pixels.
    pub size: [u32; 2],
}

/// What was published.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Published {
    /// The folder.
    pub folder: PathBuf,
    /// Existing folders of that name, which are kept.
    pub spared: Vec<PathBuf>,
    /// The photos.
    pub photos: Vec<LeavingPhoto>,
    /// The bytes of all files together.
    pub bytes: u64,
    /// The bytes of the data for the first picture.
    pub first: u64,
    /// The bytes of the viewer.
    pub viewer: u64,
    /// The bytes by what they are for.
    pub parts: Vec<PagePart>,
    /// What the page lacks, in sentences.
    pub left_out: Vec<String>,
}

/// The bytes of one kind of data.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct PagePart {
    /// What it is.
    pub what: &'static str,
    /// The bytes of the files.
    pub bytes: u64,
}
