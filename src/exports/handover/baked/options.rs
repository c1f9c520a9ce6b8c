//! What is wanted of a baked model.

use quadratura_handover::textured::obj::UpAxis;

/// The name of files and of the scene.
pub(super) const NAME: &str = "site";

/// The number of texels that an atlas has at most where the density is chosen automatically: most of one page of 8192 x 8192.
const AUTOMATIC_TEXELS: f64 = 48.0 * 1024.0 * 1024.0;

/// The memory that a page takes per texel, in bytes: its colours, and those of a chart of its size while they are carried outwards.
const BYTES_PER_TEXEL: u64 = 16;

/// The sides that pages may have, in texels.
pub const PAGE_SIDES: [u32; 4] = [1024, 2048, 4096, 8192];

/// Options of [`super::bake`].
#[derive(Debug, Clone, PartialEq)]
pub struct BakedOptions {
    /// The format.
    pub format: BakedFormat,
    /// The largest density of charts.
    pub density: Density,
    /// The largest side of pages in texels; `None` for 8192, or less where memory allows no more.
    pub page: Option<u32>,
    /// Whether opaque pages are PNG, without loss.
    pub png: bool,
    /// Whether what no photo shows is grey.
    pub holes: bool,
    /// The direction that is up in OBJ files.
    pub up: UpAxis,
    /// Whether pages are tiles of one picture (UDIM), for OBJ and USD.
    pub udim: bool,
    /// The approximate memory budget in bytes.
    pub memory: u64,
}

/// A format of baked models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BakedFormat {
    /// glTF 2.0 in one binary file.
    Glb,
    /// Wavefront OBJ.
    Obj,
    /// USD, as text and as a package.
    Usd,
}

/// The largest density of charts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Density {
    /// As photos show it, within one large page.
    #[default]
    Auto,
    /// Texels per unit of the world.
    PerUnit(f64),
}

impl BakedOptions {
    /// Returns the largest side of pages in texels.
    pub fn page_side(&self) -> u32 {
        let affordable =
            |side: &u32| u64::from(*side) * u64::from(*side) * BYTES_PER_TEXEL <= self.memory.max(1 << 26);
        let largest = PAGE_SIDES.into_iter().rfind(affordable).unwrap_or(PAGE_SIDES[0]);
        self.page.unwrap_or(largest)
    }

    /// Returns the largest density, and the largest number of texels.
    pub(super) fn limits(&self) -> (f64, f64) {
        match self.density {
            Density::Auto => (f64::INFINITY, AUTOMATIC_TEXELS),
            Density::PerUnit(density) => (density, f64::INFINITY),
        }
    }
}

impl Default for BakedOptions {
    fn default() -> Self {
        Self {
            format: BakedFormat::Glb,
            density: Density::Auto,
            page: None,
            png: false,
            holes: false,
            up: UpAxis::Project,
            udim: false,
            memory: 1 << 30,
        }
    }
}
