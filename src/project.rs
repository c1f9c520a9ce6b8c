//! A project is a folder with the decisions about a site (`project.json`) and with what is derived from it.
//!
//! # Create a project and open it
//!
//! ```
//! use quadratura::project::{NewProject, create_project, open};
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let folder = temporary.path();
//! # quadratura::testing::tiny_site(folder)?;
//! let new = NewProject {
//!     photos: folder.join("photos"),
//!     cameras: folder.join("sparse"),
//!     model: folder.join("model.obj"),
//!     ..NewProject::default()
//! };
//! let task = Task::silent();
//! create_project(&folder.join("project"), &new, &task)?;
//!
//! // Any later time:
//! let opened = open(&folder.join("project"), &task)?;
//! opened.problems.errors.iter().for_each(|problem| println!("a photo is left out: {problem}"));
//! // Names may be abbreviated where they remain unambiguous.
//! let chosen = opened.photos_named(&["left".into()])?;
//! assert_eq!(chosen[0].name, "left.png");
//! # Ok(())
//! # }
//! ```
//!
//! # Change options
//!
//! A program that writes holds the project's lock, so that no other one writes at the same time.
//!
//! ```
//! use quadratura::project::{ProjectLock, change_project, read_project};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (folder, _) = quadratura::testing::tiny_project(temporary.path())?;
//! let lock = ProjectLock::take(&folder)?;
//! change_project(&folder, |project| {
//!     let mut project = project?;
//!     project.options.margin = 8; // pixels around each element
//!     Ok(project)
//! })?;
//! drop(lock);
//! assert_eq!(read_project(&folder)?.options.margin, 8);
//! # Ok(())
//! # }
//! ```

#[doc(inline)]
pub use quadratura_document::Project;
#[doc(inline)]
pub use quadratura_files::lock::ProjectLock;
#[doc(inline)]
pub use quadratura_io::project::{change_project, read_project, write_project};
#[doc(inline)]
pub use quadratura_sites::create::{NewProject, create_project};
#[doc(inline)]
pub use quadratura_sites::open::{Opened, OpeningProblems, UnusableMask, open, open_site};
