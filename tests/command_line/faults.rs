//! What goes wrong is said with its place, and the rest goes on.

use std::fs;

use quadratura::testing::files::lock::ProjectLock;

use super::common::adapter;
use super::site::{PHOTOS, Site, json_of, stderr_of, stdout_of, whole_stacks};

#[test]
fn new_reports_all_that_is_wrong_at_once_and_leaves_nothing() {
    let site = Site::new();
    let failed =
        site.run("new project --photos pictures --cameras sparse --model model.fbx").failure().code(1);
    let message = stderr_of(&failed);
    assert!(message.contains("pictures") && message.contains("model.fbx"), "{message}");
    assert!(!site.project().exists());

    fs::write(site.path("sparse/cameras.txt"), "1 PINHOLE 160 120 nan 160 80 60\n").unwrap();
    fs::write(site.path("model.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    let failed = site.run("new project --photos photos --cameras sparse --model model.obj").failure().code(1);
    let message = stderr_of(&failed);
    assert!(message.contains("cameras.txt") && message.contains("line 1"), "{message}");
    assert!(message.contains("model.obj") && message.contains("line 2"), "{message}");
    let missing = "new project --photos photos --cameras sparse/7 --model model.obj";
    let message = stderr_of(&site.run(missing).failure().code(1));
    assert!(message.contains("sparse/7") && message.contains("there are cameras in sparse"), "{message}");
    assert!(!site.project().exists());
}

#[test]
fn new_refuses_a_folder_that_is_not_empty_and_leaves_it_alone() {
    let site = Site::new();
    fs::create_dir(site.project()).unwrap();
    fs::write(site.path("project/thesis.txt"), "mine").unwrap();
    let failed = site.run("new project --photos photos --cameras sparse --model model.obj").failure().code(1);
    assert!(stderr_of(&failed).contains("not empty (it contains thesis.txt)"));
    assert_eq!(fs::read_dir(site.project()).unwrap().count(), 1);
}

#[test]
fn a_folder_without_a_project_and_a_broken_project_are_named() {
    let site = Site::new();
    for command in ["check nowhere", "build nowhere", "info nowhere", "export nowhere --out out"] {
        let message = stderr_of(&site.run(command).failure().code(1));
        assert!(message.contains("nowhere") && message.contains("quadratura new"), "{message}");
        assert!(!site.path("nowhere").exists());
    }
    site.make_project();
    let file = site.path("project/project.json");
    let broken = fs::read_to_string(&file).unwrap().replace("\"margin\": 1", "\"margin\": one");
    fs::write(&file, broken).unwrap();
    let message = stderr_of(&site.run("info project").failure().code(1));
    assert!(message.contains("project.json, line 16 column 15"), "{message}");
}

#[test]
fn a_place_that_cannot_be_written_to_is_told_before_the_work() {
    let site = Site::new();
    site.make_project();
    // Nothing of the work is possible, so that only the place can be what is told: there is no stack and no image.
    fs::write(site.path("file"), "mine").unwrap();
    for words in [
        "render project --cameras photos --out file/views",
        "render project --cameras photos --out views --video file/flight.apng",
        "render project --through left,left --out views --write-path file/path.json",
        "score project --pictures file/views",
        "export project --out file/layers",
        "export project --format cameras --out file/cameras",
        "export project --format blender --out file/blender",
        "export project --format glb --out file/glb",
        "export project --format usd --out file",
        "ldi build project --photo left --from site --out file/left.ldi",
        "ldi build project --photo left --cube --out file/left.ldi",
        "ldi render left.ldi --out file",
        "ldi export left.ldi --format page --out file/page",
        "ldi export left.ldi --format page --out file",
        "ldi export left.ldi --format ply --out file/points.ply",
        "tree render oak --cameras orbit --out file/views",
        "tree render oak --cameras orbit --method flakes --images file --out views",
        "tree export project oak --out file/layers",
        "info project --json-file file/info.json",
    ] {
        let message = stderr_of(&site.run(words).failure().code(1));
        assert!(message.contains("file: this is a file"), "{words}: {message}");
        assert_eq!(message.matches("error:").count(), 1, "{words}: {message}");
    }
    assert!(!site.path("views").exists() && fs::read_to_string(site.path("file")).unwrap() == "mine");
    let named = stderr_of(&site.run("ldi build project --photo left --out left.txt").failure().code(1));
    assert!(named.contains("left.txt") && named.contains("write to left.ldi"), "{named}");
}

/// Every format of `export`.
const FORMATS: [&str; 12] =
    ["psd", "folder", "xcf", "ora", "blender", "cameras", "glb", "obj", "usd", "exr", "nuke", "page"];

#[test]
fn every_format_names_the_folder_that_cannot_be_written_to_and_what_to_do() {
    let site = Site::new();
    site.make_project();
    let all = stderr_of(&site.run("export project --format nothing --out x").code(2));
    for format in FORMATS {
        assert!(all.contains(format), "{format}: {all}");
    }
    fs::write(site.path("file"), "mine").unwrap();
    let mut places = vec![("file", "file: this is a file", "give another place")];
    places.push(("file/below", "below cannot be in it", "give another place"));
    // Not even the system's administrator, who runs tests in containers, may write there.
    if cfg!(target_os = "linux") {
        places.push(("/sys/quadratura", "/sys: could not write to this folder", "give yourself permission"));
        places.push(("/sys", "/sys: could not write to this folder", "give yourself permission"));
    }
    for (place, found, remedy) in places {
        for format in FORMATS {
            let failed = site.run(&format!("export project --format {format} --out {place}")).code(1);
            let said = stderr_of(&failed);
            assert!(said.contains(found) && said.contains(remedy), "{format} to {place}: {said}");
            assert_eq!(said.matches("error:").count(), 1, "{format} to {place}: {said}");
        }
    }
    assert_eq!(fs::read_to_string(site.path("file")).unwrap(), "mine");
}

#[test]
fn a_camera_path_that_is_none_is_told_without_the_names_of_types() {
    let site = Site::new();
    fs::write(site.path("path.json"), "[]").unwrap();
    let message = stderr_of(&site.run("tree render oak --cameras path.json --out views").failure().code(1));
    assert!(
        message.contains("path.json") && message.contains("a list of 0 values, expected an object, {...}"),
        "{message}"
    );
    fs::write(site.path("depths.json"), "[]").unwrap();
    let build = "ldi build --depth-images depths.json --reference a.png --out a.ldi";
    let message = stderr_of(&site.run(build).failure().code(1));
    assert!(message.contains("expected an object, {...}") && !message.contains("struct"), "{message}");
}

#[test]
fn an_error_is_json_too_where_json_is_wanted() {
    let site = Site::new();
    let failed = json_of(&site.run("info nowhere --json").failure().code(1));
    assert!(failed["error"].as_str().unwrap().contains("nowhere"), "{failed}");
}

#[test]
fn a_missing_photo_is_a_failure_and_the_others_are_built() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    fs::remove_file(site.path("photos/left.png")).unwrap();
    let failed = site.run("build project --json").failure().code(1);
    assert!(stderr_of(&failed).contains("left.png"), "{}", stderr_of(&failed));
    let result = json_of(&failed);
    assert_eq!(result["photos"][0]["photo"], PHOTOS[1]);
    assert_eq!(result["photos"][0]["state"], "built");
    assert_eq!(result["problems"].as_array().unwrap().len(), 1);
    assert_eq!(whole_stacks(&site.project()), 1);
    let info = site.run("info project").failure().code(1);
    let table = stdout_of(&info);
    let row = table.lines().find(|line| line.starts_with("left.png")).unwrap_or_default();
    assert!(table.contains("1 photo (and 1 left out)") && row.ends_with("left out"), "{table}");
    assert_eq!(stderr_of(&info).matches("left.png").count(), 1, "{}", stderr_of(&info));
    // Who asks for the photo that is there gets it.
    site.command("build project --photo").arg("tür 2").assert().success();
}

#[test]
fn a_photo_that_breaks_off_in_the_middle_fails_alone() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let file = site.path("photos/left.png");
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let failed = site.run("build project --json").failure().code(1);
    assert!(stderr_of(&failed).contains("left.png"), "{}", stderr_of(&failed));
    assert_eq!(whole_stacks(&site.project()), 1);
    assert!(
        !fs::read_dir(site.path("project/stacks"))
            .unwrap()
            .any(|entry| { entry.unwrap().file_name().to_string_lossy().starts_with('+') })
    );
}

#[test]
fn a_jpeg_that_is_cut_short_is_left_out_by_new_and_build_and_the_other_goes_on() {
    let site = Site::with_photos(&["left.jpg", "right.jpg"], 160, 120, 1);
    let file = site.path("photos/left.jpg");
    let whole = fs::read(&file).unwrap();
    let cut = || fs::write(&file, &whole[..whole.len() / 2]).unwrap();
    cut();
    let new = site.run("new project --photos photos --cameras sparse --model model.obj").failure().code(1);
    let message = stderr_of(&new);
    assert!(
        message.contains("left.jpg") && message.contains("cut short") && message.contains("copy the file"),
        "{message}"
    );
    assert!(site.path("project/project.json").is_file(), "the project is made of the other");
    if adapter().is_none() {
        return;
    }
    fs::write(&file, &whole).unwrap();
    site.run("build project").success();
    cut();
    let built = site.run("build project --force --json").failure().code(1);
    assert!(stderr_of(&built).contains("cut short"));
    assert_eq!(json_of(&built)["photos"].as_array().unwrap().len(), 1);
}

#[test]
fn a_whole_stack_that_cannot_be_read_is_a_failure_and_pictures_are_made_of_the_others() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("build project -q").success();
    fs::write(site.path("project/stacks/left.png/stack.json"), "{").unwrap();
    for command in ["render project --cameras photos --out out --json", "score project --json"] {
        let done = site.run(command).failure().code(1);
        let problems = &json_of(&done)["problems"];
        let message = problems[0].as_str().unwrap();
        assert!(
            message.contains("left.png") && message.contains("quadratura update"),
            "{command}: {problems:#}"
        );
    }
    assert_eq!(fs::read_dir(site.path("out")).unwrap().count(), 2, "both views are drawn");
    let info = site.run("info project").failure().code(1);
    assert!(super::site::stdout_of(&info).contains("broken"), "the table is shown all the same");
}

#[test]
fn a_photo_whose_file_is_gone_is_told_so_wherever_it_is_asked_for() {
    let site = Site::new();
    site.make_project();
    fs::remove_file(site.path("photos/left.png")).unwrap();
    for command in ["export project --photo left --out layers", "info project --photo left.png"] {
        let message = stderr_of(&site.run(command).failure().code(1));
        assert!(
            message.contains("left.png is left out") && message.contains("no file of this name"),
            "{command}: {message}"
        );
    }
}

#[test]
fn where_the_photos_are_gone_it_is_said_where_that_is_written() {
    let site = Site::new();
    site.make_project();
    fs::rename(site.path("photos"), site.path("pictures")).unwrap();
    let message = stderr_of(&site.run("info project").failure().code(1));
    assert!(message.contains("project.json") && message.contains("\"photos\""), "{message}");
}

#[test]
fn an_object_that_the_model_lacks_is_answered_with_those_that_it_has() {
    let site = Site::new();
    site.make_project();
    let message = stderr_of(&site.run("fill project --without nope").failure().code(1));
    assert!(
        message.contains("\"nope\"") && message.contains("\"shed\"") && message.contains("\"wall\""),
        "{message}"
    );
}

#[test]
fn what_colour_decides_of_all_photos_or_twice_of_one_is_said() {
    let site = Site::new();
    site.make_project();
    let all = site.command("colour project --leave-out left --leave-out").arg("tür 2").assert().success();
    let message = super::site::stdout_of(&all);
    assert!(message.contains("All photos are left out") && message.contains("--free"), "{message}");
    let both = site.run("colour project --reset --fix left=0.5 --leave-out left").success();
    assert!(stderr_of(&both).contains("both fixed and left out"), "{}", stderr_of(&both));
}

#[test]
fn a_photo_that_nobody_knows_is_refused_by_name() {
    let site = Site::new();
    site.make_project();
    let message = stderr_of(&site.run("info project --photo right.png").failure().code(1));
    assert!(message.contains("right.png"), "{message}");
    let message = stderr_of(&site.run("info project --face roof[0]").failure().code(1));
    assert!(message.contains("roof"), "{message}");
    let message = stderr_of(&site.run("info project --face wall[7]").failure().code(1));
    assert!(message.contains("1 face"), "{message}");
}

#[test]
fn exports_are_not_written_among_the_files_of_a_project() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("build project --photo left").success();
    for place in ["project", "project/stacks", "project/paint/new"] {
        let message = stderr_of(&site.run(&format!("export project --out {place}")).failure().code(1));
        assert!(message.contains("belongs to the project"), "{message}");
    }
    assert!(!site.path("project/paint/new").exists() && !site.path("project/left.png.psd").exists());
    site.run("export project --out project/layers").success();
    assert!(site.path("project/layers/left.png.psd").is_file());
}

#[test]
fn exporting_what_was_not_built_says_what_to_do() {
    let site = Site::new();
    site.make_project();
    let message = stderr_of(&site.run("export project --out layers").failure().code(1));
    assert_eq!(message.matches("quadratura update").count(), 1, "once for all: {message}");
    if adapter().is_none() {
        return;
    }
    site.run("build project --photo left").success();
    let done = site.run("export project --out layers --json").success();
    let note = stderr_of(&done);
    assert!(
        note.contains("not exported: north side/tür 2.png") && note.contains("quadratura update"),
        "{note}"
    );
    assert_eq!(json_of(&done)["photos"].as_array().unwrap().len(), 1);
    site.command("export project --out layers --photo").arg("tür 2").assert().failure().code(1);
}

#[test]
fn the_second_writer_is_told_who_the_first_is() {
    let site = Site::new();
    site.make_project();
    let _lock = ProjectLock::take(&site.project()).unwrap();
    let message = stderr_of(&site.run("decide project --photo left --margin 5").failure().code(1));
    assert!(message.contains(&format!("process {}", std::process::id())), "{message}");
    site.run("info project").success();
}

#[test]
fn paint_on_a_guide_of_a_folder_is_reported() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("build project -q").success();
    site.run("export project --photo left --out layers --format folder").success();
    let nothing = site.json("import project layers/left.png.layers --json").to_string();
    assert!(!nothing.contains("not imported"), "guides as they were exported are no news: {nothing}");
    let guides = fs::read_dir(site.path("layers/left.png.layers/guides")).unwrap();
    let guide = guides.map(|entry| entry.unwrap().path()).next().unwrap();
    let mut picture = image::open(&guide).unwrap().to_rgba8();
    picture.put_pixel(picture.width() / 2, picture.height() / 2, image::Rgba([250, 20, 30, 255]));
    picture.save(&guide).unwrap();
    let told = site.json("import project layers/left.png.layers --json").to_string();
    assert!(told.contains("it was painted on, but this paint is not imported"), "{told}");
}
