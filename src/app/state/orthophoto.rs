//! The dialog that draws an orthophoto of the selected face or object, or a plan of the site.

use std::path::PathBuf;
use std::sync::Arc;

use quadratura_base::error::{Error, Result};
use quadratura_view::{Picture, Unseen};
use quadratura_views::ortho::{OrthoFormat, OrthoOptions, Resolution, Subject};
use quadratura_views::render::Appearance;

/// The dialog, as it is being edited.
#[derive(Debug, Clone, PartialEq)]
pub struct OrthophotoDialog {
    /// The project's folder.
    pub project: PathBuf,
    /// The name of the selected object or face; `None` where there is none, and a plan of all is drawn.
    pub selected: Option<String>,
    /// Whether it is seen from above.
    pub is_plan: bool,
    /// The number of the scale as typed: 50 for 1:50.
    pub scale: String,
    /// Pixels per inch as typed.
    pub dpi: String,
    /// Metres in front of the subject as typed; empty for the usual.
    pub depth: String,
    /// The folder as typed or chosen; relative paths start at the project folder.
    pub folder: String,
    /// The formats.
    pub formats: Vec<OrthoFormat>,
    /// Whether what no photo shows is left empty.
    pub holes: bool,
    /// Whether the site has a scale.
    pub has_scale: bool,
    /// The preview that was drawn last.
    pub preview: Option<Arc<Picture>>,
    /// What there is to say about the last orthophoto, in sentences.
    pub report: Vec<String>,
    /// The folder of the last orthophoto.
    pub done: Option<PathBuf>,
}

impl OrthophotoDialog {
    /// Returns the reason why nothing can be drawn.
    pub fn problem(&self) -> Option<String> {
        if !self.has_scale {
            let how = "measure a known length with View › Measure and set the scale, or run “quadratura frame SITE --unit m”";
            return Some(format!("The site has no unit: {how}."));
        }
        if self.folder.trim().is_empty() {
            return Some("Choose a folder.".into());
        }
        if self.formats.is_empty() {
            return Some("Choose a format.".into());
        }
        self.options(1).err().map(|error| error.to_string())
    }

    /// Returns what is drawn, with this memory for pixels in bytes.
    ///
    /// # Errors
    /// [`Error::Request`] for numbers that are none.
    pub fn options(&self, memory: u64) -> Result<OrthoOptions> {
        let number = |text: &str, what: &str| {
            let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
            number.ok_or_else(|| Error::Request(format!("{what} is a number above 0")))
        };
        let scale = number(self.scale.trim().trim_start_matches("1:"), "The scale")?;
        let dpi = number(&self.dpi, "Pixels per inch")?;
        let depth_m = match self.depth.trim() {
            "" => None,
            "0" => Some(0.0),
            typed => Some(number(typed, "The depth")?),
        };
        let names: Vec<String> = self.selected.iter().cloned().collect();
        Ok(OrthoOptions {
            subject: if self.is_plan || names.is_empty() { Subject::Plan(names) } else { Subject::On(names) },
            resolution: Resolution::new(Some(scale), Some(dpi), None)?,
            depth_m,
            look: Appearance {
                supersampled: true,
                unseen: if self.holes { Unseen::Empty } else { Unseen::Continued },
                ..Appearance::default()
            },
            out: self.project.join(self.folder.trim()),
            name: None,
            formats: self.formats.clone(),
            title: None,
            memory,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dialog() -> OrthophotoDialog {
        OrthophotoDialog {
            project: "site".into(),
            selected: Some("wall[0]".into()),
            is_plan: false,
            scale: "1:20".into(),
            dpi: "254".into(),
            depth: "0.5".into(),
            folder: "out".into(),
            formats: vec![OrthoFormat::Tiff],
            holes: true,
            has_scale: true,
            preview: None,
            report: Vec::new(),
            done: None,
        }
    }

    #[test]
    fn what_is_typed_says_what_is_drawn() {
        let options = dialog().options(7).unwrap();
        assert_eq!(options.subject, Subject::On(vec!["wall[0]".into()]));
        assert!((options.resolution.pixel_m - 0.002).abs() < 1e-12 && options.depth_m == Some(0.5));
        assert_eq!((options.out, options.look.unseen), ("site/out".into(), Unseen::Empty));
        let plan = OrthophotoDialog { is_plan: true, ..dialog() }.options(7).unwrap();
        assert_eq!(plan.subject, Subject::Plan(vec!["wall[0]".into()]));
    }

    #[test]
    fn what_is_missing_is_said() {
        assert_eq!(dialog().problem(), None);
        let without = |change: fn(&mut OrthophotoDialog)| {
            let mut dialog = dialog();
            change(&mut dialog);
            dialog.problem().unwrap()
        };
        assert!(without(|it| it.has_scale = false).contains("View › Measure"));
        assert!(without(|it| it.folder = " ".into()).contains("folder"));
        assert!(without(|it| it.formats.clear()).contains("format"));
        assert!(without(|it| it.scale = "wide".into()).contains("The scale is a number"));
        assert!(without(|it| it.depth = "-1".into()).contains("The depth"));
    }
}
