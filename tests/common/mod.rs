//! What several integration tests share.

use std::path::{Path, PathBuf};

use quadratura::gpu::{Gpu, GpuRasteriser};
use quadratura::io::cameras::read_cameras;
use quadratura::io::models::read_model;
use quadratura::recipe::photos::import_photos;
use quadratura::scene::Site;
use quadratura::task::Task;

/// A rasteriser on this machine's adapter. Without one the test is left out, and says why; where
/// `CI=true` it fails, because the set-up there installs a software adapter.
#[allow(dead_code)]
pub fn gpu_rasteriser() -> Option<GpuRasteriser> {
    match Gpu::headless().and_then(|gpu| GpuRasteriser::new(&gpu)) {
        Ok(rasteriser) => Some(rasteriser),
        Err(error) if std::env::var("CI").is_ok_and(|ci| ci == "true") => panic!("{error}"),
        Err(error) => {
            eprintln!("left out: {error}");
            None
        }
    }
}

/// The castle, beside the project. Where it is missing the test is left out, and says so; in CI it
/// fails where the folder that it belongs in exists.
#[allow(dead_code)]
pub fn castle() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/castle");
    if folder.exists() {
        return Some(folder);
    }
    let shared = folder.ancestors().nth(2).expect("it lies in shared/data");
    assert!(std::env::var_os("CI").is_none() || !shared.exists(), "{} is missing", folder.display());
    eprintln!("left out: {} is missing", folder.display());
    None
}

/// The site of a folder with `sparse/`, photos and a model, in the cameras' world.
#[allow(dead_code)]
pub fn site(folder: &Path, photos: &str, model: &str) -> Site {
    let task = Task::silent();
    let cameras = read_cameras(&folder.join("sparse"), &task).unwrap();
    let (model, _) = read_model(&folder.join(model), &task).unwrap();
    let import = import_photos(&cameras, &folder.join(photos), &folder.join("cache"), &task).unwrap();
    Site { photos: import.photos, model: model.into() }
}
