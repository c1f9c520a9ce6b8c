//! A model with one set of textures, as other programs take it: polygons with texture coordinates, on pages.
//!
//! | module | contents |
//! |---|---|
//! | (this file) | the model as plain data, with the vertices that formats share |
//! | `encoded` | pages as JPEG and PNG |
//! | [`glb`], [`obj`], [`usd`] | the files of each format |

mod encoded;
pub mod glb;
pub mod obj;
pub mod usd;

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;

pub use encoded::{PageKind, encoded};

/// A model with textures. Positions are those of the world less [`Self::origin`], in its units.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TexturedModel {
    /// The name that files and scenes get.
    pub name: String,
    /// The point of the world that is the origin of all positions.
    pub origin: DVec3,
    /// The unit up direction.
    pub up: DVec3,
    /// The objects, in the model's order.
    pub objects: Vec<TexturedObject>,
    /// The textures.
    pub pages: Vec<TexturePage>,
}

/// A named object.
#[derive(Debug, Clone, PartialEq)]
pub struct TexturedObject {
    /// The unique name.
    pub name: String,
    /// The faces, in the model's order.
    pub faces: Vec<TexturedFace>,
    /// Whether it is a flat stand-in that other programs should not take for a wall.
    pub billboard: bool,
}

/// A polygon on a page.
#[derive(Debug, Clone, PartialEq)]
pub struct TexturedFace {
    /// The outline: one ring, holes bridged by doubled edges.
    pub corners: Vec<Corner>,
    /// The triangles, as indices into the corners.
    pub triangles: Vec<[u32; 3]>,
    /// The index of the page.
    pub page: usize,
}

/// A corner of a polygon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// The position.
    pub position: DVec3,
    /// The place on the page: 0 to 1, from the left and from the top.
    pub uv: DVec2,
}

/// A texture.
#[derive(Debug, Clone, PartialEq)]
pub struct TexturePage {
    /// The name of its file, and without ending that of the material.
    pub file: String,
    /// The format of the file.
    pub kind: PageKind,
    /// Its number, from 0, where pages are tiles of one picture (UDIM); the file is `SET.1001.ENDING` then, and so on.
    pub tile: Option<u32>,
    /// The file's bytes.
    pub bytes: Vec<u8>,
}

/// The number of the first tile of a picture; there are ten in a row.
pub const FIRST_UDIM: u32 = 1001;

impl TexturePage {
    /// Returns the name of the material.
    pub fn material(&self) -> &str {
        self.file.rsplit_once('.').map_or(&self.file, |(stem, _)| stem)
    }

    /// Returns the name of the picture that it is a tile of; of a page that is none that of its material.
    pub fn set(&self) -> &str {
        let material = self.material();
        match self.tile {
            Some(_) => material.rsplit_once('.').map_or(material, |(set, _)| set),
            None => material,
        }
    }

    /// Returns the coordinates of texture of a place on the page, which is 0 to 1 from the left and from the top: v runs upwards, and a tile has
    /// its own square of the plane.
    pub fn st(&self, uv: DVec2) -> DVec2 {
        let tile = self.tile.unwrap_or(0);
        DVec2::new(uv.x + f64::from(tile % 10), 1.0 - uv.y + f64::from(tile / 10))
    }
}

impl TexturedObject {
    /// Returns the runs of faces on one page, which become one primitive each: so faces keep their order.
    pub fn runs(&self) -> impl Iterator<Item = &[TexturedFace]> {
        self.faces.chunk_by(|a, b| a.page == b.page)
    }
}

/// A file of a format: its name, relative to the folder, and its bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenFile {
    /// The name.
    pub name: String,
    /// The content.
    pub bytes: Vec<u8>,
}

/// Values of corners, each once, in the order of first use.
struct Shared<K> {
    known: FxHashMap<K, usize>,
}

impl<K: std::hash::Hash + Eq> Shared<K> {
    fn new() -> Self {
        Self { known: FxHashMap::default() }
    }

    /// Returns the number of a value, and whether it is new.
    fn number(&mut self, value: K) -> (usize, bool) {
        let next = self.known.len();
        let number = *self.known.entry(value).or_insert(next);
        (number, number == next)
    }
}

#[cfg(test)]
mod tests;
