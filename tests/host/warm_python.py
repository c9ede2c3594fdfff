# SPDX-License-Identifier: BSD-3-Clause
"""A quick `python3` for tests that let the program call the Python package hundreds of times.

Importing numpy, pandas and matplotlib takes a second. `started()` imports the package once, in a
server; the `python3` that it puts into a folder hands its request, its three streams, its folder
and its environment to the server, which answers it in a fork. Limits on resources are those of the
server. Tests whose subject is the start of Python itself use the real one. Tests in C++:
tests/warm_python.hpp."""
import contextlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import traceback
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "host" / "python"
CLIENT = """#!{python} -IS
import json, os, signal, socket, sys
link = socket.socket(socket.AF_UNIX)
link.connect({address!r})
request = json.dumps({{"folder": os.getcwd(), "environment": dict(os.environ)}}).encode()
socket.send_fds(link, [len(request).to_bytes(8, "little") + request], [0, 1, 2])
status = int(link.recv(20) or b"1")
if status < 0:
    signal.signal(-status, signal.SIG_DFL)
    os.kill(os.getpid(), -status)
sys.exit(status)
"""


def answer(link):
    """Answers the request of one client, in a child, and sends how it ended."""
    from ra2d import commands
    data, streams, _, _ = socket.recv_fds(link, 1 << 20, 3)
    size = int.from_bytes(data[:8], "little")
    while len(data) < 8 + size:
        data += link.recv(1 << 20)
    request = json.loads(data[8:])
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    child = os.fork()
    if child == 0:
        status = 1
        try:
            for number, stream in enumerate(streams):
                os.dup2(stream, number)
            os.chdir(request["folder"])
            os.environ.clear()
            os.environ.update(request["environment"])
            sys.stdin, sys.stdout, sys.stderr = open(0), open(1, "w"), open(2, "w")
            status = commands.main(sys.stdin)
            sys.stdout.flush()
        except BaseException:
            traceback.print_exc()
        sys.stderr.flush()
        os._exit(status)
    link.send(str(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])).encode())


def serve(address):
    """Answers clients until the standard input ends, with the process that started this one."""
    sys.path.insert(0, str(PACKAGE))
    from ra2d import commands  # noqa: F401: what takes a second
    from scipy import interpolate, signal as _, special  # noqa: F401: imported where they are used
    listening = socket.socket(socket.AF_UNIX)
    listening.bind(address)
    listening.listen(16)
    print("ready", flush=True)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    while sys.stdin not in select.select([listening, sys.stdin], [], [])[0]:
        link, _ = listening.accept()
        if os.fork() == 0:
            answer(link)
            os._exit(0)
        link.close()


@contextlib.contextmanager
def started():
    """A PATH whose `python3` is quick."""
    with tempfile.TemporaryDirectory(prefix="ra2d_python_") as folder:
        address, client = os.path.join(folder, "socket"), Path(folder, "python3")
        client.write_text(CLIENT.format(python=sys.executable, address=address))
        client.chmod(0o755)
        server = subprocess.Popen([sys.executable, __file__, address], stdin=subprocess.PIPE,
                                  stdout=subprocess.PIPE)
        if server.stdout.readline() != b"ready\n":
            raise RuntimeError("the server of warm_python.py did not start")
        yield f"{folder}{os.pathsep}{os.environ['PATH']}"
        server.communicate()


def offer():
    """Prints the PATH, for a program that is no Python, and serves until the standard input
    ends."""
    with started() as path:
        print(path, flush=True)
        sys.stdin.read()


if __name__ == "__main__":
    if len(sys.argv) > 1:
        serve(sys.argv[1])
    else:
        offer()
