//! Segments: what is joined, that nothing gapes, and that textures and depths come back.

use glam::{DVec2, DVec3};

use super::atlas::packed;
use super::cells::{CellLimits, patches};
use super::join::label;
use super::{SegmentOptions, Segments, TexturedPart, Vertex, segments};
use crate::levels::pyramid;
use crate::tests::tower;
use crate::{DepthPixel, Ldi, LdiKind, LdiReport, LdiSurface, ResolutionLevel, Splat};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::synthetic::Rng;
use quadratura_base::task::Task;

fn pixel(inverse_depth: f32, surface: u16) -> DepthPixel {
    DepthPixel { inverse_depth, colour: [200, 100, 50, 255], surface, splat: Splat(0) }
}

/// Returns an image whose layered depth pixels are what a function says of column and row.
fn image(size: [u32; 2], surfaces: Vec<LdiSurface>, of: impl Fn(u32, u32) -> Vec<DepthPixel>) -> Ldi {
    let [width, height] = size;
    let half = [f64::from(width) / 2.0, f64::from(height) / 2.0];
    let camera = Pinhole { width, height, fx: 200.0, fy: 200.0, cx: half[0], cy: half[1] };
    let row = |y| {
        (0..width).flat_map(|x| of(x, y).into_iter().map(move |pixel| (x as u16, pixel))).collect::<Vec<_>>()
    };
    let level = ResolutionLevel::of_rows(camera, (0..height).map(row));
    Ldi {
        kind: LdiKind::Depth,
        inputs: String::new(),
        camera,
        pose: Pose { rotation: glam::DMat3::IDENTITY, translation: DVec3::ZERO },
        photo_rect: None,
        gain: [0.0; 3],
        levels: pyramid(level, &surfaces),
        surfaces,
        sources: Vec::new(),
        report: LdiReport { quartiles: [1.0, 2.0, 3.0], ..LdiReport::default() },
    }
}

fn surface(nu: [f64; 3]) -> LdiSurface {
    LdiSurface { nu: DVec3::from_array(nu), object: "wall".to_owned(), face: None }
}

fn labels_of(ldi: &Ldi) -> (Vec<u32>, u32) {
    let labels = label(&ldi.levels[0], &ldi.surfaces, 0.01, &Task::silent()).unwrap();
    (labels.segments, labels.count)
}

fn made(ldi: &Ldi, options: &SegmentOptions) -> Segments {
    segments(ldi, options, &Task::silent()).unwrap()
}

/// Returns the inverse depth of triangles at a position of the frame, and how many of them hold it.
fn depths_at(parts: &[TexturedPart], position: DVec2) -> Vec<f64> {
    let mut found = Vec::new();
    for part in parts {
        for triangle in &part.triangles {
            let corners = triangle.map(|corner| part.vertices[usize::from(corner)]);
            let at = corners.map(|Vertex { x, y, .. }| DVec2::new(x.into(), y.into()));
            let area = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
            let whole = area(at[0], at[1], at[2]);
            let shares = [
                area(position, at[1], at[2]) / whole,
                area(at[0], position, at[2]) / whole,
                area(at[0], at[1], position) / whole,
            ];
            if shares.iter().all(|share| *share >= 0.0) {
                found.push((0..3).map(|i| shares[i] * f64::from(corners[i].inverse_depth)).sum());
            }
        }
    }
    found
}

#[test]
fn neighbours_of_one_surface_or_of_nearly_one_depth_are_joined_and_jumps_part() {
    // Columns 0 to 3: a steep surface; 4 and 5: unknown at its last depth; 6 and 7: a jump; 8 and 9: infinitely far.
    let depth = |x: u32| [1.0, 1.2, 1.4, 1.6, 1.6, 1.61, 2.0, 2.0, 0.0, 0.0][x as usize];
    let ldi = image([10, 4], vec![surface([0.2, 0.0, 1.0])], |x, _| vec![pixel(depth(x), u16::from(x < 4))]);
    let (labels, count) = labels_of(&ldi);
    assert_eq!(count, 3);
    assert_eq!(labels[..10], [0, 0, 0, 0, 0, 0, 1, 1, 2, 2]);
}

#[test]
fn an_unknown_surface_that_falls_off_evenly_is_one_segment() {
    // Each column is 4 % farther: four times epsilon, and no more than the one before was.
    let ldi = image([20, 3], Vec::new(), |x, _| vec![pixel(0.96f32.powi(x as i32), 0)]);
    assert_eq!(labels_of(&ldi).1, 1);
}

#[test]
fn a_segment_holds_one_depth_pixel_of_each_ray() {
    let mut rng = Rng::new(5);
    let mut depths = vec![0.0; 4 * 40 * 30];
    depths.iter_mut().for_each(|depth| *depth = rng.between(1.0, 1.06) as f32);
    let ldi = image([40, 30], Vec::new(), |x, y| {
        let first = 4 * (y * 40 + x) as usize;
        let mut ray = depths[first..first + 4].to_vec();
        ray.sort_by(|a, b| b.total_cmp(a));
        ray.into_iter().map(|depth| pixel(depth, 0)).collect()
    });
    let (labels, _) = labels_of(&ldi);
    let level = &ldi.levels[0];
    for ray in (0..30).flat_map(|y| level.layered_pixels(y)) {
        let mut of_ray = labels[ray].to_vec();
        of_ray.sort_unstable();
        of_ray.dedup();
        assert_eq!(of_ray.len(), 4, "each of the four is of a segment of its own");
    }
}

/// A plane beside a field of bumps, of one surface, so that cells of many sizes meet.
fn bumpy() -> Ldi {
    image([200, 136], vec![surface([0.001, 0.002, 1.0])], |x, y| {
        let plane = 0.001 * (f64::from(x) + 0.5) + 0.002 * (f64::from(y) + 0.5) + 1.0;
        // They rise from the plane without a step.
        let height = |at: u32, from: f64| ((f64::from(at) - from) / 20.0).clamp(0.0, 1.0);
        let bump = 0.03
            * height(x, 90.0)
            * height(y, 40.0)
            * (f64::from(x) / 7.0).sin()
            * (f64::from(y) / 5.0).cos();
        vec![pixel((plane + bump) as f32, 1)]
    })
}

#[test]
fn cells_of_different_size_meet_without_gap_or_overlap() {
    let ldi = bumpy();
    let limits = CellLimits { error: 1e-3, undivided: None };
    let labels = label(&ldi.levels[0], &ldi.surfaces, 0.01, &Task::silent()).unwrap();
    let mut sides = std::collections::BTreeSet::new();
    for patch in patches(&ldi, &labels, &Task::silent()).unwrap() {
        patch.leaves(&limits, &|_| false, &mut |_, node| {
            sides.insert(node.side);
        });
    }
    assert!(sides.len() >= 4 && sides.contains(&64), "the scene must mix sizes: {sides:?}");
    // The limit in inverse depth is this parallax at half of a reach of 1/8 and a focal length of 200 px.
    let made = made(&ldi, &SegmentOptions { parallax: 1e-3 * 200.0 / 16.0, ..SegmentOptions::default() });
    // Every edge is in two triangles, in opposite directions, but for those of the outline; corners are the same to the bit.
    let mut edges = std::collections::BTreeMap::new();
    for part in &made.parts {
        for triangle in &part.triangles {
            let corners = triangle.map(|corner| part.vertices[usize::from(corner)]);
            let key = |v: Vertex| (v.x, v.y, v.inverse_depth.to_bits());
            for i in 0..3 {
                *edges.entry((key(corners[i]), key(corners[(i + 1) % 3]))).or_insert(0) += 1;
            }
        }
    }
    let mut single = 0;
    for ((from, to), count) in &edges {
        assert_eq!(*count, 1, "an edge is in two triangles of one direction: {from:?} {to:?}");
        if !edges.contains_key(&(*to, *from)) {
            let outside = |v: &(i32, i32, u32)| v.0 < 0 || v.1 < 0 || v.0 > 200 || v.1 > 136;
            assert!(outside(from) && outside(to), "an edge without its other side: {from:?} {to:?}");
            single += 1;
        }
    }
    assert!(single > 8, "there is an outline");
    // The whole frame is covered once, and the error is what was allowed, or twice that where corners are means of two cells.
    let mut rng = Rng::new(3);
    for _ in 0..400 {
        let (x, y) = (rng.between(0.0, 200.0) as u32, rng.between(0.0, 136.0) as u32);
        let found = depths_at(&made.parts, DVec2::new(f64::from(x) + 0.497, f64::from(y) + 0.489));
        let level = &ldi.levels[0];
        let expected = f64::from(level.inverse_depths[level.at(x, y).start]);
        assert_eq!(found.len(), 1, "at {x}, {y}");
        assert!((found[0] - expected).abs() < 2.5e-3, "{} for {expected} at {x}, {y}", found[0]);
    }
}

#[test]
fn a_plane_takes_few_large_cells_and_is_exact() {
    let ldi = image([256, 128], vec![surface([0.001, 0.002, 1.0])], |x, y| {
        vec![pixel((0.001 * (f64::from(x) + 0.5) + 0.002 * (f64::from(y) + 0.5) + 1.0) as f32, 1)]
    });
    let made = made(&ldi, &SegmentOptions::default());
    assert_eq!((made.count, made.triangles()), (1, 2 * 4 * 2));
    for vertex in made.parts.iter().flat_map(|part| &part.vertices) {
        let exact = 0.001 * f64::from(vertex.x) + 0.002 * f64::from(vertex.y) + 1.0;
        // Single precision.
        assert!((f64::from(vertex.inverse_depth) - exact).abs() < 1e-6, "{vertex:?}");
    }
}

#[test]
fn what_a_wall_hides_stays_behind_it_also_where_both_meet() {
    let ldi = tower();
    let made = made(&ldi, &SegmentOptions::default());
    let (front, side): (Vec<TexturedPart>, Vec<TexturedPart>) =
        made.parts.into_iter().partition(|part| part.segment == 0);
    let level = &ldi.levels[0];
    let mut compared = 0;
    for (x, y) in (0..160).flat_map(|y| (0..400).map(move |x| (x, y))) {
        let of_ray = level.at(x, y);
        // Also beside the edge, over the pixel by which sides are moved.
        let beyond = of_ray.is_empty() && x > 0 && level.at(x - 1, y).len() == 2;
        if of_ray.len() == 2 || beyond {
            let at = DVec2::new(f64::from(x) + 0.497, f64::from(y) + 0.489);
            let (before, behind) = (depths_at(&front, at), depths_at(&side, at));
            assert!(before.len() == 1 && behind.len() <= 1, "at {x}, {y}: {before:?} {behind:?}");
            // Single precision, in which corners are.
            assert!(
                behind.iter().all(|depth| *depth <= before[0] + 1e-7),
                "at {x}, {y}: {before:?} {behind:?}"
            );
            compared += behind.len();
        }
    }
    assert!(compared > 3000, "{compared}");
}

#[test]
fn rows_of_one_column_are_not_taken_for_a_ray() {
    let plane = |y: u32| (1.0 + 0.003 * (f64::from(y) + 0.5)) as f32;
    let pole = |columns: u32| {
        image([64, 64], vec![surface([0.0, 0.003, 1.0])], move |x, y| {
            if (20..20 + columns).contains(&x) { vec![pixel(plane(y), 1)] } else { Vec::new() }
        })
    };
    let [one, two] = [1, 2].map(|columns| made(&pole(columns), &SegmentOptions::default()).triangles());
    assert!(one <= two, "{one} and {two}");
}

#[test]
fn more_triangles_than_allowed_make_cells_coarser() {
    let ldi = bumpy();
    let fine = made(&ldi, &SegmentOptions { parallax: 0.001, ..SegmentOptions::default() });
    let coarse = made(&ldi, &SegmentOptions { parallax: 0.001, triangles: 500, ..SegmentOptions::default() });
    assert!(
        fine.triangles() > 500 && coarse.triangles() <= 500,
        "{} {}",
        fine.triangles(),
        coarse.triangles()
    );
    assert!(coarse.parallax > fine.parallax);
}

#[test]
fn no_triangle_spans_a_jump_and_every_depth_pixel_has_its_texel() {
    // A square before a wall that goes on behind it.
    let ldi = image([96, 80], vec![surface([0.0, 0.0, 1.0]), surface([0.0, 0.0, 2.0])], |x, y| {
        let wall = DepthPixel { colour: [x as u8, y as u8, 7, 255], ..pixel(1.0, 1) };
        let inside = (30..60).contains(&x) && (20..50).contains(&y);
        let square = DepthPixel { colour: [y as u8, x as u8, 99, 255], ..pixel(2.0, 2) };
        if inside { vec![square, wall] } else { vec![wall] }
    });
    let made = made(&ldi, &SegmentOptions::default());
    assert_eq!(made.count, 2);
    for part in &made.parts {
        let depths: Vec<f32> = part.vertices.iter().map(|vertex| vertex.inverse_depth).collect();
        assert!(depths.iter().all(|depth| (depth - depths[0]).abs() < 1e-6), "{depths:?}");
    }
    let mut covered = 0;
    for part in &made.parts {
        let atlas = &made.atlases[part.atlas];
        for (row, column) in (0..part.size[1]).flat_map(|y| (0..part.size[0]).map(move |x| (y, x))) {
            let at = ((part.at[1] + row) * atlas.width + part.at[0] + column) as usize;
            let (x, y) = (part.origin[0] + column as i32, part.origin[1] + row as i32);
            if atlas.opacity[at] == 255 {
                let colour = [atlas.rgb[3 * at], atlas.rgb[3 * at + 1], atlas.rgb[3 * at + 2]];
                let expected = if colour[2] == 99 { [y as u8, x as u8, 99] } else { [x as u8, y as u8, 7] };
                assert_eq!(colour, expected, "at {x}, {y}");
                covered += usize::from(part.vertices.iter().any(|vertex| vertex.x > x));
            }
        }
    }
    assert!(covered >= 96 * 80 + 900, "{covered}");
    // Colours go on two texels past a rim, without opacity.
    let square = made.parts.iter().find(|part| part.vertices[0].inverse_depth > 1.5).unwrap();
    let atlas = &made.atlases[square.atlas];
    let outside = ((square.at[1] + (21 - square.origin[1]) as u32) * atlas.width
        + square.at[0]
        + (28 - square.origin[0]) as u32) as usize;
    assert_eq!((atlas.opacity[outside], atlas.rgb[3 * outside + 2]), (0, 99));
}

#[test]
fn what_is_infinitely_far_stays_there() {
    let ldi = image([70, 70], Vec::new(), |_, _| vec![pixel(0.0, 0)]);
    let made = made(&ldi, &SegmentOptions::default());
    assert!(made.parts.iter().flat_map(|part| &part.vertices).all(|vertex| vertex.inverse_depth == 0.0));
}

#[test]
fn packed_rectangles_do_not_overlap_and_waste_little() {
    let mut rng = Rng::new(9);
    let mut side = || 8 * rng.between(1.0, 9.0) as u32;
    let sizes: Vec<[u32; 2]> = (0..700).map(|_| [side(), side()]).collect();
    let packed = packed(&sizes);
    assert_eq!(packed.sizes.len(), 1);
    let [width, height] = packed.sizes[0];
    let mut taken = vec![false; (width * height) as usize];
    for ([w, h], (_, [x, y])) in sizes.iter().zip(&packed.places) {
        for at in (*y..y + h).flat_map(|row| (*x..x + w).map(move |column| (row * width + column) as usize)) {
            assert!(!std::mem::replace(&mut taken[at], true));
        }
    }
    let used = taken.iter().filter(|taken| **taken).count();
    assert!(used * 10 > taken.len() * 8, "{used} of {}", taken.len());
}

#[test]
fn segments_are_the_same_whatever_the_number_of_threads() {
    let ldi = bumpy();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| made(&ldi, &SegmentOptions { parallax: 0.01, ..SegmentOptions::default() }))
    };
    assert!(with(1) == with(3));
}
