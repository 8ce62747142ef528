//! Stages on a graphics processor.

use clap::ValueEnum;
use uvgraft::Filter;
use uvgraft_gpu::{Adapters, Gpu};

use super::measure::time;
use super::stage::{Stage, StageKind, Variant};
use super::workload::{TEXEL, Workload, stage};
use crate::failure::{note, warn};

/// Which drivers will do.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum AdapterName {
    /// A graphics processor
    Hardware,
    /// Also a driver that runs on the CPU
    Any,
}

impl AdapterName {
    /// Opens a graphics processor; without one, says so, and the CPU alone is measured.
    pub(super) fn open(self) -> Option<Gpu> {
        let adapters = match self {
            Self::Hardware => Adapters::Hardware,
            Self::Any => Adapters::Any,
        };
        match Gpu::new(adapters) {
            Ok(gpu) => {
                note(format_args!("graphics processor: {}", gpu.name()));
                Some(gpu)
            }
            Err(error) => {
                warn(format_args!("{error}; only the CPU is measured"));
                None
            }
        }
    }
}

impl Workload<'_> {
    /// The stages on a graphics processor, for each filter.
    pub(super) fn gpu_stages(
        &self,
        gpu: &Gpu,
        filters: &[Filter],
    ) -> anyhow::Result<Vec<Stage<'_>>> {
        let mut stages = Vec::new();
        for &filter in filters {
            stages.push(self.gpu_resample(gpu.clone(), filter)?);
            stages.push(self.gpu_carry(gpu, filter)?);
        }
        Ok(stages)
    }

    /// What a user has who shows the result, or carries it on.
    fn gpu_resample(&self, gpu: Gpu, filter: Filter) -> anyhow::Result<Stage<'_>> {
        let transfer = gpu.transfer(&self.graft(filter)?)?;
        let (source, base) = (gpu.upload(&self.source)?, gpu.upload(&self.base)?);
        let work = move || {
            let (applied, seconds) = time(|| {
                let applied = transfer.apply(&source, &base)?;
                gpu.wait().map(|()| applied)
            });
            // What it made is freed after the timing.
            let _ = applied?;
            Ok(seconds)
        };
        Ok(self.on_gpu(StageKind::Gpu, filter, work))
    }

    fn gpu_carry(&self, gpu: &Gpu, filter: Filter) -> anyhow::Result<Stage<'_>> {
        let transfer = gpu.transfer(&self.graft(filter)?)?;
        let work = move || {
            let (carried, seconds) = time(|| transfer.carry(&self.source, &self.base));
            let _ = carried?;
            Ok(seconds)
        };
        Ok(self.on_gpu(StageKind::GpuCarry, filter, work))
    }

    fn on_gpu<'s>(
        &'s self,
        kind: StageKind,
        filter: Filter,
        work: impl FnMut() -> anyhow::Result<f64> + 's,
    ) -> Stage<'s> {
        let moved = (self.read + self.filled) * TEXEL;
        stage(kind, Some(Variant::Filter(filter)), Some(self.filled), Some(moved), work)
    }
}
