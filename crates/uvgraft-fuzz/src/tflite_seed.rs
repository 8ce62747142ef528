//! A small network as a TensorFlow Lite model.

/// A value of a flatbuffer's table, of four bytes or by an offset.
#[derive(Debug, Clone)]
pub(crate) enum Field {
    None,
    Byte(u8),
    Bytes(Vec<u8>),
    Ints(Vec<i32>),
    Tables(Vec<Vec<Field>>),
}

/// Appends a table to which `place` points, and what it points to.
fn table(bytes: &mut Vec<u8>, place: usize, fields: &[Field]) {
    let vtable = bytes.len();
    bytes.extend((4 + 2 * fields.len() as u16).to_le_bytes());
    bytes.extend([0; 2]);
    for (index, field) in fields.iter().enumerate() {
        let offset = if matches!(field, Field::None) { 0 } else { 4 + 4 * index as u16 };
        bytes.extend(offset.to_le_bytes());
    }
    let start = bytes.len();
    point(bytes, place, start);
    bytes.extend(((start - vtable) as u32).to_le_bytes());
    for field in fields {
        bytes.extend([if let Field::Byte(value) = field { *value } else { 0 }, 0, 0, 0]);
    }
    for (index, field) in fields.iter().enumerate() {
        let (place, end) = (start + 4 + 4 * index, bytes.len());
        match field {
            Field::None | Field::Byte(_) => {}
            Field::Bytes(content) => {
                point(bytes, place, end);
                bytes.extend((content.len() as u32).to_le_bytes());
                bytes.extend(content);
            }
            Field::Ints(values) => {
                point(bytes, place, end);
                bytes.extend((values.len() as u32).to_le_bytes());
                values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
            }
            Field::Tables(tables) => {
                point(bytes, place, end);
                bytes.extend((tables.len() as u32).to_le_bytes());
                let first = bytes.len();
                bytes.resize(first + 4 * tables.len(), 0);
                for (index, fields) in tables.iter().enumerate() {
                    table(bytes, first + 4 * index, fields);
                }
            }
        }
    }
}

fn point(bytes: &mut [u8], place: usize, to: usize) {
    bytes[place..place + 4].copy_from_slice(&((to - place) as u32).to_le_bytes());
}

/// The root table of a network with two tensors and one operator that adds them up.
pub(crate) fn fields() -> Vec<Field> {
    let tensor = |shape: Vec<i32>, buffer: u8| {
        vec![Field::Ints(shape), Field::Byte(0), Field::Byte(buffer), Field::Bytes(b"t".to_vec())]
    };
    let operator = vec![Field::Byte(0), Field::Ints(vec![0, 1]), Field::Ints(vec![2])];
    let graph = vec![
        Field::Tables(vec![tensor(vec![1, 2], 0), tensor(vec![1, 2], 1), tensor(vec![1, 2], 0)]),
        Field::Ints(vec![0]),
        Field::Ints(vec![2]),
        Field::Tables(vec![operator]),
    ];
    let weights: Vec<u8> = [1.0f32, 2.0].iter().flat_map(|value| value.to_le_bytes()).collect();
    vec![
        Field::Byte(3),
        Field::Tables(vec![vec![Field::Byte(0)]]),
        Field::Tables(vec![graph]),
        Field::None,
        Field::Tables(vec![vec![Field::None], vec![Field::Bytes(weights)]]),
    ]
}

/// The file with a root table.
pub(crate) fn written(root: &[Field]) -> Vec<u8> {
    let mut bytes = b"\0\0\0\0TFL3".to_vec();
    table(&mut bytes, 0, root);
    bytes
}

/// The network as a file.
pub(crate) fn model() -> Vec<u8> {
    written(&fields())
}
