//! Numbers about a baked model.

use serde::Serialize;

/// Numbers about a baked model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BakedReport {
    /// The number of faces, cards included.
    pub faces: usize,
    /// The number of charts.
    pub charts: usize,
    /// Width and height of each page in texels.
    pub pages: Vec<[u32; 2]>,
    /// The median of the charts' densities, in texels per unit, by area.
    pub density: f64,
    /// The largest density that the size of the atlas left; `None` where it took no effect.
    pub density_cap: Option<f64>,
    /// The share of texels for which photos have fewer pixels, 0 to 1.
    pub upsampled: f64,
    /// The shares of texels by what they show.
    pub coverage: Coverage,
}

/// How much of the texels is known: numbers of texels, or shares of them.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Coverage {
    /// Shown by a photo, or painted.
    pub photographed: f64,
    /// Filled from other photos.
    pub filled: f64,
    /// Inpainted.
    pub inpainted: f64,
    /// Not shown by any photo.
    pub nothing: f64,
}

impl Coverage {
    /// Adds the numbers of other texels.
    pub fn add(&mut self, other: &Self) {
        self.photographed += other.photographed;
        self.filled += other.filled;
        self.inpainted += other.inpainted;
        self.nothing += other.nothing;
    }

    /// Returns the shares of all texels, 0 to 1.
    pub fn as_shares(&self) -> Self {
        let all = (self.photographed + self.filled + self.inpainted + self.nothing).max(1.0);
        Self {
            photographed: self.photographed / all,
            filled: self.filled / all,
            inpainted: self.inpainted / all,
            nothing: self.nothing / all,
        }
    }
}
