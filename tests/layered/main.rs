//! Layered files there and back: what writers write readers read, what editors write besides is read
//! as well, and what is damaged is an error.

mod documents;
mod memory;
mod mutated;
mod psd_file;
mod psd_parameters;
mod psd_variants;
mod round_trip;
mod xcf_file;
mod xcf_variants;

#[global_allocator]
static ALLOCATOR: memory::Counting = memory::Counting;
