//! The runs of a transfer on the device, in bands that fit a binding.

use bytemuck::{Pod, Zeroable};
use uvgraft::plan::{Plan, PlannedFootprint, PlannedRun};
use wgpu::{Buffer, BufferUsages};

use crate::Gpu;

/// Texels that share an entry of [`Band::blocks`].
const BLOCK: u32 = 64;

/// Maximum number of texels in a band: what 32 bits and all devices' numbers of workgroups allow.
const MAX_TEXELS: u32 = 1 << 28;

/// Some runs of a map, for one call of the kernel.
#[derive(Debug)]
pub(crate) struct Band {
    /// Number of texels.
    pub texels: u32,
    /// For every block of texels, the run that contains the first of them.
    pub blocks: Buffer,
    pub runs: Buffer,
    pub footprints: Buffer,
}

/// As in the kernel.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Run {
    first: u32,
    texel: u32,
    footprint: u32,
    unused: u32,
    start: [i64; 2],
    step: [i64; 2],
}

/// As in the kernel.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Footprint {
    samples: [u32; 2],
    first: [i64; 2],
    steps: [[i64; 2]; 2],
}

impl From<PlannedFootprint> for Footprint {
    fn from(PlannedFootprint { samples, first, steps }: PlannedFootprint) -> Self {
        Self { samples, first, steps }
    }
}

/// A band that is being filled.
#[derive(Default)]
struct Open {
    texels: u32,
    blocks: Vec<u32>,
    runs: Vec<Run>,
    footprints: Vec<Footprint>,
}

impl Band {
    /// Divides a plan into bands.
    pub fn all(gpu: &Gpu, plan: &Plan) -> Vec<Self> {
        let known: Vec<Footprint> = plan.footprints().map(Footprint::from).collect();
        // A run brings one footprint at most; one record more ends a band.
        let max =
            (gpu.limits.binding as usize / size_of::<Run>().max(size_of::<Footprint>()) - 1).max(1);
        let mut bands = Vec::new();
        let mut open = Open::default();
        // For each footprint, the band that holds it and its index there.
        let mut held = vec![(u32::MAX, 0); known.len()];
        for run in plan.runs() {
            if open.runs.len() == max || open.texels + run.len > MAX_TEXELS {
                bands.push(std::mem::take(&mut open).close(gpu));
            }
            let (band, index) = &mut held[run.footprint as usize];
            if *band as usize != bands.len() {
                (*band, *index) = (bands.len() as u32, open.footprints.len() as u32);
                open.footprints.push(known[run.footprint as usize]);
            }
            open.add(run, *index);
        }
        if !open.runs.is_empty() {
            bands.push(open.close(gpu));
        }
        bands
    }
}

impl Open {
    fn add(&mut self, run: PlannedRun, footprint: u32) {
        let PlannedRun { texel: [x, y], len, start, step, .. } = run;
        let (first, index) = (self.texels, self.runs.len() as u32);
        // Sides have 16 bits at most.
        self.runs.push(Run { first, texel: x | y << 16, footprint, unused: 0, start, step });
        self.texels += len;
        let blocks = self.texels.div_ceil(BLOCK) as usize;
        self.blocks.resize(blocks, index);
    }

    fn close(mut self, gpu: &Gpu) -> Band {
        self.runs.push(Run { first: self.texels, ..Run::zeroed() });
        Band {
            texels: self.texels,
            blocks: gpu.constants(&self.blocks, BufferUsages::STORAGE),
            runs: gpu.constants(&self.runs, BufferUsages::STORAGE),
            footprints: gpu.constants(&self.footprints, BufferUsages::STORAGE),
        }
    }
}
