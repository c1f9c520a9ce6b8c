//! The passes, one file each, beside their shaders of the same name in `shaders/`.
