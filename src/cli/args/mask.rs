//! Arguments of `mask` and `object`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};

use super::PhotoArgs;
use super::number::whole;
use quadratura_sites::masks::ClearedMasks;

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("widened").args(["object", "suggest", "accept"]).multiple(true))]
pub struct MaskArgs {
    /// The project folder
    pub project: PathBuf,
    #[command(flatten)]
    pub photos: PhotoArgs,
    /// Use a PNG or TIFF as a mask of the photo that --photo names: as large as the original photo; black is masked
    #[arg(long, value_name = "FILE", requires = "names")]
    pub add: Option<PathBuf>,
    /// Use the masks found beside the photos (NAME.mask.png, NAME_mask.png) or in a folder `masks`
    /// (masks/NAME.jpg.png, as in COLMAP); masks that were found before are read again
    #[arg(long)]
    pub find: bool,
    /// Mask what the photos show of this object, even if it was removed from the model (may be given several
    /// times; `*` stands for any characters)
    #[arg(long, value_name = "OBJECT")]
    pub object: Vec<String>,
    /// Also mask pixels within this distance: of an object, because models are a few pixels off; of what --suggest finds;
    /// of suggestions that are accepted [default: 0; of --suggest: 6]
    #[arg(long, value_name = "PX", requires = "widened",
          value_parser = whole::<u32>(0..=4096))]
    pub margin: Option<u32>,
    /// Find transient objects (people, cars), which only one photo shows, by comparing photos: writes
    /// pictures and a list, and masks nothing
    #[arg(long)]
    pub suggest: bool,
    /// With --suggest: also list what is hardly an object, such as haze, glare and window panes; with --accept all: also mask it
    #[arg(long, requires = "widened")]
    pub all: bool,
    /// Mask suggestions: `all` that are likely, or numbers such as 1,4,7
    #[arg(long, value_name = "all|N,N,..", value_parser = accepted)]
    pub accept: Option<Accepted>,
    /// Remove masks first, before making others: all of them, or those that are `suggested`, `painted` (in the editor or
    /// in a layer `mask`), from `files`, of `objects`, of one object (`object:NAME`), of `trees`, or of one tree (`tree:NAME`)
    #[arg(long, value_name = "WHICH", value_parser = cleared, num_args = 0..=1, require_equals = true,
          default_missing_value = "all")]
    pub clear: Option<ClearedMasks>,
}

fn cleared(text: &str) -> Result<ClearedMasks, String> {
    Ok(match text {
        "all" => ClearedMasks::All,
        "suggested" => ClearedMasks::Suggested,
        "painted" => ClearedMasks::Painted,
        "files" => ClearedMasks::Files,
        "objects" => ClearedMasks::Objects,
        "trees" => ClearedMasks::Trees,
        _ => match text.split_once(':').filter(|(_, name)| !name.is_empty()) {
            Some(("object", name)) => ClearedMasks::Object(name.to_owned()),
            Some(("tree", name)) => ClearedMasks::Tree(name.to_owned()),
            _ => {
                let kinds = "all, suggested, painted, files, objects, object:NAME, trees, or tree:NAME";
                return Err(format!("expected {kinds}"));
            }
        },
    })
}

/// Accepted suggestions by number; empty for all of them.
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
    /// The project folder
    pub project: PathBuf,
    /// Remove this object from the model in this project (may be given several times; `*` stands for any
    /// characters)
    #[arg(long, value_name = "OBJECT")]
    pub off: Vec<String>,
    /// Restore this object
    #[arg(long, value_name = "OBJECT")]
    pub on: Vec<String>,
}
