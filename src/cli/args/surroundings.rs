//! Arguments of `surroundings`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};

use super::number::whole;

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("picture").multiple(true))]
pub struct SurroundingsArgs {
    /// The project folder
    pub project: PathBuf,
    /// Write what is seen in all directions to this file, which must not exist: .png (sRGB, 8 bits) or .hdr
    /// (Radiance, linear light)
    #[arg(long, value_name = "FILE", group = "picture")]
    pub export: Option<PathBuf>,
    /// The width of the exported picture in pixels; it is half as high
    #[arg(long, value_name = "PX", requires = "export", value_parser = whole::<u32>(2..=16384))]
    pub width: Option<u32>,
    /// Use this picture instead of the photos, where they show nothing: equirectangular, twice as wide as high
    #[arg(long, value_name = "FILE", group = "picture", conflicts_with = "remove")]
    pub set: Option<PathBuf>,
    /// The direction of the middle of the picture in the cameras' world [default: to export, that in which the photos
    /// look; to set, what an exported picture says itself, else the world's Y axis if it is level, else -Z or X]
    #[arg(long, value_name = "X,Y,Z", requires = "picture", allow_hyphen_values = true, value_parser = direction)]
    pub middle: Option<[f64; 3]>,
    /// Use the photos again instead of a picture
    #[arg(long)]
    pub remove: bool,
}

/// Parses three numbers, which are not all 0.
pub(super) fn direction(text: &str) -> Result<[f64; 3], String> {
    let parts: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match parts.map(<[f64; 3]>::try_from) {
        Ok(Ok(parts)) if parts.iter().all(|x| x.is_finite()) && parts != [0.0; 3] => Ok(parts),
        _ => Err("expected a direction such as 0,1,0: three numbers, not all 0".into()),
    }
}
