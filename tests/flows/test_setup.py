"""`deploy/setup.sh` where it cannot go on: one sentence that names what to install."""

import os
import subprocess
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "deploy" / "setup.sh"
WITHOUT_VENV = '#!/bin/sh\ncase "$2" in *ensurepip*) exit 1;; esac\nexec python3 "$@"\n'


def setup(folder: Path, python: str) -> "subprocess.CompletedProcess[str]":
    environment = os.environ | {"PYTHON": python, "PATH": f"{folder}:{os.environ['PATH']}"}
    return subprocess.run(
        ["bash", str(SCRIPT)], cwd=folder, env=environment, capture_output=True, text=True,
        timeout=600,
    )  # fmt: skip


def put(folder: Path, name: str, text: str) -> None:
    (folder / name).write_text(text)
    (folder / name).chmod(0o755)


def test_missing_venv_without_sudo_names_the_package(tmp_path):
    put(tmp_path, "python3.12", WITHOUT_VENV)
    put(tmp_path, "id", "#!/bin/sh\necho 1000\n")
    put(tmp_path, "sudo", "#!/bin/sh\nexit 1\n")
    done = setup(tmp_path, "python3.12")
    assert done.returncode == 1
    assert "install the package python3.12-venv as root" in done.stderr
    assert done.stderr.count("\n") == 1


def test_old_or_missing_python_is_one_sentence(tmp_path):
    put(tmp_path, "python3", "#!/bin/sh\nexit 1\n")
    done = setup(tmp_path, "python3")
    assert done.returncode == 1
    assert "Python 3.11 or newer" in done.stderr
    assert done.stderr.count("\n") == 1
