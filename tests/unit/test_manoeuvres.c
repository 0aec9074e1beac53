/* The order of the manoeuvres and the conditions of each change. */
#include "tests/unit/manoeuvres_bench.h"

static void given_caught(double omega_m)
{
    machine.omega_m = omega_m;
    wish.omega_m_ref = (float)omega_m;
    begin();
    (void)steps_until(MANOEUVRE_RUN, 0.021);
}

static void given_running(double omega_m)
{
    given_caught(omega_m);
    steps(0.5);
    traced = 0;
}

/* Runs to the period in which a setpoint of the present window takes effect: the first period of the
 * window after the next. */
static void until_it_acts(void)
{
    windows(1u);
    step();
}

static void given_heavy_running(double omega_m)
{
    setUp();
    make_heavy();
    given_running(omega_m);
}

/* ---- catch ---- */

/* The angle of a catch lags by the error of the speed with which it was rotated, divided by the 600 rad/s
 * of its low-pass. */
static void expect_caught(void)
{
    const double miss = (double)fast.locked.omega_e - POLE_PAIRS * machine.omega_m;
    TEST_ASSERT_DOUBLE_WITHIN(0.04 * fabs(POLE_PAIRS * machine.omega_m), 0.0, miss);
    TEST_ASSERT_DOUBLE_WITHIN(fabs(miss) / 600.0 + 1e-4, 0.0,
                              circle((double)fast.locked.theta_e - machine.theta));
}

/* The number of periods until the fast task has locked the loop to what it has caught. */
static uint32_t steps_until_locked(void)
{
    const uint32_t from = period;
    do {
        step();
    } while (fast.locking == 0u && period - from < 400u);
    TEST_ASSERT_EQUAL_UINT32(1u, fast.locking);
    return period - from;
}

/* Above the hand-over speed, 16 rad/s, the rotor runs without a proof. */
static void test_turning_rotor_is_caught_and_run(void)
{
    static const double speeds[] = {20.0, 30.0, 90.0, 150.0};
    for (int n = 0; n < 8; n++) {
        setUp();
        make_heavy();
        params.speed_ramp = 10.0f;
        machine.omega_m = (n % 2 == 0 ? 1.0 : -1.0) * speeds[n / 2];
        machine.theta = 0.7 * n;
        wish.omega_m_ref = (float)machine.omega_m;
        begin();
        TEST_ASSERT_FALSE(manoeuvres_knows(&m));
        const uint32_t taken = steps_until_locked();
        TEST_ASSERT_TRUE(taken >= 100u && taken <= 200u);
        expect_caught();
        TEST_ASSERT_EQUAL_INT32(FRAME_TURNS, demand.change);
        TEST_ASSERT_TRUE(demand.frame.theta_e == fast.locked.theta_e);
        /* The current along the d axis continues to flow and makes no torque. */
        TEST_ASSERT_TRUE(demand.current.q == 0.0f);
        TEST_ASSERT_EQUAL_FLOAT(3.0f * params.doubtful_current, demand.current.d);
        TEST_ASSERT_TRUE(steps_until(MANOEUVRE_RUN, 0.001) <
                         W); /* the medium task knows it at the end of its window */
        TEST_ASSERT_DOUBLE_WITHIN(0.04, 1.0, (double)made.omega_m_ref / machine.omega_m);
        TEST_ASSERT_DOUBLE_WITHIN(0.1, 0.0, made_i_q());
        TEST_ASSERT_TRUE(m.start_try == 0u && m.failed == 0u && manoeuvres_knows(&m));
        windows(MANOEUVRE_MASKED);
        TEST_ASSERT_FALSE(manoeuvres_judged(&m));
        windows(1u);
        TEST_ASSERT_TRUE(manoeuvres_judged(&m));
        steps(1.0);
        EXPECT_TRACE(MANOEUVRE_CATCH, MANOEUVRE_RUN);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, 1.0, machine.omega_m / (double)wish.omega_m_ref);
    }
}

/* The catch is in the stationary frame with integrals at zero, and its voltage is the EMF at the time at
 * which it acts. The current is along phase a for 4 ms, then along the direction that makes no torque. */
static void test_catch_holds_the_emf_and_hardly_a_current(void)
{
    make_heavy();
    machine.omega_m = -100.0;
    begin();
    step();
    TEST_ASSERT_EQUAL_INT32(FRAME_ANEW, demand.change);
    for (int n = 2; n < 100; n++) {
        const double turned = 1.5 * T * (double)fast.catching.omega_e;
        step();
        TEST_ASSERT_EQUAL_INT32(FRAME_GOES_ON, demand.change);
        TEST_ASSERT_TRUE(demand.frame.theta_e == 0.0f && demand.frame.omega_e == 0.0f);
        if (n <= 40) {
            TEST_ASSERT_TRUE(demand.current.d == 3.0f * params.doubtful_current && demand.current.q == 0.0f);
        } else {
            const double complex current = of_dq(demand.current);
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, 3.0 * (double)params.doubtful_current,
                                      cabs(current)); /* no other current is requested */
            TEST_ASSERT_DOUBLE_WITHIN(0.1, 0.0, circle(carg(current) - machine.theta));
        }
        const double complex voltage = of_dq(demand.emf);
        const double complex emf = of_ab(estimate.emf);
        TEST_ASSERT_EQUAL(n > 40, turned < 0.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, cabs(voltage - emf * cexp(J * turned)));
        TEST_ASSERT_EQUAL_FLOAT(fast.catching.omega_e, reference_speed(&fast));
    }
}

static void test_catch_waits_for_the_observer(void)
{
    begin();
    setpoint = next;
    reference_take(&fast, &fast_tuning, &setpoint);
    const reference_input_t input = {.estimate = &estimate, .u_dc = U_DC};
    for (int n = 0; n < 500; n++) {
        reference_step(&fast, &fast_tuning, &setpoint, &input, &demand);
    }
    TEST_ASSERT_EQUAL_INT32(CATCH_GOES_ON, fast.outcome);
    TEST_ASSERT_EQUAL_UINT32(0u, fast.catching.periods);
}

/* 450 rad/s make 329 V. The link can hold 179 V, and 293 V if 0.7 of the current limit weakens the field. */
static void test_rotor_beyond_the_link_is_too_fast(void)
{
    for (int way = -1; way <= 1; way += 2) {
        machine.omega_m = way * 450.0;
        begin();
        for (uint32_t n = 0; n < 2u; n++) { /* 1 ms, which is known at the end of its window */
            TEST_ASSERT_EQUAL_HEX32(0u, m.failed);
            windows(1u);
        }
        TEST_ASSERT_EQUAL_HEX32(MANOEUVRE_TOO_FAST, m.failed);
        manoeuvres_end(&m);
        TEST_ASSERT_EQUAL_HEX32(0u, m.failed);
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_OFF, m.now);
    }
}

/* ---- start ---- */

/* By the rule the turn of an alignment takes 16 over the pendulum's frequency, and at least 0.3 s. */
static uint32_t align_periods(double inertia)
{
    const double natural = sqrt(POLE_PAIRS * KT * (double)params.current_limit / inertia);
    return W * (uint32_t)(fmin(fmax(16.0 / natural, 0.3), 2.0) / (W * T) + 0.5); /* whole windows */
}

/* One turn from the initial angle of the frame, in the requested direction, from every angle of the rotor,
 * including the unstable one. At the end the rotor turns with the frame. It lags by asin(T_f/(K_t I)) plus
 * the rest of its oscillation, whose amplitude was omega_if/w_n = 2 pi/16 when the frame passed the rotor.
 * In at least half of the turn it has decayed by exp(-8 zeta). zeta is 0.5 for the light rotor and 0.22
 * for the heavy one, so that 0.01 and 0.07 rad are left. */
static void test_alignment_of_one_slow_turn_takes_every_rotor_along(void)
{
    for (int n = 0; n < 48; n++) {
        setUp();
        if (n % 2 != 0) {
            make_heavy();
        }
        const double way = n < 24 ? 1.0 : -1.0;
        machine.theta = circle(n / 2 * PI / 6.0);
        wish.omega_m_ref *= (float)way;
        begin();
        TEST_ASSERT_EQUAL_UINT32(200u, steps_until(MANOEUVRE_ALIGN, 0.021));
        until_it_acts();
        TEST_ASSERT_EQUAL_INT32(FRAME_ANEW, demand.change);
        const uint32_t periods = align_periods(machine.inertia);
        const double speed = way * 2.0 * PI / (periods * T);
        for (uint32_t k = 1u; k <= periods; k++) {
            TEST_ASSERT_TRUE(m.now == (int32_t)MANOEUVRE_ALIGN || k + 2u * W >= periods);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3 * fabs(speed), speed, (double)demand.frame.omega_e);
            TEST_ASSERT_DOUBLE_WITHIN(3e-3, 0.0, circle((double)demand.frame.theta_e - speed * (k - 1u) * T));
            TEST_ASSERT_TRUE(k == 1u || demand.change == FRAME_GOES_ON);
            TEST_ASSERT_TRUE(cabs(current_in(0.0)) <= 10.0001);
            step();
        }
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RAMP, m.now);
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * fabs(speed), speed, (double)demand.frame.omega_e);
        const double behind = way * circle((double)demand.frame.theta_e - machine.theta);
        const double still = asin(machine.friction / (KT * (double)params.current_limit));
        TEST_ASSERT_DOUBLE_WITHIN(n % 2 == 0 ? 0.04 : 0.1, still, behind);
    }
}

/* 0.8 of the observed EMF is fed forward, and the loop is locked at the angle of the EMF. */
static void test_forced_frame_gets_its_share_of_the_emf(void)
{
    begin();
    (void)steps_until(MANOEUVRE_RAMP, 1.0);
    bool locked = false;
    double largest = 0.0;
    while (m.now != (int32_t)MANOEUVRE_HANDOVER) {
        step();
        TEST_ASSERT_TRUE(period < 30000u);
        const double complex emf = of_ab(estimate.emf);
        const double complex in_frame = emf * cexp(-J * (double)demand.frame.theta_e);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.8 * creal(in_frame), (double)demand.emf.d);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.8 * cimag(in_frame), (double)demand.emf.q);
        TEST_ASSERT_EQUAL_FLOAT(demand.frame.omega_e, reference_speed(&fast));
        largest = fmax(largest, cabs(emf));
        if (fast.locking != 0u) {
            locked = true;
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, circle((double)fast.locked.theta_e - machine.theta));
            /* The frame has continued for at most two windows and the one in which this is detected. */
            TEST_ASSERT_FLOAT_WITHIN(0.01f * m.limits.handover_speed + 3.0f * m.limits.ramp,
                                     0.4f * m.limits.handover_speed, fast.locked.omega_e);
        }
    }
    TEST_ASSERT_TRUE(locked && largest > 5.0);
}

typedef struct {
    double load; /* [N m] in addition to friction */
    bool heavy;
    float speed; /* [rad/s] */
} start_t;

/* At the hand-over the current continues in the frame of the rotor, with its mean over 1/70 s. */
static void check_start(const start_t *start, double theta)
{
    setUp();
    if (start->heavy) {
        make_heavy();
    }
    machine.friction += start->load;
    machine.theta = theta;
    again = theta > 0.0;
    wish.omega_m_ref = start->speed;
    params.speed_ramp = 100.0f; /* larger than the ramp of the start */
    begin();
    (void)steps_until(MANOEUVRE_HANDOVER, 5.0);
    double complex had = current_in(machine.theta);
    uint32_t taken = 0u;
    for (; m.now != (int32_t)MANOEUVRE_RUN && taken < 11000u; taken++) {
        step();
        had += 70.0 * T * (current_in(machine.theta) - had);
    }
    TEST_ASSERT_TRUE(taken >= 1500u && m.now == (int32_t)MANOEUVRE_RUN);
    /* The mean of a window is half a window old, in which the current decreases by at most 10/s of 10 A. */
    TEST_ASSERT_DOUBLE_WITHIN(0.02 + 0.04, cimag(had), made_i_q());
    TEST_ASSERT_DOUBLE_WITHIN(0.02 + 0.04, creal(had), (double)made.current.d);
    until_it_acts();
    TEST_ASSERT_EQUAL_INT32(FRAME_TURNS, demand.change);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, circle((double)demand.frame.theta_e - machine.theta));
    /* There are currents to be kept: that of the load, and that of the remaining swing. */
    TEST_ASSERT_DOUBLE_WITHIN(0.5, machine.friction / KT, fabs(cimag(had)));
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * fabs(machine.omega_m), machine.omega_m, (double)m.run.omega_m_ref);
    TEST_ASSERT_EQUAL_UINT32(1u, m.start_try);
    steps(3.0);
    EXPECT_TRACE(MANOEUVRE_CATCH, MANOEUVRE_ALIGN, MANOEUVRE_RAMP, MANOEUVRE_HANDOVER, MANOEUVRE_RUN);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * fabs((double)start->speed), (double)start->speed, machine.omega_m);
    TEST_ASSERT_EQUAL_UINT32(0u, m.start_try); /* the start is completed */
}

static void test_standing_rotor_is_aligned_forced_handed_over_and_run(void)
{
    static const start_t starts[] = {{0.0, false, 50.0f},  {2.5, false, -50.0f}, {5.0, false, 50.0f},
                                     {0.0, true, -120.0f}, {2.5, true, 120.0f},  {5.0, true, -50.0f}};
    for (int n = 0; n < 6; n++) {
        for (double theta = -3.0; theta < 3.1; theta += 1.5) {
            check_start(&starts[n], theta);
        }
    }
}

/* The estimate does not settle: a detector of 0.5 has a scatter of 0.25. */
static void test_estimate_that_does_not_settle_fails_the_start(void)
{
    params.start_tries = 1;
    machine.detector = 0.5;
    begin();
    (void)steps_until(MANOEUVRE_HANDOVER, 3.0);
    for (int n = 1; n < 1250; n++) {
        windows(1u);
        TEST_ASSERT_EQUAL_HEX32(0u, m.failed);
    }
    windows(1u);
    TEST_ASSERT_EQUAL_HEX32(MANOEUVRE_UNLOCKED, m.failed);
}

/* The number of windows after which the loop is locked to the EMF; 0: not within 0.2 s. */
static uint32_t windows_until_locked(void)
{
    for (uint32_t n = 1u; n <= 250u; n++) {
        windows(1u);
        if (made.lock == (int32_t)LOCK_TO_EMF) {
            return n;
        }
    }
    return 0u;
}

/* The frame turns at 10 rad/s, 40 electrical, and the hand-over speed is 64. A loop that is not locked and
 * has a speed that differs by more than this is locked again after 20 ms, as often as that happens. The first
 * means of the lock need some windows before they show it. */
static void test_a_loop_that_leaves_the_forced_frame_is_locked_again(void)
{
    static const struct {
        double astray, detector;
        bool locked;
    } cases[] = {{200.0, 0.5, true},  {-100.0, 0.5, true}, {200.0, 0.0, true},
                 {100.0, 0.5, false}, {-20.0, 0.5, false}, {0.0, 0.5, false}};
    for (size_t n = 0; n < 2u * sizeof cases / sizeof cases[0]; n++) {
        const double way = n % 2u == 0u ? 1.0 : -1.0;
        setUp();
        wish.omega_m_ref = (float)(way * 10.0);
        begin();
        steps(3.0);
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_FORCED, m.now);
        TEST_ASSERT_EQUAL_UINT32(1u, m.tracking);
        TEST_ASSERT_DOUBLE_WITHIN(0.1, way * 10.0, machine.omega_m);
        machine.astray = way * cases[n / 2u].astray;
        machine.detector = cases[n / 2u].detector;
        for (int k = 0; k < 2; k++) {
            const uint32_t taken = windows_until_locked();
            TEST_ASSERT_TRUE(cases[n / 2u].locked ? taken >= 25u && taken <= 40u : taken == 0u);
        }
        machine.astray = 0.0;
        machine.detector = 0.0;
        TEST_ASSERT_EQUAL_UINT32(0u, windows_until_locked());
        TEST_ASSERT_EQUAL_UINT32(1u, m.start_try);
    }
}

/* ---- stall and retry ---- */

/* The change of the speed in four windows of the acceleration between alignment and fallback_speed [rad/s].
 */
static double ramp_slope(void)
{
    while (fast.forced.frame.omega_e < 0.36f * m.limits.handover_speed) {
        step();
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RAMP, m.now);
    }
    windows(2u); /* the ramp of a whole window acts */
    const double before = (double)fast.forced.frame.omega_e;
    windows(4u);
    return (double)fast.forced.frame.omega_e - before;
}

/* psi_f is configured 1.25 times too large and R 0.8 ohm. A load turns the rotor by 45 degrees behind 4 A, so
 * that 3.2 V are subtracted from the EMF's part along the current, 3.2 to 4.6 V at 25 to 36 rad/s: the length
 * is below 0.6 of the expected one for 0.25 s. The part across the current is 0.71/1.25 = 0.57. */
static void test_a_rotor_that_follows_under_load_with_a_wrong_r_is_no_stall(void)
{
    params.start_current = 4.0f;
    params.motor_flux_linkage = (float)(1.25 * PSI);
    params.speed_ramp = 10.0f;
    machine.friction = KT * 4.0 * sqrt(0.5);
    machine.wrong_r = 0.8;
    wish.omega_m_ref = 50.0f;
    begin();
    (void)steps_until(MANOEUVRE_HANDOVER, 5.0);
    TEST_ASSERT_EQUAL_UINT32(1u, m.start_try);
    EXPECT_TRACE(MANOEUVRE_CATCH, MANOEUVRE_ALIGN, MANOEUVRE_RAMP, MANOEUVRE_HANDOVER);
}

/* The stall is reported 50 ms after fallback_speed. After a pause of 0.3 s the next start has more current
 * and a slower ramp; there are at most start_tries of them. */
static void test_blocked_rotor_is_tried_again_with_more_current_and_a_slower_ramp(void)
{
    params.start_current = 4.0f;
    machine.blocked = true;
    begin();
    double slope = 0.0;
    for (uint32_t n = 1u; n <= 3u; n++) {
        (void)steps_until(MANOEUVRE_RAMP, 2.0);
        TEST_ASSERT_EQUAL_UINT32(n, m.start_try);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 4.0 * pow(1.3, n - 1.0), (double)demand.current.d);
        const double now = ramp_slope();
        TEST_ASSERT_TRUE(now > 0.0);
        if (n > 1u) {
            TEST_ASSERT_DOUBLE_WITHIN(0.01 * slope, 0.6 * slope, now);
        }
        slope = now;
        while (m.forced.speed < m.limits.fallback_speed) {
            step();
        }
        const uint32_t from = period;
        while (m.now == (int32_t)MANOEUVRE_RAMP && m.failed == 0u) {
            step();
        }
        /* 50 ms are 63 windows, of which the one that has reached the speed is the first. */
        TEST_ASSERT_EQUAL_UINT32(62u * W, period - from);
        TEST_ASSERT_EQUAL_HEX32(n == 3u ? MANOEUVRE_STALLED : 0u, m.failed);
        if (n < 3u) {
            TEST_ASSERT_EQUAL_INT32(MANOEUVRE_CATCH, m.now);
            until_it_acts();
            TEST_ASSERT_EQUAL_INT32(FRAME_ANEW, demand.change);
            TEST_ASSERT_EQUAL_UINT32(2999u, steps_until(MANOEUVRE_ALIGN, 1.0));
        }
    }
}

/* ---- slow ---- */

static void test_reference_too_slow_to_track_is_forced(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        wish.omega_m_ref = (float)way * 3.0f;
        begin();
        steps(5.0);
        EXPECT_TRACE(MANOEUVRE_CATCH, MANOEUVRE_ALIGN, MANOEUVRE_RAMP, MANOEUVRE_FORCED);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, way * 3.0, machine.omega_m);
        TEST_ASSERT_EQUAL_UINT32(0u, m.tracking);
        const frame_t rotor =
            reference_tracks(&fast) ? estimate.frame : reference_rotor(&fast, &estimate.frame);
        TEST_ASSERT_EQUAL_MEMORY(&fast.forced.frame, &rotor, sizeof rotor);
        wish.omega_m_ref = (float)way * 40.0f;
        steps(3.0);
        EXPECT_TRACE(MANOEUVRE_FORCED, MANOEUVRE_RAMP, MANOEUVRE_HANDOVER, MANOEUVRE_RUN);
        TEST_ASSERT_DOUBLE_WITHIN(0.4, way * 40.0, machine.omega_m);
        wish.omega_m_ref = (float)way * 2.0f;
        steps(3.0);
        EXPECT_TRACE(MANOEUVRE_RUN, MANOEUVRE_FORCED);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, way * 2.0, machine.omega_m);
        TEST_ASSERT_EQUAL_HEX32(0u, m.failed);
    }
}

/* The turn of the alignment would drive the motor for 0.3 to 2 s more: the frame must slow down at once. */
static void test_a_quick_stop_in_the_alignment_stops_the_frame(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        wish.omega_m_ref = (float)way * 50.0f;
        begin();
        (void)steps_until(MANOEUVRE_ALIGN, 1.0);
        steps(0.1);
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_ALIGN, m.now);
        wish.mode = RUN_STOP;
        steps(4.0 * (double)DRIVE_WINDOW_PERIOD);
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_FORCED, m.now);
        steps(5.0 / (double)FORCED_EASE_CUTOFF); /* e^-5 of the speed remains */
        TEST_ASSERT_FLOAT_WITHIN(0.01f * m.limits.align_speed, 0.0f, m.forced.speed);
        TEST_ASSERT_EQUAL_HEX32(0u, m.failed);
    }
}

/* By rule a light rotor stops as fast as the frame can take it along, here by the share of its speed with
 * which the frame approaches zero: 12 rad/s times 6 rad/s and more exceed the 52 rad/s^2 of its start. A
 * gentler quick_stop_ramp is kept. */
static void test_a_quick_stop_does_not_wait_for_the_ramp_of_a_start(void)
{
    for (int way = -1; way <= 1; way += 2) {
        for (int gentle = 0; gentle < 2; gentle++) {
            setUp();
            params.motor_inertia = 0.003f;
            params.quick_stop_ramp = gentle != 0 ? 10.0f : 0.0f;
            tune();
            manoeuvres_take(&m, &tuning);
            wish.omega_m_ref = (float)way * 50.0f;
            begin();
            (void)steps_until(MANOEUVRE_RAMP, 2.0);
            while (fabsf(m.forced.speed) < 0.4f * m.limits.handover_speed) {
                step();
                TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RAMP, m.now);
            }
            wish.mode = RUN_STOP;
            windows(1u);
            const double before = fabs((double)m.forced.speed);
            windows(4u);
            const double falls = 4.0 * 10.0 * (double)DRIVE_WINDOW_PERIOD * params.motor_pole_pairs;
            const double left =
                gentle != 0 ? before - falls : before * pow(1.0 - (double)m.limits.ease_share, 4.0);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3 * before, way * left, (double)m.forced.speed);
        }
    }
}

/* The flux, R and J are configured 1.3 times too large, and only a quarter of J is on the motor's side of
 * an elastic shaft. The excess of the EMF that is fed forward is delta p omega with delta = s psi_f -
 * psi_f/1.3. It must drive no more than the resistance holds, K_t delta < J w_b R, and 0.4 of the lag t of
 * the encoder's speed must not drive a swing, s psi_f (1 + 0.4 t ki/kp) < psi_f/1.3 (theory 15), unless s is
 * limited by its smallest value or J is large. Far away from this limit s must be 1, for either source of the
 * position. */
static void test_an_emf_fed_forward_too_much_does_not_drive_the_rotor(void)
{
    const double configured = POLE_PAIRS * (double)params.motor_flux_linkage;
    const double kp = (double)params.motor_inductance_q * (double)params.current_bandwidth;
    const double most = 0.25 * kp * (double)params.current_bandwidth;
    const double resistance = (double)(params.motor_resistance + params.device_resistance);
    const double lag = 0.4 * (2.0 / (double)params.encoder_bandwidth + 1.5 * T);
    for (double inertia = 1e-7; inertia < 0.1; inertia *= 1.3) {
        params.motor_inertia = (float)inertia;
        params.position_source = POSITION_ENCODER;
        tune();
        const double share = (double)fast_tuning.flux_linkage / (double)params.motor_flux_linkage;
        const double drives = 1.5 * configured * configured / 1.69 * (1.3 * share - 1.0);
        const double holds = 0.25 * inertia / 1.3 * (double)params.current_bandwidth * resistance / 1.3;
        const double held = fmin(3.0 * 1.5 * configured * configured / inertia, most);
        const double ki = fmax(held, resistance * (double)params.current_bandwidth);
        const double excess = 1.3 * (1.0 + lag * ki / kp);
        const double driven = 1.5 * configured * configured;
        TEST_ASSERT_TRUE(share >= 1.0 / excess - 1e-6 && share <= 1.0);
        TEST_ASSERT_TRUE(drives < 1.1 * fmax(holds, 0.25 * inertia / 1.69 * ki));
        TEST_ASSERT_TRUE(share * excess < 1.0 + 0.26 * inertia * ki / driven);
        TEST_ASSERT_TRUE(share == 1.0 || driven * (excess - 1.0) > 0.25 * inertia * ki);
        params.position_source = POSITION_SENSORLESS;
        tune();
        TEST_ASSERT_EQUAL_FLOAT((float)share, fast_tuning.flux_linkage / params.motor_flux_linkage);
    }
}

/* The rotor is a pendulum on the current I with w_n^2 = p K_t I/J: six times the electrical speed has to
 * be at least twice w_n. */
static void test_a_forced_frame_turns_evenly_above_the_pendulum_s_own_frequency(void)
{
    make_heavy();
    machine.omega_m = 0.0;
    begin();
    (void)steps_until(MANOEUVRE_ALIGN, 1.0);
    for (int n = 1; n <= 10; n++) {
        const double current = n;
        const double natural = sqrt(POLE_PAIRS * KT * current / (double)params.motor_inertia);
        m.forced.current = (float)current;
        for (int sign = -1; sign <= 1; sign += 2) {
            m.forced.speed = (float)(sign * 0.98 * natural / 3.0);
            TEST_ASSERT_FALSE(manoeuvres_even(&m));
            m.forced.speed = (float)(sign * 1.02 * natural / 3.0);
            TEST_ASSERT_TRUE(manoeuvres_even(&m));
        }
    }
    m.forced.speed = 0.0f;
    m.now = (int32_t)MANOEUVRE_RUN;
    TEST_ASSERT_TRUE(manoeuvres_even(&m));
}

/* The d axis advances by the load angle, so that the torque does not change. */
static void test_fall_back_keeps_the_torque(void)
{
    static const double loads[] = {0.05, 2.0, 5.0, 8.0};
    for (int n = 0; n < 8; n++) {
        setUp();
        make_heavy();
        machine.friction = loads[n / 2];
        given_running(n % 2 == 0 ? 30.0 : -30.0);
        wish.omega_m_ref = 0.0f;
        params.speed_ramp = 20.0f;
        tune();
        manoeuvres_take(&m, &tuning);
        double before = 0.0;
        while (fast.source != (int32_t)SOURCE_FORCED) {
            before = torque_of_current();
            step();
            TEST_ASSERT_TRUE(period < 60000u);
        }
        TEST_ASSERT_EQUAL_INT32(FRAME_TURNS, demand.change);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, 10.0, hypot((double)demand.current.d, (double)demand.current.q));
        step();
        TEST_ASSERT_DOUBLE_WITHIN(0.15, before, torque_of_current());
    }
}

/* ---- reversal ---- */

/* At the current limit the rotor passes zero speed faster than the model of the loop needs, which is 12
 * rad/s at 152 rad/s^2 and more. The manoeuvre run continues and is not judged in this range: from the EMF
 * of 15.8 rad/s, the hand-over speed, until 10.5 rad/s in the other direction, and for the 10 ms after
 * that. At 152 to 200 rad/s^2 this takes 0.14 to 0.18 s. */
static void test_quick_reversal_stays_in_run_and_is_not_judged_near_zero(void)
{
    for (int way = -1; way <= 1; way += 2) {
        given_heavy_running(way * 50.0);
        TEST_ASSERT_TRUE(manoeuvres_judged(&m) && m.reversing == 0u);
        wish.omega_m_ref = (float)way * -50.0f;
        bool sign = false, passed = false;
        uint32_t masked = 0u;
        for (int n = 0; n < 20000; n++) {
            step();
            TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
            sign = sign || m.unlocked != 0u;
            TEST_ASSERT_FALSE(m.unlocked != 0u && manoeuvres_judged(&m));
            if (POLE_PAIRS * fabs(machine.omega_m) < (double)m.limits.fallback_speed) {
                passed = true;
                TEST_ASSERT_FALSE(manoeuvres_judged(&m));
            }
            masked += manoeuvres_judged(&m) ? 0u : 1u;
            TEST_ASSERT_FALSE(manoeuvres_steady(&m) && m.reversing != 0u);
        }
        TEST_ASSERT_TRUE(sign && passed); /* there was a sign while the loop was not judged */
        TEST_ASSERT_TRUE(masked > 1400u && masked < 1800u);
        TEST_ASSERT_TRUE(manoeuvres_judged(&m) && m.reversing == 0u);
        TEST_ASSERT_DOUBLE_WITHIN(0.5, way * -50.0, machine.omega_m);
    }
}

/* The passage from 6.3 rad/s, fallback_speed, to the opposite speed may take 0.1 s. A speed that has passed
 * zero and stays at 2 rad/s has gained (6.3 + 2)/(2 x 6.3) = 0.66 of it: the forced frame takes over 66 ms
 * after the EMF was lost. At 4 rad/s it is 0.82, 82 ms. The mean of the EMF lags by up to 10 ms, in which up
 * to 2 rad/s are gained: (4.3 + 2)/(4.3 + 6.3) = 0.59. */
static void test_a_reversal_that_stays_behind_ends_in_the_forced_frame(void)
{
    static const struct {
        double stays, least, most; /* [rad/s], [s] */
    } cases[] = {{2.0, 0.056, 0.08}, {4.0, 0.073, 0.095}};
    for (size_t n = 0; n < 2u * sizeof cases / sizeof cases[0]; n++) {
        const double way = n % 2u == 0u ? 1.0 : -1.0;
        const double slow = 6.3;
        given_heavy_running(way * 50.0);
        wish.omega_m_ref = (float)way * -50.0f;
        while (way * machine.omega_m > slow) {
            step();
        }
        double since = 0.0;
        for (; since < 0.2 && m.now == (int32_t)MANOEUVRE_RUN; since += T) {
            step();
            machine.inertia *=
                machine.inertia < 1e3 && way * machine.omega_m < -cases[n / 2u].stays ? 1e6 : 1.0;
        }
        TEST_ASSERT_TRUE(since >= cases[n / 2u].least && since <= cases[n / 2u].most);
    }
}

/* The rotor stays between the speeds at which the EMF is found and at which a reversal has passed zero,
 * 6.3 and 10.5 rad/s: its loop must settle there. The mean of its error counts the periods in which it
 * tracks: 0.5^2 (1 - exp(-t/5 ms)) > 0.12 from 3.3 ms on, and 5 ms of these periods are the limit. With an
 * error of 0.3^2 it counts as settled. */
static void test_a_loop_that_does_not_settle_ends_a_reversal(void)
{
    static const struct {
        double detector;
        uint32_t coasts;
        double within; /* [s]; 0: the manoeuvre run continues */
    } cases[] = {{0.5, 0u, 0.011}, {0.5, 6u, 0.027}, {0.3, 0u, 0.0}, {0.3, 6u, 0.0}};
    for (size_t n = 0; n < 2u * sizeof cases / sizeof cases[0]; n++) {
        const double way = n % 2u == 0u ? 1.0 : -1.0;
        given_heavy_running(way * 50.0);
        wish.omega_m_ref = (float)way * -50.0f;
        for (int k = 0; k < 20000 && way * machine.omega_m > -8.5; k++) {
            step();
        }
        machine.inertia *= 1e6; /* so that it keeps this speed */
        steps(0.02);
        TEST_ASSERT_TRUE(m.reversing != 0u && !manoeuvres_judged(&m));
        traced = 0;
        machine.detector = cases[n / 2u].detector;
        machine.coasts = cases[n / 2u].coasts;
        steps(cases[n / 2u].within > 0.0 ? cases[n / 2u].within : 0.2);
        TEST_ASSERT_EQUAL_INT(cases[n / 2u].within > 0.0 ? 1 : 0, m.now != (int32_t)MANOEUVRE_RUN);
        TEST_ASSERT_TRUE(cases[n / 2u].within == 0.0 || trace[1].name == (int32_t)MANOEUVRE_FORCED);
    }
}

/* In a reversal a load holds the rotor at zero speed, and the loop leaves it: it has 20 rad/s in the
 * direction of the reference, without an EMF. That is no passed zero. The EMF has been missing for longer
 * than 5 ms, so that the forced frame takes over in the next windows, and no rotor counts as lost. */
static void test_a_loop_that_leaves_a_held_rotor_in_a_reversal_ends_in_the_forced_frame(void)
{
    for (int way = -1; way <= 1; way += 2) {
        given_heavy_running(way * 50.0);
        wish.omega_m_ref = (float)way * -50.0f;
        for (int k = 0; k < 20000 && way * machine.omega_m > 0.5; k++) {
            step();
        }
        machine.blocked = true;
        steps(0.01);
        TEST_ASSERT_TRUE(m.reversing != 0u && m.now == (int32_t)MANOEUVRE_RUN);
        machine.astray = way * -20.0 * POLE_PAIRS;
        steps(0.005);
        TEST_ASSERT_EQUAL_INT32(SOURCE_FORCED, fast.source);
        TEST_ASSERT_EQUAL_UINT32(0u, m.losses.count);
    }
}

/* A load stops the rotor at 25 rad/s, and the loop runs on in the direction of the reference with 20 rad/s.
 * The mean EMF along its axis is still that of the old direction, 25 rad/s exp(-t/5 ms); it is no proof that
 * the rotor has passed zero. */
static void test_the_emf_of_the_old_direction_does_not_end_a_reversal(void)
{
    for (int way = -1; way <= 1; way += 2) {
        given_heavy_running(way * 50.0);
        wish.omega_m_ref = (float)way * -50.0f;
        for (int k = 0; k < 20000 && way * machine.omega_m > 25.0; k++) {
            step();
        }
        machine.blocked = true;
        machine.astray = way * -20.0 * POLE_PAIRS;
        for (int k = 0; k < 40; k++) {
            step();
            TEST_ASSERT_TRUE(m.reversing != 0u);
        }
        steps(0.02);
        TEST_ASSERT_EQUAL_INT32(SOURCE_FORCED, fast.source);
        TEST_ASSERT_EQUAL_UINT32(0u, m.losses.count);
    }
}

/* In a reversal a loop with an error of 0.5^2 > 0.12 has an EMF of the new direction: beside such a loop it
 * is no proof, neither of the angle nor that zero was passed, also if it is longer than at the hand-over
 * (15.8 rad/s). The EMF was missing before (5.5 rad/s), or smaller than at the hand-over (8 rad/s). The limit
 * is 5 ms from the window on in which the mean of the error has reached 0.12, after 3.3 ms. Neither the speed
 * of the loop nor that of its EMF is known to be the rotor's: the forced frame begins at rest. With an error
 * of 0.3^2 the loop has passed zero. */
static void test_an_emf_beside_a_scattered_loop_does_not_end_the_passage(void)
{
    static const double begins[] = {5.5, 8.0}, emf[] = {60.0, 20.0}; /* [rad/s] */
    for (int n = 0; n < 8; n++) {
        const double way = n % 2 == 0 ? 1.0 : -1.0;
        const bool ends = n < 4;
        given_heavy_running(way * 50.0);
        wish.omega_m_ref = (float)way * -50.0f;
        for (int k = 0; k < 20000 && way * machine.omega_m > begins[n / 2 % 2]; k++) {
            step();
        }
        traced = 0;
        machine.detector = ends ? 0.5 : 0.3;
        steps(0.004);
        machine.omega_m = way * -emf[n / 2 % 2];
        for (int k = 0; k < 80 && m.now == (int32_t)MANOEUVRE_RUN; k++) {
            step();
        }
        TEST_ASSERT_EQUAL_INT(ends ? 1 : 0, m.now != (int32_t)MANOEUVRE_RUN);
        TEST_ASSERT_TRUE(!ends || trace[1].name == (int32_t)MANOEUVRE_FORCED);
        TEST_ASSERT_TRUE(!ends || m.forced.speed == 0.0f);
        TEST_ASSERT_EQUAL_UINT32(0u, m.losses.count);
    }
}

/* At 20 rad/s^2 the rotor stays near zero speed for longer than the model of the loop can bridge. */
static void test_slow_reversal_goes_through_zero_in_a_forced_frame(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        make_heavy();
        params.speed_ramp = 20.0f;
        given_running(way * 40.0);
        wish.omega_m_ref = (float)way * -40.0f;
        steps(10.0);
        EXPECT_TRACE(MANOEUVRE_RUN, MANOEUVRE_FORCED, MANOEUVRE_REVERSE, MANOEUVRE_HANDOVER, MANOEUVRE_RUN);
        TEST_ASSERT_DOUBLE_WITHIN(0.4, way * -40.0, machine.omega_m);
        TEST_ASSERT_EQUAL_HEX32(0u, m.failed);
        TEST_ASSERT_EQUAL_UINT32(0u, m.losses.count);
    }
}

/* The lock is judged only in the manoeuvre run, and not within 10 ms after a hand-over. */
static void test_nothing_else_than_run_is_judged(void)
{
    begin();
    uint32_t run = 0u; /* [windows] */
    while (run < 125u) {
        windows(1u);
        run = m.now == (int32_t)MANOEUVRE_RUN ? run + 1u : 0u;
        TEST_ASSERT_EQUAL(run > MANOEUVRE_MASKED + 1u, manoeuvres_judged(&m));
        TEST_ASSERT_TRUE(period < 60000u);
    }
}

/* ---- loss ---- */

static void test_lost_rotor_is_caught_again(void)
{
    for (int way = -1; way <= 1; way += 2) {
        given_heavy_running(way * 60.0);
        again = way > 0;
        lose();
        TEST_ASSERT_EQUAL_UINT32(1u, m.losses.count);
        TEST_ASSERT_FALSE(manoeuvres_judged(&m) || manoeuvres_knows(&m));
        until_it_acts();
        TEST_ASSERT_EQUAL_INT32(FRAME_ANEW, demand.change);
        TEST_ASSERT_TRUE(demand.frame.theta_e == 0.0f && demand.frame.omega_e == 0.0f);
        TEST_ASSERT_TRUE(demand.current.d == 3.0f * params.doubtful_current && demand.current.q == 0.0f);
        TEST_ASSERT_EQUAL_UINT32(0u, fast.tracking);
        TEST_ASSERT_TRUE(steps_until_locked() < 200u);
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RELOCK, m.now); /* locked and not proved yet: no torque */
        expect_caught();
        TEST_ASSERT_TRUE(demand.current.q == 0.0f);
        /* The EMF must agree four times for 2 ms, in whole windows, from the end of the window in which
         * the rotor was caught. */
        const uint32_t proof = PROOF_WINDOWS * m.proof.tuning.window * W;
        const uint32_t took = steps_until(MANOEUVRE_RUN, 0.012);
        TEST_ASSERT_TRUE(took >= proof && took < proof + W);
        steps(0.5);
        TEST_ASSERT_DOUBLE_WITHIN(0.6, way * 60.0, machine.omega_m);
        TEST_ASSERT_EQUAL_HEX32(0u, m.failed);
    }
}

static void test_rotor_that_stands_after_a_loss_is_started(void)
{
    given_running(60.0);
    machine.blocked = true;
    windows(1u);
    machine.blocked = false;
    machine.friction = 0.05;
    lose();
    steps(3.0);
    EXPECT_TRACE(MANOEUVRE_RUN, MANOEUVRE_RELOCK, MANOEUVRE_ALIGN, MANOEUVRE_RAMP, MANOEUVRE_HANDOVER,
                 MANOEUVRE_RUN);
    TEST_ASSERT_DOUBLE_WITHIN(0.6, 60.0, machine.omega_m);
}

/* The third loss within 2 s of the first is a fault; without this limit of time any third loss would be. */
static void test_three_losses_within_two_seconds_are_a_fault(void)
{
    static const double apart[] = {0.1, 0.98, 1.02, 1.5};
    for (int n = 0; n < 4; n++) {
        given_heavy_running(60.0);
        for (uint32_t k = 1u; k <= 3u; k++) {
            lose();
            TEST_ASSERT_EQUAL_UINT32(k, m.losses.count);
            TEST_ASSERT_EQUAL_HEX32(k == 3u && n < 2 ? MANOEUVRE_LOST : 0u, m.failed);
            steps(apart[n] - W * T);
        }
    }
}

/* A start after which the rotor is lost within half a second counts as a failed try. This number of tries
 * is counted at any distance in time. */
static void test_starts_that_are_lost_at_once_are_counted_as_tries(void)
{
    for (int n = 0; n < 3; n++) {
        const uint32_t left = n == 1 ? 1u : 0u;
        setUp();
        make_heavy();
        given_caught(60.0);
        m.start_try = (uint32_t)params.start_tries - left; /* as after catches at standstill */
        steps(n == 2 ? 0.51 : 0.45);
        lose();
        TEST_ASSERT_EQUAL_HEX32(n == 0 ? MANOEUVRE_LOST : 0u, m.failed);
    }
}

/* Relocks whose runs do not last count as tries, too, however long the forced frame between them lasts. */
static void test_relocks_whose_runs_do_not_last_are_counted_as_tries(void)
{
    given_heavy_running(60.0);
    steps(1.0);
    for (uint32_t k = 0u; k <= (uint32_t)params.start_tries; k++) {
        TEST_ASSERT_EQUAL_HEX32(0u, m.failed);
        lose(); /* the first loss ends a run that has lasted */
        m.clock += DRIVE_WINDOWS(3.0f);
        steps(0.1);
    }
    TEST_ASSERT_EQUAL_HEX32(MANOEUVRE_LOST, m.failed);
}

/* The oscillation of a shaft may have caused the loss: the speed then contains the proportional part of the
 * loop, until the bridge is switched on again. */
static void test_after_a_loss_the_shaft_counts_as_one_that_swings(void)
{
    given_heavy_running(60.0);
    TEST_ASSERT_EQUAL_UINT32(0u, m.run.swings);
    lose();
    TEST_ASSERT_EQUAL_UINT32(1u, m.run.swings);
    manoeuvres_end(&m);
    start();
    TEST_ASSERT_EQUAL_UINT32(0u, m.run.swings);
}

/* The losses of the previous operation do not count. */
static void test_losses_begin_again_when_the_bridge_comes_on(void)
{
    given_heavy_running(60.0);
    for (int n = 0; n < 2; n++) {
        lose();
        steps(0.1);
    }
    manoeuvres_end(&m);
    start();
    (void)steps_until(MANOEUVRE_RUN, 0.021);
    lose();
    TEST_ASSERT_EQUAL_HEX32(0u, m.failed);
    TEST_ASSERT_EQUAL_UINT32(1u, m.losses.count);
}

/* ---- requested currents, encoder ---- */

static void test_request_for_a_current_starts_in_its_direction(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        make_heavy();
        wish = (run_wish_t){RUN_CURRENT, 77.0f, {0.5f, (float)way * 3.0f}, 0.0f};
        begin();
        (void)steps_until(MANOEUVRE_RUN, 5.0);
        windows(2u); /* the setpoint takes effect, and the current reaches it */
        TEST_ASSERT_TRUE(way * machine.omega_m > 5.0);
        TEST_ASSERT_TRUE(demand.current.d == 0.5f && demand.current.q == (float)way * 3.0f);
        const double before = machine.omega_m;
        steps(0.5); /* (K_t 3 A - T_f)/J = 31 rad/s^2 */
        TEST_ASSERT_DOUBLE_WITHIN(1.0, before + way * 15.5, machine.omega_m);
    }
}

static void test_with_the_encoder_there_is_nothing_but_run(void)
{
    params.position_source = POSITION_ENCODER;
    wish.omega_m_ref = 1.0f;
    begin();
    TEST_ASSERT_TRUE(manoeuvres_knows(&m));
    for (int n = 0; n < 20000; n++) {
        wish.omega_m_ref = n < 10000 ? 1.0f : -40.0f;
        lost = n == 5000;
        step();
        const frame_t encoder = true_frame();
        const frame_t rotor = reference_tracks(&fast) ? estimate.frame : reference_rotor(&fast, &encoder);
        TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
        TEST_ASSERT_FALSE(manoeuvres_judged(&m));
        TEST_ASSERT_EQUAL_MEMORY(&encoder, &demand.frame, sizeof encoder);
        TEST_ASSERT_EQUAL_MEMORY(&encoder, &rotor, sizeof encoder);
        TEST_ASSERT_EQUAL_INT32(n == 0 ? FRAME_ANEW : FRAME_GOES_ON, demand.change);
        TEST_ASSERT_TRUE(demand.emf.d == 0.0f);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, (float)PSI * encoder.omega_e, demand.emf.q);
    }
    TEST_ASSERT_EQUAL_HEX32(0u, m.failed);
    TEST_ASSERT_DOUBLE_WITHIN(0.4, -40.0, machine.omega_m);
}

static void change_source(int32_t source)
{
    params.position_source = source;
    tune();
    manoeuvres_take(&m, &tuning);
    windows(1u);
    until_it_acts();
    TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
    TEST_ASSERT_EQUAL_INT32(FRAME_TURNS, demand.change);
}

/* When the drive leaves the forced frame, the current keeps its value; when it returns, the manoeuvre run
 * continues. Both changes rotate the integrals once. */
static void test_other_source_under_way_turns_the_frame(void)
{
    machine.friction = 2.0;
    wish.omega_m_ref = 3.0f;
    begin();
    (void)steps_until(MANOEUVRE_FORCED, 2.0);
    steps(2.0);
    change_source(POSITION_ENCODER);
    const double complex had = current_in(machine.theta);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, cimag(had), (double)demand.current.q);
    /* i_d has decayed for 0.8 ms with 100 ms. */
    TEST_ASSERT_DOUBLE_WITHIN(0.05 + 0.008 * creal(had), creal(had), (double)demand.current.d);
    step();
    TEST_ASSERT_EQUAL_INT32(FRAME_GOES_ON, demand.change);
    wish.omega_m_ref = 40.0f;
    steps(1.0);
    while (in_window != 0u) {
        step();
    }
    change_source(POSITION_SENSORLESS);
    steps(0.5);
    TEST_ASSERT_EQUAL_INT32(MANOEUVRE_RUN, m.now);
    TEST_ASSERT_DOUBLE_WITHIN(0.4, 40.0, machine.omega_m);
}
