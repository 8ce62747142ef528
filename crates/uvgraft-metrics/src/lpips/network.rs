//! Layer structure of the two networks whose features are compared.
//!
//! Source: torchvision's AlexNet ("One weird trick", Krizhevsky 2014) and VGG16 (Simonyan and
//! Zisserman 2015, configuration D), truncated after the last ReLU that LPIPS uses.

use std::fmt;

use uvgraft::{Choice, choices};

/// The network whose features LPIPS compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LpipsNetwork {
    /// AlexNet: fast, and recommended by the authors of LPIPS for measuring.
    Alex,
    /// VGG16: some twenty times the cost.
    Vgg,
}

choices!(LpipsNetwork {
    Alex => "alex", "AlexNet, recommended for measuring";
    Vgg => "vgg", "VGG16, some twenty times the cost";
});

impl LpipsNetwork {
    /// Both networks.
    pub const ALL: [Self; 2] = [Self::Alex, Self::Vgg];

    /// The shapes of the convolution kernels: height, width, inputs, outputs.
    pub fn kernel_shapes(self) -> Vec<[usize; 4]> {
        let shape = |layer: &Layer| match layer.kind {
            LayerKind::Convolution { inputs, outputs } => {
                Some([layer.window.side, layer.window.side, inputs, outputs])
            }
            LayerKind::Pool => None,
        };
        self.layers().iter().filter_map(shape).collect()
    }

    /// The number of channels of each of the five compared feature maps.
    pub fn compared_channels(self) -> Vec<usize> {
        let compared = self.layers().iter().filter(|layer| layer.compared);
        compared.map(|layer| layer.channels_after(0)).collect()
    }

    /// The shortest side of a picture, in texels, for which every layer has an output.
    pub const fn least_side(self) -> u32 {
        match self {
            Self::Alex => 31,
            Self::Vgg => 16,
        }
    }

    /// The layers, from first to last.
    pub(super) const fn layers(self) -> &'static [Layer] {
        match self {
            Self::Alex => &ALEX,
            Self::Vgg => &VGG,
        }
    }
}

impl fmt::Display for LpipsNetwork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One step of a network.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layer {
    pub(super) kind: LayerKind,
    pub(super) window: Window,
    /// Whether its output is one of the compared feature maps.
    pub(super) compared: bool,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum LayerKind {
    /// A convolution with bias, followed by a ReLU.
    Convolution { inputs: usize, outputs: usize },
    /// Max pooling.
    Pool,
}

/// The window of a layer along either axis: each output texel reads `side` input texels,
/// starting `stride` texels after those of the previous one. `padding` zeros are added on each
/// side of the map.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub(super) side: usize,
    pub(super) stride: usize,
    pub(super) padding: usize,
}

impl Window {
    /// Number of outputs for `length` inputs.
    pub(super) const fn outputs(self, length: usize) -> usize {
        match (length + 2 * self.padding).checked_sub(self.side) {
            Some(rest) => rest / self.stride + 1,
            None => 0,
        }
    }
}

impl Layer {
    pub(super) const fn convolution(
        inputs: usize,
        outputs: usize,
        [side, stride, padding]: [usize; 3],
    ) -> Self {
        let kind = LayerKind::Convolution { inputs, outputs };
        Self { kind, window: Window { side, stride, padding }, compared: false }
    }

    pub(super) const fn pool(side: usize, stride: usize) -> Self {
        Self { kind: LayerKind::Pool, window: Window { side, stride, padding: 0 }, compared: false }
    }

    pub(super) const fn compared(mut self) -> Self {
        self.compared = true;
        self
    }

    pub(super) const fn channels_after(&self, before: usize) -> usize {
        match self.kind {
            LayerKind::Convolution { outputs, .. } => outputs,
            LayerKind::Pool => before,
        }
    }
}

static ALEX: [Layer; 7] = [
    Layer::convolution(3, 64, [11, 4, 2]).compared(),
    Layer::pool(3, 2),
    Layer::convolution(64, 192, [5, 1, 2]).compared(),
    Layer::pool(3, 2),
    Layer::convolution(192, 384, [3, 1, 1]).compared(),
    Layer::convolution(384, 256, [3, 1, 1]).compared(),
    Layer::convolution(256, 256, [3, 1, 1]).compared(),
];

const SAME: [usize; 3] = [3, 1, 1];

static VGG: [Layer; 17] = [
    Layer::convolution(3, 64, SAME),
    Layer::convolution(64, 64, SAME).compared(),
    Layer::pool(2, 2),
    Layer::convolution(64, 128, SAME),
    Layer::convolution(128, 128, SAME).compared(),
    Layer::pool(2, 2),
    Layer::convolution(128, 256, SAME),
    Layer::convolution(256, 256, SAME),
    Layer::convolution(256, 256, SAME).compared(),
    Layer::pool(2, 2),
    Layer::convolution(256, 512, SAME),
    Layer::convolution(512, 512, SAME),
    Layer::convolution(512, 512, SAME).compared(),
    Layer::pool(2, 2),
    Layer::convolution(512, 512, SAME),
    Layer::convolution(512, 512, SAME),
    Layer::convolution(512, 512, SAME).compared(),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_side_is_minimal() {
        for network in LpipsNetwork::ALL {
            let last = |side: usize| {
                network.layers().iter().fold(side, |side, layer| match side {
                    0 => 0,
                    side => layer.window.outputs(side),
                })
            };
            let least = network.least_side() as usize;
            assert_eq!((last(least - 1), last(least)), (0, 1), "{network}");
        }
    }

    #[test]
    fn layer_shapes_are_consistent() {
        for network in LpipsNetwork::ALL {
            let mut channels = 3;
            for [_, _, inputs, outputs] in network.kernel_shapes() {
                assert_eq!(inputs, channels);
                channels = outputs;
            }
            assert_eq!(network.compared_channels().len(), 5);
        }
        // Sides of torchvision's feature maps for a 224² picture.
        let sides = |network: LpipsNetwork| {
            let sides = network.layers().iter().scan(224, |side, layer| {
                *side = layer.window.outputs(*side);
                Some((*side, layer.compared))
            });
            sides.filter(|(_, compared)| *compared).map(|(side, _)| side).collect::<Vec<_>>()
        };
        assert_eq!(sides(LpipsNetwork::Alex), [55, 27, 13, 13, 13]);
        assert_eq!(sides(LpipsNetwork::Vgg), [224, 112, 56, 28, 14]);
    }
}
