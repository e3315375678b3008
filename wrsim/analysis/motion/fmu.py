"""A scenario's vehicle as a co-simulation unit (`simulation.fmu`), with the scenario and its model files."""

from collections.abc import Sequence
from typing import NamedTuple

from wrsim.analysis.motion.run import holding_stepper
from wrsim.contact.library.build import compiler_for
from wrsim.contact.models import NORMAL_MODELS
from wrsim.errors import WrsimError
from wrsim.scenario.build import build, name_among_models
from wrsim.scenario.loading import Scenario
from wrsim.simulation.fmu import FOLDERS, pack_fmu


class Unit(NamedTuple):
    """A unit: the bytes of its file, its step [s], names of its inputs, systems it runs on, why not on others, and its
    budget in words."""

    content: bytes
    step: float
    inputs: list[str]
    systems: list[str]
    missing: list[str]
    budget: str


def export_fmu(
    scenario: Scenario,
    name: str,
    step: float | None = None,
    systems: Sequence[str] = (),
    version: str = "3",
    budget: float | None = None,
) -> Unit:
    """A scenario's vehicle as a unit; step: of the integration [s], None: one that holds over the run.

    budget: as `stepper` takes it, None: any; name: of the file, without its ending; systems: that it shall
    run on, none for all that there is a compiler for;
    version: of FMI. Raises InputError and SimulationError as `stepper`, WrsimError without a C compiler.
    """
    missing = {}
    for system in systems or FOLDERS[version]:
        try:
            compiler_for(system)
        except WrsimError as problem:
            missing[system] = str(problem)
    chosen = [system for system in systems or FOLDERS[version] if system not in missing]
    if missing and (systems or not chosen):
        raise WrsimError(next(iter(missing.values())))
    bench, setup = holding_stepper(scenario, step, budget), build(scenario)
    text, resources = scenario.text, {}
    for file in setup.files:
        if file not in scenario.merged.files:
            resources[name_among_models(scenario, file)] = file.read_bytes()
        text = text.replace(f'"{file}"', f'"{name_among_models(scenario, file)}"')  # of files that are named absolutely
    resources["scenario.toml"] = text.encode()
    normal = NORMAL_MODELS[setup.contact.normal].kernel
    content = pack_fmu(bench, normal, name, scenario.title, setup.plan.duration, resources, chosen, version)
    return Unit(content, bench.step_size, list(bench.inputs), chosen, list(missing.values()), bench.budget_line)
