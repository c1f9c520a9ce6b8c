//! Faces by the names that are typed for them.

use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_base::scene::{FaceIndex, Model};
use quadratura_document::Stack;
use quadratura_layers::{Faces, LayerIndex};
use quadratura_sites::unknown_name::no_such;

/// Returns the faces that `typed` refers to: the token of an image layer of the stack, an object, or faces of one
/// as `OBJECT[3, 5-8]`.
///
/// # Errors
/// Returns [`Error::Request`] when it is none of these.
pub fn faces_named(model: &Model, stack: Option<&Stack>, typed: &str) -> Result<Vec<Faces>> {
    let object_called = |name: &str| model.object_like(name).map(|object| model.object(object).name.as_str());
    // Objects take precedence, whatever their names.
    if let Some(object) = object_called(typed).or((typed == SURROUNDINGS).then_some(typed)) {
        return Ok(vec![Faces::whole(object)]);
    }
    let layer = stack.and_then(|stack| Some(faces_of_layer(stack, stack.layer_with_token(typed)?)));
    if let Some(faces) = layer {
        return Ok(faces);
    }
    let unknown = || {
        let object = typed.split_once('[').map_or(typed, |(object, _)| object);
        if object_called(object).is_some() {
            return Error::Request(format!("{typed:?} is no list of faces; write OBJECT[3, 5-8]"));
        }
        let known = model.objects.iter().map(|object| object.name.as_str());
        let tokens = stack.iter().flat_map(|stack| &stack.image_layers).map(|layer| layer.id.as_str());
        no_such("object or image layer", object, known.chain(tokens), Some(Remedy::List))
    };
    let (object, rest) = typed.rsplit_once('[').ok_or_else(unknown)?;
    let faces = rest.strip_suffix(']').and_then(indices).zip(object_called(object));
    let (faces, object) = faces.ok_or_else(unknown)?;
    Ok(vec![Faces { object: object.to_owned(), faces }])
}

/// Parses indices such as `3, 5-8`; an index has to be below a million.
fn indices(text: &str) -> Option<Vec<FaceIndex>> {
    const MOST: u32 = 1_000_000;
    let mut all = Vec::new();
    for part in text.split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (first, last): (u32, u32) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
        if first > last || last >= MOST {
            return None;
        }
        all.extend((first..=last).map(FaceIndex));
    }
    all.sort_unstable();
    all.dedup();
    Some(all)
}

/// Returns the faces in an image layer, one entry per object; nothing where the stack has no such layer.
pub fn faces_of_layer(stack: &Stack, layer: LayerIndex) -> Vec<Faces> {
    let Some(layer) = stack.image_layers.get(layer.index()) else { return Vec::new() };
    let held = stack.numbered_elements().filter(|(index, _)| layer.elements.contains(index));
    super::united(held.map(|(_, element)| element.known_by()).collect())
}
