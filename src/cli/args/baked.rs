//! Arguments of `export` for models with one set of textures.

use clap::Args;

use super::one_of::one_of;
use quadratura_exports::handover::baked::{BakedOptions, Density, UpAxis};

/// The sides that pages may have.
const PAGE_SIZES: &[(&str, u32, &str)] =
    &[("1024", 1024, ""), ("2048", 2048, ""), ("4096", 4096, ""), ("8192", 8192, "")];

/// The directions that may be up in OBJ files.
const UP_AXES: &[(&str, UpAxis, &str)] =
    &[("project", UpAxis::Project, "As in the project"), ("y", UpAxis::Y, "+y, as many programs expect it")];

#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Models with textures (glb, obj, usd)")]
pub struct BakedArgs {
    /// The largest number of texels per unit of the world; auto: as many as photos show, within one page of 8192 x 8192
    #[arg(long, value_name = "auto|N", value_parser = density, allow_hyphen_values = true)]
    pub density: Option<Density>,
    /// The largest side of textures, in texels [default: 8192, or less where --memory allows no more]
    #[arg(long, value_name = "TEXELS", value_parser = one_of(PAGE_SIZES))]
    pub page_size: Option<u32>,
    /// Write textures as PNG, without loss, instead of JPEG
    #[arg(long)]
    pub png: bool,
    /// Leave grey what no photo shows, instead of baking fillings and continuing surfaces
    #[arg(long)]
    pub holes: bool,
    /// Make pages the tiles of one picture (UDIM), for programs of film; for --format obj and usd
    #[arg(long)]
    pub udim: bool,
    /// The direction that is up in OBJ files [default: project]
    #[arg(long, value_parser = one_of(UP_AXES))]
    pub up: Option<UpAxis>,
}

fn density(text: &str) -> std::result::Result<Density, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    match (text.trim(), number) {
        ("auto", _) => Ok(Density::Auto),
        (_, Some(number)) => Ok(Density::PerUnit(number)),
        _ => Err("expected auto, or a number of texels per unit above 0".into()),
    }
}

impl BakedArgs {
    /// Returns the options.
    pub fn options(&self, memory: u64) -> BakedOptions {
        BakedOptions {
            density: self.density.unwrap_or_default(),
            page: self.page_size,
            png: self.png,
            holes: self.holes,
            up: self.up.unwrap_or_default(),
            udim: self.udim,
            memory,
            ..BakedOptions::default()
        }
    }
}
