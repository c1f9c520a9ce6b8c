//! The dialog in which the site's frame is set: level, scale, north, origin, and the reference system of a map.

use quadratura_document::SiteFrame;
use quadratura_document::frame::{FramePart, MapReference};
use quadratura_views::frame::{FrameChange, KnownDirection, KnownLength, Level, described};

/// What the up direction is taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LevelChoice {
    /// It stays as it is.
    #[default]
    Keep,
    /// The model's upright edges.
    Verticals,
    /// The cameras' mean up direction.
    Cameras,
    /// The selected face or object.
    Selected,
}

/// What the unit is taken from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ScaleChoice {
    /// It stays as it is.
    #[default]
    Keep,
    /// The model's own unit: metres of one, and its name.
    Unit(f64, &'static str),
    /// A length between two points.
    Length,
}

/// Units of models.
pub const UNITS: [(f64, &str); 5] = [(1.0, "m"), (0.01, "cm"), (0.001, "mm"), (0.3048, "ft"), (0.0254, "in")];

/// The dialog, as it is being edited. Points are written as on the command line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SiteFrameDialog {
    /// What is known now, in words, by part.
    pub known: Vec<(FramePart, Option<String>)>,
    /// The name of the selected object or face.
    pub selected: Option<String>,
    /// The two points of the measuring tool, where there are two.
    pub measured: Option<[String; 2]>,
    /// What the up direction is taken from.
    pub level: LevelChoice,
    /// What the unit is taken from.
    pub scale: ScaleChoice,
    /// The points between which a length is known, and the length in metres, as typed.
    pub length: [String; 3],
    /// The points from the first of which to the second is north, and the degrees from north, as typed; empty for what stays.
    pub north: [String; 3],
    /// The point that becomes 0, 0, 0, as typed; empty for what stays.
    pub origin: String,
    /// The number of the reference system, and east, north and height, as typed; empty for what stays.
    pub map: [String; 4],
    /// Why the last change could not be made.
    pub problem: Option<String>,
}

impl SiteFrameDialog {
    /// Opens the dialog on a frame.
    pub fn new(frame: &SiteFrame, selected: Option<String>, measured: Option<[String; 2]>) -> Self {
        let known = FramePart::ALL.map(|part| (part, described(frame, part))).to_vec();
        Self { known, selected, measured, ..Self::default() }
    }

    /// Returns what is asked for.
    ///
    /// # Errors
    /// A sentence about what was typed.
    pub fn change(&self) -> Result<FrameChange, String> {
        let level = match (self.level, &self.selected) {
            (LevelChoice::Keep, _) => None,
            (LevelChoice::Verticals, _) => Some(Level::Verticals),
            (LevelChoice::Cameras, _) => Some(Level::Cameras),
            (LevelChoice::Selected, Some(name)) => Some(Level::Faces(vec![name.clone()])),
            (LevelChoice::Selected, None) => return Err("Select a level or upright face first.".into()),
        };
        let [a, b, metres] = self.length.each_ref().map(|text| text.trim());
        let scale = match self.scale {
            ScaleChoice::Length => {
                let metres = number(metres, "The length in metres").ok().filter(|metres| *metres > 0.0);
                let metres = metres.ok_or("The length is a number of metres above 0.")?;
                Some(KnownLength { between: [a.to_owned(), b.to_owned()], metres })
            }
            ScaleChoice::Keep | ScaleChoice::Unit(..) => None,
        };
        let unit = match self.scale {
            ScaleChoice::Unit(metres, name) => Some((metres, name.to_owned())),
            ScaleChoice::Keep | ScaleChoice::Length => None,
        };
        let [from, to, degrees] = self.north.each_ref().map(|text| text.trim());
        let north = match (from, to) {
            ("", "") => None,
            (from, to) => Some(KnownDirection {
                from_to: [from.to_owned(), to.to_owned()],
                azimuth_deg: if degrees.is_empty() { 0.0 } else { number(degrees, "The angle from north")? },
            }),
        };
        let origin = Some(self.origin.trim()).filter(|origin| !origin.is_empty()).map(str::to_owned);
        let [epsg, offset @ ..] = self.map.each_ref().map(|text| text.trim());
        let crs = match epsg.trim_start_matches("EPSG:") {
            "" => None,
            epsg => Some(MapReference {
                epsg: epsg
                    .parse()
                    .map_err(|_| "The reference system is a number, such as 25832.".to_owned())?,
                offset: [
                    number(offset[0], "East")?,
                    number(offset[1], "North")?,
                    number(offset[2], "The height")?,
                ],
            }),
        };
        Ok(FrameChange { level, scale, unit, north, origin, crs, ..FrameChange::default() })
    }
}

fn number(text: &str, what: &str) -> Result<f64, String> {
    text.parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| format!("{what} is a number."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_typed_and_chosen_is_the_change_and_the_rest_stays() {
        let mut dialog = SiteFrameDialog::new(&SiteFrame::default(), Some("wall[0]".into()), None);
        assert!(dialog.change().unwrap().is_empty());
        assert!(dialog.known.iter().all(|(_, known)| known.is_none()));
        dialog.level = LevelChoice::Selected;
        dialog.scale = ScaleChoice::Length;
        dialog.length = ["0,0,0".into(), "1,0,0".into(), " 2.5 ".into()];
        dialog.north = ["0,0,0".into(), "0,1,0".into(), String::new()];
        dialog.map = ["EPSG:25832".into(), "1".into(), "2".into(), "3".into()];
        let change = dialog.change().unwrap();
        assert_eq!(change.level, Some(Level::Faces(vec!["wall[0]".into()])));
        assert_eq!(change.scale.unwrap().metres, 2.5);
        assert_eq!((change.north.unwrap().azimuth_deg, change.origin), (0.0, None));
        assert_eq!(change.crs, Some(MapReference { epsg: 25832, offset: [1.0, 2.0, 3.0] }));
        dialog.scale = ScaleChoice::Unit(0.01, "cm");
        assert_eq!(dialog.change().unwrap().unit, Some((0.01, "cm".into())));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let wrong = |change: fn(&mut SiteFrameDialog)| {
            let mut dialog = SiteFrameDialog::default();
            change(&mut dialog);
            dialog.change().unwrap_err()
        };
        assert!(wrong(|it| it.level = LevelChoice::Selected).contains("Select a level"));
        assert!(wrong(|it| it.scale = ScaleChoice::Length).contains("above 0"));
        assert!(wrong(|it| it.map[0] = "UTM".into()).contains("such as 25832"));
        assert!(wrong(|it| it.map[0] = "25832".into()).contains("East is a number"));
        assert!(wrong(|it| (it.north[0], it.north[2]) = ("a".into(), "east".into())).contains("angle"));
    }
}
