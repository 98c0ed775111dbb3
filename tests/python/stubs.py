"""The types of `bristle.float32` are those of `bristle` in float: python3 stubs.py --update writes
them."""
# SPDX-License-Identifier: BSD-3-Clause
import pathlib
import re
import sys

PACKAGE = pathlib.Path(__file__).resolve().parents[2] / "examples" / "python" / "package"
STUB = PACKAGE / "bristle" / "__init__.pyi"
STUB_FLOAT32 = PACKAGE / "bristle" / "float32.pyi"
MARK = "# Once for each scalar:\n"


def of_float32(text):
    """Text of float32.pyi, from that of __init__.pyi."""
    head, mark, scalar = text.partition(MARK)
    if not mark:
        raise ValueError(f"{STUB}: no line {MARK!r}")
    common = re.findall(r"^class ([A-Z]\w+)", head, re.MULTILINE)
    used = sorted(name for name in common if re.search(rf"\b{name}\b", scalar))
    scalar = scalar.replace("np.float64", "np.float32")
    imports = ",\n    ".join(used)
    return ("# Made of __init__.pyi: tests/python/stubs.py --update\n"
            "# SPDX-License-Identifier: BSD-3-Clause\n"
            "from collections.abc import Sequence\nfrom typing import Union\n\n"
            "import numpy as np\nfrom numpy.typing import ArrayLike, NDArray\n\n"
            f"from . import (\n    {imports},\n)\n{scalar}")


if __name__ == "__main__":
    if sys.argv[1:] != ["--update"]:
        sys.exit(__doc__)
    STUB_FLOAT32.write_text(of_float32(STUB.read_text()))
