//! Conversion of the visibility sort's result to the contents of `stack.json`.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use crate::linked::{LinkedLayers, linked_layers, name_in_layer};
use crate::unsatisfied::unsatisfied;
use crate::untextured;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_base::scene::{FaceId, Model, ObjectId, Photo};
use quadratura_document::FilesInUse;
use quadratura_document::stack::{
    Element, FacePiece, ImageLayer, STACK_VERSION, Stack, StackCamera, StackCounts, StackPhoto, StackSurface,
    Support, ToleratedOverlap,
};
use quadratura_layers::ElementIndex;
use quadratura_layers::cluster::Cluster;
use quadratura_layers::content::Content;
use quadratura_layers::nodes::GraphNode;
use quadratura_layers::pieces::{NodePieces, outline, pieces_of_nodes};
use quadratura_layers::surroundings::{Surroundings, SurroundingsLayer};
use quadratura_layers::{Faces, LayerConstraints, Method, Options, Sorted};
use quadratura_projection::frustum::uv_from_world;

/// Assembles the stack of a photo. `inputs` is the hash of everything it was made from. The layers have their
/// automatic names, and `bytes` is still 0.
pub fn assemble(
    model: &Model,
    photo: &Photo,
    sorted: &Sorted,
    options: &Options,
    constraints: &LayerConstraints,
    inputs: &str,
) -> Stack {
    let pieces = pieces_of_nodes(model, &sorted.view, &sorted.nodes, &sorted.layers.tolerated, &photo.pose);
    let elements = elements(model, sorted, &pieces);
    let linked = linked_layers(constraints, sorted, &elements);
    let image_layers = image_layers(model, photo, sorted, &elements, &linked);
    let token = |layer: &usize| image_layers[*layer].id.clone();
    let linked = linked.iter().map(|linked| linked.layers.iter().map(token).collect()).collect();
    let (unresolved, forgiven): (Vec<_>, Vec<_>) =
        sorted.layers.against.iter().partition(|against| against.2 > options.min_support);
    let stencil = options.method == Method::Stencil;
    Stack {
        version: STACK_VERSION,
        method: options.method,
        inputs: inputs.to_owned(),
        photo: StackPhoto {
            name: photo.name.clone(),
            width: photo.camera.width,
            height: photo.camera.height,
        },
        camera: camera(&photo.camera, &photo.pose),
        surfaces: surfaces(model, sorted),
        pieces: piece_list(model, sorted, &pieces),
        occlusions: supports(&sorted.layers.occlusions.edges),
        forgiven: if stencil { Vec::new() } else { supports(&forgiven) },
        unresolved: if stencil { Vec::new() } else { supports(&unresolved) },
        texels: image_layers.iter().map(|l| l.rect.area()).sum(),
        texels_used: image_layers.iter().map(|l| l.texels_used).sum(),
        texels_unmerged: sorted.texels_unmerged,
        bytes: 0,
        fill: None,
        untextured: untextured::of_sort(model, sorted).into(),
        notes: notes(model, sorted, options),
        unsatisfied: unsatisfied(constraints, sorted, &elements),
        counts: counts(sorted, options),
        in_use: FilesInUse::default(),
        leftovers: sorted.leftovers.spans.iter().map(|span| [span.y, span.x0, span.x1]).collect(),
        surroundings_left_over: false,
        spared: spared(model, sorted),
        tolerated: tolerated(model, sorted),
        linked,
        image_layers,
        visibility_layers: by_layer(sorted, elements),
    }
}

/// Lists the faces that keep their image layers although the photo barely shows them, one face each.
fn spared(model: &Model, sorted: &Sorted) -> Vec<Faces> {
    let face = |id: &FaceId| {
        let face = model.face(*id);
        Faces { object: model.object(face.object).name.clone(), faces: vec![face.index] }
    };
    sorted.leftovers.spared.iter().map(face).collect()
}

/// Converts the overlaps that were tolerated, one for each pair of faces.
fn tolerated(model: &Model, sorted: &Sorted) -> Vec<ToleratedOverlap> {
    let face = |node: u32| sorted.view.items[sorted.nodes.list[node as usize].item as usize].face;
    let mut px: BTreeMap<(FaceId, FaceId), u64> = BTreeMap::new();
    for overlap in &sorted.layers.tolerated {
        *px.entry((face(overlap.back), face(overlap.front))).or_default() += u64::from(overlap.px);
    }
    let overlap = |((back, front), px): ((FaceId, FaceId), u64)| {
        let (back, front) = (model.face(back), model.face(front));
        let object = model.object(back.object).name.clone();
        ToleratedOverlap { object, face: back.index, by: front.index, px }
    };
    px.into_iter().map(overlap).collect()
}

/// Converts camera and pose to their form in `stack.json`.
fn camera(camera: &Pinhole, pose: &Pose) -> StackCamera {
    StackCamera { K: camera.matrix_rows(), R: pose.rotation_rows(), t: pose.translation.to_array() }
}

/// Converts the elements, in the sort's order.
fn elements(model: &Model, sorted: &Sorted, pieces: &[Option<NodePieces>]) -> Vec<Element> {
    sorted
        .layers
        .elements
        .iter()
        .map(|e| {
            let object = model.object(e.object);
            let impostor = object.impostor.is_some();
            let mut element = Element {
                object: object.name.clone(),
                faces: Vec::new(),
                pieces: Vec::new(),
                back: Vec::new(),
                leftovers: Vec::new(),
                leftover_pieces: Vec::new(),
                impostor,
                see_through: (object.see_through != impostor).then_some(object.see_through),
            };
            for node in &e.nodes {
                let item = &sorted.view.items[sorted.nodes.list[node.0 as usize].item as usize];
                let face = model.face(item.face).index;
                let (faces, face_pieces) = match sorted.leftovers.nodes[node.0 as usize] {
                    false => (&mut element.faces, &mut element.pieces),
                    true => (&mut element.leftovers, &mut element.leftover_pieces),
                };
                match &pieces[node.0 as usize] {
                    None => faces.push(face),
                    Some(p) => face_pieces.extend((0..p.rings.len() as u32).map(|r| (face, p.first + r))),
                }
                if item.back {
                    element.back.push(face);
                }
            }
            element.faces.sort_unstable();
            element.pieces.sort_unstable();
            element.leftovers.sort_unstable();
            element.leftover_pieces.sort_unstable();
            element.back.sort_unstable();
            element.back.dedup();
            element
        })
        .collect()
}

/// Groups the elements by visibility layer.
fn by_layer(sorted: &Sorted, elements: Vec<Element>) -> Vec<Vec<Element>> {
    let mut layers = vec![Vec::new(); sorted.layers.count() as usize];
    for (sorted, element) in sorted.layers.elements.iter().zip(elements) {
        layers[sorted.visibility_layer as usize].push(element);
    }
    layers
}

/// Converts the surfaces of the working set, in the model's order.
fn surfaces(model: &Model, sorted: &Sorted) -> Vec<StackSurface> {
    let mut items: Vec<u32> = sorted.nodes.list.iter().map(|node| node.item).collect();
    items.sort_unstable();
    items.dedup();
    let surface = |index: u32| {
        let item = &sorted.view.items[index as usize];
        let face = model.face(item.face);
        let outline = outline(model, &sorted.view, index);
        StackSurface {
            object: model.object(face.object).name.clone(),
            face: face.index,
            triangle: item.triangle,
            outline: outline.iter().map(|p| p.to_array()).collect(),
        }
    };
    items.into_iter().map(surface).collect()
}

/// Converts the pieces of all cut faces.
fn piece_list(model: &Model, sorted: &Sorted, pieces: &[Option<NodePieces>]) -> Vec<FacePiece> {
    let of_node = |(node, p): (&GraphNode, &Option<NodePieces>)| {
        let Some(p) = p else { return Vec::new() };
        let face = model.face(p.face);
        let triangle = sorted.view.items[node.item as usize].triangle;
        let object = model.object(face.object).name.clone();
        (p.first..)
            .zip(&p.rings)
            .map(|(piece, ring)| FacePiece {
                object: object.clone(),
                face: face.index,
                piece,
                triangle,
                polygon: ring.iter().map(|p| p.to_array()).collect(),
            })
            .collect::<Vec<_>>()
    };
    sorted.nodes.list.iter().zip(pieces).flat_map(of_node).collect()
}

fn supports(edges: &[(u32, u32, u32)]) -> Vec<Support> {
    edges
        .iter()
        .map(|&(front, back, px)| Support { front: ElementIndex(front), back: ElementIndex(back), px })
        .collect()
}

/// Converts the clusters to image layers with distinct tokens.
fn image_layers(
    model: &Model,
    photo: &Photo,
    sorted: &Sorted,
    elements: &[Element],
    linked: &[LinkedLayers],
) -> Vec<ImageLayer> {
    let mut taken = BTreeSet::new();
    sorted
        .clusters
        .list
        .iter()
        .zip(&sorted.contents)
        .enumerate()
        .map(|(index, (cluster, content))| {
            let held: Vec<&Element> =
                cluster.patches.iter().map(|patch| &elements[patch.element.index()]).collect();
            let id = free_token(&photo.name, &held, cluster.rect, &mut taken);
            let name_of = |object: ObjectId| name_in_layer(&model.object(object).name, index, linked);
            let name = name(sorted, cluster, content, name_of);
            let Cluster { order, rect, patches } = cluster;
            let elements = patches.iter().map(|patch| patch.element).collect();
            image_layer(photo, *order, *rect, elements, content, name, id)
        })
        .collect()
}

/// Makes an image layer of some order and rectangle.
fn image_layer(
    photo: &Photo,
    order: u32,
    rect: PixelRect,
    elements: Vec<ElementIndex>,
    content: &Content,
    name: String,
    id: String,
) -> ImageLayer {
    ImageLayer {
        name,
        own_name: None,
        order,
        rect,
        elements,
        file: format!("{id}.png"),
        needed_file: format!("{id}.needed.png"),
        needed_rect: content.needed_rect(),
        texels_used: content.texels_used(),
        texels_visible: content.texels_visible(),
        fill: None,
        uv_from_world: uv_from_world(&photo.camera, &photo.pose, rect),
        id,
    }
}

/// The longest automatic name that lists more than one object, in characters; exported layers have room for it.
const LONGEST_LIST: usize = 48;

/// Names a layer after the objects in it, those with most visible texels first (most covered ones, if none is visible):
/// `facade`, `facade, door`, `facade, door, 2 more`.
fn name(
    sorted: &Sorted,
    cluster: &Cluster,
    content: &Content,
    name_of: impl Fn(ObjectId) -> String,
) -> String {
    let mut texels: BTreeMap<ObjectId, [u64; 2]> = BTreeMap::new();
    for patch in &cluster.patches {
        let object = sorted.layers.elements[patch.element.index()].object;
        texels.entry(object).or_default();
    }
    for (element, [covered, seen]) in &content.texels_of {
        let sum = texels.entry(sorted.layers.elements[element.index()].object).or_default();
        *sum = [sum[0] + seen, sum[1] + covered];
    }
    // The first one in the model wins a tie.
    let mut objects: Vec<(Reverse<[u64; 2]>, ObjectId)> =
        texels.into_iter().map(|(object, texels)| (Reverse(texels), object)).collect();
    objects.sort_unstable();
    let names: Vec<String> = objects.iter().map(|(_, object)| name_of(*object)).collect();
    list_of(&names.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Lists names: all of up to three, the first two and the number of the others, or fewer where they are long.
fn list_of(names: &[&str]) -> String {
    let first = |count: usize| match names.len() - count {
        0 => names.join(", "),
        more => format!("{}, {more} more", names[..count].join(", ")),
    };
    let counts = match names.len() {
        0 => return String::new(),
        all @ 1..=3 => all,
        _ => 2,
    };
    let fitting = (1..=counts).rev().map(first).find(|list| list.chars().count() <= LONGEST_LIST);
    fitting.unwrap_or_else(|| first(1))
}

/// The automatic name of the image layer of the surroundings.
const NAME_OF_SURROUNDINGS: &str = "surroundings";

/// Adds the surroundings to the stack of a photo, as an element in a visibility layer of its own behind all others, and
/// in image layers behind all others. Occlusions do not name them: everything is in front of them.
pub fn add_surroundings(stack: &mut Stack, photo: &Photo, surroundings: &Surroundings) {
    let layers = match surroundings {
        Surroundings::Nothing => return,
        Surroundings::LeftOver(spans) => {
            stack.leftovers.extend(spans.iter().map(|span| [span.y, span.x0, span.x1]));
            stack.leftovers.sort_unstable();
            stack.surroundings_left_over = true;
            return;
        }
        Surroundings::Layers { layers, spared } => {
            stack.spared.extend(spared.then(|| Faces::whole(SURROUNDINGS)));
            layers
        }
    };
    let index = ElementIndex(stack.numbered_elements().count() as u32);
    let element = Element::surroundings();
    let order = stack.image_layers.last().map_or(0, |layer| layer.order + 1);
    let mut taken = stack.image_layers.iter().map(|layer| layer.id.clone()).collect();
    for SurroundingsLayer { rect, content } in layers {
        let id = free_token(&photo.name, &[&element], *rect, &mut taken);
        let name = NAME_OF_SURROUNDINGS.to_owned();
        let layer = image_layer(photo, order, *rect, vec![index], content, name, id);
        stack.texels += rect.area();
        stack.texels_unmerged += rect.area();
        stack.texels_used += layer.texels_used;
        stack.image_layers.push(layer);
    }
    stack.visibility_layers.push(vec![element]);
    stack.counts.elements += 1;
    stack.counts.visibility_layers += 1;
}

/// Returns a token that is not taken, and takes it.
fn free_token(photo: &str, held: &[&Element], rect: PixelRect, taken: &mut BTreeSet<String>) -> String {
    let mut tokens = (0..).map(|salt| token(photo, held, rect, salt));
    tokens.find(|id| taken.insert(id.clone())).expect("salts do not end")
}

/// Returns a token of eight characters of 5 bits each: short enough for a layer's name. Two layers of a project of
/// ten thousand share one with a probability of 1 in 20,000; within a stack `salt` prevents that.
fn token(photo: &str, held: &[&Element], rect: PixelRect, salt: u32) -> String {
    const DIGITS: &[u8; 32] = b"abcdefghijkmnpqrstuvwxyz23456789";
    let named: Vec<_> = held.iter().map(|e| (&e.object, &e.faces, &e.pieces)).collect();
    let key = serde_json::to_vec(&(photo, named, rect, salt)).expect("plain data is JSON");
    let hash = blake3::hash(&key);
    hash.as_bytes()[..8].iter().map(|b| DIGITS[usize::from(b % 32)] as char).collect()
}

/// Writes the notes about violations of the order and about cycles that could not be cut.
fn notes(model: &Model, sorted: &Sorted, options: &Options) -> Vec<String> {
    let name =
        |node: u32| model.face_name(sorted.view.items[sorted.nodes.list[node as usize].item as usize].face);
    let mut notes = Vec::new();
    if options.method == Method::Stencil {
        let against = &sorted.layers.against;
        let px: u64 = against.iter().map(|a| u64::from(a.2)).sum();
        let (pairs, locked) = (against.len(), sorted.locked);
        notes.push(format!(
            "built by stencil peeling as published in 2003: {pairs} pairs of elements are in the wrong \
             order, at {px} pixels, and {locked} faces that occlude each other share the last layer; `--method graph` sorts and cuts them"
        ));
    }
    let strong = sorted.refused.iter().filter(|r| r.2 > options.min_support);
    notes.extend(strong.map(|&(front, back, px)| {
        let (front, back) = (name(front), name(back));
        format!(
            "{front} is in front of {back} at {px} pixels but behind it in the stack: the two occlude each \
             other and could not be cut; they are in separate image layers"
        )
    }));
    notes
}

/// Counts what reports need.
fn counts(sorted: &Sorted, options: &Options) -> StackCounts {
    let stencil = options.method == Method::Stencil;
    let is_noise = |refused: &&(u32, u32, u32)| refused.2 <= options.min_support;
    let layers = &sorted.layers;
    let mut per_object = std::collections::BTreeMap::new();
    layers.elements.iter().for_each(|e| *per_object.entry(e.object).or_insert(0u32) += 1);
    let mut faces: Vec<_> =
        sorted.nodes.list.iter().map(|n| sorted.view.items[n.item as usize].face).collect();
    faces.sort_unstable();
    faces.dedup();
    StackCounts {
        fragments: sorted.runs.fragments(),
        faces: faces.len() as u32,
        elements: layers.elements.len() as u32,
        whole_objects: per_object.values().filter(|&&n| n == 1).count() as u32,
        visibility_layers: layers.count(),
        cuts: sorted.cuts,
        free_cuts: sorted.free_cuts,
        forgiven: if stencil { 0 } else { sorted.refused.iter().filter(is_noise).count() as u32 },
        violations: if stencil { layers.against.len() as u32 } else { 0 },
        violation_px: if stencil { layers.against.iter().map(|a| u64::from(a.2)).sum() } else { 0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{Modeller, camera_is_world, centred};
    use quadratura_base::task::Task;
    use quadratura_layers::{SoftwareRasteriser, sort_photo};

    #[test]
    fn a_name_lists_up_to_three_objects_and_counts_the_others_and_stays_readable() {
        assert_eq!(list_of(&[]), "");
        assert_eq!(list_of(&["facade"]), "facade");
        assert_eq!(list_of(&["facade", "door", "steps"]), "facade, door, steps");
        assert_eq!(list_of(&["facade", "door", "steps", "gate"]), "facade, door, 2 more");
        let long = "a name of some twenty letters";
        assert_eq!(list_of(&[long, long, "b"]), format!("{long}, 2 more"));
        let longer = long.repeat(3);
        assert_eq!(list_of(&[&longer]), longer);
        assert_eq!(list_of(&[&longer, "b"]), format!("{longer}, 1 more"));
    }

    #[test]
    fn a_layer_is_called_after_what_is_seen_in_it_and_not_after_what_reaches_farthest() {
        let mut modeller = Modeller::new();
        modeller.object("beam").screen(10.0, [-6.0, -1.0, 6.0, 1.0]);
        modeller.object("panel").screen(10.0, [-2.0, 1.2, 2.0, 2.9]);
        // Two ends of the beam are left.
        modeller.object("front").screen(8.0, [-4.4, -1.0, 4.4, 0.9]);
        let model = modeller.finish();
        let camera = centred(160, 120, 120.0);
        let pose = camera_is_world();
        let together = ["beam", "panel"].map(Faces::whole).to_vec();
        let constraints = LayerConstraints { merge: vec![together], ..LayerConstraints::default() };
        let options = Options::default();
        let task = Task::silent();
        let sorted =
            sort_photo(&model, &camera, &pose, &SoftwareRasteriser, &options, &constraints, &task).unwrap();
        let names = sorted.clusters.list.iter().zip(&sorted.contents);
        let name_of = |object: ObjectId| model.object(object).name.clone();
        let names: Vec<_> =
            names.map(|(cluster, content)| name(&sorted, cluster, content, name_of)).collect();
        assert_eq!(names, ["front", "panel, beam"]);
        for content in &sorted.contents {
            let [covered, seen] = content.texels_of.values().fold([0; 2], |[a, b], [c, d]| [a + c, b + d]);
            assert_eq!([covered, seen], [content.texels_used(), content.texels_visible()], "none overlap");
        }
    }
}
