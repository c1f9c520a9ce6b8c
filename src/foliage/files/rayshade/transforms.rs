//! Transforms, which act in the order in which they are written.

use glam::{DAffine3, DMat3, DVec3};

use super::super::maps::is_within_numbers;
use super::words::Words;
use quadratura_base::error::Result;

impl Words<'_> {
    /// Reads the transforms that follow. Returns all of them together.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line.
    pub fn transforms(&mut self) -> Result<DAffine3> {
        let mut map = DAffine3::IDENTITY;
        while let Some(next) = self.transform()? {
            // Points are rows in the file, so that the last transform acts last.
            map = next * map;
            if !is_within_numbers(&map) {
                return Err(self.wrong("the transforms up to here have numbers beyond 1e15 together"));
            }
        }
        Ok(map)
    }

    /// Reads a transform, if one is next.
    fn transform(&mut self) -> Result<Option<DAffine3>> {
        let map = if self.take("translate")? {
            DAffine3::from_translation(self.point("`translate`")?)
        } else if self.take("scale")? {
            DAffine3::from_scale(self.point("`scale`")?)
        } else if self.take("rotate")? {
            let axis = self.point("the axis of `rotate`")?;
            let angle = self.number("the degrees of `rotate`")?;
            let axis = axis.try_normalize();
            let axis = axis.ok_or_else(|| self.wrong("`rotate` about 0 0 0, expected a direction"))?;
            DAffine3::from_mat3(DMat3::from_axis_angle(axis, angle.to_radians()))
        } else if self.take("transform")? {
            let m: [f64; 9] = self.numbers("`transform`")?;
            let row = |i: usize| DVec3::new(m[3 * i], m[3 * i + 1], m[3 * i + 2]);
            let has_shift = self.is_number()?;
            let shift = if has_shift { self.point("the translation of `transform`")? } else { DVec3::ZERO };
            // The rows of a matrix for row vectors are the columns of its transpose.
            DAffine3::from_cols(row(0), row(1), row(2), shift)
        } else {
            return Ok(None);
        };
        Ok(Some(map))
    }
}
