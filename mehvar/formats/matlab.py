# SPDX-License-Identifier: Apache-2.0
"""MAT-files of version 7.3, which are HDF5 files without the 2 GB limit of version 5."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import numpy as np

_HEADER = b"MATLAB 7.3 MAT-file, written by mehvar".ljust(116) + bytes(8) + b"\0\2IM"
_BLOCK = 512
"""Number of bytes before the HDF5 contents, which hold the header."""
_CLASSES = {"f8": "double", "f4": "single", "b1": "logical"}
"""MATLAB classes by NumPy type, except integers, whose names agree."""


def matlab73(values: Mapping[str, Any]) -> bytes:
    """Return a MAT-file of named numbers, arrays, texts, lists of texts and mappings."""
    import h5py

    content = io.BytesIO()
    with h5py.File(content, "w", userblock_size=_BLOCK) as file:
        _fill(file, values)
    return _HEADER.ljust(_BLOCK, b"\0") + content.getvalue()[_BLOCK:]


def _fill(group: Any, values: Mapping[str, Any]) -> None:
    """Write values to a group as MATLAB does: mappings as structs, arrays transposed, empty arrays as their shape."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            place, kind = group.create_group(name), "struct"
            _fill(place, value)
        else:
            array, kind = _matrix(value)
            place = group.create_dataset(name, data=array.T if array.size else np.array(array.shape, dtype="u8"))
            place.attrs.update({"MATLAB_empty": np.uint8(1)} if not array.size else {})
            place.attrs.update({"MATLAB_int_decode": np.int32(array.itemsize)} if kind in ("char", "logical") else {})
        place.attrs["MATLAB_class"] = np.bytes_(kind)


def _matrix(value: Any) -> tuple[np.ndarray[Any, Any], str]:
    """Return a value as a two-dimensional array with its MATLAB class; vectors are columns, texts rows."""
    array = np.asarray(value)
    if array.dtype.kind in "US":
        texts = np.atleast_1d(array).astype("U")
        letters = texts.view("u4").reshape(len(texts), -1)[:, : max(map(len, texts))]
        return np.where(letters == 0, ord(" "), letters).astype("u2"), "char"
    array = array.reshape(-1, 1) if array.ndim < 2 else array
    kind = _CLASSES.get(array.dtype.str[1:], array.dtype.name)
    return array.astype("u1") if kind == "logical" else array, kind
