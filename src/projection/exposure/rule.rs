//! The rule by which views are exposed, and the lead that another than that by place needs.

use serde::{Deserialize, Serialize};

use quadratura_view::Exposure;

/// A rule for the exposure of views.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExposureRule {
    /// By place: [`Exposure::Near`].
    #[default]
    Near,
    /// By the meter: [`Exposure::Metered`].
    Metered,
    /// The common exposure: [`Exposure::Common`].
    Common,
    /// The photos as they are: [`Exposure::Raw`].
    Raw,
}

impl ExposureRule {
    /// All rules.
    pub const ALL: [Self; 4] = [Self::Near, Self::Metered, Self::Common, Self::Raw];

    /// Returns the exposure of views under the rule.
    pub fn exposure(self) -> Exposure {
        match self {
            Self::Near => Exposure::Near,
            Self::Metered => Exposure::Metered,
            Self::Common => Exposure::Common,
            Self::Raw => Exposure::Raw,
        }
    }

    /// Returns the rule's word in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Near => "near",
            Self::Metered => "metered",
            Self::Common => "common",
            Self::Raw => "raw",
        }
    }
}

/// How well a rule predicts photos that are left out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RuleScore {
    /// The rule.
    pub rule: ExposureRule,
    /// The mean over whole photos of the PSNR of their predicted colours, in dB.
    pub psnr: f64,
}

/// By how many dB photos that are left out are predicted better in one way than in another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Lead {
    /// The mean over photos; below 0 where they are predicted worse.
    pub mean: f64,
    /// The standard error of the mean.
    pub error: f64,
}

impl Lead {
    /// Returns the lead of several photos; `None` for fewer than two.
    pub(super) fn of(leads: &[f64]) -> Option<Self> {
        let count = leads.len() as f64;
        let mean = leads.iter().sum::<f64>() / count;
        let squares: f64 = leads.iter().map(|lead| (lead - mean).powi(2)).sum();
        (leads.len() > 1).then(|| Self { mean, error: (squares / (count * (count - 1.0))).sqrt() })
    }

    /// Returns true when the lead is hardly due to chance: more than twice its standard error.
    pub fn is_clear(&self) -> bool {
        self.mean > 2.0 * self.error
    }
}

/// The lead from which on another rule than that by place is taken, in dB.
pub(super) const CLEAR_DB: f64 = 0.1;

/// Returns the best rule.
pub(super) fn best_rule(scores: &[RuleScore]) -> ExposureRule {
    let Some(near) = psnr_of(scores, ExposureRule::Near) else { return ExposureRule::default() };
    let better = scores.iter().filter(|score| score.psnr > near + CLEAR_DB);
    better.max_by(|a, b| a.psnr.total_cmp(&b.psnr)).map_or(ExposureRule::Near, |score| score.rule)
}

/// Returns by how many dB photos are predicted better in the exposure that their cameras wrote down than by a rule.
pub(super) fn camera_lead(by_camera: &[(f64, [f64; 4])], rule: ExposureRule) -> Option<f64> {
    let rule = ExposureRule::ALL.iter().position(|other| *other == rule)?;
    let leads = by_camera.iter().map(|(camera, by_rule)| camera - by_rule[rule]);
    (!by_camera.is_empty()).then(|| leads.sum::<f64>() / by_camera.len() as f64)
}

/// Returns the PSNR of a rule; `None` where rules were not compared.
pub(super) fn psnr_of(scores: &[RuleScore], rule: ExposureRule) -> Option<f64> {
    scores.iter().find(|score| score.rule == rule).map(|score| score.psnr)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_rule_than_by_place_needs_a_lead_and_the_best_of_several_is_taken() {
        let best = |psnr: [f64; 4]| {
            let scores = ExposureRule::ALL.into_iter().zip(psnr).map(|(rule, psnr)| RuleScore { rule, psnr });
            best_rule(&scores.collect::<Vec<_>>())
        };
        assert_eq!(best([30.0, 30.05, 29.0, 30.09]), ExposureRule::Near);
        assert_eq!(best([30.0, 30.2, 29.0, 30.3]), ExposureRule::Raw);
        assert_eq!(best([30.0, 29.0, 30.2, 30.1]), ExposureRule::Common);
        assert_eq!(best_rule(&[]), ExposureRule::Near);
    }
}
