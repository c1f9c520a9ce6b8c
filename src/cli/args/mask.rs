//! What may be typed for `mask` and `object`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::RangedU64ValueParser;

use super::PhotoArgs;

#[derive(Debug, Args)]
pub struct MaskArgs {
    /// The project's folder
    pub project: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    /// Take a PNG as a mask of the one photo that --photo names: as large as the photo as taken, black is
    /// masked
    #[arg(long, value_name = "FILE", requires = "names")]
    pub add: Option<PathBuf>,
    /// Take the masks that lie beside the photos (NAME.mask.png, NAME_mask.png) or in a folder `masks`
    /// (masks/NAME.jpg.png, as COLMAP has it); those taken before are read again
    #[arg(long)]
    pub find: bool,
    /// Mask what the photos show of this object, also of one that is switched off (may be given several
    /// times; `NAME*` for all that begin so)
    #[arg(long, value_name = "OBJECT")]
    pub object: Vec<String>,
    /// Mask also what is so many pixels around the object: models are wrong by a few
    #[arg(long, value_name = "PX", requires = "object", default_value_t = 0,
          value_parser = RangedU64ValueParser::<u32>::new().range(0..=4096))]
    pub margin: u32,
    /// Look for what stands in one photo alone (people, cars), by asking the other photos: writes pictures and a list,
    /// masks nothing
    #[arg(long)]
    pub suggest: bool,
    /// Mask what was suggested: `all`, or numbers such as 1,4,7
    #[arg(long, value_name = "all|N,N,..", value_parser = accepted)]
    pub accept: Option<Accepted>,
    /// Take masks away, before others of this command are made
    #[arg(long)]
    pub clear: bool,
}

/// Suggestions by number; none for all of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Accepted(pub Vec<u32>);

fn accepted(text: &str) -> Result<Accepted, String> {
    if text == "all" {
        return Ok(Accepted(Vec::new()));
    }
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    numbers.map(Accepted).map_err(|_| "expected `all`, or numbers such as 1,4,7".to_owned())
}

#[derive(Debug, Args)]
pub struct ObjectArgs {
    /// The project's folder
    pub project: PathBuf,
    /// Switch this object off: it is as if the model did not have it (may be given several times; `NAME*`
    /// for all that begin so)
    #[arg(long, value_name = "OBJECT")]
    pub off: Vec<String>,
    /// Switch it on again
    #[arg(long, value_name = "OBJECT")]
    pub on: Vec<String>,
}
