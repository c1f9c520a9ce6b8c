//! COLMAP's camera models: their numbers, names and parameters.

use super::raw::RawCamera;
use quadratura_base::geometry::Lens;
use quadratura_files::text::Objection;

/// One of COLMAP's camera models.
pub(super) struct ColmapModel {
    /// The model's name in text files; its index in [`MODELS`] is its number in binary files.
    pub name: &'static str,
    /// The parameters in file order, as COLMAP's documentation writes them.
    pub parameters: &'static str,
    /// From the parameters behind focal length(s) and principal point.
    lens: fn(&[f64]) -> Lens,
}

/// All models, in the order of their numbers. Source: COLMAP, `src/colmap/sensor/models.h`.
pub(super) const MODELS: [ColmapModel; 18] = [
    model("SIMPLE_PINHOLE", "f, cx, cy", |_| Lens::None),
    model("PINHOLE", "fx, fy, cx, cy", |_| Lens::None),
    model("SIMPLE_RADIAL", "f, cx, cy, k", |k| brown([k[0], 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 2])),
    model("RADIAL", "f, cx, cy, k1, k2", |k| brown([k[0], k[1], 0.0, 0.0, 0.0, 0.0], [0.0; 2])),
    model("OPENCV", "fx, fy, cx, cy, k1, k2, p1, p2", |k| {
        brown([k[0], k[1], 0.0, 0.0, 0.0, 0.0], [k[2], k[3]])
    }),
    model("OPENCV_FISHEYE", "fx, fy, cx, cy, k1, k2, k3, k4", |k| fisheye([k[0], k[1], k[2], k[3]])),
    model("FULL_OPENCV", "fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6", |k| {
        brown([k[0], k[1], k[4], k[5], k[6], k[7]], [k[2], k[3]])
    }),
    model("FOV", "fx, fy, cx, cy, omega", |k| Lens::Fov { omega: k[0] }),
    model("SIMPLE_RADIAL_FISHEYE", "f, cx, cy, k", |k| fisheye([k[0], 0.0, 0.0, 0.0])),
    model("RADIAL_FISHEYE", "f, cx, cy, k1, k2", |k| fisheye([k[0], k[1], 0.0, 0.0])),
    model("THIN_PRISM_FISHEYE", "fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, sx1, sy1", |k| Lens::Fisheye {
        k: [k[0], k[1], k[4], k[5]],
        p: [k[2], k[3]],
        s: [k[6], k[7]],
    }),
    model(
        "RAD_TAN_THIN_PRISM_FISHEYE",
        "fx, fy, cx, cy, k0, k1, k2, k3, k4, k5, p0, p1, s0, s1, s2, s3",
        |k| Lens::PrismFisheye {
            k: [k[0], k[1], k[2], k[3], k[4], k[5]],
            p: [k[6], k[7]],
            s: [k[8], k[9], k[10], k[11]],
        },
    ),
    model("SIMPLE_DIVISION", "f, cx, cy, k", |k| Lens::Division { k: k[0] }),
    model("DIVISION", "fx, fy, cx, cy, k", |k| Lens::Division { k: k[0] }),
    model("SIMPLE_FISHEYE", "f, cx, cy", |_| fisheye([0.0; 4])),
    model("FISHEYE", "fx, fy, cx, cy", |_| fisheye([0.0; 4])),
    model("EUCM", "fx, fy, cx, cy, alpha, beta", |k| Lens::Eucm { alpha: k[0], beta: k[1] }),
    model("EQUIRECTANGULAR", "w, h", |_| Lens::None),
];

const fn model(name: &'static str, parameters: &'static str, lens: fn(&[f64]) -> Lens) -> ColmapModel {
    ColmapModel { name, parameters, lens }
}

fn brown(k: [f64; 6], p: [f64; 2]) -> Lens {
    Lens::Brown { k, p }
}

fn fisheye(k: [f64; 4]) -> Lens {
    Lens::Fisheye { k, p: [0.0; 2], s: [0.0; 2] }
}

impl ColmapModel {
    /// The model with this name, as in text files.
    pub fn by_name(name: &str) -> Option<&'static Self> {
        MODELS.iter().find(|model| model.name == name)
    }

    /// The model with this number, as in binary files.
    pub fn by_number(number: i32) -> Option<&'static Self> {
        MODELS.get(usize::try_from(number).ok()?)
    }

    /// How many parameters it has.
    pub fn parameter_count(&self) -> usize {
        self.parameters.split(", ").count()
    }

    /// True for the one model that has no focal length, hence no pinhole of the same scale.
    pub fn is_spherical(&self) -> bool {
        self.name == "EQUIRECTANGULAR"
    }

    /// The camera with these parameters, of a photo of `width` x `height` pixels.
    ///
    /// # Errors
    /// The model is a panorama's, or `values` are not its parameters.
    pub fn camera(&self, width: u64, height: u64, values: &[f64]) -> Result<RawCamera, Objection> {
        if self.is_spherical() {
            let remedy = "cut the panorama into pinhole views first (COLMAP's panorama script does)";
            return Err(("a spherical panorama (EQUIRECTANGULAR) is not a pinhole image".into(), remedy));
        }
        let (name, expected) = (self.name, self.parameter_count());
        if values.len() != expected {
            let wanted = self.parameters;
            let found = format!("{} parameters where {name} has {expected} ({wanted})", values.len());
            return Err((found, "write all of them, in this order"));
        }
        let one_focal_length = self.parameters.starts_with("f,");
        let (fx, rest) = (values[0], &values[1..]);
        let (fy, rest) = if one_focal_length { (fx, rest) } else { (rest[0], &rest[1..]) };
        let lens = (self.lens)(&rest[2..]);
        let not_finite = values.iter().find(|value| !value.is_finite()).copied();
        match not_finite {
            Some(value) => Err((format!("a parameter is {value}"), "calibrate the camera again")),
            None => {
                Ok(RawCamera { size: [width, height], focal: [fx, fy], centre: [rest[0], rest[1]], lens })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_takes_exactly_its_parameters() {
        for (number, model) in MODELS.iter().enumerate().filter(|(_, m)| !m.is_spherical()) {
            let values: Vec<f64> = (1..=model.parameter_count()).map(|v| v as f64).collect();
            let RawCamera { size, focal, centre: [cx, cy], .. } = model.camera(40, 30, &values).unwrap();
            assert_eq!((size, focal[0]), ([40, 30], 1.0), "{number}");
            assert!(cy == cx + 1.0 && cy <= 4.0, "{number}");
        }
    }

    #[test]
    fn full_opencv_has_its_tangential_terms_in_the_middle() {
        let values: Vec<f64> = (1..=12).map(f64::from).collect();
        let camera = ColmapModel::by_name("FULL_OPENCV").unwrap().camera(1, 1, &values).unwrap();
        assert_eq!(camera.lens, Lens::Brown { k: [5.0, 6.0, 9.0, 10.0, 11.0, 12.0], p: [7.0, 8.0] });
    }

    #[test]
    fn names_and_numbers_agree_with_colmap() {
        assert_eq!(ColmapModel::by_number(4).unwrap().name, "OPENCV");
        assert_eq!(ColmapModel::by_number(10).unwrap().name, "THIN_PRISM_FISHEYE");
        assert_eq!(ColmapModel::by_number(17).unwrap().name, "EQUIRECTANGULAR");
        assert!(ColmapModel::by_number(-1).is_none() && ColmapModel::by_number(18).is_none());
        assert!(ColmapModel::by_name("pinhole").is_none());
    }
}
