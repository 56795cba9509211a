import json
import subprocess
import sys

# every package that is installed, but for these two and what runs tests
SCRIPT = """
import sys
from importlib.metadata import packages_distributions
kept = {"numpy", "scipy", "contactstudy", "studies", "tests", *sys.stdlib_module_names}
sys.modules.update({name: None for name in packages_distributions() if name not in kept})

import json
import contactstudy as cs

steel = cs.HalfSpace(210e9, 0.3)
scene = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(0.01),))
solution = cs.solve(scene)
estimate = solution.error
said = {"plan": cs.plan(scene, error=1e-2).dimension, "status": solution.status.name, "l1": estimate.l1.total,
        "table": solution._repr_html_(), "missing": {}}
uses = {
    "Contact.to_dataset": solution.to_dataset,
    "Contact.plot": solution.plot,
    "MeasuredSurface.read": lambda: cs.MeasuredSurface.read(sys.executable),
    "contactstudy.write_scene": lambda: cs.write_scene(scene, "scene.toml"),
    "studies.run": lambda: __import__("studies").run,
}
uses = {f"contactstudy.{name}": lambda name=name: getattr(cs, name) for name in cs.__all__} | uses
for name, use in uses.items():
    try:
        use()
    except ModuleNotFoundError as missing:
        said["missing"][name] = str(missing)
sys.argv = ["contactstudy", "--help"]
try:
    from studies.cli.main import main
    main()
except SystemExit as ended:
    said["command"] = str(ended)
print(json.dumps(said))
"""


def test_numpy_and_scipy_are_enough_to_solve_and_the_rest_says_what_it_needs() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["status"] == "CONVERGED"
    assert said["plan"] == 1
    assert said["l1"] < 1e-2  # the default error of a plan
    assert "<img" not in said["table"]
    assert said["missing"] == {
        name: f"{name} needs {package}, which is not installed: pip install {install}."
        for name, package, install in (
            ("contactstudy.write_scene", "tomli_w", "tomli-w"),
            ("contactstudy.compare", "xarray", "xarray"),
            ("Contact.to_dataset", "xarray", "xarray"),
            ("Contact.plot", "matplotlib", "matplotlib"),
            ("MeasuredSurface.read", "SurfaceTopography", "'contactstudy[measured]'"),
            ("studies.run", "cloudpickle", "cloudpickle"),
        )
    }
    assert said["command"].startswith("contactstudy: the command needs click, which is not installed")
