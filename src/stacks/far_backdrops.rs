//! Backdrops that views show as surroundings. A sky that is modelled as a few large faces around a site has no useful depth: edges
//! between its faces are visible, it is filled behind everything, and what rises above roofs is stretched over it.

use std::collections::BTreeSet;

use glam::DVec3;

use quadratura_base::raster::robust::median;
use quadratura_base::scene::builder::says_backdrop;
use quadratura_base::scene::{Object, Site};
use quadratura_view::hidden::HiddenFaces;

/// The least distance of a backdrop from the middle of the cameras, as a multiple of the largest distance of one of them: the skies
/// around castle and entry have 3.7 and 6.3. A row of houses across the street is nearer, and stays where it is.
const FAR: f64 = 2.5;

/// The least distance, as a multiple of the median distance of the vertices of everything else.
const BEYOND: f64 = 1.5;

/// The objects of a site that are backdrops and far away.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FarBackdrops {
    names: BTreeSet<String>,
}

impl FarBackdrops {
    /// Finds them: objects whose name contains `backdrop`, that one does not see through, and that are so far away that photos
    /// hardly see them shift.
    pub fn new(site: &Site) -> Self {
        let centres: Vec<DVec3> = site.photos.iter().map(|photo| photo.pose.center_in_world()).collect();
        let middle = centres.iter().sum::<DVec3>() / centres.len().max(1) as f64;
        let farthest = centres.iter().map(|centre| centre.distance(middle)).fold(0.0, f64::max);
        let mut near: Vec<f64> = site
            .model
            .objects
            .iter()
            .filter(|object| !says_backdrop(&object.name))
            .flat_map(|object| object.faces.iter().flat_map(|face| site.model.ring_points(*face)))
            .map(|point| point.distance(middle))
            .collect();
        // Cameras that all stand in one place see nothing shift.
        let least = (FAR * farthest).max(BEYOND * median(&mut near).unwrap_or(0.0));
        let is_far = |object: &&Object| {
            let model = &site.model;
            let triangles = object.faces.iter().flat_map(|face| model.face_triangles(*face));
            let corners = |triangle: &[u32; 3]| triangle.map(|vertex| model.vertices[vertex as usize]);
            let distances = triangles.map(|triangle| distance_to_triangle(middle, corners(triangle)));
            let nearest = distances.fold(f64::INFINITY, f64::min);
            // One sees through the others to what is behind them.
            let is_solid = says_backdrop(&object.name) && !object.shows_what_is_behind();
            is_solid && nearest.is_finite() && least > 0.0 && nearest >= least
        };
        Self { names: site.model.objects.iter().filter(is_far).map(|object| object.name.clone()).collect() }
    }

    /// Returns whether an object is one.
    pub fn contains(&self, object: &str) -> bool {
        self.names.contains(object)
    }

    /// Returns whether there are none.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Returns their faces.
    pub fn faces(&self, site: &Site) -> HiddenFaces {
        let objects = site.model.objects.iter().filter(|object| self.contains(&object.name));
        objects.flat_map(|object| object.faces.iter().copied()).collect()
    }
}

/// Returns the distance of a point from a triangle (Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5).
fn distance_to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let onto = |from: DVec3, to: DVec3| {
        let along = to - from;
        let share = ((p - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        p.distance(from + along * if share.is_finite() { share } else { 0.0 })
    };
    let edges = [(a, b), (b, c), (c, a)];
    let is_over = edges.iter().all(|(from, to)| (*to - *from).cross(p - *from).dot(normal) >= 0.0);
    match normal.try_normalize() {
        Some(normal) if is_over => (p - a).dot(normal).abs(),
        _ => edges.into_iter().map(|(from, to)| onto(from, to)).fold(f64::INFINITY, f64::min),
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;
    use quadratura_base::scene::Photo;
    use quadratura_base::scene::synthetic::{Modeller, centred, look_at};

    /// A house, a row of houses behind it, a sky and a see-through wood far away, with cameras at these places.
    fn site(eyes: &[DVec3]) -> Site {
        let mut m = Modeller::new();
        m.object("house").cuboid(dvec3(0.0, 1.0, 1.5), dvec3(3.0, 1.0, 1.5), glam::DMat3::IDENTITY);
        for (name, distance) in [("houses.backdrop", 3.0), ("sky.Backdrop", 300.0), ("wood.backdrop", 200.0)]
        {
            let corner = dvec3(-400.0, distance, -50.0);
            m.object(name).quad_facing(DVec3::NEG_Y, corner, DVec3::X * 800.0, DVec3::Z * 300.0);
        }
        let mut model = m.finish();
        std::sync::Arc::make_mut(&mut model).objects[3].see_through = true;
        let photo = |(at, eye): (usize, &DVec3)| Photo {
            name: format!("{at}.jpg"),
            camera: centred(2000, 1500, 1600.0),
            pose: look_at(*eye, dvec3(0.0, 0.0, 1.7)),
            file: "missing.jpg".into(),
            exposure: None,
            masks: Vec::new(),
        };
        Site { photos: eyes.iter().enumerate().map(photo).collect(), model }
    }

    #[test]
    fn a_sky_is_far_and_a_row_of_houses_and_what_one_sees_through_are_not_from_any_number_of_cameras() {
        let eye = dvec3(0.0, -12.0, 1.7);
        for eyes in [&[eye - DVec3::X * 10.0, eye, eye + DVec3::X * 10.0][..], &[eye]] {
            let site = site(eyes);
            let far = FarBackdrops::new(&site);
            let names: Vec<&str> = far.names.iter().map(String::as_str).collect();
            assert_eq!(names, ["sky.Backdrop"]);
            assert_eq!(far.faces(&site).iter().collect::<Vec<_>>(), site.model.objects[2].faces);
        }
        assert!(FarBackdrops::new(&site(&[])).faces(&site(&[])).iter().count() <= 1, "without photos");
    }

    #[test]
    fn the_distance_from_a_triangle_is_that_of_its_nearest_point() {
        let triangle = [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0];
        let distance = |x: f64, y: f64, z: f64| distance_to_triangle(DVec3::new(x, y, z), triangle);
        assert_eq!(distance(0.5, 0.5, -3.0), 3.0);
        assert_eq!(distance(-1.0, 1.0, 0.0), 1.0);
        assert!((distance(2.0, 2.0, 0.0) - 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(distance(3.0, 0.0, 0.0), 1.0);
    }
}
