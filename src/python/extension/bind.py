# SPDX-License-Identifier: Apache-2.0
"""bind.py MODULE.c WORDS…: writes the C source of the module that binds the libraries to Python, by cffi. WORDS preprocess extension.h.

All types of that and of the project's headers that it includes are declared to cffi as they stand there, and the functions that
cellwalk/*.py calls. So Python fills structs by the names of their members, and nothing is declared twice."""
import pathlib
import re
import subprocess
import sys

import cffi

here = pathlib.Path(__file__).resolve().parent
project = here.parents[2]


def own(text):
    """Of preprocessed C: the lines from the project's headers."""
    keep = False
    for line in text.splitlines():
        marker = re.match(r'# \d+ "(.*?)"', line)
        if marker:
            keep = project in pathlib.Path(marker[1]).resolve().parents
        elif keep:
            yield line


def declarations(text):
    """One by one; a function with a body is none."""
    begin = depth = 0
    for found in re.finditer("[{};]", text):
        depth += (found[0] == "{") - (found[0] == "}")
        part = text[begin:found.end()].strip()
        inline = part.startswith("static")
        if depth == 0 and (found[0] == ";" or inline):
            begin = found.end()
            if not inline and part != ";":
                yield part


def bound(part, called):
    """The declaration for cffi; empty for a function without a caller."""
    function = None if part.startswith("typedef") else re.match(r"[^({]*\b(\w+)\(", part)
    if function is None:
        return part
    # What C calls is in Python.
    return f'extern "Python+C" {part}' if function[1].startswith("python_") else part if function[1] in called else ""


target, *words = sys.argv[1:]
called = {name for path in here.parent.glob("cellwalk/*.py") for name in re.findall(r"\blib\.(\w+)", path.read_text())}
text = subprocess.run([*words, "-DCW_API=", "-D__attribute__(x)=", here / "extension.h"], check=True, capture_output=True, text=True).stdout
text = re.sub(r"const (\w+ \(\*)", r"\1", "\n".join(own(text)))  # cffi writes pointers to constant rows wrongly
ffi = cffi.FFI()
ffi.cdef("typedef _Bool atomic_bool;\n" + "\n".join(bound(part, called) for part in declarations(text)))
ffi.set_source("cellwalk._cellwalk", "#include <alloca.h>\n#include \"extension.h\"")
ffi.emit_c_code(target)  # which does not touch a file that is the same already
