from wrsim.analysis import run as run
from wrsim.errors import InputError as InputError
from wrsim.errors import SimulationError as SimulationError
from wrsim.errors import WrsimError as WrsimError
from wrsim.results import Result as Result
from wrsim.scenario.loading import Scenario as Scenario
from wrsim.scenario.loading import load as load

__version__: str
