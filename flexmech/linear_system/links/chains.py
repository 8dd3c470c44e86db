"""Block-banded matrices of a chain of elements, stored element by element.

The matrix of a link of many elements is zero but for a narrow band. Its elements take memory that
grows with their number, where all entries of the matrix take its square. Of few elements the whole
matrix is as small and faster, so that a link matrix is either of both.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from flexmech.arrays import FloatArray, IntArray

# Up to so many elements products of whole matrices are faster. Speed alone.
MOST_WHOLE = 16


@dataclass(frozen=True, eq=False)
class ChainMatrix:
    """Sum of the matrices of consecutive elements of p coordinates a node.

    Parameters
    ----------
    elements : ndarray, shape (..., e, 2 p, 2 p)
        The matrix has the shape (..., n, n), n = p (e + 1), with one batch dimension or none.
    """

    elements: FloatArray

    # Products with arrays are those below, in whichever order they are written.
    __array_ufunc__ = None

    @property
    def per_node(self) -> int:
        """Coordinates p of a node."""
        return int(self.elements.shape[-1]) // 2

    @property
    def shape(self) -> tuple[int, ...]:
        """As of the whole matrix, (..., n, n)."""
        size: int = self.per_node * (self.elements.shape[-3] + 1)
        return (*self.elements.shape[:-3], size, size)

    @property
    def ndim(self) -> int:
        """2, or 3 of a batch."""
        return self.elements.ndim - 1

    @property
    def T(self) -> ChainMatrix:  # noqa: N802  (as of an array)
        """Transposed, also of each matrix of a batch."""
        return ChainMatrix(np.swapaxes(self.elements, -1, -2))

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, which: slice | IntArray) -> ChainMatrix:
        """Matrices of some positions of a batch."""
        assert self.ndim == 3
        return ChainMatrix(self.elements[which])

    def any(self) -> bool:
        """Whether an entry is not zero."""
        return bool(self.elements.any())

    @overload
    def __matmul__(self, right: FloatArray) -> FloatArray: ...

    @overload
    def __matmul__(self, right: NDArray[Any]) -> NDArray[Any]: ...

    def __matmul__(self, right: NDArray[Any]) -> NDArray[Any]:
        """Product with vectors, as of whole matrices."""
        columns = right[:, None] if right.ndim == 1 else right
        index, size = _coordinates(*self.elements.shape[-3:-1]), self.per_node
        forces = self.elements @ columns[..., index, :]
        total = np.zeros((*forces.shape[:-3], len(index) + 1, size, forces.shape[-1]), forces.dtype)
        total[..., :-1, :, :] = forces[..., :size, :]
        total[..., 1:, :, :] += forces[..., size:, :]
        product = total.reshape(*forces.shape[:-3], self.shape[-1], forces.shape[-1])
        return product[..., 0] if right.ndim == 1 else product

    @overload
    def __rmatmul__(self, left: FloatArray) -> FloatArray: ...

    @overload
    def __rmatmul__(self, left: NDArray[Any]) -> NDArray[Any]: ...

    def __rmatmul__(self, left: NDArray[Any]) -> NDArray[Any]:
        """Product with vectors, as of whole matrices."""
        if left.ndim == 1:
            return self.T @ left
        return np.swapaxes(self.T @ np.swapaxes(left, -1, -2), -1, -2)

    def diagonal(self) -> FloatArray:
        """Entries on the diagonal, (..., n)."""
        own = np.diagonal(self.elements, axis1=-2, axis2=-1)
        size, batch = self.per_node, self.elements.shape[:-3]
        total = np.zeros((*batch, self.elements.shape[-3] + 1, size))
        total[..., :-1, :] = own[..., :size]
        total[..., 1:, :] += own[..., size:]
        return total.reshape(*batch, -1)

    def with_entries(self, rows: IntArray, columns: IntArray, values: FloatArray) -> ChainMatrix:
        """The matrix with entries added, each within an element.

        Parameters
        ----------
        rows, columns : ndarray of int, shape (k,)
        values : ndarray, shape (..., k)
            May be of a batch where the matrix is of none.
        """
        count = self.elements.shape[-3]
        element = np.minimum(np.minimum(rows, columns) // self.per_node, count - 1)
        first = self.per_node * element
        batch = np.broadcast_shapes(self.elements.shape[:-3], values.shape[:-1])
        elements = np.array(np.broadcast_to(self.elements, (*batch, *self.elements.shape[-3:])))
        for number, (e, row, column) in enumerate(
            zip(element, rows - first, columns - first, strict=True)
        ):
            elements[..., e, row, column] += values[..., number]
        return ChainMatrix(elements)

    def __add__(self, other: ChainMatrix) -> ChainMatrix:
        return ChainMatrix(self.elements + other.elements)

    def sparse(self) -> csc_array:
        """As a sparse matrix (n, n); not of a batch."""
        index, (count, size, _) = _coordinates(*self.elements.shape[:2]), self.elements.shape
        rows = np.broadcast_to(index[:, :, None], (count, size, size))
        columns = np.broadcast_to(index[:, None], (count, size, size))
        entries = (self.elements.ravel(), (rows.ravel(), columns.ravel()))
        return csc_array(entries, shape=self.shape)

    def whole(self) -> FloatArray:
        """The full matrix, (..., n, n)."""
        size, count = self.per_node, self.elements.shape[-3]
        first, second = slice(0, size), slice(size, None)
        total = np.zeros((*self.elements.shape[:-3], count + 1, size, count + 1, size))
        of_nodes = _along_diagonal(total)
        of_nodes[..., :-1, :, :] = self.elements[..., first, first]
        of_nodes[..., 1:, :, :] += self.elements[..., second, second]
        _along_diagonal(total[..., :-1, :, 1:, :])[:] = self.elements[..., first, second]
        _along_diagonal(total[..., 1:, :, :-1, :])[:] = self.elements[..., second, first]
        return total.reshape(self.shape)


LinkMatrix = FloatArray | ChainMatrix
"""Matrix of a link, (n, n) or (B, n, n): whole, or that of a chain of elements."""


def whole(matrix: LinkMatrix) -> FloatArray:
    """A link matrix as a full one, (n, n) or (B, n, n)."""
    return matrix.whole() if isinstance(matrix, ChainMatrix) else matrix


def diagonal(matrix: LinkMatrix) -> FloatArray:
    """Entries on the diagonal, (n,) or (B, n)."""
    if isinstance(matrix, ChainMatrix):
        return matrix.diagonal()
    return np.diagonal(matrix, axis1=-2, axis2=-1)


def couples(matrix: LinkMatrix, some: NDArray[np.bool_], others: NDArray[np.bool_]) -> bool:
    """Whether a matrix couples some coordinates with others.

    Parameters
    ----------
    matrix : ndarray or ChainMatrix, shape (n, n)
    some, others : ndarray of bool, shape (n,)
    """
    if not isinstance(matrix, ChainMatrix):
        return bool(matrix[..., some, :][..., others].any())
    index = _coordinates(*matrix.elements.shape[:2])
    between = some[index][:, :, None] & others[index][:, None]
    return bool(matrix.elements[between].any())


def in_positions(matrix: LinkMatrix, which: slice | IntArray) -> LinkMatrix:
    """A link matrix in some positions; a constant one stays."""
    return matrix[which] if matrix.ndim == 3 else matrix


def chain_matrix(elements: FloatArray) -> LinkMatrix:
    """Sum of the matrices of consecutive elements, in the form that suits their number.

    Parameters
    ----------
    elements : ndarray, shape (..., e, 2 p, 2 p)
    """
    matrix = ChainMatrix(elements)
    return matrix if elements.shape[-3] > MOST_WHOLE else matrix.whole()


def chain_matrices(elements: FloatArray) -> list[LinkMatrix]:
    """Several matrices of one chain, each as by :func:`chain_matrix`.

    Parameters
    ----------
    elements : ndarray, shape (k, ..., e, 2 p, 2 p)
    """
    if elements.shape[-3] > MOST_WHOLE:
        return [ChainMatrix(own) for own in elements]
    return list(ChainMatrix(elements).whole())


def summed(first: LinkMatrix, second: LinkMatrix) -> LinkMatrix:
    """Sum of two link matrices of one form, (n, n) or (B, n, n)."""
    if isinstance(first, ChainMatrix) and isinstance(second, ChainMatrix):
        return first + second
    return whole(first) + whole(second)


def times(matrix: FloatArray, columns: NDArray[Any]) -> NDArray[Any]:
    """Product of a link's matrix with vectors in all positions.

    Parameters
    ----------
    matrix : ndarray, shape (r, n), (D, r, n) or (B, r, n)
        The same in all positions, in those of each design, or different in every one.
    columns : ndarray, shape (B, n, m)

    Returns
    -------
    ndarray, shape (B, r, m)
    """
    batch, size, count = columns.shape
    if matrix.ndim == 3 and len(matrix) == batch:
        return np.asarray(matrix @ columns)
    *designs, rows, _ = matrix.shape
    each = batch // (designs or [1])[0]
    product = matrix[..., None, :, :] @ columns.reshape(*designs, each, size, count)
    return np.asarray(product.reshape(batch, rows, count))


def as_real(columns: NDArray[Any]) -> FloatArray:
    """Columns (B, n, m), each complex one as two: its real and its imaginary part."""
    return np.ascontiguousarray(columns).view(float)


def as_given(real: FloatArray, columns: NDArray[Any]) -> NDArray[Any]:
    """The other way round, as ``columns`` are."""
    return np.ascontiguousarray(real).view(columns.dtype)


def with_entries(
    matrix: LinkMatrix, rows: IntArray, columns: IntArray, values: FloatArray
) -> LinkMatrix:
    """A link matrix with entries added, each within an element.

    Parameters
    ----------
    matrix : ndarray or ChainMatrix, shape (n, n) or (B, n, n)
    rows, columns : ndarray of int, shape (k,)
        Each pair once.
    values : ndarray, shape (k,) or (B, k)

    Returns
    -------
    ndarray or ChainMatrix
        Of a batch, where the values are.
    """
    if isinstance(matrix, ChainMatrix):
        return matrix.with_entries(rows, columns, values)
    batch = np.broadcast_shapes(matrix.shape[:-2], values.shape[:-1])
    total = np.array(np.broadcast_to(matrix, (*batch, *matrix.shape[-2:])))
    total[..., rows, columns] += values
    return total


def _along_diagonal(blocks: FloatArray) -> FloatArray:
    """View of the blocks (..., i, p, i, p) of a matrix by blocks; (..., i, p, p)."""
    return np.asarray(np.einsum("...iaib->...iab", blocks))


@lru_cache(maxsize=64)
def _coordinates(count: int, size: int) -> IntArray:
    """Coordinates of each of so many elements, (e, 2 p)."""
    return (size // 2) * np.arange(count)[:, None] + np.arange(size)
