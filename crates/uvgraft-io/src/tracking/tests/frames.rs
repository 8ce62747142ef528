//! Checkpoints of metrical-tracker, as `torch.save` writes dicts of NumPy arrays.

use std::io::{Cursor, Write};
use std::path::Path;

use uvgraft::texture::Size;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::{put_image, put_text};

/// The content of a checkpoint. By default it is the camera that PyTorch3D's
/// `look_at_view_transform(dist=1)` gives: at `[0, 0, 1]`, looking along -z.
#[derive(Clone)]
pub(super) struct Checkpoint {
    /// The first two rows of PyTorch3D's rotation.
    pub(super) six: [f32; 6],
    pub(super) translation: [f32; 3],
    pub(super) focal_length: f32,
    pub(super) principal_point: [f32; 2],
    pub(super) jaw: Vec<f32>,
    pub(super) has_opencv: bool,
}

impl Default for Checkpoint {
    fn default() -> Self {
        Self {
            six: [-1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            translation: [0.0, 0.0, 1.0],
            focal_length: 2.0,
            principal_point: [0.1, -0.05],
            jaw: vec![0.0, -1.0, 0.0, 1.0, 0.0, 0.0],
            has_opencv: true,
        }
    }
}

impl Checkpoint {
    pub(super) fn without_opencv(&self) -> Self {
        Self { has_opencv: false, ..self.clone() }
    }

    pub(super) fn bytes(&self) -> Vec<u8> {
        let eyes = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0];
        let flame = dict(&[
            ("exp", floats(&[1, 2], &[0.5, -0.5])),
            ("shape", floats(&[1, 3], &[1.0, 2.0, 3.0])),
            ("sh", floats(&[1, 1, 3], &[0.0; 3])),
            ("eyes", floats(&[1, 12], &eyes)),
            ("eyelids", floats(&[1, 2], &[0.25, 0.75])),
            ("jaw", floats(&[1, self.jaw.len()], &self.jaw)),
        ]);
        let camera = dict(&[
            ("R", floats(&[1, 6], &self.six)),
            ("t", floats(&[1, 3], &self.translation)),
            ("fl", floats(&[1, 1], &[self.focal_length])),
            ("pp", floats(&[1, 2], &self.principal_point)),
        ]);
        // By hand for the default: both axes of PyTorch3D's camera that differ are reversed.
        let opencv = dict(&[
            ("R", floats(&[1, 3, 3], &[1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0])),
            ("t", floats(&[1, 3], &[0.0, 0.0, 1.0])),
            ("K", floats(&[1, 3, 3], &[480.0, 0.0, 296.0, 0.0, 480.0, 252.0, 0.0, 0.0, 1.0])),
        ]);
        let mut entries = vec![("flame", flame), ("camera", camera)];
        if self.has_opencv {
            entries.push(("opencv", opencv));
        }
        let size: Vec<u8> = [480_i64, 640].into_iter().flat_map(i64::to_le_bytes).collect();
        entries.push(("img_size", array(&[2], "i8", &size)));
        entries.push(("frame_id", text("00000")));
        entries.push(("global_step", b"K\x07".to_vec()));
        archive(&[b"\x80\x02".to_vec(), dict(&entries), b".".to_vec()].concat())
    }
}

/// A folder of checkpoints by name, each with its image.
pub(super) fn metrical_folder(folder: &Path, checkpoints: &[(&str, Checkpoint)]) {
    put_text(&folder.join("checkpoint/notes.txt"), "");
    for (name, checkpoint) in checkpoints {
        put_image(&folder.join(format!("input/{name}.png")), Size::new(4, 3));
        let path = folder.join(format!("checkpoint/{name}.frame"));
        std::fs::write(path, checkpoint.bytes()).unwrap();
    }
}

/// A torch file of a pickle.
pub(super) fn archive(pickle: &[u8]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in [("archive/data.pkl", pickle), ("archive/version", b"3\n")] {
        archive.start_file(name, SimpleFileOptions::default()).unwrap();
        archive.write_all(content).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

fn text(text: &str) -> Vec<u8> {
    [b"X", &(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

fn dict(entries: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = b"}(".to_vec();
    for (key, value) in entries {
        bytes.extend(text(key));
        bytes.extend(value);
    }
    bytes.push(b'u');
    bytes
}

fn floats(shape: &[usize], values: &[f32]) -> Vec<u8> {
    let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    array(shape, "f4", &data)
}

/// `numpy.ndarray.__reduce__` in protocol 2, where bytes are the Latin-1 code of a string.
fn array(shape: &[usize], dtype: &str, data: &[u8]) -> Vec<u8> {
    let encoded = |data: &[u8]| {
        let data: String = data.iter().map(|&byte| char::from(byte)).collect();
        [b"c_codecs\nencode\n".to_vec(), text(&data), text("latin1"), b"\x86R".to_vec()].concat()
    };
    let lengths = shape.iter().map(|&length| [b"J", &(length as u32).to_le_bytes()[..]].concat());
    [
        b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\0\x85".to_vec(),
        encoded(b"b"),
        b"\x87R(K\x01(".to_vec(),
        lengths.collect::<Vec<_>>().concat(),
        b"tcnumpy\ndtype\n".to_vec(),
        text(dtype),
        b"K\0K\x01\x87R(K\x03".to_vec(),
        text("<"),
        b"NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0tb\x89".to_vec(),
        encoded(data),
        b"tb".to_vec(),
    ]
    .concat()
}
