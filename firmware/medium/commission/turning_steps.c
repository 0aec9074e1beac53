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
#define STRAIGHTENS  3u    /* [-] steps to the angle of the EMF of a saturating rotor */
#define NEAR         0.05f /* relative distance from the reference of a steady speed [-] */
#define STEADY       0.6f  /* [s] near it before a mean */
#define SMOOTH       15.0f /* [rad/s] low-pass of the speed for that */
#define MEAN         1.0f  /* [s] */

#define CYCLES       4u     /* [-] at least; the first one shows how long the phases take */
#define CYCLES_FEW   2u     /* [-] the same of a heavy rotor, whose phases have many slices */
#define CYCLES_MOST  40u    /* [-] more of them would only hide errors that do not scatter */
#define SCATTER_GOOD 0.007f /* standard error of J that ends the cycles, relative [-] */
#define SCATTER_FINE 0.003f /* the same that ends them after CYCLES_FEW [-] */
#define SCATTER_MOST 0.015f /* the same that is accepted after all cycles [-] */
#define LOW_SHARE    0.35f  /* low over high speed of the torque test [-] */
#define LOW_ABOVE    1.3f   /* low speed over that of the hand-over [-] */
#define COAST_TO     0.35f  /* of the way from low to high, where braking begins [-] */
#define BRAKE        0.5f   /* braking over accelerating current [-] */
#define PUSH_TIME    0.6f   /* [s] of the acceleration */
#define PUSH_SHORT   0.025f /* [s] of that of a light rotor */
#define PUSH_LEAST   0.08f  /* of the largest current [-] */
#define PUSH_MOST    0.8f
#define PUSH_ADDED   0.03f /* of the largest current, beyond friction [-] */
#define BIAS_PUSHES  2.0f  /* i_d over the push, at most [-] */
#define LOSS_REST    0.02f /* share of the dead time's loss that its compensation leaves in the EMF [-] */
#define TURNED_MOST  0.04f /* of the push that i_d adds by the EMF's angle, at most [-] */
#define PUSH_GROWTH  1.4f
#define PUSH_WAIT    3.0f   /* [s] after which a push that does not suffice grows */
#define COAST_MOST   3.0f   /* [s] */
#define SLICES       6.0f   /* of a push [-] */
#define SLICE_SHORT  160.0f /* [windows] up to which a phase is one slice */
#define SLICE_SHARE  0.9f   /* of the phase of the first cycle that the slices fill [-] */
#define WEIGHT_MOST                                                                                          \
    5e5f /* of a slice, that of 40 windows; more would give the noise of their torque too much weight [-] */
#define PARABOLA                                                                                             \
    1.875f               /* 15/8 (1 - x^2)^2: share of each moment in the curvature of a fitted parabola [-] \
                          */
#define SLICE_LEAST 6.0f /* [windows] */
#define SLICE_MOST  250.0f
#define SKIP        5u    /* [windows] after a change of the torque */
#define CONFIRMS    0.04f /* the same of two torque tests [-] */
#define AGREES      0.08f /* largest relative distance from the J of the swing [-] */
#define SLICES_LEAST                                                                                         \
    24.0f                /* of a fit: with fewer ones its standard error is small by chance too often [-]    \
                          */
#define STEADY_HIGH 0.9f /* of the high speed: first steady speed [-] */

static float length(dq_t vector)
{
    return root_or_none(vector.d * vector.d + vector.q * vector.q);
}

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

/* Current in the frame of the EMF [A]. */
static dq_t across_emf(const turning_input_t *input)
{
    const float amount = length(input->emf);
    const float share = amount > 0.0f ? 1.0f / amount : 0.0f;
    const rotation_t error = {-share * input->emf.d, share * input->emf.q};
    return frames_park((ab_t){input->current.d, input->current.q}, error);
}

float turning_mean_length(float n, float turn)
{
    const float y = 0.25f * turn * turn;
    const float nn = n * n;
    return 1.0f - (nn - 1.0f) * y * (1.0f / 6.0f - (3.0f * nn - 7.0f) * y * (1.0f / 360.0f));
}

/* Factor by which the mean of a turning vector over a window is too short, inverted. */
static float lengthening(const commission_tuning_t *tuning, const turning_input_t *input)
{
    return 1.0f / turning_mean_length(tuning->window / tuning->period, tuning->period * input->omega_e);
}

/* psi_q/i_q at this i_q [H]. */
static float apparent(const commission_tuning_t *tuning, float i_q)
{
    const float x = tuning->saturation > 0.0f ? i_q / tuning->saturation : 0.0f;
    return tuning->inductance_q * inverse_root(1.0f + x * x);
}

/* The observer takes L_q for constant: c = psi_q - L_q i_q of a saturating axis adds -omega c along the
 * magnet to its EMF, which has to be taken out before it shows the angle. */
static turning_input_t straightened(const commission_tuning_t *tuning, const turning_input_t *input)
{
    turning_input_t straight = *input;
    for (uint32_t n = 0u; n < STRAIGHTENS && tuning->saturation > 0.0f; n++) {
        const float i_q = across_emf(&straight).q;
        const float c = (apparent(tuning, i_q) - tuning->observed_q) * i_q;
        const float amount = length(straight.emf);
        const float share = amount > 0.0f ? input->omega_e * c / amount : 0.0f;
        straight.emf = (dq_t){input->emf.d + share * straight.emf.q, input->emf.q - share * straight.emf.d};
    }
    return straight;
}

/* Torque of a window [N m]. */
static float torque_of(const commission_tuning_t *tuning, const turning_input_t *input, float psi)
{
    const float longer = lengthening(tuning, input);
    const dq_t across = across_emf(input);
    const dq_t current = {longer * across.d, longer * across.q};
    const float reluctance = (tuning->inductance_d - apparent(tuning, current.q)) * current.d;
    return 1.5f * tuning->pole_pairs * (psi + reluctance) * current.q;
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
    const float longer = lengthening(tuning, input);
    const float reluctance = (tuning->inductance_d - tuning->observed_q) * longer * across_emf(input).d;
    const float speed = bounds_magnitude(input->omega_e);
    const float volts = longer * length(input->emf) - speed * (psi + reluctance);
    mean->windows += 1.0f;
    mean->omega += input->omega_e;
    mean->speed += speed;
    mean->volts += volts; /* about a near value, for the sum of the squares */
    mean->square += volts * volts;
    mean->torque += torque_of(tuning, input, psi);
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
    const turning_input_t straight = straightened(tuning, seen);
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
    results->flux_linkage = psi;
    results->flux_scatter = root_or_none(share * mean->square - volts * volts) / (share * mean->speed * psi);
    return commission_finished();
}

/* ---- J and friction ---- */

void torque_test_begin(torque_test_t *step)
{
    *step = (torque_test_t){.phase = (int32_t)TORQUE_START};
}

static void begin_phase(torque_test_t *step, torque_phase_t phase)
{
    step->phase = (int32_t)phase;
    step->windows = 0u;
    step->steady.windows = 0u;
    step->slice = (turning_slice_t){.windows = 0u};
    step->mean = (turning_mean_t){.windows = 0.0f};
}

/* Windows of a slice of this phase. */
static uint32_t length_of(const torque_test_t *step)
{
    return step->length[(uint32_t)step->phase - (uint32_t)TORQUE_UP];
}

/* The end of a slice: speed and acceleration from the parabola, mechanical. */
static void close(torque_test_t *step, const commission_tuning_t *tuning)
{
    turning_slice_t *part = &step->slice;
    const float n = (float)length_of(step);
    const float of_square = n * (n * n - 1.0f) * (n * n - 4.0f) * (1.0f / 180.0f);
    const float of_linear = n * (n * n - 1.0f) * (1.0f / 12.0f);
    const float per_time = 1.0f / tuning->window;
    /* the variance of the acceleration is the inverse of `of_square`, until other errors prevail */
    const float weight = root_or_none(bounds_less(of_square, WEIGHT_MOST));
    const float omega_m = part->linear * per_time / (of_linear * tuning->pole_pairs);
    const float middle = 0.5f * (step->low + step->high); /* about which the fit is well conditioned */
    const float x[TURNING_UNKNOWNS] = {weight * part->torque / n, weight, weight * (omega_m - middle)};
    turning_fit_add(&step->fit, x,
                    weight * 2.0f * part->square * per_time * per_time / (of_square * tuning->pole_pairs));
    part->windows = 0u;
    part->turned = 0.0f;
    part->linear = 0.0f;
    part->square = 0.0f;
    part->torque = 0.0f;
}

/* A window of a slice, with the angle of the EMF, which has no lag of the loop. */
static void slice(torque_test_t *step, const commission_tuning_t *tuning, const turning_input_t *input,
                  float psi)
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
    part->torque += PARABOLA * bell * bell * torque_of(tuning, input, psi);
    part->windows++;
    if (part->windows == length_of(step)) {
        close(step, tuning);
    }
}

/* The first push: PUSH_TIME for the way, by the J known so far. */
static void begin_pushing(torque_test_t *step, const commission_tuning_t *tuning, float psi)
{
    const float constant = 1.5f * tuning->pole_pairs * psi;
    const float inertia = step->earlier > 0.0f ? step->earlier : tuning->inertia;
    const float way = inertia * (step->high - step->low) / constant; /* [A s] */
    const float most = PUSH_MOST * tuning->current_max;
    const float least = bounds_less(PUSH_LEAST * tuning->current_max, way / PUSH_SHORT);
    const float wanted = bounds_more(way / PUSH_TIME, least);
    const float mean = step->mean.windows > 0.0f ? step->mean.torque / step->mean.windows : 0.0f;
    const float friction = bounds_magnitude(mean) / constant;
    step->push = bounds_less(wanted + friction + PUSH_ADDED * tuning->current_max, most);
    for (uint32_t n = 0u; n < 3u; n++) {
        step->length[n] = (uint32_t)SLICE_MOST;
    }
    begin_phase(step, TORQUE_UP);
}

/* What is left of the dead time turns the EMF, and i_d then counts as torque. true: by too much of the push.
 */
static bool is_turned(const torque_test_t *step, const commission_tuning_t *tuning,
                      const commission_results_t *results, float current_d, float psi)
{
    const float emf = psi * tuning->pole_pairs * step->low;
    const float most = bounds_less(bounds_magnitude(current_d), BIAS_PUSHES * step->push);
    return LOSS_REST * results->dead_voltage * most > TURNED_MOST * step->push * emf;
}

/* J of the fit [kg m^2] and its standard error, relative; 0: there is none that is good enough. */
static float inertia_of(const torque_test_t *step, float *error)
{
    float x[TURNING_UNKNOWNS];
    const bool good = step->fit.n >= SLICES_LEAST && turning_fit_solve(&step->fit, x, error) && x[0] > 0.0f &&
                      *error <= SCATTER_MOST;
    return good ? 1.0f / x[0] : 0.0f;
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

/* The pushes are over: the steady speeds follow, or a second test. */
static void end_pushing(torque_test_t *step, const commission_results_t *results, float psi)
{
    float error;
    const float inertia = inertia_of(step, &error);
    if (inertia > 0.0f && step->earlier == 0.0f && !is_confirmed(step, results, psi, inertia)) {
        *step = (torque_test_t){.phase = (int32_t)TORQUE_START,
                                .earlier = inertia,
                                .low = step->low,
                                .high = step->high,
                                .push = step->push};
        return;
    }
    begin_phase(step, TORQUE_STEADY_FAST);
}

/* true: the fit needs another cycle. */
static bool goes_on(const torque_test_t *step)
{
    float x[TURNING_UNKNOWNS];
    float error = 1.0f;
    const bool solved = step->fit.n >= SLICES_LEAST && turning_fit_solve(&step->fit, x, &error);
    uint32_t least = CYCLES;
    if (solved && error < SCATTER_FINE) {
        least = CYCLES_FEW;
    }
    return step->cycle < least || (!(solved && error < SCATTER_GOOD) && step->cycle < CYCLES_MOST);
}

/* A phase ends. That of the first cycle has shown how long it takes: slices as long as possible, because the
 * variance of an acceleration falls with the fifth power of their length. */
static void end_phase(torque_test_t *step, torque_phase_t next)
{
    if (step->cycle == 0u && step->phase <= (int32_t)TORQUE_DOWN) {
        const float room = SLICE_SHARE * ((float)step->windows - (float)SKIP);
        const float parts = (float)(uint32_t)bounds_clamp(room / SLICE_SHORT, SLICES - 1.0f) + 1.0f;
        step->length[(uint32_t)step->phase - (uint32_t)TORQUE_UP] =
            (uint32_t)bounds_less(bounds_more(room / parts, SLICE_LEAST), SLICE_MOST);
    }
    begin_phase(step, next);
}

/* Torque up, coast, brake. After the last push the rotor coasts for the time of the current's decay and then
 * changes to a speed, from which friction would have stopped a light rotor at the end of a brake. */
static void push(torque_test_t *step, const commission_tuning_t *tuning, const turning_input_t *input,
                 turning_wish_t *wish, const commission_results_t *results, float psi)
{
    const float omega_m = input->omega_e / tuning->pole_pairs;
    const float middle = step->low + COAST_TO * (step->high - step->low);
    slice(step, tuning, input, psi);
    step->windows++;
    if (step->phase == (int32_t)TORQUE_UP) {
        if (step->windows > periods_of(PUSH_WAIT, tuning->window)) {
            step->push = bounds_less(PUSH_GROWTH * step->push, PUSH_MOST * tuning->current_max);
            step->fit = (turning_fit_t){.n = 0.0f}; /* the rotor may have stood: friction was anything */
            begin_phase(step, TORQUE_UP);
        } else if (omega_m > step->high) {
            end_phase(step, TORQUE_COAST);
        }
    } else if (step->phase == (int32_t)TORQUE_COAST) {
        if (step->windows == SKIP + 1u && !goes_on(step)) {
            end_pushing(step, results, psi);
        } else if (omega_m < middle || step->windows > periods_of(COAST_MOST, tuning->window)) {
            end_phase(step, TORQUE_DOWN);
        }
    } else if (omega_m < step->low) {
        end_phase(step, TORQUE_UP);
        step->cycle++;
    }
    const float push = step->phase == (int32_t)TORQUE_UP     ? step->push
                       : step->phase == (int32_t)TORQUE_DOWN ? -BRAKE * step->push
                                                             : 0.0f;
    uint32_t by_current = 1u;
    if (step->phase == (int32_t)TORQUE_STEADY_FAST || step->phase == (int32_t)TORQUE_START) {
        by_current = 0u;
    }
    wish->current.d = bounds_clamp(wish->current.d, BIAS_PUSHES * step->push);
    *wish = (turning_wish_t){by_current, wish->omega_m_ref, {wish->current.d, push}};
}

static commission_verdict_t judge(const torque_test_t *step, commission_results_t *results, float psi)
{
    float error;
    const float inertia = inertia_of(step, &error);
    if (!(inertia > 0.0f) || !is_confirmed(step, results, psi, inertia)) {
        return commission_failed(COMMISSION_REASON_INERTIA_NOT_SEEN, 0);
    }
    const float apart = step->omega[0] - step->omega[1];
    const float slope = apart > 0.0f ? (step->torque[0] - step->torque[1]) / apart : 0.0f;
    const float viscous = bounds_more(slope, 0.0f);
    results->inertia = inertia;
    results->inertia_scatter = error;
    results->friction_viscous = viscous;
    results->friction_coulomb = bounds_more(
        0.5f * (step->torque[0] + step->torque[1] - viscous * (step->omega[0] + step->omega[1])), 0.0f);
    return commission_finished();
}

/* Means of a steady speed. */
static commission_verdict_t hold_speed(torque_test_t *step, const commission_tuning_t *tuning,
                                       const turning_input_t *input, turning_wish_t *wish,
                                       commission_results_t *results, float psi)
{
    uint32_t which = 1u;
    if (step->phase == (int32_t)TORQUE_STEADY_FAST) {
        which = 0u;
    }
    turning_mean_t *mean = &step->mean;
    wish->omega_m_ref = which == 0u ? STEADY_HIGH * step->high : step->low;
    if (!is_steady(&step->steady, tuning, input, wish->omega_m_ref)) {
        *mean = (turning_mean_t){.windows = 0.0f};
        return commission_goes_on();
    }
    mean_add(mean, tuning, input, psi);
    if (mean->windows < (float)periods_of(MEAN, tuning->window)) {
        return commission_goes_on();
    }
    step->torque[which] = mean->torque / mean->windows;
    step->omega[which] = mean->omega / (mean->windows * tuning->pole_pairs);
    if (which == 1u) {
        return judge(step, results, psi);
    }
    begin_phase(step, TORQUE_STEADY_SLOW);
    return commission_goes_on();
}

commission_verdict_t torque_test_step(torque_test_t *step, const commission_tuning_t *tuning,
                                      const turning_input_t *seen, turning_wish_t *wish,
                                      commission_results_t *results)
{
    const turning_input_t straight = straightened(tuning, seen);
    const turning_input_t *input = &straight;
    const float psi = flux(tuning, results);
    step->high = input->speed;
    step->low = bounds_more(LOW_SHARE * input->speed, LOW_ABOVE * input->least);
    *wish = (turning_wish_t){0u, step->low, {bias(BIAS_TORQUE, tuning, psi), 0.0f}};
    if (!(step->low < 0.7f * step->high)) {
        return commission_failed(COMMISSION_REASON_EMF_TOO_SMALL, 0);
    }
    if (step->phase == (int32_t)TORQUE_START) {
        const bool steady = is_steady(&step->steady, tuning, input, step->low);
        if (step->steady.windows == 0u) {
            step->mean = (turning_mean_t){.windows = 0.0f};
        }
        mean_add(&step->mean, tuning, input, psi);
        if (steady) {
            begin_pushing(step, tuning, psi);
            if (is_turned(step, tuning, results, wish->current.d, psi)) {
                return commission_failed(COMMISSION_REASON_EMF_TOO_SMALL, 0);
            }
        }
        return commission_goes_on();
    }
    if (step->phase >= (int32_t)TORQUE_STEADY_FAST) {
        return hold_speed(step, tuning, input, wish, results, psi);
    }
    if (input->runs == 0u) {
        return commission_failed(COMMISSION_REASON_SENSORLESS_LOST, 0);
    }
    push(step, tuning, input, wish, results, psi);
    return commission_goes_on();
}
