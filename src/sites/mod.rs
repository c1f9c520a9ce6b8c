//! Tasks on a whole site, without its stacks: find its files, open it, check it, mask photos, suggest a model.
//!
//! | module | what it does |
//! |---|---|
//! | `unknown_name`, `known_names`, `named` | photos and objects by name |
//! | `budget`, `side_by_side`, `shared` | work on several photos at a time, within memory, beside other programs |
//! | `thumbnail`, `dome_picture`, `legend_picture`, `photo_plan`, `site_parts`, `site_stamp`, `impostors`, `see_through`, `objects` | single parts of a site |
//! | `masks`, `photos`, `open` | a site of all its parts |
//! | `check`, `discover`, `views` | what there is, and what is wrong with it |
//! | `create`, `copy`, `relink`, `sample`, `suggest` | projects that are made, copied, mended |

pub mod budget;
pub mod check;
pub mod copy;
pub mod create;
pub mod discover;
pub mod dome_picture;
pub mod impostors;
pub mod known_names;
pub mod legend_picture;
pub mod masks;
pub mod named;
pub mod objects;
pub mod open;
pub mod photo_plan;
pub mod photos;
pub mod relink;
pub mod sample;
pub mod see_through;
pub mod shared;
pub mod side_by_side;
pub mod site_parts;
pub mod site_stamp;
pub mod suggest;
pub mod thumbnail;
pub mod unknown_name;
pub mod views;

#[cfg(test)]
#[path = "../../tests/common/left_out.rs"]
mod left_out;
