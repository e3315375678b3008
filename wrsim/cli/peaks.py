"""What the user reads of runs and poses: peaks in words, medians in full curves, what the integration took."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wrsim.cli.showing import print_some, print_table, say

if TYPE_CHECKING:
    from wrsim.results import Result

WIDTH = 100
"""Letters that the tables of a vehicle need."""

OF_WHEELS = {
    "Y_max_kN": "Y max kN",
    "Y_min_kN": "Y min kN",
    "Q_max_kN": "Q max kN",
    "Q_min_kN": "Q min kN",
    "Y_over_Q_max": "Y/Q max",
    "T_gamma_max_N": "Tγ max N",
    "p0_max_MPa": "p₀ max MPa",
}
"""Peaks in the table of several wheelsets, and their headings."""

MEDIANS = ("lateral_shift", "yaw", "sum_Y", "Y", "Q", "Y_over_Q", "contact_angle", "p0", "T_gamma")
"""Channels in the tables of full curves."""
HEADS = ("shift mm", "attack mrad", "ΣY kN", "Y kN", "Q kN", "Y/Q", "angle °", "p₀ MPa", "Tγ N")

MOST_CURVES = 3
"""Full curves that are printed; all of them stand in summary.json."""


def print_peaks(result: Result) -> None:
    """The peaks of each wheel and wheelset, medians in full curves, events; of a run, what its integration took."""
    summary = result.summary()
    if len(summary["wheelsets"]) > 1:
        _print_wheelsets(result.title, summary)
    else:
        _print_wheelset(result.title, *summary["wheelsets"].values())
    _print_curves(summary)
    if "energy" in summary:
        _print_energy(summary["energy"])
    print_some([f"{event['distance_m']:.1f} m: {event['event']}" for event in summary.get("events", [])], "events")
    if "integration" in summary:
        _print_integration(**summary["integration"])


def _print_wheelset(title: str, own: dict[str, Any]) -> None:
    """Every peak of a wheelset with its place, one a line."""
    from wrsim.results.summary import OF_WHEELSET, PEAKS

    heads = ["", *(head for wheel in own["wheels"] for head in (wheel, "at"))]
    rows = []
    for name, (words, unit) in PEAKS.items():
        cells = [cell for peaks in own["wheels"].values() for cell in _peak(peaks.get(name))]
        rows.append([f"{words} [{unit}]" if unit else words, *cells])
    print_table(heads, (r for r in rows if set(r[1::2]) != {"-"}), title=title, left=("", "at"))
    for name, (words, unit) in OF_WHEELSET.items():
        found = own.get(name)
        if found is not None and found["value"]:
            value, place = _peak(found)
            say(f"{words}, largest either way: {value} {unit} at {place}")


def _print_wheelsets(title: str, summary: dict[str, Any]) -> None:
    """The peaks of every wheel of several wheelsets, a line each, and those of the wheelsets."""
    from wrsim.results.summary import OF_WHEELSET
    from wrsim.results.wheelsets import numbered

    labels = numbered(tuple(summary["wheelsets"]))
    wheelsets = [(labels[name], own) for name, own in summary["wheelsets"].items()]
    rows = [
        [name if j == 0 else "", wheel, *(_peak(peaks.get(key))[0] for key in OF_WHEELS)]
        for name, own in wheelsets
        for j, (wheel, peaks) in enumerate(own["wheels"].items())
    ]
    left = ("wheelset", "wheel")
    print_table([*left, *OF_WHEELS.values()], rows, title=title, left=left, width=WIDTH)
    known = {
        key: words
        for key, words in OF_WHEELSET.items()
        if any((own.get(key) or {}).get("value") for _, own in wheelsets)
    }
    rows = [[name, *(" at ".join(filter(None, _peak(own.get(key)))) for key in known)] for name, own in wheelsets]
    if known:
        heads = [
            "wheelset",
            *(f"{words.removeprefix('track shifting force ')} {unit}" for words, unit in known.values()),
        ]
        say()
        print_table(heads, rows, title="largest either way", left=heads[:1], width=WIDTH)


def _print_curves(summary: dict[str, Any]) -> None:
    """Quasi-static values of every wheel in the first full curves."""
    from wrsim.results import CHANNELS
    from wrsim.results.wheelsets import numbered

    labels = numbered(tuple(summary["wheelsets"]))
    several = len(labels) > 1
    curves = [own.get("full_curves", []) for own in summary["wheelsets"].values()]
    least = min(map(len, curves), default=0)
    for k in range(min(least, MOST_CURVES)):
        first, rows = curves[0][k], []
        for name, own in summary["wheelsets"].items():
            curve = own["full_curves"][k]
            for j, wheel in enumerate(own["wheels"]):
                values = curve | curve.get(wheel, {}) if j == 0 else curve.get(wheel, {})
                cells = ["" if (v := values.get(CHANNELS[key].column)) is None else f"{v:z.4g}" for key in MEDIANS]
                rows.append([*([labels[name] if j == 0 else ""] if several else []), wheel, *cells])
        hand = "left" if first["radius_m"] > 0.0 else "right"
        place = f"{first['from_m']:z.0f} to {first['to_m']:.0f} m"
        title = f"full curve, R {abs(first['radius_m']):.0f} m to the {hand}, {place}: medians of its second half"
        left = ("wheelset", "wheel") if several else ("wheel",)
        say()
        print_table([*left, *HEADS], rows, title=title, left=left, width=WIDTH)
    if least > MOST_CURVES:
        say(f"and {least - MOST_CURVES} more full curves: see summary.json")


def _print_energy(energy: dict[str, float]) -> None:
    """What became of the work of drive and pull; what nothing was put in or taken out of is left out."""
    from wrsim.results.summary import ENERGY

    rows = [[words, f"{energy[key]:z.4g}"] for key, words in ENERGY.items() if energy[key] or key == "left_over_kJ"]
    say()
    print_table(("", "kJ"), rows, title="balance of energy over the run", left=("",))


def _print_integration(
    integrator: str,
    step_ms: float,
    steps: int,
    evaluations: int,
    jacobians: int,
    cut_steps: int,
    explicit_steps: int,
) -> None:
    """What the integration of a run took."""
    words = f"{integrator}: {steps} steps of {step_ms:.4g} ms, {evaluations} evaluations of the forces"
    words += f", {jacobians} Jacobians" if jacobians else ""
    cut = f"; {cut_steps} steps that Newton's method did not solve cut into parts, {explicit_steps} of them for rk44"
    say(words + (cut if cut_steps else ""))


def print_wall_time(wall: float, run: float, compiling: float) -> None:
    """How long a run took, without compiling, beside how long it lasts on the track [s]."""
    ratio = run / wall
    words = f"{ratio:.3g} times faster" if ratio >= 1.0 else f"{1.0 / ratio:.3g} times slower"
    besides = f"; compiling kernels, once, took {compiling:.3g} s besides" if compiling >= 0.1 else ""
    say(f"{run:.4g} s on the track in {wall:.3g} s of wall time: {words} than real time{besides}")


def _peak(peak: dict[str, Any] | None) -> tuple[str, str]:
    """Value and place in words."""
    if peak is None or peak["value"] is None:
        return "-", ""
    place = peak.get("pose")
    if place is None:
        place = f"{peak['distance_m']:z.1f} m" if "distance_m" in peak else f"{peak['time_s']:z.3f} s"
    return f"{peak['value']:z.4g}", str(place)
