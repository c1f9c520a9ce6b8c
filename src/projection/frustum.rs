//! The sheared sub-frustum of an image layer (Reche & Drettakis 2003, section 5): a projection for any
//! rectangle of the photo.

use glam::{DMat3, DMat4, DVec3, DVec4};

use quadratura_base::geometry::{Pinhole, PixelRect, Pose};

/// Computes the rows ((fx r1 + (cx - x) r3) / w, (fy r2 + (cy - y) r3) / h, r3) of [R|t]: the projection of
/// the rectangle's sub-frustum and its bias in one, without a near plane (see [`texture_matrix`]).
///
/// The result has 3 rows x 4: `(u q, v q, q) = rows * (x, y, z, 1)` of a world point, with u and v in 0..1 of
/// the rectangle, v down, and q the depth in the photo's camera in world units. The photo does not show
/// points where q is not positive.
pub fn uv_from_world(camera: &Pinhole, pose: &Pose, rect: PixelRect) -> [[f64; 4]; 3] {
    let t = pose.translation;
    let [x, y, z] = uv_from_direction(camera, pose, rect);
    let (w, h) = (f64::from(rect.w), f64::from(rect.h));
    let u = (camera.fx * t.x + (camera.cx - f64::from(rect.x)) * t.z) / w;
    let v = (camera.fy * t.y + (camera.cy - f64::from(rect.y)) * t.z) / h;
    [[x.x, x.y, x.z, u], [y.x, y.y, y.z, v], [z.x, z.y, z.z, t.z]]
}

/// Computes [`uv_from_world`] for points relative to `origin` (a world point near the cameras). The sums are
/// made here in f64, so that coordinates of millions of metres lose nothing when the result becomes f32.
pub fn uv_from_rebased(camera: &Pinhole, pose: &Pose, rect: PixelRect, origin: DVec3) -> [[f64; 4]; 3] {
    // R p + t = R (p - C): the difference is small wherever the site lies in the world.
    let from_center = origin - pose.center_in_world();
    uv_from_direction(camera, pose, rect).map(|row| [row.x, row.y, row.z, row.dot(from_center)])
}

/// Computes the first three columns of [`uv_from_world`]; the vectors are its rows.
fn uv_from_direction(camera: &Pinhole, pose: &Pose, rect: PixelRect) -> [DVec3; 3] {
    let rows = pose.rotation.transpose();
    let (x, y) = (f64::from(rect.x), f64::from(rect.y));
    [
        (rows.x_axis * camera.fx + rows.z_axis * (camera.cx - x)) / f64::from(rect.w),
        (rows.y_axis * camera.fy + rows.z_axis * (camera.cy - y)) / f64::from(rect.h),
        rows.z_axis,
    ]
}

/// Computes the texture matrix as in OpenGL: `bias * frustum(x'min, x'max, y'min, y'max) * view` (design of
/// the published system), rows for u q, v q and q. The near distance of the frustum, `near`, cancels out.
/// This is the definition that the short form is tested against.
pub fn texture_matrix(camera: &Pinhole, pose: &Pose, rect: PixelRect, near: f64) -> DMat4 {
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let (x_min, x_max) = (-camera.cx * near / camera.fx, (width - camera.cx) * near / camera.fx);
    let (y_min, y_max) = (-(height - camera.cy) * near / camera.fy, camera.cy * near / camera.fy);
    let column = |px: f64| x_min + px * (x_max - x_min) / width;
    let row = |px: f64| y_max - px * (y_max - y_min) / height;
    let (left, right) = (column(f64::from(rect.x)), column(f64::from(rect.right())));
    let (top, bottom) = (row(f64::from(rect.y)), row(f64::from(rect.bottom())));
    let frustum = DMat4::from_cols(
        DVec4::new(2.0 * near / (right - left), 0.0, 0.0, 0.0),
        DVec4::new(0.0, 2.0 * near / (top - bottom), 0.0, 0.0),
        DVec4::new((right + left) / (right - left), (top + bottom) / (top - bottom), 0.0, -1.0),
        DVec4::new(0.0, 0.0, 0.0, 0.0),
    );
    let flip = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
    let view = DMat4::from_cols(
        (flip * pose.rotation.x_axis).extend(0.0),
        (flip * pose.rotation.y_axis).extend(0.0),
        (flip * pose.rotation.z_axis).extend(0.0),
        (flip * pose.translation).extend(1.0),
    );
    // Maps x to (x + 1) / 2 and y to (1 - y) / 2; w is unchanged.
    let bias = DMat4::from_cols(
        DVec4::new(0.5, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -0.5, 0.0, 0.0),
        DVec4::new(0.0, 0.0, 1.0, 0.0),
        DVec4::new(0.5, 0.5, 0.0, 1.0),
    );
    bias * frustum * view
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    /// Returns a camera with any principal point and direction, at the distance `away` from the origin.
    fn random_camera(rng: &mut Rng, away: f64) -> (Pinhole, Pose) {
        let camera = Pinhole {
            width: 3072,
            height: 2048,
            fx: rng.between(500.0, 5000.0),
            fy: rng.between(500.0, 5000.0),
            cx: rng.between(-500.0, 3500.0),
            cy: rng.between(-500.0, 2500.0),
        };
        let turn = glam::DQuat::from_euler(
            glam::EulerRot::XYZ,
            rng.between(-3.0, 3.0),
            rng.between(-3.0, 3.0),
            rng.between(-3.0, 3.0),
        );
        let rotation = DMat3::from_quat(turn);
        let center = DVec3::new(away, -0.7 * away, 3.0);
        (camera, Pose { rotation, translation: -(rotation * center) })
    }

    fn random_rect(rng: &mut Rng) -> PixelRect {
        let side = |rng: &mut Rng| 1u32 << (rng.between(0.0, 12.9) as u32);
        PixelRect {
            x: rng.between(-5000.0, 5000.0) as i32,
            y: rng.between(-5000.0, 5000.0) as i32,
            w: side(rng),
            h: side(rng),
        }
    }

    fn divided(rows: &[[f64; 4]; 3], p: DVec3) -> (f64, f64) {
        let dot = |row: &[f64; 4]| row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
        (dot(&rows[0]) / dot(&rows[2]), dot(&rows[1]) / dot(&rows[2]))
    }

    /// Returns a point in front of the camera, at most the photo's own size outside of it.
    fn point_before(rng: &mut Rng, camera: &Pinhole) -> DVec3 {
        let px = glam::DVec2::new(rng.between(-3072.0, 6144.0), rng.between(-2048.0, 4096.0));
        camera.ray_in_camera(px) * rng.between(0.5, 200.0)
    }

    #[test]
    fn a_sheared_sub_frustum_gives_the_photos_own_pixels_wherever_its_rectangle_lies() {
        let mut rng = Rng::new(3);
        for case in 0..2000 {
            let away = if case % 2 == 0 { 0.0 } else { 5e6 };
            let (camera, pose) = random_camera(&mut rng, away);
            let rect = random_rect(&mut rng);
            let origin = pose.center_in_world().round();
            let in_camera = point_before(&mut rng, &camera);
            let rebased = pose.rotation.transpose() * in_camera + (pose.center_in_world() - origin);
            let (u, v) = divided(&uv_from_rebased(&camera, &pose, rect, origin), rebased);
            let px = camera.image_from_camera(in_camera).expect("it is in front");
            let found_x = u * f64::from(rect.w) + f64::from(rect.x);
            let found_y = v * f64::from(rect.h) + f64::from(rect.y);
            let error = (found_x - px.x).abs().max((found_y - px.y).abs());
            assert!(error < 1e-6, "case {case}: {error} px, {rect:?}");
        }
    }

    #[test]
    fn the_short_form_is_the_published_texture_matrix() {
        let mut rng = Rng::new(4);
        for _ in 0..500 {
            let (camera, pose) = random_camera(&mut rng, 20.0);
            let rect = random_rect(&mut rng);
            let p = pose.world_from_camera(point_before(&mut rng, &camera));
            let q = texture_matrix(&camera, &pose, rect, rng.between(0.01, 10.0)) * p.extend(1.0);
            let (u, v) = divided(&uv_from_world(&camera, &pose, rect), p);
            let error = (q.x / q.w - u).abs() * f64::from(rect.w);
            let error = error.max((q.y / q.w - v).abs() * f64::from(rect.h));
            assert!(error < 1e-6, "{error} px");
        }
    }
}
