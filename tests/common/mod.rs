//! What several integration tests share.

mod left_out;

use std::path::Path;
use std::sync::OnceLock;

use quadratura::task::Task;
use quadratura::testing::gpu::{Gpu, GpuRasteriser};
use quadratura::testing::import::cameras::read_cameras;
use quadratura::testing::import::models::read_model;
use quadratura::testing::scene::Site;
use quadratura::testing::sites::photos::import_photos;

#[allow(unused_imports)]
pub use left_out::{castle, chromium, python};

/// A rasteriser on this machine's adapter; `None` where there is no adapter, and the test is left out.
#[allow(dead_code)]
pub fn gpu_rasteriser() -> Option<GpuRasteriser> {
    left_out::on_adapter(Gpu::headless().and_then(|gpu| GpuRasteriser::new(&gpu)))
}

/// Whether this machine has an adapter; `None` where it has none, and the test is left out. For tests whose program or
/// window opens the adapter itself: it is looked for once, not once for each of them.
#[allow(dead_code)]
pub fn adapter() -> Option<()> {
    static OPENED: OnceLock<Result<(), String>> = OnceLock::new();
    let opened = OPENED.get_or_init(|| Gpu::headless().map(drop).map_err(|error| error.to_string()));
    left_out::on_adapter(opened.clone())
}

/// This machine's adapter; `None` where there is none, and the test is left out.
#[allow(dead_code)]
pub fn gpu() -> Option<Gpu> {
    left_out::on_adapter(Gpu::headless())
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
