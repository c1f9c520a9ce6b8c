//! The surroundings in novel views: what is seen where a ray meets no face. They are infinitely far away, so a photo
//! shows a direction at the same pixel from everywhere, and photos differ only by how far their cameras are from the
//! viewpoint. The CPU reference of `shaders/surroundings.wgsl`.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cells::ServerCandidate;
use super::dome::PENALTY;
use super::sources::Sources;
use quadratura_base::geometry::{Pinhole, PixelRect};
use quadratura_base::scene::PhotoId;
use quadratura_view::shot::{MOST_TAPS, Shot};
use quadratura_view::weights::{Claim, LEAST_ANGLE, octaves_missing};

/// The number of photos near a viewpoint whose surroundings a view may show; farther ones are no use with so many nearer.
const MOST_NEAR: usize = 32;

/// The photo at twice whose distance others still serve: where many stand at one place, all of them do.
const CLUSTER: usize = 8;

/// The share of the reach over which photos fade.
const FADING: f64 = 0.2;

/// The distance of photos' cameras from a viewpoint from which on their surroundings are not shown, in world units; infinite on sites
/// where all are. Photos fade before it, so that nothing pops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach(pub f64);

impl Reach {
    /// Returns the reach of a view.
    pub fn new(sources: &Sources, shot: &Shot) -> Self {
        if sources.surroundings.len() <= MOST_NEAR {
            return Self(f64::INFINITY);
        }
        let shown = sources.servers_of_surroundings().iter().map(|server| server.photo);
        let photos: BTreeSet<PhotoId> =
            shown.filter(|photo| !sources.is_dome(*photo) && !shot.without.contains(photo)).collect();
        let eye = shot.viewpoint();
        let mut distances: Vec<f64> =
            photos.iter().map(|photo| sources.photo(*photo).pose.center_in_world().distance(eye)).collect();
        distances.sort_by(f64::total_cmp);
        let farthest = distances.get(MOST_NEAR).map(|next| next.max(2.0 * distances[CLUSTER - 1]));
        Self(farthest.filter(|reach| *reach > 0.0).unwrap_or(f64::INFINITY))
    }

    /// Returns the factor of the trust in a photo at this distance, 1 near the viewpoint to 0 at the reach.
    pub fn nearness(self, distance: f64) -> f64 {
        if self.0.is_infinite() { 1.0 } else { ((1.0 - distance / self.0) / FADING).clamp(0.0, 1.0) }
    }
}

/// The cells of the surroundings: those of the whole view, in row order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurroundingsCells {
    /// The reach of the view.
    pub reach: Reach,
    /// The index of the first cell in [`super::cells::Cells::ranges`].
    pub first: u32,
    /// The number of columns.
    pub columns: u32,
}

/// Returns the claim of a photo on a direction of a view, with these border, confidence and agreement: the distance
/// of its camera from the viewpoint, as a share of the site's scale, takes the place of the angle, and grows without bound towards
/// the `reach` of the view. `in_view` and
/// `in_photo` are the direction in the two cameras' frames. The dome lacks no resolution: it is asked where photos
/// are not.
pub fn claim(
    sources: &Sources,
    shot: &Shot,
    id: PhotoId,
    reach: Reach,
    [in_view, in_photo]: [DVec3; 2],
    [border, confidence, agreement]: [f64; 3],
) -> Claim {
    let photo = sources.photo(id);
    let octaves =
        octaves_missing(pixels_per_angle(&shot.camera, in_view), pixels_per_angle(&photo.camera, in_photo));
    let octaves = if sources.is_dome(id) { 0.0 } else { octaves };
    Claim { angle: distance(sources, shot, id, reach), octaves, border, confidence, agreement }
}

/// Returns the distance of a photo's camera from the viewpoint, as a share of the site's scale, over its nearness; that of the dome
/// is the same everywhere.
fn distance(sources: &Sources, shot: &Shot, id: PhotoId, reach: Reach) -> f64 {
    if sources.is_dome(id) {
        return PENALTY;
    }
    let distance = sources.photo(id).pose.center_in_world().distance(shot.viewpoint());
    let distance_in_scales =
        if distance == 0.0 { 0.0 } else { distance / sources.surroundings_scale.max(f64::MIN_POSITIVE) };
    distance_in_scales / reach.nearness(distance)
}

/// Returns the pixels per radian of a camera in a direction of its frame, the geometric mean over both ways to turn.
pub fn pixels_per_angle(camera: &Pinhole, direction: DVec3) -> f64 {
    (camera.fx * camera.fy).sqrt() * (direction.length() / direction.z).powf(1.5)
}

/// Returns the number of columns of the view's cells, its reach, and for each cell, in row order, the servers of the surroundings
/// that may contribute, by rising lower bound of the penalty. `leaning` is as for [`super::cells::cells`].
pub(super) fn lists(
    sources: &Sources,
    shot: &Shot,
    side_px: u32,
    leaning: &[f64],
) -> (u32, Reach, Vec<Vec<ServerCandidate>>) {
    let reach = Reach::new(sources, shot);
    if !shot.surroundings || sources.surroundings.is_empty() {
        return (0, reach, Vec::new());
    }
    let camera = &shot.camera;
    let (columns, rows) = (camera.width.div_ceil(side_px), camera.height.div_ceil(side_px));
    let of_cell = |cell: u32| {
        let low = DVec2::new(f64::from(cell % columns), f64::from(cell / columns)) * f64::from(side_px);
        let high = low + f64::from(side_px);
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let rays = corners.map(|px| camera.ray_in_camera(px));
        let mut list: Vec<ServerCandidate> = sources
            .surroundings
            .clone()
            .filter_map(|server| {
                let found = candidate(sources, shot, reach, &rays, server)?;
                let photo = sources.servers[server as usize].photo;
                let factor = leaning.get(photo.index()).copied().unwrap_or(1.0);
                Some(ServerCandidate { least: factor * found.least, ..found })
            })
            .collect();
        list.sort_by(|a, b| a.least.total_cmp(&b.least).then(a.server.cmp(&b.server)));
        list
    };
    (columns, reach, (0..columns * rows).into_par_iter().map(of_cell).collect())
}

/// Returns a server as a candidate for a cell with these rays at its corners, in the view's camera frame; `None` where
/// its photo shows no direction of the cell, or is out of reach.
fn candidate(
    sources: &Sources,
    shot: &Shot,
    reach: Reach,
    rays: &[DVec3; 4],
    id: u32,
) -> Option<ServerCandidate> {
    let server = &sources.servers[id as usize];
    if shot.without.contains(&server.photo) || !sources.shows_around(server.photo) {
        return None;
    }
    let distance = distance(sources, shot, server.photo, reach);
    if distance.is_infinite() {
        return None;
    }
    let photo = sources.photo(server.photo);
    let turn = photo.pose.rotation * shot.pose.rotation.transpose();
    let in_photo = rays.map(|ray| turn * ray);
    let rect = sources.layer_texture(server.layer_texture).rect;
    let whole = (
        DVec2::new(f64::from(rect.x), f64::from(rect.y)) - 1.0,
        DVec2::new(f64::from(rect.right()), f64::from(rect.bottom())) + 1.0,
    );
    // A cell is the convex hull of its corners' rays, in both cameras.
    let in_front = in_photo.iter().filter(|ray| ray.z > 0.0).count();
    let (low, high) = match in_front {
        0 => return None,
        4 => {
            let px = in_photo.map(|ray| project(&photo.camera, ray));
            let (low, high) = px.iter().fold((px[0], px[0]), |(low, high), px| (low.min(*px), high.max(*px)));
            (low.max(whole.0), high.min(whole.1))
        }
        _ => whole,
    };
    if low.cmpgt(high).any() {
        return None;
    }
    let pixels =
        PixelRect::from_edges(low.x as i32 - 2, low.y as i32 - 2, high.x as i32 + 3, high.y as i32 + 3);
    // Both cameras resolve least where a ray is nearest to the axis, and most at corners.
    let of_view = rays.map(|ray| pixels_per_angle(&shot.camera, ray)).into_iter().fold(0.0, f64::max);
    let axis = DVec2::new(photo.camera.cx, photo.camera.cy);
    let nearest = photo.camera.ray_in_camera(axis.clamp(low, high));
    let finer = if shot.quality.is_anisotropic() { MOST_TAPS.log2() } else { 0.0 };
    let spare = (pixels_per_angle(&photo.camera, nearest) / of_view).log2();
    Some(ServerCandidate {
        server: id,
        least: distance + LEAST_ANGLE,
        rect: pixels.intersection(&rect),
        finest: (spare - finer).max(0.0) as u32,
    })
}

/// Projects a direction in front of a camera.
fn project(camera: &Pinhole, ray: DVec3) -> DVec2 {
    DVec2::new(camera.fx * ray.x / ray.z + camera.cx, camera.fy * ray.y / ray.z + camera.cy)
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::{Domain, LayerTexture, LayerTextureId, Projector, Server};
    use quadratura_base::geometry::Pose;
    use quadratura_base::scene::PhotoId;
    use quadratura_view::Quality;

    const CAMERA: Pinhole = Pinhole { width: 200, height: 100, fx: 100.0, fy: 120.0, cx: 90.0, cy: 60.0 };

    /// Photos that look in turned directions, all from one place, each with its whole frame as a texture.
    fn sources(turns: &[f64]) -> Sources {
        let mut sources = Sources { surroundings_scale: 1.0, ..Sources::default() };
        for (at, turn) in (0u32..).zip(turns) {
            let pose = Pose { rotation: DMat3::from_rotation_y(*turn), translation: DVec3::ZERO };
            sources.photos.push(Projector { name: at.to_string(), camera: CAMERA, pose });
            let rect = PixelRect::of_size(256, 128);
            sources.layer_textures.push(LayerTexture {
                photo: PhotoId(at),
                id: at.to_string(),
                rect,
                see_through: false,
            });
            let (layer_texture, photo) = (LayerTextureId(at), PhotoId(at));
            let domain = Domain::Whole;
            sources.servers.push(Server { layer_texture, photo, back: false, pinned: false, domain });
        }
        sources.surroundings = 0..turns.len() as u32;
        sources
    }

    #[test]
    fn every_pixel_that_a_photo_shows_is_within_the_rectangle_of_its_cells_candidate() {
        let sources = sources(&[0.0, 0.3, -0.9, 1.6, 3.1]);
        let pose = Pose { rotation: DMat3::from_rotation_x(0.2), translation: DVec3::new(3.0, 0.0, 0.0) };
        for quality in [Quality::Preview, Quality::Final] {
            let shot = Shot { quality, ..Shot::new(CAMERA, pose) };
            let (columns, reach, cells) = lists(&sources, &shot, 16, &[]);
            let mut shown = [0; 5];
            for (x, y) in CAMERA.rect().pixels() {
                let list = &cells[(y as u32 / 16 * columns + x as u32 / 16) as usize];
                let ray = CAMERA.ray_in_camera(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
                for (id, photo) in (0u32..).zip(&sources.photos) {
                    let in_photo = photo.pose.rotation * (shot.pose.rotation.transpose() * ray);
                    let Some(px) = CAMERA.image_from_camera(in_photo) else { continue };
                    if !CAMERA.rect().contains_position(px) {
                        continue;
                    }
                    shown[id as usize] += 1;
                    let found = list.iter().find(|candidate| candidate.server == id).expect("it is listed");
                    assert!(found.rect.contains(px.x.floor() as i32, px.y.floor() as i32), "{px} {found:?}");
                    let claim = claim(&sources, &shot, PhotoId(id), reach, [ray, in_photo], [1.0; 3]);
                    assert!(found.least <= claim.penalty(&shot.blend));
                }
            }
            assert!(shown[0] > 9000 && shown[4] == 0, "{shown:?}");
        }
    }

    #[test]
    fn without_surroundings_or_without_the_wish_nothing_is_listed() {
        let some = sources(&[0.0]);
        let shot = Shot::new(CAMERA, some.photos[0].pose);
        assert!(!lists(&some, &shot, 16, &[]).2.is_empty());
        assert!(lists(&some, &Shot { surroundings: false, ..shot.clone() }, 16, &[]).2.is_empty());
        assert!(lists(&sources(&[]), &shot, 16, &[]).2.is_empty());
        let left_out = lists(&some, &Shot { without: vec![PhotoId(0)], ..shot }, 16, &[]).2;
        assert!(left_out.iter().all(Vec::is_empty));
    }

    #[test]
    fn of_hundreds_of_photos_the_near_ones_serve_and_each_fades_before_it_is_left_out() {
        let mut all = sources(&[0.0; 200]);
        for (photo, x) in all.photos.iter_mut().zip(0..) {
            photo.pose.translation.x = -f64::from(x);
        }
        let from = |x: f64| {
            let pose = Pose { translation: DVec3::new(-x, 0.0, 0.0), ..all.photos[0].pose };
            Shot::new(CAMERA, pose)
        };
        let listed = |x: f64| lists(&all, &from(x), 64, &[]).2[0].len();
        assert!((MOST_NEAR / 2..=MOST_NEAR).contains(&listed(100.0)), "{}", listed(100.0));
        // Along the way, every photo loses its trust by and by.
        let trust = |x: f64, photo: u32| Reach::new(&all, &from(x)).nearness((x - f64::from(photo)).abs());
        let step = 0.05;
        for at in 1..1000 {
            let x = 80.0 + f64::from(at) * step;
            for photo in 60..180 {
                let change = (trust(x, photo) - trust(x - step, photo)).abs();
                // The reach is 16 or more, which fades over a fifth of it, while both change by a step.
                assert!(change < 2.5 * step / (FADING * 16.0), "{photo} from {x}: {change}");
            }
        }
    }

    #[test]
    fn all_photos_of_one_place_serve_and_so_do_all_of_a_small_site() {
        let some = sources(&[0.1; 100]);
        let shot = Shot::new(CAMERA, Pose { translation: DVec3::new(0.5, 0.0, 0.0), ..some.photos[0].pose });
        assert_eq!(lists(&some, &shot, 64, &[]).2[0].len(), 100);
        assert_eq!(Reach::new(&some, &Shot::new(CAMERA, some.photos[0].pose)), Reach(f64::INFINITY));
        assert_eq!(Reach::new(&sources(&[0.0; MOST_NEAR]), &shot), Reach(f64::INFINITY));
    }

    #[test]
    fn a_photos_own_camera_has_the_least_penalty_and_a_wider_angle_resolves_more_at_its_edge() {
        let sources = sources(&[0.0, 0.0]);
        let photo = &sources.photos[0];
        let shot = Shot::new(CAMERA, photo.pose);
        let ray = CAMERA.ray_in_camera(DVec2::new(0.5, 0.5));
        let own = claim(&sources, &shot, PhotoId(0), Reach::new(&sources, &shot), [ray, ray], [1.0; 3]);
        assert_eq!((own.angle, own.octaves, own.penalty(&shot.blend)), (0.0, 0.0, LEAST_ANGLE));
        // One radian of arc at 60 degrees from the axis covers 2^1.5 times as many pixels.
        let oblique = DVec3::new(3f64.sqrt(), 0.0, 1.0);
        let gained = pixels_per_angle(&CAMERA, oblique) / pixels_per_angle(&CAMERA, DVec3::Z);
        assert!((gained - 8f64.sqrt()).abs() < 1e-12);
    }
}
