//! The round-trip methods, and their times.

use std::sync::Arc;

use serde::Serialize;
use uvgraft::statistics::median;
use uvgraft::{
    Channels, Depth, Direction, Filter, FitOptions, Graft, GraftError, MapOptions, Pair,
    SamplingMap, Size, Sizes, Texture, TextureError,
};
use uvgraft_metrics::baseline::{affine::Affine, grid};

use crate::bench::time;
use crate::failure::OrBadInput;
use crate::fitting::{FitBar, FitSummary};

/// A method of transferring a texture there and back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Method {
    /// uvgraft, sampled with a filter.
    Sampled(Filter),
    /// uvgraft, fitted there and sampled back with the same filter.
    Fitted(Filter),
    /// The published reference's convention.
    Grid,
    /// A warp per triangle.
    Affine,
}

/// The input of a method.
pub(super) struct RoundTripInput<'a> {
    pub(super) pair: &'a Arc<Pair>,
    /// The direction from the texture's layout to the other.
    pub(super) there: Direction,
    pub(super) texture: &'a Texture,
    pub(super) via: Size,
    pub(super) gutter_px: u32,
    /// Number of timed runs of fast stages.
    pub(super) repeats: u32,
}

/// The result of a round trip.
pub(super) struct RoundTrip {
    /// The texture in the other layout.
    pub(super) via: Texture,
    /// The texture transferred back onto the original.
    pub(super) back: Texture,
    pub(super) times: Times,
    pub(super) fit: Option<FitSummary>,
    pub(super) whole_picture: Option<WholePicture>,
}

/// Times in seconds; medians of repeated runs.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Times {
    /// Both sampling maps, or both lists of triangles.
    pub(super) maps_s: f64,
    /// Other preparation for a pair and its sizes: padding for both directions.
    pub(super) padding_s: Option<f64>,
    /// The transfer to the other layout, including a fit.
    pub(super) there_s: f64,
    /// The transfer back.
    pub(super) back_s: f64,
}

impl Times {
    pub(super) fn total_s(&self) -> f64 {
        self.maps_s + self.padding_s.unwrap_or(0.0) + self.there_s + self.back_s
    }
}

/// Extrapolated time of warping the whole image for each triangle.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct WholePicture {
    /// Number of measured triangles, in both directions.
    pub(super) measured: usize,
    /// Total number of triangles, in both directions.
    pub(super) triangles: usize,
    /// For both directions, without the median filter.
    pub(super) extrapolated_s: f64,
}

impl Method {
    /// Label for tables.
    pub(super) fn title(self) -> String {
        match self {
            Self::Fitted(filter) => format!("{filter}, fitted"),
            _ => self.slug(),
        }
    }

    /// Label for file names.
    pub(super) fn slug(self) -> String {
        match self {
            Self::Sampled(filter) => filter.to_string(),
            Self::Fitted(filter) => format!("{filter}-fitted"),
            Self::Grid => "grid".to_owned(),
            Self::Affine => "affine".to_owned(),
        }
    }

    pub(super) fn run(self, course: &RoundTripInput) -> anyhow::Result<RoundTrip> {
        match self {
            Self::Sampled(filter) => course.sampled(filter),
            Self::Fitted(filter) => course.fitted(filter),
            Self::Grid => course.grid(),
            Self::Affine => course.affine(),
        }
    }
}

/// Both transfers, and the seconds spent on their maps and padding.
struct Prepared {
    there: Graft,
    back: Graft,
    maps_s: f64,
    padding_s: f64,
}

impl RoundTripInput<'_> {
    /// Without a gutter, which would overwrite the original around its islands.
    pub(super) fn map_back(&self) -> SamplingMap {
        self.map(self.there.opposite(), self.texture.size(), 0)
    }

    fn map(&self, direction: Direction, size: Size, gutter_px: u32) -> SamplingMap {
        SamplingMap::new(self.pair, direction, size, &MapOptions::with_gutter(gutter_px))
    }

    /// The base in the other layout.
    fn grey(&self) -> Result<Texture, TextureError> {
        let (encoding, depth) = (self.texture.encoding(), self.texture.depth());
        let channels = self.texture.channels().without_alpha();
        Texture::filled(self.via, channels, encoding, depth, &[0.5; 3][..channels.count()])
    }

    fn sizes(&self, direction: Direction) -> Sizes {
        if direction == self.there {
            Sizes { from: self.texture.size(), to: self.via }
        } else {
            Sizes { from: self.via, to: self.texture.size() }
        }
    }

    fn graft(
        &self,
        direction: Direction,
        filter: Filter,
        gutter_px: u32,
    ) -> Result<Graft, GraftError> {
        Graft::builder(Arc::clone(self.pair), self.sizes(direction))
            .direction(direction)
            .filter(filter)
            .gutter_px(gutter_px)
            .build()
    }

    fn sampled(&self, filter: Filter) -> anyhow::Result<RoundTrip> {
        let prepared = self.prepare(filter)?;
        let grey = self.grey()?;
        let (via, there_s) = self.median_time(
            || (self.texture.clone(), grey.clone()),
            |(texture, grey)| prepared.there.apply(texture, grey),
        );
        self.back_again(&prepared, via?, there_s, None)
    }

    fn fitted(&self, filter: Filter) -> anyhow::Result<RoundTrip> {
        let prepared = self.prepare(filter)?;
        let (texture, grey) = (self.texture.clone(), self.grey()?);
        let bar = FitBar::default();
        let (fitted, there_s) = time(|| {
            let fitted = prepared
                .there
                .fit(texture, grey.format(), &FitOptions::default(), &mut |progress| {
                    bar.show(progress);
                })
                .or_bad_input()?;
            anyhow::Ok((fitted.overlay.lay(0, grey)?, fitted.summary))
        });
        bar.finish();
        let (via, summary) = fitted?;
        self.back_again(&prepared, via, there_s, Some(FitSummary::from(&summary)))
    }

    /// Prepares both transfers, and measures the time.
    fn prepare(&self, filter: Filter) -> anyhow::Result<Prepared> {
        let (_, maps_s) = self.median_time(
            || (),
            |()| (self.map(self.there, self.via, self.gutter_px), self.map_back()),
        );
        let graft = |direction, gutter_px| {
            self.median_time(|| (), |()| self.graft(direction, filter, gutter_px))
        };
        let (there, there_s) = graft(self.there, self.gutter_px);
        let (back, back_s) = graft(self.there.opposite(), 0);
        // Preparing a graft also builds its map.
        let padding_s = (there_s + back_s - maps_s).max(0.0);
        Ok(Prepared { there: there?, back: back?, maps_s, padding_s })
    }

    /// Transfers a texture back.
    fn back_again(
        &self,
        prepared: &Prepared,
        via: Texture,
        there_s: f64,
        fit: Option<FitSummary>,
    ) -> anyhow::Result<RoundTrip> {
        let (result, back_s) = self.median_time(
            || (via.clone(), self.texture.clone()),
            |(via, texture)| prepared.back.apply(via, texture),
        );
        let (maps_s, padding_s) = (prepared.maps_s, Some(prepared.padding_s));
        let times = Times { maps_s, padding_s, there_s, back_s };
        Ok(RoundTrip { via, back: result?, times, fit, whole_picture: None })
    }

    fn grid(&self) -> anyhow::Result<RoundTrip> {
        let ((there, back), maps_s) =
            self.median_time(|| (), |()| (self.map(self.there, self.via, 0), self.map_back()));
        let grey = self.grey()?;
        let (via, there_s) =
            self.median_time(|| grey.clone(), |grey| grid::transfer(&there, self.texture, grey));
        let (result, back_s) = self
            .median_time(|| self.texture.clone(), |texture| grid::transfer(&back, &via, texture));
        let times = Times { maps_s, padding_s: None, there_s, back_s };
        Ok(RoundTrip { via, back: result, times, fit: None, whole_picture: None })
    }

    fn affine(&self) -> anyhow::Result<RoundTrip> {
        let grey = self.grey()?;
        let ((there, back), maps_s) = time(|| {
            (
                Affine::new(self.pair, self.there, self.sizes(self.there)),
                Affine::new(self.pair, self.there.opposite(), self.sizes(self.there.opposite())),
            )
        });
        let (via, there_s) = time(|| there.transfer(self.texture, grey.clone()));
        let (result, back_s) = time(|| back.transfer(&via, self.texture.clone()));
        let times = Times { maps_s, padding_s: None, there_s, back_s };
        let original = self.texture.clone().converted(Channels::Rgb, Depth::U8);
        let costs = [(&there, &original, grey), (&back, &via, original.clone())]
            .map(|(triangles, source, base)| whole_picture(triangles, source, base));
        let whole_picture = WholePicture {
            measured: costs.iter().map(|cost| cost.measured).sum(),
            triangles: costs.iter().map(|cost| cost.triangles).sum(),
            extrapolated_s: costs.iter().map(|cost| cost.extrapolated_s).sum(),
        };
        Ok(RoundTrip { via, back: result, times, fit: None, whole_picture: Some(whole_picture) })
    }

    /// Runs `work` several times on inputs made by `prepare`; returns the last result and the
    /// median time.
    fn median_time<I, T>(&self, prepare: impl Fn() -> I, work: impl Fn(I) -> T) -> (T, f64) {
        let mut input = prepare();
        let mut seconds = Vec::new();
        loop {
            let (result, taken) = time(|| work(input));
            seconds.push(taken);
            if seconds.len() >= self.repeats as usize {
                return (result, median(seconds).unwrap_or_default());
            }
            input = prepare();
        }
    }
}

/// The time of warping the whole image for each triangle, extrapolated from a sample of triangles.
fn whole_picture(triangles: &Affine, source: &Texture, base: Texture) -> WholePicture {
    const SAMPLES: usize = 4;
    let count = triangles.triangles();
    let measured = count.min(SAMPLES);
    // Conversions are not counted.
    let mut base = base.converted(Channels::Rgb, Depth::U8);
    let mut seconds = Vec::new();
    for sample in 0..measured {
        let (result, taken) =
            time(|| triangles.draw_whole_picture(sample * count / measured, source, base));
        base = result;
        seconds.push(taken);
    }
    let mean = seconds.iter().sum::<f64>() / measured.max(1) as f64;
    WholePicture { measured, triangles: count, extrapolated_s: mean * count as f64 }
}
