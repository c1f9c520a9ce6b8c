//! The editor: applies results, handles keys, draws, and applies requests. It owns textures and the layout of the centre;
//! everything independent of the window is in `State`, threads are in `Work`.

use std::ops::{Deref, DerefMut};
use std::path::PathBuf;

use eframe::egui::{self, CentralPanel, Context, Key, KeyboardShortcut, Panel, Ui, ViewportCommand};
use eframe::{Frame, Storage};

use super::APP_ID;
use super::crash::crash_ui;
use super::frame_times::FrameTimes;
use super::input_splitter::InputSplitter;
use super::look::apply_look;
use super::pane_layout::{PaneLayout, centre_ui};
use super::textures::Textures;
use crate::action::end::end;
use crate::action::known::{follow_known, remember};
use crate::action::opening::{take_dropped, watch_opening};
use crate::action::{apply, check_cancelled, take_in};
use crate::command::{self, Command, Commands};
use crate::panel;
use crate::panel::check::{CheckView, check_ui};
use crate::panel::closing::ClosingView;
use crate::panel::dialogs::DialogsView;
use crate::panel::flight::export::export_ui;
use crate::panel::flight::timeline::{TimelineView, timeline_ui};
use crate::panel::layer_options::LayerOptionsView;
use crate::panel::model_suggestions::model_suggestions_ui;
use crate::panel::notes::NotesView;
use crate::panel::opening::opening_ui;
use crate::panel::opening::view::OpeningView;
use crate::panel::orthophoto::orthophoto_ui;
use crate::panel::palette::palette_ui;
use crate::panel::publish::publish_ui;
use crate::panel::save_image::save_image_ui;
use crate::panel::site_frame::site_frame_ui;
use crate::panel::space::SpaceTextures;
use crate::panel::status::StatusView;
use crate::panel::welcome::WelcomeView;
use crate::state::State;
use crate::state::life::{Goal, LifeEvent};
use crate::state::model_suggestions::SuggestedModelState;
use crate::state::panes::KeyOwner;
use crate::state::request::{ProjectRequest, Request};
use crate::state::session::Session;
use crate::state::settings::{Colours, Settings};
use crate::widget::focus::{FocusKind, focused};
use crate::widget::sized::{PanelEdge, sized_panel};
use crate::work::Work;
use crate::work::crash::{self, Crash};
use crate::work::known::KnownFile;
use crate::work::waker::Waker;

/// The key of the settings in eframe's storage.
const SETTINGS: &str = "settings";
/// The name of the file that all windows share, beside eframe's storage.
const KNOWN: &str = "projects.json";

/// What earlier versions kept among the settings.
#[derive(Default, serde::Deserialize)]
#[serde(default)]
struct FormerSettings {
    recent: Vec<PathBuf>,
}

/// The largest share of the remaining height that each panel below the views takes.
const BELOW_MOST: f32 = 0.4;

/// The editor.
pub struct Editor {
    /// The state that is shown and edited.
    pub state: State,
    /// The threads beside the window.
    pub work: Work,
    /// The layout of the views of the centre.
    pub layout: PaneLayout,
    /// The textures that panels draw.
    pub textures: Textures,
    /// The times of frames.
    pub frame_times: FrameTimes,
    /// The fault that is shown in place of the editor.
    pub crash: Option<Crash>,
    /// The context of the window.
    pub context: Context,
    /// The colours and the scale applied to the window.
    look: (Colours, f32),
    title: String,
}

/// The editor derefs to its state, for tests and panels.
impl Deref for Editor {
    type Target = State;

    fn deref(&self) -> &State {
        &self.state
    }
}

impl DerefMut for Editor {
    fn deref_mut(&mut self) -> &mut State {
        &mut self.state
    }
}

impl Editor {
    /// Makes the editor with the stored settings, and opens `project` if there is one.
    pub fn new(context: &Context, storage: Option<&dyn Storage>, project: Option<PathBuf>) -> Self {
        let mut settings: Settings =
            storage.and_then(|storage| eframe::get_value(storage, SETTINGS)).unwrap_or_default();
        // Without storage, hints would return in every run.
        settings.hints &= storage.is_some();
        apply_look(&settings, context);
        context.add_plugin(InputSplitter::default());
        let wakes = context.clone();
        let mut editor = Self {
            look: (settings.colours, settings.scale),
            state: State { settings, ..State::default() },
            work: Work::new(Waker::new(move || wakes.request_repaint())),
            layout: PaneLayout::stored(storage),
            textures: Textures::default(),
            frame_times: FrameTimes::default(),
            crash: None,
            context: context.clone(),
            title: String::new(),
        };
        editor.layout.notify(&mut editor.state.panes);
        editor.share(storage);
        if let Some(project) = project {
            editor.apply(ProjectRequest::Open(project));
        }
        editor
    }

    /// Shares what is known of projects with all other windows, where settings are stored.
    fn share(&mut self, storage: Option<&dyn Storage>) {
        let Some((storage, folder)) = storage.zip(eframe::storage_dir(APP_ID)) else { return };
        self.work.pages = Some(folder.join("documents"));
        self.work.known = KnownFile::new(folder.join(KNOWN));
        if self.work.known.is_missing() {
            let former: FormerSettings = eframe::get_value(storage, SETTINGS).unwrap_or_default();
            former.recent.iter().rev().for_each(|project| remember(&mut self.state, &self.work, project));
        }
        follow_known(&mut self.state, &mut self.work);
    }

    /// Applies a request.
    pub fn apply(&mut self, request: impl Into<Request>) {
        apply(&mut self.state, &mut self.work, request.into());
    }

    /// Runs a command if it is ready; otherwise a note gives the reason.
    pub fn run(&mut self, command: &Command) {
        self.apply(command.requested(&self.state));
    }

    fn take_in(&mut self, context: &Context) {
        let dropped = context.input(|input| input.raw.dropped_files.clone());
        let dropped: Vec<PathBuf> = dropped.iter().map(|file| file.path().to_path_buf()).collect();
        let (state, work) = (&mut self.state, &mut self.work);
        take_in(state, work);
        self.textures.take_in(context, &mut work.pictures);
        take_dropped(state, work, &dropped);
        watch_opening(state, work);
        self.show_title(context);
        self.take_close_request(context);
        check_cancelled(&mut self.state, &mut self.work);
    }

    fn show_title(&mut self, context: &Context) {
        let name = self.state.session.as_ref().map(Session::name);
        let unsaved = if self.state.is_dirty() { "*" } else { "" };
        let title = name.map_or_else(|| "Quadratura".into(), |name| format!("{unsaved}{name} – Quadratura"));
        if title != self.title {
            context.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// Handles a request to close from the window system.
    fn take_close_request(&mut self, context: &Context) {
        if self.work.ending.is_asked() && !self.state.life.quits() {
            return self.state.quit();
        }
        let asked = context.input(|input| input.viewport().close_requested());
        let facts = self.state.life_facts();
        let ends = facts.is_dirty || facts.writes;
        // After a fault no question can be answered; unsaved changes are in the autosave.
        if asked && ends && !self.state.life.quits() && self.crash.is_none() {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
            self.apply(ProjectRequest::Life(LifeEvent::Leave(Goal::Quit)));
        }
    }

    /// Returns whether the keys of a command apply: while a dialog is open they belong to it, and without a project
    /// keys without Ctrl apply to ready commands only.
    fn hears(&self, command: &Command, keys: &KeyboardShortcut) -> bool {
        if self.state.has_dialog() {
            return (command.in_dialog)(&self.state);
        }
        if !keys.modifiers.command && !command.keys_in.includes(self.state.panes.key_owner()) {
            return false;
        }
        self.state.session.is_some() || keys.modifiers.command || (command.ready)(&self.state).is_ok()
    }

    /// Returns the keys that belong to the focused widget: those that press a control, and Enter in a list while no
    /// view is under the pointer.
    fn taken_keys(&self, context: &Context) -> &'static [Key] {
        match focused(context) {
            FocusKind::Control => &[Key::Enter, Key::Space],
            FocusKind::List if self.state.panes.key_owner() == KeyOwner::Beside => &[Key::Enter],
            FocusKind::List | FocusKind::View | FocusKind::Nothing => &[],
        }
    }

    /// Applies the state's requests to the window.
    fn settle(&mut self, context: &Context) {
        let wanted = (self.state.settings.colours, self.state.settings.scale);
        let resets = std::mem::take(&mut self.state.window.resets);
        if resets {
            context.memory_mut(|memory| *memory = egui::Memory::default());
            self.layout = PaneLayout::default();
        }
        if resets || self.look != wanted {
            apply_look(&self.state.settings, context);
            self.look = wanted;
        }
        for pane in self.state.panes.take_to_front() {
            self.layout.show(pane);
        }
        self.layout.notify(&mut self.state.panes);
        if std::mem::take(&mut self.state.window.closes) {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
        if let Some(text) = self.state.window.copies.take() {
            context.copy_text(text);
        }
        if let Some(seconds) = self.state.window.next_frame_s.take() {
            context.request_repaint_after_secs(seconds as f32);
        }
    }
}

impl eframe::App for Editor {
    fn logic(&mut self, context: &Context, frame: &mut Frame) {
        // The usage is that of the previous frame.
        self.frame_times.begin(frame.info().cpu_usage, !self.state.running.is_idle());
        self.state.window.now_s = context.input(|input| input.time);
        self.state.window.density = context.pixels_per_point();
        let work = || {
            self.take_in(context);
            // Turns are handled in order: one may open a dialog, to which the following ones belong.
            while self.crash.is_none() {
                let heard = |command: &Command, keys: &KeyboardShortcut| self.hears(command, keys);
                let taken = self.taken_keys(context);
                let Some(command) = command::next_pressed(context, taken, heard) else {
                    break;
                };
                self.run(command);
            }
            self.settle(context);
        };
        if let Err(crash) = crash::guarded(work) {
            self.crashed(crash);
        }
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut Frame) {
        if let Some(crash) = &self.crash {
            let answer = crash_ui(crash, ui);
            answer.into_iter().for_each(|answer| self.answer_crash(answer));
        } else if let Err(crash) = crash::guarded(|| self.draw(ui)) {
            self.crashed(crash);
            ui.ctx().request_repaint();
        }
        let context = ui.ctx().clone();
        self.settle(&context);
        self.frame_times.end(!self.state.running.is_idle());
    }

    fn save(&mut self, storage: &mut dyn Storage) {
        eframe::set_value(storage, SETTINGS, &self.state.settings);
        self.layout.store(storage);
    }

    fn on_exit(&mut self) {
        end(&mut self.state, &mut self.work);
    }
}

impl Drop for Editor {
    /// A lost display connection ends the window without any question.
    fn drop(&mut self) {
        // A second panic during unwinding would abort the process.
        let _ = crash::guarded(|| end(&mut self.state, &mut self.work));
    }
}

impl Editor {
    fn draw(&mut self, ui: &mut Ui) {
        let mut requests = Vec::new();
        Panel::top("menu").show(ui, |ui| {
            panel::menu::menu_ui(Commands::of(&self.state), &self.state.settings, ui, &mut requests)
        });
        Panel::bottom("status")
            .show(ui, |ui| panel::status::status_ui(&StatusView::new(&self.state), ui, &mut requests));
        let mut sizes = self.state.settings.sizes;
        if self.state.settings.notes_shown {
            let most = BELOW_MOST * ui.available_height();
            sized_panel(ui, PanelEdge::Bottom, "notes", &mut sizes.notes, most, |ui| {
                panel::notes::notes_ui(&NotesView::new(&self.state), ui, &mut requests)
            });
        }
        if self.state.session.is_some() && self.state.flights.shown {
            let most = BELOW_MOST * ui.available_height();
            sized_panel(ui, PanelEdge::Bottom, "flight", &mut sizes.flight, most, |ui| {
                timeline_ui(ui, &TimelineView::new(&self.state), &mut requests)
            });
        }
        if self.state.session.is_some() {
            self.state.look_up_selection();
            // The lists change while the rest of the state is read.
            let mut lists = std::mem::take(&mut self.state.lists);
            let (photos, paint) = (&self.textures.photos, &mut self.textures.paint);
            panel::sides::sides_ui(ui, &self.state, &mut sizes, &mut lists, photos, paint, &mut requests);
            self.state.lists = lists;
        }
        self.state.settings.sizes = sizes;
        if self.state.session.is_some() {
            let Self { layout, state, textures, .. } = self;
            CentralPanel::no_frame().show(ui, |ui| centre_ui(ui, layout, state, textures, &mut requests));
        } else {
            self.textures.space = SpaceTextures::default();
            let mut path = self.state.opening.dialogs.typed.clone();
            let welcome = |ui: &mut Ui| {
                panel::welcome::welcome_ui(&WelcomeView::new(&self.state), &mut path, ui, &mut requests)
            };
            CentralPanel::default_margins().show(ui, welcome);
            self.state.opening.dialogs.typed = path;
        }
        let context = ui.ctx().clone();
        panel::closing::closing_ui(&context, &ClosingView::new(&self.state), &mut requests);
        panel::merging::merging_ui(&context, self.state.lists.merging.as_ref(), &mut requests);
        panel::removing::removing_ui(&context, self.state.lists.removing.as_ref(), &mut requests);
        export_ui(&context, &mut self.state.flights.export, &mut requests);
        let mut save_image = self.state.dialogs.save_image.take();
        save_image_ui(&context, self.state.session.is_some(), &mut save_image, &mut requests);
        self.state.dialogs.save_image = save_image;
        let mut orthophoto = self.state.dialogs.orthophoto.take().filter(|_| self.state.session.is_some());
        let texture = &mut self.textures.orthophoto;
        orthophoto_ui(&context, &self.state.running, &mut orthophoto, texture, &mut requests);
        self.state.dialogs.orthophoto = orthophoto;
        let mut publish = self.state.dialogs.publish.take().filter(|_| self.state.session.is_some());
        publish_ui(&context, &self.state.running, &mut publish, &mut requests);
        self.state.dialogs.publish = publish;
        let mut site_frame = self.state.dialogs.site_frame.take().filter(|_| self.state.session.is_some());
        site_frame_ui(&context, &mut site_frame, &mut requests);
        self.state.dialogs.site_frame = site_frame;
        panel::help::help_ui(
            self.state.dialogs.help,
            self.state.settings.navigation,
            &context,
            &mut requests,
        );
        panel::history::history_ui(
            self.state.dialogs.history,
            self.state.session.as_ref(),
            &context,
            &mut requests,
        );
        let mut shown = self.state.dialogs.about;
        panel::about::about_ui(self.state.space.device.as_deref(), &mut shown, &context);
        self.state.dialogs.about = shown;
        let State { dialogs, settings, .. } = &self.state;
        let commands = Commands::of(&self.state);
        panel::settings::settings_ui(dialogs.settings, settings, commands, &context, &mut requests);
        panel::layer_options::layer_options_ui(&context, &LayerOptionsView::new(&self.state), &mut requests);
        let SuggestedModelState { mut offered, shown, rejected } =
            std::mem::take(&mut self.state.suggested_model);
        model_suggestions_ui(&context, &self.state.running, shown, &mut offered, &mut requests);
        self.state.suggested_model = SuggestedModelState { offered, shown, rejected };
        check_ui(&CheckView::new(&self.state), &mut self.textures.check, &context, &mut requests);
        let mut dialogs = self.state.opening.dialogs.clone();
        opening_ui(&OpeningView::new(&self.state), &mut dialogs, &context, &mut requests);
        self.state.opening.dialogs = dialogs;
        let mut dialogs = self.state.round_trip.dialogs.clone();
        panel::dialogs::dialogs_ui(&context, &DialogsView::new(&self.state), &mut dialogs, &mut requests);
        self.state.round_trip.dialogs = dialogs;
        let mut palette = self.state.dialogs.palette.clone();
        let command = palette_ui(Commands::of(&self.state), &mut palette, &context);
        self.state.dialogs.palette = palette;
        requests.extend(command.map(|command| command.requested(&self.state)));
        requests.into_iter().for_each(|request| self.apply(request));
    }
}
