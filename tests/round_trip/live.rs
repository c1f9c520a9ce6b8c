//! The live view shows what was painted without being opened anew.

use quadratura::gpu::Gpu;
use quadratura::projection::{Picture, Renders, Shot};
use quadratura::recipe::import::take_back;
use quadratura::recipe::open::{Opened, open};
use quadratura::recipe::preview::{self, Preview, PreviewOptions};
use quadratura::task::Task;

use super::paper::Paper;
use super::{RED, SOFT, Studio};

fn preview(studio: &Studio, opened: &Opened) -> Preview {
    let (gpu, task) = (Gpu::headless().unwrap(), Task::silent());
    preview::open(&studio.site.project(), opened, &gpu, &PreviewOptions::default(), &task).unwrap()
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
    let renewed = live.renew_paint(&photos, &task).unwrap();
    assert_eq!(renewed.sheets, 1, "the wall's alone");
    let after = picture(&mut live, &opened);
    assert_ne!(after, before);
    assert!(after == picture(&mut preview(&studio, &opened), &opened), "as if it had been opened now");
    assert_eq!(live.renew_paint(&photos, &task).unwrap().sheets, 0, "nothing has changed since");

    take_back(&studio.site.project()).unwrap();
    live.renew_paint(&photos, &task).unwrap();
    assert!(picture(&mut live, &opened) == before, "as it was");
}
