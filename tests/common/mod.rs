//! What several integration tests share.

use std::path::{Path, PathBuf};

use quadratura::gpu::{Gpu, GpuRasteriser};

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
