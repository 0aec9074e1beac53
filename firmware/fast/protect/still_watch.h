/* Reports a current sensor whose value does not change while control requires another current. This is the
 * fast part of current_watch.h, in the fast task: where V/L makes 25 A/ms, a window is too long. In each
 * period, for each sensor:
 *
 *     stuck   the value has not changed by a bit in the last periods, and differs from the reference
 *             by more than 5 % of the range in each of the last four of them; 2 % if the noise excludes it
 *
 *             or it has not changed in the last three periods, while the voltage of its phase jumped: in the
 *             last two of them it was larger than in the first, enough to change the current by 2 % of the
 *             range, 40 codes. An EMF does not jump
 *
 * With such a control error the current changes by many codes per period, unless the voltage is at the limit
 * of the link. Because of noise a value repeats for one or two periods at most. A phase with an open wire has
 * no current, which does not change either. Therefore, with two sensors, while any phase has almost no
 * current, only a difference of 15 % is judged, and the value must have repeated for longer, also after a
 * jump of the voltage. Two observations exclude an open wire:
 *
 *     excess  L di/dt = u - R i - e holds for each phase. While the value of sensor a does not change, the
 *             voltage v_a = u_a - e_a drives no measured current. With an open wire the star point moves by
 *             v_a/2, and the other two phases each lose half of v_a: the excess v = u - e - L di/dt of the
 *             other sensor's phase is -v_a/2. With a stuck sensor a, the law holds for the other sensor, and
 *             its excess is zero. Its limit is -v_a/4.
 *     noise   the sensor of a phase without current has noise, measured with the bridge off
 *
 * With a wrong offset a sensor shows a constant value other than zero while its phase carries no current. The
 * dead time, compensated with the wrong sign, then holds the current at zero against the control. Therefore a
 * difference at which the control's voltage is less than this effect is not judged for such a value, unless
 * the noise excludes that it is measured.
 *
 * A value that the noise excludes for a longer time is stuck at any reference as soon as current flows. It
 * may have been stuck since before the bridge came on.
 *
 * Three values that add up to zero are those of the currents: a stuck one would make the sum different by its
 * error. One of them then does not change because its switch does not conduct.
 *
 * Does not handle: a sensor that is stuck near the reference without a jump of the voltage. */
#ifndef FAST_PROTECT_STILL_WATCH_H
#define FAST_PROTECT_STILL_WATCH_H

#include <float.h>
#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"
#include "math/winding.h"

#define STILL_SOME   3u       /* [periods] without a change from which a value is examined */
#define STILL_OFF    4u       /* [periods]: a step of the reference is visible in the third sample */
#define STILL_ALONE  8u       /* [periods] without a change, where a phase has almost no current ... */
#define STILL_WIRED  5u       /* [periods] ... and no wire is open */
#define STILL_PUSHED 0x10000u /* [periods] in place of a count, after a jump of the voltage */
#define STILL_FAR    3.0f     /* [-] factor on the accepted difference, where a phase has almost no current */

/* Results of a period: a sensor is stuck; sensor a or b is stuck unless a wire is open. */
#define STILL_WATCH_STUCK UINT32_C(1)
#define STILL_WATCH_OPEN  UINT32_C(2) /* of sensor a; of b 4 */

/* The largest change of the dead time's loss: the loss of three legs, 4/3 of that of one, with the opposite
 * sign in two periods. */
#define STILL_PUSH_DEAD 5.33333333f /* [-] */
/* The largest effect of one sensor's offset on its phase: its leg and that of the computed third current are
 * compensated with the wrong sign, (2 2 + 2)/3 of the loss of a leg. */
#define STILL_HELD_DEAD 2.0f /* [-] */

/* A noise with the standard deviation s, in codes of the converter, gives the same code twice in succession
 * with the probability 1/(2 sqrt(pi) s): at most 0.33 with a mean square of 0.75 codes, noise of the rounding
 * included, and 0.46 with 0.4 codes, the least mean square of two sensors of which one has no noise and the
 * other one code. NOISY: 1e-6 for a value that is wrong if its phase carries current. SILENT: 3e-14 for any
 * value. A code is 1/2048 of the range, and its square 0.00424 of that of almost no current. */
#define STILL_LONG         9u  /* [periods] from which on a count of STILL_OFF ends at STILL_NOISY or later */
#define STILL_NOISY        12u /* [periods] */
#define STILL_SILENT       40u /* [periods] */
#define STILL_NOISY_LEAST  (0.75f * 0.00424f) /* [-] */
#define STILL_SILENT_LEAST (0.4f * 0.00424f)  /* [-] */
#define STILL_LITTLE       0.4f /* [-] of the accepted difference, for these values: 2 % of the range, 40 codes */
#define STILL_FLOWS                                                                                          \
    2.7f /* [-] over almost no current: least current beside a silent sensor, 2 % of the range */
#define STILL_SHARE 0.25f /* [-] between 1/2, the excess beside an open wire, and 0 */

typedef struct {
    float range;        /* range of the sensors in both directions [A] */
    float inductance;   /* the larger of L_d and L_q [H], > 0 */
    float gain;         /* the smaller gain of the current control [ohm], > 0 */
    float dead_time;    /* of the legs [s] */
    float drop;         /* of a device [V] */
    float period;       /* T [s] */
    bool three_sensors; /* false: two sensors */
    bool judged;        /* false: the watch is off */
} still_watch_params_t;

typedef struct {
    uint32_t sensors; /* [-] 2 or 3; 0: the watch is off */
    float off;        /* largest accepted difference from the reference [A] */
    float gain;       /* the smaller gain of the current control [ohm] */
    float held;       /* largest effect of the drops on the voltage of a phase, with a wrong offset [V] */
    float none;       /* limit of almost no current [A] */
    float slow;       /* link voltage below which a current changes by only a few codes in a period [V] */
    float push;       /* least jump of the voltage, as the sum of two periods [V] ... */
    float push_link;  /* ... in addition, per volt of the link: largest change of the dead time's loss [-] */
    float turn;       /* ... in addition, per speed and volt: change of a rotating EMF in this time [s] */
    float per_change; /* L/T [V/A] */
} still_watch_tuning_t;

typedef struct {
    float value[3];    /* sample of the last period, offset included [A] */
    uint32_t still[3]; /* [periods] without a change */
    uint32_t off[3]; /* [periods] of these with a difference from the reference; or STILL_PUSHED, after a jump
                        of the voltage */
    ab_t voltage[2]; /* that acted in the last period and in the one before [V] */
} still_watch_t;

/* The inputs of a period in which a value is examined. */
typedef struct {
    ab_t asked;           /* reference for the sample of the last period [A] */
    const abc_t *current; /* measured [A] ... */
    float noise;          /* mean square of a sensor's noise [A^2] */
    const ab_t *voltage;  /* that acted in the last period [V] */
    float omega_e;        /* assumed speed of the rotor [rad/s] */
    float u_dc;           /* [V] */
    bool limited;         /* the applied voltage is less than control required */
} still_watch_input_t;

/* Computes the coefficients. One division. */
still_watch_tuning_t still_watch_prepare(const still_watch_params_t *params);

/* One period of sensor `n`, with its sample [A]. true: it has not changed for some periods. */
static inline bool still_watch_one(still_watch_t *watch, uint32_t n, float sample)
{
    if (sample != watch->value[n]) {
        watch->value[n] = sample;
        watch->still[n] = 0u;
        return false;
    }
    watch->still[n]++;
    return watch->still[n] >= STILL_SOME;
}

/* Counts in each period, with the samples as the sensors measure them, because an offset that is measured
 * again does not change a stuck sensor [A]. true: a value has not changed for some periods. */
static inline bool still_watch_count(still_watch_t *watch, const still_watch_tuning_t *tuning, float i_a,
                                     float i_b, float i_c)
{
    if (tuning->sensors == 0u) {
        return false;
    }
    const bool a = still_watch_one(watch, 0u, i_a);
    const bool b = still_watch_one(watch, 1u, i_b);
    const bool c = tuning->sensors == 3u && still_watch_one(watch, 2u, i_c);
    return a || b || c;
}

/* Each period, after the judgement: the voltage that acted in the last period [V]. */
static inline void still_watch_remember(still_watch_t *watch, const ab_t *voltage)
{
    watch->voltage[1] = watch->voltage[0];
    watch->voltage[0] = *voltage;
}

/* Bits of the judged sensors whose value has changed in the last `periods`, by their counts of periods
 * without a change. */
static inline uint32_t still_watch_moved(const uint32_t still[3], uint32_t periods)
{
    uint32_t moved = still[0] < periods ? UINT32_C(1) : UINT32_C(0);
    if (still[1] < periods) {
        moved |= 2u;
    }
    if (still[2] < periods) {
        moved |= 4u;
    }
    return moved;
}

/* The jump of the voltage of each phase [V]: the sum of the last two of three periods, minus twice the
 * voltage of the first one. The control responds to a sample in the second of three periods. */
static inline abc_t still_watch_jumps(const still_watch_t *watch, ab_t voltage)
{
    const ab_t was = watch->voltage[1];
    return frames_inverse_clarke((ab_t){voltage.alpha + watch->voltage[0].alpha - 2.0f * was.alpha,
                                        voltage.beta + watch->voltage[0].beta - 2.0f * was.beta});
}

/* Largest jump that a rotating EMF, the dead time and a small change of the current explain [V]. */
static inline float still_watch_explained(const still_watch_t *watch, const still_watch_tuning_t *tuning,
                                          float u_dc, float omega_e)
{
    const ab_t was = watch->voltage[1];
    const float length = bounds_magnitude(was.alpha) + bounds_magnitude(was.beta);
    return tuning->push + tuning->push_link * u_dc + tuning->turn * bounds_magnitude(omega_e) * length;
}

/* Limits of a period. */
typedef struct {
    float off;            /* largest difference from the reference [A] */
    float u_dc;           /* [V] */
    float push;           /* largest jump of the voltage [V] */
    float noise;          /* mean square of a sensor's noise [A^2] */
    uint32_t limited;     /* [-] 1: the applied voltage is less than control required */
    const abc_t *current; /* measured [A] */
} still_limits_t;

/* Limits for these inputs. While the link allows only a slow change, no difference counts. */
static inline still_limits_t still_watch_limits(const still_watch_t *watch,
                                                const still_watch_tuning_t *tuning,
                                                const still_watch_input_t *input)
{
    const bool counts = !input->limited || input->u_dc > tuning->slow;
    return (still_limits_t){
        .off = counts ? tuning->off : FLT_MAX,
        .u_dc = input->u_dc,
        .push = still_watch_explained(watch, tuning, input->u_dc, input->omega_e),
        .noise = input->noise,
        .limited = input->limited ? UINT32_C(1) : UINT32_C(0),
        .current = input->current,
    };
}

/* True if the dead time may hold a value constant that misses its reference by this difference [A]. */
static inline bool still_watch_holds(const still_watch_tuning_t *tuning, float value, float miss, float u_dc)
{
    return !bounds_within(value, tuning->none) &&
           bounds_within(tuning->gain * miss,
                         tuning->held + STILL_HELD_DEAD / STILL_PUSH_DEAD * tuning->push_link * u_dc);
}

/* True if a phase has almost no current [A], because its wire is open or by chance, and no third sensor
 * excludes an open wire. */
bool still_watch_is_alone(const still_watch_tuning_t *tuning, const abc_t *current);

/* Removes the differences and jumps that were counted. */
void still_watch_forget(still_watch_t *watch);

/* What the noise says about a value that has not changed since STILL_LONG or longer, while another current,
 * `other` [A], flows. */
typedef enum { STILL_NOISE_NONE, STILL_NOISE_SOON, STILL_NOISE_SILENT } still_noise_t;

/* SOON: the noise excludes the value after STILL_NOISY if its phase carries current. SILENT: it excludes the
 * value. */
still_noise_t still_watch_noise(const still_watch_tuning_t *tuning, const still_limits_t *limits,
                                uint32_t still, float other);

/* The result for sensor `n` whose value is wrong if its phase carries current. `miss` [A]: its difference
 * from the reference, or FLT_MAX after a jump of the voltage. */
uint32_t still_watch_verdict(const still_watch_tuning_t *tuning, const still_limits_t *limits, uint32_t n,
                             uint32_t still, float miss, still_noise_t noise);

/* A sensor in a period: its number, current, reference and the current of another sensor [A], and the jump of
 * the voltage of its phase [V]. */
typedef struct {
    uint32_t n;
    float value, asked, other, jump;
} still_sensor_t;

/* One period of a sensor: STILL_WATCH_... bits. */
static inline uint32_t still_watch_one_judged(still_watch_t *watch, const still_watch_tuning_t *tuning,
                                              const still_limits_t *limits, still_sensor_t sensor)
{
    const uint32_t n = sensor.n;
    const uint32_t still = watch->still[n];
    if (still < STILL_SOME) {
        watch->off[n] = 0u;
        return 0u;
    }
    still_noise_t noise = STILL_NOISE_NONE;
    if (still >= STILL_LONG) {
        noise = still_watch_noise(tuning, limits, still, sensor.other);
    }
    uint32_t off = still == STILL_SOME ? 0u : watch->off[n];
    float miss = FLT_MAX;
    if (off >= STILL_PUSHED || !bounds_within(sensor.jump, limits->push)) {
        off = STILL_PUSHED;
    } else {
        miss = sensor.asked - sensor.value;
        const float least =
            noise != STILL_NOISE_NONE && limits->limited == 0u ? STILL_LITTLE * limits->off : limits->off;
        const bool right =
            bounds_within(miss, least) ||
            (noise == STILL_NOISE_NONE && still_watch_holds(tuning, sensor.value, miss, limits->u_dc));
        off = right ? 0u : off + 1u;
    }
    watch->off[n] = off;
    return off >= STILL_OFF || noise == STILL_NOISE_SILENT
               ? still_watch_verdict(tuning, limits, n, still, miss, noise)
               : 0u;
}

/* Judges the sensors while control runs and still_watch_count() is true: STILL_WATCH_... bits. */
static inline uint32_t still_watch_judge(still_watch_t *watch, const still_watch_tuning_t *tuning,
                                         const still_watch_input_t *input)
{
    const abc_t asked = frames_inverse_clarke(input->asked);
    const abc_t jump = still_watch_jumps(watch, *input->voltage);
    const still_limits_t limits = still_watch_limits(watch, tuning, input);
    const abc_t current = *input->current;
    const still_sensor_t a = {0u, current.a, asked.a, current.b, jump.a};
    const still_sensor_t b = {1u, current.b, asked.b, current.a, jump.b};
    const uint32_t found =
        still_watch_one_judged(watch, tuning, &limits, a) | still_watch_one_judged(watch, tuning, &limits, b);
    if (tuning->sensors < 3u) {
        return found;
    }
    const still_sensor_t c = {2u, current.c, asked.c, current.a, jump.c};
    const uint32_t all = found | still_watch_one_judged(watch, tuning, &limits, c);
    return winding_adds_up(input->current, tuning->off) ? 0u : all;
}

/* ---- a value that is wrong unless a wire is open ---- */

/* The inputs of a period for this question. */
typedef struct {
    const abc_t *current; /* measured [A] ... */
    const abc_t *before;  /* ... and one period earlier [A] */
    const ab_t *voltage;  /* that acted in the last period [V] */
    ab_t emf;             /* assumed EMF [V] ... */
    float doubt;          /* ... and four times the length of its error [V] */
    float u_dc;           /* [V] */
} still_watch_winding_t;

/* Voltage of a phase that neither the EMF nor the measured change of the current explains [V]. */
static inline abc_t still_watch_excess(const still_watch_tuning_t *tuning,
                                       const still_watch_winding_t *winding)
{
    const ab_t now = frames_clarke(*winding->current);
    const ab_t before = frames_clarke(*winding->before);
    return frames_inverse_clarke(
        (ab_t){winding->voltage->alpha - winding->emf.alpha - tuning->per_change * (now.alpha - before.alpha),
               winding->voltage->beta - winding->emf.beta - tuning->per_change * (now.beta - before.beta)});
}

/* true: no wire is open, because this excess [V] of the phase of a constant value does not have its opposite
 * half in the phase of the other sensor. */
static inline bool still_watch_is_one(float excess, float other, float uncertain)
{
    const float across = excess < 0.0f ? -other : other;
    const float much = bounds_magnitude(excess);
    return much > uncertain && across > -STILL_SHARE * much;
}

/* true: a sensor of which still_watch_judge() has `found` that it is stuck unless a wire is open is stuck. */
static inline bool still_watch_is_wired(const still_watch_tuning_t *tuning, uint32_t found,
                                        const still_watch_winding_t *winding)
{
    const abc_t excess = still_watch_excess(tuning, winding);
    const float uncertain = tuning->push + tuning->push_link * winding->u_dc + winding->doubt;
    return ((found & STILL_WATCH_OPEN) != 0u && still_watch_is_one(excess.a, excess.b, uncertain)) ||
           ((found & STILL_WATCH_OPEN << 1) != 0u && still_watch_is_one(excess.b, excess.a, uncertain));
}

#endif
