/* Values that follow from a case: its motor, its limits, and the expected behaviour. */
#include <math.h>

#include "host_sim/lab/campaign_parts.h"

#define ROOT_3       1.7320508075688772
#define SPEED_DRAWN  0.9    /* [-] of rated speed: the fastest that is drawn */
#define SPEED_MIN    60.0   /* [rad/s] rated, mechanical */
#define SPEED_MAX    1000.0 /* [rad/s] the same */
#define ELECTRIC_MAX 2000.0 /* [rad/s] rated, electrical: 3 % of a turn a period */
#define RUN_UP_MIN   4e-3   /* [s] to rated speed by rated torque: the smallest servo motors */
#define RIPPLE_MAX   0.3    /* [-] of rated current, peak to peak: V_dc T_s/(6 L) */
#define CATCH                                                                                                \
    2.7 /* [-] periods times 0.9 of rated speed: during which the EMF drives the current of a catch          \
         */
#define NOISE_MOST 0.3 /* [-] of the EMF at rated speed: L n/T of the currents' noise n */
#define PERIOD     ((double)BOARD_PERIOD)
#define LINK_LEAST (270.0 * (BOARD_DC_NOMINAL_MV / 311e3)) /* [V] that is drawn */
/* [-] At handover_speed the EMF is 1.15 times the voltage of the dead time or R i. Their errors, 20 % of the
 * delays and drops and 30 % of R, take a tenth of this EMF, and a hidden EMF shows no wrong angle. */
#define VOLTAGE_ERRORS 1.1

#define TRIP       1.4  /* [-] overspeed_trip over rated speed ... */
#define TRIP_FIELD 1.15 /* [-] ... or over the fastest of a motor whose field is weakened */
/* [-] of dc_overvoltage: largest EMF between two phases at overspeed_trip */
#define LINK_USED     0.95
#define TURN_MOST     0.33        /* [rad] electrical, in a period at overspeed_trip */
#define SALIENT_ERROR (1.0 / 3.0) /* [-] of the error of other motors' L */
#define SATURATES     0.6         /* [-] of rated current: least current of saturation */

/* The motor of the paper, whose data are the defaults of the rows. */
static campaign_motor_t default_motor(void)
{
    const double torque_per_ampere =
        1.5 * rig_initial_named("plant.pole_pairs") * rig_initial_named("plant.flux_linkage");
    const double current = rig_initial_named("current_limit");
    return (campaign_motor_t){
        .pole_pairs = rig_initial_named("plant.pole_pairs"),
        .resistance = rig_initial_named("plant.resistance"),
        .inductance_d = rig_initial_named("plant.inductance_d"),
        .inductance_q = rig_initial_named("plant.inductance_q"),
        .flux_linkage = rig_initial_named("plant.flux_linkage"),
        .inertia = rig_initial_named("plant.inertia"),
        .speed = rig_initial_named("overspeed_trip") / 1.4,
        .torque = torque_per_ampere * current,
        .current = current,
        .trip = rig_initial_named("overcurrent_trip"),
        .fastest = 1.0,
    };
}

bool campaign_is_salient(const campaign_case_t *drawn)
{
    return CAMPAIGN_VALUE(drawn, motor_drawn) != 0.0 && CAMPAIGN_VALUE(drawn, interior) != 0.0;
}

/* L of a salient motor is not learnt, and an L_q that is wrong by a tenth changes the estimated angle by 0.1
 * to 0.2 rad under load (docs/theory.md, 30). Therefore its configured L_q has a third of the error of other
 * motors. */
double campaign_inductance_configured(const campaign_case_t *drawn)
{
    const double configured = drawn->true_values ? 1.0 : CAMPAIGN_VALUE(drawn, inductance_configured);
    return campaign_is_salient(drawn) ? 1.0 + SALIENT_ERROR * (configured - 1.0) : configured;
}

/* [-] Fastest speed over the rated one: the configured EMF at overspeed_trip stays below what the open bridge
 * may make of the link, and the rotor's turn in a period below what `tune` allows. */
static double fastest_of(const campaign_case_t *drawn, double emf, double pole_pairs, double speed)
{
    const double open = emf * CAMPAIGN_VALUE(drawn, flux_configured) * ROOT_3 * TRIP_FIELD;
    const double by_link = LINK_USED * rig_initial_named("dc_overvoltage") / open;
    const double by_turn = TURN_MOST / (TRIP_FIELD * pole_pairs * speed * PERIOD);
    return campaign_is_salient(drawn) ? fmax(1.0, fmin(CAMPAIGN_VALUE(drawn, field), fmin(by_link, by_turn)))
                                      : 1.0;
}

campaign_motor_t campaign_motor(const campaign_case_t *drawn)
{
    if (CAMPAIGN_VALUE(drawn, motor_drawn) == 0.0) {
        return default_motor();
    }
    /* E: peak EMF of a phase at rated speed; run-up time t = J omega/T, T = 1.5 E I/omega */
    const double emf = CAMPAIGN_VALUE(drawn, emf_share) * LINK_LEAST / ROOT_3;
    const double inertia = CAMPAIGN_VALUE(drawn, inertia);
    const double most = inertia * SPEED_MAX * SPEED_MAX / (1.5 * emf * RUN_UP_MIN);
    const double current = fmax(0.5, fmin(CAMPAIGN_VALUE(drawn, current), most));
    const double asked = sqrt(1.5 * emf * current * CAMPAIGN_VALUE(drawn, run_up) / inertia);
    const double speed = fmax(SPEED_MIN, fmin(asked, SPEED_MAX));
    const double pole_pairs = fmax(1.0, fmin(CAMPAIGN_VALUE(drawn, pole_pairs), floor(ELECTRIC_MAX / speed)));
    const double by_reactance = CAMPAIGN_VALUE(drawn, reactance) * emf / (pole_pairs * speed * current);
    const double by_ripple = CAMPAIGN_VALUE(drawn, dc_voltage) * PERIOD / (6.0 * RIPPLE_MAX * current);
    const double saturates = fmax(CAMPAIGN_VALUE(drawn, saturation) * current, 1.0);
    const bool bends = campaign_is_salient(drawn) && CAMPAIGN_VALUE(drawn, saturation) > SATURATES;
    const double bent =
        bends ? hypot(1.0, 1.5 * current / saturates) / fmax(1.0, CAMPAIGN_VALUE(drawn, interior)) : 1.0;
    const double by_catch = CATCH * PERIOD * emf / (1.5 * current) * fmax(1.0, bent);
    const double by_noise = NOISE_MOST * PERIOD * emf / CAMPAIGN_VALUE(drawn, current_noise);
    const double inductance = fmax(fmin(fmin(by_reactance, 0.5), by_noise), fmax(by_ripple, by_catch));
    const double ratio = campaign_is_salient(drawn)
                             ? fmax(1.0, fmin(CAMPAIGN_VALUE(drawn, interior), by_noise / inductance))
                             : CAMPAIGN_VALUE(drawn, saliency);
    const double flux = emf / (pole_pairs * speed);
    return (campaign_motor_t){
        .pole_pairs = pole_pairs,
        .resistance = CAMPAIGN_VALUE(drawn, resistive) * emf / current,
        .inductance_d = inductance,
        .inductance_q = inductance * ratio,
        .flux_linkage = flux,
        .inertia = inertia,
        .speed = speed,
        .torque = 1.5 * emf * current / speed,
        .current = current,
        .trip = fmin(1.5 * current, 0.95 * rig_max(rig_row_by_name("overcurrent_trip"))),
        .saturation = bends ? saturates : 0.0,
        .fastest = fastest_of(drawn, emf, pole_pairs, speed),
    };
}

/* [-] overspeed_trip over rated speed. */
static double beyond(const campaign_motor_t *motor)
{
    return fmax(TRIP, TRIP_FIELD * motor->fastest);
}

double campaign_speed_of(const campaign_case_t *drawn, const campaign_event_t *event)
{
    return event->kind == CAMPAIGN_V_SPEED ? event->value * campaign_motor(drawn).fastest : event->value;
}

/* docs/theory.md, 23: 1.15 times the voltage of dead time or R I, which could be mistaken for an EMF, but at
 * most 0.3 of overspeed_trip. */
double campaign_handover_speed(const campaign_case_t *drawn)
{
    const campaign_motor_t motor = campaign_motor(drawn);
    const double dead = rig_initial_named("dead_time") / PERIOD * rig_initial_named("dc_overvoltage");
    const double drop = motor.resistance * CAMPAIGN_VALUE(drawn, resistance_configured) * motor.current;
    const double flux = motor.flux_linkage * CAMPAIGN_VALUE(drawn, flux_configured);
    return fmin(1.15 * fmax(dead, drop) / (flux * motor.pole_pairs), 0.3 * beyond(&motor) * motor.speed);
}

double campaign_fallback_speed(const campaign_case_t *drawn)
{
    return 0.4 * campaign_handover_speed(drawn);
}

/* docs/theory.md, 23: 1.4 times the time of the passage with the configured J and psi_f, 20 ms to 0.1 s. */
double campaign_passage_seconds(const campaign_case_t *drawn)
{
    const double torque = campaign_motor(drawn).torque * CAMPAIGN_VALUE(drawn, flux_configured);
    const double inertia = campaign_inertia(drawn) * CAMPAIGN_VALUE(drawn, inertia_configured);
    const double passing = 1.4 * 2.0 * campaign_fallback_speed(drawn) * inertia / torque;
    return fmin(fmax(passing, 20e-3), 0.1);
}

double campaign_blind_speed(const campaign_case_t *drawn)
{
    const double turns = CAMPAIGN_TURN / CAMPAIGN_ANGLE_SECONDS / campaign_motor(drawn).pole_pairs;
    const double weak = fmax(CAMPAIGN_VALUE(drawn, flux_configured), 1.0);
    return fmax(VOLTAGE_ERRORS * weak * campaign_handover_speed(drawn), turns);
}

bool campaign_is_coded(const campaign_case_t *drawn, double time)
{
    bool coded = CAMPAIGN_VALUE(drawn, encoder) != 0.0;
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        coded = coded != (drawn->events[n].kind == CAMPAIGN_V_SOURCE && drawn->events[n].time <= time);
    }
    return coded;
}

double campaign_initial(const campaign_case_t *drawn, const char *row)
{
    const table_row_t *found = rig_row_by_name(row);
    return drawn->around != NULL ? scenario_initial(drawn->around, found) : rig_initial(found);
}

double campaign_trip(const campaign_case_t *drawn)
{
    return drawn->around != NULL ? campaign_initial(drawn, "overcurrent_trip") : campaign_motor(drawn).trip;
}

double campaign_overspeed(const campaign_case_t *drawn)
{
    const campaign_motor_t motor = campaign_motor(drawn);
    return drawn->around != NULL ? campaign_initial(drawn, "overspeed_trip") : beyond(&motor) * motor.speed;
}

double campaign_inertia(const campaign_case_t *drawn)
{
    return campaign_motor(drawn).inertia * (1.0 + CAMPAIGN_VALUE(drawn, second_mass));
}

double campaign_load(const campaign_case_t *drawn)
{
    return CAMPAIGN_VALUE(drawn, fan) + CAMPAIGN_VALUE(drawn, sine) + CAMPAIGN_VALUE(drawn, spring);
}

bool campaign_is_healthy(const campaign_case_t *drawn)
{
    return drawn->around == NULL && drawn->faults[0].kind == 0u && drawn->faults[1].kind == 0u;
}

/* true: the requested torque, a current, exceeds the friction up to the trip of the speed. */
static bool is_driven_beyond(const campaign_case_t *drawn, const campaign_event_t *event)
{
    const campaign_motor_t motor = campaign_motor(drawn);
    const double most = beyond(&motor);
    const double held = CAMPAIGN_VALUE(drawn, friction) + most * CAMPAIGN_VALUE(drawn, viscous) +
                        most * most * CAMPAIGN_VALUE(drawn, fan);
    return event->kind == CAMPAIGN_V_CURRENT && fabs(event->value) > held;
}

bool campaign_overhauls(const campaign_case_t *drawn)
{
    bool loads = CAMPAIGN_VALUE(drawn, load) != 0.0;
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        loads = loads || drawn->events[n].kind == CAMPAIGN_V_LOAD;
    }
    return (CAMPAIGN_VALUE(drawn, load_kind) != 0.0 && loads) || CAMPAIGN_VALUE(drawn, sine) != 0.0 ||
           CAMPAIGN_VALUE(drawn, spring) != 0.0;
}

/* True if the rotor has more energy than the link can store below its trip. Braking then charges a link that
 * has no discharge, and noise and the errors of the currents may raise it to the trip. */
static bool fills_link(const campaign_case_t *drawn)
{
    const double trip = campaign_initial(drawn, "dc_overvoltage");
    const double source = CAMPAIGN_VALUE(drawn, dc_voltage);
    const campaign_motor_t motor = campaign_motor(drawn);
    const double speed = SPEED_DRAWN * motor.fastest * motor.speed;
    return campaign_inertia(drawn) * speed * speed >
           CAMPAIGN_VALUE(drawn, dc_soft) * (trip * trip - source * source);
}

/* [-] Change of the speed by a step of the load: relative to rated speed, for a step of rated torque. The
 * speed control has k_p = J w/K_t and k_i = k_p w/3, so that w(s)/T(s) = s/(J (s^2 + w s + w^2/3)), whose
 * largest response to a step is 0.70 T/(J w); k_p contains the configured J and psi_f. */
static double moved_by(const campaign_case_t *drawn, double load)
{
    const campaign_motor_t motor = campaign_motor(drawn);
    const double configured =
        CAMPAIGN_VALUE(drawn, inertia_configured) / CAMPAIGN_VALUE(drawn, flux_configured);
    const double w = campaign_speed_loop(drawn) * fmin(1.0, configured);
    return 0.70 * load * motor.torque / (campaign_inertia(drawn) * w * motor.speed);
}

/* true: the step of a load moves a shaft from the requested speed beyond the trip. */
static bool is_unloaded_beyond(const campaign_case_t *drawn)
{
    const campaign_motor_t motor = campaign_motor(drawn);
    double load = CAMPAIGN_VALUE(drawn, load);
    double speed = 0.0;
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        const campaign_event_t *event = &drawn->events[n];
        if (event->kind == CAMPAIGN_V_SPEED || event->kind == CAMPAIGN_V_SLOW) {
            speed = fmax(speed, fabs(campaign_speed_of(drawn, event)));
        } else if (event->kind == CAMPAIGN_V_LOAD) {
            if (speed + moved_by(drawn, fabs(event->value - load)) > beyond(&motor)) {
                return true;
            }
            load = event->value;
        }
    }
    return false;
}

bool campaign_is_calm(const campaign_case_t *drawn)
{
    bool beyond = false;
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        beyond = beyond || is_driven_beyond(drawn, &drawn->events[n]);
    }
    return campaign_is_healthy(drawn) && !campaign_overhauls(drawn) && !beyond &&
           !is_unloaded_beyond(drawn) && CAMPAIGN_VALUE(drawn, dc_edge) == 0.0 &&
           (CAMPAIGN_VALUE(drawn, dc_soft) == 0.0 || !fills_link(drawn));
}
