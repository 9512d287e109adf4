"""Node.js and the packages of the engines under it, rigid/jolt and rigid/mujoco: `python3 -m sunder_tools.launch.node` gets
them.

The viewer's page (coupler/viewer) has its three.js and uPlot the same way, and needs no Node.js.
"""
from __future__ import annotations

import base64
import hashlib
import http.client
import io
import json
import os
import shutil
import sys
import tarfile
import tempfile
import time
import urllib.error
import urllib.request
from pathlib import Path, PurePosixPath

from ..errors import CommandError
from ..places import BUILD_DIR_VARIABLE, LOCK_FILE, REPOSITORY, has_packages, named_build, npm_folder
from ..words import command_line
from .install import ensure_installed
from .logged import run_logged, tail

NODE_PACKAGES = ("nodejs",)  # not Debian's npm: it draws in hundreds of packages
REGISTRY_VARIABLE = "npm_config_registry"  # npm's own
PUBLIC_REGISTRY = "https://registry.npmjs.org"  # npm's own default
TRIES = 3
PATIENCE_S = 60.0  # without a byte


def ensure_node(sources: Path = REPOSITORY / "rigid" / "jolt", folder: Path | None = None) -> None:
    """Installs Node.js, and the packages of `sources`/package-lock.json in `folder`/node_modules (default: where
    `npm_folder` says); quick when all is there. Raises CommandError.

    What apt and npm say goes to node.log beside the folder. Where SUNDER_BUILD_DIR is set, Node.js has to be there.
    """
    folder = folder or npm_folder("node", sources)
    log = folder.parent / "node.log"
    if named_build() is None:
        try:
            log.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _not_written(folder, error) from None
        ensure_installed(log, NODE_PACKAGES)
    elif not shutil.which("node"):
        raise CommandError(f"there is no Node.js, and {BUILD_DIR_VARIABLE} is set: no Debian package is installed then; "
                           f"as root run: apt-get install -y --no-install-recommends {' '.join(NODE_PACKAGES)}")
    ensure_packages(log, sources, folder)


def ensure_packages(log: Path, sources: Path, folder: Path, whose: str = "the engines under Node.js") -> None:
    """The packages alone. They are all there or, after a failure, as they were before."""
    if has_packages(folder, sources):
        return
    wanted = (sources / LOCK_FILE).read_bytes()
    print(f"sunder: getting the packages of {whose}", file=sys.stderr, flush=True)
    start = time.monotonic()
    fresh: Path | None = None
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        fresh = Path(tempfile.mkdtemp(prefix=f"{folder.name}.new-", dir=folder.parent))
        if shutil.which("npm"):  # knows the user's registry, proxy and certificates
            _by_npm(log, sources, fresh)
        else:
            _by_hand(json.loads(wanted), fresh)
        (fresh / LOCK_FILE).write_bytes(wanted)
        fresh.chmod(0o755)
        _put_in_place(fresh, folder, sources)
    except OSError as error:
        raise _not_written(folder, error) from None
    finally:
        if fresh is not None:
            shutil.rmtree(fresh, ignore_errors=True)
    print(f"sunder: got them in {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)


def _not_written(folder: Path, error: OSError) -> CommandError:
    return CommandError(f"cannot write {folder}: {error.strerror or error}: {error.filename}; mend that, or name a build "
                        f"folder that you may write to in {BUILD_DIR_VARIABLE}")


def _put_in_place(fresh: Path, folder: Path, sources: Path) -> None:
    """Renames the folder, so that other processes see the old packages or the new ones. Two at once do no harm."""
    try:
        if folder.exists():
            os.rename(folder, fresh / "old")
        os.rename(fresh, folder)
    except OSError:
        if not has_packages(folder, sources):  # by the other one
            raise
    shutil.rmtree(folder / "old", ignore_errors=True)


def _by_npm(log: Path, sources: Path, fresh: Path) -> None:
    for name in ("package.json", LOCK_FILE):
        shutil.copyfile(sources / name, fresh / name)
    # none of them needs its install script: zeromq comes with its binary
    command = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"]
    status = run_logged(command, log, fresh)
    if status != 0:
        raise CommandError(f"{tail(log, 20)}\n{command_line(command)} failed with status {status} (whole log: {log}); check "
                           f"the network, npm's settings and {REGISTRY_VARIABLE}, then run this again")


def _by_hand(lock: dict[str, object], fresh: Path) -> None:
    packages = lock["packages"]
    assert isinstance(packages, dict)
    for place, entry in sorted(packages.items()):
        if not place:
            continue  # the engine itself
        name = place.rpartition("node_modules/")[2]
        archive = _download(name, entry["version"])
        _check_integrity(archive, entry["integrity"], f"{name} {entry['version']}")
        _unpack(archive, fresh / place, name)


def _download(name: str, version: str) -> bytes:
    registry = (os.environ.get(REGISTRY_VARIABLE) or PUBLIC_REGISTRY).rstrip("/")
    url = f"{registry}/{name}/-/{name.rpartition('/')[2]}-{version}.tgz"
    for attempt in range(1, TRIES + 1):
        try:
            with urllib.request.urlopen(url, timeout=PATIENCE_S) as answer:
                return answer.read()
        except (OSError, http.client.HTTPException, ValueError) as error:  # URLError is an OSError
            final = attempt == TRIES or isinstance(error, (ValueError, urllib.error.HTTPError))
            if final:
                raise CommandError(f"cannot download {url}: {error}; check the network, or name a registry that has it "
                                   f"in {REGISTRY_VARIABLE}, then run this again") from None
            time.sleep(attempt)
    raise AssertionError("unreachable")


def _check_integrity(archive: bytes, integrity: str, what: str) -> None:
    algorithm, _, expected = integrity.partition("-")
    if algorithm != "sha512":
        raise CommandError(f"{LOCK_FILE}: {what} has integrity '{integrity}', must be sha512")
    found = base64.b64encode(hashlib.sha512(archive).digest()).decode()
    if found != expected:
        raise CommandError(f"{what}: the archive that came has sha512 {found}, {LOCK_FILE} says {expected}; it was changed "
                           f"on its way, or {REGISTRY_VARIABLE} names a registry with other files")


def _unpack(archive: bytes, target: Path, name: str) -> None:
    """Files below the archive's one top folder, under whatever name, go below `target`; nothing gets out of it."""
    try:
        with tarfile.open(fileobj=io.BytesIO(archive), mode="r:gz") as tar:
            for member in tar:
                path = PurePosixPath(member.name)
                if member.isdir():
                    continue
                if not member.isfile() or path.is_absolute() or ".." in path.parts or len(path.parts) < 2:
                    raise CommandError(f"{name}: its archive holds '{member.name}', which is no plain file below one folder")
                file = target.joinpath(*path.parts[1:])
                file.parent.mkdir(parents=True, exist_ok=True)
                content = tar.extractfile(member)
                assert content is not None
                file.write_bytes(content.read())
    except (tarfile.TarError, EOFError, OSError) as error:
        if isinstance(error, OSError) and error.filename:
            raise
        raise CommandError(f"{name}: its archive cannot be unpacked: {error}") from None


def main() -> int:
    """Installs the engine's packages for users who do not run the tests."""
    try:
        ensure_node()
    except CommandError as error:
        print(f"sunder: {error}", file=sys.stderr)
        return error.status
    return 0


if __name__ == "__main__":
    sys.exit(main())
