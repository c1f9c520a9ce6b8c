//! Likely reasons for a wrong alignment, as messages.

use super::{SearchOutcome, Verdict};
use glam::DMat3;
use quadratura_base::geometry::{Similarity, axes};

/// Scales that differ from 1 by less than this are a finer fit, not another unit.
const SAME_UNIT: f64 = 0.02;

/// Compares the present transform with a better one and returns one sentence for each likely mistake: axes, unit,
/// position. Both transforms take the model to the cameras' world.
pub fn likely_mistakes(now: &Similarity, better: &Similarity) -> Vec<String> {
    let correction = better.compose(&now.inverse());
    let mut mistakes = Vec::new();
    if !correction.rotation.abs_diff_eq(DMat3::IDENTITY, 1e-9) {
        let convention =
            axes::conventions().into_iter().find(|(_, r)| r.abs_diff_eq(correction.rotation, 1e-9));
        mistakes.push(match convention {
            Some((name, _)) => {
                format!("The model's axes differ from the cameras': the model has to be read as {name}.")
            }
            None => "The model is rotated relative to the cameras.".into(),
        });
    }
    if (correction.scale - 1.0).abs() > SAME_UNIT {
        let unit = unit(correction.scale);
        mistakes.push(format!(
            "The model has another unit than the cameras: one unit of the model is {unit} \
            of the cameras'."
        ));
    }
    let shift = correction.translation.length();
    // The size of the site is unknown here, so every shift is reported with its length.
    if shift > 0.0 {
        mistakes.push(format!("The model is shifted by {shift:.3} units of the cameras' world."));
    }
    mistakes
}

/// Returns advice for a model that no other transform aligns better, by how the search ended.
pub fn advice_without_fix(verdict: Verdict, search: Option<SearchOutcome>) -> &'static str {
    match (verdict, search) {
        (Verdict::Fits, _) => "",
        (_, Some(SearchOutcome::Mirrored)) => {
            "The model is mirrored: its axes are left-handed. Export it again with right-handed axes, or with one axis \
             reversed."
        }
        (_, Some(SearchOutcome::NoFaces)) => {
            "The model has no face with an area that could be aligned: objects named backdrop or sky, and those that turn \
             towards the camera, do not count. Use the model of the site."
        }
        (_, Some(SearchOutcome::FewPoints)) => {
            "Too few sparse points are seen by these photos to align the model by them. Export the cameras with their \
             points, or point out corners of the model in the photos with --pair."
        }
        (_, Some(SearchOutcome::NoPlanes)) => {
            "The sparse points lie on no planes, so that no faces can be laid on them. Point out corners of the model in \
             the photos with --pair."
        }
        (Verdict::Misses, _) => {
            "The cameras and the model are probably not of the same site: no turn, scale and shift align \
             the model with the photos. Use the model that belongs to these cameras, or the cameras that belong to this \
             model. If they are of the same site, point out corners of the model in the photos with --pair."
        }
        (Verdict::Poor, _) => {
            "No other turn, scale and shift fit better: the model leaves out much of what the photos show, \
             or shows another state of the site. Look at its edges over the photos; if they do not match, point out \
             corners of the model in the photos with --pair."
        }
    }
}

/// Writes a scale: as an integer where it is nearly one, otherwise with four significant digits.
fn unit(scale: f64) -> String {
    let rounded = scale.round();
    if rounded >= 1.0 && (scale / rounded - 1.0).abs() < 1e-3 {
        return rounded.to_string();
    }
    format!("{scale:.3e}").parse::<f64>().map_or_else(|_| scale.to_string(), |scale| scale.to_string())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn transform(text: &str) -> Similarity {
        Similarity::parse(text).unwrap()
    }

    #[test]
    fn a_model_with_other_axes_or_another_unit_is_told_so() {
        let [mistake] = likely_mistakes(&Similarity::IDENTITY, &transform("y-up")).try_into().unwrap();
        assert!(mistake.contains("y-up") || mistake.contains("x,"), "{mistake}");
        let centimetres = Similarity { scale: 0.01, ..Similarity::IDENTITY };
        let [mistake] = likely_mistakes(&Similarity::IDENTITY, &centimetres).try_into().unwrap();
        assert!(mistake.contains("is 0.01 of the cameras'"), "{mistake}");
        assert!(likely_mistakes(&centimetres, &Similarity::IDENTITY)[0].contains("is 100 of the cameras'"));
    }

    #[test]
    fn what_stands_as_it_should_has_no_mistake_and_a_shift_is_told_by_its_length() {
        let upright = transform("y-up");
        assert!(likely_mistakes(&upright, &upright).is_empty());
        let moved = Similarity { translation: DVec3::new(3.0, 0.0, 4.0), ..Similarity::IDENTITY };
        assert!(likely_mistakes(&Similarity::IDENTITY, &moved)[0].contains("5.000 units"));
    }
}
