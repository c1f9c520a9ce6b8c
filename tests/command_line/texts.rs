//! Texts at places, and what a page says beside them.

use std::fs;

use super::site::{Site, stderr_of, stdout_of};

#[test]
fn texts_are_added_listed_replaced_and_removed() {
    let site = Site::new();
    site.make_project();
    let before = fs::read_to_string(site.path("project/project.json")).unwrap();
    assert!(stdout_of(&site.run("text list project").success()).contains("no texts yet"));
    let added = site.json("text add project --title Wall --text Old. --at wall[0]:0 --language en --json");
    // The first corner of the face that the model's file lists as `f 4 3 2 1`.
    assert_eq!(added["texts"][0]["at"], serde_json::json!([20.0, -20.0, 12.0]));
    // The middle of the left photo shows what is straight before the camera at 0, 0, 0: the box.
    let pixel = site.json("text add project --title Box --text New. --at left:80,60 --json");
    let depth = pixel["texts"][1]["at"][2].as_f64().unwrap();
    assert!((depth - 6.0).abs() < 1e-9, "{pixel}: rounding of a ray's hit alone");
    let twice = stderr_of(&site.run("text add project --title Wall --text x --at 0,0,0").failure());
    assert!(
        twice.contains("text 1 already has the title \"Wall\"") && twice.contains("--replace"),
        "{twice}"
    );
    let replaced = site.json("text add project --title Wall --text Older. --at 1,2,3 --replace --json");
    assert_eq!(
        (&replaced["texts"][0]["text"], replaced["texts"].as_array().unwrap().len()),
        (&"Older.".into(), 2)
    );
    let listed = stdout_of(&site.run("text list project").success());
    assert!(listed.contains("1.000,2.000,3.000") && listed.contains("Older."), "{listed}");
    let left = site.json("text remove project 2 Wall --json");
    assert_eq!(left["texts"], serde_json::json!([]));
    assert_eq!(fs::read_to_string(site.path("project/project.json")).unwrap(), before);
}

#[test]
fn texts_of_a_file_are_all_added_or_none() {
    let site = Site::new();
    site.make_project();
    let before = fs::read_to_string(site.path("project/project.json")).unwrap();
    let text = |rest: &str| format!(r#"{{"title": "A", "text": "b", "at": [1, 2, 3]{rest}}}"#);
    for (content, meant) in [
        (format!("[{}]", text(r#", "link": "javascript:alert(1)""#)), "has the link \"javascript:alert(1)\""),
        (format!("[{}]", text(r#", "view": "the gate""#)), "no bookmark \"the gate\"; it has none"),
        (format!("[{}, {}]", text(""), text("")), "already has the title \"A\""),
        (r#"[{"title": "A"}]"#.to_owned(), "missing field `text`"),
        (format!("[{}]", text(r#", "colour": 1"#)), "colour"),
    ] {
        fs::write(site.path("texts.json"), &content).unwrap();
        let refused = stderr_of(&site.run("text add project texts.json").failure());
        assert!(refused.contains(meant), "{content}: {refused}");
    }
    assert_eq!(fs::read_to_string(site.path("project/project.json")).unwrap(), before, "nothing changed");
    let missing = stderr_of(&site.run("text remove project 7").failure());
    assert!(missing.contains("there is no text \"7\""), "{missing}");
}

#[test]
fn what_a_page_says_is_kept_and_forgotten() {
    let site = Site::new();
    site.make_project();
    let before = fs::read_to_string(site.path("project/project.json")).unwrap();
    let about =
        site.json("text about project --title Square --credit Ann --credit Bob --licence CC-BY-4.0 --json");
    let said = serde_json::json!({"title": "Square", "credits": ["Ann", "Bob"], "licence": "CC-BY-4.0"});
    assert_eq!(about["page"], said);
    assert_eq!(site.json("text about project --json")["page"], said, "without options it is shown");
    site.command("text about project")
        .args(["--title", "", "--credit", "", "--licence", ""])
        .assert()
        .success();
    assert_eq!(fs::read_to_string(site.path("project/project.json")).unwrap(), before);
}
