//! The bound on the memory of what shows scenes.

use uvgraft_files::input::ReadError;
use uvgraft_gltf::scene::{Budget, MemoryShares, SceneError};
use uvgraft_pipeline::{Blame, Failure, Result, memory_taken};

/// A bound on the memory of the process.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bound {
    /// As requested, in bytes.
    memory: Option<u64>,
    /// What the process has, and will need for anything but the scene.
    taken: u64,
}

impl Bound {
    /// - `memory`: bytes; without it, a file may take memory by its size.
    /// - `others`: bytes that are needed for anything but the scene.
    pub fn new(memory: Option<u64>, others: u64) -> Self {
        Self { memory, taken: memory_taken().saturating_add(others) }
    }

    /// What is left for a scene.
    pub fn budget(&self) -> Budget {
        let left = |memory: u64| Budget::bytes(memory.saturating_sub(self.taken));
        self.memory.map_or_else(Budget::default, left)
    }

    /// The result of loading a scene.
    pub fn loaded<T>(&self, result: std::result::Result<T, ReadError<SceneError>>) -> Result<T> {
        match result {
            Err(ReadError::Content { path, reason: SceneError::Memory { shares } }) => {
                Err(self.too_much(&shares).context(path.display()))
            }
            result => result.or_input(),
        }
    }

    /// The result of reading a scene in memory.
    pub fn read<T>(&self, result: std::result::Result<T, SceneError>) -> Result<T> {
        match result {
            Err(SceneError::Memory { shares }) => Err(self.too_much(&shares)),
            result => result.or_input(),
        }
    }

    fn too_much(&self, shares: &MemoryShares) -> Failure {
        let mib = |bytes: u64| bytes.div_ceil(1 << 20);
        let needed = mib(shares.needed().saturating_add(self.taken));
        let allowed = match self.memory {
            Some(memory) => format!("`memory` allows {}", memory >> 20),
            None => format!("a file of its size may take {}", shares.max() >> 20),
        };
        let of_parts = shares.by_purpose();
        Failure::option(format!(
            "may take {needed} MiB of memory, {of_parts}, but {allowed}; if that is right, add \
             `memory` {needed}M"
        ))
    }
}
