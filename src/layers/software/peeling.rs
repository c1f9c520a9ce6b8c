//! Peeling on fragment lists: exact peeling, which is the reference for the occlusion graph, and stencil
//! peeling as published, which is the baseline.

use rayon::prelude::*;

use crate::is_behind;
use crate::pairs::pixels;
use crate::projected_model::ProjectedModel;
use crate::rasteriser::{FragmentLists, StencilLayers, VISIBLE};
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// Returns, per item, whether a fragment of it lies behind a fragment of another item by more than the
/// tolerance. The `forgiven` pairs (front, back), sorted, are ignored.
pub fn occluded(
    view: &ProjectedModel,
    lists: &FragmentLists,
    tolerance: f32,
    forgiven: &[(u32, u32)],
) -> Vec<bool> {
    marked(view, lists, |fragments, mark| {
        for &(back, inverse_depth) in fragments {
            let hides = |&(front, nearer): &(u32, f32)| {
                is_behind(inverse_depth, nearer, tolerance) && forgiven.binary_search(&(front, back)).is_err()
            };
            // Tested once per item only: most fragments belong to an item that is marked already.
            if !mark[back as usize] && fragments.iter().any(hides) {
                mark[back as usize] = true;
            }
        }
    })
}

/// Does stencil peeling as published in 2003. A round draws the set with the depth test inverted, so that the
/// farthest item wins each pixel, and counts the fragments there that are nearer by more than the tolerance;
/// items that won a pixel with a count leave the set. When no pixel has a count, the remaining set is a
/// layer, and the items that left are the next set.
pub fn stencil(
    view: &ProjectedModel,
    lists: &FragmentLists,
    tolerance: f32,
    working: &[bool],
    task: &Task,
) -> Result<StencilLayers> {
    let mut layer = vec![None; view.items.len()];
    let mut rest = working.to_vec();
    let mut passes = 0;
    let mut current = 0;
    let mut locked = 0;
    while rest.contains(&true) {
        task.check_cancelled()?;
        let (set, rounds) = peel_one(view, lists, tolerance, &rest);
        passes += rounds;
        // An empty set means that every item hides another: no order can be found any more.
        let set = set.unwrap_or_else(|| {
            locked = rest.iter().filter(|&&left| left).count() as u32;
            rest.clone()
        });
        for item in (0..set.len()).filter(|&item| set[item]) {
            layer[item] = Some(current);
            rest[item] = false;
        }
        current += 1;
    }
    Ok(StencilLayers { layer, passes, locked })
}

/// Peels one layer off the `rest`: returns its items, or `None` when a round emptied the set, and the number
/// of rounds.
fn peel_one(
    view: &ProjectedModel,
    lists: &FragmentLists,
    tolerance: f32,
    rest: &[bool],
) -> (Option<Vec<bool>>, u32) {
    let mut set = rest.to_vec();
    for rounds in 1.. {
        let hidden = farthest_of_several(view, lists, tolerance, &set);
        if !hidden.contains(&true) {
            return (Some(set), rounds);
        }
        for (alive, hidden) in set.iter_mut().zip(hidden) {
            *alive &= !hidden;
        }
        if !set.contains(&true) {
            return (None, rounds);
        }
    }
    unreachable!("every round takes an item out of a finite set")
}

/// Returns, per item of the `set`, whether it is the farthest item at a pixel where another one is nearer. Of
/// equally far fragments the last in model order wins.
fn farthest_of_several(
    view: &ProjectedModel,
    lists: &FragmentLists,
    tolerance: f32,
    set: &[bool],
) -> Vec<bool> {
    marked(view, lists, |fragments, mark| {
        let alive = || fragments.iter().filter(|(item, _)| set[*item as usize]);
        let farthest = alive().copied().min_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        let Some((item, inverse_depth)) = farthest else { return };
        if alive().any(|&(_, nearer)| is_behind(inverse_depth, nearer, tolerance)) {
            mark[item as usize] = true;
        }
    })
}

/// Collects marks per item over all pixels: `look` gets each pixel's fragments (item, inverse depth) and the
/// marks so far.
fn marked(
    view: &ProjectedModel,
    lists: &FragmentLists,
    look: impl Fn(&[(u32, f32)], &mut [bool]) + Sync,
) -> Vec<bool> {
    let none = || vec![false; view.items.len()];
    let either = |a: Vec<bool>, b: Vec<bool>| a.into_iter().zip(b).map(|(a, b)| a | b).collect();
    let in_band = |band| {
        let (mut mark, mut fragments) = (none(), Vec::new());
        for (x, y, entries) in pixels(lists, band) {
            fragments.clear();
            fragments.extend(entries.iter().map(|entry| {
                let item = entry & !VISIBLE;
                (item, view.items[item as usize].inverse_depth.at(x, y))
            }));
            look(&fragments, &mut mark);
        }
        mark
    };
    lists.bands.par_iter().map(in_band).reduce(none, either)
}
