"""Arrays of any shape, strides and dtype: a result or an exception, never a crash."""

import contextlib

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

import uvgraft

ACCEPTED = (TypeError, ValueError, OverflowError, uvgraft.Error)
SETTINGS = settings(
    max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@st.composite
def arrays(draw):
    """Arrays of small sizes with odd strides."""
    dtypes = st.one_of(
        st.sampled_from([np.dtype(kind) for kind in ("u1", "u2", "f4", "?")]),
        npst.scalar_dtypes(),
    )
    shape = draw(npst.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=9))
    array = draw(npst.arrays(draw(dtypes), shape, fill=st.nothing()) if draw(st.booleans())
                 else st.builds(np.zeros, st.just(shape), dtypes))  # fmt: skip
    how = draw(
        st.sampled_from(["plain", "transposed", "reversed", "strided", "broadcast", "locked"])
    )
    if how == "transposed":
        array = array.T
    elif how == "reversed" and array.ndim:
        array = array[::-1]
    elif how == "strided" and array.ndim:
        array = array[::2]
    elif how == "broadcast":
        array = np.broadcast_to(array, (3, *array.shape))
    elif how == "locked":
        array.flags.writeable = False
    return array


@SETTINGS
@given(texture=arrays(), base=arrays(), out=st.one_of(st.none(), arrays()))
def test_transfers(pair, texture, base, out):
    graft = uvgraft.Graft(pair, gutter=2)
    try:
        result = graft.apply(texture, base, out=out)
    except ACCEPTED:
        return
    # Four axes are several.
    wanted = base.shape[1:3] if base.ndim == 4 else base.shape[:2]
    found = result.shape[1:3] if texture.ndim == 4 else result.shape[:2]
    assert found == wanted
    assert out is None or result is out


@SETTINGS
@given(texture=arrays(), mask=arrays())
def test_regions(pair, texture, mask):
    try:
        graft = uvgraft.Graft(pair, region=uvgraft.Region.mask(mask), size=8, content="data")
        graft.apply(texture)
    except ACCEPTED:
        pass


@SETTINGS
@given(positions=arrays(), faces=arrays(), uv=arrays())
def test_meshes(positions, faces, uv):
    try:
        mesh = uvgraft.Mesh(positions, faces, uv, uv_origin="top-left")
        uvgraft.Pair(mesh, mesh)
    except ACCEPTED:
        pass


@SETTINGS
@given(values=arrays())
def test_operators(pair, values):
    operator = uvgraft.Graft(pair, size=8).operator(source_size=8)
    for method in (operator.forward, operator.adjoint, operator._forward_planes):
        with contextlib.suppress(ACCEPTED):
            assert method(values).dtype == np.float32


@SETTINGS
@given(data=st.binary(max_size=200))
def test_encoded_files(data):
    for parse in (uvgraft.Pair.from_bytes,):
        with contextlib.suppress(ACCEPTED):
            parse(data)
