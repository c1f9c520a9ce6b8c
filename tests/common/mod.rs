//! What several integration tests share.

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
