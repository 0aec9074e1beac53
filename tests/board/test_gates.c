/* The signals at the gate pins, and the instants at which the currents are sampled: carrier, dead band,
 * zero vector, limits of the pulses, timing contract. The HAL is tested alone first, above a chip whose
 * outputs are all recorded, then with the drive. All expected values are computed here from the lines of
 * the board file as docs/board.md explains them. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "hal/hal.h"
#include "host_sim/chip/chip.h"
#include "host_sim/rig/rig_state.h"
#include "tests/board/motors.h"

#define TICK  (1.0 / 150e6)           /* [s] */
#define CYCLE (1.0 / BOARD_SYSCLK_HZ) /* [s] */
#define NS    1e-9

/* Edges are reported in whole ticks: at 100 MHz an odd number of cycles is rounded by half a tick. */
#define TICK_OFF (0.51 * TICK)

#define EDGES 40000u

typedef struct {
    uint64_t tick;
    uint32_t on; /* bit 2n is the upper, bit 2n + 1 the lower switch of leg n = a, b, c */
} edge_t;

static edge_t edge[EDGES];
static uint32_t edges;

static void add_edge(uint64_t tick, uint32_t on)
{
    if (edges < EDGES) {
        edge[edges++] = (edge_t){tick, on};
    }
}

#define UPPER(leg) (1u << (2u * (leg)))
#define LOWER(leg) (2u << (2u * (leg)))

/* The switch of a leg that conducts in the zero vector in which the board samples, and the other switch of
 * the leg. */
#if BOARD_SAMPLES_AT == BOARD_UPPER_ZERO_VECTOR
#define ZERO_SWITCH(leg)  UPPER(leg)
#define OTHER_SWITCH(leg) LOWER(leg)
#else
#define ZERO_SWITCH(leg)  LOWER(leg)
#define OTHER_SWITCH(leg) UPPER(leg)
#endif

static bool turns_off(uint32_t n, uint32_t sw)
{
    return n > 0u && (edge[n - 1u].on & sw) != 0u && (edge[n].on & sw) == 0u;
}

static bool turns_on(uint32_t n, uint32_t sw)
{
    return n > 0u && (edge[n - 1u].on & sw) == 0u && (edge[n].on & sw) != 0u;
}

/* The last turn-off of a switch at or before this tick, and the first after it; 0 if none is recorded. */
static uint64_t off_before(uint32_t sw, uint64_t tick)
{
    uint64_t found = 0;
    for (uint32_t n = 0; n < edges && edge[n].tick <= tick; n++) {
        found = turns_off(n, sw) ? edge[n].tick : found;
    }
    return found;
}

static uint64_t off_after(uint32_t sw, uint64_t tick)
{
    for (uint32_t n = 0; n < edges; n++) {
        if (edge[n].tick > tick && turns_off(n, sw)) {
            return edge[n].tick;
        }
    }
    return 0;
}

/* The time at which the switch that is on at this tick turned on; UINT64_MAX if it is off. */
static uint64_t on_since(uint32_t sw, uint64_t tick)
{
    uint64_t since = UINT64_MAX;
    for (uint32_t n = 0; n < edges && edge[n].tick <= tick; n++) {
        since = turns_on(n, sw) ? edge[n].tick : turns_off(n, sw) ? UINT64_MAX : since;
    }
    return since;
}

/* The two switches of a leg are never on together, and from each turn-off to the turn-on of the other
 * switch it takes at least this time [s]. */
static void expect_dead_band(double least, double most)
{
    double shortest = (double)INFINITY;
    double longest = 0.0;
    uint32_t counted = 0;
    for (uint32_t leg = 0; leg < 3u; leg++) {
        uint64_t off[2] = {0, 0};
        for (uint32_t n = 0; n < edges; n++) {
            TEST_ASSERT_TRUE((edge[n].on & (UPPER(leg) | LOWER(leg))) != (UPPER(leg) | LOWER(leg)));
            for (uint32_t k = 0; k < 2u; k++) {
                const uint32_t sw = k == 0u ? UPPER(leg) : LOWER(leg);
                const uint32_t partner = k == 0u ? LOWER(leg) : UPPER(leg);
                if (turns_off(n, partner)) {
                    off[k] = edge[n].tick;
                }
                if (turns_on(n, sw) && off[k] != 0u) {
                    shortest = fmin(shortest, (double)(edge[n].tick - off[k]) * TICK);
                    longest = fmax(longest, (double)(edge[n].tick - off[k]) * TICK);
                    counted++;
                }
            }
        }
    }
    printf("dead band %.1f to %.1f ns over %u edges, demanded %d\n", shortest / NS, longest / NS, counted,
           BOARD_DEAD_BAND_MIN_NS);
    TEST_ASSERT_TRUE(counted >= 100u);
    TEST_ASSERT_TRUE(shortest >= least - TICK_OFF);
    TEST_ASSERT_TRUE(shortest >= BOARD_DEAD_BAND_MIN_NS * NS - 1e-12);
    TEST_ASSERT_TRUE(longest <= most + TICK_OFF);
}

/* ---- the HAL alone ---- */

static chip_t chip;
static uint16_t compare[3];
static bool want_on;
static uint64_t asked[16]; /* tick at which each input was last sampled */
static uint64_t hold[3];   /* tick at which currents a, b, c were held for the last interrupt */

static double analog(void *context, uint64_t tick, uint32_t channel)
{
    (void)context;
    asked[channel] = tick;
    return 1.0;
}

/* Assigns the pins to switches by lines 4 and 5: ePWMn has GPIO 2n - 2 (upper) and 2n - 1 (lower). */
static void gates(void *context, uint64_t tick, uint32_t level, uint32_t driven)
{
    static const uint32_t legs[3] = {BOARD_LEG_A, BOARD_LEG_B, BOARD_LEG_C};
    const uint32_t on = (HAL_GATE_ACTIVE_HIGH ? level : ~level) & driven;
    uint32_t sorted = 0;
    uint32_t others = on;
    (void)context;
    for (uint32_t leg = 0; leg < 3u; leg++) {
        sorted |= (on >> (2u * legs[leg] - 2u) & 1u) * UPPER(leg);
        sorted |= (on >> (2u * legs[leg] - 1u) & 1u) * LOWER(leg);
        others &= ~(3u << (2u * legs[leg] - 2u));
    }
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(0u, others, "a pin of another module has changed");
    add_edge(tick, sorted);
}

static int64_t encoder(void *context, uint64_t tick)
{
    (void)context;
    (void)tick;
    return 0;
}

static const chip_world_t world = {.analog = analog, .gates = gates, .encoder = encoder};

static void on_sample(void)
{
    hal_samples_t samples;
    hal_read(&samples);
    hold[0] = asked[BOARD_CURRENT_A_INPUT];
    hold[1] = asked[BOARD_CURRENT_B_INPUT];
#if BOARD_CURRENT_C_INPUT != BOARD_NONE
    hold[2] = asked[BOARD_CURRENT_C_INPUT];
#endif
    hal_write_compare(compare[0], compare[1], compare[2]);
    if (want_on) {
        TEST_ASSERT_TRUE(hal_gates_on());
    }
    hal_end_of_sample();
}

static void on_medium(void)
{
}

static void on_trip(void)
{
    hal_end_of_trip();
}

static void run_periods(uint32_t periods)
{
    chip_run(chip_now(&chip) + periods * CHIP_TICKS_PER_SECOND / BOARD_CARRIER_HZ);
}

/* Legs a, b, c at these shares of the period, gates on. */
static void switch_at(double a, double b, double c)
{
    /* [cycles] half of a period, within a few cycles. */
    const double full = 0.5 * BOARD_SYSCLK_HZ / BOARD_CARRIER_HZ;
    compare[0] = (uint16_t)(a * full + 0.5);
    compare[1] = (uint16_t)(b * full + 0.5);
    compare[2] = (uint16_t)(c * full + 0.5);
    want_on = true;
    run_periods(3u);
    edges = 0;
    run_periods(40u);
}

void setUp(void)
{
    const hal_config_t config = {
        (uint16_t)ceil(BOARD_DEAD_TIME_NS * NS / CYCLE - 1e-6), 9999u, on_sample, on_medium, on_trip, NULL};
    edges = 0;
    want_on = false;
    chip_power_on(&chip, BOARD_CRYSTAL_HZ);
    chip_bind(&chip, &world);
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_init(&config));
    run_periods(3u);
}

/* Line 3: the period is the nearest one that is a whole number of ADC clocks, which have SYSCLK/2n and at
 * most 25 MHz. */
static void test_gates_switch_at_the_requested_carrier(void)
{
    const double adc_clock = 2.0 * ceil(BOARD_SYSCLK_HZ / 50e6) * CYCLE;
    switch_at(0.3, 0.5, 0.8);
    for (uint32_t leg = 0; leg < 3u; leg++) {
        const uint64_t first = off_after(UPPER(leg), 0u);
        const uint64_t last = off_before(UPPER(leg), chip_now(&chip));
        uint32_t turns = 0;
        for (uint32_t n = 0; n < edges; n++) {
            turns += turns_off(n, UPPER(leg));
        }
        const double period = (double)(last - first) * TICK / (turns - 1u);
        printf("leg %c: %.3f Hz, requested %d\n", "abc"[leg], 1.0 / period, BOARD_CARRIER_HZ);
        TEST_ASSERT_TRUE(turns >= 39u);
        TEST_ASSERT_TRUE(fabs(period - 1.0 / BOARD_CARRIER_HZ) <= 0.5 * adc_clock + TICK / 30.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, remainder(period / adc_clock, 1.0));
        TEST_ASSERT_DOUBLE_WITHIN(TICK / 30.0, RIG_PERIOD_SECONDS, period);
    }
}

static void test_dead_band_is_kept_at_every_edge(void)
{
    switch_at(0.3, 0.5, 0.8);
    expect_dead_band(BOARD_DEAD_TIME_NS * NS, BOARD_DEAD_TIME_NS * NS + CYCLE);
}

/* Currents a and b are held at the same time, in the middle of the zero vector. It is measured between the
 * turn-offs that begin and end it, because no dead band shifts a turn-off. */
static void expect_hold_in_the_middle(double a, double b, double c)
{
    switch_at(a, b, c);
    TEST_ASSERT_EQUAL_UINT64(hold[0], hold[1]);
    /* The zero vector of the last hold ends only after the interrupt. */
    const uint64_t at = hold[0];
    run_periods(1u);
    for (uint32_t leg = 0; leg < 3u; leg++) {
        const uint64_t begin = off_before(OTHER_SWITCH(leg), at);
        const uint64_t end = off_after(ZERO_SWITCH(leg), at);
        char message[120];
        snprintf(message, sizeof message,
                 "leg %c: zero vector from %.1f ns before the hold to %.1f ns after it", "abc"[leg],
                 (double)(at - begin) * TICK / NS, (double)(end - at) * TICK / NS);
        TEST_ASSERT_TRUE_MESSAGE(begin > 0u && end > 0u, message);
        TEST_ASSERT_TRUE_MESSAGE(on_since(ZERO_SWITCH(leg), at) != UINT64_MAX, message);
        TEST_ASSERT_TRUE_MESSAGE(fabs((double)(at - begin) - (double)(end - at)) <= 1.01, message);
    }
}

static void test_currents_are_held_in_the_middle_of_the_zero_vector(void)
{
    expect_hold_in_the_middle(0.3, 0.5, 0.8);
    expect_hold_in_the_middle(0.72, 0.41, 0.26);
}

/* The third sensor is held one pair of conversions later, after 7 ADC clocks, still in the same zero
 * vector. */
static void test_current_c_is_held_in_the_same_zero_vector(void)
{
#if BOARD_CURRENT_C_INPUT == BOARD_NONE
    TEST_IGNORE_MESSAGE("two sensors");
#else
    switch_at(0.3, 0.5, 0.8);
    TEST_ASSERT_TRUE(hold[2] >= hold[0]);
    TEST_ASSERT_TRUE((double)(hold[2] - hold[0]) * TICK <= 0.4e-6);
    for (uint32_t leg = 0; leg < 3u; leg++) {
        TEST_ASSERT_TRUE(on_since(ZERO_SWITCH(leg), hold[2]) <= hold[0]);
    }
#endif
}

/* ---- the drive ---- */

static void on_edge(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    (void)context;
    if (what == RIG_EDGE_GATES) {
        add_edge(tick, value);
    }
}

static uint64_t now_of(rig_t *rig)
{
    return RIG_PERIOD_TICKS * rig_period(rig);
}

/* Turns on the drive with the encoder at this share of the rated speed. */
static rig_t *turning(double share, double load)
{
    rig_t *rig = rig_create(71);
    board_put_motor(rig);
    run_put(rig, "current_noise", 0.0);
    board_to_ready_at(rig, share * board_motor.speed);
    run_on(rig, share * BOARD_RATED_RPM);
    run_put(rig, "load_torque", load);
    run_seconds(rig, 1.0);
    run_expect_no_fault(rig);
    return rig;
}

/* A very large resistance at a shaft that is turned: the requested current is never reached, the voltage
 * goes to its limit, and in one turn every leg reaches both limits of its duty. The DC link still drives a
 * fifth of the current limit through the winding, because less would be reported as a broken wire. The
 * voltage over this resistance, which the drive does not know, is that of a much faster rotor: the encoder is
 * not judged. */
static void expect_clamps(double dead_time)
{
    const double turn = 2.0 * 3.14159265358979 / (board_motor.pole_pairs * 0.2 * board_motor.speed);
    const double shortest_pulse = BOARD_MINIMUM_PULSE_NS * NS;
    const double settled = BOARD_SHUNT_SETTLED_NS * NS;
    rig_t *rig = rig_create(72);
    board_put_motor(rig);
    run_parameter(rig, "dead_time", dead_time);
    run_parameter(rig, "encoder_fault_reaction", (double)ENCODER_FAULT_IGNORED);
    run_put(rig, "plant.resistance", fmin(100.0, 3.0 * BOARD_DC_NOMINAL_MV / 1e3 / BOARD_LIMIT_AMPERES));
    /* Two codes of noise; the same value occurs in 7 successive periods with a probability of 1e-6. */
    run_put(rig, "current_noise", 0.02);
    run_put(rig, "shaft_locked", 1.0);
    run_put(rig, "shaft_locked_speed", 0.2 * board_motor.speed);
    board_to_ready_at(rig, 0.0);
    run_put(rig, "mode", 1.0);
    run_put(rig, "i_q_request", BOARD_LIMIT_AMPERES);
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 0.1);
    edges = 0;
    rig_watch_edges(rig, on_edge, NULL);
    const uint64_t from = now_of(rig);
    run_seconds(rig, turn);
    const uint64_t to = now_of(rig);
    rig_watch_edges(rig, NULL, NULL);
    run_expect_no_fault(rig);
    TEST_ASSERT_TRUE(edges > 1000u && edges < EDGES);

    expect_dead_band(dead_time, dead_time + CYCLE);
    double pulse = (double)INFINITY;
    double largest = 0.0;
    double smallest = (double)INFINITY;
    for (uint32_t leg = 0; leg < 3u; leg++) {
        uint64_t lower_off = 0;
        uint64_t on[2] = {0, 0};
        for (uint32_t n = 1; n < edges; n++) {
            on[0] = turns_on(n, UPPER(leg)) ? edge[n].tick : on[0];
            on[1] = turns_on(n, LOWER(leg)) ? edge[n].tick : on[1];
            if (turns_off(n, UPPER(leg)) && on[0] != 0u) {
                pulse = fmin(pulse, (double)(edge[n].tick - on[0]) * TICK);
            }
            if (turns_off(n, LOWER(leg))) {
                pulse = on[1] != 0u ? fmin(pulse, (double)(edge[n].tick - on[1]) * TICK) : pulse;
                lower_off = edge[n].tick;
            }
            /* The command of the upper switch lasts from one turn-off to the other. */
            if (turns_off(n, UPPER(leg)) && lower_off > 0u) {
                largest = fmax(largest, (double)(edge[n].tick - lower_off) * TICK);
                smallest = fmin(smallest, (double)(edge[n].tick - lower_off) * TICK);
            }
        }
    }
    /* Lines 7 and 10. A duty is a whole number of counts, each two cycles of the period. */
    double duty_end = RIG_PERIOD_SECONDS - dead_time - shortest_pulse;
    if (BOARD_SAMPLES_AT == BOARD_LOWER_ZERO_VECTOR) {
        duty_end = fmin(duty_end, RIG_PERIOD_SECONDS - 2.0 * (settled + dead_time));
    }
    printf("shortest pulse %.1f ns, duty %.4f to %.4f, allowed to %.4f\n", pulse / NS,
           smallest / RIG_PERIOD_SECONDS, largest / RIG_PERIOD_SECONDS, duty_end / RIG_PERIOD_SECONDS);
    TEST_ASSERT_TRUE(pulse >= shortest_pulse - CYCLE - TICK_OFF);
    TEST_ASSERT_DOUBLE_WITHIN(2.01 * CYCLE + TICK_OFF, duty_end, largest);
    TEST_ASSERT_DOUBLE_WITHIN(2.01 * CYCLE + TICK_OFF, dead_time + shortest_pulse, smallest);

    /* Line 10: all lower switches are on at every t_k, and the last of them has been on for as long as the
     * shunts need. */
    if (BOARD_SAMPLES_AT == BOARD_LOWER_ZERO_VECTOR) {
        double least = (double)INFINITY;
        for (uint64_t at = from + 2u * RIG_PERIOD_TICKS; at < to; at += RIG_PERIOD_TICKS) {
            for (uint32_t leg = 0; leg < 3u; leg++) {
                const uint64_t since = on_since(LOWER(leg), at);
                TEST_ASSERT_TRUE(since != UINT64_MAX);
                least = fmin(least, (double)(at - since) * TICK);
            }
        }
        printf("shunts on for %.1f ns at least, requested %d\n", least / NS, BOARD_SHUNT_SETTLED_NS);
        TEST_ASSERT_TRUE(least >= settled - CYCLE - TICK_OFF);
    }
    rig_free(rig);
}

static void test_at_full_voltage_pulses_and_shunts_have_their_time(void)
{
    expect_clamps(BOARD_DEAD_TIME_NS * NS);
}

/* The shortest dead time is compared with the demand itself, which need not be a whole number of cycles. */
static void test_the_shortest_dead_time_is_not_less_than_the_demand(void)
{
    expect_clamps(BOARD_DEAD_BAND_MIN_NS * NS * 1.000001);
}

/* The voltage of the command of period k acts from t_k+1 to t_k+2. No dead band shifts the two turn-offs
 * of each leg's pulse; they must be at the times that follow from the duties of that command. */
static void test_what_period_k_commands_acts_in_the_next_period_and_no_other(void)
{
    static const char *const names[3] = {"duty_a", "duty_b", "duty_c"};
    rig_t *rig = turning(0.6, 0.3 * BOARD_LIMIT_AMPERES * board_torque_per_ampere());
    double duty[3] = {0};
    double before[3] = {0};
    double off = 0.0;
    double off_if_late = 0.0;
    rig_watch_edges(rig, on_edge, NULL);
    for (uint32_t k = 0; k < 400u; k++) {
        for (uint32_t leg = 0; leg < 3u; leg++) {
            before[leg] = duty[leg];
            duty[leg] = rig_value(rig, names[leg]); /* duties of the last period */
        }
        const uint64_t begin = now_of(rig);
        edges = 0;
        add_edge(begin, 0u);
        rig_step(rig);
        for (uint32_t leg = 0; k >= 2u && leg < 3u; leg++) {
            const uint64_t end = begin + RIG_PERIOD_TICKS;
            for (uint32_t n = 1; n < edges; n++) {
                const bool ends_zero = (edge[n].on & ZERO_SWITCH(leg)) == 0u && n > 1u &&
                                       (edge[n - 1u].on & ZERO_SWITCH(leg)) != 0u;
                const bool begins_zero = (edge[n].on & OTHER_SWITCH(leg)) == 0u && n > 1u &&
                                         (edge[n - 1u].on & OTHER_SWITCH(leg)) != 0u;
                const double upper = BOARD_SAMPLES_AT == BOARD_UPPER_ZERO_VECTOR;
                const double share = upper != 0.0 ? duty[leg] : 1.0 - duty[leg];
                const double share_late = upper != 0.0 ? before[leg] : 1.0 - before[leg];
                const double half = 0.5 * (double)RIG_PERIOD_TICKS;
                if (ends_zero) {
                    const double at = (double)(edge[n].tick - begin);
                    off = fmax(off, fabs(at - share * half));
                    off_if_late = fmax(off_if_late, fabs(at - share_late * half));
                }
                if (begins_zero) {
                    const double at = (double)(end - edge[n].tick);
                    off = fmax(off, fabs(at - share * half));
                    off_if_late = fmax(off_if_late, fabs(at - share_late * half));
                }
            }
        }
    }
    printf("edges off by %.2f ticks; %.0f by the command before\n", off, off_if_late);
    rig_watch_edges(rig, NULL, NULL);
    run_expect_no_fault(rig);
    TEST_ASSERT_TRUE(off <= 1.01);
    TEST_ASSERT_TRUE(off_if_late > 20.0);
    rig_free(rig);
}

/* A sample is the true value at t_k within the step of the ADC: half a step of rounding and half a step of
 * the measured zero. A third sensor samples current c 7 ADC clocks later; in that time EMF and voltage
 * drop move the current, because the zero vector is a short circuit. */
static void test_samples_are_the_currents_of_t_k(void)
{
    static const char *const names[3][2] = {{"i_a", "true_i_a"}, {"i_b", "true_i_b"}, {"i_c", "true_i_c"}};
    const double code =
        3000.0 / 4096.0 * fabs((double)BOARD_CURRENT_STEP_MA) / BOARD_CURRENT_STEP_MV / 1e3; /* [A] */
    const double speed = 0.6 * board_motor.speed * board_motor.pole_pairs;
    const double slope = (board_motor.flux_linkage * speed + board_motor.resistance * BOARD_LIMIT_AMPERES) /
                         board_motor.inductance; /* [A/s] */
    const double later = 7.0 * 2.0 * ceil(BOARD_SYSCLK_HZ / 50e6) * CYCLE;
    rig_t *rig = turning(0.6, 0.3 * BOARD_LIMIT_AMPERES * board_torque_per_ampere());
    double square[3] = {0};
    const uint32_t periods = 2000u;
    for (uint32_t n = 0; n < periods; n++) {
        rig_step(rig);
        for (uint32_t k = 0; k < 3u; k++) {
            const double err = rig_value(rig, names[k][0]) - rig_value(rig, names[k][1]);
            square[k] += err * err / periods;
        }
    }
    printf("rms of a, b, c: %.2f, %.2f, %.2f codes of %.4f A\n", sqrt(square[0]) / code,
           sqrt(square[1]) / code, sqrt(square[2]) / code, code);
    run_expect_no_fault(rig);
    TEST_ASSERT_TRUE(sqrt(square[0]) <= code);
    TEST_ASSERT_TRUE(sqrt(square[1]) <= code);
    /* with two sensors c is minus the sum of a and b, and has the errors of both */
    TEST_ASSERT_TRUE(sqrt(square[2]) <=
                     (BOARD_CURRENT_C_INPUT == BOARD_NONE ? 2.0 * code : code + slope * later));
    rig_free(rig);
}

/* Line 17: where the upper gates are charged through the lower switches, each lower switch is on for this
 * time before the upper one turns on for the first time. The charging causes no fault, at standstill or at
 * rated speed. */
static void test_lower_switches_charge_the_upper_gates(void)
{
#if BOARD_GATE_CHARGE_US == 0
    TEST_IGNORE_MESSAGE("isolated supplies");
#else
    for (int32_t fast = 0; fast <= 1; fast++) {
        rig_t *rig = rig_create(73);
        board_put_motor(rig);
        board_to_ready_at(rig, fast * board_motor.speed);
        edges = 0;
        rig_watch_edges(rig, on_edge, NULL);
        run_on(rig, fast * BOARD_RATED_RPM);
        double peak = 0.0;
        for (int32_t n = 0; n < 100; n++) {
            rig_run(rig, 1u);
            peak = fmax(peak, fmax(fabs(rig_value(rig, "true_i_a")), fabs(rig_value(rig, "true_i_b"))));
        }
        for (uint32_t leg = 0; leg < 3u; leg++) {
            uint64_t lower = 0, upper = 0;
            for (uint32_t n = 0; n < edges && upper == 0u; n++) {
                lower = lower == 0u && (edge[n].on & LOWER(leg)) != 0u ? edge[n].tick : lower;
                upper = (edge[n].on & UPPER(leg)) != 0u ? edge[n].tick : 0u;
            }
            const double charged = (double)(upper - lower) * TICK;
            printf("%s, leg %c: %.0f us, demanded %d, %.1f A\n", fast != 0 ? "turning" : "standing",
                   "abc"[leg], charged * 1e6, BOARD_GATE_CHARGE_US, peak);
            TEST_ASSERT_TRUE(lower != 0u && upper > lower);
            TEST_ASSERT_TRUE(fast != 0 ||
                             charged >= BOARD_GATE_CHARGE_US * 1e-6); /* shorter if the rotor turns */
            TEST_ASSERT_TRUE(charged <= BOARD_GATE_CHARGE_US * 1e-6 + 4.0 * RIG_PERIOD_SECONDS);
        }
        run_expect_no_fault(rig);
        rig_free(rig);
    }
#endif
}
