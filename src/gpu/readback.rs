//! Reading of results from the device.

use std::ops::Range;
use std::sync::mpsc;

use wgpu::{Buffer, BufferUsages, MapMode, PollType};

use super::device::Gpu;
use quadratura_base::error::{Error, Result};

/// Waits for the device and reads words (of 4 bytes) of each buffer: directly where the device allows it,
/// else through a copy.
pub fn read<const N: usize>(gpu: &Gpu, ranges: [(&Buffer, Range<u64>); N]) -> Result<[Vec<u32>; N]> {
    // A mapping has to begin at a multiple of 8 bytes.
    let mapped = ranges.map(|(buffer, words)| {
        let begin = words.start & !1;
        let skip = (words.start - begin) as usize;
        let bytes = 4 * begin..4 * words.end.max(begin + 1);
        (source(gpu, buffer, bytes), skip..skip + (words.end - words.start) as usize)
    });
    let (sender, receiver) = mpsc::channel();
    for ((buffer, bytes), _) in &mapped {
        let sender = sender.clone();
        // The receiver is gone only when another mapping failed before.
        buffer.map_async(MapMode::Read, bytes.clone(), move |result| drop(sender.send(result)));
    }
    wait(gpu)?;
    drop(sender);
    for result in receiver {
        result.map_err(|error| failed(&error))?;
    }
    let mut results = [const { Vec::new() }; N];
    for (result, ((buffer, bytes), words)) in results.iter_mut().zip(mapped) {
        let view = buffer.get_mapped_range(bytes).map_err(|error| failed(&error))?;
        *result = bytemuck::cast_slice(&view)[words].to_vec();
        drop(view);
        buffer.unmap();
    }
    Ok(results)
}

/// Waits for the device and passes the contents of a buffer that can be mapped to `work`.
pub fn mapped<T>(gpu: &Gpu, buffer: &Buffer, work: impl FnOnce(&[u8]) -> T) -> Result<T> {
    let (sender, receiver) = mpsc::channel();
    // The receiver is there until the device has answered.
    buffer.map_async(MapMode::Read, .., move |result| drop(sender.send(result)));
    let waited = wait(gpu).and_then(|()| match receiver.try_iter().find_map(std::result::Result::err) {
        Some(error) => Err(failed(&error)),
        None => Ok(()),
    });
    let result = waited.and_then(|()| {
        let view = buffer.get_mapped_range(..).map_err(|error| failed(&error))?;
        Ok(work(&view))
    });
    buffer.unmap();
    result
}

fn wait(gpu: &Gpu) -> Result<()> {
    let waited = gpu.device.poll(PollType::wait_indefinitely());
    waited.map(drop).map_err(|error| Error::Gpu(format!("waiting for the device: {error}")))
}

fn failed(error: &dyn std::fmt::Display) -> Error {
    Error::Gpu(format!("reading results back: {error}"))
}

/// Returns a buffer that can be mapped, and the range of its bytes: the buffer itself, or a copy of the
/// requested part.
fn source(gpu: &Gpu, buffer: &Buffer, bytes: Range<u64>) -> (Buffer, Range<u64>) {
    if buffer.usage().contains(BufferUsages::MAP_READ) {
        return (buffer.clone(), bytes);
    }
    let size = bytes.end - bytes.start;
    let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size,
        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, bytes.start, &copy, 0, size);
    gpu.queue.submit([encoder.finish()]);
    (copy, 0..size)
}
