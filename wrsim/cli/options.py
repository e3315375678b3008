"""Commands from functions of the API: parameters become arguments and options, docstrings become help."""

import inspect
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from os.path import abspath
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, get_args, get_origin

import typer

import wrsim
from wrsim.api.options import BESIDE, PARAMETERS, Argument, Force, Option
from wrsim.api.outcome import Outcome, folder_beside, in_units
from wrsim.api.pages import look
from wrsim.cli.console import print_error, print_outcome, progress_of, show_times, silent
from wrsim.cli.errors import reporting_errors, writing_files
from wrsim.errors import InputError

Values = dict[str, Any]
QUIET = "No progress bar, no table."
SWITCHES = {
    "force": Force,
    "as_json": Annotated[bool, Option("Write one JSON object to stdout and nothing else.", flags="--json")],
    "quiet": Annotated[bool, Option(QUIET, flags="--quiet -q")],
    "verbose": Annotated[bool, Option("Print the steps of the work with their times.", flags="--verbose -v")],
}
ADDED = {
    name: inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=False, annotation=annotation)
    for name, annotation in SWITCHES.items()
}
"""Options that the functions do not have."""
LOOK = {parameter.name: parameter.replace(default=None) for parameter in PARAMETERS[look]}
"""Options of the pictures that a command draws, and of units."""
LAST = ("models", "pictures", "workers", "scheduler", "slurm", "tls", *ADDED, *LOOK)
"""Options that follow those of the function alone, in this order."""
PICTURES = (".png", ".svg", ".pdf")
ENDINGS = {
    "PNG|SVG|PDF": PICTURES, "HTML": (".html",), "HTML|PDF": (".html", ".pdf"), "FMU": (".fmu",),
    "PNG|SVG|PDF|IFC|XML": (*PICTURES, ".ifc", ".xml", ".landxml"),
}  # fmt: skip
"""Endings of the names of files to be written, by the word for the value of the option."""


def command(
    api: Callable[..., Outcome],
    complete: Callable[[Values], Values] = lambda values: {},
    show: Callable[[Outcome, Values], None] = print_outcome,
    *,
    draws: Sequence[str] = (),
    adds: Sequence[str] = ("force", "as_json", "units"),
    source: str = "",
    reads: str = "",
    further: Sequence[inspect.Parameter] = (),
) -> Callable[..., None]:
    """The command of a function of the API: it prints what the function gives and ends with its exit code.

    complete: gives further values, or refuses those that are given; draws: options of `wrsim.look`; adds, further:
    options that the function does not have; source, reads: parameters with the result that it reports on, of several
    the first one, and with files that it reads.
    """
    parameters = {each.name: each for each in PARAMETERS[api]}
    first = next(iter(parameters))
    long = [] if "bar" not in parameters else ["quiet", "verbose"]
    taken = [each for each in parameters.values() if isinstance(get_args(each.annotation)[1], Option)]
    taken += [ADDED[name] for name in (*adds, *long) if name not in parameters and name in ADDED]
    taken += [*further, *(LOOK[name] for name in LOOK if name in draws or name in adds)]
    names = {_name(each): each.name for each in taken}

    def run(**options: Any) -> None:
        values: Values = {names[name]: value for name, value in options.items() if value is not None}
        as_json, quiet = values.get("as_json", False), values.get("quiet", False)
        with ExitStack() as stack:
            stack.enter_context(reporting_errors(as_json))
            stack.enter_context(in_units(values.get("units")))
            if looks := {name: values[name] for name in draws if name in values}:
                stack.enter_context(wrsim.look(**looks))
            values |= complete(values)
            for each in taken:
                _place(each, values, values.get(first))
            if "force" in values:
                results = _paths(values.get(source))
                read = [path for name in reads.split() for path in _paths(values.get(name))]
                result = results[0] if results else None
                stack.enter_context(writing_files(as_json, values["force"], *results[1:], *read, of=result))
            muted = silent if quiet and "workers" not in parameters else print_error
            prints = {"warn": muted, **progress_of(quiet or as_json)}
            outcome = api(**{name: value for name, value in (prints | values).items() if name in parameters})
            for message in [] if as_json else outcome.numbers.get("warnings", ()):
                print_error(f"{values[first]}: warning: {message}")
            show(outcome, values)
            if outcome.code:
                raise typer.Exit(outcome.code)

    run.__doc__ = (api.__doc__ or "").partition("\n\nParameters\n")[0]
    signature = [_typed(each) for each in sorted(taken, key=_rank)]
    run.__signature__ = inspect.Signature(signature)  # type: ignore[attr-defined]
    run.__annotations__ = {each.name: each.annotation for each in signature}
    return run


def _name(parameter: inspect.Parameter) -> str:
    """The name of a parameter in the command: where to write is always output."""
    return "output" if "-o" in get_args(parameter.annotation)[1].flags.split() else parameter.name


def _rank(parameter: inspect.Parameter) -> tuple[bool, bool, int]:
    """Arguments, the place to write to, options in the order of the function, options of many commands."""
    is_option = not isinstance(get_args(parameter.annotation)[1], Argument)
    last = LAST.index(parameter.name) if parameter.name in LAST else -1
    return is_option, is_option and _name(parameter) != "output", last


def _typed(parameter: inspect.Parameter) -> inspect.Parameter:
    """A parameter of the command with what typer makes an option or an argument of."""
    kind, option = get_args(parameter.annotation)
    default = None if parameter.default == () else parameter.default
    text = option.help + (f" Default: {option.default}." if option.default else "")
    told: dict[str, Any] = {"help": text.replace("[", "\\["), "metavar": option.metavar}
    told |= {"min": option.least, "max": option.most}
    if isinstance(option, Argument):
        info = typer.Argument(**told)
    else:
        dashed = "--" + parameter.name.lower().replace("_", "-")
        flags = option.flags.split() or [f"{dashed}/--no-{dashed[2:]}" if default is True else dashed]
        info = typer.Option(*flags, callback=show_times if parameter.name == "verbose" else None, **told)
    if default is inspect.Parameter.empty and option.default:
        default = None
    kind = option.kind or _read(kind)
    kind = kind if default is not None or NoneType in get_args(kind) else kind | None
    keyword = inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter(_name(parameter), keyword, default=default, annotation=Annotated[kind, info])


def _read(kind: Any) -> Any:
    """The type that the command line reads for one of the API: paths and lists."""
    if get_origin(kind) is Sequence:
        return list[_read(get_args(kind)[0])]  # type: ignore[misc]
    if Path in get_args(kind):
        return Path | None if NoneType in get_args(kind) else Path
    return kind


def _paths(value: Any) -> list[Path]:
    return [] if value is None else list(map(Path, value)) if isinstance(value, list) else [Path(value)]


def _place(parameter: inspect.Parameter, values: Values, first: Any) -> None:
    """Where to write, of the name of the first argument unless it is given. Raises InputError for a wrong ending."""
    option = get_args(parameter.annotation)[1]
    if option.default and parameter.name not in values:
        beside = _paths(first)[0]
        stem = Path(abspath(beside)).stem
        is_beside = option.default == BESIDE
        values[parameter.name] = folder_beside(beside) if is_beside else Path(option.default.replace("<FILE>", stem))
    endings, path = ENDINGS.get(option.metavar or ""), values.get(parameter.name)
    if endings and path is not None and path.suffix.lower() not in endings:
        flag = "-o" if _name(parameter) == "output" else f"--{parameter.name}"
        raise InputError(f"{flag} {path}: must end in {' or '.join(endings)}")
