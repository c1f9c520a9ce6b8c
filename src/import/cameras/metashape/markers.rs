//! Markers: points that the user placed in several photos. The files have no positions of them in the chunk, so that these are
//! triangulated here.

use std::collections::BTreeMap;

use glam::DVec2;
use roxmltree::Node;

use super::super::assembly::Assembly;
use super::super::foreign_text::{child, children};
use super::super::triangulate::triangulated;
use quadratura_base::raster::robust::upper_median;

/// The places of one marker: photos by their index, and pixels.
type Places = Vec<(u32, DVec2)>;

/// Returns the markers of a chunk with their places in photos that are used: in the chunk itself, in its frames, and in the frame of an
/// archive.
fn markers(
    chunk: Node<'_, '_>,
    frame: Option<Node<'_, '_>>,
    photos: &BTreeMap<&str, u32>,
) -> BTreeMap<String, Places> {
    let frames = child(chunk, "frames").into_iter().flat_map(|all| children(all, "frame"));
    let all = std::iter::once(chunk).chain(frames).chain(children(chunk, "frame")).chain(frame);
    let mut found: BTreeMap<String, Places> = BTreeMap::new();
    for marker in all.filter_map(|node| child(node, "markers")).flat_map(|all| children(all, "marker")) {
        let Some(id) = marker.attribute("marker_id").or(marker.attribute("id")) else { continue };
        let places = children(marker, "location").filter_map(|location| {
            let number = |name: &str| location.attribute(name)?.parse::<f64>().ok().filter(|n| n.is_finite());
            Some((*photos.get(location.attribute("camera_id")?)?, DVec2::new(number("x")?, number("y")?)))
        });
        found.entry(id.to_owned()).or_default().extend(places);
    }
    found
}

/// Takes the markers as points with observations.
pub(super) fn read(
    chunk: Node<'_, '_>,
    frame: Option<Node<'_, '_>>,
    photos: &BTreeMap<&str, u32>,
    assembly: &mut Assembly<'_>,
) {
    assembly.points_are_triangulated();
    for (number, (id, places)) in markers(chunk, frame, photos).into_iter().enumerate() {
        let seen: Vec<_> = places.iter().map(|(photo, at)| (assembly.taken(*photo), *at)).collect();
        if let Some(position) = triangulated(&seen) {
            assembly.seen_point(format!("marker {id}"), number as u64, position.into(), places);
        }
    }
}

/// Returns the median distance along the axis, in world units, of the markers that each photo shows.
pub(super) fn depths(
    chunk: Node<'_, '_>,
    frame: Option<Node<'_, '_>>,
    photos: &BTreeMap<&str, u32>,
    assembly: &Assembly<'_>,
) -> BTreeMap<u32, f64> {
    let mut depths: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for places in markers(chunk, frame, photos).values() {
        let seen: Vec<_> = places.iter().map(|(photo, at)| (assembly.taken(*photo), *at)).collect();
        let Some(position) = triangulated(&seen) else { continue };
        for (photo, at) in places.iter().zip(&seen) {
            depths.entry(photo.0).or_default().push(at.0.pose.camera_from_world(position).z);
        }
    }
    let median = |(photo, mut depths): (u32, Vec<f64>)| Some((photo, upper_median(&mut depths)?));
    depths.into_iter().filter_map(median).filter(|(_, depth)| *depth > 0.0).collect()
}
