//! Tests of the paint on disk: what comes back, what is told, and readers beside a writer.

use super::*;
use quadratura_base::scene::FaceIndex;
use quadratura_base::scene::synthetic::Rng;
use quadratura_document::paint::{ERASED, PaintColour};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{scope, sleep};
use std::time::Duration;

fn entry(object: &str, import: u32) -> PaintEntry {
    PaintEntry {
        photo: "nord/1.png".into(),
        object: object.into(),
        face: Some(FaceIndex(3)),
        triangle: None,
        beyond: false,
        layer: "t1".into(),
        document: "k1".into(),
        import,
        view: "v".into(),
        outline: vec![],
        file: String::new(),
        rect: PixelRect::EMPTY,
        pixels: 0,
    }
}

fn painted(store: &PaintStore, object: &str, colour: PaintColour) -> (PaintEntry, PaintPatch) {
    let patch = PaintPatch::of_pixels(&[(-3, 2, colour), (4, 5, ERASED)]);
    let mut entry = entry(object, 1);
    store.add(&mut entry, &patch).unwrap();
    (entry, patch)
}

fn names(folder: &Path) -> Vec<String> {
    let below = |path: PathBuf| {
        let inner = if path.is_dir() { names(&path) } else { vec![] };
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        [vec![name], inner].concat()
    };
    entries_of(folder).unwrap().into_iter().flat_map(below).collect()
}

#[test]
fn paint_comes_back_in_8_and_in_16_bits_erased_pixels_too() {
    let project = tempfile::tempdir().unwrap();
    let store = PaintStore::new(project.path());
    for colour in [[257, 0, 514, 65535], [1, 2, 3, 4], [0, 0, 0, 257]] {
        let (entry, patch) = painted(&store, "wall", colour);
        assert_eq!(store.patch(&entry).unwrap(), patch);
        assert_eq!((entry.rect, entry.pixels), (PixelRect { x: -3, y: 2, w: 8, h: 4 }, 2));
    }
}

#[test]
fn a_picture_that_is_gone_or_damaged_is_told_with_what_is_lost_and_where_it_came_from() {
    let project = tempfile::tempdir().unwrap();
    let store = PaintStore::new(project.path());
    let (mut entry, _) = painted(&store, "wall", [257; 4]);
    entry.document = "k1@layers/1.png.psd".into();
    fs::create_dir(project.path().join("layers")).unwrap();
    fs::write(project.path().join("layers/1.png.psd"), "edited").unwrap();
    let book = PaintBook { entries: vec![entry.clone()], ..PaintBook::default() };
    store.commit(&book, &PaintBook::default()).unwrap();
    store.check(&entry).unwrap();
    let file = project.path().join("paint").join(&entry.file);
    let whole = fs::read(&file).unwrap();
    let mut other = Vec::new();
    let retouched = PaintPatch::of_pixels(&[(-3, 2, [514; 4]), (4, 5, ERASED)]);
    write_rgba(&mut other, &raster_of(&retouched), None).unwrap();
    fs::write(&file, other).unwrap();
    store.check(&entry).unwrap();
    assert_eq!(store.patch(&entry).unwrap(), retouched, "a changed picture is used");
    for damage in [Some(&whole[..whole.len() / 2]), None] {
        match damage {
            Some(bytes) => fs::write(&file, bytes).unwrap(),
            None => fs::remove_file(&file).unwrap(),
        }
        for message in [store.check(&entry).unwrap_err(), store.patch(&entry).unwrap_err()] {
            let message = message.to_string();
            assert!(message.contains("2 px of paint on wall[3] of photo nord/1.png"), "{message}");
            assert!(message.contains("layers/1.png.psd again") && !message.contains("stack"), "{message}");
        }
    }
}

#[test]
fn an_object_of_any_name_has_a_file() {
    let project = tempfile::tempdir().unwrap();
    let store = PaintStore::new(project.path());
    for name in ["a/b:c", "\0", "Säule ".repeat(60).as_str(), ""] {
        let (entry, _) = painted(&store, name, [257; 4]);
        assert!(project.path().join("paint").join(&entry.file).is_file(), "{}", entry.file);
    }
}

#[test]
fn unnamed_pictures_are_removed_and_files_of_others_are_not() {
    let project = tempfile::tempdir().unwrap();
    let store = PaintStore::new(project.path());
    let (kept, _) = painted(&store, "kept", [257; 4]);
    painted(&store, "left over by a kill", [257; 4]);
    let theirs = project.path().join("paint/nord%2F1.png/mine-0123456789ab.png");
    fs::write(&theirs, "not ours").unwrap();
    let book = PaintBook { entries: vec![kept], ..PaintBook::default() };
    store.commit(&book, &PaintBook::default()).unwrap();
    assert_eq!(store.read().unwrap(), book);
    let found = names(&project.path().join("paint"));
    assert_eq!(found.len(), 4, "{found:?}");
    assert!(theirs.is_file() && found[1].starts_with("kept-3-"), "{found:?}");
}

#[test]
fn pictures_whose_book_is_gone_are_told_and_stay() {
    let project = tempfile::tempdir().unwrap();
    let store = PaintStore::new(project.path());
    let (entry, _) = painted(&store, "wall", [257; 4]);
    let picture = project.path().join("paint").join(&entry.file);
    let nothing = PaintBook::default();
    store.commit(&PaintBook { entries: vec![entry], ..PaintBook::default() }, &nothing).unwrap();
    std::fs::remove_file(project.path().join("paint/paint.json")).unwrap();
    let message = store.read().unwrap_err().to_string();
    assert!(
        message.contains("paint.json") && message.contains("1 pictures") && message.contains("copy"),
        "{message}"
    );
    let (other, _) = painted(&store, "floor", [9 * 257; 4]);
    store.commit(&PaintBook { entries: vec![other], ..PaintBook::default() }, &nothing).unwrap();
    assert!(picture.is_file(), "it was not to be removed");
}

#[test]
fn a_book_without_anything_leaves_no_folder_and_the_one_before_it_is_not_read() {
    let project = tempfile::tempdir().unwrap();
    let store = PaintStore::new(project.path());
    let (entry, _) = painted(&store, "wall", [257; 4]);
    let (book, nothing) = (PaintBook { entries: vec![entry], ..PaintBook::default() }, PaintBook::default());
    store.commit(&book, &nothing).unwrap();
    // Reading fails from here on: a writer has read the book before, and it is not read a second time.
    fs::write(project.path().join("paint/paint.json"), "no book").unwrap();
    store.commit(&nothing, &book).unwrap();
    assert!(names(project.path()).is_empty());
    assert!(store.read().unwrap().is_empty());
}

#[test]
fn a_book_of_another_version_is_refused_with_a_remedy() {
    let project = tempfile::tempdir().unwrap();
    let store = PaintStore::new(project.path());
    store
        .commit(
            &PaintBook { version: 9, entries: vec![entry("a", 1)], ..PaintBook::default() },
            &PaintBook::default(),
        )
        .unwrap();
    let said = store.read().unwrap_err().to_string();
    assert!(said.contains("paint.json") && said.contains("version 9"), "{said}");
}

/// Waits up to `most_us` microseconds.
fn wait(rng: &mut Rng, most_us: f64) {
    sleep(Duration::from_micros(rng.between(0.0, most_us) as u64));
}

/// Paints and undoes strokes for a while, and returns the last book.
fn paint_and_undo(store: &PaintStore, rng: &mut Rng) -> PaintBook {
    for stroke in 0..12 {
        let before = store.read().unwrap();
        let mut book = before.clone();
        if !book.entries.is_empty() && rng.chance(0.5) {
            book.entries.pop();
        } else {
            let colour = [257 * rng.whole(1, 255) as u16, 257 * stroke, 514, 65535];
            book.entries.push(painted(store, "wall", colour).0);
        }
        wait(rng, 2000.0);
        store.commit(&book, &before).unwrap();
        wait(rng, 2000.0);
    }
    store.read().unwrap()
}

/// Reads books and their pictures until the writer has ended, each book for some time.
fn look_at_paint(store: &PaintStore, rng: &mut Rng, ended: &AtomicBool) {
    while !ended.load(Ordering::Relaxed) {
        let book = store.read().unwrap();
        wait(rng, 5000.0);
        for entry in &book.entries {
            store.check(entry).unwrap();
            store.patch(entry).unwrap();
        }
    }
}

#[test]
fn readers_of_paint_never_meet_its_writer_half_way() {
    let rounds = std::env::var("QUADRATURA_ROUNDS").ok().and_then(|rounds| rounds.parse().ok());
    for seed in 0..rounds.unwrap_or(5) {
        let project = tempfile::tempdir().unwrap();
        let store = PaintStore::new(project.path());
        let ended = AtomicBool::new(false);
        let last = scope(|scope| {
            for reader in 1..4 {
                let (store, ended) = (&store, &ended);
                scope.spawn(move || look_at_paint(store, &mut Rng::new(1000 * reader + seed), ended));
            }
            let writer = scope.spawn(|| paint_and_undo(&store, &mut Rng::new(seed)));
            let last = writer.join();
            ended.store(true, Ordering::Relaxed);
            last.unwrap()
        });
        // Nobody has a former book any more: the next writer removes what only those name.
        store.commit(&last, &last).unwrap();
        let pictures =
            names(&project.path().join("paint")).into_iter().filter(|name| name.starts_with("wall-"));
        assert_eq!(pictures.count(), last.files().len(), "seed {seed}");
    }
}

#[test]
fn a_picture_that_another_program_has_replaced_is_not_told_as_damaged() {
    let project = tempfile::tempdir().unwrap();
    let store = PaintStore::new(project.path());
    let (entry, _) = painted(&store, "wall", [257; 4]);
    // These books are of no reader of this program.
    let (book, nothing) =
        (PaintBook { entries: vec![entry.clone()], ..PaintBook::default() }, PaintBook::default());
    store.commit(&book, &nothing).unwrap();
    store.commit(&nothing, &book).unwrap();
    for error in [store.check(&entry).unwrap_err(), store.patch(&entry).unwrap_err()] {
        let said = error.to_string();
        assert!(said.contains("was replaced while it was being read") && !said.contains("copy"), "{said}");
    }
}
