//! A scene, sorted, with the fragments that it was sorted by.

use std::sync::Arc;

use quadratura::task::Task;
use quadratura::testing::layers::cycles::{Resolved, resolve_cycles};
use quadratura::testing::layers::rasteriser::Presence;
use quadratura::testing::layers::{Fragments, LayerConstraints, Options, Rasteriser, Sorted, sort_photo};
use quadratura::testing::scene::synthetic::{Scene, Truth};
use quadratura::testing::scene::{Model, ObjectId};

/// A result, and what is needed to judge it.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    pub name: String,
    pub model: Arc<Model>,
    pub options: Options,
    pub fragments: Fragments,
    pub sorted: Sorted,
}

impl Case {
    pub fn new(scene: &Scene, rasteriser: &dyn Rasteriser) -> Self {
        Self::with(scene, rasteriser, Options::default())
    }

    pub fn with(scene: &Scene, rasteriser: &dyn Rasteriser, options: Options) -> Self {
        Self::wished(scene, rasteriser, options, &LayerConstraints::default())
    }

    pub fn wished(
        scene: &Scene,
        rasteriser: &dyn Rasteriser,
        options: Options,
        constraints: &LayerConstraints,
    ) -> Self {
        let Scene { name, model, camera, pose, .. } = scene.clone();
        let task = Task::silent();
        let sorted = sort_photo(&model, &camera, &pose, rasteriser, &options, constraints, &task)
            .expect("the rasteriser works and nobody stops it");
        let fragments =
            rasteriser.fragments(&sorted.view, options.tolerance, &task).expect("it worked a moment ago");
        Self { name, model, options, fragments, sorted }
    }

    /// Which items are in the working set.
    pub fn working(&self) -> Vec<bool> {
        self.sorted.presence.iter().map(|p| *p == Presence::Working).collect()
    }

    /// The step before elements are gathered.
    pub fn resolved(&self) -> Resolved {
        let Sorted { view, runs, .. } = &self.sorted;
        resolve_cycles(view, runs, &self.working(), &self.fragments.occlusions, &self.options)
    }

    /// The object of a node.
    pub fn object_of(&self, node: u32) -> ObjectId {
        let item = self.sorted.nodes.list[node as usize].item;
        self.model.face(self.sorted.view.items[item as usize].face).object
    }

    /// Asserts what the scene says about itself.
    pub fn check_truth(&self, truth: &Truth) {
        match truth {
            Truth::Unknown => {}
            Truth::Cycle => assert!(self.sorted.cuts > 0, "{}: nothing was cut", self.name),
            Truth::Layers(expected) => {
                assert_eq!(&self.names_by_layer(), expected, "{}", self.name);
                assert_eq!(self.sorted.cuts, 0, "{}: something was cut", self.name);
                assert!(self.sorted.layers.against.is_empty(), "{}: something was forgiven", self.name);
            }
        }
    }

    fn names_by_layer(&self) -> Vec<Vec<&str>> {
        let mut names = vec![Vec::new(); self.sorted.layers.count() as usize];
        for element in &self.sorted.layers.elements {
            names[element.visibility_layer as usize].push(self.model.object(element.object).name.as_str());
        }
        names.iter_mut().for_each(|layer| layer.sort_unstable());
        names
    }
}
