//! Transfers on the device.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use uvgraft::plan::Plan;
use uvgraft::{Depth, Filter, Graft, Size, TexelFormat, Texture};
use wgpu::{BindingResource, Buffer, BufferUsages};

use crate::bands::Band;
use crate::kernels::Kernels;
use crate::padding::Padding;
use crate::{DeviceTexture, Gpu, GpuError};

/// A transfer whose map is on the device.
#[derive(Debug)]
pub struct Transfer {
    gpu: Gpu,
    plan: Plan,
    bands: Vec<Band>,
    padding: Option<Padding>,
    /// Lanczos weights, as whole numbers and as floats.
    phases: [Buffer; 2],
    /// What depends on the format of textures, made when one is first used.
    formats: Mutex<HashMap<(Depth, bool), Arc<Format>>>,
}

#[derive(Debug)]
struct Format {
    kernels: Kernels,
    /// Holds the padded texture while it is sampled. What is submitted runs in order, so one is enough.
    padded: Option<DeviceTexture>,
}

impl Gpu {
    /// Copies the map of a transfer to the device.
    ///
    /// # Errors
    /// [`GpuError::Plan`] if the transfer is more than sampling, such as one with a blend;
    /// [`GpuError::Memory`] or [`GpuError::Device`].
    pub fn transfer(&self, graft: &Graft) -> Result<Transfer, GpuError> {
        let plan = graft.plan()?;
        let bands = Band::all(self, &plan);
        let padding = Padding::new(self, &plan);
        let phases = lanczos().map(|phases| self.constants(&phases, BufferUsages::STORAGE));
        self.check()?;
        Ok(Transfer { gpu: self.clone(), plan, bands, padding, phases, formats: Mutex::default() })
    }
}

impl Transfer {
    /// Lays a texture over a base, both on the device; both are kept as they are. The device may
    /// still be at work when this returns.
    ///
    /// # Errors
    /// [`GpuError::Size`] or [`GpuError::Formats`] for textures that do not fit; [`GpuError::Memory`]
    /// or [`GpuError::Device`].
    pub fn apply(
        &self,
        texture: &DeviceTexture,
        base: &DeviceTexture,
    ) -> Result<DeviceTexture, GpuError> {
        let mut results = self.apply_all(&[texture], base)?;
        Ok(results.pop().expect("a result for each texture"))
    }

    /// As [`Transfer::apply`] for several textures, in one submission.
    ///
    /// # Errors
    /// As [`Transfer::apply`].
    pub fn apply_all(
        &self,
        textures: &[&DeviceTexture],
        base: &DeviceTexture,
    ) -> Result<Vec<DeviceTexture>, GpuError> {
        let sizes = self.plan.sizes();
        check_size("base", base.size(), sizes.to)?;
        for texture in textures {
            check_size("texture", texture.size(), sizes.from)?;
            if texture.format() != base.format() {
                return Err(GpuError::Formats { texture: texture.format(), base: base.format() });
            }
        }
        let format = self.format(base)?;
        let device = &self.gpu.device;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut results = Vec::with_capacity(textures.len());
        for texture in textures {
            let result = self.gpu.texture(sizes.to, base.format())?;
            result.copy_from(base, &mut encoder);
            let source = match (&self.padding, &format.padded) {
                (Some(padding), Some(padded)) => {
                    padding.apply(&self.gpu, &mut encoder, &format.kernels, texture, padded);
                    padded
                }
                _ => texture,
            };
            self.sample(&mut encoder, &format.kernels, source, base, &result);
            results.push(result);
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.check()?;
        Ok(results)
    }

    /// Lays a texture over a base as [`Graft::apply`] does: to the device, and back.
    ///
    /// # Errors
    /// As [`Transfer::apply`], except for [`GpuError::Formats`].
    #[cfg(not(target_family = "wasm"))]
    pub fn apply_texture(&self, texture: &Texture, base: &Texture) -> Result<Texture, GpuError> {
        let formats = [texture.format(), base.format()];
        let working = self.plan.working([texture.clone(), base.clone()]);
        let [texture, base] = working.each_ref().map(|texture| self.gpu.upload(texture));
        let result = self.gpu.download(&self.apply(&texture?, &base?)?)?;
        Ok(self.plan.restored(result, formats))
    }

    fn format(&self, base: &DeviceTexture) -> Result<Arc<Format>, GpuError> {
        let TexelFormat { depth, .. } = base.format();
        let mut formats = self.formats.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(format) = formats.get(&(depth, base.has_alpha())) {
            return Ok(Arc::clone(format));
        }
        let padded = match &self.padding {
            Some(_) => Some(self.gpu.texture(self.plan.sizes().from, base.format())?),
            None => None,
        };
        let kernels = Kernels::new(&self.gpu, self.plan.filter(), depth, base.has_alpha());
        self.gpu.check()?;
        let format = Arc::new(Format { kernels, padded });
        formats.insert((depth, base.has_alpha()), Arc::clone(&format));
        Ok(format)
    }

    /// Samples a padded texture into a copy of the base.
    fn sample(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        kernels: &Kernels,
        source: &DeviceTexture,
        base: &DeviceTexture,
        result: &DeviceTexture,
    ) {
        let is_whole = base.format().depth == Depth::U8 && !base.has_alpha();
        let phases = &self.phases[usize::from(!is_whole)];
        let [from, under, to] = [source, base, result].map(DeviceTexture::view);
        let size = source.size();
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        for band in &self.bands {
            let [source, target] = [source.tiles, base.tiles];
            let sizes = [
                size.width,
                size.height,
                source.bits,
                source.columns,
                target.bits,
                target.columns,
                band.texels,
                0,
            ];
            let sizes = self.gpu.constants(&sizes, BufferUsages::UNIFORM);
            let bindings = [
                sizes.as_entire_binding(),
                BindingResource::TextureView(&from),
                BindingResource::TextureView(&under),
                BindingResource::TextureView(&to),
                band.blocks.as_entire_binding(),
                band.runs.as_entire_binding(),
                band.footprints.as_entire_binding(),
                phases.as_entire_binding(),
            ];
            kernels.transfer.call(&self.gpu, &mut pass, &bindings, band.texels);
        }
    }
}

fn check_size(what: &'static str, found: Size, wanted: Size) -> Result<(), GpuError> {
    if found == wanted { Ok(()) } else { Err(GpuError::Size { what, found, wanted }) }
}

/// Lanczos weights at 1025 phases, eight for each: in units of 2⁻¹⁴, and as the bits of floats.
fn lanczos() -> [Vec<i32>; 2] {
    const PHASES: u32 = 1024;
    let [mut whole, mut floats] = [Vec::new(), Vec::new()];
    for phase in 0..=PHASES {
        let weights = Filter::Lanczos3.weights(phase as f32 / PHASES as f32);
        for tap in 0..8 {
            let weight = weights.get(tap).copied().unwrap_or(0.0);
            whole.push((weight * 16_384.0).round_ties_even() as i32);
            floats.push(weight.to_bits().cast_signed());
        }
    }
    [whole, floats]
}
