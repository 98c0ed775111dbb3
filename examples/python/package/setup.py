"""Makes a wheel of what CMake builds.

Of a build folder that BRISTLE_BUILD names, with the package in it; without that the folder
build/wheel of the source tree is configured and built first.
"""
# SPDX-License-Identifier: BSD-3-Clause
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(os.environ.get("BRISTLE_BUILD") or ROOT / "build" / "wheel").resolve()


def version():
    """The version of the library, from its header."""
    header = ROOT / "include" / "bristle" / "core" / "version.hpp"
    text = header.read_text()
    found = [re.search(rf"#define BRISTLE_VERSION_{part} +([0-9]+)", text)
             for part in ("MAJOR", "MINOR", "PATCH")]
    if None in found:
        raise RuntimeError(f"no version in {header}")
    return ".".join(number[1] for number in found)


class CMakeBuild(build_ext):
    """Takes the compiled part from CMake."""

    def build_extension(self, ext):
        if "BRISTLE_BUILD" not in os.environ:
            subprocess.run(
                ["cmake", "-S", ROOT, "-B", BUILD, "-DCMAKE_BUILD_TYPE=Release",
                 "-DBRISTLE_BUILD_TESTS=OFF", "-DBRISTLE_BUILD_BENCHMARKS=OFF",
                 "-DBRISTLE_WITH_FCL=OFF", "-DBRISTLE_WERROR=OFF",
                 f"-DPython_EXECUTABLE={sys.executable}"], check=True)
            jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count()))
            subprocess.run(["cmake", "--build", BUILD, "--parallel", jobs, "--target",
                            "bristle_python"], check=True)
        target = pathlib.Path(self.get_ext_fullpath(ext.name))
        built = BUILD / "examples" / "python" / "bristle" / target.name
        if not built.is_file():
            raise RuntimeError(f"{BUILD} has no {target.name}: it must have built bristle_python "
                               f"for this Python, {sys.executable}")
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(built, target)


# Nothing of it goes into the source tree.
WORK = BUILD / "wheel_files"
WORK.mkdir(parents=True, exist_ok=True)
setup(version=version(), ext_modules=[Extension("bristle._core", sources=[])],
      cmdclass={"build_ext": CMakeBuild},
      options={"build": {"build_base": str(WORK)}, "egg_info": {"egg_base": str(WORK)}})
