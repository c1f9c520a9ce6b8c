//! RealityScan and RealityCapture: a file `.xmp` beside each photo, or one table of *Internal/External camera parameters*.
//!
//! Both have the focal length for a frame 36 mm wide, so that it is in parts of 36 of the photo's longer side; the principal point
//! is from the middle in parts of the longer side. Sizes are those of the photos' files. Sources: nerfstudio after its repair of
//! issue 3131; reports of users for the tangential coefficients. Not tried with the program itself.

pub(super) mod table;
pub(super) mod xmp;

use super::raw::RawCamera;
use quadratura_base::geometry::Lens;
use quadratura_files::text::Objection;

/// The intrinsics of a photo, in the units of the program.
#[derive(Debug, Clone, Default)]
struct Intrinsics {
    /// The focal length for a frame 36 mm wide.
    focal_mm: f64,
    /// Focal length along y, in focal lengths along x.
    aspect: f64,
    /// The principal point from the middle, in longer sides.
    principal: [f64; 2],
    /// The name of the lens model; empty for Brown's.
    model: String,
    /// k1 to k4, t1 and t2.
    coefficients: [f64; 6],
}

impl Intrinsics {
    /// Returns the camera of a photo with this size.
    fn camera(&self, size: [u64; 2]) -> Result<RawCamera, Objection> {
        let longer = size[0].max(size[1]) as f64;
        let f = self.focal_mm * longer / 36.0;
        let centre = [0, 1].map(|axis| 0.5 * size[axis] as f64 + self.principal[axis] * longer);
        let [k1, k2, k3, k4, t1, t2] = self.coefficients;
        let (k, p) = ([k1, k2, k3, k4], [t1, t2]);
        let lens = match self.model.to_lowercase().as_str() {
            "none" | "perspective" => Lens::None,
            "division" => Lens::Division { k: k1 },
            model if model.is_empty() || model.starts_with("brown") => match k4 {
                0.0 => Lens::Brown { k: [k1, k2, k3, 0.0, 0.0, 0.0], p },
                _ => Lens::Skewed { k, p, skew: 0.0 },
            },
            model => {
                let found =
                    format!("the distortion model {model:?}, expected brown3, brown4, division or none");
                return Err((found, "align with one of these, and export again"));
            }
        };
        Ok(RawCamera { size, focal: [f, f * self.aspect], centre, lens })
    }

    fn has_tangential(&self) -> bool {
        self.coefficients[4..] != [0.0; 2]
    }
}

/// Returns the note about photos with tangential coefficients.
fn tangential_note(file: &std::path::Path, photos: usize) -> Option<String> {
    (photos > 0).then(|| {
        format!(
            "{}: {photos} photos have tangential coefficients t1 and t2, which are read as OpenCV's p1 and p2; this was not tried \
             with the program itself: compare the pictures of `check`, or export without them",
            file.display()
        )
    })
}
