//! Actions on bookmarks and the flight; a job orders the frames of pictures and videos from the view's painter.

use crate::state::State;
use crate::state::flight::export::{Export, Rendering};
use crate::state::notes::{Note, Weight};
use crate::state::request::FlightRequest;
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use crate::work::painter::Painter;
use quadratura_base::task::Task;
use quadratura_sites::views::RequestedView;
use quadratura_view::{DisplayMode, Quality, Shot, Unseen};
use quadratura_views::render::{
    Appearance, PictureFormat, RenderOptions, RenderReport, VideoOptions, render,
};

/// Applies a request about bookmarks, the flight, pictures and videos.
pub fn apply(state: &mut State, work: &mut Work, request: FlightRequest) {
    match request {
        FlightRequest::FlyToView(view) => state.fly_to_view(view),
        FlightRequest::GoTo(time_s) => state.go_to(time_s),
        FlightRequest::Pause => state.flights.pause(),
        FlightRequest::SelectKeyframe(index) => state.flights.keyframe = Some(index),
        FlightRequest::KeepView => state.keep_view(),
        FlightRequest::AddKeyframe => state.add_keyframe(),
        FlightRequest::RemoveKeyframe => state.remove_keyframe(),
        FlightRequest::Play => state.play(),
        FlightRequest::ChooseStill => state.request_still(),
        FlightRequest::ChooseFilm => state.request_film(),
        FlightRequest::Render(export) => export_views(state, work, &export),
    }
}

/// Starts rendering the picture or video of a dialog.
fn export_views(state: &mut State, work: &mut Work, export: &Export) {
    let Some(views) = state.views_of(export) else { return };
    let Some(session) = &state.session else { return };
    let Some(orders) = work.painter.as_ref().map(Painter::orders) else { return };
    let look = Appearance {
        quality: Quality::Final,
        supersampled: true,
        unseen: Unseen::Continued,
        ..state.space.look.clone()
    };
    let out = export.out();
    let fps = session.opened.project.flight.as_ref().map_or(25.0, |path| path.fps);
    // The background of a video is black where nothing is textured.
    let film = export.what == Rendering::Video;
    let film = film.then(|| VideoOptions { file: out.join(&export.name), fps, background: [0; 3] });
    let format = if film.is_some() { PictureFormat::Png } else { export.format };
    let grey = look.display != DisplayMode::Colour;
    let options = RenderOptions { out, format, film, film_alone: true, grey, ..RenderOptions::default() };
    let name = match export.what {
        Rendering::Picture => "Rendering a picture",
        Rendering::Video => "Rendering a video",
        Rendering::Sequence => "Rendering pictures of the flight",
    };
    work.jobs.start(&mut state.running, JobKind::Render, name, move |task| {
        let mut draw = |view: &RequestedView, task: &Task| {
            let shot = Shot { linear: options.format.is_linear(), ..look.shot(view.camera, view.pose) };
            orders.picture(shot, task)
        };
        let report = render(&views, &mut draw, &options, task)?;
        let notes = notes_of_report(&report);
        Ok(arrival(move |state| notes.into_iter().for_each(|note| state.notify(note))))
    });
}

fn notes_of_report(report: &RenderReport) -> Vec<Note> {
    let mut notes: Vec<Note> = Vec::new();
    for (view, error) in &report.failed {
        notes.push(Note::about(Weight::Problem, view, error.to_string()));
    }
    if let Some(film) = &report.film {
        notes.push(Note::new(Weight::Info, format!("Video rendered: {}", film.display())));
    } else if let [one] = &report.done[..] {
        notes.push(Note::new(Weight::Info, format!("Picture rendered: {}", one.path.display())));
    } else if let Some(first) = report.done.first() {
        let folder = first.path.parent().unwrap_or(&first.path).display();
        notes.push(Note::new(Weight::Info, format!("{} pictures rendered: {folder}", report.done.len())));
    }
    notes
}
