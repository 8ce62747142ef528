"""Makes the samples in this folder. Run once with each Python, from this folder:

    python2.7 make.py   # with numpy 1.16, scipy 1.2, chumpy 0.67.6: as used to pickle body models
    python3 make.py     # with numpy 2.4, scipy 1.17, torch 2.x

All values are invented. The tests read the files and need neither Python.
"""

import pickle
import sys
from collections import OrderedDict

import numpy as np
from scipy import sparse


def regressor():
    """[[0, 0.5, 0, 0.5], [1, 0, 0, 0]], in doubles."""
    return np.array([[0, 0.5, 0, 0.5], [1, 0, 0, 0]])


def by_python_2():
    """A tiny model, in the form of SMPL's, MANO's and FLAME's files."""
    import cPickle
    import chumpy

    directions = chumpy.array(np.arange(12.0).reshape(2, 3, 2) / 4)
    model = {
        "v_template": np.arange(6.0).reshape(2, 3),
        "shapedirs": directions,
        "first_direction": directions[:, :, :1],
        "J_regressor": sparse.csc_matrix(regressor()),
        "f": np.array([[0, 1, 2], [2, 1, 0]], dtype=np.uint32),
        "kintree_table": np.array([[4294967295, 0], [0, 1]], dtype=np.uint32),
        "bs_type": "lrotmin",
    }
    for protocol in 0, 2:
        with open("python2_protocol%d.pkl" % protocol, "wb") as file:
            cPickle.dump(model, file, protocol)


def by_python_3():
    import torch

    class Ch:
        """Stands in for chumpy, which has no release for this Python; its arrays keep their values in `x`."""

    Ch.__module__, Ch.__qualname__ = "chumpy.ch", "Ch"
    modules = {"chumpy": type(sys)("chumpy"), "chumpy.ch": type(sys)("chumpy.ch")}
    modules["chumpy.ch"].Ch = Ch
    sys.modules.update(modules)
    directions = Ch()
    directions.x = np.arange(12.0, dtype=np.float32).reshape(2, 3, 2) / 4
    directions._dirty_vars = {"x"}
    with open("python3_protocol4.pkl", "wb") as file:
        model = OrderedDict(
            shapedirs=directions,
            csc=sparse.csc_matrix(regressor()),
            csr=sparse.csr_matrix(regressor().astype(np.float32)),
            coo=sparse.coo_array(regressor()),
            gender=np.array("female"),
            rows=[[1, 2], [3, 4]],
            frames={"rate": 30.0, "count": np.int64(7)},
        )
        pickle.dump(model, file, 4)

    object_array = np.empty((), dtype=object)
    object_array[()] = sparse.csc_matrix(regressor())
    np.savez_compressed(
        "deflated.npz",
        v_template=np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        half=np.array([1, 0.5, -2, 6e-8, np.inf], dtype=np.float16),
        big=np.array([[1.5, -2.5]], dtype=">f4"),
        f=np.array([[0, 1, 2]], dtype=np.uint32),
        kintree_table=np.array([[4294967295, 0], [0, 1]], dtype=np.uint32),
        hidden=np.array([True, False]),
        gender=np.array("neutral"),
        gender_bytes=np.array(b"male"),
        mocap_framerate=np.array(120.0),
        J_regressor=object_array,
        joint2num=np.array({"Pelvis": 0}, dtype=object),
        when=np.array("2020-01-01", dtype="datetime64[D]"),
    )

    base = torch.arange(6, dtype=torch.float32).reshape(2, 3)
    tensors = OrderedDict(
        plain=base,
        turned=base.t(),
        column=base[:, 1],
        parameter=torch.nn.Parameter(torch.tensor([0.25])),
        half=torch.tensor([1.5, -2], dtype=torch.float16),
        brain=torch.tensor([1.5, -2], dtype=torch.bfloat16),
        double=torch.tensor(0.1, dtype=torch.float64),
        long=torch.tensor([-1, 1 << 40]),
        bytes=torch.tensor([255], dtype=torch.uint8),
        bools=torch.tensor([True, False]),
        layer={"weight": torch.tensor([3], dtype=torch.int32)},
        epoch=7,
    )
    torch.save(tensors, "tensors.pth")
    torch.save(base, "bare.pth")
    torch.save(base, "before_1_6.pth", _use_new_zipfile_serialization=False)
    torch.jit.save(torch.jit.script(torch.nn.Identity()), "script.pt")

    # A dump of 8x8 texels, whose colours are a slice of a larger output, as in FATE.
    output = torch.zeros(1, 11, 8, 8)
    u, v = torch.meshgrid(torch.arange(8) / 7, torch.arange(8) / 7, indexing="xy")
    for channel, value in enumerate([0.1 + 0.8 * u, 0.1 + 0.8 * v, torch.full((8, 8), 0.5)]):
        output[0, channel] = torch.atanh(2 * value - 1)
    output[0, 3] = torch.logit(0.2 + 0.6 * u)
    output = (output * torch.ones(1, requires_grad=True)).requires_grad_()
    slices = {"color": slice(0, 3), "opacity": slice(3, 4), "offset": slice(10, 11)}
    dump = {name: output[:, channels] for name, channels in slices.items()}
    torch.save(dump, "fate_tex_dump.pth")


by_python_2() if sys.version_info[0] == 2 else by_python_3()
