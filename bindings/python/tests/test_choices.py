"""Names of options' values are stated once, in Rust; annotations and docstrings list the same."""

import ast
import re
from pathlib import Path

import pytest

import uvgraft
from uvgraft import _uvgraft

PACKAGE = Path(uvgraft.__file__).parent
CHOICES = _uvgraft.choices()
# Parameters of one name that mean something else.
OTHERS = {
    ("hand_pose", "side"),
    ("hand_mean", "side"),
}
# Arrays of colours; files may hold data, too.
ANY_ENCODING = {"write_image"}
# Not annotated by names alone, or without a name in the choices.
WITHOUT_LITERAL = {"metrics"}


def wanted(function, parameter):
    if parameter == "encoding" and function not in ANY_ENCODING:
        parameter = "color_encoding"
    return set(CHOICES[parameter])


def trees():
    for path in [*PACKAGE.glob("*.py"), *PACKAGE.glob("*.pyi")]:
        yield path, ast.parse(path.read_text())


def aliases():
    """The values of the package's names for literals."""
    found = {}
    for _, tree in trees():
        for node in tree.body:
            target = node.target if isinstance(node, ast.AnnAssign) else None
            target = node.targets[0] if isinstance(node, ast.Assign) else target
            if isinstance(target, ast.Name) and node.value is not None:
                values = literals(node.value, {})
                if values:
                    found[target.id] = values
    return found


def literals(annotation, known):
    """The strings of all literals in an annotation."""
    found = set()
    for node in ast.walk(annotation):
        if isinstance(node, ast.Subscript) and getattr(node.value, "id", None) == "Literal":
            found |= {it.value for it in ast.walk(node.slice) if isinstance(it, ast.Constant)}
        elif isinstance(node, ast.Name):
            found |= known.get(node.id, set())
    return found


def parameters():
    """Functions, their parameters, the literals that annotate these, and their defaults.

    Options that functions share are fields of a class.
    """
    known = aliases()
    for path, tree in trees():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef) and node.name.endswith("Options"):
                for field in node.body:
                    if isinstance(field, ast.AnnAssign):
                        where = f"{path.name}:{field.lineno}"
                        yield (
                            where,
                            node.name,
                            field.target.id,
                            literals(field.annotation, known),
                            None,
                        )
            if not isinstance(node, ast.FunctionDef):
                continue
            given = node.args
            plain = given.posonlyargs + given.args
            plain_defaults = [None] * (len(plain) - len(given.defaults)) + given.defaults
            defaults = [*plain_defaults, *given.kw_defaults]
            for parameter, default in zip(plain + given.kwonlyargs, defaults, strict=True):
                if parameter.annotation is not None:
                    values = literals(parameter.annotation, known)
                    where = f"{path.name}:{parameter.lineno}"
                    yield where, node.name, parameter.arg, values, default


def test_annotations_have_the_names_of_the_compiled_part():
    met = set()
    for where, function, parameter, values, default in parameters():
        if parameter not in CHOICES or not values or (function, parameter) in OTHERS:
            continue
        assert values == wanted(function, parameter), f"{where}: {parameter} of {function}"
        if isinstance(default, ast.Constant) and default.value is not None:
            assert default.value in values, where
        met.add(parameter)
    assert met == set(CHOICES) - {"color_encoding"} - WITHOUT_LITERAL


def docstrings():
    for path in PACKAGE.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                yield node.name, ast.get_docstring(node) or ""
    for name in dir(_uvgraft):
        thing = getattr(_uvgraft, name)
        yield name, getattr(thing, "__doc__", None) or ""
        if isinstance(thing, type):
            for method in vars(thing):
                yield method, getattr(getattr(thing, method), "__doc__", None) or ""


def test_docstrings_have_the_names_of_the_compiled_part():
    count = 0
    for function, text in docstrings():
        for names, values in re.findall(r"^ *([\w, ]+) : \{(.*?)\}", text, re.MULTILINE):
            for parameter in names.split(", "):
                if parameter not in CHOICES or (function, parameter) in OTHERS:
                    continue
                found = set(re.findall(r'"(.*?)"', values))
                assert found == wanted(function, parameter), f"{parameter} of {function}"
                count += 1
    assert count >= 25
    for name in CHOICES["metrics"]:
        assert f'"{name}"' in _uvgraft.compare.__doc__


@pytest.mark.parametrize("value", CHOICES["filter"])
def test_values_that_are_listed_are_taken(value):
    assert f'"{value}"' in str(refusal(lambda: filtered("x")))
    filtered(value)


def filtered(name):
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    uv = [[0.1, 0.1], [0.9, 0.1], [0.1, 0.9]]
    mesh = uvgraft.Mesh(corners, [[0, 1, 2]], uv, uv_origin="top-left")
    return uvgraft.Graft(uvgraft.Pair(mesh, mesh, vertex_map=[0, 1, 2]), filter=name)


def refusal(call):
    with pytest.raises(ValueError, match="must be") as refused:
        call()
    return refused.value
