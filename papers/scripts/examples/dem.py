# SPDX-License-Identifier: Apache-2.0
"""A real elevation model: 344 x 403 samples of the Jacksboro fault in Tennessee, part of matplotlib."""
import cellwalk as cw
import matplotlib
import numpy as np


def field():
    dem = np.load(matplotlib.get_data_path() + "/sample_data/jacksboro_fault_dem.npz")
    return cw.Field(dem["elevation"], transform=(dem["dx"], 0, dem["xmin"], 0, -dem["dy"], dem["ymin"]), crs="EPSG:4326")


def show(pictures, titles, path, **how):
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(1, len(pictures), figsize=(5 * len(pictures), 4.5), constrained_layout=True, squeeze=False)
    for axis, picture, title in zip(axes[0], pictures, titles):
        axis.set_title(title)
        figure.colorbar(axis.imshow(picture, **{"extent": (-84.414, -84.078, 36.446, 36.733), "aspect": 1.24, **how}), ax=axis)
    figure.savefig(path, dpi=80)
