//! Messages about merges and splits that a stack could not satisfy.

use crate::linked::is_linkable;
use quadratura_base::scene::FaceIndex;
use quadratura_document::Element;
use quadratura_layers::occlusion_graph::OcclusionGraph;
use quadratura_layers::together::{Obstacle, Unsatisfied};
use quadratura_layers::{Faces, LayerConstraints, Sorted};

/// Returns a message for each merge or split that the stack of these elements does not satisfy, with the reason.
pub fn unsatisfied(constraints: &LayerConstraints, sorted: &Sorted, elements: &[Element]) -> Vec<String> {
    let mut messages = Vec::new();
    for (number, merge) in (0u32..).zip(&constraints.merge) {
        let title = format!("merge of {}", list(merge));
        messages.extend(missing(merge, elements).map(|faces| format!("{title}: {}", no_texture(faces))));
        let order = &sorted.layers.occlusions;
        let of_merge = of_merge(merge, number, &sorted.clusters.unsatisfied, elements);
        // Layers that are linked instead are as the user decided.
        let not_linked = of_merge.iter().filter(|u| !is_linkable(merge, u.why));
        messages.extend(not_linked.map(|u| format!("{title}: {}", in_words(u, order, elements))));
    }
    for split in &constraints.split {
        let title = title_of_split(split);
        let all: Vec<Faces> = split.iter().flatten().cloned().collect();
        messages.extend(missing(&all, elements).map(|faces| format!("{title}: {}", no_texture(faces))));
    }
    messages
}

/// Returns the title of a split: `split of tower from gate, tree`, or `split of tower from all else`.
pub fn title_of_split(groups: &[Vec<Faces>]) -> String {
    match groups {
        [alone] => format!("split of {} from all else", list(alone)),
        groups => format!("split of {}", groups.iter().map(|g| list(g)).collect::<Vec<_>>().join(" from ")),
    }
}

/// Returns a list of faces for messages: `tower, gate[2]`.
pub fn list(faces: &[Faces]) -> String {
    faces.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// Writes the message for faces that this photo does not texture.
fn no_texture(faces: &Faces) -> String {
    format!("{faces} is not textured by this photo now; the decision applies again when it is")
}

/// Returns the items of the list of which no element contains a face.
fn missing<'a>(list: &'a [Faces], elements: &'a [Element]) -> impl Iterator<Item = &'a Faces> {
    list.iter().filter(|faces| !elements.iter().any(|element| holds(element, faces)))
}

/// Returns true when the element contains one of these faces.
pub fn holds(element: &Element, faces: &Faces) -> bool {
    let is_named = element.is_surroundings() && faces.object == element.object;
    is_named || element.all_faces().iter().any(|face| faces.holds(&element.object, *face))
}

/// Returns the unsatisfied parts of the merge with this number.
pub fn of_merge<'a>(
    merge: &[Faces],
    number: u32,
    unsatisfied: &'a [Unsatisfied],
    elements: &[Element],
) -> Vec<&'a Unsatisfied> {
    let of_merge: Vec<&Unsatisfied> = unsatisfied.iter().filter(|u| u.merge == number).collect();
    let stays = |u: &&Unsatisfied| !is_met_otherwise(merge, u.item, &of_merge, elements);
    of_merge.iter().copied().filter(stays).collect()
}

/// Returns true when the merge contains another element with the same faces. The pieces of a cut face may be in
/// several elements; one of them in the merge is enough.
fn is_met_otherwise(merge: &[Faces], item: u32, unsatisfied: &[&Unsatisfied], elements: &[Element]) -> bool {
    let element = &elements[item as usize];
    let joined = |other: &Element, number: u32| {
        number != item && other.object == element.object && !unsatisfied.iter().any(|u| u.item == number)
    };
    let asked = |face: &FaceIndex| merge.iter().any(|faces| faces.holds(&element.object, *face));
    element.all_faces().iter().filter(|face| asked(face)).all(|face| {
        let others = elements.iter().zip(0u32..).filter(|(other, number)| joined(other, *number));
        others.into_iter().any(|(other, _)| other.all_faces().contains(face))
    })
}

/// Returns the sentence why an element stays out of a merge; `order` is the graph of occlusions between elements.
pub fn in_words(unsatisfied: &Unsatisfied, order: &OcclusionGraph, elements: &[Element]) -> String {
    let name = |element: u32| elements[element as usize].known_by().to_string();
    let (item, with) = (name(unsatisfied.item), name(unsatisfied.with));
    let both = if item == with { format!("two pieces of {item}") } else { format!("{item} and {with}") };
    match unsatisfied.why {
        Obstacle::Occluded => match path_between(unsatisfied, order) {
            Some(path) => {
                let steps: Vec<String> =
                    path.windows(2).map(|step| in_front(step, order, elements)).collect();
                format!("{}, so one image layer cannot hold {both}", steps.join(", and "))
            }
            None => format!(
                "another merge puts {item} or {with} into one image layer with something that lies between them in \
                 depth, so one image layer cannot hold {both}"
            ),
        },
        Obstacle::Forgiven => {
            format!(
                "{both} each lie in front of the other at a few pixels, so one image layer cannot hold both"
            )
        }
        Obstacle::SeeThrough => format!(
            "one sees through only one of {both}, and the alpha of an image layer is the matte of all that it holds"
        ),
        Obstacle::Split => format!("a split keeps {both} in separate image layers"),
        Obstacle::TooLarge => {
            format!("the rectangle of an image layer with {both} would exceed `largest_side`")
        }
    }
}

/// Returns the elements from the nearer of the two to the farther, each in front of the next; `None` where only earlier
/// merges connect them.
fn path_between(unsatisfied: &Unsatisfied, order: &OcclusionGraph) -> Option<Vec<u32>> {
    let Unsatisfied { item, with, .. } = *unsatisfied;
    order.shortest_path(item, with).or_else(|| order.shortest_path(with, item))
}

/// Returns the clause about one element in front of another: `box[0] lies in front of a part of wall[0] (12 pixels)`.
fn in_front(step: &[u32], order: &OcclusionGraph, elements: &[Element]) -> String {
    let [front, back] = [step[0], step[1]].map(|element| elements[element as usize].known_by().to_string());
    let px = support(order, step[0], step[1]);
    match front == back {
        true => format!("a piece of {front} lies in front of another piece of it ({px} pixels)"),
        false => format!("{front} lies in front of a part of {back} ({px} pixels)"),
    }
}

fn support(order: &OcclusionGraph, front: u32, back: u32) -> u32 {
    order.edges_of(front).iter().find(|edge| edge.1 == back).map_or(0, |edge| edge.2)
}

/// An overlap of two parts of one object that can be tolerated, and its price.
pub struct TolerableOverlap {
    /// The object.
    pub object: String,
    /// The number of pixels at which the photo would no longer texture the farther part.
    pub px: u32,
}

/// Returns the overlap that keeps an element out of a merge where it can be tolerated: it occludes another part of its
/// own object, or is occluded by it, with nothing else between.
pub fn tolerable(
    unsatisfied: &Unsatisfied,
    order: &OcclusionGraph,
    elements: &[Element],
) -> Option<TolerableOverlap> {
    let Unsatisfied { item, with, .. } = *unsatisfied;
    let path = path_between(unsatisfied, order).filter(|_| unsatisfied.why == Obstacle::Occluded)?;
    let [object, other] = [item, with].map(|element| &elements[element as usize].object);
    let px = support(order, item, with) + support(order, with, item);
    (path.len() == 2 && object == other).then(|| TolerableOverlap { object: object.clone(), px })
}
