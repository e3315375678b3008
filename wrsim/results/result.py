"""A Result: one labelled dataset, kept in one NetCDF file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from wrsim.errors import InputError
from wrsim.register import resolved
from wrsim.results.dataset import FORMAT, FORMAT_VERSION, fault_of_result
from wrsim.results.netcdf import read_netcdf, write_netcdf

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from wrsim.results.table import Table


@dataclass(frozen=True, eq=False)
class Result:
    """What an analysis computed, with everything needed to redraw and to rerun it.

    A stopped run holds what was computed until it stopped. The numbers of a long run stay on disk
    (`wrsim.results.netcdf`) and are read as they are asked for; ``dataset.load()`` brings them all into memory.

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
        from wrsim.results.repr import result_text

        return result_text(self.dataset)

    def numbers(self) -> list[Table]:
        """The tables that people read first: peaks, medians in full curves, critical speeds."""
        from wrsim.results.summary_tables import numbers_of

        return numbers_of(self.dataset, self.summary())

    def _repr_html_(self) -> str:
        from wrsim.results.repr import result_html

        return result_html(self.dataset)

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
        """Channels of one wheelset, without the dimension ``wheelset``; ``distance`` is its own.

        Parameters
        ----------
        name : str, optional
            Not needed where there is only one.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        InputError
            For a wrong name, or when one is needed; lists which there are.
        """
        from wrsim.results.wheelsets import of_wheelset

        return of_wheelset(self.dataset, name)

    def patch(
        self,
        at: str | float,
        wheel: str | None = None,
        *,
        wheelset: str | None = None,
        number: int = 0,
        columns: int = 101,
    ) -> xr.Dataset:
        """One contact patch as arrays.

        Parameters
        ----------
        at : float or str
            Distance along the track [m] of a moment whose patches are kept (the nearest within 1 m), or name of a pose.
        wheel : {"left", "right"}, optional
            Not needed where there is only one.
        wheelset : str, optional
            Not needed where there is only one.
        number : int
            Of the patch, 0 for the one with the largest normal force.
        columns : int
            Number of points along x; the exact solver's elements have columns of their own.

        Returns
        -------
        xarray.Dataset
            ``p`` (s, x): pressures [Pa], zero outside of contact; coordinates ``s`` (s,), curved axis from the main
            point to the field side [m], and ``x`` (x,), along the track [m]; with the exact solver ``qx`` and ``qs``,
            tractions [Pa]. The strips' own channels along ``s`` (``strip_ds``, ``strip_a``, ``strip_N`` ...), and the
            numbers of the patch (``N``, ``p0``, ``area``, ``contact_angle`` ...), all in SI units.

        Raises
        ------
        InputError
            For a wheelset, a wheel, a place, a pose or a patch that is not there; lists which there are.
        """
        from wrsim.results.moments import patch_of

        return patch_of(self.wheelset(wheelset), at, wheel, number, columns)

    def to_dataframe(self, wheelset: str | None = None) -> DataFrame:
        """All channels over time or poses as one wide table, as ``wrsim export`` writes it.

        Parameters
        ----------
        wheelset : str, optional
            This one alone, its columns without its name. Default: all.

        Returns
        -------
        pandas.DataFrame
            A row an instant or pose, a column for every wheelset, wheel and patch, in units for readers, which are
            at the end of the name (``Y_wheelset_left_kN``) and in ``attrs["units"]``.

        Raises
        ------
        InputError
            For a wheelset that is not there; lists which there are.
        """
        from wrsim.results.tables import frame

        return frame(self.dataset if wheelset is None else self.wheelset(wheelset))

    def plot(self, *names: str, wheelset: str | None = None) -> Figure:
        """One of the standard pictures, or histories of channels.

        Parameters
        ----------
        *names : str
            One of ``pictures``; or channels (``"Y"``, ``"lateral_shift"``), drawn above each other over the distance,
            of poses over the lateral shift. Default: the first picture.
        wheelset : str, optional
            Needed for channels where there are several wheelsets.

        Returns
        -------
        matplotlib.figure.Figure
            Made without pyplot: ``savefig`` writes it, notebooks show it.

        Raises
        ------
        InputError
            For a name that is neither a picture nor a channel of this result, and for a wheelset that is not there.
        """
        figure: Figure = resolved("wrsim.plots.pictures:picture")(self, names, wheelset)
        return figure

    @property
    def pictures(self) -> tuple[str, ...]:
        """Names of the standard pictures, for `plot`."""
        return tuple(resolved("wrsim.plots.pictures:standard_figures")(self.dataset))

    def summary(self) -> dict[str, Any]:
        """Peak and quasi-static values as plain numbers in units for readers; what ``summary.json`` holds.

        Returns
        -------
        dict
            Units are in the keys: ``summary["wheelsets"]["wheelset"]["wheels"]["left"]["Y_max_kN"]``.
        """
        from wrsim.results.summary import summarise

        return summarise(self.dataset)

    def save(self, path: str | Path) -> Path:
        """Write the dataset as NetCDF 4; the file appears whole or not at all.

        Parameters
        ----------
        path : str or Path
            An older file of that name is replaced.

        Returns
        -------
        Path

        Raises
        ------
        WrsimError
            When the disk is full or the place cannot be written to.
        """
        return write_netcdf(path, self.dataset)

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Read a file that `save` wrote, or the result in the folder of a run.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        Result

        Raises
        ------
        InputError
            When it is missing, damaged or not ours.
        """
        path = Path(path)
        if path.is_dir():
            path = path / "result.nc"
        dataset = _without_encoding(read_netcdf(path, "result"))
        attributes = dataset.attrs
        if attributes.get("format") != FORMAT:
            raise InputError(f"{path}: a NetCDF file, but not a wrsim result")
        version = attributes.get("format_version")
        if not isinstance(version, int):
            raise InputError(f"{path}: says that it is a wrsim result, but not in which format; run the scenario again")
        if version > FORMAT_VERSION:
            raise InputError(
                f"{path}: written by a newer wrsim ({attributes.get('wrsim_version', 'unknown version')}) "
                f"in format {version}; this one reads up to {FORMAT_VERSION}"
            )
        dataset = _with_rails_of_moments(dataset)
        if fault := fault_of_result(dataset):
            raise InputError(f"{path}: says that it is a wrsim result, but {fault}; run the scenario again")
        return cls(dataset)


def _without_encoding(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset without the traces of its file, so that it saves like a fresh one."""
    clean: xr.Dataset = dataset.drop_encoding()
    clean.attrs = {n: value.item() if getattr(value, "size", 0) == 1 else value for n, value in clean.attrs.items()}
    return clean


def _with_rails_of_moments(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with the rails' sections of every moment, of which format 2 kept one for all."""
    moments = dataset["wheel_profile_y"].sizes if "wheel_profile_y" in dataset else {}
    for name in ("rail_profile_y", "rail_profile_z"):
        if name in dataset and dataset[name].dims == ("wheel", "rail_point"):
            if not moments:
                dataset = dataset.drop_vars(name)
                continue
            own = dataset[name]
            own = own.expand_dims({dim: size for dim, size in moments.items() if dim not in ("wheel", "wheel_point")})
            dataset[name] = own.copy()
    dataset.attrs["format_version"] = FORMAT_VERSION
    return dataset
