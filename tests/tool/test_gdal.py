# SPDX-License-Identifier: Apache-2.0
"""What files may make GDAL do, as users run the program: wait for nobody, read no memory, send no request unless asked for. ../io/test_network.py
tries the filter behind that call by call."""
import contextlib
import os
import socket
import socketserver
import threading

import numpy as np
import pytest
from program import needs, on_map, refused, run, vrt, write


@pytest.fixture(autouse=True)
def gdal(folder):
    needs("GDAL")
    write("grid.asc", "ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 1\n" + 4 * "1 2 3 4\n")
    np.save("field.npy", np.array([[1, 2], [3, 4]], np.float32))


def hide(name, source):
    vrt(name, source, (4, 4), on_map(None, 0, 1, 0, 4, 0, -1))
    text = open(name).read().replace(' relativeToVRT="1"', "").replace("ComplexSource", "SimpleSource").replace("<NODATA>-9999</NODATA>", "")
    write(name, text)
    return text


# ---- doors ----------------------------------------------------------------------------------------------------------------


def test_pipes_are_refused():
    os.mkfifo("pipe")
    os.symlink("pipe", "link.tif")
    os.symlink("/dev/zero", "zero.tif")
    hide("source.vrt", "pipe")
    hide("inner.vrt", "source.vrt")
    hide("zipped.vrt", "/vsigzip/pipe")
    for name, why in [("link.tif", "not a regular file"), ("source.vrt", "pipe is not a regular file"), ("inner.vrt", "pipe is not a regular file"),
                      ("zipped.vrt", "/vsigzip/pipe is not a regular file"), ("zero.tif", "not a regular file"), ("/vsistdin/", "cannot read"),
                      ("/vsigzip/pipe", "not a regular file"), ("/vsigzip//vsistdin/", "not a regular file"),
                      ("/vsizip/pipe/a.tif", "not a regular file"), ("/vsisubfile/0_99,pipe", "not a regular file"),
                      ("GTIFF_DIR:1:pipe", "not a regular file"), ('NETCDF:"pipe":z', "not a regular file")]:
        refused(1, why, "info", name)
    os.symlink("pipe", "pipe.geojson")
    refused(1, "not a regular file", "viewshed", "field.npy", "--observers", "pipe.geojson", "-o", "o.npy")


ADDRESS = "MEM:::DATAPOINTER=1,PIXELS=4,LINES=4,DATATYPE=Float32"


@pytest.mark.parametrize("name", [ADDRESS, "mem" + ADDRESS[3:], "Mem" + ADDRESS[3:], "DERIVED_SUBDATASET:AMPLITUDE:" + ADDRESS,
                                  "derived_subdataset:AMPLITUDE:DERIVED_SUBDATASET:AMPLITUDE:" + ADDRESS, "vrt://" + ADDRESS,
                                  f"vrt://{ADDRESS}?bands=1", "&#77;" + ADDRESS[1:]])
def test_names_are_files(name):
    """A name may hold an address in memory, or text in which one stands; entities hide the name in the text of a VRT."""
    text = hide("hidden.vrt", name)
    for file in name, "hidden.vrt", text, " " + text:
        refused(1, "cannot read", "info", file)
    refused(1, "cannot read", "viewshed", "field.npy", "--observers", name, "-o", "out.npy")
    refused(1, "cannot read", "viewshed", "field.npy", "--from", "0,0", "--table", "t.csv", "--within", name, "-o", "out.npy")
    refused(1, "cannot read", "horizon", "field.npy", "--places", name)


def test_python_never_runs():
    """Not even that of a module which the environment trusts."""
    write("module.py", "open('ran', 'w')\n")
    write("code.vrt", hide("code.vrt", "grid.asc").replace('band="1">', 'band="1" subClass="VRTDerivedRasterBand"><PixelFunctionLanguage>Python'
          "</PixelFunctionLanguage><PixelFunctionType>module.run</PixelFunctionType>"))
    refused(1, "disabled", "info", "code.vrt", env={"GDAL_VRT_PYTHON_TRUSTED_MODULES": "module", "PYTHONPATH": os.getcwd()})


# ---- the network ----------------------------------------------------------------------------------------------------------


class Visit(socketserver.BaseRequestHandler):
    """Is counted, and hung up on."""

    def handle(self):
        self.server.visits += 1


@pytest.fixture
def server():
    with socketserver.TCPServer(("127.0.0.1", 0), Visit) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        server.visits = 0
        yield server
        server.shutdown()


def visits(server):
    """How many came since. Visitors are counted in the order in which they come, so the test visits as the last."""
    with contextlib.suppress(ConnectionResetError), socket.create_connection(server.server_address) as last:
        last.recv(1)  # until the server hangs up
    came, server.visits = server.visits - 1, 0
    return came


def is_open_on_request(server, *words, **env):
    """Whether the server is visited once that is allowed; never without."""
    environment = {"no_proxy": "127.0.0.1", "GDAL_HTTP_MAX_RETRY": "0", **env}  # no proxy of the machine's stands between
    done = run(*words, env=environment)
    assert done.status == 1 and "--allow-network" in done.err and visits(server) == 0, (words, done.err)
    assert run(*words, "--allow-network", env=environment).status == 1
    return visits(server) > 0


def test_no_request_unless_asked_for(server):
    port = server.server_address[1]
    here, nowhere = f"http://127.0.0.1:{port}", "http://nowhere.invalid"
    write("map.tif", f'<GDAL_WMS><Service name="TMS"><ServerUrl>{here}/${{z}}/${{x}}/${{y}}.png</ServerUrl></Service><DataWindow><UpperLeftX>0'
          "</UpperLeftX><UpperLeftY>4</UpperLeftY><LowerRightX>4</LowerRightX><LowerRightY>0</LowerRightY><TileLevel>0</TileLevel><TileCountX>1"
          "</TileCountX><TileCountY>1</TileCountY></DataWindow><BlockSizeX>4</BlockSizeX><BlockSizeY>4</BlockSizeY><BandsCount>1</BandsCount>"
          "</GDAL_WMS>")
    ways = [is_open_on_request(server, "info", name) for name in ("map.tif", f"/vsicurl/{here}/b.tif")]  # by names on the command line
    ways += [is_open_on_request(server, "viewshed", "field.npy", "--observers", name, "-o", "o.npy") for name in (f"{here}/a.geojson", f"WFS:{here}/a")]
    for source in (f"/vsicurl/{here}/a.tif", f"/vsicurl_streaming/{here}/a.tif", f"/vsizip//vsicurl/{here}/a.zip/a.tif",
                   f"NETCDF:&quot;{here}/a.nc&quot;:z", f"{here}/a.tif", f"WMTS:{here}/w", "map.tif"):
        hide("net.vrt", source)
        ways.append(is_open_on_request(server, "info", "net.vrt"))
    ways.append(is_open_on_request(server, "shadow", "net.vrt", "--sun", "90,10", "-o", "o.tif"))
    # By a proxy that GDAL is told of, and that goes before those of the environment; by one that netCDF finds in the working folder.
    hide("net.vrt", f"/vsicurl/{nowhere}/a.tif")
    ways.append(is_open_on_request(server, "info", "net.vrt", GDAL_HTTP_PROXY=f"127.0.0.1:{port}"))
    hide("net.vrt", f"NETCDF:&quot;{nowhere}/a.nc&quot;:z")
    for name in ".dodsrc", ".ncrc", ".daprc":
        write(name, f"HTTP.PROXY.SERVER={here}\n")
        ways.append(is_open_on_request(server, "info", "net.vrt"))
        os.unlink(name)
    print(f"{sum(ways)} of {len(ways)} ways lead to the network")
    if not any(ways):
        pytest.skip("this GDAL has no libcurl")


def test_without_a_filter():
    """On a system without one, GDAL is not loaded unless the user says so."""
    hide("dem.vrt", "grid.asc")
    done = run("info", "dem.vrt", no_filters=True)
    assert done.status == 1 and "seccomp" in done.err and "--allow-network" in done.err
    assert run("info", "dem.vrt", "--allow-network", no_filters=True).status == 0 and run("info", "field.npy", no_filters=True).status == 0
