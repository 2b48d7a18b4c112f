"""Reads a run file with h5py alone: unit, description, frame on every dataset; one length; attributes are str."""
import sys

import h5py

path, frames = sys.argv[1], int(sys.argv[2])
with h5py.File(path, "r") as f:
    for key in ("kind", "scenario", "title", "terrain", "version", "format"):
        assert isinstance(f.attrs[key], str), key
    assert int(f.attrs["seed"]) == -7
    assert "\u00e4" in f.attrs["scenario"]
    for name, data in f.items():
        for key in ("unit", "description", "frame"):
            assert isinstance(data.attrs[key], str), (name, key)
        values = data[...]
        assert values.dtype == "float64", name
        if data.maxshape[0] is None:
            assert values.shape[0] == frames, (name, values.shape)
    assert f["time"].attrs["unit"] == "s"
    assert f["time"][frames - 1] == 0.01 * (frames - 1)
    assert f["wheel.force"].shape == (frames, 3)
    assert f["wheel.force"][17, 2] == 1000 + 17 + 0.25
    assert f["ground.x"].shape == (3,)
