//! The GPU device, and the conversion of its errors to this crate's.

use wgpu::{Adapter, AdapterInfo, Backends, Device, DeviceType, ErrorFilter, Features, Queue};

use quadratura_base::error::{Error, Result};

/// The message for machines without an adapter.
const NO_ADAPTER: &str = "no Vulkan, Metal or DX12 adapter was found; a software adapter is sufficient: on \
    Debian and Ubuntu install the package mesa-vulkan-drivers (`sh examples/setup.sh` does this)";

/// What it takes for shaders to find maxima of words of 64 bits.
const WIDE_ATOMICS: Features = Features::SHADER_INT64.union(Features::SHADER_INT64_ATOMIC_MIN_MAX);

/// A device with its queue. It is passed to the code that draws and never global; clones share both.
#[derive(Debug, Clone)]
pub struct Gpu {
    pub(super) device: Device,
    pub(super) queue: Queue,
    info: AdapterInfo,
    /// Whether shaders may take maxima of words of 64 bits.
    wide_atomics: bool,
}

impl Gpu {
    /// Opens a device without a window: on a hardware adapter where there is one, else on a software adapter.
    /// The environment variable `WGPU_ADAPTER_NAME` selects an adapter by a part of its name.
    ///
    /// # Errors
    /// [`Error::Gpu`] when there is no adapter, none of that name, or the adapter provides no device.
    pub fn headless() -> Result<Self> {
        let backends = Backends::from_env().unwrap_or(Backends::PRIMARY);
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = backends;
        let adapters = pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(backends));
        let adapter = choose(adapters, std::env::var("WGPU_ADAPTER_NAME").ok().as_deref())?;
        Self::open(&adapter)
    }

    /// Wraps an existing device, such as the editor window's. Optional features that it was not created with
    /// (large storage bindings, direct read-back) are not used.
    pub(crate) fn from_device(device: Device, queue: Queue) -> Self {
        let info = device.adapter_info();
        let wide_atomics = device.features().contains(WIDE_ATOMICS);
        Self { device, queue, info, wide_atomics }
    }

    /// Returns a device that validates everything and computes nothing, for tests of pipelines.
    pub fn noop() -> Self {
        let (device, queue) = Device::noop(&wgpu::DeviceDescriptor::default());
        Self::from_device(device, queue)
    }

    /// Describes the adapter on one line: name, kind, interface and driver.
    pub fn adapter_summary(&self) -> String {
        let AdapterInfo { name, device_type, backend, driver, driver_info, .. } = &self.info;
        format!("{name} ({device_type:?}, {backend}, {driver} {driver_info})")
    }

    /// Returns true when the adapter is a software renderer on the CPU.
    pub fn is_software(&self) -> bool {
        self.info.device_type == DeviceType::Cpu
    }

    fn open(adapter: &Adapter) -> Result<Self> {
        // Where the GPU shares the CPU's memory, results can be read without a copy.
        let software = adapter.get_info().device_type == DeviceType::Cpu;
        let wanted = if software { Features::MAPPABLE_PRIMARY_BUFFERS } else { Features::empty() };
        let wanted = wanted | Features::TEXTURE_COMPRESSION_BC | WIDE_ATOMICS;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("quadratura"),
            required_features: adapter.features() & wanted,
            required_limits: adapter.limits(),
            memory_hints: if software {
                wgpu::MemoryHints::MemoryUsage
            } else {
                wgpu::MemoryHints::default()
            },
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.request_device(&descriptor));
        let (device, queue) = opened.map_err(|error| {
            Error::Gpu(format!("the adapter {} gives no device: {error}", adapter.get_info().name))
        })?;
        Ok(Self::from_device(device, queue))
    }

    /// Returns true when storage buffers can be mapped and read without a copy.
    pub(super) fn reads_directly(&self) -> bool {
        self.device.features().contains(Features::MAPPABLE_PRIMARY_BUFFERS)
    }

    /// Returns true when textures can be BC7-compressed.
    pub(super) fn has_compression(&self) -> bool {
        self.device.features().contains(Features::TEXTURE_COMPRESSION_BC)
    }

    /// Returns true when shaders can take maxima of words of 64 bits.
    pub(super) fn has_wide_atomics(&self) -> bool {
        self.wide_atomics
    }

    /// Returns the device as one that has no maxima of words of 64 bits, for tests of what it does then.
    #[cfg(test)]
    pub(super) fn without_wide_atomics(&self) -> Self {
        Self { wide_atomics: false, ..self.clone() }
    }

    /// Returns the number of bytes that one storage binding may hold.
    pub(super) fn largest_binding(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    /// Runs `work` and converts validation and memory errors of the device in it to [`Error::Gpu`]; `doing`
    /// names the work.
    pub(super) fn guarded<T>(&self, doing: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
        let filters = [ErrorFilter::Internal, ErrorFilter::OutOfMemory, ErrorFilter::Validation];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        let result = work();
        let found = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop()));
        // The error of the innermost scope is reported; every scope has to be popped.
        match found.collect::<Vec<_>>().first() {
            Some(error) => Err(Error::Gpu(format!("{doing}: {error}"))),
            None => result,
        }
    }
}

/// Chooses the best adapter, or the best of those whose name contains the user's.
fn choose(mut adapters: Vec<Adapter>, name: Option<&str>) -> Result<Adapter> {
    let names: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
    if let Some(wanted) = name {
        let wanted = wanted.to_lowercase();
        adapters.retain(|a| a.get_info().name.to_lowercase().contains(&wanted));
    }
    adapters.sort_by_key(|a| rank(a.get_info().device_type));
    adapters.into_iter().next().ok_or_else(|| match name {
        Some(wanted) if !names.is_empty() => {
            let names = names.join(", ");
            Error::Gpu(format!("WGPU_ADAPTER_NAME is {wanted:?}, but the adapters are: {names}; unset it"))
        }
        _ => Error::Gpu(NO_ADAPTER.into()),
    })
}

/// Returns the rank of a kind of adapter; smaller is better.
fn rank(device_type: DeviceType) -> u32 {
    match device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_an_adapter_the_message_names_the_package() {
        let message = choose(Vec::new(), None).expect_err("there is none").to_string();
        assert!(
            message.contains("mesa-vulkan-drivers") && message.contains("examples/setup.sh"),
            "{message}"
        );
    }

    #[test]
    fn a_mistake_in_our_use_of_the_device_is_an_error_where_it_arose() {
        let gpu = Gpu::noop();
        let made = gpu.guarded("making a buffer", || {
            let (size, usage) = (!3u64, wgpu::BufferUsages::STORAGE);
            Ok(gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage,
                mapped_at_creation: false,
            }))
        });
        let message = made.expect_err("no device holds that").to_string();
        assert!(message.starts_with("GPU: making a buffer: "), "{message}");
    }
}
