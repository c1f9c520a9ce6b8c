//! The fix of the alignment: the model gets another transform, and the project stays what it is otherwise.

use super::{AlignmentSuggestion, AlternativeTransform};
use quadratura_base::geometry::Similarity;
use quadratura_document::Project;

impl AlternativeTransform {
    /// Returns the transform from the model to the cameras' world.
    pub fn similarity(&self) -> Similarity {
        Similarity::parse(&self.transform).expect("a transform is written as it is read")
    }
}

impl AlignmentSuggestion {
    /// Returns the transform from the model to the cameras' world that is suggested.
    pub fn similarity(&self) -> Similarity {
        Similarity::parse(&self.transform).expect("a transform is written as it is read")
    }
}

/// Returns a project with its model at another place in the cameras' world. Decisions, masks and paint stay: they name faces
/// and pixels, not places.
pub fn realigned(project: &Project, world_from_model: Similarity) -> Project {
    Project { world_from_model, ..project.clone() }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use quadratura_base::geometry::axes;

    #[test]
    fn every_transform_that_is_suggested_is_read_again_exactly() {
        let conventions = axes::conventions().into_iter().map(|(_, rotation)| rotation);
        for (rotation, step) in conventions.zip(1..) {
            let moved = Similarity { rotation, scale: 1.0, translation: DVec3::X * f64::from(step) };
            let transform = moved.to_string();
            let suggestion =
                AlignmentSuggestion { transform, agreement: None, covered: None, alternatives: Vec::new() };
            assert_eq!(suggestion.similarity(), moved);
        }
    }
}
