//! User-defined names of image layers, and the layers to which they belong after a stack was rebuilt.

use std::cmp::Reverse;
use std::collections::BTreeSet;

use quadratura_base::scene::FaceIndex;
use quadratura_document::decisions::LayerNaming;
use quadratura_document::{ImageLayer, Stack};
use quadratura_layers::ElementIndex;

/// The result of renaming a stack's layers.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Renamed {
    /// Whether a layer's name changed.
    pub changed: bool,
    /// The names for which no layer was found, each in a sentence.
    pub unmatched: Vec<String>,
}

/// Returns, for each image layer, the index of its name in `names`. Pairs of a name and a layer are matched
/// greedily, those with most faces in common first (ties: name, layer); each layer gets at most one name, and each
/// name at most one layer.
pub fn layers_of_names(stack: &Stack, names: &[LayerNaming]) -> Vec<Option<usize>> {
    let layers = || stack.image_layers.iter().enumerate();
    let mut pairs: Vec<(Reverse<usize>, usize, usize)> = names
        .iter()
        .enumerate()
        .flat_map(|(at, name)| {
            layers().map(move |(l, layer)| (Reverse(in_common(stack, layer, name)), at, l))
        })
        .filter(|(common, ..)| common.0 > 0)
        .collect();
    pairs.sort_unstable();
    let mut of_layer = vec![None; stack.image_layers.len()];
    for (_, name, layer) in pairs {
        if of_layer[layer].is_none() && !of_layer.contains(&Some(name)) {
            of_layer[layer] = Some(name);
        }
    }
    of_layer
}

/// Returns the number of faces that a layer and a name have in common.
fn in_common(stack: &Stack, layer: &ImageLayer, name: &LayerNaming) -> usize {
    let held = stack.numbered_elements().filter(|(index, _)| layer.elements.contains(index));
    // The surroundings have no faces, and are one layer as a whole.
    let is_named = |element: &quadratura_document::Element| {
        element.is_surroundings() && name.of.iter().any(|faces| faces.object == element.object)
    };
    let common = |(_, element): (ElementIndex, &quadratura_document::Element)| {
        let named = |face: &&FaceIndex| name.of.iter().any(|faces| faces.holds(&element.object, **face));
        element.all_faces().iter().filter(named).count() + usize::from(is_named(element))
    };
    held.map(common).sum()
}

/// Names the image layers: as decided, or else with their automatic names. Equal names are numbered: `fountain`,
/// `fountain (2)`.
pub fn rename(stack: &mut Stack, names: &[LayerNaming]) -> Renamed {
    let of_layer = layers_of_names(stack, names);
    let own_names = own_names(stack);
    let mut renamed = Renamed::default();
    for ((layer, name), own) in stack.image_layers.iter_mut().zip(&of_layer).zip(own_names) {
        let given = name.map_or(&own, |name| &names[name].name);
        renamed.changed |= layer.name != *given;
        layer.name = given.clone();
        layer.own_name = (own != layer.name).then_some(own);
    }
    let unmatched = (0..names.len()).filter(|name| !of_layer.contains(&Some(*name)));
    renamed.unmatched = unmatched.map(|name| unmatched_message(&names[name])).collect();
    renamed
}

/// Returns the automatic names of the image layers, which are names of objects. Of layers with the same name, such
/// as those of an object's parts before and behind another one, the second from the front becomes `fountain (2)`,
/// the next `fountain (3)`. The same stack always gets the same names.
fn own_names(stack: &Stack) -> Vec<String> {
    let layers = stack.image_layers.iter();
    let plain: Vec<String> =
        layers.map(|layer| layer.own_name.as_ref().unwrap_or(&layer.name).clone()).collect();
    let mut taken: BTreeSet<String> = BTreeSet::new();
    let unlike = |name: &String| {
        let numbered = (2..).map(|number| format!("{name} ({number})"));
        // An unchanged name takes precedence over one that was numbered.
        let free = |other: &String| !taken.contains(other) && (other == name || !plain.contains(other));
        let found = std::iter::once(name.clone()).chain(numbered).find(free);
        let found = found.expect("numbers do not end");
        taken.insert(found.clone());
        found
    };
    plain.iter().map(unlike).collect()
}

/// Writes the message for a name without a layer.
fn unmatched_message(name: &LayerNaming) -> String {
    let of: Vec<String> = name.of.iter().map(ToString::to_string).collect();
    format!("no image layer is named {:?} now, because none contains {}", name.name, of.join(", "))
}
