//! The live view shows what was painted and decided without being opened anew.

use quadratura::task::Task;
use quadratura::testing::document::Project;
use quadratura::testing::document::paint::PaintBook;
use quadratura::testing::editing::import::take_back;
use quadratura::testing::gpu::Gpu;
use quadratura::testing::io::paint_store::PaintStore;
use quadratura::testing::layers::Faces;
use quadratura::testing::projection::Renders;
use quadratura::testing::sites::open::{Opened, open};
use quadratura::testing::view::{Picture, Shot};
use quadratura::testing::views::preview::{self, Preview, PreviewOptions};

use super::paper::Paper;
use super::site::Site;
use super::{RED, SOFT, Studio, adapter};

fn preview(studio: &Studio, opened: &Opened) -> Preview {
    let (gpu, task) = (Gpu::headless().unwrap(), Task::silent());
    preview::open(
        &studio.site.project(),
        &opened.project,
        &opened.site,
        &gpu,
        &PreviewOptions::default(),
        &task,
    )
    .unwrap()
}

/// The project's paint as it is on disk.
fn book(studio: &Studio) -> PaintBook {
    PaintStore::new(&studio.site.project()).read().unwrap()
}

fn picture(preview: &mut Preview, opened: &Opened) -> Picture {
    let photo = &opened.site.photos[0];
    preview.picture(&Shot::new(photo.camera, photo.pose), &Task::silent()).unwrap()
}

#[test]
fn paint_that_comes_home_and_is_taken_back_shows_in_a_view_that_stays_open() {
    let Some(studio) = Studio::new("psd") else { return };
    let task = Task::silent();
    let opened = open(&studio.site.project(), &task).unwrap();
    let mut live = preview(&studio, &opened);
    let before = picture(&mut live, &opened);

    let mut paper = Paper::read(&studio.file());
    let wall = paper.sheet("wall");
    let (shown, empty) = (wall.pixels_where(true), wall.pixels_where(false));
    shown.iter().step_by(3).for_each(|(x, y)| wall.paint(*x, *y, RED));
    empty.iter().for_each(|(x, y)| wall.paint(*x, *y, SOFT));
    paper.write(&studio.file());
    studio.import();

    let photos = [opened.site.photos[0].name.clone()];
    let renewed = live.reload_paint(&photos, &book(&studio), &task).unwrap();
    assert_eq!(renewed, 1, "the wall's alone");
    let after = picture(&mut live, &opened);
    assert_ne!(after, before);
    assert!(after == picture(&mut preview(&studio, &opened), &opened), "as if it had been opened now");
    assert_eq!(live.reload_paint(&photos, &book(&studio), &task).unwrap(), 0, "nothing has changed since");

    take_back(&studio.site.project()).unwrap();
    live.reload_paint(&photos, &book(&studio), &task).unwrap();
    assert!(picture(&mut live, &opened) == before, "as it was");
}

#[test]
fn what_is_decided_about_faces_and_photos_shows_in_a_view_that_stays_open() {
    if adapter().is_none() {
        return;
    }
    let studio = Studio { site: Site::with_photos(&["left.png", "right.png"], 160, 120, 1), format: "psd" };
    studio.site.make_project();
    studio.site.run("build project -q").success();
    let project = studio.site.project();
    let opened = open(&project, &Task::silent()).unwrap();
    let mut live = preview(&studio, &opened);
    let before = picture(&mut live, &opened);

    let object = opened.site.model.objects[0].name.clone();
    let of = vec![Faces { object, faces: Vec::new() }];
    let mut pictures = vec![before.clone()];
    for pinned in [false, true] {
        let mut decided = opened.project.decisions.of("left.png");
        (if pinned { &mut decided.pin } else { &mut decided.exclude }).clone_from(&of);
        let mut after = Project::clone(&opened.project);
        after.decisions.set("left.png", decided);
        let after = opened.with_project(&project, after);
        live.redecide(&after.site, &after.project.decisions).unwrap();
        let shown = picture(&mut live, &opened);
        assert!(shown == picture(&mut preview(&studio, &after), &opened), "as if it had been opened now");
        pictures.push(shown);
    }
    assert!(pictures[1] != pictures[0], "the other photo alone serves what the first one does not");
    live.redecide(&opened.site, &opened.project.decisions).unwrap();
    assert!(picture(&mut live, &opened) == before, "as it was");
}
