#include "medium/manoeuvre/run.h"

#include "math/bounds.h"
#include "math/filter.h"
#include "math/root.h"

/* Factor on the speed control when it is made slower because it oscillates [-]. */
#define CALMER     0.5f /* each time */
#define CALM_LEAST 0.25f

/* [-] factor by which the limits of i_q, which are two steps old, are widened so
 * that they do not limit the torque. */
#define ROOM_SPARE 1.05f

void run_init(run_t *run, const run_tuning_t *tuning)
{
    run->tuning = *tuning;
    run->apart = tuning->saliency;
    run->steep = tuning->saliency;
    run->calm = 1.0f;
    run->swings = 0u;
    run->stiff = 1.0f;
    run->low_kept = 1.0f;
    weakening_init(&run->weakening, &tuning->weakening);
    speed_control_init(&run->speed, &tuning->speed);
    run_limit(run, -tuning->speed.current_limit, tuning->speed.current_limit);
    run_enter(run, (dq_t){0.0f, 0.0f}, 0.0f);
}

void run_enter(run_t *run, dq_t current, float omega_m)
{
    const float kept = run->low_kept * run->tuning.low_current;
    run->omega_m_ref = omega_m;
    run->i_d = current.d;
    run->i_d_mtpa = 0.0f;
    run->limited = 0u;
    if (run->tuning.saliency > 0.0f) {
        run->i_d_low = current.d < 0.0f ? -bounds_clamp(current.d, kept) : 0.0f;
        run->i_d_left = current.d + run->i_d_low;
    } else {
        run->i_d_low = bounds_clamp(current.d, kept);
        run->i_d_left = current.d;
    }
    run->torque = run_torque(run) * current.q;
    speed_control_reset(&run->speed, run->torque, omega_m);
}

static void scale_speed(run_t *run)
{
    const speed_control_tuning_t speed = speed_control_scaled(&run->tuning.speed, run->calm * run->stiff);
    speed_control_take(&run->speed, &speed, run->omega_m_ref);
}

void run_calm(run_t *run, bool whole)
{
    const float calmer = CALMER * run->calm;
    run->calm = whole ? 1.0f : calmer > CALM_LEAST ? calmer : CALM_LEAST;
    scale_speed(run);
}

void run_stiffen(run_t *run, float factor)
{
    const float next = bounds_more(factor, RUN_RELAX * run->stiff);
    if (next != run->stiff) {
        run->stiff = next;
        scale_speed(run);
    }
}

/* ---- i_d ---- */

/* D at this i_q [A], in equal parts with that of the last step, because i_q depends on the result. A
 * division. */
static void saturate(run_t *run, float i_q)
{
    const run_tuning_t *tuning = &run->tuning;
    const saturation_point_t point = saturation_at(&tuning->saturation, i_q);
    const float per_flux = tuning->weakening.inverse_flux;
    const float apart = tuning->saliency + point.excess * per_flux;
    run->apart = lowpass_step(run->apart, RUN_MTPA_SHARE, apart);
    run->steep = run->apart + bounds_magnitude(i_q) * point.slope * per_flux;
    weakening_bend(&run->weakening,
                   tuning->weakening.inductance_d + run->apart * tuning->weakening.flux_linkage);
}

/* The same as most_per_ampere() with D_a of the apparent and D_i of the incremental L_q: 2 D_a i_q^2/(psi_f +
 * sqrt(psi_f^2 + 4 D_a D_i i_q^2)). */
static float most_per_ampere_bent(const run_t *run, float i_q)
{
    const float lean = 2.0f * bounds_more(run->apart, 0.0f) * i_q;
    const float square = 1.0f + 2.0f * run->steep * i_q * lean;
    return lean * i_q / (1.0f + root_or_none(square));
}

/* Magnitude of the i_d of most torque per ampere for this i_q [A]: 2 D i_q^2/(psi_f + sqrt(psi_f^2 + 4 D^2
 * i_q^2)). */
static float most_per_ampere(const run_t *run, float i_q)
{
    if (saturation_is_on(&run->tuning.saturation)) {
        return most_per_ampere_bent(run, i_q);
    }
    const float lean = 2.0f * run->tuning.saliency * i_q;
    const float square = 1.0f + lean * lean;
    return lean * i_q / (1.0f + square * inverse_root(square));
}

/* i_d of a salient rotor [A]. It follows i_q in several steps, because i_q depends on it. */
static float salient(run_t *run, float i_q, float low)
{
    const run_tuning_t *tuning = &run->tuning;
    const float wanted = tuning->mtpa != 0u ? most_per_ampere(run, i_q) : 0.0f;
    run->i_d_mtpa = lowpass_step(run->i_d_mtpa, RUN_MTPA_SHARE, wanted);
    run->i_d_low = lowpass_step(run->i_d_low, tuning->low_share, low);
    return run->i_d_left - (run->i_d_low > run->i_d_mtpa ? run->i_d_low : run->i_d_mtpa);
}

/* i_d in addition to the requested one [A], for this i_q [A], without the effect of the voltage. */
static float unweakened(run_t *run, float i_q, float omega_e)
{
    const run_tuning_t *tuning = &run->tuning;
    const float slower = 1.2f - bounds_magnitude(omega_e) * tuning->low_inverse;
    const float kept = slower < 1.0f ? (slower > 0.2f ? slower : 0.2f) : 1.0f;
    const float short_of = kept * run->low_kept * tuning->low_current - bounds_magnitude(i_q);
    const float low = short_of > 0.0f ? short_of : 0.0f;
    const float left = tuning->fade * run->i_d_left;
    run->i_d_left = bounds_within(left, RUN_NOTHING) ? 0.0f : left;
    if (tuning->saliency > 0.0f) {
        return salient(run, i_q, low);
    }
    run->i_d_low = lowpass_step(run->i_d_low, tuning->low_share, low);
    return run->i_d_left > run->i_d_low ? run->i_d_left : run->i_d_low;
}

/* ---- torque ---- */

float run_room(const run_t *run)
{
    const float limit = run->speed.current_limit;
    const bool looks = run->weakening.looks != 0u;
    const float i_d = run->tuning.saliency > 0.0f || looks ? run->i_d : run->i_d_left;
    const float square = limit * limit - i_d * i_d;
    const float room = i_d == 0.0f ? limit : root_or_none(square);
    const float most = run->weakening.i_q_most;
    return looks && most < room ? most : room;
}

/* Limits of the torque as a current of psi_f: by heat and DC link, by the longest vector and by the
 * voltage. Where the voltage may limit, i_d reaches the value of most torque only if that torque may
 * be requested. The limit is therefore the torque of i_q with the i_d at the limit, and the fast
 * task limits i_q to what remains. */
static bounds_t torque_limits(const run_t *run)
{
    const weakening_t *weakening = &run->weakening;
    const float room = run_room(run);
    const float torque = weakening->looks != 0u ? ROOM_SPARE * weakening->torque_share : run_torque(run);
    bounds_t limits = {torque * bounds_clamp(run->lower, room), torque * bounds_clamp(run->upper, room)};
    if (weakening->looks != 0u) {
        limits.lower = bounds_clamp(limits.lower, weakening->torque_limit);
        limits.upper = bounds_clamp(limits.upper, weakening->torque_limit);
    }
    return limits;
}

/* true: the torque of this step is at one of its limits. */
static uint32_t at_limit(const run_t *run, bounds_t limits)
{
    return run->torque <= limits.lower || run->torque >= limits.upper ? UINT32_C(1) : UINT32_C(0);
}

/* Limits to which the torque may have grown at the end of this step. */
static bounds_t grown(const run_t *run)
{
    const float last = run->torque;
    return (bounds_t){(last < 0.0f ? last : 0.0f) - run->tuning.slew,
                      (last > 0.0f ? last : 0.0f) + run->tuning.slew};
}

/* The torque of the speed control, and its change with the speed in the periods until the next step. */
static void follow_speed(run_t *run, float omega_m, bounds_t limits)
{
    const float kp = run->speed.pi.tuning.kp;
    float standing = speed_control_standing(&run->speed, run->omega_m_ref);
    bounds_t narrow = limits;
    if (run->tuning.slew > 0.0f) {
        const bounds_t slewed = grown(run);
        narrow = (bounds_t){bounds_between(slewed.lower, limits), bounds_between(slewed.upper, limits)};
        standing = bounds_between(standing - kp * omega_m, slewed) + kp * omega_m;
    }
    run->torque = speed_control_step(&run->speed, run->omega_m_ref, omega_m, narrow.lower, narrow.upper);
    run->limited = at_limit(run, limits);
    run->i_q_standing = standing;
    run->stiffness = kp;
}

/* The requested torque [N m]. The speed control follows it. */
static void follow_torque(run_t *run, float wanted, float omega_m, bounds_t limits)
{
    const float torque = bounds_between(run->tuning.per_torque * wanted, limits);
    run->torque = run->tuning.slew > 0.0f ? bounds_between(torque, grown(run)) : torque;
    run->limited = at_limit(run, limits);
    run->i_q_standing = run->torque;
    run->stiffness = 0.0f;
    run->omega_m_ref = omega_m;
    speed_control_reset(&run->speed, run->torque, omega_m);
}

/* The current that makes the torque [A]: i_d follows from the i_q that is needed with the i_d of the last
 * step, and from the voltage limit; i_q is psi_f/psi_a of the torque. */
static dq_t current_of(run_t *run, float i_d_wanted, float omega_e)
{
    const bool salient_rotor = run->tuning.saliency > 0.0f;
    const float i_q = salient_rotor ? run->torque / run_torque(run) : run->torque;
    if (salient_rotor && saturation_is_on(&run->tuning.saturation)) {
        saturate(run, i_q);
    }
    const float full = i_d_wanted + unweakened(run, i_q, omega_e);
    run->i_d = weakening_i_d(&run->weakening, run->torque, full, omega_e) - i_d_wanted;
    const float share = salient_rotor ? 1.0f / run_torque(run) : 1.0f;
    run->i_q_standing *= share;
    run->stiffness *= share;
    return (dq_t){i_d_wanted + run->i_d, share * run->torque};
}

/* ---- the step ---- */

void run_step(run_t *run, const run_wish_t *wish, float omega_e, float omega_m, dq_t *current,
              float *omega_m_ref)
{
    run->limited = 0u;
    switch (wish->mode) {
    case RUN_ZERO:
        run->omega_m_ref = omega_m;
        run->torque = 0.0f;
        *current = (dq_t){0.0f, 0.0f};
        run->i_q_standing = 0.0f;
        run->stiffness = 0.0f;
        *omega_m_ref = 0.0f;
        return;
    case RUN_CURRENT:
        run->omega_m_ref = omega_m;
        *current =
            (dq_t){wish->current.d, bounds_between(wish->current.q, (bounds_t){run->lower, run->upper})};
        run->i_q_standing = current->q;
        run->stiffness = 0.0f;
        run->i_d = current->d;
        run->torque = run_torque(run) * current->q;
        speed_control_reset(&run->speed, run->torque, omega_m);
        *omega_m_ref = omega_m;
        return;
    case RUN_TORQUE:
        follow_torque(run, wish->torque, omega_m, torque_limits(run));
        break;
    case RUN_SPEED:
        run->omega_m_ref = run_reference(run, wish->omega_m_ref, run->tuning.ramp);
        follow_speed(run, omega_m, torque_limits(run));
        break;
    case RUN_STOP:
        run->omega_m_ref = run_reference(run, 0.0f, run->tuning.stop_ramp);
        follow_speed(run, omega_m, torque_limits(run));
        break;
    }
    *current = current_of(run, wish->current.d, omega_e);
    *omega_m_ref = run->omega_m_ref;
}
