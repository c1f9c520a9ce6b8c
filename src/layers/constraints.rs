//! The user's constraints on a photo's image layers, which override the method's own choice: faces that shall
//! share an image layer, and faces that shall not. Faces are given by name, so that constraints remain valid
//! when stacks are rebuilt or the model is replaced.

use std::fmt;

use rustc_hash::{FxHashMap, FxHashSet};
use serde::{Deserialize, Serialize};

use quadratura_base::scene::{FaceId, FaceIndex, Model};

/// A selection of faces of one object, by name; all faces of the object where none is listed.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Faces {
    /// The unique name of the object.
    pub object: String,
    /// Indices of faces within the object as in the model file, rising; empty for the whole object.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faces: Vec<FaceIndex>,
}

impl Faces {
    /// Selects a whole object.
    pub fn whole(object: impl Into<String>) -> Self {
        Self { object: object.into(), faces: Vec::new() }
    }

    /// Returns true when face `index` of `object` is one of these faces.
    pub fn holds(&self, object: &str, index: FaceIndex) -> bool {
        self.object == object && (self.faces.is_empty() || self.faces.contains(&index))
    }

    /// Returns those of these faces that the model has, in rising order.
    pub fn in_model(&self, model: &Model) -> Vec<FaceId> {
        let Some(object) = model.objects.iter().find(|o| o.name == self.object) else { return Vec::new() };
        if self.faces.is_empty() {
            return object.faces.clone();
        }
        let mut found: Vec<FaceId> = self.faces.iter().filter_map(|index| object.face(*index)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// Formats the faces as `tower` (a whole object) or `tower[0-2, 5]`.
impl fmt::Display for Faces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.object)?;
        if self.faces.is_empty() {
            return Ok(());
        }
        let runs = self.faces.chunk_by(|a, b| a.0.checked_add(1) == Some(b.0));
        let run = |run: &[FaceIndex]| match run {
            [first, .., last] => format!("{first}-{last}"),
            alone => alone[0].to_string(),
        };
        write!(f, "[{}]", runs.map(run).collect::<Vec<_>>().join(", "))
    }
}

/// The user's constraints on one photo's image layers.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LayerConstraints {
    /// Merges. Each is a list of faces whose elements shall share one image layer, as far as the method
    /// allows.
    pub merge: Vec<Vec<Faces>>,
    /// Splits. Each is a list of groups of faces that shall not share an image layer with one another; a
    /// split of one group keeps that group apart from all other faces.
    pub split: Vec<Vec<Vec<Faces>>>,
    /// Faces that keep their image layer however little the photo shows of them, besides those of merges.
    pub keep: Vec<Faces>,
    /// Faces of which the parts of their object may overlap without limit, as in [`super::Options::tolerated`].
    pub tolerate: Vec<Faces>,
}

/// The constraints, resolved to the faces of a model.
#[derive(Debug, Clone, Default)]
pub struct ResolvedConstraints {
    merges: Vec<Vec<FaceId>>,
    splits: Vec<Division<FaceId>>,
    kept: FxHashSet<FaceId>,
    tolerated: FxHashSet<FaceId>,
}

impl ResolvedConstraints {
    /// Resolves constraints to the faces of a model; faces that the model does not have are dropped.
    pub fn new(constraints: &LayerConstraints, model: &Model) -> Self {
        let all = |list: &Vec<Faces>| list.iter().flat_map(|faces| faces.in_model(model)).collect::<Vec<_>>();
        let merges: Vec<Vec<FaceId>> = constraints.merge.iter().map(all).collect();
        let kept = merges.iter().flatten().copied().chain(all(&constraints.keep)).collect();
        let resolve_split = |groups: &Vec<Vec<Faces>>| {
            let numbered = (0u32..).zip(groups);
            let group_of =
                numbered.flat_map(|(number, group)| all(group).into_iter().map(move |f| (f, vec![number])));
            Division { group_of: group_of.collect(), alone: groups.len() == 1 }
        };
        let tolerated = all(&constraints.tolerate).into_iter().collect();
        Self { merges, splits: constraints.split.iter().map(resolve_split).collect(), kept, tolerated }
    }

    /// Returns true for a face whose overlaps with its own object do not matter.
    pub(super) fn tolerates(&self, face: FaceId) -> bool {
        self.tolerated.contains(&face)
    }

    /// Returns true when there is such a face.
    pub(super) fn tolerates_any(&self) -> bool {
        !self.tolerated.is_empty()
    }

    /// Returns true for a face that keeps its image layer however little the photo shows of it.
    pub(super) fn keeps(&self, face: FaceId) -> bool {
        self.kept.contains(&face)
    }

    /// Returns true when a split forbids that two faces share an image layer.
    pub fn apart(&self, a: FaceId, b: FaceId) -> bool {
        self.splits.iter().any(|split| split.separates(&a, &b))
    }

    /// Converts the constraints to elements, each of which is given by its faces.
    pub fn to_elements(&self, faces_of: &[Vec<FaceId>]) -> ElementConstraints {
        let elements = || (0u32..).zip(faces_of);
        let holding = |faces: &Vec<FaceId>| {
            let holds = |of: &Vec<FaceId>| of.iter().any(|face| faces.contains(face));
            elements().filter(|(_, of)| holds(of)).map(|(element, _)| element).collect()
        };
        let resolve_split = |split: &Division<FaceId>| Division {
            group_of: elements()
                .map(|(element, of)| {
                    let mut groups: Vec<u32> = of.iter().map(|face| split.group(face)).collect();
                    groups.sort_unstable();
                    groups.dedup();
                    (element, groups)
                })
                .collect(),
            alone: split.alone,
        };
        ElementConstraints {
            merges: self.merges.iter().map(holding).collect(),
            splits: self.splits.iter().map(resolve_split).collect(),
        }
    }
}

/// The constraints, resolved to one photo's elements.
#[derive(Debug, Clone, Default)]
pub struct ElementConstraints {
    /// Per merge, the elements that hold a face of it, in reading order.
    pub merges: Vec<Vec<u32>>,
    splits: Vec<Division<u32>>,
}

impl ElementConstraints {
    /// Returns true when a split forbids that two elements share an image layer.
    pub fn apart(&self, a: u32, b: u32) -> bool {
        self.splits.iter().any(|split| split.separates(&a, &b))
    }
}

/// The group number of faces or elements that are in no group of a split.
const REST: u32 = u32::MAX;

/// One split: the groups that each face or element belongs to; those not listed belong to [`REST`].
#[derive(Debug, Clone)]
struct Division<T> {
    group_of: FxHashMap<T, Vec<u32>>,
    /// True when [`REST`] shares no image layer with the groups either.
    alone: bool,
}

impl<T: Eq + std::hash::Hash> Division<T> {
    fn groups(&self, key: &T) -> &[u32] {
        self.group_of.get(key).map_or(&[REST], |groups| groups)
    }

    fn group(&self, key: &T) -> u32 {
        self.groups(key)[0]
    }

    fn separates(&self, a: &T, b: &T) -> bool {
        let apart = |a: u32, b: u32| a != b && (self.alone || (a != REST && b != REST));
        self.groups(a).iter().any(|&a| self.groups(b).iter().any(|&b| apart(a, b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::closed_form;

    fn named(object: &str, faces: &[u32]) -> Faces {
        Faces { object: object.into(), faces: faces.iter().copied().map(FaceIndex).collect() }
    }

    #[test]
    fn faces_are_written_as_people_type_them_and_read_as_the_file_has_them() {
        assert_eq!(Faces::whole("tower").to_string(), "tower");
        assert_eq!(named("tower", &[1, 3, 4, 5]).to_string(), "tower[1, 3-5]");
        assert_eq!(serde_json::to_string(&Faces::whole("tower")).unwrap(), r#"{"object":"tower"}"#);
        let read: Faces = serde_json::from_str(r#"{"object":"tower","faces":[3]}"#).unwrap();
        assert!(
            read.holds("tower", FaceIndex(3))
                && !read.holds("tower", FaceIndex(4))
                && !read.holds("gate", FaceIndex(3))
        );
    }

    #[test]
    fn a_group_alone_is_apart_from_all_others_and_groups_are_apart_from_one_another() {
        let model = closed_form::stairs().model;
        let object = |i: usize| Faces::whole(model.objects[i].name.clone());
        let face = |i: usize| model.objects[i].faces[0];
        let split = |groups: Vec<Vec<Faces>>| {
            ResolvedConstraints::new(
                &LayerConstraints { split: vec![groups], ..LayerConstraints::default() },
                &model,
            )
        };
        let alone = split(vec![vec![object(0), object(1)]]);
        assert!(
            !alone.apart(face(0), face(1)) && alone.apart(face(0), face(2)) && !alone.apart(face(2), face(3))
        );
        let two = split(vec![vec![object(0)], vec![object(1)]]);
        assert!(two.apart(face(0), face(1)) && !two.apart(face(0), face(2)) && !two.apart(face(1), face(2)));
        let elements = alone.to_elements(&[vec![face(0)], vec![face(1)], vec![face(1), face(2)]]);
        assert!(
            !elements.apart(0, 1) && elements.apart(0, 2) && elements.apart(1, 2),
            "a mixed element is apart"
        );
    }

    #[test]
    fn what_the_model_does_not_have_is_left_out() {
        let model = closed_form::stairs().model;
        let name = &model.objects[1].name;
        let merge = vec![vec![Faces::whole("gone"), named(name, &[0, 99])]];
        let wanted =
            ResolvedConstraints::new(&LayerConstraints { merge, ..LayerConstraints::default() }, &model);
        let elements: Vec<Vec<FaceId>> = model.objects.iter().map(|object| object.faces.clone()).collect();
        assert_eq!(wanted.to_elements(&elements).merges, [[1]]);
    }
}
