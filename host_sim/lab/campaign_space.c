/* The random choices of a campaign: their tables, and the draw. */
#include <math.h>
#include <stdlib.h>

#include "host_sim/lab/campaign_parts.h"

#define TURN 6.283185307179586

#define CAMPAIGN_LINK(volts)    ((volts) * (BOARD_DC_NOMINAL_MV / 311e3))
#define CAMPAIGN_LIMIT(amperes) ((amperes) * (BOARD_CURRENT_LIMIT_MA / 10e3))
#define CAMPAIGN_RANGE(amperes) ((amperes) * ((double)BOARD_CURRENT_RANGE / 20.0))

const campaign_quantity_row_t campaign_quantities[CAMPAIGN_QUANTITY_COUNT] = {
#define ROW(name, group, law, initial, least, most, unit, text)                                              \
    {#name, CAMPAIGN_##group, CAMPAIGN_##law, initial, least, most, unit, text},
    CAMPAIGN_QUANTITIES(ROW)
#undef ROW
};

const campaign_quantity_row_t campaign_errors[CAMPAIGN_ERROR_COUNT] = {
#define ROW(name, group, law, initial, least, most, unit, text)                                              \
    {#name, CAMPAIGN_##group, CAMPAIGN_##law, initial, least, most, unit, text},
    CAMPAIGN_ERRORS(ROW)
#undef ROW
};

uint32_t campaign_rows(const campaign_case_t *drawn, const campaign_quantity_row_t **rows)
{
    *rows = drawn->around != NULL ? campaign_errors : campaign_quantities;
    return drawn->around != NULL ? (uint32_t)CAMPAIGN_ERROR_COUNT : (uint32_t)CAMPAIGN_QUANTITY_COUNT;
}

static const struct {
    campaign_law_t law;
    double least, most;
} events[CAMPAIGN_EVENT_KINDS] = {
#define ROW(NAME, law, least, most, text) {CAMPAIGN_##law, least, most},
    CAMPAIGN_EVENTS(ROW)
#undef ROW
};

const campaign_invariant_row_t campaign_invariants[CAMPAIGN_INVARIANT_COUNT] = {
#define ROW(NAME, name, limit, unit, text) {name, limit, unit, text},
    CAMPAIGN_INVARIANTS(ROW)
#undef ROW
};

#define SENSOR_STANDS                                                                                        \
    "the control follows a stuck sensor until the drive can distinguish it from a steady current",           \
        CAMPAIGN_UNTIL_TOLD
#define GAIN_IS_WRONG                                                                                        \
    "a gain error is visible only while the current changes fast. Until then the trip current is wrong by "  \
    "the gain error, and the error of R i hides the EMF of a slow rotor",                                    \
        CAMPAIGN_TO_CEILING | CAMPAIGN_WHILE_SLOW
#define SENSOR_IS_OFF                                                                                        \
    "the dead-time voltage of a current with the wrong sign hides the EMF of a slow rotor",                  \
        CAMPAIGN_WHILE_SLOW
#define SLOW_HIDES "a slow rotor has no EMF that shows the error", CAMPAIGN_WHILE_SLOW | CAMPAIGN_STAYS
#define LEG_LOSES  "the voltage loss of a leg hides the EMF of a slow rotor", CAMPAIGN_WHILE_SLOW
#define WIRE_HIDES                                                                                           \
    CAMPAIGN_BIT(ANGLE), "a small current does not show an open wire, which turns the EMF", CAMPAIGN_UNFED
#define TURNS_BACK "without the encoder the direction of rotation is unknown", CAMPAIGN_UNCODED

/* A board without this input cannot report the temperature. */
#define TEMPERATURE_AT(input)                                                                                \
    (input) != BOARD_NONE ? 0u : CAMPAIGN_BIT(NOTICE),                                                       \
        (input) != BOARD_NONE ? "" : "the board has no sensor of this temperature", CAMPAIGN_ALWAYS

/* In a late interrupt the drive reads samples and executes requests late. In one that runs past its period
 * the voltage vector stays where it is for up to eight periods, and the current is not controlled either. */
#define TIME_BITS (CAMPAIGN_BIT(LATE) | CAMPAIGN_BIT(OFF))

#define LINK_IS_HIDDEN "the sensor of the link does not show its voltage", CAMPAIGN_ALWAYS
#define BIT_FLIPPED                                                                                          \
    CAMPAIGN_BIT(NUMBER) | CAMPAIGN_BIT(OFF) | CAMPAIGN_BIT(STOP) | CAMPAIGN_BIT(TRIP_SPEED) |               \
        CAMPAIGN_BIT(TRIP_LINK) | CAMPAIGN_BIT(PERSIST) | CAMPAIGN_BIT(NOTICE),                              \
        "a flipped bit may change a limit, a request, a state or a factor", CAMPAIGN_STAYS

const double campaign_wire_current = 0.04 * (double)BOARD_CURRENT_RANGE;

/* Every row of plant and rig that a fault can change. */
const campaign_fault_t campaign_faults[] = {
    {"none", "", CAMPAIGN_EVEN, 0.0, 0.0, CAMPAIGN_AS_IT_IS, 0u, "", CAMPAIGN_ALWAYS},
    {"open_phase_a", "open_phase_a", CAMPAIGN_EVEN, 1.0, 1.0, CAMPAIGN_AS_IT_IS, WIRE_HIDES},
    {"open_phase_b", "open_phase_b", CAMPAIGN_EVEN, 1.0, 1.0, CAMPAIGN_AS_IT_IS, WIRE_HIDES},
    {"open_phase_c", "open_phase_c", CAMPAIGN_EVEN, 1.0, 1.0, CAMPAIGN_AS_IT_IS, WIRE_HIDES},
    {"stuck_current_a", "stuck_current_a", CAMPAIGN_WHOLE, 0.0, 4095.0, CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(CURRENT), SENSOR_STANDS},
    {"stuck_current_b", "stuck_current_b", CAMPAIGN_WHOLE, 0.0, 4095.0, CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(CURRENT), SENSOR_STANDS},
    {"stuck_near_zero_a", "stuck_current_a", CAMPAIGN_WHOLE, 1980.0, 2116.0, CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(CURRENT), SENSOR_STANDS},
    {"stuck_near_zero_b", "stuck_current_b", CAMPAIGN_WHOLE, 1980.0, 2116.0, CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(CURRENT), SENSOR_STANDS},
    {"current_gain_a", "current_gain_error_a", CAMPAIGN_EVEN, -0.5, 0.5, CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(CURRENT) | CAMPAIGN_BIT(ANGLE), GAIN_IS_WRONG},
    {"current_gain_b", "current_gain_error_b", CAMPAIGN_EVEN, -0.5, 0.5, CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(CURRENT) | CAMPAIGN_BIT(ANGLE), GAIN_IS_WRONG},
    {"current_offset_a", "current_offset_a", CAMPAIGN_EVEN, -0.5, 0.5, CAMPAIGN_OF_CURRENT,
     CAMPAIGN_BIT(ANGLE), SENSOR_IS_OFF},
    {"current_offset_b", "current_offset_b", CAMPAIGN_EVEN, -0.5, 0.5, CAMPAIGN_OF_CURRENT,
     CAMPAIGN_BIT(ANGLE), SENSOR_IS_OFF},
    {"current_range", "current_range", CAMPAIGN_LOG, 0.5, 2.0, CAMPAIGN_OF_ROW, CAMPAIGN_BIT(CURRENT),
     GAIN_IS_WRONG},
    {"current_noise", "current_noise", CAMPAIGN_LOG, 0.02, 0.2, CAMPAIGN_OF_CURRENT, 0u, "", CAMPAIGN_ALWAYS},
    {"stuck_dc_link", "stuck_dc_link", CAMPAIGN_WHOLE, 0.0, 4095.0, CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(TRIP_LINK), LINK_IS_HIDDEN},
    {"dc_gain", "dc_gain_error", CAMPAIGN_EVEN, -0.5, 0.5, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(TRIP_LINK),
     LINK_IS_HIDDEN},
    {"dc_sag", "dc_voltage", CAMPAIGN_EVEN, 0.0, 0.9, CAMPAIGN_OF_ROW, 0u, "", CAMPAIGN_ALWAYS},
    {"dc_surge", "dc_voltage", CAMPAIGN_EVEN, 1.1, 1.4, CAMPAIGN_OF_ROW, 0u, "", CAMPAIGN_ALWAYS},
    {"module_fault", "force_fault", CAMPAIGN_EVEN, 1.0, 1.0, CAMPAIGN_AS_IT_IS, 0u, "", CAMPAIGN_ALWAYS},
    {"sink_hot", "plant.sink_temperature", CAMPAIGN_EVEN, 80.0, 150.0, CAMPAIGN_AS_IT_IS,
     TEMPERATURE_AT(BOARD_SINK_INPUT)},
    {"motor_hot", "plant.motor_temperature", CAMPAIGN_EVEN, 128.0, 150.0, CAMPAIGN_AS_IT_IS,
     TEMPERATURE_AT(BOARD_MOTOR_INPUT)},
    {"late_interrupt", "interrupt_delay", CAMPAIGN_LOG, 1e-6, 200e-6, CAMPAIGN_AS_IT_IS, TIME_BITS,
     "the interrupt begins late", CAMPAIGN_ALWAYS},
    {"slow_interrupt", "interrupt_time", CAMPAIGN_LOG, 1.5, 8.0, CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(CURRENT) | TIME_BITS, "the interrupt runs past its period", CAMPAIGN_ALWAYS},
    {"slow_background", "background_time", CAMPAIGN_LOG, 1e-3, 1.0, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(CHIP),
     "the watchdog resets the chip if the background stalls, and the virtual chip reports this",
     CAMPAIGN_STAYS},
    {"long_section", "section_time", CAMPAIGN_LOG, 10.0, 1e3, CAMPAIGN_AS_IT_IS, TIME_BITS,
     "interrupts are disabled for longer than a period allows", CAMPAIGN_ALWAYS},
    {"jam", "brake_torque", CAMPAIGN_LOG, 0.5, 10.0, CAMPAIGN_OF_TORQUE, 0u, "", CAMPAIGN_ALWAYS},
    {"overload", "load_torque", CAMPAIGN_EVEN, 1.0, 3.0, CAMPAIGN_OF_TORQUE, 0u, "", CAMPAIGN_ALWAYS},
    {"brake_falls", "holding_torque", CAMPAIGN_LOG, 0.5, 10.0, CAMPAIGN_OF_TORQUE, 0u, "", CAMPAIGN_ALWAYS},
    {"estimate_jump", "estimate_jump", CAMPAIGN_EVEN, -3.14, 3.14, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     SLOW_HIDES},
    {"encoder_lines", "plant.encoder_lines", CAMPAIGN_WHOLE, 512.0, 5000.0, CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(ANGLE), SLOW_HIDES},
    {"encoder_slips", "plant.encoder_offset", CAMPAIGN_EVEN, -3.14, 3.14, CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(ANGLE), SLOW_HIDES},
    {"weak_magnet", "plant.flux_linkage", CAMPAIGN_EVEN, 0.3, 0.9, CAMPAIGN_OF_ROW, 0u, "", CAMPAIGN_ALWAYS},
    {"leg_drop_a", "leg_a_drop", CAMPAIGN_LOG, CAMPAIGN_LINK(3.0), CAMPAIGN_LINK(50.0), CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(ANGLE), LEG_LOSES},
    {"leg_drop_b", "leg_b_drop", CAMPAIGN_LOG, CAMPAIGN_LINK(3.0), CAMPAIGN_LINK(50.0), CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(ANGLE), LEG_LOSES},
    {"leg_drop_c", "leg_c_drop", CAMPAIGN_LOG, CAMPAIGN_LINK(3.0), CAMPAIGN_LINK(50.0), CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(ANGLE), LEG_LOSES},
    {"leg_resistance_a", "leg_a_resistance", CAMPAIGN_LOG, 1.0, 10.0, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     LEG_LOSES},
    {"leg_resistance_b", "leg_b_resistance", CAMPAIGN_LOG, 1.0, 10.0, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     LEG_LOSES},
    {"leg_resistance_c", "leg_c_resistance", CAMPAIGN_LOG, 1.0, 10.0, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     LEG_LOSES},
    {"leg_delay_a", "leg_a_delay", CAMPAIGN_LOG, 0.5e-6, 5e-6, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     LEG_LOSES},
    {"leg_delay_b", "leg_b_delay", CAMPAIGN_LOG, 0.5e-6, 5e-6, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     LEG_LOSES},
    {"leg_delay_c", "leg_c_delay", CAMPAIGN_LOG, 0.5e-6, 5e-6, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     LEG_LOSES},
    {"open_switch", "open_switches", CAMPAIGN_WHOLE, 0.0, 5.0, CAMPAIGN_OF_SWITCH, WIRE_HIDES},
    {"shorted_switch", "shorted_switches", CAMPAIGN_WHOLE, 0.0, 5.0, CAMPAIGN_OF_SWITCH,
     CAMPAIGN_BIT(LEGS) | CAMPAIGN_BIT(CURRENT), "the switch conducts at any level of its gate",
     CAMPAIGN_ALWAYS},
    {"swap_phases", "swap_phases", CAMPAIGN_WHOLE, 1.0, 3.0, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     TURNS_BACK},
    {"swap_currents", "swap_currents", CAMPAIGN_WHOLE, 1.0, 3.0, CAMPAIGN_AS_IT_IS, 0u, "", CAMPAIGN_ALWAYS},
    {"encoder_reversed", "encoder_reversed", CAMPAIGN_EVEN, 1.0, 1.0, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     SLOW_HIDES},
    {"encoder_slip", "encoder_slip", CAMPAIGN_LOG, 0.01, 1.0, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     SLOW_HIDES},
    {"encoder_stuck_a", "encoder_stuck_a", CAMPAIGN_WHOLE, 0.0, 1.0, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     SLOW_HIDES},
    {"encoder_stuck_b", "encoder_stuck_b", CAMPAIGN_WHOLE, 0.0, 1.0, CAMPAIGN_AS_IT_IS, CAMPAIGN_BIT(ANGLE),
     SLOW_HIDES},
    {"dc_ripple", "dc_ripple", CAMPAIGN_EVEN, CAMPAIGN_LINK(5.0), CAMPAIGN_LINK(150.0), CAMPAIGN_AS_IT_IS, 0u,
     "", CAMPAIGN_ALWAYS},
    {"supply_lost", "supply_lost", CAMPAIGN_EVEN, 1.0, 1.0, CAMPAIGN_AS_IT_IS, 0u, "", CAMPAIGN_ALWAYS},
    {"charge_cut", "dc_returns", CAMPAIGN_EVEN, 0.0, 0.0, CAMPAIGN_AS_IT_IS, 0u, "", CAMPAIGN_ALWAYS},
    {"chopper_dead", "chopper_driven", CAMPAIGN_EVEN, 0.0, 0.0, CAMPAIGN_AS_IT_IS, 0u, "", CAMPAIGN_ALWAYS},
    {"missing_samples", "missing_samples", CAMPAIGN_WHOLE, 1.0, 20.0, CAMPAIGN_AS_IT_IS,
     CAMPAIGN_BIT(CURRENT) | TIME_BITS, "without a conversion there is no interrupt, and no protection acts",
     CAMPAIGN_ALWAYS},
    {"flipped_bit", "flip_word", CAMPAIGN_EVEN, 0.0, 1.0, CAMPAIGN_OF_STATE, BIT_FLIPPED},
};
const uint32_t campaign_fault_count = sizeof campaign_faults / sizeof campaign_faults[0];

/* ---- drawing ---- */

/* SplitMix64's output function (Steele, Lea, Flood 2014): a bijection of 64-bit words. */
static uint64_t mixed(uint64_t x)
{
    x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
    return x ^ (x >> 31);
}

/* The odd number nearest to 2^64 over the golden ratio: its multiples by consecutive counters are far apart.
 */
#define STRIDE UINT64_C(0x9e3779b97f4a7c15)

static uint64_t word_of(uint64_t seed, uint32_t run, uint32_t draw)
{
    const uint64_t stream = mixed(mixed(seed + STRIDE) + STRIDE * (run + UINT64_C(1)));
    return mixed(stream + STRIDE * (draw + UINT64_C(1)));
}

double campaign_random(uint64_t seed, uint32_t run, uint32_t draw)
{
    return (double)(word_of(seed, run, draw) >> 11) * 0x1p-53;
}

/* Counts its draws, so that none is used twice. */
typedef struct {
    uint64_t seed;
    uint32_t run, next;
} source_t;

static double even(source_t *source)
{
    return campaign_random(source->seed, source->run, source->next++);
}

static double draw(source_t *source, campaign_law_t law, double initial, double least, double most)
{
    const double u = even(source);
    switch (law) {
    case CAMPAIGN_LOG:
        return least * exp(u * log(most / least));
    case CAMPAIGN_WHOLE:
        return least + floor(u * (most - least + 1.0));
    case CAMPAIGN_HALF:
        return u < 0.5 ? initial : least + (2.0 * u - 1.0) * (most - least);
    case CAMPAIGN_FEW:
    case CAMPAIGN_OWN:
        return u < 0.875 ? initial : least + (8.0 * u - 7.0) * (most - least);
    case CAMPAIGN_EVEN:
    case CAMPAIGN_THIRD:
        break;
    }
    return least + u * (most - least);
}

/* Two drifts in opposite directions show a current of twice this share of the trip while none flows, until
 * the drive has measured the offsets again. More than the trip would be an overcurrent to every drive. */
#define DRIFT_MOST 0.4 /* [-] of overcurrent_trip */

static void add(campaign_case_t *drawn, source_t *source, campaign_event_kind_t kind, double time)
{
    if (drawn->event_count < CAMPAIGN_EVENTS_MAX && time < drawn->seconds) {
        const double value = draw(source, events[kind].law, 0.0, events[kind].least, events[kind].most);
        const double most = kind == CAMPAIGN_V_DRIFT ? DRIFT_MOST * campaign_trip(drawn) : (double)INFINITY;
        drawn->events[drawn->event_count++] =
            (campaign_event_t){.kind = kind, .time = time, .value = fmin(fmax(value, -most), most)};
    }
}

/* A random kind of event, with different probabilities: most are requests for a speed. */
static campaign_event_kind_t kind_of(source_t *source)
{
    static const campaign_event_kind_t kinds[] = {
        CAMPAIGN_V_SPEED,   CAMPAIGN_V_SPEED,      CAMPAIGN_V_SPEED, CAMPAIGN_V_SPEED,  CAMPAIGN_V_SPEED,
        CAMPAIGN_V_SLOW,    CAMPAIGN_V_SLOW,       CAMPAIGN_V_LOAD,  CAMPAIGN_V_LOAD,   CAMPAIGN_V_LOAD,
        CAMPAIGN_V_LOAD,    CAMPAIGN_V_QUICK_STOP, CAMPAIGN_V_OFF,   CAMPAIGN_V_ON,     CAMPAIGN_V_ON,
        CAMPAIGN_V_CURRENT, CAMPAIGN_V_SOURCE,     CAMPAIGN_V_RESET, CAMPAIGN_V_PARAMS, CAMPAIGN_V_DRIFT,
    };
    return kinds[(size_t)(even(source) * (double)(sizeof kinds / sizeof kinds[0]))];
}

/* [s] as whole periods of 0.1 ms; those of another carrier are taken as the next one that begins. */
static double whole(double time)
{
    return 1e-4 * floor(1e4 * time + 0.5);
}

/* Calibration takes 58 ms; a start without encoder most of a second. */
static double time_from(source_t *source, double from, double to)
{
    return 1e-4 * floor(1e4 * (from + even(source) * (to - from)));
}

/* An event and the events that belong to it: half of the quick stops are withdrawn before they end, half of
 * the resets are followed by a new start, and offsets drift while the bridge is off. */
static void add_with_company(campaign_case_t *drawn, source_t *source, campaign_event_kind_t kind,
                             double time)
{
    const bool alone = kind != CAMPAIGN_V_DRIFT && even(source) < 0.5;
    if (kind == CAMPAIGN_V_DRIFT) {
        add(drawn, source, CAMPAIGN_V_OFF, whole(fmax(0.0, time - 0.05)));
    }
    add(drawn, source, kind, time);
    if (kind == CAMPAIGN_V_QUICK_STOP && !alone) {
        const double u = even(source);
        add(drawn, source, CAMPAIGN_V_ON, whole(time + 0.3 * u * u));
    } else if (kind == CAMPAIGN_V_RESET && !alone) {
        add(drawn, source, CAMPAIGN_V_OFF, whole(time + 0.02));
        add(drawn, source, CAMPAIGN_V_ON, whole(time + 0.04));
    } else if (kind == CAMPAIGN_V_DRIFT) {
        add(drawn, source, CAMPAIGN_V_ON, whole(time + 0.05));
    }
}

static int by_time(const void *a, const void *b)
{
    const double x = ((const campaign_event_t *)a)->time;
    const double y = ((const campaign_event_t *)b)->time;
    return (x > y) - (x < y);
}

void campaign_drop_drifts(campaign_case_t *drawn)
{
    campaign_event_kind_t last = CAMPAIGN_V_OFF;
    uint32_t kept = 0;
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        const campaign_event_kind_t kind = drawn->events[n].kind;
        const bool enables = kind == CAMPAIGN_V_OFF || kind == CAMPAIGN_V_ON || kind == CAMPAIGN_V_QUICK_STOP;
        last = enables ? kind : last;
        if (kind != CAMPAIGN_V_DRIFT || last == CAMPAIGN_V_OFF) {
            drawn->events[kept++] = drawn->events[n];
        }
    }
    drawn->event_count = kept;
}

/* A fault from this time on; a quarter of the faults ends again, after 10 to 300 ms. `choice`, 0..1, selects
 * the fault. */
static campaign_injected_t draw_fault(source_t *source, double choice, double from, double to)
{
    campaign_injected_t fault = {1u + (uint32_t)(choice * (campaign_fault_count - 1u)), 0.0, 0.0, 0.0};
    const campaign_fault_t *row = &campaign_faults[fault.kind];
    fault.time = time_from(source, from, to);
    fault.value = draw(source, row->law, 0.0, row->least, row->most);
    if (even(source) < 0.25) {
        fault.lasts = whole(draw(source, CAMPAIGN_LOG, 0.0, 0.01, 0.3));
    }
    return fault;
}

/* Two numbers, 0..1, that spread evenly over the runs of a seed (Roberts' sequence R2), instead of at random:
 * a campaign of some hundred runs then contains every fault. */
#define SPREAD_STREAM UINT64_C(0x535052454144)

static double spread(uint64_t seed, uint32_t run, uint32_t dimension)
{
    static const double steps[] = {0.7548776662466927, 0.5698402909980532}; /* 1/g, 1/g^2 with g^3 = g + 1 */
    source_t begin = {seed ^ SPREAD_STREAM, dimension, 0u};
    const double sum = even(&begin) + steps[dimension] * run;
    return sum - floor(sum);
}

/* Salient motors are drawn from a separate random stream, so that they do not change the other runs of a
 * seed.
 */
#define SALIENT_STREAM UINT64_C(0x53414c49454e54)
#define SALIENT_SHARE  (1.0 / 3.0)              /* [-] of the runs */
#define SUPPLY_STREAM  UINT64_C(0x535550504c59) /* the same for the supply */

static void draw_quantities(source_t *source, campaign_case_t *drawn)
{
    source_t own = {source->seed ^ SALIENT_STREAM, source->run, 0u};
    source_t supply = {source->seed ^ SUPPLY_STREAM, source->run, 0u};
    const bool salient = even(&own) < SALIENT_SHARE;
    const campaign_quantity_row_t *rows;
    const uint32_t count = campaign_rows(drawn, &rows);
    for (uint32_t n = 0; n < count; n++) {
        if (rows[n].law == CAMPAIGN_THIRD) {
            const double value = draw(&own, CAMPAIGN_EVEN, 0.0, rows[n].least, rows[n].most);
            drawn->quantities[n] = salient ? value : rows[n].initial;
            continue;
        }
        source_t *from = rows[n].law == CAMPAIGN_OWN ? &supply : source;
        drawn->quantities[n] = draw(from, rows[n].law, rows[n].initial, rows[n].least, rows[n].most);
    }
}

void campaign_draw_around(uint64_t seed, uint32_t run, const scenario_t *scenario, campaign_case_t *drawn)
{
    source_t source = {seed, run, 0u};
    *drawn = (campaign_case_t){.seed = seed, .run = run, .seconds = scenario->duration, .around = scenario};
    draw_quantities(&source, drawn);
}

void campaign_draw(uint64_t seed, uint32_t run, double seconds, campaign_case_t *drawn)
{
    source_t source = {seed, run, 0u};
    *drawn = (campaign_case_t){.seed = seed, .run = run, .seconds = seconds};
    draw_quantities(&source, drawn);

    const double on = time_from(&source, 0.0, 0.1);
    add(drawn, &source, CAMPAIGN_V_ON, on);
    add(drawn, &source, CAMPAIGN_V_SPEED, on);
    const uint32_t more = (uint32_t)(even(&source) * 8.0);
    for (uint32_t n = 0; n < more; n++) {
        const campaign_event_kind_t kind = kind_of(&source);
        add_with_company(drawn, &source, kind, time_from(&source, 0.1, seconds));
    }
    qsort(drawn->events, drawn->event_count, sizeof drawn->events[0], by_time);
    campaign_drop_drifts(drawn);

    /* in half of the runs one fault, in a tenth of them a second one after it */
    if (spread(seed, run, 0u) < 0.5) {
        drawn->faults[0] = draw_fault(&source, spread(seed, run, 1u), 0.0, 0.95 * seconds);
        if (even(&source) < 0.1) {
            drawn->faults[1] = draw_fault(&source, even(&source), drawn->faults[0].time, 0.95 * seconds);
        }
    }
}
