/* Judges whether a drive does its work: it runs, follows its requests, and ends operation beyond its limits.
 */
#include <math.h>
#include <string.h>

#include "host_sim/lab/campaign_parts.h"
#include "settings/reasons.h"

#define OFF_PERIODS   (2u * DRIVE_WINDOW + 2u) /* [periods] of campaign_invariants */
#define LINK_PERIODS  3u                       /* [periods] of too high a link with a gate on */
#define SPEED_SECONDS 5e-3                     /* [s] of too fast a shaft with a gate on */
#define LOOP_LAG      5.0 /* [-] k_p/k_i of the tracking loop times its bandwidth, at damping 1 */
/* [-] time from a step of psi_f, times the bandwidth of the loop, until the error of the speed of a loop
 * of damping 1 has decreased to 5 %: (1 + x) exp(-x) = 0.05 at x = w_n t = 4.74,
 * and w_n is 0.26 of the bandwidth with a feed-forward of a quarter of it */
#define MAGNET_SETTLES  18.3
#define AWAY_SECONDS    0.1  /* [s] of a torque that increases the error of the speed */
#define INTEGRAL        3.0  /* [-] k_p w/k_i of the speed control, with k_p = J w/K_t, by its rule */
#define ANSWERS         3.0  /* [-] time constants after which the speed control has responded */
#define ANSWER_MOST     1.0  /* [s] */
#define HELD_MOST       2.0  /* [s] longest time for which the integral may leave a shaft at standstill */
#define AWAY_SPEED      0.05 /* [-] of rated speed: with a smaller error the speed counts as reached */
#define AWAY_BEYOND     1.3  /* [-] of the requested torque */
#define WINDOW_SECONDS  0.1  /* [s] over which the speed's error is averaged */
#define TURN            6.28318530717958647692 /* [rad] */
#define REACH_LOAD      0.5  /* [-] of rated torque: with a larger load no speed is promised */
#define BASE_SHARE      0.9  /* [-] of rated speed: above this the field may be weakened */
#define LEAST_ROOM      0.15 /* [-] of rated torque, that is available for acceleration */
#define START_SECONDS   1.8  /* [s] that a start without encoder may take */
#define ENCODER_SECONDS 0.4  /* [s] the same with the encoder */
#define STOPS_HANDOVER  1.1  /* [-] of the hand-over speed: starts failed from 1.27 on, not at 1.1 */
#define STOP_SECONDS    0.5  /* [s] that a quick stop may take in addition to the braking time */
#define STOP_SHARE      3.0  /* [-] of the time that rated torque needs to stop all that turns */
#define STOP_FORCED     7.0  /* [-] the same from a forced frame, which uses 15 % of the torque */
#define SWITCH_ON_SPEED 0.9  /* [-] of the trip, from which on the refusal `overspeed` is true */
#define LINK_NOISE      4.0  /* [-] accepted number of standard deviations of the link's noise */
#define LINK_STEP       0.5  /* [V] of the converter of the link's voltage, and of its filter */

static double drag_of(const campaign_case_t *drawn)
{
    return CAMPAIGN_VALUE(drawn, friction) * fmax(1.0, CAMPAIGN_VALUE(drawn, stiction)) +
           CAMPAIGN_VALUE(drawn, viscous);
}

/* Without stiction the plant's friction is smooth within this speed, so that an active load that real
 * friction would hold turns the shaft at up to this speed. */
static double creep_of(const campaign_case_t *drawn, double torque)
{
    const double rotor = campaign_inertia(drawn) / (1.0 + CAMPAIGN_VALUE(drawn, second_mass));
    return CAMPAIGN_VALUE(drawn, stiction) != 0.0
               ? 0.0
               : CAMPAIGN_CREEP * CAMPAIGN_VALUE(drawn, friction) * torque / rotor;
}

/* k_i K_t = J w^2/3 by the rule, from the configured J and psi_f. */
static double winding(const campaign_case_t *drawn)
{
    const double w = campaign_speed_loop(drawn);
    const double configured =
        CAMPAIGN_VALUE(drawn, inertia_configured) / CAMPAIGN_VALUE(drawn, flux_configured);
    return configured * campaign_inertia(drawn) * w * w / INTEGRAL;
}

/* [s] Time in which the integral of the speed control changes by this torque [N m] at this error [rad/s]. A
 * light rotor has a small k_i, independent of its load. */
static double winding_time(const campaign_duty_t *duty, double torque, double error)
{
    return fmin(torque / (duty->winding * error), HELD_MOST);
}

/* [rad/s] Speed below which a shaft by itself does not pass the largest torque A of a load that varies with
 * the angle: its energy, J w^2/2, is then less than the 2 A/n that the load takes in half of one of its n
 * cycles. The shaft stops in every cycle, until the integral of the speed control has reached A, and is then
 * released. */
static double passing_speed(const campaign_case_t *drawn, double torque)
{
    const double most = CAMPAIGN_VALUE(drawn, sine) * torque;
    return most != 0.0 ? 2.0 * sqrt(most / (CAMPAIGN_VALUE(drawn, sine_cycles) * campaign_inertia(drawn)))
                       : 0.0;
}

/* [rad/s] The same, or the speed below which the mean speed of a window contains the change of the speed by
 * such a load. */
static double uneven_of(const campaign_case_t *drawn, double torque)
{
    const double passing = passing_speed(drawn, torque);
    return passing > 0.0 ? fmax(TURN / WINDOW_SECONDS / CAMPAIGN_VALUE(drawn, sine_cycles), passing) : 0.0;
}

void campaign_duty_begin(campaign_watch_t *watch)
{
    const campaign_case_t *drawn = watch->drawn;
    const double sensed = 1.0 - fabs(CAMPAIGN_VALUE(drawn, dc_gain));
    const double noise = LINK_NOISE * CAMPAIGN_VALUE(drawn, dc_noise) + LINK_STEP;
    watch->duty = (campaign_duty_t){
        .torque = watch->motor.torque,
        .speed = watch->motor.speed,
        .inertia = campaign_inertia(drawn),
        .overspeed = campaign_invariants[CAMPAIGN_I_TRIP_SPEED].limit * watch->overspeed,
        .link = (campaign_initial(drawn, "dc_overvoltage") + noise) / sensed,
        .stop_time = campaign_initial(drawn, "fault_stop_time"),
        .load = campaign_load(drawn),
        .drag = drag_of(drawn),
        .creep = creep_of(drawn, watch->motor.torque),
        .uneven = uneven_of(drawn, watch->motor.torque),
        .needs_encoder = !campaign_has_encoder(drawn) && passing_speed(drawn, watch->motor.torque) >
                                                             STOPS_HANDOVER * campaign_handover_speed(drawn),
        .answer = fmin(ANSWERS / campaign_speed_loop(drawn), ANSWER_MOST),
        .winding = winding(drawn),
        .lag = LOOP_LAG / campaign_loop(drawn),
        .settles = MAGNET_SETTLES / campaign_loop(drawn),
        .drawn = drawn->around == NULL,
        .coded = campaign_has_encoder(drawn),
        .healthy = campaign_is_healthy(drawn),
        .limited = CAMPAIGN_VALUE(drawn, dc_edge) != 0.0 || CAMPAIGN_VALUE(drawn, supply_drawn) != 0.0 ||
                   CAMPAIGN_VALUE(drawn, supply_returned) != 0.0 ||
                   (CAMPAIGN_VALUE(drawn, dc_soft) != 0.0 && campaign_overhauls(drawn)),
        .soft = CAMPAIGN_VALUE(drawn, dc_soft) != 0.0,
    };
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        watch->duty.coded = watch->duty.coded && drawn->events[n].kind != CAMPAIGN_V_SOURCE;
    }
}

static uint32_t counted(bool holds, uint32_t before)
{
    return holds ? before + 1u : 0u;
}

/* The period in which `enable` goes to off may still have a gate on, and so may the next. */
static void judge_off(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    campaign_duty_t *duty = &watch->duty;
    duty->off = counted(rows[CAMPAIGN_AT_enable] == 0u, duty->off);
    if (duty->off > OFF_PERIODS && watch->gates_seen) {
        campaign_violated(watch, CAMPAIGN_I_OFF, period, duty->off, "enable");
    }
}

static void judge_mute(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    campaign_duty_t *duty = &watch->duty;
    const double most = campaign_invariants[CAMPAIGN_I_PERSIST].limit * 1e-3;
    const bool mute = rows[CAMPAIGN_AT_enable] == 1u && rows[CAMPAIGN_AT_state] <= watch->ready &&
                      rows[CAMPAIGN_AT_refusal] == 0u && rows[CAMPAIGN_AT_coasting] == 0u;
    duty->mute = counted(mute, duty->mute);
    if (duty->mute * RIG_PERIOD_SECONDS > most) {
        campaign_violated(watch, CAMPAIGN_I_PERSIST, period, duty->mute, "state");
    }
}

/* Longest permitted time of this quick stop [s]; 0: an active load may overhaul the motor, or the link
 * limits its
 * braking. */
static double stop_most(const campaign_watch_t *watch, const uint32_t *rows)
{
    const campaign_duty_t *duty = &watch->duty;
    const double load = fabs(campaign_number(rows, CAMPAIGN_AT_load_torque)) / duty->torque + duty->load;
    const double speed = fabs(campaign_number(rows, CAMPAIGN_AT_true_omega_m));
    if (rows[CAMPAIGN_AT_enable] != 2u) {
        return duty->stop_time + 2.0 * RIG_PERIOD_SECONDS;
    }
    const double share = rows[CAMPAIGN_AT_manoeuvre] == watch->run ? STOP_SHARE : STOP_FORCED;
    return !duty->healthy || duty->limited || duty->soft || load > REACH_LOAD
               ? 0.0
               : STOP_SECONDS +
                     share * watch->motor.fastest * speed * duty->inertia / (duty->torque * (1.0 - load));
}

static void judge_stop(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    campaign_duty_t *duty = &watch->duty;
    const bool stops = rows[CAMPAIGN_AT_state] == watch->stops;
    if (stops && duty->stopping == 0u) {
        duty->stop_most = stop_most(watch, rows);
    }
    duty->stopping = counted(stops, duty->stopping);
    const double speed = fabs(campaign_number(rows, CAMPAIGN_AT_true_omega_m));
    const bool creeps = speed > CAMPAIGN_STANDSTILL && speed < duty->creep;
    if (duty->stop_most > 0.0 && !creeps && duty->stopping * RIG_PERIOD_SECONDS > duty->stop_most) {
        campaign_violated(watch, CAMPAIGN_I_STOP, period, duty->stopping, "state");
    }
}

/* [s] Time within which the drive must open the bridge if the shaft is too fast. Without encoder the speed of
 * the loop lags behind an acceleration by k_p/k_i, in proportion to the error of the feed-forward by a wrong
 * psi_f. */
static double fast_most(const campaign_duty_t *duty)
{
    return SPEED_SECONDS + (duty->coded ? 0.0 : duty->lag);
}

/* True while the loop without encoder follows a step of psi_f, or after a catch the difference of the true
 * from the configured psi_f: its feed-forward is the EMF over the configured psi_f, and its integral has to
 * take over the difference. */
static bool loop_settles(const campaign_watch_t *watch, uint32_t period)
{
    const campaign_duty_t *duty = &watch->duty;
    const uint32_t settles = campaign_periods(duty->settles);
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX && !duty->coded; n++) {
        const bool magnet =
            strcmp(campaign_faults[watch->drawn->faults[n].kind].row, "plant.flux_linkage") == 0;
        if (magnet && campaign_is_there(watch, n, period) && period - watch->excused[n].begins < settles) {
            return true;
        }
    }
    return !duty->coded && duty->locked < settles;
}

/* True if the encoder that control uses has a fault. */
static bool is_miscoded(const campaign_watch_t *watch, uint32_t period)
{
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        const char *row = campaign_faults[watch->drawn->faults[n].kind].row;
        if (strstr(row, "encoder_") != NULL && campaign_is_there(watch, n, period)) {
            return campaign_is_coded(watch->drawn, RIG_PERIOD_SECONDS * period);
        }
    }
    return false;
}

/* A wrong encoder does not show that the shaft is too fast. The EMF shows the fault of the encoder, within
 * the promised time after the bridge comes on or the fault begins: with the bridge off there are no voltages
 * from which the EMF could be computed. */
static void judge_trips(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    campaign_duty_t *duty = &watch->duty;
    duty->miscoded = counted(watch->gates_seen && is_miscoded(watch, period), duty->miscoded);
    const bool hidden = duty->miscoded > 0u && duty->miscoded <= campaign_periods(PROMISED_NOTICE);
    const bool runs = rows[CAMPAIGN_AT_manoeuvre] == watch->run && watch->gates_seen;
    const double speed = fabs(campaign_number(rows, CAMPAIGN_AT_true_omega_m));
    duty->locked = counted(runs, duty->locked);
    duty->fast = counted(runs && speed > duty->overspeed && !loop_settles(watch, period), duty->fast);
    duty->high =
        counted(watch->gates_seen && campaign_number(rows, CAMPAIGN_AT_true_u_dc) > duty->link, duty->high);
    if (!hidden && duty->fast * RIG_PERIOD_SECONDS > fast_most(duty)) {
        campaign_violated(watch, CAMPAIGN_I_TRIP_SPEED, period, duty->fast, "true_omega_m");
    }
    if (duty->high > LINK_PERIODS) {
        campaign_violated(watch, CAMPAIGN_I_TRIP_LINK, period, duty->high, "true_u_dc");
    }
}

/* True for a speed at which the field may be weakened: there less than rated torque may be available. */
static bool is_beyond_base(const campaign_watch_t *watch, double speed)
{
    return watch->motor.fastest > 1.0 && fabs(speed) > BASE_SHARE * watch->duty.speed;
}

/* True if the torque [N m] drives the shaft away from both speeds, between which the reference is. */
static bool leaves(const campaign_watch_t *watch, const uint32_t *rows, double torque, double wanted)
{
    const double speed = campaign_number(rows, CAMPAIGN_AT_true_omega_m);
    const double near = AWAY_SPEED * watch->duty.speed;
    const double in_force = campaign_number(rows, CAMPAIGN_AT_omega_m_ref);
    return !is_beyond_base(watch, speed) && !is_beyond_base(watch, wanted) && fabs(wanted - speed) > near &&
           torque * (wanted - speed) < 0.0 && torque * (in_force - speed) <= 0.0;
}

/* True if in current mode the torque is larger than requested, or has the other direction. */
static bool exceeds(const campaign_watch_t *watch, const uint32_t *rows, double torque)
{
    const double per_ampere = watch->motor.torque / watch->motor.current;
    const double asked = per_ampere * campaign_number(rows, CAMPAIGN_AT_i_q_request);
    const double margin = campaign_invariants[CAMPAIGN_I_AWAY].limit * watch->duty.torque;
    const bool drives = torque * campaign_number(rows, CAMPAIGN_AT_true_omega_m) > 0.0;
    return drives && (torque * asked < 0.0 || fabs(torque) > AWAY_BEYOND * fabs(asked) + margin);
}

/* true: another speed, current or stop was requested, or the load has changed. */
static bool is_another_wish(campaign_duty_t *duty, const uint32_t *rows)
{
    const uint32_t wish[4] = {rows[CAMPAIGN_AT_state], rows[CAMPAIGN_AT_mode],
                              rows[CAMPAIGN_AT_speed_request], rows[CAMPAIGN_AT_load_torque]};
    const bool another = memcmp(wish, duty->away_wish, sizeof wish) != 0;
    memcpy(duty->away_wish, wish, sizeof wish);
    return another;
}

/* Distinguishes speed control from a runaway: if the torque responds to a load, or brakes a change of speed
 * caused by a load, the speed is nearer to its reference after half of the time. The speed control also has
 * the time in which its integral changes by this torque. */
static void judge_away(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    campaign_duty_t *duty = &watch->duty;
    const double torque = campaign_number(rows, CAMPAIGN_AT_true_torque);
    const bool stops = rows[CAMPAIGN_AT_state] == watch->stops;
    const bool runs = duty->healthy && rows[CAMPAIGN_AT_manoeuvre] == watch->run &&
                      (stops || rows[CAMPAIGN_AT_state] == watch->enabled) &&
                      fabs(torque) > campaign_invariants[CAMPAIGN_I_AWAY].limit * duty->torque;
    const double wanted = stops ? 0.0 : campaign_number(rows, CAMPAIGN_AT_speed_request);
    const bool follows = !stops && rows[CAMPAIGN_AT_mode] == 0u;
    const double error = fabs(wanted - campaign_number(rows, CAMPAIGN_AT_true_omega_m));
    const bool away = stops || follows ? leaves(watch, rows, torque, wanted) : exceeds(watch, rows, torque);
    duty->away = is_another_wish(duty, rows) ? 0u : duty->away;
    duty->away = counted(runs && away, duty->away);
    const uint32_t half = campaign_periods(0.5 * (stops ? AWAY_SECONDS : fmax(AWAY_SECONDS, duty->answer)));
    const bool grows = !follows || error > duty->away_error;
    if (!grows && duty->away > 1u && duty->away % half == 1u) {
        duty->away = 1u;
    }
    const double near = fmax(error, AWAY_SPEED * duty->speed);
    duty->away_torque = duty->away > 1u ? fmax(duty->away_torque, fabs(torque)) : fabs(torque);
    duty->away_wound = duty->away > 1u ? duty->away_wound + duty->winding * near * RIG_PERIOD_SECONDS : 0.0;
    duty->away_error = duty->away % half == 1u ? error : duty->away_error;
    const bool wound = duty->away_wound > duty->away_torque || duty->away > campaign_periods(ANSWER_MOST);
    if (duty->away > 2u * half && grows && (stops || wound)) {
        campaign_violated(watch, CAMPAIGN_I_AWAY, period, duty->away, "true_torque");
    }
}

/* ---- the speed is reached ---- */

/* True if request and load are the same as in the period before. */
static bool wishes_the_same(campaign_duty_t *duty, const uint32_t *rows)
{
    const uint32_t wish[4] = {rows[CAMPAIGN_AT_enable], rows[CAMPAIGN_AT_mode],
                              rows[CAMPAIGN_AT_speed_request], rows[CAMPAIGN_AT_load_torque]};
    const bool same = memcmp(wish, duty->wish, sizeof wish) == 0;
    memcpy(duty->wish, wish, sizeof wish);
    return same;
}

/* [s] Time for which friction and a passive load hold a shaft at standstill, while the integral of the
 * speed control changes from its present torque to the torque that moves the shaft in the other direction.
 * */
static double held(const campaign_watch_t *watch, const uint32_t *rows, double load)
{
    const campaign_duty_t *duty = &watch->duty;
    const double wanted = campaign_number(rows, CAMPAIGN_AT_speed_request);
    const double torque = campaign_number(rows, CAMPAIGN_AT_true_torque);
    const double against = wanted * torque < 0.0 ? fabs(torque) : 0.0;
    const double least = campaign_invariants[CAMPAIGN_I_REACH].limit * duty->speed;
    return winding_time(duty, (load + duty->drag) * duty->torque + against, fmax(fabs(wanted), least));
}

/* [periods] Time within which the shaft must reach its speed. */
static double due_of(const campaign_watch_t *watch, const uint32_t *rows, double load)
{
    const campaign_duty_t *duty = &watch->duty;
    const double way = fabs(campaign_number(rows, CAMPAIGN_AT_speed_request)) +
                       fabs(campaign_number(rows, CAMPAIGN_AT_true_omega_m));
    const double room = fmax(LEAST_ROOM, 0.75 - load - duty->drag);
    const double start = duty->coded ? ENCODER_SECONDS + held(watch, rows, load) : START_SECONDS;
    return (start + 2.0 * duty->answer + 2.0 * way * duty->inertia / (duty->torque * room)) /
           RIG_PERIOD_SECONDS;
}

/* True if the request moves the shaft towards zero. If the link accepts no energy, only friction brakes the
 * shaft. */
static bool brakes(const campaign_watch_t *watch, const uint32_t *rows)
{
    const double wanted = campaign_number(rows, CAMPAIGN_AT_speed_request);
    const double speed = campaign_number(rows, CAMPAIGN_AT_true_omega_m);
    const double near = AWAY_SPEED * watch->duty.speed;
    return fabs(speed) > near && (wanted * speed < 0.0 || fabs(wanted) < fabs(speed) - near);
}

/* True if a speed can be expected. It is false with a latched fault, which is judged by its reason; during a
 * stop, which ends first; while a start is refused because `enable` was on at a reset; and while a load
 * drives the shaft beyond the trip, or with an encoder beyond the share from which on this is the refusal,
 * because the bridge then does not come on. */
static bool is_expected(const campaign_watch_t *watch, const uint32_t *rows, double load)
{
    const campaign_duty_t *duty = &watch->duty;
    const double speed = campaign_number(rows, CAMPAIGN_AT_true_omega_m);
    const bool refused = rows[CAMPAIGN_AT_refusal] == (uint32_t)REASON_OVERSPEED;
    const double most = (refused ? SWITCH_ON_SPEED : 1.0) * watch->overspeed;
    if (rows[CAMPAIGN_AT_state] <= watch->ready && fabs(speed) > most) {
        return false;
    }
    if (is_beyond_base(watch, campaign_number(rows, CAMPAIGN_AT_speed_request)) ||
        is_beyond_base(watch, speed)) {
        return false;
    }
    return duty->healthy && !duty->limited && !(duty->soft && duty->brakes) && load <= REACH_LOAD &&
           rows[CAMPAIGN_AT_enable] == 1u && rows[CAMPAIGN_AT_mode] == 0u &&
           rows[CAMPAIGN_AT_state] != watch->fault && rows[CAMPAIGN_AT_state] != watch->stops &&
           rows[CAMPAIGN_AT_refusal] != (uint32_t)REASON_ENABLE_HELD;
}

static void judge_reach(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    campaign_duty_t *duty = &watch->duty;
    const uint32_t window = campaign_periods(WINDOW_SECONDS);
    const double load = fabs(campaign_number(rows, CAMPAIGN_AT_load_torque)) / duty->torque + duty->load;
    const double wanted = fabs(campaign_number(rows, CAMPAIGN_AT_speed_request));
    const bool same = wishes_the_same(duty, rows);
    duty->brakes = same ? duty->brakes : brakes(watch, rows);
    const bool uneven = wanted < duty->uneven || duty->needs_encoder;
    if (!same || uneven || !is_expected(watch, rows, load)) {
        duty->since = 0u;
        duty->error = 0.0;
        duty->due = due_of(watch, rows, load);
        return;
    }
    duty->since++;
    if ((double)duty->since <= duty->due) {
        return;
    }
    const uint32_t past = duty->since - (uint32_t)duty->due;
    duty->error +=
        campaign_number(rows, CAMPAIGN_AT_true_omega_m) - campaign_number(rows, CAMPAIGN_AT_speed_request);
    if (past % window == 0u) {
        const double most = campaign_invariants[CAMPAIGN_I_REACH].limit * duty->speed;
        if (fabs(duty->error) / window > most) {
            campaign_violated(watch, CAMPAIGN_I_REACH, period, window, "true_omega_m");
        }
        duty->error = 0.0;
    }
}

void campaign_judge_duty(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    judge_off(watch, period, rows);
    judge_mute(watch, period, rows);
    judge_stop(watch, period, rows);
    if (watch->duty.drawn) {
        judge_trips(watch, period, rows);
        judge_away(watch, period, rows);
        judge_reach(watch, period, rows);
    }
}
