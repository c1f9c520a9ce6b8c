//! The names that image layers were given: which layer has which, whatever became of the stack since.

use std::cmp::Reverse;
use std::collections::BTreeSet;

use crate::document::decisions::LayerName;
use crate::document::{ImageLayer, Stack};

/// What became of the names.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Renamed {
    /// Some layer is called otherwise than before.
    pub changed: bool,
    /// Names that no layer has, each in a sentence.
    pub homeless: Vec<String>,
}

/// By image layer, the place of its name in `names`. Of all pairs of a name and a layer those with most
/// faces in common come first (ties: name, layer); a layer has one name, and a name one layer.
pub fn layers_of_names(stack: &Stack, names: &[LayerName]) -> Vec<Option<usize>> {
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

fn in_common(stack: &Stack, layer: &ImageLayer, name: &LayerName) -> usize {
    let elements = stack.visibility_layers.iter().flatten().zip(0u32..);
    let held = elements.filter(|(_, number)| layer.elements.contains(number));
    let common = |(element, _): (&crate::document::Element, u32)| {
        let named = |face: &&u32| name.of.iter().any(|faces| faces.holds(&element.object, **face));
        element.all_faces().iter().filter(named).count()
    };
    held.map(common).sum()
}

/// Gives the image layers their names: those that were decided, else the ones that they have by themselves, which are
/// numbered where several are the same: `fountain`, `fountain (2)`.
pub fn rename(stack: &mut Stack, names: &[LayerName]) -> Renamed {
    let of_layer = layers_of_names(stack, names);
    let own_names = own_names(stack);
    let mut renamed = Renamed::default();
    for ((layer, name), own) in stack.image_layers.iter_mut().zip(&of_layer).zip(own_names) {
        let given = name.map_or(&own, |name| &names[name].name);
        renamed.changed |= layer.name != *given;
        layer.name = given.clone();
        layer.own_name = (own != layer.name).then_some(own);
    }
    let homeless = (0..names.len()).filter(|name| !of_layer.contains(&Some(*name)));
    renamed.homeless = homeless.map(|name| homeless_in_words(&names[name])).collect();
    renamed
}

/// The names that the image layers have by themselves: that of an object. Of layers with the same name, such as
/// those of an object's parts before and behind another one, the second from the front is called `fountain (2)`, the
/// next `fountain (3)`: the same stack has the same names.
fn own_names(stack: &Stack) -> Vec<String> {
    let layers = stack.image_layers.iter();
    let plain: Vec<String> =
        layers.map(|layer| layer.own_name.as_ref().unwrap_or(&layer.name).clone()).collect();
    let mut taken: BTreeSet<String> = BTreeSet::new();
    let unlike = |name: &String| {
        let numbered = (2..).map(|number| format!("{name} ({number})"));
        // A name that stands there as it is goes before one that is made of another.
        let free = |other: &String| !taken.contains(other) && (other == name || !plain.contains(other));
        let found = std::iter::once(name.clone()).chain(numbered).find(free);
        let found = found.expect("numbers do not end");
        taken.insert(found.clone());
        found
    };
    plain.iter().map(unlike).collect()
}

fn homeless_in_words(name: &LayerName) -> String {
    let of: Vec<String> = name.of.iter().map(ToString::to_string).collect();
    format!("no image layer is named {:?} now, because none contains {}", name.name, of.join(", "))
}
