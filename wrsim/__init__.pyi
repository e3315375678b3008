from wrsim.analysis import run as run
from wrsim.analysis.motion.run import stepper as stepper
from wrsim.analysis.poses.static import contact_map as contact_map
from wrsim.analysis.poses.static import solve_poses as solve_poses
from wrsim.contact.model import ContactModel as ContactModel
from wrsim.contact.models import contact_model as contact_model
from wrsim.contact.pose import Pose as Pose
from wrsim.contact.settings import ContactSettings as ContactSettings
from wrsim.contact.settings import Friction as Friction
from wrsim.errors import InputError as InputError
from wrsim.errors import SimulationError as SimulationError
from wrsim.errors import WrsimError as WrsimError
from wrsim.geometry.profile.models import load_profile as load_profile
from wrsim.geometry.profile.profile import Profile as Profile
from wrsim.geometry.track.segments import Arc as Arc
from wrsim.geometry.track.segments import Straight as Straight
from wrsim.geometry.track.segments import Transition as Transition
from wrsim.geometry.track.track import Track as Track
from wrsim.results import Result as Result
from wrsim.scenario.loading import Scenario as Scenario
from wrsim.scenario.loading import load as load
from wrsim.scenario.loading import load_text as load_text
from wrsim.vehicle.vehicle import Vehicle as Vehicle
from wrsim.vehicle.vehicle_files import load_vehicle as load_vehicle

__version__: str
