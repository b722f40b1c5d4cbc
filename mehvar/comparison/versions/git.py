# SPDX-License-Identifier: Apache-2.0
"""Reader of git revisions, which leaves working tree and index unchanged."""

from __future__ import annotations

import io
import subprocess
import tarfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from mehvar.base.errors import InputError
from mehvar.codegen.workspace import ROOMS


@dataclass(frozen=True)
class Revision:
    """A commit of the repository that contains a project.

    Attributes
    ----------
    root : Path
        Folder of the project, the repository's root or one inside it.
    name : str
        Name that the user gave, as in HEAD~1.
    commit : str
        Its full hash.
    """

    root: Path
    name: str
    commit: str

    @property
    def label(self) -> str:
        """Name and short hash, as in "HEAD~1 (1e392cc)"."""
        short = self.commit[:7]
        return short if self.commit.startswith(self.name) else f"{self.name} ({short})"

    @property
    def top(self) -> Path:
        """Folder of the repository."""
        return Path(_git(self.root, "rev-parse", "--show-toplevel").decode().removesuffix("\n"))

    def models(self) -> tuple[str, ...]:
        """Names of the models that the revision has, as sources or generated files."""
        folders = _git(self.root, "ls-tree", "-d", "--name-only", self.commit, "generated/", "models/")
        rooms = {f"models/{room}" for room in ROOMS}
        names = {Path(line).name for line in folders.decode().splitlines() if line not in rooms}
        return tuple(sorted(name for name in names if not name.startswith((".", "_"))))

    def of_today(self, files: Iterable[str]) -> str:
        """Return the first of some files, given by absolute paths, that the revision has and the working tree holds."""
        own = _git(self.root, "ls-tree", "-r", "--full-tree", "--name-only", "-z", self.commit).decode().split("\0")
        paths = {str(self.top / name) for name in own}
        return next((file for file in files if file in paths), "")

    def extract(self, paths: Sequence[str], folder: Path) -> None:
        """Write the revision's files below `paths` into `folder`."""
        names = _git(self.root, "ls-tree", "--name-only", self.commit, *paths).decode().splitlines()
        if not names:
            return
        archive = _git(self.root, "archive", "--format=tar", self.commit, "--", *names)
        with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            for member in tar:
                if content := _content(tar, member):
                    path = folder / member.name
                    path.parent.mkdir(parents=True, exist_ok=True)
                    path.write_bytes(content.read())


def _content(tar: tarfile.TarFile, member: tarfile.TarInfo) -> IO[bytes] | None:
    """Return the content of a file; None for a folder, or a link to a file that git does not have."""
    try:
        return tar.extractfile(member)
    except KeyError:
        return None


def find_revision(root: Path, name: str) -> Revision | None:
    """Return the commit with the name `name` in the repository around `root`; None if there is no such commit.

    Raises
    ------
    InputError
        If git is not installed.
    """
    if "\0" in name:  # not possible in a command line
        return None
    try:
        commit = _git(root, "rev-parse", "--verify", "--quiet", "--end-of-options", f"{name}^{{commit}}")
    except subprocess.CalledProcessError:
        return None
    return Revision(root, name, commit.decode().split()[-1])


def in_repository(root: Path) -> bool:
    """Return True for a folder inside a git repository."""
    try:
        _git(root, "rev-parse", "--git-dir")
    except subprocess.CalledProcessError:
        return False
    return True


def _git(root: Path, *arguments: str) -> bytes:
    try:
        return subprocess.run(["git", "-C", str(root), *arguments], capture_output=True, check=True).stdout
    except FileNotFoundError:
        raise InputError("git is not installed: compare folders, or install git") from None
