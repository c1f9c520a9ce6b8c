//! Whole suggestions for invented sites: a court of three walls with ground, photographed from inside.

use glam::{DMat3, DVec3};

use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose, Similarity};
use quadratura_base::raster::Image;
use quadratura_base::scene::Model;
use quadratura_base::scene::synthetic::{Modeller, Rng, centred, look_at};
use quadratura_base::task::Task;

use super::planes::PlaneKind;
use super::support::middle;
use super::{Input, Reason, SourcePhoto, SourcePoint, SuggestedObject, Suggestion, points_of_mesh, suggest};

/// A site whose every surface has a texture.
struct Invented {
    model: Model,
    cameras: Vec<(Pinhole, Pose)>,
}

impl Invented {
    /// A court of 20 x 14 with walls of 6 on three sides, seen from its open side.
    fn court() -> Self {
        let mut m = Modeller::new();
        m.object("ground").quad(DVec3::new(0.0, -2.0, 0.0), DVec3::X * 20.0, DVec3::Y * 16.0);
        m.object("north").quad_facing(
            DVec3::NEG_Y,
            DVec3::new(0.0, 14.0, 0.0),
            DVec3::X * 20.0,
            DVec3::Z * 6.0,
        );
        m.object("west").quad_facing(DVec3::X, DVec3::ZERO, DVec3::Y * 14.0, DVec3::Z * 6.0);
        m.object("east").quad_facing(DVec3::NEG_X, DVec3::X * 20.0, DVec3::Y * 14.0, DVec3::Z * 6.0);
        let eye = |i: i32| DVec3::new(4.0 + 2.0 * f64::from(i), 0.5 + 0.6 * f64::from(i % 3), 1.7);
        let target = |i: i32| DVec3::new(3.0 + 2.3 * f64::from((i * 3) % 7), 14.0, 2.6);
        let cameras = (0..7).map(|i| (centred(480, 320, 360.0), look_at(eye(i), target(i)))).collect();
        Self { model: std::sync::Arc::unwrap_or_clone(m.finish()), cameras }
    }

    /// Turns the cameras about their axes, one to the left, the next to the right.
    fn rolled(mut self, by_rad: f64) -> Self {
        for (i, (_, pose)) in self.cameras.iter_mut().enumerate() {
            let roll = DMat3::from_rotation_z(if i % 2 == 0 { by_rad } else { -by_rad });
            *pose = Pose { rotation: roll * pose.rotation, translation: roll * pose.translation };
        }
        self
    }

    /// The triangles, with the object of each.
    fn surface(&self) -> (Bvh, Vec<u32>) {
        let (mut triangles, mut objects) = (Vec::new(), Vec::new());
        for face in self.model.face_ids() {
            for corners in self.model.face_triangles(face) {
                triangles.push(corners.map(|v| self.model.vertices[v as usize]));
                objects.push(self.model.face(face).object.0);
            }
        }
        (Bvh::new(triangles), objects)
    }

    fn photos(&self) -> Vec<SourcePhoto> {
        let (tree, objects) = self.surface();
        let photo = |(camera, pose): &(Pinhole, Pose)| {
            let eye = pose.center_in_world();
            let shade = |(x, y): (i32, i32)| {
                let ray = camera.ray_in_camera(middle(x as usize, y as usize));
                let ray = pose.rotation.transpose() * ray;
                match tree.first_hit(eye, ray, f64::INFINITY) {
                    None => [225, 235, 250, 255],
                    Some((t, triangle)) => {
                        let grey = texture(eye + ray * t, objects[triangle as usize]);
                        [grey, grey, (f64::from(grey) * 0.9) as u8, 255]
                    }
                }
            };
            let rect = PixelRect::of_size(camera.width, camera.height);
            SourcePhoto { camera: *camera, pose: *pose, pixels: Image::from_fn(rect, shade) }
        };
        self.cameras.iter().map(photo).collect()
    }

    /// Points on all surfaces with those cameras that see them; each is off by about half a pixel of two cameras.
    fn points(&self, count: usize) -> Vec<SourcePoint> {
        let (tree, _) = self.surface();
        let mut rng = Rng::new(5);
        let mut points = Vec::new();
        while points.len() < count {
            let (camera, pose) = self.cameras[rng.whole(0, self.cameras.len() as u32 - 1) as usize];
            let px =
                middle(rng.whole(0, camera.width - 1) as usize, rng.whole(0, camera.height - 1) as usize);
            let (eye, ray) = (pose.center_in_world(), pose.rotation.transpose() * camera.ray_in_camera(px));
            let Some((t, _)) = tree.first_hit(eye, ray, f64::INFINITY) else { continue };
            let at = eye + ray * t;
            let sees = |(camera, pose): &(Pinhole, Pose)| {
                let eye = pose.center_in_world();
                let px = camera.image_from_camera(pose.camera_from_world(at));
                let shown = px.is_some_and(|px| camera.rect().contains_position(px));
                shown && tree.first_hit(eye, at - eye, 2.0).is_some_and(|(t, _)| t > 0.999)
            };
            let observers: Vec<u32> =
                (0..).zip(&self.cameras).filter(|(_, camera)| sees(camera)).map(|(i, _)| i).collect();
            if observers.len() > 1 {
                let mut noise = || rng.between(-1.0, 1.0) * 0.0008 * t;
                let position = at + DVec3::new(noise(), noise(), noise());
                points.push(SourcePoint { position, observers, error_rad: 0.5 / camera.fx });
            }
        }
        points
    }

    /// The same site in other coordinates.
    fn moved(mut self, to: &Similarity) -> Self {
        for (_, pose) in &mut self.cameras {
            let rotation = pose.rotation * to.rotation.transpose();
            let eye = to.apply(pose.center_in_world());
            *pose = Pose { rotation, translation: -(rotation * eye) };
        }
        self.model = self.model.transformed(to);
        self
    }
}

/// Noise of three sizes, in the object's own place.
fn texture(at: DVec3, object: u32) -> u8 {
    let cell = |size: f64| {
        let corner = (at / size).floor();
        let share = at / size - corner;
        let value = |offset: DVec3| {
            let [x, y, z] = (corner + offset).to_array().map(|v| v as i64 as u64);
            let seed = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
            Rng::new(seed ^ u64::from(object) << 40).unit()
        };
        let ease = share * share * (DVec3::splat(3.0) - 2.0 * share);
        let mut sum = 0.0;
        for corner in 0..8 {
            let pick =
                |bit: i32, ease: f64| if corner >> bit & 1 == 1 { (1.0, ease) } else { (0.0, 1.0 - ease) };
            let [(x, u), (y, v), (z, w)] = [pick(0, ease.x), pick(1, ease.y), pick(2, ease.z)];
            sum += u * v * w * value(DVec3::new(x, y, z));
        }
        sum
    };
    let tone = 60.0 + 22.0 * f64::from(object);
    (tone + 90.0 * (cell(1.3) - 0.5) + 60.0 * (cell(0.45) - 0.5) + 40.0 * (cell(0.17) - 0.5))
        .clamp(5.0, 200.0) as u8
}

fn answer(photos: &[SourcePhoto], points: &[SourcePoint]) -> Result<Suggestion, Reason> {
    suggest(&Input { photos, points, given: None }, &Task::silent()).unwrap()
}

fn suggested(site: &Invented) -> Suggestion {
    answer(&site.photos(), &site.points(2500)).unwrap()
}

fn area(object: &SuggestedObject) -> f64 {
    let doubled = |ring: &[DVec3]| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| (a - ring[0]).cross(b - ring[0])).sum::<DVec3>().length()
    };
    object.faces.iter().map(|face| doubled(&face.ring) / 2.0).sum()
}

/// Checks that a suggestion is the court, which is `scale` times as large.
fn assert_court(found: &Suggestion, site: &Invented, scale: f64, up: DVec3) {
    let tilt = found.up.angle_between(up).to_degrees();
    assert!(tilt < 0.2, "up is {tilt} degrees off");
    for (object, kind) in [
        ("ground", PlaneKind::Ground),
        ("north", PlaneKind::Plumb),
        ("west", PlaneKind::Plumb),
        ("east", PlaneKind::Plumb),
    ] {
        let id = site.model.object_named(object).unwrap();
        let truth = site.model.face(site.model.object(id).faces[0]).plane;
        // A point of each candidate is 10 away from its observers, and may be off by 0.2 %.
        let is_there = |it: &&SuggestedObject| {
            let corners = || it.faces.iter().flat_map(|face| &face.ring);
            it.kind == kind && corners().all(|corner| truth.signed_distance(*corner).abs() < 0.03 * scale)
        };
        let own: Vec<&SuggestedObject> = found.objects.iter().filter(is_there).collect();
        let names: Vec<&str> = found.objects.iter().map(|it| it.name.as_str()).collect();
        assert_eq!(own.len(), 1, "{object} among {names:?}");
        let normal = {
            let ring = &own[0].faces[0].ring;
            let next = ring.iter().cycle().skip(1);
            ring.iter().zip(next).map(|(a, b)| (a - ring[0]).cross(b - ring[0])).sum::<DVec3>().normalize()
        };
        assert!(normal.dot(truth.normal) > 0.999, "{object} is wound outwards");
    }
    let north = found.objects.iter().find(|it| {
        let id = site.model.object_named("north").unwrap();
        let truth = site.model.face(site.model.object(id).faces[0]).plane;
        it.faces[0].ring.iter().all(|corner| truth.signed_distance(*corner).abs() < 0.03 * scale)
    });
    let share = area(north.unwrap()) / (120.0 * scale * scale);
    // Two pixels of 8 cm all around are 3 % of the area, and sky is cheap to cover.
    assert!((0.93..1.25).contains(&share), "the north wall has {share} of its area");
}

#[test]
fn a_court_is_found_wherever_it_is_and_however_large() {
    let site = Invented::court();
    assert_court(&suggested(&site), &site, 1.0, DVec3::Z);
    let rotation = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(2.0);
    let to = Similarity { scale: 1000.0, rotation, translation: DVec3::new(4e5, -5e6, 100.0) };
    let moved = Invented::court().moved(&to);
    // The texture is made where the site was.
    let photos: Vec<SourcePhoto> = Invented::court()
        .photos()
        .into_iter()
        .zip(&moved.cameras)
        .map(|(photo, (_, pose))| SourcePhoto { pose: *pose, ..photo })
        .collect();
    let mut points = Invented::court().points(2500);
    points.iter_mut().for_each(|point| point.position = to.apply(point.position));
    assert_court(&answer(&photos, &points).unwrap(), &moved, 1000.0, rotation * DVec3::Z);
}

/// The site's surfaces as a scanner makes them: small triangles, rough by 2 cm, wound either way.
fn scanned(site: &Invented, side: f64) -> Bvh {
    let mut rng = Rng::new(3);
    let mut triangles = Vec::new();
    for face in site.model.face_ids() {
        let ring: Vec<DVec3> = site.model.ring_points(face).collect();
        let (along, across) = (ring[1] - ring[0], ring[3] - ring[0]);
        let [columns, rows] = [along, across].map(|edge| (edge.length() / side).ceil() as usize);
        let mut rough = || site.model.face(face).plane.normal * rng.between(-0.02, 0.02);
        let grid: Vec<DVec3> = (0..(columns + 1) * (rows + 1))
            .map(|at| {
                let (i, j) = (at % (columns + 1), at / (columns + 1));
                ring[0] + along * (i as f64 / columns as f64) + across * (j as f64 / rows as f64) + rough()
            })
            .collect();
        for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
            let first = j * (columns + 1) + i;
            let [a, b, c, d] =
                [first, first + 1, first + columns + 1, first + columns + 2].map(|at| grid[at]);
            triangles.extend([[a, b, c], [b, c, d]]);
        }
    }
    Bvh::new(triangles)
}

#[test]
fn a_dense_mesh_takes_the_place_of_sparse_points() {
    let site = Invented::court();
    let photos = site.photos();
    let points = points_of_mesh(&scanned(&site, 0.25), &photos, &Task::silent()).unwrap();
    assert!((10_000..31_000).contains(&points.len()), "{} points", points.len());
    let found = answer(&photos, &points).unwrap();
    assert_court(&found, &site, 1.0, DVec3::Z);
    let elsewhere = Bvh::new(vec![[DVec3::Z, DVec3::X, DVec3::Y].map(|corner| corner + 1e4)]);
    assert!(points_of_mesh(&elsewhere, &photos, &Task::silent()).unwrap().is_empty());
}

#[test]
fn a_face_in_front_of_a_camera_is_cut_where_rays_pass() {
    let mut site = Invented::court();
    // Behind an arch in a wall across the court, whose front is towards the others.
    let eye = DVec3::new(10.0, -3.0, 1.7);
    site.cameras.push((centred(480, 320, 360.0), look_at(eye, DVec3::new(10.0, 14.0, 2.0))));
    let found = suggested(&site);
    let points = site.points(2500);
    for object in &found.objects {
        for face in &object.faces {
            let plane = quadratura_base::geometry::polygon::fit_plane(&face.ring).unwrap();
            let triangles = quadratura_base::geometry::polygon::triangulate(&face.ring, &plane).triangles;
            let tree = Bvh::new(triangles.iter().map(|t| t.map(|i| face.ring[i as usize])).collect());
            let (mut blocked, mut met) = (0, 0);
            for (point, observer) in points.iter().flat_map(|p| p.observers.iter().map(move |o| (p, o))) {
                let eye = site.cameras[*observer as usize].1.center_in_world();
                if let Some((t, _)) = tree.first_hit(eye, point.position - eye, 1.02) {
                    met += 1;
                    blocked += usize::from(t < 0.97);
                }
            }
            // A ray may pass in the cell beside the outline, and one alone may be wrong.
            assert!(
                f64::from(blocked as u32) <= 0.01 * f64::from(met) + 2.0,
                "{}: {blocked} of {met}",
                object.name
            );
        }
    }
}

#[test]
fn too_little_is_refused_with_the_reason() {
    let site = Invented::court();
    let (photos, points) = (site.photos(), site.points(400));
    assert_eq!(answer(&photos[..1], &points).unwrap_err(), Reason::FewPhotos);
    assert_eq!(answer(&photos, &[]).unwrap_err(), Reason::NoPoints);
    assert_eq!(answer(&photos, &points[..5]).unwrap_err(), Reason::FewPoints);
    let turned: Vec<SourcePhoto> = photos
        .iter()
        .map(|photo| {
            let rotation = photo.pose.rotation;
            let pose = Pose { rotation, translation: -(rotation * photos[0].pose.center_in_world()) };
            SourcePhoto { pose, ..photo.clone() }
        })
        .collect();
    assert_eq!(answer(&turned, &points).unwrap_err(), Reason::OnePlace);
}

#[test]
fn without_tracks_and_with_wild_observations_fewer_faces_are_suggested() {
    let site = Invented::court();
    let photos = site.photos();
    let mut points = site.points(1500);
    points.iter_mut().for_each(|point| point.observers.clear());
    let found = answer(&photos, &points).unwrap();
    assert!(found.objects.iter().any(|object| object.kind == PlaneKind::Plumb));
    let (mut rng, mut noise) = (Rng::new(9), Rng::new(10));
    let mut points = site.points(1500);
    for point in points.iter_mut().filter(|_| rng.chance(0.2)) {
        // Ten pixels off at a distance of 14 is some 40 cm across the ray, and more along it.
        point.position += (point.position - DVec3::new(10.0, 1.0, 1.7)) * noise.between(-0.1, 0.1);
    }
    let found = answer(&photos, &points).unwrap();
    let faces: usize = found.objects.iter().map(|object| object.faces.len()).sum();
    assert!((3..20).contains(&faces), "{faces} faces");
}

#[test]
fn walls_tell_up_where_cameras_disagree() {
    for by in [3.0f64, 11.0] {
        let found = suggested(&Invented::court().rolled(by.to_radians()));
        let tilt = found.up.angle_between(DVec3::Z).to_degrees();
        assert!(tilt < 0.5, "up is {tilt} degrees off, of cameras rolled by {by}");
    }
}

#[test]
fn a_white_wall_without_points_takes_nothing_else_with_it() {
    let site = Invented::court();
    let north = site.model.object_named("north").unwrap();
    let plane = site.model.face(site.model.object(north).faces[0]).plane;
    let (tree, objects) = site.surface();
    let mut photos = site.photos();
    for photo in &mut photos {
        let (eye, turn) = (photo.pose.center_in_world(), photo.pose.rotation.transpose());
        let before = photo.pixels.clone();
        let rect = PixelRect::of_size(photo.camera.width, photo.camera.height);
        photo.pixels = Image::from_fn(rect, |(x, y)| {
            let ray = turn * photo.camera.ray_in_camera(middle(x as usize, y as usize));
            let hit = tree.first_hit(eye, ray, f64::INFINITY);
            let is_north = hit.is_some_and(|(_, triangle)| objects[triangle as usize] == north.0);
            if is_north { [232, 232, 228, 255] } else { before.pixels()[(y * rect.w as i32 + x) as usize] }
        });
    }
    let mut points = site.points(2500);
    points.retain(|point| plane.signed_distance(point.position).abs() > 0.1);
    let found = answer(&photos, &points).unwrap();
    let walls = found.objects.iter().filter(|object| object.kind == PlaneKind::Plumb).count();
    assert!(walls >= 2 && found.objects[0].kind == PlaneKind::Ground, "{walls} walls");
    let corners = found.objects.iter().flat_map(|object| &object.faces).flat_map(|face| &face.ring);
    let farthest = corners.map(|corner| corner.distance(DVec3::new(10.0, 7.0, 2.0))).fold(0.0, f64::max);
    assert!(farthest < 40.0, "a face reaches {farthest} from the middle of a court of 20 x 16");
}

#[test]
fn steps_are_no_slope_of_the_ground() {
    let mut site = Invented::court();
    let mut m = Modeller::new();
    m.object("ground").quad(DVec3::new(0.0, -2.0, 0.0), DVec3::X * 20.0, DVec3::Y * 10.0);
    for step in 0..3 {
        let (y, z) = (8.0 + f64::from(step), 0.35 * f64::from(step));
        m.object(format!("riser {step}")).quad_facing(
            DVec3::NEG_Y,
            DVec3::new(0.0, y, z),
            DVec3::X * 20.0,
            DVec3::Z * 0.35,
        );
        m.object(format!("tread {step}")).quad(DVec3::new(0.0, y, z + 0.35), DVec3::X * 20.0, DVec3::Y);
    }
    m.object("north").quad_facing(DVec3::NEG_Y, DVec3::new(0.0, 11.0, 1.05), DVec3::X * 20.0, DVec3::Z * 6.0);
    site.model = std::sync::Arc::unwrap_or_clone(m.finish());
    let found = suggested(&site);
    let ground: Vec<&SuggestedObject> =
        found.objects.iter().filter(|object| object.kind == PlaneKind::Ground).collect();
    assert_eq!(ground.len(), 1);
    let heights = || ground[0].faces.iter().flat_map(|face| &face.ring).map(|corner| corner.z);
    let (low, high) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    assert!(low > -0.15 && high < 0.15, "the ground is at {low} to {high}, and not under the steps");
}

#[test]
fn cameras_on_one_line_are_enough_for_the_wall_opposite() {
    let mut site = Invented::court();
    for (i, (_, pose)) in site.cameras.iter_mut().enumerate() {
        let eye = DVec3::new(4.0 + 2.0 * i as f64, 1.0, 1.7);
        *pose = look_at(eye, eye + DVec3::new(0.0, 10.0, 0.5));
    }
    let found = suggested(&site);
    assert!(found.up.angle_between(DVec3::Z).to_degrees() < 0.5);
    assert!(found.objects.iter().any(|object| object.kind == PlaneKind::Plumb));
}

#[test]
fn what_the_given_model_explains_is_not_suggested_again() {
    let site = Invented::court();
    let (photos, points) = (site.photos(), site.points(2500));
    let with = |given: &Model| {
        suggest(&Input { photos: &photos, points: &points, given: Some(given) }, &Task::silent()).unwrap()
    };
    match with(&site.model) {
        Err(reason) => assert_eq!(reason, Reason::AllExplained),
        Ok(found) => {
            let of =
                |it: &SuggestedObject| (it.name.clone(), area(it), it.gain, it.photos_for, it.photos_against);
            let total: f64 = found.objects.iter().map(area).sum();
            let objects: Vec<_> = found.objects.iter().map(of).collect();
            // Walls that run on into the sky, where they cost nothing.
            assert!(total < 90.0, "{total} of 600 are suggested again: {objects:?}");
        }
    }
    let found = with(&site.model.without(|object| object.name == "west")).unwrap();
    let west = found.objects.iter().filter(|object| object.kind == PlaneKind::Plumb).map(area).sum::<f64>();
    assert!((60.0..130.0).contains(&west), "{west} of the west wall's 84");
}
