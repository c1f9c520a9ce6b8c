//! The site as a web page, published from the window.

use std::fs;

use quadratura::testing::app::command;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::document::Project;

use crate::common;
use crate::harness::{appears, built_photos, is_there, opened, press, wait};

fn present(editor: &Editor) -> &Project {
    editor.session.as_ref().unwrap().history.present()
}

#[test]
fn a_page_with_a_text_is_published_what_it_says_is_kept_and_undo_takes_it_back() {
    let folder = tempfile::tempdir().unwrap();
    if common::adapter().is_none() {
        return;
    }
    let project = built_photos(folder.path(), "piazza", 2, true);
    let mut harness = opened(&project);
    harness.state_mut().run(&command::images::PUBLISH);
    appears(&mut harness, "2 of 2 photos are published");
    // The dialog takes clicks once its size is known and it has faded in.
    (0..6).for_each(|_| harness.step());
    press(&mut harness, "Add text");
    let dialog = harness.state_mut().dialogs.publish.as_mut().unwrap();
    (dialog.title, dialog.credits) = ("The square".into(), "Ann\nBob".into());
    let text = &mut dialog.texts[0];
    (text.title, text.text) = ("The church".into(), "The clock is late.".into());
    (text.at, text.language) = ("nowhere".into(), "en".into());
    dialog.longest = 1024;
    harness.step();
    press(&mut harness, "Publish");
    appears(&mut harness, "is not a point");
    assert!(harness.state().running.is_idle(), "nothing is written without a place for the text");
    assert_eq!(present(harness.state()).texts, []);
    harness.state_mut().dialogs.publish.as_mut().unwrap().texts[0].at = "church.facade[0]:0".into();
    harness.step();
    press(&mut harness, "Preview");
    wait(&mut harness, "the preview", |editor| {
        editor.dialogs.publish.as_ref().is_some_and(|dialog| dialog.done.is_some())
    });
    appears(&mut harness, "Nothing is published yet.");
    assert!(project.join("cache/page/index.html").is_file() && !project.join("page").exists());
    assert_eq!(present(harness.state()).texts, [], "a preview keeps nothing in the project");
    harness.state_mut().dialogs.publish.as_mut().unwrap().done = None;
    press(&mut harness, "Publish");
    wait(&mut harness, "the page", |editor| {
        editor.dialogs.publish.as_ref().is_some_and(|dialog| dialog.done.is_some())
    });
    appears(&mut harness, "Open page");
    assert!(is_there(&harness, "are needed for the first picture"));
    let index = fs::read_to_string(project.join("page/index.html")).unwrap();
    for said in ["<title>The square</title>", "<article lang=\"en\"><h2>The church</h2>", "<p>Bob</p>"] {
        assert!(index.contains(said), "{said}: {index}");
    }
    assert_eq!(present(harness.state()).page.credits, ["Ann", "Bob"]);
    assert_eq!(present(harness.state()).texts[0].title, "The church");
    press(&mut harness, "Close");
    harness.state_mut().run(&command::edit::UNDO);
    harness.step();
    assert!(present(harness.state()).texts.is_empty() && present(harness.state()).page.is_empty());
}
