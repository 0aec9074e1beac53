#!/bin/sh
# A quick stop in the console, standstill, then `go`: the bridge comes on again. Usage: THIS LAGLESS [PORT]
L=$1; P=${2:-$((20000 + $$ % 20000))}; T=$(mktemp -d)
printf 'schema = 1\ntitle = "bench"\n[run]\nduration = "1 s"\n[plant]\nload_torque = "0.5 N m"\n[rig]\nfidelity = "averaged"\n' > $T/b.toml
$L serve $T/b.toml --port $P -q > /dev/null & S=$!
sleep 1
printf 'wait until state == ready\ngo 500 r/min\nwait until omega_m > 495 r/min timeout 10 s\nquick_stop\nwait until state == ready timeout 10 s\ngo 300 r/min\nwait until omega_m > 295 r/min timeout 10 s\n' | $L connect tcp://127.0.0.1:$P
R=$?
kill $S; rm -r $T; exit $R
