"""Runs a script with packages of PyPI: environment.py FOLDER PACKAGE... -- SCRIPT [ARGUMENT...]

The virtual environment FOLDER is made once and kept as long as the packages are the same. Exit
status 77, with the reason, if they cannot be installed.
"""

import fcntl
import os
import pathlib
import subprocess
import sys

LIMIT_S = 300  # a registry that does not answer


def prepared(folder, packages):
    """Installs the packages, unless they are there; the error of pip, or None."""
    marker = folder / "packages.txt"
    if marker.exists() and marker.read_text().split() == packages:
        return None
    subprocess.run([sys.executable, "-m", "venv", "--clear", folder], check=True)
    try:
        pip = subprocess.run([folder / "bin/pip", "install", "--quiet", "--retries", "1", "--only-binary",
                              ":all:", *packages], capture_output=True, text=True, timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        return f"pip has not ended after {LIMIT_S} s"
    if pip.returncode:
        return (pip.stderr.strip().splitlines() or [f"pip: exit status {pip.returncode}"])[-1]
    marker.write_text("\n".join(packages))
    return None


def main(folder, arguments):
    end = arguments.index("--")
    folder.parent.mkdir(parents=True, exist_ok=True)
    with open(f"{folder}.lock", "w") as lock:  # tests run at the same time
        fcntl.flock(lock, fcntl.LOCK_EX)
        error = prepared(folder, arguments[:end])
    if error:
        print(f"skipped: {error}")
        return 77
    python = folder / "bin/python"
    os.execv(python, [python, *arguments[end + 1:]])


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]), sys.argv[2:]))
