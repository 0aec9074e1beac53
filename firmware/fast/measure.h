/* Samples to measurements: offsets of the current sensors, found while no current flows, and what is no
 * measurement at all: not a number, or a sensor at its end. The last good sample then stands in.
 *
 * While the bridge is off and the drive ready, the offsets are measured again and again, block by block, so
 * that a start finds them measured and waits for nothing. A block tells by its span whether a current flows
 * (a rotor whose EMF is beyond the link feeds it through the diodes): such a block says nothing. Offsets that
 * have moved by less than MEASURE_MOVED stay, and with them what was found while turning. A start waits for
 * the block under way only where the sensors have just moved by more. */
#ifndef FAST_MEASURE_H
#define FAST_MEASURE_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/measured.h"
#include "math/bounds.h"
#include "settings/params.h"

#define DRIVE_SAMPLE_TRIPPED    UINT32_C(1) /* the trip zone holds the gates off */
#define DRIVE_SAMPLE_FAULT_LINE UINT32_C(2) /* the power module pulls its fault line now */
#define DRIVE_SAMPLE_ENCODER    UINT32_C(4) /* quadrature phase error since the last sample */
#define DRIVE_SAMPLE_LATE       UINT32_C(8) /* this period's interrupt came too late */

/* What a sensor that the board has not reads: no temperature there is [degC]. */
#define DRIVE_NO_TEMPERATURE (-273.15f)

typedef struct {
    float i_a;               /* [A] phase currents at t_k, as the sensors say, positive into the motor */
    float i_b;               /* [A] */
    float i_c;               /* [A] with two sensors minus the sum of the others */
    float u_dc;              /* [V] DC link */
    float sink_temperature;  /* [degC] DRIVE_NO_TEMPERATURE without a sensor, this one and the next */
    float motor_temperature; /* [degC] */
    uint32_t encoder;        /* [counts] 0 .. 4 encoder_lines - 1, at t_k */
    uint32_t flags;          /* [-] DRIVE_SAMPLE_... */
} drive_samples_t;

/* A sensor that reads half a per cent less than its end, or more, is there or broken [A]. */
#define MEASURE_MIDDLE (0.5f * (DRIVE_CURRENT_MAX + DRIVE_CURRENT_MIN))
#define MEASURE_HALF   (0.4975f * (DRIVE_CURRENT_MAX - DRIVE_CURRENT_MIN))
/* What phase c may have of a sensor's range: without one of its own it is the sum of two, and within twice
 * that. */
#define MEASURE_C_SHARE (DRIVE_CURRENT_SENSORS == 3 ? 1.0f : 3.0f)

/* DC link [V] and temperatures [degC] of sensors that work are less than this together. */
#define MEASURE_LIMIT 2000.0f

/* Span of a phase current within a block up to which none flows [A]; and what an offset must have moved by,
 * as the length of the current's vector, to be taken again [A]. */
#define MEASURE_QUIET (0.02f * DRIVE_CURRENT_RANGE)
#define MEASURE_MOVED (0.005f * DRIVE_CURRENT_RANGE)

typedef struct {
    float weight;     /* 1/calibration_periods [-] */
    uint32_t periods; /* [periods] of the whole calibration */
    float offset_max; /* [A] of a sensor that is accepted */
} measure_tuning_t;

/* DUE: the sensors read another current than none, which no block has measured yet. */
typedef enum { CALIBRATION_GOES_ON, CALIBRATION_GOOD, CALIBRATION_FAILED, CALIBRATION_DUE } calibration_t;

/* A block of samples while the bridge is off. */
typedef struct {
    abc_t mean;       /* [A] sum so far, weighted */
    ab_t recent;      /* [A] low-pass of the current, offsets and trim removed */
    abc_t smallest;   /* [A] */
    abc_t largest;    /* [A] */
    uint32_t periods; /* [periods] settling and block so far */
    uint32_t unsure; /* [-] 1: a current may have flowed in the calibration: the first quiet block is taken */
    int32_t found;   /* [-] calibration_t of the last block that says something; GOES_ON: none yet */
} measure_rest_t;

typedef struct {
    abc_t offset;        /* [A] measured at zero current */
    uint32_t calibrated; /* [periods] of the calibration so far */
    measure_rest_t rest;
    measured_t measured; /* of the newest sample */
} measure_t;

/* Coefficients. One division. */
measure_tuning_t measure_prepare(const params_t *params);

/* Offsets zero, nothing measured. */
void measure_init(measure_t *measure);

/* Other coefficients from here on; offsets and a calibration under way go on, a block begins anew. */
static inline void measure_take(measure_t *measure)
{
    measure->rest.periods = 0u;
}

/* The next calibration begins anew, and so does what is measured after it. */
void measure_begin_calibration(measure_t *measure);

/* A period of the calibration: the offsets become the mean of the currents while none flows. The first
 * samples are left out, for the sensors settle, and so is what is no measurement. Failed: an offset is larger
 * than a sensor's may be. No division. */
calibration_t measure_calibrate(measure_t *measure, const measure_tuning_t *tuning,
                                const drive_samples_t *samples);

/* The bridge comes on, or the link is too low to say that no current flows: what follows begins anew. */
void measure_begin_rest(measure_t *measure);

/* A period with the bridge off. `trim` [A]: as in measure_step(). true: the offsets have moved and are those
 * of this block now, and the trim is to be 0. measure->rest.found CALIBRATION_FAILED: an offset is larger
 * than a sensor's may be. No division. */
bool measure_rest(measure_t *measure, const measure_tuning_t *tuning, const drive_samples_t *samples,
                  ab_t trim);

/* What is known of the offsets while the bridge is off. No start with DUE: its offsets would be wrong. A
 * block that is not quiet says nothing: others judge what flows there. */
calibration_t measure_found(const measure_t *measure);

/* Is this sample one of a sensor that works? */
static inline bool measure_is_good(const drive_samples_t *samples)
{
    const float others = bounds_magnitude(samples->u_dc) + bounds_magnitude(samples->sink_temperature) +
                         bounds_magnitude(samples->motor_temperature);
    return bounds_within(samples->i_a - MEASURE_MIDDLE, MEASURE_HALF) &&
           bounds_within(samples->i_b - MEASURE_MIDDLE, MEASURE_HALF) &&
           bounds_within(samples->i_c - MEASURE_MIDDLE, MEASURE_C_SHARE * MEASURE_HALF) &&
           bounds_within(others, MEASURE_LIMIT);
}

/* Does more current flow than offsets and noise show? */
static inline bool measure_current_flows(const measured_t *measured)
{
    const ab_t i = measured->current;
    return i.alpha * i.alpha + i.beta * i.beta > MEASURE_QUIET * MEASURE_QUIET;
}

/* measure->measured of this period. `trim` [A]: what the trim has found of the offsets since. No division. */
static inline void measure_step(measure_t *measure, const drive_samples_t *samples, ab_t trim)
{
    measured_t *measured = &measure->measured;
    measured->good = measure_is_good(samples);
    if (measured->good != 0u) {
        measured->current_abc = (abc_t){samples->i_a - measure->offset.a, samples->i_b - measure->offset.b,
                                        samples->i_c - measure->offset.c};
        measured->u_dc = samples->u_dc;
        measured->sink_temperature = samples->sink_temperature;
        measured->motor_temperature = samples->motor_temperature;
    }
    const ab_t current = frames_clarke(measured->current_abc);
    measured->current = (ab_t){current.alpha - trim.alpha, current.beta - trim.beta};
    measured->encoder_count = samples->encoder;
    measured->flags = samples->flags;
}

#endif
