//! Models of TensorFlow Lite (`*.tflite`), as far as the networks that find faces need it.
//!
//! A model is a flatbuffer with the identifier `TFL3`, in which one graph has a list of tensors and a
//! list of operators that read and write them, in the order in which they run. Constant tensors have
//! their values in a list of buffers.
//!
//! # Source
//! `tensorflow/compiler/mlir/lite/schema/schema.fbs` of TensorFlow, version 3 of the schema, for the
//! order of fields and the numbers of operators and types.

mod flatbuffer;
mod operator;
#[cfg(test)]
mod tests;

use flatbuffer::{Buffer, Table};

pub use operator::{Activation, Operator, OperatorKind, Window};

/// A tensor of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensor {
    /// Length of each axis. Their product fits `usize`.
    pub shape: Vec<usize>,
    /// Type of its values.
    pub element: Element,
    /// Its values if it is constant: as many as the product of `shape`.
    pub constant: Option<Values>,
}

/// Type of a tensor's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Element {
    /// Single precision.
    F32,
    /// Half precision.
    F16,
    /// Signed integers.
    I32,
}

/// Values of a constant tensor, row-major.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Values {
    /// Single precision; also what half precision is read as, which is exact.
    F32(Vec<f32>),
    /// Signed integers.
    I32(Vec<i32>),
}

/// A model's only graph.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// All tensors.
    pub tensors: Vec<Tensor>,
    /// All operators, in the order in which they run. Their indices of tensors are valid.
    pub operators: Vec<Operator>,
    /// Indices of the tensors that the caller gives.
    pub inputs: Vec<usize>,
    /// Indices of the tensors that are the result.
    pub outputs: Vec<usize>,
}

/// Why a model was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TfliteError {
    /// Another kind of file.
    #[error("not a TensorFlow Lite model: must have `TFL3` at byte 4")]
    Foreign,
    /// Another schema.
    #[error("a TensorFlow Lite model must have version 3, got {0}")]
    Version(u32),
    /// The file is cut short or damaged.
    #[error("truncated or damaged TensorFlow Lite model: nothing at byte {at}")]
    Offset {
        /// Where something should be.
        at: usize,
    },
    /// A list is longer than in any model of this kind.
    #[error(
        "damaged TensorFlow Lite model: a list at byte {at} must have at most {most} elements, got \
         {found}"
    )]
    Length {
        /// Where the list is.
        at: usize,
        /// Its length.
        found: usize,
        /// The limit.
        most: usize,
    },
    /// There are too many or too few graphs.
    #[error("a TensorFlow Lite model must have one graph, got {0}")]
    Graphs(usize),
    /// An index is too large or negative.
    #[error("damaged TensorFlow Lite model: there is no {what} {index}")]
    Index {
        /// Of what.
        what: &'static str,
        /// The index.
        index: i64,
    },
    /// A tensor has an unknown type.
    #[error(
        "tensors of TensorFlow Lite models must be float32, float16 or int32, got type number {0}"
    )]
    Element(u8),
    /// A tensor's shape is not one.
    #[error("damaged TensorFlow Lite model: tensor {0} has an impossible shape")]
    Shape(usize),
    /// A constant has more or fewer values than its shape says.
    #[error("damaged TensorFlow Lite model: tensor {tensor} must have {wanted} bytes, got {found}")]
    Constant {
        /// Which tensor.
        tensor: usize,
        /// Bytes by its shape.
        wanted: usize,
        /// Bytes of its buffer.
        found: usize,
    },
    /// An operator that face networks do not use.
    #[error("the TensorFlow Lite operator number {0} is not supported")]
    Operator(i32),
    /// An unknown activation.
    #[error("the TensorFlow Lite activation number {0} is not supported")]
    Activation(u8),
    /// A stride, dilation or window is negative, zero or huge.
    #[error("damaged TensorFlow Lite model: a stride or window of {0}")]
    Step(i32),
}

/// Most axes of a tensor.
const MAX_AXES: usize = 8;

/// Most tensors that an operator, or the graph, reads or writes.
const MAX_OPERANDS: usize = 64;

/// Reads a model.
///
/// # Errors
/// [`TfliteError`]; memory stays in proportion to the file, whatever it states.
pub fn parse(bytes: &[u8]) -> Result<Model, TfliteError> {
    if bytes.get(4..8) != Some(b"TFL3") {
        return Err(TfliteError::Foreign);
    }
    let root = Buffer::new(bytes).root()?;
    let version = root.u32(0)?;
    if version != 3 {
        return Err(TfliteError::Version(version));
    }
    let graphs = root.tables(2)?;
    let [graph] = graphs[..] else { return Err(TfliteError::Graphs(graphs.len())) };
    let codes = root.tables(1)?.into_iter().map(operator_code).collect::<Result<Vec<_>, _>>()?;
    let buffers = root.tables(4)?;
    let mut budget = bytes.len();
    let tensors = graph.tables(0)?.into_iter().enumerate();
    let tensors = tensors
        .map(|(index, table)| tensor(index, table, &buffers, &mut budget))
        .collect::<Result<Vec<_>, _>>()?;
    let count = tensors.len();
    let operators = graph.tables(3)?.into_iter();
    let operators =
        operators.map(|table| read_operator(table, &codes, count)).collect::<Result<_, _>>()?;
    let indices = |field| -> Result<Vec<usize>, TfliteError> {
        graph
            .i32_vector(field, MAX_OPERANDS)?
            .into_iter()
            .map(|index| tensor_index(index, count))
            .collect()
    };
    Ok(Model { operators, inputs: indices(1)?, outputs: indices(2)?, tensors })
}

/// The number of an operator. It was a byte at first, and is stored in both fields if it fits.
fn operator_code(table: Table<'_>) -> Result<i32, TfliteError> {
    Ok(table.i32(3, 0)?.max(i32::from(table.u8(0)?.cast_signed())))
}

fn tensor_index(index: i32, count: usize) -> Result<usize, TfliteError> {
    let valid = usize::try_from(index).ok().filter(|&index| index < count);
    valid.ok_or(TfliteError::Index { what: "tensor", index: index.into() })
}

/// - `budget`: bytes of constants that may still be read. Tensors may share a buffer, so without it
///   a small file could ask for much memory.
fn tensor(
    index: usize,
    table: Table<'_>,
    buffers: &[Table<'_>],
    budget: &mut usize,
) -> Result<Tensor, TfliteError> {
    let shape = table.i32_vector(0, MAX_AXES)?.into_iter().map(usize::try_from);
    let shape = shape.collect::<Result<Vec<_>, _>>().map_err(|_| TfliteError::Shape(index))?;
    let (element, size) = match table.u8(1)? {
        0 => (Element::F32, 4),
        1 => (Element::F16, 2),
        2 => (Element::I32, 4),
        other => return Err(TfliteError::Element(other)),
    };
    let wanted = shape.iter().try_fold(size, |product: usize, &side| product.checked_mul(side));
    let wanted = wanted.ok_or(TfliteError::Shape(index))?;
    let buffer = table.u32(2)?;
    let missing = TfliteError::Index { what: "buffer", index: buffer.into() };
    let bytes = buffers.get(buffer as usize).ok_or(missing)?.byte_vector(0)?;
    // Tensors that are computed name an empty buffer.
    if bytes.is_empty() {
        return Ok(Tensor { shape, element, constant: None });
    }
    if bytes.len() != wanted || wanted > *budget {
        return Err(TfliteError::Constant { tensor: index, wanted, found: bytes.len() });
    }
    *budget -= wanted;
    let words = || bytes.as_chunks::<4>().0.iter();
    let constant = match element {
        Element::F32 => Values::F32(words().map(|&word| f32::from_le_bytes(word)).collect()),
        Element::I32 => Values::I32(words().map(|&word| i32::from_le_bytes(word)).collect()),
        Element::F16 => {
            let halves = bytes.as_chunks::<2>().0.iter();
            Values::F32(halves.map(|&half| f32_from_f16(u16::from_le_bytes(half))).collect())
        }
    };
    Ok(Tensor { shape, element, constant: Some(constant) })
}

fn read_operator(table: Table<'_>, codes: &[i32], tensors: usize) -> Result<Operator, TfliteError> {
    let code = table.u32(0)?;
    let missing = TfliteError::Index { what: "operator code", index: code.into() };
    let code = *codes.get(code as usize).ok_or(missing)?;
    let inputs = table.i32_vector(1, MAX_OPERANDS)?.into_iter();
    let inputs = inputs
        .map(|index| if index == -1 { Ok(None) } else { tensor_index(index, tensors).map(Some) });
    let outputs = table.i32_vector(2, MAX_OPERANDS)?.into_iter();
    Ok(Operator {
        kind: operator::kind(code, table.table(4)?)?,
        inputs: inputs.collect::<Result<_, _>>()?,
        outputs: outputs.map(|index| tensor_index(index, tensors)).collect::<Result<_, _>>()?,
    })
}

/// The value of a half-precision float (IEEE 754 binary16), exactly.
fn f32_from_f16(half: u16) -> f32 {
    let sign = u32::from(half >> 15) << 31;
    let (exponent, fraction) = (u32::from(half >> 10 & 0x1f), u32::from(half & 0x3ff));
    let magnitude = match exponent {
        // Subnormal: a multiple of 2⁻²⁴.
        0 => (fraction as f32 / 16_777_216.0).to_bits(),
        31 => 0x7f80_0000 | fraction << 13,
        // The bias is 127 instead of 15.
        _ => (exponent + 112) << 23 | fraction << 13,
    };
    f32::from_bits(sign | magnitude)
}
