//! Decisions about the layers of a photo: faces are merged, split, named, excluded or pinned.
//!
//! A decision names faces and not layers, so it applies to every stack that is built later. [`edited`] is a pure
//! function: it returns another project, or the reason why not.
//!
//! ```
//! use quadratura::edit::{Faces, LayerEdit, decided, edited};
//! use quadratura::project::{open, write_project};
//! use quadratura::stack::StackStore;
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (folder, _) = quadratura::testing::tiny_stacks(temporary.path())?;
//! let opened = open(&folder, &Task::silent())?;
//! let store = StackStore::new(&folder);
//! let stacks: Vec<_> =
//!     opened.site.photos.iter().map(|photo| store.current(&photo.name)).collect::<Result<_, _>>()?;
//! let stacks: Vec<_> = stacks.iter().map(Option::as_ref).collect();
//!
//! let name = LayerEdit::Rename {
//!     photo: "left".into(),
//!     of: vec![Faces::whole("wall")],
//!     name: Some("north wall".into()),
//! };
//! let project = edited(&opened.project, &name, &opened.site, &stacks)?;
//! write_project(&folder, &project)?;
//! for decision in decided(&project.decisions.of("left.png")) {
//!     println!("{}. {}", decision.number, decision.text);
//! }
//!
//! // The box hides the wall: one image layer cannot hold both.
//! let merge = LayerEdit::Merge { photo: "left".into(), of: vec![Faces::whole("wall"), Faces::whole("box")] };
//! let refused = edited(&project, &merge, &opened.site, &stacks);
//! println!("{}", refused.expect_err("the two occlude each other"));
//! # Ok(())
//! # }
//! ```

#[doc(inline)]
pub use quadratura_document::decisions::{Decisions, LayerNaming, PhotoDecisions, PhotoOptions};
#[doc(inline)]
pub use quadratura_layers::Faces;
#[doc(inline)]
pub use quadratura_stacks::decide::{
    DecisionKind, LayerEdit, ListedDecision, decided, edited, faces_named, faces_of_layer,
};
