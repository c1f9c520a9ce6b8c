//! A stack is all image layers of one photo, nearest first, with the files that hold their pixels.
//!
//! # Build stacks and walk one
//!
//! ```
//! use quadratura::project::open;
//! use quadratura::sort::SoftwareRasteriser;
//! use quadratura::stack::{BuildOptions, StackStore, build, read_layer};
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (project, _) = quadratura::testing::tiny_project(temporary.path())?;
//! let task = Task::silent();
//! let opened = open(&project, &task)?;
//! let store = StackStore::new(&project);
//! let options = BuildOptions {
//!     layers: opened.project.options.clone(),
//!     decisions: opened.project.decisions.clone(),
//!     ..BuildOptions::default()
//! };
//! for built in build(&opened.site, &store, &SoftwareRasteriser, &options, &task)? {
//!     // A photo that fails stops no other one.
//!     let stack = built.stack?;
//!     println!("{}: {} image layers", built.photo, stack.image_layers.len());
//! }
//!
//! let stack = store.current("left.png")?.expect("it was just built");
//! let folder = store.folder("left.png");
//! for layer in &stack.image_layers {
//!     // R, G, B, A of 8 bits, in the layer's rectangle of the photo; rows from the top.
//!     let texels = read_layer(&folder.join(&layer.file), layer.rect, layer.rect)?;
//!     let visible = texels.chunks_exact(4).filter(|texel| texel[3] > 0).count() as u64;
//!     assert_eq!(visible, layer.texels_visible);
//!     println!("{}. {}: {visible} of {} texels are visible", layer.order, layer.name, layer.texels_used);
//! }
//! # assert_eq!(stack.image_layers.len(), 2);
//! # Ok(())
//! # }
//! ```
//!
//! # Ask what became of a face
//!
//! ```
//! use quadratura::site::FaceIndex;
//! use quadratura::stack::{FaceInStack, StackStore, face_in_stack};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # use quadratura::stack::LayerIndex;
//! # let temporary = tempfile::tempdir()?;
//! # let (project, _) = quadratura::testing::tiny_stacks(temporary.path())?;
//! let stack = StackStore::new(&project).current("right.png")?.expect("the stacks are built");
//! match face_in_stack(&stack, "wall", FaceIndex(0)) {
//!     FaceInStack::Textured { image_layers, .. } => {
//!         let names: Vec<_> = image_layers.iter().map(|layer| &stack.layer(*layer).name).collect();
//!         println!("it is in {names:?}");
//!         # assert_eq!(image_layers, [LayerIndex(1)]);
//!     }
//!     FaceInStack::Untextured(untextured) => println!("it has no texture: {}", untextured.in_words()),
//!     FaceInStack::Unknown => println!("the stack was made from a model without this face"),
//! }
//! # Ok(())
//! # }
//! ```

#[doc(inline)]
pub use quadratura_document::stack::{
    Element, FacePiece, ImageLayer, LayerFill, PropagationEntry, Stack, StackCamera, StackCounts, StackFill,
    StackPhoto, StackSurface, Support, Untextured, UntexturedReason,
};
#[doc(inline)]
pub use quadratura_io::layer_reader::{read_grey, read_layer, read_mask};
#[doc(inline)]
pub use quadratura_io::stack_store::StackStore;
#[doc(inline)]
pub use quadratura_layers::{ElementIndex, LayerIndex};
#[doc(inline)]
pub use quadratura_stacks::build::{BuildOptions, Built, build};
#[doc(inline)]
pub use quadratura_stacks::survey::{StackState, Survey};
#[doc(inline)]
pub use quadratura_stacks::untextured::{FaceInStack, face_in_stack, untextured};
