//! `fill` on small invented sites, from photos on disk to filled stacks on disk.

mod bench;
mod contradicted;
mod kept;
mod overhanging;
mod projected;
mod propagated;
mod seen;
mod updates;

use std::collections::BTreeSet;
use std::fs;

use bench::{Bench, PHOTOS, facade, noise};
use quadratura::task::Task;
use quadratura::testing::document::Decisions;
use quadratura::testing::document::export_record::ExportFormat;
use quadratura::testing::document::stack::origins;
use quadratura::testing::editing::export::{ExportOptions, export, write_provenance};
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layers::Options;
use quadratura::testing::layers::fill::{FillOptions, Invent};
use quadratura::testing::scene::synthetic::{closed_form, random};
use quadratura::testing::stacks::fill::{FillInputs, FillShares, FillState};

#[test]
fn what_one_photo_hides_others_give_and_it_is_as_it_would_have_been_seen() {
    let bench = Bench::courtyard();
    bench.build(Options::default());
    let filled = bench.fill(&FillOptions::default());
    for (photo, filled) in filled.iter().enumerate() {
        let stack = filled.stack.as_ref().unwrap();
        let shares = FillShares::from_stack(stack);
        assert!(shares.hidden > 0.02 && shares.empty == 0.0, "{shares:?}");
        assert!(shares.from_photos > 0.3, "{shares:?}");
        let origins = &stack.fill.as_ref().unwrap().origins;
        assert!(!origins.contains(&filled.photo), "a photo gives nothing to itself");
        assert_eq!(origins[..4], [origins::NONE, origins::PAINTED, origins::EXEMPLAR, origins::DIFFUSED]);
        let given =
            bench.differences(photo, stack, |place, layer| place >= 4 && layer.name.starts_with("wall"));
        assert!(given.len() > 200);
        // Between pixels of another photo nothing is exact: edges of the facade are off by a part of a pixel.
        let close = given.iter().filter(|d| **d < 12.0).count();
        assert!(close as f64 > 0.85 * given.len() as f64, "{close} of {}", given.len());
    }
}

#[test]
fn what_no_photo_shows_is_invented_and_trusted_less_than_anything_seen() {
    let bench = Bench::alone();
    bench.build(Options::default());
    for invent in [Invent::Exemplar, Invent::Diffusion] {
        let filled = bench.fill(&FillOptions { invent, ..FillOptions::default() });
        let stack = filled[0].stack.as_ref().unwrap();
        let shares = FillShares::from_stack(stack);
        assert_eq!((shares.from_photos, shares.empty), (0.0, 0.0));
        assert_eq!(shares.by_example > 0.5, invent == Invent::Exemplar, "{shares:?}");
        let trusted = bench.texels(0, stack).into_iter().map(|texel| texel.confidence).max();
        assert!(trusted.is_some_and(|most| (1..=26).contains(&most)), "a tenth at most: {trusted:?}");
    }
}

#[test]
fn a_filled_stack_gives_the_photo_back_bit_for_bit() {
    let scenes = closed_form::all().into_iter().chain((0..8).map(|seed| random::boxes(seed, 14)));
    let mut forgiven = 0;
    for scene in scenes {
        for (bits, alpha) in [(8, true), (16, false)] {
            let bench = Bench::of(std::slice::from_ref(&scene), bits, alpha, noise);
            let built = bench.build(Options::default());
            bench.fill(&FillOptions::default());
            let stack = StackStore::new(bench.folder.path()).current(&built[0]).unwrap().unwrap();
            forgiven += stack.forgiven.len();
            assert_eq!(bench.wrong_pixels(0, &stack), 0, "{}, {bits} bits", scene.name);
        }
    }
    assert!(forgiven > 0, "no overlap was forgiven, so nothing was tried");
}

#[test]
fn an_object_that_is_left_out_stays_empty_and_its_neighbours_do_not_spill_into_it() {
    let bench = Bench::courtyard();
    bench.build(Options::default());
    let without = FillOptions { without: vec!["wall".into(), "grou*".into()], ..FillOptions::default() };
    for filled in bench.fill(&without) {
        let stack = filled.stack.unwrap();
        let (cube, others): (Vec<_>, Vec<_>) =
            stack.image_layers.iter().partition(|layer| layer.name.starts_with("cube"));
        let mut of_model = others.iter().filter(|layer| layer.name != "surroundings");
        assert!(of_model.all(|layer| layer.fill.is_none()));
        assert!(cube.iter().all(|layer| layer.texels_visible == layer.texels_used || layer.fill.is_some()));
        assert!(FillShares::from_stack(&stack).empty > 0.0);
    }
    let unknown = FillOptions { without: vec!["no such".into()], ..FillOptions::default() };
    assert!(bench.try_fill(&unknown).unwrap_err().to_string().contains("no such"));
}

#[test]
fn only_what_is_stale_is_filled_again_and_a_new_stack_is_not_filled() {
    let bench = Bench::courtyard();
    bench.build(Options::default());
    let options = FillOptions::default();
    assert!(bench.fill(&options).iter().all(|filled| !filled.up_to_date));
    assert!(bench.fill(&options).iter().all(|filled| filled.up_to_date));
    let built = bench.build(Options::default());
    let store = StackStore::new(bench.folder.path());
    let stacks = || built.iter().map(|photo| store.current(photo).unwrap()).collect::<Vec<_>>();
    assert!(stacks().iter().flatten().all(|stack| stack.fill.is_some()), "an up to date build keeps it");
    let state = |options: &FillOptions| {
        let opened = bench.opened();
        let inputs =
            FillInputs::new(bench.folder.path(), &opened.project, &opened.site, &stacks(), options).unwrap();
        FillState::new(stacks()[0].as_ref().unwrap(), &inputs)
    };
    assert_eq!(state(&options), FillState::Current);
    assert_eq!(state(&FillOptions { invent: Invent::Diffusion, ..options.clone() }), FillState::Stale);
    // One changed file is enough, even if it says the same.
    let layer = stacks()[0].clone().unwrap().image_layers.into_iter().find_map(|layer| layer.fill).unwrap();
    let file = store.folder(&built[0]).join(layer.filled_file);
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, b"changed").unwrap();
    let again = bench.fill(&options);
    assert_eq!(again.iter().map(|filled| filled.up_to_date).collect::<Vec<_>>(), [false, true, true]);
    assert_eq!(fs::read(&file).unwrap(), bytes);
    assert_eq!(again[0].kept.len(), 1, "what somebody changed is kept");
    let other = Options { margin: 5, ..Options::default() };
    bench.build(other);
    assert_eq!(state(&options), FillState::Missing);
}

#[test]
fn the_same_site_is_filled_with_the_same_bytes_by_any_number_of_threads() {
    let filled = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let bench = Bench::courtyard();
        bench.build(Options::default());
        pool.install(|| bench.fill(&FillOptions::default()));
        bench.files()
    });
    assert!(filled[0].keys().filter(|file| file.ends_with(".filled.png")).count() >= PHOTOS);
    assert!(filled[0] == filled[1]);
}

#[test]
fn one_photo_alone_is_filled_as_it_is_among_all() {
    let all = Bench::courtyard();
    all.build(Options::default());
    let texels =
        all.fill(&FillOptions::default())[1].stack.as_ref().map(|stack| all.texels(1, stack)).unwrap();
    let alone = Bench::courtyard();
    let names = alone.build(Options::default());
    let filled = alone.fill_photos(&FillOptions::default(), &names[1..2]).unwrap();
    assert_eq!(filled.len(), 1);
    assert!(alone.texels(1, filled[0].stack.as_ref().unwrap()) == texels);
}

#[test]
fn an_export_gives_the_filling_away_in_the_layers_and_tells_where_it_comes_from() {
    let bench = Bench::courtyard();
    bench.build(Options::default());
    let (out, opened, task) = (tempfile::tempdir().unwrap(), bench.opened(), Task::silent());
    let photos: Vec<_> = opened.site.photos.iter().take(1).collect();
    let options = ExportOptions { format: ExportFormat::Folder, ..ExportOptions::default() };
    let hashes = |folder: &str| {
        let out = out.path().join(folder);
        let exported = export(bench.folder.path(), &photos, &out, &options, &task).unwrap();
        let record = bench.folder.path().join(format!("exports/{}.json", exported.done[0].key));
        let record: serde_json::Value = serde_json::from_slice(&fs::read(record).unwrap()).unwrap();
        let layers = record["layers"].as_array().unwrap().clone();
        (exported, layers.iter().map(|layer| layer["pixels"].to_string()).collect::<BTreeSet<_>>())
    };
    let (_, empty) = hashes("empty");
    let filled = bench.fill(&FillOptions::default());
    let (exported, full) = hashes("full");
    assert_ne!(empty, full, "the record knows what was given away");
    let stack = filled[0].stack.as_ref().unwrap();
    let layer = stack.image_layers.iter().find(|layer| layer.fill.is_some()).unwrap();
    let file = fs::read_dir(&exported.done[0].path).unwrap().map(|entry| entry.unwrap().path());
    let file = file.into_iter().find(|path| path.to_string_lossy().contains(&layer.id)).unwrap();
    let opaque = bench::decode(&file).2.chunks_exact(4).filter(|texel| texel[3] > 0).count();
    let texels_filled = layer.fill.as_ref().unwrap().texels_filled;
    assert_eq!(opaque as u64, layer.texels_visible + texels_filled);
    write_provenance(bench.folder.path(), &photos, &Decisions::default(), out.path(), &task).unwrap();
    let legend = out.path().join(format!("{}.provenance/legend.json", photos[0].name));
    let legend: serde_json::Value = serde_json::from_slice(&fs::read(legend).unwrap()).unwrap();
    assert_eq!(legend["colours"][0]["origin"], photos[0].name.as_str());
    let with_fill = stack.image_layers.iter().filter(|layer| layer.fill.is_some()).count();
    assert_eq!(legend["layers"].as_array().unwrap().len(), with_fill);
}

#[test]
fn the_facade_of_these_tests_is_no_plain_wall() {
    let colours: BTreeSet<[u16; 3]> = (0..400)
        .map(|i| {
            facade(glam::DVec3::new(f64::from(i % 20) * 0.31, f64::from(i / 20) * 0.27, 0.0))
                .map(|v| (v * 9.0) as u16)
        })
        .collect();
    assert!(colours.len() >= 3);
}
