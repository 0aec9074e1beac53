# shellcheck shell=sh
# For the scripts of this folder, which source it from the top folder of the repository: one line a step, with the seconds
# it took; what the step printed goes to build/log/. POSIX sh.

steps_log=build/log
mkdir -p "$steps_log"
steps_begin=$(date +%s)

# step LOG TEXT COMMAND...: runs the command; LOG is appended to, so that several steps share one. A failing step shows
# the end of what it printed and ends the script.
step() {
    step_log=$steps_log/$1.log
    step_text=$2
    shift 2
    step_start=$(date +%s)
    step_before=0
    [ ! -f "$step_log" ] || step_before=$(wc -l <"$step_log")
    if "$@" >>"$step_log" 2>&1 </dev/null; then
        printf '%-66s %4d s\n' "$step_text" $(($(date +%s) - step_start))
    else
        printf '%-66s %4d s  FAILED\n' "$step_text" $(($(date +%s) - step_start))
        echo >&2
        tail -n "+$((step_before + 1))" "$step_log" | tail -n 60 >&2
        echo "$0: '$step_text' failed; all of it is in $step_log" >&2
        exit 1
    fi
}

# A step of this script begins its log anew.
step_log_clear() {
    for name in "$@"; do
        : >"$steps_log/$name.log"
    done
}

steps_seconds() {
    echo $(($(date +%s) - steps_begin))
}

# The machine's processors, for the build and the tests.
steps_jobs() {
    nproc 2>/dev/null || getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2
}
