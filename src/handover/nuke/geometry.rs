//! The surfaces of an image layer as OBJ, already cut: triangles, because programs divide polygons that are not convex each in their own way.

use std::fmt::Write as _;

use glam::DVec3;

use quadratura_base::geometry::polygon::{fit_plane, triangulate};

/// Returns the OBJ file of surfaces, given by their outlines; holes are bridged. Surfaces without area are left out.
pub fn surfaces_obj<'a>(outlines: impl Iterator<Item = &'a [DVec3]>, generator: &str) -> String {
    let mut text = format!("# {generator}\n");
    let mut first = 1;
    for outline in outlines {
        let Some(plane) = fit_plane(outline) else { continue };
        let divided = triangulate(outline, &plane);
        if divided.triangles.is_empty() {
            continue;
        }
        for DVec3 { x, y, z } in outline.iter().chain(&divided.crossings) {
            let [x, y, z] = [x, y, z].map(|value| value + 0.0);
            writeln!(text, "v {x} {y} {z}").expect("memory does not fail");
        }
        for [a, b, c] in divided.triangles {
            let [a, b, c] = [a, b, c].map(|corner| corner as usize + first);
            writeln!(text, "f {a} {b} {c}").expect("memory does not fail");
        }
        first += outline.len() + divided.crossings.len();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_become_triangles_with_their_corners_counted_on() {
        let square =
            |z: f64| [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, z));
        let line = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        let outlines = [&square(0.0)[..], &line[..], &square(-0.25)[..]];
        let text = surfaces_obj(outlines.into_iter(), "a test");
        let rows = |start: &str| text.lines().filter(|line| line.starts_with(start)).count();
        assert_eq!((rows("v "), rows("f ")), (8, 4));
        assert!(text.contains("v 2 1 -0.25"), "{text}");
        let corners = text.lines().filter_map(|line| line.strip_prefix("f "));
        let largest = corners.flat_map(|line| line.split(' ')).map(|at| at.parse::<usize>().unwrap()).max();
        assert_eq!(largest, Some(8));
    }
}
