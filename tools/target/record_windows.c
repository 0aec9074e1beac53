/* Writes the windows of a commissioning (recording_windows.h): all steps with a salient motor that saturates,
 * and the step `angle` with its shaft held. The linker redirects the call of commission_window by the medium
 * task to this program (--wrap), which records the inputs and the state of the real function.
 *
 * usage: record_windows FILE */
#include <stdio.h>
#include <stdlib.h>

#include "host_sim/lab/commission.h"
#include "tools/target/recording_windows.h"
#include "tools/target/words_out.h"

static commission_tuning_t taken;
static const commission_t *begun; /* the state that was recorded last */

void __real_commission_window(commission_t *commission, const commission_tuning_t *tuning, int32_t requested,
                              const commission_window_t *input);
void __wrap_commission_window(commission_t *commission, const commission_tuning_t *tuning, int32_t requested,
                              const commission_window_t *input);

void __wrap_commission_window(commission_t *commission, const commission_tuning_t *tuning, int32_t requested,
                              const commission_window_t *input)
{
    const bool anew = begun != commission;
    if (anew) {
        begun = commission;
        put(WINDOWS_INIT);
    }
    const bool changed = anew || memcmp(&taken, tuning, sizeof taken) != 0;
    put(WINDOWS_NEXT);
    put((uint32_t)requested);
    put(changed ? 1u : 0u);
    if (changed) {
        taken = *tuning;
        put_words(&taken, WINDOWS_WORDS(commission_tuning_t));
    }
    put_words(input->standing.seen, WINDOWS_WORDS(excite_seen_t));
    put_words(&input->standing.current_abc, WINDOWS_WORDS(abc_t));
    put_words(&input->standing.current, WINDOWS_WORDS(ab_t));
    put_words(&input->standing.u_dc, 1u);
    put(input->standing.tripped);
    put_words(&input->turning, WINDOWS_WORDS(turning_input_t));
    put(input->bridge_on ? 1u : 0u);
    __real_commission_window(commission, tuning, requested, input);
    put(windows_hash(commission));
}

static void set(rig_t *rig, const char *row, double value)
{
    if (!rig_put(rig, row, value)) {
        fprintf(stderr, "record_windows: %s: %s\n", row, rig_error(rig));
        exit(3);
    }
}

/* Runs these steps with a motor that has this plate; they have to end with this reason. */
static void commission(const char *steps, bool held, const char *reason)
{
    static const commission_plate_t plate = {4.0, 5.0, 157.0};
    commission_options_t options = {.chosen = true, .plant_answers = true};
    commission_result_t result;
    scenario_error_t error = {.file = ""};
    char why[128];
    rig_t *rig = rig_create(3u);
    if (rig == NULL || !commission_choose(&options, steps, why, sizeof why)) {
        fprintf(stderr, "record_windows: %s\n", rig == NULL ? "no memory" : why);
        exit(3);
    }
    set(rig, "plant.inertia", 3e-3);
    set(rig, "plant.friction_coulomb", 0.1);
    set(rig, "plant.inductance_q", 15e-3);
    set(rig, "plant.saturation_q", 15.0);
    set(rig, "plant.shaft_locked", held ? 1.0 : 0.0);
    if (!commission_rig(rig, &plate, &options, &result, &error) || strcmp(result.reason, reason) != 0) {
        fprintf(stderr, "record_windows: %s: %s %s\n", steps, result.reason, result.what);
        exit(3);
    }
    printf("%-60s%6.1f s\n", steps, result.seconds);
    rig_free(rig);
    begun = NULL;
}

int main(int argc, char **argv)
{
    if (argc != 2 || (file = fopen(argv[1], "wb")) == NULL) {
        fprintf(stderr, "usage: record_windows FILE; FILE must be writable\n");
        return 2;
    }
    put(WINDOWS_MAGIC);
    put(WINDOWS_WORDS(commission_t));
    commission("board,wiring,resistance,inductance,current_loop,turn,swing,flux,inertia", false, "");
    /* L does not show the polarity of the magnets, because the d axis does not saturate */
    commission("angle", true, "no_standstill_angle");
    put(WINDOWS_END);
    return fclose(file) == 0 ? 0 : 3;
}
