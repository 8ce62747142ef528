//! Meshes of files in which some polygons have no UV coordinates.

use uvgraft::mesh::{Mesh, MeshPart};

/// The polygons of a file that have UV coordinates, and what the others are.
#[derive(Debug, Clone, PartialEq)]
pub struct TexturedMesh {
    /// The polygons with UV coordinates.
    pub mesh: Mesh,
    /// What the mesh lacks of the file.
    pub without_uv: WithoutUv,
}

/// Polygons without UV coordinates, on which no texture can be.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct WithoutUv {
    /// Number of polygons.
    pub polygons: usize,
    /// Their names, as far as the file has any. Polygons are numbered among those without UV
    /// coordinates.
    pub parts: Vec<MeshPart>,
}

impl WithoutUv {
    /// Adds polygons of a part. Consecutive ones of the same names are one part.
    pub fn add(&mut self, [object, group, material]: [&str; 3], polygons: usize) {
        let count = |polygons: usize| u32::try_from(polygons).unwrap_or(u32::MAX);
        let start = count(self.polygons);
        self.polygons += polygons;
        let end = count(self.polygons);
        match self.parts.last_mut() {
            Some(last)
                if [&*last.object, &last.group, &last.material] == [object, group, material] =>
            {
                last.polygons.end = end;
            }
            _ => self.parts.push(MeshPart {
                object: object.to_owned(),
                group: group.to_owned(),
                material: material.to_owned(),
                image: None,
                polygons: start..end,
            }),
        }
    }

    /// Only some of the parts.
    #[must_use]
    pub fn only_parts(&self, is_kept: impl Fn(&MeshPart) -> bool) -> Self {
        let mut kept = Self::default();
        for part in self.parts.iter().filter(|part| is_kept(part)) {
            kept.add([&part.object, &part.group, &part.material], part.polygons.len());
        }
        kept
    }

    /// The names of parts, quoted, for a message; empty if they have none.
    ///
    /// - `kept`: the parts with UV coordinates, from which the names are to tell the others apart.
    pub fn listed(&self, kept: &[MeshPart]) -> String {
        /// Names listed, and characters shown of each.
        const SHOWN: usize = 5;
        const LENGTH: usize = 40;
        let names = self.names(kept);
        let quoted = |name: &&str| format!("{:?}", name.chars().take(LENGTH).collect::<String>());
        let shown: Vec<String> = names.iter().take(SHOWN).map(quoted).collect();
        let shown = shown.join(", ");
        match names.len().saturating_sub(SHOWN) {
            0 => shown,
            more => format!("{shown} and {more} more"),
        }
    }

    /// The first name of each part that none of the others has, or else its first name, without
    /// repetition.
    fn names(&self, kept: &[MeshPart]) -> Vec<&str> {
        fn given(part: &MeshPart) -> [&str; 3] {
            [&part.object, &part.group, &part.material]
        }
        let mut names = Vec::new();
        for part in &self.parts {
            let names_of_part = given(part);
            let of_part = || (0..3).filter(|&kind| !names_of_part[kind].is_empty());
            let tells_apart =
                |kind: &usize| kept.iter().all(|kept| given(kept)[*kind] != names_of_part[*kind]);
            let chosen = of_part().find(tells_apart).or_else(|| of_part().next());
            let name = chosen.map(|kind| names_of_part[kind]);
            names.extend(name.filter(|name| !names.contains(name)));
        }
        names
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_are_counted_by_name() {
        let mut found = WithoutUv::default();
        found.add(["hair", "", "brown"], 2);
        found.add(["hair", "", "brown"], 1);
        found.add(["", "", "cap"], 1);
        assert_eq!((found.polygons, found.parts.len()), (4, 2));
        assert_eq!(found.parts[1].polygons, 3..4);
        assert_eq!(found.listed(&[]), "\"hair\", \"cap\"");
        let cap_part = found.parts[1].clone();
        let cap = found.only_parts(|part| part.material == "cap");
        assert_eq!((cap.parts[0].polygons.clone(), &*cap.listed(&[])), (0..1, "\"cap\""));
        // A window of a car has the object's name, and so has the rest of the car.
        let mut window = WithoutUv::default();
        window.add(["car", "", "glass"], 1);
        assert_eq!(window.listed(&[]), "\"car\"");
        assert_eq!(
            window.listed(&[MeshPart { object: "car".to_owned(), ..cap_part }]),
            "\"glass\""
        );
        let mut many = WithoutUv::default();
        (0..9).for_each(|k| many.add([&format!("part {k}"), "", ""], 1));
        assert!(many.listed(&[]).ends_with("\"part 4\" and 4 more"), "{}", many.listed(&[]));
        let mut unnamed = WithoutUv::default();
        unnamed.add([""; 3], 7);
        assert_eq!(unnamed.listed(&[]), "");
    }
}
