"""PEP 517 backend: builds the package by CMake and packs what it installs into a wheel.

pip's option --config-settings build-dir=DIR names a build folder that is kept; without it the
build has a temporary folder. python-headers=DIR, such as /usr/include/python3.14, makes a wheel for
the version of these headers, not for that of the interpreter.
"""

import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def _version():
    return re.search(r"project\(aula VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]


def _digest(data):
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def pack(package, wheel):
    """Writes the files below a folder, and their list, into a wheel."""
    record = next(package.glob("*.dist-info")) / "RECORD"
    record.unlink(missing_ok=True)
    files = [path for path in sorted(package.rglob("*")) if path.is_file()]
    digests = ((path.relative_to(package), path.read_bytes()) for path in files)
    record.write_text("".join(f"{name},sha256={_digest(data)},{len(data)}\n"
                              for name, data in digests) + f"{record.relative_to(package)},,\n")
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in [*files, record]:
            archive.write(path, path.relative_to(package))


def _configure(build, headers):
    """With the pybind11 that pip has installed for the build, else with the system's."""
    try:
        import pybind11
        where = [f"-Dpybind11_DIR={pybind11.get_cmake_dir()}"]
    except ImportError:
        where = []
    subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DAULA_BUILD_TESTS=OFF", "-DAULA_PYTHON=ON",
                    f"-DAULA_PYTHON_HEADERS={headers}", f"-DPython_EXECUTABLE={sys.executable}",
                    *where], check=True)


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Without a build."""
    name = f"aula-{_version()}.dist-info"
    info = pathlib.Path(metadata_directory, name)
    info.mkdir()
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: aula\nVersion: {_version()}\n"
        "Summary: Room acoustics from geometry and materials\nLicense: Apache-2.0\n"
        "Requires-Python: >=3.11\nRequires-Dist: numpy\n")
    for file in ("LICENSE", "cmake/debian/copyright"):
        (info / pathlib.Path(file).name).write_bytes((ROOT / file).read_bytes())
    return name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    with tempfile.TemporaryDirectory() as scratch:
        settings = config_settings or {}
        build = settings.get("build-dir", f"{scratch}/build")
        headers = settings.get("python-headers", "")
        if headers or not pathlib.Path(build, "CMakeCache.txt").exists():
            _configure(build, headers)
        subprocess.run(["cmake", "--build", build, "--target", "aula_python",
                        "--parallel", str(len(os.sched_getaffinity(0)))], check=True)
        subprocess.run(["cmake", "--install", build, "--component", "python", "--strip",
                        "--prefix", f"{scratch}/prefix"], check=True)

        version = "{0}.{1}".format(*sys.version_info)
        if headers:
            version = pathlib.Path(headers).name.removeprefix("python")
        python = "cp" + version.replace(".", "")
        tag = f"{python}-{python}-" + re.sub("[-.]", "_", sysconfig.get_platform())
        package = pathlib.Path(scratch, "prefix/lib/python3/dist-packages")
        info = prepare_metadata_for_build_wheel(package)
        (package / info / "WHEEL").write_text(
            f"Wheel-Version: 1.0\nGenerator: aula\nRoot-Is-Purelib: false\nTag: {tag}\n")
        wheel = f"aula-{_version()}-{tag}.whl"
        pack(package, pathlib.Path(wheel_directory, wheel))
        return wheel
