//! The model as the search sees it: triangles for rays, *regions* (coplanar triangles that share edges), and *planes*
//! (all coplanar triangles), in coordinates about its middle in units of its radius.

use glam::DVec3;
use rustc_hash::FxHashMap;

use quadratura_base::geometry::Similarity;
use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::geometry::triangle::{Triangle, area_vector};
use quadratura_base::scene::{FaceId, Model};

/// A model in normalised coordinates: `model = origin + radius * normalised`.
pub struct NormalisedModel {
    /// The middle of the model, in its own coordinates.
    pub origin: DVec3,
    /// The median distance of its area from the middle, in its own unit.
    pub radius: f64,
    /// The triangles, normalised.
    pub tree: Bvh,
    /// The unit normal of each triangle.
    pub normals: Vec<DVec3>,
    /// The region of each triangle, counted from 0.
    pub regions: Vec<u32>,
    /// The number of regions.
    pub region_count: usize,
    /// The most telling planes, the first one first.
    pub planes: Vec<ModelPlane>,
}

/// A plane of the model with all its triangles.
pub struct ModelPlane {
    /// The unit normal, on the side from which the triangles run counter-clockwise.
    pub normal: DVec3,
    /// A point of the plane.
    pub point: DVec3,
    /// The area of its triangles, in squares of the radius.
    pub area: f64,
    /// Its triangles.
    pub triangles: Vec<u32>,
    /// One or two unit directions of most of its edges.
    pub directions: Vec<DVec3>,
}

/// Objects with these words in their names are not part of the site: the sky is nowhere.
const ELSEWHERE: [&str; 2] = ["backdrop", "sky"];

/// Two triangles are coplanar when their normals differ by less than this.
const PARALLEL_COS: f64 = 0.9986; // 3 degrees

/// ... and when one lies no farther from the plane of the other, in radii.
const COPLANAR: f64 = 0.004;

/// The number of planes that the search lays on planes of the points. By area alone, window panes and reliefs behind
/// a wall that is missing would be left out, so planes are ranked by the sum of the roots of their faces' areas.
const PLANES: usize = 14;

/// The most triangles that are gathered to planes, the largest ones, and the most planes that are told apart before they
/// are ranked: a model of a million triangles takes no longer.
const GATHERED: usize = 20_000;
const PLANES_HELD: usize = 4000;

impl NormalisedModel {
    /// Reads the faces of a model that are part of the site; `None` where they have no area at all.
    pub fn new(model: &Model) -> Option<Self> {
        let elsewhere = |face: FaceId| {
            let object = model.object(model.face(face).object);
            let name = object.name.to_lowercase();
            object.impostor.is_some() || object.billboard || ELSEWHERE.iter().any(|word| name.contains(word))
        };
        let faces = model.face_ids().filter(|face| !elsewhere(*face));
        let (mut raw, mut face_of) = (Vec::new(), Vec::new());
        for face in faces {
            for corners in model.face_triangles(face) {
                let triangle: Triangle = corners.map(|v| model.vertices[v as usize]);
                if triangle.iter().all(|corner| corner.is_finite()) && area_vector(&triangle) != DVec3::ZERO {
                    raw.push(triangle);
                    face_of.push(face);
                }
            }
        }
        let (origin, radius) = middle(&raw)?;
        let triangles: Vec<Triangle> =
            raw.iter().map(|corners| corners.map(|corner| (corner - origin) / radius)).collect();
        let normals: Vec<DVec3> = triangles.iter().map(|t| area_vector(t).normalize_or_zero()).collect();
        let (regions, region_count, borders) = regions(&triangles, &normals);
        let planes = planes(&triangles, &normals, &face_of, &borders);
        Some(Self { origin, radius, tree: Bvh::new(triangles), normals, regions, region_count, planes })
    }
}

impl NormalisedModel {
    /// Whether most of the model's area lies on the model again after a transform of normalised coordinates.
    pub fn repeats(&self, by: &Similarity) -> bool {
        const LOOKED_AT: usize = 200;
        const NEAR: f64 = 0.03;
        let triangles = self.tree.triangles();
        let area = |t: &usize| area_vector(&triangles[*t]).length();
        let mut largest: Vec<usize> = (0..triangles.len()).collect();
        largest.sort_by(|a, b| area(b).total_cmp(&area(a)).then(a.cmp(b)));
        largest.truncate(LOOKED_AT);
        let (mut all, mut again) = (0.0, 0.0);
        for t in &largest {
            let [a, b, c] = triangles[*t];
            for [of_a, of_b, of_c] in [[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]] {
                let place = by.apply((a * of_a + b * of_b + c * of_c) / 6.0);
                let normal = by.rotation * self.normals[*t];
                let is_there = self.tree.nearest(place).is_some_and(|(other, foot)| {
                    foot.distance(place) < NEAR && self.normals[other as usize].dot(normal).abs() > 0.9
                });
                all += area(t);
                again += if is_there { area(t) } else { 0.0 };
            }
        }
        again > 0.6 * all
    }
}

/// Returns the median centre by area, and the median distance from it.
fn middle(triangles: &[Triangle]) -> Option<(DVec3, f64)> {
    let places: Vec<(DVec3, f64)> = triangles
        .iter()
        .map(|t| ((t[0] + t[1] + t[2]) / 3.0, area_vector(t).length()))
        .filter(|(_, area)| area.is_finite())
        .collect();
    let along = |axis: usize| weighted_median(places.iter().map(|(place, area)| (place[axis], *area)));
    let origin = DVec3::new(along(0)?, along(1)?, along(2)?);
    // One face reaches as far as its corners.
    let far = triangles
        .iter()
        .zip(&places)
        .map(|(t, (_, area))| (t.iter().map(|corner| corner.distance(origin)).sum::<f64>() / 3.0, *area));
    let radius = weighted_median(far)?;
    (radius > 0.0 && radius.is_finite() && origin.is_finite()).then_some((origin, radius))
}

/// Returns the value up to which half of the weight lies.
fn weighted_median(values: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let mut values: Vec<(f64, f64)> = values.collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * values.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut sum = 0.0;
    values.into_iter().find_map(|(value, weight)| {
        sum += weight;
        (sum >= half).then_some(value)
    })
}

/// Whether two triangles lie in one plane, on whichever sides they are seen.
fn coplanar(a: (&Triangle, DVec3), b: (&Triangle, DVec3)) -> bool {
    let flat = |corner: &DVec3| (corner - a.0[0]).dot(a.1).abs() < COPLANAR;
    a.1.dot(b.1).abs() > PARALLEL_COS && b.0.iter().all(flat)
}

/// Joins coplanar triangles along edges that they share. Returns the region of each triangle, the number of regions,
/// and the edges on the borders of regions, each with its triangle.
fn regions(triangles: &[Triangle], normals: &[DVec3]) -> (Vec<u32>, usize, Vec<(u32, DVec3, DVec3)>) {
    let mut parents: Vec<u32> = (0..triangles.len() as u32).collect();
    let mut edges: FxHashMap<[[i64; 3]; 2], Vec<u32>> = FxHashMap::default();
    let key = |corner: DVec3| (corner * 1e6).round().to_array().map(|x| x as i64);
    let edge_key = |a: DVec3, b: DVec3| {
        let (a, b) = (key(a), key(b));
        if a < b { [a, b] } else { [b, a] }
    };
    for (t, corners) in (0..).zip(triangles) {
        for i in 0..3 {
            edges.entry(edge_key(corners[i], corners[(i + 1) % 3])).or_default().push(t);
        }
    }
    let joined = |a: u32, b: u32| {
        let (a, b) = (a as usize, b as usize);
        coplanar((&triangles[a], normals[a]), (&triangles[b], normals[b]))
    };
    let mut shared: Vec<(u32, u32)> =
        edges.values().flat_map(|all| all.windows(2).map(|pair| (pair[0], pair[1]))).collect();
    shared.sort_unstable();
    for (a, b) in shared {
        if joined(a, b) {
            let (a, b) = (root(&mut parents, a), root(&mut parents, b));
            parents[a.max(b) as usize] = a.min(b);
        }
    }
    let mut numbers: FxHashMap<u32, u32> = FxHashMap::default();
    let regions: Vec<u32> = (0..triangles.len() as u32)
        .map(|t| {
            let (root, next) = (root(&mut parents, t), numbers.len() as u32);
            *numbers.entry(root).or_insert(next)
        })
        .collect();
    let mut borders = Vec::new();
    for (t, corners) in (0..).zip(triangles) {
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            let inner = edges[&edge_key(a, b)]
                .iter()
                .any(|other| *other != t && regions[*other as usize] == regions[t as usize]);
            if !inner {
                borders.push((t, a, b));
            }
        }
    }
    (regions, numbers.len(), borders)
}

/// Follows a union-find forest to the root, shortening the path.
fn root(parents: &mut [u32], mut at: u32) -> u32 {
    while parents[at as usize] != at {
        let next = parents[parents[at as usize] as usize];
        parents[at as usize] = next;
        at = next;
    }
    at
}

/// Gathers coplanar triangles, the largest first, and ranks the planes.
fn planes(
    triangles: &[Triangle],
    normals: &[DVec3],
    faces: &[FaceId],
    borders: &[(u32, DVec3, DVec3)],
) -> Vec<ModelPlane> {
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    let area = |t: u32| 0.5 * area_vector(&triangles[t as usize]).length();
    order.sort_by(|a, b| area(*b).total_cmp(&area(*a)).then(a.cmp(b)));
    order.truncate(GATHERED);
    let mut planes: Vec<ModelPlane> = Vec::new();
    for t in order {
        let (normal, place) = (normals[t as usize], triangles[t as usize].iter().sum::<DVec3>() / 3.0);
        let of = |plane: &&mut ModelPlane| {
            plane.normal.dot(normal) > PARALLEL_COS
                && (place - plane.point).dot(plane.normal).abs() < COPLANAR
        };
        let held = planes.len();
        match planes.iter_mut().find(of) {
            Some(plane) => {
                plane.triangles.push(t);
                plane.area += area(t);
            }
            None if held < PLANES_HELD => planes.push(ModelPlane {
                normal,
                point: place,
                area: area(t),
                triangles: vec![t],
                directions: Vec::new(),
            }),
            None => (),
        }
    }
    let rank = |plane: &ModelPlane| {
        let mut of_faces: FxHashMap<FaceId, f64> = FxHashMap::default();
        for t in &plane.triangles {
            *of_faces.entry(faces[*t as usize]).or_default() += area(*t);
        }
        let mut areas: Vec<f64> = of_faces.into_values().map(f64::sqrt).collect();
        // Sums are the same on every run only in one order.
        areas.sort_by(f64::total_cmp);
        areas.iter().sum::<f64>()
    };
    let mut ranked: Vec<(f64, ModelPlane)> = planes.into_iter().map(|plane| (rank(&plane), plane)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked.truncate(PLANES);
    let mut planes: Vec<ModelPlane> = ranked.into_iter().map(|(_, plane)| plane).collect();
    let mut plane_of = vec![usize::MAX; triangles.len()];
    for (i, plane) in planes.iter().enumerate() {
        plane.triangles.iter().for_each(|t| plane_of[*t as usize] = i);
    }
    let mut edges: Vec<Vec<DVec3>> = vec![Vec::new(); planes.len()];
    for (t, a, b) in borders {
        if let Some(edges) = edges.get_mut(plane_of[*t as usize]) {
            edges.push(b - a);
        }
    }
    for (plane, edges) in planes.iter_mut().zip(edges) {
        plane.directions = main_directions(plane.normal, &edges);
    }
    planes
}

/// Returns one or two directions in the plane with this normal in which, or across which, most of the edges' length
/// runs.
fn main_directions(normal: DVec3, edges: &[DVec3]) -> Vec<DVec3> {
    const STEPS: usize = 180; // half a degree each
    let (u, v) = normal.any_orthonormal_pair();
    let (mut lengths, quarter) = ([0.0; STEPS], std::f64::consts::FRAC_PI_2);
    for edge in edges {
        let angle = edge.dot(v).atan2(edge.dot(u)).rem_euclid(quarter);
        // Spread over three degrees, so that the halves of a peak at a border of steps stay together.
        let (at, length) = (angle / quarter * STEPS as f64, edge.length());
        for off in -3i32..=3 {
            let step = (at as i32 + off).rem_euclid(STEPS as i32) as usize;
            lengths[step] += length * f64::from(4 - off.abs());
        }
    }
    let mut found: Vec<(usize, f64)> = Vec::new();
    let most = lengths.iter().copied().fold(0.0, f64::max);
    for _ in 0..2 {
        let apart = |step: usize, other: usize| {
            let away = step.abs_diff(other);
            away.min(STEPS - away) > 6
        };
        let free = (0..STEPS).filter(|step| found.iter().all(|(other, _)| apart(*step, *other)));
        let best = free.max_by(|a, b| lengths[*a].total_cmp(&lengths[*b]));
        found.extend(best.filter(|step| lengths[*step] > 0.3 * most).map(|step| (step, lengths[step])));
    }
    if found.is_empty() {
        return vec![u];
    }
    found
        .into_iter()
        .map(|(step, _)| {
            // The exact angle is that of the edges near the peak.
            let about = (step as f64 + 0.5) / STEPS as f64 * quarter;
            let (mut sum, mut weight) = (0.0, 0.0);
            for edge in edges {
                let angle = edge.dot(v).atan2(edge.dot(u));
                let off = (angle - about + 0.5 * quarter).rem_euclid(quarter) - 0.5 * quarter;
                if off.abs() < 0.03 {
                    (sum, weight) = (sum + off * edge.length(), weight + edge.length());
                }
            }
            let angle = about + if weight > 0.0 { sum / weight } else { 0.0 };
            u * angle.cos() + v * angle.sin()
        })
        .collect()
}
