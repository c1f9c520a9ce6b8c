//! What was typed, what it means, run.
