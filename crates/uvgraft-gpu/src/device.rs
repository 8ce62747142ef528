//! The connection to a graphics processor.

use std::sync::{Arc, Mutex, PoisonError};

use wgpu::util::{BufferInitDescriptor, DeviceExt};

use crate::GpuError;

/// Maximum size of a binding: what all devices allow.
const MAX_BINDING: u64 = 128 << 20;

/// Maximum logarithm of the side of a tile: what all devices allow.
const MAX_TILE_BITS: u32 = 13;

/// Which adapters may be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Adapters {
    /// Graphics processors only.
    #[default]
    Hardware,
    /// Also drivers that run on the CPU, such as Mesa's lavapipe: for tests, since they are slower than
    /// this program is without them.
    Any,
}

uvgraft::choices!(Adapters {
    Hardware => "hardware", "Graphics processors only";
    Any => "any", "Also drivers that run on the CPU, which are slow";
});

/// A graphics processor that is ready for use. Clones share it.
#[derive(Debug, Clone)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    name: Arc<str>,
    /// The first error that has not been reported yet.
    failure: Arc<Mutex<Option<GpuError>>>,
    pub(crate) limits: Limits,
}

/// What the device allows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Maximum size of a binding in bytes.
    pub binding: u64,
    /// Logarithm of the side of a texture's tiles.
    pub tile_bits: u32,
    /// Maximum number of tiles of a texture.
    pub tiles: u32,
    /// Maximum number of workgroups on one axis.
    pub groups: u32,
}

impl Limits {
    fn new(limits: &wgpu::Limits) -> Self {
        Self {
            binding: limits
                .max_storage_buffer_binding_size
                .min(limits.max_buffer_size)
                .min(MAX_BINDING),
            tile_bits: limits.max_texture_dimension_2d.ilog2().min(MAX_TILE_BITS),
            tiles: limits.max_texture_array_layers,
            groups: limits.max_compute_workgroups_per_dimension,
        }
    }
}

/// Where the first failure of a device will be.
fn first_failure(device: &wgpu::Device) -> Arc<Mutex<Option<GpuError>>> {
    let failure = Arc::new(Mutex::new(None));
    let first = |failure: &Mutex<Option<GpuError>>, error: GpuError| {
        failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    };
    let uncaptured = Arc::clone(&failure);
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        let error = match error {
            wgpu::Error::OutOfMemory { .. } => GpuError::Memory,
            error => GpuError::Device(error.to_string()),
        };
        first(&uncaptured, error);
    }));
    let lost = Arc::clone(&failure);
    device.set_device_lost_callback(move |reason, message| {
        if reason != wgpu::DeviceLostReason::Destroyed {
            first(&lost, GpuError::Device(format!("the device was lost: {message}")));
        }
    });
    failure
}

impl Gpu {
    /// Opens the fastest adapter.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] if there is none, [`GpuError::NoDevice`] if it cannot be used.
    #[cfg(not(target_family = "wasm"))]
    pub fn new(adapters: Adapters) -> Result<Self, GpuError> {
        pollster::block_on(Self::request(adapters))
    }

    /// As [`Gpu::new`], for browsers, where nothing may block.
    ///
    /// # Errors
    /// As [`Gpu::new`].
    pub async fn request(adapters: Adapters) -> Result<Self, GpuError> {
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                ..Default::default()
            })
            .await
            .map_err(|error| GpuError::NoAdapter(error.to_string()))?;
        let info = adapter.get_info();
        if info.device_type == wgpu::DeviceType::Cpu && adapters == Adapters::Hardware {
            return Err(GpuError::NoAdapter(format!("only {}, which runs on the CPU", info.name)));
        }
        let no_device = |reason: String| GpuError::NoDevice { adapter: info.name.clone(), reason };
        let capabilities = adapter.get_downlevel_capabilities();
        if !capabilities.flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
            return Err(no_device("it has no compute shaders".to_owned()));
        }
        let limits = adapter.limits();
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("uvgraft"),
                required_limits: limits.clone(),
                ..Default::default()
            })
            .await
            .map_err(|error| no_device(error.to_string()))?;
        let (failure, limits) = (first_failure(&device), Limits::new(&limits));
        Ok(Self { name: info.name.as_str().into(), failure, limits, device, queue })
    }

    /// The adapter's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Waits until the device has done everything that was submitted.
    ///
    /// # Errors
    /// [`GpuError::Device`] or [`GpuError::Memory`] if anything failed since the last check.
    #[cfg(not(target_family = "wasm"))]
    pub fn wait(&self) -> Result<(), GpuError> {
        let polled = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        polled.map(drop).map_err(|error| GpuError::Device(error.to_string()))
    }

    /// Reports the first failure since the last check.
    pub(crate) fn check(&self) -> Result<(), GpuError> {
        match self.failure.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// A buffer that kernels read.
    pub(crate) fn constants<T: bytemuck::Pod>(
        &self,
        values: &[T],
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        let contents = bytemuck::cast_slice(values);
        self.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
    }

    /// Numbers of workgroups for a number of invocations.
    pub(crate) fn groups(&self, invocations: u32) -> [u32; 2] {
        let groups = invocations.div_ceil(crate::kernels::GROUP);
        let rows = groups.div_ceil(self.limits.groups).max(1);
        [groups.div_ceil(rows), rows]
    }
}
