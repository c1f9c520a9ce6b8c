//! Decisions that are made, rejected and removed, on a site of four panes.

use super::*;
use crate::assemble::assemble;
use crate::layer_names::rename;
use crate::untextured::{FaceTexture, excluded};
use quadratura_base::scene::synthetic::{Modeller, Scene, closed_form};
use quadratura_base::scene::{FaceIndex, PhotoId};
use quadratura_base::task::Task;
use quadratura_layers::{ElementIndex, LayerIndex, Options, SoftwareRasteriser, sort_photo};

/// Makes a pane, one behind it, and an object of two faces beside them.
fn site() -> Site {
    let mut m = Modeller::new();
    m.object("front").screen(3.0, [-0.5, -0.5, 0.5, 0.5]);
    m.object("back").screen(5.0, [-1.0, -0.8, 0.8, 0.8]);
    m.object("pair").screen(4.0, [1.2, -0.5, 1.7, 0.5]).screen(4.0, [1.8, -0.5, 2.2, 0.5]);
    m.object("shed").screen(9.0, [-0.1, -0.1, 0.1, 0.1]);
    let site = Scene { model: m.finish(), ..closed_form::two_quads() }.site();
    let photo = |name: &str| quadratura_base::scene::Photo { name: name.into(), ..site.photos[0].clone() };
    Site { photos: vec![photo("a.jpg"), photo("b.jpg")], ..site.clone() }
}

fn project() -> Project {
    let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
    serde_json::from_str(text).unwrap()
}

/// Returns the stack that a build makes of the first photo.
fn stack(site: &Site, project: &Project) -> Stack {
    let (photo, options) = (&site.photos[0], Options::default());
    let decided = project.decisions.of(&photo.name);
    let (constraints, task) = (decided.constraints(), Task::silent());
    let sort = sort_photo(
        &site.model,
        &photo.camera,
        &photo.pose,
        &SoftwareRasteriser,
        &options,
        &constraints,
        &task,
    );
    let mut stack = assemble(&site.model, photo, &sort.unwrap(), &options, &constraints, "made of");
    rename(&mut stack, &decided.names);
    stack
}

fn faces(object: &str, faces: &[u32]) -> Faces {
    Faces { object: object.into(), faces: faces.iter().copied().map(FaceIndex).collect() }
}

fn whole(names: &[&str]) -> Vec<Faces> {
    names.iter().map(|name| Faces::whole(*name)).collect()
}

/// Applies edits in order, each with the stack as it is then.
fn all(edits: &[LayerEdit]) -> Result<Project> {
    let site = site();
    edits.iter().try_fold(project(), |project, edit| {
        let stack = stack(&site, &project);
        edited(&project, edit, &site, &[Some(&stack), None])
    })
}

fn refused(edits: &[LayerEdit]) -> String {
    all(edits).unwrap_err().to_string()
}

fn merge(of: Vec<Faces>) -> LayerEdit {
    LayerEdit::Merge { photo: "a".into(), of }
}

fn split(groups: Vec<Vec<Faces>>) -> LayerEdit {
    LayerEdit::Split { photo: "a".into(), groups }
}

fn layer_of(stack: &Stack, object: &str, index: u32) -> LayerIndex {
    let elements: Vec<_> = stack.visibility_layers.iter().flatten().collect();
    let holds = |number: &ElementIndex| {
        let element = elements[number.index()];
        element.object == object && element.all_faces().contains(&FaceIndex(index))
    };
    stack.numbered_layers().find(|(_, layer)| layer.elements.iter().any(holds)).unwrap().0
}

#[test]
fn a_merge_that_can_be_is_made_by_the_next_build_and_leaves_nothing_unmet() {
    let site = site();
    let plain = stack(&site, &project());
    assert_ne!(layer_of(&plain, "back", 0), layer_of(&plain, "pair", 0));
    let merged = stack(&site, &all(&[merge(whole(&["pair", "back"]))]).unwrap());
    assert_eq!(layer_of(&merged, "back", 0), layer_of(&merged, "pair", 0));
    assert!(merged.unsatisfied.is_empty(), "{:?}", merged.unsatisfied);
    assert!(merged.image_layers.is_sorted_by_key(|layer| layer.order));
}

#[test]
fn a_merge_of_what_hides_each_other_is_refused_with_who_hides_whom() {
    let message = refused(&[merge(whole(&["back", "front"]))]);
    assert!(message.contains("in a.jpg, front[0] lies in front of a part of back[0] ("), "{message}");
    assert!(message.contains("so one image layer cannot hold"), "{message}");
    let message = refused(&[merge(whole(&["front"]))]);
    assert!(message.contains("one part of one object"), "{message}");
}

#[test]
fn a_merge_of_the_front_and_the_back_of_one_object_links_their_layers() {
    let mut m = Modeller::new();
    m.object("post").screen(4.0, [-0.2, -0.8, 0.2, 0.8]);
    m.object("column").screen(3.0, [-0.5, -0.5, 0.5, 0.5]).screen(5.0, [-1.0, -0.8, 0.8, 0.8]);
    let site = Scene { model: m.finish(), ..closed_form::two_quads() }.site();
    let photo = quadratura_base::scene::Photo { name: "a.jpg".into(), ..site.photos[0].clone() };
    let site = Site { photos: vec![photo], ..site.clone() };
    let apart = stack(&site, &project());
    assert!(apart.linked.is_empty());
    let project = edited(&project(), &merge(whole(&["column"])), &site, &[Some(&apart)]).unwrap();
    let linked = stack(&site, &project);
    let layers = [0, 1].map(|face| linked.layer(layer_of(&linked, "column", face)));
    assert_eq!(layers.map(|layer| layer.name.as_str()), ["column (front)", "column (back)"]);
    assert_eq!(linked.linked, [layers.map(|layer| layer.id.clone()).to_vec()]);
    assert!(layers[0].order < layers[1].order && linked.unsatisfied.is_empty());
    // With another object in the merge it is refused as before.
    let refused = edited(&project, &merge(whole(&["column", "post"])), &site, &[Some(&linked)]);
    assert!(refused.unwrap_err().to_string().contains("lies in front of a part of"));
}

#[test]
fn a_merge_that_parts_of_one_object_prevent_names_the_price_of_tolerating_that() {
    let mut m = Modeller::new();
    m.object("column").screen(3.0, [-0.5, -0.5, 0.5, 0.5]).screen(5.0, [-1.0, -0.8, 0.8, 0.8]);
    m.object("aside").screen(4.0, [1.8, -0.5, 2.2, 0.5]);
    let site = Scene { model: m.finish(), ..closed_form::two_quads() }.site();
    let photo = quadratura_base::scene::Photo { name: "a.jpg".into(), ..site.photos[0].clone() };
    let site = Site { photos: vec![photo], ..site.clone() };
    let stack = stack(&site, &project());
    let px = stack.occlusions.iter().map(|support| support.px).max().unwrap();
    let refused = edited(&project(), &merge(whole(&["column", "aside"])), &site, &[Some(&stack)]);
    let message = refused.unwrap_err().to_string();
    let front = format!("column[0] lies in front of a part of column[1] ({px} pixels)");
    assert!(message.contains(&front), "{message}");
    let price = format!("merge column alone and tolerate that ({px} pixels");
    assert!(message.contains(&price), "{message}");
}

#[test]
fn the_layers_that_can_be_merged_are_those_whose_merge_is_made() {
    let site = site();
    let plain = stack(&site, &project());
    let listed = mergeable(&PhotoDecisions::default(), &plain, &site.model, &Options::default());
    assert_eq!(listed.len(), plain.image_layers.len());
    let (mut possible, mut impossible) = (0, 0);
    for (layer, of) in plain.layer_indices().zip(&listed) {
        assert_eq!((&of.token, of.depth), (&plain.layer(layer).id, plain.layer(layer).order + 1));
        for other in plain.layer_indices().filter(|other| *other != layer) {
            let both = [faces_of_layer(&plain, layer), faces_of_layer(&plain, other)].concat();
            let made = edited(&project(), &merge(both), &site, &[Some(&plain), None]);
            let is_listed = of.with.iter().any(|partner| partner.token == plain.layer(other).id);
            assert_eq!(made.is_ok(), is_listed, "{} and {}", of.name, plain.layer(other).name);
            possible += u32::from(is_listed);
            impossible += u32::from(!is_listed);
            if let Ok(project) = made {
                assert!(stack(&site, &project).unsatisfied.is_empty());
            }
        }
        let more = |partner: &MergePartner| partner.texels as i64 - partner.before as i64;
        assert!(of.with.is_sorted_by_key(more), "the cheapest first");
    }
    assert!(possible > 0 && impossible > 0, "{possible} {impossible}");
}

#[test]
fn what_is_behind_its_own_object_is_left_to_other_photos_where_that_is_asked_for() {
    let mut m = Modeller::new();
    m.object("column").screen(3.0, [-0.5, -0.5, 0.5, 0.5]).screen(5.0, [-1.0, -0.8, 0.8, 0.8]);
    let site = Scene { model: m.finish(), ..closed_form::two_quads() }.site();
    let photo = quadratura_base::scene::Photo { name: "a.jpg".into(), ..site.photos[0].clone() };
    let site = Site { photos: vec![photo], ..site.clone() };
    let apart = stack(&site, &project());
    assert_eq!((apart.image_layers.len(), apart.tolerated.len()), (2, 0));
    let edits =
        [LayerEdit::Tolerate { photo: "a".into(), of: whole(&["column"]) }, merge(whole(&["column"]))];
    let decided =
        edits.iter().try_fold(project(), |project, edit| edited(&project, edit, &site, &[Some(&apart)]));
    let project = decided.unwrap();
    let one = stack(&site, &project);
    assert_eq!((one.image_layers.len(), one.linked.len(), one.unsatisfied.len()), (1, 0, 0));
    let overlap = &one.tolerated[0];
    assert_eq!((overlap.face, overlap.by, one.tolerated.len()), (FaceIndex(1), FaceIndex(0), 1));
    assert!(overlap.px > 100, "{overlap:?}");

    let sources = crate::sources::sources(&site, &[Some(one)], &project.decisions);
    let serves = |face: usize, x: f64, z: f64| {
        let photo = &site.photos[0];
        let point = photo.pose.camera_from_world(glam::DVec3::new(x, 0.0, z));
        let px = photo.camera.image_from_camera(point).unwrap();
        let servers = sources.servers_of(site.model.objects[0].faces[face]);
        servers.iter().any(|server| server.domain.holds(px))
    };
    assert!(serves(0, 0.0, 3.0) && serves(1, -0.95, 5.0));
    assert!(!serves(1, 0.0, 5.0), "the front of the column is there in the photo");
    let text = &self::decided(&project.decisions.of("a.jpg"))[1].text;
    assert_eq!(text, "overlaps within column are left to other photos");
}

#[test]
fn what_is_not_there_is_told_all_at_once_and_what_is_not_seen_with_the_reason() {
    let message = refused(&[merge(vec![Faces::whole("gate"), faces("pair", &[7])])]);
    assert!(message.contains("no object \"gate\"") && message.contains("no face 7"), "{message}");
    let message = refused(&[LayerEdit::Exclude { photo: "a".into(), of: whole(&["shed"]) }]);
    assert!(message.contains("does not texture shed: hidden by"), "{message}");
    let message = refused(&[LayerEdit::Exclude { photo: "c".into(), of: whole(&["front"]) }]);
    assert!(message.contains("there is no photo \"c\""), "{message}");
}

#[test]
fn faces_of_one_object_are_split_into_layers_of_their_own() {
    let site = site();
    let project = all(&[split(vec![vec![faces("pair", &[1])]])]).unwrap();
    let stack = stack(&site, &project);
    let layer = stack.layer(layer_of(&stack, "pair", 1));
    assert_eq!(layer.elements.len(), 1);
    assert_ne!(layer_of(&stack, "pair", 0), layer_of(&stack, "pair", 1));
}

#[test]
fn merges_and_splits_that_contradict_each_other_are_refused() {
    let apart = || split(vec![whole(&["pair"]), whole(&["back"])]);
    let message = refused(&[apart(), merge(whole(&["pair", "back"]))]);
    assert!(
        message.contains("a split keeps back[0] and pair[0-1] in separate image layers; remove that split"),
        "{message}"
    );
    let message = refused(&[merge(whole(&["pair", "back"])), apart()]);
    assert!(message.contains("the merge of back, pair contains both sides"), "{message}");
    let message = refused(&[split(vec![whole(&["pair"]), vec![faces("pair", &[1])]])]);
    assert!(message.contains("in two of its groups"), "{message}");
    // The members of a single group may be merged with each other.
    all(&[split(vec![whole(&["pair", "back"])]), merge(whole(&["pair", "back"]))]).unwrap();
}

#[test]
fn a_layer_has_the_last_name_that_it_was_given_and_its_own_when_that_is_taken_back() {
    let site = site();
    let name = |name: Option<&str>| LayerEdit::Rename {
        photo: "a".into(),
        of: vec![faces("pair", &[0])],
        name: name.map(Into::into),
    };
    let named = all(&[name(Some("left")), name(Some(" right "))]).unwrap();
    assert_eq!(named.decisions.of("a.jpg").names.len(), 1);
    let stack = stack(&site, &named);
    assert_eq!(stack.layer(layer_of(&stack, "pair", 1)).name, "right");
    assert_eq!(all(&[name(Some("left")), name(None)]).unwrap(), project());
    assert!(refused(&[name(Some("  "))]).contains("names[0]"));
}

#[test]
fn of_excluding_and_pinning_the_last_word_holds_face_by_face() {
    let exclude = |photo: &str, of: Vec<Faces>| LayerEdit::Exclude { photo: photo.into(), of };
    let pin = |photo: &str, of: Vec<Faces>| LayerEdit::Pin { photo: photo.into(), of };
    let both = all(&[exclude("a", whole(&["pair"])), pin("a", vec![faces("pair", &[1])])]).unwrap();
    let decided = both.decisions.of("a.jpg");
    assert_eq!((decided.exclude, decided.pin), (vec![faces("pair", &[0])], vec![faces("pair", &[1])]));
    let moved = all(&[pin("a", whole(&["pair"])), pin("b", vec![faces("pair", &[0])])]).unwrap();
    assert_eq!(moved.decisions.of("a.jpg").pin, [faces("pair", &[1])]);
    assert_eq!(moved.decisions.of("b.jpg").pin, [faces("pair", &[0])]);
    let taken = all(&[pin("a", whole(&["pair"])), exclude("a", whole(&["pair"]))]).unwrap();
    assert!(taken.decisions.of("a.jpg").pin.is_empty());
    let site = site();
    let excluded_faces = excluded(&stack(&site, &taken), &taken.decisions.of("a.jpg"));
    assert_eq!(
        excluded_faces.iter().map(|u| (u.face.0, u.in_words())).collect::<Vec<_>>(),
        [(0, "excluded".into()), (1, "excluded".into())]
    );
    assert_eq!(state_of_face(&taken.decisions.of("a.jpg"), "pair", FaceIndex(1)), Some("excluded"));
}

#[test]
fn excluded_and_pinned_faces_are_served_accordingly() {
    let site = site();
    let edits = [
        LayerEdit::Exclude { photo: "a".into(), of: whole(&["front"]) },
        LayerEdit::Pin { photo: "a".into(), of: whole(&["back"]) },
    ];
    let project = all(&edits).unwrap();
    let of_a = stack(&site, &project);
    let stacks = [Some(of_a.clone()), Some(of_a)];
    let sources = crate::sources::sources(&site, &stacks, &project.decisions);
    let servers = |object: usize| {
        let servers = sources.servers_of(site.model.objects[object].faces[0]).iter();
        servers.map(|server| (server.photo.0, server.pinned)).collect::<Vec<_>>()
    };
    assert_eq!(servers(0), [(1, false)], "a is excluded for it");
    assert_eq!(servers(1), [(0, true), (1, false)], "the other serves where a does not");
    assert_eq!(servers(2), [(0, false), (1, false)]);
}

#[test]
fn decisions_are_taken_back_by_number_and_all_together() {
    let options = PhotoOptions { margin: Some(5), ..PhotoOptions::default() };
    let edits = [
        merge(whole(&["pair", "back"])),
        LayerEdit::Exclude { photo: "a".into(), of: whole(&["front"]) },
        LayerEdit::Options { photo: "a".into(), options },
    ];
    let project = all(&edits).unwrap();
    let list = decided(&project.decisions.of("a.jpg"));
    let texts: Vec<&str> = list.iter().map(|one| one.text.as_str()).collect();
    assert_eq!(texts, ["merge of back, pair", "excluded for front", "margin 5"]);
    let edit = |edit: LayerEdit| edited(&project, &edit, &site(), &[]);
    let forget = |number: usize| edit(LayerEdit::Forget { photo: "a".into(), number });
    let left = forget(2).unwrap().decisions.of("a.jpg");
    assert!(left.exclude.is_empty() && left.merge.len() == 1 && left.options == options);
    assert!(forget(4).unwrap_err().to_string().contains("it has 3"));
    assert!(edit(LayerEdit::Reset { photo: Some("a".into()) }).unwrap().decisions.is_default());
    assert!(edit(LayerEdit::Reset { photo: None }).unwrap().decisions.is_default());
    let wide = PhotoOptions { tolerance: Some(2.0), ..options };
    let message = edit(LayerEdit::Options { photo: "a".into(), options: wide }).unwrap_err().to_string();
    assert!(message.contains("a.jpg: options: tolerance is 2"), "{message}");
}

#[test]
fn decisions_about_what_is_gone_are_kept_told_and_can_be_forgotten() {
    let mut project = all(&[merge(whole(&["pair", "back"]))]).unwrap();
    let of = project.decisions.of("a.jpg");
    project.decisions.set("gone.jpg", of);
    let mut site = site();
    let mut model = (*site.model).clone();
    model.objects[2].name = "twins".into();
    site.model = std::sync::Arc::new(model);
    let messages = stale(&project.decisions, &site);
    assert_eq!(messages.len(), 2);
    assert!(
        messages[0].to_string().contains("a.jpg, decision 1") && messages[0].to_string().contains("pair"),
        "{messages:?}"
    );
    assert!(
        messages[1].to_string().contains("gone.jpg")
            && messages[1].to_string().contains("reset decisions about gone.jpg"),
        "{messages:?}"
    );
    let stack = stack(&site, &project);
    assert!(stack.unsatisfied[0].contains("pair is not textured"), "{:?}", stack.unsatisfied);
    let edit = LayerEdit::Reset { photo: Some("gone.jpg".into()) };
    assert_eq!(edited(&project, &edit, &site, &[]).unwrap().decisions.photos.len(), 1);
}

#[test]
fn faces_are_named_as_people_type_them() {
    let (site, project) = (site(), project());
    let stack = stack(&site, &project);
    let named = |typed: &str| faces_named(&site.model, Some(&stack), typed);
    assert_eq!(named("pair").unwrap(), whole(&["pair"]));
    assert_eq!(named("pair[0-1]").unwrap(), [faces("pair", &[0, 1])]);
    assert_eq!(named("pair[1, 0]").unwrap(), [faces("pair", &[0, 1])]);
    assert_eq!(named("Pair[1]").unwrap(), [faces("pair", &[1])], "no other object is called so");
    let layer = layer_of(&stack, "front", 0);
    let of_layer = named(&stack.layer(layer).id).unwrap();
    assert!(of_layer.contains(&faces("front", &[0])), "{of_layer:?}");
    for wrong in ["gate", "pair[", "pair[x]", "pair[2-1]", "gate[0]", "pair[0-4000000000]"] {
        let message = named(wrong).unwrap_err().to_string();
        assert!(
            message.contains("there is no object") || message.contains("is no list of faces"),
            "{message}"
        );
    }
}

#[test]
fn a_face_is_freed_of_what_was_decided_about_its_whole_object() {
    let exclude = LayerEdit::Exclude { photo: "a".into(), of: whole(&["pair"]) };
    let free = |of: Vec<Faces>| LayerEdit::Free { photo: "a".into(), of };
    let decided = all(&[exclude.clone(), free(vec![faces("pair", &[1])])]).unwrap().decisions.of("a.jpg");
    assert_eq!(decided.exclude, [faces("pair", &[0])]);
    let pin = LayerEdit::Pin { photo: "a".into(), of: whole(&["pair"]) };
    assert!(all(&[exclude, pin, free(whole(&["pair"]))]).unwrap().decisions.is_default());
    assert!(refused(&[free(whole(&["gate"]))]).contains("no object \"gate\""));
}

#[test]
fn each_photo_tells_how_it_stands_to_a_face() {
    let (site, plain) = (site(), project());
    let stack = stack(&site, &plain);
    let stacks = [Some(&stack), None];
    let faces_in_photos = |project: &Project, object: &str| {
        let object = site.model.objects.iter().find(|it| it.name == object).unwrap();
        face_in_photos(&site, &stacks, &project.decisions, object.faces[0])
    };
    let front = faces_in_photos(&plain, "front");
    assert!(matches!(front.photos[0].given, FaceTexture::Texture { image_layers: 1, .. }), "{front:?}");
    assert_eq!((&front.photos[1].given, front.pinned_to), (&FaceTexture::NotBuilt, None));
    let FaceTexture::Nothing(why) = &faces_in_photos(&plain, "shed").photos[0].given else {
        panic!("no photo sees it")
    };
    assert_eq!((why.reason, why.by.is_some()), (quadratura_document::stack::UntexturedReason::Hidden, true));

    let pin = LayerEdit::Pin { photo: "b".into(), of: whole(&["front"]) };
    let exclude = LayerEdit::Exclude { photo: "a".into(), of: whole(&["front"]) };
    let decided = all(&[exclude, pin]).unwrap();
    let front = faces_in_photos(&decided, "front");
    let FaceTexture::Nothing(why) = &front.photos[0].given else { panic!("it is excluded") };
    assert_eq!(why.reason, quadratura_document::stack::UntexturedReason::Excluded);
    assert_eq!(front.photos[0].decided, Some("excluded"));
    assert_eq!((front.photos[1].decided, front.pinned_to), (Some("pinned to this photo"), Some(PhotoId(1))));

    let counted = |project: &Project, object, faces| {
        photos_of_faces(&[(&stack, project.decisions.of("a.jpg"))], object, faces)
    };
    assert_eq!(counted(&plain, "pair", 2), [1, 1]);
    assert_eq!([counted(&plain, "shed", 1), counted(&decided, "front", 1)], [[0], [0]]);
}

#[test]
fn what_a_merge_would_keep_empty_is_told_in_texels() {
    let site = site();
    let stack = stack(&site, &project());
    let (options, absent) = (Options::default(), LayerIndex::new(stack.image_layers.len()));
    let (a, b) = (layer_of(&stack, "front", 0), layer_of(&stack, "pair", 0));
    let cost = MergeCost::new(&stack, &[a, b], &options).unwrap();
    let area = |layer: LayerIndex| stack.layer(layer).rect.area();
    assert_eq!((cost.layers, cost.before), (2, area(a) + area(b)));
    let holds = |layer: LayerIndex| {
        let rect = stack.layer(layer).needed_rect;
        cost.size[0] >= rect.w && cost.size[1] >= rect.h
    };
    assert!(holds(a) && holds(b) && cost.size.iter().all(|side| side.is_power_of_two()), "{cost:?}");
    assert_eq!(cost.texels, u64::from(cost.size[0]) * u64::from(cost.size[1]));
    assert_eq!(MergeCost::new(&stack, &[a], &options), None);
    assert!(MergeCost::new(&stack, &[a, absent], &options).is_none(), "there is no such layer");
    let small = Options { largest_side: 64, ..options };
    assert!(MergeCost::new(&stack, &[a, b], &small).unwrap().is_too_large() && !cost.is_too_large());

    let twice = MergeCost { texels: 2 * cost.before, ..cost };
    let more = MergeCost { texels: 2 * cost.before + cost.photo, ..cost };
    let little = MergeCost { texels: 40, before: 10, ..cost };
    assert_eq!([twice, more, little].map(|cost| cost.is_high()), [false, true, false]);
}

#[test]
fn every_edit_has_a_name_for_the_history() {
    assert_eq!(merge(whole(&["pair", "back"])).name(), "merge of pair, back");
    assert_eq!(merge(whole(&["a", "b", "c", "d"])).name(), "merge of a, b and 2 more");
    assert_eq!(split(vec![whole(&["pair"])]).name(), "split of pair");
    let edit = LayerEdit::Forget { photo: "a".into(), number: 2 };
    assert_eq!(edit.name(), "remove decision 2 of a");
}

#[test]
fn layers_of_one_name_are_numbered_from_the_front_and_a_given_name_stays_as_it_was_given() {
    let (site, project) = (site(), project());
    let mut stack = stack(&site, &project);
    assert_eq!(stack.image_layers.len(), 3);
    for (layer, name) in stack.image_layers.iter_mut().zip(["wall", "wall (2)", "wall"]) {
        (layer.name, layer.own_name) = (name.into(), None);
    }
    let named = |stack: &Stack| stack.image_layers.iter().map(|layer| layer.name.clone()).collect::<Vec<_>>();
    assert!(rename(&mut stack, &[]).changed);
    assert_eq!(named(&stack), ["wall", "wall (2)", "wall (3)"]);
    assert!(!rename(&mut stack, &[]).changed, "once is enough");
    let elements: Vec<_> = stack.visibility_layers.iter().flatten().collect();
    let held = stack.image_layers[2].elements.iter().map(|element| elements[element.index()]);
    let of =
        held.map(|element| Faces { object: element.object.clone(), faces: element.all_faces() }).collect();
    rename(&mut stack, &[LayerNaming { name: "wall".into(), of }]);
    assert_eq!(named(&stack), ["wall", "wall (2)", "wall"]);
    assert_eq!(stack.image_layers[2].own_name.as_deref(), Some("wall (3)"));
}
