# SPDX-License-Identifier: Apache-2.0
"""GeoTIFF and the like: what other programs write is read as heights at the right places, and what is written they find again."""
import os
import subprocess

import numpy as np
import pytest
import rasterio
from program import PROGRAM, entries, on_map, read, vrt, write
from rasterio.transform import Affine

NX, NY, UTM = 5, 4, Affine(10, 0, 600000, 0, -10, 5200000)


def values(band=1, ny=NY, nx=NX):
    return 100.0 * band + np.arange(ny * nx).reshape(ny, nx)


def tif(name="a.tif", z=None, bands=1, dtype="float32", crs="EPSG:32632", transform=UTM, scale=None, offset=None, unit=None, point=None,
        mask=None, **more):
    """A GeoTIFF of values 10 m apart."""
    z = [values(band) for band in range(1, bands + 1)] if z is None else [z]
    with rasterio.Env(GDAL_TIFF_INTERNAL_MASK=True), rasterio.open(
            name, "w", driver="GTiff", width=z[0].shape[1], height=z[0].shape[0], count=bands, dtype=dtype, crs=crs, transform=transform,
            **more) as file:
        if point:
            file.update_tags(AREA_OR_POINT=point)
        if scale:
            file.scales, file.offsets = [scale], [offset]
        if unit:
            file.units = [unit]
        for band, one in enumerate(z, 1):
            file.write(one.astype(dtype), band)
        if mask is not None:
            file.write_mask(mask)
    return name


def test_samples_stand_at_pixel_centres(files):
    for point in None, "Point":
        found = files.raster(tif(point=point))
        assert (found.z == values()).all() and found.map.tolist() == [[10, 0, 0, 600005], [0, -10, 0, 5199995], [0, 0, 1, 0]]
        assert (found.placed, found.geographic, found.unit, found.name) == (1, 0, 1, "WGS 84 / UTM zone 32N")
    found = files.raster(tif(transform=Affine(3, 4, 1000, 4, -3, 2000), crs=None))
    assert found.map.tolist() == [[3, 4, 0, 1003.5], [4, -3, 0, 2000.5], [0, 0, 1, 0]] and (found.placed, found.name, found.unit) == (1, "", 0)


@pytest.mark.parametrize("scale, offset", [(None, None), (0.25, 83)])
@pytest.mark.parametrize("dtype", ["uint8", "uint16", "int16", "uint32", "int32", "float32", "float64"])
def test_values_become_heights(files, dtype, scale, offset):
    found = files.raster(tif(dtype=dtype, nodata=107, scale=scale, offset=offset), nodata=(109, 108))  # the file's numbers; some heights are 108, too
    wanted = values() * (scale or 1) + (offset or 0)
    wanted.flat[7:10] = np.nan
    np.testing.assert_array_equal(found.z, wanted)
    assert found.has_nodata == 1


def test_masks_and_the_lowest_float_are_no_data(files):
    """Headers have the lowest float with more digits than a float has."""
    z = values()
    z[1, 1] = lowest = -3.4028234663852886e38
    found = files.raster(tif(z=z, nodata=lowest))
    assert np.argwhere(np.isnan(found.z)).tolist() == [[1, 1]]
    mask = np.full((NY, NX), 255, "u1")
    mask[:, 2] = 0
    assert (np.isnan(files.raster(tif(mask=mask)).z) == (mask == 0)).all()


@pytest.mark.parametrize("head", ["xllcorner 100\nyllcorner 200\ncellsize 10", "XLLCENTER 105\nYLLCENTER 205\nCELLSIZE 10",
                                  "xllcorner 100\nyllcorner 200\ndx 10\ndy 10"])
def test_ascii_grids(files, head):
    """The first sample, of the northern row, is a pixel's centre. Fractions may come behind however many whole numbers."""
    side = 300
    text = f"ncols {side}\nnrows {side}\n{head}\nNODATA_value -9999\n-9999 " + "".join(f"{k % 9 + 1} " for k in range(1, side * side - 1))
    write("a.asc", text + "1.25e1\n")
    found = files.raster("a.asc")
    assert found.map.tolist() == [[10, 0, 0, 105], [0, -10, 0, 195 + 10 * side], [0, 0, 1, 0]]
    assert np.isnan(found.z[0, 0]) and found.z[0, 1] == 2 and found.z[-1, -1] == 12.5
    write("a.asc", text + "1e99\n")
    files.raster_refused("beyond the range of float", "a.asc")
    write("a.asc", text[:len(text) // 2])
    files.raster_refused("cannot read", "a.asc")


def test_bands_are_chosen(files):
    tif(bands=3)
    found = files.raster("a.tif", band=2)
    assert (found.z == values(2)).all() and not found.warnings
    found = files.raster("a.tif")
    assert (found.z == values()).all() and "has 3 bands" in found.warnings[0]
    files.raster_refused("3 bands, not 4", "a.tif", band=4)
    files.raster_refused("complex", tif(dtype="complex64"))


DEGREE, SURVEY = 0.017453292519943295, 1200 / 3937


@pytest.mark.parametrize("crs, unit, zscale, metres, map_unit", [
    ("EPSG:32632", "m", 1, 1, 1),
    ("EPSG:32632", "ft", 0.3048, 0.3048, 1),
    ("EPSG:2263", "US survey foot", 1, SURVEY, SURVEY),
    ("EPSG:2263", None, 1, 0, SURVEY),
    ("EPSG:2263", "metre", 1 / SURVEY, 1, SURVEY),
    ("EPSG:4326", "Foot", 0.3048, 0.3048, DEGREE),
    ("EPSG:4326", None, 1, 0, DEGREE),
    (None, "ft", 0.3048, 0.3048, 0), (None, "m", 1, 1, 0),  # x and y are taken as metres
    ("EPSG:26918+6360", None, SURVEY, SURVEY, 1)])  # heights in feet, as a compound system says
def test_units_are_known(files, crs, unit, zscale, metres, map_unit):
    found = files.raster(tif(crs=crs, unit=unit))
    np.testing.assert_allclose([found.map[2, 2], found.height_unit, found.unit], [zscale, metres, map_unit], atol=1e-12)
    assert found.geographic == (map_unit == DEGREE)
    if map_unit == DEGREE:
        np.testing.assert_allclose(found.ellipsoid, [6378137, 298.257223563], rtol=1e-12)


def test_units_of_other_formats(files):
    """A GeoTIFF passes the vertical unit of its system off as the band's; other formats do not."""
    tif(crs="EPSG:26918+6360")
    vrt("a.vrt", "a.tif", (NY, NX), on_map("26918+6360", 0, 1, 0, 0, 0, -1))
    found = files.raster("a.vrt")
    assert abs(found.map[2, 2] - SURVEY) < 1e-12 and (found.z == values()).all()


def test_what_smells_is_said(files):
    assert "'fathom'" in files.raster(tif(unit="fathom")).warnings[0]
    assert "counts depths" in files.raster(tif(crs="EPSG:32632+5715")).warnings[0]
    found = files.raster(tif(unit="fathom"), zscale=1.8288)
    assert found.map[2, 2] == 1.8288 and not found.warnings
    files.raster_refused("the file gives the distance", "a.tif", zscale=1.8288, cellsize=5)
    z = values()
    z[1, 1] = -32768
    found = files.raster(tif(z=z, dtype="int16"))
    assert found.z[1, 1] == -32768 and "1 samples are -32768" in found.warnings[0] and "--nodata -32768" in found.warnings[0]
    found = files.raster("a.tif", nodata=(-32768,))
    assert np.isnan(found.z[1, 1]) and not found.warnings
    assert "looks like degrees" in files.raster(tif(crs=None, transform=Affine(0.001, 0, 7, 0, -0.001, 46))).warnings[0]


def test_large_files_come_in_pieces(files):
    z = values(1, 2000, 2000)
    tif(z=z, dtype="float64", tiled=True)
    assert (files.raster("a.tif").z == z.astype("f4")).all()
    files.raster_refused("interrupted", "a.tif", stop=1)
    write("short.tif", read("a.tif")[:os.path.getsize("a.tif") // 2])
    files.raster_refused("", "short.tif")
    write("text.tif", "no picture at all")
    files.raster_refused("cannot read", "text.tif")
    files.raster_refused("No such file", "absent.tif")


def test_a_real_terrain(files):
    """The grid of Luxembourg that Debian's r-cran-terra has in its examples."""
    real = "/usr/lib/R/site-library/terra/ex/elev.tif"
    if not os.path.exists(real):
        pytest.skip(f"{real} (Debian: r-cran-terra) is not there")
    found = files.raster(real)
    assert found.z.shape == (90, 95) and found.geographic == 1 and np.isnan(found.z).sum() == 3942
    assert (np.nanmin(found.z), np.nanmax(found.z)) == (141, 547) and 5.7 < found.map[0, 3] < 5.8 and 50.1 < found.map[1, 3] < 50.2


# ---- what is written ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name, words, compression", [
    ("o.tif", [], "deflate"), ("o.tif", ["--co=COMPRESS=ZSTD"], "zstd"), ("o.TIFF", ["--co=COMPRESS=NONE"], None),
    ("o.tif", ["--cog"], "deflate"), ("o.tif", ["--cog", "--co=BLOCKSIZE=128", "--co=COMPRESS=LZW", "--co=PREDICTOR=NO"], "lzw")])
def test_results_are_whole(name, words, compression):
    """A COG has smaller copies; it is made beside scratch files, which go."""
    tif("dem.tif", z=values(ny=300, nx=300) * 7919 % 23)
    for out, more in ("o.npy", []), (name, words):
        subprocess.run([PROGRAM, "horizon", "dem.tif", "--directions", "2", *more, "-o", out], check=True)
    assert entries() == sorted(["dem.tif", "o.npy", name])
    with rasterio.open(name) as file:
        assert file.transform == UTM and file.crs.to_epsg() == 32632 and np.isnan(file.nodata)
        np.testing.assert_array_equal(file.read(), np.load("o.npy"))
        assert file.units == ("degree",) * 2 and file.descriptions == ("azimuth 0", "azimuth 180") and file.tags()["DIRECTIONS"] == "2"
        layout = file.tags(ns="IMAGE_STRUCTURE")
        assert (layout.get("COMPRESSION") or "none").lower() == (compression or "none")
        assert (layout.get("LAYOUT") == "COG") == ("--cog" in words) and len(file.overviews(2)) == (2 if "--co=BLOCKSIZE=128" in words else 0)
        if "--cog" not in words:
            assert file.block_shapes[0] == (160, 160)  # twice that is more than 300, by less than two tiles of 256 are


@pytest.mark.parametrize("side, magic", [(1000, "42"), (40000, "43")])
def test_large_files_are_bigtiff(files, side, magic):
    """What may grow beyond 4 GB has the large header from the beginning. GDAL would fill in what is not written."""
    write("cells", bytes(4 * 256 * side))
    assert files("raster write", "large.tif", f"nx={side} ny={side} sparse=1") == magic and entries() == ["cells"]


def test_missing_rows_leave_nothing(files):
    for name, cell, more in ("less.png", 3, ""), ("less.npy", 4, ""), ("less.tif", 4, ""), ("less.tif", 4, " cog=1"):
        write("cells", bytes(cell * NX * (NY - 1)))
        files.refused("missing", "raster write", name, f"nx={NX} ny={NY}{more}")
    assert entries() == ["cells"]


def test_pictures(files):
    """Three bytes a pixel are its colours. A terrain with a map has a world file, which appears and fails with the picture."""
    turned, cells, words = Affine(3, 4, 1000, 4, -3, 2000), (7 * np.arange(3 * NX * NY)).astype("u1"), f"nx={NX} ny={NY}"
    files.raster(tif(transform=turned))
    cells.tofile("cells")
    files("raster write", "out.png", words)
    with rasterio.open("out.png") as file:
        assert file.transform == turned and (np.moveaxis(file.read(), 0, 2).ravel() == cells).all()
    files.refused("", "can write", "out.png", 2)
    files.refused(".tif", "can write", "out.gif", 1)
    write("out.pgw", "old")
    before = entries()
    write("cells", bytes(3 * NX))  # rows that are missing leave what was there
    files.refused("missing", "raster write", "out.png", words)
    assert read("out.pgw") == b"old"
    os.mkdir("no.pgw")  # is an error from the beginning on, and there is no picture
    files.refused("no.pgw", "raster write", "no.png", words)
    assert entries() == sorted([*before, "no.pgw"])
