//! Compiled kernels and their bindings.

use std::fmt::Write;

use uvgraft::{Depth, Filter};
use wgpu::{
    BindGroupLayout, BindGroupLayoutEntry, BindingType, BufferBindingType, ComputePipeline,
    ShaderStages, StorageTextureAccess, TextureSampleType, TextureViewDimension,
};

use crate::Gpu;
use crate::texture::device_format;

/// Invocations of a workgroup.
pub(crate) const GROUP: u32 = 64;

/// The kernels for textures of one format.
#[derive(Debug)]
pub(crate) struct Kernels {
    pub transfer: Kernel,
    pub gather: Kernel,
    pub scatter: Kernel,
}

#[derive(Debug)]
pub(crate) struct Kernel {
    pub layout: BindGroupLayout,
    pub pipeline: ComputePipeline,
}

/// What kernels bind, in the order of their bindings.
#[derive(Clone, Copy)]
enum Binding {
    Uniform,
    Texture,
    Stored,
    Constants,
    Buffer,
}

impl Kernels {
    pub fn new(gpu: &Gpu, filter: Filter, depth: Depth, has_alpha: bool) -> Self {
        use Binding::{Buffer, Constants, Stored, Texture, Uniform};
        let transfer = format!(
            "{}{}{}",
            types(depth),
            constants(filter, depth, has_alpha),
            include_str!("kernels.wgsl")
        );
        let padding = format!("{}{}", types(depth), include_str!("padding.wgsl"));
        let bindings =
            [Uniform, Texture, Texture, Stored, Constants, Constants, Constants, Constants];
        let kernel = |source: &str, name: &str, bindings: &[Binding]| {
            Kernel::new(gpu, source, name, bindings, depth)
        };
        Self {
            transfer: kernel(&transfer, "transfer", &bindings),
            gather: kernel(&padding, "gather", &[Uniform, Texture, Stored, Constants, Buffer]),
            scatter: kernel(&padding, "scatter", &[Uniform, Texture, Stored, Constants, Buffer]),
        }
    }
}

/// The types that stand for a depth.
fn types(depth: Depth) -> String {
    let (scalar, format) = match depth {
        Depth::U8 => ("u32", "rgba8uint"),
        Depth::U16 => ("u32", "rgba16uint"),
        Depth::F32 => ("f32", "rgba32float"),
    };
    format!("alias Scalar = {scalar};\nalias Stored = texture_storage_2d_array<{format}, write>;\n")
}

fn constants(filter: Filter, depth: Depth, has_alpha: bool) -> String {
    let number = Filter::ALL.iter().position(|&other| other == filter).expect("one of all");
    let one = match depth {
        Depth::U8 => 255.0,
        Depth::U16 => 65_535.0,
        Depth::F32 => 1.0,
    };
    let mut text = String::new();
    let is_whole = depth == Depth::U8 && !has_alpha;
    writeln!(
        text,
        "const FILTER = {number}u;\nconst TAPS = {}u;\nconst ALPHA = {has_alpha};\nconst WHOLE = \
         {is_whole};\nconst ONE = f32({one});\nconst FLOATS = {};",
        filter.taps(),
        depth == Depth::F32,
    )
    .expect("strings take everything");
    text
}

impl Kernel {
    fn new(gpu: &Gpu, source: &str, name: &str, bindings: &[Binding], depth: Depth) -> Self {
        let sample_type = match depth {
            Depth::F32 => TextureSampleType::Float { filterable: false },
            _ => TextureSampleType::Uint,
        };
        let buffer =
            |ty| BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let entries: Vec<BindGroupLayoutEntry> = (0..)
            .zip(bindings)
            .map(|(binding, kind)| BindGroupLayoutEntry {
                binding,
                visibility: ShaderStages::COMPUTE,
                ty: match kind {
                    Binding::Uniform => buffer(BufferBindingType::Uniform),
                    Binding::Constants => buffer(BufferBindingType::Storage { read_only: true }),
                    Binding::Buffer => buffer(BufferBindingType::Storage { read_only: false }),
                    Binding::Texture => BindingType::Texture {
                        sample_type,
                        view_dimension: TextureViewDimension::D2Array,
                        multisampled: false,
                    },
                    Binding::Stored => BindingType::StorageTexture {
                        access: StorageTextureAccess::WriteOnly,
                        format: device_format(depth),
                        view_dimension: TextureViewDimension::D2Array,
                    },
                },
                count: None,
            })
            .collect();
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(name),
            entries: &entries,
        });
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &[Some(&layout)],
            ..Default::default()
        });
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(name),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { layout, pipeline }
    }

    /// Adds a call of the kernel for a number of invocations.
    pub fn call(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'_>,
        bindings: &[wgpu::BindingResource<'_>],
        invocations: u32,
    ) {
        let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
            .zip(bindings)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
            .collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.layout,
            entries: &entries,
        });
        let [x, y] = gpu.groups(invocations);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(x, y, 1);
    }
}
