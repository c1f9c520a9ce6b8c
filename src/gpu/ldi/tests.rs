//! The warp on the GPU: its shaders without a device, and its pictures against the processor's.

mod shaders;
mod twin;

use std::sync::Arc;

use glam::DVec3;

use super::{GpuLdi, GpuWarp};
use crate::Gpu;
use quadratura_base::error::Error;
use quadratura_base::geometry::Pose;
use quadratura_base::scene::synthetic::{Modeller, camera_is_world, centred};
use quadratura_base::task::Task;
use quadratura_ldi::synthetic::{of_model, with_level};
use quadratura_ldi::{Ldi, ResolutionLevel, Spacing, SplatKind, WarpOptions, Warped, warp};
use quadratura_view::Shot;

/// The kinds of splats that the GPU draws.
const SPLATS: [SplatKind; 2] = [SplatKind::Pixel, SplatKind::Sums];

fn of_splat(splat: SplatKind) -> WarpOptions {
    WarpOptions { splat, ..WarpOptions::default() }
}

fn on_adapter() -> Option<GpuWarp> {
    crate::left_out::on_adapter(Gpu::headless().and_then(|gpu| GpuWarp::new(&gpu)))
}

fn uploaded(gpu: &GpuWarp, ldi: Ldi) -> GpuLdi {
    gpu.upload(Arc::new(ldi)).unwrap()
}

fn picture(gpu: &mut GpuWarp, ldi: &GpuLdi, shot: &Shot, options: &WarpOptions) -> Warped {
    gpu.picture(ldi, shot, options, &Task::silent()).unwrap()
}

fn on_processor(ldi: &Ldi, shot: &Shot, options: &WarpOptions) -> Warped {
    warp(ldi, shot, options, &Task::silent()).unwrap()
}

/// Returns a white wall before the reference camera, which is the world's.
fn wall() -> Ldi {
    let mut model = Modeller::new();
    model.object("wall").screen(4.0, [-4.0, -4.0, 4.0, 4.0]);
    of_model(&model.finish(), centred(64, 48, 50.0), camera_is_world(), |_, _| [255; 4])
}

fn shot(width: u32, height: u32) -> Shot {
    Shot::new(centred(width, height, 50.0), camera_is_world())
}

#[test]
fn an_image_without_depth_pixels_gives_an_empty_picture() {
    let camera = centred(40, 30, 40.0);
    let empty =
        with_level(ResolutionLevel::of_rows(camera, vec![Vec::new(); 30]), camera_is_world(), Vec::new());
    // The second device only validates.
    for mut gpu in [on_adapter(), GpuWarp::new(&Gpu::noop()).ok()].into_iter().flatten() {
        let empty = uploaded(&gpu, empty.clone());
        for splat in SPLATS {
            let found = picture(&mut gpu, &empty, &shot(20, 10), &of_splat(splat)).picture;
            assert_eq!((found.width, found.height), (20, 10));
            assert!(found.rgba.len() == 800 && found.rgba.iter().all(|byte| *byte == 0), "{splat:?}");
        }
    }
}

#[test]
fn a_view_that_sees_nothing_is_empty_also_after_one_that_sees_something() {
    let Some(mut gpu) = on_adapter() else { return };
    let wall = uploaded(&gpu, wall());
    let back = glam::DMat3::from_rotation_y(std::f64::consts::PI);
    for splat in SPLATS {
        let mut is_empty = |pose: Pose| {
            let shot = Shot::new(centred(64, 48, 50.0), pose);
            let found = picture(&mut gpu, &wall, &shot, &of_splat(splat)).picture;
            found.pixels().iter().all(|pixel| *pixel == [0; 4])
        };
        let away = Pose { rotation: back, ..camera_is_world() };
        let beside = Pose { translation: DVec3::new(900.0, 0.0, 0.0), ..camera_is_world() };
        let seen = [camera_is_world(), away, camera_is_world(), beside].map(&mut is_empty);
        assert_eq!(seen, [false, true, false, true], "{splat:?}");
    }
}

#[test]
fn a_side_that_the_reference_camera_does_not_see_is_drawn_only_on_request() {
    let Some(mut gpu) = on_adapter() else { return };
    let wall = uploaded(&gpu, wall());
    let rotation = glam::DMat3::from_rotation_y(std::f64::consts::PI);
    let beyond = Pose { rotation, translation: rotation * -DVec3::new(0.0, 0.0, 8.0) };
    for (splat, backs) in SPLATS.into_iter().flat_map(|splat| [true, false].map(|backs| (splat, backs))) {
        let shot = Shot { backs, ..Shot::new(centred(64, 48, 50.0), beyond) };
        let found = picture(&mut gpu, &wall, &shot, &of_splat(splat)).picture;
        assert_eq!(found.pixels().iter().any(|pixel| pixel[3] > 0), backs, "{splat:?}");
    }
}

#[test]
fn pictures_that_the_device_cannot_draw_are_refused_with_what_it_can() {
    let gpu = Gpu::noop();
    let longest = gpu.device.limits().max_texture_dimension_2d;
    let mut gpu = GpuWarp::new(&gpu).unwrap();
    let wall = uploaded(&gpu, wall());
    for (width, height) in [(longest + 1, 10), (10, u32::MAX), (0, 10)] {
        let refused = gpu.picture(&wall, &shot(width, height), &of_splat(SplatKind::Sums), &Task::silent());
        let error = refused.unwrap_err().to_string();
        assert!(
            error.contains(&format!("{width} x {height}")) && error.contains(&longest.to_string()),
            "{error}"
        );
    }
}

#[test]
fn the_published_splats_and_spacing_are_refused() {
    let mut gpu = GpuWarp::new(&Gpu::noop()).unwrap();
    let wall = uploaded(&gpu, wall());
    let published =
        [of_splat(SplatKind::Over), WarpOptions { spacing: Spacing::Table, ..WarpOptions::default() }];
    for options in published {
        let refused = gpu.picture(&wall, &shot(20, 10), &options, &Task::silent());
        assert!(matches!(refused, Err(Error::Request(_))), "{refused:?}");
    }
}

#[test]
fn a_stopped_task_ends_the_drawing() {
    let mut gpu = GpuWarp::new(&Gpu::noop()).unwrap();
    let wall = uploaded(&gpu, wall());
    let task = Task::silent().with_stop_flag(Arc::new(true.into()));
    let stopped = gpu.picture(&wall, &shot(20, 10), &WarpOptions::default(), &task);
    assert!(matches!(stopped, Err(Error::Cancelled)), "{stopped:?}");
}

#[test]
fn a_lost_device_is_an_error_of_the_gpu_and_no_crash() {
    let Some(mut gpu) = on_adapter() else { return };
    let wall = uploaded(&gpu, wall());
    picture(&mut gpu, &wall, &shot(20, 10), &WarpOptions::default());
    gpu.gpu.device.destroy();
    assert!(matches!(gpu.upload(wall.ldi().clone()), Err(Error::Gpu(_))));
    for _ in 0..2 {
        let lost = gpu.picture(&wall, &shot(20, 10), &WarpOptions::default(), &Task::silent());
        assert!(matches!(lost, Err(Error::Gpu(_))), "{lost:?}");
    }
}
