"""A Result: one labelled dataset, stored in one NetCDF file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr
from markupsafe import Markup

from wrsim.errors import InputError
from wrsim.inputs.file_kinds import resolved
from wrsim.results.dataset import FORMAT, FORMAT_VERSION, faults_of_result
from wrsim.results.netcdf import read_netcdf, write_netcdf
from wrsim.results.table import Table, as_html, as_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@dataclass(frozen=True, eq=False)
class Result:
    """What an analysis computed, with everything needed to redraw and to rerun it.

    A stopped run holds what was computed until it stopped. The numbers of a long run stay on disk until they are used;
    ``dataset.load()`` brings them all into memory.

    Parameters
    ----------
    dataset : xarray.Dataset
        Channels as variables with ``units`` (SI) and ``long_name``; scenario text, status and versions as attributes.

    Examples
    --------
    >>> from wrsim import Result
    >>> result = Result.load("results/curve_r300")
    >>> result.plot("Y", "Q").savefig("forces.png")
    >>> patch = result.patch(120.0, "right")
    >>> patch.s, patch.x, patch.p
    """

    dataset: xr.Dataset

    def __repr__(self) -> str:
        return f"<Result: {self.title}>\n{as_text(self._tables())}"

    def _tables(self) -> list[Table]:
        """The overview; behind it, where no wheel has forces, the numbers."""
        from wrsim.results.summary_tables import overview

        return overview(self.dataset) + ([] if "Q" in self.dataset else self.numbers())

    def numbers(self) -> list[Table]:
        """The tables that people read first: peaks, medians in full curves, critical speeds."""
        from wrsim.results.summary_tables import numbers_of

        return numbers_of(self.dataset, self.summary())

    def _repr_html_(self) -> str:
        tables = Markup("").join(map(as_html, self._tables()))
        return Markup("<div><strong>{}</strong>{}</div>").format(self.title, tables)

    @property
    def title(self) -> str:
        """Title of the scenario."""
        return str(self.dataset.attrs["title"])

    @property
    def analysis(self) -> str:
        """Its kind, such as ``"static"``, ``"equilibrium"`` or ``"curving"``."""
        return str(self.dataset.attrs["analysis"])

    @property
    def status(self) -> str:
        """``"completed"`` or ``"stopped"``."""
        return str(self.dataset.attrs["status"])

    @property
    def stop_reason(self) -> str:
        """Why the analysis stopped early; empty when it did not."""
        return str(self.dataset.attrs.get("stop_reason", ""))

    def wheelset(self, name: str | None = None) -> xr.Dataset:
        """Channels of one wheelset, without the dimension ``wheelset``; ``distance`` is its own. name: needed where
        there are several. Raises ``InputError`` for a wrong or missing name; the message lists all names."""
        from wrsim.results.wheelsets import of_wheelset

        return of_wheelset(self.dataset, name)

    def fast(self, wheelset: str | None = None) -> xr.Dataset:
        """The channels of ``run.fast_channels`` in place of the others, over their own ``time`` and by the same names:
        ``result.fast()["Q"]``. wheelset: this one alone. Raises ``InputError`` where there are none."""
        from wrsim.results.wheelsets import fast_of

        return fast_of(self.dataset if wheelset is None else self.wheelset(wheelset))

    def patch(
        self,
        at: str | float,
        wheel: str | None = None,
        *,
        wheelset: str | None = None,
        number: int = 0,
        columns: int = 101,
    ) -> xr.Dataset:
        """One contact patch as arrays, in SI units.

        at: distance of the vehicle [m] at a snapshot (the nearest within 1 m), or name of a pose; wheel, wheelset: not
        needed where there is only one; number: of the patch, 0 for the one with the largest normal force; columns:
        points along x, except for the elements of the exact solver.

        The dataset holds ``p`` (s, x): pressures [Pa], zero outside of contact, over ``s`` (s,), curved axis from the
        main point to the field side [m], and ``x`` (x,), along the track [m]; with the exact solver ``qx`` and ``qs``,
        tractions [Pa]; channels of strips along ``s`` (``strip_ds``, ``strip_a``, ``strip_N`` ...); numbers of the
        patch (``N``, ``p0``, ``area``, ``contact_angle`` ...). Raises ``InputError`` for a wheelset, wheel, place, pose
        or patch that does not exist; the message lists those that do.
        """
        from wrsim.results.moments import patch_of

        return patch_of(self.wheelset(wheelset), at, wheel, number, columns)

    def to_dataframe(self, wheelset: str | None = None) -> DataFrame:
        """All channels over the distance along the track [m], or over the poses, in units for readers.

        Columns have three levels, wheelset, wheel and channel, empty where a channel has none of them:
        ``table["front.outer", "left", "Y"]``. A patch, body or point follows the channel: ``"p0_0"``. The units of the
        columns are in ``attrs["units"]``.

        wheelset: this one alone, its name left out. Raises ``InputError`` for a name that is none.
        """
        from wrsim.results.tables import indexed_frame

        return indexed_frame(self.dataset if wheelset is None else self.wheelset(wheelset))

    def plot(self, *names: str, wheelset: str | None = None) -> Figure:
        """One of the standard pictures, or histories of channels.

        names: one of ``pictures``; or channels (``"Y"``, ``"lateral_shift"``), drawn above each other over the
        distance, of poses over the lateral shift. Default: the first picture. wheelset: needed for channels where there
        are several. ``"fast_Q"`` is a fast channel. The figure is made without pyplot: ``savefig`` writes it, notebooks
        show it. Raises ``InputError`` for a name that is neither a picture nor a channel of this result, and for an
        unknown wheelset.
        """
        figure: Figure = resolved("wrsim.plots.pictures:picture")(self, names, wheelset)
        return figure

    @property
    def pictures(self) -> tuple[str, ...]:
        """Names of the standard pictures, for `plot`."""
        return tuple(resolved("wrsim.plots.pictures:standard_figures")(self.dataset))

    def summary(self) -> dict[str, Any]:
        """Peak and quasi-static values as plain numbers, which ``summary.json`` holds; units for readers are in the
        keys: ``summary["wheelsets"]["wheelset"]["wheels"]["left"]["Y_max_kN"]``.
        """
        from wrsim.results.summary import summarise

        return summarise(self.dataset)

    def save(self, path: str | Path) -> Path:
        """Write the dataset as NetCDF 4 in place of an older file, whole or not at all. Raises ``WrsimError`` when the
        disk is full or the place cannot be written to."""
        return write_netcdf(path, self.dataset)

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Read a file of `save`, or the result in a run's folder. Raises ``InputError``: missing, damaged, none."""
        path = Path(path)
        if path.is_dir():
            path = path / "result.nc"
        dataset = read_netcdf(path, "result").drop_encoding()
        attributes = {n: v.item() if getattr(v, "size", 0) == 1 else v for n, v in dataset.attrs.items()}
        dataset.attrs = attributes
        if attributes.get("format") != FORMAT:
            noun = {"wrsim study": "a study", "wrsim wear": "a profile evolution"}.get(str(attributes.get("format")))
            kind = f"{noun} (wrsim report)" if noun else "another NetCDF file"
            raise InputError(f"{path}: not a wrsim result, but {kind}")
        version = attributes.get("format_version")
        if not isinstance(version, int):
            raise InputError(f"{path}: is marked as a wrsim result, but has no format; run the scenario again")
        if version > FORMAT_VERSION:
            raise InputError(
                f"{path}: written by a newer wrsim ({attributes.get('wrsim_version', 'unknown version')}) "
                f"in format {version}; this one reads up to {FORMAT_VERSION}"
            )
        dataset = _with_rails_of_moments(dataset)
        for fault in faults_of_result(dataset):
            raise InputError(f"{path}: is marked as a wrsim result, but {fault}; run the scenario again")
        return cls(dataset)


def _with_rails_of_moments(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with the rails' sections of every moment; format 2 has one for all."""
    moments = dataset["wheel_profile_y"].sizes if "wheel_profile_y" in dataset else {}
    for name in ("rail_profile_y", "rail_profile_z"):
        if name in dataset and dataset[name].dims == ("wheel", "rail_point"):
            if not moments:
                dataset = dataset.drop_vars(name)
                continue
            var = dataset[name]
            var = var.expand_dims({dim: size for dim, size in moments.items() if dim not in ("wheel", "wheel_point")})
            dataset[name] = var.copy()
    dataset.attrs["format_version"] = FORMAT_VERSION
    return dataset
