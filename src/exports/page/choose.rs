//! Which of many photos a page has: those that together show most of the site well, as many as its budget allows.

use std::collections::BTreeSet;

use glam::DVec3;
use rayon::prelude::*;

use super::safe::{WELL, seen_from};
use quadratura_base::scene::PhotoId;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_sites::site_parts::SiteParts;
use quadratura_view::weights::{angle_at, border};

/// The photos that may show a point which is seen from a place, by their numbers, each with how well it does, from 0 to 1.
pub type ShownBy = Vec<(usize, f64)>;

/// Returns what visitors see, from where photos were taken and from between each and the nearest other, and which of the photos may show
/// it. Whether something within a face hides a point from a photo is not asked.
pub fn shown(parts: &SiteParts, surface: &ModelSurface, ids: &[PhotoId], up: DVec3) -> Vec<ShownBy> {
    let sources = &parts.skirts.sources;
    let centres: Vec<DVec3> = ids.iter().map(|id| sources.photo(*id).pose.center_in_world()).collect();
    let between = |centre: &DVec3| {
        let others = centres.iter().filter(|other| *other != centre);
        let away = |other: &&DVec3| other.distance_squared(*centre);
        others.min_by(|a, b| away(a).total_cmp(&away(b))).map(|nearest| centre.midpoint(*nearest))
    };
    let places: Vec<DVec3> = centres.iter().copied().chain(centres.iter().filter_map(between)).collect();
    let from = |place: &DVec3| -> Vec<ShownBy> {
        let shown_by = |seen: super::safe::VisiblePoint| {
            let mut best = ShownBy::new();
            for server in seen.servers(parts) {
                let Ok(number) = ids.binary_search(&server.photo) else { continue };
                let projector = sources.photo(server.photo);
                let px = projector.camera.image_from_camera(projector.pose.camera_from_world(seen.point));
                let confidence = px.map_or(0.0, |px| border(&projector.camera, px));
                if confidence > 0.0 {
                    let penalty = angle_at(seen.point, *place, centres[number]) / confidence;
                    best.push((number, (1.0 - penalty / WELL).max(0.0)));
                }
            }
            best
        };
        seen_from(parts, surface, up, *place).into_iter().map(shown_by).collect()
    };
    places.par_iter().flat_map_iter(from).collect()
}

/// Returns so many of `photos` photos that together show most points best, ascending: again and again the one that adds most.
pub fn best(shown: &[ShownBy], photos: usize, most: usize) -> Vec<usize> {
    let mut so_far = vec![0.0f64; shown.len()];
    let mut chosen = BTreeSet::new();
    while chosen.len() < most.min(photos) {
        let mut gains = vec![0.0; photos];
        for (shown_by, so_far) in shown.iter().zip(&so_far) {
            shown_by.iter().for_each(|(photo, well)| gains[*photo] += (well - so_far).max(0.0));
        }
        let free = (0..photos).filter(|photo| !chosen.contains(photo));
        let Some(next) = free.max_by(|a, b| gains[*a].total_cmp(&gains[*b]).then(b.cmp(a))) else { break };
        chosen.insert(next);
        for (shown_by, so_far) in shown.iter().zip(&mut so_far) {
            let own = shown_by.iter().filter(|(photo, _)| *photo == next);
            *so_far = own.map(|(_, well)| *well).fold(*so_far, f64::max);
        }
    }
    chosen.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn photos_that_add_most_come_first_and_equal_ones_in_their_order() {
        // The first two show the same half, the second one better; the third shows a part of the other half.
        let left = || vec![(0, 0.8), (1, 0.9)];
        let shown = vec![left(), left(), left(), vec![(2, 0.5)], Vec::new()];
        assert_eq!(best(&shown, 4, 1), [1]);
        assert_eq!(best(&shown, 4, 2), [1, 2], "what is shown already counts for little");
        assert_eq!(best(&shown, 4, 3), [0, 1, 2], "nothing is gained by either of the last two");
        assert_eq!(best(&shown, 4, 9), [0, 1, 2, 3]);
    }
}
