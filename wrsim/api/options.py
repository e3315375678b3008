"""Parameters of the functions that are commands too: each is described once, here or in a signature.

`documented` makes the section "Parameters" of a docstring of them, `wrsim.cli.options` the options of the command.
"""

import inspect
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Annotated, Any, ForwardRef, TypeAlias, TypedDict, TypeVar, get_args

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.scenario.loading import Scenario
    from wrsim.vehicle.vehicle import Vehicle

F = TypeVar("F", bound=Callable[..., Any])
Bar: TypeAlias = Callable[[], AbstractContextManager[Any]]
AnyPath: TypeAlias = str | Path | None
ResultLike: TypeAlias = "Result | str | Path"
ResultsLike: TypeAlias = "ResultLike | Sequence[ResultLike]"
VehicleLike: TypeAlias = "Vehicle | str"


@dataclass(frozen=True)
class Option:
    """A parameter of a function and the option of the command that gives it."""

    help: str
    """What it is."""
    metavar: str | None = None
    """Word for its value in the help of the command."""
    least: float | None = None
    """Smallest value that the command takes."""
    most: float | None = None
    """Largest value that the command takes."""
    flags: str = ""
    """Its names, unless that is --name."""
    kind: Any = None
    """Type that the command reads, unless that of the parameter."""
    default: str = ""
    """Place that the command takes unless it is given, where the function takes none; <FILE>: name of the argument."""


class Argument(Option):
    """A parameter of a function and the argument of the command that gives it."""


BESIDE = "beside the result"
into = partial(Option, flags="--output -o")
"""Where to write."""


ScenarioFile: TypeAlias = Annotated[
    "Scenario | str | Path", Argument("A scenario or its file (TOML).", "FILE", kind=Path)
]
ResultFile: TypeAlias = Annotated[
    ResultLike,
    Argument("A result: its file, the folder of a run, or a run that was cut off (.part).", "RESULT", kind=Path),
]
Values: TypeAlias = Annotated[
    Sequence[str] | Mapping[str, Any],
    Option(
        "Keys to be changed: vehicle.speed_kmh=60, vehicle.bogie.primary.stiffness_kN_per_m.2=1500.",
        "KEY=VALUE",
        flags="--set -s",
        kind=list[str],
    ),
]
Budget: TypeAlias = Annotated[
    float | None,
    Option(
        "Residuals of the strip model a wheel and evaluation, shared in a step, to bound its time; default any.",
        least=3.0,
    ),
]
Models: TypeAlias = Annotated[Sequence[str | Path], Option("Folder with your model files; may be repeated.", "DIR")]
Output: TypeAlias = Annotated[AnyPath, into("Folder; results/<name of FILE> unless given.", "DIR")]
BesideResult: TypeAlias = Annotated[AnyPath, into("Folder; beside the result unless given.", "DIR")]
TablesBeside: TypeAlias = Annotated[AnyPath, into("Folder for tables and pictures.", "DIR", default=BESIDE)]
SectionsOf: TypeAlias = Annotated[
    "Scenario | str | Path | None",
    Option("Scenario with the settings; default: those of the result.", "FILE", kind=Path | None),
]
Pictures: TypeAlias = Annotated[bool, Option("Draw the pictures.")]
Force: TypeAlias = Annotated[bool, Option("Overwrite files that wrsim did not write, or that were changed since.")]
Places: TypeAlias = Annotated[
    Sequence[str], Option("Distance of the vehicle in m, or pose, of the contacts; may be repeated.", "PLACE")
]
OneWheelset: TypeAlias = Annotated[str | None, Option("Name or number of one wheelset.", "NAME")]
ShowsProgress: TypeAlias = Annotated[Bar, "Gives a context with the callback of a progress bar."]
Warn: TypeAlias = Annotated[Callable[[str], None], "Takes a warning."]


class Reading(TypedDict, total=False):
    """How files of points are read; what a profile file says itself wins."""

    unit: Annotated[str | None, Option("Unit of files of points.", "mm|m|cm|in|thou")]
    heights: Annotated[str | None, Option("Direction of positive heights of points.", "up|down")]
    field_side: Annotated[str | None, Option("Sign of the field side in points of rails.", "positive|negative")]
    origin: Annotated[str | None, Option("Origin of x in points of wheels.", "'tape circle'|'flange back'")]
    back_to_tape_circle_mm: Annotated[
        float | None, Option("From the flange back; default: of the file, or 70.", least=20.0, most=120.0)
    ]
    measured: Annotated[
        bool | None, Option("Smooth points, or interpolate; default: by file.", flags="--measured/--exact")
    ]


class Computing(TypedDict, total=False):
    """Where and how the cases of a study are computed."""

    models: Models
    workers: Annotated[
        int | None, Option("Worker processes or SLURM jobs; default: one a processor.", "N", 1, flags="--workers -w")
    ]
    scheduler: Annotated[str | None, Option("Use the workers of this dask scheduler.", "ADDRESS")]
    slurm: Annotated[bool, Option("Run the workers as SLURM jobs (extra wrsim[cluster]).")]
    tls: Annotated[
        Path | None, Option("Certificates for --scheduler or --slurm: a folder with ca.pem, cert.pem, key.pem.", "DIR")
    ]
    force: Force
    bar: ShowsProgress
    notify: Annotated[Callable[[str], None], "Takes lines on the progress of a study."]
    warn: Warn


PARAMETERS: dict[Callable[..., Any], list[inspect.Parameter]] = {}
"""Parameters of documented functions; their annotations carry what they are."""


USUAL = {
    "Returns": "Returns\n-------\nOutcome\n    ``files``.",
    "Raises": "Raises\n------\nInputError\n    For what cannot be used; the message names what is allowed.",
}
"""Sections of docstrings that do not have them."""


def documented(function: F) -> F:
    """The function with its parameters in its docstring and, by their types alone, in its signature."""
    parameters = PARAMETERS[function] = list(_parameters(function))
    head, *sections = re.split(r"\n\n(?=Returns\n|Raises\n)", inspect.cleandoc(function.__doc__ or ""))
    told = USUAL | {section.partition("\n")[0]: section for section in sections}
    described = "\n".join(("Parameters\n----------", *map(_described, parameters)))
    function.__doc__ = "\n\n".join((head, described, told["Returns"], told["Raises"]))
    shown = [each.replace(annotation=_type_text(each)) for each in parameters]
    returned = inspect.signature(function).return_annotation
    function.__signature__ = inspect.Signature(shown, return_annotation=returned)  # type: ignore[attr-defined]
    return function


def _parameters(function: Callable[..., Any]) -> Iterator[inspect.Parameter]:
    """Parameters with what they are; those of a table of keyword arguments one by one."""
    for parameter in inspect.signature(function, eval_str=True).parameters.values():
        if parameter.kind is not inspect.Parameter.VAR_KEYWORD:
            yield parameter
            continue
        (table,) = get_args(parameter.annotation)
        for name, annotation in table.__annotations__.items():
            default = False if get_args(annotation)[0] is bool else None
            yield inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def _described(parameter: inspect.Parameter) -> str:
    """A parameter in a docstring."""
    about = get_args(parameter.annotation)[1]
    text, default = about.help if isinstance(about, Option) else about, parameter.default
    suffix = "" if default is inspect.Parameter.empty else ", optional"
    suffix = f", default {default!r}" if isinstance(default, str | float | bool) and default != "" else suffix
    return f"{parameter.name} : {_type_text(parameter)}{suffix}\n" + fill(
        text, 110, initial_indent="    ", subsequent_indent="    "
    )


def _type_text(parameter: inspect.Parameter) -> str:
    """The type of a parameter as it is written."""
    kind = get_args(parameter.annotation)[0]
    text = kind.__forward_arg__ if isinstance(kind, ForwardRef) else inspect.formatannotation(kind)
    return re.sub(r"\w+\.(?=\w)", "", text)
