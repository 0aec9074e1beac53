"""A campaign on a local dask cluster of two workers gives the result of one process, even if a worker is killed during it.

usage: test_dask.py     PYTHONPATH and LAGLESS_LIBRARY select the package; ends with 77, skipped, without distributed."""
import importlib.util
import os
import signal
import sys
import unittest

if importlib.util.find_spec("numpy") is None or importlib.util.find_spec("distributed") is None:
    print("skipped: this Python has no distributed (tools/setup all installs it into build/venv)")
    sys.exit(77)

from dask.distributed import Client, LocalCluster

import lagless

RUNS, SEED, SECONDS, SHARDS = 48, 3, 0.3, 12


class Cluster(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
        cls.client = Client(cls.cluster)
        cls.alone = lagless.campaign(RUNS, SEED, SECONDS, threads=1)

    @classmethod
    def tearDownClass(cls):
        cls.client.close()
        cls.cluster.close()

    def campaign(self, progress=None):
        return lagless.campaign(RUNS, SEED, SECONDS, client=self.client, shards=SHARDS, progress=progress)

    def test_two_workers_give_what_one_process_gives(self):
        shares = []
        found = self.campaign(shares.append)
        self.assertEqual((found.head, found.lines, found.scenarios), (self.alone.head, self.alone.lines, self.alone.scenarios))
        self.assertEqual(found.summary["done"], RUNS)
        self.assertEqual(shares, [n / SHARDS for n in range(1, SHARDS + 1)])

    def test_a_killed_worker_loses_no_result(self):
        killed = []

        def kill(share):
            if not killed:
                killed.append(next(iter(self.client.run(os.getpid).values())))
                os.kill(killed[0], signal.SIGKILL)

        found = self.campaign(kill)
        self.assertEqual(len(killed), 1)
        self.assertEqual((found, found.summary), (self.alone, self.alone.summary))


if __name__ == "__main__":
    unittest.main()
