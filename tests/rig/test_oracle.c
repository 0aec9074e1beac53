/* The switched plant in the whole simulation is compared with matrix exponentials. The real firmware
 * accelerates the motor from rest to 1500 r/min under load; its gate edges are replayed by the oracle,
 * which shares no code with the plant. */
#include "host_sim/rig/rig_state.h"
#include "tests/oracle/oracle.h"
#include "tests/rig/run.h"

#define PERIODS 5600u /* 58 ms until ready, then more than 0.5 s of running */

static oracle_edge_t edges[PERIODS * 12u + 100u];
static size_t edge_count;
static uint64_t ticks[PERIODS];
static oracle_sample_t expected[PERIODS];
static double seen[PERIODS][3];

static void on_edge(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    if (what == RIG_EDGE_GATES) {
        TEST_ASSERT_TRUE(edge_count < sizeof edges / sizeof edges[0]);
        edges[edge_count++] = (oracle_edge_t){tick + *(const uint64_t *)context, value};
    }
}

static void run_and_compare(oracle_frame_t frame, double inductance_d, double inductance_q)
{
    rig_t *rig = run_rig(41);
    edge_count = 0;
    rig_watch_edges(rig, on_edge, &rig_state(rig)->start);
    run_put(rig, "inertia", 0.003);
    run_put(rig, "load_torque", RUN_LIMIT_SHARE * 5.0);
    run_paper_drive(rig);
    run_shaft_of_board(rig);
    TEST_ASSERT_TRUE(rig_apply(rig));
    run_put(rig, "plant.inductance_d", inductance_d);
    run_put(rig, "plant.inductance_q", inductance_q);
    run_on(rig, 1500.0);
    for (uint32_t k = 0; k < PERIODS; k++) {
        ticks[k] = rig_state(rig)->start + RIG_PERIOD_TICKS * k;
        rig_step(rig);
        seen[k][0] = rig_value(rig, "true_i_a");
        seen[k][1] = rig_value(rig, "true_i_b");
        seen[k][2] = rig_value(rig, "true_i_c");
    }
    run_expect_no_fault(rig);
    /* The motor did accelerate. */
    TEST_ASSERT_DOUBLE_WITHIN(75.0, 1500.0, rig_value(rig, "true_omega_m") / RPM);

    const plant_params_t params = rig_plant_params(&rig_state(rig)->plant_values);
    TEST_ASSERT_TRUE(oracle_run(&params, frame, 0.0, 0.0, edges, edge_count, ticks, PERIODS, expected));
    double far = 0.0;
    double largest = 0.0;
    for (uint32_t k = 0; k < PERIODS; k++) {
        far = fmax(far, fabs(seen[k][0] - expected[k].i_a));
        far = fmax(far, fabs(seen[k][1] - expected[k].i_b));
        far = fmax(far, fabs(seen[k][2] - expected[k].i_c));
        largest = fmax(largest, fabs(expected[k].i_a));
    }
    const char *const message = run_say("largest difference %.2g mA of %.2f A, %zu gate edges, %u samples",
                                        1e3 * far, largest, edge_count, PERIODS);
    TEST_ASSERT_TRUE_MESSAGE(largest > 0.9 * rig_value(rig, "current_limit"), message);
    TEST_ASSERT_TRUE_MESSAGE(far <= 1e-3, message);
    rig_free(rig);
}

/* The oracle runs in the stationary frame, and for a salient machine in the rotor's frame. */
static void test_currents_of_a_run_up_are_the_oracles_within_1_mA(void)
{
    grid_t grid = grid_of("run-up", 2u);
    for (uint32_t n; grid_next(&grid, &n);) {
        run_and_compare(n == 0u ? ORACLE_STATIONARY : ORACLE_ROTOR, n == 0u ? 0.0125 : 0.011,
                        n == 0u ? 0.0125 : 0.015);
    }
}
