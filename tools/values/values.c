/* Declares every input and every state that the fixed-point estimator can have, for the value analysis
 *(tools/check-values).
 *
 * The ranges of formats.h and of the structs' comments are declared here; one call of each kind is made in
 * any state in them with any samples. The results are asserted to be in the same ranges again, so that the
 * ranges hold after any number of steps. Samples are any 32 bits. */
#include <stdint.h>

#include "__fc_builtin.h"
#include "estimator/fixed/estimator_q.h"

#define ONE(n) (INT32_C(1) << (n))

/* Sine and cosine, with the limit that follows from interval arithmetic: 1.25. */
#define ROTATION_MOST (ONE(30) + ONE(28))

static int32_t any(int32_t min, int32_t max)
{
    return (int32_t)Frama_C_long_interval(min, max);
}

static int64_t any_long(int64_t min, int64_t max)
{
    return (int64_t)Frama_C_long_long_interval(min, max);
}

static uint32_t any_word(uint32_t max)
{
    return (uint32_t)Frama_C_unsigned_long_interval(0u, max);
}

static int32_t any_number(void)
{
    return any(-INT32_MAX, INT32_MAX);
}

static ab_q_t any_pair(int32_t limit)
{
    ab_q_t pair = {any(-limit, limit), any(-limit, limit)};
    return pair;
}

static ab_q_t any_sample(void)
{
    ab_q_t pair = {any(INT32_MIN, INT32_MAX), any(INT32_MIN, INT32_MAX)};
    return pair;
}

static q_scale_t any_scale(void)
{
    q_scale_t scale = {any(0, INT32_MAX), any(1, INT32_MAX)};
    return scale;
}

static lowpass_q_t any_filter(int32_t alpha, int64_t least)
{
    lowpass_q_t filter = {alpha, any_long(least, FILTER_Q_LONGEST)};
    return filter;
}

static smo_tuning_q_t any_smo(int32_t switching)
{
    smo_tuning_q_t params;
    params.resistance = any(0, 25 * ONE(24));
    params.voltage_gain = any(1, INT32_MAX);
    params.gain = any(ONE(29), ONE(30));
    params.half_slope = any(1, INT32_MAX);
    params.gain_slope = any(1, INT32_MAX);
    params.emf_decay = any(0, INT32_MAX);
    params.mean_share = any(0, INT32_MAX);
    params.current_loss = any(0, INT32_C(1717986918));              /* 0.4 */
    params.hold[0] = any(INT32_C(-644245094), INT32_C(-429496730)); /* -0.6..-0.4 */
    params.hold[1] = any(0, ONE(27));
    params.hold[2] = any(-ONE(23), 0);
    params.hold[3] = any(-ONE(22), 0);
    params.inductance = any(1, 50 * ONE(24));
    params.one_ohm = any(0, INT32_MAX);
    params.ohms = any(0, 100 * ONE(24));
    params.gain_largest = any(1, INT32_MAX);
    params.axis_gain_largest = any(1, INT32_MAX);
    params.filter_odd = any(0, INT32_C(1000) * ONE(20));
    params.switching = switching;
    return params;
}

static pll_tuning_q_t any_pll(void)
{
    pll_tuning_q_t params;
    params.kp_rest = any(0, INT32_C(687194767)); /* 0.32 */
    params.ki_period = any_scale();
    params.feedforward_share = any(0, INT32_MAX);
    params.amplitude_floor = any(PLL_FLOOR_LEAST, ONE(30));
    params.inverse_floor = any(ONE(13), ONE(30));
    params.emf_decay = any(0, ONE(30));
    params.sign_speed = any(ONE(16), ONE(28));
    params.inverse_sign_speed = any(ONE(17), ONE(30));
    params.signed_speed = any(ONE(18), ONE(30));
    return params;
}

static estimator_tuning_q_t any_tuning(int32_t switching, int32_t lag)
{
    estimator_tuning_q_t params;
    params.smo = any_smo(switching);
    params.pll = any_pll();
    params.lag = lag;
    params.speed_per_volt = any(ONE(13), ONE(29));
    params.torque_feedforward = any(0, INT32_MAX);
    params.amplitude_min = any(0, ONE(30));
    params.amplitude_max = any(0, INT32_MAX);
    params.amplitude_allowance = any(0, ONE(30));
    params.detector_max = any(0, INT32_MAX);
    params.current_max = any(0, INT32_MAX);
    params.speed_min = any(0, INT32_MAX);
    params.speed_max = any(0, INT32_MAX);
    for (int32_t n = 0; n < ESTIMATOR_CRITERIA; n++) {
        params.debounce.limit[n] = any_word(INT32_C(20000000));
    }
    return params;
}

static estimator_q_t any_state(int32_t switching, int32_t lag)
{
    estimator_q_t est;
    est.tuning = any_tuning(switching, lag);
    est.smo.tuning = est.tuning.smo;
    est.smo.current_hat = any_pair(SAMPLE_LARGEST + ERROR_LARGEST);
    est.smo.current_err = any_pair(ERROR_LARGEST);
    est.smo.switched = any_pair(SWITCHED_LARGEST);
    est.smo.emf_hat = any_pair(SWITCHED_LARGEST);
    est.smo.gain_axis.alpha = any(0, INT32_MAX);
    est.smo.gain_axis.beta = any(0, INT32_MAX);
    est.smo.mean_product = any_filter(est.tuning.smo.mean_share, -FILTER_Q_LONGEST);
    est.smo.mean_square = any_filter(est.tuning.smo.mean_share, -FILTER_Q_LONGEST);
    est.smo.gain_mean = any(0, INT32_MAX);
    est.smo.conductance = any(0, CONDUCTANCE_LARGEST);
    est.smo.rejected = any_word(1u);
    est.load = any(-SAMPLE_LARGEST, SAMPLE_LARGEST);
    est.pll.tuning = est.tuning.pll;
    est.pll.theta_e = any_word(UINT32_MAX);
    est.pll.rotation.sin = any(-ROTATION_MOST, ROTATION_MOST);
    est.pll.rotation.cos = any(-ROTATION_MOST, ROTATION_MOST);
    est.pll.integral = any_long(-2 * PLL_SPEED_LIMIT, 2 * PLL_SPEED_LIMIT);
    est.pll.feedforward = any_long(-PLL_SPEED_LIMIT, PLL_SPEED_LIMIT);
    est.pll.emf.d = any(-SAMPLE_LARGEST, SAMPLE_LARGEST);
    est.pll.emf.q = any(-SAMPLE_LARGEST, SAMPLE_LARGEST);
    est.pll.omega_e = any_number();
    est.pll.omega_smooth = any_number();
    est.pll.direction = any(-1, 1);
    est.pll.detector = any(-ONE(30), ONE(30));
    est.pll.amplitude = any(0, INT32_MAX);
    est.speed_per_volt = any(ONE(13), ONE(30) - 1);
    est.emf = any_pair(SAMPLE_LARGEST);
    for (int32_t n = 0; n < ESTIMATOR_CRITERIA; n++) {
        est.debounce.count[n] = any_word(UINT32_C(20000000));
    }
    est.debounce.counting = any_word(UINT32_MAX);
    est.debounce.invalid = any_word(15u);
    est.coasted = any_word(1u);
    return est;
}

/* Asserts that the state after a step is in the ranges of any_state(). */
static void check(const estimator_q_t *est)
{
    const ab_q_t x = est->smo.current_err;
    /*@ assert x_alpha: -ERROR_LARGEST <= x.alpha <= ERROR_LARGEST; */
    /*@ assert x_beta: -ERROR_LARGEST <= x.beta <= ERROR_LARGEST; */
    const ab_q_t hat = est->smo.current_hat;
    /*@ assert hat_alpha: -SAMPLE_LARGEST - ERROR_LARGEST <= hat.alpha <= SAMPLE_LARGEST + ERROR_LARGEST; */
    /*@ assert hat_beta: -SAMPLE_LARGEST - ERROR_LARGEST <= hat.beta <= SAMPLE_LARGEST + ERROR_LARGEST; */
    const ab_q_t v = est->smo.switched;
    /*@ assert v_alpha: -SWITCHED_LARGEST <= v.alpha <= SWITCHED_LARGEST; */
    /*@ assert v_beta: -SWITCHED_LARGEST <= v.beta <= SWITCHED_LARGEST; */
    const ab_q_t e_hat = est->smo.emf_hat;
    /*@ assert e_hat_alpha: -SWITCHED_LARGEST <= e_hat.alpha <= SWITCHED_LARGEST; */
    /*@ assert e_hat_beta: -SWITCHED_LARGEST <= e_hat.beta <= SWITCHED_LARGEST; */
    const int32_t g = est->smo.conductance;
    /*@ assert conductance: 0 <= g <= CONDUCTANCE_LARGEST; */
    const int32_t k_f = est->smo.gain_mean;
    /*@ assert gain_mean: k_f >= 0; */
    const ab_q_t k_axis = est->smo.gain_axis;
    /*@ assert gain_axis: k_axis.alpha >= 0 && k_axis.beta >= 0; */
    const int64_t product = est->smo.mean_product.value;
    /*@ assert mean_product: -FILTER_Q_LONGEST <= product <= FILTER_Q_LONGEST; */
    const int64_t mean_square = est->smo.mean_square.value;
    /*@ assert mean_square: -FILTER_Q_LONGEST <= mean_square <= FILTER_Q_LONGEST; */
    const rotation_q_t rotation = est->pll.rotation;
    /*@ assert sine: -ROTATION_MOST <= rotation.sin <= ROTATION_MOST; */
    /*@ assert cosine: -ROTATION_MOST <= rotation.cos <= ROTATION_MOST; */
    const int64_t integral = est->pll.integral;
    /*@ assert integral: -2 * PLL_SPEED_LIMIT <= integral <= 2 * PLL_SPEED_LIMIT; */
    const int64_t feedforward = est->pll.feedforward;
    /*@ assert feedforward: -PLL_SPEED_LIMIT <= feedforward <= PLL_SPEED_LIMIT; */
    const dq_q_t emf = est->pll.emf;
    /*@ assert loop_emf_d: -SAMPLE_LARGEST <= emf.d <= SAMPLE_LARGEST; */
    /*@ assert loop_emf_q: -SAMPLE_LARGEST <= emf.q <= SAMPLE_LARGEST; */
    const int32_t omega_e = est->pll.omega_e;
    /*@ assert omega_e: omega_e >= -INT32_MAX; */
    const int32_t omega_smooth = est->pll.omega_smooth;
    /*@ assert omega_smooth: omega_smooth >= -INT32_MAX; */
    const int32_t direction = est->pll.direction;
    /*@ assert direction: -1 <= direction <= 1; */
    const int32_t detector = est->pll.detector;
    /*@ assert detector: -0x40000000 <= detector <= 0x40000000; */
    const int32_t amplitude = est->pll.amplitude;
    /*@ assert amplitude: amplitude >= 0; */
    const ab_q_t e = est->emf;
    /*@ assert emf_alpha: -SAMPLE_LARGEST <= e.alpha <= SAMPLE_LARGEST; */
    /*@ assert emf_beta: -SAMPLE_LARGEST <= e.beta <= SAMPLE_LARGEST; */
}

void main(void)
{
    const int32_t switching = any(SMO_SIGN, SMO_SIGMOID_VECTOR);
    const int32_t lag = any(LAG_NONE, LAG_EXACT);
    estimator_q_t est = any_state(switching, lag);
    switch (any(0, 3)) {
    case 0:
        (void)estimator_step_q(&est, any_sample(), any_sample());
        break;
    case 1:
        (void)estimator_coast_q(&est, any_sample(), any_sample());
        break;
    case 2: {
        const position_q_t start = {any_word(UINT32_MAX), any_number()};
        estimator_reset_q(&est, start, any_pair(INT32_MAX));
        break;
    }
    default: {
        const estimator_tuning_q_t tuning = any_tuning(switching, lag);
        estimator_take_q(&est, &tuning);
        break;
    }
    }
    check(&est);
}
