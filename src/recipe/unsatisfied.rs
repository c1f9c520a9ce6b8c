//! Messages about merges and splits that a stack could not satisfy.

use super::linked::is_linkable;
use crate::document::Element;
use crate::layers::graph::Graph;
use crate::layers::together::{Obstacle, Unsatisfied};
use crate::layers::{Faces, LayerConstraints, Sorted};
use crate::scene::FaceIndex;

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
    element.all_faces().iter().any(|face| faces.holds(&element.object, *face))
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

/// Returns the message why an element stays out of a merge; `order` is the graph of occlusions between elements.
pub fn in_words(unsatisfied: &Unsatisfied, order: &Graph, elements: &[Element]) -> String {
    let name = |element: u32| elements[element as usize].known_by().to_string();
    let (item, with) = (name(unsatisfied.item), name(unsatisfied.with));
    let why = match unsatisfied.why {
        Obstacle::Occluded => {
            let path = order
                .shortest_path(unsatisfied.item, unsatisfied.with)
                .or_else(|| order.shortest_path(unsatisfied.with, unsatisfied.item));
            match path {
                Some(path) => {
                    let names: Vec<String> = path.into_iter().map(name).collect();
                    // Only the second name is hidden by the subject of the sentence.
                    names.join(", which occludes a part of ").replacen(", which occludes", " occludes", 1)
                }
                None => format!("another merge joins it with something in front of or behind {with}"),
            }
        }
        Obstacle::Forgiven => format!("it and {with} each occlude a few pixels of the other"),
        Obstacle::Split => format!("a split keeps it separate from {with}"),
        Obstacle::TooLarge => {
            format!("a rectangle around it and {with} exceeds `largest_side`")
        }
    };
    format!("{item} stays separate: {why}")
}
