//! The measuring tool of the 3D view: two points on surfaces.

use quadratura_views::measure::PointOnFace;

/// The measuring tool.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasuringTool {
    /// Whether it is in use.
    pub on: bool,
    /// The points so far, two at most.
    pub points: Vec<PointOnFace>,
    /// The length between them that was typed, to set the scale by.
    pub length: String,
}

impl MeasuringTool {
    /// Adds a point; after two, the next one begins anew.
    pub fn add(&mut self, point: PointOnFace) {
        if self.points.len() >= 2 {
            self.points.clear();
        }
        self.points.push(point);
    }

    /// Returns both points.
    pub fn both(&self) -> Option<[PointOnFace; 2]> {
        <[PointOnFace; 2]>::try_from(&self.points[..]).ok()
    }

    /// Returns the length that was typed, in metres, if it is one.
    pub fn metres(&self) -> Option<f64> {
        let typed = self.length.trim().trim_end_matches('m').trim_end();
        typed.parse().ok().filter(|metres: &f64| metres.is_finite() && *metres > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use quadratura_base::scene::FaceId;

    #[test]
    fn a_third_point_begins_anew_and_lengths_are_in_metres() {
        let mut tool = MeasuringTool::default();
        let point = |x: f64| PointOnFace { position: DVec3::X * x, face: FaceId(0) };
        tool.add(point(1.0));
        assert_eq!(tool.both(), None);
        tool.add(point(2.0));
        assert_eq!(tool.both(), Some([point(1.0), point(2.0)]));
        tool.add(point(3.0));
        assert_eq!(tool.points, [point(3.0)]);
        let typed = |text: &str| MeasuringTool { length: text.into(), ..MeasuringTool::default() }.metres();
        assert_eq!([typed("12.5 m"), typed("0"), typed("wide")], [Some(12.5), None, None]);
    }
}
