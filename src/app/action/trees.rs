//! Actions on trees: edits, eyes, the tool that places them, masks of the real ones, and what the 3D view shows of them.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::masks::keeping::queue_mask;
use crate::state::State;
use crate::state::masking::keeping::MaskWork;
use crate::state::notes::{Note, Weight};
use crate::state::panes::Pane;
use crate::state::request::TreeRequest;
use crate::state::running::JobKind;
use crate::state::selection::Selection;
use crate::state::space::view_pixel::ViewPixel;
use crate::state::trees::ShownTrees;
use crate::state::trees::hand::{HeldTree, Hold};
use crate::work::Work;
use crate::work::jobs::arrival;
use crate::work::painter::PreviewChange;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Site, up};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::trees::{PlacedTree, TreeLight, TreeSpecies, Trees};
use quadratura_foliage::level_axes;
use quadratura_trees::edit::{TreeChange, duplicated, placed, replaced};
use quadratura_trees::light::{LightEstimate, estimated_light, is_needed};
use quadratura_trees::list::species_figures;
use quadratura_trees::paint::species_plant;
use quadratura_trees::{PlantParts, SiteTrees, site_trees, species_images};

/// The width of a crown whose plant is not known yet, as a share of the site's radius.
const UNKNOWN_SHARE: f64 = 0.05;

/// Applies a request about trees.
pub fn apply(state: &mut State, work: &mut Work, request: TreeRequest) {
    match request {
        TreeRequest::Set { name, tree, what, goes_on } => set(state, &name, &tree, what, goes_on),
        TreeRequest::Duplicate(name) => duplicate(state, &name),
        TreeRequest::Remove(name) => remove(state, &name),
        TreeRequest::Show(names, on) => state.show_trees(&names, on),
        TreeRequest::ShowAll => state.trees.hidden.clear(),
        TreeRequest::Light { light, goes_on } => set_light(state, light, goes_on),
        TreeRequest::Mask => mask(state, work),
        TreeRequest::ClearMasks => clear_masks(state),
        TreeRequest::WantFigures => want_figures(state, work),
        TreeRequest::Hand => take_up(state),
        TreeRequest::Choose(species) => state.trees.hand.species = species,
        TreeRequest::Press(pixel) => press(state, &pixel),
        TreeRequest::Drag(pixel, hold) => drag(state, &pixel, hold),
        TreeRequest::Release => {
            state.trees.hand.held = None;
            state.end_gesture();
        }
        TreeRequest::GiveUp => {
            if let Some(held) = state.trees.hand.held.take() {
                state.give_gesture_up(&held.before);
            }
        }
    }
}

/// Shows the present trees in the 3D view, where it shows others.
pub fn follow_trees(state: &mut State, work: &mut Work) {
    state.follow_selected_tree();
    // A video shows the trees with which it began.
    if state.running.runs(JobKind::Render) {
        return;
    }
    let (Some(session), Some(painter)) = (&state.session, &mut work.painter) else {
        state.trees.sent = None;
        return;
    };
    let project = session.history.present().clone();
    let (hidden, mut estimate) = (state.trees.hidden.clone(), state.trees.light.estimate());
    if !is_needed(&project) {
        // Light is given, and no photo shows a tree any more.
        estimate = estimate.map(|known| Arc::new(LightEstimate::plain(known.strength, known.support)));
    }
    let (images, plants_version) = (state.trees.images.count(), state.trees.plants_version);
    let shown = ShownTrees { project, hidden, estimate, images, plants_version };
    match &state.trees.sent {
        Some(sent) if sent.looks_like(&shown) => (),
        sent => {
            if sent.as_ref().is_some_and(|sent| sent.plants_version != plants_version) {
                painter.change(PreviewChange::Plants);
            }
            painter.change(PreviewChange::Trees(shown.clone()));
            state.space.redraw();
            state.window.wake_within(0.0);
        }
    }
    state.trees.sent = Some(shown);
}

fn set(state: &mut State, name: &str, tree: &PlacedTree, what: &str, goes_on: bool) {
    let (Some(session), Some(trees)) = (&state.session, state.trees()) else { return };
    let after = replaced(trees, name, tree);
    if after.is_err() || tree.name == name {
        state.edit_trees(format!("{what} of {name}"), after, goes_on);
        return;
    }
    // What the photos show of the tree stays masked.
    let mut masks = session.history.present().masks.clone();
    masks.rename_tree(name, &tree.name);
    let both = after.map(|trees| (trees, masks));
    state.edit_trees_and_masks(format!("{what} of {name}"), both, goes_on);
    state.tree_renamed(name, &tree.name);
}

fn duplicate(state: &mut State, name: &str) {
    let (Some(session), Some(trees)) = (&state.session, state.trees()) else { return };
    let width = trees.find(name).and_then(|tree| state.trees.size_of(trees, tree)).map(|[_, width]| width);
    let (x, _) = level_axes(session.scene_frame.up);
    let beside = width.unwrap_or(UNKNOWN_SHARE * session.scene_frame.radius) * x;
    match duplicated(trees, name, beside) {
        Ok((trees, copy)) => {
            state.edit_trees(format!("copy of {name}"), Ok(trees), false);
            // Its name may be that of a tree that was hidden and is gone.
            state.trees.hidden.remove(&copy);
            state.select_tree(&copy);
        }
        Err(error) => state.notify(Note::new(Weight::Problem, error.to_string())),
    }
}

fn remove(state: &mut State, name: &str) {
    let Some(trees) = state.trees() else { return };
    let mut rest = trees.clone();
    rest.placed.retain(|tree| tree.name != name);
    state.edit_trees(format!("removal of {name}"), Ok(rest), false);
}

fn set_light(state: &mut State, light: TreeLight, goes_on: bool) {
    let Some(trees) = state.trees() else { return };
    let lit = Trees { light, ..trees.clone() };
    let lit = lit.problem().map_or(Ok(lit), |problem| Err(Error::Request(problem)));
    state.edit_trees("light on trees".into(), lit, goes_on);
}

/// Queues the masks of all trees as a step of the history.
fn mask(state: &mut State, work: &mut Work) {
    let margin_px = state.masking.margin_px;
    queue_mask(state, work, "masks of trees".into(), MaskWork::Trees { margin_px });
}

fn clear_masks(state: &mut State) {
    let (Some(masks), Some(session)) = (state.masks_without_trees(), &state.session) else { return };
    let project = Project { masks, ..Project::clone(session.history.present()) };
    state.edit("removal of masks of trees", project, None);
}

/// Returns the species that are among some, with their names: paint belongs to a name.
fn named(trees: &Trees, among: &[TreeSpecies]) -> Vec<(String, TreeSpecies)> {
    let named = trees.species.iter().filter(|(_, species)| among.contains(species));
    named.map(|(name, species)| (name.clone(), species.clone())).collect()
}

/// Starts the job that reads or grows plants whose figures are not known.
fn want_figures(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let missing = state.trees.figures.missing(&session.history.present().trees, &state.running);
    if missing.is_empty() {
        return;
    }
    let (folder, named) = (session.folder.clone(), named(&session.history.present().trees, &missing));
    let version = state.trees.plants_version;
    let job = work.jobs.start(&mut state.running, JobKind::Look, "Reading plants", move |task| {
        let mut found = Vec::new();
        for (name, species) in named {
            task.check_cancelled()?;
            // The 3D view tells what is wrong with a plant.
            let quiet = Task::silent().with_stop_flag(task.stop_flag());
            let figures = species_figures(&folder, &name, &species, &quiet);
            found.push((species, figures.map_err(|error| error.to_string())));
        }
        // What was found of files that have changed since is found again.
        Ok(arrival(move |state| {
            if state.trees.plants_version == version {
                state.trees.figures.add(found);
            }
        }))
    });
    state.trees.figures.job = Some(job);
}

/// Starts the job that estimates the light on trees where it is not known, unless a gesture goes on.
pub fn follow_light(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let project = session.history.present();
    if state.trees.hand.held.is_some() || !state.trees.light.is_missing(project, &state.running) {
        return;
    }
    let (folder, project) = (session.folder.clone(), project.clone());
    let (begun, version) = (project.clone(), state.trees.plants_version);
    let opened = session.opened.with_project(&folder, Project::clone(&project));
    let job =
        work.jobs.start(&mut state.running, JobKind::Look, "Estimating the light on trees", move |task| {
            let found = match estimated(&folder, &opened.project, &opened.site, task) {
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                found => found.map_err(|error| error.to_string()),
            };
            Ok(arrival(move |state| match state.trees.plants_version == version {
                true => state.trees.light.keep(&project, found),
                // It is of files that have changed since, and is found again.
                false => state.trees.light.forget(),
            }))
        });
    state.trees.light.begin(&begun, job);
}

/// Starts the job that makes the images of species that have none, unless a gesture goes on.
pub fn follow_images(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let missing = state.trees.images.missing(&session.history.present().trees, &state.running);
    if missing.is_empty() || state.trees.hand.held.is_some() {
        return;
    }
    let (folder, begun) = (session.folder.clone(), missing.clone());
    let named = named(&session.history.present().trees, &missing);
    let job = work.jobs.start(&mut state.running, JobKind::Look, "Making images of trees", move |task| {
        for (name, species) in &named {
            // The 3D view tells what is wrong with a plant.
            let quiet = Task::silent().with_stop_flag(task.stop_flag());
            let Ok(plant) = species_plant(&folder, name, species, &quiet) else { continue };
            match species_images(&folder, &plant, PlantParts::Images, task) {
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(error) => task.note(error.message()),
                Ok(_) => (),
            }
        }
        Ok(arrival(move |state| state.trees.images.add(missing)))
    });
    state.trees.images.begin(&begun, job);
}

fn estimated(folder: &Path, project: &Project, site: &Site, task: &Task) -> Result<LightEstimate> {
    // The 3D view tells what is wrong with a plant.
    let quiet = Task::silent().with_stop_flag(task.stop_flag());
    let trees = site_trees(folder, &project.trees, up(&site.photos), PlantParts::Openness, &quiet)?;
    let Some(SiteTrees { placed, .. }) = trees.filter(|trees| !trees.placed.trees.is_empty()) else {
        return Err(Error::Request("no tree can be drawn".into()));
    };
    estimated_light(folder, project, site, &placed, task)
}

/// Takes up the tool in the 3D view, or puts it away. It takes the place of the brush.
fn take_up(state: &mut State) {
    state.panes.show(Pane::Space);
    state.space.brush.give_up();
    state.space.brush.on = false;
    state.space.measure.on = false;
    state.trees.hand.held = None;
    state.trees.hand.on = !state.trees.hand.on;
}

/// Takes the tree under the pointer, or places one where a surface is.
fn press(state: &mut State, pixel: &ViewPixel) {
    state.end_gesture();
    let Some(scene) = state.scene() else { return };
    let before = scene.session.history.present().clone();
    if scene.shows_tree_of_before(pixel) {
        state.notify(Note::new(
            Weight::Info,
            "Place tree: the trees in the picture have just changed; click again",
        ));
        return;
    }
    // A tree that was placed just now is taken as well, before it is drawn.
    if let Some(index) = scene.tree_at(pixel).or_else(|| scene.undrawn_tree_at(pixel)) {
        state.select(Selection::Tree(index));
    } else if !place(state, pixel) {
        return;
    }
    let Some(tree) = state.selected_tree().cloned() else { return };
    let size = held_size(state, &tree);
    state.trees.hand.held = Some(HeldTree::new(before, tree, size, pixel.at_px));
}

/// Places a tree with its foot on the surface under the pointer, and selects it; returns false where that is not possible.
fn place(state: &mut State, pixel: &ViewPixel) -> bool {
    let Some(ground) = state.scene().and_then(|scene| scene.ground_at(pixel)) else {
        let text = "Place tree: there is no surface here to stand on";
        state.notify(Note::new(Weight::Info, text));
        return false;
    };
    let Some(trees) = state.trees() else { return false };
    let change = TreeChange { at: Some(ground.to_array()), ..TreeChange::default() };
    match placed(trees, &state.trees.hand.species, None, &change) {
        Ok((trees, name)) => {
            state.edit_trees(format!("placing of {name}"), Ok(trees), true);
            state.trees.hidden.remove(&name);
            state.select_tree(&name);
            true
        }
        Err(error) => {
            state.notify(Note::new(Weight::Problem, error.to_string()));
            false
        }
    }
}

/// Returns the height and width of a tree, or of one that fits the site until its plant is known.
fn held_size(state: &State, tree: &PlacedTree) -> [f64; 2] {
    let radius = state.session.as_ref().map_or(1.0, |session| session.scene_frame.radius);
    let known = state.trees().and_then(|trees| state.trees.size_of(trees, tree));
    known.unwrap_or([tree.height.unwrap_or(UNKNOWN_SHARE * radius), UNKNOWN_SHARE * radius])
}

/// Drags the tree that is held, as a part of the gesture that began with the press.
fn drag(state: &mut State, pixel: &ViewPixel, hold: Hold) {
    let Some(mut held) = state.trees.hand.held.take() else { return };
    let Some(now) = state.trees().and_then(|trees| trees.find(held.name())).cloned() else { return };
    held.hold_for(hold, &now, held_size(state, &now), pixel.at_px);
    let ground = |at_px| -> Option<DVec3> { state.scene()?.ground_at(&ViewPixel { at_px, ..*pixel }) };
    if let Some(tree) = held.dragged(pixel, ground).filter(|tree| *tree != now) {
        let name = tree.name.clone();
        set(state, &name, &tree, hold.word(), true);
    }
    state.trees.hand.held = Some(held);
}
