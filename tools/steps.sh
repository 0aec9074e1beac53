# shellcheck shell=sh
# For the scripts of this folder, which source it from the top folder of the repository: one line a step, with the seconds
# it took; what the step printed goes to build/log/, and its seconds and processor seconds to build/log/steps.tsv. POSIX sh.

steps_log=build/log
mkdir -p "$steps_log"
steps_begin=$(date +%s)
steps_beside=  # names of the parallel parts, each with its process: " NAME:PID NAME:PID"
steps_inside=  # yes: this shell is a parallel part
steps_child=   # process of the step that runs in a parallel part
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

# step LOG TEXT COMMAND...: runs the command; LOG is appended to, so that several steps can share one. A failing step shows the end
# of its output and ends the script, also if it runs in a parallel part.
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
        echo "$0: '$step_text' failed; its whole output is in $step_log" >&2
        exit 1
    fi
    steps_beside_failed
}
# A step that is not in a parallel part runs in a shell of its own, because `times` in the shell of the script would also count the
# parallel parts, at the moment when they end.
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

# beside NAME COMMAND...: runs a function of steps in parallel with the following steps. beside_end NAME waits for its end and
# prints its lines. The parallel part ends when the script ends for any reason.
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

# unchecked TEXT: reports a part that this run could not check. steps_unchecked prints all of these texts again at the end. They
# are a failure under continuous integration, which sets CI.
unchecked() {
    echo "$1"
    echo "$1" >>"$steps_log/unchecked"
}
steps_unchecked() {
    if [ -s "$steps_log/unchecked" ]; then
        printf '\nnot checked, %s:\n' "$(wc -l <"$steps_log/unchecked" | tr -d ' ')"
        sed 's/^/  /' "$steps_log/unchecked"
        if [ -n "${CI:-}" ]; then
            echo "$0: CI is set, so that every part has to be checked" >&2
            return 1
        fi
    fi
}

# tools_here TEXT TOOL...: returns 0 if these commands are on the path; otherwise it reports TEXT as unchecked.
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

# steps_skipped LOG NAME: reports the tests of NAME that ctest skipped, or whose program is missing, by its output LOG.
steps_skipped() {
    sed -nE 's/^[[:space:]]*[0-9]+ - ([^ ]*) \((Skipped|Not Run|Disabled).*/\1/p' "$steps_log/$1.log" | sort -u |
        while read -r test; do
            unchecked "$2: test $test was skipped"
        done
}
# steps_skipped_inside FOLDER NAME: prints the tests that passed, but omitted a part, by the record of ctest in the build FOLDER.
# This is no failure: examples are a board with two sensors, the user root, who can read every file, and a locale that is not
# installed.
steps_skipped_inside() {
    awk '
        /^[0-9]+\/[0-9]+ Test: / { test = $3 }
        /^OK \(.*skipped=[0-9]/ { n = $0; sub(/.*skipped=/, "", n); print test, n + 0 }
        /^[0-9]+ Tests [0-9]+ Failures [1-9][0-9]* Ignored/ { print test, $5 }
    ' "$1/Testing/Temporary/LastTest.log" | while read -r test count; do
        echo "$2: test $test skipped $count of its parts: this machine or board lacks something that they need"
    done
}

# The first step of this script that uses a log empties it.
step_log_clear() {
    for name in "$@"; do
        : >"$steps_log/$name.log"
    done
}

steps_seconds() {
    echo $(($(date +%s) - steps_begin))
}

# The number of processors of the machine, for the build and the tests.
steps_jobs() {
    nproc 2>/dev/null || getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2
}

# Processor seconds of the steps that have ended, with those of parallel parts.
steps_processor_sum() {
    awk -F '\t' '{ sum += $4 - $3 } END { printf "%.0f", sum }' "$steps_log/steps.tsv"
}
