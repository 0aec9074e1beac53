#include "estimator/fixed/lag_q.h"

#include "math/root_q.h"
#include "math/trig_q.h"

/* Formats of a compensation vector: the part of the filter, and the whole vector. */
#define FILTER_Q 20
#define UNDO_Q   24

/* omega T, Q31. */
#define TURN_Q 31

/* LAG_TURN_LIMIT_FIXED as a speed, and pi. */
#define TURN_LIMIT Q_CONST(30, 2.0f * LAG_TURN_LIMIT_FIXED / 6.28318531f)
#define PI_Q       29
#define PI         Q_CONST(PI_Q, 3.14159265f)

/* For lag_error_q(), as in lag.c; the ratio of its steps to the distance, up to 20, is Q24. */
#define ERROR_STEPS   4
#define EMF_SHARE_MAX Q_CONST(UNIT_Q, 0.99f)
#define LONGER_Q      24

typedef struct {
    int32_t re, im;
} complex_q_t;

static int32_t times(int32_t a, int32_t unit)
{
    return q_multiply(a, unit, UNIT_Q);
}

static int32_t squared(int32_t unit)
{
    return (int32_t)(q_square(unit) >> UNIT_Q);
}

static int32_t speed_within(int32_t omega_e)
{
    return q_clamp(omega_e, TURN_LIMIT);
}

/* Z = R + j omega L + g W of lag.h, Q24, for g in Q24, 0..CONDUCTANCE_LARGEST; at most an eighth of a turn
 * per period. */
static complex_q_t impedance_of(const smo_tuning_q_t *tuning, int32_t omega_e, int32_t g)
{
    int32_t turn = q_multiply(q_clamp(omega_e, Q_ONE(SPEED_Q - 3)), PI, SPEED_Q + PI_Q - TURN_Q - 1);
    int32_t square = q_high(turn, turn); /* Q30 */
    int32_t bend = times(square, tuning->hold[1] - times(square, tuning->hold[3]));
    int32_t lead = tuning->hold[0] - times(square, tuning->hold[2]);
    complex_q_t z;
    z.re = tuning->resistance + g - times(g, bend);
    z.im = q_multiply(turn, tuning->inductance + times(g, lead), TURN_Q);
    return z;
}

/* a b, components shifted by n bits. */
static complex_q_t product(complex_q_t a, complex_q_t b, int32_t n)
{
    complex_q_t result = {q_saturate(q_round(q_product(a.re, b.re) - q_product(a.im, b.im), n)),
                          q_saturate(q_round(q_product(a.re, b.im) + q_product(a.im, b.re), n))};
    return result;
}

/* Length and direction: the unit vector in Q30, and 1/length in its format. */
static complex_q_t unit_of(complex_q_t vector, root_q_t *inverse)
{
    *inverse = inverse_root_q(q_square_sum(vector.re, vector.im));
    complex_q_t unit = {q_clamp(quotient_q(vector.re, *inverse, UNIT_Q), Q_ONE(UNIT_Q)),
                        q_clamp(quotient_q(vector.im, *inverse, UNIT_Q), Q_ONE(UNIT_Q))};
    return unit;
}

/* a/b 2^n, saturated. */
static complex_q_t divided(complex_q_t a, complex_q_t b, int32_t n)
{
    root_q_t inverse;
    complex_q_t unit = unit_of(b, &inverse);
    unit.im = -unit.im;
    complex_q_t turned = product(unit, a, UNIT_Q);
    return (complex_q_t){quotient_q(turned.re, inverse, n), quotient_q(turned.im, inverse, n)};
}

/* v/e_hat of the filter, the same as filter_of() of lag.c, Q20; a speed used as an angle is that of half a
 * period. */
static complex_q_t filter_of(const smo_q_t *smo, int32_t omega_e)
{
    rotation_q_t half = trig_rotation_q((uint32_t)omega_e);
    int32_t size = times(smo->tuning.filter_odd, half.sin);
    return (complex_q_t){q_add(Q_ONE(FILTER_Q), times(size, half.sin)), times(size, half.cos)};
}

/* e/e_hat of observer, hold and filter; Q24. */
static complex_q_t undoing(const smo_q_t *smo, int32_t omega_e)
{
    int32_t speed = speed_within(omega_e);
    complex_q_t z = impedance_of(&smo->tuning, speed, smo->conductance);
    root_q_t per_g = reciprocal_q(smo->conductance);
    complex_q_t share = {quotient_q(z.re, per_g, UNDO_Q), quotient_q(z.im, per_g, UNDO_Q)};
    return product(share, filter_of(smo, speed), FILTER_Q);
}

/* A vector in the direction of the lag in this mode. */
static complex_q_t direction(const smo_q_t *smo, lag_mode_t mode, int32_t omega_e)
{
    int32_t turn = q_multiply(q_clamp(omega_e, Q_ONE(SPEED_Q - 1)), PI, SPEED_Q - 1); /* omega T, Q29 */
    int32_t reactance = q_multiply_saturated(smo->tuning.inductance, turn, PI_Q);
    switch (mode) {
    case LAG_NONE:
        break;
    case LAG_PRINTED: {
        int32_t re =
            q_multiply_saturated(smo->tuning.ohms, q_add(smo->conductance, smo->tuning.one_ohm), IMPEDANCE_Q);
        return (complex_q_t){re, reactance};
    }
    case LAG_CORRECTED: {
        int32_t resistance = smo->tuning.resistance;
        return (complex_q_t){q_add(smo->conductance, resistance), reactance};
    }
    case LAG_EXACT:
        return undoing(smo, omega_e);
    }
    return (complex_q_t){Q_ONE(UNDO_Q), 0};
}

uint32_t lag_angle_q(const smo_q_t *smo, lag_mode_t mode, int32_t omega_e)
{
    complex_q_t vector = direction(smo, mode, omega_e);
    return trig_atan2_q(vector.im, vector.re);
}

int32_t lag_attenuation_q(const smo_q_t *smo, int32_t omega_e)
{
    root_q_t inverse;
    (void)unit_of(undoing(smo, omega_e), &inverse);
    return quotient_q(Q_ONE(20), inverse, 2 * UNDO_Q - 20);
}

/* The paper's modes: direction of the mode, exact length. */
static complex_q_t undoing_of_paper(const smo_q_t *smo, lag_mode_t mode, int32_t omega_e)
{
    root_q_t unused;
    complex_q_t unit = unit_of(direction(smo, mode, omega_e), &unused);
    complex_q_t undo = undoing(smo, omega_e);
    uint32_t length = root_q(q_square_sum(undo.re, undo.im));
    int32_t size = length > (uint32_t)Q_LARGEST ? Q_LARGEST : (int32_t)length;
    return (complex_q_t){times(size, unit.re), times(size, unit.im)};
}

/* Current error from a voltage and the reciprocal of an impedance, Q24. */
static int32_t error_of(int32_t voltage, root_q_t per_impedance)
{
    return q_clamp(quotient_q(voltage, per_impedance, IMPEDANCE_Q + CURRENT_Q - VOLTAGE_Q), ERROR_LARGEST);
}

ab_q_t lag_emf_q(const smo_q_t *smo, lag_mode_t mode, int32_t omega_e)
{
    if (mode != LAG_EXACT) {
        complex_q_t hat = {smo->emf_hat.alpha, smo->emf_hat.beta};
        complex_q_t emf = product(undoing_of_paper(smo, mode, omega_e), hat, UNDO_Q);
        return (ab_q_t){q_clamp(emf.re, SAMPLE_LARGEST), q_clamp(emf.im, SAMPLE_LARGEST)};
    }
    ab_q_t error = smo->current_err;
    if (smo->tuning.switching != (int32_t)SMO_SIGMOID_VECTOR) {
        root_q_t per_g = reciprocal_q(smo->conductance);
        error = (ab_q_t){error_of(smo->switched.alpha, per_g), error_of(smo->switched.beta, per_g)};
    }
    complex_q_t z = impedance_of(&smo->tuning, omega_e, smo->conductance);
    return (ab_q_t){q_cut(q_product(z.re, error.alpha) - q_product(z.im, error.beta),
                          IMPEDANCE_Q + CURRENT_Q - VOLTAGE_Q, SAMPLE_BITS),
                    q_cut(q_product(z.re, error.beta) + q_product(z.im, error.alpha),
                          IMPEDANCE_Q + CURRENT_Q - VOLTAGE_Q, SAMPLE_BITS)};
}

/* Limits an EMF to the range of the observer. Returns its length. */
static int32_t shortened(const smo_q_t *smo, ab_q_t *emf)
{
    int32_t length = direction_q(emf->alpha, emf->beta).length;
    int32_t longest = q_multiply(smo->tuning.gain, EMF_SHARE_MAX, GAIN_Q + UNIT_Q - VOLTAGE_Q);
    if (length <= longest) {
        return length;
    }
    root_q_t unused;
    complex_q_t unit = unit_of((complex_q_t){emf->alpha, emf->beta}, &unused);
    *emf = (ab_q_t){times(longest, unit.re), times(longest, unit.im)};
    return longest;
}

/* The same as in lag.c: Newton's method rises from the y of the largest gain. */
ab_q_t lag_error_q(const smo_q_t *smo, int32_t omega_e, ab_q_t emf)
{
    const smo_tuning_q_t *tuning = &smo->tuning;
    int32_t speed = speed_within(omega_e);
    int32_t length = shortened(smo, &emf);
    int32_t y = 0;
    int32_t g = tuning->gain_slope >> (SLOPE_Q - IMPEDANCE_Q);
    int32_t slope = g + tuning->resistance;
    for (int32_t n = 0; n < ERROR_STEPS; n++) {
        complex_q_t z = impedance_of(tuning, speed, g);
        int32_t goal = error_of(length, inverse_root_q(q_square_sum(z.re, z.im)));
        int32_t longer = quotient_q(g + tuning->resistance, reciprocal_q(slope), LONGER_Q);
        y = q_clamp(q_add(y, q_multiply_saturated(goal - y, longer, LONGER_Q)), ERROR_LARGEST);
        int32_t stretched = smo_stretched_q(smo, y);
        int32_t ratio = tanh_ratio_q(q_square(stretched));
        int32_t f = q_clamp(q_multiply_saturated(ratio, stretched, STRETCHED_Q), Q_ONE(UNIT_Q));
        g = q_high(tuning->gain_slope, ratio);
        slope = tuning->resistance + q_high(tuning->gain_slope, Q_ONE(UNIT_Q) - squared(f));
    }
    complex_q_t z = impedance_of(tuning, speed, g);
    complex_q_t error = divided((complex_q_t){emf.alpha, emf.beta}, z, IMPEDANCE_Q + CURRENT_Q - VOLTAGE_Q);
    return (ab_q_t){q_clamp(error.re, ERROR_LARGEST), q_clamp(error.im, ERROR_LARGEST)};
}

ab_q_t lag_switched_q(const smo_q_t *smo, int32_t omega_e, ab_q_t emf)
{
    complex_q_t z = impedance_of(&smo->tuning, speed_within(omega_e), smo->conductance);
    complex_q_t error = divided((complex_q_t){emf.alpha, emf.beta}, z, IMPEDANCE_Q + CURRENT_Q - VOLTAGE_Q);
    return (ab_q_t){smo_switched_q(smo->conductance, q_clamp(error.re, ERROR_LARGEST)),
                    smo_switched_q(smo->conductance, q_clamp(error.im, ERROR_LARGEST))};
}

ab_q_t lag_filtered_q(const smo_q_t *smo, int32_t omega_e, ab_q_t switched)
{
    complex_q_t filter = filter_of(smo, speed_within(omega_e));
    complex_q_t late = divided((complex_q_t){switched.alpha, switched.beta}, filter, FILTER_Q);
    return (ab_q_t){q_clamp(late.re, SWITCHED_LARGEST), q_clamp(late.im, SWITCHED_LARGEST)};
}
