"""Compares a campaign with what campaign_not_yet.txt pins of the present program.

usage: judge_campaign.py LAGLESS PINNED pool|day|carrier|new|pin [FOLDER]
  pool     the runs that the file was made of: exactly its violations, no more and no fewer. Its false alarms and excuses likewise.
  day      a few runs of a seed of today's date, or of LAGLESS_GRID_SEED
  carrier  more runs of that seed, for a program of another carrier
  new      as many runs as the pool has, of a seed that nobody has used; FOLDER keeps the results and the scenarios of violations
  pin      makes the pool and writes the file

The runs of `day`, `carrier` and `new` are others than the pool's, so that only counts can be compared. If both campaigns have one
rate of a kind of violation, m of n runs here and k of N there, m is distributed as m of the m + k violations that fall on n of
n + N runs (hypergeometric). The judgement is "worse" or "better" where so many or more, or so few or fewer, come by chance less than once in
CHANCE judgements. It needs no knowledge of the rate, so that it holds for any seed. Worse and better are both an error: who has
mended something writes the file anew with `pin`.

Exit status: 0 as pinned, 1 otherwise, 2 wrong use."""
import collections
import datetime
import json
import math
import os
import pathlib
import subprocess
import sys
import time

CHANCE = 1e-7       # of a judgement; about 25 are made in a campaign
POOL_SEED, POOL_RUNS = 1, 600
DAY_RUNS, CARRIER_RUNS = 60, 200
EXCUSED_MOST = 0.02  # share of the runs that may need one excuse


def run(lagless, seed, runs, folder=None):
    line = [lagless, "campaign", "--seed", str(seed), "--runs", str(runs), "--json"]
    line += ["--out", folder, "--force"] if folder else ["--as-drawn"]
    done = subprocess.run(line, stdout=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"judge_campaign: {' '.join(map(str, line))} ended with {done.returncode}, accepted are 0 and 1")
    return json.loads(done.stdout)


def violations(summary):
    return sorted((each["run"], each["invariant"], each["injected"]) for each in summary["violations"])


def counts(summary):
    """How often each kind came: by name."""
    found = collections.Counter("violation " + each["invariant"] for each in summary["violations"])
    found["alarm"] = summary["alarms"]
    found["calm"] = summary["calm"]
    for cause, count in summary["excuses"].items():
        found["excuse " + cause] = count
    return found


def write(path, summary):
    lines = ["# What a campaign finds that is not mended yet, and what it excuses: of all runs of one seed.",
             "# Written by tests/lab/judge_campaign.py LAGLESS FILE pin. A row that is mended goes, a new one is an error.",
             f"pool {POOL_SEED} {POOL_RUNS}"]
    lines += [f"run {run} {invariant} {injected}" for run, invariant, injected in violations(summary)]
    found = counts(summary)
    lines += [f"count {count} {name}" for name, count in sorted(found.items()) if not name.startswith("violation")]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def read(path):
    seed = runs = None
    rows, found = [], collections.Counter()
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        words = line.split(" ")
        try:
            if line.startswith("#") or not line:
                continue
            if words[0] == "pool":
                seed, runs = int(words[1]), int(words[2])
            elif words[0] == "run":
                rows.append((int(words[1]), words[2], words[3]))
                found["violation " + words[2]] += 1
            elif words[0] == "count":
                found[" ".join(words[2:])] = int(words[1])
            else:
                raise ValueError
        except (ValueError, IndexError):
            sys.exit(f"judge_campaign: {path}:{number}: {line}: accepted are pool SEED RUNS, run N INVARIANT INJECTED, count N NAME")
    if runs is None:
        sys.exit(f"judge_campaign: {path}: there is no line pool SEED RUNS")
    return seed, runs, rows, found


def tails(here, there, runs, pool):
    """Probabilities of so many or more, and of so few or fewer, of all that were found in both."""
    found, of = here + there, math.comb(runs + pool, runs)
    def exactly(m):
        return math.comb(found, m) * math.comb(runs + pool - found, runs - m) / of
    more = sum(exactly(m) for m in range(here, min(found, runs) + 1))
    fewer = sum(exactly(m) for m in range(max(0, found - pool), here + 1))
    return more, fewer


def compare_counts(found, runs, pinned, pool):
    wrong = []
    for name in sorted(set(found) | set(pinned)):
        here, there = found[name], pinned[name]
        # alarms are counted among the calm runs
        n, of = (found["calm"], pinned["calm"]) if name == "alarm" else (runs, pool)
        more, fewer = tails(here, there, n, of)
        if min(more, fewer) < CHANCE:
            wrong.append(f"{'more' if more < fewer else 'fewer'} than pinned: {name}: {here} of {n} runs, pinned {there} of {of}")
    return wrong


def compare_pool(summary, rows, pinned):
    wrong = [f"new: run {run} {invariant} {injected}" for run, invariant, injected in sorted(set(violations(summary)) - set(rows))]
    wrong += [f"mended: run {run} {invariant} {injected}" for run, invariant, injected in sorted(set(rows) - set(violations(summary)))]
    found = counts(summary)
    for name in sorted(set(found) | set(pinned)):
        if not name.startswith("violation") and found[name] != pinned[name]:
            wrong.append(f"{name}: {found[name]}, pinned {pinned[name]}")
    return wrong


def excuses_too_often(found, runs):
    return [f"{name}: {count} of {runs} runs, accepted are {EXCUSED_MOST:.0%}" for name, count in sorted(found.items())
            if name.startswith("excuse") and count > EXCUSED_MOST * runs]


def excuses_beyond_chance(found, runs):
    """Those that so many runs, or more, need less than once in CHANCE judgements if their share is the largest accepted."""
    def chance(count):
        return 1.0 - sum(math.comb(runs, n) * EXCUSED_MOST**n * (1.0 - EXCUSED_MOST)**(runs - n) for n in range(count))
    return [f"{name}: {count} of {runs} runs, more than {EXCUSED_MOST:.0%} explain" for name, count in sorted(found.items())
            if name.startswith("excuse") and chance(count) < CHANCE]


def main(lagless, path, form, folder=None):
    path = pathlib.Path(path)
    if form == "pin":
        summary = run(lagless, POOL_SEED, POOL_RUNS)
        write(path, summary)
        wrong = excuses_too_often(counts(summary), POOL_RUNS)
    elif form == "pool":
        seed, runs, rows, pinned = read(path)
        summary = run(lagless, seed, runs)
        wrong = compare_pool(summary, rows, pinned) + excuses_too_often(counts(summary), runs)
    elif form in ("day", "carrier", "new"):
        _, pool, _, pinned = read(path)
        day = os.environ.get("LAGLESS_GRID_SEED") or datetime.datetime.now(datetime.timezone.utc).strftime("%Y%m%d")
        seed, runs = {"day": (int(day), DAY_RUNS), "carrier": (int(day), CARRIER_RUNS), "new": (time.time_ns() // 1000, pool)}[form]
        if folder:
            folder = pathlib.Path(folder) / f"seed-{seed}"
            folder.mkdir(parents=True, exist_ok=True)
            print(f"results and scenarios: {folder}")
        summary = run(lagless, seed, runs, folder)
        print(f"seed {seed}, {runs} runs, {len(summary['violations'])} violations, pinned {sum(v for k, v in pinned.items() if k.startswith('violation'))} of {pool}")
        wrong = compare_counts(counts(summary), runs, pinned, pool) + excuses_beyond_chance(counts(summary), runs)
    else:
        print(__doc__, file=sys.stderr)
        return 2
    for each in summary["violations"]:
        print(f"  run {each['run']:5} {each['invariant']:12} injected {each['injected']}, fault {each['fault']}")
    for line in wrong:
        print(f"NOT AS PINNED: {line}")
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        print(__doc__, file=sys.stderr)
        sys.exit(2)
    sys.exit(main(*sys.argv[1:]))
