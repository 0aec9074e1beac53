#include "estimator/fixed/lag_q.h"

#include "math/root_q.h"
#include "math/trig_q.h"

/* Formats of a vector that undoes: the observer's own part, the filter's, both. */
#define OBSERVER_Q 28
#define FILTER_Q   20
#define UNDO_Q     24

/* LAG_TURN_LIMIT as a speed, and pi. */
#define TURN_LIMIT Q_CONST(30, 2.0f * LAG_TURN_LIMIT / 6.28318531f)
#define PI_Q       29
#define PI         Q_CONST(PI_Q, 3.14159265f)

/* The polynomials of lag.c for tan h and for the length, |h| <= LAG_TURN_LIMIT/2. */
#define TAN_1  Q_CONST(UNIT_Q, 1.00000763f)
#define TAN_3  Q_CONST(UNIT_Q, 0.33276332f)
#define TAN_5  Q_CONST(UNIT_Q, 0.14390343f)
#define SIZE_4 Q_CONST(UNIT_Q, 0.62474806f)

/* For lag_error_q(), as lag.c; how much longer than the way to the goal its steps are, up to 20, is Q24. */
#define ERROR_STEPS   4
#define EMF_SHARE_MAX Q_CONST(UNIT_Q, 0.99f)
#define LONGER_Q      24

typedef struct {
    int32_t re, im;
} complex_q_t;

/* What the terms in the speed have in common. */
typedef struct {
    int32_t h;      /* half_turn() */
    int32_t square; /* h^2, Q30 */
    int32_t t;      /* tan h, Q30 */
} turning_t;

static int32_t times(int32_t a, int32_t unit)
{
    return q_multiply(a, unit, UNIT_Q);
}

static int32_t squared(int32_t unit)
{
    return (int32_t)(q_square(unit) >> UNIT_Q);
}

/* omega T/2, Q30, within LAG_TURN_LIMIT/2. */
static int32_t half_turn(int32_t omega_e)
{
    return q_multiply(q_clamp(omega_e, TURN_LIMIT), PI, SPEED_Q + PI_Q - UNIT_Q);
}

static turning_t turning_of(int32_t omega_e)
{
    turning_t turning;
    turning.h = half_turn(omega_e);
    turning.square = squared(turning.h);
    int32_t slope = TAN_3 + times(TAN_5, turning.square);
    turning.t = times(TAN_1 + times(slope, turning.square), turning.h);
    return turning;
}

/* a b, components moved by n bits. */
static complex_q_t product(complex_q_t a, complex_q_t b, int32_t n)
{
    complex_q_t result = {q_saturate(q_round(q_product(a.re, b.re) - q_product(a.im, b.im), n)),
                          q_saturate(q_round(q_product(a.re, b.im) + q_product(a.im, b.re), n))};
    return result;
}

/* `re` + j `im`, turned back by the small angle `lead` (Q30). */
static complex_q_t led(int32_t re, int32_t im, int32_t lead)
{
    complex_q_t vector = {q_add(re, times(im, lead)), q_subtract(im, times(re, lead))};
    return vector;
}

/* Length and direction: the unit vector in Q30; and 1/length for what its format says. */
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

static complex_q_t filter_of(const smo_q_t *smo, int32_t t)
{
    int32_t odd = smo->params.filter_odd;
    int32_t t_square = squared(t);
    complex_q_t vector = {Q_ONE(FILTER_Q) + q_multiply(Q_ONE(FILTER_Q) + odd, t_square, UNIT_Q),
                          times(odd, t)};
    return vector;
}

/* e/e_hat of observer, hold and filter, as undoing() of lag.c; Q24. */
static complex_q_t undoing(const smo_q_t *smo, turning_t at)
{
    int32_t lead = times(
        (smo->params.hold_lead >> (SMALL_Q - UNIT_Q)) + times(at.square, smo->params.hold_lead_rise), at.h);
    int32_t loop_gain = q_saturate(q_round(q_product(smo->params.loop_gain_unit, smo->gain_mean),
                                           GAIN_Q + IMPEDANCE_Q - OBSERVER_Q)); /* b g */
    int32_t real = q_add(loop_gain, smo->params.current_loss >> (SMALL_Q - OBSERVER_Q));
    int32_t imag = times(q_subtract(Q_ONE(OBSERVER_Q + 1), real), at.t);
    complex_q_t both = product(led(real, imag, lead), filter_of(smo, at.t), OBSERVER_Q + FILTER_Q - UNDO_Q);

    root_q_t per_gain = reciprocal_q(loop_gain);
    int32_t size = Q_ONE(UNIT_Q) - times(at.square, smo->params.hold_size - times(at.square, SIZE_4));
    both.re = quotient_q(times(both.re, size), per_gain, OBSERVER_Q);
    both.im = quotient_q(times(both.im, size), per_gain, OBSERVER_Q);
    return both;
}

/* A vector in the direction of the mode's lag. */
static complex_q_t direction(const smo_q_t *smo, lag_mode_t mode, int32_t omega_e)
{
    int32_t turn = q_multiply(q_clamp(omega_e, Q_ONE(SPEED_Q - 1)), PI, SPEED_Q - 1); /* omega T, Q29 */
    int32_t reactance = q_multiply_saturated(smo->params.inductance, turn, PI_Q);
    switch (mode) {
    case LAG_NONE:
        break;
    case LAG_PRINTED: {
        int32_t re =
            q_multiply_saturated(smo->params.ohms, q_add(smo->conductance, smo->params.one_ohm), IMPEDANCE_Q);
        return (complex_q_t){re, reactance};
    }
    case LAG_CORRECTED: {
        int32_t resistance = smo->params.resistance;
        return (complex_q_t){q_add(smo->conductance, resistance), reactance};
    }
    case LAG_EXACT:
        return undoing(smo, turning_of(omega_e));
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
    (void)unit_of(undoing(smo, turning_of(omega_e)), &inverse);
    return quotient_q(Q_ONE(20), inverse, 2 * UNDO_Q - 20);
}

/* The paper's modes: their direction, the true length. */
static complex_q_t undoing_of_paper(const smo_q_t *smo, lag_mode_t mode, int32_t omega_e)
{
    root_q_t unused;
    complex_q_t unit = unit_of(direction(smo, mode, omega_e), &unused);
    complex_q_t undo = undoing(smo, turning_of(omega_e));
    uint32_t length = root_q(q_square_sum(undo.re, undo.im));
    int32_t size = length > (uint32_t)Q_LARGEST ? Q_LARGEST : (int32_t)length;
    return (complex_q_t){times(size, unit.re), times(size, unit.im)};
}

/* A voltage over what the Q24 of an impedance makes of it, as an error. */
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
    if (smo->params.switching == (int32_t)SMO_SIGMOID_VECTOR) {
        return lag_emf_exact_q(smo, smo->current_err, omega_e);
    }
    root_q_t per_g = reciprocal_q(smo->conductance);
    ab_q_t error = {error_of(smo->switched.alpha, per_g), error_of(smo->switched.beta, per_g)};
    return lag_emf_exact_q(smo, error, omega_e);
}

/* Cuts an EMF to what the observer can make. Returns its length. */
static int32_t shortened(const smo_q_t *smo, ab_q_t *emf)
{
    int32_t length = direction_q(emf->alpha, emf->beta).length;
    int32_t longest = q_multiply(smo->params.gain, EMF_SHARE_MAX, GAIN_Q + UNIT_Q - VOLTAGE_Q);
    if (length <= longest) {
        return length;
    }
    root_q_t unused;
    complex_q_t unit = unit_of((complex_q_t){emf->alpha, emf->beta}, &unused);
    *emf = (ab_q_t){times(longest, unit.re), times(longest, unit.im)};
    return longest;
}

/* As lag.c: Newton's method climbs from the y of the largest gain. */
ab_q_t lag_error_q(const smo_q_t *smo, int32_t omega_e, ab_q_t emf)
{
    const smo_params_q_t *params = &smo->params;
    int32_t length = shortened(smo, &emf);
    int32_t y = 0;
    int32_t g = params->gain_slope >> (SLOPE_Q - IMPEDANCE_Q);
    int32_t slope = g + params->resistance;
    for (int32_t n = 0; n < ERROR_STEPS; n++) {
        lag_impedance_q_t z = lag_impedance_q(smo, g, omega_e);
        int32_t goal = error_of(length, inverse_root_q(q_square_sum(z.re, z.im)));
        int32_t longer = quotient_q(g + params->resistance, reciprocal_q(slope), LONGER_Q);
        y = q_clamp(q_add(y, q_multiply_saturated(goal - y, longer, LONGER_Q)), ERROR_LARGEST);
        int32_t stretched = smo_stretched_q(smo, y);
        int32_t ratio = tanh_ratio_q(q_square(stretched));
        int32_t f = q_clamp(q_multiply_saturated(ratio, stretched, STRETCHED_Q), Q_ONE(UNIT_Q));
        g = q_high(params->gain_slope, ratio);
        slope = params->resistance + q_high(params->gain_slope, Q_ONE(UNIT_Q) - squared(f));
    }
    lag_impedance_q_t z = lag_impedance_q(smo, g, omega_e);
    complex_q_t error = divided((complex_q_t){emf.alpha, emf.beta}, (complex_q_t){z.re, z.im},
                                IMPEDANCE_Q + CURRENT_Q - VOLTAGE_Q);
    return (ab_q_t){q_clamp(error.re, ERROR_LARGEST), q_clamp(error.im, ERROR_LARGEST)};
}

void lag_make_q(const smo_q_t *smo, int32_t omega_e, ab_q_t emf, ab_q_t *switched, ab_q_t *emf_hat)
{
    turning_t at = turning_of(omega_e);
    complex_q_t late = divided((complex_q_t){emf.alpha, emf.beta}, undoing(smo, at), UNDO_Q);
    complex_q_t before = product(late, filter_of(smo, at.t), FILTER_Q);
    int32_t cosine_square = quotient_q(Q_ONE(UNIT_Q), reciprocal_q(Q_ONE(UNIT_Q) + squared(at.t)), UNIT_Q);
    *switched = (ab_q_t){times(before.re, cosine_square), times(before.im, cosine_square)};
    *emf_hat = (ab_q_t){late.re, late.im};
}
