"""Builds a wheel of a build folder, installs it where nothing but numpy is, and uses it there.

Usage: python3 build_wheel.py BUILD WORK
"""
# SPDX-License-Identifier: BSD-3-Clause
import os
import pathlib
import shutil
import subprocess
import sys
import venv

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples" / "python"

try:
    import ensurepip  # noqa: F401
    import numpy
    import setuptools  # noqa: F401
    import wheel  # noqa: F401
except ImportError as error:
    print(f"skipped: no {error.name}: python3-numpy, -setuptools, -wheel and -venv are needed")
    sys.exit(77)


def run(*command, **options):
    print("+", *command, flush=True)
    done = subprocess.run([str(word) for word in command], check=False, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options)
    print(done.stdout, flush=True)
    if done.returncode != 0:
        sys.exit(f"ended with {done.returncode}")
    return done.stdout


def require(holds, what):
    if not holds:
        sys.exit(f"failed: {what}")


build, work = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
shutil.rmtree(work, ignore_errors=True)
environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
before = {path for path in EXAMPLES.rglob("*") if "__pycache__" not in path.parts}

# The tools: pip, and setuptools and wheel of the system.
venv.create(work / "tools", with_pip=True, system_site_packages=True)
pip = work / "tools" / "bin" / "pip"
run(pip, "wheel", "--no-build-isolation", "--no-deps", "--no-index", "--wheel-dir", work / "dist",
    EXAMPLES / "package", env={**environment, "BRISTLE_BUILD": str(build)})
wheels = list((work / "dist").iterdir())
require(len(wheels) == 1, f"one wheel, not {wheels}")
require(f"cp{sys.version_info[0]}{sys.version_info[1]}" in wheels[0].name
        and "none-any" not in wheels[0].name, f"{wheels[0].name} is of this Python and machine")
left = {path for path in EXAMPLES.rglob("*") if "__pycache__" not in path.parts} - before
require(not left, f"nothing is left in the source tree: {left}")

# A Python that knows numpy alone.
venv.create(work / "clean", with_pip=False)
python = work / "clean" / "bin" / "python"
site = pathlib.Path(run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))")
                    .strip())
numpy_home = pathlib.Path(numpy.__file__).parents[1]
for path in [numpy_home / "numpy", *numpy_home.glob("numpy-*-info"),
             *numpy_home.glob("numpy.libs")]:
    (site / path.name).symlink_to(path)
missing = subprocess.run([python, "-I", "-c", "import bristle"], capture_output=True, check=False)
require(missing.returncode != 0, "bristle is not there before")
run(pip, "--python", python, "install", "--no-index", wheels[0], env=environment)

output = run(python, "-I", EXAMPLES / "falling_box.py", cwd=work, env=environment)
require(output == "32.0 mm, 4.905 N, 25 of 25\n", "the falling box prints what it should")
where = run(python, "-I", "-c", "import bristle; print(bristle.__file__, bristle.__version__)",
            cwd=work, env=environment).split()
require(pathlib.Path(where[0]).is_relative_to(site), f"{where[0]} is what was installed")
require(wheels[0].name.startswith(f"bristle-{where[1]}-"), f"{wheels[0].name} is of {where[1]}")
require((site / "bristle" / "py.typed").is_file() and (site / "bristle" / "__init__.pyi").is_file(),
        "types are in the wheel")
run(python, "-I", "-m", "bristle.demo", "grip.glb", cwd=work, env=environment)
require((work / "grip.glb").read_bytes()[:4] == b"glTF", "the demo writes a recording")

# A folder without the package is refused with a sentence.
refused = subprocess.run(
    [pip, "wheel", "--no-build-isolation", "--no-deps", "--no-index", "--wheel-dir", work / "none",
     EXAMPLES / "package"], env={**environment, "BRISTLE_BUILD": str(work)}, check=False,
    capture_output=True, text=True)
require(refused.returncode != 0 and "must have built bristle_python" in
        refused.stdout + refused.stderr, "a folder without the package is refused")
print("a wheel is built, installed and used")
