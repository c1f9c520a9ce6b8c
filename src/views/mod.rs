//! Views of a site: the preview, pictures of a flight, orthophotos, measurements, and how good pictures are.
//!
//! | module | what it does |
//! |---|---|
//! | `picture_file`, `known`, `continuation`, `written_exposure` | what pictures need |
//! | `preview` | a project opened for drawing |
//! | `frame`, `measure` | level, scale, north; lengths and areas |
//! | `render`, `score`, `ortho`, `colour` | what a user asks for |

pub mod colour;
pub mod continuation;
pub mod frame;
pub mod known;
pub mod measure;
pub mod ortho;
pub mod picture_file;
pub mod preview;
pub mod render;
pub mod score;
pub mod written_exposure;
