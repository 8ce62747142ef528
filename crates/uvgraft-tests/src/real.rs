//! Real meshes, which their licences keep out of the repository; `UVGRAFT_DATA` names their folder.

use std::path::PathBuf;
use std::sync::Arc;

use uvgraft::Pair;

/// The folder of real data; `None`, with a message, if `UVGRAFT_DATA` is not set.
pub fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("UVGRAFT_DATA").map(PathBuf::from);
    if folder.is_none() {
        #[expect(clippy::print_stderr, reason = "a skipped test must be visible")]
        {
            eprintln!("skipped: UVGRAFT_DATA is not set, so there are no real meshes to test with");
        }
    }
    folder
}

/// FLAME as the source and SMPL-X as the target, linked by their vertex ids.
///
/// # Panics
/// If a file in the folder is missing or invalid.
pub fn flame_to_smplx() -> Option<Arc<Pair>> {
    let folder = folder()?;
    let mesh = |name: &str| uvgraft_io::obj::read(folder.join(name)).expect("a sound mesh");
    let ids = uvgraft_io::vertex_map::read(folder.join("smplx_flame_vertex_ids.npy"));
    let pair = Pair::by_vertex_map(
        mesh("flame_head_template.obj"),
        mesh("smplx_addon.obj"),
        &ids.expect("a sound vertex map"),
    );
    Some(Arc::new(pair.expect("a head that is part of the body")))
}
