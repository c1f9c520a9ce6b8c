//! A test bench whose photos have stacks, which are sorted by the software rasteriser and are not on disk.

use std::sync::Arc;

use super::bench::TestBench;
use crate::state::session::{BUILT, PhotoStatus};
use quadratura_base::scene::{Photo, Site};
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_layers::{LayerConstraints, Options, SoftwareRasteriser, sort_photo};
use quadratura_stacks::assemble::assemble;

/// Makes a bench with an open project, all photos of which have layers.
pub fn layered() -> TestBench {
    let mut bench = TestBench::new();
    let session = bench.state.session.as_mut().expect("a project is open");
    let site = &session.opened.site;
    let status = |photo| {
        let stack = Some(Arc::new(stack_of(site, photo)));
        PhotoStatus { word: BUILT, stack, problem: None, look: 0 }
    };
    session.photos = site.photos.iter().map(status).collect();
    bench
}

fn stack_of(site: &Site, photo: &Photo) -> Stack {
    let (options, constraints, task) = (Options::default(), LayerConstraints::default(), Task::silent());
    let (camera, pose) = (&photo.camera, &photo.pose);
    let sorted = sort_photo(&site.model, camera, pose, &SoftwareRasteriser, &options, &constraints, &task);
    assemble(&site.model, photo, &sorted.unwrap(), &options, &constraints, "")
}
