/* Thousands of random runs. Rules that must hold in all runs judge every period of each of them.
 *
 * Run n of seed S is a scenario with a random motor, load, inverter and sensors, random configured data and a
 * random profile of requests. Half of the runs also have one or two faults at random times. A counter gives
 * the random values (campaign_random). Therefore run n does not depend on the order of the runs, the number
 * of threads or the shard. The campaign runs the text of the scenario, so that the scenario in the file of a
 * violation gives the same bits again.
 *
 * A run that violates an invariant is minimised (campaign_shrink): every value that the violation does not
 * need returns to its default.
 *
 * Results are lines of text in any order. Each line is complete with its line end, so that an interrupted
 * campaign keeps its finished runs. Any number of result files can be merged.
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

/* Groups of quantities. Minimisation first returns all quantities of a group to their defaults together. */
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
    CAMPAIGN_LOG,   /* its logarithm evenly from that of least to that of most */
    CAMPAIGN_WHOLE, /* a whole number from least to most, all equally probable */
    CAMPAIGN_HALF,  /* in half of the runs evenly from least to most, in the other half the default */
    CAMPAIGN_FEW,   /* in an eighth of the runs evenly from least to most, in the others the default */
    CAMPAIGN_THIRD, /* evenly in the third of the runs that have a salient motor; it has its own random stream
                     */
    CAMPAIGN_OWN,   /* as CAMPAIGN_FEW, with its own random stream */
} campaign_law_t;

/* clang-format off */
/* K(name, group, law, default, least, most, "unit", "meaning"). Voltages and currents are those of the default board. On another board they
 * are scaled with its link voltage, its current limit or the range of its sensors (CAMPAIGN_LINK, _LIMIT, _RANGE of campaign_space.c). */
#define CAMPAIGN_QUANTITIES(K) \
    K(motor_drawn,      MOTOR,   EVEN,  0.0,   1.0,   1.0,   "-",       "0: the default motor, 1: the random motor") \
    K(inertia,          MOTOR,   LOG,   0.01,  1e-6,  0.1,   "kg m^2",  "inertia of everything that turns") \
    K(current,          MOTOR,   LOG,   CAMPAIGN_LIMIT(5.0), CAMPAIGN_LIMIT(0.5), CAMPAIGN_LIMIT(10.0),  "A",       "rated current, peak value; for a light rotor limited to a run-up in 4 ms") \
    K(run_up,           MOTOR,   LOG,   0.1,   4e-3,  1.0,   "s",       "time to rated speed with rated torque; the rated speed is 60 to 1000 rad/s") \
    K(emf_share,        MOTOR,   EVEN,  0.7,   0.5,   0.75,  "-",       "EMF at rated speed divided by the largest voltage of the link") \
    K(pole_pairs,       MOTOR,   WHOLE, 4.0,   1.0,   8.0,   "-",       "pole pairs p; fewer if p times the speed would exceed 2000 rad/s") \
    K(reactance,        MOTOR,   LOG,   0.2,   0.05,  0.4,   "-",       "omega_e L I divided by the EMF at rated speed; more if ripple and catch require it, less if the noise requires it") \
    K(resistive,        MOTOR,   LOG,   0.04,  0.01,  0.1,   "-",       "R I divided by the EMF at rated speed") \
    K(saliency,         MOTOR,   HALF,  1.0,   1.0,   1.19,  "-",       "L_q/L_d, limited to the range that the drive accepts without encoder") \
    K(friction,         SHAFT,   EVEN,  0.0,   0.0,   0.15,  "-",       "dry friction divided by rated torque") \
    K(stiction,         SHAFT,   HALF,  0.0,   1.0,   1.5,   "-",       "break-away torque divided by dry friction; 0: none") \
    K(viscous,          SHAFT,   HALF,  0.0,   0.0,   0.1,   "-",       "viscous friction at rated speed divided by rated torque") \
    K(load_kind,        SHAFT,   WHOLE, 0.0,   0.0,   1.0,   "-",       "0: passive load, 1: active load") \
    K(load,             SHAFT,   HALF,  0.0,   0.05,  0.5,   "-",       "load divided by rated torque") \
    K(second_mass,      SHAFT,   HALF,  0.0,   0.2,   3.0,   "-",       "inertia behind an elastic shaft divided by that of the motor; 0: none") \
    K(resonance,        SHAFT,   LOG,   600.0, 100.0, 2000.0, "rad/s",  "natural frequency of the elastic shaft, both ends free") \
    K(fan,              SHAFT,   FEW,   0.0,   0.05,  0.3,   "-",       "load that grows with the square of the speed: its value at rated speed divided by rated torque") \
    K(sine,             SHAFT,   FEW,   0.0,   0.02,  0.2,   "-",       "load that varies with the shaft's angle: its amplitude divided by rated torque") \
    K(sine_cycles,      SHAFT,   WHOLE, 1.0,   1.0,   6.0,   "-",       "cycles of that load in a turn") \
    K(spring,           SHAFT,   FEW,   0.0,   0.05,  0.3,   "-",       "torque of a spring after the whole run at rated speed, divided by rated torque") \
    K(emf_5th, POWER, HALF, 0.0, -0.03, 0.03, "-", "fifth harmonic of the EMF, of the fundamental") \
    K(emf_7th, POWER, HALF, 0.0, -0.03, 0.03, "-", "seventh harmonic of the EMF, of the fundamental") \
    K(dc_voltage,       POWER,   EVEN,  CAMPAIGN_LINK(311.0), CAMPAIGN_LINK(270.0), CAMPAIGN_LINK(340.0), "V",       "voltage of the source") \
    K(dc_edge,          POWER,   FEW,   0.0,   -1.0,  1.0,   "-",       "above 0: the source is at most 3 % below dc_overvoltage; below 0: at most 5 % above dc_undervoltage") \
    K(dc_soft,          POWER,   HALF,  0.0,   0.3e-3, 3e-3, "F",       "capacitor of the link behind 0.5 ohm; 0: a stiff link") \
    K(turn_on_delay,    POWER,   EVEN,  1.0,   0.8,   1.2,   "-",       "true turn-on delay of the module divided by that of the data sheet") \
    K(drops,            POWER,   EVEN,  1.0,   0.8,   1.2,   "-",       "true voltage drops of IGBT and diode divided by those of the data sheet") \
    K(leg_drop,         POWER,   HALF,  0.0, 0.0, CAMPAIGN_LINK(1.0),   "V",       "additional voltage drop of leg b") \
    K(leg_delay,        POWER,   HALF,  0.0,   0.0,   0.2e-6, "s",      "additional delay of leg c") \
    K(leg_resistance,   POWER,   HALF,  0.0,   0.0,   0.2,   "-",       "additional resistance of leg a divided by that of the motor") \
    K(offset_a,         SENSORS, EVEN,  0.0, CAMPAIGN_RANGE(-0.2), CAMPAIGN_RANGE(0.2),   "A",       "offset of current sensor a before its calibration") \
    K(offset_b,         SENSORS, EVEN,  0.0, CAMPAIGN_RANGE(-0.2), CAMPAIGN_RANGE(0.2),   "A",       "offset of current sensor b before its calibration") \
    K(gain_a,           SENSORS, EVEN,  0.0,   -0.01, 0.01,  "-",       "gain error of current sensor a") \
    K(gain_b,           SENSORS, EVEN,  0.0,   -0.01, 0.01,  "-",       "gain error of current sensor b") \
    K(current_noise,    SENSORS, LOG,   CAMPAIGN_RANGE(0.01), CAMPAIGN_RANGE(0.01), CAMPAIGN_RANGE(0.03),  "A",       "noise of each current sample, rms; at least one code of the converter") \
    K(dc_gain,          SENSORS, EVEN,  0.0,   -0.02, 0.02,  "-",       "gain error of the link's sensor") \
    K(dc_noise, SENSORS, HALF, 0.0, 0.0, CAMPAIGN_LINK(1.0), "V", "noise of each sample of the link, rms") \
    K(resistance_configured, CONFIGURED, EVEN, 1.0, 0.7, 1.3, "-", "configured R divided by the true one") \
    K(inductance_configured, CONFIGURED, EVEN, 1.0, 0.7, 1.3, "-", "configured L divided by the true one") \
    K(flux_configured, CONFIGURED, EVEN, 1.0, 0.7, 1.3, "-", "configured psi_f divided by the true one") \
    K(inertia_configured, CONFIGURED, EVEN, 1.0, 0.7, 1.3, "-", "configured J divided by the true one") \
    K(dead_configured,      CONFIGURED, EVEN,  1.0,   0.7,   1.3,   "-",       "configured turn-off delay and drops divided by those of the data sheet") \
    K(encoder,          DRIVE,   WHOLE, 0.0,   0.0,   1.0,   "-",       "1: control uses the encoder, 0: sensorless") \
    K(loop_share,       DRIVE,   LOG,   1.0,   0.7,   1.4,   "-",       "pll_bandwidth divided by its rule, 6.4 sqrt(p torque/J) from 200 to 1000 rad/s; the cutoff of the feed-forward is a quarter") \
    K(encoder_lines,    DRIVE,   WHOLE, 2500.0, 512.0, 5000.0, "-",     "lines of the encoder, true and configured value") \
    K(angle,            START,   EVEN,  0.0,   0.0,   6.2831853, "rad", "angle of the rotor at t = 0, mechanical") \
    K(speed,            START,   HALF,  0.0,   -0.9,  0.9,   "-",       "speed of the rotor at t = 0 divided by rated speed") \
    K(interior,         MOTOR,   THIRD, 0.0,   1.0,   4.0,   "-",       "L_q/L_d of a salient motor, replaces saliency; less if the noise requires it; 0: not salient") \
    K(saturation,       MOTOR,   THIRD, 0.0,   -1.8,  3.0,   "-",       "saturation current of the q axis divided by the rated current; below 0.6: no saturation") \
    K(field,            MOTOR,   THIRD, 0.0,   0.0,   2.5,   "-",       "largest speed divided by the rated speed, if above 1; less if the link or the period requires it") \
    K(battery,          POWER,   OWN,   0.0,   1.0,   1.0,   "-",       "1: the source of a soft link is a battery, which takes current; 0: a rectifier") \
    K(chopper,          POWER,   OWN,   0.0,   0.90,  0.94,  "-",       "chopper_voltage of a soft link divided by dc_overvoltage, with a resistor for the rated power; 0: no chopper") \
    K(supply_drawn,     DRIVE,   OWN,   0.0,   0.3,   1.5,   "-",       "supply_current_max divided by rated power over the voltage of the source; 0: no limit") \
    K(supply_returned,  DRIVE,   OWN,   0.0,   0.05,  1.0,   "-",       "supply_current_regen_max divided by the same; 0: no limit")

/* Errors of the plant in a campaign around a scenario. The drive keeps the parameters of the scenario's file.
 * E(name, group, law, default, least, most, "unit", "meaning") */
#define CAMPAIGN_ERRORS(E) \
    E(resistance, MOTOR, EVEN, 1.0, 0.7, 1.3, "-", "true value divided by the scenario's") \
    E(inductance,       MOTOR,   EVEN,  1.0,   0.8,   1.2,   "-",       "true value divided by the scenario's, both axes") \
    E(flux_linkage, MOTOR, EVEN, 1.0, 0.9, 1.1, "-", "true value divided by the scenario's") \
    E(inertia, SHAFT, LOG, 1.0, 0.7, 1.4, "-", "true value divided by the scenario's") \
    E(friction,         SHAFT,   LOG,   1.0,   0.5,   2.0,   "-",       "true value divided by the scenario's, each kind of friction") \
    E(dc_voltage, POWER, EVEN, 1.0, 0.9, 1.05, "-", "true value divided by the scenario's") \
    E(turn_on_delay,    POWER,   EVEN,  1.0,   0.8,   1.2,   "-",       "true value divided by the scenario's, turn-on delay of the module") \
    E(drops,            POWER,   EVEN,  1.0,   0.8,   1.2,   "-",       "true value divided by the scenario's, IGBT and diode") \
    E(offset_a,         SENSORS, EVEN,  0.0,   -0.005, 0.005, "-",      "added to the offset of current sensor a, as a share of its range") \
    E(offset_b,         SENSORS, EVEN,  0.0,   -0.005, 0.005, "-",      "added to the offset of current sensor b, as a share of its range") \
    E(gain_a,           SENSORS, EVEN,  0.0,   -0.01, 0.01,  "-",       "added to the gain error of current sensor a") \
    E(gain_b,           SENSORS, EVEN,  0.0,   -0.01, 0.01,  "-",       "added to the gain error of current sensor b") \
    E(current_noise, SENSORS, LOG, 1.0, 0.5, 3.0, "-", "true value divided by the scenario's") \
    E(dc_gain,          SENSORS, EVEN,  0.0,   -0.02, 0.02,  "-",       "added to the gain error of the link's sensor") \
    E(angle,            START,   EVEN,  0.0,   0.0,   6.2831853, "rad", "added to the angle of the rotor at t = 0, mechanical")

/* Events during a run. The text gives the meaning of the value.
 * V(NAME, law, least, most, "meaning") */
#define CAMPAIGN_EVENTS(V) \
    V(SPEED,       EVEN, -0.9, 0.9,  "speed_request divided by the rated speed; of a salient motor by its largest speed") \
    V(SLOW,        EVEN, -0.1, 0.1,  "speed_request divided by the rated speed") \
    V(LOAD,        EVEN, 0.0,  0.6,  "plant.load_torque divided by the rated torque") \
    V(QUICK_STOP,  EVEN, 0.0,  0.0,  "enable = quick_stop") \
    V(OFF,         EVEN, 0.0,  0.0,  "enable = off") \
    V(ON,          EVEN, 0.0,  0.0,  "enable = on") \
    V(CURRENT,     EVEN, -0.3, 0.3,  "mode = current, and i_q_request divided by the rated current") \
    V(SOURCE,      EVEN, 0.0,  0.0,  "position_source changes to the other source") \
    V(RESET,       EVEN, 0.0,  0.0,  "fault_reset = yes") \
    V(DRIFT,       EVEN, CAMPAIGN_RANGE(-0.5), CAMPAIGN_RANGE(0.5), "the offset of one current sensor changes by this value in A, at most 0.4 of overcurrent_trip, that of the other by the opposite value") \
    V(PARAMS,      EVEN, 0.0,  4.0,  "a parameter changes; the integer part is its number, the fraction the size of the change")
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

/* Scale by which the value of a fault is multiplied. */
typedef enum {
    CAMPAIGN_AS_IT_IS,
    CAMPAIGN_OF_TORQUE,  /* rated */
    CAMPAIGN_OF_CURRENT, /* rated */
    CAMPAIGN_OF_ROW,     /* the value of the row at t = 0 */
    CAMPAIGN_OF_SWITCH,  /* the value is the number of a switch; the row has one bit for each switch */
    CAMPAIGN_OF_STATE    /* the value gives the place of the bit, as a share of the drive's state */
} campaign_scale_t;

/* When a fault excuses a violation; several bits. */
typedef enum {
    CAMPAIGN_ALWAYS = 0,
    CAMPAIGN_UNTIL_TOLD =
        1, /* a current up to the promised limit, until the drive must have detected the fault */
    CAMPAIGN_TO_CEILING = 2, /* a current up to the promised limit */
    CAMPAIGN_WHILE_SLOW = 4, /* a wrong angle below campaign_blind_speed */
    CAMPAIGN_UNCODED = 8,    /* a wrong angle without the encoder */
    CAMPAIGN_STAYS = 16,     /* the effect remains after the fault has ended */
    CAMPAIGN_UNFED = 32      /* a wrong angle while a small current is commanded, which shows no open wire */
} campaign_excuse_t;

/* One fault: a row of plant or rig that changes. */
typedef struct {
    const char *name;
    const char *row;
    campaign_law_t law;
    double least, most;
    campaign_scale_t scale;
    uint32_t excused;    /* bits of the invariants that the fault alone may violate */
    const char *because; /* reason of the excuse; "" if there is none */
    uint32_t excuse;     /* campaign_excuse_t */
} campaign_fault_t;

extern const campaign_fault_t campaign_faults[];
extern const uint32_t campaign_fault_count; /* [0]: none */

/* ---- invariants ---- */

/* I(NAME, "name", limit, "unit", "rule") */
#define CAMPAIGN_INVARIANTS(I)                                                                               \
    I(NUMBER, "number", 0.0, "-", "every signal is a finite number")                                         \
    I(CURRENT, "current", 1.2, "overcurrent_trip",                                                           \
      "no true phase current exceeds this limit in three consecutive samples (200 us) while a gate may be "  \
      "on; not checked after the load has driven the rotor beyond overspeed_trip")                           \
    I(GATES, "gates", 1.0, "periods", "after this time from a latched fault no gate is on")                  \
    I(ANGLE, "angle", 0.8, "rad",                                                                            \
      "while the drive runs, the angle that control uses is not wrong by more than this for 50 ms")          \
    I(LEGS, "legs", 0.0, "-", "no leg has both switches on")                                                 \
    I(LATE, "late", 0.0, "-", "no sample is late")                                                           \
    I(CHIP, "chip", 0.0, "-", "the virtual chip reports no wrong use of a peripheral")                       \
    I(REASON, "reason", 0.0, "-", "the refusal of a parameter set names a row and a reason")                 \
    I(REPEAT, "repeat", 0.0, "-", "one of 64 runs is repeated, and ends in the same state bit for bit")      \
    I(EXPECT, "expect", 0.0, "-", "with --scenario: each expectation of the scenario is met")                \
    I(OFF, "off", 2.0 * DRIVE_WINDOW + 2.0, "periods", "after this time from enable = off no gate is on")    \
    I(STOP, "stop", 0.0, "-",                                                                                \
      "a quick stop ends at standstill within 0.5 s plus three times the time that the current limit "       \
      "needs, or seven times from a forced frame; a quick stop after a fault ends within fault_stop_time")   \
    I(TRIP_SPEED, "trip_speed", 1.05, "overspeed_trip",                                                      \
      "while the drive runs with a gate on, the shaft does not exceed this for 5 ms; without encoder the "   \
      "lag of the tracking loop is added to this time; with a wrong encoder it is 20 ms, within which this " \
      "fault must be reported")                                                                              \
    I(TRIP_LINK, "trip_link", 1.0, "dc_overvoltage",                                                         \
      "while a gate is on, the DC link does not exceed this limit plus the error of its sensor for three "   \
      "periods")                                                                                             \
    I(PERSIST, "persist", 10.0, "ms", "enable = on with the bridge off and no refusal does not last longer") \
    I(AWAY, "away", 0.1, "rated torque",                                                                     \
      "without a fault the torque of a running motor, if it exceeds this limit, does not increase the "      \
      "error of the speed in both halves of 100 ms, or of a longer time if the speed control is slower; in " \
      "a quick stop the torque does not drive for 100 ms")                                                   \
    I(REACH, "reach", 0.1, "rated speed",                                                                    \
      "without a fault and with a load of at most half of the rated torque, the mean speed of 100 ms "       \
      "differs from its reference by no more than this; not checked during start and acceleration, nor "     \
      "with the encoder until the integral of the speed control can move a shaft at standstill")             \
    I(NOTICE, "notice", 0.0, "-",                                                                            \
      "the drive reports a fault within the time that the matrix promises; an open wire or switch within "   \
      "60 ms of a commanded current in its phase")                                                           \
    I(REASON_TRUE, "reason_true", 0.0, "-", "the reason of a latched fault agrees with the true cause")      \
    I(LEARN, "learn", 2.0, "mrad",                                                                           \
      "one of 8 runs, without a fault and without encoder, is 10 s longer and is done with and without "     \
      "learning; when both have been steady for 9 s, the rms angle error with learning is not larger by "    \
      "more than this than in each of 20 runs without learning with different noise, unless each learnt "    \
      "value has a smaller error than the configured one")

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
    double value; /* [-] meaning: text of CAMPAIGN_EVENTS */
} campaign_event_t;

#define CAMPAIGN_FAULTS_MAX 2u

/* A fault that is injected. */
typedef struct {
    uint32_t kind; /* place in campaign_faults; 0: none */
    double time;   /* [s] */
    double value;  /* [unit of its row] */
    double lasts;  /* [s] after this time the row returns to its previous value; 0: permanent */
} campaign_injected_t;

/* The values of a run, from which its scenario is written. */
typedef struct {
    uint64_t seed; /* of the campaign */
    uint32_t run;
    double seconds;
    const scenario_t *around;                     /* NULL: everything is random */
    double quantities[CAMPAIGN_QUANTITY_COUNT];   /* of campaign_rows */
    campaign_event_t events[CAMPAIGN_EVENTS_MAX]; /* in order of time */
    uint32_t event_count;
    campaign_injected_t faults[CAMPAIGN_FAULTS_MAX]; /* in order of time; kind 0: no fault */
    bool unlearnt;    /* true: a run of a pair in which the drive learns nothing */
    bool true_values; /* true: the values that it would learn are configured without an error */
    uint32_t noise;   /* [-] number of the noise of the sensors; 0: the one of the run */
} campaign_case_t;

typedef enum { CAMPAIGN_NOT_DONE, CAMPAIGN_HELD, CAMPAIGN_VIOLATED, CAMPAIGN_REFUSED } campaign_end_t;

/* The result of a run. */
typedef struct {
    campaign_end_t end;
    campaign_invariant_t invariant; /* that was violated */
    uint32_t
        period;   /* [periods] time of the violation; of a false alarm the time at which the fault latched */
    uint32_t row; /* id of the signal that shows the violation, or of the row that was refused */
    uint32_t fault;      /* the fault that was injected first */
    int32_t reason;      /* [-] the drive's fault at the end; 0: none */
    uint32_t excused;    /* bits of the invariants that the injected fault, or gates that are off, excused */
    uint32_t from;       /* [periods] beginning of the violation */
    uint32_t latched;    /* [periods] time at which the fault `reason` latched; 0: none */
    uint32_t reproduced; /* 1: the text of the scenario was run again, and reproduced the violation */
    uint32_t second;     /* the fault that was injected second */
    uint32_t tracked;    /* [periods] for which a run without injected fault was on the estimate */
    uint32_t inside;     /* [periods] of these, with a true error of the angle within 3 theta_sigma */
    uint32_t share;      /* [1e-3] mean theta_sigma over the rms error in these periods */
    uint32_t calm; /* 1: a run without injected fault whose load and supply stay within limits: a fault is a
                      false alarm */
} campaign_result_t;

/* Random number k of run n of seed S, in [0, 1). The output function of SplitMix64 makes the numbers of
 * neighbouring runs independent. */
double campaign_random(uint64_t seed, uint32_t run, uint32_t draw);

void campaign_draw(uint64_t seed, uint32_t run, double seconds, campaign_case_t *drawn);

/* The same around a scenario, which must exist as long as the case. The events and the drive of the scenario
 * are unchanged. The errors of its plant and the seed of its noise are random. No fault is injected. */
void campaign_draw_around(uint64_t seed, uint32_t run, const scenario_t *scenario, campaign_case_t *drawn);

/* Sets `rows` to the table of the case's quantities: those of a free campaign, or the errors around a
 * scenario. Returns their number. */
uint32_t campaign_rows(const campaign_case_t *drawn, const campaign_quantity_row_t **rows);

/* Writes the scenario as text. If `result` contains a violation that a signal shows, the text contains an
 * expectation that fails. Returns the length; 0: the text does not fit. */
size_t campaign_text(const campaign_case_t *drawn, const campaign_result_t *result, char *to, size_t size);

/* Runs and judges the case, up to the first violation. false: `stop` has interrupted the run. */
bool campaign_run(const campaign_case_t *drawn, const volatile sig_atomic_t *stop, campaign_result_t *result);

/* Replaces the case by the smallest case found that violates the same invariant, and the result by its
 * result. Returns the number of runs that this needed. */
uint32_t campaign_shrink(campaign_case_t *drawn, campaign_result_t *result,
                         const volatile sig_atomic_t *stop);

/* Runs the text of the scenario again. true: the run fails as the text states, or no signal shows the
 * violation but the rules find it again. The result then contains the fault with which this run ends. The
 * fault may occur after the violation. */
bool campaign_reproduces(const campaign_case_t *drawn, campaign_result_t *result);

/* ---- many ---- */

typedef struct {
    uint64_t seed;
    uint32_t runs;
    double seconds;             /* [s] of each */
    const scenario_t *scenario; /* of a campaign around a scenario; NULL: everything is random */
    uint32_t shard;             /* 1.. */
    uint32_t shards;            /* 1.. */
    unsigned threads;           /* 1.. */
    bool as_drawn;              /* violations are not minimised */
    const volatile sig_atomic_t *stop;
    /* Receives each finished run, called by one thread at a time. `scenario` is the text of a violation, else
     * NULL. false: the result could not be stored, and the campaign ends. */
    bool (*keep)(void *context, uint32_t run, const campaign_result_t *result, const char *scenario);
    void (*progress)(void *context, uint32_t done, uint32_t of); /* may be NULL */
    void *context;
} campaign_t;

/* Does all runs of the campaign. Entries of `results` [runs] that are already done remain, so that an
 * interrupted campaign continues. false: `keep` failed, or there was no memory; `why` has the text. */
bool campaign_all(const campaign_t *campaign, campaign_result_t *results, char why[POOL_WHY]);

/* ---- results as text ---- */

/* Share of the calm runs that may end in a fault of the drive. campaign_alarms checks it. */
#define CAMPAIGN_ALARM_RATE 0.002

/* Counts the calm runs, and those of them that ended in a fault. true: CAMPAIGN_ALARM_RATE explains this
 * number. false: with this rate at most one of a million campaigns would have this number of faults by
 * chance. */
bool campaign_alarms(const campaign_t *campaign, const campaign_result_t *results, uint32_t *calm,
                     uint32_t *alarms);

/* Least share of the periods in which the true error of the angle is within 3 theta_sigma, and the largest
 * median of theta_sigma over the rms error. campaign_sigma() checks both. */
#define CAMPAIGN_SIGMA_INSIDE 0.99
#define CAMPAIGN_SIGMA_SHARE  3.0

/* theta_sigma beside the true error, in runs without an injected fault while the drive runs on the estimate.
 */
typedef struct {
    double periods; /* [periods] compared */
    double inside;  /* [periods] of these, with an error within 3 theta_sigma */
    double median;  /* [-] of the mean theta_sigma over the rms error, over `runs` */
    uint32_t runs;  /* that are long enough for this median */
    bool judged;    /* there are enough periods, and the set-up is not that of a scenario */
    bool kept;      /* both limits are kept */
} campaign_sigma_t;

campaign_sigma_t campaign_sigma(const campaign_t *campaign, const campaign_result_t *results);

#define CAMPAIGN_LINE_SIZE 192u

/* First line of a results file. It must be the same in all files that are merged. */
void campaign_head(const campaign_t *campaign, char line[CAMPAIGN_LINE_SIZE]);

/* Reads seed, runs and seconds from a first line. false: the line is not a first line, or comes from a
 * program with other tables. */
bool campaign_read_head(const char *line, campaign_t *campaign);

/* Names of the fields of a line. This line follows the first line. */
#define CAMPAIGN_COLUMNS                                                                                     \
    "run,end,invariant,period,row,injected,reason,excused,from,reproduced,latched,second,calm,tracked,"      \
    "inside,share\n"

void campaign_line(uint32_t run, const campaign_result_t *result, char line[CAMPAIGN_LINE_SIZE]);
bool campaign_read_line(const char *line, uint32_t runs, uint32_t *run, campaign_result_t *result);

/* Name of a violation's file. */
void campaign_file_name(uint32_t run, char name[32]);

/* Writes the summary. It does not depend on how the runs were divided into shards. Returns the number of
 * violations, plus one if there are more false alarms than their rate explains, plus one if the limits of
 * theta_sigma are judged and not kept. */
uint32_t campaign_summary(FILE *file, const campaign_t *campaign, const campaign_result_t *results,
                          bool json);

#endif
