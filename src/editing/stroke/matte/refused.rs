//! Why a stroke of the matte brush has nothing to change: each cause by itself, with what to do.

use quadratura_base::error::{Error, Remedy};
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::scene::Site;
use quadratura_document::stack::ImageLayer;
use quadratura_document::stroke::Stroke;
use quadratura_document::{Project, Stack};

/// The number of layers or objects that an error lists.
const LISTED: usize = 3;

/// Returns the error for a stroke that no layer with a matte is under. `under` are the pixels of the photo under it.
pub fn nothing_under(stroke: &Stroke, under: &Spans, stack: &Stack, project: &Project, site: &Site) -> Error {
    let photo = &stack.photo;
    if under.is_empty() {
        return Error::Request(format!(
            "the stroke of the matte brush is outside of {}, which has {} x {} pixels; draw it within the photo",
            photo.name, photo.width, photo.height
        ));
    }
    match &stroke.layer {
        Some(token) => of_layer(token, stack, project),
        None => of_any(stack, project, site),
    }
}

/// Explains why the layer that a stroke names is not changed.
fn of_layer(token: &str, stack: &Stack, project: &Project) -> Error {
    let photo = &stack.photo.name;
    let Some(index) = stack.layer_with_token(token) else {
        let found =
            format!("{photo} has no image layer [{token}], which the stroke of the matte brush names; ");
        return Error::missing((found, Remedy::List, " lists its layers"));
    };
    let layer = stack.layer(index);
    let named = format!("{} [{token}]", layer.name);
    if !is_see_through(stack, layer) {
        return Error::Request(format!(
            "the image layer {named} of {photo} is solid, so it has no matte; to see through {}, declare it see-through \
             (`decide --see-through`), and fill again",
            some(objects(stack, layer))
        ));
    }
    match has_matte(layer) {
        false => without_mattes(stack, &[layer], project),
        true => Error::Request(format!(
            "the stroke of the matte brush is beside the image layer {named} of {photo}, which {}; draw it there, or select \
             another layer",
            extent(layer)
        )),
    }
}

/// Explains why no layer of a photo is changed by a stroke that names none.
fn of_any(stack: &Stack, project: &Project, site: &Site) -> Error {
    let photo = &stack.photo.name;
    let layers: Vec<&ImageLayer> =
        stack.image_layers.iter().filter(|layer| is_see_through(stack, layer)).collect();
    let model = &site.model;
    if layers.is_empty() && !model.has_see_through() {
        return Error::Request(
            "no object of the model is see-through, so that there are no mattes to paint on; billboards that turn are, and \
             what is declared so (`decide --see-through NAME`)"
                .into(),
        );
    }
    if layers.is_empty() {
        let see_through = model.objects.iter().filter(|object| object.see_through);
        return Error::Request(format!(
            "{photo} has no image layer of a see-through object, such as {}; paint in a photo that shows one, or update the \
             project if it was declared see-through since the photo was built",
            some(see_through.map(|object| object.name.as_str()).collect())
        ));
    }
    let with: Vec<&ImageLayer> = layers.iter().copied().filter(|layer| has_matte(layer)).collect();
    if with.is_empty() {
        return without_mattes(stack, &layers, project);
    }
    let places: Vec<String> = with
        .iter()
        .take(LISTED)
        .map(|layer| format!("{} [{}] {}", layer.name, layer.id, extent(layer)))
        .collect();
    let more = match with.len().saturating_sub(LISTED) {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    Error::Request(format!(
        "under the stroke of the matte brush {photo} shows no see-through object with a matte; draw it over one of them: {}{more}",
        places.join(", ")
    ))
}

/// Explains why see-through layers of a photo have no mattes.
fn without_mattes(stack: &Stack, layers: &[&ImageLayer], project: &Project) -> Error {
    let photo = &stack.photo.name;
    let names = some(layers.iter().flat_map(|layer| objects(stack, layer)).collect());
    if stack.fill.is_none() {
        let found = format!(
            "{names} in {photo} has no matte yet, because the hidden parts of the photo are not filled; "
        );
        return Error::missing((found, Remedy::Fill, " fills them"));
    }
    if project.fill.no_mattes {
        return Error::Request(format!(
            "{names} in {photo} has no matte, because the project's options leave see-through objects solid (`no_mattes`); \
             `fill --mattes --save-options` changes that"
        ));
    }
    Error::Request(format!(
        "{names} in {photo} has no matte, although the photo is filled: it was filled without mattes, or they could not be \
         found; `matte` says what is known of them, and `fill --force` fills the photo again"
    ))
}

fn has_matte(layer: &ImageLayer) -> bool {
    layer.fill.as_ref().is_some_and(|fill| fill.matte_file.is_some())
}

fn is_see_through(stack: &Stack, layer: &ImageLayer) -> bool {
    let mut held = stack.numbered_elements().filter(|(index, _)| layer.elements.contains(index));
    held.any(|(_, element)| element.sees_through())
}

/// Returns the names of the objects in a layer.
fn objects<'a>(stack: &'a Stack, layer: &ImageLayer) -> Vec<&'a str> {
    let held = stack.numbered_elements().filter(|(index, _)| layer.elements.contains(index));
    held.map(|(_, element)| element.object.as_str()).collect()
}

/// Returns some names in one phrase, each once.
fn some(mut names: Vec<&str>) -> String {
    names.sort_unstable();
    names.dedup();
    let shown = names[..names.len().min(LISTED)].join(", ");
    match names.len().saturating_sub(LISTED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Returns where a layer is, as the end of a sentence.
fn extent(layer: &ImageLayer) -> String {
    let PixelRect { x, y, .. } = layer.needed_rect;
    let (right, bottom) = (layer.needed_rect.right() - 1, layer.needed_rect.bottom() - 1);
    format!("is in columns {x} to {right} and rows {y} to {bottom}")
}
