//! Eliminates groups of columns from the leaves of their tree to its root, and solves with them.

use std::ops::Range;

use super::dense::{Buffers, Front};
use super::matrix::Matrix;
use super::structure::{Group, NONE, Structure};
use crate::threads::for_each_with;

/// What a group adds to the columns of the rows below it: a square, column by column, of which values
/// above the diagonal are unused.
type Rest = Vec<f64>;

/// The values of the factors, as [`Group::start`] says; `None` if the matrix is not positive
/// definite.
pub(super) fn factorise(structure: &Structure, matrix: &Matrix) -> Option<Vec<f64>> {
    let mut values = vec![0.0; structure.len()];
    let branches = branches(structure);
    // Branches are independent of each other; what is above them is eliminated group by group, with
    // the arithmetic on all threads.
    let mut within = Vec::with_capacity(branches.len());
    let mut above = Vec::new();
    let mut left = values.as_mut_slice();
    let mut take = |groups: Range<usize>| {
        let len = structure.groups[groups].iter().map(Group::len).sum();
        left.split_off_mut(..len).expect("the values of all groups")
    };
    let mut next = 0;
    for branch in &branches {
        above.extend((next..branch.start).map(|group| (group, take(group..group + 1))));
        within.push((branch.clone(), take(branch.clone())));
        next = branch.end;
    }
    above.extend((next..structure.groups.len()).map(|group| (group, take(group..group + 1))));

    let mut results: Vec<Option<Rest>> = vec![None; branches.len()];
    let new_worker = || Worker::new(structure, matrix);
    for_each_with(
        within.into_iter().zip(&mut results),
        new_worker,
        |worker, _, ((branch, values), result)| *result = worker.branch(branch, values),
    );
    let mut rests: Vec<Rest> = vec![Vec::new(); structure.groups.len()];
    for (branch, result) in branches.iter().zip(results) {
        rests[branch.end - 1] = result?;
    }
    let mut worker = new_worker();
    for (group, values) in above {
        worker.eliminate(group, values, &mut rests, 0, true)?;
    }
    Some(values)
}

/// Branches of the tree that are worth a thread's time and leave enough of them for all: those that
/// take a small part of the time, as ranges of groups.
fn branches(structure: &Structure) -> Vec<Range<usize>> {
    /// The greatest part of the time that a branch may take.
    const PART: f64 = 1.0 / 24.0;
    /// Multiplications that are not worth being distributed.
    const FEW: f64 = 3e6;
    let groups = &structure.groups;
    let mut costs: Vec<f64> =
        groups.iter().map(|group| group.width() as f64 * (group.height() as f64).powi(2)).collect();
    let all: f64 = costs.iter().sum();
    if all < FEW {
        return std::iter::once(0..groups.len()).collect();
    }
    let mut first: Vec<usize> = (0..groups.len()).collect();
    for (group, Group { parent, .. }) in groups.iter().enumerate() {
        if *parent != NONE {
            let parent = *parent as usize;
            costs[parent] += costs[group];
            first[parent] = first[parent].min(first[group]);
        }
    }
    let is_small = |group: usize| costs[group] <= PART * all;
    let is_branch = |group: &usize| {
        let parent = groups[*group].parent;
        is_small(*group) && (parent == NONE || !is_small(parent as usize))
    };
    (0..groups.len()).filter(is_branch).map(|group| first[group]..group + 1).collect()
}

/// Eliminates groups; with buffers that are reused from group to group.
struct Worker<'a> {
    structure: &'a Structure,
    matrix: &'a Matrix,
    /// For each row of the matrix, its row in the front.
    place: Vec<u32>,
    /// Rows of a child that are consecutive in the front, too: the first of them in the child and in
    /// the front, and their number.
    stretches: Vec<[usize; 3]>,
    buffers: Buffers,
    idle: Vec<Rest>,
}

impl<'a> Worker<'a> {
    fn new(structure: &'a Structure, matrix: &'a Matrix) -> Self {
        Self {
            structure,
            matrix,
            place: vec![0; matrix.columns()],
            stretches: Vec::new(),
            buffers: Buffers::default(),
            idle: Vec::new(),
        }
    }

    /// Eliminates the groups of a branch, and returns what it adds to the others; `None` if a pivot is
    /// not positive.
    fn branch(&mut self, groups: Range<usize>, mut values: &mut [f64]) -> Option<Rest> {
        let mut rests = vec![Vec::new(); groups.len()];
        for group in groups.clone() {
            let len = self.structure.groups[group].len();
            let own = values.split_off_mut(..len).expect("the values of a branch");
            self.eliminate(group, own, &mut rests, groups.start, false)?;
        }
        rests.pop()
    }

    /// Eliminates a group, with what its children add to it.
    ///
    /// - `rests`: those of the groups from `first` on.
    fn eliminate(
        &mut self,
        group: usize,
        own: &mut [f64],
        rests: &mut [Rest],
        first: usize,
        is_parallel: bool,
    ) -> Option<()> {
        let (structure, number) = (self.structure, group);
        let group = &structure.groups[group];
        let (width, height) = (group.width(), group.height());
        let below = height - width;
        for (row, place) in
            group.columns.clone().chain(structure.below(group).iter().copied()).zip(0..)
        {
            self.place[row as usize] = place;
        }
        let mut rest = self.idle.pop().unwrap_or_default();
        rest.clear();
        // Not the matrix's own entries: those are added where their columns are eliminated.
        rest.resize(below * below, 0.0);
        for (column, values) in group.columns.clone().zip(own.chunks_exact_mut(height)) {
            let (rows, entries) = self.matrix.column(column as usize);
            for (&row, entry) in rows.iter().zip(entries) {
                values[self.place[row as usize] as usize] = *entry;
            }
        }
        let mut front = Front { width, height, own, rest: &mut rest, is_parallel };
        for child in structure.children(number) {
            let given = std::mem::take(&mut rests[child - first]);
            self.add(structure.below(&structure.groups[child]), &given, &mut front);
            self.idle.push(given);
        }
        let is_positive = front.eliminate(&mut self.buffers);
        rests[number - first] = rest;
        is_positive.then_some(())
    }

    /// Adds to a front what a child gives.
    ///
    /// - `rows`: those below the child.
    fn add(&mut self, rows: &[u32], given: &[f64], front: &mut Front<'_>) {
        self.stretches.clear();
        for (index, &row) in rows.iter().enumerate() {
            let place = self.place[row as usize] as usize;
            match self.stretches.last_mut() {
                Some([_, first, len]) if *first + *len == place => *len += 1,
                _ => self.stretches.push([index, place, 1]),
            }
        }
        for (number, &[from, to, len]) in self.stretches.iter().enumerate() {
            for k in 0..len {
                let (column, above) = front.column(to + k);
                let given = &given[(from + k) * rows.len()..][..rows.len()];
                // From the diagonal on.
                for (index, &[from, to, len]) in self.stretches[number..].iter().enumerate() {
                    let skipped = if index == 0 { k } else { 0 };
                    let column = &mut column[to + skipped - above..to + len - above];
                    for (value, given) in column.iter_mut().zip(&given[from + skipped..]) {
                        *value += given;
                    }
                }
            }
        }
    }
}

/// Solves for several right-hand sides, in place.
pub(super) fn solve<const N: usize>(
    structure: &Structure,
    values: &[f64],
    solution: &mut [[f64; N]],
) {
    let mut below = Vec::new();
    let columns = |group: &Group| {
        let values = &values[group.start..][..group.len()];
        values.chunks_exact(group.height()).enumerate()
    };
    let own = |group: &Group| group.columns.start as usize..group.columns.end as usize;
    // Forwards, `L y = b`: what a group takes from the rows below is passed on at once.
    for group in &structure.groups {
        below.clear();
        below.resize(group.below.len(), [0.0; N]);
        let own = &mut solution[own(group)];
        for (k, column) in columns(group) {
            let (upper, lower) = column.split_at(own.len());
            let value = own[k].map(|value| value / upper[k]);
            own[k] = value;
            subtract(&mut own[k + 1..], &upper[k + 1..], value);
            subtract(&mut below, lower, value);
        }
        for (&row, below) in structure.below(group).iter().zip(&below) {
            for (value, below) in solution[row as usize].iter_mut().zip(below) {
                *value += below;
            }
        }
    }
    // Backwards, `Lᵀ x = y`: from the root, so that the rows below are known.
    for group in structure.groups.iter().rev() {
        below.clear();
        below.extend(structure.below(group).iter().map(|&row| solution[row as usize]));
        let own = &mut solution[own(group)];
        for (k, column) in columns(group).rev() {
            let (upper, lower) = column.split_at(own.len());
            let [a, b] = [sum(&own[k + 1..], &upper[k + 1..]), sum(&below, lower)];
            for (axis, value) in own[k].iter_mut().enumerate() {
                *value = (*value - a[axis] - b[axis]) / upper[k];
            }
        }
    }
}

fn subtract<const N: usize>(from: &mut [[f64; N]], factors: &[f64], value: [f64; N]) {
    for (from, factor) in from.iter_mut().zip(factors) {
        for (from, value) in from.iter_mut().zip(value) {
            *from -= factor * value;
        }
    }
}

fn sum<const N: usize>(values: &[[f64; N]], factors: &[f64]) -> [f64; N] {
    let mut sums = [0.0; N];
    for (values, factor) in values.iter().zip(factors) {
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += factor * value;
        }
    }
    sums
}
