//! What is estimated of the exposure of photos.

use serde::{Deserialize, Serialize};

use super::gain_support::GainSupport;
use super::gains::Gains;
use super::grouping::GroupSupport;
use super::rule::{ExposureRule, Lead, RuleScore, psnr_of};
use quadratura_base::scene::PhotoId;

/// The result of the estimation of gains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The gains.
    pub gains: Gains,
    /// How well each rule of exposure predicts photos that are left out; empty where nothing can be compared.
    pub rules: Vec<RuleScore>,
    /// By how many dB left-out photos are predicted better in the exposure that their cameras wrote down than by the best rule;
    /// `None` where none is known or nothing can be compared.
    #[serde(default)]
    pub camera_lead: Option<f64>,
    /// The PSNR, in dB, with which the colours of each photo that was left out are predicted at common points by each rule, in the
    /// order of [`ExposureRule::ALL`].
    #[serde(default)]
    pub left_out_psnr: Vec<[f64; 4]>,
    /// The lead of views that lean to the groups of light that they show most of over those with all photos in one group; `None`
    /// where all photos are one group, and where nothing can be compared.
    #[serde(default)]
    pub leaning_lead: Option<Lead>,
    /// The lead of gains per surface, by which other groups are brought over to the light of a photo's group; `None` as for
    /// `leaning_lead`.
    #[serde(default)]
    pub surfaces_lead: Option<Lead>,
    /// By how many dB left-out photos are predicted better where views keep the vignetting of lenses; `None` where none was
    /// found or it was not compared.
    pub vignetting_lead: Option<f64>,
    /// The support of each photo's gain.
    #[serde(rename = "grounds")]
    pub gain_support: Vec<GainSupport>,
    /// The typical distance between surfaces and their cameras, in world units; movements of the camera are
    /// measured relative to it ([`super::Shares::new`]).
    pub reach: f64,
    /// The number of surface points that two photos or more show with usable colours.
    pub points: usize,
    /// The number of compared pairs of photos, over all points.
    pub pairs: usize,
    /// What speaks for the groups of light.
    #[serde(default)]
    pub group_support: GroupSupport,
    /// Photos that share no point with another one; their gain is unknown, and 0.
    pub alone: Vec<PhotoId>,
    /// The number of groups of photos that share points, not counting photos alone.
    pub components: usize,
    /// Median of the absolute log ratios, R, G, B, of the unchanged photos.
    pub before: [f64; 3],
    /// Median of the absolute log ratios, R, G, B, after gains and optics are removed: the rest is due to
    /// misregistered textures, reflections and changed light.
    pub after: [f64; 3],
}

impl Estimate {
    /// Decides whether views lean to groups of light, given what is estimated with all photos in one group. A wrong guess at the
    /// light costs several dB, a right one brings as much: few photos decide only where they clearly say the same.
    pub(super) fn decide_leaning(&mut self, one: Self) {
        self.leaning_lead = lead_over(self, &one);
        if self.leaning_lead.is_some_and(|lead| !lead.is_clear()) {
            (self.rules, self.left_out_psnr) = (one.rules, one.left_out_psnr);
            self.camera_lead = one.camera_lead;
            self.vignetting_lead = one.vignetting_lead;
            self.gains.rule = one.gains.rule;
            self.gains.light.blended = Some(Box::new(one.gains));
        }
    }

    /// Numbers the photos, which are the `kept` ones (in rising order) of `count`, as among all.
    pub(super) fn among(self, kept: &[PhotoId], count: usize) -> Self {
        let mut gain_support = vec![GainSupport::default(); count];
        for (i, photo) in kept.iter().map(|photo| photo.index()).enumerate() {
            gain_support[photo] = self.gain_support[i];
        }
        let has_gain =
            |photo: &PhotoId| kept.binary_search(photo).is_ok_and(|i| !self.alone.contains(&PhotoId::new(i)));
        let alone = PhotoId::all(count).filter(|photo| !has_gain(photo)).collect();
        let gains = self.gains.among(kept, count);
        Self { gains, gain_support, alone, ..self }
    }
}

/// Returns the lead of one estimate over another, each with its rule; `None` where less than two photos can be compared.
fn lead_over(estimate: &Estimate, other: &Estimate) -> Option<Lead> {
    let of_rule = |estimate: &Estimate| -> Vec<f64> {
        let rule = ExposureRule::ALL.iter().position(|rule| *rule == estimate.gains.rule).unwrap_or(0);
        estimate.left_out_psnr.iter().map(|psnr| psnr[rule]).collect()
    };
    // The same photos are left out, in the same order.
    let leads = of_rule(estimate).into_iter().zip(of_rule(other)).map(|(own, other)| own - other);
    Lead::of(&leads.collect::<Vec<f64>>())
}

/// Returns the PSNR of the rule that was taken; `None` where rules were not compared.
pub(super) fn best_psnr(estimate: &Estimate) -> Option<f64> {
    psnr_of(&estimate.rules, estimate.gains.rule)
}
