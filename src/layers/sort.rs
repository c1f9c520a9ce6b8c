//! The steps of sorting one photo: view, fragments, cycles, elements, layers, image layers, content.

use rayon::prelude::*;

use super::cluster::{Clusters, box_size, cluster};
use super::constraints::{LayerConstraints, ResolvedConstraints};
use super::content::{Content, contents};
use super::cycles::{Resolved, resolve_cycles};
use super::leftovers::Leftovers;
use super::nodes::Nodes;
use super::options::{Method, Options};
use super::parts::{Layers, gather_parts};
use super::projected_model::ProjectedModel;
use super::rasteriser::{Fragments, Presence, Rasteriser};
use super::runs::{Runs, item_of};
use super::stencil::layers_of_stencil;
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::{FaceId, Model};
use quadratura_base::task::Task;

/// The complete result of sorting one photo.
#[derive(Debug, Clone, PartialEq)]
pub struct Sorted {
    /// The model as this photo sees it.
    pub view: ProjectedModel,
    /// The state of each item of the view.
    pub presence: Vec<Presence>,
    /// The fragments of the working set.
    pub runs: Runs,
    /// Items and pieces of the working set.
    pub nodes: Nodes,
    /// The elements in their visibility layers.
    pub layers: Layers,
    /// The faces that are in no image layer, because the photo barely shows them.
    pub leftovers: Leftovers,
    /// The image layers.
    pub clusters: Clusters,
    /// The content of each image layer, in the order of `clusters`.
    pub contents: Vec<Content>,
    /// The number of texels that would be needed if every face and piece had a rectangle of its own.
    pub texels_unmerged: u64,
    /// The number of cuts made.
    pub cuts: u32,
    /// The number of cuts of which one piece is visible nowhere.
    pub free_cuts: u32,
    /// Pairs of nodes whose occlusion was refused and contradicts the layers: `(front, back, px)`.
    pub refused: Vec<(u32, u32, u32)>,
    /// The number of items that stencil peeling could not separate and put into one last layer.
    pub locked: u32,
}

/// Sorts the faces of the model (in world coordinates) that one photo sees into image layers, and honours the
/// user's constraints (`constraints`) as far as the order of occlusions allows.
///
/// # Errors
/// The errors of the rasteriser, and [`quadratura_base::Error::Cancelled`].
pub fn sort_photo(
    model: &Model,
    camera: &Pinhole,
    pose: &Pose,
    rasteriser: &dyn Rasteriser,
    options: &Options,
    constraints: &LayerConstraints,
    task: &Task,
) -> Result<Sorted> {
    let wanted = ResolvedConstraints::new(constraints, model);
    let view = task.timed("view", || ProjectedModel::new(model, camera, pose));
    task.check_cancelled()?;
    let Fragments { presence, lists, occlusions } =
        task.timed("fragments", || rasteriser.fragments(&view, options.tolerance, task))?;
    task.check_cancelled()?;
    let runs = task.timed("runs", || Runs::new(lists));
    let working: Vec<bool> = presence.iter().map(|p| *p == Presence::Working).collect();

    let (resolved, layers, locked) = match options.method {
        Method::Graph => {
            let resolved =
                task.timed("cycles", || resolve_cycles(&view, &runs, &working, &occlusions, options));
            let gather = || gather_parts(model, &view, &runs, &resolved, options, &wanted);
            let layers = task.timed("parts", gather);
            (resolved, layers, 0)
        }
        Method::Stencil => {
            let peeled = task
                .timed("stencil", || rasteriser.stencil_peeling(&view, options.tolerance, &working, task))?;
            let nodes = Nodes::whole(&working);
            let items: Vec<u32> = nodes.list.iter().map(|n| n.item).collect();
            let support = options.min_support;
            let layers = layers_of_stencil(model, &view, &items, &peeled, &occlusions, support, &wanted);
            (Resolved { nodes, ..Resolved::default() }, layers, peeled.locked)
        }
    };
    task.check_cancelled()?;

    let find = || Leftovers::find(model, &view, &runs, &resolved.nodes, options, &wanted);
    let leftovers = task.timed("leftovers", find);
    let mut bounds_of_nodes = node_bounds(&view, &runs, &resolved.nodes);
    let left_over = bounds_of_nodes.iter_mut().zip(&leftovers.nodes).filter(|(_, left_over)| **left_over);
    left_over.for_each(|(bounds, _)| *bounds = PixelRect::EMPTY);
    let textured = bounds_of_nodes.iter().zip(&leftovers.nodes).filter(|(_, left_over)| !**left_over);
    let texels_unmerged = textured.map(|(b, _)| box_size(*b, options).area()).sum();
    let bounds = element_bounds(&bounds_of_nodes, &layers);
    let photo = camera.rect();
    let grouping = wanted.to_elements(&faces_of_elements(&view, &resolved.nodes, &layers));
    let clusters = task.timed("cluster", || cluster(model, &layers, &bounds, photo, options, &grouping));
    let contents = task
        .timed("content", || contents(&view, &runs, &resolved.nodes, &layers, &leftovers.nodes, &clusters));
    let refused = contradicting(&resolved, &layers);
    let Resolved { nodes, cuts, free_cuts, .. } = resolved;
    Ok(Sorted {
        view,
        presence,
        runs,
        nodes,
        layers,
        leftovers,
        clusters,
        contents,
        texels_unmerged,
        cuts,
        free_cuts,
        refused,
        locked,
    })
}

/// Returns the faces of each element, in rising order.
fn faces_of_elements(view: &ProjectedModel, nodes: &Nodes, layers: &Layers) -> Vec<Vec<FaceId>> {
    let face = |node: u32| view.items[nodes.list[node as usize].item as usize].face;
    let of_element = |element: &super::parts::SortedElement| {
        let mut faces: Vec<FaceId> = element.nodes.iter().map(|node| face(node.0)).collect();
        faces.dedup();
        faces
    };
    layers.elements.iter().map(of_element).collect()
}

/// Returns the refused edges that the layers contradict; other refused edges turned out to agree with the
/// layers.
fn contradicting(resolved: &Resolved, layers: &Layers) -> Vec<(u32, u32, u32)> {
    let layer = |node: u32| layers.elements[layers.element_of[node as usize].index()].visibility_layer;
    let same = |f: u32, b: u32| layers.element_of[f as usize] == layers.element_of[b as usize];
    let refused = resolved.kept.refused.iter().copied();
    refused.filter(|&(f, b, _)| !same(f, b) && layer(f) >= layer(b)).collect()
}

/// Computes the bounding box of every element, in photo pixels; it is empty where all nodes are leftovers.
fn element_bounds(bounds_of_nodes: &[PixelRect], layers: &Layers) -> Vec<PixelRect> {
    layers
        .elements
        .iter()
        .map(|element| {
            let bounds = element.nodes.iter().map(|node| bounds_of_nodes[node.0 as usize]);
            let union = bounds.reduce(|a, b| a.hull(&b));
            union.expect("an element holds a node at least")
        })
        .collect()
}

/// Computes the bounding box of every node, in photo pixels: of its outline for a whole item, of its pixels
/// for a piece.
fn node_bounds(view: &ProjectedModel, runs: &Runs, nodes: &Nodes) -> Vec<PixelRect> {
    let mut bounds = piece_bounds(view, runs, nodes);
    for (bounds, node) in bounds.iter_mut().zip(&nodes.list) {
        if !nodes.is_cut(node.item) {
            *bounds = view.items[node.item as usize].bounds;
        }
    }
    bounds
}

/// Computes the bounding boxes of the pixels of cut items' nodes; the boxes of all other nodes are empty.
fn piece_bounds(view: &ProjectedModel, runs: &Runs, nodes: &Nodes) -> Vec<PixelRect> {
    const EMPTY: PixelRect = PixelRect::EMPTY;
    let unite = |mut a: Vec<PixelRect>, b: Vec<PixelRect>| {
        for (a, b) in a.iter_mut().zip(b) {
            *a = if a.is_empty() {
                b
            } else if b.is_empty() {
                *a
            } else {
                a.union(&b)
            };
        }
        a
    };
    let none = || vec![EMPTY; nodes.list.len()];
    runs.rows
        .par_iter()
        .enumerate()
        .fold(none, |mut bounds, (y, row)| {
            for run in &row.runs {
                for item in row.entries(run).iter().map(|&e| item_of(e)).filter(|&i| nodes.is_cut(i)) {
                    for x in run.x0..run.x1 {
                        let Some(node) = nodes.at(view, item, x, y as u32) else { continue };
                        let pixel = PixelRect { x: x as i32, y: y as i32, w: 1, h: 1 };
                        let b = &mut bounds[node.0 as usize];
                        *b = if b.is_empty() { pixel } else { b.union(&pixel) };
                    }
                }
            }
            bounds
        })
        .reduce(none, unite)
}
