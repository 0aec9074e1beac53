/* The error map: the error of the estimated angle over speed, direction and load, with wrong configured data
 * of the motor, and with additional errors of sensors and inverter; without and with adaptation.
 *
 * A point is one run on its own rig. The rotor is brought to its speed and load, and the drive keeps it there
 * without encoder. The electrical error theta_hat - theta is averaged over whole electrical periods. A
 * deviation changes a configured value and leaves the motor unchanged. Deviations of sensors, of a leg and of
 * the EMF's harmonics change the plant.
 *
 * Theory of the mean error [rad], with dR, dL = configured - true R and L_q, and i_d, i_q in the frame of the
 * estimate:
 *
 *     asin((dR i_d/omega - dL i_q)/(psi_f + (L_d - L_q) i_d))
 *
 * The numerator is the voltage across the true EMF that the observer takes for EMF. R has no effect while i_d
 * = 0. psi_f never has an effect: it changes only the speed of the feed-forward, and the integrator of the
 * loop compensates this. With adaptation on, L is the present learnt value.
 *
 * Speeds: at some speeds an electrical turn is a whole or half-integer number of samples. Each turn then has
 * the same few codes of the ADC, and the same ripple at its zero crossings. The mean would depend on the
 * angle of the first sample, by 2 mrad at 1000 r/min. Therefore each point runs at a speed near its nominal
 * one, at which each turn begins (3 - sqrt 5)/2 of a sample earlier or later than the previous one. The
 * samples are then distributed evenly over the turn, and the result is the mean over all initial angles. The
 * speed differs by at most 0.38 samples a turn, 0.25 % at 1000 r/min and four pole pairs.
 *
 * Fidelity: with mean voltages the dead-time loss of a leg follows from one current per period. With gate
 * edges it follows from the current at each edge, including the ripple. Above 1000 r/min without load this
 * changes the mean by 2 mrad. At other points both agree within 0.4 mrad, unless the dead time is wrong.
 * Therefore the default is every edge, which takes twice the time.
 *
 * Conditions. Real: the paper's drive with i_d = 0. The inverter has the plant's defaults (2.5 us dead time,
 * delays, drops) and is compensated. ADC of 12 bits, noise 10 mA; sensor a has a gain error of 0.2 % and an
 * offset of 30 mA that appeared after the calibration. Ideal: inverter and sensors without error, with
 * deviations of the motor data only. Scenario: its tables params, plant and rig at t = 0; the offset exists
 * at the calibration.
 *
 * The same setup gives the same bits with any number of threads. Does not handle: acceleration, standstill.
 */
#ifndef HOST_SIM_LAB_MAP_H
#define HOST_SIM_LAB_MAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/lab/pool.h"
#include "host_sim/lab/scenario.h"

#define MAP_SPEEDS_MAX 16u
#define MAP_LOADS_MAX  4u
#define MAP_RPM_MIN    10.0   /* [r/min] at lower speeds one electrical period takes seconds */
#define MAP_RPM_MAX    1900.0 /* [r/min] limit by DC link and overspeed trip, with 5 N m */
#define MAP_LOAD_MAX   10.0   /* [N m] at the current limit */

typedef enum {
    MAP_NOMINAL,
    MAP_FLUX_LOW, /* psi_f configured 10 % too small */
    MAP_FLUX_HIGH,
    MAP_RESISTANCE_LOW, /* R configured 50 % too small */
    MAP_RESISTANCE_HIGH,
    MAP_INDUCTANCE_LOW, /* L configured 20 % too small */
    MAP_INDUCTANCE_HIGH,
    MAP_DEAD_TIME_LOW, /* dead time configured 0.5 us too small, or a fifth of less than 2.5 us */
    MAP_DEAD_TIME_HIGH,
    MAP_OFFSET,    /* 50 mA of offset remain on sensor a */
    MAP_NOISE,     /* 20 mA rms */
    MAP_HARMONICS, /* 3 % of 5th and 2 % of 7th in the EMF */
    MAP_LEG,       /* drops of leg a 0.5 V larger */
    MAP_GAIN,      /* sensor a reads 1 % too much */
    MAP_DEVIATIONS
} map_deviation_t;

typedef enum {
    MAP_ADAPTATION_OFF, /* all parameters of adaptation are 0 */
    MAP_ADAPTATION_ON,  /* each has its default or the value of the scenario; if this is 0, the value in map.c
                         */
    MAP_ADAPTATIONS
} map_adaptation_t;

typedef struct {
    double speeds[MAP_SPEEDS_MAX]; /* [r/min] each in both directions; MAP_RPM_MIN..MAP_RPM_MAX, ascending */
    size_t speed_count;            /* [-] 1..MAP_SPEEDS_MAX */
    double loads[MAP_LOADS_MAX];   /* [N m] against the rotation, besides the friction; 0..MAP_LOAD_MAX */
    size_t load_count;             /* [-] 1..MAP_LOADS_MAX */
    bool columns[MAP_ADAPTATIONS]; /* [-] columns to run; at least one */
    bool left_out[MAP_DEVIATIONS]; /* [-] deviations that are omitted */
    const scenario_t *scenario;    /* scenario of the map; NULL: the conditions above */
    bool ideal;                    /* [-] inverter and sensors without error; not with a scenario */
    bool averaged;                 /* [-] mean voltages instead of every gate edge */
    uint64_t seed;                 /* of all noise, the same for every point */
    double settle;                 /* [s] before the window, adaptation off */
    double learn;  /* [s] the same with adaptation on, above 20 Hz electrical; longer at lower speeds, at most
                      twice */
    double window; /* [s] rounded up to whole electrical turns */
    void (*progress)(void *context, double fraction); /* called after each point; may be NULL */
    void *progress_context;
    double turns; /* [-] least whole number of electrical turns in the window; more turns reduce the noise of
                     the mean */
} map_setup_t;

typedef struct {
    /* the point */
    double rpm;                  /* requested speed [r/min], sign = direction */
    double load;                 /* [N m] */
    map_deviation_t deviation;   /* [-] */
    map_adaptation_t adaptation; /* [-] */
    /* the results over the window */
    double mean_mrad;   /* of theta_hat - theta [mrad] */
    double sd_mrad;     /* standard deviation about the mean [mrad] */
    double peak_mrad;   /* largest magnitude, mean included [mrad] */
    double theory_mrad; /* mean by theory, with the R and L that the drive uses [mrad]; NAN: not locked, or a
                           deviation other than nominal, R, L, psi_f */
    double true_rpm;    /* mean of the rotor's speed [r/min] */
    double i_d, i_q;    /* means, in the frame of the estimate [A] */
    double inductance;  /* mean of the L_q that the drive uses [H] */
    double confidence;  /* mean of the drive's inductance_confidence [-] */
    int32_t fault;      /* [-] the drive's reason; 0: none */
    bool locked;        /* [-] see map_run */
} map_point_t;

/* Judgement of one claim of the theory over all points for which the claim is made. */
typedef struct {
    double worst_mrad;        /* largest difference from the claim [mrad] */
    double limit_mrad;        /* largest accepted difference [mrad] */
    const map_point_t *worst; /* point with the largest difference; NULL: no point could be judged */
    size_t judged;            /* [-] points */
    size_t lost;              /* [-] points that are not locked and cannot be judged */
    bool met;                 /* [-] every point is judged, and within the limit */
    bool silent;              /* [-] the claim applies to none of the points */
} map_verdict_t;

typedef enum {
    /* Deviations of L, with the L that the drive used: difference of the mean from that of the nominal
       points, after the theoretical value has been subtracted from both. */
    MAP_CLAIM_INDUCTANCE,
    /* Deviations of psi_f and R, adaptation off: the same, reduced by a fifth of the theoretical value. A
       dither of i_d makes the error due to R oscillate. */
    MAP_CLAIM_NO_EFFECT,
    /* Deviations of L with adaptation and a high inductance_confidence: difference of the mean from that of
       the nominal points. */
    MAP_CLAIM_LEARNT,
    MAP_CLAIMS
} map_claim_t;

typedef struct {
    char text[POOL_WHY]; /* one line */
} map_error_t;

/* The map of the command line without options: 100 to 1490 r/min, no load and 5 N m, both columns. Before the
 * window begins the drive has trimmed the offset. The noise of the trim causes 0.2 mrad of the mean at 100
 * r/min. */
map_setup_t map_setup_default(void);

/* "L +20 %"; "nominal". */
const char *map_deviation_name(map_deviation_t deviation);

/* Number of points of the setup. */
size_t map_count(const map_setup_t *setup);

/* Replaces plant, parameters and sensors of the setup by those of a scenario at t = 0, and its loads by the
 * magnitudes of plant.load_torque, including those of events. If speed_count is 0, the speeds of
 * speed_request replace the setup's speeds as well. The scenario must exist as long as the setup. false: a
 * setting of the file cannot be used; `error` names it. */
bool map_of_scenario(map_setup_t *setup, const scenario_t *scenario, scenario_error_t *error);

/* "off", "on" */
const char *map_adaptation_name(map_adaptation_t adaptation);

/* The point with these values; NULL: the map has none. */
const map_point_t *map_find(const map_point_t *points, size_t count, map_deviation_t deviation, double rpm,
                            double load, map_adaptation_t adaptation);

/* Speed of a point [r/min] (see "Speeds" above), and number of PWM periods of its window. The window is a
 * whole number of electrical periods, to the nearest PWM period, and has at least the length setup->window
 * and setup->turns turns. */
typedef struct {
    double rpm;
    uint32_t periods;
} map_window_t;
map_window_t map_window(const map_setup_t *setup, double rpm);

/* Runs all points with this number of threads (at least 1), and fills points[map_count] in the order
 * deviation, load, adaptation off and on, speed. Speeds ascend from the fastest reverse one. A point is
 * locked under three conditions. At the end no fault is latched, and the drive is on and uses the estimate.
 * |mean| and SD are below 250 mrad. The true mean speed is within 5 % or 10 r/min of the reference, whichever
 * is more. A point that is not locked has numbers as well; if its fault occurred before the window, they are
 * those of a rotor that coasts. false: the rig refused something; `why` has the message. */
bool map_run(const map_setup_t *setup, map_point_t *points, unsigned threads, map_error_t *why);

/* A map of a scenario is judged by two promises of the drive instead of a first-order law: it never loses the
 * rotor, and with right data the angle is within the limits that `lagless tune` writes. */
#define MAP_OWN_MEAN 30.0 /* [mrad] of the mean, with right data */
#define MAP_OWN_SD   50.0 /* [mrad] */

typedef struct {
    const map_point_t *largest;  /* largest mean of all locked points; NULL: there is none */
    const map_point_t *nominal;  /* the same of the points with right data */
    const map_point_t *restless; /* the largest SD of the points with right data */
    const map_point_t *lost;     /* the first that is not locked; NULL: none */
    size_t lost_count;           /* [-] */
    double limit_mrad;           /* [mrad] limit of the means with right data */
    bool held, accurate;         /* [-] the two promises */
} map_own_t;
map_own_t map_judge_own(const map_point_t *points, size_t count);

/* Judges one claim over the points of map_run. A map without points of a claim neither meets nor contradicts
 * it. */
map_verdict_t map_judge(const map_point_t *points, size_t count, map_claim_t claim);

#endif
