//! The steps from photos and points to a model.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use quadratura_base::error::Result;
use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::scene::Model;
use quadratura_base::task::Task;

use super::chart::grown;
use super::face::NormalisedFace;
use super::ground::with_ground;
use super::label::{LabelCandidates, LabelledPhoto, PhotoLabels, labelled};
use super::outline::{SLACK_OF_SIDE, outlines};
use super::planes::{PlaneKind, PlaneOfPoints, PlaneSearch, merged};
use super::points::{NormalisedPoint, PointFrame, SourcePoint, certain, neighbours};
use super::predict::{HARM, HARM_OF_ADDED, Judgement, Predictor};
use super::rays::Rays;
use super::sky::skies;
use super::snap::Guides;
use super::support::{PlaneSupport, middle};
use super::sweep::swept;
use super::up::up;
use super::view::{SourcePhoto, WorkingPhoto};
use super::votes::{PlaneVotes, votes};

/// What a model is suggested from.
pub struct Input<'a> {
    /// The photos.
    pub photos: &'a [SourcePhoto],
    /// The points; observers are indices of `photos`.
    pub points: &'a [SourcePoint],
    /// The model that is there, in the cameras' world: only what it does not explain is suggested.
    pub given: Option<&'a Model>,
}

/// A polygon in the cameras' world.
#[derive(Debug, Clone)]
pub struct SuggestedFace {
    /// The corners, counter-clockwise seen from the front, with bridged holes.
    pub ring: Vec<DVec3>,
}

/// An object that is suggested: the faces of one plane.
#[derive(Debug, Clone)]
pub struct SuggestedObject {
    /// The name, such as `wall_3`.
    pub name: String,
    /// How its plane lies.
    pub kind: PlaneKind,
    /// Its faces.
    pub faces: Vec<SuggestedFace>,
    /// Sparse points on its plane.
    pub points: usize,
    /// The mean number of photos that show a place of it.
    pub photos_for: f64,
    /// The mean number of photos that see through a place of it.
    pub photos_against: f64,
    /// By how much it lowers the root mean square error of left-out photos where they show it, of 255; `None` where no two
    /// photos show it.
    pub gain: Option<f64>,
}

impl SuggestedObject {
    /// Returns how many of the photos that could confirm it do, 0 to 1.
    pub fn confidence(&self) -> f64 {
        self.photos_for / (self.photos_for + self.photos_against).max(1e-9)
    }
}

/// A model that is suggested.
#[derive(Debug, Clone)]
pub struct Suggestion {
    /// The objects, the ground first, then the most useful ones.
    pub objects: Vec<SuggestedObject>,
    /// The direction upwards in the cameras' world.
    pub up: DVec3,
    /// Faces that were dropped because they hardly show, or because left-out photos are predicted better without them.
    pub dropped: usize,
    /// How well left-out photos are predicted, as PSNR in dB at the working size.
    pub psnr_db: f64,
}

/// Why nothing is suggested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reason {
    /// There are fewer than two photos.
    FewPhotos,
    /// There are no points at all.
    NoPoints,
    /// All cameras are at one place, or so near to each other that no point's distance is known.
    OnePlace,
    /// Fewer points than [`FEWEST_POINTS`] have a known distance.
    FewPoints,
    /// The points lie on no plane, or no photo shows one.
    NoPlanes,
    /// The model that is given explains all that is seen.
    AllExplained,
}

/// The fewest points from which something is suggested.
pub const FEWEST_POINTS: usize = 30;

/// The most planes of points.
const MOST_PLANES: usize = 45;

/// The stages that are reported.
const STAGE_PLANES: &str = "find planes";
const STAGE_LABELS: &str = "label photos";
const STAGE_VOTES: &str = "outline faces";

/// Suggests a model, or says why there is none.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`] on request.
pub fn suggest(input: &Input<'_>, task: &Task) -> Result<std::result::Result<Suggestion, Reason>> {
    let site = match KnownSite::new(input, task)? {
        Ok(site) => site,
        Err(reason) => return Ok(Err(reason)),
    };
    let candidates = site.candidates(task)?;
    if candidates.planes.is_empty() {
        return Ok(Err(Reason::NoPlanes));
    }
    let Some(best) = site.best_attempt(candidates, task)? else { return Ok(Err(Reason::NoPlanes)) };
    if best.faces.is_empty() {
        return Ok(Err(if input.given.is_some() { Reason::AllExplained } else { Reason::NoPlanes }));
    }
    let psnr_db = 10.0 * (255.0 * 255.0 / best.error.max(1e-9)).log10();
    let (objects, dropped) = (site.objects(&best.candidates, best.faces), best.dropped);
    Ok(Ok(Suggestion { objects, up: site.up, dropped, psnr_db }))
}

/// The faces of one way to label the photos, and how well they predict photos.
struct Attempt {
    candidates: LabelCandidates,
    faces: Vec<(NormalisedFace, Judgement)>,
    dropped: usize,
    /// The mean squared error of photos that are left out.
    error: f64,
}

/// How much rays that pass through planes count. They bound faces, and erase what stands behind columns: which is worse depends on
/// the site.
const VIOLATIONS: [f32; 2] = [1.5, 0.0];

/// The shares of rays that the cells of a face may block, tried one after the other until its outline blocks no more than it may.
const MOST_BLOCKED: [f64; 3] = [0.0075, 0.0025, 0.0];

/// What is known before the search.
struct KnownSite {
    frame: PointFrame,
    views: Vec<WorkingPhoto>,
    points: Vec<NormalisedPoint>,
    /// The photos at half the working size.
    coarse: Vec<WorkingPhoto>,
    near: Vec<Vec<u32>>,
    up: DVec3,
    /// The inverse depth of the given model in each photo.
    given: Option<Vec<Vec<f32>>>,
    sky: Vec<Vec<f32>>,
}

impl KnownSite {
    fn new(input: &Input<'_>, task: &Task) -> Result<std::result::Result<Self, Reason>> {
        task.step(STAGE_PLANES, 0, 4)?;
        if input.photos.len() < 2 {
            return Ok(Err(Reason::FewPhotos));
        }
        if input.points.is_empty() {
            return Ok(Err(Reason::NoPoints));
        }
        let eyes: Vec<DVec3> = input.photos.iter().map(|photo| photo.pose.center_in_world()).collect();
        let Some(frame) = PointFrame::new(&eyes, input.points) else { return Ok(Err(Reason::NoPoints)) };
        let views: Vec<WorkingPhoto> =
            input.photos.par_iter().map(|photo| WorkingPhoto::new(photo, frame.origin, frame.unit)).collect();
        let points = certain(&views, input.points, &frame);
        if points.len() < FEWEST_POINTS {
            let spread = eyes.iter().map(|eye| eye.distance(eyes[0])).fold(0.0, f64::max);
            let reason = if spread < 0.01 * frame.unit { Reason::OnePlace } else { Reason::FewPoints };
            return Ok(Err(reason));
        }
        task.step(STAGE_PLANES, 1, 4)?;
        let up = up(&views, &points);
        let near = neighbours(&views, &points);
        let given = input.given.map(|model| depths_of_model(model, &views, &frame));
        let sky = skies(&views, &points, &near, up);
        let coarse = input
            .photos
            .par_iter()
            .map(|photo| WorkingPhoto::new(&photo.halved(), frame.origin, frame.unit))
            .collect();
        Ok(Ok(Self { frame, views, points, coarse, near, up, given, sky }))
    }

    /// Finds the planes of points, and the ground.
    fn candidates(&self, task: &Task) -> Result<LabelCandidates> {
        task.step(STAGE_PLANES, 2, 4)?;
        let search = PlaneSearch::new(&self.points, Some(self.up), 1);
        let mut search = if self.given.is_some() { search.ending_at_chance() } else { search };
        let planes = search.planes(MOST_PLANES);
        let planes = merged(&self.points, planes, self.up);
        task.step(STAGE_PLANES, 3, 4)?;
        let planes = with_ground(planes, &self.points, &self.views, self.up, &self.near);
        let candidates = self.supported(planes);
        task.step(STAGE_PLANES, 4, 4)?;
        Ok(candidates)
    }

    fn supported(&self, planes: Vec<PlaneOfPoints>) -> LabelCandidates {
        let support = |plane: &PlaneOfPoints| PlaneSupport::new(plane, &self.points, &self.views, self.up);
        let supports = planes.par_iter().map(support).collect();
        LabelCandidates { planes, supports, up: self.up, violation: VIOLATIONS[0] }
    }

    /// Labels all photos.
    fn labels(&self, candidates: &LabelCandidates, task: &Task) -> Result<Vec<PhotoLabels>> {
        let done = AtomicU64::new(0);
        let total = self.views.len() as u64;
        let label = |of: usize| {
            task.step(STAGE_LABELS, done.fetch_add(1, Ordering::Relaxed), total)?;
            let subject = LabelledPhoto {
                views: &self.views,
                of,
                neighbours: &self.near[of],
                points: &self.points,
                sky: &self.sky[of],
                given: self.given.as_ref().map(|given| given[of].as_slice()),
            };
            Ok(labelled(&subject, candidates))
        };
        let labels = (0..self.views.len()).into_par_iter().map(label).collect();
        task.step(STAGE_LABELS, total, total)?;
        labels
    }

    /// Tries planes of points alone and with walls without points, with and without rays, and returns what predicts left-out photos best.
    fn best_attempt(&self, candidates: LabelCandidates, task: &Task) -> Result<Option<Attempt>> {
        let labels = self.labels(&candidates, task)?;
        let found = swept(&self.coarse, &self.near, &self.points, &self.sky, &labels, &candidates, task)?;
        let mut ways = vec![candidates];
        if !found.is_empty() {
            ways.push(self.supported(ways[0].planes.iter().cloned().chain(found).collect()));
        }
        let mut first = Some(labels);
        let mut best: Option<Attempt> = None;
        for way in ways {
            for violation in VIOLATIONS {
                let candidates = LabelCandidates { violation, ..way.clone() };
                let labels = first.take().map_or_else(|| self.labels(&candidates, task), Ok)?;
                let attempt = self.attempt(candidates, &labels, task)?;
                if best.as_ref().is_none_or(|best| attempt.error < best.error) {
                    best = Some(attempt);
                }
            }
        }
        Ok(best)
    }

    /// Outlines and checks the faces of labelled photos.
    fn attempt(&self, candidates: LabelCandidates, labels: &[PhotoLabels], task: &Task) -> Result<Attempt> {
        let faces = self.faces(&candidates, labels, task)?;
        let mut predictor = Predictor::new(&self.views, &self.near, &faces, self.given.as_deref());
        let (stays, judgements) =
            predictor.useful(&faces, if self.given.is_some() { HARM_OF_ADDED } else { HARM }, task)?;
        let error = predictor.error();
        let count = faces.len();
        let kept = faces.into_iter().zip(judgements).zip(stays).filter(|(_, stays)| *stays);
        let faces: Vec<(NormalisedFace, Judgement)> = kept.map(|(face, _)| face).collect();
        let dropped = count - faces.len();
        Ok(Attempt { candidates, faces, dropped, error })
    }

    /// Outlines the faces of all planes.
    fn faces(
        &self,
        candidates: &LabelCandidates,
        labels: &[PhotoLabels],
        task: &Task,
    ) -> Result<Vec<NormalisedFace>> {
        let each = |number: usize| {
            task.check_cancelled()?;
            let votes = votes(number as u16, candidates, &self.views, labels);
            Ok(votes.map_or_else(Vec::new, |votes| self.faces_of_plane(number, candidates, &votes)))
        };
        task.step(STAGE_VOTES, 0, 1)?;
        let faces: Result<Vec<Vec<NormalisedFace>>> =
            (0..candidates.planes.len()).into_par_iter().map(each).collect();
        task.step(STAGE_VOTES, 1, 1)?;
        Ok(faces?.into_iter().flatten().collect())
    }

    fn faces_of_plane(
        &self,
        number: usize,
        candidates: &LabelCandidates,
        votes: &PlaneVotes,
    ) -> Vec<NormalisedFace> {
        let PlaneOfPoints { plane, kind, .. } = &candidates.planes[number];
        // A cell more closes cracks between faces.
        let mask = grown(&votes.mask(*kind, &self.views, plane), votes.chart.size, 1);
        let rays = Rays::new(plane, &votes.chart, &self.points, &self.views);
        // What is added has to keep off the given model.
        let slack_of_side = if self.given.is_some() { 0.0 } else { SLACK_OF_SIDE };
        let guides = Guides::new(number, &candidates.planes, &votes.chart);
        let mut faces = Vec::new();
        // Outlines leave the cells, so that less has to be left where a face still blocks too much.
        for most in MOST_BLOCKED {
            let mut cut = mask.clone();
            rays.cut(&mut cut, &votes.chart, most);
            let rings = outlines(&cut, votes.chart.size, slack_of_side)
                .into_iter()
                .flat_map(|outline| guides.snapped(&outline).rings(&votes.chart));
            let face = |ring| NormalisedFace::new(number, *kind, *plane, ring, &votes.chart);
            let (wrong, right): (Vec<_>, Vec<_>) =
                rings.map(face).partition(|face: &NormalisedFace| rays.is_wrong(&face.covers));
            faces = right;
            if wrong.is_empty() {
                break;
            }
        }
        faces.into_iter().map(|face| with_votes(face, votes)).collect()
    }

    /// Names what is suggested and returns it to the cameras' world.
    fn objects(
        &self,
        candidates: &LabelCandidates,
        faces: Vec<(NormalisedFace, Judgement)>,
    ) -> Vec<SuggestedObject> {
        let mut objects: BTreeMap<usize, Vec<(NormalisedFace, Judgement)>> = BTreeMap::new();
        for (face, judgement) in faces {
            objects.entry(face.number).or_default().push((face, judgement));
        }
        let worth = |faces: &[(NormalisedFace, Judgement)]| {
            faces.iter().map(|(_, it)| it.without - it.with).sum::<f64>()
        };
        let mut objects: Vec<(usize, Vec<(NormalisedFace, Judgement)>)> = objects.into_iter().collect();
        let is_ground = |number: usize| candidates.planes[number].kind == PlaneKind::Ground;
        objects.sort_by(|a, b| is_ground(b.0).cmp(&is_ground(a.0)).then(worth(&b.1).total_cmp(&worth(&a.1))));
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        let named = |(number, faces): (usize, Vec<(NormalisedFace, Judgement)>)| {
            let plane = &candidates.planes[number];
            let count = counts.entry(word(plane.kind)).or_insert(0);
            *count += 1;
            let ending = if plane.kind == PlaneKind::Thing { ".billboard" } else { "" };
            self.object(format!("{}_{count}{ending}", word(plane.kind)), plane, &faces)
        };
        objects.into_iter().map(named).collect()
    }

    fn object(
        &self,
        name: String,
        plane: &PlaneOfPoints,
        faces: &[(NormalisedFace, Judgement)],
    ) -> SuggestedObject {
        let world = |at: &DVec3| self.frame.origin + *at * self.frame.unit;
        let count = faces.len().max(1) as f64;
        let sum = faces.iter().fold(Judgement::default(), |sum, (_, it)| sum.and(it));
        SuggestedObject {
            name,
            kind: plane.kind,
            faces: faces
                .iter()
                .map(|(f, _)| SuggestedFace { ring: f.ring.iter().map(world).collect() })
                .collect(),
            points: plane.members.len(),
            photos_for: faces.iter().map(|(face, _)| face.seen).sum::<f64>() / count,
            photos_against: faces.iter().map(|(face, _)| face.passed).sum::<f64>() / count,
            gain: sum.gain(),
        }
    }
}

/// The word for an object in its name.
fn word(kind: PlaneKind) -> &'static str {
    match kind {
        PlaneKind::Ground => "ground",
        PlaneKind::Plumb => "wall",
        PlaneKind::Level => "level",
        PlaneKind::Sloped => "roof",
        PlaneKind::Thing => "thing",
    }
}

/// Adds the mean votes of the cells that a face covers.
fn with_votes(mut face: NormalisedFace, votes: &PlaneVotes) -> NormalisedFace {
    let cells: Vec<usize> = (0..face.covers.len()).filter(|at| face.covers[*at]).collect();
    let mean =
        |of: &[f32]| cells.iter().map(|at| f64::from(of[*at])).sum::<f64>() / cells.len().max(1) as f64;
    (face.seen, face.passed) = (mean(&votes.seen), mean(&votes.passed));
    face
}

/// Returns the inverse depth of a model at each pixel of each photo; 0 where it is not.
fn depths_of_model(model: &Model, views: &[WorkingPhoto], frame: &PointFrame) -> Vec<Vec<f32>> {
    let corner = |vertex: u32| (model.vertices[vertex as usize] - frame.origin) / frame.unit;
    let tree = Bvh::new(model.triangles.iter().map(|triangle| triangle.map(corner)).collect());
    let of_view = |view: &WorkingPhoto| {
        let w = view.size()[0];
        let inverse = |at: usize| {
            let hit = tree.first_hit(view.eye, view.ray(middle(at % w, at / w)), f64::INFINITY);
            hit.map_or(0.0, |(depth, _)| (1.0 / depth) as f32)
        };
        (0..view.known.len()).map(inverse).collect()
    };
    views.par_iter().map(of_view).collect()
}
