use super::*;

/// Weights that are different at every position.
fn counted(network: LpipsNetwork) -> LpipsWeights {
    let mut next = 0;
    let mut values = |count: usize| -> Vec<f32> {
        next += count;
        (next - count..next).map(|value| value as f32).collect()
    };
    let shapes = network.kernel_shapes();
    let convolutions = shapes.iter().map(|shape| ConvolutionWeights {
        kernel: values(shape.iter().product()),
        bias: values(shape[3]),
    });
    let convolutions = convolutions.collect();
    let linear = network.compared_channels().into_iter().map(&mut values).collect();
    LpipsWeights::new(network, convolutions, linear).unwrap()
}

fn both() -> BothNetworks {
    BothNetworks { alex: counted(LpipsNetwork::Alex), vgg: counted(LpipsNetwork::Vgg) }
}

#[test]
fn what_is_written_is_read_and_nothing_less() {
    let both = both();
    let mut bytes = encode(&both).unwrap();
    assert_eq!(decode(&bytes, LpipsNetwork::Alex).unwrap(), both.alex);
    assert_eq!(decode(&bytes, LpipsNetwork::Vgg).unwrap(), both.vgg);
    assert_eq!(bytes, encode(&both).unwrap());

    let error = |bytes: &[u8]| decode(bytes, LpipsNetwork::Alex).unwrap_err().to_string();
    for end in [9, 100, 5_000, bytes.len() - 1] {
        assert!(error(&bytes[..end]).contains("truncated or damaged"), "cut at {end}");
    }
    assert!(error(&[&bytes[..], b"x"].concat()).contains("truncated or damaged"));
    let header = u64::from_le_bytes(*bytes.first_chunk().unwrap()) as usize + 8;
    let text = String::from_utf8(bytes[8..header].to_vec()).unwrap();
    let changed = |from: &str, to: &str| {
        assert_eq!(from.len(), to.len());
        let mut changed = bytes.clone();
        let place = text.find(from).unwrap() + 8;
        changed[place..place + from.len()].copy_from_slice(to.as_bytes());
        error(&changed)
    };
    assert!(changed("uvgraft-lpips", "uvgraft-other").contains("not a file of LPIPS weights"));
    assert!(changed(r#"version\":1"#, r#"version\":7"#).contains("version 1 or older, got 7"));
    assert_eq!(
        changed("alex.conv2.bias", "alex.conv2.bies"),
        "damaged LPIPS weights: tensor `alex.conv2.bias` is missing"
    );
    assert_eq!(
        changed("[11,11,3,64]", "[11,3,11,64]"),
        "damaged LPIPS weights: tensor `alex.conv1.kernel` must be F32 [11, 11, 3, 64], got F32 [11, 3, 11, 64]"
    );
    // A single bit of one value.
    bytes[header + 54_019] ^= 0x40;
    assert!(error(&bytes).contains("SHA-256"), "{}", error(&bytes));
}

#[test]
fn other_files_are_foreign() {
    let empty = safetensors::serialize(Vec::<(&str, TensorView<'_>)>::new(), None).unwrap();
    for bytes in [&b""[..], b"\x89PNG\r\n\x1a\n....", b"\x1f\x8b\x08\0\0\0\0\0\0\0", &empty] {
        let error = decode(bytes, LpipsNetwork::Vgg).unwrap_err();
        assert!(matches!(error, WeightsFileError::Foreign), "{error}");
    }
}
