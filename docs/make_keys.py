"""Pages and schemas made from the code. Run: python docs/make_keys.py

The pages, docs/reference/keys.md, commands.md, channels.md, status.md, spectra.md and docs/user/scenarios.md, are
written whenever the site is built. The schemas, docs/schema/*.json, are committed: editors read them.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any, get_args

from typer.main import get_command

from wrsim.analysis.motion.derailment import DROP
from wrsim.analysis.motion.messages import EventKind
from wrsim.analysis.motion.monitor import INTERVAL, LIFT_DISTANCE, LIFT_TIME, STRETCH
from wrsim.analysis.stability.cycles import Ending
from wrsim.cli import application
from wrsim.contact.records import STATUS_TOO_DEEP
from wrsim.contact.status import WORDS
from wrsim.inputs.file_kinds import FILES
from wrsim.inputs.reference import entries, heading, purpose
from wrsim.inputs.section import Section
from wrsim.results import CHANNELS
from wrsim.scenario.reference import schema_text, tables_of_file
from wrsim.simulation.recorder import Cause
from wrsim.study.task import STATUSES
from wrsim.track.irregularities import CHANNELS as TRACK_CHANNELS
from wrsim.track.spectra import SPECTRA

HERE = Path(__file__).parent
REFERENCE = HERE / "reference"
HEAD = """# Keys
Every key of every file. This page is made from the code.

`wrsim keys contact` prints the keys of a table, `wrsim new curving` writes a scenario to start from.

"needed": the key has no default; "none": left out, something else decides, as the row says.

## In an editor
An editor offers the keys of a table and their allowed words while you type, shows what a key is, and underlines what
is wrong. It does so by the schemas in `docs/schema`. In VS Code install the extension "Even Better TOML"; other editors
use its language server, [Taplo](https://taplo.tamasfe.dev). On the command line `taplo lint scenarios/*.toml` checks
likewise (`pip install taplo`). In the folder of wrsim all this works at once, by the file `.taplo.toml`. Elsewhere
write the schema beside your files and begin each scenario with a line that names it:

```sh
wrsim keys --schema > scenario.schema.json
```

```text
#:schema ./scenario.schema.json
```

`wrsim keys --file vehicle --schema` gives that of vehicle files; there are also `wheelset`, `train`, `track`,
`profile` (wheels and rails), `columns` (of a recording), `study` and `evolution`. Keys that go together, such as one
radius or two, are beyond a schema: `wrsim check FILE` reports them.
"""


COMMANDS = """# Commands
Every command with its arguments and options, made from the command line. `wrsim --help` and `wrsim COMMAND --help`
print the same. Results (`RESULT`) are a result file, the folder of a run, or a run that was cut off.

Options of many commands:

| option | meaning | default |
|---|---|---|
{shared}

Exit codes: 0 completed; 1 a file cannot be read or written; 2 an input or the command line is not valid; 3 a run
stopped before its end, or a case of a study has no result; 4 two results differ (`wrsim diff`); 70 an error of wrsim
itself; 130 interrupted.
"""
CHANNELS_HEAD = """# Channels of a result
Every channel by its name, made from the register. A result is one labelled dataset (xarray, in `result.nc`) in SI
units with the channels that its analysis computes; every variable has `units` and `long_name`. Tables and pictures
show the unit in brackets. "Also called" has terms of the field and the names in CONTACT.

| dimension | labels | meaning |
|---|---|---|
| sample | `time` [s] in runs, `pose` (names) in static analyses | a dataset has one of the two |
| fast_time | [s] | samples of `fast_channels`: `fast_Q` is `Q` there, `fast_distance` the place |
| moment | `snapshot` (0, 1, ...) in runs, `pose` in static analyses | where strips are stored |
| wheelset | names, as "front.outer"; "wheelset" where it runs alone | the front one first |
| wheel | "left", "right" | one of them alone where only one wheel is computed |
| patch | 0, 1, 2 | contact patches of a wheel, largest normal force first |
| strip, column | none | strips of a patch by increasing s, elements by increasing x; unused places are not-a-number |
| axis | none | t, o, b of the wheel's own rail; on the right side mirrored, angular velocities too |
| amplitude | [m] | of the swing, in conicity analyses |
| mode, cycle | none | oscillating modes by their frequencies; held speeds of the search for limit cycles |
| body, point, suspension, coupling, external_load | names | of the vehicle file |
| event | none | what happens in the run |
| wheel_place, rail_place | none | bins of equal arclength on the profiles of wheels and rails |
| rail_point, wheel_point | none | points of the outlines |

Values are not-a-number where there is no contact, no such patch, no solution; counts are integers, 0 there. Axes and
signs: [conventions](conventions.md). CONTACT, SIMPACK and GENSYS have y to the right and z down: a lateral or
vertical channel has the opposite sign there, unless it counts outward or down. `Result.wheelset(name)` gives the
channels of one wheelset without the dimension `wheelset`, with its own distance as `distance`.

Attributes of the dataset: `format`, `format_version`, `title`, `analysis`, `status` ("completed" or "stopped"),
`resolved_with` and `resolved_at_same` (snapshots solved again by another contact model), `stop_reason` (a sentence),
`stop_cause` (one word), `stop_time_s`, `stop_distance_m`; of a run `integrator`, `step_s`, `steps`, `evaluations` (of
the forces), `jacobians`, `cut_steps`, `explicit_steps`, `refined_steps`; `scenario_text`, `inputs` (JSON: SHA-256 of
every file that is read, by its name), and the versions of wrsim, Python and the numerical libraries.
"""
STATUS = """# Status words and messages
Every status word, made from the code.

## Status of a run
`status` is "completed" or "stopped", and `stop_cause` is the cause:

{causes}
`stop_reason` is a sentence with time and place. The result contains everything up to that instant, and the strips of
the last sample as the snapshot "at the stop".

## Derailment
The state is checked every {interval} ms or every {stretch} m, whichever is shorter. The rules use positions and not
forces. Each of them ends the run.

| message | rule |
|---|---|
| the flange has climbed over its rail | the lowest point of the flange is outside of the gauge point |
| the wheel has dropped | the tape circle is more than {drop} mm below the top of its rail |
| the wheel has had no contact | no contact for {way} m and for {time} ms |
| {deep} | no contact solution |

The lowest point is that of the section below the axle; the gauge point lies 14 mm below the top of the rail. An S1002
wheel whose flange has climbed is lifted by 20 to 27 mm.

Unloading for some milliseconds or a large Y/Q is no derailment: [assess](../user/assessment.md) the result.

## Events of a run
`event_label` is a sentence with the wheel or the element, the place and the duration. The kinds:

{events}
## Status of a case of a study
{cases}
## Messages of a contact
Runs and states of rest report a message as an event, static poses in `contact_remark` or `pose_message`, steady
motions, stability analyses and `wrsim resolve` in `contact_remark`. Limit cycles have a `cycle_remark`. Summary,
terminal, tables, `wrsim compare`, `wrsim assess` and the viewer show these messages. An overlap ends a run. The status
of the C library is the sum of the bits.

{contacts}
## Limit cycles
`cycle_ending` of a [stability analysis](../user/stability.md):

{cycles}
## Marks of sources
| mark | meaning |
|---|---|
| [read] | read in the text of the law or standard itself |
| [pub] | from a published source that was read |
| [mem] | from memory of a standard or of the literature: check it against the text |
| [derived] | follows from other numbers as the comment says |
| [assumed] | a choice of this project |
"""
SPECTRA_HEAD = """# Spectra of track irregularities
Every spectrum by name, made from the code. Densities are **one-sided over the wave number Ω = 2π/λ**, in m²/(rad/m).
Equations: [track](../theory/track.md). Keys: [`[[track.irregularities]]`](../user/track.md).

The table has the rms in mm of each channel over waves of 3 to 25 m, then over waves of 3 to 100 m: the root of the
integral of the density over the band. A drawn line has this rms over its period. The period is 16 of the longest waves,
or the length of the track if that is longer. A short track has few long waves and another rms. `wrsim check` and each
run print convention, band, rms and missing channels in one line.

| name | also understood as | waves of the fit | {channels} |
|---|---|---|{bars}|
{rows}
A dash: the source has no such channel, and none is drawn. A cell marked [mem] has a figure from memory.

## Sources and conventions
All densities are one-sided in their sources.

| name | source | convention there |
|---|---|---|
| ERRI | ERRI B 176, RP 1, 1989, as others quote it [pub] | rad/m; cross-level: angle over 1.5 m |
| German | the same, with a gauge as Chinese authors have it: A_g = 5.32e-8, 1.032e-7 m² rad/m [pub] | rad/m |
| FRA, level | Lei and Noda 2002, as others quote it [pub] | rad/m, A in cm² rad/m |
| FRA, alignment | classes 1, 2, 5, 6 [pub], 3 and 4 [mem] | rad/m, A in cm² rad/m |
| FRA, cross-level and gauge | A of the level; Ωs [mem] | rad/m |
| SNCF | Berawi, doctoral thesis, Porto, as quoted in TTB-2D (Cantero, SoftwareX 20, 2022) [pub] | 1/m, A in m³ |
| China-HSR | ballastless track, TB/T 3352-2014; three public programs agree [pub] | 1/m, mm²/(1/m) |
| China-main-line | older fit of the upgraded main lines, read in one public program [pub] | 1/m, mm²/(1/m) |

- **SNCF**: other authors may take the same A over rad/m; amplitudes are then 2.5 times as large.
- **China-main-line**: left and right rail have densities in the source; their mean is taken. Its waves were not read.
- **FRA**: authors disagree. The level of another fit (Frýba 1996, quoted in TTB-2D) has 1.6 mm for class 6 and 2.7 mm
  for class 4 over waves of 3 to 100 m.
- The gauge of low classes alone may press a wheel into its flange. Choose `channels`, or widen the gauge.
"""
CAUSES = {
    "": "the run reached the end of the track, `distance_m` or `time_s`; exit code 0",
    "monitor": "derailment, or contact solution lost; exit code 3",
    "not-finite": "a force or a coordinate is not a number; exit code 3",
    "forces": "a wheelset has no place near the track; exit code 3",
    "interrupt": "Ctrl-C; exit code 130",
    "cut-off": "the process was ended; the result is read from its `.part` file",
}
EVENTS = {
    "lift": "a wheel loses contact",
    "stop": "a bump stop beyond the end of its table; the stroke of a buffer or a draw gear used up",
    "contact": "a message of a contact, see below",
    "steps": "the time step is cut again and again",
    "between": "a vertical force peaks between output samples, beyond both by more than 5 % of the mean wheel load",
    "strike": "a wheel-rail impact faster than the time step resolves",
    "spins": "a wheelset driven beyond adhesion",
    "slides": "a wheelset braked beyond adhesion",
    "swings": "a wheelset that excites itself on its contacts",
    "loose": "a friction element without a normal force",
}
CASES = {
    "completed": "the run came to its end",
    "derailed": "it derailed or overturned; its numbers cover the way up to there",
    "stopped": "the integration could not continue; the message gives the reason",
    "out of time": "it took longer than `time_limit_s`; with a larger limit it continues",
    "failed": "it could not start, or its process ended; the message gives the reason",
}
CYCLES = {
    "cycle": "a limit cycle: amplitude and frequency are constant",
    "rest": "the motion decays",
    "not converged": "neither within the time allowed",
    "derailed": "a wheel left its rail",
}
SCENARIOS = """# Scenarios that come with wrsim

Files in the folder `scenarios` with their titles. Comments in each file explain its keys; `base = "other.toml"`
starts a scenario from another one. `wrsim run` takes scenarios, `wrsim study` the studies and `wrsim wear` the
profile evolutions.

| file | title |
|---|---|
"""
SHARED = {"as_json", "quiet", "force", "models", "pictures"}
"""Options that the head of the page of commands has."""


def markdown(section: type[Section], level: str = "###") -> list[str]:
    """Heading, purpose and keys of one table."""
    lines = [f"{level} {heading(section)}", "", *purpose(section), ""]
    rows = entries(section)
    if rows:
        heads = ("key", "what it is", "default", "also understood as")
        lines += [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
        for e in rows:
            example = f" *Example:* {_code(e.example)}" if e.example and e.example != e.default else ""
            cells = [
                f"`{e.key}`" + (f" [{e.unit}]" if e.unit else "") + "".join(f", `{key}`" for key in e.us),
                f"{e.meaning} *Must be* {e.allowed}.{example}",
                _code(e.default),
                ", ".join(map(_code, e.aliases)),
            ]
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines.append("")
    return lines


def _code(text: str) -> str:
    if text in ("needed", "none", ""):
        return text
    return f"`{text}`"


def commands() -> str:
    """The page of commands: what each does, its arguments and its options; options of many commands once."""
    members = get_command(application()).commands  # type: ignore[attr-defined]
    shared = {p.name: _option(p) for command in members.values() for p in command.params if p.name in SHARED}
    lines = [COMMANDS.format(shared="\n".join(shared.values()))]
    for name, command in members.items():
        arguments = [_plain(p.metavar or p.name) for p in command.params if p.param_type_name == "argument"]
        lines += [f"## {name}", "", f"`{' '.join(['wrsim', name, *arguments])}`", "", _plain(command.help), ""]
        rows = [_option(p) for p in command.params if p.name not in SHARED]
        if rows:
            lines += ["| argument, option | meaning | default |", "|---|---|---|", *rows, ""]
    return "\n".join(lines).rstrip() + "\n"


def _option(parameter: Any) -> str:
    """Row of one argument or option."""
    name = parameter.metavar or parameter.name
    if parameter.param_type_name == "option":
        name = ", ".join([*parameter.opts, *parameter.secondary_opts]) + (f" {parameter.metavar or ''}")
    default = parameter.default
    shown = "" if default is None or callable(default) or isinstance(default, bool) else f"`{default}`"
    return f"| `{_plain(name)}` | {_plain(parameter.help)} | {shown} |"


def channels() -> str:
    """The page of channels, in the sections that the register has as lines with #."""
    lines = [CHANNELS_HEAD]
    register = files("wrsim.results").joinpath("data/channels.csv").read_text(encoding="utf-8").splitlines()
    for line in register[2:]:
        if line.startswith("#"):
            heads = ("channel", "dimensions", "unit", "meaning", "also called")
            lines += ["", f"#{line}", f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
            continue
        c = CHANNELS[line.partition(",")[0]]
        unit = c.unit if c.shown.symbol in (c.unit, "m/s²") else f"{c.unit} [{c.shown.symbol}]"
        meaning = f"{c.long_name}: {c.note}" if c.note else c.long_name
        lines.append(f"| `{c.name}` | {', '.join(c.dims)} | {unit} | {_plain(meaning)} | {_plain(c.terms)} |")
    return re.sub("\n{3,}", "\n\n", "\n".join(lines)) + "\n"


def status() -> str:
    """The page of status words: the words are those of the code, each has its meaning here."""
    bits = {str(bit): WORDS[bit] for bit in sorted(WORDS)}
    return STATUS.format(
        causes=_meanings("`stop_cause`", get_args(Cause), CAUSES),
        events=_meanings("kind", get_args(EventKind), EVENTS),
        cases=_meanings("status", STATUSES, CASES),
        contacts=_meanings("bit", bits, bits, "message"),
        cycles=_meanings("word", get_args(Ending), CYCLES),
        deep=WORDS[STATUS_TOO_DEEP],
        interval=f"{1e3 * INTERVAL:g}",
        stretch=STRETCH,
        drop=f"{1e3 * DROP:g}",
        way=f"{LIFT_DISTANCE:g}",
        time=f"{1e3 * LIFT_TIME:g}",
    )


def spectra() -> str:
    """The page of spectra: names, terms, and the rms of their channels."""
    rows = ""
    for name, spectrum in SPECTRA.items():
        fit = f"{spectrum.waves[0]:g} to {spectrum.waves[1]:g} m" if spectrum.waves else ""
        cells = [f"`{name}`", ", ".join(spectrum.terms), fit]
        for channel in TRACK_CHANNELS:
            sizes = [
                f"{1e3 * spectrum.rms(channel, (3.0, far)):.2f}"
                for far in (25.0, 100.0)
                if channel in spectrum.densities
            ]
            cells.append(", ".join(sizes) + " [mem]" * (channel in spectrum.recalled) if sizes else "-")
        rows += f"| {' | '.join(cells)} |\n"
    return SPECTRA_HEAD.format(
        channels=" | ".join(TRACK_CHANNELS), bars="---|" * (len(TRACK_CHANNELS) - 1) + "---", rows=rows
    )


def _meanings(head: str, codes: Iterable[str], meanings: Mapping[str, str], of: str = "meaning") -> str:
    """Table of words of the code. Raises ValueError where a word has no meaning, or a meaning no word."""
    if wrong := set(codes) ^ set(meanings):
        raise ValueError(f"{head}: {sorted(wrong)} are words of the code or of this page alone")
    rows = (f"| {f'`{word}`' if word else 'empty'} | {meanings[word]} |\n" for word in codes)
    return f"| {head} | {of} |\n|---|---|\n{''.join(rows)}"


def scenarios() -> str:
    """The page of shipped scenarios, studies and services."""
    folder = HERE.parent / "scenarios"
    files = sorted(folder.rglob("*.toml"), key=lambda path: (path.parent != folder, path))
    titled = [(path, tomllib.loads(path.read_text(encoding="utf-8")).get("title")) for path in files]
    return SCENARIOS + "".join(f"| `{p.relative_to(folder)}` | {title} |\n" for p, title in titled if title)


def _plain(text: str | None) -> str:
    """Help without line breaks and without the escapes of the terminal; bars are those of a table."""
    return re.sub(r"\s+", " ", (text or "").replace("\\[", "[")).strip().replace("|", "\\|").replace("<", "\\<")


def keys() -> str:
    """The page of keys: the tables of every kind of file, each where it comes first."""
    lines = [HEAD]
    shown: set[type] = set()
    for name, (title, *_) in FILES.items():
        lines += [f"## {title[0].upper()}{title[1:]}", ""]
        for table in tables_of_file(name):
            if table not in shown:
                table_lines = markdown(table)
                lines += table_lines[2:] if table.header == title else table_lines  # the file itself has its heading
            shown.add(table)
    return "\n".join(lines).rstrip() + "\n"


PAGES = {
    REFERENCE / "keys.md": keys,
    REFERENCE / "commands.md": commands,
    REFERENCE / "channels.md": channels,
    REFERENCE / "status.md": status,
    REFERENCE / "spectra.md": spectra,
    HERE / "user" / "scenarios.md": scenarios,
}
"""What makes the text of each page, by its path."""


def pages() -> dict[Path, str]:
    """Text of every page, by its path."""
    return {path: make() for path, make in PAGES.items()}


def schemas() -> dict[Path, str]:
    """Text of the schema of every kind of file, by its path."""
    return {HERE / "schema" / f"{name}.schema.json": schema_text(name) + "\n" for name in FILES}


def write(texts: dict[Path, str]) -> None:
    """Write what has changed: an unchanged page is not built again."""
    for path, text in texts.items():
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write(pages() | schemas())
