//! Actions that complete the model by what is suggested.

use std::path::PathBuf;

use crate::state::State;
use crate::state::model_suggestions::ModelSuggestions;
use crate::state::notes::{Note, Weight};
use crate::state::request::{JobRequest, ModelRequest, Request};
use crate::state::running::JobKind;
use crate::work::Work;
use quadratura_document::Project;
use quadratura_document::model_change::ModelChange;
use quadratura_sites::site_stamp::SiteStamp;
use quadratura_sites::suggest::{
    Added, SuggestedModel, add_to_model, model_hash, suggest_missing, write_model_change,
};

/// Applies a request about what is suggested to complete the model.
pub fn apply(state: &mut State, work: &mut Work, request: ModelRequest) {
    let suggested = &mut state.suggested_model;
    match request {
        ModelRequest::Suggest if suggested.offered.is_some() => suggested.shown = true,
        ModelRequest::Suggest | ModelRequest::SuggestAgain => suggest(state, work),
        ModelRequest::Hide => suggested.shown = false,
        ModelRequest::Reject(object) => {
            let rejected = suggested.offered.as_mut().map(|offered| offered.reject(object));
            suggested.rejected.extend(rejected.into_iter().flatten());
        }
        ModelRequest::MoveEdge(edge, to) => {
            suggested.offered.iter_mut().for_each(|offered| offered.move_edge(edge, to));
        }
        ModelRequest::Add => add(state, work),
    }
}

/// Starts the search for what the model does not explain.
fn suggest(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let (folder, project) = (session.folder.clone(), Project::clone(session.history.present()));
    if session.seen.changes(&SiteStamp::new(&folder, &project)).contains(&"the model") {
        let text =
            "The model’s file has changed: reload the site from disk first, then suggest what is missing";
        return state.notify(Note::new(Weight::Warning, text));
    }
    let opened = session.opened.with_project(&folder, project);
    work.jobs.start(&mut state.running, JobKind::Model, "Suggesting what is missing", move |task| {
        let hash = model_hash(&folder, &opened.project)?;
        let found = suggest_missing(&folder, &opened, task)?;
        found.problems.iter().for_each(|problem| task.note(problem.to_string()));
        Ok(Box::new(move |state| {
            state.model_suggested(folder, hash, &found);
            Vec::new()
        }))
    });
}

/// Starts adding what is wanted to the model.
fn add(state: &mut State, work: &mut Work) {
    let (Some(session), Some(offered)) = (&state.session, &state.suggested_model.offered) else { return };
    let additions = offered.additions();
    if additions.is_empty() || session.folder != offered.project {
        return;
    }
    let (folder, project, lock) =
        (session.folder.clone(), Project::clone(session.history.present()), session.lock.clone());
    let known = offered.model_hash.clone();
    work.jobs.start(&mut state.running, JobKind::Model, "Adding to the model", move |task| {
        let added = add_to_model(&folder, &project, &known, &additions, task)?;
        let hash = model_hash(&folder, &project)?;
        drop(lock);
        Ok(Box::new(move |state| state.model_completed(&folder, additions.len(), added, hash)))
    });
}

/// Writes the model's file as a step of the history asks, unless another program has changed it since.
pub fn turn_model(state: &mut State, work: &mut Work, change: &ModelChange) {
    let (text, weight) = match write_model_change(change) {
        Ok(true) => {
            if let (Some(session), Some(offered)) = (&state.session, &mut state.suggested_model.offered)
                && let Ok(hash) = model_hash(&session.folder, session.history.present())
            {
                offered.model_hash = hash;
            }
            return super::reread::reload(state, work);
        }
        Ok(false) => (
            format!(
                "{} was changed by another program since, and stays as it is: this step cannot be undone or redone",
                change.file.display()
            ),
            Weight::Warning,
        ),
        Err(error) => (format!("The model’s file was not written: {error}"), Weight::Problem),
    };
    if let Some(session) = &mut state.session {
        session.history.forget_model_change(change);
    }
    state.notify(Note::new(weight, text));
}

impl State {
    /// Shows what was found, unless the project was left.
    pub fn model_suggested(&mut self, folder: PathBuf, model_hash: String, found: &SuggestedModel) {
        let Some(session) = self.session.as_ref().filter(|session| session.folder == folder) else { return };
        let suggested = &mut self.suggested_model;
        let model = &session.opened.whole;
        let offers = ModelSuggestions::new(folder, model_hash, &found.objects, model, &suggested.rejected);
        let (count, is_empty) = (offers.objects.len(), offers.objects.is_empty());
        (suggested.offered, suggested.shown) = ((!is_empty).then_some(offers), !is_empty);
        let text = match count {
            0 => "Nothing else is missing: all that was found was rejected before".to_owned(),
            1 => "One object is suggested: see it as glass in the views".to_owned(),
            count => format!("{count} objects are suggested: see them as glass in the views"),
        };
        self.notify(Note::new(Weight::Info, text));
    }

    /// Takes in what was added to the model, as one step that can be undone.
    fn model_completed(
        &mut self,
        folder: &PathBuf,
        count: usize,
        added: Added,
        model_hash: String,
    ) -> Vec<Request> {
        let Some(session) = self.session.as_mut().filter(|session| session.folder == *folder) else {
            return Vec::new();
        };
        let what = if count == 1 { "one suggestion".to_owned() } else { format!("{count} suggestions") };
        if let Some(offered) = &mut self.suggested_model.offered {
            offered.objects.retain(|object| !object.wanted);
            (offered.model_hash, offered.pointed) = (model_hash, None);
            if offered.objects.is_empty() {
                (self.suggested_model.offered, self.suggested_model.shown) = (None, false);
            }
        }
        let name = format!("addition of {what} to the model");
        match added {
            Added::Written(change) => {
                let text = format!("Added {what} to {}. Undo removes them again", change.file.display());
                session.history.model_written(name, change);
                self.notify(Note::new(Weight::Info, text));
                vec![JobRequest::Reread(None).into()]
            }
            Added::Copied { file, model } => {
                let project = Project { model, ..Project::clone(session.history.present()) };
                let text = format!(
                    "The project’s model is now {}: a copy as OBJ, with {what}. The former file stays as it is",
                    file.display()
                );
                self.edit(name, project, None);
                self.notify(Note::new(Weight::Info, text));
                Vec::new()
            }
            Added::Beside(file) => {
                let text = format!(
                    "The model’s file was changed by another program since the search, and stays as it is: {what} were \
                     written to {}, to be joined with it there",
                    file.display()
                );
                self.notify(Note::new(Weight::Warning, text));
                Vec::new()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::action::tests::bench::TestBench;
    use crate::state::request::DecideRequest;
    use glam::DVec3;
    use quadratura_sites::suggest::{PlaneKind, SuggestedFace, SuggestedObject};

    const MODEL: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\no floor\nf 1 2 3\n";

    fn found() -> SuggestedModel {
        let object = |x: f64| SuggestedObject {
            name: "wall_1".into(),
            kind: PlaneKind::Plumb,
            faces: vec![SuggestedFace {
                ring: vec![DVec3::X * x, DVec3::new(x, 4.0, 0.0), DVec3::new(x, 0.0, 4.0)],
            }],
            points: 40,
            photos_for: 3.0,
            photos_against: 0.0,
            gain: Some(2.0),
        };
        SuggestedModel {
            objects: vec![object(1.0), object(9.0)],
            dropped: 0,
            psnr_db: 20.0,
            photos: 3,
            points: 99,
            problems: Vec::new(),
        }
    }

    /// Opens a project with a model of one triangle for which two walls are suggested.
    fn bench() -> TestBench {
        let mut bench = TestBench::new();
        let file = bench.folder().join("m.obj");
        std::fs::write(&file, MODEL).unwrap();
        let (folder, project) = (bench.folder().to_path_buf(), bench.project());
        bench.state.model_suggested(folder.clone(), model_hash(&folder, &project).unwrap(), &found());
        bench
    }

    fn model(bench: &TestBench) -> String {
        std::fs::read_to_string(bench.folder().join("m.obj")).unwrap()
    }

    fn offered(bench: &TestBench) -> usize {
        bench.state.suggested_model.offered.as_ref().map_or(0, |offered| offered.objects.len())
    }

    #[test]
    fn what_is_wanted_is_added_as_one_step_that_can_be_undone_and_redone() {
        let mut bench = bench();
        assert!(bench.state.suggested_model.visible().is_some() && offered(&bench) == 2);
        let objects = &mut bench.state.suggested_model.offered.as_mut().unwrap().objects;
        (objects[0].name, objects[1].wanted) = ("gate".into(), false);
        bench.request(ModelRequest::Add);
        bench.settle();
        let completed = model(&bench);
        assert!(completed.starts_with(MODEL) && completed.matches("\no ").count() == 2, "{completed}");
        assert!(completed.contains("\no gate\n"));
        assert_eq!((bench.undoes(), offered(&bench)), (Some("addition of one suggestion to the model"), 1));
        bench.request(DecideRequest::Undo);
        assert_eq!(model(&bench), MODEL);
        bench.settle();
        bench.request(DecideRequest::Redo);
        assert_eq!(model(&bench), completed);
        bench.settle();
        bench.request(ModelRequest::Add);
        bench.settle();
        assert!(!model(&bench).contains("wall"), "it is not wanted");
    }

    #[test]
    fn a_file_that_another_program_has_changed_is_never_overwritten() {
        let mut bench = bench();
        let other = MODEL.replace("floor", "court");
        std::fs::write(bench.folder().join("m.obj"), &other).unwrap();
        bench.request(ModelRequest::Add);
        bench.settle();
        assert_eq!(model(&bench), other);
        let beside = std::fs::read_to_string(bench.folder().join("suggested.obj")).unwrap();
        assert_eq!(beside.matches("o wall_").count(), 2, "{beside}");
        assert_eq!(bench.undoes(), None);
        assert!(
            bench.said().iter().any(|text| text.contains("changed by another program")),
            "{:?}",
            bench.said()
        );
    }

    #[test]
    fn an_addition_is_not_undone_over_the_changes_of_another_program() {
        let mut bench = bench();
        bench.request(ModelRequest::Add);
        bench.settle();
        let edited = model(&bench).replace("floor", "court");
        std::fs::write(bench.folder().join("m.obj"), &edited).unwrap();
        bench.request(DecideRequest::Undo);
        bench.settle();
        assert_eq!((model(&bench), bench.undoes()), (edited, None));
        assert!(bench.said().iter().any(|text| text.contains("cannot be undone")), "{:?}", bench.said());
    }

    #[test]
    fn a_rejected_object_is_not_offered_again_and_hidden_ones_come_back() {
        let mut bench = bench();
        bench.request(ModelRequest::Reject(0));
        assert_eq!((offered(&bench), model(&bench).as_str()), (1, MODEL));
        bench.request(ModelRequest::Hide);
        assert!(bench.state.suggested_model.visible().is_none());
        bench.request(ModelRequest::Suggest);
        assert!(bench.state.suggested_model.visible().is_some());
        let folder = bench.folder().to_path_buf();
        bench.state.model_suggested(folder, String::new(), &found());
        assert_eq!(offered(&bench), 1, "the other one");
        let other = bench.folder().join("other");
        bench.state.model_suggested(other, String::new(), &found());
        assert_eq!(offered(&bench), 1, "that project was left");
    }

    #[test]
    fn a_model_of_another_format_is_copied_and_the_project_names_the_copy() {
        let mut bench = bench();
        let file = bench.folder().join("m.obj");
        std::fs::rename(&file, bench.folder().join("m.txt")).unwrap();
        let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"name":"floor","mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
            "bufferViews":[{"buffer":0,"byteLength":36}],
            "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;
        std::fs::write(bench.folder().join("m.gltf"), json).unwrap();
        let project = Project { model: "m.gltf".into(), ..bench.project() };
        bench.state.edit("model", project.clone(), None);
        let hash = model_hash(bench.folder(), &project).unwrap();
        bench.state.suggested_model.offered.as_mut().unwrap().model_hash = hash;
        bench.request(ModelRequest::Add);
        bench.settle();
        assert_eq!(bench.project().model, "m-completed.obj", "{:?}", bench.said());
        let copy = std::fs::read_to_string(bench.folder().join("m-completed.obj")).unwrap();
        assert!(copy.contains("o floor\n") && copy.matches("o wall_").count() == 2, "{copy}");
        bench.request(DecideRequest::Undo);
        assert_eq!(bench.project().model, "m.gltf");
    }
}
