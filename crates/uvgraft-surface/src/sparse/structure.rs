//! Where the factors of a matrix are not 0: groups of columns, their rows, and their tree.
//!
//! The elimination tree is that of J. Liu, "The role of elimination trees in sparse factorization",
//! 1990. Groups are merged where that stores few zeros, as in Y. Chen, T. Davis, W. Hager and S.
//! Rajamanickam, "Algorithm 887: CHOLMOD", 2008: dense arithmetic is faster than that with indices.

use std::ops::Range;

use super::matrix::Matrix;

/// Values and multiplications that any factors may take, so that small systems need no care.
const LEAST_VALUES: f64 = 1e6;
const LEAST_PRODUCTS: f64 = 5e8;
/// And those for each column, and for columns to the power of 1.5, as which those of surfaces grow. The
/// membrane of a body takes 16 and 6, the bending of 20,000 points of a head 130 and 220.
const VALUES_PER_COLUMN: f64 = 1000.0;
const PRODUCTS_PER_COLUMN: f64 = 1000.0;

/// Stands for the parent of a root.
pub(super) const NONE: u32 = u32::MAX;

/// Consecutive columns of the factors with the same rows below them.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// The columns.
    pub columns: Range<u32>,
    /// The rows below the last column, as a range of [`Structure::rows`].
    pub below: Range<usize>,
    /// Where its values start: those of each column in turn, for the group's own rows (those above
    /// the diagonal are unused) and then for the rows below.
    pub start: usize,
    /// The group that its rows below are assembled into; [`NONE`] for a root.
    pub parent: u32,
}

impl Group {
    /// Number of columns.
    pub fn width(&self) -> usize {
        self.columns.len()
    }

    /// Number of rows, those of the columns themselves included.
    pub fn height(&self) -> usize {
        self.width() + self.below.len()
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        self.width() * self.height()
    }
}

/// The groups of all columns. Children come before their parents, and the groups of a branch are
/// consecutive.
#[derive(Debug)]
pub(super) struct Structure {
    pub groups: Vec<Group>,
    rows: Vec<u32>,
    /// One child of each group, or [`NONE`].
    first_child: Vec<u32>,
    /// The next child of each group's parent, or [`NONE`].
    sibling: Vec<u32>,
}

/// The groups of columns, before their rows are known.
#[derive(Debug)]
pub(super) struct Tree {
    /// The new number of each column; those of a group are consecutive, and so are the groups of a
    /// branch.
    pub number: Vec<u32>,
    /// The parent of each column, both by their new numbers.
    parents: Vec<u32>,
    /// The first column of each group, and the number of columns.
    firsts: Vec<u32>,
}

/// What factors may take.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    /// Values of the factors.
    pub values: u64,
    /// Multiplications that compute them.
    pub products: f64,
}

impl Limit {
    /// - `columns`: of the matrix.
    pub fn of(columns: usize) -> Self {
        let columns = columns as f64;
        Self {
            values: (LEAST_VALUES + VALUES_PER_COLUMN * columns) as u64,
            products: LEAST_PRODUCTS + PRODUCTS_PER_COLUMN * columns.powf(1.5),
        }
    }
}

impl Tree {
    /// `None` if the factors are beyond the limit, which is found before any of their values is
    /// computed, and in no more steps than it allows values.
    ///
    /// - `lower`: the entries on the diagonal and below.
    pub fn new(lower: &Matrix, limit: Limit) -> Option<Self> {
        let (parents, counts) = elimination_tree(lower, limit.values)?;
        // Eliminating a column multiplies its values with one another.
        let products: f64 = counts.iter().map(|&count| f64::from(count).powi(2)).sum();
        if products > limit.products {
            return None;
        }
        let number = postorder(&parents, &counts);
        let renumbered = |of: &dyn Fn(usize) -> u32| {
            let mut values = vec![0; number.len()];
            for (old, &new) in number.iter().enumerate() {
                values[new as usize] = of(old);
            }
            values
        };
        let counts = renumbered(&|old| counts[old]);
        let parents = renumbered(&|old| match parents[old] {
            NONE => NONE,
            parent => number[parent as usize],
        });
        let firsts = merged(&parents, &counts, &groups(&parents, &counts));
        Some(Self { number, parents, firsts })
    }
}

impl Structure {
    /// Finds the rows below each group: those of its own entries and of its children's rows below.
    ///
    /// - `lower`: the entries on the diagonal and below, in the tree's numbers.
    pub fn new(Tree { parents, firsts, .. }: &Tree, lower: &Matrix) -> Self {
        let count = firsts.len() - 1;
        let mut group_of_column = vec![0; lower.columns()];
        for (group, range) in (0u32..).zip(firsts.windows(2)) {
            group_of_column[range[0] as usize..range[1] as usize].fill(group);
        }
        let mut structure = Self {
            groups: Vec::with_capacity(count),
            rows: Vec::new(),
            first_child: vec![NONE; count],
            sibling: vec![NONE; count],
        };
        let mut seen = vec![NONE; lower.columns()];
        let mut start = 0;
        for (group, range) in (0u32..).zip(firsts.windows(2)) {
            let first = structure.rows.len();
            let mut offer = |row: u32, rows: &mut Vec<u32>| {
                if row >= range[1] && std::mem::replace(&mut seen[row as usize], group) != group {
                    rows.push(row);
                }
            };
            for column in range[0]..range[1] {
                for &row in lower.column(column as usize).0 {
                    offer(row, &mut structure.rows);
                }
            }
            let mut child = structure.first_child[group as usize];
            while child != NONE {
                for index in structure.groups[child as usize].below.clone() {
                    offer(structure.rows[index], &mut structure.rows);
                }
                child = structure.sibling[child as usize];
            }
            structure.rows[first..].sort_unstable();
            let parent = match parents[range[1] as usize - 1] {
                NONE => NONE,
                column => group_of_column[column as usize],
            };
            if parent != NONE {
                let first = &mut structure.first_child[parent as usize];
                structure.sibling[group as usize] = std::mem::replace(first, group);
            }
            let below = first..structure.rows.len();
            let group = Group { columns: range[0]..range[1], below, start, parent };
            start += group.len();
            structure.groups.push(group);
        }
        structure
    }

    /// Number of values of the factors.
    pub fn len(&self) -> usize {
        self.groups.last().map_or(0, |last| last.start + last.len())
    }

    /// The groups whose rows below are assembled into a group.
    pub fn children(&self, group: usize) -> impl Iterator<Item = usize> {
        let some = |group: u32| (group != NONE).then_some(group as usize);
        std::iter::successors(some(self.first_child[group]), move |&child| {
            some(self.sibling[child])
        })
    }

    /// The rows below a group.
    pub fn below(&self, group: &Group) -> &[u32] {
        &self.rows[group.below.clone()]
    }
}

/// The parent of each column in the elimination tree, and the number of rows of its factor; `None` if
/// these add up to more than `most`.
fn elimination_tree(lower: &Matrix, most: u64) -> Option<(Vec<u32>, Vec<u32>)> {
    let columns = lower.columns();
    // The entries left of the diagonal, row by row.
    let mut starts = vec![0_u32; columns + 1];
    for &row in &lower.rows {
        starts[row as usize + 1] += 1;
    }
    for row in 0..columns {
        starts[row + 1] += starts[row];
    }
    let mut next = starts.clone();
    let mut of_rows = vec![0; lower.rows.len()];
    for column in 0..columns {
        for &row in lower.column(column).0 {
            of_rows[next[row as usize] as usize] = column as u32;
            next[row as usize] += 1;
        }
    }
    let (mut parents, mut counts) = (vec![NONE; columns], vec![1; columns]);
    let mut seen = vec![NONE; columns];
    let mut values = 0;
    for row in 0..columns as u32 {
        if values > most {
            return None;
        }
        values += 1;
        seen[row as usize] = row;
        for &column in &of_rows[starts[row as usize] as usize..next[row as usize] as usize] {
            // All columns from the entry's up to the row itself have it in their factors.
            let mut column = column as usize;
            while seen[column] != row {
                seen[column] = row;
                counts[column] += 1;
                values += 1;
                if parents[column] == NONE {
                    parents[column] = row;
                }
                column = parents[column] as usize;
            }
        }
    }
    Some((parents, counts))
}

/// The number of each column in an order in which branches are consecutive and children come before
/// parents, the one with most rows last, since it is the one that can be merged.
fn postorder(parents: &[u32], counts: &[u32]) -> Vec<u32> {
    let columns = parents.len();
    let (mut first_child, mut sibling) = (vec![NONE; columns], vec![NONE; columns]);
    let mut roots = Vec::new();
    for column in (0..columns as u32).rev() {
        match parents[column as usize] {
            NONE => roots.push(column),
            parent => {
                let first = &mut first_child[parent as usize];
                sibling[column as usize] = std::mem::replace(first, column);
            }
        }
    }
    // From the last number to the first: a column before its children, and of these the largest
    // first.
    let mut number = vec![0; columns];
    let mut left = columns as u32;
    let mut stack = roots;
    while let Some(column) = stack.pop() {
        left -= 1;
        number[column as usize] = left;
        let begin = stack.len();
        let mut child = first_child[column as usize];
        while child != NONE {
            stack.push(child);
            child = sibling[child as usize];
        }
        if let Some(largest) =
            (begin..stack.len()).max_by_key(|&index| counts[stack[index] as usize])
        {
            let last = stack.len() - 1;
            stack.swap(largest, last);
        }
    }
    number
}

/// The first column of each group of columns with the same rows, and the number of columns.
fn groups(parents: &[u32], counts: &[u32]) -> Vec<u32> {
    let continues = |column: usize| {
        parents[column - 1] == column as u32 && counts[column - 1] == counts[column] + 1
    };
    let columns = parents.len();
    let starts = (0..columns).filter(|&column| column == 0 || !continues(column));
    starts.chain([columns]).map(|column| column as u32).collect()
}

/// Merges groups with the next one, if that is their parent, where few zeros have to be stored: the
/// fewer columns, the more.
fn merged(parents: &[u32], counts: &[u32], firsts: &[u32]) -> Vec<u32> {
    /// Up to so many columns, this share of zeros. These are CHOLMOD's defaults (`nrelax`,
    /// `zrelax`).
    const ZEROS: [(u64, f64); 4] = [(4, 1.0), (16, 0.8), (48, 0.1), (u64::MAX, 0.05)];
    /// The last groups so far, which later ones may be merged into.
    struct Last {
        first: u32,
        end: u32,
        /// How many zeros it stores on and below its diagonal.
        zeros: u64,
    }
    let mut groups: Vec<Last> = Vec::with_capacity(firsts.len());
    // All columns of a group have the rows below its last one.
    let below = |group: &Last| u64::from(counts[group.end as usize - 1]) - 1;
    for range in firsts.windows(2) {
        let mut group = Last { first: range[0], end: range[1], zeros: 0 };
        while let Some(child) = groups.last() {
            if !(group.first..group.end).contains(&parents[child.end as usize - 1]) {
                break;
            }
            let [child_width, width] =
                [child, &group].map(|group| u64::from(group.end - group.first));
            let all = child_width + width;
            // The child's columns get all rows of the parent.
            let zeros = child.zeros
                + group.zeros
                + child_width * (width + below(&group)).saturating_sub(below(child));
            let values = all * (all + 1) / 2 + all * below(&group);
            let (_, share) = ZEROS[ZEROS.partition_point(|&(most, _)| most < all)];
            if zeros as f64 > share * values as f64 {
                break;
            }
            group = Last { first: child.first, end: group.end, zeros };
            groups.pop();
        }
        groups.push(group);
    }
    groups.iter().map(|group| group.first).chain([parents.len() as u32]).collect()
}
