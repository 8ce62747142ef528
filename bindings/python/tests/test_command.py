"""The command that the package holds."""

import shutil
import subprocess
import sysconfig

import pytest
from scenes import command

import uvgraft


def test_a_report():
    assert command("render", "--help").stdout.startswith("Render an avatar")


def test_the_script_and_the_module_are_one_program():
    script = shutil.which("uvgraft", path=sysconfig.get_path("scripts"))
    done = subprocess.run([script, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"uvgraft {uvgraft.__version__}\n"
    assert command("--version").stdout == done.stdout


def test_modules_in_the_working_directory_do_not_replace_the_package(tmp_path, monkeypatch):
    (tmp_path / "random.py").write_text("raise SystemExit(99)")
    (tmp_path / "uvgraft.py").write_text("raise SystemExit(99)")
    monkeypatch.chdir(tmp_path)
    script = shutil.which("uvgraft", path=sysconfig.get_path("scripts"))
    assert subprocess.run([script, "--version"], capture_output=True, check=False).returncode == 0


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["render", "none.glb", "-o", "a.png"], 2, "none.glb: No such file"),
        (["render", "none.glb", "-o", "a.png", "--zoom=0"], 2, "'--zoom <FACTOR>': must be 0.1"),
        (["avatar", "--help"], 0, ""),
    ],
)
def test_exit_codes(arguments, code, message):
    done = command(*arguments, check=False)
    assert (done.returncode, message in done.stderr) == (code, True), done.stderr
