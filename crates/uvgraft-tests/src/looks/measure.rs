//! Measures of how good a transfer looks.

use std::fmt;
use std::sync::Arc;

use uvgraft::blend::CutMesh;
use uvgraft::color::delta_e;
use uvgraft::{
    Channels, Content, Depth, Encoding, Filter, Graft, Pair, Size, Sizes, Texture, color,
};
use uvgraft_metrics::seams::{self, Offset, SeamOptions};

use super::{BodyFrame, Color, Label, Labels, LayoutSpots, mean_color};

/// Texels closer than this to another label are ignored, since filters blur across the edge.
const MARGIN_PX: u32 = 2;
/// Distance from the boundary at which colours are taken on both sides, in metres.
const RIM_OFFSET_M: f64 = 0.003;

/// A pair, with what is known about its target.
#[derive(Debug, Clone)]
pub struct Bench {
    pair: Arc<Pair>,
    /// Layout of the target.
    layout: LayoutSpots,
    /// `[texels]`, whether the pair's links reach a texel of the target.
    transferred: Vec<bool>,
    areas: Areas,
}

/// Areas of a body, in its layout.
#[derive(Debug, Clone)]
struct Areas {
    cheeks: Vec<bool>,
    chest: Vec<bool>,
    hands: Vec<bool>,
    feet: Vec<bool>,
}

/// A result and everything it is judged by. Textures are in the target's layout, at the bench's
/// size.
#[derive(Debug, Clone, Copy)]
pub struct Case<'a> {
    /// True labels of the transferred face, from [`Bench::transfer`]; `None` if unknown.
    pub face: Option<&'a Labels>,
    /// True labels of the body; `None` if it is all skin outside the transferred face.
    pub body: Option<&'a Labels>,
    /// The body before the transfer.
    pub base: &'a Texture,
    /// The face laid over it without blending.
    pub paste: &'a Texture,
    /// The texture that is judged.
    pub result: &'a Texture,
    /// The transferred region, cut along its boundary.
    pub region: &'a CutMesh,
}

/// Statistics of the differences over many texels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// The median.
    pub median: f64,
    /// The mean.
    pub mean: f64,
    /// The 95th percentile.
    pub p95: f64,
}

/// Results of [`Bench::measure`]; differences are CIEDE2000, `None` where no texel qualifies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Between the mean colours of cheeks and chest, in the result.
    pub cheek_to_chest: Option<f64>,
    /// The same in the body before the transfer.
    pub own_cheek_to_chest: Option<f64>,
    /// Hair in the result against the plain paste.
    pub hair: Option<Shift>,
    /// The same for brows.
    pub brow: Option<Shift>,
    /// The same for eyes.
    pub eye: Option<Shift>,
    /// The same for teeth and the inside of the mouth.
    pub mouth: Option<Shift>,
    /// Cloth outside the transferred area, in the result against the body.
    pub cloth: Option<Shift>,
    /// Skin outside the transferred area, in the result against the body: the effect of a tone.
    pub skin: Option<Shift>,
    /// Hands in the result against the body's hands with the chest's gains applied.
    pub hands: Option<f64>,
    /// The same for feet.
    pub feet: Option<f64>,
    /// Share of transferred skin texels with a channel at its maximum that is below it in the plain
    /// paste.
    pub clipped_high: Option<f64>,
    /// The same for channels at 0.
    pub clipped_low: Option<f64>,
    /// The same for channels within ten levels of the maximum: washed out, even if not clipped.
    pub washed_out: Option<f64>,
    /// Median step across the region's boundary.
    pub rim: Option<f64>,
    /// The same in the body before the transfer.
    pub own_rim: Option<f64>,
}

/// Agreement of labels with the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    /// Intersection over union of cloth; `None` if neither has any.
    pub cloth_iou: Option<f64>,
    /// Share of true skin that is labelled as cloth or [`Label::Other`].
    pub lost_skin: f64,
}

impl Bench {
    /// Prepares a pair whose target has the landmarks of `frame`.
    ///
    /// # Panics
    /// If the pair links nothing.
    pub fn new(pair: Arc<Pair>, frame: &BodyFrame, size: Size) -> Self {
        let layout = LayoutSpots::new(pair.target(), size);
        let mask = nearest(&pair, size, size).mask();
        let transferred = texels(&mask).map(|[value, ..]| value > 0.5).collect();
        let areas = Areas::new(&layout, frame);
        Self { pair, layout, transferred, areas }
    }

    /// Layout of the target.
    pub fn layout(&self) -> &LayoutSpots {
        &self.layout
    }

    /// A face's labels, transferred to the target's layout; [`Label::Other`] where nothing is transferred.
    pub fn transfer(&self, face: &Labels) -> Labels {
        let size = self.layout.size();
        let graft = nearest(&self.pair, face.size, size);
        let blank = Texture::filled(size, Channels::Grey, Encoding::Data, Depth::U8, &[0.0]);
        let blank = blank.expect("a size that the layout has");
        let transferred = graft.apply(face.texture(), blank).expect("textures of these sizes");
        let mut labels = Labels::from_texture(&transferred);
        // The gutter belongs to no label.
        for (label, &is_transferred) in labels.of_texels.iter_mut().zip(&self.transferred) {
            if !is_transferred {
                *label = Label::Other;
            }
        }
        labels
    }

    /// Measures a result: differences over the texels of one label, away from its edges, between
    /// the result and the plain paste inside the transferred area, and between the result and the body
    /// outside.
    ///
    /// # Panics
    /// If a texture is not of the bench's size.
    pub fn measure(&self, case: &Case<'_>) -> Figures {
        let [base, paste, result] = [case.base, case.paste, case.result].map(|texture| {
            assert_eq!(texture.size(), self.layout.size(), "textures of the bench's size");
            texels(texture).collect::<Vec<_>>()
        });
        let count = base.len();
        let is = |labels: Option<&Labels>, at: usize, label: Label| {
            labels.is_none_or(|labels| labels.of_texels[at] == label)
        };
        // Labels come from the face within the region, and from the body outside.
        let shows_skin = |at: usize| {
            is(if self.transferred[at] { case.face } else { case.body }, at, Label::Skin)
        };
        let own_skin = |at: usize| is(case.body, at, Label::Skin);
        let contrast = |texture: &[Color], is_skin: &dyn Fn(usize) -> bool| {
            let mean = |area: &[bool]| {
                mean_color((0..count).filter(|&at| area[at] && is_skin(at)).map(|at| texture[at]))
            };
            Some(delta_e(mean(&self.areas.cheeks)?, mean(&self.areas.chest)?))
        };
        let shift = |a: &[Color], b: &[Color], chosen: &dyn Fn(usize) -> bool| {
            Shift::of((0..count).filter(|&at| chosen(at)).map(|at| delta_e(a[at], b[at])).collect())
        };
        let transferred_shift = |label: Label| {
            // Mouths are only a few texels wide in body layouts.
            let margin = if label == Label::Mouth { 0 } else { MARGIN_PX };
            let inside = case.face?.well_inside(label, margin);
            shift(&result, &paste, &|at| inside[at])
        };
        let inside_cloth = case.body.map(|body| body.well_inside(Label::Cloth, MARGIN_PX));
        let clipped = |is_clipped: &dyn Fn(f32) -> bool| {
            let skin: Vec<usize> = (0..count)
                .filter(|&at| self.transferred[at] && is(case.face, at, Label::Skin))
                .collect();
            let lost = skin.iter().filter(|&&at| {
                (0..3).any(|k| is_clipped(result[at][k]) && !is_clipped(paste[at][k]))
            });
            (!skin.is_empty()).then(|| lost.count() as f64 / skin.len() as f64)
        };
        let follow = |area: &[bool]| self.follows(&base, &result, area, &own_skin);
        let rim = |texture: &Texture| {
            let options = SeamOptions::default().offset(Offset::Distance(RIM_OFFSET_M)).worst(0);
            let CutMesh { mesh, inside } = case.region;
            let report = seams::measure(mesh, texture, inside, &options).ok()?;
            report.rim.delta_e.map(|steps| steps.median)
        };
        Figures {
            cheek_to_chest: contrast(&result, &shows_skin),
            own_cheek_to_chest: contrast(&base, &own_skin),
            hair: transferred_shift(Label::Hair),
            brow: transferred_shift(Label::Brow),
            eye: transferred_shift(Label::Eye),
            mouth: transferred_shift(Label::Mouth),
            cloth: inside_cloth.and_then(|inside| {
                shift(&result, &base, &|at| inside[at] && !self.transferred[at])
            }),
            skin: shift(&result, &base, &|at| {
                self.layout.spots()[at].is_some() && !self.transferred[at] && own_skin(at)
            }),
            hands: follow(&self.areas.hands),
            feet: follow(&self.areas.feet),
            clipped_high: clipped(&|value| value >= 254.5 / 255.0),
            clipped_low: clipped(&|value| value <= 0.5 / 255.0),
            washed_out: clipped(&|value| value >= 244.5 / 255.0),
            rim: rim(case.result),
            own_rim: rim(case.base),
        }
    }

    /// Difference of an area's mean colour from the prediction by the chest's gains in linear
    /// light.
    fn follows(
        &self,
        base: &[Color],
        result: &[Color],
        area: &[bool],
        is_skin: &dyn Fn(usize) -> bool,
    ) -> Option<f64> {
        let mean = |texture: &[Color], area: &[bool]| -> Option<[f64; 3]> {
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for at in (0..area.len()).filter(|&at| area[at] && is_skin(at) && !self.transferred[at])
            {
                let light = texture[at].map(|value| f64::from(color::linear_from_srgb(value)));
                sum = [0, 1, 2].map(|k| sum[k] + light[k]);
                count += 1.0;
            }
            (count > 0.0).then(|| sum.map(|value| value / count))
        };
        let (before, after) = (mean(base, &self.areas.chest)?, mean(result, &self.areas.chest)?);
        let (area_before, area_after) = (mean(base, area)?, mean(result, area)?);
        let wanted = [0, 1, 2].map(|k| area_before[k] * after[k] / before[k].max(1e-6));
        let encoded = |light: [f64; 3]| light.map(|value| color::srgb_from_linear(value as f32));
        Some(delta_e(encoded(wanted), encoded(area_after)))
    }
}

impl Areas {
    fn new(layout: &LayoutSpots, frame: &BodyFrame) -> Self {
        let [nose_y, _] = frame.head.nose;
        let [half, low, high] = frame.chest;
        let ankle = frame.heights[3];
        let area = |is_in: &dyn Fn([f32; 3]) -> bool| -> Vec<bool> {
            let local = |spot: &super::Spot| frame.head.local(spot.position);
            layout
                .spots()
                .iter()
                .map(|spot| spot.as_ref().is_some_and(|s| is_in(local(s))))
                .collect()
        };

        Self {
            cheeks: area(&|[x, y, z]| {
                (2.2..5.6).contains(&x.abs()) && (-2.6..1.9).contains(&(y - nose_y)) && z > -3.0
            }),
            chest: area(&|[x, y, z]| x.abs() < half && (low..high).contains(&y) && z > -8.0),
            hands: area(&|p| frame.along_arm(p).is_some_and(|along| along > 1.05)),
            feet: area(&|p| p[1] < ankle - 1.0),
        }
    }
}

fn nearest(pair: &Arc<Pair>, from: Size, to: Size) -> Graft {
    let builder = Graft::builder(Arc::clone(pair), Sizes { from, to });
    let graft = builder.filter(Filter::Nearest).content(Content::Data).build();
    graft.expect("sizes that textures have")
}

/// Red, green and blue of all texels; the first channel in place of each if there is no colour.
fn texels(texture: &Texture) -> impl Iterator<Item = Color> + '_ {
    let Size { width, height } = texture.size();
    let channels = if texture.channels().has_color() { [0, 1, 2] } else { [0; 3] };
    (0..height).flat_map(move |y| (0..width).map(move |x| channels.map(|k| texture.get(x, y, k))))
}

impl Shift {
    fn of(mut values: Vec<f64>) -> Option<Self> {
        if values.is_empty() {
            return None;
        }
        values.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        Some(Self { median: at(0.5), mean, p95: at(0.95) })
    }
}

/// Labels found by the library, in the classes and at the size of the truth.
pub fn labels_like(truth: &Labels, found: &uvgraft::Labels) -> Labels {
    let (to, from) = (truth.size, found.size());
    let at = |index: usize| {
        let (x, y) = (index as u32 % to.width, index as u32 / to.width);
        let place = |at: u32, to: u32, from: u32| {
            (((f64::from(at) + 0.5) * f64::from(from) / f64::from(to)) as u32).min(from - 1)
        };
        let (x, y) = (place(x, to.width, from.width), place(y, to.height, from.height));
        let most = uvgraft::Label::ALL
            .into_iter()
            .max_by(|&a, &b| found.weight(a, x, y).total_cmp(&found.weight(b, x, y)));
        match most {
            Some(uvgraft::Label::Skin) => Label::Skin,
            Some(uvgraft::Label::Hair) => Label::Hair,
            Some(uvgraft::Label::Brow) => Label::Brow,
            Some(uvgraft::Label::Lip) => Label::Lip,
            Some(uvgraft::Label::Eye) => Label::Eye,
            Some(uvgraft::Label::Mouth) => Label::Mouth,
            Some(uvgraft::Label::Cloth) => Label::Cloth,
            _ => Label::Other,
        }
    };
    Labels { size: to, of_texels: (0..to.texels()).map(at).collect() }
}

/// Agreement of predicted labels with the truth.
///
/// # Panics
/// If they differ in size.
pub fn agreement(predicted: &Labels, truth: &Labels) -> Agreement {
    assert_eq!(predicted.size, truth.size, "labels of one texture");
    let pairs = || predicted.of_texels.iter().copied().zip(truth.of_texels.iter().copied());
    let count = |chosen: &dyn Fn((Label, Label)) -> bool| {
        pairs().filter(|&pair| chosen(pair)).count() as f64
    };
    let both = count(&|(found, wanted)| found == Label::Cloth && wanted == Label::Cloth);
    let either = count(&|(found, wanted)| found == Label::Cloth || wanted == Label::Cloth);
    let skin = count(&|(_, wanted)| wanted == Label::Skin);
    let lost = count(&|(found, wanted)| {
        wanted == Label::Skin && matches!(found, Label::Cloth | Label::Other)
    });
    Agreement {
        cloth_iou: (either > 0.0).then(|| both / either),
        lost_skin: if skin > 0.0 { lost / skin } else { 0.0 },
    }
}

impl Figures {
    /// Column headings for the `Display` output of [`Figures`].
    pub const HEAD: &str = "cheek-chest(own)   hair med/mean   brow    eye  mouth  cloth95   skin  hands   feet  \
                            clip255%   clip0%  washed%    rim(own)";
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |value: Option<f64>, width: usize| match value {
            Some(value) => format!("{value:width$.2}"),
            None => format!("{:>width$}", "–"),
        };
        let median = |shift: Option<Shift>| shift.map(|shift| shift.median);
        let percent = |share: Option<f64>| number(share.map(|share| share * 100.0), 8);
        write!(
            f,
            "{} ({}) {}/{} {} {} {} {} {} {} {} {} {} {} {} ({})",
            number(self.cheek_to_chest, 9),
            number(self.own_cheek_to_chest, 5),
            number(median(self.hair), 8),
            number(self.hair.map(|shift| shift.mean), 5),
            number(median(self.brow), 6),
            number(median(self.eye), 6),
            number(median(self.mouth), 6),
            number(self.cloth.map(|shift| shift.p95), 8),
            number(median(self.skin), 6),
            number(self.hands, 6),
            number(self.feet, 6),
            percent(self.clipped_high),
            percent(self.clipped_low),
            percent(self.washed_out),
            number(self.rim, 6),
            number(self.own_rim, 5),
        )
    }
}
