//! Tests of the renderer, with a builder that makes images of one colour when it is let.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use super::*;
use crate::live::builder::Workbench;
use quadratura_base::error::Error;
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::synthetic::closed_form::stairs;
use quadratura_base::task::Event;
use quadratura_ldi::device::{DeviceWarper, UploadedLdi, WarpDevice};
use quadratura_ldi::{DepthPixel, Ldi, LdiKind, LdiReport, ResolutionLevel, Splat, warp};
use quadratura_projection::Gains;
use quadratura_projection::exposure::ViewExposure;
use quadratura_sites::open::Opened;

/// The side of the pictures in pixels.
const SIDE: u32 = 8;

/// Returns an image of one depth, whose colour says of which photo it is.
fn ldi(photo: PhotoId, camera: Pinhole, pose: Pose) -> Ldi {
    let pixel = |x: u32| {
        let colour = [40 * (photo.0 as u8 + 1), 0, 0, 255];
        (x as u16, DepthPixel { inverse_depth: 0.5, colour, surface: 0, splat: Splat(0) })
    };
    let rows = (0..camera.height).map(|_| (0..camera.width).map(pixel).collect());
    Ldi {
        kind: LdiKind::Photos,
        inputs: String::new(),
        camera,
        pose,
        photo_rect: None,
        gain: [0.0; 3],
        surfaces: Vec::new(),
        sources: Vec::new(),
        levels: vec![ResolutionLevel::of_rows(camera, rows)],
        report: LdiReport { depth_complexity: 1.0, layers: 1, ..LdiReport::default() },
    }
}

/// A view whose builder makes an image when it is let.
struct Bench {
    view: LiveView,
    shot: Shot,
    go: Sender<()>,
    begun: Receiver<Vec<u32>>,
    now: Instant,
}

fn bench() -> Bench {
    bench_with(WarpOn::Processor, ldi)
}

/// Draws on a device or the processor what `image` makes of the reference photo of a request, and its camera.
fn bench_with(on: WarpOn, image: impl Fn(PhotoId, Pinhole, Pose) -> Ldi + Send + 'static) -> Bench {
    let scene = stairs();
    let mut site = scene.site();
    let photo = site.photos[0].clone();
    let camera = Pinhole { width: SIDE, height: SIDE, fx: 8.0, fy: 8.0, cx: 4.0, cy: 4.0 };
    site.photos = (0..4).map(|_| quadratura_base::scene::Photo { camera, ..photo.clone() }).collect();
    let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
    let opened = Opened {
        project: serde_json::from_str(text).unwrap(),
        site,
        whole: scene.model.clone(),
        points: Arc::default(),
        reprojection: None,
        problems: Arc::default(),
    };
    let inputs =
        LiveInputs { folder: "none".into(), opened: Arc::new(opened), gains: Gains::none(4), relief: None };
    let ((go, may), (begins, begun)) = (channel(), channel());
    let pose = photo.pose;
    let work = move |bench: &Workbench<ImageRequest, BuiltImage>| {
        while let Some((request, task)) = bench.next() {
            let _ = begins.send(request.photos.iter().map(|photo| photo.0).collect());
            if may.recv().is_err() {
                return;
            }
            let ldi = Arc::new(image(request.photos[0], camera, pose));
            bench.finish(&task, Ok(BuiltImage { ldi, photos: request.photos, stage: RequestStage::Whole }));
        }
    };
    let builder = Builder::start(|| (), || (), work).unwrap();
    let (warper, images) = (Warper::new(on), Images::default());
    let view = LiveView { inputs: Arc::new(inputs), builder, warper, images };
    Bench { view, shot: Shot::new(camera, pose), go, begun, now: Instant::now() }
}

impl Bench {
    /// Draws a view with these shares of photos after some milliseconds.
    fn draw(&mut self, shares: [f64; 4], after_ms: u64) -> LivePicture {
        self.draw_with(LiveOptions::default(), shares, after_ms)
    }

    fn draw_with(&mut self, options: LiveOptions, shares: [f64; 4], after_ms: u64) -> LivePicture {
        self.now += Duration::from_millis(after_ms);
        let shares = Shares { of_photo: shares.to_vec(), of_common: 0.0, takes_part: vec![true; 4] };
        let seen = ExposedShot { shot: &self.shot, exposure: &ViewExposure::neutral(4) };
        self.view.drawn(&shares, seen, &options, self.now, &Task::silent()).unwrap()
    }

    /// Lets the builder finish what it makes.
    fn finish(&self) {
        self.go.send(()).unwrap();
        while self.view.builder.is_busy() {
            std::thread::yield_now();
        }
    }
}

/// Returns the red of the middle of a picture.
fn red(drawn: &LivePicture) -> Option<u8> {
    let picture = drawn.picture.as_ref()?;
    Some(picture.pixels()[(SIDE * SIDE / 2 + SIDE / 2) as usize][0])
}

fn numbers(photos: &[PhotoId]) -> Vec<u32> {
    photos.iter().map(|photo| photo.0).collect()
}

#[test]
fn pictures_do_not_wait_for_the_builder_and_say_what_it_builds() {
    let mut bench = bench();
    let first = bench.draw([0.4, 0.3, 0.1, 0.2], 0);
    assert_eq!((red(&first), numbers(&first.status.building)), (None, vec![0, 1, 3]));
    assert_eq!(bench.begun.recv(), Ok(vec![0, 1, 3]));
    // The builder would wait for ever.
    for _ in 0..50 {
        assert!(bench.draw([0.4, 0.3, 0.1, 0.2], 20).picture.is_none());
    }
    bench.finish();
    let drawn = bench.draw([0.4, 0.3, 0.1, 0.2], 0);
    assert_eq!((red(&drawn), drawn.changes), (Some(40), false), "there is nothing to fade from");
    assert_eq!((numbers(&drawn.status.photos), drawn.status.building), (vec![0, 1, 3], Vec::new()));
    assert!(bench.begun.try_recv().is_err(), "the same was requested once");
}

#[test]
fn the_image_of_a_view_is_drawn_until_the_one_of_the_next_view_is_there_and_fades_into_it() {
    let mut bench = bench();
    bench.draw([0.5, 0.0, 0.0, 0.0], 0);
    bench.finish();
    assert_eq!(red(&bench.draw([0.5, 0.0, 0.0, 0.0], 0)), Some(40));
    let moved = bench.draw([0.0, 0.0, 0.5, 0.0], 0);
    assert_eq!((red(&moved), numbers(&moved.status.photos)), (Some(40), vec![0]));
    assert_eq!(numbers(&moved.status.building), [2]);
    bench.finish();
    let pictures = [0, 50, 50, 50, 50, 50].map(|ms| bench.draw([0.0, 0.0, 0.5, 0.0], ms));
    let reds: Vec<u8> = pictures.iter().map(|drawn| red(drawn).unwrap()).collect();
    assert_eq!(reds, [40, 60, 80, 100, 120, 120]);
    let changes = pictures.each_ref().map(|drawn| drawn.changes);
    assert_eq!(changes, [true, true, true, true, false, false]);
}

#[test]
fn an_image_that_stands_in_is_drawn_only_while_no_better_one_is_built() {
    let mut bench = bench();
    let stands_in = LiveOptions { complete: true, ..LiveOptions::default() };
    bench.draw([0.5, 0.0, 0.0, 0.0], 0);
    bench.finish();
    assert_eq!(red(&bench.draw_with(stands_in, [0.5, 0.0, 0.0, 0.0], 0)), Some(40));
    assert_eq!(red(&bench.draw_with(stands_in, [0.0, 0.5, 0.0, 0.0], 0)), None);
    bench.finish();
    let fading = bench.draw_with(stands_in, [0.0, 0.5, 0.0, 0.0], 0);
    assert_eq!((red(&fading), fading.changes), (Some(40), true));
    assert_eq!(red(&bench.draw_with(stands_in, [0.0, 0.5, 0.0, 0.0], 300)), Some(80));
}

#[test]
fn a_finer_image_is_requested_when_the_view_comes_near_and_a_coarser_one_never() {
    let mut bench = bench();
    let requested = |fx: f64| {
        bench.shot.camera.fx = fx;
        bench.draw([0.5, 0.0, 0.0, 0.0], 0);
        let halvings = bench.view.images.request.as_ref().unwrap().halvings;
        bench.finish();
        halvings
    };
    // The photo has 8 pixels per unit of tangent; an image resolves at least what the picture does.
    let found = [1.0, 0.5, 2.0, 8.0, 1.0].map(requested);
    assert_eq!(found, [2, 2, 1, 0, 0]);
}

#[test]
fn what_cannot_be_made_is_said_and_not_tried_again_before_the_project_changes() {
    let mut bench = bench();
    bench.draw([0.5, 0.0, 0.0, 0.0], 0);
    let result = Err(quadratura_base::error::Error::Request("there is no stack".into()));
    bench.view.images.take(Made { result, is_draft: false }, bench.now);
    let drawn = bench.draw([0.5, 0.0, 0.0, 0.0], 0);
    assert!(drawn.status.fault.is_some_and(|fault| fault.contains("there is no stack")));
    let LiveInputs { folder, opened, gains, .. } = &*bench.view.inputs;
    let (folder, opened, gains) = (folder.clone(), opened.clone(), gains.clone());
    bench.view.renew(LiveInputs { folder, opened, gains, relief: None });
    assert_eq!(bench.draw([0.5, 0.0, 0.0, 0.0], 0).status.fault, None);
}

#[test]
fn a_coarse_image_is_drawn_until_there_is_a_better_one_and_never_after_it() {
    let mut bench = bench();
    let camera = bench.shot.camera;
    let pose = bench.shot.pose;
    let mut take = |photo: u32, stage: RequestStage| {
        let photo = PhotoId(photo);
        let built = BuiltImage { ldi: Arc::new(ldi(photo, camera, pose)), photos: vec![photo], stage };
        bench.view.images.take(Made { result: Ok(built), is_draft: stage < RequestStage::Whole }, bench.now);
        // The image before has faded by then.
        let drawn = bench.draw([0.5, 0.0, 0.0, 0.0], 300);
        (red(&drawn), numbers(&drawn.status.photos))
    };
    assert_eq!(take(3, RequestStage::Coarse), (Some(160), vec![3]), "of the photo that lies in the cache");
    assert_eq!(take(0, RequestStage::OnePhoto), (Some(40), vec![0]));
    assert_eq!(take(1, RequestStage::Coarse), (Some(40), vec![0]));
    assert_eq!(take(2, RequestStage::Whole), (Some(120), vec![2]));
    assert_eq!(take(0, RequestStage::OnePhoto), (Some(120), vec![2]));
}

/// Returns the layered depth image of some boxes, and a view from beside it.
/// A device that draws as the processor does, pictures of at most so many pixels across, and counts what is uploaded.
#[derive(Debug, Clone)]
struct StandIn {
    widest: u32,
    uploads: Arc<AtomicUsize>,
}

fn stand_in() -> StandIn {
    StandIn { widest: 100, uploads: Arc::default() }
}

impl WarpDevice for StandIn {
    fn warper(&self) -> Result<Box<dyn DeviceWarper>> {
        Ok(Box::new(self.clone()))
    }
}

impl DeviceWarper for StandIn {
    fn upload(&self, ldi: Arc<Ldi>) -> Result<UploadedLdi> {
        self.uploads.fetch_add(1, Ordering::Relaxed);
        Ok(Box::new(ldi))
    }

    fn picture(
        &mut self,
        image: &UploadedLdi,
        shot: &Shot,
        options: &WarpOptions,
        task: &Task,
    ) -> Result<Picture> {
        if shot.camera.width > self.widest {
            return Err(Error::Request(format!("{} pixels are too many", shot.camera.width)));
        }
        let ldi = image.downcast_ref::<Arc<Ldi>>().expect("it was uploaded here");
        let mut picture = warp(ldi, shot, options, task)?.picture;
        // So it is seen who drew it.
        picture.rgba.as_chunks_mut::<4>().0.iter_mut().for_each(|pixel| pixel[2] = 7);
        Ok(picture)
    }
}

#[test]
fn a_device_draws_an_image_that_is_uploaded_once() {
    let device = stand_in();
    let mut bench = bench_with(WarpOn::Device(Arc::new(device.clone())), ldi);
    bench.draw([0.5, 0.0, 0.0, 0.0], 0);
    bench.finish();
    let drawn = bench.draw([0.5, 0.0, 0.0, 0.0], 0).picture.unwrap();
    assert_eq!(drawn.pixels()[(SIDE / 2 * SIDE + SIDE / 2) as usize], [40, 0, 7, 255]);
    assert_eq!(bench.draw([0.5, 0.0, 0.0, 0.0], 20).picture, Some(drawn), "again");
    assert_eq!(device.uploads.load(Ordering::Relaxed), 1);
    assert!(bench.view.images.newest.as_ref().unwrap().image.is_uploaded());
}

#[test]
fn what_a_device_cannot_draw_is_drawn_by_the_processor_from_then_on_and_said_once() {
    let mut bench = bench_with(WarpOn::Device(Arc::new(stand_in())), ldi);
    bench.draw([0.5, 0.0, 0.0, 0.0], 0);
    bench.finish();
    bench.draw([0.5, 0.0, 0.0, 0.0], 0);
    let notes = Arc::new(std::sync::Mutex::new(Vec::new()));
    let kept = notes.clone();
    let task = Task::new(move |event| {
        if let Event::Note { text, .. } = event {
            kept.lock().unwrap().push(text.to_string());
        }
    });
    let mut draw = |width: u32| {
        let camera = Pinhole { width, ..bench.shot.camera };
        let shot = Shot { camera, ..bench.shot.clone() };
        let images = &mut bench.view.images;
        let drawn = images.picture(
            &mut bench.view.warper,
            ExposedShot { shot: &shot, exposure: &ViewExposure::neutral(4) },
            bench.now,
            &task,
        );
        let picture = drawn.unwrap().unwrap();
        picture.pixels()[(SIDE / 2 * width + SIDE / 2) as usize]
    };
    let (device, processor) = ([40, 0, 7, 255], [40, 0, 0, 255]);
    assert_eq!([SIDE, 101, SIDE, 101].map(&mut draw), [device, processor, processor, processor]);
    let notes = notes.lock().unwrap();
    assert!(matches!(&notes[..], [one] if one.contains("101 pixels are too many")), "{notes:?}");
    assert!(!bench.view.images.newest.as_ref().unwrap().image.is_uploaded());
}
