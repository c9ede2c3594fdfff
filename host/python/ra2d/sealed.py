# SPDX-License-Identifier: BSD-3-Clause
"""Files with a seal (docs/results.md), of which every byte that is read is compared with it. HDF5
itself trusts what it reads: a wrong byte among its addresses can end the interpreter."""
from __future__ import annotations

import io
import os
import pathlib
import re
from typing import Any

import xxhash

from .errors import FileError

BLOCK, LINE, HASH = 4096, 64, 16  # bytes: of a block, of the last line, of a hash
PIECE = 1024 * BLOCK
_SEAL = re.compile(rb"ra2d seal 2 (\d{18}) ([0-9a-f]{32})\n")


def _damaged(path: pathlib.Path, what: str) -> FileError:
    return FileError(f"{str(path)!r} is damaged: {what}. 'ra2d check' says what of it is damaged")


class Seal:
    """The hashes of a file's blocks. A file without a seal has none: one that h5py has opened for
    writing, or of an older version."""

    def __init__(self, path: pathlib.Path) -> None:
        self.size, self.hashes = 0, b""  # bytes that are sealed; of each block of them
        with path.open("rb") as file:
            end = file.seek(0, os.SEEK_END)
            file.seek(max(0, end - LINE))
            found = _SEAL.fullmatch(file.read(LINE))
            if not found:
                return
            self.size = int(found[1])
            file.seek(self.size)
            self.hashes = file.read(max(0, end - LINE - self.size))
        if (len(self.hashes) != -(-self.size // BLOCK) * HASH
                or xxhash.xxh3_128_hexdigest(self.hashes) != found[2].decode()):
            raise _damaged(path, "its seal does not fit")


class SealedFile(io.RawIOBase):
    """A file for h5py. Blocks are compared as they are read; `fault`: why one was refused."""

    def __init__(self, path: pathlib.Path, seal: Seal) -> None:
        self._path, self._seal = path, seal
        self._file = path.open("rb", buffering=0)
        self._size, self._at = os.fstat(self._file.fileno()).st_size, 0
        self.fault: FileError | None = None

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        self._at = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._size}[whence]
        return self._at

    def tell(self) -> int:
        return self._at

    def close(self) -> None:
        self._file.close()
        super().close()

    def readinto(self, buffer: Any) -> int:
        into = memoryview(buffer).cast("B")
        size, done = max(0, min(len(into), self._size - self._at)), 0
        while done < size:  # by pieces: a system reads no more than two gigabytes at once
            begin = self._at // BLOCK * BLOCK
            skipped = self._at - begin
            part = min(size - done, PIECE - skipped)
            # whole blocks of what is sealed; behind that stands the seal, for which HDF5 has no use
            sealed = max(0, min(-(-(skipped + part) // BLOCK) * BLOCK, self._seal.size - begin))
            read = memoryview(os.pread(self._file.fileno(), max(sealed, skipped + part), begin))
            if len(read) < max(sealed, skipped + part):
                self._refuse("it has become shorter")
            self._compare(read[:sealed], begin)
            into[done : done + part] = read[skipped : skipped + part]
            self._at, done = self._at + part, done + part
        return size

    def _compare(self, blocks: memoryview, begin: int) -> None:
        for at in range(0, len(blocks), BLOCK):
            hashed = (begin + at) // BLOCK * HASH
            if (xxhash.xxh3_128_digest(blocks[at : at + BLOCK])
                    != self._seal.hashes[hashed : hashed + HASH]):
                self._refuse(f"its bytes from {begin + at} on are not those that were written")

    def _refuse(self, what: str) -> None:
        self.fault = _damaged(self._path, what)
        raise OSError(str(self.fault))
