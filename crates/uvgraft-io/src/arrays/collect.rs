//! Extracts arrays by name from a pickle.

use super::error::{ArraysError, MAX_NAMES, MAX_NUMBERS, MAX_REPEATED_NUMBERS, Unread};
use super::named::{Held, NamedArrays};
use super::numeric::{Numbers, NumericArray, count};
use super::sparse;
use crate::numpy::text::lenient;
use crate::pickle::{Array, Class, Object, Value};

/// Maximum nesting depth of dicts, lists and objects. A pickle may contain itself.
const MAX_DEPTH: usize = 16;

/// Maximum total number of list items in a file, counted each time a list is visited.
const MAX_ITEMS: usize = 1 << 20;

/// Maximum length of a name in bytes.
const LONGEST_NAME: usize = 1024;

/// Reads tensors, whose numbers lie outside of the pickle.
pub(crate) trait Outside {
    /// The values of a tensor; `spend` receives their number before they are read.
    fn tensor(
        &mut self,
        tensor: Object<'_>,
        spend: &mut dyn FnMut(usize) -> Result<(), Unread>,
    ) -> Result<NumericArray, Unread>;
}

/// Collects arrays within the limits of a file.
pub(crate) struct Collector<'o> {
    found: NamedArrays,
    outside: Option<&'o mut dyn Outside>,
    budget: Budget,
    names: usize,
}

/// The remaining budget.
struct Budget {
    numbers: usize,
    /// How many there were at first.
    most: usize,
    items: usize,
}

impl Budget {
    fn spend(&mut self, count: usize) -> Result<(), Unread> {
        spend(&mut self.numbers, count, "numbers", self.most)
    }

    fn spend_items(&mut self, count: usize) -> Result<(), Unread> {
        spend(&mut self.items, count, "list items", MAX_ITEMS)
    }
}

fn spend(left: &mut usize, count: usize, what: &'static str, most: usize) -> Result<(), Unread> {
    let most = most as u64;
    let rest = left.checked_sub(count);
    *left = rest.ok_or(Unread::Refused(ArraysError::TooMany { what, most }))?;
    Ok(())
}

impl<'o> Collector<'o> {
    /// - `stored`: bytes of the file, unpacked.
    pub(crate) fn new(outside: Option<&'o mut dyn Outside>, stored: usize) -> Self {
        let most = stored.saturating_add(MAX_REPEATED_NUMBERS).min(MAX_NUMBERS);
        let budget = Budget { numbers: most, most, items: MAX_ITEMS };
        Self { found: NamedArrays::new(), outside, budget, names: 0 }
    }

    pub(crate) fn finish(self) -> NamedArrays {
        self.found
    }

    /// All entries of a dict, or a single array under an empty name.
    pub(crate) fn collect(mut self, root: Value<'_>) -> Result<NamedArrays, ArraysError> {
        if root.entries().is_some() {
            self.add_dict("", root, MAX_DEPTH)?;
        } else {
            match self.convert(root, MAX_DEPTH) {
                Ok(held @ Held::Array(_)) => self.hold("", held),
                Ok(_) => return Err(ArraysError::NotADict { found: root.kind().to_owned() }),
                Err(Unread::Unusable(found)) => return Err(ArraysError::NotADict { found }),
                Err(unread) => self.unread("", unread)?,
            }
        }
        Ok(self.found)
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.found.entries().any(|(found, _)| found == name)
    }

    /// Adds the value of a name; a dict adds its entries.
    pub(super) fn add(&mut self, name: &str, value: Value<'_>) -> Result<(), ArraysError> {
        self.add_within(name, value, MAX_DEPTH)
    }

    fn add_within(
        &mut self,
        name: &str,
        value: Value<'_>,
        depth: usize,
    ) -> Result<(), ArraysError> {
        let inner = single(value);
        if inner.entries().is_some() {
            return match depth.checked_sub(1) {
                Some(depth) => self.add_dict(&format!("{name}."), inner, depth),
                None => {
                    self.leave_out(name, "a dict nested too deeply".to_owned());
                    Ok(())
                }
            };
        }
        match self.convert(value, depth) {
            Ok(held) => self.hold(name, held),
            Err(unread) => self.unread(name, unread)?,
        }
        Ok(())
    }

    fn add_dict(&mut self, before: &str, dict: Value<'_>, depth: usize) -> Result<(), ArraysError> {
        for (key, value) in dict.entries().into_iter().flatten() {
            // In the dicts of torch's optimisers, names are numbers.
            let name = match (key.as_str(), key.as_int()) {
                (Some(text), _) => text.to_owned(),
                (None, Some(number)) => number.to_string(),
                (None, None) => format!("({})", key.kind()),
            };
            if before.len() + name.len() > LONGEST_NAME {
                return Err(ArraysError::TooMany {
                    what: "bytes in a name",
                    most: LONGEST_NAME as u64,
                });
            }
            self.count_name()?;
            self.add_within(&format!("{before}{name}"), value, depth)?;
        }
        Ok(())
    }

    /// Counts a visited name: one dict may be contained in many.
    fn count_name(&mut self) -> Result<(), ArraysError> {
        self.names += 1;
        if self.names > MAX_NAMES {
            return Err(ArraysError::TooMany { what: "names", most: MAX_NAMES as u64 });
        }
        Ok(())
    }

    pub(super) fn hold(&mut self, name: &str, held: Held) {
        self.found.hold(name.to_owned(), held);
    }

    pub(super) fn leave_out(&mut self, name: &str, reason: String) {
        self.hold(name, Held::Unusable(reason));
    }

    pub(super) fn unread(&mut self, name: &str, unread: Unread) -> Result<(), ArraysError> {
        match unread {
            Unread::Unusable(reason) => self.leave_out(name, reason),
            Unread::Broken(problem) => return Err(ArraysError::array(name, problem)),
            Unread::Refused(error) => return Err(error),
        }
        Ok(())
    }

    /// Counts values that are about to be read.
    pub(super) fn spend(&mut self, count: usize) -> Result<(), Unread> {
        self.budget.spend(count)
    }

    fn convert(&mut self, value: Value<'_>, depth: usize) -> Result<Held, Unread> {
        let value = single(value);
        let text = value.as_str().map(str::to_owned);
        let text = text.or_else(|| value.as_bytes().map(|bytes| lenient(bytes).into_owned()));
        if let Some(text) = text {
            // Any number of names may refer to one string.
            self.spend(text.len())?;
            return Ok(Held::Text(text));
        }
        self.array(value, depth).map(Held::Array)
    }

    fn array(&mut self, value: Value<'_>, depth: usize) -> Result<NumericArray, Unread> {
        let Some(depth) = depth.checked_sub(1) else {
            return Err(Unread::Unusable(
                "arrays nested too deeply in lists or objects".to_owned(),
            ));
        };
        let value = single(value);
        let scalar = match (value.as_bool(), value.as_int(), value.as_float()) {
            (Some(flag), _, _) => NumericArray::new_i64(Vec::new(), vec![flag.into()]),
            (_, Some(number), _) => NumericArray::new_i64(Vec::new(), vec![number]),
            (_, _, Some(number)) => NumericArray::new_f64(Vec::new(), vec![number]),
            _ => None,
        };
        if let Some(scalar) = scalar {
            self.spend(1)?;
            return Ok(scalar);
        }
        if let Some(array) = value.as_array() {
            self.spend(array.count())?;
            return plain(&array);
        }
        if let Some(object) = value.as_object() {
            return self.object(object, depth);
        }
        if let Some(items) = value.objects() {
            return self.stacked(items, depth);
        }
        match value.items() {
            Some(items) => self.stacked(items, depth),
            None => Err(Unread::Unusable(value.kind().to_owned())),
        }
    }

    /// The values of a sparse matrix.
    pub(super) fn coordinates(
        &mut self,
        matrix: Object<'_>,
    ) -> Result<sparse::Coordinates, Unread> {
        let shape = sparse::shape(matrix)?;
        sparse::pickled(matrix, shape, |value| part(value, |count| self.spend(count)))
    }

    fn object(&mut self, object: Object<'_>, depth: usize) -> Result<NumericArray, Unread> {
        // One object may be reached many times through others.
        self.budget.spend_items(1)?;
        match object.class() {
            Class::SparseCsc | Class::SparseCsr | Class::SparseCoo => {
                // Both closures draw on the budget, one after the other.
                let budget = std::cell::RefCell::new(&mut self.budget);
                let numbers = |value| part(value, |count| budget.borrow_mut().spend(count));
                sparse::dense(object, numbers, |count| budget.borrow_mut().spend(count))
            }
            Class::Chumpy => {
                let x = object.attribute("x");
                let x = x.ok_or_else(|| Unread::broken("a chumpy array must have an `x`"))?;
                self.array(x, depth)
            }
            Class::ChumpySelect => {
                let (a, places) = (object.attribute("a"), object.attribute("idxs"));
                let (Some(a), Some(places)) = (a, places) else {
                    return Err(Unread::broken("a chumpy selection must have `a` and `idxs`"));
                };
                let (a, places) = (self.array(a, depth)?, self.array(places, depth)?);
                let shape = object.attribute("preferred_shape");
                let shape = shape.map(|shape| self.array(shape, depth)).transpose()?;
                self.spend(places.numbers().len())?;
                chosen(a, &places, shape.as_ref())
            }
            Class::Parameter => match object.arg(0).and_then(Value::as_object) {
                Some(tensor) if tensor.class() == Class::Tensor => self.object(tensor, depth),
                _ => Err(Unread::broken("a parameter must have a tensor")),
            },
            Class::Tensor => match &mut self.outside {
                Some(outside) => outside.tensor(object, &mut |count| self.budget.spend(count)),
                None => Err(Unread::Unusable("a tensor outside a torch file".to_owned())),
            },
            Class::Storage(_) => Err(Unread::Unusable("a torch storage".to_owned())),
        }
    }

    /// Stacks arrays of one shape.
    fn stacked<'p>(
        &mut self,
        items: impl ExactSizeIterator<Item = Value<'p>>,
        depth: usize,
    ) -> Result<NumericArray, Unread> {
        let length = items.len();
        self.budget.spend_items(length)?;
        let mut stack: Option<(Vec<usize>, Numbers)> = None;
        for item in items {
            let (shape, numbers) = self.array(item, depth)?.into_parts();
            match &mut stack {
                None => stack = Some((shape, numbers)),
                Some((first, stacked)) if *first == shape => stacked.append(numbers),
                Some((first, _)) => {
                    let found =
                        format!("a list of arrays of different shapes, {first:?} and {shape:?}");
                    return Err(Unread::Unusable(found));
                }
            }
        }
        let (mut shape, numbers) = stack.unwrap_or((Vec::new(), Numbers::I64(Vec::new())));
        shape.insert(0, length);
        NumericArray::new(shape, numbers)
            .ok_or_else(|| Unread::broken("the length of a list does not match its items"))
    }
}

/// An array of a sparse matrix. `spend` receives the number of values before they are read.
fn part(
    value: Value<'_>,
    spend: impl FnOnce(usize) -> Result<(), Unread>,
) -> Result<NumericArray, Unread> {
    let array = value.as_array();
    let array = array.ok_or_else(|| Unread::broken("a sparse matrix must consist of arrays"))?;
    spend(array.count())?;
    plain(&array)
}

/// The content of an array with a single object.
pub(crate) fn single(value: Value<'_>) -> Value<'_> {
    let objects = value.objects().filter(|objects| objects.len() == 1);
    objects.and_then(|mut objects| objects.next()).unwrap_or(value)
}

/// A NumPy array.
pub(crate) fn plain(array: &Array<'_>) -> Result<NumericArray, Unread> {
    let (shape, is_fortran) = (array.shape().to_vec(), array.is_fortran_order());
    NumericArray::stored(shape, is_fortran, array.dtype(), array.bytes())
}

/// Selects values of an array; negative indices count from its end.
///
/// Source: chumpy's `Select`, which stands for `a.ravel()[idxs].reshape(preferred_shape)`.
fn chosen(
    a: NumericArray,
    places: &NumericArray,
    shape: Option<&NumericArray>,
) -> Result<NumericArray, Unread> {
    fn choose<T: Copy>(values: &[T], places: &[i64]) -> Option<Vec<T>> {
        let length = i64::try_from(values.len()).ok()?;
        let at = |place: i64| if place < 0 { place.checked_add(length) } else { Some(place) };
        let value = |&place: &i64| values.get(usize::try_from(at(place)?).ok()?).copied();
        places.iter().map(value).collect()
    }
    let outside = || Unread::Broken("a chumpy selection has indices out of range".to_owned());
    let places = places.integers().ok_or_else(outside)?;
    let numbers = match a.into_parts().1 {
        Numbers::F32(values) => Numbers::F32(choose(&values, &places).ok_or_else(outside)?),
        Numbers::F64(values) => Numbers::F64(choose(&values, &places).ok_or_else(outside)?),
        Numbers::I64(values) => Numbers::I64(choose(&values, &places).ok_or_else(outside)?),
    };
    let shape: Option<Vec<usize>> = match shape.map(NumericArray::integers) {
        None => Some(vec![numbers.len()]),
        Some(lengths) => lengths.and_then(|lengths| {
            lengths.into_iter().map(|length| usize::try_from(length).ok()).collect()
        }),
    };
    let shape = shape.filter(|shape| count(shape).is_some());
    let array = shape.and_then(|shape| NumericArray::new(shape, numbers));
    array.ok_or_else(|| {
        Unread::Broken("the shape of a chumpy array does not match its values".to_owned())
    })
}

impl Numbers {
    /// Appends values; mixed types become doubles.
    fn append(&mut self, more: Self) {
        match (&mut *self, more) {
            (Self::F32(values), Self::F32(more)) => values.extend(more),
            (Self::F64(values), Self::F64(more)) => values.extend(more),
            (Self::I64(values), Self::I64(more)) => values.extend(more),
            (_, more) => {
                let mut values = std::mem::replace(self, Self::I64(Vec::new())).into_doubles();
                values.extend(more.into_doubles());
                *self = Self::F64(values);
            }
        }
    }

    pub(super) fn into_doubles(self) -> Vec<f64> {
        match self {
            Self::F32(values) => values.into_iter().map(f64::from).collect(),
            Self::F64(values) => values,
            Self::I64(values) => values.into_iter().map(|value| value as f64).collect(),
        }
    }
}
