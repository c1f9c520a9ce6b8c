//! Stereo: two views with parallel axes, side by side, and the distance between the eyes that is comfortable.

use glam::DVec3;

use quadratura_base::geometry::Pose;
use quadratura_base::raster::robust::of_rank;
use quadratura_ldi::transfer::Transfer;
use quadratura_ldi::{Ldi, LdiSet};
use quadratura_view::{Picture, Shot};

/// The largest distance between the eyes that is comfortable, as a share of the depth of what is near.
pub const COMFORTABLE: f64 = 1.0 / 20.0;
/// The share of what a view shows that is near.
const NEAR: f64 = 0.1;
/// The longest side of the level whose depths are looked at, in pixels.
const COARSE: u32 = 256;

/// Returns the poses of the left and the right eye: half the distance, in world units, to either side of a camera, whose axes
/// they have.
pub fn eyes(pose: &Pose, distance: f64) -> [Pose; 2] {
    let to_the_side = |x: f64| Pose { translation: pose.translation - DVec3::new(x, 0.0, 0.0), ..*pose };
    [to_the_side(-distance / 2.0), to_the_side(distance / 2.0)]
}

/// Returns a picture and another one of the same size to its right.
pub fn side_by_side(left: &Picture, right: &Picture) -> Picture {
    let row = 4 * left.width as usize;
    let rows = left.rgba.chunks_exact(row).zip(right.rgba.chunks_exact(row));
    let rgba = rows.flat_map(|(left, right)| [left, right]).flatten().copied().collect();
    Picture { width: 2 * left.width, height: left.height, rgba }
}

/// Returns the depth within which the nearest tenth of what a view shows is, in world units; `None` where it shows nothing, or
/// where that is infinitely far. What other surfaces of the view hide counts, too.
pub fn near_depth(set: &LdiSet, shot: &Shot) -> Option<f64> {
    let mut in_view: Vec<f32> = set.images.iter().flat_map(|image| inverse_depths(image, shot)).collect();
    let at = (NEAR * in_view.len() as f64) as usize;
    let rank = in_view.len().checked_sub(1 + at)?;
    let near = of_rank(&mut in_view, rank)?;
    (near > 0.0).then(|| 1.0 / f64::from(near))
}

/// Returns the inverse depths, in the view's camera, of what an image's camera sees and the view has in its frame.
fn inverse_depths(image: &Ldi, shot: &Shot) -> Vec<f32> {
    let is_coarse =
        |level: &&quadratura_ldi::ResolutionLevel| level.camera.width.max(level.camera.height) <= COARSE;
    let Some(level) = image.levels.iter().find(is_coarse).or(image.levels.last()) else { return Vec::new() };
    let transfer = Transfer::new(&level.camera, &image.pose, &shot.camera, &shot.pose);
    let [width, height] = transfer.size.map(f64::from);
    let of_row = |y: u32| {
        level.layered_pixels(y).filter_map(move |pixel| {
            let (x, depth) = (level.columns[pixel.start], f64::from(level.inverse_depths[pixel.start]));
            let centre = glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let (at, omega) = transfer.position(centre, depth)?;
            let within = at.min_element() >= 0.0 && at.x < width && at.y < height;
            within.then_some((depth / omega) as f32)
        })
    };
    (0..level.camera.height).flat_map(of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::LdiDrawing;
    use quadratura_base::scene::synthetic::{camera_is_world, centred};
    use quadratura_base::task::Task;
    use quadratura_ldi::levels::pyramid;
    use quadratura_ldi::{DepthPixel, LdiKind, LdiReport, ResolutionLevel, Splat, SplatKind, WarpOptions};
    use quadratura_sites::views::RequestedView;
    use quadratura_view::Quality;

    /// Nine tenths of the frame are 20 units away, the left part 2.
    fn wall_with_a_post() -> Ldi {
        let camera = centred(100, 50, 60.0);
        let row = |_| {
            let pixel = |x: u16| DepthPixel {
                inverse_depth: if x < 12 { 0.5 } else { 0.05 },
                colour: [x as u8, 7, 9, 255],
                surface: 0,
                splat: Splat(0),
            };
            (0..100).map(|x| (x, pixel(x))).collect()
        };
        Ldi {
            kind: LdiKind::Depth,
            inputs: String::new(),
            camera,
            pose: camera_is_world(),
            photo_rect: None,
            gain: [0.0; 3],
            surfaces: Vec::new(),
            sources: Vec::new(),
            levels: pyramid(ResolutionLevel::of_rows(camera, (0..50).map(row)), &[]),
            report: LdiReport::default(),
        }
    }

    #[test]
    fn eyes_are_apart_along_the_cameras_rows_and_turn_nothing() {
        let rotation = glam::DMat3::from_rotation_z(std::f64::consts::FRAC_PI_2);
        let pose = Pose { rotation, translation: DVec3::new(1.0, 2.0, 3.0) };
        let [left, right] = eyes(&pose, 0.5);
        let apart = right.center_in_world() - left.center_in_world();
        assert!(apart.distance(rotation.transpose() * DVec3::new(0.5, 0.0, 0.0)) < 1e-12);
        let middle = left.center_in_world().midpoint(right.center_in_world());
        assert!(middle.distance(pose.center_in_world()) < 1e-12);
        let ldi = wall_with_a_post();
        let transfer = |eye: &Pose| Transfer::new(&ldi.camera, &ldi.pose, &ldi.camera, eye);
        let [of_left, of_right] = [&left, &right].map(transfer);
        assert_eq!(of_left.a, of_right.a);
        assert!((of_right.b - of_left.b - DVec3::new(-0.5 * 60.0, 0.0, 0.0)).length() < 1e-9);
    }

    #[test]
    fn what_is_near_is_the_nearest_tenth_of_what_the_view_shows() {
        let ldi = wall_with_a_post();
        let near = |camera| near_depth(&ldi.clone().into(), &Shot::new(camera, camera_is_world())).unwrap();
        assert!((near(ldi.camera) - 2.0).abs() < 1e-5);
        // A longer focal length leaves the post outside.
        assert!((near(centred(100, 50, 90.0)) - 20.0).abs() < 1e-4);
        let away = Pose { rotation: glam::DMat3::from_rotation_y(3.0), ..camera_is_world() };
        assert_eq!(near_depth(&ldi.clone().into(), &Shot::new(ldi.camera, away)), None);
    }

    #[test]
    fn the_right_eye_sees_what_a_camera_at_its_place_sees_and_so_does_the_left_one() {
        let sets = [LdiSet::from(wall_with_a_post())];
        let pose =
            Pose { rotation: glam::DMat3::from_rotation_y(0.1), translation: DVec3::new(0.1, 0.0, 0.4) };
        let camera = centred(80, 45, 70.0);
        let view = |pose| RequestedView { name: "view".into(), camera, pose, photo: None };
        for splat in [SplatKind::Sums, SplatKind::Over, SplatKind::Pixel] {
            let options = WarpOptions { splat, ..WarpOptions::default() };
            let picture = |stereo: Option<f64>, pose| {
                let mut drawing = LdiDrawing::new(&sets, options, Quality::Final, stereo, None);
                (drawing.picture(&view(pose), &Task::silent()).unwrap(), drawing.uncomfortable)
            };
            let (both, noted) = picture(Some(0.3), pose);
            assert_eq!((both.width, both.height), (160, 45));
            let [left, right] = eyes(&pose, 0.3).map(|eye| picture(None, eye).0);
            assert!(left != right && both == side_by_side(&left, &right));
            // What is near is 2 units away, some of it 0.4 nearer to this camera.
            assert_eq!(noted.len(), 1);
            assert!((noted[0].1 - 2.4).abs() < 0.3, "{noted:?}");
            assert!(picture(Some(0.05), pose).1.is_empty());
        }
    }

    #[test]
    fn pictures_are_put_side_by_side_row_by_row() {
        let picture = |start: u8| Picture { width: 2, height: 2, rgba: (start..start + 16).collect() };
        let both = side_by_side(&picture(0), &picture(100));
        assert_eq!((both.width, both.height), (4, 2));
        let expected: Vec<u8> = (0..8).chain(100..108).chain(8..16).chain(108..116).collect();
        assert_eq!(both.rgba, expected);
    }
}
