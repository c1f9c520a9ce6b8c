//! Viewpoints that matter for filling: saved views, keyframes of the flight, or the photos' own cameras.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::Site;
use quadratura_document::{Bookmark, CameraPath, Project};

/// The picture size of saved views where there is no flight.
const USUAL_SIZE: [u32; 2] = [1920, 1080];

/// The index of a view in the list of views that a ranking was made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct ViewpointIndex(pub usize);

/// A view from which the site may be seen.
#[derive(Debug, Clone, PartialEq)]
pub struct RankedViewpoint {
    /// The name.
    pub name: String,
    /// The camera: size and K in pixels.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
}

/// The choice of views that count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Viewpoints {
    /// Bookmarks and the flight's keyframes.
    Kept,
    /// The photos' own cameras, near which viewers of a site usually are.
    Photos,
}

impl Viewpoints {
    /// Returns the default: bookmarks and keyframes if there are any, otherwise the photos.
    pub fn usual(project: &Project) -> Self {
        if bookmark_count(project) > 0 { Self::Kept } else { Self::Photos }
    }

    /// Returns the views. `up` is the up direction of the world where the flight gives none.
    pub fn views(self, project: &Project, site: &Site, up: DVec3) -> Vec<RankedViewpoint> {
        match self {
            Self::Photos => views_of_photos(site),
            Self::Kept => views_kept(&project.views, project.flight.as_ref(), up),
        }
    }
}

/// Returns the number of views to which [`Viewpoints::Kept`] refers.
pub fn bookmark_count(project: &Project) -> usize {
    project.views.len() + project.flight.as_ref().map_or(0, |flight| flight.keyframes.len())
}

/// Returns the views of the photos' own cameras.
pub fn views_of_photos(site: &Site) -> Vec<RankedViewpoint> {
    let view = |photo: &quadratura_base::scene::Photo| RankedViewpoint {
        name: photo.name.clone(),
        camera: photo.camera,
        pose: photo.pose,
    };
    site.photos.iter().map(view).collect()
}

/// Returns the bookmarks and the views at a flight's keyframes; a flight that cannot be flown has none.
fn views_kept(kept: &[Bookmark], flight: Option<&CameraPath>, up: DVec3) -> Vec<RankedViewpoint> {
    let [width, height] = flight.map_or(USUAL_SIZE, |path| path.size);
    let of_bookmark = |kept: &Bookmark| {
        let view = kept.viewpoint();
        RankedViewpoint { name: kept.name.clone(), camera: view.camera(width, height), pose: view.pose }
    };
    let flown = flight.and_then(|path| Some((path, path.flight(up).ok()?)));
    let keyframes = flown.iter().flat_map(|(path, flight)| {
        (1..).zip(&path.keyframes).map(move |(number, frame)| {
            let (camera, pose) = flight.at(frame.t);
            RankedViewpoint { name: format!("keyframe {number}"), camera, pose }
        })
    });
    kept.iter().map(of_bookmark).chain(keyframes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{centred, closed_form, look_at};
    use quadratura_view::navigation::Viewpoint;

    #[test]
    fn kept_views_and_keyframes_come_before_the_photos_cameras() {
        let site = closed_form::two_quads().site();
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
        let mut project: Project = serde_json::from_str(text).unwrap();
        assert_eq!(Viewpoints::usual(&project), Viewpoints::Photos);
        let photos = Viewpoints::Photos.views(&project, &site, DVec3::Z);
        assert_eq!((photos.len(), &photos[0].name), (site.photos.len(), &site.photos[0].name));

        let view = |x: f64| {
            let pose = look_at(DVec3::new(x, -8.0, 2.0), DVec3::ZERO);
            Viewpoint::of_camera(&centred(640, 480, 500.0), &pose, DVec3::ZERO)
        };
        project.views.push(Bookmark::new("gate", &view(0.0)));
        let mut path = CameraPath::empty([320, 240]);
        [(0.0, 1.0), (2.0, 3.0)].into_iter().for_each(|(time_s, x)| path.set(time_s, &view(x)));
        project.flight = Some(path);
        assert_eq!((Viewpoints::usual(&project), bookmark_count(&project)), (Viewpoints::Kept, 3));
        let kept = Viewpoints::Kept.views(&project, &site, DVec3::Z);
        let names: Vec<&str> = kept.iter().map(|view| view.name.as_str()).collect();
        assert_eq!(names, ["gate", "keyframe 1", "keyframe 2"]);
        for (kept, x) in kept.iter().zip([0.0, 1.0, 3.0]) {
            let off = kept.pose.center_in_world().distance(view(x).position());
            assert!(off < 1e-9 && kept.camera.width == 320, "{x}: {off}");
        }
    }
}
