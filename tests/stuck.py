"""Limits the time of a test: a test that takes too long reports the place where it waits, and its program ends with all processes that it
has started.

A time-out of ctest would name neither the test nor the line, and processes that hold an end of a pipe would continue to run."""

import faulthandler
import os
import signal
import sys
import threading
import unittest

SECONDS = 240  # [s] limit for one test; the longest needs a fraction of it, and ctest allows every program more


def descendants(process):
    """The children of this process, the youngest first; an empty list if the system does not list them."""
    found = []
    try:
        for thread in os.listdir(f"/proc/{process}/task"):
            with open(f"/proc/{process}/task/{thread}/children") as file:
                for child in map(int, file.read().split()):
                    found += [*descendants(child), child]
    except OSError:
        pass
    return found


def end(what):
    print(f"{what} has not ended within {SECONDS} s; it waits here:", file=sys.stderr, flush=True)
    faulthandler.dump_traceback(all_threads=True)
    for child in descendants(os.getpid()):
        try:
            os.kill(child, signal.SIGKILL)
        except OSError:
            pass
    os._exit(1)


def watch(what):
    """Ends the program unless `cancel()` of the returned timer is called in time."""
    timer = threading.Timer(SECONDS, end, [what])
    timer.daemon = True
    timer.start()
    return timer


class TestCase(unittest.TestCase):
    """A test with a time limit, which includes its set-up."""

    def run(self, result=None):
        watching = watch(self.id())
        try:
            return super().run(result)
        finally:
            watching.cancel()
