//! The light of groups on single surfaces: what the photos' gains do not explain of the differences between groups, such as a
//! facade that is in the shadow in one group and in the sun in another.
//!
//! At common points that photos of several groups show, each group's light relative to the mean over these groups is known.
//! Its robust mean on each face is drawn towards 0, so that few points decide nothing, and towards that of the faces with
//! which the face shares an edge, the more the less they are turned against each other. Photos of one group that serve a view
//! that leans to another are multiplied by the ratio of the two.

use serde::{Deserialize, Serialize};

use super::groups::LightGroups;
use super::patch::PatchColour;
use super::points::SharedPoint;
use quadratura_base::raster::robust::upper_median;
use quadratura_base::scene::{FaceId, PhotoId};

/// The number of points that 0 counts for on each face: those of one face lie close together, and err together.
const PRIOR: f64 = 10.0;
/// The number of points that a face counts for on another in the same plane with which it shares an edge.
const JOINED: f64 = 5.0;
/// The largest deviation from the median of a face that counts, as a natural logarithm: beyond, something moved.
const LARGEST: f64 = 0.5;
/// The number of times that faces are made equal to their neighbours; light does not spread farther than that.
const ROUNDS: usize = 30;

/// Two faces that share an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JoinedFaces {
    /// The faces.
    pub faces: [FaceId; 2],
    /// The absolute cosine of the angle between their normals.
    pub cosine: f64,
}

/// The light of groups on each face, beside the photos' gains.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SurfaceGains {
    /// The number of groups; 0 where nothing is known.
    groups: usize,
    /// The natural logarithm of the light of each group, R, G, B, on each face, in the order of the faces and then the
    /// groups. Faces beyond the list have 0.
    of_face: Vec<[f64; 3]>,
}

impl SurfaceGains {
    /// Estimates the light of groups on faces. `gains` are the photos'.
    pub(super) fn new(
        points: &[SharedPoint],
        colours: &[Vec<PatchColour>],
        gains: &[[f64; 3]],
        groups: &LightGroups,
        joined: &[JoinedFaces],
    ) -> Self {
        let count = groups.count();
        let in_points = points.iter().map(|point| point.face.0 as usize);
        let faces =
            joined.iter().flat_map(|joined| joined.faces).map(|face| face.0 as usize).chain(in_points);
        let faces = faces.max().map_or(0, |last| last + 1);
        let mut of_face: Vec<Vec<[f64; 3]>> = vec![Vec::new(); faces * count];
        for (point, colours) in points.iter().zip(colours) {
            for (group, light) in lights(point, colours, gains, groups) {
                of_face[point.face.0 as usize * count + group].push(light);
            }
        }
        if of_face.iter().all(Vec::is_empty) {
            return Self::default();
        }
        let points: Vec<f64> = of_face.iter().map(|lights| lights.len() as f64).collect();
        let means: Vec<[f64; 3]> = of_face.iter().map(|lights| robust_mean(lights)).collect();
        let mut beside: Vec<Vec<(usize, f64)>> = vec![Vec::new(); faces];
        for JoinedFaces { faces: [a, b], cosine } in joined {
            beside[a.0 as usize].push((b.0 as usize, JOINED * cosine));
            beside[b.0 as usize].push((a.0 as usize, JOINED * cosine));
        }
        let mut of_face = vec![[0.0; 3]; faces * count];
        for _ in 0..ROUNDS {
            for (face, beside) in beside.iter().enumerate() {
                let around: f64 = beside.iter().map(|(_, weight)| weight).sum();
                for at in face * count..(face + 1) * count {
                    let all = points[at] + PRIOR + around;
                    of_face[at] = [0, 1, 2].map(|c| {
                        let others = beside
                            .iter()
                            .map(|(other, weight)| weight * of_face[other * count + at % count][c]);
                        (points[at] * means[at][c] + others.sum::<f64>()) / all
                    });
                }
            }
        }
        Self::from_faces(count, of_face)
    }

    /// Takes the natural logarithms of the light of groups, in the order of the faces and then the groups.
    pub fn from_faces(groups: usize, of_face: Vec<[f64; 3]>) -> Self {
        Self { groups, of_face }
    }

    /// Returns true where nothing is known.
    pub fn is_empty(&self) -> bool {
        self.groups == 0
    }

    /// Returns the factors that bring photos to the light of groups in these shares, which sum to 1.
    pub fn towards(&self, shares: &[f64], groups: &LightGroups) -> SurfaceFactors {
        if self.is_empty() {
            return SurfaceFactors::default();
        }
        let of_face = self.of_face.chunks_exact(self.groups).flat_map(|lights| {
            let mean = [0, 1, 2]
                .map(|c| lights.iter().zip(shares).map(|(light, share)| share * light[c]).sum::<f64>());
            lights.iter().map(move |light| [0, 1, 2].map(|c| (mean[c] - light[c]).exp()))
        });
        SurfaceFactors { groups: groups.clone(), count: self.groups, of_face: of_face.collect() }
    }
}

/// Factors on the photos' linear colours in a view, by face and group of light.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SurfaceFactors {
    /// The photos' groups.
    groups: LightGroups,
    /// The number of groups; 0 where there are no factors.
    count: usize,
    /// The factors, R, G, B, in the order of the faces and then the groups.
    of_face: Vec<[f64; 3]>,
}

impl SurfaceFactors {
    /// Returns the number of groups; 0 where all factors are 1.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns the factors of all groups on a face; none where they are 1.
    pub fn of_groups(&self, face: FaceId) -> &[[f64; 3]] {
        let first = face.0 as usize * self.count;
        self.of_face.get(first..first + self.count).unwrap_or_default()
    }

    /// Returns the factor on a photo's colours on a face.
    pub fn of(&self, face: FaceId, photo: PhotoId) -> [f64; 3] {
        self.of_groups(face).get(self.groups.of(photo)).copied().unwrap_or([1.0; 3])
    }
}

/// Returns the logarithm of the light of each group at a point, relative to the mean of these groups; none where only one group
/// shows it.
fn lights(
    point: &SharedPoint,
    colours: &[PatchColour],
    gains: &[[f64; 3]],
    groups: &LightGroups,
) -> Vec<(usize, [f64; 3])> {
    let mut of_group: Vec<([f64; 3], u32)> = vec![([0.0; 3], 0); groups.count()];
    for (patch, colour) in point.patches.iter().zip(colours) {
        let Some(colour) = colour.filter(|colour| colour.usable) else { continue };
        let (sum, count) = &mut of_group[groups.of(patch.photo)];
        (0..3).for_each(|c| sum[c] += colour.mean[c].ln() - gains[patch.photo.index()][c]);
        *count += 1;
    }
    let known = of_group.into_iter().enumerate().filter(|(_, (_, count))| *count > 0);
    let known: Vec<(usize, [f64; 3])> =
        known.map(|(group, (sum, count))| (group, sum.map(|sum| sum / f64::from(count)))).collect();
    if known.len() < 2 {
        return Vec::new();
    }
    let mean = [0, 1, 2].map(|c| known.iter().map(|(_, light)| light[c]).sum::<f64>() / known.len() as f64);
    known.into_iter().map(|(group, light)| (group, [0, 1, 2].map(|c| light[c] - mean[c]))).collect()
}

/// Returns the mean of values near their median, per channel; 0 without any.
fn robust_mean(lights: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|c| {
        let mut values: Vec<f64> = lights.iter().map(|light| light[c]).collect();
        let Some(median) = upper_median(&mut values) else { return 0.0 };
        values.iter().map(|value| value.clamp(median - LARGEST, median + LARGEST)).sum::<f64>()
            / values.len() as f64
    })
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::exposure::{MeanColour, PointPatch};

    /// Returns points on a face that two photos show, the second with this light.
    fn points(face: u32, count: usize, light: f64) -> Vec<(SharedPoint, Vec<PatchColour>)> {
        let patch = |photo: u32| PointPatch {
            photo: PhotoId(photo),
            center_px: DVec2::ZERO,
            towards_camera: DVec3::Z,
            distance: 1.0,
            px_per_unit: 1.0,
        };
        let point = SharedPoint {
            own: PhotoId(0),
            face: FaceId(face),
            position: DVec3::ZERO,
            normal: DVec3::Z,
            patches: vec![patch(0), patch(1)],
        };
        let colour = |light: f64| Some(MeanColour { mean: [0.5 * light, 0.5, 0.5 * light], usable: true });
        vec![(point, vec![colour(1.0), colour(light)]); count]
    }

    #[test]
    fn a_shadow_of_one_group_is_taken_off_the_faces_where_it_is() {
        let (points, colours): (Vec<_>, Vec<_>) =
            [points(0, 200, 0.3), points(2, 200, 1.0), points(3, 3, 0.3)].concat().into_iter().unzip();
        let groups = LightGroups::new(&[0, 1]);
        let joined = [JoinedFaces { faces: [FaceId(0), FaceId(1)], cosine: 1.0 }];
        let found = SurfaceGains::new(&points, &colours, &[[0.0; 3]; 2], &groups, &joined);
        let factors = found.towards(&[1.0, 0.0], &groups);
        let red = |face: u32, photo: u32| factors.of(FaceId(face), PhotoId(photo))[0];
        assert!((red(0, 1) * 0.3 - 1.0).abs() < 0.15, "{}", red(0, 1));
        assert_eq!((red(0, 0), factors.of(FaceId(0), PhotoId(1))[1]), (1.0, 1.0), "its own light, and green");
        assert!(red(1, 1) > 1.2 && red(1, 1) < red(0, 1), "as its neighbour, but less: {}", red(1, 1));
        assert_eq!((red(2, 1), red(9, 1)), (1.0, 1.0));
        assert!(red(3, 1) > 1.0 && red(3, 1) < 1.5, "three points say little: {}", red(3, 1));
        // Halfway between both groups, each is brought halfway.
        let between = found.towards(&[0.5, 0.5], &groups);
        let [lit, dark] = [0, 1].map(|photo| between.of(FaceId(0), PhotoId(photo))[0]);
        assert!((lit * dark - 1.0).abs() < 1e-9 && dark > 1.5, "{lit} {dark}");
        assert_eq!(SurfaceGains::default().towards(&[1.0], &groups).count(), 0);
    }
}
