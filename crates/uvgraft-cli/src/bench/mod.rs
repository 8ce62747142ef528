//! `uvgraft bench`: the cost of each stage of a transfer on this machine.

mod copy;
#[cfg(feature = "gpu")]
mod gpu;
mod measure;
mod painting;
mod report;
mod stage;
mod workload;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use indicatif::ProgressBar;
use uvgraft::{Choice, Direction, Filter, Pair, Size};
#[cfg(feature = "gpu")]
use uvgraft_gpu::Adapters;
use uvgraft_io::pair_file;

use crate::choice::choice;
use crate::failure::{OrBadInput, bad_input};
use crate::number::whole_number;
use crate::outcome;
use crate::progress;
use crate::report::parse_size;
use copy::CopyRate;
pub(crate) use measure::time;
use report::{Report, Row};
use stage::{Stage, StageKind};
use workload::Workload;

/// Benchmark each stage of a transfer on this machine
///
/// Textures are generated: 8-bit RGB with detail down to single texels. Their PNG files are held in
/// memory or in a temporary folder. Each round runs every stage once, so that other load on the
/// machine affects all stages alike; the first round is a warm-up.
///
/// The last column compares a stage with memory bandwidth: the time to copy as many bytes as the
/// stage must read and write, as a share of the stage's own time.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Pair file that links the two meshes
    pair: PathBuf,
    /// Texture size in the source layout
    #[arg(long, default_value = "2048", value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true)]
    source_size: Size,
    /// Texture sizes in the target layout, comma-separated
    #[arg(long, visible_alias = "target-size", default_value = "4096", value_name = "N|WxH,...")]
    #[arg(value_delimiter = ',', value_parser = parse_size, allow_negative_numbers = true)]
    size: Vec<Size>,
    /// Transfer from the target layout to the source layout
    #[arg(long)]
    reverse: bool,
    /// Benchmark both directions
    #[arg(long, conflicts_with = "reverse")]
    both: bool,
    /// Interpolation filters to benchmark, comma-separated [default: all but nearest]
    #[arg(long, value_parser = choice::<Filter>(), value_delimiter = ',', value_name = "FILTER,...")]
    filter: Vec<Filter>,
    /// Stages to benchmark, comma-separated [default: all]
    #[arg(
        long,
        value_parser = choice::<StageKind>(),
        value_delimiter = ',',
        value_name = "STAGE,...",
        hide_default_value = true
    )]
    #[arg(default_values = StageKind::ALL.iter().map(|kind| kind.name()))]
    stage: Vec<StageKind>,
    /// Also benchmark a graphics processor; with `any`, a driver that runs on the CPU will do
    #[cfg(feature = "gpu")]
    #[arg(long, value_name = "ADAPTER", num_args = 0..=1, require_equals = true)]
    #[arg(value_parser = choice::<Adapters>(), default_missing_value = Adapters::Hardware.name())]
    gpu: Option<Adapters>,
    /// Number of timed rounds
    #[arg(long, default_value_t = 5, value_name = "N")]
    #[arg(value_parser = whole_number::<u32>(1..=1000), allow_negative_numbers = true)]
    runs: u32,
}

impl Args {
    fn directions(&self) -> &'static [Direction] {
        match (self.reverse, self.both) {
            (_, true) => &[Direction::Forward, Direction::Reverse],
            (true, false) => &[Direction::Reverse],
            (false, false) => &[Direction::Forward],
        }
    }

    /// Filters from fastest to slowest, without duplicates.
    fn filters(&self) -> Vec<Filter> {
        let wanted = |filter: &Filter| match self.filter[..] {
            [] => *filter != Filter::Nearest,
            ref filters => filters.contains(filter),
        };
        Filter::ALL.into_iter().filter(wanted).collect()
    }

    /// Whether any stage depends on the filter.
    fn is_filtered(&self) -> bool {
        #[cfg(feature = "gpu")]
        if self.gpu.is_some() {
            return true;
        }
        self.stage.iter().any(|kind| kind.is_filtered())
    }

    fn has(&self, kind: StageKind) -> bool {
        self.stage.contains(&kind)
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if !args.filter.is_empty() && !args.is_filtered() {
        return Err(bad_input("--filter means nothing to the stages given by --stage"));
    }
    let pair = pair_file::read(&args.pair).or_bad_input()?.pair;
    #[cfg(feature = "gpu")]
    let gpu = args.gpu.and_then(gpu::open);
    let copy = CopyRate::measured(args.runs);
    let cases = args.size.len() * args.directions().len();
    let progress = match cases {
        1 => ProgressBar::hidden(),
        cases => progress::bar(cases as u64, "{bar:32} {pos}/{len} {eta:>4} {wide_msg}"),
    };
    let mut rows = Vec::new();
    for &size in &args.size {
        for &direction in args.directions() {
            progress.set_message(format!("{size}, {direction:?}"));
            rows.extend(rows_of(
                args,
                &pair,
                direction,
                size,
                copy,
                #[cfg(feature = "gpu")]
                gpu.as_ref(),
            )?);
            progress.inc(1);
        }
    }
    progress.finish_and_clear();
    let report = Report::new(args.pair.display().to_string(), args.runs, copy, rows);
    outcome::report(|| &report, || report.markdown())?;
    Ok(ExitCode::SUCCESS)
}

/// Measures one direction at one size.
fn rows_of(
    args: &Args,
    pair: &Arc<Pair>,
    direction: Direction,
    size: Size,
    copy: CopyRate,
    #[cfg(feature = "gpu")] gpu: Option<&uvgraft_gpu::Gpu>,
) -> anyhow::Result<Vec<Row>> {
    let (from, to) = match direction {
        Direction::Forward => (args.source_size, size),
        Direction::Reverse => (size, args.source_size),
    };
    let workload = Workload::new(&args.pair, pair, direction, from, to)?;
    let mut stages: Vec<Stage<'_>> = Vec::new();
    for kind in StageKind::IN_ORDER.into_iter().filter(|kind| args.has(*kind)) {
        stages.extend(workload.stages(kind, &args.filters())?);
    }
    #[cfg(feature = "gpu")]
    if let Some(gpu) = gpu {
        stages.extend(workload.gpu_stages(gpu, &args.filters())?);
    }
    let times = measure::rounds(&mut stages, args.runs)?;
    let rows = stages.iter().zip(times);
    Ok(rows.map(|(stage, times)| Row::new(&workload, stage, times, copy)).collect())
}
