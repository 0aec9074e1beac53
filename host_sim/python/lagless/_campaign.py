"""Campaigns: random runs, each checked against rules that always hold; on this machine or on a dask cluster."""
import ctypes as c
import json
import os
import pathlib

from ._errors import Error
from ._library import Campaign as _Struct
from ._library import Keep, of, why


class Campaign:
    """The results of the runs. Two results are equal if every run ended in the same way.

    lines: a header and a line for each run, in the order of the runs (the format of campaign.csv); scenarios: name of file
    -> text of the scenario of each violation, minimised; summary: counts, violations and reasons as
    `lagless campaign --json` has them."""

    def __init__(self, head, lines, scenarios, board=None):
        self.board = of(board).name
        self.head = head
        self.lines = sorted(lines, key=lambda line: int(line.partition(",")[0]))
        self.scenarios = dict(sorted(scenarios.items()))
        self.summary = json.loads(self._text(True))

    def _text(self, as_json):
        refusal = why()
        library = of(self.board)
        memory = library.campaign_summary((self.head + "".join(self.lines)).encode(), as_json, refusal)
        if not memory:
            raise Error(refusal.value.decode())
        try:
            return c.string_at(memory).decode()
        finally:
            library.free(memory)

    def __str__(self):
        return self._text(False)

    def __repr__(self):
        summary = self.summary
        return f"<Campaign of seed {summary['seed']}: {summary['done']} of {summary['runs']} runs, {summary['violated']} violated>"

    def __eq__(self, other):
        return isinstance(other, Campaign) and (self.head, self.lines, self.scenarios) == (other.head, other.lines, other.scenarios)

    __hash__ = None

    def write(self, folder):
        """Writes campaign.csv and the scenarios, in the form of `lagless campaign --out FOLDER`."""
        folder = pathlib.Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in self.scenarios.items():
            (folder / name).write_text(text, encoding="utf-8")
        (folder / "campaign.csv").write_text(self.head + "".join(self.lines), encoding="utf-8")


def _struct(runs, seed, seconds, shard, shards, threads, keep=None):
    numbers = {"runs": runs, "seed": seed, "shards": shards, "threads": threads}
    for name, value in numbers.items():
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**31:
            raise Error(f"{name} = {value!r}: accepted: whole numbers from 0", name)
    return _Struct(seed, float(seconds), runs, shard, shards, threads, keep or Keep())


def head(runs, seed, seconds, board=None):
    """First line of the results of a campaign. It must be the same for all shards, and includes the hash of the program's tables."""
    text = why()
    good = of(board).campaign_head(c.byref(_struct(runs, seed, seconds, 1, 1, 1)), text)
    if not good:
        raise Error(text.value.decode())
    return text.value.decode()


def shard(runs, seed, seconds, number, shards, threads=1, progress=None, board=None):
    """Every `shards`-th run from the `number`-th on (from 1): (head, lines, scenarios). Runs in a worker of a cluster."""
    lines, scenarios, errors = [], {}, []

    def keep(run, line, scenario):
        try:
            lines.append(line.decode())
            if scenario is not None:
                scenarios[f"run-{run:06}.toml"] = scenario.decode()
            if progress is not None:
                progress(len(lines))
        except BaseException as error:  # Ctrl-C as well; raised again when the library has returned
            errors.append(error)
        return bool(errors)

    refusal = why()
    good = of(board).campaign(c.byref(_struct(runs, seed, seconds, number, shards, threads, Keep(keep))), refusal)
    if errors:
        raise errors[0]
    if not good:
        raise Error(refusal.value.decode())
    return head(runs, seed, seconds, board), lines, scenarios


def campaign(runs=10000, seed=1, seconds=2.0, client=None, shards=None, threads=None, progress=None, board=None):
    """Random motors, loads, wrong assumptions, sensor errors, profiles and faults; every period of every run is judged.

    runs, seed, seconds (simulated, of each): as of `lagless campaign`, with the same runs: run n of a seed does not depend on how the runs
    are divided. Without `client` the runs use `threads` cores of this machine (default: all).

    client: a dask.distributed.Client; the runs are divided into `shards` (default: 8 for each of its threads), each a task. If a worker is
    lost, another one repeats its task; no run is counted twice. The workers must have the same build of this package: a worker with other
    tables is refused. progress: called with the completed share. board: the power stage, one of boards().

    Returns a Campaign."""
    tell = progress or (lambda share: None)
    if client is None:
        done = shard(runs, seed, seconds, 1, 1, threads or os.cpu_count() or 1, lambda count: tell(count / runs), board)
        return Campaign(*done, board)
    from dask.distributed import as_completed

    if shards is None:
        shards = max(1, min(runs, 8 * sum(client.nthreads().values())))
    first = head(runs, seed, seconds, board)
    futures = client.map(lambda number: shard(runs, seed, seconds, number, shards, board=board), range(1, shards + 1), pure=False,
                         key="lagless-campaign")
    lines, scenarios = [], {}
    try:
        for count, future in enumerate(as_completed(futures), 1):
            theirs, more, found = future.result()
            if theirs != first:
                raise Error(f"a worker has another build of lagless: its campaign is {theirs.strip()}, here {first.strip()}; "
                            "install the same build on all workers")
            lines += more
            scenarios.update(found)
            tell(count / shards)
    finally:
        client.cancel(futures)
    return Campaign(first, lines, scenarios, board)
