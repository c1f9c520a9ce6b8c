//! Sparse points that no face explains: what the photos show and the model leaves out. Views show such things wherever a
//! ray ends instead, which is infinitely far away where no face is.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::faces::CheckedSurface;
use quadratura_base::raster::robust::quantile;
use quadratura_base::scene::builder::says_backdrop;
use quadratura_base::scene::up;
use quadratura_base::scene::{Model, Object, PhotoId, Site, SparsePoint};

/// A point is explained by a face within this share of its distance from the nearest camera: 40 cm at 20 m, twice the
/// detail that a coarse model leaves out. Of the points of castle, fountain, entry and piazza, whose models leave out
/// next to nothing, 0.5 to 1.6 % are farther.
const EXPLAINED: f64 = 0.02;

/// The error of an observation in pixels, from which the error of a point's distance follows.
const ERROR_PX: f64 = 2.0;

/// Points whose distance is less certain than this share of it tell nothing.
const UNCERTAIN: f64 = 0.1;

/// A point on no face is far when its distance from the nearest camera exceeds this many times the distance that
/// [`MOST`] of the points on faces do not exceed. Infinitely far away is where such things belong.
const FAR: f64 = 1.5;

/// The share of the points on faces that bounds how far away the model is, and of those above its lowest points.
const MOST: f64 = 0.95;

/// The least number of points that are judged.
const ENOUGH: usize = 50;

/// The least number of points, and the least share of those judged, that is worth a line in reports of other commands.
const TELLING: (usize, f64) = (20, 0.01);

/// What the photos show instead of a point that no face explains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Miss {
    /// No face is behind the point: views show what is there infinitely far away.
    Open,
    /// A face is behind the point: views show what is there flat on that face.
    InFront,
    /// A face hides the point.
    Hidden,
}

impl Miss {
    /// All kinds, the worst first.
    pub const ALL: [Self; 3] = [Self::Open, Self::InFront, Self::Hidden];

    /// Says what it means.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Open => "with no face behind them: shown infinitely far away",
            Self::InFront => "in front of a face: shown flat on that face",
            Self::Hidden => "behind a face, which hides them",
        }
    }
}

/// The sparse points that no face explains. Backdrops explain nothing: they stand for what is far away.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Unexplained {
    /// The number of points that were judged: those that two photos show from directions different enough.
    pub judged: usize,
    /// The number of points with no face behind them, near enough that they are not taken for the background.
    pub open: usize,
    /// The number of points in front of a face.
    pub in_front: usize,
    /// The number of points that a face hides.
    pub hidden: usize,
    /// The number of points with no face behind them on ground beside the model: as low as its lowest points. They are
    /// not counted as unexplained.
    pub ground: usize,
    /// The number of points with no face behind them that are much farther away than the model. They are not counted
    /// as unexplained.
    pub far: usize,
    /// The photos that show unexplained points, with their number; most of them first.
    pub photos: Vec<(String, usize)>,
    /// The unexplained points by photo, in the site's order.
    #[serde(skip)]
    pub in_photo: Vec<Vec<(DVec3, Miss)>>,
}

impl Unexplained {
    fn counter(&mut self, miss: Miss) -> &mut usize {
        match miss {
            Miss::Open => &mut self.open,
            Miss::InFront => &mut self.in_front,
            Miss::Hidden => &mut self.hidden,
        }
    }

    /// Returns the number of points of a kind.
    pub fn of(&self, miss: Miss) -> usize {
        match miss {
            Miss::Open => self.open,
            Miss::InFront => self.in_front,
            Miss::Hidden => self.hidden,
        }
    }

    /// Returns the number of points that no face explains.
    pub fn count(&self) -> usize {
        self.open + self.in_front + self.hidden
    }

    /// Says how many there are and which photos show most of them; `listed` photos at most. `None` where there are none.
    pub fn sentence(&self, listed: usize) -> Option<String> {
        let count = self.count();
        let share = 100.0 * count as f64 / self.judged.max(1) as f64;
        let photos = self.photos.iter().take(listed).map(|(photo, count)| format!("{photo} ({count})"));
        let photos = photos.collect::<Vec<_>>().join(", ");
        (count > 0).then(|| {
            format!(
                "sparse points that no face explains: {count} of {} ({share:.1} %), most of them in {photos}",
                self.judged
            )
        })
    }

    /// Returns whether there are so many that something is missing from the model.
    pub fn is_telling(&self) -> bool {
        let (least, share) = TELLING;
        self.count() >= least && self.count() as f64 >= share * self.judged as f64
    }
}

/// What was found about a point.
enum Finding {
    /// It is not certain enough where the point is.
    Uncertain,
    /// A face is there.
    Explained,
    /// No face is there.
    Missed(Miss),
}

/// Finds the sparse points that no face explains. `None` where too few points can be judged.
pub fn unexplained(site: &Site, points: &[SparsePoint]) -> Option<Unexplained> {
    let judge = Judge::new(site);
    let found: Vec<(Finding, f64)> = points.par_iter().map(|point| judge.finding(point)).collect();
    let explained = || points.iter().zip(&found).filter(|(_, (it, _))| matches!(it, Finding::Explained));
    let up = up(&site.photos);
    let mut heights: Vec<f64> = explained().map(|(point, _)| point.position.dot(up)).collect();
    let mut away: Vec<f64> = explained().map(|(_, (_, distance))| *distance).collect();
    let lowest = quantile(&mut heights, 1.0 - MOST).unwrap_or(f64::NEG_INFINITY);
    let farthest = FAR * quantile(&mut away, MOST).unwrap_or(f64::INFINITY);
    let mut result = Unexplained { in_photo: vec![Vec::new(); site.photos.len()], ..Unexplained::default() };
    for (point, (finding, distance)) in points.iter().zip(&found) {
        let miss = match finding {
            Finding::Uncertain => continue,
            Finding::Explained => None,
            Finding::Missed(miss) => Some(*miss),
        };
        result.judged += 1;
        let Some(miss) = miss else { continue };
        let is_ground = || point.position.dot(up) <= lowest + EXPLAINED * distance;
        match miss {
            Miss::Open if *distance > farthest => result.far += 1,
            Miss::Open if is_ground() => result.ground += 1,
            miss => {
                *result.counter(miss) += 1;
                for photo in judge.photos_of(point) {
                    result.in_photo[photo.index()].push((point.position, miss));
                }
            }
        }
    }
    let names = site.photos.iter().map(|photo| photo.name.clone());
    let counts = result.in_photo.iter().map(Vec::len);
    result.photos = names.zip(counts).filter(|(_, count)| *count > 0).collect();
    // The sort is stable: equal ones stay in the site's order.
    result.photos.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    (result.judged >= ENOUGH).then_some(result)
}

/// What points are judged by.
struct Judge<'a> {
    site: &'a Site,
    /// The model without backdrops, and without what turns.
    surface: CheckedSurface,
    /// The volumes that billboards stand for.
    volumes: Vec<BillboardVolume>,
    eyes: Vec<DVec3>,
}

impl<'a> Judge<'a> {
    fn new(site: &'a Site) -> Self {
        let stands_for_volume = |object: &Object| object.billboard;
        let solid = site.model.without(|object| says_backdrop(&object.name) || stands_for_volume(object));
        let billboards = site.model.objects.iter().filter(|object| stands_for_volume(object));
        let eyes = site.photos.iter().map(|photo| photo.pose.center_in_world()).collect();
        let volumes = billboards.filter_map(|object| BillboardVolume::new(&site.model, object)).collect();
        Self { site, surface: CheckedSurface::from_model(&solid), volumes, eyes }
    }

    /// Returns the photos that show a point, each once.
    fn photos_of(&self, point: &SparsePoint) -> Vec<PhotoId> {
        let known = point.observations.iter().filter(|(photo, _)| (*photo as usize) < self.eyes.len());
        let mut photos: Vec<PhotoId> = known.map(|(photo, _)| PhotoId(*photo)).collect();
        photos.sort_unstable();
        photos.dedup();
        photos
    }

    /// Judges a point; also returns its distance from the nearest camera that shows it.
    fn finding(&self, point: &SparsePoint) -> (Finding, f64) {
        let at = point.position;
        let photos = self.photos_of(point);
        let rays: Vec<DVec3> = photos.iter().map(|photo| at - self.eyes[photo.index()]).collect();
        let distance = rays.iter().map(|ray| ray.length()).fold(f64::INFINITY, f64::min);
        let uncertainty = self.uncertainty(&photos, &rays);
        if !at.is_finite() || uncertainty.is_nan() || uncertainty > UNCERTAIN {
            return (Finding::Uncertain, distance);
        }
        let tolerance = uncertainty.max(EXPLAINED);
        let is_near = |(_, foot): (u32, DVec3)| foot.distance(at) <= tolerance * distance;
        let is_on_face = self.surface.tree.nearest(at).is_some_and(is_near);
        if is_on_face || self.volumes.iter().any(|volume| volume.holds(at, tolerance * distance)) {
            return (Finding::Explained, distance);
        }
        let mut misses: Vec<Miss> = photos
            .iter()
            .zip(&rays)
            .filter_map(|(photo, ray)| self.miss(self.eyes[photo.index()], *ray, tolerance))
            .collect();
        if 2 * misses.len() <= photos.len() {
            return (Finding::Explained, distance);
        }
        // What most photos show; of two as frequent, the worse one.
        misses.sort_unstable();
        let times = |miss: Miss| misses.iter().filter(|it| **it == miss).count();
        let miss = Miss::ALL.into_iter().rev().max_by_key(|miss| times(*miss)).expect("there are kinds");
        (Finding::Missed(miss), distance)
    }

    /// Returns what a photo shows at a point; `None` where a face is there.
    fn miss(&self, eye: DVec3, ray: DVec3, tolerance: f64) -> Option<Miss> {
        match self.surface.tree.first_hit(eye, ray, f64::INFINITY) {
            None => Some(Miss::Open),
            Some((t, _)) if t > 1.0 + tolerance => Some(Miss::InFront),
            Some((t, _)) if t < 1.0 - tolerance => Some(Miss::Hidden),
            Some(_) => None,
        }
    }

    /// Returns the error of a point's distance as a share of it: that of its observations over the widest angle
    /// between two of them. Infinite for points that one photo shows.
    fn uncertainty(&self, photos: &[PhotoId], rays: &[DVec3]) -> f64 {
        let focal =
            photos.iter().map(|photo| self.site.photo(*photo).camera.fx).fold(f64::INFINITY, f64::min);
        let pairs = (1..rays.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let widest = pairs.map(|(a, b)| rays[a].angle_between(rays[b])).fold(0.0, f64::max);
        ERROR_PX / (focal * widest.sin().abs())
    }
}

/// The volume that a billboard stands for: an upright cylinder where it turns, else the box around its corners.
enum BillboardVolume {
    Cylinder { foot: DVec3, axis: DVec3, height: f64, radius: f64 },
    Box { low: DVec3, high: DVec3 },
}

impl BillboardVolume {
    fn new(model: &Model, object: &Object) -> Option<Self> {
        if let Some(turning) = &object.impostor {
            let (foot, axis, height) = (turning.foot, turning.axis, turning.height);
            return Some(Self::Cylinder { foot, axis, height, radius: turning.half_width });
        }
        let corners = || object.faces.iter().flat_map(|face| model.ring_points(*face));
        let (low, high) = (corners().reduce(DVec3::min)?, corners().reduce(DVec3::max)?);
        Some(Self::Box { low, high })
    }

    /// Returns whether a point is in the volume, or nearer to it than `margin`.
    fn holds(&self, point: DVec3, margin: f64) -> bool {
        match self {
            Self::Cylinder { foot, axis, height, radius } => {
                let along = (point - *foot).dot(*axis);
                let beside = (point - *foot - *axis * along).length();
                (-margin..=height + margin).contains(&along) && beside <= radius + margin
            }
            Self::Box { low, high } => point.clamp(*low, *high).distance(point) <= margin,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, dvec3};

    use super::*;
    use quadratura_base::scene::Photo;
    use quadratura_base::scene::synthetic::{Modeller, Rng, centred, look_at};

    const EYES: [DVec3; 3] = [dvec3(-3.0, -12.0, 1.7), dvec3(0.0, -12.0, 1.7), dvec3(3.0, -12.0, 1.7)];

    /// A house on its ground before a painted sky, seen from the south.
    fn site() -> Site {
        let mut m = Modeller::new();
        m.object("ground").quad(dvec3(-5.0, -12.0, 0.0), DVec3::X * 10.0, DVec3::Y * 14.0);
        m.object("house").cuboid(dvec3(0.0, 1.0, 1.5), dvec3(3.0, 1.0, 1.5), glam::DMat3::IDENTITY);
        m.object("sky.backdrop").quad_facing(
            DVec3::NEG_Y,
            dvec3(-400.0, 300.0, -50.0),
            DVec3::X * 800.0,
            DVec3::Z * 300.0,
        );
        let photo = |(at, eye): (usize, DVec3)| Photo {
            name: format!("{at}.jpg"),
            camera: centred(2000, 1500, 1600.0),
            pose: look_at(eye, dvec3(0.0, 0.0, 1.7)),
            file: "missing.jpg".into(),
            exposure: None,
            masks: Vec::new(),
        };
        Site { photos: EYES.into_iter().enumerate().map(photo).collect(), model: m.finish() }
    }

    fn seen_by(position: DVec3, photos: &[u32]) -> SparsePoint {
        SparsePoint { position, observations: photos.iter().map(|photo| (*photo, DVec2::ZERO)).collect() }
    }

    /// A hundred points on the front of the house, up to 5 cm off.
    fn on_the_house() -> Vec<SparsePoint> {
        let mut rng = Rng::new(3);
        let mut at = |low: f64, high: f64| rng.between(low, high);
        let mut place = || dvec3(at(-2.9, 2.9), at(-0.05, 0.05), at(0.1, 2.9));
        (0..100).map(|_| seen_by(place(), &[0, 1, 2])).collect()
    }

    fn judged(more: &[SparsePoint]) -> Unexplained {
        unexplained(&site(), &[on_the_house(), more.to_vec()].concat()).unwrap()
    }

    #[test]
    fn what_the_model_has_is_explained() {
        let found = judged(&[]);
        assert_eq!((found.judged, found.count(), found.sentence(3)), (100, 0, None));
        assert!(!found.is_telling() && found.photos.is_empty());
    }

    #[test]
    fn a_finial_is_shown_infinitely_far_away_and_its_photos_are_named() {
        let finial: Vec<_> =
            (0..30).map(|i| seen_by(dvec3(0.5, 0.5, 3.5 + 0.05 * f64::from(i)), &[1, 2])).collect();
        let found = judged(&finial);
        assert_eq!((found.open, found.in_front, found.hidden), (30, 0, 0), "the sky explains nothing");
        assert_eq!(found.photos, [("1.jpg".to_owned(), 30), ("2.jpg".to_owned(), 30)]);
        assert_eq!(found.in_photo[0].len(), 0);
        assert_eq!(
            found.sentence(1).unwrap(),
            "sparse points that no face explains: 30 of 130 (23.1 %), most of them in 1.jpg (30)"
        );
        assert!(found.is_telling());
    }

    #[test]
    fn a_lamp_before_the_house_and_what_is_inside_of_it_are_told_apart() {
        let lamp = seen_by(dvec3(0.0, -4.0, 1.6), &[0, 1, 2]);
        let inside = seen_by(dvec3(0.0, 1.4, 1.5), &[0, 1, 2]);
        let found = judged(&[lamp, inside]);
        assert_eq!((found.open, found.in_front, found.hidden), (0, 1, 1));
        assert!(!found.is_telling(), "two of a hundred are noise");
    }

    #[test]
    fn ground_beside_the_model_and_far_hills_are_no_missing_things() {
        let ground = seen_by(dvec3(-9.0, 1.0, 0.05), &[0, 1, 2]);
        let hill = seen_by(dvec3(30.0, 80.0, 12.0), &[0, 1, 2]);
        let tree = seen_by(dvec3(-6.0, 3.0, 2.5), &[0, 1, 2]);
        let found = judged(&[ground, hill, tree]);
        assert_eq!((found.ground, found.far, found.open), (1, 1, 1));
    }

    #[test]
    fn points_that_are_uncertain_are_not_judged() {
        let mut photos = site();
        // Five millimetres between two cameras: eleven metres away, a pixel is metres of distance.
        photos.photos[1].pose = look_at(EYES[0] + DVec3::X * 0.005, dvec3(0.0, 0.0, 1.7));
        let points = [
            on_the_house(),
            vec![
                seen_by(dvec3(0.5, 0.5, 4.5), &[0, 1]),
                seen_by(dvec3(0.5, 0.5, 4.5), &[2]),
                seen_by(DVec3::NAN, &[0, 2]),
            ],
        ];
        let found = unexplained(&photos, &points.concat()).unwrap();
        assert_eq!((found.judged, found.count()), (100, 0));
        assert!(unexplained(&photos, &points[1]).is_none(), "too few to judge by");
    }

    #[test]
    fn a_billboard_explains_the_crown_around_it() {
        let mut m = Modeller::new();
        m.object("house").cuboid(dvec3(0.0, 1.0, 1.5), dvec3(3.0, 1.0, 1.5), glam::DMat3::IDENTITY);
        m.object("tree.billboard").quad_facing(
            DVec3::NEG_Y,
            dvec3(4.0, 0.0, 0.0),
            DVec3::X * 3.0,
            DVec3::Z * 5.0,
        );
        let turning =
            Model::clone(&m.finish()).with_impostors(DVec3::Z, |object| object.name.contains("tree"));
        let model = std::sync::Arc::new(turning.0);
        let crown = seen_by(dvec3(5.5, 1.2, 4.0), &[0, 1, 2]);
        let beside = seen_by(dvec3(5.5, 4.0, 4.0), &[0, 1, 2]);
        let points = [on_the_house(), vec![crown, beside]].concat();
        let found = unexplained(&Site { model, ..site() }, &points).unwrap();
        assert_eq!(found.count(), 1);
    }
}
