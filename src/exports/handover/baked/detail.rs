//! Pixels per unit of the photos on charts.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::parts::{Part, Parts};
use quadratura_base::scene::PhotoId;
use quadratura_handover::atlas::chart::Chart;
use quadratura_projection::{Server, Sources};
use quadratura_view::Blend;
use quadratura_view::weights::{angle_at, border, octaves_missing, pixels_per_unit};

/// The places along each side of a chart at which photos are judged.
const PLACES: u32 = 12;

/// Returns, for each chart, the pixels per unit of the photo that serves best, at places spread over the chart; none where no photo
/// serves.
pub(super) fn details(parts: &Parts, sources: &Sources, photos: &[PhotoId]) -> Vec<Vec<f64>> {
    parts.charts.par_iter().map(|chart| detail(chart, parts, sources, photos)).collect()
}

fn detail(chart: &Chart, parts: &Parts, sources: &Sources, photos: &[PhotoId]) -> Vec<f64> {
    let grid = places(chart, parts);
    let middles = || {
        let middle = |part: usize, corners: &[u32; 3]| {
            let ring = &parts.faces[part].ring;
            (part, corners.iter().map(|&corner| ring[corner as usize]).sum::<DVec3>() / 3.0)
        };
        chart
            .faces
            .iter()
            .flat_map(|&part| parts.faces[part].triangles.iter().map(move |t| (part, t)))
            .map(|(part, t)| middle(part, t))
            .collect()
    };
    let places: Vec<(usize, DVec3)> = if grid.is_empty() { middles() } else { grid };
    let of_place = |(part, point): (usize, DVec3)| best(&parts.faces[part], point, sources, photos);
    places.into_iter().filter_map(of_place).collect()
}

/// Returns the places of a grid over a chart that are within its faces, with these.
fn places(chart: &Chart, parts: &Parts) -> Vec<(usize, DVec3)> {
    let share = |at: u32| (f64::from(at) + 0.5) / f64::from(PLACES);
    let at = |at: u32| chart.low + chart.size() * DVec2::new(share(at % PLACES), share(at / PLACES));
    let of_place = |at: DVec2| {
        let is_within = |part: &&usize| {
            let part = &parts.faces[**part];
            let flat = |corner: u32| chart.frame.flat(part.ring[corner as usize]);
            part.triangles.iter().any(|corners| is_inside(at, corners.map(flat)))
        };
        Some((*chart.faces.iter().find(is_within)?, chart.frame.raised(at)))
    };
    (0..PLACES * PLACES).map(at).filter_map(of_place).collect()
}

/// Returns whether a point is within a triangle, of either winding.
fn is_inside(point: DVec2, [a, b, c]: [DVec2; 3]) -> bool {
    let turns = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).perp_dot(point - from));
    turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0)
}

/// Returns the pixels per unit of the photo of least penalty at a point: angles are those to the normal, octaves those to the finest photo.
fn best(part: &Part, point: DVec3, sources: &Sources, photos: &[PhotoId]) -> Option<f64> {
    let seen = |server: &Server| {
        let photo = sources.photo(server.photo);
        let in_photo = photo.pose.camera_from_world(point);
        let px = photo.camera.image_from_camera(in_photo)?;
        let eye = photo.pose.center_in_world();
        let serves =
            part.card_of.map_or(photos.binary_search(&server.photo).is_ok(), |only| only == server.photo)
                && server.back == part.back
                && server.domain.holds(px)
                && border(&photo.camera, px) > 0.0;
        let angle = angle_at(point, point + part.plane.normal, eye);
        serves.then(|| (pixels_per_unit(&photo.camera, &part.plane, eye, in_photo.z), angle))
    };
    let servers: Vec<(f64, f64)> = sources.servers_of(part.face).iter().filter_map(seen).collect();
    let finest = servers.iter().map(|(density, _)| *density).fold(0.0, f64::max);
    let lambda = Blend::default().lambda;
    let penalty = |(density, angle): &(f64, f64)| angle + lambda * octaves_missing(finest, *density);
    let best = servers.iter().min_by(|a, b| penalty(a).total_cmp(&penalty(b)));
    best.map(|(density, _)| *density).filter(|density| *density > 0.0 && density.is_finite())
}
