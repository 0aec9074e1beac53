/* Functions and data that the sources of the campaign share. Included by host_sim/lab/campaign*.c only. */
#ifndef HOST_SIM_LAB_CAMPAIGN_PARTS_H
#define HOST_SIM_LAB_CAMPAIGN_PARTS_H

#include <math.h>
#include <string.h>

#include "host_sim/lab/campaign.h"
#include "host_sim/lab/promised.h"
#include "host_sim/lab/runner.h"

/* The quantity of this name in a case. */
#define CAMPAIGN_VALUE(drawn, name) ((drawn)->quantities[CAMPAIGN_Q_##name])

/* The motor that follows from the quantities, in SI units; peak values of a phase. */
typedef struct {
    double pole_pairs, resistance, inductance_d, inductance_q, flux_linkage; /* [-], [ohm], [H], [H], [Wb] */
    double inertia;                                                          /* [kg m^2] */
    double speed;                                                            /* [rad/s] rated, mechanical */
    double torque;                                                           /* [N m] rated */
    double current;                                                          /* [A] rated */
    double trip;                                                             /* [A] overcurrent_trip */
    double saturation; /* [A] current at which the q axis saturates; 0: it does not */
    double fastest;    /* [-] largest requested speed divided by SPEED_DRAWN times the rated speed */
} campaign_motor_t;

campaign_motor_t campaign_motor(const campaign_case_t *drawn);

/* [A] overcurrent_trip and [rad/s] overspeed_trip of the case. */
double campaign_trip(const campaign_case_t *drawn);
double campaign_overspeed(const campaign_case_t *drawn);

/* [-] The speed of an event divided by the rated speed. */
double campaign_speed_of(const campaign_case_t *drawn, const campaign_event_t *event);

/* true: the motor is one of the salient motors, which have their own random stream. */
bool campaign_is_salient(const campaign_case_t *drawn);

/* [-] Configured L divided by true L. */
double campaign_inductance_configured(const campaign_case_t *drawn);

/* [kg m^2] Inertia of everything that turns. */
double campaign_inertia(const campaign_case_t *drawn);

/* [-] Largest torque of fan, sine and spring together, divided by rated torque. */
double campaign_load(const campaign_case_t *drawn);

/* true: no fault is injected. Around a scenario this is unknown, and the result is false. */
bool campaign_is_healthy(const campaign_case_t *drawn);

/* true: the load can drive the motor. */
bool campaign_overhauls(const campaign_case_t *drawn);

/* true: no fault is injected, and nothing can take the drive beyond its limits. The load cannot overhaul the
 * motor, and the supply is away from its limits. No requested current and no load step accelerates the rotor
 * beyond overspeed_trip, and the rotor cannot overcharge the link. */
bool campaign_is_calm(const campaign_case_t *drawn);

/* campaign_rows.c: the settings at t = 0. */
typedef struct {
    const table_row_t *row;
    double value; /* [unit of the row] */
} campaign_setting_t;

#define CAMPAIGN_SETTINGS_MAX 96u

typedef struct {
    campaign_setting_t settings[CAMPAIGN_SETTINGS_MAX];
    uint32_t count;
} campaign_settings_t;

void campaign_set_all(campaign_settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor);
double campaign_loop(const campaign_case_t *drawn);       /* [rad/s] pll_bandwidth */
double campaign_speed_loop(const campaign_case_t *drawn); /* [rad/s] of the speed control, by its rule */
/* campaign_space.c: removes the events in which offsets drift while the bridge is on. Such a drift would be a
 * fault. */
void campaign_drop_drifts(campaign_case_t *drawn);

bool campaign_has_encoder(const campaign_case_t *drawn);

/* [A] By which the offsets have drifted before this time [s]: that of sensor a, and of b with the other sign.
 */
double campaign_drift(const campaign_case_t *drawn, double time);

/* Text that grows in a buffer. Text that does not fit is cut; `used` is then size - 1. */
typedef struct {
    char *to;
    size_t size, used;
} campaign_writing_t;
void campaign_say(campaign_writing_t *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
void campaign_say_value(campaign_writing_t *text, const table_row_t *row, double value);

/* campaign_around.c: writes the scenario with its errors. Expectations that end after the run are omitted. */
void campaign_say_around(campaign_writing_t *text, const campaign_case_t *drawn, const char *what);

/* [rad/s] mechanical: handover_speed that the drive computes for the configured motor with sensors without
 * noise. */
double campaign_handover_speed(const campaign_case_t *drawn);

/* [rad] electrical: turn within which the drive must detect a fault. */
#define CAMPAIGN_TURN (2.0 * 3.14159265358979323846 * PROMISED_TURN)

/* [s] Permitted duration of a wrong angle. */
#define CAMPAIGN_ANGLE_SECONDS 50e-3

/* [rad/s] mechanical: below this speed the drive need not detect a wrong angle within that time. Below
 * handover_speed the EMF is too small. With magnets that are weaker than configured this holds up to a larger
 * speed. In addition a third of an electrical turn takes longer there. */
double campaign_blind_speed(const campaign_case_t *drawn);

/* [rad/s] mechanical: fallback_speed that the drive computes from that handover_speed; [s] time for which the
 * drive waits for the EMF in a passage through zero speed. */
double campaign_fallback_speed(const campaign_case_t *drawn);
double campaign_passage_seconds(const campaign_case_t *drawn);

/* true: control uses the encoder at this time [s]. */
bool campaign_is_coded(const campaign_case_t *drawn, double time);

/* campaign_judge.c: signals of a run that the rules use. */
#define CAMPAIGN_WATCHED_MAX RIG_TAP_MAX

/* Rows that the rules use individually. They follow the floats among the signals, in this order, floats
 * first. */
#define CAMPAIGN_JUDGED_FLOATS(R)                                                                            \
    R(true_i_a)                                                                                              \
    R(true_i_b)                                                                                              \
    R(true_i_c)                                                                                              \
    R(theta_err)                                                                                             \
    R(theta_sigma)                                                                                           \
    R(true_omega_m)                                                                                          \
    R(true_u_dc)                                                                                             \
    R(shoot_throughs)                                                                                        \
    R(chip_reports)                                                                                          \
    R(true_torque)                                                                                           \
    R(omega_m_ref)                                                                                           \
    R(i_d_ref)                                                                                               \
    R(i_q_ref)                                                                                               \
    R(frame_theta_e)                                                                                         \
    R(u_alpha) R(u_beta) R(true_theta_e) R(speed_request) R(i_q_request) R(load_torque) CAMPAIGN_LEARNT(R)
/* The learnt values that change the mean of the angle. Others, the shape of the EMF and differences of the
 * legs, change only its ripple. */
#define CAMPAIGN_LEARNT(R) R(dead_time_hat) R(inductance_hat) R(resistance_hat)
#define CAMPAIGN_JUDGED(R)                                                                                   \
    CAMPAIGN_JUDGED_FLOATS(R)                                                                                \
    R(state) R(manoeuvre) R(sample_flags) R(enable) R(mode) R(refusal) R(fault_reason) R(coasting)
enum {
#define CAMPAIGN_PLACE(name) CAMPAIGN_AT_##name,
    CAMPAIGN_JUDGED(CAMPAIGN_PLACE)
#undef CAMPAIGN_PLACE
        CAMPAIGN_JUDGED_ROWS
};
#define CAMPAIGN_FLOATS_JUDGED CAMPAIGN_AT_state

/* Violations that an injected fault excuses, and when. */
typedef struct {
    uint32_t bits;   /* of the invariants that the fault alone may violate */
    uint32_t begins; /* [periods] time at which the fault begins */
    uint32_t ends;   /* [periods] time at which its effect has ended */
    double ceiling;  /* [A] a true current above this value is not excused */
    double blind;    /* [rad/s] mechanical: a slower rotor does not show the fault; 0: none */
    bool uncoded;    /* without the encoder nothing shows the fault */
    bool unfed;      /* the angle may be wrong while less than campaign_wire_current is commanded */
    uint32_t told;   /* [periods] time from which the fault excuses nothing */
    uint32_t notice; /* [periods] with the bridge on, within which it must be reported; 0: no limit */
    double
        turned; /* [rad] electrical angle since the fault began, or since the bridge came on with the fault */
    uint32_t far[3]; /* [periods] time for which the current of this phase has exceeded the ceiling */
    double offset;   /* [A] error that the fault adds to the measured currents */
} campaign_excused_t;

#define CAMPAIGN_CREEP      2e-4 /* [s] PLANT_SHAFT_FOLLOW of the plant */
#define CAMPAIGN_STANDSTILL 2.0  /* [rad/s] SEQUENCE_STANDSTILL of the drive */

/* campaign_duty.c: the rules about the task of the drive. */
typedef struct {
    double torque, speed, inertia; /* [N m] and [rad/s] rated, [kg m^2] of everything that turns */
    double overspeed;              /* [rad/s] limit of the speed of the shaft */
    double link;                   /* [V] limit of the link voltage, including the error of its sensor */
    double stop_time;              /* [s] fault_stop_time */
    double load, drag;   /* [-] shares of rated torque: of fan, sine and spring together; of friction */
    bool drawn, healthy; /* everything is random (no scenario); no fault is injected */
    bool limited;        /* the link limits the torque that keeps a speed constant */
    bool soft;           /* the link limits only the braking torque */
    bool brakes;         /* the present request is slower than the shaft was, or in the other direction */
    uint32_t off, fast, high, mute; /* [periods] duration of: enable = off with a gate on; speed too high;
                                       link too high; enable = on without bridge and refusal */
    uint32_t miscoded;     /* [periods] time with a gate on and with a wrong encoder that control uses */
    uint32_t away;         /* [periods] time for which the torque has increased the error of the speed */
    double away_torque;    /* [N m] largest torque in that time */
    double away_wound;     /* [N m] by which the integral of the speed control changes in that time */
    double away_error;     /* [rad/s] error of the speed at the beginning of the second half of that time */
    uint32_t away_wish[4]; /* slots of the requests in that time, and of the load */
    bool coded;            /* control uses the encoder in the whole run */
    double lag;            /* [s] lag of the speed of the tracking loop */
    double settles;        /* [s] in which this speed follows a step of the magnet's flux */
    uint32_t locked;       /* [periods] since the drive runs with a gate on */
    double answer;         /* [s] response time of the speed control */
    double winding;        /* [N m/rad] change of its integral per error and time */
    uint32_t stopping;     /* [periods] since the quick stop began */
    double stop_most;      /* [s] permitted duration of the quick stop; 0: it is not judged */
    double creep;          /* [rad/s] speed below which the plant's friction is smaller than dry friction */
    double uneven; /* [rad/s] speed below which a load that varies with the angle moves the shaft unevenly */
    bool needs_encoder; /* such a load stops the shaft at the speed of the hand-over */
    uint32_t wish[4];   /* slots of the last requests, and of the load */
    double due;         /* [periods] time from the request to the arrival of the speed */
    uint32_t since;     /* [periods] since the request has changed */
    double error;       /* [rad/s] sum of the present window */
} campaign_duty_t;

/* campaign_reasons.c: the true events, with which the reason of a fault is compared. */
#define CAMPAIGN_CODES 4095.0 /* [-] largest code of a sensor, at 3 V */

typedef struct {
    double fast, over, high, low, under; /* [rad/s], [A], [V]: limits from which a reason is true */
    double fast_coded;                   /* [rad/s] the same limit with a wrong encoder */
    double speed;                        /* [rad/s] mechanical, with the lag of the tracking loop */
    double none; /* [A] length of a current that counts as none, as in the drive's watch of the encoder */
    uint32_t fast_at, over_at, high_at, low_at,
        scaled_at,  /* less than half of the link is shown, by which all voltages are scaled */
        apart_at,   /* two phases are open, whose missing voltages have any direction together */
        wrong_at;   /* [periods] last time at which the limit was exceeded; 0: it was not exceeded */
    uint32_t quiet; /* [periods] time without current, with all gates off */
    bool drifted;   /* the offsets have changed, and there has been no time to measure them since */
    double step;    /* [A] by which they have changed; 0: they have been measured since */
    uint32_t opens[CAMPAIGN_FAULTS_MAX]; /* bit of the phase that this fault opens; 0: none */
    bool heavy; /* a load behind an elastic shaft may move the motor against its torque */
    bool weak;  /* the injected fault is a weak magnet, whose EMF may count as missing */
    bool fed;   /* the rotor has fed the link since that change, so that the offsets could not be measured */
    uint32_t stopping; /* [-] causes that were present since a stop began; 0: the drive does not stop */
    int32_t reason;    /* [-] the reason that was compared last */
    int32_t shown;     /* [-] reason in the last period */
    uint32_t shown_at; /* [periods] time at which this reason appeared */
} campaign_truth_t;

/* [A] With less current in a phase no report of an open wire is required. It is twice the current that shows
 * an open wire. */
extern const double campaign_wire_current;

/* campaign_notice.c: the time in which a fault must be reported. */
typedef struct {
    uint32_t starved;                    /* [periods] time for which the link has been too low */
    uint32_t asked[CAMPAIGN_FAULTS_MAX]; /* [periods] in which the fault could be detected */
    double turned[CAMPAIGN_FAULTS_MAX];  /* [rad] electrical angle in those periods */
    bool seen[CAMPAIGN_FAULTS_MAX];      /* the fault could be detected in one period at least */
    double i_d, i_q;                     /* [A] mean of the requested current in its frame */
    double u_d, u_q;                     /* [V] mean of the voltage beyond the EMF in this frame */
    double more_d, more_q; /* [V] mean of what it has more beyond the EMF of the configured psi_f */
} campaign_notices_t;

/* Index of the phase that a broken wire or an open switch interrupts. */
uint32_t campaign_open_phase(const campaign_injected_t *injected);

/* campaign_pair.c: the angle error of a run, for the comparison with the same run without learning. */
#define CAMPAIGN_ANGLE_WINDOWS 512u

/* Number of values of CAMPAIGN_LEARNT. */
#define CAMPAIGN_ONE_LEARNT(name) +1
enum { CAMPAIGN_LEARNT_COUNT = 0 CAMPAIGN_LEARNT(CAMPAIGN_ONE_LEARNT) };
#undef CAMPAIGN_ONE_LEARNT

typedef struct {
    double learnt[CAMPAIGN_LEARNT_COUNT]; /* last values, in the order of CAMPAIGN_LEARNT */
    double truth[CAMPAIGN_LEARNT_COUNT];  /* [V], [H], [ohm] their true values */
    double lost_time;                     /* [-] that a leg loses, over a period */
    double drop;                          /* [V] of a leg */
    double blind, rated;                  /* [rad/s] mechanical: least speed of the comparison; rated speed */
    double shape;  /* [rad] standard deviation of the direction of the EMF by its harmonics */
    double shaped; /* [rad/s] mechanical: speed up to which the loop follows them */
    double speed;  /* [rad/s] mechanical: magnitude in the last steady period */
    /* [rad^2] mean square error of each window; below 0: the window was not steady */
    float square[CAMPAIGN_ANGLE_WINDOWS];
    float mean[CAMPAIGN_ANGLE_WINDOWS]; /* [rad] mean error of each window */
    uint32_t windows;                   /* number of complete windows */
    uint32_t wish[4];                   /* slots of the last requests, and of the load */
    uint32_t settled;                   /* [periods] since the request has changed */
    uint32_t periods;                   /* [periods] of the present window */
    double squares;                     /* [rad^2] sum over the present window */
    double sum;                         /* [rad] sum over the present window */
    bool steady;                        /* the present window has been steady until now */
} campaign_angles_t;

void campaign_angles_begin(campaign_angles_t *angles, const campaign_case_t *drawn);

#define CAMPAIGN_PAIR_SECONDS 10.0 /* [s] additional length of the runs of a pair */

/* Number of runs without learning of a pair, which differ in the noise of the sensors only. */
#define CAMPAIGN_PAIR_NOISES 20u

/* true: the run is done with learning and without. */
bool campaign_is_paired(const campaign_case_t *drawn);

/* What a leg loses: a time [s], and in addition a voltage [V]. */
double campaign_lost_time(const campaign_case_t *drawn);
double campaign_lost_voltage(const campaign_case_t *drawn);

/* R of the winding and of all that is in series with it [ohm]. */
double campaign_series_resistance(const campaign_case_t *drawn);

/* true: the learnt values differ from the configured ones, and are nearer to the true ones. */
bool campaign_is_truer(const campaign_angles_t *with, const campaign_angles_t *without);

/* Enters a violation into the result if the angle error was larger with learning, and returns true then. */
bool campaign_compare_angles(const campaign_angles_t *with, const campaign_angles_t *without,
                             campaign_result_t *result);

typedef struct {
    const campaign_case_t *drawn;
    campaign_result_t *result;
    campaign_angles_t *angles;  /* NULL: angles are not stored */
    volatile sig_atomic_t stop; /* the run must end, because of a violation or an interruption */
    const volatile sig_atomic_t *asked;
    campaign_motor_t motor;
    uint32_t ready, enabled, stops, fault; /* [-] values of `state` */
    uint32_t run;                          /* [-] of `manoeuvre` */
    double trip;                           /* [A] limit of the true phase current */
    double drift;                          /* [A] largest drift of an offset while the bridge is off */
    double overspeed;                      /* [rad/s] overspeed_trip */
    double per_omega; /* [rad s/rad] electrical angle per period, divided by the mechanical speed */
    campaign_excused_t excused[CAMPAIGN_FAULTS_MAX];
    campaign_duty_t duty;
    campaign_truth_t truth;
    campaign_notices_t notices;
    uint32_t over[3];     /* [periods] time for which the current of this phase has exceeded the limit */
    uint32_t over_off[3]; /* [periods] the same while all gates are off */
    bool fast;            /* caught above overspeed_trip, with the current of this catch still flowing */
    uint32_t wrong;       /* [periods] time for which the angle has been wrong */
    double error_square;  /* [rad^2] sum over the periods of campaign_result_t.tracked */
    double sigma;         /* [rad] the same sum of theta_sigma */
    double slow;          /* [rad/s] fallback_speed of the drive */
    double passage;       /* [s] time for which the drive waits for the EMF below this speed */
    uint32_t latched;     /* [periods] since the fault was latched */
    uint32_t gates;       /* gates that are on, one bit each */
    bool gates_seen;      /* a gate was on in this period */
    double shorts;        /* [-] shoot_throughs in the previous period */
    bool reset;           /* the watchdog has reset the chip, and a fault excuses this */
} campaign_watch_t;

/* Enters a violation that has lasted `since` periods, including the present one. Only the first violation of
 * a run counts. */
void campaign_violated(campaign_watch_t *watch, campaign_invariant_t invariant, uint32_t period,
                       uint32_t since, const char *row);

static inline double campaign_number(const uint32_t *rows, uint32_t place)
{
    float value;
    memcpy(&value, &rows[place], sizeof value);
    return (double)value;
}

/* [A] Length of the commanded current. */
static inline double campaign_asked(const uint32_t *rows)
{
    return hypot(campaign_number(rows, CAMPAIGN_AT_i_d_ref), campaign_number(rows, CAMPAIGN_AT_i_q_ref));
}

/* [periods] of a time. */
static inline uint32_t campaign_periods(double seconds)
{
    return (uint32_t)(seconds / RIG_PERIOD_SECONDS + 0.5);
}

/* true: the fault is present in this period. */
bool campaign_is_there(const campaign_watch_t *watch, uint32_t fault, uint32_t period);

/* Error of the measured currents by the offsets of the faults that are present [A]. */
double campaign_offset(const campaign_watch_t *watch, uint32_t period);

void campaign_duty_begin(campaign_watch_t *watch);
void campaign_judge_duty(campaign_watch_t *watch, uint32_t period, const uint32_t *rows);
void campaign_truth_begin(campaign_watch_t *watch);
void campaign_judge_reasons(campaign_watch_t *watch, uint32_t period, const uint32_t *rows);
void campaign_judge_notices(campaign_watch_t *watch, uint32_t period, const uint32_t *rows);
void campaign_keep_angle(campaign_watch_t *watch, const uint32_t *rows);

/* The value of a row at t = 0: that of the scenario around which the case is drawn, or the default. */
double campaign_initial(const campaign_case_t *drawn, const char *row);

/* Lists the rows that the rules use, the floats among the signals first. Returns their number; `floats` is
 * the number of those that must be finite. */
uint32_t campaign_watched(uint32_t ids[CAMPAIGN_WATCHED_MAX], uint32_t *floats);

void campaign_watch_begin(campaign_watch_t *watch, const campaign_case_t *drawn, campaign_result_t *result,
                          const volatile sig_atomic_t *asked);
void campaign_watch_sample(void *watch, uint32_t period, const uint32_t *slots, uint32_t count);
void campaign_watch_edge(void *watch, uint64_t tick, uint32_t what, uint32_t value);

/* [-] of an encoder's speed: an EMF that turns more slowly denies it (ENCODER_WATCH_TURNS). */
#define CAMPAIGN_TURNS 0.7

/* Bit of sample_flags, defined by the text of this signal. */
#define CAMPAIGN_LATE_FLAG UINT32_C(8)

/* Number of words of the drive's state in which a bit may be flipped, from the first word on. */
#define CAMPAIGN_STATE_WORDS 768u

/* campaign_alarms.c: true if the run is calm and ended in a fault of the drive. The other two print the
 * number of false alarms with the rule by which it is judged, and the runs. */
bool campaign_is_alarm(const campaign_result_t *result);
void campaign_say_alarms(FILE *file, uint32_t calm, uint32_t alarms);
void campaign_list_alarms(FILE *file, const campaign_t *campaign, const campaign_result_t *results);

/* campaign_result_t.share counts thousandths. */
#define CAMPAIGN_PER_MILLE 1000.0

/* campaign_sigma.c: the two forms of the summary's text. */
void campaign_say_sigma(FILE *file, const campaign_sigma_t *sigma);
void campaign_json_sigma(FILE *file, const campaign_sigma_t *sigma);

/* Bit of an invariant. */
#define CAMPAIGN_BIT(NAME) (UINT32_C(1) << CAMPAIGN_I_##NAME)

#endif
