"""PEP 517 backend: builds the package by CMake and packs what it installs into a wheel.

pip's option --config-settings build-dir=DIR names a build folder that is kept; without it the
build has a temporary folder.
"""

import base64
import hashlib
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


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    with tempfile.TemporaryDirectory() as scratch:
        build = (config_settings or {}).get("build-dir", f"{scratch}/build")
        if not pathlib.Path(build, "CMakeCache.txt").exists():
            subprocess.run(["cmake", "-S", ROOT, "-B", build, "-DCMAKE_BUILD_TYPE=Release",
                            "-DAULA_BUILD_TESTS=OFF", "-DAULA_PYTHON=ON",
                            f"-DPython_EXECUTABLE={sys.executable}"], check=True)
        subprocess.run(["cmake", "--build", build, "--target", "aula_python"], check=True)
        subprocess.run(["cmake", "--install", build, "--component", "python", "--strip",
                        "--prefix", f"{scratch}/prefix"], check=True)

        tag = "cp{0}{1}-cp{0}{1}-".format(*sys.version_info) + \
            re.sub("[-.]", "_", sysconfig.get_platform())
        info = f"aula-{_version()}.dist-info"
        package = pathlib.Path(scratch, "prefix/lib/python3/dist-packages")
        files = {str(path.relative_to(package)): path.read_bytes()
                 for path in sorted(package.rglob("*")) if path.is_file()}
        files[f"{info}/METADATA"] = (
            f"Metadata-Version: 2.1\nName: aula\nVersion: {_version()}\n"
            "Summary: Room acoustics from geometry and materials\nLicense: Apache-2.0\n"
            "Requires-Python: >=3.11\nRequires-Dist: numpy\n").encode()
        files[f"{info}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: aula\n"
                                  f"Root-Is-Purelib: false\nTag: {tag}\n").encode()
        for name in ("LICENSE", "cmake/debian/copyright"):
            path = ROOT / name
            files[f"{info}/{path.name}"] = path.read_bytes()
        record = "".join(
            f"{name},sha256={_digest(data)},"
            f"{len(data)}\n" for name, data in files.items())
        files[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
        wheel = f"aula-{_version()}-{tag}.whl"
        with zipfile.ZipFile(pathlib.Path(wheel_directory, wheel), "w",
                             zipfile.ZIP_DEFLATED) as archive:
            for name, data in files.items():
                archive.writestr(name, data)
        return wheel
