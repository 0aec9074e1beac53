"""Runs a client against a drive of its own. usage: served.py LAGLESS CLIENT, which gets the port as its argument."""
import subprocess
import sys

with subprocess.Popen([sys.argv[1], "serve", "cold_start", "--port", "0", "--quiet"], text=True, stdout=subprocess.PIPE) as server:
    try:
        port = server.stdout.readline().rsplit(":", 1)[1].strip()
        code = subprocess.run([sys.executable, "-B", sys.argv[2], port], timeout=30).returncode
    finally:
        server.terminate()
sys.exit(code)
