/* The limits of the current of the supply, with the power of a motor in closed form, 1.5 R i^2 + K omega i
 * + P_0. */
#include "medium/protect/supply_limit.h"
#include "tests/unit/compare.h"

#define LINK       311.0  /* [V] */
#define RESISTANCE 0.97   /* [ohm] */
#define TORQUE     1.098  /* [N m/A] */
#define MOST       10.0   /* [A] limit of i_q */
#define LOOK       0.8e-3 /* [s] between two evaluations */
#define SETTLED    500u   /* [evaluations] 40 time constants */

static supply_limit_t limit;
static supply_limit_tuning_t tuning;

static void begin(double drawn, double back, double drop)
{
    const supply_limit_params_t params = {
        .drawn = (float)drawn,
        .back = (float)back,
        .current_max = (float)MOST,
        .resistance = (float)RESISTANCE,
        .torque = (float)TORQUE,
        .drop = (float)drop,
        .free_emf = (float)(0.15 * RESISTANCE * MOST),
        .period = (float)LOOK,
    };
    memset(&limit, 0x55, sizeof limit);
    tuning = supply_limit_prepare(&params);
    supply_limit_reset(&limit, &tuning);
}

static void look(double power, double i_q, double omega_m)
{
    const supply_limit_input_t input = {
        .u_dc = (float)LINK,
        .power = (float)power,
        .magnitudes = (float)(2.0 * fabs(i_q)),
        .i_q = (float)i_q,
        .torque_share = 1.0f,
        .omega_m = (float)omega_m,
        .conducting = 1u,
        .in_rotor = 1u,
    };
    supply_limit_step(&limit, &tuning, &input);
}

/* A motor whose R, K and other losses differ from the drive's values. */
static const struct {
    double resistance, torque, rest;
} motors[] = {{1.0, 1.0, 0.0}, {1.0, 1.0, 40.0}, {1.3, 0.8, 0.0}, {0.7, 1.2, 40.0}};

static double power_of(size_t motor, double i_q, double omega_m)
{
    return 1.5 * motors[motor].resistance * RESISTANCE * i_q * i_q +
           motors[motor].torque * TORQUE * omega_m * i_q + motors[motor].rest;
}

/* The speed control requests the largest current, so that i_q is at its limit. The current of the supply
 * settles at its limit, or below it if the limit of i_q is reached first. Floats resolve P_r to 1e-3. */
static void test_the_current_settles_at_its_limit_in_both_directions(void)
{
    for (size_t motor = 0; motor < sizeof motors / sizeof motors[0]; motor++) {
        for (int way = -1; way <= 1; way += 2) {
            for (double omega_m = -300.0; omega_m <= 300.0; omega_m += 12.5) {
                begin(2.0, 1.0, 0.0);
                const double forward = omega_m < 0.0 ? -way : way;
                double i_q = 0.0;
                for (uint32_t n = 0; n < SETTLED; n++) {
                    look(power_of(motor, i_q, omega_m), i_q, omega_m);
                    i_q = forward * (double)(way > 0 ? limit.driving : limit.braking);
                }
                const double supply = power_of(motor, i_q, omega_m) / LINK;
                char where[120];
                snprintf(where, sizeof where, "motor %u, %g rad/s, i_q %g A: %.4f A", (unsigned)motor,
                         omega_m, i_q, supply);
                TEST_ASSERT_TRUE_MESSAGE(supply <= 2.0 * 1.001 && supply >= -1.0 * 1.001, where);
                TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-3, supply, (double)limit.current, where);
                const bool most = fabs(fabs(i_q) - MOST) < 1e-6;
                const double wanted = way > 0 ? 2.0 : -1.0;
                TEST_ASSERT_TRUE_MESSAGE(most || fabs(supply - wanted) < 2e-3 || fabs(omega_m) < 25.0, where);
            }
        }
    }
}

/* With right data the first evaluation already gives the final limits: 1.5 R i^2 + K omega i = u I. */
static void test_the_limit_is_right_before_it_has_settled(void)
{
    begin(2.0, 1.0, 0.0);
    const double omega_m = 157.0, e = TORQUE * omega_m;
    look(0.0, 0.0, omega_m);
    const double drives = (-e + sqrt(e * e + 6.0 * RESISTANCE * 2.0 * LINK)) / (3.0 * RESISTANCE);
    const double brakes = (e - sqrt(e * e - 6.0 * RESISTANCE * 1.0 * LINK)) / (3.0 * RESISTANCE);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, drives, (double)limit.driving);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, brakes, (double)limit.braking);
}

/* At standstill the copper consumes all power, in both directions; nothing is returned. */
static void test_at_standstill_the_copper_alone_draws_current(void)
{
    begin(0.2, 0.001, 0.0);
    look(0.0, 0.0, 0.0);
    const double most = sqrt(2.0 * 0.2 * LINK / (3.0 * RESISTANCE));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, most, (double)limit.driving);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, most, (double)limit.braking);
}

/* A rotor returns at most e^2/(6 R): if this is less than the limit, braking is not limited. */
static void test_a_slow_rotor_that_cannot_return_so_much_brakes_with_all_torque(void)
{
    begin(0.0, 1.0, 0.0);
    const double edge = sqrt(6.0 * RESISTANCE * 1.0 * LINK) / TORQUE;
    look(0.0, 0.0, 0.99 * edge);
    TEST_ASSERT_EQUAL_FLOAT(MOST, limit.braking);
    TEST_ASSERT_EQUAL_FLOAT(MOST, limit.driving);
    look(0.0, 0.0, 2.0 * edge);
    TEST_ASSERT_TRUE(limit.braking < (float)MOST);
}

/* With almost no permitted return current the limit of braking is near zero from omega_free on; at half of
 * omega_free it is halfway to the whole current. */
static void test_near_standstill_the_limit_of_braking_fades_out(void)
{
    const double free = 0.15 * RESISTANCE * MOST / TORQUE;
    begin(0.0, 1e-6, 0.0);
    look(0.0, 0.0, free);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.0, (double)limit.braking);
    look(0.0, 0.0, -0.5 * free);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.5 * MOST, (double)limit.braking);
    look(0.0, 0.0, 0.0);
    TEST_ASSERT_EQUAL_FLOAT(MOST, limit.braking);
}

/* A limit counts as reached in its own direction only, for either sign of the speed. */
static void test_a_reached_limit_is_reported(void)
{
    for (double omega_m = -150.0; omega_m <= 150.0; omega_m += 300.0) {
        const double forward = omega_m < 0.0 ? -1.0 : 1.0;
        for (double i_q = -MOST; i_q <= MOST; i_q += 1.0) {
            begin(2.0, 1.0, 0.0);
            look(power_of(0, forward * i_q, omega_m), forward * i_q, omega_m);
            const bool reached = i_q > 0.98 * (double)limit.driving || -i_q > 0.98 * (double)limit.braking;
            TEST_ASSERT_EQUAL_UINT32(reached ? 1u : 0u, limit.limits);
        }
    }
}

/* The smallest limit is zero, whatever the power is. */
static void test_a_limit_never_reverses_the_torque(void)
{
    for (double power = -1e4; power <= 1e4; power += 500.0) {
        for (double omega_m = -300.0; omega_m <= 300.0; omega_m += 10.0) {
            begin(0.5, 0.5, 1.0);
            for (uint32_t n = 0; n < 100u; n++) {
                look(power, n % 2u == 0u ? 10.0 : -10.0, omega_m);
                TEST_ASSERT_TRUE(limit.driving >= 0.0f && limit.driving <= (float)MOST);
                TEST_ASSERT_TRUE(limit.braking >= 0.0f && limit.braking <= (float)MOST);
            }
        }
    }
}

/* The supply current includes the drops of the devices: (600 W + 1.5 V 20 A)/311 V. */
static void test_the_drops_count(void)
{
    begin(9.0, 0.0, 1.5);
    for (uint32_t n = 0; n < SETTLED; n++) {
        look(600.0, 10.0, 50.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 630.0 / LINK, (double)limit.current);
}

static void test_without_limits_and_in_a_forced_frame_nothing_is_limited(void)
{
    begin(0.0, 0.0, 0.0);
    TEST_ASSERT_EQUAL_UINT32(0u, tuning.on);
    begin(0.1, 0.1, 0.0);
    for (uint32_t n = 0; n < SETTLED; n++) {
        const supply_limit_input_t input = {
            .u_dc = (float)LINK, .power = 311.0f, .i_q = 10.0f, .omega_m = 100.0f, .conducting = 1u};
        supply_limit_step(&limit, &tuning, &input);
        TEST_ASSERT_EQUAL_FLOAT(MOST, limit.driving);
        TEST_ASSERT_EQUAL_FLOAT(MOST, limit.braking);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 1.0, (double)limit.current);
    const supply_limit_input_t open = {.u_dc = (float)LINK};
    supply_limit_step(&limit, &tuning, &open);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, limit.current);
}
