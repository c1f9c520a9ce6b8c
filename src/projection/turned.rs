//! Photos as they see impostors: each looks at the rectangle that faces itself, and a view shows the one that faces the
//! viewer ([`quadratura_base::scene::impostor`]). CPU reference of `place_of` in `shaders/project.wgsl`.

use glam::DVec3;

use super::Projector;
use super::sources::Server;
use quadratura_base::geometry::Pose;
use quadratura_base::scene::impostor::{Facing, Impostor, Turn};
use quadratura_base::scene::{FaceId, Model};
use quadratura_view::{Blend, Shot};

/// The angle, in radians, that is added where an impostor shows the mirror image of a photo: a photo from behind is worth
/// as much as one from the side by this angle.
pub const MIRRORED: f64 = 0.5;

/// The largest number of photos that share a point of an impostor: more would mix more trunks and branches.
pub const MOST_ON_IMPOSTORS: u32 = 3;

/// Returns how photos are blended on a face in a view.
pub fn blend_on(model: &Model, face: FaceId, blend: &Blend) -> Blend {
    let photos =
        if model.impostor(face).is_some() { blend.photos.min(MOST_ON_IMPOSTORS) } else { blend.photos };
    Blend { photos, ..*blend }
}

/// A photo as it sees one face of a view.
#[derive(Debug, Clone, Copy)]
pub struct PhotoOnFace {
    /// The pose from which points of the face, as the view has them, are seen where the photo shows them.
    pub pose: Pose,
    /// The photo's own camera, and how points get from the view to it; `None` where the face does not turn.
    turned: Option<Turned>,
}

#[derive(Debug, Clone, Copy)]
struct Turned {
    turn: Turn,
    /// The camera's centre; where the photo's mirror image is shown, that of the camera on the other side.
    center: DVec3,
}

impl PhotoOnFace {
    /// Returns how a photo, not its mirror image, sees a face in a view.
    pub fn looking(model: &Model, face: FaceId, shot: &Shot, photo: &Projector) -> Self {
        match model.impostor(face) {
            Some(impostor) => Self::turned(impostor, &Facing::of_pose(&shot.pose), &photo.pose, false),
            None => Self { pose: photo.pose, turned: None },
        }
    }

    /// Returns how the photo of a server sees a face in a view.
    pub fn new(model: &Model, face: FaceId, shot: &Shot, photo: &Projector, server: &Server) -> Self {
        match model.impostor(face).filter(|_| server.back) {
            Some(impostor) => Self::turned(impostor, &Facing::of_pose(&shot.pose), &photo.pose, true),
            None => Self::looking(model, face, shot, photo),
        }
    }

    fn turned(impostor: &Impostor, view: &Facing, pose: &Pose, mirrored: bool) -> Self {
        let photo = Facing::of_pose(pose);
        let mut turn = impostor.turn(view, &photo);
        let mut center = photo.eye;
        if mirrored {
            turn = turn.and_half(impostor.axis);
            center = impostor.mirrored(&photo).eye;
        }
        Self { pose: turn.before(pose), turned: Some(Turned { turn, center }) }
    }

    /// Returns a point in the direction from which the photo sees a point of the face.
    pub fn seen_from(&self, point: DVec3) -> DVec3 {
        match &self.turned {
            Some(Turned { turn, center }) => point + *center - turn.apply(point),
            None => self.pose.center_in_world(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{Modeller, Rng, look_at};

    #[test]
    fn a_photo_shows_an_impostor_at_the_same_place_and_from_its_own_direction() {
        let mut m = Modeller::new();
        m.object("tree.billboard").quad(DVec3::new(-3.0, 0.0, 0.0), 6.0 * DVec3::X, 8.0 * DVec3::Z);
        let (model, _) = (*m.finish()).clone().with_impostors(DVec3::Z, |_| true);
        let tree = model.objects[0].impostor.unwrap();
        let mut rng = Rng::new(5);
        for _ in 0..100 {
            let mut at = || DVec3::new(rng.between(-40.0, 40.0), rng.between(-40.0, 40.0), 2.0);
            let (eye, camera) = (at(), at());
            let (view, pose) = (look_at(eye, DVec3::Z), look_at(camera, DVec3::Z));
            let (facing, photo) = (Facing::of_pose(&view), Facing::of_pose(&pose));
            for mirrored in [false, true] {
                let on_face = PhotoOnFace::turned(&tree, &facing, &pose, mirrored);
                let place = glam::DVec2::new(rng.between(-3.0, 3.0), rng.between(0.0, 8.0));
                let point = tree.point(&facing, place);
                let same = glam::DVec2::new(if mirrored { -place.x } else { place.x }, place.y);
                let in_photo = tree.point(&photo, same);
                let found = on_face.pose.camera_from_world(point);
                assert!(found.distance(pose.camera_from_world(in_photo)) < 1e-9);
                let other = if mirrored { tree.mirrored(&photo) } else { photo };
                let direction = other.eye - tree.point(&other, place);
                assert!((on_face.seen_from(point) - point).distance(direction) < 1e-9);
            }
        }
    }
}
