"""Resolves every data item of an XDMF 2.0 file against the HDF5 file that it names, and checks extents."""
import os
import sys
import xml.etree.ElementTree as ET

import h5py
import numpy as np

path, frames = sys.argv[1], int(sys.argv[2])
folder = os.path.dirname(path)
files = {}


def dims_of(item):
    return [int(x) for x in item.get("Dimensions").split()]


def load(item):
    """Values of a DataItem as its reader would see them."""
    dims = dims_of(item)
    if item.get("ItemType") == "HyperSlab":
        selection, source = item
        start, stride, count = np.array(selection.text.split(), int).reshape(dims_of(selection))
        data = load(source)
        assert data.ndim == len(start), item.attrib
        assert all(start + (count - 1) * stride < data.shape), (start, count, data.shape)
        data = data[tuple(slice(a, a + s * n, s) for a, s, n in zip(start, stride, count))]
        assert list(data.shape) == dims, (data.shape, dims)
        return data
    if item.get("Format") == "XML":
        return np.array(item.text.split(), float).reshape(dims)
    name, dataset = item.text.strip().split(":")
    file = files.setdefault(name, h5py.File(os.path.join(folder, name), "r"))
    data = file[dataset][...]
    assert item.get("Precision") == str(data.dtype.itemsize)
    assert data.size == np.prod(dims), (dataset, data.shape, dims)
    return data.reshape(dims)


root = ET.parse(path).getroot()
assert root.get("Version") == "2.0"
(collection,) = root.findall("Domain/Grid")
assert collection.get("CollectionType") == "Temporal"
steps = collection.findall("Grid")
assert len(steps) == frames, len(steps)
for i, step in enumerate(steps):
    assert float(step.find("Time").get("Value")) == 0.005 * i
    grids = {g.get("Name"): g for g in step.findall("Grid")}
    assert set(grids) == {"chassis", "front", "ground"}, set(grids)
    for name in ("chassis", "front"):
        assert load(grids[name].find("Geometry/DataItem")).tolist() == [[0.5 * i, 1, 2]]
    values = {a.get("Name"): load(a.find("DataItem")) for a in grids["front"].findall("Attribute")}
    assert values["force [N]"].tolist() == [[i, 0, 100]]
    assert values["sinkage [m]"].tolist() == [0.001 * i]
    x, y, z = (load(d) for d in grids["ground"].findall("Geometry/DataItem"))
    shape = [int(n) for n in grids["ground"].find("Topology").get("Dimensions").split()]
    assert shape == [z.size, y.size, x.size], shape
    height = load(grids["ground"].find("Attribute/DataItem"))
    assert height[0, 2, 3] == 23 and list(height.shape) == shape
