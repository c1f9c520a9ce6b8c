//! What all ways of making a layered depth image end with: quartiles of distances, entries of the published table, figures,
//! and the coarser levels.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::layout::{DepthPixel, Ldi, LdiKind, LdiSurface, ResolutionLevel};
use super::levels::pyramid;
use super::report::LdiReport;
use super::spacing::{distance, entry_of, normal_of, quartiles};
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::task::Task;

/// The depth pixels of a row with their columns, in the order of the layout.
pub type Row = Vec<(u16, DepthPixel)>;

/// A layered depth image whose depth pixels are known. The fields are those of [`Ldi`]; `rows` has one entry for each row of
/// the frame, and of its splat indices only the origin counts.
#[derive(Debug, Clone)]
pub struct Unfinished {
    /// See [`Ldi::kind`].
    pub kind: LdiKind,
    /// See [`Ldi::inputs`].
    pub inputs: String,
    /// See [`Ldi::camera`].
    pub camera: Pinhole,
    /// See [`Ldi::pose`].
    pub pose: Pose,
    /// See [`Ldi::photo_rect`].
    pub photo_rect: Option<PixelRect>,
    /// See [`Ldi::gain`].
    pub gain: [f64; 3],
    /// See [`Ldi::surfaces`].
    pub surfaces: Vec<LdiSurface>,
    /// See [`Ldi::sources`].
    pub sources: Vec<String>,
    /// The depth pixels of each row from the top.
    pub rows: Vec<Row>,
    /// What is counted while depth pixels are found.
    pub counts: SampleCounts,
    /// See [`LdiReport::options`].
    pub options: BTreeMap<String, String>,
}

/// What became of the samples from which depth pixels are made: see [`LdiReport`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SampleCounts {
    /// All samples.
    pub samples: u64,
    /// Those that became part of another one's depth pixel.
    pub merged: u64,
    /// Those beyond the largest number of layers.
    pub dropped: u64,
    /// Those without a colour, on surfaces that have no holes.
    pub empty: u64,
    /// Surfaces that became unknown.
    pub unknown_surfaces: u64,
}

impl std::ops::AddAssign for SampleCounts {
    fn add_assign(&mut self, other: Self) {
        self.samples += other.samples;
        self.merged += other.merged;
        self.dropped += other.dropped;
        self.empty += other.empty;
        self.unknown_surfaces += other.unknown_surfaces;
    }
}

impl Unfinished {
    /// Computes what follows from the depth pixels.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn finish(mut self, task: &Task) -> Result<Ldi> {
        let quartiles = quartiles_of(&self.camera, &self.rows);
        self.index_splats(&quartiles);
        let Self { kind, inputs, camera, pose, photo_rect, gain, surfaces, sources, rows, counts, options } =
            self;
        let level = ResolutionLevel::of_rows(camera, rows);
        task.check_cancelled()?;
        let report = LdiReport {
            depth_complexity: level.len() as f64 / level.layered().max(1) as f64,
            layers: (level.histogram().len() - 1) as u32,
            samples: counts.samples,
            merged: counts.merged,
            dropped: counts.dropped,
            empty_needed: counts.empty,
            unknown_surfaces: counts.unknown_surfaces,
            quartiles,
            options,
        };
        let levels = task.timed("levels", || pyramid(level, &surfaces));
        Ok(Ldi { kind, inputs, camera, pose, photo_rect, gain, surfaces, sources, levels, report })
    }

    /// Gives each depth pixel its entry of the published table.
    fn index_splats(&mut self, quartiles: &[f64; 3]) {
        let normal = |surface: &LdiSurface| match surface.nu == DVec3::ZERO {
            true => -DVec3::Z,
            false => normal_of(surface, &self.camera),
        };
        let normals: Vec<DVec3> =
            std::iter::once(-DVec3::Z).chain(self.surfaces.iter().map(normal)).collect();
        let camera = self.camera;
        self.rows.par_iter_mut().enumerate().for_each(|(y, row)| {
            for (column, pixel) in row {
                let normal = normals[usize::from(pixel.surface)];
                let distance = distance(&camera, *column, y as u32, pixel.inverse_depth);
                pixel.splat = pixel.splat.with_entry(entry_of(normal, distance, quartiles));
            }
        });
    }
}

/// Returns the quartiles of the distances of all depth pixels.
fn quartiles_of(camera: &Pinhole, rows: &[Row]) -> [f64; 3] {
    let of_row = |(y, row): (usize, &Row)| {
        let of_pixel =
            move |(x, pixel): &(u16, DepthPixel)| distance(camera, *x, y as u32, pixel.inverse_depth) as f32;
        row.iter().map(of_pixel).collect::<Vec<_>>()
    };
    quartiles(rows.par_iter().enumerate().flat_map_iter(of_row).collect())
}
