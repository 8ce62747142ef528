//! The bound on memory: what work may need, and textures that wait for their share.
//!
//! The estimates are upper bounds, measured with margins. Memory that is already in use counts as it
//! is, where the system tells.

use std::fs::Metadata;
use std::path::Path;
use std::sync::{Condvar, Mutex, PoisonError};

use uvgraft::{Averaging, Depth, Encoding, Size, TexelFormat, threads};
use uvgraft_files::input::Input;
use uvgraft_image::{self as image, Format, Header};

use crate::base::{Base, BaseOptions, bytes_of};
use crate::base_source::BaseSource;
use crate::failure::{Failure, Result};
use crate::link::Link;
use crate::plan::{Batch, Job};
use crate::shared::Options;
use crate::transfer::Transfer;
use crate::unchanged::Unchanged;

/// For textures processed at once, if the caller has no bound; a larger one is processed alone.
const TOGETHER: u64 = 2 << 30;

/// Bands of rows of a texture, the queue to the encoder, and the graft.
const BANDS: u64 = 24 << 20;

/// Stacks and buffers of a thread.
const THREAD: u64 = 6 << 20;

/// The program itself, where the system does not tell.
const PROGRAM: u64 = 32 << 20;

/// Of each vertex of the target, for a blend and for its tone: systems of equations and their
/// factors.
const BLEND_PER_VERTEX: u64 = 6 << 10;
const TONE_PER_VERTEX: u64 = 8 << 10;

/// Memory that the process has now.
fn in_use() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = resident.and_then(|text| text.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kib.map_or(PROGRAM, |kib| kib << 10)
}

/// Memory that the process has now, and that its threads will need: what a bound on memory leaves none of.
pub fn memory_taken() -> u64 {
    in_use() + of_threads()
}

/// Bytes of a bound on memory such as 500M or 4G.
///
/// # Errors
/// What it must be, for anything else.
pub fn parse_memory(text: &str) -> std::result::Result<u64, String> {
    let wanted = || "must be a size such as 500M or 4G".to_owned();
    let (digits, unit) = match text.char_indices().last() {
        Some((end, last)) if last.is_ascii_alphabetic() => (&text[..end], last),
        _ => (text, 'B'),
    };
    let power = match unit.to_ascii_uppercase() {
        'B' => 0,
        'K' => 1,
        'M' => 2,
        'G' => 3,
        'T' => 4,
        _ => return Err(wanted()),
    };
    let number: u64 = digits.parse().map_err(|_| wanted())?;
    number.checked_mul(1 << (10 * power)).filter(|&bytes| bytes > 0).ok_or_else(wanted)
}

impl Transfer {
    /// Checks that a batch can be within the bound, before its base is decoded and its blend
    /// prepared.
    ///
    /// - `header`: that of the base, if it is an image.
    pub(crate) fn check_memory(
        &self,
        batch: &Batch,
        link: &Link,
        base: &BaseOptions<'_>,
        header: Option<Header>,
    ) -> Result<()> {
        let Some(bound) = self.memory else { return Ok(()) };
        let size = base.size.or_else(|| header.map(|header| header.size));
        let base = header.map_or(0, |header| base_bytes(base, header, self.keeps_base(batch)));
        let target = size.unwrap_or(Size::square(1));
        let blend = match (&self.blending, link.pair()) {
            (Some(blending), Some(pair)) => {
                let vertices = pair.to(self.direction).positions().len() as u64;
                let tone = if blending.needs_colors() { TONE_PER_VERTEX } else { 0 };
                vertices * (BLEND_PER_VERTEX + tone) + 2 * target.texels() as u64
            }
            _ => 0,
        };
        let options = Options::new(self, batch.values);
        // Of several textures, each is checked when it is its turn.
        let texture = match &*batch.jobs {
            [job] => needed(job, target, header.map(|header| header.depth), &options),
            _ => 0,
        };
        check_memory("the transfer", bound, base + blend + texture)
    }

    /// The budget of the textures of a batch, whose base and blend are in memory.
    pub(crate) fn budget(&self, base: &Base, unchanged: Option<&Unchanged>) -> Memory {
        let unchanged = unchanged.map_or(0, Unchanged::limit);
        let (limit, common) = match self.memory {
            Some(bound) => (bound, memory_taken() + unchanged),
            None => (TOGETHER, base.bytes() + unchanged),
        };
        Memory::new(limit, common, self.memory.is_some())
    }
}

fn of_threads() -> u64 {
    threads::count() as u64 * THREAD
}

/// Refuses work that could exceed a bound on memory, before it starts.
///
/// - `work`: what is refused, such as `"the transfer"`.
/// - `bound`: the most memory that the process may have, in bytes.
/// - `needed`: what the work takes at most, in bytes, beside what the process has now and its threads.
///
/// # Errors
/// As bad input, with both numbers.
pub fn check_memory(work: &str, bound: u64, needed: u64) -> Result<()> {
    refuse_beyond(work, bound, memory_taken() + needed)
}

fn refuse_beyond(work: &str, bound: u64, needed: u64) -> Result<()> {
    if needed <= bound {
        return Ok(());
    }
    let megabytes = needed.div_ceil(1 << 20);
    Err(Failure::option(format!(
        "{work} may take {megabytes} MiB of memory, but `memory` allows {}; add `memory` \
         {megabytes}M, or use smaller textures",
        bound >> 20
    )))
}

/// Upper bound of the bytes that decoding a base takes and leaves.
fn base_bytes(options: &BaseOptions<'_>, header: Header, keeps: bool) -> u64 {
    let target = options.size.unwrap_or(header.size);
    let is_resized = target != header.size;
    let decoded = decoded_bytes(options.onto.and_then(BaseSource::as_image), &header);
    let resized = TexelFormat {
        channels: header.channels,
        depth: if is_resized { Depth::F32 } else { header.depth },
        encoding: Encoding::Srgb,
    };
    if is_resized {
        decoded + bytes_of(target, resized) + bytes_of(header.size, resized) / 2
    } else if keeps || header.format.codec().is_decoded_whole() {
        decoded
    } else {
        BANDS
    }
}

/// Upper bound of the bytes that an image takes while it is decoded.
///
/// - `image`: where it comes from. One that is in memory already is counted as it is.
pub fn decoded_bytes(image: Option<&Input>, header: &Header) -> u64 {
    let file = image.and_then(Input::path).and_then(|path| path.metadata().ok());
    // Read as a whole, and copied in part by decoders, but for those of rows.
    let copies = if header.format.codec().is_decoded_whole() { 2 } else { 0 };
    copies * file.map_or(0, |found| found.len()) + header.decoding_bytes
}

/// Upper bound of the bytes that a texture takes. Unreadable files need hardly any, since they fail
/// early.
pub(crate) fn needed(job: &Job, target: Size, base: Option<Depth>, options: &Options) -> u64 {
    let Job { source, output } = job;
    // A pipe can be read only once.
    let is_file = |path: &Path| path.metadata().as_ref().is_ok_and(Metadata::is_file);
    if !source.path().is_none_or(is_file) {
        return BANDS;
    }
    let Ok(header) = image::read_header(source) else { return BANDS };
    let texels = header.size.texels() as u64;
    let target = target.texels() as u64;
    let depth = base.unwrap_or(header.depth).max(header.depth);
    let value = if depth > Depth::U8 || options.averaging == Averaging::Light { 4 } else { 1 };
    // Once as decoded and once as processed: with the channels of both, as floats if the formats
    // differ; and what it shows, if a blend asks.
    let source = decoded_bytes(Some(source), &header) + texels * (4 * value + 2);
    // The solver keeps at most five float textures on either side.
    let fit = if options.fit.is_some() { (texels + target) * 4 * 4 * 5 } else { 0 };
    // Collected before encoding, and as what the encoder makes of it.
    let is_collected =
        Format::from_path(output).is_some_and(|format| format.codec().is_encoded_whole());
    let collected = if is_collected { 2 * target * 4 * value } else { 0 };
    BANDS + source + fit + collected
}

/// A memory budget shared by all textures.
pub(crate) struct Memory {
    limit: u64,
    /// What everything but textures takes, also of the limit.
    common: u64,
    is_bound: bool,
    used: Mutex<u64>,
    freed: Condvar,
}

/// A share of the budget, returned on drop.
pub(crate) struct Reservation<'a> {
    memory: &'a Memory,
    bytes: u64,
}

impl Memory {
    fn new(limit: u64, common: u64, is_bound: bool) -> Self {
        Self { limit, common, is_bound, used: Mutex::new(common), freed: Condvar::new() }
    }

    /// Waits for a share of the budget. A request beyond the whole budget is granted alone, unless
    /// the budget is a bound.
    ///
    /// # Errors
    /// As bad input for such a request, if the budget is a bound.
    pub(crate) fn take(&self, bytes: u64) -> Result<Reservation<'_>> {
        if self.is_bound {
            refuse_beyond("the transfer", self.limit, self.common + bytes)?;
        }
        let used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        let is_full = |used: &mut u64| *used > self.common && *used + bytes > self.limit;
        let used = self.freed.wait_while(used, is_full);
        *used.unwrap_or_else(PoisonError::into_inner) += bytes;
        Ok(Reservation { memory: self, bytes })
    }
}

impl Drop for Reservation<'_> {
    fn drop(&mut self) {
        *self.memory.used.lock().unwrap_or_else(PoisonError::into_inner) -= self.bytes;
        self.memory.freed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_refuses_and_a_default_makes_wait() {
        let bound = Memory::new(100 << 20, 60 << 20, true);
        let share = bound.take(40 << 20).unwrap();
        drop(share);
        let refused = bound.take((40 << 20) + 1).map(drop).unwrap_err();
        let wanted = "the transfer may take 101 MiB of memory, but `memory` allows 100; add \
                      `memory` 101M, or use smaller textures";
        assert_eq!(refused.to_string(), wanted);
        // Alone, but not with another.
        let default = Memory::new(100, 60, false);
        let large = default.take(1000).unwrap();
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| default.take(1).map(drop));
            std::thread::sleep(std::time::Duration::from_millis(30));
            assert!(!waiting.is_finished());
            drop(large);
            waiting.join().unwrap().unwrap();
        });
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_is_in_use_is_known() {
        let before = in_use();
        let block = vec![1u8; 64 << 20];
        assert!(in_use() > before + (48 << 20), "{}", block[9]);
    }
}
