"""Tables: named columns with units, and what other libraries make of them."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas
    import polars
    import xarray

_SHOWN_ROWS = 8
_SHOWN_COLUMNS = 12


@dataclass(frozen=True)
class Column:
    """A column of a table."""

    name: str
    values: NDArray[Any]
    """Numbers (NaN where there is none) or texts, one for each row."""
    unit: str = ""
    """Such as mm or N/mm; empty for texts and plain numbers."""
    description: str = ""
    """What it says, where the name and the unit do not say it."""

    @property
    def attributes(self) -> dict[str, str]:
        """Unit and description, as far as there are any, under the names that xarray and CF use."""
        named = {"units": self.unit, "description": self.description}
        return {name: text for name, text in named.items() if text}


class Table(Mapping[str, NDArray[Any]]):
    """Columns of the same length by name: ``table["deflection_mm"]``."""

    def __init__(self, name: str, columns: Sequence[Column]) -> None:
        self.name = name
        self._columns = {column.name: column for column in columns}

    def __getitem__(self, name: str) -> NDArray[Any]:
        try:
            return self._columns[name].values
        except KeyError:
            raise KeyError(f"{name}; there are: {', '.join(self._columns)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """Number of columns; rows are :attr:`rows`."""
        return len(self._columns)

    def __repr__(self) -> str:
        return f"Table {self.name}: {self.rows} rows of {', '.join(self._columns)}"

    @property
    def columns(self) -> list[Column]:
        """The columns with their units."""
        return list(self._columns.values())

    @property
    def rows(self) -> int:
        """Number of rows."""
        return max((len(column.values) for column in self._columns.values()), default=0)

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column that has one."""
        return {column.name: column.unit for column in self._columns.values() if column.unit}

    def where(self, **values: object) -> Table:
        """The rows that have these values in these columns, such as ``source="all"``."""
        keep = np.ones(self.rows, dtype=bool)
        for name, value in values.items():
            keep &= self[name] == value
        kept = [Column(c.name, c.values[keep], c.unit, c.description) for c in self.columns]
        return Table(self.name, kept)

    def to_pandas(self) -> pandas.DataFrame:
        """As a data frame; units are in ``frame.attrs["units"]``."""
        import pandas

        frame = pandas.DataFrame({name: self[name] for name in self})
        frame.attrs["units"] = self.units
        return frame

    def to_polars(self) -> polars.DataFrame:
        """As a data frame; NaN where there is no number."""
        import polars

        return polars.DataFrame(
            {name: self[name].tolist() if self[name].dtype == object else self[name] for name in self}
        )

    def to_arrow(self) -> Any:
        """As a ``pyarrow.Table``; units and descriptions are metadata of its fields."""
        import pyarrow

        arrays = [pyarrow.array(column.values, from_pandas=True) for column in self.columns]
        fields = [
            pyarrow.field(column.name, array.type, metadata=column.attributes)
            for column, array in zip(self.columns, arrays, strict=True)
        ]
        return pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields))

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """For whatever reads Arrow streams; needs pyarrow."""
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def to_xarray(self, *dims: str) -> xarray.Dataset:
        """As a data set over the values of the columns `dims`, such as ``"x_mm", "y_mm", "z_mm", "source"``; without
        any, over its rows.

        Rows that no combination has are NaN, or empty texts. Two rows of one combination raise a ValueError.
        """
        import xarray

        if not dims:
            rows = {c.name: ("row", c.values, c.attributes) for c in self.columns}
            return xarray.Dataset(rows, attrs={"name": self.name})
        coordinates, places = {}, []
        for dim in dims:
            values, first, inverse = np.unique(self[dim], return_index=True, return_inverse=True)
            if self[dim].dtype == object:
                # Words keep the order in which they come.
                order = np.argsort(first)
                values, inverse = values[order], np.argsort(order)[inverse]
            coordinates[dim] = (dim, values, self._columns[dim].attributes)
            places.append(inverse.reshape(-1))
        shape = tuple(len(values) for _, values, _ in coordinates.values())
        index = np.ravel_multi_index(places, shape) if self.rows else np.zeros(0, dtype=np.int64)
        if len(np.unique(index)) < self.rows:
            raise ValueError(f"{self.name}: several rows have the same {', '.join(dims)}; expected one")
        variables = {}
        for column in self.columns:
            if column.name not in dims:
                is_text = column.values.dtype == object
                cells = np.full(int(np.prod(shape)), "" if is_text else np.nan, dtype=object if is_text else np.float64)
                cells[index] = column.values
                variables[column.name] = (dims, cells.reshape(shape), column.attributes)
        return xarray.Dataset(variables, coords=coordinates, attrs={"name": self.name})

    def _repr_html_(self) -> str:
        """The first rows, in a notebook."""
        columns = self.columns[:_SHOWN_COLUMNS]
        heads = "".join(f"<th>{html.escape(column.name)}</th>" for column in columns)
        body = "".join(
            "<tr>" + "".join(f"<td>{html.escape(_shown(column.values[row]))}</td>" for column in columns) + "</tr>"
            for row in range(min(self.rows, _SHOWN_ROWS))
        )
        more = f"{html.escape(self.name)}: {self.rows} rows, {len(self)} columns"
        return f"<table><thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table><p>{more}</p>"


def _shown(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
