//! The editor's window without a display, driven by the names of its widgets.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use eframe::egui::{Event, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use image::imageops::FilterType;
use quadratura::task::Task;
use quadratura::testing::app::command;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::sites::create::{NewProject, create_project};
use tempfile::TempDir;

/// A guard against waiting for ever, far beyond what any step takes.
const NEVER: Duration = Duration::from_secs(600);

/// A window, with a project or without.
pub fn window(project: Option<PathBuf>) -> Harness<'static, Editor> {
    let builder = Harness::builder().with_size([1280.0, 800.0]);
    builder.build_eframe(|creation| {
        let mut editor = Editor::new(&creation.egui_ctx, None, project);
        // Most tests look at what one command does.
        editor.settings.keep_up_to_date = false;
        editor
    })
}

/// The window of a project, when it is open and nothing runs.
pub fn opened(project: &Path) -> Harness<'static, Editor> {
    let mut harness = window(Some(project.to_path_buf()));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    harness
}

/// A project of the piazza's first photos, made smaller, in a folder of its own.
pub fn first_photos(folder: &Path, photos: usize) -> PathBuf {
    let (site, project) = (folder.join("site"), folder.join("project"));
    small_piazza(&site, photos);
    project_of(&site, &project);
    project
}

/// A project of the piazza's first photos with layers of `all` of them or of the first only, and with what the window keeps
/// beside them, as `name` in a folder of its own. A window builds it once for all tests, which get copies.
pub fn built_photos(folder: &Path, name: &str, photos: usize, all: bool) -> PathBuf {
    static BUILT: [[OnceLock<TempDir>; 10]; 2] = [const { [const { OnceLock::new() }; 10] }; 2];
    let built = BUILT[usize::from(all)][photos].get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let mut harness = opened(&first_photos(folder.path(), photos));
        let build = if all { &command::layers::BUILD } else { &command::layers::BUILD_PHOTO };
        harness.state_mut().run(build);
        wait(&mut harness, "the layers to copy", |editor| {
            editor.space.device.is_some() && editor.running.is_idle()
        });
        wait(&mut harness, "a picture of the layers to copy", |editor| editor.space.has_picture());
        wait(&mut harness, "what is kept beside the layers", |editor| editor.running.is_idle());
        folder
    });
    copy(&built.path().join("site"), &folder.join("site"));
    copy(&built.path().join("project"), &folder.join(name));
    folder.join(name)
}

/// Copies a folder with the times of its files, by which layers know whether these have changed.
fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(|entry| entry.unwrap()) {
        let (old, new) = (entry.path(), to.join(entry.file_name()));
        if old.is_dir() {
            copy(&old, &new);
        } else {
            fs::copy(&old, &new).unwrap();
            let changed = old.metadata().unwrap().modified().unwrap();
            fs::File::options().append(true).open(&new).unwrap().set_modified(changed).unwrap();
        }
    }
}

/// The time between two frames while a test waits: frames leave the processor's cores to the work that is waited for.
const BETWEEN: Duration = Duration::from_millis(25);

/// Lets frames go by until something is as it should be.
pub fn wait(harness: &mut Harness<'_, Editor>, what: &str, done: impl Fn(&Editor) -> bool) {
    wait_for_window(harness, what, |harness| done(harness.state()));
    harness.step();
}

/// Lets frames go by until a widget has these words in its name.
pub fn appears(harness: &mut Harness<'_, Editor>, words: &str) {
    harness.step();
    wait_for_window(harness, words, |harness| is_there(harness, words));
}

fn wait_for_window(
    harness: &mut Harness<'_, Editor>,
    what: &str,
    done: impl Fn(&Harness<'_, Editor>) -> bool,
) {
    let start = Instant::now();
    while !done(harness) {
        harness.step();
        std::thread::sleep(BETWEEN);
        let notes: Vec<String> =
            harness.state().notes.list().iter().map(|note| note.text.to_string()).collect();
        assert!(start.elapsed() < NEVER, "waiting for {what:?}: {notes:?}");
    }
}

/// A widget has these words in its name.
pub fn is_there(harness: &Harness<'_, Editor>, words: &str) -> bool {
    harness.query_all_by_label_contains(words).next().is_some()
}

/// Clicks what has this name, and lets the window do it.
pub fn press(harness: &mut Harness<'_, Editor>, name: &str) {
    harness.get_by_label(name).click();
    harness.step();
    harness.step();
}

/// Runs a command by its name in the palette.
pub fn command(harness: &mut Harness<'_, Editor>, name: &str) {
    let command = command::all().find(|command| command.name == name).unwrap();
    assert_eq!((command.ready)(harness.state()), Ok(()), "{name}");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::P);
    harness.step();
    harness.step();
    harness.event(Event::Text(name.into()));
    harness.step();
    harness.key_press(Key::Enter);
    harness.step();
    harness.step();
}

/// The site that comes with the program.
pub fn site_of_piazza() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("projects/piazza")
}

/// A copy of it with its first photos, so that it is quick.
pub fn copy_of_piazza(to: &Path, photos: usize) {
    let from = site_of_piazza();
    let mut files = files_of(&from.join("photos"));
    files.truncate(photos);
    files.extend(files_of(&from.join("sparse")));
    files.push(from.join("piazza.obj"));
    for file in files {
        let copy = to.join(file.strip_prefix(&from).unwrap());
        fs::create_dir_all(copy.parent().unwrap()).unwrap();
        fs::copy(&file, &copy).unwrap();
    }
}

/// The factor by which photos are made smaller for tests that make layers.
const SMALLER: u32 = 4;

/// The width and height of these smaller photos, in pixels.
pub const SMALL_SIZE: [u32; 2] = [2160 / SMALLER, 1440 / SMALLER];

/// A copy of it with its first photos, made smaller.
pub fn small_piazza(to: &Path, photos: usize) {
    copy_of_piazza(to, photos);
    for photo in files_of(&to.join("photos")) {
        let pixels = image::open(&photo).unwrap().into_rgb8();
        let (width, height) = (pixels.width() / SMALLER, pixels.height() / SMALLER);
        image::imageops::resize(&pixels, width, height, FilterType::Triangle).save(&photo).unwrap();
    }
    let smaller = |number: &str| (number.parse::<f64>().unwrap() / f64::from(SMALLER)).to_string();
    // Number and model come before all that is in pixels.
    let camera = |line: &str| {
        let in_pixels =
            |(place, word): (usize, &str)| if place < 2 { word.to_owned() } else { smaller(word) };
        line.split_whitespace().enumerate().map(in_pixels).collect::<Vec<_>>().join(" ")
    };
    // Of each point two coordinates, then its number; every other line has points.
    let points = |line: &str| {
        let in_pixels =
            |(place, word): (usize, &str)| if place % 3 == 2 { word.to_owned() } else { smaller(word) };
        line.split_whitespace().enumerate().map(in_pixels).collect::<Vec<_>>().join(" ")
    };
    let written = |name: &str, changed: &dyn Fn(usize, &str) -> String| {
        let file = to.join("sparse").join(name);
        let text = fs::read_to_string(&file).unwrap();
        let lines = text.lines().filter(|line| !line.starts_with('#')).enumerate();
        let lines: Vec<String> = lines.map(|(place, line)| changed(place, line)).collect();
        fs::write(&file, lines.join("\n") + "\n").unwrap();
    };
    written("cameras.txt", &|_, line| camera(line));
    written("images.txt", &|place, line| if place % 2 == 1 { points(line) } else { line.to_owned() });
}

fn files_of(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Makes a project of a site that has the piazza's files.
pub fn project_of(site: &Path, project: &Path) {
    let new = NewProject {
        photos: site.join("photos"),
        cameras: site.join("sparse"),
        model: site.join("piazza.obj"),
        ..NewProject::default()
    };
    create_project(project, &new, &Task::silent()).unwrap();
}
