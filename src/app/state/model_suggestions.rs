//! What is suggested to complete the model, as it is looked at, renamed and extended.

use std::collections::BTreeSet;
use std::path::PathBuf;

use glam::DVec3;

use quadratura_base::geometry::Plane;
use quadratura_base::geometry::polygon::{extent, newell_normal, triangulate};
use quadratura_base::scene::Model;
use quadratura_sites::suggest::{Addition, SuggestedObject, free_name, with_edge_through};

/// Suggestions for the open project.
#[derive(Default)]
pub struct SuggestedModelState {
    /// What is offered.
    pub offered: Option<ModelSuggestions>,
    /// Whether the window with them is open.
    pub shown: bool,
    /// What was rejected: it is not offered again while the project is open.
    pub rejected: Vec<RejectedPlane>,
}

impl SuggestedModelState {
    /// Returns the suggestions while they are shown.
    pub fn visible(&self) -> Option<&ModelSuggestions> {
        self.offered.as_ref().filter(|_| self.shown)
    }
}

/// The objects that are offered.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelSuggestions {
    /// The project's folder.
    pub project: PathBuf,
    /// The hash of the model's file that they complete.
    pub model_hash: String,
    /// The objects, the most useful ones first.
    pub objects: Vec<OfferedObject>,
    /// The object under the pointer in the list.
    pub pointed: Option<usize>,
}

/// An object that is offered.
#[derive(Debug, Clone, PartialEq)]
pub struct OfferedObject {
    /// The name, which can be typed.
    pub name: String,
    /// Whether it is to be added.
    pub wanted: bool,
    /// The faces, in the cameras' world.
    pub faces: Vec<OfferedFace>,
    /// Sparse points on its plane.
    pub points: usize,
    /// By how much it lowers the error of left-out photos, of 255.
    pub gain: Option<f64>,
    /// How many of the photos that could confirm it do, 0 to 1.
    pub confidence: f64,
    /// Whether an edge was moved: the figures are of the face before.
    pub is_changed: bool,
}

/// A face that is offered.
#[derive(Debug, Clone, PartialEq)]
pub struct OfferedFace {
    /// The outline, counter-clockwise seen from the front, with bridged holes.
    pub ring: Vec<DVec3>,
    /// Its unit normal.
    pub normal: DVec3,
    /// Its triangles.
    pub triangles: Vec<[DVec3; 3]>,
}

impl OfferedFace {
    /// Makes a face of an outline.
    pub fn new(ring: Vec<DVec3>) -> Self {
        let normal = newell_normal(&ring).normalize_or_zero();
        let plane = Plane { normal, point: ring.first().copied().unwrap_or_default() };
        let found = triangulate(&ring, &plane);
        let corner = |at: u32| {
            let at = at as usize;
            ring.get(at).or_else(|| found.crossings.get(at - ring.len())).copied().unwrap_or_default()
        };
        let triangles = found.triangles.iter().map(|triangle| triangle.map(corner)).collect();
        Self { ring, normal, triangles }
    }

    fn middle(&self) -> DVec3 {
        self.ring.iter().sum::<DVec3>() / self.ring.len().max(1) as f64
    }
}

impl OfferedObject {
    /// Makes an offer of a suggestion.
    fn new(object: &SuggestedObject, name: String) -> Self {
        Self {
            name,
            wanted: true,
            faces: object.faces.iter().map(|face| OfferedFace::new(face.ring.clone())).collect(),
            points: object.points,
            gain: object.gain,
            confidence: object.confidence(),
            is_changed: false,
        }
    }

    fn addition(&self) -> Addition {
        Addition { name: self.name.clone(), rings: self.faces.iter().map(|face| face.ring.clone()).collect() }
    }
}

/// An edge of a suggestion: it begins at a corner of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgeOfSuggestion {
    /// The index of the object.
    pub object: usize,
    /// The index of the face within it.
    pub face: usize,
    /// The index of the corner.
    pub corner: usize,
}

/// The edge under the pointer, and whether it is being dragged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EdgeGrip {
    /// The edge.
    pub edge: Option<EdgeOfSuggestion>,
    /// Whether it is being dragged.
    pub is_dragged: bool,
}

/// A plane that was rejected, about one of its places.
#[derive(Debug, Clone, PartialEq)]
pub struct RejectedPlane {
    normal: DVec3,
    middle: DVec3,
    size: f64,
}

/// The cosine of the angle up to which planes are the same: 3 degrees, the difference between two searches.
const SAME_COSINE: f64 = 0.9986;
/// The distance of one from the other, as a share of the larger size.
const SAME_SHARE: f64 = 0.02;

impl RejectedPlane {
    fn new(face: &OfferedFace) -> Self {
        Self { normal: face.normal, middle: face.middle(), size: extent(&face.ring) }
    }

    fn is_like(&self, other: &Self) -> bool {
        let apart = other.middle - self.middle;
        let size = self.size.max(other.size);
        self.normal.dot(other.normal) > SAME_COSINE
            && apart.dot(self.normal).abs() < SAME_SHARE * size
            && apart.length() < 0.5 * size
    }
}

impl ModelSuggestions {
    /// Makes offers of suggestions, with names that the model does not have, without what was rejected.
    pub fn new(
        project: PathBuf,
        model_hash: String,
        found: &[SuggestedObject],
        model: &Model,
        rejected: &[RejectedPlane],
    ) -> Self {
        let mut taken: BTreeSet<String> = model.objects.iter().map(|object| object.name.clone()).collect();
        let offered = |object: &SuggestedObject| {
            let name = free_name(&object.name, &taken);
            let mut offer = OfferedObject::new(object, name.clone());
            offer.faces.retain(|face| {
                let plane = RejectedPlane::new(face);
                !rejected.iter().any(|rejected| rejected.is_like(&plane))
            });
            taken.insert(name);
            (!offer.faces.is_empty()).then_some(offer)
        };
        let objects = found.iter().filter_map(offered).collect();
        Self { project, model_hash, objects, pointed: None }
    }

    /// Removes an object, and returns its planes.
    pub fn reject(&mut self, object: usize) -> Vec<RejectedPlane> {
        if object >= self.objects.len() {
            return Vec::new();
        }
        self.pointed = None;
        self.objects.remove(object).faces.iter().map(RejectedPlane::new).collect()
    }

    /// Moves an edge within its plane, so that its line passes a point; a face that would cross itself stays as it is.
    pub fn move_edge(&mut self, edge: EdgeOfSuggestion, to: DVec3) {
        let Some(object) = self.objects.get_mut(edge.object) else { return };
        let Some(face) = object.faces.get_mut(edge.face) else { return };
        if let Some(ring) = with_edge_through(&face.ring, face.normal, edge.corner, to) {
            *face = OfferedFace::new(ring);
            object.is_changed = true;
        }
    }

    /// Returns the objects that are to be added.
    pub fn additions(&self) -> Vec<Addition> {
        self.objects.iter().filter(|object| object.wanted).map(OfferedObject::addition).collect()
    }

    /// Returns the edge's ends in the world.
    pub fn ends(&self, edge: EdgeOfSuggestion) -> Option<[DVec3; 2]> {
        let ring = &self.face(edge)?.ring;
        Some([*ring.get(edge.corner)?, ring[(edge.corner + 1) % ring.len()]])
    }

    /// Returns the face of an edge.
    pub fn face(&self, edge: EdgeOfSuggestion) -> Option<&OfferedFace> {
        self.objects.get(edge.object)?.faces.get(edge.face)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::ModelBuilder;
    use quadratura_base::task::Task;
    use quadratura_sites::suggest::{PlaneKind, SuggestedFace};

    fn suggested(name: &str, x: f64) -> SuggestedObject {
        let ring = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)].map(|(y, z)| DVec3::new(x, y, z));
        SuggestedObject {
            name: name.into(),
            kind: PlaneKind::Plumb,
            faces: vec![SuggestedFace { ring: ring.to_vec() }],
            points: 40,
            photos_for: 3.0,
            photos_against: 1.0,
            gain: Some(2.0),
        }
    }

    fn offers(rejected: &[RejectedPlane]) -> ModelSuggestions {
        let mut builder = ModelBuilder::default();
        let object = builder.object("wall_1");
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|at| builder.vertex(at));
        builder.face(object, &corners);
        let (model, _) = builder.finish(&Task::silent()).unwrap();
        let found = [suggested("wall_1", 0.0), suggested("wall_2", 9.0)];
        ModelSuggestions::new("p".into(), "hash".into(), &found, &model, rejected)
    }

    #[test]
    fn offers_have_free_names_and_all_are_wanted_at_first() {
        let mut offers = offers(&[]);
        let names: Vec<String> = offers.additions().into_iter().map(|addition| addition.name).collect();
        assert_eq!(names.len(), 2);
        assert!(!names.contains(&"wall_1".to_owned()) && names[0] != names[1], "{names:?}");
        offers.objects[1].wanted = false;
        offers.objects[0].name = "gate".into();
        let additions = offers.additions();
        assert_eq!((additions.len(), additions[0].name.as_str()), (1, "gate"));
        assert_eq!(offers.objects[0].faces[0].triangles.len(), 2);
    }

    #[test]
    fn what_was_rejected_is_not_offered_again() {
        let mut first = offers(&[]);
        let rejected = first.reject(0);
        assert_eq!((first.objects.len(), rejected.len()), (1, 1));
        let again = offers(&rejected);
        assert_eq!(again.objects.len(), 1);
        assert!(again.objects[0].faces[0].ring[0].x > 8.0, "the other one is offered");
        assert!(first.reject(7).is_empty());
    }

    #[test]
    fn an_edge_that_is_moved_extends_the_face() {
        let mut offers = offers(&[]);
        let edge = EdgeOfSuggestion { object: 0, face: 0, corner: 1 };
        offers.move_edge(edge, DVec3::new(0.0, 7.0, 1.0));
        assert!(offers.objects[0].is_changed && !offers.objects[1].is_changed);
        assert_eq!(offers.ends(edge).unwrap()[0], DVec3::new(0.0, 7.0, 0.0));
        let before = offers.clone();
        offers.move_edge(edge, DVec3::new(0.0, -7.0, 1.0));
        offers.move_edge(EdgeOfSuggestion { object: 5, ..edge }, DVec3::ZERO);
        assert_eq!(offers, before, "a face never turns inside out");
    }
}
