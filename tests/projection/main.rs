//! What the renderer's pictures must be: the twin's, the photos' own in their own cameras, whole
//! photos' where nothing is hidden, exact wherever the site lies, and without popping.

#[path = "../common/mod.rs"]
mod common;

mod bench;
mod flights;
mod gpu_twin;
mod impostors;
mod layered;
mod linear;
mod mattes;
mod orthographic;
mod own_camera;
mod patch;
mod peeling;
mod popping;
mod random_scenes;
mod shear;
mod shoot;
