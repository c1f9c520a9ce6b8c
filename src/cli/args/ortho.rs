//! Arguments of `ortho`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};

use super::frame::metres;
use super::{MemoryArg, one_of};
use crate::view_args::LookArgs;
use quadratura_base::error::Result;
use quadratura_views::frame::FORMS;
use quadratura_views::ortho::{OrthoFormat, Resolution, Subject};

#[derive(Debug, Args)]
#[command(
    group = ArgGroup::new("subject").args(["on", "plan", "section"]).required(true).multiple(true),
    after_help = format!("A and B are points: {FORMS}.\n\nA scale needs a unit: `quadratura frame` sets it.")
)]
pub struct OrthoArgs {
    /// The project folder
    pub project: PathBuf,
    /// Show these from straight in front: objects (`*` stands for any characters) or faces as 'OBJECT[3, 5-8]'. Of an object with several
    /// walls it is the largest facade that cameras look at
    #[arg(long, value_name = "OBJECT|FACES", num_args = 1.., conflicts_with = "section")]
    pub on: Vec<String>,
    /// Show the site from above, or what --on names
    #[arg(long, conflicts_with = "section")]
    pub plan: bool,
    /// Show what is behind the upright plane through A and B, with A on the left
    #[arg(long, num_args = 2, value_names = ["A", "B"], allow_hyphen_values = true)]
    pub section: Option<Vec<String>>,
    /// The scale of a print, such as 1:50
    #[arg(long, value_name = "1:N", value_parser = scale)]
    pub scale: Option<f64>,
    /// Pixels per inch of a print [default: 300 with --scale]
    #[arg(long, value_name = "N", value_parser = dpi)]
    pub dpi: Option<f64>,
    /// The side of a pixel on the surface, such as 2mm
    #[arg(long, value_name = "LENGTH", value_parser = metres)]
    pub gsd: Option<f64>,
    /// Leave out what is farther than this in front of the subject, such as 0.5m [default: 1 m in front of --on, all of a plan, nothing in
    /// front of a section]
    #[arg(long, value_name = "LENGTH", value_parser = metres_or_none)]
    pub depth: Option<f64>,
    /// The folder for the files; what is there is not overwritten
    #[arg(short, long, value_name = "DIR")]
    pub out: PathBuf,
    /// The name of the files, without ending [default: that of the subject]
    #[arg(long, value_name = "NAME", value_parser = file_name)]
    pub name: Option<String>,
    /// The formats: TIFF (GeoTIFF for plans of a site with north), PNG, and a page with scale bar and title block
    #[arg(long, value_parser = one_of(FORMATS), value_delimiter = ',', num_args = 1.., default_value = "tiff,pdf")]
    pub format: Vec<OrthoFormat>,
    /// The title on the page [default: the subject]
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    #[command(flatten)]
    pub memory: MemoryArg,
    #[command(flatten)]
    pub look: LookArgs,
}

const FORMATS: &[(&str, OrthoFormat, &str)] = &[
    ("tiff", OrthoFormat::Tiff, "TIFF with resolution and alpha; BigTIFF from 4 GB on"),
    ("png", OrthoFormat::Png, "PNG with resolution and alpha"),
    ("pdf", OrthoFormat::Pdf, "A page as PDF"),
];

impl OrthoArgs {
    /// Returns what the picture is of.
    pub fn subject(&self) -> Subject {
        match self.section.as_deref() {
            Some([a, b]) => Subject::Section([a.clone(), b.clone()]),
            _ if self.plan => Subject::Plan(self.on.clone()),
            _ => Subject::On(self.on.clone()),
        }
    }

    /// Returns how finely it is drawn.
    ///
    /// # Errors
    /// As [`Resolution::new`].
    pub fn resolution(&self) -> Result<Resolution> {
        Resolution::new(self.scale, self.dpi, self.gsd)
    }
}

fn scale(text: &str) -> std::result::Result<f64, String> {
    let number = text.strip_prefix("1:").unwrap_or(text);
    number
        .parse()
        .ok()
        .filter(|number| (0.001..=1e6).contains(number))
        .ok_or_else(|| format!("{text:?} is no scale; write 1:50 for a print on which 1 cm is 50 cm"))
}

fn dpi(text: &str) -> std::result::Result<f64, String> {
    let number = text.parse().ok().filter(|number| (1.0..=10_000.0).contains(number));
    number.ok_or_else(|| format!("{text:?} is no number of pixels per inch from 1 to 10000"))
}

fn metres_or_none(text: &str) -> std::result::Result<f64, String> {
    if text == "0" { Ok(0.0) } else { metres(text) }
}

fn file_name(text: &str) -> std::result::Result<String, String> {
    let is_name = !text.is_empty() && !text.contains(['/', '\\']) && text != "." && text != "..";
    if is_name {
        Ok(text.to_owned())
    } else {
        Err("expected a name of files without folder and ending".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_written_as_on_drawings() {
        assert_eq!([scale("1:50"), scale("20")], [Ok(50.0), Ok(20.0)]);
        assert!(scale("50:1").is_err() && scale("1:0").is_err());
        assert!(file_name("a/b").is_err() && file_name("west-2").is_ok());
    }
}
