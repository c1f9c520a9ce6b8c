//! The faces that a view shows, and their depths: see-through ones count only where something of them is there.

use glam::DVec3;

use super::frame::StoredDepths;
use super::program::Program;
use super::render_target::{self, RenderTarget, TargetKey};
use super::tables::TableData;
use super::{DrawnSurfaces, LEAST_CELL_PX, Prepared, Renderer};
use crate::device::Gpu;
use quadratura_base::error::Result;
use quadratura_base::scene::{FaceId, Model};
use quadratura_base::task::Task;
use quadratura_projection::cells::Cells;
use quadratura_projection::exposure::ViewExposure;
use quadratura_projection::{Renders, shown_face};
use quadratura_view::optics::Optics;
use quadratura_view::{Quality, Shot};

/// Returns the view whose faces are those that a view shows: there is one a pixel, so that trees need not be finer than in previews.
pub(super) fn of_seen(shot: &Shot) -> Shot {
    Shot { quality: Quality::Preview, ..shot.clone() }
}

impl Renderer {
    /// Draws the faces that a view shows, on a site with mattes.
    pub(super) fn drawn_seen(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        let gpu = self.gpu.clone();
        render_target::judge(&gpu, shot)?;
        gpu.guarded("drawing faces", || {
            // The window draws the picture of the same view first, so that its tables and tiles serve again.
            let ready = self.ready.as_ref().filter(|(of, _)| of == shot).map(|(_, prepared)| *prepared);
            let prepared = match ready {
                Some(prepared) => prepared,
                None => self.prepare(shot, self.cell_px(shot), None, DrawnSurfaces::Nearest, task)?,
            };
            let seen = Program::of_seen_faces(shot, &self.features(false));
            self.draw(&of_seen(shot), [Program::Faces, seen], &prepared, task)?;
            self.targets[&TargetKey::of_faces(shot)].faces(&gpu)
        })
    }

    /// Draws the faces of a view as `prepared`, and reads them back; `read` gets how the depth buffer stores depths, too.
    pub(super) fn drawn_faces<T>(
        &mut self,
        shot: &Shot,
        prepared: Prepared,
        task: &Task,
        read: impl FnOnce(&RenderTarget, &Gpu, StoredDepths) -> Result<T>,
    ) -> Result<T> {
        let gpu = self.gpu.clone();
        render_target::judge(&gpu, shot)?;
        gpu.guarded("drawing faces", || {
            self.face(shot);
            // Without a known scale, depths would be so small that their differences vanish.
            let depths = match shot.parallel {
                None => [0.0, farthest(&self.model, shot.viewpoint())],
                Some(_) => range(&self.model, shot),
            };
            let depths = self.depths_with_trees(shot, depths);
            let cells = Cells { side_px: LEAST_CELL_PX, depths, ..Cells::default() };
            let photos = self.sources.photos.len();
            let (exposure, optics) = (&ViewExposure::neutral(photos), &vec![Optics::default(); photos]);
            let (groups, sky, origin) = (&self.gains.light.groups, &self.sky, self.surfaces.origin());
            let content = TableData { shot, cells: &cells, exposure, optics, groups, sky, origin };
            self.tables.write(&gpu, &self.sources, &content);
            task.check_cancelled()?;
            self.draw(shot, [Program::Faces; 2], &prepared, task)?;
            read(&self.targets[&TargetKey::of_faces(shot)], &gpu, StoredDepths::new(shot, depths))
        })
    }

    /// Draws the depths of what a view shows. Where a see-through face is only a gap, the depth is that of the plane that is
    /// seen through it.
    pub(super) fn drawn_depths(&mut self, shot: &Shot, task: &Task) -> Result<Vec<f32>> {
        let shot = &of_seen(shot);
        let (numbers, mut depths) =
            self.drawn_faces(shot, Prepared::default(), task, |target, gpu, depths| {
                let depth = |stored: &f32| depths.depth(*stored) as f32;
                Ok((target.faces(gpu)?, target.depth_buffer(gpu)?.iter().map(depth).collect::<Vec<f32>>()))
            })?;
        if self.mattes {
            let width = shot.camera.width as usize;
            let seen = self.seen_faces(shot, task)?;
            let differing =
                seen.into_iter().zip(numbers).enumerate().filter(|(_, (seen, number))| seen != number);
            for (px, (seen, _)) in differing {
                depths[px] = match (seen, shown_face(seen)) {
                    (0, _) => f32::INFINITY,
                    (_, Some(face)) => depth_of_plane(&self.model, face, shot, (px % width, px / width)),
                    // A tree behind a gap is about where the gap is.
                    (_, None) => depths[px],
                };
            }
        }
        Ok(depths)
    }
}

/// Returns the depth of a face's plane at a pixel's centre, behind the view's reference point.
fn depth_of_plane(model: &Model, face: FaceId, shot: &Shot, (column, row): (usize, usize)) -> f32 {
    let (camera, plane) = (&shot.camera, &model.face(face).plane);
    let [right, down, forward] = shot.pose.rotation_rows().map(DVec3::from);
    let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
    // The ray has a depth of 1.
    let ray = forward + right * ((x - camera.cx) / camera.fx) + down * ((y - camera.cy) / camera.fy);
    let from_viewpoint = plane.normal.dot(plane.point - shot.viewpoint()) / plane.normal.dot(ray);
    (from_viewpoint - shot.parallel.map_or(0.0, |parallel| parallel.distance)) as f32
}

/// Returns the least and the largest depth of vertices from the viewpoint, in world units.
fn range(model: &Model, shot: &Shot) -> [f64; 2] {
    let depths = model.vertices.iter().map(|vertex| shot.pose.camera_from_world(*vertex).z);
    depths.fold([f64::INFINITY, 0.0], |[low, high], depth| [depth.min(low), depth.max(high)])
}

/// Returns the distance of the farthest vertex, in world units.
fn farthest(model: &Model, viewpoint: DVec3) -> f64 {
    model.vertices.iter().map(|vertex| vertex.distance(viewpoint)).fold(0.0, f64::max)
}
