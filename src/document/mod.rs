//! What is saved: the authored project and the derived stacks.
