//! The light on trees as the window shows it: where the sun is in angles, and what sources give.

use std::sync::Arc;

use glam::DVec3;

use crate::state::running::{JobId, Running};
use quadratura_document::colour::ColourDecisions;
use quadratura_document::trees::{LightStrength, Strength, TreeLight, Trees};
use quadratura_document::{Masks, Project};
use quadratura_foliage::{OutdoorLight, level_axes};
use quadratura_trees::light::{LightEstimate, estimated_trees, is_needed};

/// Where the sun is, in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunAngles {
    /// The angle about what is up, against the clock as seen from above, from the level axis of the world's x: -180 to 180.
    pub bearing: f64,
    /// The angle above the horizon: -90 to 90.
    pub height: f64,
}

/// Returns where the sun is: as the project says, or as on a clear day.
pub fn sun_angles(light: &TreeLight, up: DVec3) -> SunAngles {
    let sun = light.sun.map_or(OutdoorLight::day(up).towards_sun, DVec3::from_array).normalize_or(up);
    let (x, y) = level_axes(up);
    SunAngles {
        bearing: sun.dot(y).atan2(sun.dot(x)).to_degrees(),
        height: sun.dot(up).clamp(-1.0, 1.0).asin().to_degrees(),
    }
}

/// Returns the direction to the sun, of length 1.
pub fn sun_direction(angles: SunAngles, up: DVec3) -> [f64; 3] {
    let (x, y) = level_axes(up);
    let (bearing, height) = (angles.bearing.to_radians(), angles.height.to_radians());
    let level = bearing.cos() * x + bearing.sin() * y;
    (height.cos() * level + height.sin() * up).to_array()
}

/// What an estimate of the light depends on.
#[derive(Debug, Clone, PartialEq)]
struct Basis {
    /// Without what goes on top of it.
    trees: Trees,
    masks: Masks,
    colour: ColourDecisions,
}

impl Basis {
    fn of(project: &Project) -> Self {
        let Project { masks, colour, .. } = project;
        Self { trees: estimated_trees(&project.trees), masks: masks.clone(), colour: colour.clone() }
    }

    fn is_of(&self, project: &Project) -> bool {
        self.masks == project.masks
            && self.colour == project.colour
            && self.trees == estimated_trees(&project.trees)
    }
}

/// The estimated light, as far as it is known.
#[derive(Debug, Default)]
pub struct KnownLight {
    known: Option<Result<Arc<LightEstimate>, String>>,
    /// What the last job was started for: when it is stopped, it does not start again by itself.
    tried: Option<Basis>,
    /// The job that estimates it.
    pub job: Option<JobId>,
}

impl KnownLight {
    /// Returns the last estimate, which may be of other trees while a new one is made, or why there is none.
    pub fn last(&self) -> Option<&Result<Arc<LightEstimate>, String>> {
        self.known.as_ref()
    }

    /// Returns what the last estimate gives.
    pub fn strength(&self) -> Option<LightStrength> {
        self.estimate().map(|estimate| estimate.strength)
    }

    /// Returns the last estimate where there is one.
    pub fn estimate(&self) -> Option<Arc<LightEstimate>> {
        self.last()?.as_ref().ok().cloned()
    }

    /// Returns true where a project needs an estimate that is not known, and no job makes one.
    pub fn is_missing(&self, project: &Project, running: &Running) -> bool {
        is_needed(project)
            && !self.job.is_some_and(|job| running.is_running(job))
            && self.tried.as_ref().is_none_or(|basis| !basis.is_of(project))
    }

    /// Keeps that a job makes the estimate for a project.
    pub fn begin(&mut self, project: &Project, job: JobId) {
        self.tried = Some(Basis::of(project));
        self.job = Some(job);
    }

    /// Keeps the estimate for a project.
    pub fn keep(&mut self, project: &Project, found: Result<LightEstimate, String>) {
        self.tried = Some(Basis::of(project));
        self.known = Some(found.map(Arc::new));
    }

    /// Forgets the estimate, because photos may have changed.
    pub fn forget(&mut self) {
        (self.known, self.tried) = (None, None);
    }
}

/// Returns the light with what sources give.
pub fn with_strength(light: &TreeLight, strength: LightStrength) -> TreeLight {
    TreeLight { strength: Strength::Given(strength), ..*light }
}

/// Returns what sources give, rounded to what the window shows.
pub fn shown_strength(LightStrength { sun, sky, ground }: &LightStrength) -> LightStrength {
    let shown = |light: &[f64; 3]| light.map(|value| (value * 1e3).round() / 1e3);
    LightStrength { sun: shown(sun), sky: shown(sky), ground: shown(ground) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_document::masks::{Mask, MaskOrigin, MaskedTree};
    use quadratura_trees::edit::{TreeChange, placed};
    use quadratura_trees::light::{LightSupport, clear_day};

    #[test]
    fn angles_of_the_sun_and_its_direction_are_the_same_thing_whatever_is_up() {
        for up in [DVec3::Z, -DVec3::Y, DVec3::new(0.6, 0.0, -0.8)] {
            let day = sun_angles(&TreeLight::default(), up);
            assert!((day.height - 49.4).abs() < 0.1, "{day:?}");
            let angles = SunAngles { bearing: -120.0, height: 30.0 };
            let light = TreeLight { sun: Some(sun_direction(angles, up)), ..TreeLight::default() };
            let back = sun_angles(&light, up);
            assert!((back.bearing + 120.0).abs() < 1e-9 && (back.height - 30.0).abs() < 1e-9, "{back:?}");
        }
        let east = sun_direction(SunAngles { bearing: 90.0, height: 0.0 }, DVec3::Z);
        assert!(DVec3::from_array(east).abs_diff_eq(DVec3::Y, 1e-12));
    }

    #[test]
    fn an_estimate_is_missing_until_it_is_kept_and_again_when_trees_or_the_sun_change() {
        let (trees, _) = placed(&Trees::default(), "oak", None, &TreeChange::default()).unwrap();
        let mut project = Project { trees, ..Project::default() };
        let (mut light, running) = (KnownLight::default(), Running::default());
        assert!(!light.is_missing(&Project::default(), &running), "there are no trees");
        assert!(light.is_missing(&project, &running));
        let estimate = LightEstimate::plain(clear_day(), LightSupport::ClearDay);
        light.keep(&project, Ok(estimate));
        assert!(!light.is_missing(&project, &running));
        project.trees.light.sun = Some([0.0, 0.0, 1.0]);
        assert!(light.is_missing(&project, &running));
        project.trees.light = with_strength(&project.trees.light, clear_day());
        assert!(!light.is_missing(&project, &running), "it is given");
        project.trees.placed[0].tint = [1.0; 3];
        let from = MaskOrigin::Tree(MaskedTree {
            name: project.trees.placed[0].name.clone(),
            margin: 2,
            placing: None,
        });
        let mask = Mask { from, file: "mask.png".into(), pixels: 9 };
        project.masks.put("photo.jpg", mask);
        assert!(light.is_missing(&project, &running), "a photo shows the tree");
        project.trees.light.without_photos = true;
        assert!(!light.is_missing(&project, &running), "photos are not matched");
        project.trees.light.without_photos = false;
        light.keep(&project, Err("no light".into()));
        project.trees.placed[0].tint = [0.0; 3];
        assert!(!light.is_missing(&project, &running), "tints go on top");
        project.trees.placed[0].name = "another".into();
        assert!(!light.is_missing(&project, &running), "the tree of the mask is gone");
    }

    #[test]
    fn what_is_shown_has_three_digits() {
        let day = shown_strength(&clear_day());
        assert_eq!(day.sun, [2.05, 1.93, 1.72]);
        assert_eq!(shown_strength(&LightStrength { sky: [0.12345, 0.0, 1.0], ..day }).sky, [0.123, 0.0, 1.0]);
    }
}
