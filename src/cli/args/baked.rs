//! Arguments of `export` for models with one set of textures.

use clap::Args;

use super::one_of::one_of;
use quadratura_base::error::{Error, Result};
use quadratura_recipe::handover::baked::{BakedFormat, BakedOptions, Density, UpAxis};

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
    /// Returns the options for a format.
    pub fn options(&self, format: BakedFormat, memory: u64) -> BakedOptions {
        let format = match format {
            BakedFormat::Obj(_) => BakedFormat::Obj(self.up.unwrap_or_default()),
            other => other,
        };
        let (page, png, holes) = (self.page_size, self.png, self.holes);
        BakedOptions { format, density: self.density.unwrap_or_default(), page, png, holes, memory }
    }

    /// Checks that no argument was given that the format `name` does not have; `format` is that of a model with textures.
    ///
    /// # Errors
    /// Returns [`Error::Usage`].
    pub fn check(&self, name: &str, format: Option<BakedFormat>) -> Result<()> {
        let is_obj = matches!(format, Some(BakedFormat::Obj(_)));
        let given = [
            ("--density", self.density.is_some(), format.is_some()),
            ("--page-size", self.page_size.is_some(), format.is_some()),
            ("--png", self.png, format.is_some()),
            ("--holes", self.holes, format.is_some()),
            ("--up", self.up.is_some(), is_obj),
        ];
        match given.iter().find(|(_, given, has)| *given && !has) {
            Some((argument, ..)) => {
                let meant = if *argument == "--up" { "obj" } else { "glb, obj and usd" };
                Err(Error::Usage(format!("{argument} does not apply to --format {name}; it is for {meant}")))
            }
            None => Ok(()),
        }
    }
}
