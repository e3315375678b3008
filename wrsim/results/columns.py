"""One wide table of a result: a row a sample (instant or pose), a column for each wheelset, wheel, ..."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING, Any

import xarray as xr
from numpy.typing import NDArray

from wrsim.results.channels import CHANNELS, Channel

if TYPE_CHECKING:
    from pandas import DataFrame

Column = tuple[str, Channel, NDArray[Any]]
"""Name, channel, values of one column."""


def columns(dataset: xr.Dataset) -> Iterator[Column]:
    """The wide table, the samples first: names as in ``Y_front.outer_left_kN``; strips and outlines are left out."""
    sample = "time" if "time" in dataset.dims else "pose"
    for name, channel in CHANNELS.items():
        if name not in dataset.variables:
            continue
        data = dataset[name]
        if not data.dims or data.dims[0] != sample or "strip" in data.dims:
            continue
        labels = [
            [str(v) for v in dataset[d].values] if d in dataset.coords else range(dataset.sizes[d])
            for d in data.dims[1:]
        ]
        for column, place in enumerate(product(*(range(dataset.sizes[d]) for d in data.dims[1:]))):
            own = [str(label[i]) for label, i in zip(labels, place, strict=True)]
            words = (name, *own, channel.shown.suffix if channel.kind == "number" else "")
            values = data.values.reshape(data.shape[0], -1)[:, column]
            if channel.kind == "number":
                values = values * channel.shown.factor
            yield "_".join(word.replace(" ", "_") for word in words if word), channel, values


def frame(dataset: xr.Dataset) -> DataFrame:
    """The wide table as a data frame; ``attrs["units"]`` holds the unit of every column."""
    import pandas as pd

    found = list(columns(dataset))
    table = pd.DataFrame({name: values for name, _, values in found})
    table.attrs["units"] = {name: channel.shown.symbol for name, channel, _ in found if channel.kind == "number"}
    return table
