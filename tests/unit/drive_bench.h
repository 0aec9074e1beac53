/* A drive without hardware: its parameters, samples and command, the effect of the trip zone on the
 * command, and functions that bring it into its states. */
#ifndef TESTS_UNIT_DRIVE_BENCH_H
#define TESTS_UNIT_DRIVE_BENCH_H

#include "drive/drive.h"
#include "tests/unit/compare.h"

static drive_t drive;
static params_t params;
static drive_samples_t samples; /* samples of two current sensors */
static drive_command_t command;

/* The defaults, with the paper's speed control on the encoder. No rotor and no winding are simulated. */
static inline void bench_begin(void)
{
    params_defaults(&params);
    params.position_source = POSITION_ENCODER;
    params.encoder_fault_reaction = ENCODER_FAULT_IGNORED; /* without a rotor there is no EMF */
    params.current_judged = CURRENT_NOT_JUDGED;            /* there is no winding */
    params.speed_kp = 0.5f;
    params.speed_ki = 2.5f;
    params.speed_setpoint_weight = 1.0f;
    drive_init(&drive, &params);
    samples = (drive_samples_t){
        .u_dc = 311.0f, .sink_temperature = 40.0f, .motor_temperature = 40.0f, .flags = DRIVE_SAMPLE_TRIPPED};
    memset(&command, 0, sizeof command);
}

static inline void step(void)
{
    samples.i_c = -(samples.i_a + samples.i_b);
    if (drive_step(&drive, &samples, &command)) {
        drive_medium_step(&drive);
    }
}

static inline void steps(uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        step();
        /* The effect of the trip zone on the command. */
        if (command.gates == GATES_ON) {
            samples.flags &= ~DRIVE_SAMPLE_TRIPPED;
        } else if (command.gates == GATES_OFF) {
            samples.flags |= DRIVE_SAMPLE_TRIPPED;
        }
    }
}

/* Runs to the end of the present window, and this number of windows more. */
static inline void windows(uint32_t count)
{
    do {
        steps(1);
        count -= drive.fast.sum.periods % DRIVE_WINDOW == 0u ? 1u : 0u;
    } while (count > 0u);
}

/* Runs until a present request, or a decision at the end of this window, has its full effect. The effect
 * begins with the first period of the window after the next and is complete at the end of that window. */
static inline void windows_until_it_acts(void)
{
    windows(2u);
    steps(1);
}

static inline void request(int32_t enable)
{
    requests_t requests = drive.requests;
    requests.enable = enable;
    drive_request(&drive, &requests);
}

static inline void request_currents(float d, float q)
{
    requests_t requests = drive.requests;
    requests.mode = MODE_CURRENT;
    requests.i_d_request = d;
    requests.i_q_request = q;
    drive_request(&drive, &requests);
}

static inline void request_speed(float omega_m)
{
    requests_t requests = drive.requests;
    requests.mode = MODE_SPEED;
    requests.speed_request = omega_m;
    drive_request(&drive, &requests);
}

/* Makes `params` active from the next step on. */
static inline void offer_params(void)
{
    params_error_t why;
    TEST_ASSERT_TRUE(params_check(&params, &why));
    const assumed_t assumed = params_configured(&params);
    drive_withdraw(&drive);
    drive_prepare(drive_idle_tuning(&drive), &params, &assumed);
    drive_offer(&drive);
}

static inline void expect_state(drive_state_t state)
{
    TEST_ASSERT_EQUAL_INT32(state, drive.state);
}

static inline void expect_fault(int32_t reason)
{
    expect_state(DRIVE_FAULT);
    TEST_ASSERT_EQUAL_INT32(reason, drive.fault_reason);
}

static inline void bring_to_ready(void)
{
    steps(2000);
    expect_state(DRIVE_READY);
}

/* [windows] From the request to operation. These are the window in which the request is read, the next
 * one, the one in which the gates are switched on, and the one until the decision takes effect and is
 * shown. */
#define SWITCHING_ON 4u

static inline void bring_to_run(void)
{
    bring_to_ready();
    request(REQUEST_ON);
    windows(SWITCHING_ON);
    expect_state(DRIVE_OPERATION_ENABLED);
}

/* Turns the shaft by this number of counts in each period. A turn has 10000 counts; a whole number per
 * period makes the tracked speed exact. */
static inline void turn(uint32_t counts, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        samples.encoder = (samples.encoder + counts) % 10000u;
        steps(1);
    }
}

#endif
