"""A port that gives prepared replies, and misbehaves at one case in a way that it is told.

    python bad_port.py REPLIES.json WAY CASE DTYPE

It imports nothing of the package, so that it starts in no time.
"""

import json
import os
import signal
import sys
import time

NEVER_S = 3600.0


def write(data: bytes) -> None:
    """Write to the output at once."""
    sys.stdout.buffer.write(data)
    sys.stdout.buffer.flush()


def flood(number: int) -> None:
    """Write to a file descriptor without end."""
    while True:
        os.write(number, b"x" * 65536)


def sleep() -> None:
    """Do nothing."""
    time.sleep(NEVER_S)


def close_output() -> None:
    """Close the output and live on."""
    os.close(1)
    sleep()


def run_out_of_memory() -> None:
    """End as C++ does if memory is short."""
    os.write(2, b"terminate called after throwing an instance of 'std::bad_alloc'\n")
    os._exit(134)


WAYS = {
    "exit": lambda good: os._exit(0),
    "crash": lambda good: os.kill(os.getpid(), signal.SIGTERM),
    "killed": lambda good: os.kill(os.getpid(), signal.SIGKILL),
    "out-of-memory": lambda good: run_out_of_memory(),
    "hang": lambda good: sleep(),
    "half-a-line": lambda good: (write(good[:10]), sleep()),
    "half-a-line-and-exit": lambda good: (write(good[:10]), os._exit(0)),
    "garbage": lambda good: write(b"Segmentation fault is fine\n"),
    "rubbish-bytes": lambda good: write(b"\xff\xfe\x00\xc3\x28\n"),
    "empty-line": lambda good: write(b"\n"),
    "not-an-object": lambda good: write(b"[1, 2]\n"),
    "deep-nesting": lambda good: write(b"[" * 200000 + b"\n"),
    "long-integer": lambda good: write(b'{"id": ' + b"9" * 100000 + b"}\n"),
    "two-lines": lambda good: write(good + b'{"debug": 1}\n'),
    "wrong-id": lambda good: write(good.replace(b'"id":"', b'"id":"not-', 1)),
    "no-id": lambda good: write(b'{"status":"ok","output":{}}\n'),
    "other-case": lambda good: write(sys.argv[5].encode() + b"\n"),
    "closed-output": lambda good: close_output(),
    "flood": lambda good: flood(1),
    "flood-of-errors": lambda good: flood(2),
}


def main() -> None:
    """Answer until the input ends."""
    with open(sys.argv[1], encoding="ascii") as file:
        replies = json.load(file)
    way, bad = sys.argv[2], sys.argv[3:5]
    for line in sys.stdin:
        request = json.loads(line)
        if "hello" in request:
            write(json.dumps(replies["hello"]).encode() + b"\n")
            continue
        key = [request["id"], request["dtype"]]
        good = json.dumps(replies[" ".join(key)], separators=(",", ":")).encode() + b"\n"
        if key == bad:
            WAYS[way](good)
        else:
            write(good)


if __name__ == "__main__":
    main()
