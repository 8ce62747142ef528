use crate::tflite::{Activation, Element, Model, Operator, OperatorKind, Tensor, Values, Window};

use super::*;

fn computed(shape: &[usize]) -> Tensor {
    Tensor { shape: shape.to_vec(), element: Element::F32, constant: None }
}

fn constant(shape: &[usize], values: Vec<f32>) -> Tensor {
    Tensor { shape: shape.to_vec(), element: Element::F32, constant: Some(Values::F32(values)) }
}

fn window(is_same: bool, stride: u32, activation: Activation) -> Window {
    Window { is_same, stride: [stride; 2], dilation: [1; 2], activation }
}

/// A model of one operator whose first tensor is the input and whose second is the output.
fn single(kind: OperatorKind, tensors: Vec<Tensor>) -> Model {
    let constants = (2..tensors.len()).map(Some);
    let inputs = std::iter::once(Some(0)).chain(constants).collect();
    let operators = vec![Operator { kind, inputs, outputs: vec![1] }];
    Model { tensors, operators, inputs: vec![0], outputs: vec![1] }
}

fn run(model: &Model, input: &[f32]) -> Vec<f32> {
    let network = Network::new(model).unwrap();
    let found = network.run(input).unwrap();
    assert_eq!(found, network.run_reference(input).unwrap());
    assert_eq!(network.output_lengths(), [found[0].len()]);
    found.into_iter().next().unwrap()
}

#[test]
fn a_convolution_by_hand() {
    // Three columns, stride 2: two outputs, and half of one row or column of zeros on each side.
    let kernel = constant(&[1, 3, 3, 1], (1..10).map(|value| value as f32).collect());
    let bias = constant(&[1], vec![0.5]);
    let tensors = vec![computed(&[1, 3, 3, 1]), computed(&[1, 2, 2, 1]), kernel, bias];
    let input = [1.0, 0.0, 2.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0];
    let kind = OperatorKind::Convolution(window(true, 2, Activation::None));
    assert_eq!(run(&single(kind, tensors.clone()), &input), [5.5, 10.5, -4.5, 5.5]);
    let kind = OperatorKind::Convolution(window(true, 2, Activation::Relu));
    assert_eq!(run(&single(kind, tensors.clone()), &input), [5.5, 10.5, 0.0, 5.5]);
    let kind = OperatorKind::Convolution(window(true, 2, Activation::ReluSix));
    assert_eq!(run(&single(kind, tensors), &input), [5.5, 6.0, 0.0, 5.5]);
}

#[test]
fn an_even_input_has_its_zeros_below_and_on_the_right() {
    let kernel = constant(&[1, 3, 3, 1], (1..10).map(|value| value as f32).collect());
    let kind = OperatorKind::DepthwiseConvolution {
        window: window(true, 2, Activation::None),
        multiplier: 1,
    };
    let bias = constant(&[1], vec![0.0]);
    let model = single(kind, vec![computed(&[1, 4, 4, 1]), computed(&[1, 2, 2, 1]), kernel, bias]);
    let mut input = [0.0; 16];
    input[0] = 1.0;
    assert_eq!(run(&model, &input), [1.0, 0.0, 0.0, 0.0]);
    input[15] = 1.0;
    assert_eq!(run(&model, &input), [1.0, 0.0, 0.0, 5.0]);
}

#[test]
fn fast_convolutions_have_the_bits_of_the_reference() {
    let mut random = fastrand::Rng::with_seed(3);
    let mut values =
        |count: usize| -> Vec<f32> { (0..count).map(|_| random.f32() * 2.0 - 1.0).collect() };
    // Sizes that leave rests of tiles and panels.
    for (side, from, to, taps, stride) in
        [(9, 3, 16, 3, 2), (7, 5, 3, 1, 1), (6, 4, 9, 2, 2), (5, 17, 20, 1, 1), (8, 2, 8, 5, 1)]
    {
        let out = usize::div_ceil(side, stride as usize);
        let kernel = constant(&[to, taps, taps, from], values(to * taps * taps * from));
        let bias = constant(&[to], values(to));
        let (input, output) = (computed(&[1, side, side, from]), computed(&[1, out, out, to]));
        let window = window(true, stride, Activation::None);
        let kind = OperatorKind::Convolution(window);
        run(&single(kind, vec![input.clone(), output, kernel, bias]), &values(side * side * from));
        let kernel = constant(&[1, taps, taps, from], values(taps * taps * from));
        let kind = OperatorKind::DepthwiseConvolution { window, multiplier: 1 };
        let output = computed(&[1, out, out, from]);
        let bias = constant(&[from], values(from));
        run(&single(kind, vec![input, output, kernel, bias]), &values(side * side * from));
    }
}

#[test]
fn the_other_layers_by_hand() {
    let pool = OperatorKind::MaxPooling { window: window(true, 2, Activation::None), size: [2; 2] };
    let model = single(pool, vec![computed(&[1, 3, 3, 1]), computed(&[1, 2, 2, 1])]);
    assert_eq!(run(&model, &[1., 2., 3., 4., 5., 6., 7., 8., -9.]), [5.0, 6.0, 8.0, -9.0]);

    let slopes = constant(&[1, 1, 2], vec![0.5, 2.0]);
    let model =
        single(OperatorKind::Prelu, vec![computed(&[1, 1, 2, 2]), computed(&[1, 1, 2, 2]), slopes]);
    assert_eq!(run(&model, &[1.0, -1.0, -2.0, 3.0]), [1.0, -2.0, -1.0, 3.0]);

    let padding = Tensor {
        shape: vec![4, 2],
        element: Element::I32,
        constant: Some(Values::I32(vec![0, 0, 0, 1, 1, 0, 0, 1])),
    };
    let tensors = vec![computed(&[1, 1, 1, 2]), computed(&[1, 2, 2, 3]), padding];
    let found = run(&single(OperatorKind::Pad, tensors), &[3.0, 4.0]);
    assert_eq!(found, [0., 0., 0., 3., 4., 0., 0., 0., 0., 0., 0., 0.]);

    let mut model = single(
        OperatorKind::Concatenation { axis: -1, activation: Activation::None },
        vec![computed(&[1, 2, 2]), computed(&[1, 2, 4])],
    );
    model.operators[0].inputs = vec![Some(0), Some(0)];
    assert_eq!(run(&model, &[1., 2., 3., 4.]), [1., 2., 1., 2., 3., 4., 3., 4.]);

    let mut model = single(
        OperatorKind::Add { activation: Activation::ReluOne },
        vec![computed(&[3]), computed(&[3])],
    );
    model.operators[0].inputs = vec![Some(0), Some(0)];
    assert_eq!(run(&model, &[0.25, -3.0, 2.0]), [0.5, -1.0, 1.0]);
}

#[test]
fn models_that_contradict_themselves_are_refused() {
    let kernel = || constant(&[1, 1, 1, 2], vec![1.0; 2]);
    let kind = OperatorKind::Convolution(window(true, 1, Activation::None));
    let (input, output) = (computed(&[1, 4, 4, 2]), computed(&[1, 4, 4, 1]));
    let refused = |model: &Model| Network::new(model).unwrap_err();
    let good = single(kind, vec![input.clone(), output.clone(), kernel()]);
    assert!(Network::new(&good).is_ok());
    for bad in [
        single(kind, vec![input.clone(), computed(&[1, 4, 3, 1]), kernel()]),
        single(kind, vec![computed(&[1, 4, 4, 3]), output.clone(), kernel()]),
        single(kind, vec![computed(&[2, 4, 4, 2]), output.clone(), kernel()]),
        single(kind, vec![input.clone(), output.clone()]),
        single(kind, vec![input.clone(), output.clone(), computed(&[1, 1, 1, 2])]),
        single(OperatorKind::Reshape, vec![input.clone(), output.clone()]),
        single(OperatorKind::Reshape, vec![computed(&[1 << 30]), computed(&[1 << 30])]),
    ] {
        assert_eq!(refused(&bad), NetworkError::Operator { index: 0 });
    }
    let mut unknown = good.clone();
    unknown.inputs = vec![1];
    assert!(matches!(refused(&unknown), NetworkError::Order { tensor: 0 }));
    let mut twice = good;
    twice.inputs = vec![0, 0];
    assert!(matches!(refused(&twice), NetworkError::Ends { inputs: 2, outputs: 1 }));
}
