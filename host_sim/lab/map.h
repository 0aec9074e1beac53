/* The error map: how far the estimated angle is off, over speed, direction and load, when the drive believes
 * something wrong about its machine or its sensors are worse than they should be.
 *
 * A point is one run on a rig of its own: the rotor is brought to its speed and load, the drive holds it
 * there sensorless, and theta_hat - theta (electrical, the estimate closes the loop) is averaged over whole
 * electrical periods. A deviation changes what the drive believes and leaves the machine alone; those of the
 * sensors change the sensors.
 *
 * What theory says of the mean [rad], with dL = believed - true inductance and the true current i_q:
 *
 *     L wrong         -atan(dL i_q/psi_f): the observer takes dL di/dt for EMF, at right angles to it
 *     psi_f, R wrong  nothing in steady state: psi_f sets the feed-forward's speed only, which the loop's
 *                     integrator makes up for; R i lies along the EMF while i_d = 0
 *
 * Fidelity: mean voltages take a leg's dead-time loss from one current a period, gate edges from the current
 * at each edge, ripple included. From 1000 r/min without load that moves the mean by 2 mrad; elsewhere both
 * agree within 0.4 mrad, unless the dead time is wrong. So the default is every edge, at twice the time.
 *
 * Conditions. Real: inverter of the plant's defaults (2.5 us dead time, delays, drops) and compensated,
 * 12-bit ADC, noise 10 mA, offset 30 mA that came after the calibration and gain error 0.2 % on sensor a.
 * Ideal: inverter and sensors without error; deviations of the machine only, since the others have no meaning
 * there.
 *
 * Same setup: same bits, in any number of threads. Does not handle: acceleration, standstill, salient
 * machines. */
#ifndef HOST_SIM_LAB_MAP_H
#define HOST_SIM_LAB_MAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/lab/pool.h"

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
    MAP_OFFSET, /* 50 mA left on sensor a */
    MAP_NOISE,  /* 20 mA rms */
    MAP_DEVIATIONS
} map_deviation_t;

typedef struct {
    double speeds[MAP_SPEEDS_MAX]; /* [r/min] each in both directions; MAP_RPM_MIN..MAP_RPM_MAX, ascending */
    size_t speed_count;            /* [-] 1..MAP_SPEEDS_MAX */
    double loads[MAP_LOADS_MAX];   /* [N m] against the rotation, besides the friction; 0..MAP_LOAD_MAX */
    size_t load_count;             /* [-] 1..MAP_LOADS_MAX */
    bool ideal;                    /* [-] inverter and sensors without error */
    bool averaged;                 /* [-] mean voltages instead of every gate edge */
    uint64_t seed;                 /* of all noise, the same for every point */
    double settle;                 /* [s] before the window */
    double window;                 /* [s] rounded up to whole electrical periods */
} map_setup_t;

typedef struct {
    /* which */
    double rpm;                /* reference [r/min], sign = direction */
    double load;               /* [N m] */
    map_deviation_t deviation; /* [-] */
    /* what came of it, over the window */
    double mean_mrad; /* of theta_hat - theta [mrad] */
    double sd_mrad;   /* standard deviation about the mean [mrad] */
    double peak_mrad; /* largest magnitude, mean included [mrad] */
    double
        theory_mrad; /* what the deviation adds to the mean [mrad]; NAN: no number is known, or not locked */
    double true_rpm; /* mean of the rotor's speed [r/min] */
    double i_q;      /* mean of the true one [A] */
    int32_t fault;   /* [-] the drive's reason; 0: none */
    bool locked;     /* [-] see map_run */
} map_point_t;

/* Judgement of one claim of theory over all points that it speaks of. */
typedef struct {
    double worst_mrad;        /* largest distance from it [mrad] */
    double limit_mrad;        /* that is accepted [mrad] */
    const map_point_t *worst; /* where; NULL: no point could be judged */
    size_t judged;            /* [-] points */
    size_t lost;              /* [-] points that are not locked: nothing can be said of them */
    bool met;                 /* [-] every point is judged, and within the limit */
} map_verdict_t;

typedef enum {
    MAP_CLAIM_INDUCTANCE, /* L rows: distance of the mean from that of the nominal row plus theory_mrad */
    MAP_CLAIM_NO_EFFECT,  /* psi_f and R rows: the same with nothing added */
    MAP_CLAIMS
} map_claim_t;

typedef struct {
    char text[POOL_WHY]; /* one line */
} map_error_t;

/* The map as the command line draws it without options: 101 to 1490 r/min, no load and 5 N m. None of the
 * speeds is a whole number of samples per revolution, whatever the carrier: each has a prime factor that
 * 60 x 150e6 does not have. At one that is, the same instants are sampled in every turn, and the mean depends
 * on the start angle (0.5 mrad at 500 r/min). Until the window the drive has
 * trimmed away what offset it finds while turning; its noise leaves 0.2 mrad of the mean at 101 r/min. */
map_setup_t map_setup_default(void);

/* "L +20 %"; "nominal". */
const char *map_deviation_name(map_deviation_t deviation);

/* How many points the setup makes. */
size_t map_count(const map_setup_t *setup);

/* Length of a point's window [periods of the PWM]: as many whole electrical periods as setup->window needs,
 * to the nearest sample. */
uint32_t map_window(const map_setup_t *setup, double rpm);

/* Runs all points, in this many threads (at least 1), and fills points[map_count]: deviation by deviation,
 * load by load, speeds ascending from the fastest reverse one. A point is locked if at the end no fault is
 * latched and the drive is on, |mean| and SD are below 250 mrad and the true mean speed is within 5 % or
 * 10 r/min of the reference, whichever is more; one that is not has its numbers all the same, and a point
 * whose fault came before the window has those of a rotor running out. false: `why` says what was refused. */
bool map_run(const map_setup_t *setup, map_point_t *points, unsigned threads, map_error_t *why);

/* Judges one claim over points from map_run. A map without the rows of a claim does not meet it. */
map_verdict_t map_judge(const map_point_t *points, size_t count, map_claim_t claim);

#endif
