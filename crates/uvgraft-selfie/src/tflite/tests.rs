use super::*;

/// Writes flatbuffers front to back, which is all that tests need: offsets point forwards to what is
/// appended later, and every vtable lies directly before its table.
#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
}

/// What a field holds.
enum Field {
    Default,
    Byte(u8),
    Int(i32),
    Bytes(Vec<u8>),
    Ints(Vec<i32>),
    Table(Vec<Field>),
    Tables(Vec<Vec<Field>>),
}

impl Writer {
    fn int(&mut self, value: usize) {
        self.bytes.extend(u32::try_from(value).unwrap().to_le_bytes());
    }

    /// Stores at `place` how far the end is from it.
    fn point_here(&mut self, place: usize) {
        let offset = u32::try_from(self.bytes.len() - place).unwrap();
        self.bytes[place..place + 4].copy_from_slice(&offset.to_le_bytes());
    }

    /// Appends a table, every field of which takes four bytes, and what it refers to.
    fn table(&mut self, place: usize, fields: &[Field]) {
        let vtable = self.bytes.len();
        let length = u16::try_from(4 + 2 * fields.len()).unwrap();
        self.bytes.extend(length.to_le_bytes());
        self.bytes.extend([0; 2]);
        for (index, field) in fields.iter().enumerate() {
            let offset = u16::try_from(4 + 4 * index).unwrap();
            let offset = if matches!(field, Field::Default) { 0 } else { offset };
            self.bytes.extend(offset.to_le_bytes());
        }
        self.point_here(place);
        let start = self.bytes.len();
        self.int(start - vtable);
        for field in fields {
            match field {
                Field::Byte(value) => self.bytes.extend([*value, 0, 0, 0]),
                Field::Int(value) => self.bytes.extend(value.to_le_bytes()),
                _ => self.int(0),
            }
        }
        for (index, field) in fields.iter().enumerate() {
            self.content(start + 4 + 4 * index, field);
        }
    }

    fn content(&mut self, place: usize, field: &Field) {
        match field {
            Field::Bytes(bytes) => {
                self.point_here(place);
                self.int(bytes.len());
                self.bytes.extend(bytes);
            }
            Field::Ints(values) => {
                self.point_here(place);
                self.int(values.len());
                values.iter().for_each(|value| self.bytes.extend(value.to_le_bytes()));
            }
            Field::Table(fields) => self.table(place, fields),
            Field::Tables(tables) => {
                self.point_here(place);
                self.int(tables.len());
                let start = self.bytes.len();
                self.bytes.resize(start + 4 * tables.len(), 0);
                for (index, fields) in tables.iter().enumerate() {
                    self.table(start + 4 * index, fields);
                }
            }
            Field::Default | Field::Byte(_) | Field::Int(_) => {}
        }
    }
}

fn file(root: &[Field]) -> Vec<u8> {
    let mut writer = Writer { bytes: b"\0\0\0\0TFL3".to_vec() };
    writer.table(0, root);
    writer.bytes
}

/// A tensor: shape, type, buffer.
fn tensor_fields(shape: &[i32], element: u8, buffer: i32) -> Vec<Field> {
    vec![Field::Ints(shape.to_vec()), Field::Byte(element), Field::Int(buffer)]
}

/// A convolution of a 4×4 image by a 1×1 kernel, whose kernel and bias are half-precision.
fn small_model() -> Vec<u8> {
    let code =
        |code| vec![Field::Byte(code), Field::Default, Field::Default, Field::Int(code.into())];
    let halves = |values: &[u16]| values.iter().flat_map(|half| half.to_le_bytes()).collect();
    let operator = |code, inputs: &[i32], output, options| {
        let (inputs, outputs) = (Field::Ints(inputs.to_vec()), Field::Ints(vec![output]));
        vec![Field::Int(code), inputs, outputs, Field::Byte(1), options]
    };
    let convolution = vec![Field::Byte(1), Field::Int(2), Field::Int(3), Field::Byte(1)];
    file(&[
        Field::Int(3),
        Field::Tables(vec![code(6), code(3)]),
        Field::Tables(vec![vec![
            Field::Tables(vec![
                tensor_fields(&[1, 4, 4, 2], 0, 0),
                tensor_fields(&[1, 1, 1, 2], 1, 1),
                tensor_fields(&[1, 1, 1, 2], 0, 0),
                tensor_fields(&[1, 2, 2, 1], 0, 0),
                tensor_fields(&[2], 2, 2),
            ]),
            Field::Ints(vec![0]),
            Field::Ints(vec![3]),
            Field::Tables(vec![
                operator(0, &[1], 2, Field::Default),
                operator(1, &[0, 2, -1], 3, Field::Table(convolution)),
            ]),
        ]]),
        Field::Default,
        Field::Tables(vec![
            vec![],
            vec![Field::Bytes(halves(&[0x3c00, 0xc100]))],
            vec![Field::Bytes(vec![7, 0, 0, 0, 255, 255, 255, 255])],
        ]),
    ])
}

#[test]
fn reads_tensors_operators_and_options() {
    let model = parse(&small_model()).unwrap();
    assert_eq!((&model.inputs[..], &model.outputs[..]), (&[0][..], &[3][..]));
    assert_eq!(model.tensors[0].shape, [1, 4, 4, 2]);
    assert_eq!(model.tensors[0].constant, None);
    assert_eq!(model.tensors[1].element, Element::F16);
    assert_eq!(model.tensors[1].constant, Some(Values::F32(vec![1.0, -2.5])));
    assert_eq!(model.tensors[4].constant, Some(Values::I32(vec![7, -1])));
    let window =
        Window { is_same: false, stride: [3, 2], dilation: [1, 1], activation: Activation::Relu };
    assert_eq!(
        model.operators,
        [
            Operator { kind: OperatorKind::Dequantize, inputs: vec![Some(1)], outputs: vec![2] },
            Operator {
                kind: OperatorKind::Convolution(window),
                inputs: vec![Some(0), Some(2), None],
                outputs: vec![3]
            },
        ]
    );
}

#[test]
fn halves_are_exact() {
    for (half, wanted) in [
        (0x0000, 0.0),
        (0x3c00, 1.0),
        (0xc000, -2.0),
        (0x7bff, 65_504.0),
        (0x0400, 6.103_515_6e-5),
        (0x0001, 5.960_464_5e-8),
        (0x83ff, -6.097_555e-5),
        (0x7c00, f32::INFINITY),
    ] {
        assert_eq!(f32_from_f16(half), wanted, "{half:04x}");
    }
    assert!(f32_from_f16(0x7e00).is_nan());
    assert!(f32_from_f16(0x8000).is_sign_negative());
}

#[test]
fn other_files_are_refused() {
    for bytes in [&b""[..], b"TFL3", b"\x08\0\0\0TFL2\0\0\0\0"] {
        assert_eq!(parse(bytes), Err(TfliteError::Foreign));
    }
    assert_eq!(parse(&file(&[Field::Int(4)])), Err(TfliteError::Version(4)));
    assert_eq!(parse(&file(&[Field::Int(3)])), Err(TfliteError::Graphs(0)));
}

#[test]
fn damaged_files_are_errors_and_take_little_memory() {
    let whole = small_model();
    for end in 0..whole.len() {
        assert!(parse(&whole[..end]).is_err(), "cut at {end}");
    }
    let mut random = fastrand::Rng::with_seed(7);
    for _ in 0..20_000 {
        let mut bytes = whole.clone();
        for _ in 0..random.usize(1..4) {
            let at = random.usize(8..bytes.len());
            let any = random.u8(..);
            bytes[at] = *random.choice(&[0, 1, 0x7f, 0x80, 0xff, any]).unwrap();
        }
        if let Ok(model) = parse(&bytes) {
            let constants = model.tensors.iter().filter_map(|tensor| tensor.constant.as_ref());
            let values: usize = constants
                .map(|values| match values {
                    Values::F32(values) => values.len(),
                    Values::I32(values) => values.len(),
                })
                .sum();
            assert!(values <= bytes.len(), "{values} values");
        }
    }
}

#[test]
fn shared_buffers_cannot_multiply_memory() {
    let tensors = (0..1000).map(|_| tensor_fields(&[1000], 0, 0)).collect();
    let graph = vec![Field::Tables(tensors)];
    let buffer = vec![vec![Field::Bytes(vec![0; 4000])]];
    let bytes = file(&[
        Field::Int(3),
        Field::Default,
        Field::Tables(vec![graph]),
        Field::Default,
        Field::Tables(buffer),
    ]);
    assert!(matches!(parse(&bytes), Err(TfliteError::Constant { .. })));
}
