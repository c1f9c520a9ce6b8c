//! Discovery in folders with typical structures.

use std::fs;

use super::*;

const CAMERAS: &str = "1 PINHOLE 8 6 9 9 4 3\n";

/// Makes files: images and models are empty, lists of photos name what is given after `=`.
fn site(files: &[&str]) -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    for file in files {
        let (file, names) = file.split_once('=').unwrap_or((file, ""));
        let path = root.path().join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let lines = names.split(' ').filter(|name| !name.is_empty()).enumerate();
        let text: String = lines.map(|(i, name)| format!("{} 1 0 0 0 0 0 0 1 {name}\n\n", i + 1)).collect();
        fs::write(&path, if file.ends_with("cameras.txt") { CAMERAS.into() } else { text }).unwrap();
    }
    root
}

fn found(root: &Path) -> [Vec<String>; 3] {
    let candidates = find_site(root, &Task::silent()).unwrap();
    let below = |path: &PathBuf| path.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
    SitePart::ALL.map(|part| candidates.of(part).iter().map(below).collect())
}

#[test]
fn a_folder_as_colmap_leaves_it_is_found_whole() {
    let root = site(&[
        "images/a.jpg",
        "images/b.jpg",
        "sparse/0/cameras.txt",
        "sparse/0/images.txt=a.jpg b.jpg",
        "castle.obj",
        "castle.gltf",
        "masks/a.png",
    ]);
    let [photos, cameras, models] = found(root.path());
    assert_eq!(photos[0], "images");
    assert_eq!(cameras, ["sparse/0"]);
    assert_eq!(models, ["castle.obj", "castle.gltf"]);
}

#[test]
fn the_folder_that_holds_the_photos_the_cameras_name_comes_first_whatever_its_name() {
    let root = site(&[
        "images/x.jpg",
        "site visit/north/a.jpg",
        "site visit/south/a.jpg",
        "cameras.txt",
        "images.txt=north/a.jpg south/a.jpg",
    ]);
    assert_eq!(found(root.path())[0][0], "site visit");
}

#[test]
fn of_several_reconstructions_the_one_of_most_photos_comes_first() {
    let root = site(&[
        "sparse/0/cameras.txt",
        "sparse/0/images.txt=a.jpg",
        "sparse/1/cameras.txt",
        "sparse/1/images.txt=a.jpg b.jpg c.jpg",
    ]);
    assert_eq!(found(root.path())[1], ["sparse/1", "sparse/0"]);
}

#[test]
fn a_coarse_model_comes_before_a_dense_mesh_and_projects_are_passed_by() {
    let root = site(&["a/meshed-poisson.obj", "house/coarse.glb", "work/project.json", "work/other.obj"]);
    fs::write(root.path().join("b.txt"), "").unwrap();
    assert_eq!(found(root.path())[2], ["house/coarse.glb", "a/meshed-poisson.obj"]);
}

#[test]
fn what_is_wrong_is_told_part_by_part_and_read_again_only_where_the_path_or_the_files_changed() {
    let root = site(&["images/a.jpg", "cameras.txt", "images.txt=a.jpg b.jpg", "house.obj"]);
    let mut parts = SiteParts {
        photos: root.path().join("images"),
        cameras: root.path().to_path_buf(),
        model: root.path().join("house.obj"),
    };
    let look = look_at(&parts, None, &Task::silent()).unwrap();
    let matched = look.matched.as_ref().unwrap();
    assert_eq!((matched.found, matched.of, matched.missing.as_slice()), (1, 2, ["b.jpg".into()].as_slice()));
    let error = look.error(SitePart::Model).unwrap();
    assert!(error.to_string().contains("the file is empty"), "{error}");
    assert!(!look.is_whole());
    assert_eq!(parts.part_of_error(error), Some(SitePart::Model));

    fs::write(&parts.model, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let again = look_at(&parts, Some(&look), &Task::silent()).unwrap();
    assert!(again.is_whole(), "the model was exported again");
    let same = |a: &DiscoveryReport, b: &DiscoveryReport| {
        std::sync::Arc::ptr_eq(a.cameras.found.as_ref().unwrap(), b.cameras.found.as_ref().unwrap())
    };
    let third = look_at(&parts, Some(&again), &Task::silent()).unwrap();
    assert!(!same(&look, &again) && same(&again, &third), "a folder changes with what is in it");
    parts.model = root.path().join("house-2.obj");
    fs::write(&parts.model, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    parts.photos = PathBuf::new();
    let look = look_at(&parts, Some(&look), &Task::silent()).unwrap();
    assert_eq!(look.model.good().map(|model| (model.objects, model.faces)), Some((1, 1)));
    assert!(look.photos.found.is_none() && look.matched.is_none());
}

#[test]
fn an_error_belongs_to_the_part_whose_path_is_nearest_above_it() {
    let parts = SiteParts { photos: "s/images".into(), cameras: "s".into(), model: "s/house.obj".into() };
    let part = |file: &str| parts.part_of_error(&Error::input(file, "", "", ""));
    assert_eq!(part("s/images/a.jpg"), Some(SitePart::Photos));
    assert_eq!(part("s/images.txt"), Some(SitePart::Cameras));
    assert_eq!(part("s/house.obj"), Some(SitePart::Model));
    assert_eq!(part("elsewhere"), None);
    assert_eq!(parts.part_of_error(&Error::Request("the folder is not empty".into())), None);
}

#[test]
fn a_file_that_is_dropped_is_known_by_its_name() {
    let root = site(&["m.GLB", "sparse/cameras.txt", "sparse/images.txt", "photos/a.jpg"]);
    let part = |below: &str| part_at(&root.path().join(below));
    assert_eq!(part("m.GLB"), Some(SitePart::Model));
    assert_eq!(part("sparse"), Some(SitePart::Cameras));
    assert_eq!(part("sparse/images.txt"), Some(SitePart::Cameras));
    assert_eq!([part("photos"), part("photos/a.jpg")], [None, None]);
}

#[test]
fn the_project_gets_a_folder_beside_the_site_that_is_free() {
    let root = site(&["castle/a.jpg"]);
    let castle = root.path().join("castle");
    let first = folder_beside(&castle);
    assert!(first.ends_with("castle-project") && !first.exists());
    fs::create_dir_all(first.join("something")).unwrap();
    assert!(folder_beside(&castle).ends_with("castle-project-2"));
}
