//! The nodes of a scene become drafts of sub-objects; those with the same content share one.

use glam::DAffine3;
use rustc_hash::FxHashMap;

use super::super::maps::{is_singular, is_within_numbers};
use super::super::notes::Notes;
use super::super::remedies::COARSER;
use super::meshes::MeshReader;
use crate::{Draft, DraftUse, MOST_CORNERS, MOST_USES};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_import::models::gltf::{SceneNode, instances};

/// The stage that is reported for reading nodes.
const STAGE: &str = "read plant";
/// Nodes are many and small: a step is reported for this number of them.
const NODES_A_STEP: usize = 1024;

/// What makes nodes one sub-object: the same mesh, and the same children at the same transforms, in any order.
#[derive(PartialEq, Eq, Hash)]
struct NodeContent {
    mesh: Option<usize>,
    /// The drafts of the children, and the bits of their transforms as 32-bit numbers, in ascending order.
    children: Vec<(usize, [u32; 12])>,
}

impl NodeContent {
    fn new(mesh: Option<usize>, uses: &[DraftUse]) -> Self {
        // -0 is 0.
        let bits = |map: &DAffine3| map.to_cols_array().map(|number| (number as f32 + 0.0).to_bits());
        let mut children: Vec<_> = uses.iter().map(|of| (of.child, bits(&of.parent_from_child))).collect();
        children.sort_unstable();
        Self { mesh, children }
    }
}

/// The drafts so far.
pub struct Graph<'a> {
    meshes: MeshReader<'a>,
    drafts: Vec<Draft>,
    known: FxHashMap<NodeContent, usize>,
    uses: usize,
    corners: u64,
}

impl<'a> Graph<'a> {
    /// Begins a graph.
    pub fn new(meshes: MeshReader<'a>) -> Self {
        Self { meshes, drafts: Vec::new(), known: FxHashMap::default(), uses: 0, corners: 0 }
    }

    /// Makes drafts of all nodes, whose parents come before them. Returns them, and which one is the whole plant: the only
    /// node without a parent, if there is one and it is not moved, else one called `name` that uses all of them.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with the JSON path; [`quadratura_base::Error::Cancelled`].
    pub fn build(
        mut self,
        nodes: &[SceneNode],
        name: String,
        notes: &mut Notes,
        task: &Task,
    ) -> Result<(Vec<Draft>, usize)> {
        // The uses of each node, and at the end those of the scene.
        let mut uses: Vec<Vec<DraftUse>> = vec![Vec::new(); nodes.len() + 1];
        for (at, node) in nodes.iter().enumerate().rev() {
            if at % NODES_A_STEP == 0 {
                task.step(STAGE, (nodes.len() - at) as u64, nodes.len() as u64)?;
            }
            // Children were met from the last to the first.
            let mut children = std::mem::take(&mut uses[at]);
            children.reverse();
            let Some(child) = self.draft_of(node.node, children, notes)? else { continue };
            let parent_from_child = node.parent_from_node;
            self.check_size(&parent_from_child, || format!("nodes[{}]", node.node))?;
            if is_singular(&parent_from_child) {
                notes.add(SINGULAR, || format!("nodes[{}]", node.node));
                continue;
            }
            uses[node.parent.unwrap_or(nodes.len())].push(DraftUse { child, parent_from_child });
        }
        let mut of_scene = uses.pop().expect("there is one more than nodes");
        of_scene.reverse();
        if let [DraftUse { child, parent_from_child }] = of_scene[..]
            && parent_from_child == DAffine3::IDENTITY
        {
            return Ok((self.drafts, child));
        }
        self.drafts.push(Draft { name, primitives: Vec::new(), uses: of_scene });
        let root = self.drafts.len() - 1;
        Ok((self.drafts, root))
    }

    /// Returns the draft of a node that uses `children`; `None` for one that holds nothing, such as a camera.
    fn draft_of(
        &mut self,
        node: usize,
        mut children: Vec<DraftUse>,
        notes: &mut Notes,
    ) -> Result<Option<usize>> {
        let root = &self.meshes.source.root;
        let described = &root.nodes[node];
        if described.skin.is_some() {
            notes.add("skins are left out: the shape at rest is used", || format!("nodes[{node}]"));
        }
        let mut mesh = described.mesh.map(|mesh| mesh.value());
        let named = |name: &Option<String>| name.clone().filter(|name| !name.is_empty());
        let of_mesh = mesh.and_then(|mesh| root.meshes.get(mesh)).and_then(|mesh| named(&mesh.name));
        let name = named(&described.name);
        let usual = || format!("node_{node}");
        if let Some(index) = mesh
            && let Some(maps) = instances(self.meshes.source, node)?
        {
            let child_name = of_mesh.clone().or_else(|| name.clone()).unwrap_or_else(usual);
            let child = self.draft(Some(index), child_name, Vec::new(), notes)?;
            let placed = child.map(|child| self.instances(node, child, maps, notes)).transpose()?;
            children.splice(0..0, placed.into_iter().flatten());
            mesh = None;
        }
        let name = name.or(of_mesh).unwrap_or_else(usual);
        self.draft(mesh, name, children, notes)
    }

    /// Returns the uses of instances.
    fn instances(
        &mut self,
        node: usize,
        child: usize,
        maps: Vec<DAffine3>,
        notes: &mut Notes,
    ) -> Result<Vec<DraftUse>> {
        let place = || format!("nodes[{node}].extensions.EXT_mesh_gpu_instancing");
        let count = maps.len();
        let mut uses = Vec::new();
        for parent_from_child in maps {
            self.check_size(&parent_from_child, place)?;
            if is_singular(&parent_from_child) {
                notes.add(SINGULAR, place);
            } else {
                uses.push(DraftUse { child, parent_from_child });
            }
        }
        self.uses += count;
        self.check(format!("nodes[{node}]"))?;
        Ok(uses)
    }

    /// Returns the draft of nodes of the same content, which has the name and the uses of the first of these in the file.
    fn draft(
        &mut self,
        mesh: Option<usize>,
        name: String,
        uses: Vec<DraftUse>,
        notes: &mut Notes,
    ) -> Result<Option<usize>> {
        let content = NodeContent::new(mesh, &uses);
        if let Some(&known) = self.known.get(&content) {
            // Nodes are met from the last to the first.
            (self.drafts[known].name, self.drafts[known].uses) = (name, uses);
            return Ok(Some(known));
        }
        let primitives = match mesh {
            Some(mesh) => self.meshes.primitives(mesh, notes)?,
            None => Vec::new(),
        };
        if primitives.is_empty() && uses.is_empty() {
            return Ok(None);
        }
        let corners = primitives.iter().map(|primitive| primitive.shape.corners());
        self.corners = corners.fold(self.corners, u64::saturating_add);
        self.check(mesh.map_or_else(String::new, |mesh| format!("meshes[{mesh}]")))?;
        self.known.insert(content, self.drafts.len());
        self.drafts.push(Draft { name, primitives, uses });
        Ok(Some(self.drafts.len() - 1))
    }

    /// Refuses transforms that bring points beyond all sizes.
    fn check_size(&self, map: &DAffine3, place: impl Fn() -> String) -> Result<()> {
        if is_within_numbers(map) {
            return Ok(());
        }
        Err(self.meshes.source.error(&place(), "a transform with numbers beyond 1e15"))
    }

    /// Refuses too much of anything, before it takes all memory.
    fn check(&self, place: String) -> Result<()> {
        let found = match () {
            () if self.uses > MOST_USES => format!("more than {MOST_USES} instances"),
            () if self.corners > MOST_CORNERS => format!("more than {MOST_CORNERS} corners"),
            () => return Ok(()),
        };
        Err(Error::input(self.meshes.source.path, place, found + ", of the plant up to here", COARSER))
    }
}

const SINGULAR: &str = "a use is left out, because its transform is singular";
