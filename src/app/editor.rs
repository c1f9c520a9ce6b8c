//! The editor: everything that is shown, and the one place where it changes.

use std::path::PathBuf;

use eframe::egui::{self, CentralPanel, Context, KeyboardShortcut, Panel, Ui};
use eframe::{Frame, Storage};

use super::check::{Checks, Mend, check_ui};
use super::command::{self, Command};
use super::crash::{self, Crash, crash_ui};
use super::flat::Flat;
use super::flight::{Flights, timeline_ui};
use super::frame_times::FrameTimes;
use super::inspect::Inspect;
use super::jobs::Jobs;
use super::keeper::Ending;
use super::layer_work::OptionsEdit;
use super::layout::{Layout, Pane, centre_ui};
use super::leaving::{Leaving, Questions};
use super::lists::Lists;
use super::masking::Masking;
use super::masking::keeping::Work;
use super::notes::{Note, Notes, Remedy, Weight};
use super::opening::{Opening, Wish, opening_ui};
use super::palette::{Palette, palette_ui};
use super::panel;
use super::panel::sized::{Edge, sized_panel};
use super::pictures::Pictures;
use super::quality::Quality;
use super::selection::Selection;
use super::session::Session;
use super::settings::Settings;
use super::space::Space;
use super::trip::Trip;
use super::turns::Turns;
use crate::document::Project;
use crate::document::history::Gesture;
use crate::geometry::PixelRect;
use crate::layers::fill::FillOptions;
use crate::recipe::colour::ColourEdit;
use crate::recipe::decide::LayerEdit;
use crate::recipe::fill::lookouts::View;
use crate::recipe::layer_table::Column;
use crate::scene::FaceId;

/// The key of the settings among what eframe keeps.
const SETTINGS: &str = "settings";

/// The most that what lies below the views takes of the height that is left, each.
const BELOW_MOST: f32 = 0.4;

/// What a panel wants; done when all panels are drawn.
pub enum Ask {
    /// A command from the tables.
    Run(&'static Command),
    /// This is selected from now on.
    Select(Selection),
    /// Adds an image layer of a photo to the selection, or takes it out.
    Toggle(usize, usize),
    /// Selects image layers of a photo, the last one first of all.
    SelectLayers(usize, Vec<usize>),
    /// Sorts the table of layers by a column.
    SortLayers(Column),
    /// Switches an object on or off, by its name.
    Switch(String, bool),
    /// Names an image layer of a photo.
    Rename(usize, usize, String),
    /// Decides something about a photo's layers.
    Decide(Box<LayerEdit>),
    /// Shows where a face is in a photo, and marks a place in it, in photo pixels.
    ShowInPhoto(usize, FaceId, Option<[u32; 2]>),
    /// Takes one decision about a photo back, by its number.
    ForgetDecision(String, usize),
    /// Flies into the camera of a photo.
    FlyTo(usize),
    /// Flies to where a view looks from.
    LookFrom(Box<View>),
    /// Looks what paint would be laid over which photos.
    LookAtPropagation,
    /// Flies to a kept view.
    FlyToView(usize),
    /// Shows the flight at a time, in seconds.
    GoTo(f64),
    /// A step of the history: what is undone, the project after it, and the gesture that it belongs to.
    Edit(String, Box<Project>, Option<Gesture>),
    /// A gesture has ended.
    EndGesture,
    /// Opens a project.
    Open(PathBuf),
    /// Imports what was chosen in the dialog.
    Import,
    /// Exports as it was chosen in the dialog.
    Export,
    /// Decides about the photos' exposures.
    Colour {
        /// One after the other.
        edits: Vec<ColourEdit>,
        /// The gesture has not ended.
        goes_on: bool,
    },
    /// Decides how hidden parts are filled.
    Fill(FillOptions),
    /// Changes masks: what is undone, and what is done.
    Mask(String, Work),
    /// Masks what is suggested, by numbers.
    Accept(Vec<u32>),
    /// Forgets what is suggested, by numbers.
    Dismiss(Vec<u32>),
    /// Masks of objects have this margin from now on, in pixels.
    Margin(u32),
    /// Shows a place of a photo, in its pixels.
    Show(usize, PixelRect),
    /// Decides about options of layers.
    Options {
        /// Of all photos, or of one.
        edit: OptionsEdit,
        /// The gesture has not ended.
        goes_on: bool,
    },
    /// What helps against what a note tells.
    Remedy(Box<Remedy>),
    /// Asks one job to stop.
    Stop(super::jobs::JobId),
    /// Forgets a project that was opened once.
    Forget(PathBuf),
    /// What a dialog around opening, making and leaving projects wants.
    Opening(Wish),
    /// Moves the model to where it should stand, or back.
    Mend(Mend),
}

/// The editor.
pub struct Editor {
    /// The project that is open.
    pub session: Option<Session>,
    /// What runs.
    pub jobs: Jobs,
    /// What was said.
    pub notes: Notes,
    /// Kept from run to run.
    pub settings: Settings,
    /// What is selected.
    pub selection: Selection,
    /// The photo that was selected last: the one that commands on a photo mean.
    pub photo: Option<usize>,
    /// Image layers that are selected beside the one of `selection`: photo and place in its stack.
    pub more_layers: Vec<(usize, usize)>,
    /// The lists of layers and objects.
    pub lists: Lists,
    /// What was found out about the selection.
    pub inspect: Inspect,
    /// The 3D view.
    pub space: Space,
    /// Kept views and the flight.
    pub flights: Flights,
    /// Where the views of the centre are.
    pub layout: Layout,
    /// The photo with its layers, and one image layer.
    pub flat: Flat,
    /// Pictures of photos.
    pub pictures: Pictures,
    /// The command palette.
    pub palette: Palette,
    /// What keys and mouse do is shown.
    pub help_shown: bool,
    /// The settings are shown.
    pub settings_shown: bool,
    /// The options of layers are shown.
    pub layer_options_shown: bool,
    /// Dialogs around opening and making projects.
    pub opening: Opening,
    /// Questions before a project is left, or after it was opened.
    pub questions: Questions,
    /// What frames took.
    pub frame_times: FrameTimes,
    /// Out to image editors, and home.
    pub trip: Trip,
    /// Fillings and colour.
    pub quality: Quality,
    /// Masks of photos.
    pub masking: Masking,
    /// What is known from comparing cameras, photos and model.
    pub checks: Checks,
    /// The program made a mistake, and somebody has to be told.
    pub crash: Option<Crash>,
    /// Who ends the window from outside.
    pub ending: Ending,
    /// To be woken by threads.
    pub context: Context,
}

impl Editor {
    /// With what was kept from the last run; opens `project` if there is one.
    pub fn new(context: &Context, storage: Option<&dyn Storage>, project: Option<PathBuf>) -> Self {
        let mut settings: Settings =
            storage.and_then(|storage| eframe::get_value(storage, SETTINGS)).unwrap_or_default();
        // Where nothing is kept from run to run, hints would come every time.
        settings.hints &= storage.is_some();
        settings.apply_to(context);
        context.add_plugin(Turns::default());
        let mut editor = Self {
            session: None,
            jobs: Jobs::new(context.clone()),
            notes: Notes::default(),
            settings,
            selection: Selection::default(),
            photo: None,
            more_layers: Vec::new(),
            lists: Lists::default(),
            inspect: Inspect::default(),
            space: Space::default(),
            flights: Flights::default(),
            layout: Layout::kept(storage),
            flat: Flat::default(),
            pictures: Pictures::default(),
            palette: Palette::default(),
            help_shown: false,
            settings_shown: false,
            layer_options_shown: false,
            opening: Opening::default(),
            questions: Questions::default(),
            frame_times: FrameTimes::default(),
            trip: Trip::default(),
            quality: Quality::default(),
            masking: Masking::default(),
            checks: Checks::default(),
            crash: None,
            ending: Ending::default(),
            context: context.clone(),
        };
        if let Some(project) = project {
            editor.open_project(project);
        }
        editor
    }

    /// Says something.
    pub fn tell(&mut self, note: Note) {
        // What helps is to be seen, too.
        if note.weight == Weight::Problem || !note.remedies.is_empty() {
            self.settings.notes_shown = true;
        }
        self.notes.add(note);
    }

    /// Changes what is selected.
    pub fn select(&mut self, selection: Selection) {
        self.selection = selection;
        self.more_layers.clear();
        self.photo = selection.photo().or(self.photo);
        self.flat.layer.follow(selection);
    }

    /// Seconds of the window's clock.
    pub fn now_s(&self) -> f64 {
        self.context.input(|input| input.time)
    }

    /// The photo that commands on a photo mean.
    pub fn selected_photo(&self) -> Option<usize> {
        self.photo.filter(|photo| self.session.as_ref().is_some_and(|session| *photo < session.photos.len()))
    }

    /// Its name.
    pub fn selected_photo_name(&self) -> Option<String> {
        let session = self.session.as_ref()?;
        Some(session.opened.site.photos[self.selected_photo()?].name.clone())
    }

    /// Everything where it was at first.
    pub fn reset_layout(&mut self, context: &Context) {
        context.memory_mut(|memory| *memory = egui::Memory::default());
        self.layout = Layout::default();
        self.settings.lay_out_anew();
        self.settings.apply_to(context);
    }

    fn take_in(&mut self, context: &Context) {
        let (notes, arrivals) = self.jobs.receive();
        notes.into_iter().for_each(|note| self.tell(note));
        arrivals.into_iter().for_each(|arrival| arrival(self));
        self.pictures.take_in(context);
        self.watch_opening(context);
        self.take_close_request(context);
        self.follow();
        self.fly_on();
        self.take_home();
        self.check_again();
        self.keep_masks();
    }

    fn grant(&mut self, ask: Ask) {
        match ask {
            Ask::Run(command) => self.run(command),
            Ask::Select(selection) => self.select(selection),
            Ask::Toggle(photo, layer) => self.toggle_layer(photo, layer),
            Ask::SelectLayers(photo, layers) => self.select_layers(photo, layers),
            Ask::SortLayers(column) => self.settings.layer_list.sort_by(column),
            Ask::Switch(object, on) => self.switch_object(&object, on),
            Ask::Rename(photo, layer, name) => self.rename_layer(photo, layer, &name),
            Ask::ForgetDecision(photo, number) => self.forget_decision(photo, number),
            Ask::Decide(edit) => self.decide(&edit),
            Ask::ShowInPhoto(photo, face, at) => self.show_in_photo(photo, face, at),
            Ask::FlyTo(photo) => {
                self.layout.show(Pane::Space);
                self.fly_to_photo(photo);
            }
            Ask::LookFrom(view) => self.look_from(&view),
            Ask::LookAtPropagation => self.look_at_propagation(),
            Ask::FlyToView(place) => {
                self.layout.show(Pane::Space);
                self.fly_to_view(place);
            }
            Ask::GoTo(time_s) => self.go_to(time_s),
            Ask::Edit(name, project, gesture) => self.edit(name, *project, gesture),
            Ask::EndGesture => self.end_gesture(),
            Ask::Open(project) => self.leave(Leaving::Open(project)),
            Ask::Import => self.import_chosen(),
            Ask::Export => self.export_chosen(),
            Ask::Colour { edits, goes_on } => self.edit_colour(&edits, goes_on),
            Ask::Fill(options) => self.edit_fill(options),
            Ask::Mask(name, work) => self.mask(name, work),
            Ask::Accept(numbers) => self.accept_suggestions(&numbers),
            Ask::Dismiss(numbers) => self.dismiss_suggestions(&numbers),
            Ask::Margin(margin_px) => self.masking.margin_px = margin_px,
            Ask::Show(photo, rect) => self.show_rect(photo, rect),
            Ask::Options { edit, goes_on } => self.edit_options(&edit, goes_on),
            Ask::Remedy(remedy) => self.remedy(*remedy),
            Ask::Stop(job) => self.jobs.stop(job),
            Ask::Opening(wish) => self.grant_opening(wish),
            Ask::Mend(mend) => self.mend(mend),
            Ask::Forget(project) => self.settings.recent.retain(|other| *other != project),
        }
    }

    /// Runs a command if it is ready, else says why not.
    pub fn run(&mut self, command: &'static Command) {
        match (command.ready)(self) {
            Ok(()) => {
                let context = self.context.clone();
                (command.run)(self, &context);
            }
            Err(why_not) => self.notes.add(Note::new(Weight::Info, format!("{}: {why_not}", command.name))),
        }
    }
}

impl eframe::App for Editor {
    fn logic(&mut self, context: &Context, frame: &mut Frame) {
        // What it says is of the frame before.
        self.frame_times.begin(frame.info().cpu_usage, !self.jobs.is_idle());
        let work = || {
            self.take_in(context);
            // Each in its turn: one may open a dialog, which the next ones belong to.
            while self.crash.is_none() {
                let heard = |command: &Command, keys: &KeyboardShortcut| self.hears(command, keys);
                let Some(command) = command::next_pressed(context, self.space.id, heard) else { break };
                self.run(command);
            }
        };
        if let Err(crash) = crash::guarded(work) {
            self.crashed(crash);
        }
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut Frame) {
        if self.crash.is_some() {
            crash_ui(self, ui);
        } else if let Err(crash) = crash::guarded(|| self.draw(ui)) {
            self.crashed(crash);
            ui.ctx().request_repaint();
        }
        self.frame_times.end(!self.jobs.is_idle());
    }

    fn save(&mut self, storage: &mut dyn Storage) {
        eframe::set_value(storage, SETTINGS, &self.settings);
        self.layout.keep(storage);
    }

    fn on_exit(&mut self) {
        self.end();
    }
}

impl Editor {
    fn draw(&mut self, ui: &mut Ui) {
        let mut asks = Vec::new();
        Panel::top("menu").show(ui, |ui| panel::menu::menu_ui(self, ui, &mut asks));
        Panel::bottom("status").show(ui, |ui| panel::status::status_ui(self, ui, &mut asks));
        let mut sizes = self.settings.sizes;
        if self.settings.notes_shown {
            let (place, most) = ((Edge::Bottom, "notes"), BELOW_MOST * ui.available_height());
            sized_panel(ui, place, &mut sizes.notes, most, |ui| panel::notes::notes_ui(self, ui, &mut asks));
        }
        if self.session.is_some() && self.flights.shown {
            let (place, most) = ((Edge::Bottom, "flight"), BELOW_MOST * ui.available_height());
            sized_panel(ui, place, &mut sizes.flight, most, |ui| timeline_ui(self, ui, &mut asks));
        }
        if self.session.is_some() {
            panel::sides_ui(self, &mut sizes, ui, &mut asks);
        }
        self.settings.sizes = sizes;
        if self.session.is_some() {
            CentralPanel::no_frame().show(ui, |ui| centre_ui(self, ui, &mut asks));
        } else {
            CentralPanel::default_margins().show(ui, |ui| panel::welcome::welcome_ui(self, ui, &mut asks));
        }
        let context = ui.ctx().clone();
        self.questions_ui(&context);
        self.merging_ui(&context);
        self.export_ui(&context);
        panel::help::help_ui(self, &context);
        panel::settings::settings_ui(self, &context, &mut asks);
        panel::layer_options::layer_options_ui(self, &context, &mut asks);
        check_ui(self, &context, &mut asks);
        opening_ui(self, &context, &mut asks);
        panel::dialogs::dialogs_ui(self, &context, &mut asks);
        asks.extend(palette_ui(self, &context).map(Ask::Run));
        asks.into_iter().for_each(|ask| self.grant(ask));
    }
}
