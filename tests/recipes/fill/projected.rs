//! Paint on other photos before it is in their files.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use quadratura::task::Task;
use quadratura::testing::document::Stack;
use quadratura::testing::io::paint_store::PaintStore;
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layers::Options;
use quadratura::testing::projection::{LayerTextureId, Texels};
use quadratura::testing::scene::PhotoId;
use quadratura::testing::sites::open::Opened;
use quadratura::testing::stacks::fill::projected::PaintProjection;
use quadratura::testing::stacks::layer_textures::LayerTextureFiles;
use quadratura::testing::stacks::projected_paint::{ProjectedPaint, ProjectedTexel};

use super::bench::{Bench, difference};
use super::propagated::{BEHIND, BLEED, BLUE, laid_over, paint_scrawl, propagating, stack_of, take_back};

fn stacks(bench: &Bench) -> Vec<Option<Arc<Stack>>> {
    (0..3).map(|photo| Some(Arc::new(stack_of(bench, photo)))).collect()
}

fn projected(bench: &Bench, opened: &Opened) -> Vec<ProjectedPaint> {
    let (stacks, task) = (stacks(bench), Task::silent());
    let projection =
        PaintProjection::new(bench.folder.path(), &opened.project, &opened.site, &stacks, &task).unwrap();
    let book = PaintStore::new(bench.folder.path()).read().unwrap();
    projection.project(&book, &[0, 1, 2].map(PhotoId), &task).unwrap()
}

/// The texels of a photo's visible part that are painted, with their colours.
fn painted(bench: &Bench, photo: usize, all: &[ProjectedPaint]) -> BTreeMap<[i32; 2], [u16; 3]> {
    let shown: BTreeSet<[i32; 2]> = bench.pixels_where(photo, |_| true).into_iter().collect();
    let of_photo = all.iter().filter(|paint| paint.photo == PhotoId(photo as u32));
    let texels = of_photo.flat_map(|paint| paint.rect.pixels().zip(&paint.texels));
    let painted = texels.filter_map(|((x, y), texel)| match texel {
        ProjectedTexel::Paint(rgb, _) => Some(([x, y], rgb.map(u16::from))),
        _ => None,
    });
    painted.filter(|(at, _)| shown.contains(at)).collect()
}

#[test]
fn a_stroke_shows_on_the_other_photos_at_once_where_their_files_will_have_it() {
    let bench = Bench::courtyard();
    bench.build(Options::default());
    let mut opened = bench.opened();
    opened.project.fill = propagating(&["*"]);
    bench.fill(&opened.project.fill);
    assert_eq!(projected(&bench, &opened), [], "the files have all paint");
    paint_scrawl(&bench, 0, BLEED, |_| BLUE);
    let at_once = projected(&bench, &opened);
    assert!(painted(&bench, 0, &at_once).is_empty(), "its own photo has it");
    let filled = bench.fill(&opened.project.fill);
    for photo in [1, 2] {
        let laid = laid_over(&bench, filled[photo].stack.as_ref().unwrap());
        let shown = painted(&bench, photo, &at_once);
        assert!(laid.len() > 500);
        assert_eq!(shown.keys().collect::<Vec<_>>(), laid.keys().collect::<Vec<_>>(), "the same texels");
        let off = |(at, (rgb, _)): (&[i32; 2], &([u16; 3], String))| {
            difference(*rgb, shown[at].map(|value| f64::from(value) / 255.0))
        };
        let worst = laid.iter().map(off).fold(0.0, f64::max);
        // The seam is at most a factor of e on linear light; of a clear colour on a clear wall it is far less.
        assert!(worst < 25.0, "the same colours but for the seam: {worst}");
    }
    assert_eq!(projected(&bench, &opened), [], "the files have it now");

    let store = StackStore::new(bench.folder.path());
    let textures = |stacks: &[Option<Arc<Stack>>]| LayerTextureFiles::new(&store, stacks, true);
    take_back(&bench);
    let bare = projected(&bench, &opened);
    assert!(bare.iter().flat_map(|paint| &paint.texels).all(|t| !matches!(t, ProjectedTexel::Paint(..))));
    let visible = |files: &LayerTextureFiles, id: LayerTextureId| {
        let pixels = files.layer_texture(id).unwrap();
        pixels.rgba.chunks_exact(4).filter(|texel| texel[3] == 255).map(<[u8]>::to_vec).collect::<Vec<_>>()
    };
    let old = textures(&stacks(&bench));
    let (live, changed) = old.with_projected(&[0, 1, 2].map(PhotoId), bare);
    assert!(!changed.is_empty());
    let at_once: Vec<_> = changed.iter().map(|id| visible(&live, *id)).collect();
    bench.fill(&opened.project.fill);
    let now = textures(&stacks(&bench));
    for (id, at_once) in changed.into_iter().zip(at_once) {
        assert!(at_once == visible(&now, id), "what the photos show is bare again");
    }
    let (same, none) = now.with_stacks(&store, &stacks(&bench), true).unwrap();
    assert!(none.is_empty() && same.len() == now.len());
}

#[test]
fn without_a_wish_for_it_nothing_that_a_photo_shows_is_painted_over() {
    let bench = Bench::courtyard();
    bench.build(Options::default());
    let opened = bench.opened();
    bench.fill(&opened.project.fill);
    paint_scrawl(&bench, 1, BEHIND, |_| BLUE);
    let at_once = projected(&bench, &opened);
    let stack = stack_of(&bench, 0);
    let texels: BTreeSet<(usize, [i32; 2])> =
        bench.texels(0, &stack).into_iter().map(|texel| (texel.layer, texel.at)).collect();
    let mut hidden = 0;
    for paint in &at_once {
        for ((x, y), texel) in paint.rect.pixels().zip(&paint.texels) {
            if matches!(texel, ProjectedTexel::Paint(..)) {
                assert!(paint.photo != PhotoId(0) || texels.contains(&(paint.layer.index(), [x, y])));
                hidden += 1;
            }
        }
    }
    assert!(hidden > 100, "the wall behind the cube is filled from it: {hidden}");
}
