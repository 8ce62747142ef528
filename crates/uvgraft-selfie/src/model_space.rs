//! The shapes and expressions that a head's model has, and those of them that photographs show.

use glam::{DMat3, DVec3};
use nalgebra::{DMatrix, DVector};

use crate::head::Head;
use crate::head_landmarks::HeadLandmark;

/// Linear shapes and expressions of a head's model, such as FLAME.
///
/// Coefficients are in standard deviations, so that all are equally likely.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelSpace {
    /// `[coefficients][vertices]`: displacements by a coefficient of 1, in the mesh's unit.
    pub shapes: Vec<Vec<DVec3>>,
    /// The same of expressions.
    pub expressions: Vec<Vec<DVec3>>,
}

/// A landmark as a photograph shows it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sighting {
    /// The displacement from the head so far that it tells of.
    pub moved: DVec3,
    /// How far it tells of it, in each direction; 1 at most.
    pub certainty: DMat3,
    /// Projects onto the line of sight.
    pub along: DMat3,
    /// How far the landmark counts at all, 0 to 1.
    pub weight: f64,
}

/// What a model's coefficients do to the landmarks of one photograph.
#[derive(Debug, Clone)]
pub(crate) struct OfLandmarks {
    /// `[landmarks × 3, coefficients]`
    shapes: DMatrix<f64>,
    expressions: DMatrix<f64>,
}

/// What photographs tell of the coefficients of a model.
#[derive(Debug, Clone)]
pub(crate) struct Coefficients {
    pub shape: DVector<f64>,
    /// Of each photograph.
    pub expressions: Vec<DVector<f64>>,
}

/// The error of a landmark's place, in eye distances. Neighbours err alike, so it is larger than that
/// of a single one.
const NOISE: f64 = 0.06;

impl ModelSpace {
    /// The vertices moved by coefficients.
    pub(crate) fn moved(
        basis: &[Vec<DVec3>],
        coefficients: &DVector<f64>,
        from: &[DVec3],
    ) -> Vec<DVec3> {
        let mut moved = from.to_vec();
        for (by, &coefficient) in basis.iter().zip(coefficients.iter()) {
            for (at, &by) in moved.iter_mut().zip(by) {
                *at += by * coefficient;
            }
        }
        moved
    }

    /// What the coefficients do to landmarks.
    pub(crate) fn of_landmarks(&self, head: &Head, landmarks: &[HeadLandmark]) -> OfLandmarks {
        let columns = |basis: &[Vec<DVec3>]| {
            let values = basis.iter().flat_map(|by| head.points_of(landmarks, by));
            let values = values.flat_map(|by| by.to_array());
            DMatrix::from_iterator(3 * landmarks.len(), basis.len(), values)
        };
        OfLandmarks { shapes: columns(&self.shapes), expressions: columns(&self.expressions) }
    }
}

impl OfLandmarks {
    /// The most probable coefficients: one shape for all photographs, and an expression for each, by
    /// least squares with a prior of one standard deviation.
    ///
    /// - `photographs`: for each what the coefficients do to its landmarks, and what it shows of them.
    /// - `unit`: the distance between the eyes.
    ///
    /// `None` if there are no photographs, or the equations have no solution.
    pub(crate) fn fitted(photographs: &[(Self, Vec<Sighting>)], unit: f64) -> Option<Coefficients> {
        let shapes = photographs.first()?.0.shapes.ncols();
        let per_square = (NOISE * unit).powi(-2);
        let mut matrix = DMatrix::<f64>::identity(shapes, shapes);
        let mut right = DVector::<f64>::zeros(shapes);
        // Each photograph's expression is eliminated, which leaves equations of the shape alone.
        let mut eliminated = Vec::with_capacity(photographs.len());
        for (Self { shapes: of_shape, expressions: of_expression }, photograph) in photographs {
            let weighted = |columns: &DMatrix<f64>| {
                let mut weighted = columns.clone();
                for (row, seen) in photograph.iter().enumerate() {
                    for column in 0..columns.ncols() {
                        let at = |k: usize| columns[(3 * row + k, column)];
                        let by = seen.certainty * DVec3::new(at(0), at(1), at(2)) * per_square;
                        for k in 0..3 {
                            weighted[(3 * row + k, column)] = by[k];
                        }
                    }
                }
                weighted
            };
            let moved = photograph.iter().flat_map(|seen| seen.moved.to_array());
            let moved = DVector::from_iterator(of_shape.nrows(), moved);
            let [by_shape, by_expression] = [weighted(of_shape), weighted(of_expression)];
            let own = of_expression.transpose() * &by_expression
                + DMatrix::<f64>::identity(of_expression.ncols(), of_expression.ncols());
            let own = own.cholesky()?;
            let mixed = of_expression.transpose() * &by_shape;
            let own_right = by_expression.transpose() * &moved;
            matrix += of_shape.transpose() * &by_shape - mixed.transpose() * own.solve(&mixed);
            right += by_shape.transpose() * &moved - mixed.transpose() * own.solve(&own_right);
            eliminated.push((own, mixed, own_right));
        }
        let shape = matrix.cholesky()?.solve(&right);
        let expressions = eliminated
            .into_iter()
            .map(|(own, mixed, right)| own.solve(&(right - mixed * &shape)))
            .collect();
        Some(Coefficients { shape, expressions })
    }
}
