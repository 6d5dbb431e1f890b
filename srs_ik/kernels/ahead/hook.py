"""Where Hatchling has the kernels compiled: into every wheel, but for editable installs, which Numba compiles for.

They are for the kind of processor that builds. SRS_IK_BUILD=portable makes a wheel for all kinds, to be handed on;
SRS_IK_BUILD=pure one without compiled kernels, which brings Numba. So does a build for this machine alone where nothing
can be compiled; a portable one ends there, as installers do not show its warning to who hands it on.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

NUMBA = "numba>=0.62,<0.69"
ZIG = "ziglang>=0.13"


def _asked() -> str:
    """What SRS_IK_BUILD asks for; raises ValueError for what it does not know."""
    asked = os.environ.get("SRS_IK_BUILD", "")
    if asked not in ("", "portable", "pure"):
        raise ValueError(f"SRS_IK_BUILD is portable or pure, not {asked}")
    return asked


def _platform() -> str:
    """The systems that compiled kernels are for, as tags of wheels name them."""
    if platform.system() != "Darwin":
        return sysconfig.get_platform().replace("-", "_").replace(".", "_")
    # Python itself may be for several processors and for older systems; what is compiled here is not.
    major, minor = [*platform.mac_ver()[0].split("."), "0"][:2]
    return f"macosx_{major}_{minor if major == '10' else 0}_{platform.machine()}"


def _has_compiler() -> bool:
    return any(map(shutil.which, ("cc", "gcc", "clang"))) or bool(os.environ.get("CC"))


class CompiledKernels(BuildHookInterface):
    """Puts compiled kernels into a wheel."""

    def dependencies(self) -> list[str]:
        """What compiling needs: a C compiler from the package index where the machine has none."""
        if _asked() == "pure":
            return []
        return [NUMBA] if _has_compiler() else [NUMBA, ZIG]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and say what the wheel is then."""
        reason = "an editable install"
        if version != "editable":
            reason = self._compile(build_data)
            if not reason:
                return
            if _asked() == "portable":
                raise RuntimeError(f"no portable wheel: {reason}; SRS_IK_BUILD=pure makes one that needs Numba to run")
            self.app.display_warning(f"srs_ik: no compiled kernels in this wheel, which needs Numba to run: {reason}")
        build_data["dependencies"].append(NUMBA)

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Leave nothing behind."""
        shutil.rmtree(build_data.get("srs_ik_scratch", ""), ignore_errors=True)

    def _compile(self, build_data: dict[str, Any]) -> str:
        """Compile; why not, in words, if that fails."""
        if _asked() == "pure":
            return "SRS_IK_BUILD=pure"
        if importlib.util.find_spec("numba") is None:
            return "no Numba to compile them"
        scratch = Path(tempfile.mkdtemp())
        build_data["srs_ik_scratch"] = str(scratch)
        # The order of sets must not change what is made.
        sources = os.pathsep.join(filter(None, (self.root, os.environ.get("PYTHONPATH"))))
        environment = {**os.environ, "PYTHONPATH": sources, "PYTHONHASHSEED": "0", "SRS_IK_JIT": "1"}
        command = [sys.executable, "-m", "srs_ik.kernels.ahead.build", str(scratch)]
        # The folder that -m looks in first: an isolated build drops from PYTHONPATH what the environment has installed
        # as editable, this checkout too.
        done = subprocess.run(command, cwd=self.root, env=environment, check=False)
        if done.returncode:
            return "they could not be compiled, see above"
        for path in scratch.iterdir():
            build_data["force_include"][str(path)] = f"srs_ik/kernels/native/{path.name}"
        build_data["pure_python"] = False
        build_data["tag"] = f"cp311-abi3-{_platform()}"
        return ""
