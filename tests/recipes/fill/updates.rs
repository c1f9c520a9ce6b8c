//! `update`: what it does, in which order, and what becomes current while the project changes.

use std::any::Any;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use quadratura::task::Task;
use quadratura::testing::document::{PhotoDecisions, Stack};
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layers::rasteriser::StencilLayers;
use quadratura::testing::layers::{Fragments, Options, ProjectedModel, Rasteriser, SoftwareRasteriser};
use quadratura::testing::scene::PhotoId;
use quadratura::testing::sites::open::Opened;
use quadratura::testing::stacks::fill::stale_fillings;
use quadratura::testing::stacks::survey::{StackState, Survey};
use quadratura::testing::stacks::turns::UpdateSource;
use quadratura::testing::stacks::update::{UpdateEnd, UpdateRequest, UpdatedPhoto, update};
use quadratura::{Error, Result};

use super::bench::{Bench, PHOTOS};
use super::propagated::{BEHIND, clean, paint_scrawl};

/// What happens when a turn of this number begins.
type AtTurn = dyn Fn(usize, &InMemory) + Sync;

/// A project in memory that may change when a turn begins.
struct InMemory {
    opened: Mutex<Arc<Opened>>,
    turns: AtomicUsize,
    held: Arc<AtomicBool>,
    at_turn: Box<AtTurn>,
    at_check: Option<Box<dyn Fn() + Sync>>,
}

/// The right to write, of which there is one.
struct Right(Arc<AtomicBool>);

impl Drop for Right {
    fn drop(&mut self) {
        assert!(self.0.swap(false, Ordering::SeqCst));
    }
}

impl InMemory {
    fn new(bench: &Bench, at_turn: impl Fn(usize, &Self) + Sync + 'static) -> Self {
        Self {
            opened: Mutex::new(Arc::new(bench.opened())),
            turns: AtomicUsize::new(0),
            held: Arc::default(),
            at_turn: Box::new(at_turn),
            at_check: None,
        }
    }

    fn still(bench: &Bench) -> Self {
        Self::new(bench, |_, _| ())
    }

    /// Decides that the layers of a photo have this margin.
    fn decide_margin(&self, photo: &str, margin: u32) {
        let mut opened = self.opened.lock().unwrap();
        let mut project = opened.project.clone();
        let mut decided = PhotoDecisions::default();
        decided.options.margin = Some(margin);
        project.decisions.set(photo, decided);
        *opened = Arc::new(Opened {
            project,
            site: opened.site.clone(),
            whole: opened.whole.clone(),
            reprojection: None,
            points: opened.points.clone(),
            problems: opened.problems.clone(),
        });
    }

    fn opened(&self) -> Arc<Opened> {
        self.opened.lock().unwrap().clone()
    }
}

impl UpdateSource for InMemory {
    fn right(&self, _: &Task) -> Result<Box<dyn Any>> {
        assert!(!self.held.load(Ordering::SeqCst), "the right is released between turns");
        (self.at_turn)(self.turns.fetch_add(1, Ordering::SeqCst), self);
        self.held.store(true, Ordering::SeqCst);
        Ok(Box::new(Right(self.held.clone())))
    }

    fn project(&self, _: &Task) -> Result<Arc<Opened>> {
        Ok(self.opened())
    }

    fn hold(&self) -> Box<dyn Any> {
        self.at_check.iter().for_each(|at_check| at_check());
        Box::new(())
    }
}

fn one_by_one(photos: &[&str]) -> UpdateRequest {
    let photos = photos.iter().map(|name| (*name).to_owned()).collect();
    UpdateRequest { photos, together: 1, memory: 1 << 30, ..UpdateRequest::default() }
}

fn run(bench: &Bench, source: &InMemory, request: &UpdateRequest) -> Vec<UpdatedPhoto> {
    run_with(bench, source, request, || Ok(Box::new(SoftwareRasteriser)))
}

fn run_with(
    bench: &Bench,
    source: &InMemory,
    request: &UpdateRequest,
    rasteriser: impl Fn() -> Result<Box<dyn Rasteriser>>,
) -> Vec<UpdatedPhoto> {
    let store = StackStore::new(bench.folder.path());
    update(&store, source, request, &rasteriser, &Task::silent()).unwrap()
}

/// The photos whose stacks are current and filled, for the project as it is now.
fn current(bench: &Bench, source: &InMemory) -> Vec<String> {
    let (store, opened) = (StackStore::new(bench.folder.path()), source.opened());
    let survey = Survey::new(&opened.project, &opened.site, &store);
    let is_current = |state: StackState| matches!(state, StackState::Current(stack) if stack.fill.is_some());
    let photos = opened.site.photos.iter().filter(|photo| is_current(survey.state(photo).unwrap()));
    photos.map(|photo| photo.name.clone()).collect()
}

fn stack_of(bench: &Bench, photo: &str) -> Option<Stack> {
    StackStore::new(bench.folder.path()).current(photo).unwrap()
}

#[test]
fn photos_are_built_and_filled_in_the_order_wanted_and_then_there_is_nothing_to_do() {
    let bench = Bench::courtyard();
    let folder = bench.folder.path().to_path_buf();
    let order: Arc<Mutex<Vec<Vec<bool>>>> = Arc::default();
    let seen = order.clone();
    let source = InMemory::new(&bench, move |_, _| {
        let store = StackStore::new(&folder);
        let filled = |photo: &str| store.current(photo).unwrap().is_some_and(|stack| stack.fill.is_some());
        seen.lock().unwrap().push(["2.png", "0.png"].map(filled).to_vec());
    });
    let request = one_by_one(&["2", "0.png"]);
    let updated = run(&bench, &source, &request);
    let names: Vec<&str> = updated.iter().map(|photo| photo.photo.as_str()).collect();
    assert_eq!(names, ["2.png", "0.png"]);
    assert!(updated.iter().all(|photo| photo.built && photo.filled), "{updated:?}");
    assert!(stack_of(&bench, "1.png").is_none(), "nobody asked for it");
    // A turn to clean up, two to build, two to fill: when the last one begins, the first photo is filled.
    assert_eq!(order.lock().unwrap()[3..], [vec![false, false], vec![true, false]]);

    let never = || -> Result<Box<dyn Rasteriser>> { panic!("nothing is to be built") };
    let again = run_with(&bench, &source, &request, never);
    assert!(again.iter().all(|photo| !photo.built && !photo.filled), "{again:?}");
    assert!(again.iter().all(|photo| matches!(photo.end, UpdateEnd::Current(_))));
}

#[test]
fn photos_that_were_never_built_are_skipped_where_that_is_wanted() {
    let bench = Bench::courtyard();
    let source = InMemory::still(&bench);
    run(&bench, &source, &one_by_one(&["1"]));
    source.decide_margin("1.png", 7);
    let request = UpdateRequest { only_existing: true, ..one_by_one(&[]) };
    let ends: Vec<bool> = run(&bench, &source, &request).iter().map(|photo| photo.built).collect();
    assert_eq!(ends, [false, true, false]);
    assert_eq!(current(&bench, &source), ["1.png"]);
}

#[test]
fn a_decision_between_two_photos_is_in_the_stack_that_becomes_current() {
    let bench = Bench::courtyard();
    // At the third turn two photos are behind us.
    let source = InMemory::new(&bench, |turn, source| {
        if turn == 2 {
            source.decide_margin("0.png", 9);
        }
    });
    let updated = run(&bench, &source, &one_by_one(&[]));
    assert!(updated.iter().all(|photo| matches!(photo.end, UpdateEnd::Current(_))), "{updated:?}");
    assert_eq!(current(&bench, &source).len(), PHOTOS);
    let inputs = |photo: &str| stack_of(&bench, photo).unwrap().inputs;
    assert!(inputs("0.png").contains('-') && !inputs("1.png").contains('-'), "one has decisions");
}

/// A rasteriser during whose work the project changes.
struct Meanwhile<F: Fn() + Sync>(F);

impl<F: Fn() + Sync> Rasteriser for Meanwhile<F> {
    fn fragments(&self, view: &ProjectedModel, tolerance: f32, task: &Task) -> Result<Fragments> {
        (self.0)();
        SoftwareRasteriser.fragments(view, tolerance, task)
    }

    fn occluded(
        &self,
        view: &ProjectedModel,
        tolerance: f32,
        alive: &[bool],
        forgiven: &[(u32, u32)],
    ) -> Result<Vec<bool>> {
        SoftwareRasteriser.occluded(view, tolerance, alive, forgiven)
    }

    fn stencil_peeling(
        &self,
        view: &ProjectedModel,
        tolerance: f32,
        working: &[bool],
        task: &Task,
    ) -> Result<StencilLayers> {
        SoftwareRasteriser.stencil_peeling(view, tolerance, working, task)
    }
}

#[test]
fn a_stack_made_from_an_older_state_does_not_become_current_and_other_photos_go_on() {
    let bench = Bench::courtyard();
    bench.build(Options::default());
    let before = stack_of(&bench, "1.png").unwrap();
    let source: &'static InMemory = Box::leak(Box::new(InMemory::still(&bench)));
    source.decide_margin("1.png", 5);
    let margin = Arc::new(AtomicUsize::new(6));
    // The photo's decisions change whenever it is built.
    let make = || -> Result<Box<dyn Rasteriser>> {
        let margin = margin.clone();
        let change = move || source.decide_margin("1.png", margin.fetch_add(1, Ordering::SeqCst) as u32);
        Ok(Box::new(Meanwhile(change)))
    };
    let updated = run_with(&bench, source, &one_by_one(&[]), make);
    assert!(margin.load(Ordering::SeqCst) > 7, "it was tried again");
    assert!(matches!(updated[1].end, UpdateEnd::Changed), "{updated:?}");
    assert_eq!(stack_of(&bench, "1.png").unwrap(), before);
    // Once nothing changes any more, it becomes current.
    let updated = run(&bench, source, &one_by_one(&[]));
    assert!(updated[1].built && current(&bench, source).len() == PHOTOS, "{updated:?}");
}

#[test]
fn a_change_of_another_photo_does_not_cancel_the_one_that_is_built() {
    let bench = Bench::courtyard();
    let source: &'static InMemory = Box::leak(Box::new(InMemory::still(&bench)));
    let built = Arc::new(AtomicUsize::new(0));
    let make = || -> Result<Box<dyn Rasteriser>> {
        let built = built.clone();
        Ok(Box::new(Meanwhile(move || {
            // While the first photo is built, something is decided about the last one.
            if built.fetch_add(1, Ordering::SeqCst) == 0 {
                source.decide_margin("2.png", 9);
            }
        })))
    };
    let updated = run_with(&bench, source, &one_by_one(&[]), make);
    assert_eq!(built.load(Ordering::SeqCst), PHOTOS, "each photo was built once");
    assert_eq!(current(&bench, source).len(), PHOTOS, "{updated:?}");
}

#[test]
fn paint_between_two_photos_is_in_the_fillings_that_become_current() {
    let bench: &'static Bench = Box::leak(Box::new(Bench::courtyard()));
    bench.build(Options::default());
    // The first turn cleans up, at the second one a filling is about to be made.
    let source = InMemory::new(bench, |turn, _| {
        if turn == 1 {
            paint_scrawl(bench, 1, BEHIND, clean);
        }
    });
    let updated = run(bench, &source, &one_by_one(&[]));
    assert!(updated.iter().all(|photo| photo.filled), "{updated:?}");
    let origins = stack_of(bench, "0.png").unwrap().fill.unwrap().origins;
    assert!(origins.iter().any(|origin| origin.contains("painted in 1.png")), "{origins:?}");
    let again = run(bench, &source, &one_by_one(&[]));
    assert!(
        again.iter().all(|photo| !photo.filled),
        "what became current was made with the paint: {again:?}"
    );
}

#[test]
fn continuous_painting_does_not_hold_up_fillings_and_what_lacks_paint_is_not_current() {
    let bench: &'static Bench = Box::leak(Box::new(Bench::courtyard()));
    bench.build(Options::default());
    let strokes = Arc::new(AtomicUsize::new(0));
    let count = strokes.clone();
    // Whenever something is about to become current, there is a new stroke.
    let paints = move || {
        let [x0, x1, y0, y1] = BEHIND;
        let stroke = count.fetch_add(1, Ordering::SeqCst) as f64;
        paint_scrawl(bench, 1, [x0, x1 - 0.02 * stroke, y0, y1], clean);
    };
    let source = InMemory { at_check: Some(Box::new(paints)), ..InMemory::still(bench) };
    let updated = run(bench, &source, &one_by_one(&["0"]));
    assert!(strokes.load(Ordering::SeqCst) > 2, "it was tried again");
    assert!(updated[0].filled && matches!(updated[0].end, UpdateEnd::Changed), "{updated:?}");
    let (folder, opened) = (bench.folder.path(), source.opened());
    assert_eq!(
        stale_fillings(folder, &opened.project, &opened.site).unwrap(),
        [PhotoId(0)],
        "it is out of date by the last stroke"
    );
    // Once nobody paints any more, the rest is quickly done.
    let source = InMemory::still(bench);
    let updated = run(bench, &source, &one_by_one(&["0"]));
    assert!(updated[0].filled && matches!(updated[0].end, UpdateEnd::Current(_)), "{updated:?}");
    assert!(stale_fillings(folder, &opened.project, &opened.site).unwrap().is_empty());
}

#[test]
fn one_photo_is_stopped_or_fails_and_the_others_go_on() {
    let bench = Bench::courtyard();
    let source = InMemory::still(&bench);
    std::fs::write(bench.folder.path().join("0.png"), "no picture").unwrap();
    let stops = BTreeMap::from([("1.png".to_owned(), Arc::new(AtomicBool::new(true)))]);
    let updated = run(&bench, &source, &UpdateRequest { stops, ..one_by_one(&[]) });
    assert!(matches!(updated[0].end, UpdateEnd::Failed(_)), "{updated:?}");
    assert!(matches!(updated[1].end, UpdateEnd::Stopped), "{updated:?}");
    assert!(matches!(updated[2].end, UpdateEnd::Current(_)), "{updated:?}");
    assert_eq!(current(&bench, &source), ["2.png"]);

    let task = Task::silent();
    task.stop_flag().store(true, Ordering::Relaxed);
    let store = StackStore::new(bench.folder.path());
    let make = || -> Result<Box<dyn Rasteriser>> { Ok(Box::new(SoftwareRasteriser)) };
    let stopped = update(&store, &source, &one_by_one(&["1"]), &make, &task);
    assert!(matches!(stopped, Err(Error::Cancelled)));
    assert!(!source.held.load(Ordering::SeqCst), "nothing keeps the right");
}
