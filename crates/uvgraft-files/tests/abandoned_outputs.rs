//! Abandoning all outputs, which a process does only once; so this test has its own binary.

use std::io::{ErrorKind, Write};

use uvgraft_files::output::{AtomicFile, abandon_unfinished, write_atomically};

#[test]
fn nothing_is_left_and_nothing_begins() {
    let folder = tempfile::tempdir().unwrap();
    let names = || {
        let names = folder.path().read_dir().unwrap().map(|entry| entry.unwrap().file_name());
        let mut names: Vec<_> = names.collect();
        names.sort();
        names
    };
    let [old, done, other] = ["old", "done", "other"].map(|name| folder.path().join(name));
    std::fs::write(&old, b"old").unwrap();
    write_atomically::<std::io::Error>(&done, |out| out.write_all(b"done")).unwrap();
    let mut half = AtomicFile::create(&old).unwrap();
    half.write_all(b"half").unwrap();
    let dropped_later = AtomicFile::create(&other).unwrap();
    // Two more where files cannot be without names.
    assert!([2, 4].contains(&names().len()), "{:?}", names());

    abandon_unfinished();
    assert_eq!(names(), ["done", "old"]);
    assert_eq!(half.commit().unwrap_err().kind(), ErrorKind::Interrupted);
    drop(dropped_later);
    assert_eq!(AtomicFile::create(&other).unwrap_err().kind(), ErrorKind::Interrupted);
    abandon_unfinished();
    assert_eq!(names(), ["done", "old"]);
    assert_eq!(std::fs::read(&old).unwrap(), b"old");
    assert_eq!(std::fs::read(&done).unwrap(), b"done");
}
