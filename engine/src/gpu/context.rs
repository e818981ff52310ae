//! Choosing an adapter and opening a device on it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use thiserror::Error;

use super::PixelsError;
use super::pipelines::Pipelines;
use crate::plan::ShaderError;
use crate::scene::{Material, SurfaceFunction};

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
    #[error("adapter '{adapter}' lost its device: {reason}; {remedy}")]
    Lost { adapter: String, reason: String, remedy: String },
    #[error("adapter '{adapter}' is out of memory: {message}")]
    OutOfMemory { adapter: String, message: String },
    #[error(transparent)]
    Compose(#[from] ShaderError),
    #[error("shader '{shader}' is not valid: {message}")]
    Shader { shader: String, message: String },
    #[error("shader '{shader}' makes no pipeline on adapter '{adapter}': {message}")]
    Pipeline { shader: String, adapter: String, message: String },
    #[error(
        "material '{material}': adapter '{adapter}' refuses its surface function '{function}': {message}"
    )]
    SurfaceFunction { material: String, function: String, adapter: String, message: String },
    #[error("{what} needs a buffer of {bytes} bytes, adapter '{adapter}' allows {limit} for its use")]
    BufferTooLarge { what: String, bytes: u64, adapter: String, limit: u64 },
    #[error(
        "{what} is a texture of {width}x{height} with {layers} layers, adapter '{adapter}' allows {limit}x{limit} with {limit_layers}"
    )]
    TextureTooLarge {
        what: String,
        width: u32,
        height: u32,
        layers: u32,
        adapter: String,
        limit: u32,
        limit_layers: u32,
    },
    #[error(
        "the frame needs {bytes} bytes of GPU memory, of which {largest} takes {largest_bytes}; the budget is {budget}"
    )]
    Budget { bytes: u64, largest: String, largest_bytes: u64, budget: u64 },
    #[error("image '{image}' is {width}x{height}, adapter '{adapter}' allows {limit}")]
    ImageTooLarge { image: String, width: u32, height: u32, adapter: String, limit: u32 },
    #[error("the scene has {count} lights, a frame can have {limit}")]
    TooManyLights { count: usize, limit: usize },
    #[error(transparent)]
    Pixels(#[from] PixelsError),
}

impl GpuError {
    /// What is wrong with a shader, as an error of the material whose own function is in it.
    pub(super) fn of(self, material: &Material, function: &SurfaceFunction, gpu: &Gpu) -> Self {
        match self {
            Self::Shader { message, .. } | Self::Pipeline { message, .. } => Self::SurfaceFunction {
                material: material.name.clone(),
                function: function.name().into(),
                adapter: gpu.name(),
                message,
            },
            other => other,
        }
    }
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
    /// The formats in which the adapter has targets of four samples.
    pub multisampled: Arc<[wgpu::TextureFormat]>,
    /// The most bytes a frame may have on the GPU; more is refused before anything is allocated.
    pub budget_bytes: u64,
    pipelines: Arc<Mutex<Pipelines>>,
    errors: Arc<Mutex<Vec<wgpu::Error>>>,
    lost: Arc<Mutex<Option<String>>>,
    reopen: Option<Reopen>,
}

/// The budget of a device for which no other was set: most of today's adapters have as much memory.
pub const DEFAULT_BUDGET_BYTES: u64 = 4 << 30;

/// Where another device comes from when one is lost.
type OpenDevice = dyn Fn() -> Result<(wgpu::Device, wgpu::Queue), GpuError> + Send + Sync;

#[derive(Clone)]
struct Reopen(Arc<OpenDevice>);

impl std::fmt::Debug for Reopen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Reopen")
    }
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

fn open_device(choice: &AdapterChoice) -> Result<(wgpu::Device, wgpu::Queue), GpuError> {
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
        hint: "install a Vulkan driver (Debian, Ubuntu: mesa-vulkan-drivers; Fedora: mesa-vulkan-drivers; \
               Arch: vulkan-swrast)"
            .into(),
    })?;
    let info = adapter.get_info();
    let no_device = |reason: String| GpuError::NoDevice { adapter: describe(&info), reason };
    let features = adapter.features() & WANTED;
    let limits = adapter.limits();
    pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("shadowgraph"),
        required_features: features,
        required_limits: limits.clone(),
        ..Default::default()
    }))
    .map_err(|error| no_device(error.to_string()))
}

impl Gpu {
    /// One line for each adapter, best first.
    pub fn list() -> Vec<String> {
        adapters().iter().map(|adapter| describe(&adapter.get_info())).collect()
    }

    /// Opens a device without any window. When it is lost, another is opened by the same choice.
    ///
    /// # Errors
    /// [`GpuError`] names what was asked for and what there is.
    pub fn open(choice: &AdapterChoice) -> Result<Self, GpuError> {
        let (device, queue) = open_device(choice)?;
        let choice = choice.clone();
        Ok(Self::from_device(device, queue).reopened_by(move || open_device(&choice)))
    }

    /// Uses a device that the caller opened. Its uncaptured errors are handled here from now on.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let errors = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&errors);
        // The default handler panics; ours keeps the message until the frame asks for it.
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            sink.lock().unwrap_or_else(PoisonError::into_inner).push(error);
        }));
        let lost = Arc::new(Mutex::new(None));
        let sink = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, message| {
            let reason = format!("{reason:?} {message}").trim().to_owned();
            sink.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(reason);
        });
        let (info, features, limits) = (device.adapter_info(), device.features(), device.limits());
        Self {
            device,
            queue,
            info,
            features,
            limits,
            multisampled: multisampled_formats(features).into(),
            budget_bytes: DEFAULT_BUDGET_BYTES,
            pipelines: Arc::default(),
            errors,
            lost,
            reopen: None,
        }
    }

    /// This device, and how to open another when it is lost.
    #[must_use]
    pub fn reopened_by(
        self,
        open: impl Fn() -> Result<(wgpu::Device, wgpu::Queue), GpuError> + Send + Sync + 'static,
    ) -> Self {
        Self { reopen: Some(Reopen(Arc::new(open))), ..self }
    }

    /// This device with another budget.
    #[must_use]
    pub fn with_budget(self, budget_bytes: u64) -> Self {
        Self { budget_bytes, ..self }
    }

    /// Another device in place of this one, which was lost.
    ///
    /// # Errors
    /// [`GpuError::Lost`] where nothing says how to open another ([`Gpu::reopened_by`]); whatever opening it reports.
    pub fn reopened(&self) -> Result<Self, GpuError> {
        let Some(reopen) = &self.reopen else {
            let reason = self.lost_reason().unwrap_or_else(|| "unknown".into());
            let remedy = "no other can be opened in its place: it was opened elsewhere, and Gpu::reopened_by was \
                          not told how";
            return Err(GpuError::Lost { adapter: self.name(), reason, remedy: remedy.into() });
        };
        let (device, queue) = (reopen.0)()?;
        let gpu = Self::from_device(device, queue).with_budget(self.budget_bytes);
        Ok(Self { reopen: self.reopen.clone(), ..gpu })
    }

    /// Why the device was lost, if it was.
    pub fn lost_reason(&self) -> Option<String> {
        self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The adapter in one line: name, backend, driver.
    pub fn name(&self) -> String {
        describe(&self.info)
    }

    /// The first error since the last call, if any.
    ///
    /// # Errors
    /// [`GpuError::Lost`] for good once the device is; [`GpuError::OutOfMemory`] and [`GpuError::Device`] with the
    /// device's own message.
    pub fn check(&self) -> Result<(), GpuError> {
        // A device reports its loss only while it is polled.
        let polled = self.device.poll(wgpu::PollType::Poll);
        let mut errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
        let first = errors.drain(..).next();
        if let Some(reason) = self.lost_reason() {
            let remedy = "everything on it is gone".into();
            return Err(GpuError::Lost { adapter: self.name(), reason, remedy });
        }
        match (first, polled) {
            (Some(error), _) => Err(self.error(&error)),
            (None, Err(error)) => Err(GpuError::Device { adapter: self.name(), message: error.to_string() }),
            (None, Ok(_)) => Ok(()),
        }
    }

    /// Waits until everything submitted is done.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub fn wait(&self) -> Result<(), GpuError> {
        let polled = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        let failed =
            |error: wgpu::PollError| GpuError::Device { adapter: self.name(), message: error.to_string() };
        polled.map(|_| ()).map_err(failed)
    }

    /// What all that draw on this device share.
    pub(crate) fn pipelines(&self) -> MutexGuard<'_, Pipelines> {
        self.pipelines.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn error(&self, error: &wgpu::Error) -> GpuError {
        let (adapter, message) = (self.name(), error.to_string());
        match error {
            wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory { adapter, message },
            _ => GpuError::Device { adapter, message },
        }
    }

    /// What `work` returns, and the first error of any kind that the device reports meanwhile.
    pub(crate) fn scoped<T>(&self, work: impl FnOnce() -> T) -> (T, Option<wgpu::Error>) {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let [outer, middle, inner] =
            [OutOfMemory, Internal, Validation].map(|filter| self.device.push_error_scope(filter));
        let result = work();
        let errors = [inner, middle, outer].map(|scope| pollster::block_on(scope.pop()));
        (result, errors.into_iter().flatten().next())
    }

    /// What `work` returns, if the device has nothing to say against it.
    ///
    /// # Errors
    /// A lost device first, then what the device reported, then what `work` itself did.
    pub(crate) fn checked<T>(&self, work: impl FnOnce() -> Result<T, GpuError>) -> Result<T, GpuError> {
        let (result, reported) = self.scoped(work);
        self.check()?;
        match reported {
            // What work found has the names in it.
            Some(error) if result.is_ok() => Err(self.error(&error)),
            _ => result,
        }
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

/// The formats in which a device with `features` has targets of four samples.
fn multisampled_formats(features: wgpu::Features) -> Vec<wgpu::TextureFormat> {
    let has_samples = |format: &wgpu::TextureFormat| {
        let flags = format.guaranteed_format_features(features).flags;
        flags.contains(wgpu::TextureFormatFeatureFlags::MULTISAMPLE_X4)
    };
    crate::plan::MULTISAMPLED_EVERYWHERE.iter().copied().filter(has_samples).collect()
}
