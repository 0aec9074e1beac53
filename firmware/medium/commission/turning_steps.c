#include "medium/commission/turning_steps.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/periods.h"
#include "math/root.h"
#include "math/trig.h"

#define BIAS         0.5f  /* of the largest current: i_d of the flux test [-] */
#define BIAS_TORQUE  0.25f /* the same of the torque test [-] */
#define SALIENT_FROM 0.1f  /* (L_q - L_d)/L_d from which on a rotor counts as salient [-] */
#define SALIENT_BIAS 0.3f  /* share of psi_f that its i_d adds, at most [-] */
#define NEAR         0.05f /* relative distance from the reference of a steady speed [-] */
#define STEADY       0.6f  /* [s] near it before a mean */
#define SMOOTH       15.0f /* [rad/s] low-pass of the speed for that */
#define MEAN         1.0f  /* [s] */

#define CYCLES      UINT32_C(4) /* [-] at least; the first one shows how long the phases take */
#define CYCLES_FEW  UINT32_C(2) /* [-] the same of a heavy rotor, whose phases have many slices */
#define CYCLES_MOST 40u         /* [-] more of them would only hide errors that do not scatter */
#define SCATTER_GOOD                                                                                         \
    0.005f /* standard error of J that ends the cycles, relative: the slices share errors of the dead time,  \
              so that J scatters by up to 2.5 times this value; 4 % shall be three deviations [-] */
#define SCATTER_FINE 0.003f /* the same that ends them after CYCLES_FEW [-] */
#define SCATTER_MOST 0.015f /* the same that is accepted after all cycles [-] */
#define LOW_SHARE    0.35f  /* low over high speed of the torque test [-] */
#define LOW_ABOVE    1.3f   /* low speed over that of the hand-over [-] */
#define COAST_TO     0.35f  /* of the way from low to high, where braking begins [-] */
#define BRAKE        0.5f   /* braking over accelerating current [-] */
#define PUSH_TIME    0.6f   /* [s] of the acceleration; a coast lasts no longer than this or the last push */
#define PUSH_SHORT   0.025f /* [s] of that of a light rotor */
#define PUSH_LEAST   0.08f  /* of the largest current [-] */
#define PUSH_MOST    0.8f
#define PUSH_ADDED   0.03f /* of the largest current, beyond friction [-] */
#define BIAS_PUSHES  2.0f  /* i_d over the push, at most [-] */
#define LOSS_REST    0.02f /* share of the dead time's loss that its compensation leaves in the EMF [-] */
#define TURNED_MOST  0.04f /* of the push that i_d adds by the EMF's angle, at most [-] */
#define PUSH_GROWTH  1.4f
#define PUSH_WAIT    3.0f   /* [s] after this time a push that is too weak is increased */
#define SLICES       6.0f   /* of a push [-] */
#define SLICE_SHORT  160.0f /* [windows] up to which a phase is one slice */
#define SLICE_SHARE  0.9f   /* of the phase of the first cycle that the slices fill [-] */
#define WEIGHT_MOST                                                                                          \
    5e5f /* of a slice, that of 40 windows; more would give the noise of their torque too much weight [-] */
/* [-] 15/8 (1 - x^2)^2: share of each moment in the curvature of a fitted parabola */
#define PARABOLA    1.875f
#define SLICE_LEAST 6.0f /* [windows] */
#define SLICE_MOST  250.0f
#define SKIP        5u    /* [windows] after a change of the torque */
#define CONFIRMS    0.04f /* the same of two torque tests [-] */
#define AGREES      0.08f /* largest relative distance from the J of the swing [-] */
/* [-] of a fit: with fewer slices its standard error is too often small by chance */
#define SLICES_LEAST 24.0f
#define STEADY_HIGH  0.9f /* of the high speed: first steady speed [-] */
#define STEADY_SLICES                                                                                        \
    10.0f /* slices of WEIGHT_MOST that a steady speed counts as: its mean of 1250 windows scatters less     \
             than 30 of 40, and an error that the slices do not have shall not prevail [-] */

/* psi_f by the results, else by the parameters. */
static float flux(const commission_tuning_t *tuning, const commission_results_t *results)
{
    return results->flux_linkage > 0.0f ? results->flux_linkage : tuning->flux_linkage;
}

/* i_d of a test [A]: this share of the largest current. On a salient rotor it is below zero, so that it adds
 * to the active flux, and so small that an error of the inductances does not count in psi_f. */
static float bias(float share, const commission_tuning_t *tuning, float psi)
{
    const float apart = tuning->inductance_q - tuning->inductance_d;
    const float current = share * tuning->current_max;
    if (!(apart > SALIENT_FROM * tuning->inductance_d)) {
        return current;
    }
    return -bounds_less(current, SALIENT_BIAS * psi / apart);
}

/* Counts the windows near this speed. true: it has been steady for a while. The estimate of a window is noisy
 * where the back-EMF is small, so that its low-passed value is judged. */
static bool is_steady(turning_steady_t *steady, const commission_tuning_t *tuning,
                      const turning_input_t *input, float omega_m)
{
    const float omega_e = tuning->pole_pairs * omega_m;
    const float share = bounds_less(SMOOTH * tuning->window, 1.0f);
    steady->omega_e += share * (input->omega_e - steady->omega_e);
    const bool near = input->runs != 0u && bounds_within(steady->omega_e - omega_e, NEAR * omega_e);
    steady->windows = near ? steady->windows + 1u : 0u;
    return steady->windows > periods_of(STEADY, tuning->window);
}

static void mean_add(turning_mean_t *mean, const commission_tuning_t *tuning, const turning_input_t *input,
                     float psi)
{
    const float longer = turning_lengthening(tuning, input);
    const float reluctance = (tuning->inductance_d - tuning->observed_q) * longer * turning_current(input).d;
    const float speed = bounds_magnitude(input->omega_e);
    const float volts = longer * turning_emf(input) - speed * (psi + reluctance);
    mean->windows += 1.0f;
    mean->omega += input->omega_e;
    mean->speed += speed;
    mean->volts += volts; /* the distance from an approximate value, because of the sum of the squares */
    mean->square += volts * volts;
    mean->torque += turning_torque(tuning, input, psi);
}

/* ---- psi_f ---- */

void flux_test_begin(flux_test_t *step)
{
    *step = (flux_test_t){.steady = {0u, 0.0f}};
}

commission_verdict_t flux_test_step(flux_test_t *step, const commission_tuning_t *tuning,
                                    const turning_input_t *seen, turning_wish_t *wish,
                                    commission_results_t *results)
{
    const turning_input_t straight = turning_straightened(tuning, seen);
    const turning_input_t *input = &straight;
    turning_mean_t *mean = &step->mean;
    const float near = tuning->flux_linkage;
    *wish = (turning_wish_t){0u, input->speed, {bias(BIAS, tuning, near), 0.0f}};
    if (!is_steady(&step->steady, tuning, input, input->speed)) {
        *mean = (turning_mean_t){.windows = 0.0f};
        return commission_goes_on();
    }
    mean_add(mean, tuning, input, near);
    if (mean->windows < (float)periods_of(MEAN, tuning->window)) {
        return commission_goes_on();
    }
    const float share = 1.0f / mean->windows;
    const float volts = share * mean->volts;
    const float psi = near + mean->volts / mean->speed;
    if (!(psi > 0.0f)) {
        return commission_failed(COMMISSION_REASON_EMF_TOO_SMALL, 0);
    }
    results->point = (commission_point_t){share * mean->speed, share * mean->speed * psi};
    results->flux_linkage = psi;
    results->flux_scatter = root_or_none(share * mean->square - volts * volts) / (share * mean->speed * psi);
    return commission_finished();
}

/* ---- J and friction ---- */

void torque_test_begin(torque_test_t *step)
{
    *step = (torque_test_t){.phase = (int32_t)TORQUE_STEADY_FAST};
}

static void begin_phase(torque_test_t *step, torque_phase_t phase)
{
    step->phase = (int32_t)phase;
    step->windows = 0u;
    step->steady.windows = 0u;
    step->slice = (turning_slice_t){.windows = 0u};
    step->mean = (turning_mean_t){.windows = 0.0f};
}

/* Adds a row to the fit. */
static void add_row(const torque_test_t *step, turning_fit_t *fit, float weight, turning_point_t point)
{
    const float middle = 0.5f * (step->low + step->high); /* relative to it the fit is well conditioned */
    const float x[TURNING_UNKNOWNS] = {weight * point.torque, weight, weight * (point.omega - middle)};
    turning_fit_add(fit, x, weight * point.acceleration);
}

/* Number of windows in a slice of this phase. */
static uint32_t length_of(const torque_test_t *step)
{
    return step->length[(uint32_t)step->phase - (uint32_t)TORQUE_UP];
}

/* The end of a slice: speed and acceleration from the parabola, mechanical. */
static void close(torque_test_t *step, const commission_tuning_t *tuning, commission_results_t *results)
{
    turning_slice_t *part = &step->slice;
    const float n = (float)length_of(step);
    const float of_square = n * (n * n - 1.0f) * (n * n - 4.0f) * (1.0f / 180.0f);
    const float of_linear = n * (n * n - 1.0f) * (1.0f / 12.0f);
    const float per_time = 1.0f / tuning->window;
    /* the variance of the acceleration is the inverse of `of_square`, until other errors prevail */
    const float weight = root_or_none(bounds_less(of_square, WEIGHT_MOST));
    const turning_point_t point = {
        part->torque / n, part->linear * per_time / (of_linear * tuning->pole_pairs),
        2.0f * part->square * per_time * per_time / (of_square * tuning->pole_pairs)};
    results->point = (commission_point_t){point.torque, point.acceleration};
    add_row(step, &step->fit, weight, point);
    part->windows = 0u;
    part->turned = 0.0f;
    part->linear = 0.0f;
    part->square = 0.0f;
    part->torque = 0.0f;
}

/* A window of a slice, with the angle of the EMF, which has no lag of the loop. */
static void slice(torque_test_t *step, const commission_tuning_t *tuning, const turning_input_t *input,
                  commission_results_t *results, float psi)
{
    turning_slice_t *part = &step->slice;
    const float angle = angle_wrap(input->theta_e + trig_atan2(-input->emf.d, input->emf.q));
    const float turned = angle_wrap(angle - part->angle);
    part->angle = angle;
    if (part->skipped < SKIP) {
        part->skipped++;
        return;
    }
    const float n = (float)length_of(step);
    const float m = (float)part->windows - 0.5f * (n - 1.0f);
    part->turned += part->windows > 0u ? turned : 0.0f;
    part->linear += m * part->turned;
    part->square += (m * m - (n * n - 1.0f) * (1.0f / 12.0f)) * part->turned;
    const float place = 2.0f * m / n; /* -1 to 1 */
    const float bell = 1.0f - place * place;
    part->torque += PARABOLA * bell * bell * turning_torque(tuning, input, psi);
    part->windows++;
    if (part->windows == length_of(step)) {
        close(step, tuning, results);
    }
}

/* The first push without friction: with the J known so far the speed rises from low to high in PUSH_TIME. */
static float first_push(const torque_test_t *step, const commission_tuning_t *tuning, float psi)
{
    const float inertia = step->earlier > 0.0f ? step->earlier : tuning->inertia;
    const float way = inertia * (step->high - step->low) / (1.5f * tuning->pole_pairs * psi); /* [A s] */
    const float least = bounds_less(PUSH_LEAST * tuning->current_max, way / PUSH_SHORT);
    return bounds_more(way / PUSH_TIME, least) + PUSH_ADDED * tuning->current_max;
}

static void begin_pushing(torque_test_t *step, const commission_tuning_t *tuning, float psi)
{
    const float most = PUSH_MOST * tuning->current_max;
    const float friction = bounds_magnitude(step->point[1].torque) / (1.5f * tuning->pole_pairs * psi);
    step->push = bounds_less(first_push(step, tuning, psi) + friction, most);
    for (uint32_t n = 0u; n < 3u; n++) {
        step->length[n] = (uint32_t)SLICE_MOST;
    }
    begin_phase(step, TORQUE_UP);
}

/* The remaining voltage error of the dead time turns the EMF, and a part of i_d then counts as torque. true:
 * this part is too large a share of the push. */
static bool is_turned(const torque_test_t *step, const commission_tuning_t *tuning,
                      const commission_results_t *results, float current_d, float psi)
{
    const float emf = psi * tuning->pole_pairs * step->low;
    return LOSS_REST * results->dead_voltage * bounds_magnitude(current_d) > TURNED_MOST * step->push * emf;
}

/* J by the fit of the slices and of the steady speeds. */
typedef struct {
    float inertia; /* 0: the fit has no solution yet [kg m^2] */
    float error;   /* standard error, relative; 1 without a solution [-] */
} fitted_t;

static fitted_t solve(const torque_test_t *step)
{
    float x[TURNING_UNKNOWNS];
    float error = 1.0f;
    turning_fit_t fit = step->fit;
    for (uint32_t n = 0u; n < 2u && step->changed == 0u; n++) {
        add_row(step, &fit, root_or_none(STEADY_SLICES * WEIGHT_MOST), step->point[n]);
    }
    if (step->fit.n < SLICES_LEAST || !turning_fit_solve(&fit, x, &error) || !(x[0] > 0.0f)) {
        return (fitted_t){0.0f, 1.0f};
    }
    return (fitted_t){1.0f / x[0], error};
}

/* The swing has measured J in another way, proportional to its psi_f, which is known better now: if the two
 * disagree, a second test has to confirm the first one. */
static bool is_confirmed(const torque_test_t *step, const commission_results_t *results, float psi,
                         float inertia)
{
    const float corrected = results->flux_first > 0.0f ? psi / results->flux_first : 1.0f;
    const float swung = corrected * results->inertia_first;
    return !(swung > 0.0f) || bounds_within(inertia - swung, AGREES * swung) ||
           bounds_within(inertia - step->earlier, CONFIRMS * step->earlier);
}

/* A second test, which keeps the fast steady speed of the first one. The slow one brings the rotor to the
 * begin of a push. */
static void begin_second(torque_test_t *step, float inertia)
{
    const turning_point_t fast = step->point[0];
    const torque_phase_t from = step->changed != 0u ? TORQUE_STEADY_FAST : TORQUE_STEADY_SLOW;
    *step = (torque_test_t){.phase = (int32_t)from, .earlier = inertia};
    step->point[0] = fast;
}

/* The pushes have ended: computes the friction by the steady speeds, or starts a second test. */
static commission_verdict_t judge(torque_test_t *step, commission_results_t *results, fitted_t fitted,
                                  float psi)
{
    const float inertia = fitted.error <= SCATTER_MOST ? fitted.inertia : 0.0f;
    const bool confirmed = inertia > 0.0f && is_confirmed(step, results, psi, inertia);
    if (inertia > 0.0f && step->earlier == 0.0f && !confirmed) {
        begin_second(step, inertia);
        return commission_goes_on();
    }
    if (!confirmed) {
        return commission_failed(COMMISSION_REASON_INERTIA_NOT_SEEN, 0);
    }
    const turning_point_t *fast = &step->point[0];
    const turning_point_t *slow = &step->point[1];
    const float torque_fast = fast->torque - inertia * fast->acceleration;
    const float torque_slow = slow->torque - inertia * slow->acceleration;
    const float apart = fast->omega - slow->omega;
    const float slope = apart > 0.0f ? (torque_fast - torque_slow) / apart : 0.0f;
    const float viscous = bounds_more(slope, 0.0f);
    results->inertia = inertia;
    results->inertia_scatter = fitted.error;
    results->friction_viscous = viscous;
    results->friction_coulomb =
        bounds_more(0.5f * (torque_fast + torque_slow - viscous * (fast->omega + slow->omega)), 0.0f);
    return commission_finished();
}

/* true: the fit needs another cycle. */
static bool goes_on(const torque_test_t *step, fitted_t fitted)
{
    const uint32_t least = fitted.error < SCATTER_FINE ? CYCLES_FEW : CYCLES;
    return step->cycle < least || (!(fitted.error < SCATTER_GOOD) && step->cycle < CYCLES_MOST);
}

/* The end of a phase. The phases of the first cycle show how long they take. The slices are then made as long
 * as possible, because the variance of an acceleration falls with the fifth power of their length. */
static void end_phase(torque_test_t *step, torque_phase_t next)
{
    if (step->cycle == 0u && step->phase >= (int32_t)TORQUE_UP) {
        const float room = SLICE_SHARE * ((float)step->windows - (float)SKIP);
        const float parts = (float)(uint32_t)bounds_clamp(room / SLICE_SHORT, SLICES - 1.0f) + 1.0f;
        step->length[(uint32_t)step->phase - (uint32_t)TORQUE_UP] =
            (uint32_t)bounds_less(bounds_more(room / parts, SLICE_LEAST), SLICE_MOST);
    }
    begin_phase(step, next);
}

/* The next phase: accelerate, coast, brake. After the last push the rotor coasts for the time of the
 * current's decay.
 *
 * J is the difference of two torques over that of their accelerations. The variance of an acceleration falls
 * with the length of its phase, so that for a given time the sum of both variances is smallest if push and
 * coast last equally long. A heavy rotor coasts for many seconds until it reaches the speed of the brake. */
static commission_verdict_t push(torque_test_t *step, const commission_tuning_t *tuning,
                                 const turning_input_t *input, turning_wish_t *wish,
                                 commission_results_t *results, float psi)
{
    const float omega_m = input->omega_e / tuning->pole_pairs;
    const float middle = step->low + COAST_TO * (step->high - step->low);
    slice(step, tuning, input, results, psi);
    step->windows++;
    if (step->phase == (int32_t)TORQUE_UP) {
        if (step->windows > periods_of(PUSH_WAIT, tuning->window)) {
            step->push = bounds_less(PUSH_GROWTH * step->push, PUSH_MOST * tuning->current_max);
            step->fit = (turning_fit_t){.n = 0.0f}; /* at standstill the friction could have any value */
            step->changed = 1u;
            begin_phase(step, TORQUE_UP);
        } else if (omega_m > step->high) {
            const uint32_t least = periods_of(PUSH_TIME, tuning->window);
            step->coasts = step->windows > least ? step->windows : least;
            end_phase(step, TORQUE_COAST);
        }
    } else if (step->phase == (int32_t)TORQUE_COAST) {
        if (step->windows == SKIP + 1u) {
            const fitted_t fitted = solve(step);
            if (!goes_on(step, fitted)) {
                return judge(step, results, fitted, psi);
            }
        }
        if (omega_m < middle || step->windows >= step->coasts) {
            end_phase(step, TORQUE_DOWN);
        }
    } else if (omega_m < step->low) {
        end_phase(step, TORQUE_UP);
        step->cycle++;
    }
    wish->by_current = 1u;
    wish->current.q = step->phase == (int32_t)TORQUE_UP     ? step->push
                      : step->phase == (int32_t)TORQUE_DOWN ? -BRAKE * step->push
                                                            : 0.0f;
    return commission_goes_on();
}

/* Means of a steady speed; after both the pushes begin. */
static commission_verdict_t hold_speed(torque_test_t *step, const commission_tuning_t *tuning,
                                       const turning_input_t *input, turning_wish_t *wish,
                                       const commission_results_t *results, float psi)
{
    const uint32_t which = (uint32_t)step->phase - (uint32_t)TORQUE_STEADY_FAST;
    turning_mean_t *mean = &step->mean;
    wish->omega_m_ref = which == 0u ? STEADY_HIGH * step->high : step->low;
    if (!is_steady(&step->steady, tuning, input, wish->omega_m_ref)) {
        *mean = (turning_mean_t){.windows = 0.0f};
        return commission_goes_on();
    }
    const float count = 2.0f * (float)periods_of(0.5f * MEAN, tuning->window); /* of two halves */
    mean_add(mean, tuning, input, psi);
    if (mean->windows <= 0.5f * count) {
        step->half = mean->omega;
    }
    if (mean->windows < count) {
        return commission_goes_on();
    }
    const float per_pairs = 1.0f / (mean->windows * tuning->pole_pairs);
    step->point[which] =
        (turning_point_t){mean->torque / mean->windows, mean->omega * per_pairs,
                          4.0f * (mean->omega - 2.0f * step->half) * per_pairs / (count * tuning->window)};
    if (which == 0u) {
        begin_phase(step, TORQUE_STEADY_SLOW);
        return commission_goes_on();
    }
    begin_pushing(step, tuning, psi);
    return is_turned(step, tuning, results, wish->current.d, psi)
               ? commission_failed(COMMISSION_REASON_EMF_TOO_SMALL, 0)
               : commission_goes_on();
}

commission_verdict_t torque_test_step(torque_test_t *step, const commission_tuning_t *tuning,
                                      const turning_input_t *seen, turning_wish_t *wish,
                                      commission_results_t *results)
{
    const turning_input_t straight = turning_straightened(tuning, seen);
    const turning_input_t *input = &straight;
    const float psi = flux(tuning, results);
    step->high = input->speed;
    step->low = bounds_more(LOW_SHARE * input->speed, LOW_ABOVE * input->least);
    if (!(step->low < 0.7f * step->high)) {
        return commission_failed(COMMISSION_REASON_EMF_TOO_SMALL, 0);
    }
    /* the same i_d in all phases: the torque that it adds by an error of the angle is then the same as well
     */
    const float most = BIAS_PUSHES * first_push(step, tuning, psi);
    *wish = (turning_wish_t){0u, step->low, {bounds_clamp(bias(BIAS_TORQUE, tuning, psi), most), 0.0f}};
    if (step->phase < (int32_t)TORQUE_UP) {
        return hold_speed(step, tuning, input, wish, results, psi);
    }
    if (input->runs == 0u) {
        return commission_failed(COMMISSION_REASON_SENSORLESS_LOST, 0);
    }
    return push(step, tuning, input, wish, results, psi);
}
