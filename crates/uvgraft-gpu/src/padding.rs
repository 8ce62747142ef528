//! Padding of textures on the device.

use uvgraft::plan::Plan;
use wgpu::{Buffer, BufferUsages};

use crate::kernels::Kernels;
use crate::{DeviceTexture, Gpu};

/// The texels that are padded before a texture is sampled.
#[derive(Debug)]
pub(crate) struct Padding {
    parts: Vec<Part>,
    /// The values of one part.
    values: Buffer,
    width: u32,
}

/// As many copies as fit a binding.
#[derive(Debug)]
struct Part {
    pairs: Buffer,
    count: u32,
}

impl Padding {
    /// `None` if nothing is padded.
    pub fn new(gpu: &Gpu, plan: &Plan) -> Option<Self> {
        const VALUE: usize = size_of::<[u32; 4]>();
        let pairs: Vec<[u32; 2]> = plan.copies().iter().map(|copy| [copy.from, copy.to]).collect();
        let max = gpu.limits.binding as usize / VALUE;
        let longest = pairs.len().min(max);
        let parts: Vec<Part> = pairs
            .chunks(max)
            .map(|pairs| Part {
                pairs: gpu.constants(pairs, BufferUsages::STORAGE),
                count: pairs.len() as u32,
            })
            .collect();
        (!parts.is_empty()).then(|| Self {
            parts,
            values: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: (longest * VALUE) as u64,
                usage: BufferUsages::STORAGE,
                mapped_at_creation: false,
            }),
            width: plan.sizes().from.width,
        })
    }

    /// Copies a texture to another one of its size and format, and pads that.
    pub fn apply(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        kernels: &Kernels,
        texture: &DeviceTexture,
        padded: &DeviceTexture,
    ) {
        padded.copy_from(texture, encoder);
        let (from, to) = (texture.view(), padded.view());
        for part in &self.parts {
            let copies = [texture.tiles.bits, texture.tiles.columns, self.width, part.count];
            let copies = gpu.constants(&copies, BufferUsages::UNIFORM);
            let bindings = [
                copies.as_entire_binding(),
                wgpu::BindingResource::TextureView(&from),
                wgpu::BindingResource::TextureView(&to),
                part.pairs.as_entire_binding(),
                self.values.as_entire_binding(),
            ];
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            kernels.gather.call(gpu, &mut pass, &bindings, part.count);
            kernels.scatter.call(gpu, &mut pass, &bindings, part.count);
        }
    }
}
