/* The error map: how far the estimated angle is off, over speed, direction and load, when the drive believes
 * something wrong about its machine or its sensors are worse than they should be; without and with what the
 * drive can learn of it while it runs.
 *
 * A point is one run on a rig of its own: the rotor is brought to its speed and load, the drive holds it
 * there sensorless, and theta_hat - theta (electrical, the estimate closes the loop) is averaged over whole
 * electrical periods. A deviation changes what the drive believes and leaves the machine alone; those of
 * sensors, of a leg and of the EMF's harmonics change these.
 *
 * What theory says of the mean [rad], with dR, dL = believed - true resistance and L_q, and i_d, i_q in the
 * frame of the estimate:
 *
 *     asin((dR i_d/omega - dL i_q)/(psi_f + (L_d - L_q) i_d))
 *
 * which is what the observer takes for EMF across the real one. R is without effect while i_d = 0. psi_f
 * never has one: it sets the feed-forward's speed only, which the loop's integrator makes up for. With
 * adaptation on it is the L of that moment that counts.
 *
 * Any speed: where an electrical turn is a whole number of samples, or a half and a half, each turn meets the
 * same few codes of the ADC and the same ripple at its zero crossings, and the mean depends on the angle at
 * which the first sample happened to lie, by 2 mrad at 1000 r/min: two points of one map are then two
 * different draws. So each point runs at the speed nearest to its own at which a turn begins a share of
 * (3 - sqrt 5)/2 of a sample earlier or later than the last one, by which the samples spread over the turn as
 * evenly as they can: at most 0.38 samples a turn away, 0.25 % at 1000 r/min and four pole pairs. What is
 * measured is the mean over all angles at which one could have started.
 *
 * Fidelity: mean voltages take a leg's dead-time loss from one current a period, gate edges from the current
 * at each edge, ripple included. From 1000 r/min without load that moves the mean by 2 mrad; elsewhere both
 * agree within 0.4 mrad, unless the dead time is wrong. So the default is every edge, at twice the time.
 *
 * Conditions. Real: the paper's drive, i_d = 0; inverter of the plant's defaults (2.5 us dead time, delays,
 * drops) and compensated, 12-bit ADC, noise 10 mA, offset 30 mA that came after the calibration and gain
 * error 0.2 % on sensor a. Ideal: inverter and sensors without error; deviations of the machine only, since
 * the others have no meaning there. Of a scenario: what its tables params, plant and rig say before t = 0,
 * the offset as if it had been there at the calibration.
 *
 * Same setup: same bits, in any number of threads. Does not handle: acceleration, standstill. */
#ifndef HOST_SIM_LAB_MAP_H
#define HOST_SIM_LAB_MAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/lab/pool.h"
#include "host_sim/lab/scenario.h"

#define MAP_SPEEDS_MAX 16u
#define MAP_LOADS_MAX  4u
#define MAP_RPM_MIN    10.0   /* [r/min] slower, one electrical period takes seconds */
#define MAP_RPM_MAX    1900.0 /* [r/min] what DC link and overspeed trip leave, with 5 N m */
#define MAP_LOAD_MAX   10.0   /* [N m] at the current limit */

typedef enum {
    MAP_NOMINAL,
    MAP_FLUX_LOW, /* psi_f believed 10 % too small */
    MAP_FLUX_HIGH,
    MAP_RESISTANCE_LOW, /* R believed 50 % too small */
    MAP_RESISTANCE_HIGH,
    MAP_INDUCTANCE_LOW, /* L believed 20 % too small */
    MAP_INDUCTANCE_HIGH,
    MAP_DEAD_TIME_LOW, /* dead time believed 0.5 us too small */
    MAP_DEAD_TIME_HIGH,
    MAP_OFFSET,    /* 50 mA left on sensor a */
    MAP_NOISE,     /* 20 mA rms */
    MAP_HARMONICS, /* 3 % of 5th and 2 % of 7th in the EMF */
    MAP_LEG,       /* drops of leg a 0.5 V larger */
    MAP_GAIN,      /* sensor a reads 1 % too much */
    MAP_DEVIATIONS
} map_deviation_t;

typedef enum {
    MAP_ADAPTATION_OFF, /* every row that learns about the machine is 0 */
    MAP_ADAPTATION_ON,  /* each as by default or in the scenario, or if that is 0, as in map.c */
    MAP_ADAPTATIONS
} map_adaptation_t;

typedef struct {
    double speeds[MAP_SPEEDS_MAX]; /* [r/min] each in both directions; MAP_RPM_MIN..MAP_RPM_MAX, ascending */
    size_t speed_count;            /* [-] 1..MAP_SPEEDS_MAX */
    double loads[MAP_LOADS_MAX];   /* [N m] against the rotation, besides the friction; 0..MAP_LOAD_MAX */
    size_t load_count;             /* [-] 1..MAP_LOADS_MAX */
    bool columns[MAP_ADAPTATIONS]; /* [-] which of them to run; at least one */
    bool left_out[MAP_DEVIATIONS]; /* [-] deviations that the map does without */
    const scenario_t *scenario;    /* what to run on; NULL: the conditions above */
    bool ideal;                    /* [-] inverter and sensors without error; not with a scenario */
    bool averaged;                 /* [-] mean voltages instead of every gate edge */
    uint64_t seed;                 /* of all noise, the same for every point */
    double settle;                 /* [s] before the window, adaptation off */
    double learn;  /* [s] the same with it on, from 20 Hz electrical up; slower more, at most twice as much */
    double window; /* [s] rounded up to whole electrical turns */
    void (*progress)(void *context, double fraction); /* after each point; NULL: nobody */
    void *progress_context;
    double turns; /* [-] of them at least, whole: what noise leaves of the mean falls with their number */
} map_setup_t;

typedef struct {
    /* which */
    double rpm;                  /* as asked for [r/min], sign = direction */
    double load;                 /* [N m] */
    map_deviation_t deviation;   /* [-] */
    map_adaptation_t adaptation; /* [-] */
    /* what came of it, over the window */
    double mean_mrad;   /* of theta_hat - theta [mrad] */
    double sd_mrad;     /* standard deviation about the mean [mrad] */
    double peak_mrad;   /* largest magnitude, mean included [mrad] */
    double theory_mrad; /* what R and L as they are believed make of the mean [mrad]; NAN: not locked, or no
                           deviation of theirs nor of psi_f, nor nominal */
    double true_rpm;    /* mean of the rotor's speed [r/min] */
    double i_d, i_q;    /* means, in the frame of the estimate [A] */
    double inductance;  /* L_q as believed, mean [H] */
    double confidence;  /* in it, the drive's own, mean [-] */
    int32_t fault;      /* [-] the drive's reason; 0: none */
    bool locked;        /* [-] see map_run */
} map_point_t;

/* Judgement of one claim of theory over all points that it speaks of. */
typedef struct {
    double worst_mrad;        /* largest distance from it [mrad] */
    double limit_mrad;        /* that is accepted [mrad] */
    const map_point_t *worst; /* where; NULL: no point could be judged */
    size_t judged;            /* [-] points */
    size_t lost;              /* [-] points that are not locked: nothing can be said of them */
    bool met;                 /* [-] every point is judged, and within the limit */
    bool silent;              /* [-] the claim speaks of none of the points */
} map_verdict_t;

typedef enum {
    /* L rows, with the L that the drive believed at the time: how far the mean lies from the nominal row's,
     * theory taken off both. */
    MAP_CLAIM_INDUCTANCE,
    /* psi_f and R rows, adaptation off: the same, beyond a fifth of what theory says. A dither of i_d makes R
     * an error that swings. */
    MAP_CLAIM_NO_EFFECT,
    /* L rows with adaptation, where the drive is sure of its L: how far the mean lies from the nominal row's.
     */
    MAP_CLAIM_LEARNT,
    MAP_CLAIMS
} map_claim_t;

typedef struct {
    char text[POOL_WHY]; /* one line */
} map_error_t;

/* The map as the command line draws it without options: 100 to 1490 r/min, no load and 5 N m, both columns.
 * Until the window the drive has trimmed away what offset it finds while turning; its noise leaves 0.2 mrad
 * of the mean at 100 r/min. */
map_setup_t map_setup_default(void);

/* "L +20 %"; "nominal". */
const char *map_deviation_name(map_deviation_t deviation);

/* How many points the setup makes. */
size_t map_count(const map_setup_t *setup);

/* Plant, parameters and sensors of a scenario, as they are before t = 0, and its loads (magnitudes of
 * plant.load_torque, those of its events included) in place of the setup's; if speed_count is 0, also
 * its speeds (of speed_request). The scenario must outlive the setup. false: `error` names the setting of the
 * file that no point can be made of. */
bool map_of_scenario(map_setup_t *setup, const scenario_t *scenario, scenario_error_t *error);

/* "off", "on" */
const char *map_adaptation_name(map_adaptation_t adaptation);

/* The point of these; NULL: the map has none. */
const map_point_t *map_find(const map_point_t *points, size_t count, map_deviation_t deviation, double rpm,
                            double load, map_adaptation_t adaptation);

/* Of a point: at which speed it runs [r/min] (see "Any speed" above), and for how many periods of the PWM it
 * is averaged, which are, to the nearest, whole electrical ones, as many as setup->window needs, and
 * setup->turns. */
typedef struct {
    double rpm;
    uint32_t periods;
} map_window_t;
map_window_t map_window(const map_setup_t *setup, double rpm);

/* Runs all points, in this many threads (at least 1), and fills points[map_count]: deviation by deviation,
 * load by load, adaptation off and on, speeds ascending from the fastest reverse one. A point is locked if at
 * the end no fault is latched and the drive is on and runs on the estimate, |mean| and SD are below 250 mrad
 * and the true mean speed is within 5 % or 10 r/min of the reference, whichever is more. A point that is
 * not locked has numbers nevertheless; if its fault came before the window, they are those of a rotor that
 * coasts. false: `why` says what was refused. */
bool map_run(const map_setup_t *setup, map_point_t *points, unsigned threads, map_error_t *why);

/* A map of a scenario is judged by what the drive promises of its motor, not by a first-order law: it keeps
 * the rotor at every point, and with right data the angle is within the limits that `lagless tune` writes. */
#define MAP_OWN_MEAN 30.0 /* [mrad] of the mean, with right data */
#define MAP_OWN_SD   50.0 /* [mrad] */

typedef struct {
    const map_point_t *largest;  /* largest mean of all points that are locked; NULL: none is */
    const map_point_t *nominal;  /* the same of those with right data */
    const map_point_t *restless; /* largest SD of these */
    const map_point_t *lost;     /* the first that is not locked; NULL: none */
    size_t lost_count;           /* [-] */
    double limit_mrad;           /* [mrad] that the means with right data have to keep */
    bool held, accurate;         /* [-] the two promises */
} map_own_t;
map_own_t map_judge_own(const map_point_t *points, size_t count);

/* Judges one claim over points from map_run. A map without points of a claim does not meet it, nor
 * contradict it. */
map_verdict_t map_judge(const map_point_t *points, size_t count, map_claim_t claim);

#endif
