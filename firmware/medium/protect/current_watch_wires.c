/* The wires: phases with nearly no current, or with less than the requested current. */
#include "medium/protect/current_watch_parts.h"

#include "math/bounds.h"

#define APART_SHARE     0.25f /* [-] of the largest phase current: least deviation from the requested current */
#define LITTLE_SHARE    0.5f  /* [-] of the requested current: limit where the EMF contradicts */
#define ELSEWHERE_TIMES 4     /* [-] factor on the time if the encoder may be wrong: its watch needs 8 ms */
#define SLOW_TIMES      4     /* [-] factor on the time at the voltage limit of a slow link */
#define SHORT_LEAST     0.25f /* [-] of the largest value of a phase without current: above its noise */
#define SHORT_SHARE     0.5f  /* [-] of its share of a short current: least current of a sound phase */
#define FED_SHARE       0.1f  /* [-] of its limit: above this only this law is used */
/* The same where a forced frame takes the rotor along, which then does not turn by 80 degrees. */
#define FORCED_SHARE 0.5f /* [-] */
#define ALL_SIGNS    2.0f /* [-] of the dead time's voltage, if all three signs are uncertain */
#define NEVER_STILL  6u   /* [periods] after which noise has changed every value */
#define MARKED       1    /* [periods] of a time that has only begun */
#define TAKEN        (-1) /* `first` has been added to `absent` */
/* Bits of `other` for phase 0, those of the other phases are above them: since the current is missing, one of
 * the other sign has flowed; one of more than `carries`; then it was missing again; and has flowed again. */
#define FLOWED  UINT32_C(1)
#define CARRIED UINT32_C(8)
#define MISSED  UINT32_C(64)
#define TWICE   UINT32_C(512)
#define ALL     (FLOWED | CARRIED | MISSED | TWICE)

/* True if a value has not changed for longer than noise permits. */
static inline bool is_still(const current_watch_t *watch, uint32_t n)
{
    return (watch->suspected >> n & 1u) != 0u && watch->phase[n].still >= NEVER_STILL;
}

/* Moves the value towards zero by at most `step`. */
static inline float shrunk(float value, float step)
{
    return value - bounds_clamp(value, step);
}

/* True if the current of a phase deviates from the requested one by more than `least`, both summed over the
 * window [A]. */
static bool deviates(const float asked[3], const current_watch_window_t *window, float least)
{
    bool apart = false;
    for (uint32_t n = 0; n < 3u; n++) {
        apart = apart || !bounds_within(asked[n] - window->periods * window->value[n], least);
    }
    return apart;
}

/* True if the current of the phase, above the noise of a wire without current, has its share of a current
 * that is shorter than the requested one, because the current control lags behind it. */
static bool shares(const current_watch_t *watch, const float asked[3], const current_watch_window_t *window,
                   uint32_t n)
{
    float most = 0.0f;
    for (uint32_t m = 0; m < 3u; m++) {
        most = bounds_more(most, bounds_magnitude(asked[m]));
    }
    const float value = asked[n] < 0.0f ? -window->value[n] : window->value[n];
    const float share = SHORT_SHARE * bounds_magnitude(asked[n]) * window->largest;
    return window->largest > watch->tuning.none && value > SHORT_LEAST * watch->tuning.none &&
           value * most > share;
}

/* A phase carries this current [A]. It ends the time without current if it has the sign of the request that
 * was missing. With an open switch a current of the other sign flows in each turn: then the current of this
 * sign is not missing. */
static void end_absence(current_watch_t *watch, uint32_t n, float value)
{
    current_watch_phase_t *phase = &watch->phase[n];
    const bool missing = value < 0.0f ? phase->absent < 0 : phase->absent > 0;
    phase->absent = missing ? 0 : phase->absent;
    phase->first = 0;
    const bool carries = !bounds_within(value, watch->tuning.carries);
    const bool again = (watch->other & MISSED << n) != 0u;
    watch->other |= (carries ? FLOWED | CARRIED | (again ? TWICE : 0u) : FLOWED) << n;
}

/* True if the current that is missing in the phase has the sign of this request, the voltage has it as well,
 * and the phase has carried a current of the other sign in two half turns between which it was missing. A
 * control that balances a wrong EMF drives a current in no direction, but a leg with an open switch conducts
 * in one. A rotor that reverses may have had a current of one sign before, once. */
static bool is_one_way(const current_watch_t *watch, uint32_t n, float asked, float moved)
{
    const int32_t absent = watch->phase[n].absent;
    const bool same = asked < 0.0f ? absent < 0 && moved < 0.0f : absent > 0 && moved > 0.0f;
    return same && (watch->other & TWICE << n) != 0u;
}

/* The time [periods] that counts with this window, whose requested current is missing for `periods`. The
 * first such window after a current counts together with the second, because the control follows a new
 * request only later, and a request that has changed again by then never becomes a current. Nor does a fast
 * phase, whose current is zero at the ends of some windows, have two of them in succession without its
 * current. */
static int32_t counted(current_watch_phase_t *phase, int32_t periods)
{
    const int32_t first = phase->first;
    if (first == 0) {
        phase->first = periods;
        return 0;
    }
    phase->first = TAKEN;
    return first == TAKEN ? periods : first + periods;
}

/* True if a phase has been without current for long enough. The time counts while the current control does
 * not reach the requested current, either in this phase or in the others, whose currents an open wire makes
 * dependent, and while the voltage exceeds that of the dead time, so that a current must flow. If no other
 * phase carries current, because the request is along the axis of this phase, the voltage must also exceed
 * the uncertain EMF: the current control may balance an EMF while no phase carries a small request. Without
 * that voltage the time only begins, until a current of the other sign shows that an open switch is the
 * cause. `asked`: requested currents, in all of the window's periods [A]. A deviation of only the others
 * counts while they carry a current, and half, because a frame with a wrong angle causes one as well. If the
 * EMF contradicts, a diode may carry the current in place of a switch: half of the requested current then
 * counts as no current. If the EMF contradicts along no phase's axis, the encoder is probably wrong, and the
 * dead time, compensated with a wrong angle, may hold a phase at zero for some milliseconds: the time is
 * longer then. It is longer, too, at the limit of a low link voltage, where a current may lag for some
 * milliseconds more than the control does. */
static bool is_absent(current_watch_t *watch, uint32_t n, const current_watch_input_t *input,
                      const current_watch_window_t *window, const float asked[3])
{
    const current_watch_tuning_t *tuning = &watch->tuning;
    current_watch_phase_t *phase = &watch->phase[n];
    const bool others = window->largest > tuning->carries;
    const bool driven = (others || !input->limited) && !bounds_within(window->moved[n], window->dead);
    const bool judged = driven && (others || is_one_way(watch, n, asked[n], window->moved[n]) ||
                                   !bounds_within(window->moved[n], window->dead + window->any));
    const float least = window->periods * (tuning->carries + APART_SHARE * window->largest);
    const bool much = driven && !bounds_within(asked[n], least);
    const float value = window->value[n];
    const float half =
        input->contradicted && judged && much ? LITTLE_SHARE * bounds_magnitude(asked[n]) : 0.0f;
    if (!bounds_within(value, tuning->none) && !bounds_within(value * window->periods, half)) {
        end_absence(watch, n, value);
        return false;
    }
    int32_t absent = phase->absent < 0 ? -phase->absent : phase->absent;
    if (driven && !is_still(watch, n) && (much || (others && deviates(asked, window, least))) &&
        (input->contradicted || !shares(watch, asked, window, n))) {
        const bool negative = asked[n] < 0.0f;
        const bool before = phase->absent < 0;
        if (judged && (watch->other & FLOWED << n) != 0u && negative != before) {
            absent = 0;
        }
        if ((watch->other & CARRIED << n) != 0u && negative == before) {
            watch->other |= MISSED << n;
        }
        if (absent == 0) {
            watch->other &= ~(ALL << n);
            absent = MARKED;
            phase->absent = negative ? -absent : absent;
        }
        if (judged) {
            const bool slow = input->limited && input->u_dc < tuning->slow_link;
            const int32_t periods = slow ? (int32_t)window->periods / SLOW_TIMES : (int32_t)window->periods;
            absent += counted(phase, much ? periods : periods / 2);
            phase->absent = negative ? -absent : absent;
        }
    }
    return absent >= (input->elsewhere ? ELSEWHERE_TIMES * tuning->absent : tuning->absent);
}

/* Voltage on a phase without current beyond the effect of the magnets' flux at any angle
 * of the rotor, over that effect. */
static float feed(current_watch_t *watch, uint32_t n, const current_watch_window_t *window)
{
    current_watch_phase_t *phase = &watch->phase[n];
    const bool none = bounds_within(phase->value, watch->tuning.none) &&
                      bounds_within(window->value[n], watch->tuning.none) && !is_still(watch, n);
    const float dead = window->largest < watch->tuning.none ? ALL_SIGNS * window->dead : window->dead;
    phase->fed = none ? shrunk(phase->fed + window->given[n], dead) : 0.0f;
    return bounds_magnitude(phase->fed);
}

bool current_watch_feeds_another(const current_watch_t *watch, uint32_t n)
{
    const float most = FED_SHARE * watch->tuning.flux;
    bool feeds = false;
    for (uint32_t m = 0; m < 3u; m++) {
        feeds = feeds || (m != n && !bounds_within(watch->phase[m].fed, most));
    }
    return feeds;
}

/* Bits of the phases whose wire may be open. Each of the others carries a current. */
static uint32_t without_current(current_watch_t *watch, const current_watch_input_t *input,
                                const current_watch_window_t *window)
{
    uint32_t phases = 0u;
    for (uint32_t n = 0; n < 3u; n++) {
        if (bounds_within(window->value[n], watch->tuning.none) || input->contradicted) {
            phases |= UINT32_C(1) << n;
            continue;
        }
        current_watch_phase_t *phase = &watch->phase[n];
        phase->fed = 0.0f;
        phase->first = 0;
        if (phase->absent != 0) {
            end_absence(watch, n, window->value[n]);
        }
    }
    return phases;
}

uint32_t current_watch_wires(current_watch_t *watch, const current_watch_input_t *input,
                             const current_watch_window_t *window)
{
    const current_watch_tuning_t *tuning = &watch->tuning;
    const uint32_t phases = without_current(watch, input, window);
    if (phases == 0u) {
        return 0u;
    }
    const float flux = input->forced ? FORCED_SHARE * tuning->flux : tuning->flux;
    float asked[3];
    spread(asked, frames_inverse_clarke(frames_inverse_park(input->asked_for, input->frame)));
    uint32_t bits = 0u;
    for (uint32_t n = 0; n < 3u; n++) {
        if ((phases >> n & 1u) == 0u) {
            continue;
        }
        const float fed = feed(watch, n, window);
        if (is_absent(watch, n, input, window, asked) || fed > flux) {
            bits |= CURRENT_WATCH_LOSS;
        }
        if (fed > FED_SHARE * tuning->flux) {
            bits |= CURRENT_WATCH_MAYBE;
        }
    }
    return bits;
}
