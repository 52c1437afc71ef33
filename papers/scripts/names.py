# SPDX-License-Identifier: Apache-2.0
"""What the names in the results are called on pages and in pictures."""

# Classes of rays, in the order in which pages show them.
CLASSES = {"primary": "primary", "shadow": "shadow", "ao": "ambient occlusion", "bounce": "bounce", "random": "random",
           "grazing": "grazing", "afar": "from afar"}
LAND = ("65", "257", "1025", "4097", "8193")
MIDDLE = ("257", "1025", "4097")
# Files of speeds, widest instruction set first.
SPEED_FILES = {"avx512": "speed-avx512.json", "avx2": "speed-avx2.json", "sse4.2": "speed-sse42.json"}
ISAS = {"avx512": "AVX-512", "avx2": "AVX2", "sse4.2": "SSE4.2", "scalar": "no vector instructions"}


def classes(results, kind="result"):
    """Those that the results have."""
    there = results.distinct("rays", kind)
    return [rays for rays in CLASSES if rays in there]


def field(name):
    """A field of land by its side: 1025²; 8193 × 1025; calm sea."""
    if "x" in name:
        return name.replace("x", " × ")
    return f"{name}²" if name.isdigit() else " ".join(reversed(name.split("-")))


def kernel(contender):
    """pyramid8x2 of pyramid8x2/watertight; a peer keeps its whole name."""
    return contender if contender.startswith("embree") else contender.split("/")[0]


def peer(contender):
    """Embree, 8 wide, of embree/triangles/w8, embree/w8 and the like."""
    library, *geometry, width = contender.split("/")
    wide, _, split = width[1:].partition("-")
    what = [part for part in (geometry or [library.removeprefix("embree")])[0].split("-") if part not in ("", "triangles")]
    return " ".join(["Embree", *what]) + f", {wide} wide{' (split)' if split else ''}"


def label(contender):
    """The leaf test is named where it is not the default."""
    if contender.startswith("embree"):
        return peer(contender)
    return f"`{kernel(contender)}`" + (", Möller–Trumbore" if contender.endswith("/moller-trumbore") else "")
