"""Builds the Python package from a checkout. It keeps the checkout's place, where programs, scenes and schema are."""
import shutil
import sys
import tempfile
from pathlib import Path

from setuptools import find_packages, setup
from setuptools.command.build_py import build_py

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.dont_write_bytecode = True
from sunder_tools.version import version  # noqa: E402


class WithPlace(build_py):
    """Adds sunder_tools/CHECKOUT, and makes sunder.py a package, since only a package can say that it is typed."""

    def run(self) -> None:
        super().run()
        if getattr(self, "editable_mode", False):
            return
        out = Path(self.build_lib)
        (out / "sunder_tools" / "CHECKOUT").write_text(f"{HERE.parent}\n", encoding="utf-8")
        (out / "sunder").mkdir(exist_ok=True)
        shutil.copyfile(HERE / "sunder.py", out / "sunder" / "__init__.py")
        (out / "sunder" / "py.typed").touch()
        (out / "sunder.py").unlink(missing_ok=True)


SCRATCH = tempfile.mkdtemp(prefix="sunder-build-")  # nothing is left in the checkout, which may not be writable
try:
    setup(version=version(), py_modules=["sunder"], package_dir={"": "."},
          packages=find_packages(str(HERE), include=["sunder_tools", "sunder_tools.*", "sunder_lab", "sunder_lab.*"]),
          package_data={"sunder_tools": ["py.typed"], "sunder_lab": ["py.typed"]}, cmdclass={"build_py": WithPlace},
          options={"build": {"build_base": SCRATCH}, "egg_info": {"egg_base": SCRATCH}})
finally:
    shutil.rmtree(SCRATCH, ignore_errors=True)
