//! A transfer as plain numbers, for kernels that run elsewhere, such as on a graphics processor.

use std::sync::Arc;

use crate::color::Encoding;
use crate::content::Content;
use crate::filter::Filter;
use crate::formats::{Averaging, Formats};
#[cfg(doc)]
use crate::graft::Graft;
#[cfg(doc)]
use crate::resampler::Overlap;
use crate::resampler::Resampler;
use crate::texture::{Sizes, TexelFormat, Texture};

pub use crate::resample::footprint::PlannedFootprint;

/// The texels that a transfer fills, where each reads in the source, and which source texels are
/// padded first; from [`Graft::plan`].
///
/// Positions are 32.32 fixed point, in units of 2⁻³² source texels from the top left corner, so that
/// their sums depend on no order. [`resample::reference`](crate::resample::reference) says what
/// becomes of them.
#[derive(Debug, Clone)]
pub struct Plan {
    pub(crate) resampler: Arc<Resampler>,
    pub(crate) averaging: Averaging,
    pub(crate) content: Content,
}

/// Consecutive texels of a row of the target whose source positions are equally spaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlannedRun {
    /// Column and row of the first texel in the target.
    pub texel: [u32; 2],
    /// Number of texels.
    pub len: u32,
    /// Index of the samples of each texel among [`Plan::footprints`].
    pub footprint: u32,
    /// Source position (x, y) of the centre of the first texel.
    pub start: [i64; 2],
    /// Offset from the source position of a texel to that of the next.
    pub step: [i64; 2],
}

/// A texel of the source that takes the value of another one before anything is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlannedCopy {
    /// Row-major index of the texel that is read. It is never one that is written.
    pub from: u32,
    /// Row-major index of the texel that is written.
    pub to: u32,
}

/// Why a transfer is more than what a [`Plan`] describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// It blends the result into the base.
    #[error("a transfer with a blend is more than sampling")]
    Blend,
    /// It rotates normals.
    #[error("a transfer of normals is more than sampling")]
    Normals,
    /// Islands of the target overlap, and [`Overlap::Average`] averages their values.
    #[error("a transfer that averages overlapping islands samples twice")]
    Average,
}

impl Plan {
    /// The sizes of textures and bases.
    pub fn sizes(&self) -> Sizes {
        Sizes { from: self.resampler.source_size(), to: self.resampler.map().size() }
    }

    /// The interpolation filter.
    pub fn filter(&self) -> Filter {
        self.resampler.filter()
    }

    /// The runs of all texels that are filled, in row-major order.
    ///
    /// Sums of a run's position, steps and offsets of samples never overflow: texels that read
    /// beyond 2³⁰ texels have a run of their own, with a position at that distance and no step.
    pub fn runs(&self) -> impl Iterator<Item = PlannedRun> {
        let (map, paths) = (self.resampler.map(), self.resampler.paths());
        (0..map.size().height).flat_map(move |row| {
            map.row(row).iter().flat_map(move |&run| {
                let walk = paths.walk(row, run);
                let (parts, len) = if walk.is_far() { (run.len, 1) } else { (1, run.len) };
                (0..parts).map(move |k| PlannedRun {
                    texel: [run.x + k, row],
                    len,
                    footprint: if walk.samples() == [1, 1] { 0 } else { run.patch + 1 },
                    start: walk.centre(k).map(|at| at.clamp(-FAR, FAR)),
                    step: if walk.is_far() { [0, 0] } else { walk.step() },
                })
            })
        })
    }

    /// The footprints of runs. The first is that of a single sample.
    pub fn footprints(&self) -> impl Iterator<Item = PlannedFootprint> {
        let (patches, paths) = (self.resampler.map().patches().len(), self.resampler.paths());
        let single = PlannedFootprint { samples: [1, 1], first: [0, 0], steps: [[0, 0]; 2] };
        (0..=patches).map(move |index| match index.checked_sub(1) {
            Some(patch) => paths.footprint(patch),
            None => single,
        })
    }

    /// The source texels to be padded.
    pub fn copies(&self) -> Vec<PlannedCopy> {
        let mut copies = Vec::new();
        self.resampler.padding().for_each_copy(|to, from| {
            // Textures have 2³⁰ texels at most.
            copies.push(PlannedCopy { from: from as u32, to: to as u32 });
        });
        copies
    }

    /// Converts a texture and a base to the format in which both are processed.
    pub fn working(&self, [texture, base]: [Texture; 2]) -> [Texture; 2] {
        let formats = self.formats(texture.format(), base.format());
        [texture, base].map(|texture| {
            let texture = match self.content {
                Content::Color => texture,
                Content::Data | Content::Normals(_) => texture.with_encoding(Encoding::Data),
            };
            formats.working(texture)
        })
    }

    /// Converts a result to the format of the results of a texture and a base.
    pub fn restored(&self, result: Texture, [texture, base]: [TexelFormat; 2]) -> Texture {
        self.formats(texture, base).restore(result)
    }

    fn formats(&self, texture: TexelFormat, base: TexelFormat) -> Formats {
        let encoding = match self.content {
            Content::Color => base.encoding,
            Content::Data | Content::Normals(_) => Encoding::Data,
        };
        Formats::new(texture, TexelFormat { encoding, ..base }, self.averaging)
    }
}

/// 2³⁰ texels.
const FAR: i64 = 1 << 62;

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::Pair;

    use super::*;
    use crate::Graft;
    use crate::texture::{Channels, Size, Texels};

    /// A square whose two triangles overlap in the target, and which reads far beyond the source at
    /// one corner.
    fn pair(far: f32) -> Pair {
        let faces = [[0, 1, 2], [0, 2, 3]];
        let mesh = |uv: [[f32; 2]; 4]| {
            Mesh::from_triangles(vec![[0.0; 3]; 4], uv.to_vec(), &faces, &faces).unwrap()
        };
        let source = mesh([[0.2, 0.3], [0.8, 0.2], [0.7, 0.9], [-far, 0.8]]);
        let target = mesh([[0.1, 0.2], [0.9, 0.15], [0.6, 0.9], [0.7, 0.3]]);
        Pair::by_vertex_map(source, target, &[0, 1, 2, 3]).unwrap()
    }

    fn random(size: Size, seed: u64) -> Texture {
        let mut rng = fastrand::Rng::with_seed(seed);
        let values = (0..size.texels() * 3).map(|_| rng.u8(..)).collect();
        Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values)).unwrap()
    }

    /// Takes texels as a plan says.
    fn taken(plan: &Plan, source: &Texture, base: &Texture) -> Vec<u8> {
        let (Texels::U8(source), Texels::U8(base)) = (source.texels(), base.texels()) else {
            unreachable!("both have 8 bits");
        };
        let (mut source, mut values) = (source.clone(), base.clone());
        for copy in plan.copies() {
            let texel = copy.from as usize * 3;
            source.copy_within(texel..texel + 3, copy.to as usize * 3);
        }
        let Sizes { from, to } = plan.sizes();
        let footprints: Vec<PlannedFootprint> = plan.footprints().collect();
        for run in plan.runs() {
            assert_eq!(footprints[run.footprint as usize].samples, [1, 1]);
            for k in 0..run.len {
                let at = |axis: usize, side: u32| {
                    let position = run.start[axis] + run.step[axis] * i64::from(k);
                    (position >> 32).clamp(0, i64::from(side) - 1) as usize
                };
                let texel = at(1, from.height) * from.width as usize + at(0, from.width);
                let [x, y] = run.texel;
                let filled = (y * to.width + x + k) as usize;
                values[filled * 3..][..3].copy_from_slice(&source[texel * 3..][..3]);
            }
        }
        values
    }

    #[test]
    fn what_a_plan_says_is_what_a_graft_does() {
        for (seed, far) in [(1, -0.3), (2, 5.0), (3, 3e9), (4, 1e30)] {
            let sizes = Sizes { from: Size::new(37, 52), to: Size::new(61, 43) };
            let (source, base) = (random(sizes.from, seed), random(sizes.to, seed + 10));
            let graft = Graft::builder(pair(far), sizes)
                .filter(Filter::Nearest)
                .gutter_px(3)
                .build()
                .unwrap();
            let plan = graft.plan().unwrap();
            let result = graft.apply(&source, &base).unwrap();
            assert_eq!(result.texels(), &Texels::U8(taken(&plan, &source, &base)), "{far}");
            assert_ne!(result, base);
        }
    }

    #[test]
    fn footprints_are_those_of_patches() {
        let sizes = Sizes { from: Size::square(400), to: Size::square(40) };
        let plan = Graft::builder(pair(-0.3), sizes).build().unwrap().plan().unwrap();
        let footprints: Vec<PlannedFootprint> = plan.footprints().collect();
        let run = plan.runs().max_by_key(|run| run.len).unwrap();
        let PlannedFootprint { samples, first, steps } = footprints[run.footprint as usize];
        assert!(samples[0] > 3 && samples[1] > 3, "{samples:?}");
        // The samples' centre is the texel's.
        for axis in 0..2 {
            let last = (0..2).map(|k| i64::from(samples[k] - 1) * steps[k][axis]).sum::<i64>();
            assert!((2 * first[axis] + last).abs() < 64, "{first:?} {steps:?}");
        }
    }

    #[test]
    fn what_is_more_than_sampling_has_no_plan() {
        let sizes = Sizes { from: Size::square(64), to: Size::square(64) };
        let builder = || Graft::builder(pair(-0.3), sizes);
        let normals = Content::Normals(crate::NormalOptions::default());
        let blend = builder().blend(crate::BlendOptions::default()).build().unwrap();
        assert_eq!(blend.plan().err(), Some(PlanError::Blend));
        assert_eq!(
            builder().content(normals).build().unwrap().plan().err(),
            Some(PlanError::Normals)
        );
    }
}
