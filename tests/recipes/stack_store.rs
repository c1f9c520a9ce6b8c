//! The stacks on disk: old or new, whole; and nobody's work is lost.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use quadratura::testing::document::stack::{STACK_VERSION, StackCamera, StackPhoto};
use quadratura::testing::document::{ImageLayer, Stack};
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::io::stack_store::{Committed, StackStore};
use quadratura::testing::scene::synthetic::Rng;

const PHOTO: &str = "nord/tür.jpg";

fn stack_of(names: &[&str], inputs: &str) -> Stack {
    let rect = PixelRect { x: 0, y: 0, w: 4, h: 4 };
    let layer = |name: &&str| ImageLayer {
        id: name.to_lowercase(),
        name: (*name).into(),
        own_name: None,
        order: 0,
        rect,
        elements: vec![],
        file: format!("{name}.png"),
        needed_file: format!("{name}-needed.png"),
        needed_rect: rect,
        texels_used: 0,
        texels_visible: 0,
        fill: None,
        uv_from_world: [[0.0; 4]; 3],
    };
    Stack {
        version: STACK_VERSION,
        method: Default::default(),
        inputs: inputs.into(),
        photo: StackPhoto { name: PHOTO.into(), width: 4, height: 4 },
        camera: StackCamera { K: [[0.0; 3]; 3], R: [[0.0; 3]; 3], t: [0.0; 3] },
        visibility_layers: vec![],
        surfaces: vec![],
        pieces: vec![],
        occlusions: vec![],
        forgiven: vec![],
        unresolved: Vec::new(),
        image_layers: names.iter().map(layer).collect(),
        texels: 0,
        texels_used: 0,
        texels_unmerged: 0,
        bytes: 0,
        fill: None,
        untextured: Default::default(),
        notes: vec![],
        unsatisfied: vec![],
        leftovers: vec![],
        spared: vec![],
        surroundings_left_over: false,
        linked: vec![],
        tolerated: vec![],
        counts: Default::default(),
        in_use: Default::default(),
    }
}

/// Commits a stack whose files all contain `content`.
fn commit(store: &StackStore, names: &[&str], content: &str) -> Committed {
    let stack = stack_of(names, content);
    let writer = store.begin(PHOTO).unwrap();
    for layer in &stack.image_layers {
        fs::write(writer.folder().join(&layer.file), content).unwrap();
        fs::write(writer.folder().join(&layer.needed_file), "needed").unwrap();
    }
    writer.commit(stack).unwrap()
}

fn file_of(store: &StackStore, stack: &Stack, layer: usize) -> PathBuf {
    store.folder(PHOTO).join(&stack.image_layers[layer].file)
}

/// Every file and folder below `folder` as text, for comparing whole trees.
fn tree(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => found.extend(tree(&path)),
            false => found.push((path.clone(), fs::read_to_string(&path).unwrap())),
        }
    }
    found.sort();
    found
}

fn project() -> (tempfile::TempDir, StackStore) {
    let folder = tempfile::tempdir().unwrap();
    let store = StackStore::new(folder.path());
    (folder, store)
}

#[test]
fn a_committed_stack_is_read_back_with_its_files() {
    let (_folder, store) = project();
    assert_eq!(store.current(PHOTO).unwrap(), None);
    let committed = commit(&store, &["left", "right"], "one");
    assert_eq!(committed.kept, [] as [PathBuf; 0]);
    assert_eq!(store.current(PHOTO).unwrap().unwrap(), committed.stack);
    assert_eq!(fs::read_to_string(file_of(&store, &committed.stack, 1)).unwrap(), "one");
    assert_eq!(store.photos().unwrap(), [PHOTO]);
}

#[test]
fn a_new_version_replaces_the_old_one_and_leaves_nothing_of_it() {
    let (folder, store) = project();
    commit(&store, &["left", "right"], "one");
    let committed = commit(&store, &["left"], "two");
    assert_eq!(fs::read_to_string(file_of(&store, &committed.stack, 0)).unwrap(), "two");
    let files = tree(&folder.path().join("stacks"));
    assert_eq!(files.len(), 4, "stack.json, files.json and two images: {files:?}");
    assert!(!folder.path().join("inbox").exists());
}

#[test]
fn a_former_version_can_stay_for_whoever_shows_it_until_it_is_cleared_away() {
    let (_folder, store) = project();
    let store = store.keeping_former();
    let former = commit(&store, &["a", "b"], "old").stack;
    let current = commit(&store, &["b", "c"], "new").stack;
    assert!(file_of(&store, &former, 0).is_file(), "it is still shown");
    assert_eq!(store.current(PHOTO).unwrap().as_ref(), Some(&current));
    assert!(store.clear_former().unwrap().is_empty(), "nobody changed anything");
    let file = file_of(&store, &former, 0);
    assert!(file.is_file(), "a stack in memory names it");
    drop(former);
    store.clear_former().unwrap();
    assert!(!file.exists() && file_of(&store, &current, 0).is_file());
}

#[test]
fn building_the_same_again_gives_the_same_bytes() {
    let (folder, store) = project();
    commit(&store, &["left", "right"], "one");
    let before = tree(&folder.path().join("stacks"));
    let committed = commit(&store, &["left", "right"], "one");
    assert_eq!(tree(&folder.path().join("stacks")), before);
    assert_eq!(committed.kept, [] as [PathBuf; 0]);
}

#[test]
fn a_stack_is_up_to_date_while_its_inputs_and_its_files_are_what_they_were() {
    let (folder, store) = project();
    let committed = commit(&store, &["left"], "one");
    assert_eq!(store.up_to_date(PHOTO, "one").unwrap(), Some(committed.stack.clone()));
    assert_eq!(store.up_to_date(PHOTO, "two").unwrap(), None);

    fs::remove_dir_all(folder.path().join("cache")).unwrap();
    assert!(store.up_to_date(PHOTO, "one").unwrap().is_some(), "the cache only saves time");

    let file = file_of(&store, &committed.stack, 0);
    fs::write(&file, "ONE").unwrap();
    assert_eq!(store.up_to_date(PHOTO, "one").unwrap(), None, "same size, other content");
    fs::remove_file(&file).unwrap();
    assert_eq!(store.up_to_date(PHOTO, "one").unwrap(), None, "missing");
}

#[test]
fn a_file_changed_by_hand_goes_to_the_inbox_when_a_new_version_comes() {
    let (folder, store) = project();
    let old = commit(&store, &["left", "right"], "one").stack;
    fs::write(file_of(&store, &old, 0), "painted").unwrap();
    fs::write(file_of(&store, &old, 0).with_file_name("sketch.xcf"), "theirs").unwrap();
    let committed = commit(&store, &["left", "right"], "two");
    let inbox = folder.path().join("inbox/nord%2Ft%C3%BCr.jpg");
    assert_eq!(committed.kept, [inbox.join("left.png"), inbox.join("sketch.xcf")]);
    assert_eq!(fs::read_to_string(inbox.join("left.png")).unwrap(), "painted");
    assert_eq!(fs::read_to_string(file_of(&store, &committed.stack, 0)).unwrap(), "two");
}

#[test]
fn a_file_changed_by_hand_goes_to_the_inbox_when_the_same_version_is_built_again() {
    let (folder, store) = project();
    let old = commit(&store, &["left", "right"], "one").stack;
    fs::write(file_of(&store, &old, 0), "painted").unwrap();
    fs::remove_file(file_of(&store, &old, 1)).unwrap();
    let committed = commit(&store, &["left", "right"], "one");
    assert_eq!(committed.kept, [folder.path().join("inbox/nord%2Ft%C3%BCr.jpg/left.png")]);
    assert_eq!(fs::read_to_string(&committed.kept[0]).unwrap(), "painted");
    assert_eq!(fs::read_to_string(file_of(&store, &committed.stack, 0)).unwrap(), "one");
    assert!(store.up_to_date(PHOTO, "one").unwrap().is_some());
}

#[test]
fn a_stack_file_changed_by_hand_goes_to_the_inbox_too() {
    let (folder, store) = project();
    let old = commit(&store, &["left"], "one").stack;
    fs::write(store.folder(PHOTO).join("stack.json"), "{ my notes").unwrap();
    assert!(store.current(PHOTO).unwrap_err().to_string().contains("line 1"));
    assert_eq!(store.up_to_date(PHOTO, "one").unwrap(), None);
    let committed = commit(&store, &["left"], "one");
    assert_eq!(committed.kept, [folder.path().join("inbox/nord%2Ft%C3%BCr.jpg/stack.json")]);
    assert_eq!(store.current(PHOTO).unwrap(), Some(old));
}

#[test]
fn a_stack_of_another_version_is_refused_with_a_remedy() {
    let (_folder, store) = project();
    let stack = Stack { version: STACK_VERSION + 1, ..stack_of(&[], "one") };
    store.begin(PHOTO).unwrap().commit(stack).unwrap();
    let message = store.current(PHOTO).unwrap_err().to_string();
    assert!(message.contains("stack.json, version") && message.contains("run “build”"), "{message}");
}

#[test]
fn a_stack_of_elements_or_rectangles_that_cannot_be_is_refused_with_its_layer() {
    let (_folder, store) = project();
    commit(&store, &["left"], "one");
    let file = store.folder(PHOTO).join("stack.json");
    let whole: serde_json::Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    for (field, value, report) in [
        ("elements", serde_json::json!([7]), "element 7"),
        ("rect", serde_json::json!([0, 0, 4, 0]), "4 x 0 pixels"),
    ] {
        let mut broken = whole.clone();
        broken["image_layers"][0][field] = value;
        fs::write(&file, broken.to_string()).unwrap();
        let error = store.current(PHOTO).unwrap_err().to_string();
        assert!(error.contains("image layer \"left\"") && error.contains(report), "{error}");
    }
}

#[test]
fn a_file_that_is_cut_or_gone_is_told_and_one_that_was_painted_on_is_not() {
    let (_folder, store) = project();
    let stack = commit(&store, &["left"], "a whole picture").stack;
    let file = file_of(&store, &stack, 0);
    assert!(store.damage(PHOTO).is_none());
    fs::write(&file, "painted on, with an end: \0\0\0\0IEND\u{1}\u{2}\u{3}\u{4}").unwrap();
    assert!(store.damage(PHOTO).is_none(), "it is whole, and somebody's work");
    fs::write(&file, "a whole").unwrap();
    let report = store.damage(PHOTO).unwrap().to_string();
    assert!(report.contains("left.png: 7 bytes of 15") && report.contains("run “build”"), "{report}");
    fs::remove_file(&file).unwrap();
    assert!(store.damage(PHOTO).unwrap().to_string().contains("the file is missing"));
}

#[test]
fn what_cannot_be_written_is_told_of_the_place_where_it_was_to_be() {
    let (_folder, store) = project();
    let writer = store.begin(PHOTO).unwrap();
    let full =
        |path: PathBuf| quadratura::Error::io(path, "write it")(std::io::ErrorKind::StorageFull.into());
    let report = store.with_final_path(PHOTO, full(writer.folder().join("left.png"))).to_string();
    assert!(report.starts_with(&store.folder(PHOTO).join("left.png").display().to_string()), "{report}");
    assert!(!report.contains("+new-") && report.contains("free some space"), "{report}");
    let elsewhere = store.with_final_path(PHOTO, full("photos/a.jpg".into())).to_string();
    assert!(elsewhere.starts_with("photos/a.jpg"), "{elsewhere}");
}

#[test]
fn a_writer_that_is_dropped_leaves_the_old_stack_and_nothing_else() {
    let (folder, store) = project();
    commit(&store, &["left"], "one");
    let before = tree(folder.path());
    let writer = store.begin(PHOTO).unwrap();
    fs::write(writer.folder().join("left.png"), "half").unwrap();
    drop(writer);
    assert_eq!(tree(folder.path()), before);
}

/// A kill between the steps of a commit leaves folders behind; here they are made by hand.
#[test]
fn what_a_killed_build_left_over_is_cleared_and_the_painted_file_in_it_kept() {
    let (folder, store) = project();
    let old = commit(&store, &["left"], "one").stack;
    let old_version = file_of(&store, &old, 0).parent().unwrap().to_path_buf();
    let saved = tree(&old_version);
    // A stack in memory would keep its version.
    drop(old);
    let new = commit(&store, &["left", "right"], "two").stack;
    let clean = tree(&folder.path().join("stacks"));

    fs::create_dir_all(&old_version).unwrap();
    saved.iter().for_each(|(path, text)| fs::write(path, text).unwrap());
    fs::write(old_version.join("left.png"), "painted").unwrap();
    fs::create_dir(store.folder(PHOTO).join("+new-abc")).unwrap();
    fs::write(store.folder(PHOTO).join("+new-abc/left.png"), "half").unwrap();

    let kept = store.clean().unwrap();
    assert_eq!(kept, [folder.path().join("inbox/nord%2Ft%C3%BCr.jpg/left.png")]);
    assert_eq!(fs::read_to_string(&kept[0]).unwrap(), "painted");
    assert_eq!(tree(&folder.path().join("stacks")), clean);
    assert_eq!(store.current(PHOTO).unwrap(), Some(new));
}

#[test]
fn a_reader_sees_the_old_stack_or_the_new_one_whole_while_they_are_replaced() {
    let (_folder, store) = project();
    commit(&store, &["left", "right"], "version 0");
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let reader = scope.spawn(|| {
            let mut whole = 0;
            while !done.load(Ordering::Relaxed) {
                let stack = store.current(PHOTO).unwrap().expect("there is a stack at every moment");
                let read = |layer| fs::read_to_string(file_of(&store, &stack, layer));
                // Files of a version that was replaced meanwhile are gone; they are never others.
                if let (Ok(left), Ok(right)) = (read(0), read(1)) {
                    assert_eq!((&left, &right), (&stack.inputs, &stack.inputs));
                    whole += 1;
                }
            }
            whole
        });
        for n in 1..60 {
            commit(&store, &["left", "right"], &format!("version {n}"));
        }
        done.store(true, Ordering::Relaxed);
        assert!(reader.join().unwrap() > 0);
    });
}

/// Waits up to `most_us` microseconds.
fn wait(rng: &mut Rng, most_us: f64) {
    std::thread::sleep(Duration::from_micros(rng.between(0.0, most_us) as u64));
}

/// Reads stacks until the writer has ended, and their files some time later: all are there.
fn look_at_stacks(store: &StackStore, rng: &mut Rng, ended: &AtomicBool) {
    while !ended.load(Ordering::Relaxed) {
        let stack = store.current(PHOTO).unwrap().expect("there is a stack at every moment");
        wait(rng, 9000.0);
        for layer in 0..stack.image_layers.len() {
            assert_eq!(fs::read_to_string(file_of(store, &stack, layer)).unwrap(), stack.inputs);
        }
    }
}

#[test]
fn former_versions_that_are_cleared_away_are_not_those_that_somebody_still_has() {
    let rounds = std::env::var("QUADRATURA_ROUNDS").ok().and_then(|rounds| rounds.parse().ok());
    for seed in 0..rounds.unwrap_or(3) {
        let (folder, store) = project();
        let store = store.keeping_former();
        commit(&store, &["left", "right"], "version 0");
        let ended = AtomicBool::new(false);
        std::thread::scope(|scope| {
            for reader in 1..4 {
                let (store, ended) = (&store, &ended);
                scope.spawn(move || look_at_stacks(store, &mut Rng::new(1000 * reader + seed), ended));
            }
            let writer = scope.spawn(|| {
                let mut rng = Rng::new(seed);
                for _ in 0..15 {
                    // Undo and redo bring back versions that were current before.
                    commit(&store, &["left", "right"], &format!("version {}", rng.whole(0, 4)));
                    wait(&mut rng, 3000.0);
                    if rng.chance(0.6) {
                        store.clear_former().unwrap();
                    }
                }
            });
            let written = writer.join();
            ended.store(true, Ordering::Relaxed);
            written.unwrap();
        });
        store.clear_former().unwrap();
        let files = tree(&folder.path().join("stacks"));
        assert_eq!(files.len(), 6, "seed {seed}: one version is left: {files:?}");
    }
}
