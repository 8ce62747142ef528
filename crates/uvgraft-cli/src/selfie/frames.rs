//! Which files are photographs: those given, and frames of folders.

use std::path::{Path, PathBuf};

use uvgraft_io::tracking::{self, TrackedFrame};
use uvgraft_pipeline::images_in;

use super::options::PhotoArgs;
use crate::failure::{OrBadInput, bad_input};

/// The photographs that arguments stand for.
#[derive(Debug, PartialEq)]
pub(crate) enum Frames {
    /// Files, each of which must show a face.
    Files(Vec<PathBuf>),
    /// Frames of a folder, of which those without a face are left out.
    Folder(Vec<PathBuf>),
    /// Frames of a tracked video, likewise.
    Tracked(Vec<TrackedFrame>),
}

/// A photograph that is to be read.
#[derive(Debug, Clone, Copy)]
pub(super) enum Frame<'a> {
    Image(&'a Path),
    Tracked(&'a TrackedFrame),
}

impl<'a> Frame<'a> {
    pub(super) fn path(self) -> &'a Path {
        match self {
            Self::Image(path) => path,
            Self::Tracked(frame) => &frame.image,
        }
    }
}

impl Frames {
    /// - `given`: files, or one folder.
    /// - `args`: how many frames to use of a folder.
    pub(crate) fn new(given: &[PathBuf], args: &PhotoArgs) -> anyhow::Result<Self> {
        Self::at_most(given, args.frames.into())
    }

    fn at_most(given: &[PathBuf], most: usize) -> anyhow::Result<Self> {
        /// More photographs don't make a better face, but need memory.
        const MOST_FILES: usize = 64;
        if let [folder] = given
            && folder.is_dir()
        {
            return Ok(match tracking::detect(folder).or_bad_input()? {
                Some(_) => {
                    Self::Tracked(evenly(tracking::read(folder).or_bad_input()?.frames, most))
                }
                None => Self::Folder(evenly(images_in(folder)?, most)),
            });
        }
        if given.len() > MOST_FILES {
            let count = given.len();
            return Err(bad_input(format!(
                "must be at most {MOST_FILES} photographs, got {count}"
            )));
        }
        for (index, path) in given.iter().enumerate() {
            if path.is_dir() {
                let path = path.display();
                return Err(bad_input(format!(
                    "{path}: a folder of frames must be the only photograph given"
                )));
            }
            if given[..index].contains(path) {
                return Err(bad_input(format!("{}: photograph given twice", path.display())));
            }
        }
        Ok(Self::Files(given.to_vec()))
    }

    /// The images.
    pub(super) fn iter(&self) -> impl Iterator<Item = Frame<'_>> {
        let (images, tracked): (&[PathBuf], &[TrackedFrame]) = match self {
            Self::Files(paths) | Self::Folder(paths) => (paths, &[]),
            Self::Tracked(frames) => (&[], frames),
        };
        let images = images.iter().map(|path| Frame::Image(path));
        images.chain(tracked.iter().map(Frame::Tracked))
    }

    /// All files that are read.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        self.iter().flat_map(|frame| {
            let mask = match frame {
                Frame::Image(_) => None,
                Frame::Tracked(frame) => frame.mask.as_deref(),
            };
            [frame.path()].into_iter().chain(mask)
        })
    }

    /// Rejects photographs that are missing.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        for path in self.files() {
            if let Err(error) = path.metadata() {
                return Err(bad_input(format!("{}: {error}", path.display())));
            }
        }
        Ok(())
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
        let at = |name: &str| folder.path().join(name);
        let frames = Frames::at_most(&[folder.path().to_path_buf()], 9).unwrap();
        assert_eq!(frames, Frames::Folder(vec![at("a.png"), at("b.jpg")]));
        assert_eq!(frames.files().count(), 2);
        Frames::at_most(&[at("a.png"), folder.path().to_path_buf()], 9).unwrap_err();
        Frames::at_most(&[at("a.png"), at("a.png")], 9).unwrap_err();
    }
}
