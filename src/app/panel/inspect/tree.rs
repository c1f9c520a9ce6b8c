//! The inspector page of a tree.

use eframe::egui::{ComboBox, DragValue, Grid, Key, Response, TextEdit, Ui};

use crate::command::{trees, view};
use crate::panel::inspect::view::InspectorView;
use crate::panel::{button, grouped, link_ui, named, rows, small_button, title};
use crate::state::request::{DecideRequest, Request, SelectRequest, TreeRequest};
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_document::trees::{PlacedTree, TreeIndex, Trees};
use quadratura_trees::mask::masks_of;

/// The species that need not be added before.
pub const BUILT_IN: [&str; 2] = ["maple", "oak"];
/// The step of a number for each point of a drag, in world units, as a share of the site's radius.
const STEP_SHARE: f64 = 1e-3;

/// Draws the page of a tree.
pub fn tree_page(ui: &mut Ui, view: &InspectorView<'_>, index: TreeIndex, requests: &mut Vec<Request>) {
    let Some(session) = view.session else { return };
    let all = session.trees();
    let Some(tree) = all.at(index) else { return };
    requests.push(TreeRequest::WantFigures.into());
    title(ui, "Tree", &tree.name);
    let step = STEP_SHARE * session.scene_frame.radius;
    let mut page = TreePage { tree, requests };
    page.name_ui(ui);
    Grid::new("tree").num_columns(2).spacing([8.0, 4.0]).show(ui, |ui| {
        page.species_ui(ui, view);
        page.place_ui(ui, step);
        page.size_ui(ui, view, step);
        page.turn_ui(ui);
        page.tint_ui(ui);
        page.casts_ui(ui);
    });
    page.replaces_ui(ui, view);
    ui.add_space(6.0);
    costs_ui(ui, view, tree, requests);
    ui.add_space(6.0);
    ui.horizontal_wrapped(|ui| {
        for command in [&view::FRAME, &trees::DUPLICATE, &trees::HIDE, &trees::REMOVE, &trees::MASK] {
            button(view.commands, ui, command, requests);
        }
    });
    let light = link_ui(ui, "Light on all trees").on_hover_text(trees::LIGHT.tooltip);
    if light.clicked() {
        requests.push(SelectRequest::Only(Selection::Trees).into());
    }
}

struct TreePage<'a> {
    tree: &'a PlacedTree,
    requests: &'a mut Vec<Request>,
}

impl TreePage<'_> {
    /// Asks for another tree in place of this one.
    fn set(&mut self, what: &'static str, goes_on: bool, change: impl FnOnce(&mut PlacedTree)) {
        let mut tree = self.tree.clone();
        change(&mut tree);
        let name = self.tree.name.clone();
        self.requests.push(TreeRequest::Set { name, tree: Box::new(tree), what, goes_on }.into());
    }

    /// Asks for what a field was changed to; a drag is one step.
    fn dragged(&mut self, field: &Response, what: &'static str, change: impl FnOnce(&mut PlacedTree)) {
        if field.changed() {
            self.set(what, goes_on(field), change);
        } else if field.drag_stopped() {
            self.requests.push(DecideRequest::EndGesture.into());
        }
    }

    /// Draws a field for the name, which is applied when the field loses the focus.
    fn name_ui(&mut self, ui: &mut Ui) {
        let id = ui.make_persistent_id(("name of tree", &self.tree.name));
        let mut typed = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| self.tree.name.clone());
        ui.horizontal(|ui| {
            let label = ui.label("Name");
            let field = TextEdit::singleline(&mut typed).desired_width(ui.available_width() - 16.0);
            let field = ui.add(field).on_hover_text("The tree's name, which no other tree has.");
            let field = field.labelled_by(label.id);
            let cancelled = ui.input(|input| input.key_pressed(Key::Escape));
            if field.lost_focus() && typed.trim() != self.tree.name && !cancelled {
                let name = typed.trim().to_owned();
                self.set("name", false, |tree| tree.name = name);
            }
            if field.has_focus() {
                ui.data_mut(|data| data.insert_temp(id, typed));
            } else {
                ui.data_mut(|data| data.remove::<String>(id));
            }
        });
    }

    fn species_ui(&mut self, ui: &mut Ui, view: &InspectorView<'_>) {
        let label = ui.label("Species");
        let combo = ComboBox::from_id_salt("species of tree").selected_text(&self.tree.species);
        let mut chosen = None;
        let combo = combo.show_ui(ui, |ui| {
            chosen = species_choice(ui, view.session.map(Session::trees), &self.tree.species)
        });
        combo.response.labelled_by(label.id);
        if let Some(species) = chosen {
            self.set("species", false, |tree| tree.species = species);
        }
        ui.end_row();
    }

    fn place_ui(&mut self, ui: &mut Ui, step: f64) {
        ui.label("Foot").on_hover_text("Where the tree stands, in world coordinates.");
        ui.horizontal_wrapped(|ui| {
            for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
                let mut at = self.tree.at[axis];
                let field = DragValue::new(&mut at).speed(step).max_decimals(3).prefix(format!("{name} "));
                let field = ui.add(field.update_while_editing(false));
                named(&field, &format!("Foot {name}"));
                self.dragged(&field, "place", |tree| tree.at[axis] = at);
            }
        });
        ui.end_row();
    }

    fn size_ui(&mut self, ui: &mut Ui, view: &InspectorView<'_>, step: f64) {
        let size = view.session.and_then(|session| view.trees.size_of(session.trees(), self.tree));
        type Set = fn(&mut PlacedTree, Option<f64>);
        let rows: [(&str, Option<f64>, &str, &'static str, Set); 2] = [
            (
                "Height",
                self.tree.height,
                "The height above the foot, in world units.",
                "height",
                |tree, to| {
                    tree.height = to;
                },
            ),
            ("Width", self.tree.width, "The width of the crown, in world units.", "width", |tree, to| {
                tree.width = to;
            }),
        ];
        for (place, (name, said, tooltip, what, set)) in rows.into_iter().enumerate() {
            let label = ui.label(name).on_hover_text(tooltip);
            ui.horizontal(|ui| {
                // What is not said is the plant's own, as soon as it is known.
                let Some(mut length) = said.or(size.map(|size| size[place])) else {
                    ui.weak("reading the plant…");
                    return;
                };
                let field = DragValue::new(&mut length).speed(step).range(step..=f64::MAX).max_decimals(3);
                let field = field.clamp_existing_to_range(false);
                let field = ui.add(field.update_while_editing(false)).labelled_by(label.id);
                self.dragged(&field, what, |tree| set(tree, Some(length)));
                if said.is_none() {
                    ui.weak("as it grows");
                } else {
                    let tooltip = format!("Gives the tree the {what} with which its species grows.");
                    if small_button(ui, "As it grows", &format!("{name} as it grows"), &tooltip).clicked() {
                        self.set(what, false, |tree| set(tree, None));
                    }
                }
            });
            ui.end_row();
        }
    }

    fn turn_ui(&mut self, ui: &mut Ui) {
        let label = ui.label("Turn");
        let mut turn = self.tree.turn;
        let field = ui.add(DragValue::new(&mut turn).suffix("°").max_decimals(1).update_while_editing(false));
        let field = field.labelled_by(label.id);
        let field = field.on_hover_text("About what is up, against the clock as seen from above.");
        self.dragged(&field, "turn", |tree| tree.turn = turn);
        ui.end_row();
    }

    fn tint_ui(&mut self, ui: &mut Ui) {
        ui.label("Brighter by").on_hover_text("How much brighter the tree is than its species, in stops.");
        ui.horizontal_wrapped(|ui| {
            for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
                let mut stops = self.tree.tint[channel];
                let field = DragValue::new(&mut stops).speed(0.01).range(-20.0..=20.0).max_decimals(2);
                let field = field.clamp_existing_to_range(false);
                let field =
                    ui.add(field.update_while_editing(false)).on_hover_text(format!("{name}, in stops"));
                named(&field, &format!("Brighter by: {name}"));
                self.dragged(&field, "tint", |tree| tree.tint[channel] = stops);
            }
        });
        ui.end_row();
    }

    fn casts_ui(&mut self, ui: &mut Ui) {
        ui.label("Shadow");
        let mut casts = self.tree.casts;
        let tooltip = "The tree's sun shadow darkens faces: for trees that no photo shows. One that the photos show has its \
                       shadow there already.";
        if ui.checkbox(&mut casts, "Casts a shadow").on_hover_text(tooltip).changed() {
            self.set("shadow", false, |tree| tree.casts = casts);
        }
        ui.end_row();
    }

    /// Draws the objects that are out of the model while the tree stands, and the choice of another one.
    fn replaces_ui(&mut self, ui: &mut Ui, view: &InspectorView<'_>) {
        let Some(session) = view.session else { return };
        let all = session.trees();
        ui.add_space(6.0);
        ui.strong("Replaces");
        for object in &self.tree.replaces {
            ui.horizontal_wrapped(|ui| {
                let name = format!("Bring {object} back");
                if small_button(ui, "Bring back", &name, "Puts the object back into the model.").clicked() {
                    let object = object.clone();
                    self.set("replaced objects", false, |tree| {
                        tree.replaces.remove(&object);
                    });
                }
                ui.label(object);
            });
        }
        let objects = session.opened.whole.objects.iter().filter(|object| object.billboard);
        let free = objects.filter(|object| all.replaced().all(|name| *name != object.name));
        let free: Vec<&str> = free.map(|object| object.name.as_str()).collect();
        if free.is_empty() {
            if self.tree.replaces.is_empty() {
                ui.weak("nothing");
            }
            return;
        }
        let combo = ComboBox::from_id_salt("replaced object").selected_text("Replace a billboard…");
        let mut chosen = None;
        let combo = combo.show_ui(ui, |ui| {
            for object in free {
                if ui.selectable_label(false, object).clicked() {
                    chosen = Some(object.to_owned());
                }
            }
        });
        named(&combo.response, "Replace a billboard");
        let tooltip = "Removes a billboard from the model while the tree stands, as `tree place --on` does.";
        combo.response.on_hover_text(tooltip);
        if let Some(object) = chosen {
            self.set("replaced objects", false, |tree| {
                tree.replaces.insert(object);
            });
        }
    }
}

/// Returns whether the gesture of a field continues.
pub fn goes_on(field: &Response) -> bool {
    field.dragged() && !field.drag_stopped()
}

/// Draws the species that trees may be of; returns the one that was chosen.
pub fn species_choice(ui: &mut Ui, trees: Option<&Trees>, now: &str) -> Option<String> {
    let known = trees.into_iter().flat_map(|trees| trees.species.keys().map(String::as_str));
    let mut all: Vec<&str> = known.chain(BUILT_IN).collect();
    all.sort_unstable();
    all.dedup();
    let mut chosen = None;
    for species in all {
        if ui.selectable_label(species == now, species).clicked() && species != now {
            chosen = Some(species.to_owned());
        }
    }
    chosen
}

/// Draws what a tree costs, and where it is masked.
fn costs_ui(ui: &mut Ui, view: &InspectorView<'_>, tree: &PlacedTree, requests: &mut Vec<Request>) {
    let Some(session) = view.session else { return };
    let project = session.history.present();
    let masked = masks_of(project, tree);
    let mut facts = vec![("Masked in", format!("{} of {} photos", masked.photos, session.photos.len()))];
    let species = project.trees.species.get(&tree.species);
    match species.and_then(|species| view.trees.figures.of(species)) {
        Some(Ok(figures)) => {
            facts.push(("Polygons", grouped(figures.counts.polygons)));
            facts.push(("Triangles", grouped(figures.counts.triangles)));
            facts.push(("Instances", grouped(figures.counts.sub_objects)));
        }
        Some(Err(_)) | None => facts.push(("Polygons", "not known".into())),
    }
    rows(ui, &facts);
    if masked.outdated {
        ui.horizontal_wrapped(|ui| {
            ui.colored_label(ui.visuals().warn_fg_color, "Its masks are out of date: the tree has changed.");
            let again = link_ui(ui, "Mask real trees").on_hover_text(trees::MASK.tooltip);
            if again.clicked() {
                requests.push(TreeRequest::Mask.into());
            }
        });
    }
    if let Some(Err(problem)) = species.and_then(|species| view.trees.figures.of(species)) {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
}
