"""The names of the package itself: they are documented, quick to import, and do what the page says."""

import ast
import re
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from inspect import cleandoc
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from support.synthetic_result import curve_run, static_poses

import wrsim
import wrsim.contact
from wrsim import ContactSettings, InputError, Pose, Result, contact_model, load_profile, solve_poses

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "user" / "python.md"
SHIFTS = (0.0, 3.0, 6.0)
FIRST = 13.06532663
"""Place of the first kept patches [m]."""


@pytest.fixture(scope="module", params=["kik-piotrowski", "strips"])
def study(request: pytest.FixtureRequest) -> Result:
    """A right wheel at three shifts."""
    rail = load_profile("rails/60E1.toml").inclined(1 / 40)
    model = contact_model(load_profile("wheels/S1002.toml"), rail, 0.46, ContactSettings(normal=request.param))
    return solve_poses(model, [Pose(lateral=1e-3 * y, yaw=2e-3, load=60e3) for y in SHIFTS], side="right")


@pytest.fixture(scope="module")
def curve() -> Result:
    """A run that nobody ran."""
    return Result(curve_run())


def test_the_page_and_type_checkers_have_exactly_the_public_names() -> None:
    rows = [line.split("|")[1] for line in PAGE.read_text().splitlines() if line.startswith("| `")]
    listed = {name for row in rows for name in re.findall(r"`(\w+)`", row)}
    assert listed == set(wrsim.__all__) - {"__version__"}
    assert (ROOT / "wrsim" / "py.typed").exists()


@pytest.mark.parametrize("package", [wrsim, wrsim.contact])
def test_stubs_and_packages_have_the_same_names(package: ModuleType) -> None:
    stub = ast.parse(Path(str(package.__file__)).with_suffix(".pyi").read_text())
    told = {n.asname: (i.module, n.name) for i in stub.body if isinstance(i, ast.ImportFrom) for n in i.names}
    assert told == {name: (home, name) for name, home in package._HOMES.items()}
    assert all(getattr(package, name) is not None for name in package.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'none'"):
        package.none  # noqa: B018


@pytest.mark.parametrize("name", [name for name in wrsim.__all__ if name != "__version__"])
def test_every_public_name_says_what_it_is(name: str) -> None:
    thing = getattr(import_module(wrsim._HOMES[name]), name)
    assert thing.__doc__, name
    if not isinstance(thing, type) and callable(thing):
        assert all(f"{part}\n----" in cleandoc(thing.__doc__) for part in ("Parameters", "Returns", "Raises")), name


def test_the_package_and_its_commands_import_nothing_heavy() -> None:
    heavy = "numpy pydantic numba matplotlib xarray exudyn scipy rich.progress"  # so --help is quick
    code = f"import sys, wrsim.cli\nprint(sorted(set({heavy.split()}) & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.strip() == "[]"


def test_a_run_imports_no_library_for_what_it_does_not_do(tmp_path: Path) -> None:
    unused = [f"scipy.{name}" for name in ("ndimage", "optimize", "signal", "sparse", "special", "stats")] + [
        "dask.array"
    ]
    code = f"import atexit, sys, wrsim.cli\nprints = lambda: print(sorted(set({unused}) & set(sys.modules)))\n"
    program = [sys.executable, "-c", f"{code}atexit.register(prints)\nwrsim.cli.main()"]
    arguments = ["run", "scenarios/curve_r300.toml", "--set", "run.distance_m=1", "-q", "-o", str(tmp_path / "run")]
    done = subprocess.run([*program, *arguments], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.strip() == "[]"
    assert len(list((tmp_path / "run").glob("*.png"))) == 5


def test_without_the_extra_of_studies_a_wrong_value_is_told_not_the_extra(tmp_path: Path) -> None:
    absent = "import sys; sys.modules |= dict.fromkeys(('cryptography', 'dask', 'pyarrow'))"
    program = f"{absent}; from wrsim.cli import application; application()()"
    wrong = ["run", "scenarios/curve_r300.toml", "--set", "run.distance_m=-5", "-o", str(tmp_path / "x")]
    study = ["study", "scenarios/studies/friction_speed.toml", "-o", str(tmp_path / "y")]
    optimisation = ["run", "scenarios/optimisation/yaw_stiffness.toml", "-o", str(tmp_path / "z")]
    kind = "is an optimisation (wrsim optimise)"
    for arguments, told in (
        (wrong, "run.distance_m = -5: must be"),
        (study, "pip install 'wrsim[study]'"),
        (optimisation, kind),
    ):
        done = subprocess.run(
            [sys.executable, "-c", program, *arguments], cwd=ROOT, capture_output=True, text=True, check=False
        )
        assert done.returncode == 2
        assert told in done.stderr and done.stderr.count("\n") == 1


def test_a_wheel_carries_its_load_and_its_patch_adds_up_to_its_normal_force(study: Result) -> None:
    np.testing.assert_allclose(study.dataset["Q"].values.ravel(), 60e3, rtol=1e-6)
    for shift in SHIFTS:
        load_errors = []
        for columns in (51, 101, 201):
            patch = study.patch(f"y{shift:+g}", columns=columns)
            dx = float(patch.x[1] - patch.x[0])
            load_errors.append(abs(float((patch.p.sum("x") * dx * patch.strip_ds).sum()) / float(patch.N) - 1.0))
        # the trapezoidal rule on a semi-ellipse converges with the power 1.5 of the columns' distance; its ends lie
        # anywhere between two columns
        assert load_errors[0] < 2e-3, "of the normal force, 51 columns"
        assert load_errors[2] < 0.5 * load_errors[0] < 1e-3


def test_poses_in_python_are_those_of_a_scenario(study: Result, request: pytest.FixtureRequest) -> None:
    scenario = wrsim.load(ROOT / "scenarios/static_s1002.toml").with_values(
        {"static.side": "right", "static.lateral_mm": list(SHIFTS), "static.yaw_mrad": 2, "static.load_kN": 60}
    )
    normal = request.node.callspec.params["study"]
    track = {"track.gauge_mm": 1435, "track.inclination": "1:40"}
    same = wrsim.run(scenario.with_values(track | {"vehicle.radius_mm": 460, "contact": {"normal": normal}}))
    assert list(same.dataset["pose"].values) == list(study.dataset["pose"].values) == ["y+0", "y+3", "y+6"]
    for name in ("N", "p0", "contact_angle", "Fy", "strip_p"):
        np.testing.assert_allclose(study.dataset[name], same.dataset[name], rtol=1e-9, err_msg=name)


def test_patches_of_the_exact_solver_have_their_elements() -> None:
    dataset = static_poses((0.0,), (0.0,), ("left",), 24e3)
    strips = dataset["strip_p"]
    dims = (*strips.dims, "column")
    shape = (*strips.shape, 4)
    x = np.full((*strips.shape[:-1], 4), np.nan)
    x[..., :3] = [-1e-3, 0.0, 1e-3]
    numbers = {"p": 7.0, "qx": 8.0, "qs": 9.0}
    fields = {f"element_{name}": (dims, np.full(shape, value)) for name, value in numbers.items()}
    patch = Result(dataset.assign(fields | {"element_x": ((*strips.dims[:-1], "column"), x)})).patch(
        str(dataset["pose"].values[0])
    )
    assert patch.p.dims == ("s", "x") and patch.sizes["x"] == 3
    assert (patch.p == 7.0).all() and (patch.qx == 8.0).all() and (patch.qs == 9.0).all()


def test_a_patch_of_a_run_is_the_one_of_the_nearest_kept_moment(curve: Result) -> None:
    patch = curve.patch(FIRST + 0.4, "right")
    assert patch.attrs["distance_m"] == pytest.approx(FIRST, abs=1e-6)
    assert patch.p.attrs["units"] == "Pa" and patch.s.attrs["units"] == "m"
    assert np.all(np.diff(patch.s) > 0.0)
    sample = int(np.argmin(np.abs(curve.dataset["time"].values - curve.dataset["snapshot_time"].values[0])))
    assert float(patch.p0) == float(curve.wheelset()["p0"].sel(wheel="right")[sample, 0])


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (lambda r: r.patch(1e6, "left"), r"at 1000000\.0: no patches are stored within 1 m .*there are \d"),
        (lambda r: r.patch(60.0), "choose a wheel: left, right"),
        (lambda r: r.patch(60.0, "rigth"), r"wheel = 'rigth': .*did you mean 'right'.*: left, right"),
        (lambda r: r.patch("here", "left"), "must be a distance in m"),
        (lambda r: r.patch(FIRST, "left", number=9), "number = 9: the left wheel has"),
        (lambda r: r.wheelset("front"), "no wheelset is called 'front'.*there are wheelset"),
        (lambda r: r.plot("Yq"), "neither a picture nor a channel.*: is none of .* names; the nearest are .*Y"),
        (lambda r: r.to_dataframe("front"), "no wheelset is called 'front'"),
        (lambda r: load_profile("rails/60E11.toml"), r'not found in .*did you mean "rails/60E1.toml"'),
        (lambda r: wrsim.load_vehicle("vehicles/manchester.toml"), 'did you mean "vehicles/manchester_1.toml"'),
    ],
)
def test_what_is_not_there_is_told_in_one_line_with_what_there_is(asked, told: str, curve: Result) -> None:
    with pytest.raises(InputError, match=told) as refused:
        asked(curve)
    assert "\n" not in str(refused.value)


def test_poses_that_cannot_be_are_refused() -> None:
    wheel, rail = load_profile("wheels/S1002.toml"), load_profile("rails/60E1.toml")
    with pytest.raises(InputError, match="'60E1' is a rail; a wheel is needed"):
        contact_model(rail, rail, 0.46)
    with pytest.raises(InputError, match=r"normal = 'strip': must be one of .*did you mean 'strips'"):
        contact_model(wheel, rail, 0.46, ContactSettings(normal="strip"))  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"polach_slip = 1\.5: must be a number from .* to 1$"):
        contact_model(wheel, rail, 0.46, ContactSettings(polach_slip=1.5))
    model = contact_model(wheel, rail, 0.46)
    for poses, told in (
        ([], "at least one"),
        ([Pose("a")], "pose 'a': load = 0: must be"),
        ([Pose("a", load=1e3), Pose("a", load=2e3)], "pose 'a': there are two of this name"),
    ):
        with pytest.raises(InputError, match=told):
            solve_poses(model, poses)
    with pytest.raises(InputError, match="side = 'middle': must be left or right"):
        solve_poses(model, [Pose(load=1e3)], side="middle")  # type: ignore[arg-type]


def test_a_result_draws_its_standard_pictures_and_any_channel(curve: Result, study: Result) -> None:
    assert curve.pictures[0] == "overview"
    drawn = curve.plot("Y", "lateral_shift")
    assert isinstance(drawn, Figure) and drawn._repr_png_().startswith(b"\x89PNG")
    labels = [axes.get_ylabel() for axes in drawn.axes]
    assert any("Lateral force" in label for label in labels) and any("Lateral shift" in label for label in labels)
    assert [axes.get_ylabel() for axes in study.plot("Q").axes] == ["Vertical force $Q$ [kN]"]
    assert isinstance(study.plot(), Figure)


def test_notebooks_escape_what_users_wrote_and_name_what_a_function_wrote(tmp_path: Path) -> None:
    dataset = curve_run()
    dataset.attrs["title"] = "<script>alert('x')</script> & more"
    card = Result(dataset)._repr_html_()
    assert "<script>" not in card and "&lt;script&gt;" in card and "&amp; more" in card
    written = wrsim.new_file("track", "curve", tmp_path / "<bend>.toml")
    assert str(tmp_path) in written._repr_html_() and "&lt;bend&gt;.toml" in written._repr_html_()
    dataset = static_poses((0.0,), (0.0,), ("left",), 24e3)
    bare = dataset.drop_vars([name for name in dataset.data_vars if str(name) in ("Y", "Q", "Y_over_Q", "p0")])
    assert isinstance(bare, xr.Dataset) and "1 pose\n" in repr(Result(bare))


def test_every_import_of_wrsim_resolves_also_those_inside_functions() -> None:
    """Commands import when they run, and mypy does not look for modules that are missing there."""
    names = r"\w+(?: as \w+)?(?:,\s*\w+(?: as \w+)?)*"
    statement = re.compile(rf"^ *from (wrsim[\w.]*) import (?:\(\s*({names}),?\s*\)|({names}))", re.MULTILINE)
    rooms = ("wrsim", "campaigns", "benchmarks", "docs")
    for path in sorted(path for room in rooms for path in (ROOT / room).rglob("*.py")):
        for home, inside, plain in statement.findall(path.read_text()):
            module = import_module(home)
            for name in (imported.split()[0] for imported in (inside or plain).split(",")):
                resolves = hasattr(module, name) or find_spec(f"{home}.{name}") is not None
                assert resolves, f"{path}: {home} has no {name}"


def test_what_a_notebook_shows_of_objects_names_them_and_runs_nothing() -> None:
    texts = {
        "wheels/S1002.toml": wrsim.load_profile("wheels/S1002.toml"),
        "Manchester": wrsim.load_vehicle("vehicles/manchester_1.toml"),
        "S1002 on 60E1": wrsim.load(ROOT / "scenarios" / "static_s1002.toml"),
        "R 300 m": wrsim.Track.build([wrsim.Straight(10.0), wrsim.Arc(20.0, radius=300.0)]),
    }
    for subject, thing in texts.items():
        shown = thing._repr_html_()
        assert Path(subject).stem.split("/")[0] in shown and shown.count("<table>") == 1, subject
    evil = wrsim.load_text(texts["S1002 on 60E1"].text, ROOT / "scenarios").with_values(
        {"title": "<script>evil()</script>"}
    )
    assert "<script" not in evil._repr_html_()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda pair: wrsim.contact_model(*pair, radius=460.0), "radius = 460"),
        (lambda pair: wrsim.contact_model("wheels/S1002.toml", pair[1], 0.46), "must be a Profile"),
        (lambda pair: wrsim.contact_model(*pair, 0.46, friction=-0.1), "friction = -0.1"),
        (lambda pair: wrsim.contact_model(*pair, 0.46, friction=wrsim.Friction(0.3, -0.2)), "friction = -0.2"),
        (lambda pair: wrsim.contact_model(*pair, 0.46, friction="dry"), "friction = 'dry'"),
        (lambda pair: wrsim.contact_model(*pair, 0.46, {"strips": 30}), "not dict"),
        (lambda pair: wrsim.contact_model(*pair, 0.46, wrsim.ContactSettings(strips=-1)), "strips = -1"),
        (lambda pair: wrsim.contact_model(*pair, 0.46, wrsim.ContactSettings(tangential="fastsin")), "'fastsim'"),
        (lambda pair: wrsim.contact_model(*pair, 0.46).evaluate((0.0, 0.0)), r"shape \(3,\)"),
        (lambda pair: wrsim.solve_poses(wrsim.contact_model(*pair, 0.46), [(0.0, 0.0)]), "list of at least one Pose"),
        (
            lambda pair: wrsim.solve_poses(wrsim.contact_model(*pair, 0.46), [wrsim.Pose(lateral=np.nan, load=1e3)]),
            "nan",
        ),
        (lambda pair: pair[1].inclined(40), "slope = 40"),
        (lambda pair: wrsim.load(None), "None: must be the name of a scenario file"),
        (lambda pair: wrsim.run_study(None), "None: must be the name of a file"),
    ],
)
def test_what_cannot_be_is_named_from_python_too(call, message: str) -> None:
    pair = wrsim.load_profile("wheels/S1002.toml"), wrsim.load_profile("rails/60E1.toml").inclined(1 / 40)
    with pytest.raises(wrsim.InputError, match=message):
        call(pair)
