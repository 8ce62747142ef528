//! The report of a benchmark, as Markdown and JSON.

use std::fmt::Write as _;

use serde::Serialize;
use uvgraft::{Direction, Size};

use super::copy::CopyRate;
use super::measure::Times;
use super::stage::{Measured, Stage, Variant};
use super::workload::Workload;
use crate::table::{Align, table};

/// The whole report.
#[derive(Serialize)]
pub(super) struct Report {
    /// Whether this is an optimised build.
    optimised: bool,
    os: &'static str,
    arch: &'static str,
    /// The name of the processor, if the system provides it.
    cpu: Option<String>,
    threads: usize,
    runs: u32,
    pair: String,
    copy: CopyRate,
    stages: Vec<Row>,
}

/// One stage for one direction and size.
#[derive(Serialize)]
pub(super) struct Row {
    stage: Measured,
    /// The filter, or the input image.
    #[serde(rename = "with")]
    variant: Option<Variant>,
    direction: Direction,
    /// Size of the source texture.
    from: Size,
    /// Size of the result.
    to: Size,
    #[serde(flatten)]
    times: Times,
    /// Unit of the throughput below: covered texels for `map` and `resample`, otherwise all texels.
    texels: Option<usize>,
    megatexels_per_second: Option<f64>,
    /// Bytes of texels and files to be read or written, each once.
    moved_bytes: Option<usize>,
    /// Time to copy as many bytes of memory.
    copy_ms: Option<f64>,
    /// `copy_ms` over the median.
    share_of_copy: Option<f64>,
}

impl Row {
    pub(super) fn new(
        workload: &Workload,
        stage: &Stage<'_>,
        times: Times,
        copy: CopyRate,
    ) -> Self {
        let copy_ms = stage.moved_bytes.map(|bytes| copy.ms(bytes));
        // The difference of two times may come out as zero.
        let per_ms = |amount: f64| (times.median_ms > 0.0).then(|| amount / times.median_ms);
        Self {
            stage: stage.measured,
            variant: stage.variant,
            direction: workload.direction,
            from: workload.from,
            to: workload.to,
            texels: stage.texels,
            megatexels_per_second: stage.texels.and_then(|count| per_ms(count as f64 / 1e3)),
            moved_bytes: stage.moved_bytes,
            copy_ms,
            share_of_copy: copy_ms.and_then(per_ms),
            times,
        }
    }

    fn title(&self) -> String {
        let title = self.stage.title();
        match self.variant {
            Some(variant) => format!("{title}, {}", variant.name()),
            None => title.to_owned(),
        }
    }

    fn cells(&self, threads: usize) -> Vec<String> {
        let number = |value: Option<f64>, digits| {
            value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"))
        };
        let Times { median_ms, min_ms, max_ms, .. } = &self.times;
        vec![
            self.title(),
            format!("{} → {}", self.from, self.to),
            threads.to_string(),
            format!("{} ({}–{})", ms(*median_ms), ms(*min_ms), ms(*max_ms)),
            number(self.megatexels_per_second, 1),
            self.share_of_copy
                .map_or_else(|| "–".to_owned(), |share| format!("{:.1} %", share * 1e2)),
        ]
    }
}

impl Report {
    pub(super) fn new(pair: String, runs: u32, copy: CopyRate, stages: Vec<Row>) -> Self {
        Self {
            optimised: !cfg!(debug_assertions),
            os: std::env::consts::OS,
            arch: std::env::consts::ARCH,
            cpu: cpu_name(),
            threads: rayon::current_num_threads(),
            runs,
            pair,
            copy,
            stages,
        }
    }

    pub(super) fn markdown(&self) -> String {
        let threads = if self.threads == 1 { "thread" } else { "threads" };
        let mut text = format!(
            "uvgraft {} on {}, {} {threads}, {}, medians of {}\n",
            env!("CARGO_PKG_VERSION"),
            self.cpu.as_deref().unwrap_or(self.arch),
            self.threads,
            self.pair,
            self.runs,
        );
        if !self.optimised {
            text.push_str("debug build: a release build is faster\n");
        }
        let _ = writeln!(
            text,
            "memory copy: {:.1} GB/s, read plus written\n",
            self.copy.gigabytes_per_second()
        );
        let head = ["stage", "size", "threads", "ms (min–max)", "Mtexel/s", "of memory copy"];
        let mut rows = vec![head.map(str::to_owned).to_vec()];
        rows.extend(self.stages.iter().map(|row| row.cells(self.threads)));
        text + &table(&rows, &[Align::Left, Align::Left])
    }
}

/// Milliseconds with about three significant digits.
fn ms(ms: f64) -> String {
    let digits = match ms {
        ms if ms < 1.0 => 3,
        ms if ms < 10.0 => 2,
        ms if ms < 100.0 => 1,
        _ => 0,
    };
    format!("{ms:.digits$}")
}

/// The processor's name on Linux.
fn cpu_name() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("model name"))?;
    let name = line.trim_start().strip_prefix(':')?.trim();
    (!name.is_empty()).then(|| name.to_owned())
}
