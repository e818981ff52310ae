//! Choosing an adapter and opening a device on it.

use std::sync::{Arc, Mutex, PoisonError};

use thiserror::Error;

use super::PixelsError;

/// Which adapter to use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The fastest kind there is: discrete, then integrated, then virtual, then software.
    #[default]
    Auto,
    /// The first whose name or backend contains this text, whatever the case.
    Named(String),
}

/// Why there is no device, or why it failed.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum GpuError {
    #[error("no graphics adapter: {hint}")]
    NoAdapter { hint: String },
    #[error("no adapter is called '{wanted}' (there are: {available})")]
    NoSuchAdapter { wanted: String, available: String },
    #[error("adapter '{adapter}' gives no device: {reason}")]
    NoDevice { adapter: String, reason: String },
    #[error("adapter '{adapter}' reported: {message}")]
    Device { adapter: String, message: String },
    #[error("mesh '{mesh}' needs a buffer of {bytes} bytes, adapter '{adapter}' allows {limit}")]
    BufferTooLarge { mesh: String, bytes: u64, adapter: String, limit: u64 },
    #[error("image '{image}' is {width}x{height}, adapter '{adapter}' allows {limit}")]
    ImageTooLarge { image: String, width: u32, height: u32, adapter: String, limit: u32 },
    #[error("the scene has {count} lights, a frame can have {limit}")]
    TooManyLights { count: usize, limit: usize },
    #[error(transparent)]
    Pixels(#[from] PixelsError),
}

/// A device, its queue and what is known of its adapter.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Its adapter.
    pub info: wgpu::AdapterInfo,
    /// The features the device was opened with.
    pub features: wgpu::Features,
    /// The limits the device was opened with.
    pub limits: wgpu::Limits,
    errors: Arc<Mutex<Vec<String>>>,
}

/// Features that are used where the adapter has them.
const WANTED: wgpu::Features = wgpu::Features::TIMESTAMP_QUERY
    .union(wgpu::Features::DEPTH32FLOAT_STENCIL8)
    .union(wgpu::Features::DEPTH_CLIP_CONTROL)
    .union(wgpu::Features::FLOAT32_BLENDABLE)
    .union(wgpu::Features::FLOAT32_FILTERABLE);

/// Software adapters last; the Vulkan face of an adapter before its others.
fn rank(info: &wgpu::AdapterInfo) -> (u8, u8) {
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    (kind, u8::from(info.backend != wgpu::Backend::Vulkan))
}

fn adapters() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.flags = wgpu::InstanceFlags::empty().with_env();
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
    adapters
}

fn describe(info: &wgpu::AdapterInfo) -> String {
    let driver = format!("{} {}", info.driver, info.driver_info);
    format!("{} ({:?}, {})", info.name, info.backend, driver.trim())
}

impl Gpu {
    /// One line for each adapter, best first.
    pub fn list() -> Vec<String> {
        adapters().iter().map(|adapter| describe(&adapter.get_info())).collect()
    }

    /// Opens a device without any window.
    ///
    /// # Errors
    /// [`GpuError`] names what was asked for and what there is.
    pub fn open(choice: &AdapterChoice) -> Result<Self, GpuError> {
        let adapters = adapters();
        let names: Vec<String> = adapters.iter().map(|adapter| describe(&adapter.get_info())).collect();
        let chosen = match choice {
            AdapterChoice::Auto => 0,
            AdapterChoice::Named(wanted) => {
                let wanted_lower = wanted.to_lowercase();
                let found = names.iter().position(|name| name.to_lowercase().contains(&wanted_lower));
                found.ok_or_else(|| GpuError::NoSuchAdapter {
                    wanted: wanted.clone(),
                    available: if names.is_empty() { "none".into() } else { names.join("; ") },
                })?
            }
        };
        let adapter = adapters.into_iter().nth(chosen).ok_or_else(|| GpuError::NoAdapter {
            hint:
                "install a Vulkan driver (Debian, Ubuntu: mesa-vulkan-drivers; Fedora: mesa-vulkan-drivers; \
                   Arch: vulkan-swrast)"
                    .into(),
        })?;
        let info = adapter.get_info();
        let no_device = |reason: String| GpuError::NoDevice { adapter: describe(&info), reason };
        let features = adapter.features() & WANTED;
        if !features.contains(wgpu::Features::DEPTH32FLOAT_STENCIL8) {
            return Err(no_device(
                "it lacks DEPTH32FLOAT_STENCIL8, the depth format of shadow volumes".into(),
            ));
        }
        let limits = adapter.limits();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("shadowgraph"),
            required_features: features,
            required_limits: limits.clone(),
            ..Default::default()
        }))
        .map_err(|error| no_device(error.to_string()))?;
        Ok(Self::from_device(device, queue))
    }

    /// Uses a device that somebody else opened. Its uncaptured errors are handled here from now on.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let errors = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&errors);
        // The default handler panics; ours keeps the message until the frame asks for it.
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            sink.lock().unwrap_or_else(PoisonError::into_inner).push(error.to_string());
        }));
        let sink = Arc::clone(&errors);
        device.set_device_lost_callback(move |reason, message| {
            sink.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(format!("device lost ({reason:?}): {message}"));
        });
        let (info, features, limits) = (device.adapter_info(), device.features(), device.limits());
        Self { device, queue, info, features, limits, errors }
    }

    /// The adapter in one line: name, backend, driver.
    pub fn name(&self) -> String {
        describe(&self.info)
    }

    /// Whether the adapter computes on the CPU: its absolute times say nothing about GPUs.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// The first error since the last call, if any.
    ///
    /// # Errors
    /// [`GpuError::Device`] with the device's own message.
    pub fn check(&self) -> Result<(), GpuError> {
        let mut errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
        match errors.drain(..).next() {
            None => Ok(()),
            Some(message) => Err(GpuError::Device { adapter: self.name(), message }),
        }
    }

    /// Waits until everything submitted is done.
    ///
    /// # Errors
    /// [`GpuError::Device`] when the device was lost or has failed.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| GpuError::Device { adapter: self.name(), message: error.to_string() })?;
        self.check()
    }

    /// A buffer with `contents`, padded to a whole number of words; never empty.
    pub(crate) fn buffer(&self, label: &str, usage: wgpu::BufferUsages, contents: &[u8]) -> wgpu::Buffer {
        let size = (contents.len() as u64).next_multiple_of(4).max(16);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        if contents.len().is_multiple_of(4) {
            self.queue.write_buffer(&buffer, 0, contents);
        } else {
            let mut padded = contents.to_vec();
            padded.resize(contents.len().next_multiple_of(4), 0);
            self.queue.write_buffer(&buffer, 0, &padded);
        }
        buffer
    }
}
