/* Starting without an encoder with parameters that are wrong, each by what a data sheet, a winding's
 * temperature or an unknown load leaves; and a load that sticks. */
#include "tests/rig/start_grid.h"

void setUp(void)
{
    rig = NULL;
}

void tearDown(void)
{
    rig_free(rig);
}

#define ROWS 4u

typedef struct {
    const char *name;
    start_row_t rows[ROWS]; /* factors; the last has no name */
} wrong_t;

/* The dead time's voltage as the firmware believes it, times this factor: T_e/T U_dc + V_0 with T_e the dead
 * band and the difference of the delays (docs/theory.md, 12). */
static void put_dead_time_share(start_row_t rows[ROWS], double factor)
{
    rig_t *const desk = rig_create(1u);
    const double on = rig_value(desk, "params.turn_on_delay");
    const double off = rig_value(desk, "params.turn_off_delay");
    const double missing = (1.0 - factor) * (rig_value(desk, "dead_time") + on - off);
    rows[0] = missing > 0.0 ? (start_row_t){"params.turn_off_delay", off + missing}
                            : (start_row_t){"params.turn_on_delay", on - missing};
    rows[1] = (start_row_t){"params.device_drop", factor * rig_value(desk, "params.device_drop")};
    rows[2] = (start_row_t){NULL, 0.0};
    rig_free(desk);
}

static const wrong_t wrong[] = {
    {"R +30 %", {{"motor_resistance", 1.3}}},
    {"R -30 %", {{"motor_resistance", 0.7}}},
    {"L +20 %", {{"motor_inductance_d", 1.2}, {"motor_inductance_q", 1.2}}},
    {"L -20 %", {{"motor_inductance_d", 0.8}, {"motor_inductance_q", 0.8}}},
    {"psi_f +10 %", {{"motor_flux_linkage", 1.1}}},
    {"psi_f -10 %", {{"motor_flux_linkage", 0.9}}},
    {"J x 2", {{"motor_inertia", 2.0}}},
    {"J x 0.5", {{"motor_inertia", 0.5}}},
};
#define WRONG_ROWS (sizeof wrong / sizeof wrong[0])

static const struct {
    const char *name;
    double factor;
} wrong_dead_time[] = {{"dead time +20 %", 1.2},
                       {"dead time -20 %", 0.8},
                       {"dead time -40 %", 0.6},
                       {"dead time +40 %", 1.4},
                       {"dead time unknown", 0.0}};
#define WRONG_DEAD_TIMES 5u
#define WRONG_REPORTED   2u /* of them, the last: reported only */

#define WRONG_CASES (1u + WRONG_ROWS + WRONG_DEAD_TIMES)

/* Rows of the n-th case, 0: all is right; and its name. */
static const char *wrong_rows(start_row_t rows[ROWS + 1u], start_shaft_t shaft, size_t n)
{
    rows[0] = (start_row_t){NULL, 0.0};
    if (n == 0u) {
        return "all right";
    }
    if (n > WRONG_ROWS) {
        put_dead_time_share(rows, wrong_dead_time[n - WRONG_ROWS - 1u].factor);
        return wrong_dead_time[n - WRONG_ROWS - 1u].name;
    }
    rig_t *const desk = start_on_desk(shaft, 1u);
    TEST_ASSERT_TRUE(rig_apply(desk));
    size_t used = 0;
    for (const start_row_t *row = wrong[n - 1u].rows; row->name != NULL; row++, used++) {
        rows[used] = (start_row_t){row->name, row->value * rig_value(desk, row->name)};
    }
    rows[used] = (start_row_t){NULL, 0.0};
    rig_free(desk);
    return wrong[n - 1u].name;
}

/* What the shaft holds at standstill, as a multiple of what it takes turning; 0: not held. The plant puts a
 * passive load on top of its break-away. */
static start_row_t break_away(start_shaft_t shaft, double load, double factor)
{
    return (start_row_t){"friction_breakaway",
                         factor > 0.0 ? factor * (start_shaft_data[shaft].friction + load) - load : 0.0};
}

/* Returns how many of the starts that are promised failed. */
static uint32_t start_with_wrong(const double loads[2], double sticks)
{
    uint32_t failed = 0;
    for (size_t s = 0; s < 2u; s++) {
        for (size_t l = 0; l < 2u; l++) {
            start_grid_t promised = {0};
            for (size_t n = 0; n < WRONG_CASES; n++) {
                const start_shaft_t shaft = (start_shaft_t)s;
                start_row_t rows[ROWS + 1u];
                const char *const name = wrong_rows(rows, shaft, n);
                size_t used = 0;
                while (rows[used].name != NULL) {
                    used++;
                }
                rows[used] = break_away(shaft, loads[l], sticks);
                rows[used + 1u] = (start_row_t){NULL, 0.0};
                const start_case_t what = {shaft, loads[l], 0.0, rows};
                const start_grid_t grid = starts(&what, 8u);
                print(&what, name, &grid);
                if (n < WRONG_CASES - WRONG_REPORTED) {
                    failed += grid.tried - grid.good;
                    start_raise(&promised.error, grid.error);
                    start_raise(&promised.dip, grid.dip);
                    start_raise(&promised.current, grid.current);
                }
            }
            printf(
                "start %c, %.2f N m, break-away %.1f, every promised error: <= %.2f A, dip %.1f r/min, error "
                "%.0f mrad\n",
                START_SHAFT_NAMES[s], loads[l], sticks, promised.current, promised.dip, promised.error);
        }
    }
    return failed;
}

static void test_starts_with_wrong_parameters(void)
{
    static const double loads[2] = {0.0, RATED_TORQUE};
    TEST_ASSERT_EQUAL_UINT32(0u, start_with_wrong(loads, 0.0));
}

static void test_starts_a_load_that_sticks_half_as_much_again_with_wrong_parameters_too(void)
{
    static const double loads[2] = {0.5 * RATED_TORQUE, RATED_TORQUE};
    TEST_ASSERT_EQUAL_UINT32(0u, start_with_wrong(loads, 1.5));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_starts_with_wrong_parameters);
    RUN_TEST(test_starts_a_load_that_sticks_half_as_much_again_with_wrong_parameters_too);
    return UNITY_END();
}
