/* Samples to measurements: the offsets of the current sensors, measured while no current flows, and the
 * rejection of invalid samples (not a number, or a sensor at its limit). The last good sample replaces an
 * invalid one.
 *
 * While the bridge is off and the drive is ready, the offsets are measured repeatedly, block by block, so
 * that they are known at a start. If the currents vary too much in a block, the block begins again. Either a
 * current flows, because the rotor's EMF exceeds the link and feeds it through the diodes, or an offset has
 * stepped. If the offsets have changed by less than MEASURE_MOVED, offsets and trim keep their values. A
 * start waits for the end of the present block only if an offset has just changed by more than this while no
 * current flows. With a current the offsets would seem to change in every block. */
#ifndef FAST_MEASURE_H
#define FAST_MEASURE_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/measured.h"
#include "math/bounds.h"
#include "settings/params.h"

#define DRIVE_SAMPLE_TRIPPED    UINT32_C(1) /* the trip zone holds the gates off */
#define DRIVE_SAMPLE_FAULT_LINE UINT32_C(2) /* the fault line of the power module is active */
#define DRIVE_SAMPLE_ENCODER    UINT32_C(4) /* quadrature phase error since the last sample */
#define DRIVE_SAMPLE_LATE       UINT32_C(8) /* the interrupt of this period came too late */
/* the enable input of the board is not active; not on a board without one */
#define DRIVE_SAMPLE_NOT_ENABLED UINT32_C(16)
/* too many of the last interrupts came too late; set by measure_late() */
#define DRIVE_SAMPLE_LATE_OFTEN UINT32_C(32)

/* [periods] A late interrupt adds MEASURE_LATE_ONE to a sum, which falls by 1 in each period.
 * MEASURE_LATE_OFTEN is reached by three late interrupts in succession, and after some time by more than one
 * in nine. */
#define MEASURE_LATE_ONE   UINT32_C(9)
#define MEASURE_LATE_OFTEN (3u * MEASURE_LATE_ONE - 2u)

/* Value of a temperature sensor that the board does not have; it is below any temperature [degC]. */
#define DRIVE_NO_TEMPERATURE (-273.15f)

typedef struct {
    float i_a;  /* [A] phase currents at t_k as the sensors measure them, positive into the motor */
    float i_b;  /* [A] */
    float i_c;  /* [A] with two sensors: the negative sum of i_a and i_b */
    float u_dc; /* [V] DC link */
    float sink_temperature;  /* [degC] DRIVE_NO_TEMPERATURE without a sensor, also for motor_temperature */
    float motor_temperature; /* [degC] */
    uint32_t encoder;        /* [counts] 0 .. 4 encoder_lines - 1, at t_k */
    uint32_t flags;          /* [-] DRIVE_SAMPLE_... */
    uint32_t codes[3];       /* [-] all of them as the converter gave them, for the record (drive/record.h) */
} drive_samples_t;

/* A current sensor that is less than half a per cent of its range from its limit is saturated or broken
 * [A]. */
#define MEASURE_MIDDLE (0.5f * (DRIVE_CURRENT_MAX + DRIVE_CURRENT_MIN))
#define MEASURE_HALF   (0.4975f * (DRIVE_CURRENT_MAX - DRIVE_CURRENT_MIN))
/* Accepted range of phase c as a multiple of a sensor's range: without a sensor of its own, phase c is the
 * sum of two, within twice that range. */
#define MEASURE_C_SHARE (DRIVE_CURRENT_SENSORS == 3 ? 1.0f : 3.0f)

/* Limit for the sum of the amounts of DC link [V] and temperatures [degC] of working sensors. */
#define MEASURE_LIMIT 2000.0f

/* MEASURE_QUIET: largest span of a phase current within a block without current [A]. MEASURE_MOVED: least
 * change of the offsets, as the length of the current vector, for which they are replaced [A]. */
/* MEASURE_NOISY: rms noise of a current sensor with which the drive does not start [A]: phase c, the sum of
 * two, then exceeds the distance from current_limit to overcurrent_trip within a second. */
#define MEASURE_NOISY (0.025f * DRIVE_CURRENT_RANGE)
#define MEASURE_QUIET (0.02f * DRIVE_CURRENT_RANGE)
#define MEASURE_MOVED (0.005f * DRIVE_CURRENT_RANGE)

typedef struct {
    float weight;     /* 1/calibration_periods [-] */
    uint32_t periods; /* [periods] of the whole calibration, settling included */
    float offset_max; /* [A] largest accepted offset of a sensor */
} measure_tuning_t;

/* DUE: the sensors read a current that is not zero, and no block has measured it yet. NOISY: the values of
 * the sensors scatter by more than MEASURE_NOISY. */
typedef enum {
    CALIBRATION_GOES_ON,
    CALIBRATION_GOOD,
    CALIBRATION_FAILED,
    CALIBRATION_DUE,
    CALIBRATION_NOISY
} calibration_t;

/* The scatter of the sensors a and b during a calibration. */
typedef struct {
    float a[2]; /* [A] the last value and the one before, of sensor a */
    float b[2]; /* [A] the same of sensor b */
    float step; /* [A^2] mean square of the change from one sample to the next, of both sensors together; 0
                   after a calibration in which a current flowed */
    float leap; /* [A^2] the same from one sample to the next but one */
} measure_noise_t;

/* A block of samples while the bridge is off. */
typedef struct {
    abc_t mean;       /* [A] weighted sum so far */
    ab_t recent;      /* [A] low-pass of the current, offsets and trim removed */
    abc_t smallest;   /* [A] */
    abc_t largest;    /* [A] */
    uint32_t periods; /* [periods] of settling and block so far */
    uint32_t flows;   /* [-] 1: the values have changed several times in a short time: a current flows */
    uint32_t again;   /* [-] 1: the present block has begun again */
    uint32_t unsure;  /* [-] 1: a current may have flowed in the calibration; the first block without current
                         replaces it */
    int32_t found;    /* [-] calibration_t of the last block that was not discarded; GOES_ON: none yet */
} measure_rest_t;

typedef struct {
    abc_t offset;        /* [A] measured at zero current */
    uint32_t calibrated; /* [periods] of the calibration so far */
    measure_noise_t noise;
    measure_rest_t rest;
    abc_t before;        /* [A] phase currents of the sample before the newest */
    uint32_t late_until; /* [periods] end of the sum of the late interrupts */
    measured_t measured; /* of the newest sample */
} measure_t;

/* Computes the coefficients. One division. */
measure_tuning_t measure_prepare(const params_t *params);

/* Clears the offsets and all measurements. */
void measure_init(measure_t *measure);

/* Continues with other coefficients: offsets and a calibration in progress stay, a block begins again. */
static inline void measure_take(measure_t *measure)
{
    measure->rest.periods = 0u;
}

/* The next calibration begins again, and so do the blocks after it. */
void measure_begin_calibration(measure_t *measure);

/* One period of the calibration: the offsets become the mean of the currents while none flows. The first
 * samples are left out because the sensors settle, and so are invalid samples. CALIBRATION_FAILED: an offset
 * is larger than offset_max. CALIBRATION_NOISY: the samples are noise with a standard deviation above
 * MEASURE_NOISY, and not a current, which changes in two periods by about twice as much as in one. No
 * division. */
calibration_t measure_calibrate(measure_t *measure, const measure_tuning_t *tuning,
                                const drive_samples_t *samples);

/* Discards the present block: the bridge comes on, or the link is too low to exclude a current. */
void measure_begin_rest(measure_t *measure);

/* One period with the bridge off. `trim` [A]: as in measure_step(). true: the offsets have moved and are now
 * those of this block, and the caller has to set the trim to 0. measure->rest.found is CALIBRATION_FAILED if
 * an offset is larger than offset_max. No division. */
bool measure_rest(measure_t *measure, const measure_tuning_t *tuning, const drive_samples_t *samples,
                  ab_t trim);

/* State of the offsets while the bridge is off. With CALIBRATION_DUE the drive must not start, because its
 * offsets would be wrong. A block with current is not judged here; other modules detect that current. */
calibration_t measure_found(const measure_t *measure);

/* true: all sensors of this sample are within their ranges. */
static inline bool measure_is_good(const drive_samples_t *samples)
{
    const float others = bounds_magnitude(samples->u_dc) + bounds_magnitude(samples->sink_temperature) +
                         bounds_magnitude(samples->motor_temperature);
    return bounds_within(samples->i_a - MEASURE_MIDDLE, MEASURE_HALF) &&
           bounds_within(samples->i_b - MEASURE_MIDDLE, MEASURE_HALF) &&
           bounds_within(samples->i_c - MEASURE_MIDDLE, MEASURE_C_SHARE * MEASURE_HALF) &&
           bounds_within(others, MEASURE_LIMIT);
}

/* true: more current flows than offsets and noise can cause. */
static inline bool measure_current_flows(const measured_t *measured)
{
    const ab_t i = measured->current;
    return i.alpha * i.alpha + i.beta * i.beta > MEASURE_QUIET * MEASURE_QUIET;
}

/* The phase currents [A] that are compared with limits in the period of an invalid sample. A current sensor
 * that is within its range has its own value. In place of another one, and of phase c without a sensor of its
 * own, the last two good samples are extrapolated, so that a growing current continues to grow: a sensor that
 * reaches its limit in this way is not broken. A sensor that has shown a current near overcurrent_trip
 * (`trip` [A]) and is now at the limit of the same sign is not broken either: where the iron saturates, the
 * next sample of this current may be beyond the range. Two sensors at opposite limits are not broken, either:
 * the current flows from one phase to the other, and they have their own values. */
abc_t measure_expected(const measure_t *measure, const drive_samples_t *samples, float trip);

/* Mean square of the noise of a sensor [A^2], from the last calibration. */
static inline float measure_noise(const measure_t *measure)
{
    return 0.25f * measure->noise.step;
}

/* Updates measure->measured of this period. `trim` [A]: change of the offsets that the trim has found since.
 * No division. */
static inline void measure_step(measure_t *measure, const drive_samples_t *samples, ab_t trim)
{
    measured_t *measured = &measure->measured;
    measured->good = measure_is_good(samples);
    if (measured->good != 0u) {
        measure->before = measured->current_abc;
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

/* Counts a late interrupt, in this period of the clock, which measure_step() has updated. The sum of the late
 * interrupts is kept as the period in which it ends, so that punctual ones need no computation. */
static inline void measure_late(measure_t *measure, uint32_t period)
{
    const uint32_t left = measure->late_until - period;
    const uint32_t end = (left < MEASURE_LATE_OFTEN ? measure->late_until : period) + MEASURE_LATE_ONE;
    measure->late_until = end;
    if (end - period >= MEASURE_LATE_OFTEN) {
        measure->late_until = period + MEASURE_LATE_OFTEN;
        measure->measured.flags |= DRIVE_SAMPLE_LATE_OFTEN;
    }
}

#endif
