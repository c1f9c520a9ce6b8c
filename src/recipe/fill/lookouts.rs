//! Where a viewer looks from: the views that somebody kept, the keyframes of the flight, or the photos' own cameras.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::document::{Bookmark, CameraPath, Project};
use crate::geometry::{Pinhole, Pose};
use crate::scene::Site;

/// The shape of pictures of kept views where no flight says another one: that of films.
const USUAL_SIZE: [u32; 2] = [1920, 1080];

/// Somewhere a viewer may look from: size and K in pixels, world to camera.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// What it is called.
    pub name: String,
    /// Size and K.
    pub camera: Pinhole,
    /// World to camera.
    pub pose: Pose,
}

/// Which views count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Lookouts {
    /// Those that were kept, and the flight's keyframes.
    Kept,
    /// The photos' own cameras: where a viewer of a site mostly is.
    Photos,
}

impl Lookouts {
    /// Those that somebody has chosen by keeping them; the photos' where there are none.
    pub fn usual(project: &Project) -> Self {
        if count_kept(project) > 0 { Self::Kept } else { Self::Photos }
    }

    /// The views. `up` is a direction of the world that is upwards where the flight says none.
    pub fn views(self, project: &Project, site: &Site, up: DVec3) -> Vec<View> {
        match self {
            Self::Photos => views_of_photos(site),
            Self::Kept => views_kept(&project.views, project.flight.as_ref(), up),
        }
    }
}

/// How many views a project has that [`Lookouts::Kept`] may mean.
pub fn count_kept(project: &Project) -> usize {
    project.views.len() + project.flight.as_ref().map_or(0, |flight| flight.keyframes.len())
}

/// The views of the photos' own cameras.
pub fn views_of_photos(site: &Site) -> Vec<View> {
    let view = |photo: &crate::scene::Photo| View {
        name: photo.name.clone(),
        camera: photo.camera,
        pose: photo.pose,
    };
    site.photos.iter().map(view).collect()
}

/// The views that were kept, and those of a flight's keyframes; a flight that cannot be flown has none.
fn views_kept(kept: &[Bookmark], flight: Option<&CameraPath>, up: DVec3) -> Vec<View> {
    let [width, height] = flight.map_or(USUAL_SIZE, |path| path.size);
    let of_bookmark = |kept: &Bookmark| {
        let view = kept.viewpoint();
        View { name: kept.name.clone(), camera: view.camera(width, height), pose: view.pose }
    };
    let flown = flight.and_then(|path| Some((path, path.flight(up).ok()?)));
    let keyframes = flown.iter().flat_map(|(path, flight)| {
        (1..).zip(&path.keyframes).map(move |(number, frame)| {
            let (camera, pose) = flight.at(frame.t);
            View { name: format!("keyframe {number}"), camera, pose }
        })
    });
    kept.iter().map(of_bookmark).chain(keyframes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::navigation::Viewpoint;
    use crate::scene::synthetic::{centred, closed_form, look_at};

    #[test]
    fn kept_views_and_keyframes_come_before_the_photos_cameras() {
        let site = closed_form::two_quads().site();
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
        let mut project: Project = serde_json::from_str(text).unwrap();
        assert_eq!(Lookouts::usual(&project), Lookouts::Photos);
        let photos = Lookouts::Photos.views(&project, &site, DVec3::Z);
        assert_eq!((photos.len(), &photos[0].name), (site.photos.len(), &site.photos[0].name));

        let view = |x: f64| {
            let pose = look_at(DVec3::new(x, -8.0, 2.0), DVec3::ZERO);
            Viewpoint::of_camera(&centred(640, 480, 500.0), &pose, DVec3::ZERO)
        };
        project.views.push(Bookmark::of("gate", &view(0.0)));
        let mut path = CameraPath::empty([320, 240]);
        [(0.0, 1.0), (2.0, 3.0)].into_iter().for_each(|(time_s, x)| path.set(time_s, &view(x)));
        project.flight = Some(path);
        assert_eq!((Lookouts::usual(&project), count_kept(&project)), (Lookouts::Kept, 3));
        let kept = Lookouts::Kept.views(&project, &site, DVec3::Z);
        let names: Vec<&str> = kept.iter().map(|view| view.name.as_str()).collect();
        assert_eq!(names, ["gate", "keyframe 1", "keyframe 2"]);
        for (kept, x) in kept.iter().zip([0.0, 1.0, 3.0]) {
            let off = kept.pose.center_in_world().distance(view(x).position());
            assert!(off < 1e-9 && kept.camera.width == 320, "{x}: {off}");
        }
    }
}
