//! Arguments of `paint`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("seen").args(["everywhere", "only_here"]))]
#[command(
    after_help = "Without options it lists the paint and where it is seen. --everywhere and --only-here concern all \
                  paint, or what --photo, --surface and --import name; `quadratura fill` then updates the photos."
)]
pub struct PaintArgs {
    /// The project folder
    pub project: PathBuf,
    /// Show paint in all photos that show the surface
    #[arg(long)]
    pub everywhere: bool,
    /// Show paint only in the photo on which it was painted
    #[arg(long)]
    pub only_here: bool,
    /// Paint on this photo (may be given several times)
    #[arg(long = "photo", value_name = "NAME", requires = "seen")]
    pub photos: Vec<String>,
    /// Paint on this object, or on faces of one as 'OBJECT[3, 5-8]' (may be given several times)
    #[arg(long = "surface", value_name = "WHAT", requires = "seen")]
    pub surfaces: Vec<String>,
    /// Paint of the import with this number (may be given several times)
    #[arg(long = "import", value_name = "N", requires = "seen")]
    pub imports: Vec<u32>,
    /// Let this photo keep the pixels that it shows, whatever is painted on others (may be given several times)
    #[arg(long, value_name = "NAME")]
    pub protect: Vec<String>,
    /// Show paint of other photos in this one again (may be given several times)
    #[arg(long, value_name = "NAME")]
    pub unprotect: Vec<String>,
}
