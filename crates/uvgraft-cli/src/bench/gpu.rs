//! Stages on a graphics processor.

use uvgraft::Filter;
use uvgraft_gpu::{Adapters, Gpu};

use super::measure::time;
use super::stage::{Measured, Stage, Variant};
use super::workload::{TEXEL, Workload, stage};
use crate::failure::{note, warn};

/// Opens a graphics processor; without one, says so, and the CPU alone is measured.
pub(super) fn open(adapters: Adapters) -> Option<Gpu> {
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
            stages.push(self.gpu_round_trip(gpu, filter)?);
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
        Ok(self.on_gpu(Measured::Gpu, filter, work))
    }

    fn gpu_round_trip(&self, gpu: &Gpu, filter: Filter) -> anyhow::Result<Stage<'_>> {
        let transfer = gpu.transfer(&self.graft(filter)?)?;
        let work = move || {
            let (result, seconds) = time(|| transfer.apply_texture(&self.source, &self.base));
            let _ = result?;
            Ok(seconds)
        };
        Ok(self.on_gpu(Measured::GpuRoundTrip, filter, work))
    }

    fn on_gpu<'s>(
        &'s self,
        measured: Measured,
        filter: Filter,
        work: impl FnMut() -> anyhow::Result<f64> + 's,
    ) -> Stage<'s> {
        let moved = (self.read + self.filled) * TEXEL;
        stage(measured, Some(Variant::Filter(filter)), self.filled, moved, work)
    }
}
