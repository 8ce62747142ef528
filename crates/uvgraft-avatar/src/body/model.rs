//! A body model, as stored in its file.

use std::collections::BTreeSet;

use uvgraft::threads;
use uvgraft_io::arrays::NamedArrays;

use super::correctives::Correctives;
use super::fields::{Axis, Fields};
use super::hands::HandPoseSpace;
use super::{BodyError, BodyKind, NamedShapes, Shaped, posedirs};
use crate::rig::{Joint, Skeleton, Skin};

/// Upper limit of the number of vertices: as many as 24-bit indices can address.
const MAX_VERTICES: usize = 1 << 24;
/// Where a single array of at least `WHOLE` components holds shape and expression, expression
/// begins after the first `SHAPES` of them; in smaller arrays, it begins after the first
/// `FEW_SHAPES`.
const WHOLE: usize = 400;
const SHAPES: usize = 300;
const FEW_SHAPES: usize = 10;

/// A body model: the vertices for any shape, expression and pose.
#[derive(Debug, Clone)]
pub struct BodyModel {
    pub(super) kind: BodyKind,
    pub(super) template: Vec<[f32; 3]>,
    /// Components of shape, then of expression.
    pub(super) directions: Directions,
    betas: usize,
    /// Names of the expression components; empty where they have none.
    expression_names: Vec<String>,
    pub(super) named_shapes: Option<NamedShapes>,
    pub(super) correctives: Correctives,
    /// Why the file's pose correctives are not in `correctives`, if they are not.
    pub(super) correctives_left_out: Option<String>,
    /// For each joint, the vertices that determine its position, with their weights.
    regressor: Vec<Vec<(u32, f32)>>,
    /// Joints that do not follow from vertices.
    own_joints: Option<OwnJoints>,
    pub(super) skin: Skin,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) hands: [HandPoseSpace; 2],
}

/// Joints by the shape's coefficients instead of by vertices.
#[derive(Debug, Clone)]
struct OwnJoints {
    template: Vec<[f32; 3]>,
    directions: Directions,
}

/// Offsets of all coordinates, one row for each component.
#[derive(Debug, Clone)]
pub(super) struct Directions {
    rows: Vec<f32>,
    width: usize,
}

/// A person's shape and expression: coefficients of a model's components, in standard
/// deviations of the people it was trained on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shape {
    /// Of the body's shape; missing ones are 0.
    pub betas: Vec<f32>,
    /// Of the facial expression; missing ones are 0.
    pub expression: Vec<f32>,
}

impl BodyModel {
    /// Builds a model from the arrays of its file.
    ///
    /// - `v_template` `[V, 3]`, metres, Y up, facing +Z.
    /// - `shapedirs` `[V, 3, S]`. In SMPL-X and FLAME it includes expression unless there is an
    ///   array `exprdirs` `[V, 3, E]`: of 400 components or more, the first 300 are shape and the
    ///   next 100 expression; of fewer, the first 10 and the next 10.
    /// - `J_regressor` `[J, V]`, `weights` `[V, J]`, `f` `[F, 3]`.
    /// - `kintree_table` `[2, J]`: parents, then joints. The number of joints determines the kind.
    /// - Optional: `posedirs` `[V, 3, 9 * (J - 1)]`, also flattened to `[3 V, 9 * (J - 1)]` or with
    ///   the last axis first; without it, and with any other shape, poses have no correctives:
    ///   see [`BodyModel::correctives_left_out`];
    ///   `hands_componentsl`, `hands_componentsr` `[45, 45]` and `hands_meanl`, `hands_meanr`
    ///   `[45]`; `J_template` `[J, 3]` and `J_shapedirs` `[J, 3, S]`, which place the joints instead of
    ///   the regressor; `expression_names`, a string with a line for each component of `exprdirs`; and
    ///   those of [`NamedShapes`].
    ///
    /// [`ModelFile`](super::ModelFile) reads only the parts of a file that are needed.
    ///
    /// # Errors
    /// [`BodyError`] for arrays that are missing or have other shapes, values that are
    /// not finite, indices out of range, joints whose parents differ from those of the
    /// kind, or weights that are negative or sum to zero.
    pub fn from_arrays(arrays: &NamedArrays) -> Result<Self, BodyError> {
        let fields = Fields(arrays);
        let kind = read_kind(&fields)?;
        let mut model = Self::without_correctives(&fields, kind, None)?;
        let all = 0..kind.features();
        (model.correctives, model.correctives_left_out) =
            posedirs::read(&fields, kind, model.vertices(), all)?;
        Ok(model)
    }

    /// A model without pose correctives: poses change it by skinning only.
    ///
    /// - `split`: the numbers of shape and expression components in `shapedirs`, if known.
    pub(super) fn without_correctives(
        fields: &Fields<'_>,
        kind: BodyKind,
        split: Option<[usize; 2]>,
    ) -> Result<Self, BodyError> {
        let template = fields.points("v_template")?;
        let vertices = template.len();
        if vertices > MAX_VERTICES {
            let (key, what, most) = ("v_template", "vertices", MAX_VERTICES);
            return Err(BodyError::TooMany { key, what, found: vertices, most });
        }
        let joints = kind.joint_count();

        let (weights, _) = fields.floats("weights", &[Axis::Is(vertices), Axis::Is(joints)])?;
        let influences = weights.chunks_exact(joints).map(|row| row.iter().copied().enumerate());
        let skin = Skin::new(influences, joints)?;
        drop(weights);

        let (parts, _) = fields.floats("J_regressor", &[Axis::Is(joints), Axis::Is(vertices)])?;
        let some = |row: &[f32]| {
            let row = (0..).zip(row.iter().copied());
            row.filter(|&(_, part)| part != 0.0).collect()
        };
        let regressor = parts.chunks_exact(vertices).map(some).collect();
        drop(parts);

        let (directions, betas) = read_directions(fields, kind, vertices, split)?;
        let own_joints = OwnJoints::read(fields, joints, betas)?;
        let triangles = fields.triangles("f", vertices)?;
        let hands = match kind.fingers() {
            None => [HandPoseSpace::default(), HandPoseSpace::default()],
            Some(_) => [
                HandPoseSpace::read(fields, "hands_componentsl", "hands_meanl")?,
                HandPoseSpace::read(fields, "hands_componentsr", "hands_meanr")?,
            ],
        };
        let correctives = Correctives::none(vertices, kind.features());
        let expression_names = read_names(fields, directions.count() - betas)?;
        let named_shapes = NamedShapes::read(fields.0, betas)?;
        Ok(Self {
            kind,
            template,
            directions,
            betas,
            expression_names,
            named_shapes,
            correctives,
            correctives_left_out: None,
            regressor,
            own_joints,
            skin,
            triangles,
            hands,
        })
    }

    /// Whether poses have correctives; models without `posedirs` have none.
    pub fn has_correctives(&self) -> bool {
        !self.correctives.is_none()
    }

    /// Why the pose correctives of the file are left out, if they are: `posedirs` has another shape
    /// than any that is known.
    pub fn correctives_left_out(&self) -> Option<&str> {
        self.correctives_left_out.as_deref()
    }

    /// The member of the family.
    pub const fn kind(&self) -> BodyKind {
        self.kind
    }

    /// Number of vertices.
    pub fn vertices(&self) -> usize {
        self.template.len()
    }

    /// Its triangles.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Number of shape components.
    pub const fn betas(&self) -> usize {
        self.betas
    }

    /// Number of expression components.
    pub fn expressions(&self) -> usize {
        self.directions.count() - self.betas
    }

    /// Names of the expression components, such as ARKit's blend shapes, which are full expressions
    /// at a coefficient of 1; empty for models whose components are learnt and have no names.
    pub fn expression_names(&self) -> &[String] {
        &self.expression_names
    }

    /// Skinning weights of the vertices.
    pub const fn skin(&self) -> &Skin {
        &self.skin
    }

    /// One person: the template plus the weighted components of shape and expression, with the
    /// joints regressed from the resulting vertices.
    ///
    /// # Errors
    /// [`BodyError::Coefficients`] for more coefficients than there are components,
    /// [`BodyError::Coefficient`] for one that is not finite, [`BodyError::Rig`] if the
    /// shape overflows.
    pub fn shaped(&self, shape: &Shape) -> Result<Shaped<'_>, BodyError> {
        self.check_coefficients("betas", &shape.betas, self.betas)?;
        let expressions = self.expressions();
        self.check_coefficients("expression coefficients", &shape.expression, expressions)?;
        let numbered = (0..).zip(shape.betas.iter().copied());
        let expression = (self.betas..).zip(shape.expression.iter().copied());
        let coefficients: Vec<(usize, f32)> =
            numbered.chain(expression).filter(|&(_, coefficient)| coefficient != 0.0).collect();
        let mut positions = self.template.clone();
        self.directions.add(&coefficients, positions.as_flattened_mut());
        let places = match &self.own_joints {
            Some(own) => own.places(&shape.betas),
            None => self.regressor.iter().map(|parts| between(parts, &positions)).collect(),
        };
        let joint = |((name, parent, human), position)| Joint {
            name: str::to_owned(name),
            parent,
            position,
            human,
        };
        let joints = self.kind.joints().into_iter().zip(places).map(joint);
        let skeleton = Skeleton::new(joints.collect())?;
        Ok(Shaped { model: self, positions, skeleton })
    }

    /// Vertex offsets of an expression component.
    pub(super) fn expression(&self, component: usize) -> &[[f32; 3]] {
        self.directions.row(self.betas + component).as_chunks::<3>().0
    }

    pub(super) fn check_coefficients(
        &self,
        what: &'static str,
        coefficients: &[f32],
        most: usize,
    ) -> Result<(), BodyError> {
        let (found, kind) = (coefficients.len(), self.kind.name());
        if found > most {
            return Err(BodyError::Coefficients { what, found, most, kind });
        }
        match coefficients.iter().position(|value| !value.is_finite()) {
            Some(at) => Err(BodyError::Coefficient { what, at, found: coefficients[at] }),
            None => Ok(()),
        }
    }
}

impl OwnJoints {
    /// Reads them, if the file has any.
    fn read(fields: &Fields<'_>, joints: usize, betas: usize) -> Result<Option<Self>, BodyError> {
        if !fields.has("J_template") {
            return Ok(None);
        }
        let (template, _) = fields.floats("J_template", &[Axis::Is(joints), Axis::Is(3)])?;
        let wanted = [Axis::Is(joints), Axis::Is(3), Axis::Any("components")];
        let (offsets, shape) = fields.floats("J_shapedirs", &wanted)?;
        let rows = transposed(&offsets, shape[2], betas.min(shape[2]));
        let template = template.as_chunks::<3>().0.to_vec();
        Ok(Some(Self { template, directions: Directions { rows, width: joints * 3 } }))
    }

    fn places(&self, betas: &[f32]) -> Vec<[f32; 3]> {
        let coefficients: Vec<(usize, f32)> =
            (0..self.directions.count()).zip(betas.iter().copied()).collect();
        let mut places = self.template.clone();
        self.directions.add(&coefficients, places.as_flattened_mut());
        places
    }
}

impl Directions {
    fn count(&self) -> usize {
        self.rows.len() / self.width
    }

    fn row(&self, component: usize) -> &[f32] {
        &self.rows[component * self.width..][..self.width]
    }

    /// Adds the components times their coefficients, in the given order.
    pub(super) fn add(&self, coefficients: &[(usize, f32)], coordinates: &mut [f32]) {
        const CHUNK: usize = 1536;
        threads::for_each_chunk(coordinates, CHUNK, |chunk, coordinates| {
            for &(component, coefficient) in coefficients {
                let row = &self.row(component)[chunk * CHUNK..];
                for (value, offset) in coordinates.iter_mut().zip(row) {
                    *value += coefficient * offset;
                }
            }
        });
    }
}

/// A weighted mean of points; strictly a sum, since the weights of published models sum to 1.
fn between(parts: &[(u32, f32)], positions: &[[f32; 3]]) -> [f32; 3] {
    let mut sum = [0.0_f64; 3];
    for &(vertex, part) in parts {
        for (sum, value) in sum.iter_mut().zip(positions[vertex as usize]) {
            *sum += f64::from(part) * f64::from(value);
        }
    }
    sum.map(|value| value as f32)
}

/// The kind with this number of joints, provided that their parents match.
pub(super) fn read_kind(fields: &Fields<'_>) -> Result<BodyKind, BodyError> {
    let key = "kintree_table";
    let (table, shape) = fields.integers(key, &[Axis::Is(2), Axis::Any("joints")])?;
    let found = shape[1];
    let kind = BodyKind::with_joints(found).ok_or(BodyError::Joints { found })?;
    let (parents, numbers) = table.split_at(found);
    for (joint, &number) in numbers.iter().enumerate() {
        if number != joint as i64 {
            return Err(BodyError::Index {
                key,
                at: found + joint,
                found: number,
                below: joint + 1,
            });
        }
    }
    // Files store the root's parent as -1, as 2³² - 1 (the same without a sign) or as 0.
    for ((joint, (name, parent, _)), &found) in kind.joints().iter().enumerate().zip(parents) {
        if let Some(wanted) = parent.filter(|&wanted| wanted as i64 != found) {
            return Err(BodyError::Parent { joint, name, kind: kind.name(), found, wanted });
        }
    }
    Ok(kind)
}

/// Splits the components of an array into shape and expression; the rest is not used.
///
/// - `apart`: expression has a separate array.
pub(super) fn split(kind: BodyKind, components: usize, apart: bool) -> [usize; 2] {
    match kind {
        _ if apart => [components, 0],
        BodyKind::Smpl | BodyKind::SmplH => [components, 0],
        BodyKind::SmplX | BodyKind::Flame if components >= WHOLE => [SHAPES, WHOLE - SHAPES],
        BodyKind::SmplX | BodyKind::Flame => {
            let betas = components.min(FEW_SHAPES);
            [betas, components.min(2 * FEW_SHAPES) - betas]
        }
    }
}

/// Reads the components; also returns how many of them are shape.
fn read_directions(
    fields: &Fields<'_>,
    kind: BodyKind,
    vertices: usize,
    known: Option<[usize; 2]>,
) -> Result<(Directions, usize), BodyError> {
    let wanted = |name| [Axis::Is(vertices), Axis::Is(3), Axis::Any(name)];
    let (shapes, shape) = fields.floats("shapedirs", &wanted("components"))?;
    let all = shape[2];
    let apart = fields.has("exprdirs");
    let [betas, expressions] = known.unwrap_or_else(|| split(kind, all, apart));
    let last = betas + expressions;
    let mut rows = transposed(&shapes, all, last);
    if apart {
        let (expressions, shape) = fields.floats("exprdirs", &wanted("components"))?;
        rows.extend(transposed(&expressions, shape[2], shape[2]));
    }
    Ok((Directions { rows, width: vertices * 3 }, betas))
}

/// Name of the string with the names of expression components.
pub(super) const EXPRESSION_NAMES: &str = "expression_names";

/// Reads the names of the expression components, if the file has them.
fn read_names(fields: &Fields<'_>, expressions: usize) -> Result<Vec<String>, BodyError> {
    let Some(text) = fields.0.text(EXPRESSION_NAMES) else { return Ok(Vec::new()) };
    let names: Vec<String> = text.lines().map(str::to_owned).collect();
    let distinct: BTreeSet<&String> = names.iter().collect();
    if names.len() == expressions && distinct.len() == expressions {
        return Ok(names);
    }
    let (what, found) = ("distinct `expression_names`", distinct.len());
    Err(BodyError::Count { what, found, wanted: expressions })
}

/// The first columns of a table, as rows.
fn transposed(table: &[f32], columns: usize, kept: usize) -> Vec<f32> {
    // Rows of the table in a block: few enough to stay in the cache while each column is gathered.
    const BLOCK: usize = 64;
    let height = table.len() / columns;
    let mut rows = vec![0.0; height * kept];
    for (block, lines) in table.chunks(BLOCK * columns).enumerate() {
        for column in 0..kept {
            let row = &mut rows[column * height + block * BLOCK..];
            for (value, line) in row.iter_mut().zip(lines.chunks_exact(columns)) {
                *value = line[column];
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_become_rows() {
        let table: Vec<f32> = (0..200 * 3).map(|value| value as f32).collect();
        let rows = transposed(&table, 3, 2);
        assert_eq!(rows.len(), 400);
        assert_eq!((rows[0], rows[1], rows[199]), (0.0, 3.0, 597.0));
        assert_eq!((rows[200], rows[201], rows[399]), (1.0, 4.0, 598.0));
    }
}
