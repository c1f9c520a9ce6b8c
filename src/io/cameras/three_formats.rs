//! One scene in three formats.
