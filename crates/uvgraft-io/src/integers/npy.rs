//! Lists of integers in NumPy's NPY arrays.

use super::{IntegersError, List};
use crate::numpy::{Dtype, NpyArray};
use crate::obj::shown;

/// What arrays are read as.
const INTEGERS: &str = "integers (i1 to i8 or u1 to u8)";
const INTEGERS_OR_BOOLS: &str = "integers (i1 to i8 or u1 to u8) or bools (b1)";

/// The values of an array as integers.
pub(super) fn integers(array: &NpyArray<'_>) -> Result<Vec<i64>, IntegersError> {
    check_list(array)?;
    integers_or(array, INTEGERS)
}

/// The values of an array as integers or bools.
pub(super) fn integers_or_mask(array: &NpyArray<'_>) -> Result<List, IntegersError> {
    check_list(array)?;
    if array.dtype_text() != Some(b"|b1") {
        return integers_or(array, INTEGERS_OR_BOOLS).map(List::Integers);
    }
    check_length(array, 1)?;
    Ok(List::Mask(array.values.iter().map(|&value| value != 0).collect()))
}

/// Checks that one axis at most is longer than 1, where C and Fortran order are the same.
fn check_list(array: &NpyArray<'_>) -> Result<(), IntegersError> {
    let is_list = |axes: &Vec<u64>| {
        !axes.is_empty() && axes.iter().filter(|&&length| length != 1).count() <= 1
    };
    match array.axes.as_ref().filter(|axes| is_list(axes)) {
        Some(_) => Ok(()),
        None => Err(IntegersError::NpyShape { found: shown(array.shape) }),
    }
}

fn integers_or(array: &NpyArray<'_>, wanted: &'static str) -> Result<Vec<i64>, IntegersError> {
    let refused = || IntegersError::NpyDtype { found: shown(array.descr), wanted };
    // Files state the byte order where it matters.
    let has_order = |dtype: &Dtype| match array.dtype_text() {
        Some([b'<' | b'>', ..]) => true,
        Some([b'|', ..]) => dtype.width == 1,
        _ => false,
    };
    let dtype = array.dtype().filter(|dtype| dtype.is_integer()).filter(has_order);
    let dtype = dtype.ok_or_else(refused)?;
    check_length(array, dtype.width)?;
    let integer = |(index, bytes)| {
        dtype.integer(bytes).map_err(|found: u64| IntegersError::OutOfRange {
            entry: index + 1,
            found: found.to_string(),
        })
    };
    array.values.chunks_exact(dtype.width).enumerate().map(integer).collect()
}

fn check_length(array: &NpyArray<'_>, width: usize) -> Result<(), IntegersError> {
    let found = array.values.len();
    array.check_length(width).map_err(|wanted| IntegersError::NpyLength { wanted, found })
}

#[cfg(test)]
mod tests {
    use super::super::{parse, parse_or_mask};
    use super::*;
    use crate::numpy::{HeaderError, MAGIC};

    fn file(version: u8, header: &str, values: &[u8]) -> Vec<u8> {
        let mut bytes = [MAGIC, &[version, 0]].concat();
        match version {
            1 => bytes.extend((header.len() as u16).to_le_bytes()),
            _ => bytes.extend((header.len() as u32).to_le_bytes()),
        }
        bytes.extend(header.as_bytes());
        bytes.extend(values);
        bytes
    }

    fn array(descr: &str, order: &str, shape: &str, values: &[u8]) -> Vec<u8> {
        let header =
            format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}    \n");
        file(1, &header, values)
    }

    fn error(descr: &str, shape: &str, values: &[u8]) -> String {
        parse(&array(descr, "False", shape, values)).unwrap_err().to_string()
    }

    #[test]
    fn reads_every_width_sign_byte_order_and_version() {
        let cases: [(&str, &[u8], [i64; 2]); 14] = [
            ("'|i1'", &[5, 0xff], [5, -1]),
            ("'|u1'", &[5, 0xff], [5, 255]),
            ("'<i2'", &[5, 1, 0xff, 0xff], [261, -1]),
            ("'>i2'", &[1, 5, 0xff, 0xfe], [261, -2]),
            ("'<u2'", &[5, 1, 0xff, 0xff], [261, 65_535]),
            ("'>u2'", &[1, 5, 0xff, 0xfe], [261, 65_534]),
            ("'<i4'", &[5, 1, 0, 0, 0xff, 0xff, 0xff, 0xff], [261, -1]),
            ("'>i4'", &[0, 0, 1, 5, 0xff, 0xff, 0xff, 0xfe], [261, -2]),
            ("'<u4'", &[5, 1, 0, 0, 0xff, 0xff, 0xff, 0xff], [261, 4_294_967_295]),
            ("\">u4\"", &[0, 0, 1, 5, 0xff, 0xff, 0xff, 0xfe], [261, 4_294_967_294]),
            ("'<i8'", b"\x05\x01\0\0\0\0\0\0\xff\xff\xff\xff\xff\xff\xff\xff", [261, -1]),
            ("'>i8'", b"\0\0\0\0\0\0\x01\x05\xff\xff\xff\xff\xff\xff\xff\xfe", [261, -2]),
            ("'<u8'", b"\x05\x01\0\0\0\0\0\0\xff\xff\xff\xff\xff\xff\xff\x7f", [261, i64::MAX]),
            ("'>u8'", b"\0\0\0\0\0\0\x01\x05\x7f\xff\xff\xff\xff\xff\xff\xff", [261, i64::MAX]),
        ];
        for (descr, values, wanted) in cases {
            for (order, shape) in [("False", "(2,)"), ("True", "(2, 1)"), ("False", "(1, 2L)")] {
                let bytes = array(descr, order, shape, values);
                assert_eq!(parse(&bytes).unwrap(), wanted, "{descr} {order} {shape}");
            }
        }
        let header = "{\"shape\":(1,),'fortran_order':True,'descr':'|u1'}";
        for version in 1..=3 {
            assert_eq!(parse(&file(version, header, &[9])).unwrap(), [9]);
        }
    }

    #[test]
    fn refuses_what_is_no_list_of_integers() {
        for descr in ["'<f4'", "'>f8'", "'|b1'", "'|O'", "'<U5'", "'<i3'", "'|i4'", "'i4'", "12"] {
            let wanted =
                format!("NPY array must have dtype integers (i1 to i8 or u1 to u8), got {descr}; ");
            let found = error(descr, "(1,)", &[0; 8]);
            assert!(found.starts_with(&wanted), "{found}");
        }
        let structured = error("[('a', '<i4'), ('b', '<i4', (2,))]", "(1,)", &[0; 12]);
        assert!(structured.contains("got [('a', '<i4'), ('b', '<i4', (2,)…"), "{structured}");
        for shape in
            ["()", "(2, 2)", "(0, 2)", "(-1,)", "(1.5,)", "7", "(,)", "(36893488147419103232,)"]
        {
            let wanted = format!("NPY array must have shape (N,), (N, 1) or (1, N), got {shape}");
            assert_eq!(error("'<i4'", shape, &[0; 16]), wanted);
        }
        assert_eq!(parse(&array("'<i4'", "False", "(0,)", &[])), Ok(Vec::new()));
        let beyond = error("'<u8'", "(2,)", b"\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80");
        assert_eq!(beyond, "entry 2: must be a signed 64-bit integer, got 9223372036854775808");
    }

    #[test]
    fn bools_are_a_mask_where_one_is_wanted() {
        let mask = |descr, shape, values: &[u8]| {
            parse_or_mask(&array(descr, "False", shape, values)).map_err(|error| error.to_string())
        };
        let found = mask("'|b1'", "(1, 3)", &[1, 0, 1]);
        assert_eq!(found, Ok(List::Mask(vec![true, false, true])));
        assert_eq!(mask("'|u1'", "(3,)", &[1, 0, 1]), Ok(List::Integers(vec![1, 0, 1])));
        // NumPy writes no other notation of bools.
        for other in ["'b1'", "'<b1'", "'=b1'"] {
            assert!(mask(other, "(3,)", &[1, 0, 1]).is_err(), "{other}");
        }
        let cut = "NPY array must have 3 bytes after the header, got 2";
        assert_eq!(mask("'|b1'", "(3,)", &[1, 0]), Err(cut.to_owned()));
        let floats = mask("'<f4'", "(1,)", &[0; 4]).unwrap_err();
        let wanted = "dtype integers (i1 to i8 or u1 to u8) or bools (b1), got '<f4'";
        assert!(floats.contains(wanted), "{floats}");
        assert_eq!(parse_or_mask(b"7, 9"), Ok(List::Integers(vec![7, 9])));
    }

    #[test]
    fn claims_are_checked_against_the_bytes() {
        let needs = |wanted: &str, found: usize| {
            format!("NPY array must have {wanted} bytes after the header, got {found}")
        };
        assert_eq!(error("'<i4'", "(2,)", &[0; 7]), needs("8", 7));
        assert_eq!(error("'<i4'", "(2,)", &[0; 9]), needs("8", 9));
        let huge = error("'<i8'", "(18446744073709551615,)", &[0; 8]);
        assert_eq!(huge, needs("147573952589676412920", 8));

        let mut long_header = file(2, "{}", b"");
        long_header[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
        let cut_short = parse(&long_header).unwrap_err();
        assert_eq!(cut_short, HeaderError::Truncated { wanted: 4_294_967_307, found: 14 }.into());
        assert_eq!(
            parse(b"\x93NUMPY\x01\0v").unwrap_err().to_string(),
            "truncated NPY file: header must have 10 bytes, got 9"
        );
        assert_eq!(
            parse(b"\x93NUMPY\x04\0\0\0"),
            Err(HeaderError::Version { major: 4, minor: 0 }.into())
        );
    }

    #[test]
    fn refuses_headers_that_are_no_description() {
        for (header, found, wanted) in [
            ("rubbish", "rubbish", "a dictionary in braces"),
            ("{'descr': '<i8'", "{'descr': '<i8'", "a dictionary in braces"),
            ("{}", "{}", "an entry 'descr'"),
            ("{'name': 1}", "'name': 1", "'descr', 'fortran_order' or 'shape'"),
            (
                "{'descr': '<i8', 'shape': (1,), 'fortran_order': 0}",
                "0",
                "True or False as 'fortran_order'",
            ),
        ] {
            let error = parse(&file(1, header, &[0; 8])).unwrap_err();
            assert_eq!(error, HeaderError::Header { found: found.into(), wanted }.into());
        }
        let nested = format!("{{'descr': {}", "[".repeat(60_000));
        assert!(parse(&file(1, &nested, &[])).is_err());
    }
}
