//! How well a pose of the model explains what cameras see of the points: rays from observers to points have to hit the
//! model first at the points, and no part of the model may count for more than a few of them.

use glam::DVec3;

use quadratura_base::geometry::Similarity;

use super::points::Points;
use super::surface::NormalisedModel;

/// No region counts for more than this share of the points. Without the limit, a big face enlarged many times wins
/// wherever the model lacks the wall on which most points lie.
pub const MOST_PER_REGION: f64 = 0.03;

/// What agrees beyond that limit counts this share.
const BEYOND: f64 = 0.05;

/// The price of a point that is hidden by the model.
const BLOCKED: f64 = 0.5;

/// The least cosine between the normals of the points' plane and of the face on which a point lies: 30 degrees.
const SAME_WAY: f64 = 0.86;

/// A ray from an observer to a point, in normalised coordinates of the points.
#[derive(Debug, Clone, Copy)]
pub struct ObservedRay {
    pub eye: DVec3,
    pub point: DVec3,
    /// The normal of the plane that the point lies on.
    pub normal: Option<DVec3>,
}

/// The rays to a sample of the points.
pub fn rays(points: &Points, sample: &[u32]) -> Vec<ObservedRay> {
    let ray = |i: &u32| {
        let sight = &points.sights[*i as usize];
        let normal = sight.plane.map(|plane| points.planes[plane as usize].normal);
        ObservedRay { eye: sight.eye, point: sight.point, normal }
    };
    sample.iter().map(ray).collect()
}

/// Where a ray hits the model: the distance of the hit over the point's distance, and the triangle.
pub type Hit = Option<(f64, u32)>;

/// Casts the rays against the model at a pose, which takes normalised model coordinates to those of the points. Hits
/// beyond `reach` times the point's distance are left out.
pub fn cast(surface: &NormalisedModel, rays: &[ObservedRay], pose: &Similarity, reach: f64) -> Vec<Hit> {
    let back = pose.inverse();
    let hit = |ray: &ObservedRay| {
        let eye = back.apply(ray.eye);
        surface.tree.first_hit(eye, back.apply(ray.point) - eye, reach)
    };
    rays.iter().map(hit).collect()
}

/// Returns whether a hit lies on the point, within a share `tolerance` of its distance, on a face that runs the way the
/// points do.
pub fn agrees(
    surface: &NormalisedModel,
    ray: &ObservedRay,
    pose: &Similarity,
    (q, triangle): (f64, u32),
    tolerance: f64,
) -> bool {
    let same_way =
        |normal: DVec3| (pose.rotation * surface.normals[triangle as usize]).dot(normal).abs() > SAME_WAY;
    (q - 1.0).abs() < tolerance && ray.normal.is_none_or(same_way)
}

/// What a pose is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worth {
    /// With the limit per region; 0 and less for no agreement.
    pub capped: f64,
    /// Without it: the share of rays that agree, each by its closeness.
    pub plain: f64,
}

/// Judges hits.
pub fn judge(
    surface: &NormalisedModel,
    rays: &[ObservedRay],
    hits: &[Hit],
    pose: &Similarity,
    tolerance: f64,
) -> Worth {
    let mut regions = vec![0.0; surface.region_count];
    let (mut plain, mut blocked) = (0.0, 0.0);
    let share = 1.0 / rays.len().max(1) as f64;
    for (ray, hit) in rays.iter().zip(hits) {
        let Some((q, triangle)) = *hit else { continue };
        if agrees(surface, ray, pose, (q, triangle), tolerance) {
            let value = share * (1.0 - 0.5 * ((q - 1.0) / tolerance).powi(2));
            regions[surface.regions[triangle as usize] as usize] += value;
            plain += value;
        } else if q < 1.0 - 2.5 * tolerance {
            blocked += share;
        }
    }
    let limited: f64 = regions.iter().map(|value| value.min(MOST_PER_REGION)).sum();
    Worth { capped: limited + BEYOND * (plain - limited) - BLOCKED * blocked, plain }
}

/// Casts and judges in one.
pub fn score(surface: &NormalisedModel, rays: &[ObservedRay], pose: &Similarity, tolerance: f64) -> Worth {
    let hits = cast(surface, rays, pose, 1.0 + 1.5 * tolerance);
    judge(surface, rays, &hits, pose, tolerance)
}
