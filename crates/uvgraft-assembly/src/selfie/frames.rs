//! Which files are photographs: those given, and frames of folders.

use std::path::Path;

use uvgraft_files::input::Input;
use uvgraft_io::tracking::{self, TrackedFrame};
use uvgraft_pipeline::{Blame, Failure, Result, images_in};

use super::request::FRAMES;

/// The photographs that arguments stand for.
#[derive(Debug, PartialEq)]
pub(crate) enum Frames {
    /// Files, each of which must show a face.
    Files(Vec<Input>),
    /// Frames of a folder, of which those without a face are left out.
    Folder(Vec<Input>),
    /// Frames of a tracked video, likewise.
    Tracked(Vec<TrackedImage>),
}

/// A frame of a tracked video, with its files.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TrackedImage {
    pub(super) image: Input,
    pub(super) mask: Option<Input>,
    pub(super) frame: TrackedFrame,
}

impl From<TrackedFrame> for TrackedImage {
    fn from(frame: TrackedFrame) -> Self {
        let mask = frame.mask.as_ref().map(Input::from);
        Self { image: Input::from(&frame.image), mask, frame }
    }
}

/// A photograph that is to be read.
#[derive(Debug, Clone, Copy)]
pub(super) enum Frame<'a> {
    Image(&'a Input),
    Tracked(&'a TrackedImage),
}

impl<'a> Frame<'a> {
    pub(super) fn image(self) -> &'a Input {
        match self {
            Self::Image(image) => image,
            Self::Tracked(tracked) => &tracked.image,
        }
    }
}

impl Frames {
    /// - `given`: photographs, or one folder.
    /// - `most`: how many frames to use of a folder, if that is given.
    pub(crate) fn new(given: &[Input], most: Option<u16>) -> Result<Self> {
        /// More photographs don't make a better face, but need memory.
        const MOST_FILES: usize = 64;
        if let [folder] = given
            && let Some(folder) = folder.path().filter(|path| path.is_dir())
        {
            let most = most.unwrap_or(FRAMES).into();
            return Ok(match tracking::detect(folder).or_input()? {
                Some(_) => {
                    let frames = evenly(tracking::read(folder).or_input()?.frames, most);
                    Self::Tracked(frames.into_iter().map(TrackedImage::from).collect())
                }
                None => {
                    let images = evenly(images_in(folder)?, most);
                    Self::Folder(images.into_iter().map(Input::from).collect())
                }
            });
        }
        if most.is_some() {
            return Err(Failure::option(
                "`frames` has no effect on photographs: it needs a folder of frames",
            ));
        }
        if given.len() > MOST_FILES {
            let count = given.len();
            return Err(Failure::input(format!(
                "must be at most {MOST_FILES} photographs, got {count}"
            )));
        }
        for (index, input) in given.iter().enumerate() {
            if input.path().is_some_and(Path::is_dir) {
                return Err(Failure::input(format!(
                    "{input}: a folder of frames must be the only photograph given"
                )));
            }
            if input.path().is_some() && given[..index].contains(input) {
                return Err(Failure::input(format!("{input}: photograph given twice")));
            }
        }
        Ok(Self::Files(given.to_vec()))
    }

    /// The images.
    pub(super) fn iter(&self) -> impl Iterator<Item = Frame<'_>> {
        let (images, tracked): (&[Input], &[TrackedImage]) = match self {
            Self::Files(images) | Self::Folder(images) => (images, &[]),
            Self::Tracked(frames) => (&[], frames),
        };
        let images = images.iter().map(Frame::Image);
        images.chain(tracked.iter().map(Frame::Tracked))
    }

    /// All that is read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Input> {
        self.iter().flat_map(|frame| {
            let mask = match frame {
                Frame::Image(_) => None,
                Frame::Tracked(tracked) => tracked.mask.as_ref(),
            };
            [frame.image()].into_iter().chain(mask)
        })
    }
}

/// At most so many of the frames, evenly spaced, the first and the last among them.
fn evenly<T>(frames: Vec<T>, most: usize) -> Vec<T> {
    let count = frames.len();
    if count <= most {
        return frames;
    }
    let gaps = most.saturating_sub(1).max(1);
    let mut wanted = (0..most).map(|k| (k * (count - 1) + gaps / 2) / gaps).peekable();
    let is_wanted = |(index, frame)| wanted.next_if_eq(&index).map(|_| frame);
    frames.into_iter().enumerate().filter_map(is_wanted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_evenly_spaced() {
        let numbers = |count: usize| (0..count).collect::<Vec<_>>();
        assert_eq!(evenly(numbers(3), 9), [0, 1, 2]);
        assert_eq!(evenly(numbers(101), 3), [0, 50, 100]);
        assert_eq!(evenly(numbers(10), 9).len(), 9);
        assert_eq!(evenly(numbers(1000), 9), [0, 125, 250, 375, 500, 624, 749, 874, 999]);
        assert_eq!(evenly(numbers(5), 1), [0]);
    }

    #[test]
    fn folders_hold_frames_and_files_are_given_once() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.jpg", "a.png", ".c.png", "notes.txt"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let at = |name: &str| Input::from(folder.path().join(name));
        let whole = Input::from(folder.path());
        let frames = Frames::new(std::slice::from_ref(&whole), None).unwrap();
        assert_eq!(frames, Frames::Folder(vec![at("a.png"), at("b.jpg")]));
        assert_eq!(frames.inputs().count(), 2);
        let one = Frames::new(std::slice::from_ref(&whole), Some(1)).unwrap();
        assert_eq!(one.inputs().count(), 1);
        Frames::new(&[at("a.png"), whole], None).unwrap_err();
        Frames::new(&[at("a.png"), at("a.png")], None).unwrap_err();
        let error = Frames::new(&[at("a.png")], Some(9)).unwrap_err().to_string();
        assert!(error.contains("needs a folder"), "{error}");
    }
}
