//! Views of a project from layered depth images while somebody looks around: the three roles of the published system (Gortler,
//! He & Cohen 1997, section 2).
//!
//! The *controller* chooses the photos that a view needs. The *builder* makes their image on a thread
//! of its own. The *renderer* ([`LiveView`]) draws the image that there is and never waits for another one.

mod billboards;
mod builder;
mod fade;
mod making;
mod request;
mod rows;
mod view;
mod warper;

pub use self::request::{LiveInputs, LiveOptions};
pub use self::view::{LivePicture, LiveStatus, LiveView};
pub use self::warper::WarpOn;
