"""The matrix of a transfer as sparse rows, for what the compiled products cannot do."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uvgraft._uvgraft import Operator


class Rows(NamedTuple):
    """A sparse matrix in compressed rows (CSR).

    Attributes
    ----------
    values : ndarray of float32, shape (entries,)
        What is not 0, row by row.
    columns : ndarray of int32, shape (entries,)
        The column of each value.
    starts : ndarray of int64, shape (rows + 1,)
        The first entry of each row, and the number of entries.
    shape : (int, int)
        Numbers of rows and of columns.
    """

    values: NDArray[np.float32]
    columns: NDArray[np.int32]
    starts: NDArray[np.int64]
    shape: tuple[int, int]

    @classmethod
    def of(cls, operator: Operator) -> Rows:
        """Return the rows of a transfer; they are the texels of the target."""
        parts, shape = operator.csr()
        return cls(*parts, shape)

    def transposed(self) -> Rows:
        """Return the rows of the transpose."""
        rows, columns = self.shape
        row_of_entry = np.repeat(np.arange(rows, dtype=np.int32), np.diff(self.starts))
        # Stable, so that entries of a row stay in ascending order of their columns.
        order = np.argsort(self.columns, kind="stable")
        starts = np.zeros(columns + 1, np.int64)
        np.cumsum(np.bincount(self.columns, minlength=columns), out=starts[1:])
        return Rows(self.values[order], row_of_entry[order], starts, (columns, rows))

    def product(self, planes: NDArray[Any]) -> NDArray[Any]:
        """Return the product with each plane, in the dtype of the planes.

        Parameters
        ----------
        planes : ndarray of float, shape (planes, columns)
            Texels row by row.

        Returns
        -------
        ndarray of float, shape (planes, rows)
        """
        done = np.zeros((len(planes), self.shape[0]), planes.dtype)
        # `reduceat` gives a row without entries the first value of the next one.
        filled = self.starts[:-1] < self.starts[1:]
        starts = self.starts[:-1][filled]
        if len(starts):
            for plane, result in zip(planes, done, strict=True):
                result[filled] = np.add.reduceat(self.values * plane[self.columns], starts)
        return done
