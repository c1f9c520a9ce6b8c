//! The layers of a site's photos: built, decided about, filled, brought up to date, and read as textures.
//!
//! | module | what it does |
//! |---|---|
//! | `inputs`, `faces_to_keep`, `layer_names`, `untextured`, `unsatisfied`, `linked`, `far_backdrops`, `layer_table`, `layer_report` | what a stack is made of, and what it says |
//! | `paint`, `depths`, `projected_paint`, `layer_pixels`, `layer_textures`, `origins` | the texels of layers with filling and paint |
//! | `survey`, `assemble`, `sources` | stacks as the site has them |
//! | `shelf`, `gains`, `relief`, `agreement`, `surroundings`, `dome_report` | estimates of the whole site, kept in `cache/` |
//! | `fill`, `turns`, `masks`, `status` | fillings, and masks that are found like them |
//! | `decide`, `build`, `update`, `tiny_site` | what a user asks for |

pub mod agreement;
pub mod assemble;
pub mod build;
pub mod decide;
pub mod depths;
pub mod dome_report;
pub mod faces_to_keep;
pub mod far_backdrops;
pub mod fill;
pub mod gains;
pub mod inputs;
pub mod layer_names;
pub mod layer_pixels;
pub mod layer_report;
pub mod layer_table;
pub mod layer_textures;
pub mod linked;
pub mod masks;
pub mod origins;
pub mod paint;
pub mod projected_paint;
pub mod relief;
mod shelf;
pub mod sources;
pub mod status;
pub mod surroundings;
pub mod survey;
pub mod tiny_site;
pub mod turns;
pub mod unsatisfied;
pub mod untextured;
pub mod update;
