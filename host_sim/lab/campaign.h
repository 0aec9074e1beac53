/* Thousands of random runs, each judged every period by what must hold in all of them.
 *
 * Run n of seed S is a scenario: motor, load, inverter, sensors, the configured data, a profile
 * of requests and, in half of the runs, one fault at a random time, or two. It is drawn by a counter
 * (campaign_random), so that run n is the same in whatever order, by however many threads and in whichever
 * shard it is made. It is run from the text of that scenario: what is written to a file runs to the same bits
 * again.
 *
 * A run that breaks an invariant is made smaller (campaign_shrink): what it takes to break the same invariant
 * stays, everything else goes back to its default.
 *
 * Results are lines of text in no order, complete with their line end; so an interrupted campaign keeps what
 * is done, and any number of them can be merged.
 *
 * Does not handle: folders and files, printing on a terminal (host_sim/cli/campaign.c). */
#ifndef HOST_SIM_LAB_CAMPAIGN_H
#define HOST_SIM_LAB_CAMPAIGN_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "host_sim/lab/pool.h"
#include "host_sim/lab/scenario.h"
#include "settings/faults.h"

#define CAMPAIGN_RUNS_MAX    1000000u
#define CAMPAIGN_SECONDS_MIN 0.1
#define CAMPAIGN_SECONDS_MAX 3600.0
#define CAMPAIGN_TEXT_SIZE   16384u /* [octets] of a scenario */

/* ---- the space ---- */

/* What a quantity is about: those of one group go back to their defaults together first. */
typedef enum {
    CAMPAIGN_MOTOR,
    CAMPAIGN_SHAFT,
    CAMPAIGN_POWER,
    CAMPAIGN_SENSORS,
    CAMPAIGN_CONFIGURED,
    CAMPAIGN_DRIVE,
    CAMPAIGN_START,
    CAMPAIGN_GROUPS
} campaign_group_t;

/* How a quantity is drawn. */
typedef enum {
    CAMPAIGN_EVEN,  /* evenly from least to most */
    CAMPAIGN_LOG,   /* its logarithm is */
    CAMPAIGN_WHOLE, /* a whole number, each as likely */
    CAMPAIGN_HALF,  /* in half of the runs evenly from least to most, in the others the default */
    CAMPAIGN_FEW,   /* the same in an eighth of the runs */
    CAMPAIGN_THIRD, /* evenly in the third of the runs that have a salient motor, by a stream of its own */
} campaign_law_t;

/* clang-format off */
/* K(name, group, law, default, least, most, "unit", "what it is"). Voltages and currents are those of the default board; on another one
 * they change as its link, its current limit or the range of its sensors: CAMPAIGN_LINK, _LIMIT, _RANGE, of campaign_space.c. */
#define CAMPAIGN_QUANTITIES(K) \
    K(motor_drawn,      MOTOR,   EVEN,  0.0,   1.0,   1.0,   "-",       "0: the motor of the defaults, 1: the one drawn") \
    K(inertia,          MOTOR,   LOG,   0.01,  1e-6,  0.1,   "kg m^2",  "everything that turns") \
    K(current,          MOTOR,   LOG,   CAMPAIGN_LIMIT(5.0), CAMPAIGN_LIMIT(0.5), CAMPAIGN_LIMIT(10.0),  "A",       "rated, peak; a light rotor gets no more than what takes it up in 4 ms") \
    K(run_up,           MOTOR,   LOG,   0.1,   4e-3,  1.0,   "s",       "to rated speed by rated torque, where that is 60 to 1000 rad/s") \
    K(emf_share,        MOTOR,   EVEN,  0.7,   0.5,   0.75,  "-",       "EMF at rated speed over what the link can") \
    K(pole_pairs,       MOTOR,   WHOLE, 4.0,   1.0,   8.0,   "-",       "p; fewer where p speed would be beyond 2000 rad/s") \
    K(reactance,        MOTOR,   LOG,   0.2,   0.05,  0.4,   "-",       "omega_e L I over the EMF, at rated speed; more where ripple and catch ask for it, less where the noise does") \
    K(resistive,        MOTOR,   LOG,   0.04,  0.01,  0.1,   "-",       "R I over the EMF at rated speed") \
    K(saliency,         MOTOR,   HALF,  1.0,   1.0,   1.19,  "-",       "L_q/L_d, as far as the drive accepts it without encoder") \
    K(friction,         SHAFT,   EVEN,  0.0,   0.0,   0.15,  "-",       "dry friction over rated torque") \
    K(stiction,         SHAFT,   HALF,  0.0,   1.0,   1.5,   "-",       "break-away over dry friction; 0: none") \
    K(viscous,          SHAFT,   HALF,  0.0,   0.0,   0.1,   "-",       "viscous friction at rated speed over rated torque") \
    K(load_kind,        SHAFT,   WHOLE, 0.0,   0.0,   1.0,   "-",       "0 passive, 1 active") \
    K(load,             SHAFT,   HALF,  0.0,   0.05,  0.5,   "-",       "load over rated torque") \
    K(second_mass,      SHAFT,   HALF,  0.0,   0.2,   3.0,   "-",       "inertia behind an elastic shaft over that of the motor; 0: none") \
    K(resonance,        SHAFT,   LOG,   600.0, 100.0, 2000.0, "rad/s",  "of the elastic shaft, both ends free") \
    K(fan,              SHAFT,   FEW,   0.0,   0.05,  0.3,   "-",       "load at rated speed over rated torque that grows with the square of speed") \
    K(sine,             SHAFT,   FEW,   0.0,   0.02,  0.2,   "-",       "amplitude over rated torque of a load that goes with the shaft's angle") \
    K(sine_cycles,      SHAFT,   WHOLE, 1.0,   1.0,   6.0,   "-",       "of that load in a turn") \
    K(spring,           SHAFT,   FEW,   0.0,   0.05,  0.3,   "-",       "torque of a spring over rated torque after the whole run at rated speed") \
    K(emf_5th,          POWER,   HALF,  0.0,   -0.03, 0.03,  "-",       "harmonic of the EMF") \
    K(emf_7th,          POWER,   HALF,  0.0,   -0.03, 0.03,  "-",       "harmonic of the EMF") \
    K(dc_voltage,       POWER,   EVEN,  CAMPAIGN_LINK(311.0), CAMPAIGN_LINK(270.0), CAMPAIGN_LINK(340.0), "V",       "of the source") \
    K(dc_edge,          POWER,   FEW,   0.0,   -1.0,  1.0,   "-",       "above 0: the source is 3 % below dc_overvoltage or less, below 0: 5 % above dc_undervoltage or less") \
    K(dc_soft,          POWER,   HALF,  0.0,   0.3e-3, 3e-3, "F",       "capacitor of the link behind 0.5 ohm; 0: a stiff link") \
    K(turn_on_delay,    POWER,   EVEN,  1.0,   0.8,   1.2,   "-",       "of the module, over its data sheet's") \
    K(drops,            POWER,   EVEN,  1.0,   0.8,   1.2,   "-",       "of IGBT and diode, over the data sheet's") \
    K(leg_drop,         POWER,   HALF,  0.0, 0.0, CAMPAIGN_LINK(1.0),   "V",       "more on leg b than on the others") \
    K(leg_delay,        POWER,   HALF,  0.0,   0.0,   0.2e-6, "s",      "more of leg c than of the others") \
    K(leg_resistance,   POWER,   HALF,  0.0,   0.0,   0.2,   "-",       "more in leg a, over the motor's") \
    K(offset_a,         SENSORS, EVEN,  0.0, CAMPAIGN_RANGE(-0.2), CAMPAIGN_RANGE(0.2),   "A",       "of current sensor a, before it is calibrated") \
    K(offset_b,         SENSORS, EVEN,  0.0, CAMPAIGN_RANGE(-0.2), CAMPAIGN_RANGE(0.2),   "A",       "of current sensor b, before it is calibrated") \
    K(gain_a,           SENSORS, EVEN,  0.0,   -0.01, 0.01,  "-",       "error of current sensor a") \
    K(gain_b,           SENSORS, EVEN,  0.0,   -0.01, 0.01,  "-",       "error of current sensor b") \
    K(current_noise,    SENSORS, LOG,   CAMPAIGN_RANGE(0.01), CAMPAIGN_RANGE(0.01), CAMPAIGN_RANGE(0.03),  "A",       "of each sample, rms; a code of the converter or more") \
    K(dc_gain,          SENSORS, EVEN,  0.0,   -0.02, 0.02,  "-",       "error of the link's sensor") \
    K(dc_noise,         SENSORS, HALF,  0.0, 0.0, CAMPAIGN_LINK(1.0),   "V",       "of each sample, rms") \
    K(resistance_configured, CONFIGURED, EVEN, 1.0,   0.7,   1.3,   "-",       "configured over true") \
    K(inductance_configured, CONFIGURED, EVEN, 1.0,   0.7,   1.3,   "-",       "configured over true") \
    K(flux_configured,      CONFIGURED, EVEN,  1.0,   0.7,   1.3,   "-",       "configured over true") \
    K(inertia_configured,   CONFIGURED, EVEN,  1.0,   0.7,   1.3,   "-",       "configured over true") \
    K(dead_configured,      CONFIGURED, EVEN,  1.0,   0.7,   1.3,   "-",       "configured turn-off delay and drops, over the data sheet's") \
    K(encoder,          DRIVE,   WHOLE, 0.0,   0.0,   1.0,   "-",       "1: control turns with the encoder, 0: sensorless") \
    K(loop_share,       DRIVE,   LOG,   1.0,   0.7,   1.4,   "-",       "pll_bandwidth over its rule: 6.4 sqrt(p torque/J), 200 to 1000 rad/s; feed-forward a quarter") \
    K(encoder_lines,    DRIVE,   WHOLE, 2500.0, 512.0, 5000.0, "-",     "of the encoder, and configured") \
    K(angle,            START,   EVEN,  0.0,   0.0,   6.2831853, "rad", "of the rotor at t = 0, mechanical") \
    K(speed,            START,   HALF,  0.0,   -0.9,  0.9,   "-",       "of the rotor at t = 0, over rated speed") \
    K(interior,         MOTOR,   THIRD, 0.0,   1.0,   4.0,   "-",       "L_q/L_d of a salient motor, in place of saliency; less where the noise requires it; 0: not salient") \
    K(saturation,       MOTOR,   THIRD, 0.0,   -1.8,  3.0,   "-",       "current of the saturation of its q axis over the rated one; below 0.6: none") \
    K(field,            MOTOR,   THIRD, 0.0,   0.0,   2.5,   "-",       "its fastest speed over the rated one, where that is more; less where the link or the period requires it")

/* What is wrong with the plant around a scenario, where its drive is configured as its file says.
 * E(name, group, law, default, least, most, "unit", "what it is") */
#define CAMPAIGN_ERRORS(E) \
    E(resistance,       MOTOR,   EVEN,  1.0,   0.7,   1.3,   "-",       "true over the scenario's") \
    E(inductance,       MOTOR,   EVEN,  1.0,   0.8,   1.2,   "-",       "true over the scenario's, both axes") \
    E(flux_linkage,     MOTOR,   EVEN,  1.0,   0.9,   1.1,   "-",       "true over the scenario's") \
    E(inertia,          SHAFT,   LOG,   1.0,   0.7,   1.4,   "-",       "true over the scenario's") \
    E(friction,         SHAFT,   LOG,   1.0,   0.5,   2.0,   "-",       "true over the scenario's, any kind") \
    E(dc_voltage,       POWER,   EVEN,  1.0,   0.9,   1.05,  "-",       "true over the scenario's") \
    E(turn_on_delay,    POWER,   EVEN,  1.0,   0.8,   1.2,   "-",       "true over the scenario's, of the module") \
    E(drops,            POWER,   EVEN,  1.0,   0.8,   1.2,   "-",       "true over the scenario's, IGBT and diode") \
    E(offset_a,         SENSORS, EVEN,  0.0,   -0.005, 0.005, "-",      "of current sensor a more, over its range") \
    E(offset_b,         SENSORS, EVEN,  0.0,   -0.005, 0.005, "-",      "of current sensor b more, over its range") \
    E(gain_a,           SENSORS, EVEN,  0.0,   -0.01, 0.01,  "-",       "error of current sensor a more") \
    E(gain_b,           SENSORS, EVEN,  0.0,   -0.01, 0.01,  "-",       "error of current sensor b more") \
    E(current_noise,    SENSORS, LOG,   1.0,   0.5,   3.0,   "-",       "true over the scenario's") \
    E(dc_gain,          SENSORS, EVEN,  0.0,   -0.02, 0.02,  "-",       "error of the link's sensor more") \
    E(angle,            START,   EVEN,  0.0,   0.0,   6.2831853, "rad", "of the rotor at t = 0 more, mechanical")

/* What may happen on the way; value is what the text says.
 * V(NAME, law, least, most, "what it is") */
#define CAMPAIGN_EVENTS(V) \
    V(SPEED,       EVEN, -0.9, 0.9,  "speed_request, over rated speed, of a salient motor over its fastest") \
    V(SLOW,        EVEN, -0.1, 0.1,  "speed_request, over rated speed") \
    V(LOAD,        EVEN, 0.0,  0.6,  "plant.load_torque, over rated torque") \
    V(QUICK_STOP,  EVEN, 0.0,  0.0,  "enable = quick_stop") \
    V(OFF,         EVEN, 0.0,  0.0,  "enable = off") \
    V(ON,          EVEN, 0.0,  0.0,  "enable = on") \
    V(CURRENT,     EVEN, -0.3, 0.3,  "mode = current and i_q_request, over rated current") \
    V(SOURCE,      EVEN, 0.0,  0.0,  "position_source: the other one") \
    V(RESET,       EVEN, 0.0,  0.0,  "fault_reset = yes") \
    V(DRIFT,       EVEN, -0.5, 0.5,  "the offsets of the current sensors move by so many amperes, the other one the other way") \
    V(PARAMS,      EVEN, 0.0,  4.0,  "a parameter changes: its number, and how far as the fraction")
/* clang-format on */

typedef enum {
#define CAMPAIGN_QUANTITY(name, group, law, initial, least, most, unit, text) CAMPAIGN_Q_##name,
    CAMPAIGN_QUANTITIES(CAMPAIGN_QUANTITY)
#undef CAMPAIGN_QUANTITY
        CAMPAIGN_QUANTITY_COUNT
} campaign_quantity_t;

typedef enum {
#define CAMPAIGN_ERROR(name, group, law, initial, least, most, unit, text) CAMPAIGN_E_##name,
    CAMPAIGN_ERRORS(CAMPAIGN_ERROR)
#undef CAMPAIGN_ERROR
        CAMPAIGN_ERROR_COUNT
} campaign_error_t;

typedef struct {
    const char *name;
    campaign_group_t group;
    campaign_law_t law;
    double initial, least, most; /* [unit] */
    const char *unit, *text;
} campaign_quantity_row_t;

extern const campaign_quantity_row_t campaign_quantities[CAMPAIGN_QUANTITY_COUNT];
extern const campaign_quantity_row_t campaign_errors[CAMPAIGN_ERROR_COUNT];

typedef enum {
#define CAMPAIGN_EVENT(NAME, law, least, most, text) CAMPAIGN_V_##NAME,
    CAMPAIGN_EVENTS(CAMPAIGN_EVENT)
#undef CAMPAIGN_EVENT
        CAMPAIGN_EVENT_KINDS
} campaign_event_kind_t;

/* What a fault's value is multiplied with. */
typedef enum {
    CAMPAIGN_AS_IT_IS,
    CAMPAIGN_OF_TORQUE,  /* rated */
    CAMPAIGN_OF_CURRENT, /* rated */
    CAMPAIGN_OF_ROW,     /* the value that the row has at t = 0 */
    CAMPAIGN_OF_SWITCH,  /* it is the number of a switch, the row a sum of their bits */
    CAMPAIGN_OF_STATE    /* it is the share of the drive's state before the bit */
} campaign_scale_t;

/* When a fault excuses what it breaks; several bits. */
typedef enum {
    CAMPAIGN_ALWAYS = 0,
    CAMPAIGN_UNTIL_TOLD = 1, /* the current up to the promised one, until it is noticed with the bridge on */
    CAMPAIGN_TO_CEILING = 2, /* the current up to the promised one */
    CAMPAIGN_WHILE_SLOW = 4, /* the angle below campaign_blind_speed */
    CAMPAIGN_UNCODED = 8,    /* the angle without the encoder */
    CAMPAIGN_STAYS = 16      /* what it broke is still broken when the fault goes away */
} campaign_excuse_t;

/* One row of plant or rig that breaks. */
typedef struct {
    const char *name;
    const char *row;
    campaign_law_t law;
    double least, most;
    campaign_scale_t scale;
    uint32_t excused;    /* bits of invariants that it breaks by itself */
    const char *because; /* "" if there are none */
    uint32_t excuse;     /* campaign_excuse_t */
} campaign_fault_t;

extern const campaign_fault_t campaign_faults[];
extern const uint32_t campaign_fault_count; /* [0]: none */

/* ---- invariants ---- */

/* I(NAME, "name", limit, "unit", "what must hold") */
#define CAMPAIGN_INVARIANTS(I)                                                                               \
    I(NUMBER, "number", 0.0, "-", "every signal is a finite number")                                         \
    I(CURRENT, "current", 1.2, "overcurrent_trip",                                                           \
      "no true phase current exceeds this in three consecutive samples, 200 us, while a gate may be on; "    \
      "not "                                                                                                 \
      "checked after the load has driven the rotor beyond overspeed_trip")                                   \
    I(GATES, "gates", 1.0, "periods", "after a latched fault no gate is on once so many have passed")        \
    I(ANGLE, "angle", 0.8, "rad",                                                                            \
      "the angle that control turns with is not wrong by more for 50 ms while the drive runs by it")         \
    I(LEGS, "legs", 0.0, "-", "no leg has both switches on")                                                 \
    I(LATE, "late", 0.0, "-", "no sample is late")                                                           \
    I(CHIP, "chip", 0.0, "-", "the chip reports no wrong use")                                               \
    I(REASON, "reason", 0.0, "-", "a set that is refused is refused by a row and with a reason")             \
    I(REPEAT, "repeat", 0.0, "-", "one run in 64 is made twice and ends in the same state, bit by bit")      \
    I(EXPECT, "expect", 0.0, "-", "with --scenario: each expectation of the scenario is met")                \
    I(OFF, "off", 2.0 * DRIVE_WINDOW + 2.0, "periods",                                                       \
      "with enable = off no gate is on once so many have passed")                                            \
    I(STOP, "stop", 0.0, "-",                                                                                \
      "a quick stop ends at standstill within three times what the current limit needs and half a second, "  \
      "one that a fault has caused within fault_stop_time")                                                  \
    I(TRIP_SPEED, "trip_speed", 1.05, "overspeed_trip",                                                      \
      "the shaft is not faster for 5 ms with a gate on while the drive runs, without encoder for the lag "   \
      "of "                                                                                                  \
      "the tracking loop more")                                                                              \
    I(TRIP_LINK, "trip_link", 1.0, "dc_overvoltage",                                                         \
      "the DC link is not higher, by more than its sensor errs, for three periods with a gate on")           \
    I(PERSIST, "persist", 10.0, "ms", "enable = on, bridge off and no refusal do not last so long")          \
    I(AWAY, "away", 0.1, "rated torque",                                                                     \
      "without a fault the torque of a motor that runs does not move the speed further away from its "       \
      "reference, by more than that, in both halves of 100 ms, of three time constants of a slower speed "   \
      "control, or of the time in which its integral takes up the torque; in a quick stop it does not "      \
      "drive for 100 ms")                                                                                    \
    I(REACH, "reach", 0.1, "rated speed",                                                                    \
      "without a fault and with half of rated torque as a load at most, the mean speed of 100 ms is at its " \
      "reference to that, once start, acceleration and, with the encoder, the integral of the speed "        \
      "control "                                                                                             \
      "that a standing shaft needs are over")                                                                \
    I(NOTICE, "notice", 0.0, "-",                                                                            \
      "a fault of which the matrix promises a report is reported within it, an open wire or switch within "  \
      "60 ms of current commanded in its phase")                                                             \
    I(REASON_TRUE, "reason_true", 0.0, "-", "the reason of a latched fault is what has happened")            \
    I(LEARN, "learn", 2.0, "mrad",                                                                           \
      "one run in 8, without a fault and without encoder, is made 10 s longer, with learning and without: "  \
      "where both have been steady for 9 s the angle is not worse with learning by more, rms")

typedef enum {
#define CAMPAIGN_INVARIANT(NAME, name, limit, unit, text) CAMPAIGN_I_##NAME,
    CAMPAIGN_INVARIANTS(CAMPAIGN_INVARIANT)
#undef CAMPAIGN_INVARIANT
        CAMPAIGN_INVARIANT_COUNT
} campaign_invariant_t;
#define CAMPAIGN_NO_INVARIANT CAMPAIGN_INVARIANT_COUNT

typedef struct {
    const char *name;
    double limit; /* [unit] */
    const char *unit, *text;
} campaign_invariant_row_t;

extern const campaign_invariant_row_t campaign_invariants[CAMPAIGN_INVARIANT_COUNT];

/* ---- one run ---- */

#define CAMPAIGN_EVENTS_MAX 12u

typedef struct {
    campaign_event_kind_t kind;
    double time;  /* [s] */
    double value; /* [-] as CAMPAIGN_EVENTS say */
} campaign_event_t;

#define CAMPAIGN_FAULTS_MAX 2u

/* One that is injected. */
typedef struct {
    uint32_t kind; /* place in campaign_faults; 0: none */
    double time;   /* [s] */
    double value;  /* as its row says */
    double lasts;  /* [s] then the row goes back to what it was; 0: for good */
} campaign_injected_t;

/* A run before it is text. */
typedef struct {
    uint64_t seed; /* of the campaign */
    uint32_t run;
    double seconds;
    const scenario_t *around;                     /* NULL: everything is drawn */
    double quantities[CAMPAIGN_QUANTITY_COUNT];   /* of campaign_rows */
    campaign_event_t events[CAMPAIGN_EVENTS_MAX]; /* in order of time */
    uint32_t event_count;
    campaign_injected_t faults[CAMPAIGN_FAULTS_MAX]; /* in order of time; those without a kind are none */
    bool unlearnt;                                   /* nothing is learnt: the other run of a pair */
} campaign_case_t;

typedef enum { CAMPAIGN_NOT_DONE, CAMPAIGN_HELD, CAMPAIGN_VIOLATED, CAMPAIGN_REFUSED } campaign_end_t;

/* What came of it. */
typedef struct {
    campaign_end_t end;
    campaign_invariant_t invariant; /* that was violated */
    uint32_t period;     /* [periods] in which that was known; of a drive's fault when it latched */
    uint32_t row;        /* id of the signal that shows it; of the row that was refused */
    uint32_t fault;      /* that was injected first */
    int32_t reason;      /* [-] the drive's fault at the end; 0: none */
    uint32_t excused;    /* bits of invariants that its fault, or the gates being off, excused */
    uint32_t from;       /* [periods] since when the invariant was violated */
    uint32_t latched;    /* [periods] when the fault `reason` latched; 0: none */
    uint32_t reproduced; /* 1: a violation whose scenario, read anew from its text, failed as it says */
    uint32_t second;     /* fault that was injected after the first */
    uint32_t
        calm; /* 1: a healthy run that nothing can take beyond its limits: a fault in it is a false alarm */
} campaign_result_t;

/* Draw k of run n of seed S in [0, 1): of all 64-bit words as far apart as SplitMix64's output function
 * makes them. */
double campaign_random(uint64_t seed, uint32_t run, uint32_t draw);

void campaign_draw(uint64_t seed, uint32_t run, double seconds, campaign_case_t *drawn);

/* The same around a scenario, which must outlive the case: its course and its drive stay, what is wrong with
 * its plant and the seed of its noise are drawn; no fault. */
void campaign_draw_around(uint64_t seed, uint32_t run, const scenario_t *scenario, campaign_case_t *drawn);

/* What the case's quantities are: the campaign's own, or the errors around its scenario. Their number. */
uint32_t campaign_rows(const campaign_case_t *drawn, const campaign_quantity_row_t **rows);

/* The scenario as text, with an expectation that fails where `result` tells of a violation that a signal
 * shows. Returns its length; 0: it does not fit. */
size_t campaign_text(const campaign_case_t *drawn, const campaign_result_t *result, char *to, size_t size);

/* Runs it and judges it; stops at the first violation. false: interrupted by `stop`. */
bool campaign_run(const campaign_case_t *drawn, const volatile sig_atomic_t *stop, campaign_result_t *result);

/* The smallest case found that breaks the same invariant, in its place, and its result. Returns how many runs
 * it took. */
uint32_t campaign_shrink(campaign_case_t *drawn, campaign_result_t *result,
                         const volatile sig_atomic_t *stop);

/* Does the text of the scenario, read anew, fail as it says? True also where no signal shows the violation
 * but the judge finds it again. The drive's fault in the result is then the one that the file's own run ends
 * with, which may come after the violation. */
bool campaign_reproduces(const campaign_case_t *drawn, campaign_result_t *result);

/* ---- many ---- */

typedef struct {
    uint64_t seed;
    uint32_t runs;
    double seconds;             /* [s] of each */
    const scenario_t *scenario; /* that all runs are around; NULL: everything is drawn */
    uint32_t shard;             /* 1.. */
    uint32_t shards;            /* 1.. */
    unsigned threads;           /* 1.. */
    bool as_drawn;              /* violations are not made smaller */
    const volatile sig_atomic_t *stop;
    /* Each finished run, by one thread at a time; scenario is that of a violation, else NULL. false: it could
     * not be kept, and the campaign ends. */
    bool (*keep)(void *context, uint32_t run, const campaign_result_t *result, const char *scenario);
    void (*progress)(void *context, uint32_t done, uint32_t of); /* may be NULL */
    void *context;
} campaign_t;

/* `results` [runs]: those that are done are left alone, so that a campaign goes on where it was. false: keep
 * failed, or there was no memory; `why` has the text. */
bool campaign_all(const campaign_t *campaign, campaign_result_t *results, char why[POOL_WHY]);

/* ---- results as text ---- */

/* Share of the calm runs that may end in a fault of the drive; the summary judges it (campaign_alarms). */
#define CAMPAIGN_ALARM_RATE 0.002

/* How many runs are calm and how many of them ended in a fault. true: no more than CAMPAIGN_ALARM_RATE
 * explains: so many or more come by chance once in a million campaigns. */
bool campaign_alarms(const campaign_t *campaign, const campaign_result_t *results, uint32_t *calm,
                     uint32_t *alarms);

#define CAMPAIGN_LINE_SIZE 160u

/* First line of a results file: what must be the same in all that are merged. */
void campaign_head(const campaign_t *campaign, char line[CAMPAIGN_LINE_SIZE]);

/* Reads a first line: seed, runs, seconds. false: it is none, or of a program with other tables. */
bool campaign_read_head(const char *line, campaign_t *campaign);

/* Names of the fields of a line; they follow the head. */
#define CAMPAIGN_COLUMNS                                                                                     \
    "run,end,invariant,period,row,injected,reason,excused,from,reproduced,latched,second,calm\n"

void campaign_line(uint32_t run, const campaign_result_t *result, char line[CAMPAIGN_LINE_SIZE]);
bool campaign_read_line(const char *line, uint32_t runs, uint32_t *run, campaign_result_t *result);

/* Name of a violation's file. */
void campaign_file_name(uint32_t run, char name[32]);

/* The summary: the same octets however the runs were divided. Returns the number of violations; false alarms
 * beyond their rate count as one more. */
uint32_t campaign_summary(FILE *file, const campaign_t *campaign, const campaign_result_t *results,
                          bool json);

#endif
