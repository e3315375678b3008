"""A scenario's vehicle as a co-simulation unit (`simulation.fmu`), with the scenario and its model files."""

from wrsim.analysis.motion.run import BENCH_STEP, stepper
from wrsim.contact.models import NORMAL_MODELS
from wrsim.scenario.build import build, name_among_models
from wrsim.scenario.loading import Scenario
from wrsim.simulation.fmu import pack_fmu


def export_fmu(scenario: Scenario, name: str, step: float = BENCH_STEP) -> tuple[bytes, list[str]]:
    """The unit as the bytes of its file, and the names of its inputs; step: of the integration [s].

    name: of the file, without its ending. Raises InputError and SimulationError as `stepper`, WrsimError without a
    C compiler.
    """
    bench, setup = stepper(scenario, step), build(scenario)
    text, resources = scenario.text, {}
    for file in setup.files:
        if file not in scenario.merged.files:
            resources[name_among_models(scenario, file)] = file.read_bytes()
        text = text.replace(f'"{file}"', f'"{name_among_models(scenario, file)}"')  # of files that are named absolutely
    resources["scenario.toml"] = text.encode()
    normal = NORMAL_MODELS[setup.contact.normal].kernel
    return pack_fmu(bench, normal, name, scenario.title, setup.plan.duration, resources), list(bench.inputs)
