# shellcheck shell=sh
# For the scripts of this folder, which source it from the top folder of the repository: one line a step, with the seconds
# it took; what the step printed goes to build/log/, and its seconds and processor seconds to build/log/steps.tsv. POSIX sh.

steps_log=build/log
mkdir -p "$steps_log"
steps_begin=$(date +%s)
steps_beside=  # names of what runs beside, each with its process: " NAME:PID NAME:PID"
steps_inside=  # yes: this shell is one of those
steps_child=   # process of the step that runs in such a shell
# A script that this one calls, with STEPS_OF_CALLER set, adds its steps to those of its caller.
if [ -z "${STEPS_OF_CALLER:-}" ]; then
    : >"$steps_log/unchecked"
    : >"$steps_log/steps.tsv"
fi

# Sets steps_processor to the processor seconds in a file that `times` has written: those of the children that the shell which
# executed it has waited for.
steps_read_processor() { # FILE
    steps_processor=$(awk 'NR == 2 { for (n = 1; n <= 2; n++) { split($n, part, "[ms]"); sum += 60 * part[1] + part[2] }
        printf "%.1f", sum }' "$1")
}

# step LOG TEXT COMMAND...: runs the command; LOG is appended to, so that several steps share one. A failing step shows
# the end of what it printed and ends the script, and so does one that runs beside.
step() {
    step_log=$steps_log/$1.log
    step_text=$2
    shift 2
    step_start=$(date +%s)
    steps_times=$steps_log/times${STEPS_OF_CALLER:+_called}${steps_inside:+_$beside_name}
    step_before_processor=0
    if [ -n "$steps_inside" ]; then
        times >"$steps_times"
        steps_read_processor "$steps_times"
        step_before_processor=$steps_processor
    fi
    step_before=0
    [ ! -f "$step_log" ] || step_before=$(wc -l <"$step_log")
    if step_command "$@" >>"$step_log" 2>&1 </dev/null; then
        step_seconds=$(($(date +%s) - step_start))
        printf '%-66s %4d s\n' "$step_text" "$step_seconds"
        [ -z "$steps_inside" ] || times >"$steps_times"
        steps_read_processor "$steps_times"
        printf '%s\t%s\t%s\t%s\n' "$step_text" "$step_seconds" "$step_before_processor" "$steps_processor" >>"$steps_log/steps.tsv"
    else
        printf '%-66s %4d s  FAILED\n' "$step_text" $(($(date +%s) - step_start))
        echo >&2
        tail -n "+$((step_before + 1))" "$step_log" | tail -n 60 >&2
        echo "$0: '$step_text' failed; all of it is in $step_log" >&2
        exit 1
    fi
    steps_beside_failed
}
# A shell of its own for a step that does not run beside: in the script's shell `times` would count what ran beside it too, all of
# that at the moment when it ends.
step_command() {
    if [ -n "$steps_inside" ]; then
        "$@" &
        steps_child=$!
        wait "$steps_child"
    else
        (
            step_code=0
            "$@" || step_code=$?
            times >"$steps_times"
            exit $step_code
        )
    fi
}

# beside NAME COMMAND...: runs a function of steps beside those that follow, until beside_end NAME waits for it and tells
# its lines, in that place. Ends with the script, whatever ends that.
beside() {
    beside_name=$1
    shift
    rm -f "$steps_log/$beside_name.ended"
    (
        steps_beside=
        steps_inside=yes
        trap 'echo $? >"$steps_log/$beside_name.ended"' EXIT
        trap '[ -z "$steps_child" ] || kill "$steps_child" 2>/dev/null; exit 143' TERM
        set -e
        "$@"
    ) >"$steps_log/$beside_name.told" 2>&1 </dev/null &
    steps_beside="$steps_beside $beside_name:$!"
    trap steps_beside_stop EXIT
    trap 'exit 130' INT TERM
}
beside_end() { # NAME
    for beside in $steps_beside; do
        if [ "${beside%:*}" = "$1" ]; then
            steps_beside=$(echo "$steps_beside " | sed "s/ $beside / /; s/ \$//")
            beside_code=0
            wait "${beside#*:}" || beside_code=$?
            cat "$steps_log/$1.told"
            [ $beside_code -eq 0 ] || exit 1
        fi
    done
}
steps_beside_failed() {
    for beside in $steps_beside; do
        beside_ended=$steps_log/${beside%:*}.ended
        if [ -s "$beside_ended" ] && [ "$(cat "$beside_ended")" != 0 ]; then
            beside_end "${beside%:*}"
        fi
    done
}
steps_beside_stop() {
    for beside in $steps_beside; do
        kill "${beside#*:}" 2>/dev/null || true
    done
}

# unchecked TEXT: what this run could not look at. steps_unchecked tells it all again at the end: tolerated by hand, a
# failure under continuous integration, which sets CI.
unchecked() {
    echo "$1"
    echo "$1" >>"$steps_log/unchecked"
}
steps_unchecked() {
    if [ -s "$steps_log/unchecked" ]; then
        printf '\nnot checked, %s:\n' "$(wc -l <"$steps_log/unchecked" | tr -d ' ')"
        sed 's/^/  /' "$steps_log/unchecked"
        if [ -n "${CI:-}" ]; then
            echo "$0: CI is set, where everything must be checked" >&2
            return 1
        fi
    fi
}

# tools_here TEXT TOOL...: are these commands on the path? If not, TEXT is unchecked.
tools_here() {
    tools_text=$1
    tools_missing=
    shift
    for tool in "$@"; do
        command -v "$tool" >/dev/null || tools_missing="$tools_missing $tool"
    done
    [ -z "$tools_missing" ] || unchecked "$tools_text: not checked, this machine has no$tools_missing (tools/setup installs it)"
    [ -z "$tools_missing" ]
}

# steps_skipped LOG NAME: the tests of NAME that ctest, whose output LOG is, found skipped or without a program.
steps_skipped() {
    sed -nE 's/^[[:space:]]*[0-9]+ - ([^ ]*) \((Skipped|Not Run|Disabled).*/\1/p' "$steps_log/$1.log" | sort -u |
        while read -r test; do
            unchecked "$2: test $test was skipped"
        done
}
# steps_skipped_inside FOLDER NAME: tests that passed, but left out a part, as ctest's record of the build FOLDER tells.
# Told, and no failure: a board of two sensors, root who may read everything, a locale that is not installed.
steps_skipped_inside() {
    awk '
        /^[0-9]+\/[0-9]+ Test: / { test = $3 }
        /^OK \(.*skipped=[0-9]/ { n = $0; sub(/.*skipped=/, "", n); print test, n + 0 }
        /^[0-9]+ Tests [0-9]+ Failures [1-9][0-9]* Ignored/ { print test, $5 }
    ' "$1/Testing/Temporary/LastTest.log" | while read -r test count; do
        echo "$2: test $test skipped $count of its parts: what this machine or board has not"
    done
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

# Processor seconds of the steps that have ended, those beside included.
steps_processor_sum() {
    awk -F '\t' '{ sum += $4 - $3 } END { printf "%.0f", sum }' "$steps_log/steps.tsv"
}
