/* The judge of a run: sees the tap of every period and every edge of the gates. */
#include <math.h>
#include <string.h>

#include "host_sim/lab/campaign_parts.h"

#define CURRENT_SAMPLES 3u    /* two periods from the first to the last */
#define ANGLE_SECONDS   50e-3 /* [s] */

/* Rows that are judged one by one, in this order behind the floats among the signals. Those that come first
 * are floats, too. */
#define JUDGED(R)                                                                                            \
    R(true_i_a)                                                                                              \
    R(true_i_b)                                                                                              \
    R(true_i_c)                                                                                              \
    R(theta_err)                                                                                             \
    R(true_omega_m) R(true_u_dc) R(shoot_throughs) R(chip_reports) R(state) R(manoeuvre) R(sample_flags)
enum {
#define PLACE(name) AT_##name,
    JUDGED(PLACE)
#undef PLACE
        JUDGED_ROWS
};
#define JUDGED_FLOATS AT_state

static const char *const judged[JUDGED_ROWS] = {
#define NAME(name) #name,
    JUDGED(NAME)
#undef NAME
};

uint32_t campaign_watched(uint32_t ids[CAMPAIGN_WATCHED_MAX], uint32_t *floats)
{
    const table_t *signals = NULL;
    uint32_t count = 0;
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        signals = strcmp(rig_table(t)->name, "signals") == 0 ? rig_table(t) : signals;
    }
    for (uint32_t n = 0; n < signals->count && count < CAMPAIGN_WATCHED_MAX - JUDGED_ROWS; n++) {
        if (signals->rows[n].kind == SLOT_FLOAT) {
            ids[count++] = signals->rows[n].id;
        }
    }
    *floats = count + JUDGED_FLOATS;
    for (uint32_t n = 0; n < JUDGED_ROWS; n++) {
        ids[count++] = rig_row_by_name(judged[n])->id;
    }
    return count;
}

static uint32_t choice(const char *row, const char *name)
{
    return (uint32_t)table_choice(rig_row_by_name(row), name);
}

void campaign_watch_begin(campaign_watch_t *watch, const campaign_case_t *drawn, campaign_result_t *result,
                          const volatile sig_atomic_t *asked)
{
    const campaign_fault_t *fault = &campaign_faults[drawn->fault];
    const bool until_told = (fault->excuse & CAMPAIGN_UNTIL_TOLD) != 0u;
    const bool while_slow = (fault->excuse & CAMPAIGN_WHILE_SLOW) != 0u;
    const bool uncoded = (fault->excuse & CAMPAIGN_UNCODED) != 0u;
    const bool limited = until_told || (fault->excuse & CAMPAIGN_TO_CEILING) != 0u;
    const double told = drawn->fault_time + PROMISED_NOTICE;
    *watch = (campaign_watch_t){
        .drawn = drawn,
        .result = result,
        .asked = asked,
        .trip = campaign_invariants[CAMPAIGN_I_CURRENT].limit * campaign_trip(drawn),
        .overspeed = campaign_overspeed(drawn),
        .ceiling = limited ? PROMISED_CURRENT : (double)INFINITY,
        .blind = while_slow ? campaign_blind_speed(drawn) : 0.0,
        .uncoded = uncoded,
        .excused = while_slow || uncoded ? fault->excused & ~CAMPAIGN_BIT(ANGLE) : fault->excused,
        .told = until_told ? (uint32_t)(told / RIG_PERIOD_SECONDS + 0.5) : UINT32_MAX,
        .per_omega = campaign_motor(drawn).pole_pairs * RIG_PERIOD_SECONDS,
        .turned = until_told ? 0.0 : CAMPAIGN_TURN,
        .notice = until_told ? (uint32_t)(PROMISED_NOTICE / RIG_PERIOD_SECONDS + 0.5) : 0u,
        .enabled = choice("state", "operation_enabled"),
        .fault = choice("state", "fault"),
        .run = choice("manoeuvre", "run"),
    };
}

/* The first violation is the one that counts; `since` so many periods, the present one among them. */
static void violated(campaign_watch_t *watch, campaign_invariant_t invariant, uint32_t period, uint32_t since,
                     uint32_t row)
{
    campaign_result_t *result = watch->result;
    const uint32_t bit = UINT32_C(1) << (uint32_t)invariant;
    if ((watch->excused & bit) != 0u && (period <= watch->told || watch->turned < CAMPAIGN_TURN)) {
        result->excused |= bit;
    } else if (result->end != CAMPAIGN_VIOLATED) {
        result->end = CAMPAIGN_VIOLATED;
        result->invariant = invariant;
        result->period = period;
        result->from = period + 1u - since;
        result->row = row;
        watch->stop = 1;
    }
}

static float number_in(uint32_t slot)
{
    float value;
    memcpy(&value, &slot, sizeof value);
    return value;
}

/* Infinite or not a number: all bits of the exponent. */
#define EXPONENT UINT32_C(0x7f800000)

/* One pass without a branch, so that it costs little. */
static bool all_finite(const uint32_t *slots, uint32_t count)
{
    uint32_t bad = 0;
    for (uint32_t n = 0; n < count; n++) {
        bad |= (uint32_t)((slots[n] & EXPONENT) == EXPONENT);
    }
    return bad == 0u;
}

static void judge_numbers(campaign_watch_t *watch, uint32_t period, const uint32_t *slots)
{
    uint32_t ids[CAMPAIGN_WATCHED_MAX];
    uint32_t floats;
    (void)campaign_watched(ids, &floats);
    for (uint32_t n = 0; n < floats; n++) {
        if ((slots[n] & EXPONENT) == EXPONENT) {
            violated(watch, CAMPAIGN_I_NUMBER, period, 1u, ids[n]);
        }
    }
}

/* With all gates off, software has done what it can: a rotor whose EMF is beyond the link feeds it through
 * the diodes. So it does in the first periods of a catch, in which nobody knows of it yet: what is beyond
 * overspeed_trip then is not the drive's doing. */
static void judge_currents(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    static const char *const names[3] = {"true_i_a", "true_i_b", "true_i_c"};
    const bool fast =
        fabs((double)number_in(rows[AT_true_omega_m])) > watch->overspeed && rows[AT_manoeuvre] != watch->run;
    for (uint32_t phase = 0; phase < 3u; phase++) {
        const double amount = fabs((double)number_in(rows[AT_true_i_a + phase]));
        const bool over = amount > watch->trip;
        const bool acts = watch->gates_seen && !fast;
        watch->over[phase] = over && acts ? watch->over[phase] + 1u : 0u;
        watch->far[phase] = over && acts && amount > watch->ceiling ? watch->far[phase] + 1u : 0u;
        watch->over_off[phase] = over && !acts ? watch->over_off[phase] + 1u : 0u;
        if (watch->over_off[phase] >= CURRENT_SAMPLES) {
            watch->result->excused |= CAMPAIGN_BIT(CURRENT);
        }
        if (watch->far[phase] >= CURRENT_SAMPLES) {
            watch->excused &= ~CAMPAIGN_BIT(CURRENT);
        }
        if (watch->over[phase] >= CURRENT_SAMPLES) {
            violated(watch, CAMPAIGN_I_CURRENT, period, watch->over[phase],
                     rig_row_by_name(names[phase])->id);
        }
    }
}

static void judge_angle(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    const bool runs = rows[AT_state] == watch->enabled && rows[AT_manoeuvre] == watch->run;
    const double error = fabs((double)number_in(rows[AT_theta_err]));
    const bool wrong = runs && error > campaign_invariants[CAMPAIGN_I_ANGLE].limit;
    const bool slow = fabs((double)number_in(rows[AT_true_omega_m])) < watch->blind;
    const bool excused =
        slow || (watch->uncoded && !campaign_is_coded(watch->drawn, RIG_PERIOD_SECONDS * period));
    watch->result->excused |= wrong && excused ? CAMPAIGN_BIT(ANGLE) : 0u;
    watch->wrong = !wrong ? 0u : excused ? watch->wrong : watch->wrong + 1u;
    if (watch->wrong * RIG_PERIOD_SECONDS > CAMPAIGN_ANGLE_SECONDS) {
        violated(watch, CAMPAIGN_I_ANGLE, period, watch->wrong, rig_row_by_name("theta_err")->id);
    }
}

/* The interrupt of the period that latches a fault opens the bridge itself. */
static void judge_gates(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    const bool latched = rows[AT_state] == watch->fault;
    if (latched && watch->gates_seen &&
        (double)watch->latched >= campaign_invariants[CAMPAIGN_I_GATES].limit) {
        violated(watch, CAMPAIGN_I_GATES, period, 1u, rig_row_by_name("state")->id);
    }
    watch->latched = latched ? watch->latched + 1u : 0u;
}

/* A chip that its watchdog has reset shows what was before; its pins float, which is off. */
static void judge_reset(campaign_watch_t *watch, uint32_t period)
{
    if (watch->gates_seen) {
        violated(watch, CAMPAIGN_I_GATES, period, 1u, rig_row_by_name("state")->id);
    }
    watch->gates_seen = watch->gates != 0u;
}

/* A sensor that stands is told within so long, or a third of a turn. With the bridge off nothing is at stake,
 * and one at zero shows what is right. */
static void judge_notice(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    if (watch->notice == 0u) {
        return;
    }
    if (!watch->gates_seen && watch->told < period + watch->notice) {
        watch->told = period + watch->notice;
        watch->turned = 0.0;
    } else if (period + watch->notice >= watch->told) {
        watch->turned += watch->per_omega * fabs((double)number_in(rows[AT_true_omega_m]));
    }
}

void campaign_watch_sample(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    campaign_watch_t *watch = context;
    const uint32_t *rows = slots + (count - JUDGED_ROWS);
    if (watch->reset) {
        judge_reset(watch, period);
        return;
    }
    if (!all_finite(slots, count - JUDGED_ROWS + JUDGED_FLOATS)) {
        judge_numbers(watch, period, slots);
    }
    judge_notice(watch, period, rows);
    judge_currents(watch, period, rows);
    judge_angle(watch, period, rows);
    judge_gates(watch, period, rows);
    if (number_in(rows[AT_shoot_throughs]) > 0.0f) {
        violated(watch, CAMPAIGN_I_LEGS, period, 1u, rig_row_by_name("shoot_throughs")->id);
    }
    if (number_in(rows[AT_chip_reports]) > 0.0f) {
        violated(watch, CAMPAIGN_I_CHIP, period, 1u, rig_row_by_name("chip_reports")->id);
        watch->reset = (watch->excused & CAMPAIGN_BIT(CHIP)) != 0u;
    }
    if ((rows[AT_sample_flags] & CAMPAIGN_LATE_FLAG) != 0u) {
        violated(watch, CAMPAIGN_I_LATE, period, 1u, rig_row_by_name("sample_flags")->id);
    }
    watch->gates_seen = watch->gates != 0u;
    if (watch->asked != NULL && *watch->asked != 0) {
        watch->stop = 1;
    }
}

void campaign_watch_edge(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    campaign_watch_t *watch = context;
    (void)tick;
    if (what == (uint32_t)RIG_EDGE_GATES) {
        watch->gates = value;
        watch->gates_seen = watch->gates_seen || value != 0u;
    }
}
