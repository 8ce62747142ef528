//! Imports point one way: ARCHITECTURE.md gives the order, of the modules of the core's two crates and of
//! all crates, and the sources keep to it.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

#[path = "imports/sources.rs"]
mod sources;

use sources::{Graph, Modules, names};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A section of ARCHITECTURE.md.
fn section(heading: &str) -> String {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let text = text.split_once(&format!("\n## {heading}\n")).expect("the section exists").1;
    text.split("\n## ").next().unwrap().to_owned()
}

/// A circle of imports, from its first member back to it; `None` if there is none.
fn circle(graph: &Graph) -> Option<Vec<&str>> {
    fn visit<'a>(
        graph: &'a Graph,
        at: &'a str,
        way: &mut Vec<&'a str>,
        done: &mut BTreeSet<&'a str>,
    ) -> bool {
        if let Some(start) = way.iter().position(|&one| one == at) {
            way.drain(..start);
            way.push(at);
            return true;
        }
        way.push(at);
        let imports = graph.get(at).into_iter().flat_map(BTreeMap::keys);
        for next in imports.filter(|next| next.as_str() != at) {
            if !done.contains(next.as_str()) && visit(graph, next, way, done) {
                return true;
            }
        }
        way.pop();
        done.insert(at);
        false
    }
    let (mut way, mut done) = (Vec::new(), BTreeSet::new());
    graph.keys().any(|start| visit(graph, start, &mut way, &mut done)).then_some(way)
}

/// What in a graph contradicts an order, in which each may import those before it.
fn against(order: &[String], graph: &Graph) -> Vec<String> {
    let mut wrong = Vec::new();
    let places: BTreeMap<&String, usize> = order.iter().zip(0..).collect();
    if places.len() < order.len() {
        wrong.push("the order names something twice".to_owned());
    }
    wrong.extend(
        order.iter().filter(|name| !graph.contains_key(*name)).map(|name| format!("no {name}")),
    );
    for (name, imports) in graph {
        let Some(place) = places.get(name) else {
            wrong.push(format!("{name} has no place in the order"));
            continue;
        };
        for (import, example) in imports {
            if places.get(import).is_some_and(|before| before >= place) {
                wrong.push(format!("{name} imports {import}, which is not before it: {example}"));
            }
        }
    }
    wrong
}

/// The modules of a crate in the order of a section of ARCHITECTURE.md: lines of a group's name and its
/// modules.
fn order_of_modules(heading: &str) -> Vec<String> {
    let text = section(heading);
    let lines = text.lines().filter_map(|line| line.strip_prefix("    "));
    let modules =
        lines.flat_map(|line| line.split_once("  ").expect("a group's name").1.split(','));
    modules.map(|name| name.trim().to_owned()).collect()
}

/// The imports among the modules of a crate of the core, and among the children of each; there are no
/// circles.
fn imports_in(name: &str) -> BTreeMap<Vec<String>, Graph> {
    let folder = root().join("crates").join(name).join("src");
    let mut modules = Modules::default();
    modules.read(&Vec::new(), &folder.join("lib.rs"), &folder);
    let graphs = modules.graphs();
    for (parent, graph) in &graphs {
        assert_eq!(circle(graph), None, "among the modules of {parent:?}: {graph:#?}");
    }
    graphs
}

#[test]
fn modules_of_the_core_keep_to_the_order() {
    let graphs = imports_in("uvgraft-surface");
    let graph = &graphs[&Vec::new()];
    assert!(graph["correspond"].contains_key("pair"), "{graph:?}");
    assert_eq!(against(&order_of_modules("Surfaces"), graph), [""; 0]);

    let graphs = imports_in("uvgraft");
    let graph = &graphs[&Vec::new()];
    assert!(
        graph["graft"].contains_key("blend") && graph["blend"].contains_key("map"),
        "{graph:?}"
    );
    assert!(graphs[&vec!["resample".to_owned()]]["fast"].contains_key("stretch"), "{graphs:?}");
    assert_eq!(against(&order_of_modules("The core"), graph), [""; 0]);
}

/// The crates and their dependencies, and their dev-dependencies.
fn crates() -> [Graph; 2] {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--no-deps", "--format-version", "1", "--manifest-path"])
        .arg(root().join("Cargo.toml"))
        .output()
        .unwrap();
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    // The table names the package of Python by its folder.
    let name = |value: &serde_json::Value| match value["name"].as_str().unwrap() {
        "uvgraft-python" => "bindings/python".to_owned(),
        name => name.to_owned(),
    };
    [false, true].map(|is_dev| {
        let imports = |package: &serde_json::Value| {
            let all = package["dependencies"].as_array().unwrap().iter();
            let all = all.filter(|it| !it["path"].is_null() && (it["kind"] == "dev") == is_dev);
            all.map(|it| (name(it), "Cargo.toml".to_owned())).collect()
        };
        packages.iter().map(|package| (name(package), imports(package))).collect()
    })
}

/// The names in backticks.
fn quoted(text: &str) -> Vec<String> {
    text.split('`').skip(1).step_by(2).map(ToOwned::to_owned).collect()
}

#[test]
fn crates_keep_to_the_order() {
    let text = section("Crates");
    let rows = text.lines().filter(|line| line.starts_with("| `"));
    let order: Vec<String> = rows.map(|row| quoted(row)[0].clone()).collect();
    let [normal, dev] = crates();
    assert!(normal["uvgraft-cli"].contains_key("uvgraft"), "{normal:?}");
    assert_eq!(against(&order, &normal), [""; 0]);

    // Circles, of dev-dependencies alone, are listed with their reasons.
    let circles: Vec<&str> = text.lines().filter(|line| line.starts_with("- `")).collect();
    assert!(circles.len() <= 2, "{circles:?}");
    let mut allowed = BTreeSet::new();
    for circle in circles {
        let (imports, reason) = circle.split_once(": ").expect("a reason");
        assert!(reason.len() > 20, "{circle}");
        let (from, to) = imports.split_once('→').expect("what imports what");
        for from in quoted(from) {
            allowed.extend(quoted(to).into_iter().map(|to| (from.clone(), to)));
        }
    }
    let place = |name: &String| order.iter().position(|it| it == name).unwrap();
    let all =
        dev.iter().flat_map(|(name, all)| all.keys().map(move |it| (name.clone(), it.clone())));
    let found: BTreeSet<_> = all.filter(|(name, import)| place(import) >= place(name)).collect();
    assert_eq!(found.difference(&allowed).collect::<Vec<_>>(), [] as [&(String, String); 0]);
    // Each crate and each import that is listed is one.
    for (from, to) in &allowed {
        assert!(found.iter().any(|it| it.0 == *from), "{from} has no such import");
        assert!(found.iter().any(|it| it.1 == *to), "nothing has such an import of {to}");
    }
}

fn graph(imports: &[(&str, &[&str])]) -> Graph {
    let all = |to: &[&str]| to.iter().map(|to| ((*to).to_owned(), "a line".to_owned())).collect();
    imports.iter().map(|(from, to)| ((*from).to_owned(), all(to))).collect()
}

#[test]
fn circles_are_found() {
    let one_way = graph(&[("a", &[]), ("b", &["a"]), ("c", &["a", "b"]), ("d", &["b"])]);
    assert_eq!(circle(&one_way), None);
    let round = graph(&[("a", &["d"]), ("b", &["a"]), ("c", &["a", "b"]), ("d", &["c"])]);
    assert_eq!(circle(&round).unwrap(), ["a", "d", "c", "a"]);
}

#[test]
fn imports_against_the_order_are_found() {
    let found = graph(&[("a", &[]), ("b", &["a"]), ("c", &["a", "b"])]);
    assert_eq!(against(&names("a b c"), &found), [""; 0]);
    let wrong = against(&names("a c b"), &found);
    assert_eq!(wrong, ["c imports b, which is not before it: a line"]);
    assert_eq!(against(&names("a b"), &found), ["c has no place in the order"]);
    assert_eq!(against(&names("a b c d"), &found), ["no d"]);
    assert_eq!(against(&names("a b b c"), &found), ["the order names something twice"]);
}
