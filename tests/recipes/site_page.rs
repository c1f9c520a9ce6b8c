//! Pages of whole sites: what is in them and what is not. What they show is looked at by `sh tests/page.sh`, in a browser.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common;
use quadratura::task::Task;
use quadratura::testing::document::PlaceText;
use quadratura::testing::exports::page::{PageOptions, Published, leaving, publish};
use quadratura::testing::scene::Photo;
use quadratura::testing::stacks::tiny_site::tiny_stacks;

/// The files of a page by their paths.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(at) = folders.pop() {
        for entry in fs::read_dir(&at).unwrap().flatten() {
            match entry.path() {
                path if path.is_dir() => folders.push(path),
                path => {
                    let name = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
                    found.insert(name, fs::read(&path).unwrap());
                }
            }
        }
    }
    found
}

#[test]
fn a_page_has_no_names_of_photos_and_the_same_bytes_each_time() {
    let Some(gpu) = common::gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (project, mut opened) = tiny_stacks(folder.path()).unwrap();
    opened.project.page.credits = vec!["Ann & Bob".to_owned()];
    opened.project.texts = vec![PlaceText {
        title: "The <b>gate</b>".to_owned(),
        text: "It is shut.".to_owned(),
        at: [0.0, 0.0, 12.0],
        link: Some("https://example.org/?a&b".to_owned()),
        view: None,
        language: Some("en".to_owned()),
    }];
    let photos: Vec<&Photo> = opened.site.photos.iter().collect();
    let title = "<script>\u{2028}".to_owned();
    let options =
        PageOptions { title: Some(title), licence: Some("CC0-1.0".to_owned()), ..PageOptions::default() };
    let page = |name: &str| -> Published {
        publish(&project, &opened, &photos, &folder.path().join(name), &options, &gpu, &Task::silent())
            .unwrap()
    };
    let (one, two) = (page("one"), page("two"));
    let content = files(&one.folder);
    assert!(content == files(&two.folder), "the same project has the same page");
    assert_eq!(one.photos, leaving(&photos, &options));
    for (name, bytes) in content.iter().filter(|(name, _)| !name.ends_with(".jpg")) {
        let text = String::from_utf8_lossy(bytes);
        for photo in &photos {
            assert!(!text.contains(&photo.name), "{name} names {}", photo.name);
        }
        assert!(!text.contains("<script>\u{2028}"), "{name}: a title is no markup");
        let is_script = name.ends_with(".js");
        assert!(!is_script || !text.contains('\u{2028}'), "{name}: a title ends no line of a script");
    }
    for name in [
        "index.html",
        "code/painter.js",
        "data/site.js",
        "data/geometry.js",
        "data/far-1.js",
        "data/near-2.js",
        "poster.jpg",
    ] {
        assert!(content.contains_key(name), "{name} is missing: {:?}", content.keys());
    }
    let index = String::from_utf8_lossy(&content["index.html"]);
    let article = "<article lang=\"en\"><h2>The &lt;b&gt;gate&lt;/b&gt;</h2><p>It is shut.</p><p><a \
                   href=\"https://example.org/?a&amp;b\">";
    assert!(index.contains(article) && index.contains("<p>Ann &amp; Bob</p>"), "{index}");
    let sum: u64 = content.values().map(|bytes| bytes.len() as u64).sum();
    assert_eq!((one.bytes, one.viewer < 120_000), (sum, true));
}

#[test]
fn a_viewpoint_that_there_is_not_is_refused_before_anything_is_written() {
    let Some(gpu) = common::gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (project, opened) = tiny_stacks(folder.path()).unwrap();
    let photos: Vec<&Photo> = opened.site.photos.iter().collect();
    let options = PageOptions { viewpoint: Some("gate".to_owned()), ..PageOptions::default() };
    let out = folder.path().join("page");
    let refused =
        publish(&project, &opened, &photos, &out, &options, &gpu, &Task::silent()).unwrap_err().to_string();
    assert!(refused.contains("\"gate\"") && refused.contains("none"), "{refused}");
    assert!(!out.exists());
}
