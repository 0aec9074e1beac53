/* Writes a recording (recording.h) of an ordinary second and of forced rare events, so that it contains the
 *longest interrupt. The linker redirects the calls of drive_step by the interrupt and of drive_prepare by the
 *background to this program (--wrap), which records the inputs and outputs of the real functions.
 *
 * usage: record FILE */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "host_sim/rig/rig.h"
#include "settings/reasons.h"
#include "tools/target/recording.h"
#include "tools/target/words_out.h"

#define RPM (2.0 * 3.14159265358979323846 / 60.0) /* [rad/s] */

/* ---- the output file ---- */

static uint32_t recorded, length; /* [periods] of this part: so far, in all */
static params_t prepared;         /* the newest set whose tuning was prepared, */
static assumed_t prepared_with;   /* with this assumption */
static bool unrecorded;           /* the tuning of the last drive_prepare() is not in the recording yet */
static uint32_t found;            /* bit n: in period n of a window a catch has found its rotor */
static void (*tampering)(drive_samples_t *samples); /* with the samples of the sensors; NULL: none */

static void put_table(const table_t *table, const void *base)
{
    for (uint32_t n = 0; n < table->count; n++) {
        put(table_bits(&table->rows[n], base));
    }
}

void __real_drive_prepare(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed);
void __wrap_drive_prepare(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed);

void __wrap_drive_prepare(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    prepared = *params;
    prepared_with = *assumed;
    unrecorded = true;
    __real_drive_prepare(tuning, params, assumed);
}

bool __real_drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command);
bool __wrap_drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command);

bool __wrap_drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command)
{
    drive_samples_t taken = *samples;
    if (recorded == length) {
        return __real_drive_step(drive, samples, command);
    }
    if (tampering != NULL) {
        tampering(&taken);
    }
    if (recorded++ == 0u) {
        put_table(&params_table, &prepared); /* an offer before the first period takes effect at once */
    }
    const bool offers = drive->offered != 0u && unrecorded;
    put(offers ? 1u : 0u);
    if (offers) {
        unrecorded = false;
        put_table(&params_table, &prepared);
        put_words(&prepared_with, ASSUMED_SLOTS);
    }
    put_table(&requests_table, &drive->requests);
    put_words(&taken, RECORDING_SAMPLES);
    const fast_t *fast = &drive->fast;
    const uint32_t searched = fast->reference.catching.found ^ 1u;
    const bool due = __real_drive_step(drive, &taken, command);
    found |= (fast->reference.catching.found & searched) << fast->sum.periods;
    drive->fast_took = (drive_duration_t){0u, 0u}; /* a replay measures no time */
    drive->medium_took = (drive_duration_t){0u, 0u};
    put_table(&signals_table, drive);
    put_words(command, RECORDING_COMMAND);
    return due;
}

/* ---- steps of a part ---- */

static rig_t *rig;
static bool good; /* every condition of the part has been met so far */

static void set(const char *name, double value)
{
    good = rig_put(rig, name, value) && good;
}

static void apply(void)
{
    good = rig_apply(rig) && good;
}

static double value(const char *name)
{
    return rig_value(rig, name);
}

static void expect_at(bool as_meant, int line)
{
    if (!as_meant) {
        fprintf(stderr, "record: line %d, period %u: manoeuvre %g, state %g, %g r/min\n", line,
                (unsigned)recorded, value("manoeuvre"), value("state"), value("omega_m") / RPM);
    }
    good = good && as_meant;
}

/* Records whether a condition of the part is met. */
#define expect(as_meant) expect_at(as_meant, __LINE__)

static void run(uint32_t periods)
{
    rig_run(rig, periods);
}

static bool operating(void)
{
    return value("state") == (double)DRIVE_OPERATION_ENABLED;
}

/* Waits until the drive runs in the frame of the rotor; without an encoder after a catch or a hand-over. */
static bool running(void)
{
    return operating() && value("manoeuvre") == (double)MANOEUVRE_RUN;
}

/* Continues to this manoeuvre, which must begin within this number of periods. */
static void run_to(manoeuvre_t manoeuvre, uint32_t most)
{
    for (uint32_t n = 0; n < most && value("manoeuvre") != (double)manoeuvre; n++) {
        run(1);
    }
    expect(operating() && value("manoeuvre") == (double)manoeuvre);
}

/* The same, while a new tuning is taken in every period, also in that in which a manoeuvre ends. */
static void take_to(manoeuvre_t manoeuvre, uint32_t most)
{
    for (uint32_t n = 0; n < most && value("manoeuvre") != (double)manoeuvre; n++) {
        apply();
        run(1);
    }
    expect(operating() && value("manoeuvre") == (double)manoeuvre);
}

/* Parameters that make a part short. */
static void stage(double position_source)
{
    set("calibration_periods", 16.0);
    set("position_source", position_source);
    set("estimate_time", 10.0);
}

/* [periods] from power-on to operation: a wait of 20 ms, and four windows. */
#define SWITCHING_ON (DRIVE_PERIODS(20e-3f) + 5u * DRIVE_WINDOW)

/* A shaft that is turned from outside at this speed [r/min], and a drive that is about to catch it, without
 * an encoder. This takes longer than the time for which a fault must be absent before a restart. */
static void catch_on_shaft(double speed)
{
    apply();
    set("shaft_locked_speed", speed * RPM);
    set("shaft_locked", 1.0);
    rig_set_motion(rig, 0.0, speed * RPM);
    set("speed_request", speed * RPM);
    set("enable", 1.0);
    run(SWITCHING_ON);
}

/* The drive runs on such a shaft. */
static void start_on_shaft(double speed)
{
    catch_on_shaft(speed);
    run_to(MANOEUVRE_RUN, 200);
}

/* ---- possible samples of the sensors ---- */

static void no_number(drive_samples_t *samples)
{
    samples->i_a = NAN;
}

static void at_the_rail(drive_samples_t *samples)
{
    samples->i_b = DRIVE_CURRENT_MAX;
}

/* Samples that increase every counter of faults; the interrupts are late as often as is not yet a fault. */
static void hot_and_late(drive_samples_t *samples)
{
    samples->sink_temperature = 200.0f;
    samples->motor_temperature = 200.0f;
    if (recorded % 9u == 0u) {
        samples->flags |= DRIVE_SAMPLE_LATE;
    }
    if (recorded % 2u != 0u) {
        samples->u_dc = 990.0f;
    }
}

/* Every row of the fault table that can hold together with the others. */
static void all_at_once(drive_samples_t *samples)
{
    hot_and_late(samples);
    samples->flags |=
        DRIVE_SAMPLE_TRIPPED | DRIVE_SAMPLE_FAULT_LINE | DRIVE_SAMPLE_ENCODER | DRIVE_SAMPLE_LATE;
    samples->i_a = 0.96f * DRIVE_CURRENT_MAX;
    samples->i_c = -samples->i_a - samples->i_b;
}

/* ---- the parts ---- */

static uint32_t seconds(double time)
{
    return rig_periods(time);
}

/* Power-on, a rotor turning at 500 r/min is caught; a speed step to 1000 r/min and a load step of 5 N m, this
 * number of seconds each. */
static void speed_and_load(double caught, double faster, double loaded)
{
    set("position_source", 1.0);
    set("torque_feedforward", 1.0);
    apply();
    rig_set_motion(rig, 0.0, 500.0 * RPM);
    set("speed_request", 500.0 * RPM);
    set("enable", 1.0);
    run(seconds(caught));
    set("speed_request", 1000.0 * RPM);
    run(seconds(faster));
    set("load_torque", 5.0);
    run(seconds(loaded));
    expect(operating());
}

static void ordinary(void)
{
    speed_and_load(0.3, 0.3, 0.4);
}

/* A short part with the learning that is on by default, and the same part without learning: their difference
 * is the cost of learning. */
static void learning(bool on)
{
    static const struct {
        const char *name;
        double rate;
    } rows[] = {{"inductance_adaptation", 3.0},
                {"dead_time_adaptation", 6.0},
                {"inertia_adaptation", 1.0},
                {"offset_trim", 0.05}};
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        set(rows[n].name, on ? rows[n].rate : 0.0);
    }
    speed_and_load(0.06, 0.06, 0.04);
}

static void all_learnt(void)
{
    learning(true);
}

static void nothing_learnt(void)
{
    learning(false);
}

/* The loop locks at the speed at which this takes longest. */
static void catch_it(void)
{
    stage(1.0);
    catch_on_shaft(1900.0);
    take_to(MANOEUVRE_RUN, 200);
}

/* Catches of the same shaft, one after the other, until one has ended in each period of a window. A higher
 * speed ends a catch earlier. */
static void catch_in_each_period(void)
{
    const uint32_t each = (1u << (DRIVE_WINDOW + 1u)) - 2u; /* bits 1 to DRIVE_WINDOW */
    stage(1.0);
    catch_on_shaft(300.0);
    run_to(MANOEUVRE_RUN, 400);
    found = 0u;
    for (uint32_t n = 0; n < 60u && found != each; n++) {
        const double speed = (300.0 + 4.0 * n) * RPM;
        set("enable", 0.0);
        run(SWITCHING_ON);
        set("shaft_locked_speed", speed);
        rig_set_motion(rig, 0.0, speed);
        set("enable", 1.0);
        run(2u * DRIVE_WINDOW);
        run_to(MANOEUVRE_RUN, 600);
    }
    expect(found == each);
}

/* From standstill on a light shaft to where the estimate takes over; it is lost, and caught again; then down
 * to where a forced frame takes over, and through it into the other direction. */
static void cold_start(void)
{
    stage(1.0);
    set("inertia", 0.003);
    set("motor_inertia", 0.003);
    set("friction_coulomb", 0.05);
    set("pll_bandwidth", 400.0);
    set("feedforward_cutoff", 125.0);
    set("start_align_time", 0.04);
    set("start_ramp", 300.0);
    apply();
    set("speed_request", 300.0 * RPM);
    set("enable", 1.0);
    run(SWITCHING_ON);
    expect(operating() && value("manoeuvre") == (double)MANOEUVRE_CATCH);
    take_to(MANOEUVRE_ALIGN, 200);
    run_to(MANOEUVRE_RAMP, 410);
    run_to(MANOEUVRE_HANDOVER, 4000);
    take_to(MANOEUVRE_RUN, 9000);
    run(600); /* faster than at a hand-over, because a slower rotor continues in the forced frame */
    set("estimate_time", 0.001);
    set("estimate_speed_min", 100.0);
    apply();
    take_to(MANOEUVRE_RELOCK, 600);
    set("estimate_time", 10.0);
    set("estimate_speed_min", 0.0);
    apply();
    take_to(MANOEUVRE_RUN, DRIVE_PERIODS(100e-3f)); /* after the EMF of four windows has been consistent */
    set("speed_request", 0.0);
    take_to(MANOEUVRE_FORCED, 1500);
    set("speed_request", -300.0 * RPM);
    run_to(MANOEUVRE_REVERSE, 3 * DRIVE_WINDOW);
    run(300);
}

/* From 300 r/min to -300 r/min on a light shaft, with the encoder, and back by a quick stop. */
static void zero_crossing(void)
{
    stage(0.0);
    set("inertia", 0.002);
    set("friction_coulomb", 0.1);
    set("speed_kp", 0.3);
    set("speed_ki", 2.5);
    set("speed_setpoint_weight", 1.0);
    apply();
    rig_set_motion(rig, 0.0, 300.0 * RPM);
    set("speed_request", 300.0 * RPM);
    set("enable", 1.0);
    run(SWITCHING_ON);
    expect(operating() && value("omega_m") > 0.0);
    set("speed_request", -300.0 * RPM);
    run(250);
    expect(operating() && value("omega_m") < -20.0);
    set("enable", 2.0);
    run(250);
    expect(value("state") == (double)DRIVE_READY && value("shoot_throughs") == 0.0);
}

/* Invalid measurements: for one period, and for two periods at the limit of the sensor. */
static void invalid_sample(void)
{
    stage(1.0);
    start_on_shaft(1000.0);
    tampering = no_number;
    run(1);
    tampering = NULL;
    run(20);
    tampering = at_the_rail;
    run(2);
    tampering = NULL;
    run(20);
    expect(running());
}

/* A DC link too low for the speed: twice the divisions of the modulator, and the integrators held back; then
 * the field is weakened. */
static void voltage_limit(void)
{
    stage(1.0);
    set("field_weakening", 0.0);
    set("dc_undervoltage", 20.0);
    start_on_shaft(1500.0);
    set("dc_voltage", 150.0);
    set("speed_request", 1900.0 * RPM);
    run(200);
    expect(running() && hypot(value("u_d") - value("u_d_ref"), value("u_q") - value("u_q_ref")) > 1.0);
    set("field_weakening", 1.0);
    apply();
    run(400);
    expect(running() && value("i_d_ref") < -1.0);
}

/* A current near zero at low speed: the voltage of its leg is uncertain, and the loop coasts. */
static void doubt(void)
{
    stage(1.0);
    set("torque_feedforward", 1.0);
    start_on_shaft(150.0);
    set("mode", 1.0);
    set("i_q_request", 4.0);
    run(400);
    expect(running());
}

/* Every criterion of the estimate fails and counts, and so does every row of the fault table that counts; the
 * voltage limit, flux adaptation, torque feed-forward, the end of the offset trim's window; in each of these
 * periods a new tuning is taken. Then all faults at once. */
static void everything(void)
{
    stage(1.0);
    set("torque_feedforward", 1.0);
    set("flux_adaptation", 0.5);
    set("field_weakening", 0.0);
    set("dc_undervoltage", 20.0);
    set("overcurrent_trip", 19.0);
    start_on_shaft(1500.0);
    set("dc_voltage", 150.0);
    set("speed_request", 1900.0 * RPM);
    set("estimate_amplitude_min", 1.0);
    set("estimate_amplitude_max", 1.0001);
    set("estimate_detector_max", 1e-6);
    set("estimate_current_max", 1e-6);
    set("estimate_speed_min", 200.0);
    set("motor_flux_linkage", 0.2);
    apply();
    run(760);
    tampering = hot_and_late;
    for (uint32_t n = 0; n < 75u; n++) { /* the wrong link voltage disturbs the estimate, which unlocks */
        apply();
        run(1);
    }
    expect(running());
    apply();
    tampering = all_at_once;
    run(1);
    tampering = NULL;
    run(1);
    expect(value("fault_reason") == (double)REASON_MODULE_FAULT);
}

/* The estimate is lost by all its criteria and the rotor caught again; then a fault, a reset, the calibration
 * and another start. */
static void fault_and_reset(void)
{
    stage(1.0);
    start_on_shaft(1000.0);
    run(500); /* the mask after a catch */
    set("estimate_amplitude_min", 1.0);
    set("estimate_amplitude_max", 1.0001);
    set("estimate_detector_max", 1e-6);
    set("estimate_current_max", 1e-6);
    set("estimate_speed_min", 200.0);
    set("estimate_time", 0.001);
    set("motor_flux_linkage", 0.2);
    apply();
    run_to(MANOEUVRE_RELOCK, 100);
    expect(value("estimator_invalid") != 0.0);
    set("estimate_speed_min", 0.0);
    set("estimate_time", 10.0);
    apply();
    run_to(MANOEUVRE_RUN, 210);
    tampering = all_at_once;
    run(1);
    tampering = NULL;
    run(1);
    expect(value("state") == (double)DRIVE_FAULT);
    set("enable", 0.0);
    run(220);
    set("fault_reset", 1.0);
    run(100);
    set("enable", 1.0);
    run(20);
    run_to(MANOEUVRE_RUN, 210);
}

/* The excitations of commissioning, with a motor at standstill: the pulses of the step `wiring` until it has
 * its result, and the current of `resistance`. Its sums with a sine are formed for every kind of excitation.
 * The check of the current loop needs the results of 15 s and costs less. The windows of all steps are in
 * record_windows.c. */
static void commissioning(void)
{
    stage(1.0);
    apply();
    set("commission", (double)COMMISSION_WIRING);
    set("enable", 1.0);
    run(SWITCHING_ON);
    for (uint32_t n = 0; n < 4000u && value("commission_state") == (double)COMMISSION_WORKS; n++) {
        run(1);
    }
    expect(operating() && value("commission_state") == (double)COMMISSION_DONE);
    set("enable", 0.0);
    run(SWITCHING_ON);
    set("commission", (double)COMMISSION_RESISTANCE);
    set("enable", 1.0);
    run(SWITCHING_ON);
    run(1200);
    expect(operating() && value("commission_state") == (double)COMMISSION_WORKS);
}

/* With an encoder, in each period of a window: a load stops the shaft at once, so that its angle is behind
 * the prediction of the slow tracking loop, and the loop continues with the rotor's own speed. */
static void encoder_suspected(void)
{
    stage(0.0);
    set("encoder_bandwidth", 300.0);
    start_on_shaft(1000.0);
    for (uint32_t phase = 0; phase < DRIVE_WINDOW; phase++) {
        for (uint32_t step = 1; step <= 20u; step++) {
            set("shaft_locked_speed", 50.0 * step * RPM);
            run(16);
        }
        run(100u + phase);
        expect(running() && value("omega_m") > 900.0 * RPM);
        set("shaft_locked_speed", 0.0);
        run(40); /* 1.2 time constants of the tracking loop, which alone would still be fast */
        expect(fabs(value("omega_m")) < 20.0 * RPM);
        run(60);
        expect(running() && value("fault_reason") == 0.0);
    }
}

/* The observers and compensations of the paper: sign, and the sigmoid per axis. */
static void paper(double switching, double lag)
{
    stage(1.0);
    set("observer_switching", switching);
    set("lag_compensation", lag);
    set("observer_emf_cutoff", switching == 0.0 ? 2500.0 : 0.0);
    start_on_shaft(1000.0);
    run(100);
    expect(running());
}

static void paper_sign(void)
{
    paper(0.0, 1.0);
}

static void paper_sigmoid(void)
{
    paper(1.0, 1.0);
}

static const struct {
    const char *name; /* name: at most 31 characters */
    uint32_t periods; /* a second: 0 */
    bool must_fit;
    void (*steps)(void);
} parts[] = {
    {"ordinary second", 0, true, ordinary},
    {"catch", 440, true, catch_it},
    {"catch in each period", 20000, true, catch_in_each_period},
    {"cold start and reversal", 13000, true, cold_start},
    {"zero crossing and quick stop", 740, true, zero_crossing},
    {"invalid samples", 480, true, invalid_sample},
    {"voltage limit", 640, true, voltage_limit},
    {"doubtful voltage", 840, true, doubt},
    {"everything at once", 1260, true, everything},
    {"relock and start anew", 1600, true, fault_and_reset},
    {"all learnt", 1600, true, all_learnt},
    {"nothing learnt", 1600, true, nothing_learnt},
    {"commissioning", 5400, true, commissioning},
    {"encoder suspected", 5000, true, encoder_suspected},
    {"paper sign", 540, false, paper_sign},
    {"paper sigmoid per axis", 540, false, paper_sigmoid},
};
#define PARTS (sizeof parts / sizeof parts[0])
_Static_assert(PARTS <= RECORDING_PARTS, "too many parts for the memory of a replay");

static uint32_t periods_of(size_t part)
{
    return parts[part].periods != 0u ? parts[part].periods : seconds(1.0);
}

static void put_contents(void)
{
    put(RECORDING_MAGIC);
    put(recording_tables());
    put((uint32_t)PARTS);
    for (size_t n = 0; n < PARTS; n++) {
        char name[4u * RECORDING_NAME] = "";
        snprintf(name, sizeof name, "%s", parts[n].name);
        for (uint32_t at = 0; at < sizeof name; at += 4u) {
            put((uint32_t)name[at] | (uint32_t)name[at + 1] << 8 | (uint32_t)name[at + 2] << 16 |
                (uint32_t)name[at + 3] << 24);
        }
        put(periods_of(n));
        put(parts[n].must_fit ? 1u : 0u);
    }
}

static bool part(size_t number)
{
    recorded = 0;
    length = periods_of(number);
    rig = rig_create(1);
    good = rig != NULL;
    if (good) {
        set("medium_time", 0.0); /* in a replay it is available at once, too */
        parts[number].steps();
        while (recorded < length) {
            rig_step(rig); /* the remaining periods, and the interrupt of the last one */
        }
        printf("%-30s%6u interrupts, %7.1f r/min, %6.2f A, state %g, fault %g\n", parts[number].name,
               (unsigned)recorded, value("omega_m") / RPM, value("i_q"), value("state"),
               value("fault_reason"));
    }
    if (!good) {
        fprintf(stderr, "record: %s: the drive did not meet a condition of this part: %s\n",
                parts[number].name, rig != NULL ? rig_error(rig) : "no memory");
    }
    rig_free(rig);
    return good;
}

int main(int argc, char **argv)
{
    if (argc != 2 || (file = fopen(argv[1], "wb")) == NULL) {
        fprintf(stderr, "usage: record FILE; FILE must be writable\n");
        return 2;
    }
    put_contents();
    bool all = true;
    for (size_t n = 0; n < PARTS; n++) {
        all = part(n) && all;
    }
    return fclose(file) == 0 && all ? 0 : 3;
}
