//! The visibility of a texture's seams, with the numbers of `uvgraft seams`.

use std::sync::Arc;

use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use uvgraft::{Anatomy, Area, Blend, BlendDomain, BlendOptions, Texture};
use uvgraft_metrics::seams::{
    EdgeGroup, Offset, SeamEdge, SeamNotes, SeamOptions, SeamReport, SkinColors, Step, ToneMatch,
    ToneReferences, TransferredFace, measure, measure_tone,
};

use crate::arguments::{color_encoding, direction};
use crate::arrays::texture;
use crate::error::{bad_value, failed, of_graft};
use crate::graft::Graft;
use crate::pair::{self, Pair};
use crate::region::selection;
use crate::threads;

/// Most edges to list of each kind, as in the command.
const MAX_WORST: usize = 1000;

/// Measure how visible the seams of a texture are, as the command ``uvgraft seams``.
///
/// Colours are sampled on both sides of mesh edges: along UV seams, along the boundary of the
/// transferred region, and, for comparison, along ordinary edges, where the texture's own detail is the
/// only difference. Edges are weighted by their length on the surface. On a mesh with a head, the skin
/// tone is assessed too: a good blend hides the boundary even where the face has the wrong colour.
///
/// Colours are compared in sRGB, ignoring alpha; points with a transparent side are skipped.
///
/// Parameters
/// ----------
/// pair : Pair, path or Graft
///     The meshes: a pair, or a pair file; of a graft its pair, direction and region.
/// texture : ndarray, PIL image or path
///     In the target's layout, or in the source's if reversed.
/// reverse : bool
///     The texture is in the layout of the pair's source; for a `Pair`.
/// region : Region, optional
///     The part of the surface whose boundary is measured; by default the graft's, or everything linked.
/// offset : float, optional
///     Distance from the edge at which colours are sampled on each side, in texels and within the UV
///     island; by default 1.
/// distance : float, optional
///     The same in the mesh's unit along the surface, across UV seams, in place of `offset`; at most the
///     mesh's largest dimension.
/// base : ndarray, PIL image or path, optional
///     The base before the transfer, of the texture's height and width, for comparing its tone.
/// face : ndarray, PIL image or path, optional
///     The texture before the transfer, in the other layout, of any size, for comparing its colours.
/// worst : int
///     Maximum number of worst edges to list, for UV seams and for the boundary each, 0 to 1000.
/// encoding : {"srgb", "linear"}
///     Encoding of colours in arrays; files have their own.
/// threads : int, optional
///     Number of threads, 0 for one per processor; see `set_threads`. It does not affect the result.
///
/// Returns
/// -------
/// Seams
///     Differences in ΔE 2000 by kind of edge, the worst edges, and the match of skin tones.
///
/// Raises
/// ------
/// TypeError
///     For other types and dtypes.
/// ValueError
///     If sizes differ, a value is out of range, or a region refers to vertices that do not exist.
/// OSError
///     For files that cannot be read.
/// uvgraft.Error
///     If no linked triangle is left in the region.
#[pyfunction]
#[pyo3(signature = (
    pair, texture, *, reverse=false, region=None, offset=None, distance=None, base=None, face=None,
    worst=5, encoding="srgb", threads=None
))]
pub(crate) fn seams<'py>(
    py: Python<'py>,
    pair: &Bound<'py, PyAny>,
    texture: &Bound<'py, PyAny>,
    reverse: bool,
    region: Option<&Bound<'py, PyAny>>,
    offset: Option<f64>,
    distance: Option<f64>,
    base: Option<&Bound<'py, PyAny>>,
    face: Option<&Bound<'py, PyAny>>,
    worst: i64,
    encoding: &str,
    threads: Option<i64>,
) -> PyResult<Bound<'py, PyAny>> {
    let of_graft = pair.cast::<Graft>().ok().map(|graft| graft.get().region(py)).transpose()?;
    let region = region.cloned().or(of_graft.flatten());
    let (pair, reverse) = pair_of(pair, reverse)?;
    let options = options(offset, distance, worst)?;
    let threads = threads::checked(threads)?;
    let textures = Textures::new(texture, base, face, encoding)?;
    let (pair, direction) = (Arc::clone(&pair.get().file.pair), direction(reverse));
    let domain = threads::run(py, threads, move || BlendDomain::new(pair, direction))?;
    if let Offset::Distance(distance) = options.offset
        && distance > domain.extent()
    {
        let largest = domain.extent();
        return Err(bad_value(format_args!(
            "distance must be at most {largest:.4}, the mesh's largest dimension, got {distance}"
        )));
    }
    let selected = match &region {
        Some(region) => selection(&domain, region)?,
        None => domain.linked(),
    };
    let (report, tone) = threads::run(py, threads, || {
        let blend = Blend::new(&selected, BlendOptions::default()).map_err(failed)?;
        textures.measured(&domain, &blend, &options)
    })??;
    result(py, &report, tone.as_ref())
}

/// A pair and its direction, from a pair or a graft.
fn pair_of<'py>(given: &Bound<'py, PyAny>, reverse: bool) -> PyResult<(Bound<'py, Pair>, bool)> {
    let py = given.py();
    if given.cast::<Graft>().is_err() {
        return Ok((pair::pair(given, "a Pair, a path or a Graft")?, reverse));
    }
    if reverse {
        return Err(bad_value("reverse is for a Pair; a Graft has its own direction"));
    }
    let pair = given.getattr(intern!(py, "pair"))?.cast_into::<Pair>()?;
    Ok((pair, given.getattr(intern!(py, "reverse"))?.extract()?))
}

fn options(offset: Option<f64>, distance: Option<f64>, worst: i64) -> PyResult<SeamOptions> {
    let offset = match (offset, distance) {
        (Some(_), Some(_)) => return Err(bad_value("give either offset or distance, not both")),
        (None, Some(distance)) => Offset::Distance(at_least_0("distance", distance)?),
        (texels, None) => Offset::Texels(at_least_0("offset", texels.unwrap_or(1.0))?),
    };
    let worst =
        usize::try_from(worst).ok().filter(|&count| count <= MAX_WORST).ok_or_else(|| {
            bad_value(format_args!("worst must be from 0 to {MAX_WORST}, got {worst}"))
        })?;
    Ok(SeamOptions::default().offset(offset).worst(worst))
}

fn at_least_0(what: &str, value: f64) -> PyResult<f64> {
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    Err(bad_value(format_args!("{what} must be finite and at least 0, got {value}")))
}

/// Textures given by a user.
struct Textures {
    texture: Texture,
    base: Option<Texture>,
    face: Option<Texture>,
}

impl Textures {
    fn new(
        given: &Bound<'_, PyAny>,
        base: Option<&Bound<'_, PyAny>>,
        face: Option<&Bound<'_, PyAny>>,
        encoding: &str,
    ) -> PyResult<Self> {
        let encoding = color_encoding(encoding)?;
        let read = |given: &Bound<'_, PyAny>, what| {
            texture(given, what, encoding).map(|given| given.texture)
        };
        let optional = |given: Option<&Bound<'_, PyAny>>, what| {
            given.map(|given| read(given, what)).transpose()
        };
        let texture = read(given, "texture")?;
        let base = optional(base, "base")?;
        if let Some(found) = base.as_ref().map(Texture::size).filter(|&it| it != texture.size()) {
            let wanted = texture.size();
            return Err(bad_value(format_args!(
                "base must have the height and width of texture, ({}, {}), got ({}, {})",
                wanted.height, wanted.width, found.height, found.width
            )));
        }
        Ok(Self { texture, base, face: optional(face, "face")? })
    }

    /// Seams, and the match of tones if the mesh has a head.
    fn measured(
        &self,
        domain: &BlendDomain,
        blend: &Blend,
        options: &SeamOptions,
    ) -> PyResult<(SeamReport, Option<ToneMatch>)> {
        let cut = blend.cut().map_err(failed)?;
        let report = measure(&cut.mesh, &self.texture, &cut.inside, options).map_err(bad_value)?;
        let Ok(anatomy) = Anatomy::find(&cut.mesh) else { return Ok((report, None)) };
        let size = self.texture.size();
        let face = self.face.as_ref().map(|face| TransferredFace::new(domain, face, size));
        let face = face.transpose().map_err(of_graft)?;
        let references = ToneReferences { base: self.base.as_ref(), face: face.as_ref() };
        let tone = measure_tone(&cut.mesh, &anatomy, &self.texture, &cut.inside, references);
        Ok((report, Some(tone.map_err(bad_value)?)))
    }
}

/// A `uvgraft.Seams`.
fn result<'py>(
    py: Python<'py>,
    report: &SeamReport,
    tone: Option<&ToneMatch>,
) -> PyResult<Bound<'py, PyAny>> {
    let groups = [
        ("uv_seams", &report.uv_seams),
        ("uv_seams_inside", &report.uv_seams_inside),
        ("rim", &report.rim),
        ("beside_uv_seams", &report.beside_uv_seams),
        ("beside_uv_seams_inside", &report.beside_uv_seams_inside),
        ("beside_rim", &report.beside_rim),
        ("ordinary", &report.ordinary),
    ];
    let fields = PyDict::new(py);
    for (name, found) in groups {
        fields.set_item(name, group(py, found)?)?;
    }
    let worst = report.worst.iter().filter_map(|&index| {
        let edge = report.edges.get(index)?;
        Some(worst_edge(py, edge, edge.worst?))
    });
    fields.set_item("worst", worst.collect::<PyResult<Vec<_>>>()?)?;
    fields.set_item("tone", tone.map(|tone| skin_match(py, tone)).transpose()?)?;
    fields.set_item("notes", notes(py, &report.notes)?)?;
    named(py, "Seams")?.call((), Some(&fields))
}

/// A class of `uvgraft._results`.
fn named<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import(intern!(py, "uvgraft._results"))?.getattr(name)
}

fn group<'py>(py: Python<'py>, found: &EdgeGroup) -> PyResult<Bound<'py, PyAny>> {
    let steps = found
        .delta_e
        .map(|it| named(py, "SeamSteps")?.call1((it.mean, it.median, it.p95, it.p99, it.max)))
        .transpose()?;
    named(py, "EdgeGroup")?.call1((found.edges, found.length, found.points, steps))
}

fn worst_edge<'py>(py: Python<'py>, edge: &SeamEdge, step: Step) -> PyResult<Bound<'py, PyAny>> {
    let values = (
        edge.mean.unwrap_or(step.delta_e),
        step.delta_e,
        edge.length,
        edge.is_uv_seam,
        edge.is_rim,
        both(py, edge.ends)?,
        step.along,
        both(py, step.uv)?,
        both(py, step.sampled)?,
        both(py, step.colors)?,
    );
    named(py, "WorstEdge")?.call1(values)
}

/// Two points or colours as tuples.
fn both<'py, T: IntoPyObject<'py>, const N: usize>(
    py: Python<'py>,
    sides: [[T; N]; 2],
) -> PyResult<Bound<'py, PyTuple>> {
    let [first, second] = sides.map(|values| PyTuple::new(py, values));
    PyTuple::new(py, [first?, second?])
}

fn skin_match<'py>(py: Python<'py>, tone: &ToneMatch) -> PyResult<Bound<'py, PyAny>> {
    let area = |skin: SkinColors| if skin.chest_area == Area::Neck { "neck" } else { "chest" };
    let values = (
        tone.skin.map(|skin| skin.delta_e()),
        tone.own.map(|own| own.delta_e()),
        tone.skin.map(area),
        tone.hair_shift,
        tone.clipped,
        tone.matches_body() && !tone.is_clipped(),
    );
    named(py, "SkinMatch")?.call1(values)
}

fn notes<'py>(py: Python<'py>, found: &SeamNotes) -> PyResult<Bound<'py, PyDict>> {
    let counts = [
        ("single_edges", found.single_edges),
        ("collapsed_triangles", found.collapsed_triangles),
        ("no_area", found.no_area),
        ("clear", found.clear),
        ("not_finite", found.not_finite),
        ("shortened", found.shortened),
        ("outside", found.outside),
    ];
    let notes = PyDict::new(py);
    for (name, count) in counts {
        notes.set_item(name, count)?;
    }
    Ok(notes)
}
