//! The names of the values of options, with which tests compare the package's annotations.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use uvgraft::correspond::By;
use uvgraft::correspond::surface::Align;
use uvgraft::{Choice, Encoding, Filter, NormalY, Overlap, Prefer, Side};
use uvgraft_assembly::avatar::{EyeStyle, LevelStorage, MapRole, MouthStyle, TextureLayout};
use uvgraft_assembly::render::Shot;
use uvgraft_avatar::motion::{GroundMode, UpAxis};
use uvgraft_gltf::glb::{EmbeddedFormat, Permissions, ShadingModel};
use uvgraft_gltf::preset::Preset;
use uvgraft_metrics::Metric;
use uvgraft_metrics::lpips::LpipsNetwork;
use uvgraft_pipeline::{BlendMode, ToneSide, Unit};
use uvgraft_selfie::Relight;

use crate::arguments::COLOR_ENCODINGS;
use crate::pair::{TABLE, VERTEX_MAP};

/// The names of the values that each parameter of the package's functions takes.
#[pyfunction]
pub(crate) fn choices() -> BTreeMap<&'static str, Vec<&'static str>> {
    let mut by = names(By::ALL);
    by.extend([VERTEX_MAP, TABLE]);
    let roles = MapRole::ALL.map(MapRole::name).to_vec();
    BTreeMap::from([
        ("align", names(Align::ALL)),
        ("base_maps", roles.clone()),
        ("blend", names(BlendMode::ALL)),
        ("by", by),
        ("camera", names(Shot::ALL)),
        ("color_encoding", names(COLOR_ENCODINGS)),
        ("encoding", names(Encoding::ALL)),
        ("eyes", names(EyeStyle::ALL)),
        ("filter", names(&Filter::ALL)),
        ("ground", names(GroundMode::ALL)),
        ("license", Permissions::NAMED.map(|(name, _)| name).to_vec()),
        ("lods_as", names(LevelStorage::ALL)),
        ("look", names(ShadingModel::ALL)),
        ("maps", roles),
        ("metrics", names(Metric::ALL)),
        ("mouth", names(MouthStyle::ALL)),
        ("network", names(&LpipsNetwork::ALL)),
        ("normal_y", names(NormalY::ALL)),
        ("normal_y_out", names(NormalY::ALL)),
        ("overlap", names(Overlap::ALL)),
        ("prefer", names(Prefer::ALL)),
        ("preset", Preset::ALL.map(|preset| preset.name).to_vec()),
        ("relight", names(Relight::ALL)),
        ("side", names(Side::ALL)),
        ("texture_format", names(EmbeddedFormat::ALL)),
        ("texture_layout", names(TextureLayout::ALL)),
        ("tone", names(ToneSide::ALL)),
        ("unit", names(Unit::ALL)),
        ("up", names(UpAxis::ALL)),
    ])
}

fn names<T: Choice>(values: &[T]) -> Vec<&'static str> {
    values.iter().map(|value| value.name()).collect()
}
