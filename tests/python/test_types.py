"""Tests of what the package says of itself: stubs have its names and parameters, and all is
explained."""
# SPDX-License-Identifier: BSD-3-Clause
import ast
import os
import re
import shutil
import subprocess
import sys
import tempfile
import types
import unittest

try:
    import numpy  # noqa: F401
except ImportError:
    print("skipped: no numpy")
    sys.exit(77)

import bristle
import bristle.float32 as bristle32
import stubs

# Members that classes of pybind11 or of Python bring along.
BROUGHT = {"__doc__", "__module__", "__eq__", "__hash__", "__repr__", "__str__", "__ne__",
           "__weakref__", "__pybind11_conduit_v1__"}
SPECIAL = {"__init__", "__len__", "__getitem__", "__copy__"}


def public(module):
    """Names of a module that are for users, without modules in it."""
    return {name: value for name, value in vars(module).items()
            if not name.startswith("_") and not isinstance(value, types.ModuleType)}


def stub_of(module):
    """Top-level classes and functions of a stub, by name."""
    path = stubs.STUB if module is bristle else stubs.STUB_FLOAT32
    return {node.name: node for node in ast.parse(path.read_text()).body
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and node.name[0] != "_"}


def members(stub):
    """Names in a class of a stub: functions and annotated names."""
    return {getattr(node, "name", None) or node.target.id: node for node in stub.body
            if isinstance(node, (ast.FunctionDef, ast.AnnAssign))}


def parameters_of_stub(function):
    """(name, has a default, by keyword alone) of each parameter."""
    a = function.args
    plain = a.posonlyargs + a.args
    defaults = [False] * (len(plain) - len(a.defaults)) + [True] * len(a.defaults)
    return ([(p.arg, d, False) for p, d in zip(plain, defaults)]
            + [(p.arg, d is not None, True) for p, d in zip(a.kwonlyargs, a.kw_defaults)])


def parameters_of_signature(docstring):
    """The same of the first line of a docstring of pybind11."""
    text = docstring.split("\n", 1)[0]
    start = text.index("(") + 1
    depth, part, parts = 1, "", []
    for c in text[start:]:
        depth += (c in "([{<") - (c in ")]}>")
        if depth == 0:
            break
        if c == "," and depth == 1:
            parts.append(part)
            part = ""
        else:
            part += c
    parts = [p.strip() for p in [*parts, part] if p.strip()]
    result, by_keyword = [], False
    for p in parts:
        if p == "*":
            by_keyword = True
        else:
            result.append((re.match(r"\w+", p)[0], " = " in p, by_keyword))
    return result


class Stubs(unittest.TestCase):
    def test_float32_is_up_to_date(self):
        self.assertEqual(stubs.STUB_FLOAT32.read_text(), stubs.of_float32(stubs.STUB.read_text()),
                         "tests/python/stubs.py --update")

    def test_names(self):
        for module in (bristle, bristle32):
            self.assertEqual(set(public(module)), set(stub_of(module)))

    def test_members_and_parameters(self):
        compared = 0
        for module in (bristle, bristle32):
            stub = stub_of(module)
            for name, value in public(module).items():
                if not isinstance(value, type):
                    self.assertEqual(parameters_of_signature(value.__doc__),
                                     parameters_of_stub(stub[name]), name)
                    continue
                if issubclass(value, Exception):
                    continue
                known = members(stub[name])
                if hasattr(value, "__members__"):  # an enumeration
                    self.assertEqual(set(value.__members__), set(known), name)
                    continue
                there = {n: v for n, v in vars(value).items()
                         if not n.startswith("_") or n in SPECIAL}
                # What cannot be made by hand has no constructor in the stub.
                if "__init__" in there and "__init__" not in known:
                    with self.assertRaisesRegex(TypeError, "No constructor defined"):
                        value()
                    there.pop("__init__")
                self.assertEqual(set(there), set(known), name)
                for member, function in there.items():
                    if isinstance(function, (property, staticmethod)):
                        continue
                    self.assertEqual(parameters_of_signature(function.__doc__),
                                     parameters_of_stub(known[member]), f"{name}.{member}")
                    compared += 1
        self.assertGreater(compared, 100)


@unittest.skipUnless(shutil.which("mypy"), "no mypy")
class TypeChecker(unittest.TestCase):
    def complaints(self, *files):
        """What mypy, at its strictest, says of programs."""
        run = subprocess.run(
            ["mypy", "--strict", "--no-error-summary", "--cache-dir", os.devnull, *map(str, files)],
            env={**os.environ, "MYPYPATH": str(stubs.PACKAGE)}, capture_output=True, text=True)
        return run.stdout + run.stderr

    def test_examples_have_no_mistakes(self):
        examples = stubs.PACKAGE.parent
        self.assertEqual(self.complaints(*(examples / name for name in (
            "falling_box.py", "slope.py", "batch.py"))), "")

    def test_mistakes_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "wrong.py")
            with open(path, "w") as file:
                file.write("import bristle\nimport bristle.float32\n"
                           "world = bristle.World(time_step='1 ms')\n"
                           "world.set_active(world.add_body(mass=1), True)\n"
                           "bristle.float32.World().contacts().gaps\n")
            self.assertEqual([line.split(":")[1] for line in self.complaints(path).splitlines()
                              if " error: " in line], ["3", "4", "5"])


class Docstrings(unittest.TestCase):
    def test_everything_is_explained(self):
        for module in (bristle, bristle32):
            for name, value in public(module).items():
                if isinstance(value, type) and issubclass(value, Exception):
                    continue
                self.assertTrue(value.__doc__, name)
                things = vars(value).items() if isinstance(value, type) else [(name, value)]
                for member, thing in things:
                    if member in BROUGHT or member.startswith("__") and member not in SPECIAL:
                        continue
                    if hasattr(value, "__members__") or (
                            member == "__init__" and thing.__doc__ is not None
                            and "Initialize self" in thing.__doc__):
                        continue
                    text = thing.__doc__ or ""
                    if not isinstance(thing, property):  # after the signature
                        text = text.partition("\n\n")[2]
                    self.assertGreater(len(text.strip()), 5, f"{name}.{member}: {text!r}")


if __name__ == "__main__":
    unittest.main()
