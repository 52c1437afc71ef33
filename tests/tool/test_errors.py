# SPDX-License-Identifier: Apache-2.0
"""Command lines that are refused: the exit status, what is said, and that nothing is left behind."""
import os
import re
import shlex

import numpy as np
import pytest
from program import SCENE, commands, info, library, needs_room, rays, read, refused, run, wall, write

# The status, a part of the message, the words, and what is in bad.csv; ~ is a new line. Of {a;b} each is tried, with that in another place.
LINES = r"""
2 | did you mean trace? | tarce
2 | unknown option '--verbose' | --verbose
2 | {FIELD;RAYS.npy} is missing | trace {;wall.npy}
2 | nothing to do | trace wall.npy rays.npy
2 | 'hits.npy' is one argument too many | trace wall.npy rays.npy hits.npy
2 | --output needs a value | trace wall.npy rays.npy -o {; ''}
2 | unknown option -x~Try 'cellwalk trace --help'. | trace wall.npy rays.npy -x
2 | did you mean --{kernel;threads}? | trace wall.npy rays.npy --{kernal=cell;thre=1}
2 | unknown option --any | trace wall.npy rays.npy --any
2 | --json takes no value | trace wall.npy rays.npy --json=yes
2 | 'celt' is unknown; did you mean cell? | trace wall.npy rays.npy --json --kernel celt
2 | there are default, moller-trumbore, watertight | trace wall.npy rays.npy --json --leaf woop
2 | scalar, sse4.2, avx2, avx512 | trace wall.npy rays.npy --json --isa avx
2 | from 1 to 1048576, not ' | trace wall.npy rays.npy --json --band {0;1048577}
2 | --threads takes | trace wall.npy rays.npy --json --threads {-1;1.5;4x;99999999999999999999}
2 | {standard output cannot take both;standard output cannot take both;no.tif: is a raster's name, and hits} | trace wall.npy rays.npy -o {-;/dev/stdout;no.tif} --json
2 | {--occluded finds no hit;go into HITS.npy} | trace wall.npy rays.npy {--occluded --points -o no.npy;--json --normals}
2 | --leaf: brute does not have the leaf test watertight | trace wall.npy rays.npy --json --kernel brute --leaf watertight
2 | CELLWALK_ISA '{sse;}' is unknown; {did you mean sse4.2? T;t}here are scalar, | ISA={sse;} trace wall.npy rays.npy -o no.npy
2 | packet4 needs sse4.2; this machine, or the limit set by --isa or CELLWALK_ISA, has scalar | {ISA=scalar ;}trace wall.npy rays.npy --json --kernel packet4 {; --isa scalar}
2 | --isa sse4.2: this machine, or CELLWALK_ISA, allows no more than scalar | ISA=scalar trace wall.npy rays.npy --json --isa sse4.2
2 | 'b' is one argument too many | info a b
2 | goes with a FIELD, which is missing | info {--samples;--band 2;--coarser 4}
2 | is given twice | {trace wall.npy rays.npy -o a.npy -o;viewshed wall.npy --from 1,2 --from 1,3 --window 0,0,9,9 --window=0,0,9,9 -o;info --threads 1 --threads 1} no.npy
2 | --filter goes with --coarser | info wall.npy --filter mean
2 | --target-height goes without --needed | viewshed wall.npy --from 1,2 --needed --target-height 0 -o no.npy
1 | cellwalk info: --json: | info -- --json
1 | f8.npy: holds elements of type '<f8', not '<f4' | trace wall.npy f8.npy -o no.npy
1 | {seven.npy: shape (2, 7);flat.npy: shape (16,)}, but rays are (N, 8) | trace wall.npy {seven;flat}.npy -o no.npy
1 | {.: cannot read: Is a directory;absent.npy: cannot read: No such file} | trace wall.npy {.;absent.npy} -o no.npy
1 | {row.npy: 16 x 1 samples:;cube.npy: shape (2, 2, 4), but a raster is (rows, columns)} | trace {row;cube}.npy rays.npy -o no.npy
1 | : s.pbrt: is a scene, which cellwalk render draws | {trace s.pbrt rays.npy;shadow s.pbrt --sun 0,9} -o no.npy
1 | cellwalk trace: field: | trace field rays.npy -o no.npy
2 | --distance goes with none of | horizon wall.npy --distance --svf -o no.npy
2 | do not go together | {horizon wall.npy --at 1,2 --places pairs.csv;viewshed wall.npy --observers t.csv --from 1,2;los wall.npy --pairs pairs.csv 1,2 3,4}
2 | go with none of --svf | horizon wall.npy --at 1,2 {--svf;--window 0,0,9,9}
1 | no room for 32 bands | horizon wall.npy -o no.png
1 | 70,5,=99: is not on the terrain, where the horizon is found | horizon wall.npy --at {70,5,=99 -o no.csv;5,5 --at 70,5,=99}
1 | no.tif: is a raster's name | {horizon wall.npy --at 5,5 -o;los wall.npy --pairs pairs.csv -o;los wall.npy 1,2 3,4 --profile;viewshed wall.npy --from 1,2 -o no.npy --table} no.tif
2 | takes metres above 0, not 0 | {horizon wall.npy --max-distance;visibility wall.npy --max-distance;viewshed wall.npy --from 1,2 --max-distance;viewshed wall.npy --from 1,2 --every} 0 -o no.npy
2 | --{cog;co} goes with -o FILE.tif | shadow wall.npy --sun 0,9 {--cog;--co A=B} -o no.npy
1 | so the sun's place at a time is not known; give --sun | {shadow;render} wall.npy --time 2024-06-21T12:00:00Z -o no.{npy;exr}
2 | --sun 0,91: the second number is the altitude, and 91 degrees is none; the azimuth is first | {shadow;render} wall.npy --sun 0,91 -o no.{npy;exr}
2 | not 'noon' | {shadow;render} wall.npy --time noon -o no.{npy;exr}
2 | --sun takes azimuth and altitude in degrees, as 225,30, not '0' | {shadow;render} wall.npy --sun 0 -o no.{npy;exr}
2 | give -o FILE | shadow wall.npy --sun 0,30
1 | the name's ending tells no format | shadow wall.npy --sun 0,30 -o no.xyz
1 | is the terrain itself | shadow wall.npy --sun 0,30 -o ./wall.npy
2 | --cellsize takes a number above 0 | shadow wall.npy --sun 0,30 --cellsize 0 -o no.npy
1 | has one band, not 2 | shadow wall.npy --sun 0,30 --band 2 -o no.npy
2 | --window takes XMIN,YMIN,XMAX,YMAX | shadow wall.npy --sun 0,30 --window 1,2,3 -o no.npy
1 | no sample is in it; samples go from 0,0 to 590,490 | shadow wall.npy --cellsize 10 --sun 0,30 --window 5000,0,6000,10 -o no.npy
1 | XMIN > XMAX or YMIN > YMAX; samples go from | shadow wall.npy --cellsize 10 --sun 0,30 --window {20,0,10,10;0,20,10,10} -o no.npy
2 | --memory takes a number of bytes | shadow wall.npy --sun 0,30 --memory {2X;"2 "} -o no.npy
1 | 60 x 50 samples matter at once, which need --memory 1M or more; there is {0.03M;12} | horizon wall.npy --memory {0.03M;12} -o no.npy
2 | --from X,Y is missing | viewshed wall.npy -o no.npy
1 | is too far away | {viewshed wall.npy -o no.npy --from 3,1e308,=9;los wall.npy 1e308,1e308,=9 10,10,2;los wall.npy 10,10,2 1e8,3,=9}
2 | unknown option --height; the height of a place is its third number: X,Y,H | viewshed wall.npy --from 1,2 --height 3 -o no.npy
1 | no sample is within 5 m of any observer | viewshed wall.npy --cellsize 10 --from 9000,0,=9 --max-distance 5 -o no.npy
2 | --layer goes with --observers | viewshed wall.npy --layer a --from 1,2 -o no.npy
2 | takes two places or more | viewshed wall.npy --from 1,2 --every 5 -o no.npy
2 | --target-height takes metres from 0 on, not -5 | {viewshed wall.npy --from 1,2;visibility wall.npy} --target-height -5 -o no.npy
2 | --curvature takes a number from 0 to 1e9, not 2e+09 | {los wall.npy 1,2 3,4;viewshed wall.npy --from 1,2 -o no.npy;horizon wall.npy --at 1,2;render wall.npy -o no.exr} --curvature 2e9
2 | --every takes metres above 0, not -5 | viewshed wall.npy --observers t.csv --every -5 -o no.npy
1 | more than 16777216 observers | viewshed wall.npy --cellsize 10 --observers t.csv --every 1e-9 -o no.npy
1 | 9,2,=400: heights along a line are all above | viewshed wall.npy --from 1,2 --from 9,2,=400 --every 5 -o no.npy
2 | --within goes with --table | viewshed wall.npy --observers t.csv --within a.gpkg -o no.npy
2 | --table lists what is seen | viewshed wall.npy --observers t.csv --table no.csv --bands -o no.npy
2 | --weights goes with --observers | viewshed wall.npy --from 1,2 --weights -o no.npy
1 | t.csv: has no column 'weight' | viewshed wall.npy --observers t.csv --weights -o no.npy
2 | keeps them apart | viewshed wall.npy --observers t.csv --weights --bands -o no.npy
2 | one can be written | viewshed wall.npy --observers t.csv --weights --angle -o no.npy
1 | is that of one observer, not of 2; --bands | viewshed wall.npy --cellsize 10 --observers t.csv {--angle;--needed} -o no.npy
2 | is that of one observer, not of 2; --bands | viewshed wall.npy --from 1,2 --from 9,2 {--angle;--needed} -o no.npy
1 | a table has no layers | viewshed wall.npy --observers t.csv --layer a -o no.npy
2 | --azimuth takes two angles | viewshed wall.npy --from 1,2 --azimuth {1;1,400} -o no.npy
2 | {the lower one first, not '5,-5';--vertical takes two angles} | viewshed wall.npy --from 1,2 --vertical {5,-5;-91,0} -o no.npy
2 | --needed looks for that height | viewshed wall.npy --from 1,2 --vertical -9,0 --needed -o no.npy
2 | --min-distance {takes metres from 0 on, not -1;9 is more than} | viewshed wall.npy --from 1,2 --min-distance {-1;9 --max-distance=5} -o no.npy
1 | t.npy: is also an input | viewshed wall.npy --cellsize 10 --observers t.csv -o t.npy
1 | no room for 2 bands | viewshed wall.npy --cellsize 10 --observers t.csv --bands -o no.png
2 | a place is X,Y or X,Y,H with H metres above ground, or X,Y,=Z with an absolute height, not | los wall.npy {5;1,2,=;1,=2} 10,10,2
1 | pairs.csv | los wall.npy --pairs pairs.csv -o ./pairs.csv
2 | {FROM;TO} is missing, or --pairs FILE | los wall.npy {;1,2}
2 | -o goes with --pairs | los wall.npy 1,2 3,4 -o no.csv
2 | --json goes with two places | los wall.npy --pairs pairs.csv --json
2 | --profile needs a file that nothing else is written to | los wall.npy {--pairs pairs.csv --profile -;1,2 3,4 --profile /dev/stdout}
2 | --frequency takes megahertz from 0.1 to 1000000, not | los wall.npy 1,2 3,4 --frequency {0;-1;0.01;1e9}
1 | bad.csv: is empty; its first line should name the columns | viewshed wall.npy --observers bad.csv -o no.npy |
1 | bad.csv: holds no places | viewshed wall.npy --observers bad.csv -o no.npy | x,y~
1 | bad.csv: has no column 'x'; its first line names a, y | viewshed wall.npy --observers bad.csv -o no.npy | a,y~1,2~
1 | bad.csv:3: 'two' stands where a number should, in y | viewshed wall.npy --observers bad.csv -o no.npy | x,y~1,1~1,two~
1 | bad.csv:2: '=' stands where a height, as 2 or =1250, should, in height | viewshed wall.npy --observers bad.csv -o no.npy | x,y,height~1,1,=~
1 | bad.csv:2: 'heavy' stands where a number should, in weight | viewshed wall.npy --observers bad.csv -o no.npy | x,y,weight~1,1,heavy~
1 | bad.csv:{4: 70,10,2: lies outside;2: 1e+300,1,2: is too far away;2: 10,10,=-500: is under the ground} | viewshed wall.npy --observers bad.csv -o no.npy | x,y,height~{10,10,~~70,10,;1e300,1,;10,10,=-500}~
1 | bad.csv:2 (Far Mast): -9,1,2: lies outside | viewshed wall.npy --observers bad.csv -o no.npy | name,x,y~Far Mast,-9,1~
1 | bad.csv: has no column 'y2'; its first line names x1, y1, x2 | los wall.npy --pairs bad.csv -o no.csv | x1,y1,x2~1,2,3~
1 | bad.csv: holds no pairs | los wall.npy --pairs bad.csv -o no.csv --profile no2.csv | x1,y1,x2,y2~
1 | bad.csv:3: 'b' stands where a number should, in x2 | los wall.npy --pairs bad.csv -o no.csv --profile no2.csv | x1,y1,x2,y2~1,2,3,5~1,2,b,4~
1 | bad.csv:3: 3,999,0: lies outside | los wall.npy --pairs bad.csv -o no.csv --profile no2.csv | x1,y1,x2,y2~1,2,3,5~1,2,3,999~
1 | bad.csv:2: 'low' stands where a height | los wall.npy --pairs bad.csv -o no.csv --profile no2.csv | x1,y1,height1,x2,y2~1,2,low,3,4~
2 | --date is missing | sun wall.npy -o no.npy
2 | --suns goes with none of --date | sun wall.npy --suns suns.csv {--date 2024;--irradiance --linke 3} -o no.npy
1 | suns.csv:3: '91' stands where an angle from -90 to 90 degrees should, in altitude | sun wall.npy --suns suns.csv {-o no.npy;--at 9,9}
1 | {head.csv: holds no places of the sun;none.csv: cannot read} | sun wall.npy --suns {head;none}.csv -o no.npy
1 | no.png: is a raster's name, and the result is a table; give -o FILE.csv | sun wall.npy --at 5,5,2 --lon-lat 9,47 --date 2024-06-21 -o no.png
2 | --max-distance goes with --at | sun wall.npy --suns suns.csv --max-distance 9 -o no.npy
2 | --max-distance takes metres above 0 | sun wall.npy --suns suns.csv --at 9,9 --max-distance={-9;0}
2 | {--tilt takes degrees;--facing goes with --tilt} | sun wall.npy --at 9,9 --lon-lat 9,47 --date 2024 {--tilt flat;--facing 9}
2 | --date takes a day | sun wall.npy --lon-lat 9,47 --date {2024-13;2024-02-30;yesterday} -o no.npy
1 | so the sun's place at a time is not known; --lon-lat tells it | sun wall.npy --date 2024-06-21 {-o no.npy;--at 5,5}
2 | {is before;divides a day;not '15'} | sun wall.npy --date 2024-06-21 {--to 2024-06-20;--step 7min;--step 15} -o no.npy
2 | go with --irradiance | sun wall.npy --date 2024-06-21 --linke 3 -o no.npy
2 | from 1 to 10, not 0 | sun wall.npy --date 2024-06-21 --irradiance --linke 0 -o no.npy
2 | not '{7;361,0}' | sun wall.npy --date 2024-06-21 --lon-lat {7;361,0} -o no.npy
2 | longer --step | sun wall.npy --date 2000-06-21 --to 2024-06-20 --step 30s -o no.npy
2 | a scene or a raster is missing | render -o no.exr
2 | is for rasters | render s.pbrt {--sun 0,30;--nodata 0;--sky;--water 3;--curvature 1} -o no.exr
2 | {not 180;not '5';--haze takes a visibility in metres, above 0, not 0} | render wall.npy --{fov 180;from 5;haze 0} -o no.exr
1 | the land is too small or too large to be drawn | render wall.npy --cellsize {1e13;1e-22} -o no.exr
1 | the same place | render wall.npy --from 5,3,9 --to 5,3,9 -o no.exr
2 | either --sun or --time | {shadow wall.npy -o no.npy;render wall.npy --time 2024-06-21T12:00:00Z --sun 0,9 -o no.exr}
2 | give the eye's place by --from | render wall.npy --curvature 1 -o no.exr
2 | --water is level and does not go with --curvature | render wall.npy --curvature 1 --from 20,20 --water 3 -o no.exr
1 | lies outside | render wall.npy {;--curvature 1} --from -900,0 -o no.exr
1 | {missing.pbrt: cannot read: No such file;s.pbrt:1: WorldBegin: no Camera} | render {missing;s}.pbrt -o no.exr
2 | -o IMAGE is missing | render scene.pbrt
1 | {unknown kind of picture;cannot write: No such file} | render scene.pbrt -o {no.jpeg;none/no.exr}
1 | holes.npy: all samples are holes | render holes.npy -o no.exr
2 | 'nothing' is unknown | render scene.pbrt --kernel nothing -o no.exr
2 | samples | render scene.pbrt --samples 0 -o no.exr
2 | not a width and a height | render scene.pbrt --size {80;80x;x60;80x0;0x60;80x60x;-80x60;' 80x60';80x65537} -o no.exr
2 | not X0,Y0,X1,Y1 | render scene.pbrt --crop {1,2,3;1,2,3,4,;3,2,3,4;1,4,3,4;'1 2 3 4';0,0,99999999999999999999,9} -o no.exr
1 | no part of 40 x 30 pixels | render scene.pbrt --crop 0,0,41,30 -o no.exr
"""


def cases():
    for line in LINES.strip().splitlines():
        text = re.split(r"\{(.*?)\}", line + "|")
        choices = [part.split(";") for part in text[1::2]]
        for k in range(len(choices[0]) if choices else 1):
            line = "".join(part if at % 2 == 0 else choices[at // 2][k] for at, part in enumerate(text))
            status, why, words, table = (part.strip().replace("~", "\n") for part in line.split("|")[:4])
            yield int(status), why, table, words


@pytest.fixture(autouse=True)
def inputs(folder):
    """Level land with a wall of 40 m and a hole."""
    wall("wall.npy", (45, 3))
    rays("rays.npy", (2.25, 1.5, 1))
    for name, shape in ("seven", (2, 7)), ("flat", 16), ("row", (1, 16)), ("cube", (2, 2, 4)), ("f8", (2, 8)):
        np.save(name, np.zeros(shape, name if name == "f8" else "f4"))
    for name, text in {"s.pbrt": "WorldBegin", "scene.pbrt": SCENE, "suns.csv": "azimuth,altitude\n1,90\n2,91\n", "head.csv": "azimuth,altitude,weight\n",
                       "pairs.csv": "x1,y1,x2,y2\n1,2,3,4\n", "t.csv": "x,y\n100,100\n200,100\n"}.items():
        write(name, text)
    os.link("t.csv", "t.npy")
    np.save("holes.npy", np.full((3, 3), np.nan, "f4"))


@pytest.mark.parametrize("status, why, table, words", cases())
def test_lines(status, why, table, words):
    isa, words = re.fullmatch("(?:ISA=(\\S*) )?(.*)", words, re.S).groups()
    if "packet4" not in words or "packet4" in [kernel["name"] for kernel in info()["kernels"]]:  # some builds lack them
        write("bad.csv", table)
        assert refused(status, why, *shlex.split(words), isa=isa).out == ""


@pytest.mark.parametrize("place, why", [
    # Column 70 does not exist, nor does row 55 from below; (5, 29) is on the wall.
    ("70,5,2", "70,5,2: lies outside: the samples, which are the pixels' centres, go from X 0 to 59 and Y 0 to 49"),
    ("-300,4", "-300,4: lies outside"),
    ("20,55,+1", "20,55,+1: lies outside, but with X and Y exchanged it would not"),
    ("59.4,5,2", "59.4,5,2: lies in the outer half of a pixel"),
    ("3,4,2", "3,4,2: there is no data at that place"),
    ("5,29,=39", "5,29,=39: is under the ground, which is 40.000 m high there: X,Y,H counts H from the ground"),
    ("5,29,-1", "5,29,-1: is under the ground, which is 40.000 m high there"), ("5,5,=1e305", "5,5,=1e305: is too high")])
def test_places(place, why):
    """One meaning of a place for all: H above ground, =Z absolute, and what is wrong with one is said."""
    for command, *more in [("viewshed", "--from", place, "-o", "v.npy"), ("horizon", "--at", place), ("los", "10,10,2", place),
                           ("los", place, "10,10,2"), ("render", "--from", place, "-o", "v.exr"), ("render", "--to", place, "-o", "v.exr")]:
        refused(1, why, command, "wall.npy", *more)


def test_eyes_far_apart_take_no_more_memory():
    """One eye is the least; land of 40 x 50 samples asked for gigabytes. Where eyes are few, --memory reckons with the margins beside them."""
    np.save("field.npy", np.arange(2000, dtype=np.float32).reshape(40, 50) % 7)
    for every in 50, 1 << 20:
        assert run("visibility", "field.npy", "--every", every, "-o", f"{every}.npy", memory=0 if needs_room() else 300 << 20).status == 0
    assert read("50.npy") == read(f"{1 << 20}.npy")
    np.save("field.npy", np.zeros((1000, 1000), np.float32))
    words = "visibility", "field.npy", "--directions", 1, "-o", "o.npy"
    refused(1, "matter at once, which need --memory", *words, "--every", 500, "--memory", "90M")


GOOD = {"info": (), "trace": ("rays.npy", "-o", "o.npy"), "shadow": ("--sun", "90,10", "-o", "o.npy"), "horizon": ("-o", "o.npy"),
        "sun": ("--date", "2024-06-21", "--lon-lat", "9,47", "--at", "1,1"), "viewshed": ("--from", "1,1", "-o", "o.npy"), "visibility": ("-o", "o.npy"),
        "los": ("1,1", "2,2"), "render": ("--size", "8x8", "-o", "o.png")}
# Options for which 0 is a number like others, by their help or by what they are.
ZEROS = {"--threads", "--nodata", "--start", "--facing", "--tilt", "--curvature", "--target-height", "--observer-height", "--min-distance",
         "--water", "--at"}


@pytest.mark.parametrize("command", GOOD)
def test_values_of_options(command):
    """0 is a number like others or refused, never what stands for an option that is not given. A word that means nothing is refused with its name."""
    assert commands() == set(GOOD)
    np.save("field.npy", np.arange(20, dtype=np.float32).reshape(4, 5))
    options = re.findall(r"^      (--[a-z-]+) [A-Z]+$|^      (--[a-z-]+) [A-Z]+  ", run(command, "--help").out, re.M)
    done = run(command, "field.npy", *GOOD[command])
    assert options and (done.status == 0 or (command == "render" and not library("libpng"))), done.err
    for option in {one or other for one, other in options} - {"--co", "--table", "--profile"}:
        at = (*GOOD[command], option).index(option)
        good = "field.npy", *GOOD[command][:at], *GOOD[command][at + 2:]
        if option != "--memory":
            done = run(command, *good, option, 0)
            assert option in ZEROS if done.status == 0 else done.err.startswith("cellwalk"), (option, done.status, done.err)
        if option not in ("--layer", "--places"):
            done = run(command, *good, option, "wrong")
            assert done.status in (1, 2) and ("wrong" in done.err or option in done.err), (option, done.err)
