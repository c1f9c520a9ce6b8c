//! Checks of decisions before they are made.

use crate::linked::is_linkable;
use crate::unsatisfied::{self, TolerableOverlap};
use crate::untextured::{FaceInStack, face_in_stack};
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_base::scene::{FaceId, FaceIndex, Model};
use quadratura_document::{Element, PhotoDecisions, Stack};
use quadratura_layers::Faces;
use quadratura_layers::constraints::{ElementConstraints, ResolvedConstraints};
use quadratura_layers::occlusion_graph::OcclusionGraph;
use quadratura_layers::together::{Obstacle, Unsatisfied, bring_together};
use quadratura_sites::unknown_name::no_such;

/// Checks that objects and faces exist.
///
/// # Errors
/// Returns [`Error::Request`] for all objects and faces that the model does not have.
pub fn refuse_unknown(of: &[Faces], model: &Model) -> Result<()> {
    let problem = |faces: &Faces| {
        if faces.object == SURROUNDINGS && faces.faces.is_empty() {
            return None;
        }
        let Some(object) = model.objects.iter().find(|object| object.name == faces.object) else {
            let known = model.objects.iter().map(|object| object.name.as_str());
            return Some(no_such("object", &faces.object, known, Some(Remedy::ListObjects)));
        };
        let missing = faces.faces.iter().find(|index| object.face(**index).is_none())?;
        let count = object.faces.len();
        let found =
            format!("{:?} has {count} faces, numbered from 0; there is no face {missing}", object.name);
        Some(Error::Request(found))
    };
    let errors = of.iter().filter_map(problem).collect();
    Error::of_all(errors).map_or(Ok(()), Err)
}

/// Checks that the given faces are not the surroundings, of which nothing but their name can be decided.
///
/// # Errors
/// Returns [`Error::Request`] for the surroundings.
pub fn refuse_surroundings(of: &[Faces]) -> Result<()> {
    match of.iter().any(|faces| faces.object == SURROUNDINGS) {
        false => Ok(()),
        true => Err(Error::Request(
            "the surroundings lie behind everything, in an image layer of their own; they can be renamed and painted \
             on, and nothing else can be decided about them"
                .into(),
        )),
    }
}

/// Checks that a photo textures the given faces.
///
/// # Errors
/// Returns [`Error::Request`] for everything of which the photo's stack, if it has one, contains nothing.
pub fn refuse_unseen(of: &[Faces], photo: &str, stack: Option<&Stack>) -> Result<()> {
    let Some(stack) = stack else { return Ok(()) };
    let elements: Vec<&Element> = stack.visibility_layers.iter().flatten().collect();
    let unseen = of.iter().filter(|faces| !elements.iter().any(|element| unsatisfied::holds(element, faces)));
    let problem = |faces: &Faces| {
        let first = faces.faces.first().copied().unwrap_or(FaceIndex(0));
        let why = match face_in_stack(stack, &faces.object, first) {
            FaceInStack::Untextured(why) => format!(": {}", why.in_words()),
            FaceInStack::Textured { .. } | FaceInStack::Unknown => String::new(),
        };
        Error::Request(format!("{photo} does not texture {faces}{why}"))
    };
    Error::of_all(unseen.map(problem).collect()).map_or(Ok(()), Err)
}

/// Checks the last merge, together with all earlier decisions.
///
/// # Errors
/// Returns [`Error::Request`] when the merge changes nothing, or when an element of another object cannot join it, with
/// the reason and what can be done.
pub fn refuse_merge(decided: &PhotoDecisions, stack: &Stack, model: &Model) -> Result<()> {
    let judge = MergeJudge::new(decided, stack, model);
    let last = decided.merge.len() - 1;
    let title = format!("merge of {}", unsatisfied::list(&decided.merge[last]));
    if judge.grouping.merges[last].len() < 2 {
        let found = format!("{title}: it is one part of one object in {}", stack.photo.name);
        return Err(Error::Request(format!("{found}; name something else to merge it with")));
    }
    let MergeJudge { elements, order, .. } = &judge;
    let left_out = judge.unsatisfied(&judge.grouping.merges);
    let refused = unsatisfied::of_merge(&decided.merge[last], last as u32, &left_out, elements);
    // Parts of one object that cannot share a layer are linked instead.
    match refused.iter().find(|u| !is_linkable(&decided.merge[last], u.why)) {
        None => Ok(()),
        Some(first) => {
            let why = unsatisfied::in_words(first, order, elements);
            let remedy = remedy(first, order, elements);
            Err(Error::Request(format!("{title}: in {}, {why}; {remedy}", stack.photo.name)))
        }
    }
}

/// Returns the remedy for a merge that fails.
fn remedy(refused: &Unsatisfied, order: &OcclusionGraph, elements: &[Element]) -> String {
    if let Some(TolerableOverlap { object, px }) = unsatisfied::tolerable(refused, order, elements) {
        return format!(
            "leave it so; or merge {object} alone and tolerate that ({px} pixels of its farther part are then textured \
             from other photos), update the stack, and then merge it with the rest"
        );
    }
    match refused.why {
        Obstacle::Occluded => "leave one of them out, because surfaces that hide each other stay separate",
        Obstacle::Forgiven => "try a larger tolerance, or leave one of them out",
        Obstacle::SeeThrough => {
            "leave one of them out, or declare the see-through object solid (`--no-see-through`)"
        }
        Obstacle::Split => "remove that split first",
        Obstacle::TooLarge => "raise `largest_side` in the project's options",
    }
    .to_owned()
}

/// What decides whether elements of a stack can share an image layer.
pub struct MergeJudge {
    elements: Vec<Element>,
    order: OcclusionGraph,
    /// Pairs of elements that may not share an image layer: forgiven and unresolved occlusions.
    against: Vec<(u32, u32, u32)>,
    grouping: ElementConstraints,
}

impl MergeJudge {
    /// Prepares the judgement of merges in a stack, beside the decided ones.
    pub fn new(decided: &PhotoDecisions, stack: &Stack, model: &Model) -> Self {
        let elements: Vec<Element> = stack.visibility_layers.iter().flatten().cloned().collect();
        let grouping = grouping(decided, &elements, model);
        let supports = |list: &[quadratura_document::stack::Support]| {
            list.iter().map(|s| (s.front.0, s.back.0, s.px)).collect::<Vec<_>>()
        };
        let order = OcclusionGraph::new(elements.len() as u32, supports(&stack.occlusions));
        let mut against = supports(&stack.forgiven);
        against.extend(supports(&stack.unresolved));
        Self { elements, order, against, grouping }
    }

    /// Returns what keeps elements out of these merges, which are lists of elements.
    fn unsatisfied(&self, merges: &[Vec<u32>]) -> Vec<Unsatisfied> {
        let obstacle =
            |joining: &[u32], group: &[u32]| obstacle(joining, group, &self.against, &self.grouping);
        bring_together(&self.order, merges, obstacle).unsatisfied
    }

    /// Returns whether all of these elements can share an image layer, beside the decided merges.
    pub fn allows(&self, elements: &[u32]) -> bool {
        let mut merges = self.grouping.merges.clone();
        let last = merges.len() as u32;
        merges.push(elements.to_vec());
        self.unsatisfied(&merges).iter().all(|left_out| left_out.merge != last)
    }
}

/// Returns what keeps elements apart from a group, with the member of the group that does.
fn obstacle(
    joining: &[u32],
    group: &[u32],
    against: &[(u32, u32, u32)],
    grouping: &ElementConstraints,
) -> Option<(u32, Obstacle)> {
    let forgiven = |a: u32, b: u32| against.iter().any(|&(f, k, _)| (f, k) == (a, b) || (f, k) == (b, a));
    let find = |keeps: &dyn Fn(u32, u32) -> bool, why| {
        let kept = group.iter().find(|&&member| joining.iter().any(|&j| keeps(j, member)));
        kept.map(|&member| (member, why))
    };
    find(&forgiven, Obstacle::Forgiven).or_else(|| find(&|a, b| grouping.apart(a, b), Obstacle::Split))
}

/// Resolves merges and splits to elements.
fn grouping(decided: &PhotoDecisions, elements: &[Element], model: &Model) -> ElementConstraints {
    let faces_of: Vec<Vec<FaceId>> = elements
        .iter()
        .map(|e| Faces { object: e.object.clone(), faces: e.all_faces() }.in_model(model))
        .collect();
    ResolvedConstraints::new(&decided.constraints(), model).to_elements(&faces_of)
}

/// Checks the last split.
///
/// # Errors
/// Returns [`Error::Request`] when a merge contains faces that it separates.
pub fn refuse_split(decided: &PhotoDecisions, model: &Model) -> Result<()> {
    let last = decided.split.len() - 1;
    let split = quadratura_layers::LayerConstraints {
        split: vec![decided.split[last].clone()],
        ..Default::default()
    };
    let wanted = ResolvedConstraints::new(&split, model);
    let faces_of = |merge: &[Faces]| merge.iter().flat_map(|f| f.in_model(model)).collect::<Vec<FaceId>>();
    let torn = |merge: &&Vec<Faces>| {
        let faces = faces_of(merge);
        faces.iter().any(|a| faces.iter().any(|b| wanted.apart(*a, *b)))
    };
    match decided.merge.iter().find(torn) {
        None => Ok(()),
        Some(merge) => Err(Error::Request(format!(
            "{}: the merge of {} contains both sides; remove it first",
            unsatisfied::title_of_split(&decided.split[last]),
            unsatisfied::list(merge)
        ))),
    }
}
